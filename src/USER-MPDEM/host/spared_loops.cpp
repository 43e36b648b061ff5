// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Loops of LIGGGHTS over all atoms of a rank in every step that do nothing for points: contacts with triangles of mesh
// walls, and gravity. Here they end with the grains. See registration.cpp for how these definitions take precedence
// over those of the library. patches/ has the same for a LIGGGHTS that is compiled anew.
//
// The first group is that of `neigh_modify include`: the grains. Only its atoms are in the bins of LIGGGHTS' neighbour
// lists, by which LIGGGHTS finds triangles next to atoms. So points have no triangles, and their contact flags are never
// read. AtomVecMpdem::points_excluded says that a run was prepared so; `include` may have changed since.
#include <mpi.h>

#include <algorithm>

#include "../styles/atoms/atom_vec_mpdem.h"
#include "../styles/atoms/grains_only.h"
#include "../styles/atoms/private_access.h"
#include "error.h"
#include "fix_contact_history_mesh.h"
#include "fix_gravity.h"
#include "fix_property_atom.h"
#include "neighbor.h"
#include "original.h"

namespace {

using namespace LAMMPS_NS;

// Are points left out of the neighbour lists (`neigh_modify include`)? The answer is the same on all ranks.
bool points_are_excluded(LAMMPS* lmp) {
  const AtomVecMpdem* cement = AtomVecMpdem::of(lmp);
  return cement && cement->points_excluded && !cement->bonds.table.empty() && lmp->neighbor->includegroup != 0;
}

// Commands may have deleted atoms since LIGGGHTS counted the first group, so nfirst may exceed nlocal. Grains precede
// points even then.
bool points_are_behind(const Atom& atom) { return atom.nfirst >= 0 && atom.nfirst <= atom.nlocal; }

// fix mpm applies the weight of points, and forces on their atoms have no effect. Their potential energy is added in
// compute_scalar(). A variable of the gravity may depend on points.
bool leaves_points_out(const FixGravity* gravity, LAMMPS* lmp) { return points_are_excluded(lmp) && !mpdem::is_variable(gravity); }

}  // namespace

namespace LAMMPS_NS {

// Clears only the flags in use. LIGGGHTS clears a whole page of them, 100 kB for each mesh.
void FixContactHistoryMesh::markAllContacts() {
  static const auto of_all = mpdem::original<void (*)(FixContactHistoryMesh*)>("_ZN9LAMMPS_NS21FixContactHistoryMesh15markAllContactsEv");
  if (!points_are_excluded(lmp) || !points_are_behind(*atom)) return of_all(this);
  keeppage_[0]->reset();
  intersectpage_[0]->reset();
  for (int i = 0; i < atom->nfirst; ++i) {
    const int triangles = fix_nneighs_->get_vector_atom_int(i);
    keepflag_[i] = keeppage_[0]->get(triangles);
    intersectflag_[i] = intersectpage_[0]->get(triangles);
    if (!keepflag_[i] || !intersectflag_[i]) error->one(FLERR, "mesh contact history overflow, boost neigh_modify one");
    std::fill_n(keepflag_[i], triangles, false);
    std::fill_n(intersectflag_[i], triangles, false);
  }
}

void FixContactHistoryMesh::cleanUpContacts() {
  cleanUpContacts(0, points_are_excluded(lmp) && points_are_behind(*atom) ? atom->nfirst : atom->nlocal);
}

void FixGravity::post_force(int vflag) {
  static const auto loop = mpdem::original<void (*)(FixGravity*, int)>("_ZN9LAMMPS_NS10FixGravity10post_forceEi");
  if (!leaves_points_out(this, lmp) || !points_are_behind(*atom)) return loop(this, vflag);
  const mpdem::GrainsOnly alone(*atom);
  loop(this, vflag);
}

double FixGravity::compute_scalar() {
  static const auto of_atoms = mpdem::original<double (*)(FixGravity*)>("_ZN9LAMMPS_NS10FixGravity14compute_scalarEv");
  const double energy = of_atoms(this);
  if (!leaves_points_out(this, lmp)) return energy;
  double g[3], mine = 0.0, of_points;
  get_gravity(g);
  if (points_are_behind(*atom))
    for (int i = atom->nfirst; i < atom->nlocal; ++i)
      if (atom->mask[i] & groupbit) mine -= atom->rmass[i] * (g[0] * atom->x[i][0] + g[1] * atom->x[i][1] + g[2] * atom->x[i][2]);
  MPI_Allreduce(&mine, &of_points, 1, MPI_DOUBLE, MPI_SUM, world);
  return energy + of_points;
}

}  // namespace LAMMPS_NS
