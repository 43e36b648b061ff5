// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "files_in_use.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "../words/arguments.h"
#include "comm.h"
#include "dump.h"
#include "fix_mpm.h"
#include "fix_mpm_couple.h"
#include "modify.h"
#include "output.h"
#include "../atoms/private_access.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {

bool same(const struct stat& a, const struct stat& b) { return S_ISREG(a.st_mode) && a.st_dev == b.st_dev && a.st_ino == b.st_ino; }

bool is_stream(const std::string& name, std::FILE* stream) {
  struct stat a, b;
  return stream && stat(name.c_str(), &a) == 0 && fstat(fileno(stream), &b) == 0 && same(a, b);
}

// Returns how many streams of this program may write to the file. Fixes of LIGGGHTS such as ave/time and print have
// files open that cannot be queried.
int writing_streams(const std::string& name) {
  struct stat file, of;
  DIR* open_files = stat(name.c_str(), &file) == 0 ? opendir("/proc/self/fd") : nullptr;
  if (!open_files) return 0;
  int count = 0;
  while (const dirent* entry = readdir(open_files)) {
    if (entry->d_name[0] == '.') continue;
    const int fd = std::atoi(entry->d_name);
    const int how = fcntl(fd, F_GETFL);
    count += how >= 0 && (how & O_ACCMODE) != O_RDONLY && fstat(fd, &of) == 0 && same(file, of);
  }
  closedir(open_files);
  return count;
}

}  // namespace

bool same_file(const std::string& a, const std::string& b) {
  struct stat of_a, of_b;
  if (stat(a.c_str(), &of_a) == 0 && stat(b.c_str(), &of_b) == 0) return same(of_a, of_b);
  // Here one of the files does not exist yet, so the paths are compared.
  std::error_code code;
  const std::filesystem::path there = std::filesystem::weakly_canonical(std::filesystem::absolute(a, code), code);
  return !code && there == std::filesystem::weakly_canonical(std::filesystem::absolute(b, code), code) && !code;
}

namespace {

// Returns the number of streams that a fix of this package has open for its own table.
int own_streams(const Fix* fix) {
  if (const auto* mpm = dynamic_cast<const FixMpm*>(fix)) return mpm->events_open();
  const auto* couple = dynamic_cast<const FixMpmCouple*>(fix);
  return couple && couple->table_open();
}

}  // namespace

std::string writer_of(LAMMPS* lmp, const std::string& name, const Fix* asks) {
  for (int i = 0; i < lmp->modify->nfix; ++i) {
    const Fix* fix = lmp->modify->fix[i];
    if (fix == asks) continue;
    std::string theirs, word;
    if (const auto* mpm = dynamic_cast<const FixMpm*>(fix)) theirs = mpm->events_name(), word = "'events'";
    if (const auto* couple = dynamic_cast<const FixMpmCouple*>(fix)) theirs = couple->table_name(), word = "'csv'";
    if (!theirs.empty() && same_file(name, theirs)) return text_of(word, " of fix ", fix->style, " (id ", fix->id, ")");
  }
  for (int i = 0; i < lmp->output->ndump; ++i) {
    const Dump* dump = lmp->output->dump[i];
    if (same_file(name, file_of(dump))) return text_of("dump '", dump->id, "'");
  }
  if (is_stream(name, lmp->logfile)) return "the log";
  if (is_stream(name, lmp->screen)) return "the screen output";
  return writing_streams(name) > (asks ? own_streams(asks) : 0) ? "another fix or command, such as fix ave/time or fix print," : "";
}

void check_only_writer(LAMMPS* lmp, const std::string& who, const std::string& word, const std::string& name, const Fix* asks) {
  if (name.empty()) return;
  const std::string other = lmp->comm->me == 0 ? writer_of(lmp, name, asks) : "";
  stop_if_any(lmp, other.empty() ? "" : text_of(who, "'", word, "' file ", name, " is written by ", other, " too; name another"));
}

}  // namespace mpdem
