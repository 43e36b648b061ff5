// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Fuzzer of scripts, point files and restart files, built with AddressSanitizer and
// UndefinedBehaviorSanitizer (of the package; LIGGGHTS' library is taken as it is). A parent sets a scene up
// once; each input runs in a process forked from it, and ends well, or by one message, or is a finding:
//   silent     ended by an error without a line ERROR, or with more than one
//   nameless   a message of the package that does not name its command
//   crash      signal, sanitizer report or C++ exception
//   hang       took more than kSeconds
//   memory     asked for more than kMegabytes
// Crashes and hangs of LIGGGHTS in a command of its own other than `run`, without a function of the package on
// the stack, are counted as `host`; they are shown but are no findings. Findings are written to a folder as
// scripts that repeat them.
//
//   fuzz_input [--inputs N] [--minutes M] [--seed S] [--jobs J] [--only NUMBER] [--scene NAME] [--folder F] [--json FILE]
//
// Ends with status 1 if there are findings. --minutes: no round of inputs begins later. --json: the counts for tools/reliability.py.
#include <fcntl.h>
#include <mpi.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <map>
#include <new>
#include <sstream>
#include <string>
#include <vector>

#include "error.h"
#include "grammar.h"
#include "input.h"
#include "lammps.h"

// sanitizer/allocator_interface.h, which GCC does not bring along
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*)(const volatile void*, std::size_t), void (*)(const volatile void*));

namespace {

constexpr unsigned kSeconds = 20;
constexpr std::size_t kMegabytes = 1500;
constexpr std::size_t kMegabytesTold = 8;  // what the package is told; it keeps inputs short
static_assert(fuzz::kScenes == 6, "kRound is a multiple of it");
constexpr long kRound = 3000;  // inputs of all scenes before the first scene has its turn again
constexpr int kMessageStatus = 41, kMemoryStatus = 42, kExceptionStatus = 43, kSanitizerStatus = 44;

enum Outcome { kOk, kMessage, kSilent, kNameless, kCrash, kHang, kMemory, kHost, kOutcomes };
const char* const kOutcomeNames[kOutcomes] = {"ok", "message", "silent", "nameless", "crash", "hang", "memory", "host"};

bool in_child = false;

void watch_memory(const volatile void*, std::size_t) {
  if (in_child && __sanitizer_get_current_allocated_bytes() > kMegabytes << 20) _exit(kMemoryStatus);
}

struct Options {
  long inputs = 1000, only = -1;
  double minutes = 1e9;
  std::uint64_t seed = 1;
  int jobs = 1, scene = -1;
  std::string folder = "fuzz-findings", json;
};

// Counts of all jobs, in shared memory.
struct Counts {
  long outcome[fuzz::kScenes][kOutcomes];
  long total() const {
    long n = 0;
    for (const auto& scene : outcome)
      for (long k : scene) n += k;
    return n;
  }
  Counts of(int scene) const {
    Counts c{};
    std::memcpy(c.outcome[scene], outcome[scene], sizeof outcome[scene]);
    return c;
  }
  long findings() const {
    long n = total();
    for (const auto& scene : outcome) n -= scene[kOk] + scene[kMessage] + scene[kHost];
    return n;
  }
};

std::string read_all(const std::string& name) {
  std::ifstream f(name, std::ios::binary);
  std::ostringstream s;
  s << f.rdbuf();
  return s.str();
}

void write_all(const std::string& name, const std::string& bytes) {
  std::ofstream f(name, std::ios::binary);
  f << bytes;
}

bool in_command_of_host(const std::string& output) {
  const std::size_t at = output.rfind("\n> ");
  const std::string line = at == std::string::npos ? "" : output.substr(at + 3, output.find('\n', at + 1) - at - 3);
  for (const char* ours : {"run", "mpm", "cement", "mpdem"})
    if (line.find(ours) != std::string::npos) return false;
  return at != std::string::npos && output.find("USER-MPDEM/") == std::string::npos;
}

Outcome judge(int status, const std::string& output) {
  const Outcome crash = in_command_of_host(output) ? kHost : kCrash;
  if (output.find("runtime error:") != std::string::npos || output.find("ERROR: AddressSanitizer") != std::string::npos) return crash;
  if (WIFSIGNALED(status)) return WTERMSIG(status) == SIGALRM && crash == kCrash ? kHang : crash;
  const int code = WEXITSTATUS(status);
  if (code == 0) return kOk;
  if (code == kMemoryStatus) return kMemory;
  if (code != kMessageStatus) return crash;
  int errors = 0;
  std::istringstream s(output);
  bool named = true;
  for (std::string line; std::getline(s, line);) {
    if (line.rfind("ERROR", 0) != 0) continue;
    ++errors;
    if (line.find("USER-MPDEM") == std::string::npos) continue;
    named = false;
    for (const char* name : {"fix mpm (id", "fix mpm/couple (id", "fix check/timestep/mpm (id", "compute mpm/atom (id",
                             "create_cement: ", "create_cement pair ",
                             "write_cement: ", "bond_stiffness: ", "read_restart: ", "atom_style mpdem: ", "write_restart: "})
      named = named || line.find(name) != std::string::npos;
  }
  return errors != 1 ? kSilent : named ? kMessage : kNameless;
}

void run_lines(LAMMPS_NS::LAMMPS* lmp, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    std::printf("> %s\n", line.c_str());
    lmp->input->one(line.c_str());
  }
}

[[noreturn]] void child(LAMMPS_NS::LAMMPS* lmp, const fuzz::Input& in, std::uint64_t number) {
  in_child = true;
  alarm(kSeconds);
  try {
    run_lines(lmp, in.lines);
    if (number % 8 == 0) delete lmp;
  } catch (const std::exception& e) {
    std::printf("exception: %s\n", e.what());
    std::fflush(nullptr);
    _exit(kExceptionStatus);
  }
  std::fflush(nullptr);
  _exit(0);
}

std::string as_script(const fuzz::Input& in, std::uint64_t seed, std::uint64_t number) {
  std::ostringstream s;
  s << "# fuzz_input --seed " << seed << " --only " << number << "\n";
  for (const std::string& l : fuzz::scene_lines(in.scene)) s << l << "\n";
  for (const std::string& l : in.lines) s << l << "\n";
  return s.str();
}

LAMMPS_NS::LAMMPS* make_scene(fuzz::Scene scene) {
  const char* words[] = {"fuzz_input", "-log", "none", "-echo", "none"};
  std::vector<char*> argv;
  for (const char* w : words) argv.push_back(strdup(w));
  auto* lmp = new LAMMPS_NS::LAMMPS(static_cast<int>(argv.size()), argv.data(), MPI_COMM_WORLD);
  run_lines(lmp, fuzz::scene_lines(scene));
  return lmp;
}

// A restart file in the working folder, made by a process of its own.
std::string valid_restart() {
  const pid_t pid = fork();
  if (pid == 0) {
    LAMMPS_NS::LAMMPS* lmp = make_scene(fuzz::kFixes);
    run_lines(lmp, {"run 3", "write_restart valid.restart"});
    std::fflush(nullptr);
    _exit(0);
  }
  int status;
  waitpid(pid, &status, 0);
  return read_all("valid.restart");
}

// One scene of one job: its inputs from `first` on, each in a child.
void serve(fuzz::Scene scene, long first, int job, const Options& o, Counts* counts, const std::string& folder) {
  const std::string output = "output.txt";
  std::fflush(nullptr);
  const int out = open(output.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_APPEND, 0644);
  dup2(out, 1);
  dup2(out, 2);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // what precedes a crash is in the file
  const std::string restart = scene == fuzz::kRestart ? valid_restart() : "";
  LAMMPS_NS::LAMMPS* lmp = make_scene(scene);
  std::fflush(nullptr);
  std::ofstream messages("messages.txt", std::ios::app);
  for (long n = first + scene; n < std::min(first + kRound, o.inputs); n += fuzz::kScenes) {
    if (o.only >= 0 ? n != o.only : n / fuzz::kScenes % o.jobs != job) continue;
    const fuzz::Input in = fuzz::make_input(o.seed, n, restart);
    if (!in.points.empty()) write_all("points.txt", in.points);
    if (!in.restart.empty()) write_all("fuzz.restart", in.restart);
    if (ftruncate(out, 0) != 0) std::abort();
    const pid_t pid = fork();
    if (pid == 0) child(lmp, in, n);
    int status;
    rusage used;
    wait4(pid, &status, 0, &used);
    const std::string text = read_all(output);
    const Outcome outcome = judge(status, text);
    __atomic_add_fetch(&counts->outcome[scene][outcome], 1, __ATOMIC_RELAXED);
    const std::size_t error = text.find("\nERROR");
    const double seconds = used.ru_utime.tv_sec + 1e-6 * used.ru_utime.tv_usec;
    messages << n << " " << std::lround(1000 * seconds) << " ms " << kOutcomeNames[outcome] << " "
             << (error == std::string::npos ? "" : text.substr(error + 1, text.find('\n', error + 1) - error - 1)) << std::endl;
    if (outcome > kMessage || o.only >= 0) {
      const std::string base = folder + "/" + kOutcomeNames[outcome] + "-" + std::to_string(o.seed) + "-" + std::to_string(n);
      mkdir(base.c_str(), 0755);
      write_all(base + "/in.fuzz", as_script(in, o.seed, n));
      write_all(base + "/output.txt", text + "\nstatus " + std::to_string(status) + "\n");
      if (!in.points.empty()) write_all(base + "/points.txt", in.points);
      if (!in.restart.empty()) write_all(base + "/fuzz.restart", in.restart);
    }
  }
  _exit(0);
}

Options parse(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string key = argv[i];
    if (i + 1 == argc) {
      std::fprintf(stderr, "fuzz_input: value of '%s' is missing\n", key.c_str());
      std::exit(2);
    }
    const char* v = argv[++i];
    if (key == "--inputs") o.inputs = std::atol(v);
    else if (key == "--minutes") o.minutes = std::atof(v);
    else if (key == "--seed") o.seed = std::strtoull(v, nullptr, 10);
    else if (key == "--jobs") o.jobs = std::atoi(v);
    else if (key == "--only") o.only = std::atol(v);
    else if (key == "--folder") o.folder = v;
    else if (key == "--json") o.json = v;
    else if (key == "--scene") {
      for (int s = 0; s < fuzz::kScenes; ++s)
        if (std::strcmp(fuzz::kSceneNames[s], v) == 0) o.scene = s;
      if (o.scene < 0) {
        std::fprintf(stderr, "fuzz_input: no scene '%s'; see kSceneNames in tests/fuzz/grammar.cpp\n", v);
        std::exit(2);
      }
    } else {
      std::fprintf(stderr, "fuzz_input: unknown word '%s'; see the head of tests/fuzz/fuzz_input.cpp\n", key.c_str());
      std::exit(2);
    }
  }
  if (o.only >= o.inputs) o.inputs = o.only + 1;
  if (o.jobs < 1 || o.inputs < 1 || !(o.minutes > 0.0)) {
    std::fprintf(stderr, "fuzz_input: --jobs and --inputs must be at least 1, --minutes above 0\n");
    std::exit(2);
  }
  return o;
}

}  // namespace

// LIGGGHTS ends by these; the processes here share what MPI has open and must not close it.
extern "C" int PMPI_Abort(MPI_Comm, int) {
  std::fflush(nullptr);
  _exit(kMessageStatus);
}
extern "C" int MPI_Finalize() {
  std::fflush(nullptr);
  _exit(kMessageStatus);
}

extern "C" const char* __asan_default_options() {
  return "exitcode=44:detect_leaks=0:handle_abort=1:allocator_may_return_null=0:quarantine_size_mb=16:detect_odr_violation=0";
}
extern "C" const char* __ubsan_default_options() { return "print_stacktrace=1:halt_on_error=1"; }

int main(int argc, char** argv) {
  static_assert(kSanitizerStatus == 44, "as in the options of the sanitizer");
  const Options o = parse(argc, argv);
  __sanitizer_install_malloc_and_free_hooks(&watch_memory, [](const volatile void*) {});
  mkdir(o.folder.c_str(), 0755);
  char* full = realpath(o.folder.c_str(), nullptr);
  if (!full) {
    std::fprintf(stderr, "fuzz_input: folder '%s' cannot be made\n", o.folder.c_str());
    return 2;
  }
  const std::string folder = full;
  MPI_Init(nullptr, nullptr);
  const rlimit told = {kMegabytesTold << 20, RLIM_INFINITY};
  setrlimit(RLIMIT_RSS, &told);  // read by the package, without effect in Linux
  auto* counts = static_cast<Counts*>(mmap(nullptr, sizeof(Counts), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  std::vector<pid_t> jobs;
  for (int j = 0; j < (o.only >= 0 ? 1 : o.jobs); ++j) {
    const pid_t job = fork();
    if (job != 0) {
      jobs.push_back(job);
      continue;
    }
    const std::string work = folder + "/work" + std::to_string(j);
    mkdir(work.c_str(), 0755);
    if (chdir(work.c_str()) != 0) _exit(2);
    int worst = 0;
    const std::time_t end_of_rounds = std::time(nullptr) + static_cast<std::time_t>(60.0 * o.minutes);
    for (long first = o.only >= 0 ? o.only / kRound * kRound : 0; first < o.inputs && std::time(nullptr) < end_of_rounds; first += kRound)
      for (int s = 0; s < fuzz::kScenes; ++s) {
        if (o.scene >= 0 && s != o.scene) continue;
        if (o.only >= 0 && o.only % fuzz::kScenes != s) continue;
        const pid_t server = fork();
        if (server == 0) serve(static_cast<fuzz::Scene>(s), first, j, o, counts, folder);
        int status;
        waitpid(server, &status, 0);
        if (status != 0) {
          std::fprintf(stderr, "scene '%s' ended with status %d:\n%s\n", fuzz::kSceneNames[s], status, read_all("output.txt").c_str());
          worst = 1;
        }
      }
    _exit(worst);
  }
  int broken = 0;
  for (unsigned long seconds = 1; !jobs.empty(); ++seconds) {
    sleep(1);
    for (std::size_t j = 0; j < jobs.size(); ++j) {
      int status;
      if (waitpid(jobs[j], &status, WNOHANG) == 0) continue;
      broken += status != 0;
      jobs.erase(jobs.begin() + static_cast<long>(j--));
    }
    if (seconds % 60 == 0) std::fprintf(stderr, "%ld of %ld inputs, %ld findings\n", counts->total(), o.inputs, counts->findings());
  }
  std::printf("%-12s", "scene");
  for (const char* name : kOutcomeNames) std::printf("%10s", name);
  std::printf("\n");
  std::ostringstream json;  // as tests/conftest.py writes figures, with the counts besides
  for (int s = 0; s < fuzz::kScenes; ++s) {
    const Counts one = counts->of(s);
    json << (s ? ",\n " : "[") << "{\"test\": \"test_fuzz\", \"case\": \"" << fuzz::kSceneNames[s]
         << "\", \"what\": \"Scripts, point files and restart files with changed words and bytes, under AddressSanitizer and "
            "UndefinedBehaviorSanitizer\", \"figure\": \"ends without a message that names its command, of "
         << counts->total() << " inputs\", \"value\": " << one.findings()
         << ", \"limit\": 0, \"met\": " << (one.findings() ? "false" : "true") << ", \"seed\": " << o.seed << ", \"counts\": {";
    std::printf("%-12s", fuzz::kSceneNames[s]);
    for (int k = 0; k < kOutcomes; ++k) {
      std::printf("%10ld", counts->outcome[s][k]);
      json << (k ? ", \"" : "\"") << kOutcomeNames[k] << "\": " << counts->outcome[s][k];
    }
    json << "}}";
    std::printf("\n");
  }
  json << "]\n";
  if (!o.json.empty()) write_all(o.json, json.str());
  const long findings = counts->findings();
  std::printf("%ld inputs of seed %llu, %ld findings%s%s\n", counts->total(), static_cast<unsigned long long>(o.seed), findings,
              findings ? ", see " : "", findings ? folder.c_str() : "");
  std::fflush(nullptr);
  PMPI_Finalize();
  return findings > 0 || broken > 0;
}
