// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The only file with access to private members of LIGGGHTS' classes. LIGGGHTS has no accessors for them, and its
// headers stay unchanged. private_access.cpp names each member once.
#ifndef MPDEM_STYLES_ATOMS_PRIVATE_ACCESS_H
#define MPDEM_STYLES_ATOMS_PRIVATE_ACCESS_H

#include <map>
#include <string>

#include "lammps.h"
#include "lmptype.h"

namespace LAMMPS_NS {
class Comm;
class Compute;
class Dump;
class Fix;
class FixGravity;
class FixMove;
class FixSetForce;
class Input;
class Modify;
class Output;
class PairGranProxy;
class Variable;
}  // namespace LAMMPS_NS
namespace LIGGGHTS::PairStyles {
class IGranularPairStyle;
}

namespace mpdem {

// Tables of LIGGGHTS: name of a style or command, and the function that makes it.
using FixStyles = std::map<std::string, LAMMPS_NS::Fix* (*)(LAMMPS_NS::LAMMPS*, int, char**)>;
using ComputeStyles = std::map<std::string, LAMMPS_NS::Compute* (*)(LAMMPS_NS::LAMMPS*, int, int, char**)>;
using CommandStyles = std::map<std::string, void (*)(LAMMPS_NS::LAMMPS*, int, char**)>;

FixStyles& fix_styles(LAMMPS_NS::Modify* modify);
ComputeStyles& compute_styles(LAMMPS_NS::Modify* modify);
CommandStyles& command_styles(LAMMPS_NS::Input* input);

// Returns the name of the file that a dump writes.
const char* file_of(const LAMMPS_NS::Dump* dump);

// Contact model of a pair style gran, which it deletes at its end.
using ContactModel = LIGGGHTS::PairStyles::IGranularPairStyle;
ContactModel*& model_of(LAMMPS_NS::PairGranProxy* contacts);

// Returns the index of the group of `communicate ... group`, or 0 without one.
int ghost_group(const LAMMPS_NS::Comm* comm);

// When LIGGGHTS writes restart files. any: a command `restart` asked for some. next_single, next_double: next step of
// either kind.
struct RestartSchedule {
  bool any;
  LAMMPS_NS::bigint &next_single, &next_double;
};
RestartSchedule restart_schedule(LAMMPS_NS::Output* output);

// Members of fix move, by direction. Where the script gives a component, its flag is not 0 and the name of its variable
// not null. `style` is mstyle of fix_move.cpp; the flags are those of velocities and amplitudes.
struct MoveMembers {
  int style;
  int velocity_flag[3], amplitude_flag[3];
  const char *position_variable[3], *velocity_variable[3];
};
MoveMembers members_of(const LAMMPS_NS::FixMove* move);

// Does the gravity depend on a variable?
bool is_variable(const LAMMPS_NS::FixGravity* gravity);

// Returns the formula of a variable of style equal. place: its index in the table of variables.
const char* formula_of(LAMMPS_NS::Variable* variables, int place);

// Makes the fix the last in the lists of initial_integrate, pre_final_integrate and final_integrate for the rest of
// this run.
void act_last(LAMMPS_NS::Modify* modify, const LAMMPS_NS::Fix* fix);
// Makes the fix the last in the list of pre_exchange for the rest of this run.
void exchange_last(LAMMPS_NS::Modify* modify, const LAMMPS_NS::Fix* fix);

// Members of fix setforce, by direction.
struct SetForceMembers {
  int style[3];
  const char* variable[3];
  bool in_region;  // sets the forces of atoms in a region only
};
SetForceMembers members_of(const LAMMPS_NS::FixSetForce* fix);

}  // namespace mpdem

#endif
