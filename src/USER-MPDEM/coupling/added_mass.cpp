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

void PenaltyLinks::add_stiffness(Grid& grid, const GrainSides& sides, double dt) {
  const double k = std::max(p_.kn, p_.kt), damper = 2.0 * std::sqrt(k) / dt;
  with_basis(basis_, [&](auto type) {
    for (const LinkBlock& b : blocks_) {
      if (!b.inert) continue;
      const vd inertia = (1.0 + sides.sides[b.at].mass_ratio) * (k * b.inert_area + damper * b.inert_damper);
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      const vd row = inertia * row_sum(b, w);
      for_each_free_node(b, w, [&](long node, vd weight) { grid.penalty[2 * node + b.side] += sum_lanes(row * abs(weight)); });
    }
  });
}

// The node's added mass belongs to its links by their share of its stiffness.
void PenaltyLinks::share_added_mass(const Grid& grid, const GrainSides& sides) {
  shares_.clear();
  int body = -1, first = -1;
  for (int i = 0; i < grid.size(); ++i) {
    if (grid.added_mass[i] == 0.0) continue;
    if (body_of(grid.keys[i][0]) != body) {
      body = body_of(grid.keys[i][0]);
      first = sides.find(body, 0);
    }
    const double *k = &grid.penalty[2 * i], unit = grid.added_mass[i] / (k[0] + k[1]);
    AddedMass a{i, {first, first + 1}, {unit * k[0], unit * k[1]}, {}};
    for (int d = 0; d < 3; ++d) a.X[d] = grid.keys[i][1 + d] * grid.h;
    shares_.push_back(a);
  }
}

namespace {

// Velocity or acceleration at r from the centre of a grain.
void rigid_at(const double* linear, const double* angular, const double* r, double* at) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    at[d] = linear[d] + angular[e] * r[g] - angular[g] * r[e];
  }
}

void acceleration_at(const GrainSide& s, const double* r, double* a) { rigid_at(s.a, s.alpha, r, a); }
void jump_at(const GrainSide& s, const double* r, double* v) { rigid_at(s.jump, s.jump + 3, r, v); }

void add_to_grain(const double* r, const double* f, double scale, double* force, double* torque) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    force[d] += scale * f[d];
    torque[d] += scale * (r[e] * f[g] - r[g] * f[e]);
  }
}

void add_to_grain(const double* r, const double* f, double scale, GrainSide& s) { add_to_grain(r, f, scale, s.force, s.torque); }

bool jumps(const GrainSide& s) {
  return std::any_of(s.jump, s.jump + 6, [](double j) { return j != 0.0; });
}

// Calls f(node, mass, side, place from its centre) for all added mass.
template <class Sides, class F>
void for_each(const std::vector<PenaltyLinks::AddedMass>& shares, const Grid& grid, Sides& sides, F f) {
  for (const PenaltyLinks::AddedMass& a : shares)
    for (int side = 0; side < 2; ++side) {
      if (a.mass[side] == 0.0) continue;
      auto& s = sides.sides[a.at[side]];
      double r[3];
      a.lever_arm(grid, s, r);
      f(a.node, a.mass[side], s, r);
    }
}

}  // namespace

void PenaltyLinks::carry_added_mass(Grid& grid, GrainSides& sides) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  for (const AddedMass& a : shares_) {
    double r[2][3], of_grain[2][3], *f = &grid.force[3 * a.node];
    for (int side = 0; side < 2; ++side) {
      const GrainSide& s = sides.sides[a.at[side]];
      a.lever_arm(grid, s, r[side]);
      acceleration_at(s, r[side], of_grain[side]);
      for (int d = 0; d < 3; ++d) f[d] += a.mass[side] * of_grain[side][d];
    }
    if (!counts[a.node]) continue;
    const double inverse = 1.0 / (grid.mass[a.node] + grid.added_mass[a.node]);
    for (int side = 0; side < 2; ++side) {
      double relative[3];
      for (int d = 0; d < 3; ++d) relative[d] = inverse * f[d] - of_grain[side][d];
      add_to_grain(r[side], relative, a.mass[side], sides.sides[a.at[side]]);
    }
  }
}

void PenaltyLinks::follow_jumps(Grid& grid, GrainSides& sides, double rate, double grain_rate) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  bool any = false;
  for (const AddedMass& a : shares_) {
    GrainSide* s[2] = {&sides.sides[a.at[0]], &sides.sides[a.at[1]]};
    if (!jumps(*s[0]) && !jumps(*s[1])) continue;
    any = true;
    const double inverse = 1.0 / (grid.mass[a.node] + grid.added_mass[a.node]);
    double r[2][3], of_grain[2][3], of_node[3] = {0, 0, 0};
    for (int side = 0; side < 2; ++side) {
      a.lever_arm(grid, *s[side], r[side]);
      jump_at(*s[side], r[side], of_grain[side]);
      for (int d = 0; d < 3; ++d) of_node[d] += inverse * a.mass[side] * of_grain[side][d];
    }
    for (int d = 0; d < 3; ++d) grid.acceleration[3 * a.node + d] += rate * of_node[d];
    if (!counts[a.node]) continue;
    for (int side = 0; side < 2; ++side) {
      double relative[3];
      for (int d = 0; d < 3; ++d) relative[d] = of_node[d] - of_grain[side][d];
      add_to_grain(r[side], relative, grain_rate * a.mass[side], s[side]->jump_force, s[side]->jump_force + 3);
    }
  }
  if (any) grid.ties.extend(grid.acceleration.data());
}

void PenaltyLinks::add_jumps(Grid& grid, GrainSides& sides, int first_body, bool at_start) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(shares_, grid, sides, [&](int node, double mass, GrainSide& s, const double* r) {
    if (s.body < first_body) return;
    double jump[3];
    jump_at(s, r, jump);
    for (int d = 0; d < 3; ++d) {
      if (at_start) jump[d] -= grid.velocity[3 * node + d];
      grid.force[3 * node + d] += mass * jump[d];
    }
    if (counts[node]) add_to_grain(r, jump, -mass, s);
  });
}

double PenaltyLinks::inertial_energy_ahead(const Grid& grid, const GrainSides& sides, double later, int end_body) const {
  double energy = 0.0;
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(shares_, grid, sides, [&](int node, double mass, const GrainSide& s, const double* r) {
    if (s.body >= end_body || !counts[node]) return;
    double of_grain[3], jump[3];
    rigid_at(s.v, s.omega, r, of_grain);
    jump_at(s, r, jump);
    for (int d = 0; d < 3; ++d) {
      const double v = grid.velocity[3 * node + d] + later * grid.acceleration[3 * node + d] - (of_grain[d] - jump[d]);
      energy += 0.5 * mass * v * v;
    }
  });
  return energy;
}

void PenaltyLinks::add_reaction(const Grid& grid, const std::vector<double>& field, double scale, GrainSides& sides) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(shares_, grid, sides, [&](int node, double mass, GrainSide& s, const double* r) {
    if (counts[node]) add_to_grain(r, &field[3 * node], scale * mass, s.transfer_force, s.transfer_force + 3);
  });
}

double PenaltyLinks::work_of_reaction(const Grid& grid, const GrainSides& sides, const std::vector<double>& field) const {
  double work = 0.0;
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(shares_, grid, sides, [&](int node, double mass, const GrainSide& s, const double* r) {
    if (!counts[node]) return;
    double of_grain[3];
    rigid_at(s.v, s.omega, r, of_grain);
    for (int d = 0; d < 3; ++d) work += mass * field[3 * node + d] * of_grain[d];
  });
  return work;
}

double PenaltyLinks::inertial_power(const Grid& grid, const GrainSides& sides, const std::vector<double>& field) const {
  double power = 0.0;
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(shares_, grid, sides, [&](int node, double mass, const GrainSide& s, const double* r) {
    if (!counts[node]) return;
    double a[3];
    acceleration_at(s, r, a);
    for (int d = 0; d < 3; ++d) power += mass * (grid.acceleration[3 * node + d] - a[d]) * field[3 * node + d];
  });
  return power;
}

double PenaltyLinks::inertial_energy(const Grid& grid, const GrainSides& sides, double early, double late,
                                     int first_body) const {
  double energy = 0.0;
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(shares_, grid, sides, [&](int node, double mass, const GrainSide& s, const double* r) {
    if (s.body < first_body || !counts[node]) return;
    double rate[3], of_grain[3];
    acceleration_at(s, r, rate);
    rigid_at(s.v, s.omega, r, of_grain);
    for (int d = 0; d < 3; ++d) {
      const double v = grid.velocity[3 * node + d] - of_grain[d];
      const double a = grid.acceleration[3 * node + d] - rate[d];
      energy += 0.5 * mass * (v + early * a) * (v + late * a);
    }
  });
  return energy;
}

std::vector<double> PenaltyLinks::added_mass(const Grid& grid, const GrainSides& sides) const {
  std::vector<double> mass(sides.sides.size(), 0.0);
  for (const AddedMass& a : shares_)
    for (int s = 0; s < 2; ++s)
      if (grid.halo.counts_here()[a.node]) mass[a.at[s]] += a.mass[s];
  return mass;
}

}  // namespace mpdem
