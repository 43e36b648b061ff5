// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "penalty_links.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "../mpm/gather.h"
#include "../mpm/scatter.h"

namespace mpdem {

// Where the link was when its body was created.
double PenaltyLinks::created(const PointStore& points, const Link& k, int d) const {
  const int b = k.slot / kLanes, l = k.slot % kLanes;
  if (p_.at_surface) return k.foot[d];
  return points.motion.empty() ? points.blocks[b].X[d][l] : points.motion[b].X0[d][l];
}

void PenaltyLinks::build(const PointStore& points, const std::vector<Body>& bodies,
                         const PenaltyParameters& parameters, double cell, double density, Basis basis) {
  p_ = parameters;
  basis_ = basis;
  const double shift = cell_shift(basis), middle = cell_middle(basis);
  inverse_h_ = 1.0 / cell;
  density_ = density;
  blocks_.clear();
  reduced_.clear();

  struct Item {
    int body, part, side, base[3], tag, link;
    double X[3];
  };
  std::vector<Item> items;
  for (std::size_t i = 0; i < points.links.size(); ++i) {
    const Link& k = points.links[i];
    if (!k.attached && !k.inert) continue;
    const int b = k.slot / kLanes, l = k.slot % kLanes;
    Item it;
    it.body = points.meta[b].body;
    it.part = points.meta[b].part;
    it.side = bodies[it.body].grain[0] == k.grain ? 0 : 1;
    it.tag = points.tags[b][l];
    it.link = static_cast<int>(i);
    for (int d = 0; d < 3; ++d) {
      it.X[d] = p_.at_surface ? k.foot[d] + k.moved[d] : points.blocks[b].X[d][l];
      it.base[d] = support_base(points.blocks[b].X[d][l], inverse_h_, shift);
    }
    items.push_back(it);
  }
  const auto place_of = [](const Item& a) { return std::make_tuple(a.body, a.part, a.base[0], a.base[1], a.base[2], a.side); };
  std::sort(items.begin(), items.end(), [&](const Item& a, const Item& b) {
    return std::make_pair(place_of(a), a.tag) < std::make_pair(place_of(b), b.tag);
  });

  for (std::size_t i = 0; i < items.size();) {
    LinkBlock b{};
    const Item& first = items[i];
    b.body = first.body;
    b.part = first.part;
    b.side = first.side;
    b.at = b.reduced = -1;
    const Body& body = bodies[b.body];
    const Mat3<double> R = rotation_of(body.orientation[b.side]);
    for (int d = 0; d < 3; ++d) {
      b.base[d] = first.base[d];
      b.X[d] = splat((b.base[d] + middle) * cell);
      b.q0[d] = splat(body.radius[b.side]);  // any direction will do where the area is zero
    }
    for (int l = 0; l < kLanes; ++l) b.link[l] = -1;
    for (int l = 0; l < kLanes && i < items.size() && place_of(items[i]) == place_of(first); ++l, ++i) {
      const Link& k = points.links[items[i].link];
      b.link[l] = items[i].link;
      b.inert |= static_cast<std::uint8_t>(1u << l);
      const double point_mass = density_ * points.blocks[k.slot / kLanes].volume[k.slot % kLanes];
      b.inert_area[l] = k.area;
      b.inert_damper[l] = 2.0 * p_.damping * std::sqrt(k.area * point_mass);
      if (k.attached) {
        b.attached |= static_cast<std::uint8_t>(1u << l);
        b.area[l] = b.inert_area[l];
        b.damper[l] = b.inert_damper[l];
      }
      double q[3];
      for (int d = 0; d < 3; ++d) {
        b.X[d][l] = items[i].X[d];
        q[d] = created(points, k, d) - body.centre[b.side][d];
      }
      for (int d = 0; d < 3; ++d) b.q0[d][l] = R.a[0][d] * q[0] + R.a[1][d] * q[1] + R.a[2][d] * q[2];
    }
    blocks_.push_back(b);
  }
}

std::vector<Key> PenaltyLinks::needed_sides() const {
  std::vector<Key> keys;
  for (const LinkBlock& b : blocks_) keys.push_back({b.body, b.side, 0, 0});
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

void PenaltyLinks::add_cells(std::vector<Grid::Cell>& cells) {
  for (LinkBlock& b : blocks_) cells.push_back({field_of(b.body, b.part), b.base, b.column});
}

void PenaltyLinks::bind(const GrainSides& sides) {
  for (LinkBlock& b : blocks_) b.at = sides.find(b.body, b.side);
}

bool PenaltyLinks::find_columns(const Grid& grid) {
  bool all = true;
  for (LinkBlock& b : blocks_) all = grid.find_columns(field_of(b.body, b.part), b.base, b.column) && all;
  return all;
}

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

void PenaltyLinks::find_moves(const Grid& grid, double dt) {
  with_basis(basis_, [&](auto type) {
    for (LinkBlock& b : blocks_) {
      gather_value(grid.velocity.data(), b.column, Weights<decltype(type)>(b.X, b.base, inverse_h_), b.move);
      for (vd& m : b.move) m *= dt;
    }
  });
}

bool PenaltyLinks::move_places(PointStore& points) {
  const double shift = cell_shift(basis_);
  bool left = false;
  for (LinkBlock& b : blocks_)
    for (int l = 0; l < kLanes; ++l) {
      if (b.link[l] < 0) continue;
      Link& k = points.links[b.link[l]];
      for (int d = 0; d < 3; ++d) {
        b.X[d][l] += b.move[d][l];
        k.moved[d] += b.move[d][l];
        const double t = points.blocks[k.slot / kLanes].X[d][k.slot % kLanes] * inverse_h_ - (shift + b.base[d]);
        left = left || !(t >= 0.0 && t < 1.0);
      }
    }
  return left;
}

void PenaltyLinks::move_to_present(PointStore& points, const Grid& grid) const {
  with_basis(basis_, [&](auto type) {
    for (const LinkBlock& b : blocks_) {
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      vd u[3];
      gather_value(grid.displacement.data(), b.column, w, u);
      for (int l = 0; l < kLanes; ++l)
        if (b.link[l] >= 0)
          for (int d = 0; d < 3; ++d) points.links[b.link[l]].moved[d] += u[d][l];
    }
  });
}

void PenaltyLinks::renumber(const std::vector<int>& new_place) {
  for (LinkBlock& b : blocks_)
    for (int& k : b.link)
      if (k >= 0) k = new_place[k];
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

void PenaltyLinks::add_stiffness(Grid& grid, double dt) {
  const double k = std::max(p_.kn, p_.kt), damper = 2.0 * std::sqrt(k) / dt;
  with_basis(basis_, [&](auto type) {
    for (LinkBlock& b : blocks_) {
      if (!b.inert) continue;
      b.inertia = k * b.inert_area + damper * b.inert_damper;
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      const vd row = b.inertia * row_sum(b, w);
      for_each_free_node(b, w, [&](long node, vd weight) { grid.penalty[node] += sum_lanes(row * abs(weight)); });
    }
  });
}

// Current vector q from the grain's centre, its deviation from R q0 and the direction n.
template <class Type>
void PenaltyLinks::place(const LinkBlock& b, const Grid& grid, const GrainSide& s, vd* q, vd* delta,
                         vd* n) const {
  vd u[3], r[3];
  gather_value(grid.displacement.data(), b.column, Weights<Type>(b.X, b.base, inverse_h_), u);
  for (int d = 0; d < 3; ++d) {
    q[d] = b.X[d] + u[d] - s.x[d];
    r[d] = s.R.a[d][0] * b.q0[0] + s.R.a[d][1] * b.q0[1] + s.R.a[d][2] * b.q0[2];
    delta[d] = q[d] - r[d];
  }
  const vd inverse = 1.0 / sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  for (int d = 0; d < 3; ++d) n[d] = inverse * r[d];
}

double PenaltyLinks::add_force(Grid& grid, GrainSides& sides, bool skip_detached) const {
  double power = 0.0;
  const double sqrt_kn = std::sqrt(p_.kn), sqrt_kt = std::sqrt(p_.kt);
  with_basis(basis_, [&](auto type) {
    using Type = decltype(type);
    for (const LinkBlock& b : blocks_) {
      if (!b.attached && skip_detached) continue;
      GrainSide& s = sides.sides[b.at];
      vd q[3], delta[3], n[3], f[3];
      place<Type>(b, grid, s, q, delta, n);
      const vd dn = delta[0] * n[0] + delta[1] * n[1] + delta[2] * n[2];
      for (int d = 0; d < 3; ++d) f[d] = -b.area * (p_.kt * delta[d] + (p_.kn - p_.kt) * dn * n[d]);
      const Weights<Type> w(b.X, b.base, inverse_h_);
      if (p_.damping > 0.0) {
        vd v[3];
        gather_value(grid.velocity.data(), b.column, w, v);
        v[0] -= s.v[0] + s.omega[1] * q[2] - s.omega[2] * q[1];
        v[1] -= s.v[1] + s.omega[2] * q[0] - s.omega[0] * q[2];
        v[2] -= s.v[2] + s.omega[0] * q[1] - s.omega[1] * q[0];
        const vd vn = v[0] * n[0] + v[1] * n[1] + v[2] * n[2];
        vd taken{};
        for (int d = 0; d < 3; ++d) {
          const vd fd = b.damper * (sqrt_kt * v[d] + (sqrt_kn - sqrt_kt) * vn * n[d]);
          f[d] -= fd;
          taken += fd * v[d];
        }
        power += sum_lanes(taken);
      }
      scatter_value(grid.force.data(), b.column, w, f);
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        s.force[d] -= sum_lanes(f[d]);
        s.torque[d] -= sum_lanes(q[e] * f[g] - q[g] * f[e]);
      }
    }
  });
  return power;
}

// Calls f(side, node, place from the grain's centre, added mass) for all nodes with such mass.
template <class F>
void PenaltyLinks::for_each_added_mass(const Grid& grid, const GrainSides& sides, F f) const {
  with_basis(basis_, [&](auto type) {
    using Type = decltype(type);
    for (const LinkBlock& b : blocks_) {
      if (!b.inert) continue;
      const GrainSide& s = sides.sides[b.at];
      const Weights<Type> w(b.X, b.base, inverse_h_);
      const vd row = b.inertia * row_sum(b, w);
      for_each_free_node(b, w, [&](long node, vd weight) {
        if (grid.added_mass[node] == 0.0) return;
        // the node's added mass belongs to its links by their share of its stiffness
        const double m = grid.added_mass[node] / grid.penalty[node] * sum_lanes(row * abs(weight));
        double r[3];
        for (int d = 0; d < 3; ++d) r[d] = grid.keys[node][1 + d] * grid.h + grid.displacement[3 * node + d] - s.x[d];
        f(b.at, node, r, m);
      });
    }
  });
}

void PenaltyLinks::carry_added_mass(Grid& grid, GrainSides& sides) const {
  const auto accelerates = [](const GrainSide& s) {
    return std::any_of(s.a, s.a + 3, [](double a) { return a != 0.0; }) || std::any_of(s.alpha, s.alpha + 3, [](double a) { return a != 0.0; });
  };
  if (std::none_of(sides.sides.begin(), sides.sides.end(), accelerates)) return;
  for_each_added_mass(grid, sides, [&](int at, long node, const double* r, double m) {
    GrainSide& s = sides.sides[at];
    double f[3];
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      f[d] = m * (s.a[d] + s.alpha[e] * r[g] - s.alpha[g] * r[e]);
    }
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      grid.force[3 * node + d] += f[d];
      s.force[d] -= f[d];
      s.torque[d] -= r[e] * f[g] - r[g] * f[e];
    }
  });
}

void PenaltyLinks::add_reaction(const Grid& grid, const std::vector<double>& field, double scale, GrainSides& sides) const {
  for_each_added_mass(grid, sides, [&](int at, long node, const double* r, double m) {
    GrainSide& s = sides.sides[at];
    const double* a = &field[3 * node];
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      s.force[d] += scale * m * a[d];
      s.torque[d] += scale * m * (r[e] * a[g] - r[g] * a[e]);
    }
  });
}

double PenaltyLinks::inertial_energy(const Grid& grid, const GrainSides& sides) const {
  double energy = 0.0;
  for_each_added_mass(grid, sides, [&](int at, long node, const double* r, double m) {
    const GrainSide& s = sides.sides[at];
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      const double v = grid.velocity[3 * node + d] - s.v[d] - (s.omega[e] * r[g] - s.omega[g] * r[e]);
      energy += 0.5 * m * v * v;
    }
  });
  return energy;
}

// Of the springs of a block, lane by lane.
vd PenaltyLinks::energy(const LinkBlock& b, const Grid& grid, const GrainSide& s) const {
  vd q[3], delta[3], n[3];
  with_basis(basis_, [&](auto type) { place<decltype(type)>(b, grid, s, q, delta, n); });
  const vd dn = delta[0] * n[0] + delta[1] * n[1] + delta[2] * n[2];
  const vd dd = delta[0] * delta[0] + delta[1] * delta[1] + delta[2] * delta[2];
  return 0.5 * b.area * (p_.kt * dd + (p_.kn - p_.kt) * dn * dn);
}

int PenaltyLinks::let_go(PointStore& points, const std::vector<int>& failed, const Grid& grid,
                         const GrainSides& sides, double& released) {
  if (failed.empty()) return 0;
  int count = 0;
  for (LinkBlock& b : blocks_) {
    if (!b.attached) continue;
    std::uint8_t freed = 0;
    for (int l = 0; l < kLanes; ++l) {
      if (!(b.attached >> l & 1)) continue;
      if (std::binary_search(failed.begin(), failed.end(), points.links[b.link[l]].slot))
        freed |= static_cast<std::uint8_t>(1u << l);
    }
    if (!freed) continue;
    const vd U = energy(b, grid, sides.sides[b.at]);
    for (int l = 0; l < kLanes; ++l) {
      if (!(freed >> l & 1)) continue;
      released += U[l];
      points.links[b.link[l]].attached = 0;
      points.links[b.link[l]].inert = true;
      b.area[l] = 0.0;
      b.damper[l] = 0.0;
      ++count;
    }
    b.attached &= static_cast<std::uint8_t>(~freed);
  }
  return count;
}

double PenaltyLinks::spring_energy(const Grid& grid, const GrainSides& sides) const {
  double U = 0.0;
  for (const LinkBlock& b : blocks_)
    if (b.attached) U += sum_lanes(energy(b, grid, sides.sides[b.at]));
  return U;
}

}  // namespace mpdem
