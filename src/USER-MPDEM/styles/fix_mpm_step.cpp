// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The time step of fix mpm. State after step n: u_n, v_n-1/2 and a_n at the nodes; F_n,
// strain and damage at the points. A step is one drift of the nodes, one pass over the
// points, one over the links, one sum over shared nodes.
#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "../mpm/gather.h"
#include "arguments.h"
#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "fix_gravity.h"
#include "fix_mpm.h"
#include "host_recipe.h"
#include "output.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::kLanes;
using mpdem::text_of;
using mpdem::vd;

// Orientation of bonded grains: LIGGGHTS' integrators for spheres keep omega only.
void FixMpm::post_integrate() {
  const double dt = update->dt;
  for (int i : grains_here_) {
    double* q = avec_->orientation(i);
    const double* w = atom->omega[i];
    const double rate = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    if (rate == 0.0) continue;
    const double c = std::cos(0.5 * rate * dt), s = std::sin(0.5 * rate * dt) / rate;
    const double p[4] = {c, s * w[0], s * w[1], s * w[2]};
    const double r[4] = {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
                         p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
                         p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
                         p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1]};
    const double n = 1.0 / std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
    for (int d = 0; d < 4; ++d) q[d] = n * r[d];
  }
}

void FixMpm::post_force(int) {
  const double dt = update->dt;
  totals_at_ = bonds_at_ = -1;  // who asked earlier in this step was told of the last one
  follow_grains();
  find_rates();
  timer_.start(mpdem::StepTimer::kCoupling);
  distribute_grains();
  // After a check; not in it, where the forces of the step are still to be shown, and which may
  // be the step of a restart file.
  if ((update->ntimestep - 1) % check_every_ == 0) {
    timer_.start(mpdem::StepTimer::kLayout);
    drop_added_mass();
    if (separate_bodies(true)) rebuild_parts();
  } else if ((update->ntimestep - 1) % kWatchEvery == 0 && coupled_ && !law_->inert() && some_path_is_cut()) {
    timer_.start(mpdem::StepTimer::kLayout);
    if (separate_bodies(false)) rebuild_parts();
  }
  jump_.clear();
  advance_.dissipated = advance_.released = 0.0;
  advance_.failed.clear();
  if (updated_) {
    step_updated(dt);
  } else {
    step_total(dt);
    sides_.clear_forces();
  }
  dt_last_ = dt;
  record_events();
  watch_paths();
  dissipated_ += advance_.dissipated;
  released_ += advance_.released;
  // Last, since it gives the points that failed other places in the store.
  if (!updated_ && reproject_distortion_ > 0.0 && update->ntimestep % check_every_ == 0 && distorted()) {
    react_to_jumps();
    take_new_reference();
    sides_.clear_forces();
  }
  add_forces();
  damped_ += damping_work(0.5 * dt_last_);
  if (updated_) {
    damped_ += half_kick_of_jump(transferred_);
    work_ -= 0.5 * dt_last_ * gravity_power(transferred_);  // nodes came here without that
  }
  react_on_grains();
  watch_late_forces(false);
  timer_.stop();
}

void FixMpm::step_total(double dt) {
  timer_.start(mpdem::StepTimer::kNodes);
  if (reproject_every_ > 0 && update->ntimestep % reproject_every_ == 0) reproject();
  if (coupled_) follow_jumps();
  grid_.drift(0.5 * (dt_last_ + dt), dt);
  timer_.start(mpdem::StepTimer::kPoints);
  grid_.clear_force();
  resting_.advance(avec_->points, grid_, *law_, dt, skip_, advance_);
  timer_.start(mpdem::StepTimer::kCoupling);
  if (coupled_) links_.let_go(avec_->points, advance_.failed, grid_, sides_, advance_.released);
}

double FixMpm::kinetic_energy(double kick) const {
  double twice[3] = {};  // of each component: their sums do not wait for each other
  for (int i = 0; i < grid_.size(); ++i) {
    if (!grid_.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) {
      const double v = grid_.velocity[3 * i + d] + kick * grid_.acceleration[3 * i + d];
      twice[d] += grid_.mass[i] * v * v;
    }
  }
  return 0.5 * (twice[0] + twice[1] + twice[2]);
}

// Everything but the internal force, which is on the nodes already.
void FixMpm::add_forces(bool in_step) {
  timer_.start(mpdem::StepTimer::kCoupling);
  if (coupled_) {
    if (in_step && !updated_) resting_links_.add_force(links_, resting_, skip_detached_, grid_, sides_);
    else links_.add_force(grid_, sides_, skip_detached_);
    // A change of velocity by transfer is an acceleration too, as far as the added mass is concerned.
    if (!jump_.empty()) links_.add_reaction(grid_, jump_, 1.0 / dt_last_, sides_);
  }
  timer_.start(mpdem::StepTimer::kHalo);
  grid_.sum_force();
  timer_.start(mpdem::StepTimer::kNodes);
  if (coupled_ && relax_ > 0.0) relaxation_.add_force(grid_, sides_);
  if (gravity_) {
    double g[3];
    gravity_->get_gravity(g);
    for (int i = 0; i < grid_.size(); ++i)
      for (int d = 0; d < 3; ++d) grid_.force[3 * i + d] += grid_.mass[i] / mass_scale_ * g[d];
  }
  if (any_added_mass_) {
    timer_.start(mpdem::StepTimer::kCoupling);
    if (any_free_grain_) find_grain_accelerations();
    links_.carry_added_mass(grid_, sides_);
    timer_.start(mpdem::StepTimer::kNodes);
  }
  grid_.update_acceleration();
}

// The energy that dampers took in the step: the velocity that their force meets is that of this time.
double FixMpm::damping_work(double later, int first_body) const {
  if (!coupled_) return 0.0;
  double power = links_.damper_power(grid_, sides_, later, first_body);
  if (relax_ > 0.0) power += relaxation_.power(grid_, sides_, later, first_body);
  return dt_last_ * power;
}

void FixMpm::react_on_grains() {
  if (!coupled_) return;
  timer_.start(mpdem::StepTimer::kCoupling);
  sides_.sum_forces();
  for (int i : grains_here_) {
    AtomVecMpdem::GrainState& g = *avec_->grain(i);
    std::fill(g.load, g.load + 6, 0.0);
  }
  for (const OwnedSide& o : owned_) {
    const mpdem::GrainSide& s = sides_.sides[o.at];
    AtomVecMpdem::GrainState& g = *avec_->grain(o.atom);
    for (int d = 0; d < 3; ++d) {
      atom->f[o.atom][d] += s.force[d];
      atom->torque[o.atom][d] += s.torque[d];
      g.load[d] += s.force[d];
      g.load[3 + d] += s.torque[d];
    }
  }
  react_to_jumps();
}

void FixMpm::distribute_grains() {
  if (!coupled_) return;
  std::vector<mpdem::GrainSides::Motion> motion(owned_.size());
  for (std::size_t k = 0; k < owned_.size(); ++k) {
    const int i = owned_[k].atom;
    domain->unmap(atom->x[i], atom->image[i], motion[k].x);
    const AtomVecMpdem::GrainState& g = *avec_->grain(i);
    std::copy(g.v, g.v + 3, motion[k].v);
    std::copy(g.v + 3, g.v + 6, motion[k].omega);
    std::copy(g.q, g.q + 4, motion[k].q);
    std::copy(g.a, g.a + 3, motion[k].a);
    std::copy(g.jump, g.jump + 6, motion[k].jump);
    motion[k].mass_ratio = owned_[k].mass_ratio;
  }
  sides_.distribute(avec_->bodies, motion);
}

// Work of grains and gravity on the cement of bodies from first_body on, in a step with the forces of
// this time: with the velocities of this time, and with those of half a step before. That of jumps and transfers has been counted.
FixMpm::StepWork FixMpm::work_of_step(int first_body) const {
  const double half = 0.5 * dt_last_;
  StepWork power{0.0, 0.0};
  for (const OwnedSide& o : owned_) {
    if (!coupled_ || o.body < first_body) continue;
    const mpdem::GrainSide& s = sides_.sides[o.at];
    const AtomVecMpdem::GrainState& g = *avec_->grain(o.atom);
    for (int d = 0; d < 6; ++d) {
      const double f = (d < 3 ? s.force[d] : s.torque[d - 3]) - s.jump_force[d] - s.transfer_force[d];
      power.now -= f * g.ended[d];
      power.before -= f * g.v[d];
    }
  }
  if (gravity_) {
    double g[3];
    gravity_->get_gravity(g);
    for (int i = 0; i < grid_.size(); ++i) {
      if (!grid_.halo.counts_here()[i] || mpdem::body_of(grid_.keys[i][0]) < first_body) continue;
      for (int d = 0; d < 3; ++d) {
        const double weight = grid_.mass[i] / mass_scale_ * g[d], v = grid_.velocity[3 * i + d];
        power.now += weight * (v + half * grid_.acceleration[3 * i + d]);
        power.before += weight * v;
      }
    }
  }
  return {dt_last_ * power.now, dt_last_ * power.before};
}

void FixMpm::end_of_step() {
  timer_.start(mpdem::StepTimer::kOutput);
  watch_late_forces(true);
  const bool output_due = update->ntimestep == output->next;
  report_grain_trouble(output_due);
  keep_velocities();
  if (output_due || update->ntimestep % check_every_ == 0 || update->ntimestep == update->firststep + 1) report_jump();
  totals_at_ = bonds_at_ = -1;  // the same, before the work of this step was counted
  // Each half step has the work of its velocity on the force at its end, so that central differences
  // keep the energy; the second half of this step is work ahead.
  const StepWork work = work_of_step();
  work_ += work.now;
  work_ahead_ = work.now - 0.5 * work.before;

  if (update->ntimestep % check_every_ == 0) {
    write_events();
    check_state();
  } else if (output_due) {
    check_state();
  }
  if (output_due) fill_atoms();
  if (!all_in_motion_) {
    for (mpdem::Body& b : avec_->bodies) b.in_motion = 1.0;
    remember_coupling();
  }
  all_in_motion_ = true;
  timer_.stop();
}

void FixMpm::post_run() {
  report_jump();
  fill_atoms();
  write_events();
  report_modes();
  report_times();
}

void FixMpm::check_state() {
  std::string trouble;
  if (!grid_.finite())
    trouble = text_of("fix mpm (id ", id, "): a node of the grid is not finite at step ", update->ntimestep,
                      "; check the motion of the grains, the time step and the contact model");
  if (coupled_ && sides_.orphan() >= 0)
    trouble = text_of("fix mpm (id ", id, "): grain ", sides_.sides[sides_.orphan()].tag,
                      " has cement but was deleted or lost at step ", update->ntimestep,
                      "; keep bonded grains, or use a larger box");
  if (trouble.empty()) trouble = grain_that_is_not_finite();
  if (trouble.empty()) trouble = grain_outside_of_group(lmp, text_of("fix mpm (id ", id, "): "), *avec_);
  mpdem::stop_if_any(lmp, trouble);
}

void FixMpm::setup(int) {
  timer_.clear();
  timed_from_ = update->ntimestep;
  advance_.ticks = mpdem::PassTicks();
  totals_at_ = bonds_at_ = -1;
  jump_.clear();
  all_in_motion_ = false;  // bodies may be new
  report_parameters();
  write_events();
  find_limit_of_jumps();
  distribute_grains();
  check_state();
  if (!updated_) take_up_added_mass(false);
  start_added_mass();
  report_added_mass();
  if (updated_) {
    mpdem::UpdatedPass::project(avec_->points, grid_, *law_, inertia_, transfer_);
    grid_.halo.sum(grid_.mass.data(), 1);
  } else {
    grid_.clear_force();
    mpdem::add_internal_force(avec_->points, grid_, *law_);
  }
  sides_.clear_forces();
  sides_.clear_sudden_forces();
  sudden_forces_are_due_ = false;
  add_forces(false);
  react_on_grains();
  start_bodies();
  fill_atoms();
}

// Velocities of bodies that were not in motion yet go back half a step. What they have of energy counts
// from here, and the work of the first half step, which is ahead.
void FixMpm::start_bodies() {
  const int bodies = static_cast<int>(avec_->bodies.size());
  if (bodies_started_ == bodies) return;
  damped_ += 0.5 * damping_work(0.0, bodies_started_);
  go_back_half_a_step();
  double mine = 0.0, energy;
  for (int i = 0; i < grid_.size(); ++i) {
    if (mpdem::body_of(grid_.keys[i][0]) < bodies_started_) continue;
    for (int d = 0; d < 3; ++d) {
      double& v = grid_.velocity[3 * i + d];
      const double kick = 0.5 * dt_last_ * grid_.acceleration[3 * i + d];
      if (grid_.halo.counts_here()[i]) mine += 0.5 * grid_.mass[i] * (v - kick) * (v + kick);
      v -= kick;
    }
  }
  if (coupled_)
    mine += links_.spring_energy(grid_, sides_, bodies_started_) +
            links_.inertial_energy(grid_, sides_, 0.0, dt_last_, bodies_started_);
  if (updated_) mpdem::UpdatedPass::start(avec_->points, grid_, bodies_started_);
  const StepWork work = work_of_step(bodies_started_);
  work_ += work.now - 0.5 * work.before;
  work_ahead_ += work.now - 0.5 * work.before;
  MPI_Allreduce(&mine, &energy, 1, MPI_DOUBLE, MPI_SUM, world);
  start_energy_ += energy;
  bodies_started_ = bodies;
}

void FixMpm::fill_atoms() {
  sync_slots();
  const mpdem::PointStore& points = avec_->points;
  // v_n = v_n-1/2 + dt a_n / 2
  std::vector<double> velocity(grid_.velocity);
  for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] += 0.5 * dt_last_ * grid_.acceleration[i];
  struct Motion {
    vd u[3], v[3];
  };
  // Points made since the grid was laid out are not on it yet and stay where they are.
  std::vector<Motion> motion(laid_out_blocks_);
  mpdem::with_basis(basis_, [&](auto type) {
    for (std::size_t b = 0; b < laid_out_blocks_; ++b) {
      const mpdem::Weights<decltype(type)> w(points.blocks[b].X, points.meta[b].base, 1.0 / cell_);
      mpdem::gather_value(grid_.displacement.data(), points.meta[b].column, w, motion[b].u);
      mpdem::gather_value(velocity.data(), points.meta[b].column, w, motion[b].v);
    }
  });
  std::string trouble;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!avec_->is_point(i)) continue;
    const int b = avec_->slot[i] / kLanes, l = avec_->slot[i] % kLanes;
    if (b >= static_cast<int>(laid_out_blocks_)) continue;
    const mpdem::Body& body = avec_->bodies[points.meta[b].body];
    double* x = atom->x[i];
    for (int d = 0; d < 3; ++d) {
      x[d] = body.origin[d] + points.blocks[b].X[d][l] + motion[b].u[d][l];
      atom->v[i][d] = motion[b].v[d][l];
      atom->f[i][d] = 0.0;  // LIGGGHTS does not clear it for points, and it has no meaning
    }
    // Not `remap` of the old flags: x is unwrapped here.
    atom->image[i] = ((tagint)IMGMAX << IMG2BITS) | ((tagint)IMGMAX << IMGBITS) | IMGMAX;
    domain->remap(x, atom->image[i]);
    for (int d = 0; d < 3; ++d)
      if (!(x[d] >= domain->boxlo[d] && x[d] <= domain->boxhi[d]) && trouble.empty())
        trouble = text_of("fix mpm (id ", id, "): material point ", atom->tag[i], " left the simulation box at step ",
                          update->ntimestep, " (", "xyz"[d], " = ", x[d], ", box ", domain->boxlo[d], " to ",
                          domain->boxhi[d], "); ", flight(i));
  }
  mpdem::stop_if_any(lmp, trouble);
}

}  // namespace LAMMPS_NS
