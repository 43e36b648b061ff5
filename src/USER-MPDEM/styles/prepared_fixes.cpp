// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "prepared_fixes.h"

#include <algorithm>

#include "arguments.h"
#include "fix.h"
#include "modify.h"

namespace LAMMPS_NS {

using mpdem::text_of;

void PreparedFixes::note(const LAMMPS* lmp) {
  known_.clear();
  for (int k = 0; k < lmp->modify->nfix; ++k) {
    const Fix& fix = *lmp->modify->fix[k];
    known_.push_back({fix.id, fix.style, fix.just_created != 0});
  }
}

// Returns the change, or an empty text. Addresses are of no use, since a fix may get that of the one it replaces.
std::string PreparedFixes::change(const LAMMPS* lmp) const {
  Fix** const first = lmp->modify->fix;
  Fix** const end = first + lmp->modify->nfix;
  for (Fix** f = first; f != end; ++f) {
    const Fix& fix = **f;
    const auto of_run = std::find_if(known_.begin(), known_.end(), [&](const Known& k) { return k.id == fix.id; });
    if (of_run == known_.end() || (fix.just_created && !of_run->created)) return text_of("fix ", fix.style, " (id ", fix.id, ") was defined");
  }
  for (const Known& k : known_)
    if (std::none_of(first, end, [&](const Fix* fix) { return k.id == fix->id; })) return text_of("fix ", k.style, " (id ", k.id, ") was removed");
  return "";
}

void PreparedFixes::check_same(LAMMPS* lmp) const {
  const std::string found = change(lmp);
  if (!found.empty()) mpdem::stop_all(lmp, "run ... pre no: " + found + " since the last run with fix mpm; leave 'pre no' out");
}

}  // namespace LAMMPS_NS
