// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Pass over the points in a step with `total` kinematics (total Lagrangian). It gathers the velocity gradient from the
// grid, finds deformation gradient, co-rotated strain, damage and stress of each point, and scatters the internal force
// to the grid. With the Kirchhoff stress tau = C(D) : strain and P = tau F^-T the force of a node is
//   f_I = - sum_p V_p P_p grad N_I(X_p).
// This conserves momentum and angular momentum of the nodes to rounding. The law gives energy per reference volume, and
// the Kirchhoff stress is work-conjugate to that. If it were taken as the Cauchy stress, the work of the forces would
// differ from the energy by the change of volume, which is 1 % and more at the strains at which cement fails.
#ifndef MPDEM_MPM_ADVANCE_POINTS_H
#define MPDEM_MPM_ADVANCE_POINTS_H

#include <vector>

#include "../material/law.h"
#include "grid.h"
#include "pass_clock.h"
#include "point_store.h"

namespace mpdem {

// What drives the damage in a pass, and which work it may skip. Skipping does not change the result.
struct AdvanceOptions {
  bool skip_undamaged = true;  // no return mapping where a bound shows that no damage grows
  bool skip_failed = true;     // skip blocks all of whose points failed
  bool skip_resting = true;    // skip bonds that have not been strained or moved
  // Averages drive the damage (drive_average.h). Points without an average keep their damage.
  bool nonlocal = false;
};

struct AdvanceResult {
  double dissipated = 0.0, released = 0.0;  // energies of this step
  std::vector<int> failed;                  // slots that failed in this step, ascending
  bool near_threshold = false;              // nonlocal damage only: some point is near its threshold, or damage has grown
  PassTicks ticks;
};

// Advances the points of the blocks [first, last) by dt with the nodal velocity, and adds the internal force at the end
// of the step. Failed points keep their state and exert no force. law: that of material 0, here and in other passes.
void advance_points(PointStore& points, int first, int last, Grid& grid, const Law& law, double dt, const AdvanceOptions& options,
                    AdvanceResult& result);

inline void advance_points(PointStore& points, Grid& grid, const Law& law, double dt, AdvanceResult& result) {
  advance_points(points, 0, static_cast<int>(points.blocks.size()), grid, law, dt, AdvanceOptions(), result);
}

// Adds the internal force of the present state. Changes no point.
void add_internal_force(const PointStore& points, Grid& grid, const Law& law);

}  // namespace mpdem

#endif
