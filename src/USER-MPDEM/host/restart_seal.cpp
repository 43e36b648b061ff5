// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Makes sure that restart files are complete. LIGGGHTS reads a restart file unchecked: one that is truncated or has a
// flipped byte makes it crash, hang, or continue with a wrong state. So with atom_style mpdem every file that
// `write_restart` or `restart` writes ends with a seal, after the data that LIGGGHTS reads, and read_restart checks the
// seal first. Files of other atom styles have no seal. Neither have those of a LIGGGHTS with the package compiled in,
// which the head of the data of atom_style mpdem says.
#include <mpi.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "../styles/words/arguments.h"
#include "../styles/atoms/atom_vec_mpdem.h"
#include "comm.h"
#include "domain.h"
#include "original.h"
#include "read_restart.h"
#include "update.h"
#include "write_restart.h"

namespace {

using LAMMPS_NS::AtomVecMpdem;

struct Seal {
  char magic[8];
  std::uint64_t length;  // bytes of the file without the seal
  std::int64_t files;    // number of files that belong to a base file (name with '%'), else 0
  std::int64_t step;     // step at which the file was written
  std::uint64_t sum;     // checksum of the file and the members above
};
constexpr char kSealMagic[8] = {'M', 'P', 'D', 'E', 'M', 'e', 'n', 'd'};
// Bytes. Every complete restart file is longer. A truncated file of this length or more still has the head of the data of
// the atom style.
constexpr std::int64_t kShortest = 500;

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
File open_file(const std::string& name, const char* mode) { return File(std::fopen(name.c_str(), mode), &std::fclose); }

// FNV-1a (Fowler, Noll, Vo), 64 bits. Every step is one-to-one, so it detects any single changed byte.
struct Sum {
  std::uint64_t value = 0xcbf29ce484222325u;
  void add(const void* data, std::size_t n) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < n; ++i) value = (value ^ p[i]) * 0x100000001b3u;
  }
};

// Adds the first `length` bytes to the sum. Returns false if there are fewer.
bool sum_of(std::FILE* f, std::uint64_t length, Sum& sum) {
  std::vector<char> buffer(1 << 20);
  while (length > 0) {
    const std::size_t n = std::fread(buffer.data(), 1, std::min<std::uint64_t>(buffer.size(), length), f);
    if (n == 0) return false;
    sum.add(buffer.data(), n);
    length -= n;
  }
  return true;
}

// Size of a regular file in bytes, -1 for anything else.
std::int64_t size_of(const std::string& name) {
  struct stat s;
  return stat(name.c_str(), &s) == 0 && S_ISREG(s.st_mode) ? s.st_size : -1;
}

std::string with(const std::string& name, const std::string& text) {  // replaces '%' by `text`
  const std::size_t at = name.find('%');
  return at == std::string::npos ? name : name.substr(0, at) + text + name.substr(at + 1);
}

// write_seal() and check_seal() return an error message, or an empty text.

// tail: bytes of the blocks of atoms, which are the last of the file. block: size with which the first block begins. A
// full disk shows there, since LIGGGHTS does not check whether its writing succeeded.
std::string write_seal(const std::string& name, std::uint64_t tail, int block, std::int64_t files, std::int64_t step) {
  const std::string failed = "write_restart: file '" + name + "' could not be written whole; use a disk with free space";
  const std::int64_t size = size_of(name);
  if (size < 0) return "write_restart: '" + name + "' is not a regular file; use the name of one";
  File f = open_file(name, "rb+");
  if (!f || static_cast<std::uint64_t>(size) < tail) return failed;
  if (tail > 0) {
    int first;
    if (std::fseek(f.get(), static_cast<long>(size - tail), SEEK_SET) != 0 || std::fread(&first, sizeof first, 1, f.get()) != 1 ||
        first != block)
      return failed;
    std::rewind(f.get());
  }
  Seal seal;
  std::memcpy(seal.magic, kSealMagic, sizeof seal.magic);
  seal.length = static_cast<std::uint64_t>(size);
  seal.files = files;
  seal.step = step;
  Sum sum;
  if (!sum_of(f.get(), seal.length, sum)) return failed;
  sum.add(&seal, offsetof(Seal, sum));
  seal.sum = sum.value;
  std::fseek(f.get(), 0, SEEK_END);
  const bool written = std::fwrite(&seal, sizeof seal, 1, f.get()) == 1;
  return std::fclose(f.release()) == 0 && written ? "" : failed;
}

// sealed: set if the file has a seal, which is then in `seal`. A missing file is left to LIGGGHTS.
std::string check_seal(const std::string& name, bool& sealed, Seal& seal) {
  sealed = false;
  const std::string cure = "; use another restart file";
  File f = open_file(name, "rb");
  const std::int64_t size = size_of(name);
  if (!f) return "";
  if (size < 0) return "read_restart: '" + name + "' is not a regular file; use the name of one";
  const bool long_enough = std::fseek(f.get(), -static_cast<long>(sizeof seal), SEEK_END) == 0;
  if (long_enough && std::fread(&seal, sizeof seal, 1, f.get()) != 1) return "read_restart: file '" + name + "' cannot be read" + cure;
  std::rewind(f.get());
  if (long_enough && std::memcmp(seal.magic, kSealMagic, sizeof seal.magic) == 0) {
    sealed = true;
    Sum sum;
    if (seal.length != size - sizeof seal || !sum_of(f.get(), seal.length, sum))
      return mpdem::text_of("read_restart: file '", name, "' is damaged: it has ", size - sizeof seal, " bytes, and had ", seal.length,
                            " when it was written", cure);
    sum.add(&seal, offsetof(Seal, sum));
    if (sum.value != seal.sum) return "read_restart: file '" + name + "' is damaged: its check sum is not that of what was written" + cure;
    return "";
  }
  if (size < kShortest) return mpdem::text_of("read_restart: file '", name, "' is truncated, it has ", size, " bytes", cure);
  // A file without a seal is of another atom style, of a program that writes no seals, or truncated. The head of the
  // data of atom_style mpdem follows its name, close to the beginning.
  std::vector<char> front(std::min<std::int64_t>(size, 4096));
  if (std::fread(front.data(), 1, front.size(), f.get()) != front.size()) return "read_restart: file '" + name + "' cannot be read" + cure;
  const std::string text(front.begin(), front.end());
  constexpr char kStyle[] = "mpdem";  // the file has the zero at its end, too
  if (text.find(std::string(kStyle, sizeof kStyle)) == std::string::npos) return "";
  const std::size_t at = text.find(std::string(AtomVecMpdem::kRestartMagic, sizeof AtomVecMpdem::kRestartMagic));
  int head[AtomVecMpdem::kRestartHead];
  const bool whole = at != std::string::npos && at + sizeof AtomVecMpdem::kRestartMagic + sizeof head <= text.size();
  if (whole) std::memcpy(head, &text[at + sizeof AtomVecMpdem::kRestartMagic], sizeof head);
  if (whole && (head[0] != AtomVecMpdem::kRestartVersion || !head[AtomVecMpdem::kRestartSealed])) return "";  // the atom style reports this
  return mpdem::text_of("read_restart: file '", name, "' is truncated: its ", size, " bytes do not end as they were written", cure);
}

}  // namespace

namespace LAMMPS_NS {

void WriteRestart::write(char* file) {
  const bool ours = AtomVecMpdem::of(lmp) != nullptr;
  if (ours) AtomVecMpdem::of(lmp)->check_motion_is_kept();  // before LIGGGHTS opens the file, which may be the one that was read
  AtomVecMpdem::restart_is_sealed = ours;
  mpdem::original<void (*)(WriteRestart*, char*)>("_ZN9LAMMPS_NS12WriteRestart5writeEPc")(this, file);
  if (!ours) return;
  const std::string name = file;
  const bool split = name.find('%') != std::string::npos;
  const int block = region ? 0 : atom->avec->size_restart();
  const std::uint64_t bytes = sizeof(int) + sizeof(double) * static_cast<std::uint64_t>(block);
  std::uint64_t all = 0;
  MPI_Reduce(&bytes, &all, 1, MPI_UINT64_T, MPI_SUM, 0, world);
  if (region) all = 0;  // the number of atoms in the region is not known
  AtomVecMpdem::of(lmp)->forget_nodes();
  std::string complaint;
  if (me == 0) complaint = write_seal(with(name, "base"), split ? 0 : all, block, split ? nprocs : 0, update->ntimestep);
  if (split && complaint.empty()) complaint = write_seal(with(name, std::to_string(me)), region ? 0 : bytes, block, 0, update->ntimestep);
  mpdem::stop_if_any(lmp, complaint);
}

void ReadRestart::command(int narg, char** arg) {
  if (narg == 1 && !domain->box_exist) {
    me = comm->me;
    nprocs = comm->nprocs;
    std::string name = arg[0], complaint;
    bool sealed = false;
    Seal seal;
    std::int64_t files = 0, step = 0;
    if (me == 0) {
      if (name.find('*') != std::string::npos) {
        std::vector<char> latest(name.size() + 32);
        file_search(arg[0], latest.data());
        name = latest.data();
      }
      complaint = check_seal(with(name, "base"), sealed, seal);
      if (sealed && complaint.empty()) files = seal.files, step = seal.step;
    }
    mpdem::stop_if_any(lmp, complaint);
    std::int64_t about[3] = {files, step, static_cast<std::int64_t>(name.size())};
    MPI_Bcast(about, 3, MPI_INT64_T, 0, world);
    name.resize(about[2]);
    MPI_Bcast(&name[0], static_cast<int>(about[2]), MPI_CHAR, 0, world);
    for (std::int64_t i = me; i < about[0] && complaint.empty(); i += nprocs) {
      const std::string part = with(name, std::to_string(i));
      complaint = check_seal(part, sealed, seal);
      if (complaint.empty() && size_of(part) >= 0 && (!sealed || seal.step != about[1]))
        complaint = mpdem::text_of("read_restart: file '", part, "' is not of step ", about[1], " as '", with(name, "base"),
                                   "' is; use files that were written together");
    }
    mpdem::stop_if_any(lmp, complaint);
  }
  mpdem::original<void (*)(ReadRestart*, int, char**)>("_ZN9LAMMPS_NS11ReadRestart7commandEiPPc")(this, narg, arg);
}

}  // namespace LAMMPS_NS
