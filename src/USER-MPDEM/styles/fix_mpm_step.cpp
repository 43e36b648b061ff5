// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The time step of fix mpm, and what has to happen when LIGGGHTS moves atoms between
// ranks. State after step n: u_n, v_n-1/2 and a_n at the nodes; F_n, strain and damage at
// the points. A step is one drift of the nodes, one pass over the points, one over the
// links, one sum over shared nodes.
#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "../mpm/gather.h"
#include "../mpm/reproject.h"
#include "../mpm/scatter.h"
#include "arguments.h"
#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "fix_mpm.h"
#include "output.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::kLanes;
using mpdem::text_of;
using mpdem::vd;

// ---------------------------------------------------------------------------- step

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
  jump_.clear();
  if (reproject_every_ > 0 && update->ntimestep % reproject_every_ == 0) reproject();
  grid_.drift(0.5 * (dt_last_ + dt), dt);
  dt_last_ = dt;
  distribute_grains();

  grid_.clear_force();
  advance_.dissipated = advance_.released = 0.0;
  advance_.failed.clear();
  mpdem::advance_points(avec_->points, grid_, *law_, dt, advance_);
  if (coupled_) links_.let_go(avec_->points, advance_.failed, grid_, sides_, advance_.released);
  dissipated_ += advance_.dissipated;
  released_ += advance_.released;
  add_forces();
  react_on_grains();
}

// The kinetic energy that a projection leaves out counts as damped.
void FixMpm::reproject() {
  const double before = kinetic_energy();
  mpdem::reproject_velocity(avec_->points, grid_, density_, jump_);
  damped_ += before - kinetic_energy();
}

double FixMpm::kinetic_energy() const {
  double energy = 0.0;
  for (int i = 0; i < grid_.size(); ++i) {
    if (!grid_.halo.counts_here()[i]) continue;
    const double* v = &grid_.velocity[3 * i];
    energy += 0.5 * grid_.mass[i] * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  return energy;
}

// Everything but the internal force, which is on the nodes already.
void FixMpm::add_forces() {
  sides_.clear_forces();
  if (coupled_) damped_ += dt_last_ * links_.add_force(grid_, sides_);
  grid_.sum_force();
  grid_.update_acceleration();
}

void FixMpm::react_on_grains() {
  if (!coupled_) return;
  // A re-projection is an acceleration too, as far as the added mass is concerned.
  for (std::size_t i = 0; i < jump_.size(); ++i) grid_.acceleration[i] += jump_[i] / dt_last_;
  links_.add_reaction(grid_, sides_);
  for (std::size_t i = 0; i < jump_.size(); ++i) grid_.acceleration[i] -= jump_[i] / dt_last_;
  sides_.sum_forces();
  for (const OwnedSide& o : owned_)
    for (int d = 0; d < 3; ++d) {
      atom->f[o.atom][d] += sides_.sides[o.at].force[d];
      atom->torque[o.atom][d] += sides_.sides[o.at].torque[d];
    }
}

void FixMpm::distribute_grains() {
  if (!coupled_) return;
  std::vector<mpdem::GrainSides::Motion> motion(owned_.size());
  for (std::size_t k = 0; k < owned_.size(); ++k) {
    const int i = owned_[k].atom;
    domain->unmap(atom->x[i], atom->image[i], motion[k].x);
    for (int d = 0; d < 3; ++d) {
      motion[k].v[d] = atom->v[i][d];
      motion[k].omega[d] = atom->omega[i][d];
    }
    std::copy(avec_->orientation(i), avec_->orientation(i) + 4, motion[k].q);
  }
  sides_.distribute(avec_->bodies, motion);
}

void FixMpm::end_of_step() {
  // Work of the grains on the cement. Forces and velocities are both those of the end of
  // the step, so the sum is the trapezoidal rule, half of the last term ahead.
  work_last_ = 0.0;
  for (const OwnedSide& o : owned_)
    for (int d = 0; d < 3; ++d)
      work_last_ -= dt_last_ * (sides_.sides[o.at].force[d] * atom->v[o.atom][d] +
                                sides_.sides[o.at].torque[d] * atom->omega[o.atom][d]);
  work_ += work_last_;

  const bool output_due = update->ntimestep == output->next;
  if (update->ntimestep % check_every_ == 0) {
    drop_added_mass();
    check_state();
  } else if (output_due) {
    check_state();
  }
  if (output_due) fill_atoms();
}

void FixMpm::post_run() { fill_atoms(); }

void FixMpm::check_state() {
  std::string trouble;
  if (!grid_.finite())
    trouble = text_of("fix mpm (id ", id, "): a node of the grid is not finite at step ", update->ntimestep,
                      "; check the motion of the grains, the time step and the contact model");
  if (coupled_ && sides_.orphan() >= 0)
    trouble = text_of("fix mpm (id ", id, "): grain ", sides_.sides[sides_.orphan()].tag,
                      " has cement but was deleted or lost at step ", update->ntimestep,
                      "; keep bonded grains, or use a larger box");
  mpdem::stop_if_any(lmp, trouble);
}

// ------------------------------------------------------- set-up and moves between ranks

void FixMpm::setup_pre_exchange() {
  if (!built_ || !started_) return;
  // The state is in the points; atoms only show it, and a command that moved them in
  // between would be without effect.
  std::vector<double> shown;
  for (int i = 0; i < atom->nlocal; ++i)
    if (avec_->is_point(i))
      for (int d = 0; d < 3; ++d) {
        shown.push_back(atom->x[i][d]);
        shown.push_back(atom->v[i][d]);
      }
  fill_atoms();
  std::string trouble;
  std::size_t at = 0;
  const double speed = law_->elasticity().fastest_wave(density_);
  for (int i = 0; i < atom->nlocal; ++i)
    if (avec_->is_point(i))
      for (int d = 0; d < 3; ++d) {
        const bool moved = std::fabs(shown[at] - atom->x[i][d]) > 1e-9 * cell_ ||
                           std::fabs(shown[at + 1] - atom->v[i][d]) > 1e-9 * speed;
        at += 2;
        if (moved && trouble.empty())
          trouble = text_of("fix mpm (id ", id, "): a command changed position or velocity of material point ", atom->tag[i],
                            " after the cement was set in motion; do so before the first run");
      }
  mpdem::stop_if_any(lmp, trouble);
}

void FixMpm::pre_exchange() {
  if (built_) fill_atoms();
}

void FixMpm::setup_pre_neighbor() {
  count_points();
  rebuild();
}

void FixMpm::pre_neighbor() {
  count_points();
  int changed = 0;
  std::size_t live = 0;
  for (int i = 0; i < atom->nlocal; ++i) live += avec_->is_point(i);
  std::size_t arranged = 0;
  for (const mpdem::BlockMeta& m : avec_->points.meta) arranged += static_cast<std::size_t>(__builtin_popcount(m.occupied));
  if (live != arranged) changed = 1;
  // Arrivals sit in tail blocks that no grid knows.
  for (int i = 0; i < atom->nlocal && !changed; ++i)
    if (avec_->slot[i] / kLanes >= static_cast<int>(arranged_blocks_)) changed = 1;
  for (const OwnedSide& o : owned_) {
    const int i = atom->map(avec_->bodies[o.body].grain[o.side]);
    if (i < 0 || i >= atom->nlocal) changed = 1;
  }
  int any;
  MPI_Allreduce(&changed, &any, 1, MPI_INT, MPI_MAX, world);
  // Added masses change at this step on every decomposition or on none.
  if (any) {
    rebuild();
  } else {
    find_owned_grains();
    drop_added_mass();
  }
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

void FixMpm::find_owned_grains() {
  owned_.clear();
  grains_here_.clear();
  for (std::size_t b = 0; b < avec_->bodies.size(); ++b)
    for (int s = 0; s < 2; ++s) {
      const int i = atom->map(avec_->bodies[b].grain[s]);
      if (i < 0 || i >= atom->nlocal) continue;
      owned_.push_back({i, sides_.find(static_cast<int>(b), s), static_cast<int>(b), s});
      avec_->track_orientation(i);
      grains_here_.push_back(i);
    }
  std::sort(grains_here_.begin(), grains_here_.end());
  grains_here_.erase(std::unique(grains_here_.begin(), grains_here_.end()), grains_here_.end());
}

void FixMpm::rebuild() {
  mpdem::PointStore& points = avec_->points;
  std::vector<int> live, tags, place;
  for (int i = 0; i < atom->nlocal; ++i)
    if (avec_->is_point(i)) {
      live.push_back(avec_->slot[i]);
      tags.push_back(atom->tag[i]);
    }
  points.arrange(live, tags, cell_, place);
  std::size_t at = 0;
  for (int i = 0; i < atom->nlocal; ++i)
    if (avec_->is_point(i)) avec_->slot[i] = place[at++];
  arranged_blocks_ = points.blocks.size();
  set_frames();

  std::vector<mpdem::Grid::Cell> cells;
  for (mpdem::BlockMeta& m : points.meta) cells.push_back({m.body, m.base, m.column});
  if (coupled_) {
    links_.build(points, avec_->bodies, penalty_, cell_, density_);
    links_.add_cells(cells);
  }
  if (restored_cell_ != 0.0 && restored_cell_ != cell_)
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): 'cell ", cell_, "' but the restart file was written with cell ",
                                 restored_cell_, "; use that"));
  std::vector<char> fresh;
  grid_.build(world, cell_, cells, restored_, fresh);
  restored_ = mpdem::NodeKinematics();
  grid_.lump_mass(points, density_);
  if (!started_) start_velocities(fresh);
  if (coupled_) {
    std::vector<mpdem::Key> owned;
    for (std::size_t b = 0; b < avec_->bodies.size(); ++b)
      for (int s = 0; s < 2; ++s) {
        const int i = atom->map(avec_->bodies[b].grain[s]);
        if (i >= 0 && i < atom->nlocal) owned.push_back({static_cast<int>(b), s, 0, 0});
      }
    sides_.build(world, avec_->bodies, links_.needed_sides(), owned);
    links_.bind(sides_);
  }
  find_owned_grains();
  built_ = true;
  if (dt_last_ == 0.0) dt_last_ = update->dt;
  refresh_added_mass();
}

void FixMpm::refresh_added_mass() {
  if (!coupled_) return;
  std::fill(grid_.penalty.begin(), grid_.penalty.end(), 0.0);
  links_.add_stiffness(grid_);
  grid_.set_added_mass(update->dt, cement_eigenvalue(), stability_bound());
}

// The same in the course of a run, where links that let go give up their added mass.
void FixMpm::drop_added_mass() {
  if (!coupled_ || law_->parameters().B0 == 0.0) return;
  const double before = links_.inertial_energy(grid_, sides_);
  refresh_added_mass();
  released_ += before - links_.inertial_energy(grid_, sides_);
}

// Frame of each new point: third axis along the axis of the elasticity.
void FixMpm::set_frames() {
  mpdem::PointStore& points = avec_->points;
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    mpdem::BlockMeta& m = points.meta[b];
    if (m.framed == m.occupied) continue;
    const mpdem::Body& body = avec_->bodies[m.body];
    for (int l = 0; l < kLanes; ++l) {
      if (!(m.occupied >> l & 1) || (m.framed >> l & 1)) continue;
      mpdem::Vector3 a;
      if (axis_ == kGlobal) {
        a = mpdem::Vector3(axis_direction_[0], axis_direction_[1], axis_direction_[2]);
      } else if (axis_ == kBond) {
        for (int d = 0; d < 3; ++d) a[d] = body.centre[1][d] - body.centre[0][d];
      } else {
        // growth normal of the nearer surface
        mpdem::Vector3 from[2];
        double depth[2];
        for (int s = 0; s < 2; ++s) {
          for (int d = 0; d < 3; ++d) from[s][d] = points.blocks[b].X[d][l] - body.centre[s][d];
          depth[s] = from[s].norm() - body.radius[s];
        }
        a = from[depth[1] < depth[0] ? 1 : 0];
      }
      const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(mpdem::Vector3::UnitZ(), a.normalized());
      mpdem::Frame& f = points.blocks[b].q;
      f.w[l] = q.w();
      f.x[l] = q.x();
      f.y[l] = q.y();
      f.z[l] = q.z();
      m.framed |= static_cast<std::uint8_t>(1u << l);
    }
  }
}

// Nodal velocities from the velocities of the points: the linear field that fits each body
// best is taken over exactly, so a translation or rotation starts without strain, the rest
// by lumped projection.
void FixMpm::start_velocities(const std::vector<char>& fresh) {
  mpdem::PointStore& points = avec_->points;
  const int bodies = static_cast<int>(avec_->bodies.size());
  std::vector<double> velocity(3 * kLanes * points.blocks.size(), 0.0);
  for (int i = 0; i < atom->nlocal; ++i)
    if (avec_->is_point(i))
      for (int d = 0; d < 3; ++d) velocity[3 * avec_->slot[i] + d] = atom->v[i][d];

  // Normal equations of v = A (1, X/cell), 4 x 4 and 4 x 3 a body.
  constexpr int kNormal = 28;
  std::vector<double> sums(kNormal * bodies, 0.0);
  for (std::size_t b = 0; b < points.blocks.size(); ++b)
    for (int l = 0; l < kLanes; ++l) {
      const double V = points.blocks[b].volume[l];
      if (V == 0.0) continue;
      double* s = &sums[kNormal * points.meta[b].body];
      double y[4] = {1.0, 0, 0, 0};
      for (int d = 0; d < 3; ++d) y[1 + d] = points.blocks[b].X[d][l] / cell_;
      for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) s[4 * r + c] += V * y[r] * y[c];
        for (int d = 0; d < 3; ++d) s[16 + 3 * r + d] += V * y[r] * velocity[3 * (kLanes * b + l) + d];
      }
    }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, world);
  std::vector<Eigen::Matrix<double, 4, 3>> fit(bodies);
  for (int n = 0; n < bodies; ++n) {
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> A(&sums[kNormal * n]);
    const Eigen::Map<const Eigen::Matrix<double, 4, 3, Eigen::RowMajor>> y(&sums[kNormal * n + 16]);
    fit[n] = A.completeOrthogonalDecomposition().solve(y);
  }

  std::vector<double> momentum(3 * grid_.size(), 0.0);
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const mpdem::PointBlock& p = points.blocks[b];
    const auto& A = fit[points.meta[b].body];
    vd rest[3];
    for (int d = 0; d < 3; ++d) {
      vd v;
      for (int l = 0; l < kLanes; ++l) v[l] = velocity[3 * (kLanes * b + l) + d];
      rest[d] = density_ * p.volume *
                (v - (A(0, d) + (A(1, d) * p.X[0] + A(2, d) * p.X[1] + A(3, d) * p.X[2]) / cell_));
    }
    mpdem::scatter_value(momentum.data(), points.meta[b].column, mpdem::Weights(p.X, points.meta[b].base, 1.0 / cell_),
                         rest);
  }
  grid_.halo.sum(momentum.data(), 3);
  for (int i = 0; i < grid_.size(); ++i) {
    if (!fresh[i]) continue;
    const auto& A = fit[grid_.keys[i][0]];
    for (int d = 0; d < 3; ++d) {
      double v = A(0, d);
      for (int e = 0; e < 3; ++e) v += A(1 + e, d) * grid_.keys[i][1 + e];
      if (grid_.mass[i] > 0.0) v += momentum[3 * i + d] / grid_.mass[i];
      grid_.velocity[3 * i + d] = v;
    }
  }
}

void FixMpm::setup(int) {
  totals_at_ = bonds_at_ = -1;
  jump_.clear();
  report_parameters();
  distribute_grains();
  check_state();
  grid_.clear_force();
  mpdem::add_internal_force(avec_->points, grid_, *law_);
  const double damped = damped_;
  add_forces();
  damped_ = damped;  // this force was counted in the step that led here
  react_on_grains();
  if (!started_) {
    grid_.drift(-0.5 * dt_last_, 0.0);
    started_ = true;
    const Totals& t = totals();
    start_energy_ = t.kinetic + t.elastic + t.coupling;
    totals_at_ = -1;
  }
  fill_atoms();
}

void FixMpm::fill_atoms() {
  const mpdem::PointStore& points = avec_->points;
  // v_n = v_n-1/2 + dt a_n / 2
  std::vector<double> velocity(grid_.velocity);
  for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] += 0.5 * dt_last_ * grid_.acceleration[i];
  struct Motion {
    vd u[3], v[3];
  };
  std::vector<Motion> motion(points.blocks.size());
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const mpdem::Weights w(points.blocks[b].X, points.meta[b].base, 1.0 / cell_);
    mpdem::gather_value(grid_.displacement.data(), points.meta[b].column, w, motion[b].u);
    mpdem::gather_value(velocity.data(), points.meta[b].column, w, motion[b].v);
  }
  std::string trouble;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!avec_->is_point(i)) continue;
    const int b = avec_->slot[i] / kLanes, l = avec_->slot[i] % kLanes;
    const mpdem::Body& body = avec_->bodies[points.meta[b].body];
    double* x = atom->x[i];
    for (int d = 0; d < 3; ++d) {
      x[d] = body.origin[d] + points.blocks[b].X[d][l] + motion[b].u[d][l];
      atom->v[i][d] = motion[b].v[d][l];
    }
    // Not `remap` of the old flags: x is unwrapped here.
    atom->image[i] = ((tagint)IMGMAX << IMG2BITS) | ((tagint)IMGMAX << IMGBITS) | IMGMAX;
    domain->remap(x, atom->image[i]);
    for (int d = 0; d < 3; ++d)
      if (!(x[d] >= domain->boxlo[d] && x[d] <= domain->boxhi[d]) && trouble.empty())
        trouble = text_of("fix mpm (id ", id, "): material point ", atom->tag[i], " left the simulation box at step ",
                          update->ntimestep, " (", "xyz"[d], " = ", x[d], ", box ", domain->boxlo[d], " to ",
                          domain->boxhi[d], "); use a larger or periodic box");
  }
  mpdem::stop_if_any(lmp, trouble);
}

}  // namespace LAMMPS_NS
