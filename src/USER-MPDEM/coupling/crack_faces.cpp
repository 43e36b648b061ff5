// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "crack_faces.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "relative_damping.h"
#include "../material/coulomb.h"
#include "../mpm/block_nodes.h"
#include "../mpm/scatter.h"
#include "../parallel/agree.h"

namespace mpdem {

namespace {

double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

CrackFaces::CrackFaces(const PointStore& points, const Grid& grid, const KeyOf& at_start, double friction) : friction_(friction) {
  const std::vector<int> tie = grid.constraints.row_of_each(grid.size());
  find_pairs(grid, at_start, tie);
  if (pairs_.empty()) return;
  std::vector<char> paired(grid.size(), 0);
  for (const Pair& p : pairs_) paired[p.node[0]] = paired[p.node[1]] = 1;
  // Constrained nodes add to their masters, which may be nodes of pairs.
  for (int i = 0; i < grid.size(); ++i)
    if (tie[i] >= 0) grid.constraints.for_each_master(tie[i], [&](int master, double) { paired[i] = paired[i] || paired[master]; });
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const BlockMeta& m = points.meta[b];
    if (m.failed == m.occupied) continue;
    bool near = false;
    for_each_node(grid, m, [&](int i) { near = near || paired[i]; });
    if (near) blocks_.push_back(static_cast<int>(b));
  }
}

// Two nodes with the same grid index belong to different layers. Layer 0 has most nodes, so its nodes are searched for
// at the grid indices where other layers have one. Pairs come in the order of grid indices.
void CrackFaces::find_pairs(const Grid& grid, const KeyOf& at_start, const std::vector<int>& tie) {
  if (grid.keys.empty()) return;
  const Field layer_0 = field_of(row_of(grid.keys.front().field()), 0);
  const auto others = std::lower_bound(grid.keys.begin(), grid.keys.end(), Key::before(layer_0 + 1));
  std::vector<std::pair<Key, int>> at;  // key of the grid index in layer 0, and node
  for (int i = static_cast<int>(others - grid.keys.begin()); i < grid.size(); ++i)
    if (tie[i] < 0) at.emplace_back(grid.keys[i].with_field(layer_0), i);
  std::sort(at.begin(), at.end());
  std::vector<int> here;  // free nodes at a grid index, ascending
  for (auto first = at.begin(); first != at.end();) {
    const Key key = first->first;
    here.clear();
    const auto of_layer_0 = std::lower_bound(grid.keys.begin(), others, key);
    const int node = static_cast<int>(of_layer_0 - grid.keys.begin());
    if (of_layer_0 != others && *of_layer_0 == key && tie[node] < 0) here.push_back(node);
    for (; first != at.end() && first->first == key; ++first) here.push_back(first->second);
    for (std::size_t i = 0; i < here.size(); ++i)
      for (std::size_t j = i + 1; j < here.size(); ++j)
        if (at_start(grid.keys[here[i]]) == at_start(grid.keys[here[j]])) pairs_.push_back({{here[i], here[j]}, {0, 0, 0}, 0.0});
  }
}

// Sums over intact points at their present positions.
void CrackFaces::find_normals(const PointStore& points, Grid& grid) {
  gradient_.assign(3 * grid.size(), 0.0);
  volume_.assign(grid.size(), 0.0);
  with_basis(grid.basis, [&](auto type) {
    for (int b : blocks_) {
      const BlockMeta& m = points.meta[b];
      const std::uint8_t intact = static_cast<std::uint8_t>(m.occupied & ~m.failed);
      if (!intact) continue;
      const PointBlock& p = points.blocks[b];
      const Mat3<vd> back = mpdem::inverse(p.F);
      Mat3<vd> T;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) T.a[i][j] = select(lanes(intact), p.volume * back.a[j][i], vd{});
      const vd volume = select(lanes(intact), p.volume, vd{});
      with_weights<decltype(type)>(p, m, 1.0 / grid.h, [&](const auto& w) {
        scatter_gradient(gradient_.data(), m.column, w, T);
        scatter_scalar(volume_.data(), m.column, w, volume);
      });
    }
  });
  grid.constraints.gather_to_masters(gradient_.data());
  grid.constraints.gather_scalars_to_masters(volume_.data());
  grid.halo.sum(gradient_.data(), 3);
  grid.halo.sum(volume_.data(), 1);
}

void CrackFaces::add_contact_force(const PointStore& points, Grid& grid, const SharedList<double>& added, double kick, double dt) {
  touching_ = 0;
  largest_penetration_ = 0.0;
  if (pairs_.empty()) return;
  find_normals(points, grid);
  for (Pair& p : pairs_) {
    double mass[2];
    for (int s = 0; s < 2; ++s) mass[s] = grid.mass[p.node[s]] + (added.empty() ? 0.0 : added[p.node[s]]);
    std::fill(p.force, p.force + 3, 0.0);
    p.too_far = 0.0;
    if (mass[0] > 0.0 && mass[1] > 0.0) add_pair_force(p, grid, mass, kick, dt);
  }
}

constexpr double kLeastFace = 1e-5;         // G over the face of a cell, for a copy to have contact
constexpr double kLeastFaceForSlip = 0.05;  // the same, for its jump to count as slip

void CrackFaces::add_pair_force(Pair& p, Grid& grid, const double* mass, double kick, double dt) {
  const long a = 3L * p.node[0], b = 3L * p.node[1];
  const double volume[2] = {volume_[p.node[0]], volume_[p.node[1]]};
  if (!(volume[0] > 0.0 && volume[1] > 0.0)) return;
  double n[3], w[3], v[3];  // v: relative velocity of the next step without these forces
  for (int d = 0; d < 3; ++d) {
    n[d] = gradient_[a + d] / volume[0] - gradient_[b + d] / volume[1];
    w[d] = grid.displacement[b + d] - grid.displacement[a + d];
    v[d] = grid.velocity[b + d] - grid.velocity[a + d] + kick * (grid.force[b + d] / mass[1] - grid.force[a + d] / mass[0]);
  }
  const double size = std::sqrt(dot(n, n));
  // G is an area. A copy with almost no intact material has no face.
  const double smaller = std::sqrt(std::min(dot(&gradient_[a], &gradient_[a]), dot(&gradient_[b], &gradient_[b]))) / (grid.h * grid.h);
  if (smaller < kLeastFace || !(size > 0.0)) return;
  for (double& x : n) x /= size;
  const double wn = dot(w, n), vn = dot(v, n);
  if (!(wn / dt + vn < 0.0 && vn < 0.0)) return;
  double slid[3], slip[3];
  for (int d = 0; d < 3; ++d) {
    slid[d] = w[d] - wn * n[d];
    slip[d] = v[d] - vn * n[d];
  }
  const double far = std::sqrt(dot(slid, slid));
  if (far > grid.h) {
    // A copy with little intact material has even less mass. A tiny force moves it far, so its jump says nothing about
    // the slip.
    if (smaller > kLeastFaceForSlip) p.too_far = far;
    return;
  }
  ++touching_;
  largest_penetration_ = std::max(largest_penetration_, -wn);
  const double reduced_mass_over_kick = 1.0 / (kick * (1.0 / mass[0] + 1.0 / mass[1]));  // force that changes v by 1
  // An overlap, where the normal rotated, is undone no faster than the faces close; otherwise it would supply energy.
  const double after = std::min(-wn / dt, -vn);
  const double normal = (after - vn) * reduced_mass_over_kick, stop = std::sqrt(dot(slip, slip)) * reduced_mass_over_kick;
  const double sticks = 1.0 - sliding_share(friction_ * normal, stop);
  for (int d = 0; d < 3; ++d) {
    p.force[d] = normal * n[d] - sticks * reduced_mass_over_kick * slip[d];
    grid.force[a + d] -= p.force[d];
    grid.force[b + d] += p.force[d];
  }
}

double CrackFaces::slid_too_far(const PointStore& points, Grid& grid) const {
  if (pairs_.empty()) return 0.0;
  const std::vector<char> held = connected_grains_of_nodes(points, grid);
  double most = 0.0;
  for (const Pair& p : pairs_)
    if (held[p.node[0]] != 0 && held[p.node[1]] != 0) most = std::max(most, p.too_far);
  return most;
}

Power CrackFaces::power(const Grid& grid) const {
  Power power;
  for (const Pair& p : pairs_)
    for (int s = 0; s < 2; ++s) {
      const long i = 3L * p.node[s];
      if (!grid.halo.counts_here()[p.node[s]]) continue;
      for (int d = 0; d < 3; ++d) power.add((s == 0 ? 1.0 : -1.0) * p.force[d], grid.velocity[i + d], grid.acceleration[i + d]);
    }
  return power;
}

}  // namespace mpdem
