// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Access to the few members of LIGGGHTS' classes that it offers no accessor for, without
// changing its headers: the arguments of an explicit template instantiation may name
// private members ([temp.spec]).
#ifndef MPDEM_PRIVATE_ACCESS_H
#define MPDEM_PRIVATE_ACCESS_H

#include <map>
#include <string>

#include "input.h"
#include "lammps.h"
#include "modify.h"

namespace mpdem {

using FixCreator = LAMMPS_NS::Fix* (*)(LAMMPS_NS::LAMMPS*, int, char**);
using ComputeCreator = LAMMPS_NS::Compute* (*)(LAMMPS_NS::LAMMPS*, int, int, char**);
using CommandCreator = void (*)(LAMMPS_NS::LAMMPS*, int, char**);

std::map<std::string, FixCreator>& fix_styles(LAMMPS_NS::Modify* modify);
std::map<std::string, ComputeCreator>& compute_styles(LAMMPS_NS::Modify* modify);
std::map<std::string, CommandCreator>& command_styles(LAMMPS_NS::Input* input);

}  // namespace mpdem

#endif
