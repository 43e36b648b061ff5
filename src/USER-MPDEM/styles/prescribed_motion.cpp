// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "prescribed_motion.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>

#include "atom.h"
#include "expose.h"
#include "fix.h"
#include "fix_move.h"
#include "fix_setforce.h"
#include "lammps.h"
#include "modify.h"

namespace mpdem {

using LAMMPS_NS::FixMove;
using LAMMPS_NS::FixSetForce;

#define MPDEM_EXPOSE_OF(FIX, WHO, T, M)  \
  struct M##_of_##WHO {                  \
    using Type = T FIX::*;               \
    friend Type member(M##_of_##WHO);    \
  };                                     \
  template struct Expose<M##_of_##WHO, &FIX::M>;
#define MPDEM_EXPOSE(T, M) MPDEM_EXPOSE_OF(FixMove, move, T, M)
MPDEM_EXPOSE(int, mstyle)
MPDEM_EXPOSE(int, vxflag)
MPDEM_EXPOSE(int, vyflag)
MPDEM_EXPOSE(int, vzflag)
MPDEM_EXPOSE(int, axflag)
MPDEM_EXPOSE(int, ayflag)
MPDEM_EXPOSE(int, azflag)
MPDEM_EXPOSE(char*, xvarstr)
MPDEM_EXPOSE(char*, yvarstr)
MPDEM_EXPOSE(char*, zvarstr)
MPDEM_EXPOSE(char*, vxvarstr)
MPDEM_EXPOSE(char*, vyvarstr)
MPDEM_EXPOSE(char*, vzvarstr)
MPDEM_EXPOSE_OF(FixSetForce, setforce, char*, xstr)
MPDEM_EXPOSE_OF(FixSetForce, setforce, char*, ystr)
MPDEM_EXPOSE_OF(FixSetForce, setforce, char*, zstr)
MPDEM_EXPOSE_OF(FixSetForce, setforce, int, xstyle)
MPDEM_EXPOSE_OF(FixSetForce, setforce, int, ystyle)
MPDEM_EXPOSE_OF(FixSetForce, setforce, int, zstyle)
#undef MPDEM_EXPOSE
#undef MPDEM_EXPOSE_OF

namespace {

// Whether the motion along direction d is given.
bool gives(const FixMove* move, int d) {
  enum { kLinear, kWiggle, kRotate, kVariable };  // as in fix_move.cpp
  int FixMove::*const linear[3] = {member(vxflag_of_move{}), member(vyflag_of_move{}), member(vzflag_of_move{})};
  int FixMove::*const wiggle[3] = {member(axflag_of_move{}), member(ayflag_of_move{}), member(azflag_of_move{})};
  char* FixMove::*const place[3] = {member(xvarstr_of_move{}), member(yvarstr_of_move{}), member(zvarstr_of_move{})};
  char* FixMove::*const speed[3] = {member(vxvarstr_of_move{}), member(vyvarstr_of_move{}), member(vzvarstr_of_move{})};
  switch (move->*member(mstyle_of_move{})) {
    case kLinear: return move->*linear[d] != 0;
    case kWiggle: return move->*wiggle[d] != 0;
    case kVariable: return move->*place[d] || move->*speed[d];
    default: return true;
  }
}

// NULL, the style that leaves a component alone, is 0 in fix_setforce.cpp; that of a variable is known after init.
bool sets(const FixSetForce* fix, int d) {
  int FixSetForce::*const style[3] = {member(xstyle_of_setforce{}), member(ystyle_of_setforce{}), member(zstyle_of_setforce{})};
  char* FixSetForce::*const variable[3] = {member(xstr_of_setforce{}), member(ystr_of_setforce{}), member(zstr_of_setforce{})};
  return fix->*variable[d] || fix->*style[d] != 0;
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
