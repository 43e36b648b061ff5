// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// How the cement is computed: what the words of a script say of it, but for its law.
#ifndef MPDEM_CEMENT_OPTIONS_H
#define MPDEM_CEMENT_OPTIONS_H

#include <limits>

#include "../mpm/advance_points.h"
#include "../mpm/basis.h"
#include "../mpm/body.h"
#include "../mpm/transfer.h"

namespace mpdem {

constexpr int kMostSubsteps = 1000;

struct CementOptions {
  double cell = 0.0;
  Basis basis = Basis::quadratic;
  AxisRule axis = AxisRule::radial;      // of new points
  double axis_direction[3] = {0, 0, 1};  // a unit vector, of `global`
  bool updated = false;                  // kinematics: the reference is the present
  bool tied = true;                      // nodes at the edge of the cement, see mpm/edge_ties.h
  Transfer transfer;
  int reproject_every = 0;               // steps, 0: never
  double reproject_distortion = 0.0;     // 0: not by distortion
  AdvanceOptions skip;
  double mass_scale = 1.0, relax = 0.0;  // quasistatic: factor of the inertia, share of critical damping
  double length = 0.0;                   // that the drive of the damage is averaged over, 0: not at all
  double half_band = 0.0;                // of a crack with this length, Law::crack_band(); 0: it has none, or one that is not known
  int mass_order = 1;                    // 1 or 2 terms of the inverse of the consistent mass, see mpm/consistent_mass.h
  bool split = false;                    // nodes where material parts, see fracture/node_copies.h
  bool unilateral = false;               // failed points are stiff while their crack is closed, see mpm/closing_points.h
  bool condense = false;                 // bonds whose damage is far from its threshold, see cement/condensed_bonds.h
  double wake = 0.8;                     // share of the threshold that ends that
  int subcycle = 1;                      // sub-steps in a step of the host, 0: as many as the cement needs
  bool balance = false;                  // bonds go to ranks that have less work, see cement/work_shares.h
  int check_every = 100;                 // steps
  double most_bytes = std::numeric_limits<double>::infinity();  // of the grids of a rank

  // Do the nodes beside a crack share the mass of what failed there, see fracture/node_copies.h? Points that may be stiff again keep their
  // mass at their own nodes, on which the bound of the step rests.
  bool shares_failed_mass() const { return split && !unilateral; }
  // Do points give velocity to nodes at all?
  bool transfers() const { return updated || reproject_every > 0; }
  // Largest dt^2 lambda. A mode that a transfer removes altogether takes half of what the central difference takes.
  double stability_bound() const { return (transfers() ? 2.0 : 4.0) / mass_order; }
};

}  // namespace mpdem

#endif
