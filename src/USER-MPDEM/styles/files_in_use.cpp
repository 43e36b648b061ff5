// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "files_in_use.h"

#include <sys/stat.h>

#include <cstdio>
#include <filesystem>

#include "arguments.h"
#include "comm.h"
#include "dump.h"
#include "fix_mpm.h"
#include "fix_mpm_couple.h"
#include "modify.h"
#include "output.h"
#include "private_access.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {

bool same(const struct stat& a, const struct stat& b) { return S_ISREG(a.st_mode) && a.st_dev == b.st_dev && a.st_ino == b.st_ino; }

bool is_stream(const std::string& name, std::FILE* stream) {
  struct stat a, b;
  return stream && stat(name.c_str(), &a) == 0 && fstat(fileno(stream), &b) == 0 && same(a, b);
}

}  // namespace

bool same_file(const std::string& a, const std::string& b) {
  struct stat of_a, of_b;
  if (stat(a.c_str(), &of_a) == 0 && stat(b.c_str(), &of_b) == 0) return same(of_a, of_b);
  // not there yet, one of them: then only names that lead to the same place are the same file
  std::error_code code;
  const std::filesystem::path there = std::filesystem::weakly_canonical(std::filesystem::absolute(a, code), code);
  return !code && there == std::filesystem::weakly_canonical(std::filesystem::absolute(b, code), code) && !code;
}

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
  return is_stream(name, lmp->screen) ? "the screen output" : "";
}

void check_only_writer(LAMMPS* lmp, const std::string& who, const std::string& word, const std::string& name, const Fix* asks) {
  if (name.empty()) return;
  const std::string other = lmp->comm->me == 0 ? writer_of(lmp, name, asks) : "";
  stop_if_any(lmp, other.empty() ? "" : text_of(who, "'", word, "' file ", name, " is written by ", other, " too; name another"));
}

}  // namespace mpdem
