// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "prescribed_motion.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>

#include "atom.h"
#include "fix.h"
#include "fix_move.h"
#include "fix_setforce.h"
#include "lammps.h"
#include "modify.h"
#include "private_access.h"

namespace mpdem {

using LAMMPS_NS::FixMove;
using LAMMPS_NS::FixSetForce;

namespace {

// Does the fix prescribe the motion along direction d?
bool gives(const FixMove* fix, int d) {
  enum { kLinear, kWiggle, kRotate, kVariable };  // values of fix_move.cpp
  const MoveMembers move = members_of(fix);
  switch (move.style) {
    case kLinear: return move.velocity_flag[d] != 0;
    case kWiggle: return move.amplitude_flag[d] != 0;
    case kVariable: return move.position_variable[d] || move.velocity_variable[d];
    default: return true;
  }
}

// For NULL, which leaves a component free, the style is 0 in fix_setforce.cpp. The style of a variable is known only
// after init.
bool sets(const FixSetForce* fix, int d) {
  const SetForceMembers set = members_of(fix);
  return set.variable[d] || set.style[d] != 0;
}

bool is(const LAMMPS_NS::Fix* fix, std::initializer_list<const char*> styles) {
  return std::any_of(styles.begin(), styles.end(), [&](const char* s) { return std::strcmp(fix->style, s) == 0; });
}

}  // namespace

PrescribedMotion prescribed_motion(LAMMPS_NS::LAMMPS* lmp, int atom) {
  PrescribedMotion p;
  for (int k = 0; k < lmp->modify->nfix; ++k) {
    const LAMMPS_NS::Fix* fix = lmp->modify->fix[k];
    if (!(lmp->atom->mask[atom] & fix->groupbit)) continue;
    if (const auto* move = dynamic_cast<const FixMove*>(fix)) {
      for (int d = 0; d < 3; ++d) p.translation[d] = p.translation[d] || gives(move, d);
      p.rotation = true;
    } else if (const auto* set = dynamic_cast<const FixSetForce*>(fix)) {
      for (int d = 0; d < 3; ++d) p.translation[d] = p.translation[d] || sets(set, d);
    } else if (is(fix, {"freeze", "nve/noforce"})) {
      p.translation[0] = p.translation[1] = p.translation[2] = p.rotation = true;
    } else if (is(fix, {"nve", "nve/limit"})) {
      p.rotation = true;
    }
  }
  return p;
}

}  // namespace mpdem
