// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Links as the semi-implicit penalty sees them: row sums of their stiffness, the added mass that follows
// from these, and what it does to nodes and grains. See penalty_links.h.
#include <algorithm>
#include <cmath>
#include <map>

#include "../mpm/gather.h"
#include "penalty_links.h"

namespace mpdem {

template <class Type, class F>
void PenaltyLinks::for_each_node(const Weights<Type>& w, F f) {
  constexpr int S = Type::kSupport;
  for (int i = 0; i < S; ++i)
    for (int j = 0; j < S; ++j) {
      const vd wij = w.w[0][i] * w.w[1][j];
      for (int k = 0; k < S; ++k) f(S * i + j, k, wij * w.w[2][k]);
    }
}

template <class Type, class F>
void PenaltyLinks::for_each_free_node(const LinkBlock& b, const Weights<Type>& w, F f) const {
  if (b.reduced < 0) {
    for_each_node(w, [&](int c, int l, vd weight) { f(b.column[c] + l, weight); });
    return;
  }
  const Reduced& r = reduced_[b.reduced];
  for (std::size_t n = 0; n < r.node.size(); ++n) f(r.node[n], r.weight[n]);
}

// Sum of the sizes of the weights: a row of the stiffness matrix of a link has the entries
// k A |w_I| |w_J| at most.
template <class Type>
vd PenaltyLinks::row_sum(const LinkBlock& b, const Weights<Type>& w) const {
  if (b.reduced >= 0) return reduced_[b.reduced].row_sum;
  vd sum = splat(1.0);
  for (int d = 0; d < 3; ++d) {
    vd of_direction{};
    for (int i = 0; i < Type::kSupport; ++i) of_direction += abs(w.w[d][i]);
    sum *= of_direction;
  }
  return sum;
}

void PenaltyLinks::find_masters(const Grid& grid) {
  reduced_.clear();
  with_basis(basis_, [&](auto type) {
    for (LinkBlock& b : blocks_) {
      b.reduced = -1;
      if (grid.ties.empty()) continue;
      std::map<int, vd> weights;
      bool tied = false;
      for_each_node(Weights<decltype(type)>(b.X, b.base, inverse_h_), [&](int c, int l, vd weight) {
        const int node = b.column[c] + l, row = grid.ties.row(node);
        const auto add = [&](int to, vd w) {
          const auto at = weights.emplace(to, vd{}).first;
          at->second += w;
        };
        if (row < 0) add(node, weight);
        else grid.ties.for_each_master(row, [&](int master, double share) { add(master, share * weight); });
        tied = tied || row >= 0;
      });
      if (!tied) continue;
      b.reduced = static_cast<int>(reduced_.size());
      Reduced r;
      r.row_sum = vd{};
      for (const auto& w : weights) {
        r.node.push_back(w.first);
        r.weight.push_back(w.second);
        r.row_sum += abs(w.second);
      }
      reduced_.push_back(std::move(r));
    }
  });
}

void PenaltyLinks::drop_inertia(PointStore& points) {
  for (LinkBlock& b : blocks_) {
    if (b.inert == b.attached) continue;
    b.inert_area = b.area;
    b.inert_damper = b.damper;
    b.inert = b.attached;
    for (int l = 0; l < kLanes; ++l)
      if (b.link[l] >= 0) points.links[b.link[l]].inert = false;
  }
}

void PenaltyLinks::add_stiffness(Grid& grid, const GrainSides& sides, double dt, double bound) {
  constexpr double kLeast = 0.01;  // of the bound, for the cement: who calls has a step that leaves it some
  const double k = std::max(p_.kn, p_.kt), damper = 2.0 * std::sqrt(k) / dt;
  with_basis(basis_, [&](auto type) {
    for (LinkBlock& b : blocks_) {
      if (!b.inert) continue;
      const double left = std::max(kLeast, 1.0 - dt * dt * sides.sides[b.at].frequency2 / bound);
      b.inertia = (k * b.inert_area + damper * b.inert_damper) / left;
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      const vd row = b.inertia * row_sum(b, w);
      for_each_free_node(b, w, [&](long node, vd weight) { grid.penalty[node] += sum_lanes(row * abs(weight)); });
    }
  });
}

void PenaltyLinks::share_added_mass(const Grid& grid) {
  shares_.clear();
  if (std::none_of(grid.added_mass.begin(), grid.added_mass.end(), [](double m) { return m != 0.0; })) return;
  std::vector<double> of_side[2];
  std::vector<int> at_side[2];
  for (int s = 0; s < 2; ++s) {
    of_side[s].assign(grid.size(), 0.0);
    at_side[s].assign(grid.size(), -1);
  }
  with_basis(basis_, [&](auto type) {
    for (const LinkBlock& b : blocks_) {
      if (!b.inert) continue;
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      const vd row = b.inertia * row_sum(b, w);
      for_each_free_node(b, w, [&](long node, vd weight) {
        if (grid.added_mass[node] == 0.0) return;
        of_side[b.side][node] += sum_lanes(row * abs(weight));
        at_side[b.side][node] = b.at;
      });
    }
  });
  // the node's added mass belongs to its links by their share of its stiffness
  for (int i = 0; i < grid.size(); ++i)
    for (int s = 0; s < 2; ++s)
      if (at_side[s][i] >= 0) shares_.push_back({at_side[s][i], i, grid.added_mass[i] / grid.penalty[i] * of_side[s][i]});
}

// Calls f(share, place from the grain's centre) for all nodes with added mass.
template <class F>
void PenaltyLinks::for_each_added_mass(const Grid& grid, const GrainSides& sides, F f) const {
  for (const AddedMass& a : shares_) {
    const GrainSide& s = sides.sides[a.at];
    double r[3];
    for (int d = 0; d < 3; ++d) r[d] = grid.keys[a.node][1 + d] * grid.h + grid.displacement[3 * a.node + d] - s.x[d];
    f(a, r);
  }
}

void PenaltyLinks::carry_added_mass(Grid& grid, GrainSides& sides) const {
  const auto accelerates = [](const GrainSide& s) {
    return std::any_of(s.a, s.a + 3, [](double a) { return a != 0.0; }) || std::any_of(s.alpha, s.alpha + 3, [](double a) { return a != 0.0; });
  };
  if (std::none_of(sides.sides.begin(), sides.sides.end(), accelerates)) return;
  for_each_added_mass(grid, sides, [&](const AddedMass& share, const double* r) {
    GrainSide& s = sides.sides[share.at];
    double f[3];
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      f[d] = share.mass * (s.a[d] + s.alpha[e] * r[g] - s.alpha[g] * r[e]);
    }
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      grid.force[3 * share.node + d] += f[d];
      s.force[d] -= f[d];
      s.torque[d] -= r[e] * f[g] - r[g] * f[e];
    }
  });
}

void PenaltyLinks::add_reaction(const Grid& grid, const std::vector<double>& field, double scale, GrainSides& sides) const {
  for_each_added_mass(grid, sides, [&](const AddedMass& share, const double* r) {
    GrainSide& s = sides.sides[share.at];
    const double *a = &field[3 * share.node], m = share.mass;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      s.force[d] += scale * m * a[d];
      s.torque[d] += scale * m * (r[e] * a[g] - r[g] * a[e]);
    }
  });
}

double PenaltyLinks::inertial_energy(const Grid& grid, const GrainSides& sides, double early, double late,
                                     int first_body) const {
  double energy = 0.0;
  for_each_added_mass(grid, sides, [&](const AddedMass& share, const double* r) {
    const GrainSide& s = sides.sides[share.at];
    if (s.body < first_body) return;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      const double v = grid.velocity[3 * share.node + d] - s.v[d] - (s.omega[e] * r[g] - s.omega[g] * r[e]);
      const double a = grid.acceleration[3 * share.node + d] - s.a[d] - (s.alpha[e] * r[g] - s.alpha[g] * r[e]);
      energy += 0.5 * share.mass * (v + early * a) * (v + late * a);
    }
  });
  return energy;
}

std::vector<double> PenaltyLinks::added_mass(const GrainSides& sides) const {
  std::vector<double> mass(sides.sides.size(), 0.0);
  for (const AddedMass& a : shares_) mass[a.at] += a.mass;
  return mass;
}

}  // namespace mpdem
