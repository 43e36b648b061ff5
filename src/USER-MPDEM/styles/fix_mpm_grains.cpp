// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Grains as their cement sees them: their accelerations, and whether they are where it knows them to be, and as
// large. A grain that a command displaces, or a formula that starts anew, would load its bond with a strain that
// nothing in the scene has caused.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <unordered_map>

#include "arguments.h"
#include "atom.h"
#include "domain.h"
#include "fix_mpm.h"
#include "modify.h"
#include "output.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::text_of;

namespace {
double length(const double* d) { return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]); }
}  // namespace

// Bonds across a boundary are as long as the box was when they were made, and the image of a grain that a
// deformed box moves on has a velocity which LIGGGHTS does not give it.
void FixMpm::check_box() const {
  for (int k = 0; k < modify->nfix; ++k) {
    const Fix* fix = modify->fix[k];
    if (fix->box_change_size || fix->box_change_shape)
      mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): fix '", fix->id, "' (", fix->style, ") changes the simulation box, which cement "
                                   "does not follow; deform the scene by walls or grains that move, and the box before create_cement"));
  }
  const std::string trouble = changed_box();
  if (!trouble.empty()) mpdem::stop_all(lmp, trouble);
}

// The same on every rank; empty if the box is that of the cement.
std::string FixMpm::changed_box() const {
  for (const mpdem::Body& b : avec_->bodies)
    for (int d = 0; d < 3; ++d) {
      const double now = domain->prd[d];
      if (b.box[d] == 0.0 || (domain->periodicity[d] ? std::fabs(now - b.box[d]) <= 1e-12 * now : b.shift[0][d] == 0.0 && b.shift[1][d] == 0.0))
        continue;
      return text_of("fix mpm (id ", id, "): the box is ", domain->periodicity[d] ? "periodic in " : "not periodic in ", "xyz"[d], " with length ",
                     now, " at step ", update->ntimestep, ", but was periodic with length ", b.box[d], " when the cement of grains ", b.grain[0],
                     " and ", b.grain[1], " was made, which does not follow; use 'change_box' before create_cement");
    }
  return "";
}

std::string FixMpm::changed_radius(int i, double made_for) const {
  if (std::fabs(atom->radius[i] - made_for) <= 1e-12 * made_for) return "";
  return text_of("fix mpm (id ", id, "): bonded grain ", atom->tag[i], " has radius ", atom->radius[i], " at step ", update->ntimestep,
                 ", but its cement was made for ", made_for, " and does not follow; set diameters before create_cement, "
                 "and leave bonded grains out of 'set ... diameter' and 'fix adapt'");
}

// After the sides are built.
void FixMpm::find_bonded_grains() {
  bonded_.assign(grains_here_.size(), {});
  int some = 0, any;
  for (std::size_t n = 0; n < bonded_.size(); ++n) {
    mpdem::GrainAccelerations::Grain& g = bonded_[n];
    const int i = grains_here_[n];
    g.mass = atom->rmass[i];
    g.inertia = 0.4 * g.mass * atom->radius[i] * atom->radius[i];
    for (int d = 0; d < 3; ++d) {
      g.free[d] = !prescribed_[n].translation[d];
      g.free[3 + d] = !prescribed_[n].rotation;
    }
    some = some || !prescribed_[n].all();
  }
  for (std::size_t k = 0; k < owned_.size(); ++k) {
    const std::size_t n = std::lower_bound(grains_here_.begin(), grains_here_.end(), owned_[k].atom) - grains_here_.begin();
    bonded_[n].sides.push_back(static_cast<int>(k));
  }
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, world);
  any_free_grain_ = any != 0;
}

// With all that acts on grains. What fixes after this one will add is not known yet: it is taken to be what they added in
// the last step.
void FixMpm::find_grain_accelerations() {
  for (std::size_t n = 0; n < bonded_.size(); ++n) {
    const int i = grains_here_[n];
    const AtomVecMpdem::GrainState& g = *avec_->grain(i);
    for (int d = 0; d < 3; ++d) {
      bonded_[n].load[d] = atom->f[i][d] + g.late[d];
      bonded_[n].load[3 + d] = atom->torque[i][d] + g.late[3 + d];
    }
  }
  accelerations_.find(world, links_, grid_, bonded_, sides_, fresh_added_mass_);
  fresh_added_mass_ = false;
}

// Before the fixes that come later in the step, and after them.
void FixMpm::watch_late_forces(bool after) {
  for (int i : grains_here_) {
    double* late = avec_->grain(i)->late;
    for (int d = 0; d < 3; ++d) {
      late[d] = after ? late[d] + atom->f[i][d] : -atom->f[i][d];
      late[3 + d] = after ? late[3 + d] + atom->torque[i][d] : -atom->torque[i][d];
    }
  }
}

// At the start of a run, against the end of the last one, the restart file or create_cement.
void FixMpm::check_grains_stayed() {
  std::unordered_map<int, double> radius;
  for (const mpdem::Body& b : avec_->bodies)
    for (int s = 0; s < 2; ++s) radius.emplace(b.grain[s], b.radius[s]);
  std::string trouble;
  for (int i = 0; i < atom->nlocal && trouble.empty(); ++i) {
    const AtomVecMpdem::GrainState* g = avec_->grain(i);
    const auto bonded = radius.find(atom->tag[i]);
    if (!g || bonded == radius.end()) continue;
    trouble = changed_radius(i, bonded->second);
    if (!trouble.empty() || g->placed == 0.0) continue;
    double x[3], moved[3];
    domain->unmap(atom->x[i], atom->image[i], x);
    bool far = false;
    for (int d = 0; d < 3; ++d) {
      moved[d] = x[d] - g->x[d];
      // what wrapping into the box rounds
      const double rounding = 16 * std::numeric_limits<double>::epsilon() * (std::fabs(x[d]) + domain->prd[d]);
      far = far || std::fabs(moved[d]) > 1e-9 * cell_ + rounding;
    }
    if (far)
      trouble = text_of("fix mpm (id ", id, "): a command moved bonded grain ", atom->tag[i], " by ", length(moved), g->seen != 0.0
                        ? " since the last run" : " since its cement was made", ", which its cement does not follow; use 'displace_atoms', "
                        "'set' and 'change_box' before create_cement, and move bonded grains by a fix or a velocity");
  }
  mpdem::stop_if_any(lmp, trouble);
}

// In each step, before the velocities of the last one are forgotten: a grain goes where its velocity takes
// it. Any smooth motion stays well within twice the larger of the two velocities.
void FixMpm::follow_grains() {
  moved_.resize(3 * grains_here_.size());
  for (std::size_t n = 0; n < grains_here_.size(); ++n) {
    const int i = grains_here_[n];
    AtomVecMpdem::GrainState& g = *avec_->grain(i);
    double x[3], *moved = &moved_[3 * n], jump[3];
    domain->unmap(atom->x[i], atom->image[i], x);
    for (int d = 0; d < 3; ++d) {
      moved[d] = x[d] - g.x[d];
      jump[d] = moved[d] - update->dt * atom->v[i][d];
      g.x[d] = x[d];
    }
    const double expected = update->dt * std::max(length(atom->v[i]), length(g.v));
    const bool known = g.placed != 0.0;
    g.placed = 1.0;
    if (known && grain_trouble_.empty() && length(jump) > 2.0 * expected + 1e-5 * cell_)
      grain_trouble_ = text_of("fix mpm (id ", id, "): bonded grain ", atom->tag[i], " jumped by ", length(moved), " in step ",
                               update->ntimestep, ", its velocity takes it ", expected, " at most; formulas of 'fix move' in step*dt jump "
                               "when 'timestep' or 'reset_timestep' changes, and need the velocity that goes with the position: define "
                               "that fix anew, with formulas that start from 0; 'displace_atoms', 'set', 'change_box' and 'fix deform' "
                               "must not move bonded grains");
  }
  if (grain_trouble_.empty() && update->ntimestep == update->firststep + 1) grain_trouble_ = changed_box();
  for (const OwnedSide& o : owned_)
    if (grain_trouble_.empty()) grain_trouble_ = changed_radius(o.atom, avec_->bodies[o.body].radius[o.side]);
}

// Collective, so not in every step; in the first one of a run, where commands and formulas show.
void FixMpm::report_grain_trouble(bool output_due) {
  if (output_due || update->ntimestep % kWatchEvery == 0 || update->ntimestep == update->firststep + 1)
    mpdem::stop_if_any(lmp, grain_trouble_);
}

}  // namespace LAMMPS_NS
