// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "atom.h"
#include "host_guards.h"

namespace mpdem {

Densities densities(const HostView& view) {
  constexpr double kRounding = 1e-12;
  const Bonds& bonds = view.cement->bonds;
  const LAMMPS_NS::Atom& atom = *view.lmp->atom;
  double least[4] = {HUGE_VAL, HUGE_VAL, HUGE_VAL, 0.0};  // lowest density, and lowest negative density; lowest own; -1: changed
  const auto add = [&](double density, double own) {
    if (own > 0.0) {
      least[2] = std::min(least[2], own);
      if (std::fabs(density - own) > kRounding * own) least[3] = -1.0;
    } else {
      least[0] = std::min(least[0], density), least[1] = std::min(least[1], -density);
    }
  };
  for (int i = 0; i < atom.nlocal; ++i)
    if (view.cement->is_point(i))
      add(atom.density[i], bonds.own_density(view.cement->points_of(i).meta[view.cement->slot_of(i) / kLanes].material));
  for (int row : bonds.rows_without_points()) {
    const PointTemplate& made_later = bonds.template_of(row);
    for (const TemplatePoint& p : made_later.points) {
      const double own = bonds.own_density(p.material);
      add(own > 0.0 ? own : made_later.head.density, own);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, least, 4, MPI_DOUBLE, MPI_MIN, view.lmp->world);
  return {least[0], -least[1], std::isfinite(least[2]) ? least[2] : 0.0, least[3] < 0.0};
}

}  // namespace mpdem
