// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "host_recipe.h"

#include <cstring>

#include "arguments.h"
#include "atom.h"
#include "comm.h"
#include "group.h"
#include "neighbor.h"
#include "private_access.h"
#include "update.h"

namespace LAMMPS_NS {

namespace {

const char* const kRecipe =
    "; the script needs these three lines, with a group that holds all grains and no cement:\n"
    "    atom_modify  map array first grains      (before the box is created)\n"
    "    communicate  single vel yes group grains\n"
    "    neigh_modify include grains";

constexpr int kNeighborMulti = 2;  // value of Neighbor::style

}  // namespace

void check_host_recipe(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& cement) {
  const Atom& atom = *lmp->atom;
  if (lmp->neighbor->style == kNeighborMulti)
    mpdem::stop_all(lmp, who + "'neighbor ... multi' finds no contacts of grains in LIGGGHTS; use 'neighbor ... bin'");
  constexpr int kMinimize = 2;  // value of Update::whichflag
  if (lmp->update->whichflag == kMinimize)
    mpdem::stop_all(lmp, who + "'minimize' never calls fix mpm, so that cement would do nothing; use 'run', and 'quasistatic' of fix mpm where the cement shall come to rest");
  if (std::strcmp(lmp->update->integrate_style, "verlet") != 0)
    mpdem::stop_all(lmp, who + mpdem::text_of("'run_style ", lmp->update->integrate_style, "' never calls fix mpm, so that cement would do nothing; use 'run_style verlet', and 'subcycle' of fix mpm where the cement needs shorter steps"));
  if (!atom.firstgroupname) mpdem::stop_all(lmp, who + "'atom_modify first' is not set" + kRecipe);
  const int ghosts = mpdem::ghost_group(lmp->comm);
  if (ghosts == 0) mpdem::stop_all(lmp, who + "'communicate ... group' is not set" + kRecipe);
  if (lmp->neighbor->includegroup == 0) mpdem::stop_all(lmp, who + "'neigh_modify include' is not set" + kRecipe);
  const int first = lmp->group->find(atom.firstgroupname);
  if (ghosts != first || lmp->neighbor->includegroup != first)
    mpdem::stop_all(lmp, who + "the three groups differ" + kRecipe);
  if (!lmp->comm->ghost_velocity) mpdem::stop_all(lmp, who + "'communicate ... vel yes' is not set" + kRecipe);
  if (atom.map_style == 0) mpdem::stop_all(lmp, who + "'atom_modify map array' is not set" + kRecipe);
  std::string trouble;
  const int bit = lmp->group->bitmask[first];
  for (int i = 0; i < atom.nlocal && trouble.empty(); ++i) {
    const bool point = cement.is_point(i);
    if (point == ((atom.mask[i] & bit) != 0))
      trouble = who + mpdem::text_of(point ? "material point " : "grain ", atom.tag[i], point ? " is" : " is not",
                                     " in group '", atom.firstgroupname, "'", kRecipe);
  }
  mpdem::stop_if_any(lmp, trouble);
}

std::string grain_outside_of_group(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& cement) {
  const Atom& atom = *lmp->atom;
  const int bit = lmp->group->bitmask[lmp->group->find(atom.firstgroupname)];
  for (int i = 0; i < atom.nlocal; ++i)
    if (!cement.is_point(i) && !(atom.mask[i] & bit))
      return who + mpdem::text_of("grain ", atom.tag[i], " is not in group '", atom.firstgroupname, "', so that it touches neither "
                                  "grains nor walls; give the fix particletemplate or fix insert that makes it this group");
  return "";
}

}  // namespace LAMMPS_NS
