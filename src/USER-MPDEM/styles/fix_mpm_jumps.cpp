// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Velocities of bonded grains as the added mass of links sees them: W- and W+ of the steps that end and begin at time n,
// half a step before and after it.
//
// Added mass c goes along with its grain, N a = f + c A with N = m + c and A = (W+ - W-)/dt. Of grains that follow forces A
// is solved for at time n. Of prescribed motion W+ is known when the grain has moved: until then a smooth A' is
// expected, and dt (A - A') is the jump J, which nodes follow by c/N J before they drift. A grain that starts with
// velocity V so takes the nodes along in its first step; would it not, their c V^2/2 against the grain would be
// energy that nothing paid for. The reaction p = c (c/N - 1) J is momentum of the grains. Central differences keep
//
//   E - W = const,  W = -sum (F_n + F_n+1)/2 . (x_n+1 - x_n) - sum p . (W- + W+)/2,
//
// with E as in FixMpm::totals(), F the force on a grain without p: exact for jumps as for smooth motion. A velocity that a
// command gives to a grain between runs is such a jump, too; then p is taken from the grain at once. Bodies start
// with added mass that has the velocity of its grain.
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "arguments.h"
#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix_gravity.h"
#include "fix_mpm.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::text_of;

namespace {
double length(const double* d) { return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]); }

// That of two estimates which is nearer to zero; zero if they disagree in sign.
double lesser(double a, double b) {
  if (a * b <= 0.0) return 0.0;
  return std::fabs(a) < std::fabs(b) ? a : b;
}
}  // namespace

bool FixMpm::follows_forces(std::size_t n, int d) const { return d < 3 ? !prescribed_[n].translation[d] : !prescribed_[n].rotation; }

// The velocity of LIGGGHTS, v and then omega; d of 6.
double& FixMpm::velocity_of(int i, int d) const { return d < 3 ? atom->v[i][d] : atom->omega[i][d - 3]; }

// Once a step, after follow_grains() and before the grains are distributed. The acceleration that is expected of prescribed
// motion is the lesser of that of the last step and of what its velocity at the step tells: after a jump they
// differ, and none is expected.
void FixMpm::find_rates() {
  const double dt = update->dt, since = 0.5 * (dt_last_ + dt);
  for (std::size_t n = 0; n < grains_here_.size(); ++n) {
    const int i = grains_here_[n];
    AtomVecMpdem::GrainState& g = *avec_->grain(i);
    for (int d = 0; d < 6; ++d) {
      const bool free = follows_forces(n, d);
      g.before[d] = g.v[d];
      g.v[d] = free || d >= 3 ? velocity_of(i, d) : moved_[3 * n + d] / dt;
      const double change = g.v[d] - g.before[d];
      g.jump[d] = free ? 0.0 : change - (d < 3 ? since * g.a[d] : 0.0);
      // in the second half of the last step, beyond what was expected
      if (!free) work_ -= 0.5 * dt * g.load[d] * (change - 2.0 * (g.ended[d] - g.before[d]));
      if (d < 3) g.a[d] = free ? 0.0 : lesser(change / since, 2.0 * (atom->v[i][d] - g.v[d]) / dt);
    }
    watch_jump(n);
    g.seen = 1.0;
  }
}

// Of the step's end: commands that change velocities show against them.
void FixMpm::keep_velocities() {
  for (std::size_t n = 0; n < grains_here_.size(); ++n) {
    const int i = grains_here_[n];
    AtomVecMpdem::GrainState& g = *avec_->grain(i);
    for (int d = 0; d < 6; ++d) g.ended[d] = follows_forces(n, d) ? velocity_of(i, d) : g.v[d] + (d < 3 ? 0.5 * dt_last_ * g.a[d] : 0.0);
  }
}

// Before nodes drift, with the added mass that they have.
void FixMpm::follow_jumps() {
  sides_.clear_sudden_forces();
  if (!any_added_mass_) return;
  links_.follow_jumps(grid_, sides_, 2.0 / (dt_last_ + update->dt), 1.0 / update->dt);
  sudden_forces_are_due_ = true;
}

// Collective. The reaction of added mass that followed jumps, or whose nodes changed their velocity by transfer, and its work.
void FixMpm::react_to_jumps() {
  if (!sudden_forces_are_due_) return;
  sudden_forces_are_due_ = false;
  sides_.sum_sudden_forces();
  for (mpdem::GrainSide& s : sides_.sides)
    for (int d = 0; d < 3; ++d) {
      s.force[d] += s.jump_force[d] + s.transfer_force[d];
      s.torque[d] += s.jump_force[3 + d] + s.transfer_force[3 + d];
    }
  for (const OwnedSide& o : owned_) {
    const mpdem::GrainSide& s = sides_.sides[o.at];
    const AtomVecMpdem::GrainState& g = *avec_->grain(o.atom);
    double power = 0.0;
    for (int d = 0; d < 6; ++d) {
      (d < 3 ? atom->f[o.atom][d] : atom->torque[o.atom][d - 3]) += s.jump_force[d] + s.transfer_force[d];
      power += s.jump_force[d] * 0.5 * (g.before[d] + g.v[d]) + s.transfer_force[d] * g.v[d];
    }
    work_ -= update->dt * power;
  }
}

// Collective. Jumps of the owned sides, for all their added mass or for that of new bodies, exchange momentum between nodes
// and grains at once: the change of velocity of nodes is left in their acceleration, that of grains is theirs.
void FixMpm::exchange_momentum(const std::vector<std::array<double, 6>>& jump, int first_body, bool at_start) {
  sides_.set_jumps(jump);
  sides_.set_accelerations(std::vector<std::array<double, 6>>(owned_.size(), std::array<double, 6>{}));
  grid_.clear_force();
  sides_.clear_forces();
  sides_.clear_sudden_forces();
  links_.add_jumps(grid_, sides_, first_body, at_start);
  if (any_free_grain_) {
    for (mpdem::GrainAccelerations::Grain& g : bonded_) g.load.setZero();
    accelerations_.find(world, links_, grid_, bonded_, sides_, fresh_added_mass_);
    fresh_added_mass_ = false;
  }
  links_.carry_added_mass(grid_, sides_);
  grid_.update_acceleration();
  sides_.sum_forces();
  for (std::size_t n = 0; n < grains_here_.size(); ++n) {
    const mpdem::GrainSide& s = sides_.sides[owned_[bonded_[n].sides.front()].at];
    for (int d = 0; d < 6; ++d)
      if (follows_forces(n, d)) velocity_of(grains_here_[n], d) += d < 3 ? s.a[d] : s.alpha[d - 3];
  }
  for (const OwnedSide& o : owned_) {
    if (o.body >= bodies_started_) continue;
    const mpdem::GrainSide& s = sides_.sides[o.at];
    const AtomVecMpdem::GrainState& g = *avec_->grain(o.atom);
    for (int d = 0; d < 6; ++d)
      work_ -= (d < 3 ? s.force[d] : s.torque[d - 3]) * 0.5 * (g.ended[d] + velocity_of(o.atom, d));
  }
}

// Commands may have changed velocities since the end of the last step.
void FixMpm::pre_initial_integrate() {
  if (!any_added_mass_ || update->ntimestep != update->firststep + 1) return;
  int some = 0, any;
  std::vector<std::array<double, 6>> jump(owned_.size(), std::array<double, 6>{});
  for (std::size_t n = 0; n < grains_here_.size(); ++n) {
    const AtomVecMpdem::GrainState& g = *avec_->grain(grains_here_[n]);
    for (int d = 0; d < 6; ++d) {
      const double change = follows_forces(n, d) ? velocity_of(grains_here_[n], d) - g.ended[d] : 0.0;
      for (int k : bonded_[n].sides) jump[k][d] = change;
      some = some || change != 0.0;
    }
  }
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, world);
  if (!any) return;
  std::vector<double> acceleration(grid_.acceleration);
  exchange_momentum(jump, 0, false);
  const double rate = 2.0 / (dt_last_ + update->dt);
  for (std::size_t k = 0; k < acceleration.size(); ++k) acceleration[k] += rate * grid_.acceleration[k];
  grid_.acceleration.swap(acceleration);
  for (std::size_t n = 0; n < grains_here_.size(); ++n) {
    const AtomVecMpdem::GrainState& g = *avec_->grain(grains_here_[n]);
    for (int d = 0; d < 6; ++d)
      if (follows_forces(n, d)) work_ -= 0.5 * dt_last_ * g.load[d] * (velocity_of(grains_here_[n], d) - g.ended[d]);
  }
}

// A grain that starts feels gravity in the first step already, also by a fix that comes later in the step than this one.
void FixMpm::expect_gravity(int i) {
  bool later = false;
  for (int k = 0; k < modify->nfix; ++k) {
    FixGravity* gravity = dynamic_cast<FixGravity*>(modify->fix[k]);
    later = later || modify->fix[k] == this;
    if (!gravity || !later || !(atom->mask[i] & gravity->groupbit)) continue;
    double g[3];
    gravity->get_gravity(g);
    for (int d = 0; d < 3; ++d) avec_->grain(i)->late[d] += atom->rmass[i] * g[d];
  }
}

// In setup, once the added mass is that of the run: that of new bodies gets the velocity of its grains, which are
// at a full step where they have not been seen before.
void FixMpm::start_added_mass() {
  if (!coupled_ || bodies_started_ == static_cast<int>(avec_->bodies.size())) return;
  for (int i : grains_here_) {
    AtomVecMpdem::GrainState& g = *avec_->grain(i);
    for (int d = 0; d < 6 && g.seen == 0.0; ++d) g.v[d] = g.before[d] = g.ended[d] = velocity_of(i, d);
    if (g.seen == 0.0) expect_gravity(i);
  }
  if (any_added_mass_) {
    std::vector<std::array<double, 6>> jump(owned_.size());
    for (std::size_t k = 0; k < owned_.size(); ++k) {
      const AtomVecMpdem::GrainState& g = *avec_->grain(owned_[k].atom);
      std::copy(g.ended, g.ended + 6, jump[k].begin());
    }
    std::vector<std::array<double, 6>> before(grains_here_.size());
    for (std::size_t n = 0; n < before.size(); ++n)
      for (int d = 0; d < 6; ++d) before[n][d] = velocity_of(grains_here_[n], d);
    exchange_momentum(jump, bodies_started_, true);
    for (std::size_t k = 0; k < grid_.velocity.size(); ++k) grid_.velocity[k] += grid_.acceleration[k];
    for (std::size_t n = 0; n < before.size(); ++n) {
      AtomVecMpdem::GrainState& g = *avec_->grain(grains_here_[n]);
      for (int d = 0; d < 6; ++d) {
        const double change = velocity_of(grains_here_[n], d) - before[n][d];
        g.v[d] += change;
        g.ended[d] += change;
      }
    }
  }
  distribute_grains();
}

// Grains that were not seen before go back to the middle of the step before, like the nodes of new bodies.
void FixMpm::go_back_half_a_step() {
  if (!coupled_) return;
  std::vector<std::array<double, 6>> rates(owned_.size());
  for (std::size_t k = 0; k < owned_.size(); ++k) {
    const mpdem::GrainSide& s = sides_.sides[owned_[k].at];
    std::copy(s.a, s.a + 3, rates[k].begin());
    std::copy(s.alpha, s.alpha + 3, rates[k].begin() + 3);
  }
  for (std::size_t n = 0; n < grains_here_.size(); ++n) {
    AtomVecMpdem::GrainState& g = *avec_->grain(grains_here_[n]);
    if (g.seen != 0.0) continue;
    g.seen = 1.0;
    for (int d = 0; d < 6; ++d) g.v[d] -= 0.5 * dt_last_ * rates[bonded_[n].sides.front()][d];
  }
  distribute_grains();
  sides_.set_accelerations(rates);
}

// A jump that matters: it is no small part of the velocity, and the stress of the wave that it sends through the cement
// is 1 % of the strength, or where there is no damage its strain is 1e-6.
void FixMpm::find_limit_of_jumps() {
  const double speed = law_->elasticity().fastest_wave(inertia_);
  jump_limit_ = 1e-6 * speed;
  if (!law_->inert())
    jump_limit_ = 0.01 / (inertia_ * speed) * std::min(law_->implied_strength(constants_.Ez).tensile_strength,
                                                     law_->implied_strength(constants_.Ep).tensile_strength);
  jump_told_ = false;
  worst_jump_.clear();
}

void FixMpm::watch_jump(std::size_t n) {
  if (jump_told_ || !worst_jump_.empty() || !coupled_) return;
  const int i = grains_here_[n];
  const AtomVecMpdem::GrainState& g = *avec_->grain(i);
  double change[6] = {};
  for (int d = 0; d < 6; ++d)
    if (!follows_forces(n, d)) change[d] = g.v[d] - g.before[d];
  const double r = atom->radius[i];
  const double jump = length(change) + r * length(change + 3);
  const double fastest = std::max(length(g.v) + r * length(g.v + 3), length(g.before) + r * length(g.before + 3));
  if (!(jump > jump_limit_ && jump > 0.5 * fastest)) return;
  const double speed = law_->elasticity().fastest_wave(inertia_);
  worst_jump_ = text_of("the prescribed velocity of bonded grain ", atom->tag[i], " jumps by ", jump, " in step ", update->ntimestep,
                        ", which sends a wave of stress ", inertia_ * speed * jump, " through its cement; let it begin, change and end "
                        "smoothly, over many steps, as by 'fix move ... variable' with formulas");
}

// Collective. Once a run, of the first jump of the lowest rank that saw one.
void FixMpm::report_jump() {
  if (jump_told_) return;
  int mine = worst_jump_.empty() ? comm->nprocs : comm->me, from;
  MPI_Allreduce(&mine, &from, 1, MPI_INT, MPI_MIN, world);
  if (from == comm->nprocs) return;
  jump_told_ = true;
  int size = static_cast<int>(worst_jump_.size());
  MPI_Bcast(&size, 1, MPI_INT, from, world);
  worst_jump_.resize(static_cast<std::size_t>(size));
  MPI_Bcast(worst_jump_.data(), size, MPI_CHAR, from, world);
  if (comm->me == 0) error->warning("fix mpm", 0, worst_jump_.c_str());
}

}  // namespace LAMMPS_NS
