// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "private_access.h"

#include "../styles/expose.h"

namespace mpdem {

using LAMMPS_NS::Input;
using LAMMPS_NS::Modify;

struct FixMap {
  using Type = std::map<std::string, FixCreator>* Modify::*;
  friend Type member(FixMap);
};
struct ComputeMap {
  using Type = std::map<std::string, ComputeCreator>* Modify::*;
  friend Type member(ComputeMap);
};
struct CommandMap {
  using Type = std::map<std::string, CommandCreator>* Input::*;
  friend Type member(CommandMap);
};
template struct Expose<FixMap, &Modify::fix_map>;
template struct Expose<ComputeMap, &Modify::compute_map>;
template struct Expose<CommandMap, &Input::command_map>;

std::map<std::string, FixCreator>& fix_styles(Modify* modify) { return *(modify->*member(FixMap{})); }
std::map<std::string, ComputeCreator>& compute_styles(Modify* modify) { return *(modify->*member(ComputeMap{})); }
std::map<std::string, CommandCreator>& command_styles(Input* input) { return *(input->*member(CommandMap{})); }

}  // namespace mpdem
