// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Loss is an error: points and grains that are gone, values that are no numbers, grains whose
// motion nobody or two fixes look after. What LIGGGHTS lets pass silently, since `thermo_modify lost`
// ignores and a run full of NaN ends like any other.
#include <mpi.h>

#include <cmath>
#include <string>

#include "arguments.h"
#include "atom.h"
#include "fix_mpm.h"
#include "fix_mpm_couple.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::text_of;

void FixMpm::count_points() {
  bigint mine = 0, total;
  for (int i = 0; i < atom->nlocal; ++i) mine += avec_->is_point(i);
  MPI_Allreduce(&mine, &total, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (total != points_expected_)
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): ", points_expected_ - total,
                                 " material points left the simulation box at step ", update->ntimestep,
                                 "; use a larger or periodic box"));
}

// Bonded or not, among the grains of this rank; empty if all are well.
std::string FixMpm::grain_that_is_not_finite() const {
  for (int i = 0; i < atom->nlocal; ++i) {
    if (avec_->is_point(i)) continue;
    double sum[5] = {0, 0, 0, 0, 0};
    for (int d = 0; d < 3; ++d) {
      sum[0] += atom->x[i][d];
      sum[1] += atom->v[i][d];
      sum[2] += atom->omega[i][d];
      sum[3] += atom->f[i][d];
      sum[4] += atom->torque[i][d];
    }
    const char* const names[] = {"position", "velocity", "angular velocity", "force", "torque"};
    for (int q = 0; q < 5; ++q)
      if (!std::isfinite(sum[q]))
        return text_of("fix mpm (id ", id, "): the ", names[q], " of grain ", atom->tag[i], " is not finite at step ",
                       update->ntimestep, "; check the fixes that move and load it, the time step and the contact model");
  }
  return "";
}

// A bonded grain follows one integrator, or is held on purpose.
void FixMpmCouple::check_integrators() {
  if (update->nsteps == 0) return;  // `run 0` moves nothing
  std::string trouble;
  for (const mpdem::Body& b : cement_->cement()->bodies)
    for (int tag : b.grain) {
      const int i = atom->map(tag);
      if (i < 0 || i >= atom->nlocal || !trouble.empty()) continue;
      const Fix* mover = nullptr;
      bool frozen = false;
      const std::string who = text_of("fix mpm/couple (id ", id, "): bonded grain ", tag, " is ");
      for (int k = 0; k < modify->nfix && trouble.empty(); ++k) {
        const Fix* fix = modify->fix[k];
        if (!(atom->mask[i] & fix->groupbit)) continue;
        frozen = frozen || std::string(fix->style) == "freeze";
        if (!fix->time_integrate) continue;
        if (mover)
          trouble = who + text_of("moved by two fixes, '", mover->id, "' (", mover->style, ") and '", fix->id, "' (", fix->style,
                                  "), twice as far as it should be; take it out of the group of one, or unfix one");
        mover = fix;
      }
      if (mover || !trouble.empty()) continue;
      bool still = true;
      for (int d = 0; d < 3; ++d) still = still && atom->v[i][d] == 0.0 && atom->omega[i][d] == 0.0;
      if (!frozen)
        trouble = who + "moved by no fix, so that its load would be lost; give it to a 'fix nve/sphere' or 'fix move', or hold it "
                        "with 'fix freeze' or 'fix move linear 0 0 0'";
      else if (!still)
        trouble = who + "held by 'fix freeze', but has a velocity, which its cement would feel; set it to 0 with 'velocity' and 'set'";
    }
  mpdem::stop_if_any(lmp, trouble);
}

}  // namespace LAMMPS_NS
