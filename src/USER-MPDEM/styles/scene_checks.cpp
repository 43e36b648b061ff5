// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "scene_checks.h"

#include <mpi.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "arguments.h"
#include "atom.h"
#include "force.h"
#include "update.h"

namespace mpdem {

using namespace LAMMPS_NS;

std::string trouble_with_units(LAMMPS* lmp) {
  const char* const style = lmp->update->unit_style;
  const std::string cure = "; use 'units si', 'cgs' or 'micro'";
  if (std::strcmp(style, "lj") == 0) return "units 'lj' are without dimension, cement has moduli, densities and strengths" + cure;
  if (lmp->force->ftm2v != 1.0 || lmp->force->nktv2p != 1.0) return text_of("units '", style, "' are not consistent") + cure;
  return "";
}

double density_of_calcite(LAMMPS* lmp) {
  const std::string units = lmp->update->unit_style;
  return units == "si" ? 2710.0 : units == "cgs" || units == "micro" ? 2.71 : 0.0;
}

// Grains and cement of one type are refused: groups by type, contact laws and particle templates could not tell them
// apart.
std::string trouble_with_types(LAMMPS* lmp, const AtomVecMpdem& cement, int type) {
  const Atom& atom = *lmp->atom;
  // for each type, the lowest ID of a grain, and whether there is cement
  const int none = MAXSMALLINT, types = atom.ntypes + 1;
  std::vector<int> grain(types, none), point(types, 0);
  for (int i = 0; i < atom.nlocal; ++i) {
    if (cement.is_point(i)) point[atom.type[i]] = 1;
    else grain[atom.type[i]] = std::min(grain[atom.type[i]], atom.tag[i]);
  }
  for (const PointPattern& p : cement.bonds.patterns) point[p.head.type] = 1;
  MPI_Allreduce(MPI_IN_PLACE, grain.data(), types, MPI_INT, MPI_MIN, lmp->world);
  MPI_Allreduce(MPI_IN_PLACE, point.data(), types, MPI_INT, MPI_MAX, lmp->world);
  if (type > 0) point[type] = 1;
  for (int t = 1; t < types; ++t)
    if (point[t] && grain[t] != none)
      return text_of("type ", t, " is that of grain ", grain[t], " too; give cement an atom type of its own, by 'type' of create_cement and one type "
                     "more in create_box, and grains another 'atom_type' of fix particletemplate");
  return "";
}

}  // namespace mpdem
