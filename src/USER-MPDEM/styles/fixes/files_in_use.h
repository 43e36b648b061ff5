// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds who writes to a file already, since two writers of one file would mix their lines. Names may be spelled
// differently, and may be links. Devices such as /dev/null may have any number of writers.
#ifndef MPDEM_STYLES_FIXES_FILES_IN_USE_H
#define MPDEM_STYLES_FIXES_FILES_IN_USE_H

#include <string>

#include "fix.h"
#include "lammps.h"

namespace mpdem {

bool same_file(const std::string& a, const std::string& b);

// Returns the writer: "'csv' of fix mpm/couple (id bond)", a dump, the log, a fix or command that has the file open, or
// an empty text. `asks`: the fix whose own table does not count, or null. Call it on the first rank.
std::string writer_of(LAMMPS_NS::LAMMPS* lmp, const std::string& name, const LAMMPS_NS::Fix* asks);

// Collective. Stops if the file of keyword `word` of a fix has another writer. An empty name means no file.
void check_only_writer(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::string& word, const std::string& name,
                       const LAMMPS_NS::Fix* asks);

}  // namespace mpdem

#endif
