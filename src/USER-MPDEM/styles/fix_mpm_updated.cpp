// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Transfers of velocity between nodes and points: every step with `updated` kinematics, every N
// steps or when the cement has distorted with `total`.
#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "../mpm/reproject.h"
#include "arguments.h"
#include "atom.h"
#include "fix_gravity.h"
#include "fix_mpm.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::StepTimer;
using mpdem::kLanes;
using mpdem::text_of;
using mpdem::vd;

// The kinetic energy that a projection leaves out counts as damped: that at the step, where
// velocity is half a kick ahead of what is stored.
void FixMpm::reproject() {
  const auto energy = [this] {
    return kinetic_energy(0.5 * dt_last_) + (coupled_ ? links_.inertial_energy_ahead(grid_, sides_, 0.5 * (dt_last_ + update->dt), bodies_started_) : 0.0);
  };
  const double before = energy();
  mpdem::reproject_velocity(avec_->points, grid_, inertia_, transfer_, 0.5 * (dt_last_ + update->dt), jump_);
  damped_ += before - energy();
  if (coupled_)  // the energy of added mass, too, is that at the step; the reaction goes to the grains
    damped_ += 0.5 * dt_last_ * links_.inertial_power(grid_, sides_, jump_) - links_.work_of_reaction(grid_, sides_, jump_);
  work_ += 0.5 * dt_last_ * gravity_power(jump_);
}

// What a change of velocity takes of the energy that central differences keep, beyond that of the stored velocity: it meets
// the acceleration, too.
double FixMpm::half_kick_of_jump(const std::vector<double>& jump) const {
  if (jump.empty()) return 0.0;
  double power[3] = {};  // of each component: their sums do not wait for each other
  for (int i = 0; i < grid_.size(); ++i) {
    if (!grid_.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) power[d] += grid_.mass[i] * grid_.acceleration[3 * i + d] * jump[3 * i + d];
  }
  const double of_links = coupled_ ? links_.inertial_power(grid_, sides_, jump) : 0.0;
  return -0.5 * dt_last_ * (power[0] + power[1] + power[2] + of_links);
}

// Of the weight of this rank's nodes on a velocity.
double FixMpm::gravity_power(const std::vector<double>& velocity) const {
  if (!gravity_ || velocity.empty()) return 0.0;
  double g[3], power = 0.0;
  gravity_->get_gravity(g);
  for (int i = 0; i < grid_.size(); ++i) {
    if (!grid_.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) power += grid_.mass[i] / mass_scale_ * g[d] * velocity[3 * i + d];
  }
  return power;
}

void FixMpm::step_updated(double dt) {
  mpdem::PointStore& points = avec_->points;
  const double dt_v = 0.5 * (dt_last_ + dt);
  timer_.start(StepTimer::kLayout);
  int stale = updated_pass_.layout_is_stale(), any;
  MPI_Allreduce(&stale, &any, 1, MPI_INT, MPI_MAX, world);
  if (any) {
    // Blocks fill badly when points went through many cells.
    int sparse = points.blocks.size() > blocks_when_arranged_ + blocks_when_arranged_ / 3;
    MPI_Allreduce(MPI_IN_PLACE, &sparse, 1, MPI_INT, MPI_MAX, world);
    const auto energy = [&] { return links_.inertial_energy_ahead(grid_, sides_, dt_v, bodies_started_); };
    const double before = energy();
    if (sparse) {
      sync_slots();
      rebuild();
    } else {
      lay_out_grid();
    }
    damped_ += before - energy();
  }

  timer_.start(StepTimer::kNodes);
  if (coupled_) follow_jumps();
  grid_.drift(dt_v, 0.0);
  const double before = kinetic_energy(0.0), inertial = coupled_ ? links_.inertial_energy(grid_, sides_) : 0.0;
  jump_.assign(grid_.velocity.size(), 0.0);
  if (transfer_.method == mpdem::Transfer::xpic && transfer_.order > 1) {
    const std::vector<double> kicked(grid_.velocity);
    for (std::size_t i = 0; i < kicked.size(); ++i) grid_.velocity[i] -= dt_v * grid_.acceleration[i];
    mpdem::filter_velocity(points, grid_, inertia_, transfer_.order);
    for (std::size_t i = 0; i < kicked.size(); ++i) {
      grid_.velocity[i] += dt_v * grid_.acceleration[i];
      jump_[i] = grid_.velocity[i] - kicked[i];
    }
    // before the nodes move, unlike the transfer
    damped_ -= half_kick_of_jump(jump_);
    work_ += 0.5 * dt_last_ * gravity_power(jump_);
    filtered_ = jump_;
  }
  timer_.start(StepTimer::kCoupling);
  if (coupled_) links_.find_moves(grid_, dt);

  timer_.start(StepTimer::kPoints);
  updated_pass_.advance(points, grid_, *law_, inertia_, dt, dt_v, transfer_, skip_, advance_);
  mpdem::stop_if_any(lmp, !updated_pass_.lost() ? std::string()
                              : text_of("fix mpm (id ", id, "): material point ", updated_pass_.lost(),
                                        " moved more than two cells in step ", update->ntimestep,
                                        " or is not finite; check the motion of the grains and the time step"));
  timer_.start(StepTimer::kHalo);
  grid_.halo.sum(grid_.mass.data(), 1);
  grid_.halo.sum(grid_.momentum.data(), 3);

  laid_out_blocks_ = points.blocks.size();

  timer_.start(StepTimer::kNodes);
  // The velocity that points take from nodes is theirs and the added mass' together; what flip
  // keeps in the points is theirs alone. A node with neither keeps what it has.
  const double shared = transfer_.method == mpdem::Transfer::flip ? 1.0 - transfer_.flip_share : 1.0;
  for (int i = 0; i < grid_.size(); ++i) {
    const double c = shared * grid_.added_mass[i], m = grid_.mass[i] + c;
    for (int d = 0; d < 3; ++d) {
      double& v = grid_.velocity[3 * i + d];
      const double w = m > 0.0 ? (grid_.momentum[3 * i + d] + c * v) / m : v;
      jump_[3 * i + d] += w - v;
      v = w;
    }
  }
  damped_ += before - kinetic_energy(0.0);
  sides_.clear_forces();
  if (coupled_) {
    timer_.start(StepTimer::kCoupling);
    links_.add_reaction(grid_, jump_, shared * shared / dt, sides_);
    damped_ -= shared * shared * links_.work_of_reaction(grid_, sides_, jump_);  // which goes to the grains
    if (links_.move_places(points)) move_links();
    links_.let_go(points, advance_.failed, grid_, sides_, advance_.released);
    links_.drop_inertia(points);
    refresh_added_mass();
    damped_ += inertial - links_.inertial_energy(grid_, sides_);
  }
  transferred_.swap(jump_);
  for (std::size_t i = 0; i < filtered_.size(); ++i) transferred_[i] -= filtered_[i];
  filtered_.clear();
  jump_.clear();
}

// Links whose place left its cell go into other blocks; where the grid ends, it is laid out anew
// in the next step, and until then the margin has the nodes.
void FixMpm::move_links() {
  if (!links_.follow_points(avec_->points, avec_->bodies, grid_, sides_))
    mpdem::stop_one(lmp, text_of("fix mpm (id ", id, "): a link moved out of the grid at step ", update->ntimestep,
                                 "; check the motion of the grains and the time step"));
}

// Has any point of `total` kinematics distorted by more than is asked for? Collective.
bool FixMpm::distorted() {
  const mpdem::PointStore& points = avec_->points;
  vd most{};
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const mpdem::Mat3<vd>& F = points.blocks[b].F;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) most = mpdem::max(most, mpdem::abs(F.a[i][j] - (i == j ? 1.0 : 0.0)));
  }
  double mine = 0.0, all;
  for (int l = 0; l < kLanes; ++l) mine = std::max(mine, most[l]);
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_MAX, world);
  return all > reproject_distortion_;
}

// The present becomes the reference of points and links; velocities go over by transfer.
void FixMpm::take_new_reference() {
  mpdem::PointStore& points = avec_->points;
  const double before = kinetic_energy(0.0), inertial = coupled_ ? links_.inertial_energy(grid_, sides_) : 0.0;
  mpdem::UpdatedPass::start(points, grid_, 0);
  mpdem::move_to_present(points, grid_);
  if (coupled_) links_.move_to_present(points, grid_);
  std::fill(grid_.displacement.begin(), grid_.displacement.end(), 0.0);
  rebuild();
  check_step_after("the present was taken for the reference");
  mpdem::UpdatedPass::project(points, grid_, *law_, inertia_, transfer_);
  grid_.halo.sum(grid_.mass.data(), 1);
  grid_.halo.sum(grid_.momentum.data(), 3);
  for (int i = 0; i < grid_.size(); ++i)
    if (grid_.mass[i] > 0.0)
      for (int d = 0; d < 3; ++d) grid_.velocity[3 * i + d] = grid_.momentum[3 * i + d] / grid_.mass[i];
  damped_ += before - kinetic_energy(0.0);
  if (coupled_) damped_ += inertial - links_.inertial_energy(grid_, sides_);
}

// Links by the slots of their points, which change while points change cells.
void FixMpm::sort_links() {
  std::vector<mpdem::Link>& links = avec_->points.links;
  const auto by_slot = [](const mpdem::Link& a, const mpdem::Link& b) { return a.slot < b.slot; };
  if (!std::is_sorted(links.begin(), links.end(), by_slot)) links_.renumber(avec_->points.sort_links());
}

void FixMpm::sync_slots() {
  if (!updated_ || !built_) return;
  mpdem::PointStore& points = avec_->points;
  sort_links();
  for (std::size_t b = 0; b < points.meta.size(); ++b)
    for (int l = 0; l < kLanes; ++l)
      if (points.meta[b].occupied >> l & 1) {
        const int i = atom->map(points.tags[b][l]);
        if (i >= 0 && i < atom->nlocal) avec_->slot[i] = kLanes * static_cast<int>(b) + l;
      }
}

}  // namespace LAMMPS_NS
