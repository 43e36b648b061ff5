// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The grid of fix mpm with the ties of its edge nodes (mpm/edge_ties.h). Bodies that came apart have
// none but those between sheets: what their parts share and what their debris holds is for free nodes. As mass goes back from
// the heirs to the nodes then, the momentum and angular momentum of the body are kept by a rigid motion.
#include <mpi.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "../parallel/memory_limit.h"
#include "arguments.h"
#include "comm.h"
#include "fix_mpm.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::text_of;

// Where parts came apart. Links have other nodes then, and their added mass another energy.
void FixMpm::rebuild_parts() {
  distribute_grains();
  const double before = links_.inertial_energy(grid_, sides_);
  rebuild(changed_bodies());
  check_step_after("parts came apart");
  released_ += before - links_.inertial_energy(grid_, sides_);
}

// Bodies that get other parts or lose their ties in the next layout, the same on every rank.
std::vector<char> FixMpm::changed_bodies() const {
  std::vector<char> changed(avec_->bodies.size(), 0);
  for (const auto& p : new_part_) changed[avec_->points.meta[p.first / mpdem::kLanes].body] = 1;
  for (std::size_t b = 0; b < separation_.size(); ++b)
    if (separation_[b].separated && (b >= untied_.size() || !untied_[b])) changed[b] = 1;
  MPI_Allreduce(MPI_IN_PLACE, changed.data(), static_cast<int>(changed.size()), MPI_SIGNED_CHAR, MPI_MAX, world);
  return changed;
}

// With ties and masses. To look for ties costs more than all the rest of a layout, and in a packing one body of
// thousands comes apart: those of bodies that did not change are taken over from the grid as it was.
void FixMpm::build_grid(mpdem::Grid& grid, const mpdem::PointStore& points, const std::vector<mpdem::Grid::Cell>& cells,
                        const mpdem::NodeKinematics& restored, std::vector<char>& fresh, int margin,
                        const std::vector<char>& changed) {
  if (memory_limit_ == 0.0) memory_limit_ = mpdem::memory_limit(world);
  grid.most_bytes = 0.5 * memory_limit_;  // points and what LIGGGHTS has come on top
  try {
    std::vector<mpdem::EdgeTie> ties, kept;
    std::vector<mpdem::Key> masters;
    const auto in_question = [&](int field) { return changed.empty() || changed[mpdem::body_of(field)]; };
    const auto merge_kept = [&] {
      std::vector<mpdem::EdgeTie> all;
      all.reserve(ties.size() + kept.size());
      std::merge(std::make_move_iterator(ties.begin()), std::make_move_iterator(ties.end()), std::make_move_iterator(kept.begin()),
                 std::make_move_iterator(kept.end()), std::back_inserter(all),
                 [](const mpdem::EdgeTie& a, const mpdem::EdgeTie& b) { return a.slave < b.slave; });
      ties.swap(all);
    };
    if (tied_ && !changed.empty())
      for (mpdem::EdgeTie& t : grid.ties.by_key(grid.keys))
        if (!in_question(t.slave[0])) kept.push_back(std::move(t));
    if (tied_ && comm->nprocs > 1) {
      // a slave of this rank may have its masters on others
      mpdem::Grid plan;
      plan.basis = basis_;
      plan.most_bytes = grid.most_bytes;
      std::vector<mpdem::Grid::Cell> asked;
      std::copy_if(cells.begin(), cells.end(), std::back_inserter(asked), [&](const mpdem::Grid::Cell& c) { return in_question(c.field); });
      plan.build(world, cell_, asked, mpdem::NodeKinematics(), fresh);
      plan.lump_mass(points, inertia_, changed);
      ties = find_ties(plan, changed);
      merge_kept();
      for (const mpdem::EdgeTie& t : ties) {
        for (const auto& h : t.heirs) masters.push_back(h.first);
        for (const auto& m : t.masters) masters.push_back(m.first);
      }
    }
    grid.build(world, cell_, cells, restored, fresh, parent_field_, margin, masters);
    if (tied_ && comm->nprocs == 1) {
      grid.lump_mass(points, inertia_);
      ties = find_ties(grid, changed);
      merge_kept();
    }
    if (tied_) grid.tie(world, ties);
    grid.lump_mass(points, inertia_);
  } catch (const mpdem::GridTooLarge& e) {
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): the grid would take more than ", e.bytes, " bytes on a rank, half of the memory for ",
                                 "one is ", grid.most_bytes, "; use a larger 'cell', more machines",
                                 margin > 0 ? ", or 'kinematics total', since points that are scattered take hundreds of nodes each" : ""));
  }
}

std::vector<mpdem::EdgeTie> FixMpm::find_ties(const mpdem::Grid& grid, const std::vector<char>& changed) {
  mpdem::TiedNodes nodes;
  for (int i = 0; i < grid.size(); ++i) {
    const std::size_t b = mpdem::body_of(grid.keys[i][0]);
    if (!changed.empty() && !changed[b]) continue;
    nodes.keys.push_back(grid.keys[i]);
    nodes.mass.push_back(grid.mass[i]);
    nodes.edge.push_back(b >= separation_.size() || !separation_[b].separated);
  }
  nodes.sheets = sheets_at(nodes.keys);
  return mpdem::find_edge_ties(world, basis_, nodes);
}

// Bodies that have ties now and will not have them in the next layout.
std::vector<int> FixMpm::bodies_to_untie() {
  std::vector<int> released;
  if (!tied_) return released;
  untied_.resize(separation_.size(), 0);
  for (std::size_t b = 0; b < separation_.size(); ++b) {
    if (!separation_[b].separated || untied_[b]) continue;
    untied_[b] = 1;
    if (built_) released.push_back(static_cast<int>(b));
  }
  return released;
}

namespace {

// Sums over the nodes of a body: mass, first and second moments of it, momentum, angular momentum,
// kinetic energy.
struct BodyMotion {
  double mass, first[3], second[6], momentum[3], angular[3], kinetic;
};
constexpr int kWidth = sizeof(BodyMotion) / sizeof(double);

}  // namespace

// Of each body, with the kick of the next drift ahead. Collective.
std::vector<double> FixMpm::motion_of_bodies() const {
  std::vector<double> sums(kWidth * avec_->bodies.size(), 0.0);
  const double kick = 0.5 * (dt_last_ + update->dt);
  for (int i = 0; i < grid_.size(); ++i) {
    if (!grid_.halo.counts_here()[i]) continue;
    BodyMotion& s = reinterpret_cast<BodyMotion*>(sums.data())[mpdem::body_of(grid_.keys[i][0])];
    double x[3], v[3];
    for (int d = 0; d < 3; ++d) {
      x[d] = grid_.keys[i][1 + d] * cell_ + grid_.displacement[3 * i + d];
      v[d] = grid_.velocity[3 * i + d] + kick * grid_.acceleration[3 * i + d];
    }
    const double m = grid_.mass[i];
    s.mass += m;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      s.first[d] += m * x[d];
      s.second[d] += m * x[d] * x[d];
      s.second[3 + d] += m * x[e] * x[g];
      s.momentum[d] += m * v[d];
      s.angular[d] += m * (x[e] * v[g] - x[g] * v[e]);
      s.kinetic += 0.5 * m * v[d] * v[d];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, world);
  return sums;
}

void FixMpm::keep_motion_of_bodies(const std::vector<int>& bodies, const std::vector<double>& before) {
  std::vector<double> after = motion_of_bodies();
  std::vector<Eigen::Matrix<double, 6, 1>> rigid(avec_->bodies.size(), Eigen::Matrix<double, 6, 1>::Zero());
  for (int b : bodies) {
    const BodyMotion& old = reinterpret_cast<const BodyMotion*>(before.data())[b];
    const BodyMotion& now = reinterpret_cast<const BodyMotion*>(after.data())[b];
    if (!(now.mass > 0.0)) continue;
    // M (V, omega) = what is missing; lengths in cells, so that the numbers are alike
    Eigen::Matrix<double, 6, 6> M = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> missing;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      M(d, d) = now.mass;
      M(d, 3 + e) = M(3 + e, d) = now.first[g] / cell_;
      M(d, 3 + g) = M(3 + g, d) = -now.first[e] / cell_;
      M(3 + d, 3 + d) = (now.second[e] + now.second[g]) / (cell_ * cell_);
      M(3 + e, 3 + g) = M(3 + g, 3 + e) = -now.second[3 + d] / (cell_ * cell_);
      missing[d] = old.momentum[d] - now.momentum[d];
      missing[3 + d] = (old.angular[d] - now.angular[d]) / cell_;
    }
    rigid[b] = M.ldlt().solve(missing);
  }
  for (int i = 0; i < grid_.size(); ++i) {
    const auto& r = rigid[mpdem::body_of(grid_.keys[i][0])];
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      const auto x = [&](int c) { return grid_.keys[i][1 + c] + grid_.displacement[3 * i + c] / cell_; };
      grid_.velocity[3 * i + d] += r[d] + r[3 + e] * x(g) - r[3 + g] * x(e);
    }
  }
  after = motion_of_bodies();
  if (comm->me == 0)
    for (int b : bodies)
      released_ += reinterpret_cast<const BodyMotion*>(before.data())[b].kinetic - reinterpret_cast<const BodyMotion*>(after.data())[b].kinetic;
}

}  // namespace LAMMPS_NS
