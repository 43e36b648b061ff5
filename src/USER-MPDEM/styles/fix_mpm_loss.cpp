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
#include "domain.h"
#include "fix_mpm.h"
#include "fix_mpm_couple.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::text_of;

namespace {
constexpr int kFixedBoundary = 1;  // Domain::boundary
}

void FixMpm::count_points() {
  bigint mine = 0, total;
  for (int i = 0; i < atom->nlocal; ++i) mine += avec_->is_point(i);
  MPI_Allreduce(&mine, &total, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (total != points_expected_)
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): ", points_expected_ - total,
                                 " material points left the simulation box at step ", update->ntimestep,
                                 "; use a larger or periodic box"));
}

// What to do about an atom that is out of the box, by its speed.
std::string FixMpm::flight(int i) const {
  const double* v = atom->v[i];
  const double cells = dt_last_ / cell_ * std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (cells < 0.5) return "use a larger box or a periodic one";
  return text_of("it moves ", cells, " cells a step, so the motion is unstable; check the motion of the grains, the contact model, 'kn' of fix "
                 "mpm/couple and the densities of grains and cement, and use a smaller time step");
}

// Of this rank, before LIGGGHTS drops it, which it does without a word.
void FixMpm::watch_for_grains_that_leave() {
  for (int i : grains_here_)
    for (int d = 0; d < 3 && grain_trouble_.empty(); ++d) {
      const double x = atom->x[i][d];
      const bool finite = std::isfinite(x);
      const bool below = domain->boundary[d][0] == kFixedBoundary && x < domain->boxlo[d];
      const bool above = domain->boundary[d][1] == kFixedBoundary && x >= domain->boxhi[d];
      if (finite && !below && !above) continue;
      const std::string who = text_of("fix mpm (id ", id, "): bonded grain ", atom->tag[i], " is lost at step ", update->ntimestep, ": ");
      grain_trouble_ = who + (finite ? text_of("it left the simulation box (", "xyz"[d], " = ", x, ", box ", domain->boxlo[d], " to ",
                                               domain->boxhi[d], "); ", flight(i))
                                     : text_of("its position is not finite; check the motion of the grains, the contact model, 'kn' of fix "
                                               "mpm/couple and the densities of grains and cement, and use a smaller time step"));
    }
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
