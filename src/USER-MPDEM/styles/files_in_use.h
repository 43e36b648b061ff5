// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Who writes to a file already: two writers of one file leave a mixture. Names may be spelled differently, and may be
// links; devices such as /dev/null take as many as there are.
#ifndef MPDEM_FILES_IN_USE_H
#define MPDEM_FILES_IN_USE_H

#include <string>

#include "fix.h"
#include "lammps.h"

namespace mpdem {

bool same_file(const std::string& a, const std::string& b);

// "'csv' of fix mpm/couple (id bond)", a dump, the log, a fix or command that holds the file open, or empty. `asks`: the fix whose own table does not count, or null.
// To be asked on the first rank.
std::string writer_of(LAMMPS_NS::LAMMPS* lmp, const std::string& name, const LAMMPS_NS::Fix* asks);

// Stops all ranks if the file of keyword `word` of a fix has another writer. Collective; no name, no file.
void check_only_writer(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::string& word, const std::string& name,
                       const LAMMPS_NS::Fix* asks);

}  // namespace mpdem

#endif
