// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A piece of cement with its grid, on one process.
#ifndef MPDEM_TESTS_CEMENT_H
#define MPDEM_TESTS_CEMENT_H

#include <numeric>
#include <vector>

#include "lanes.h"
#include "material/laws.h"
#include "mpm/advance_points.h"
#include "mpm/grid.h"
#include "mpm/point_state.h"

namespace mpdem::test {

constexpr double kCell = 1e-4, kCalcite = 2710;  // m, kg/m3

inline VtiElasticity elastic_calcite() { return VtiElasticity({50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9}); }

inline TensorDamage law_of(double B0, double interface = 1.0, double viscosity = 0.0) {
  DamageParameters p;
  p.B0 = B0;
  p.interface = interface;
  p.viscosity = viscosity;
  return TensorDamage(elastic_calcite(), p);
}

// Damage of a block as a tensor, under TensorDamage.
inline Sym3<vd> damage_of(const PointStore& points, std::size_t b) { return state_of<TensorDamage>(points, static_cast<int>(b)); }

class Cement {
 public:
  PointStore points;
  Grid grid;
  std::vector<int> slots;  // slots of the points, in the order they were given

  // All points have one volume. The material frame is rotated by q.
  Cement(double h, const std::vector<Vector>& X, double volume, const Eigen::Quaterniond& q = Eigen::Quaterniond::Identity(),
         Basis basis = Basis::quadratic, int margin = 0, const std::vector<int>& layer = {}, bool join = false) {
    std::vector<int> tags(X.size());
    std::iota(tags.begin(), tags.end(), 1);
    for (std::size_t i = 0; i < X.size(); ++i) {
      PointRecord r;
      r.has_frame = true;
      for (int d = 0; d < 3; ++d) r.X[d] = X[i][d];
      r.volume = volume;
      if (!layer.empty()) r.layer = layer[i];
      r.q[0] = q.w();
      r.q[1] = q.x();
      r.q[2] = q.y();
      r.q[3] = q.z();
      slots.push_back(points.add(r, tags[i]));
    }
    const std::vector<int> place = points.arrange(h, basis, {}, join);
    for (int& s : slots) s = place[s];
    std::vector<Grid::Cell> cells;
    for (BlockMeta& m : points.meta) cells.push_back({field_of(m.row, m.layer), m.base, m.column, m.joined});
    std::vector<char> fresh;
    grid.basis = basis;
    grid.build(MPI_COMM_SELF, h, cells, NodeKinematics(), fresh, margin);
  }

  Vector place(int node) const { return grid.h * Vector(grid.keys[node].at(0), grid.keys[node].at(1), grid.keys[node].at(2)); }
  Vector at(const std::vector<double>& nodal, int node) const { return {nodal[3 * node], nodal[3 * node + 1], nodal[3 * node + 2]}; }
  template <class F>
  void set_velocity(F f) {
    for (int n = 0; n < grid.size(); ++n) {
      const Vector v = f(place(n));
      for (int d = 0; d < 3; ++d) grid.velocity[3 * n + d] = v[d];
    }
  }
  // Sets u += dt v, then finds strain and internal force of the step.
  AdvanceResult advance(const Law& law, double dt) {
    for (std::size_t i = 0; i < grid.velocity.size(); ++i) grid.displacement[i] += dt * grid.velocity[i];
    grid.clear_force();
    AdvanceResult result;
    advance_points(points, grid, law, dt, result);
    return result;
  }
  // Calls f(block, lane) for every point.
  template <class F>
  void for_points(F f) const {
    for (int s : slots) f(s / kLanes, s % kLanes);
  }
};

// Nodes of a grid for the search of constrained nodes, all of one bond and in one layer.
inline EdgeNodes edges_of(const Grid& grid) { return {grid.keys, {grid.mass.begin(), grid.mass.end()}, {}}; }

// Points at random in [0, n h]^3. Every node between has points all over its support.
inline std::vector<Vector> scattered(Random& random, double h, int n, int per_cell) {
  std::vector<Vector> X;
  for (int i = 0; i < n * n * n * per_cell; ++i) X.push_back(h * Vector(random.uniform(0, n), random.uniform(0, n), random.uniform(0, n)));
  return X;
}

// Lattice of 2 x 2 x 2 points a cell in [0, n h]^3.
inline std::vector<Vector> lattice(double h, int n) {
  std::vector<Vector> X;
  for (int i = 0; i < 2 * n; ++i)
    for (int j = 0; j < 2 * n; ++j)
      for (int k = 0; k < 2 * n; ++k) X.push_back(0.5 * h * Vector(i + 0.5, j + 0.5, k + 0.5));
  return X;
}

}  // namespace mpdem::test

#endif
