// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "penalty_links.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "../mpm/gather.h"
#include "../mpm/scatter.h"
#include "traction_laws.h"

namespace mpdem {

namespace {
// Of the links that the bits name, zero elsewhere.
vd of(std::uint8_t which, vd value) { return select(lanes(which), value, vd{}); }

LinkSeparation separation_of(const vd* delta, const vd* n) {
  return {delta[0] * n[0] + delta[1] * n[1] + delta[2] * n[2], delta[0] * delta[0] + delta[1] * delta[1] + delta[2] * delta[2]};
}
}  // namespace

// Where the link was when its body was created.
double PenaltyLinks::created(const PointStore& points, const Link& k, int d) const {
  const int b = k.slot / kLanes, l = k.slot % kLanes;
  if (p_.at_surface) return k.foot[d];
  return points.motion.empty() ? points.blocks[b].X[d][l] : points.motion[b].X0[d][l];
}

// Where it acts, in the reference.
double PenaltyLinks::acts_at(const PointStore& points, const Link& k, int d) const {
  return p_.at_surface ? k.foot[d] + k.moved[d] : points.blocks[k.slot / kLanes].X[d][k.slot % kLanes];
}

PenaltyLinks::PenaltyLinks(const PointStore& points, const Body& body, const PenaltyParameters& parameters, double cell, double density,
                           Basis basis)
    : p_(parameters), basis_(basis), inverse_h_(1.0 / cell), density_(density) {
  if (!points.meta.empty()) body_ = points.meta.front().body;
  std::vector<Item> items;
  for (std::size_t i = 0; i < points.links.size(); ++i)
    if (points.links[i].attached || points.links[i].inert) items.push_back(item_of(points, body, static_cast<int>(i)));
  fill_blocks(points, body, items, blocks_);
  take_states(points);
}

void PenaltyLinks::take_states(const PointStore& points) {
  const int fields = p_.law->fields();
  states_.assign(fields * blocks_.size(), vd{});
  for (std::size_t b = 0; b < blocks_.size() && fields > 0; ++b)
    for (int l = 0; l < kLanes; ++l)
      for (int i = 0; i < fields && blocks_[b].link[l] >= 0; ++i) states_[fields * b + i][l] = points.links[blocks_[b].link[l]].state[i];
}

template <class L>
typename L::State PenaltyLinks::state(const L&, std::size_t block) const {
  typename L::State s{};
  if constexpr (L::kFields > 0) {
    static_assert(sizeof s == L::kFields * sizeof(vd), "a state is its fields");
    std::memcpy(&s, &states_[L::kFields * block], sizeof s);
  }
  return s;
}

PenaltyLinks::Place PenaltyLinks::place_of(const LinkBlock& b) { return {b.part, b.base[0], b.base[1], b.base[2], b.side}; }

PenaltyLinks::Item PenaltyLinks::item_of(const PointStore& points, const Body& body, int link) const {
  const Link& k = points.links[link];
  const int b = k.slot / kLanes, l = k.slot % kLanes;
  Item it{{points.meta[b].part, 0, 0, 0, body.grain[0] == k.grain ? 0 : 1}, points.tags[b][l], link};
  for (int d = 0; d < 3; ++d) it.place[1 + d] = support_base(points.blocks[b].X[d][l], inverse_h_, cell_shift(basis_));
  return it;
}

void PenaltyLinks::fill_blocks(const PointStore& points, const Body& body, std::vector<Item>& items,
                               std::vector<LinkBlock>& blocks) const {
  const double cell = 1.0 / inverse_h_, middle = cell_middle(basis_);
  std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
    return a.place != b.place ? a.place < b.place : a.tag < b.tag;
  });
  std::size_t count = 0;
  for (std::size_t i = 0, lane = 0; i < items.size(); ++i) {
    lane = i > 0 && items[i].place == items[i - 1].place ? (lane + 1) % kLanes : 0;
    count += lane == 0;
  }
  blocks.reserve(blocks.size() + count);

  for (std::size_t i = 0; i < items.size();) {
    LinkBlock b{};
    const Item& first = items[i];
    b.part = first.place[0];
    b.side = first.place[4];
    b.reduced = -1;
    const Mat3<double> R = rotation_of(body.orientation[b.side]);
    for (int d = 0; d < 3; ++d) {
      b.base[d] = first.place[1 + d];
      b.X[d] = splat((b.base[d] + middle) * cell);
      b.q0[d] = splat(body.radius[b.side]);  // any direction will do where the area is zero
    }
    for (int l = 0; l < kLanes; ++l) b.link[l] = -1;
    for (int l = 0; l < kLanes && i < items.size() && items[i].place == first.place; ++l, ++i) {
      const Link& k = points.links[items[i].link];
      b.link[l] = items[i].link;
      b.inert |= static_cast<std::uint8_t>(1u << l);
      const double point_mass = density_ * points.blocks[k.slot / kLanes].volume[k.slot % kLanes];
      b.area[l] = k.area;
      b.damper[l] = 2.0 * p_.damping * std::sqrt(k.area * point_mass);
      if (k.attached) b.attached |= static_cast<std::uint8_t>(1u << l);
      double q[3];
      for (int d = 0; d < 3; ++d) {
        b.X[d][l] = acts_at(points, k, d);
        q[d] = created(points, k, d) - body.centre[b.side][d];
      }
      for (int d = 0; d < 3; ++d) b.q0[d][l] = R.a[0][d] * q[0] + R.a[1][d] * q[1] + R.a[2][d] * q[2];
    }
    blocks.push_back(b);
  }
}

void PenaltyLinks::add_cells(std::vector<Grid::Cell>& cells) {
  for (LinkBlock& b : blocks_) cells.push_back({field_of(body_, b.part), b.base, b.column});
}

bool PenaltyLinks::find_columns(const Grid& grid) {
  bool all = true;
  for (LinkBlock& b : blocks_) all = grid.find_columns(field_of(body_, b.part), b.base, b.column) && all;
  return all;
}

void PenaltyLinks::find_moves(const Grid& grid, double dt) {
  with_basis(basis_, [&](auto type) {
    moves_.resize(blocks_.size());
    auto move = moves_.begin();
    for (LinkBlock& b : blocks_) {
      gather_value(grid.velocity.data(), b.column, Weights<decltype(type)>(b.X, b.base, inverse_h_), move->X);
      for (vd& m : (move++)->X) m *= dt;
    }
  });
}

bool PenaltyLinks::move_places(PointStore& points) {
  const double shift = cell_shift(basis_);
  concerned_.clear();
  bool left = false;
  auto move = moves_.begin();
  for (LinkBlock& b : blocks_) {
    const vd* moved = (move++)->X;
    bool changed = false;
    for (int l = 0; l < kLanes; ++l) {
      if (b.link[l] < 0) continue;
      Link& k = points.links[b.link[l]];
      Place to = place_of(b);
      for (int d = 0; d < 3; ++d) {
        k.moved[d] += moved[d][l];
        b.X[d][l] = acts_at(points, k, d);  // not moved itself: blocks are those of build(), to the bit
        to[1 + d] = support_base(points.blocks[k.slot / kLanes].X[d][k.slot % kLanes], inverse_h_, shift);
      }
      const bool crossed = !std::equal(b.base, b.base + 3, &to[1]);
      if (crossed) concerned_.push_back(to);
      left = left || crossed;
      changed = changed || crossed || !(k.attached || k.inert);
    }
    if (changed) concerned_.push_back(place_of(b));
  }
  return left;
}

bool PenaltyLinks::follow_points(const PointStore& points, const Body& body, const Grid& grid) {
  std::sort(concerned_.begin(), concerned_.end());
  concerned_.erase(std::unique(concerned_.begin(), concerned_.end()), concerned_.end());
  std::vector<Item> items;
  std::vector<LinkBlock> stay, anew;
  stay.reserve(blocks_.size());
  for (const LinkBlock& b : blocks_) {
    if (!std::binary_search(concerned_.begin(), concerned_.end(), place_of(b))) {
      stay.push_back(b);
      continue;
    }
    for (int link : b.link)
      if (link >= 0 && (points.links[link].attached || points.links[link].inert)) items.push_back(item_of(points, body, link));
  }
  fill_blocks(points, body, items, anew);
  bool all = true;
  for (LinkBlock& b : anew) all = grid.find_columns(field_of(body_, b.part), b.base, b.column) && all;
  // not inplace_merge: the buffer it takes from the library is not aligned as a block of lanes has to be
  blocks_.resize(stay.size() + anew.size());
  std::merge(stay.begin(), stay.end(), anew.begin(), anew.end(), blocks_.begin(),
             [](const LinkBlock& a, const LinkBlock& b) { return place_of(a) < place_of(b); });
  take_states(points);
  return all;
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

// Current vector q from the grain's centre, its deviation from R q0 and the direction n.
template <class Type>
void PenaltyLinks::place(const LinkBlock& b, const Grid& grid, const GrainSide& s, vd* q, vd* delta,
                         vd* n) const {
  vd u[3], r[3];
  gather_value(grid.displacement.data(), b.column, Weights<Type>(b.X, b.base, inverse_h_), u);
  for (int d = 0; d < 3; ++d) {
    // u last: what it is rounded to then is a part of itself and not of the place, so ranks agree
    const vd X = b.X[d] - s.x[d];
    r[d] = s.R.a[d][0] * b.q0[0] + s.R.a[d][1] * b.q0[1] + s.R.a[d][2] * b.q0[2];
    q[d] = X + u[d];
    delta[d] = (X - r[d]) + u[d];
  }
  const vd inverse = 1.0 / sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  for (int d = 0; d < 3; ++d) n[d] = inverse * r[d];
}

template <class Type>
void PenaltyLinks::damper(const LinkBlock& b, const Grid& grid, const GrainSide& s, const Weights<Type>& w, const TractionSecant& k,
                          const vd* q, const vd* n, vd* v, vd* f) const {
  const vd sqrt_kn = sqrt(k.kn), sqrt_kt = sqrt(k.kt);
  gather_value(grid.velocity.data(), b.column, w, v);
  v[0] -= s.v[0] + s.omega[1] * q[2] - s.omega[2] * q[1];
  v[1] -= s.v[1] + s.omega[2] * q[0] - s.omega[0] * q[2];
  v[2] -= s.v[2] + s.omega[0] * q[1] - s.omega[1] * q[0];
  const vd vn = v[0] * n[0] + v[1] * n[1] + v[2] * n[2];
  const vd g = of(b.attached, b.damper);
  for (int d = 0; d < 3; ++d) f[d] = -g * (sqrt_kt * v[d] + (sqrt_kn - sqrt_kt) * vn * n[d]);
}

double PenaltyLinks::damper_power(const Grid& grid, const GrainSide* side, double later) const {
  double power = 0.0;
  if (p_.damping == 0.0 || blocks_.empty()) return power;
  with_traction(*p_.law, [&](const auto& law) {
    with_basis(basis_, [&](auto type) {
      using Type = decltype(type);
      for (std::size_t i = 0; i < blocks_.size(); ++i) {
        const LinkBlock& b = blocks_[i];
        if (!b.attached) continue;
        const GrainSide& s = side[b.side];
        const Weights<Type> w(b.X, b.base, inverse_h_);
        vd q[3], delta[3], n[3], v[3], f[3], a[3];
        place<Type>(b, grid, s, q, delta, n);
        damper(b, grid, s, w, law.secant(separation_of(delta, n), state(law, i)), q, n, v, f);
        gather_value(grid.acceleration.data(), b.column, w, a);
        for (int d = 0; d < 3; ++d) {
          const int e = (d + 1) % 3, g = (d + 2) % 3;
          power -= sum_lanes(f[d] * (v[d] + later * (a[d] - s.a[d] - (s.alpha[e] * q[g] - s.alpha[g] * q[e]))));
        }
      }
    });
  });
  return power;
}

void PenaltyLinks::add_force(Grid& grid, GrainSide* side) const {
  if (blocks_.empty()) return;
  with_traction(*p_.law, [&](const auto& law) {
    with_basis(basis_, [&](auto type) {
      using Type = decltype(type);
      for (std::size_t i = 0; i < blocks_.size(); ++i) {
        const LinkBlock& b = blocks_[i];
        if (!b.attached) continue;
        GrainSide& s = side[b.side];
        vd q[3], delta[3], n[3], f[3];
        place<Type>(b, grid, s, q, delta, n);
        const LinkSeparation apart = separation_of(delta, n);
        const TractionSecant k = law.secant(apart, state(law, i));
        const vd area = of(b.attached, b.area);
        for (int d = 0; d < 3; ++d) f[d] = -area * (k.kt * delta[d] + (k.kn - k.kt) * apart.n * n[d]);
        const Weights<Type> w(b.X, b.base, inverse_h_);
        if (p_.damping > 0.0) {
          vd v[3], by_damper[3];
          damper(b, grid, s, w, k, q, n, v, by_damper);
          for (int d = 0; d < 3; ++d) f[d] += by_damper[d];
        }
        scatter_value(grid.force.data(), b.column, w, f);
        for (int d = 0; d < 3; ++d) {
          const int e = (d + 1) % 3, g = (d + 2) % 3;
          s.force[d] -= sum_lanes(f[d]);
          s.torque[d] -= sum_lanes(q[e] * f[g] - q[g] * f[e]);
        }
      }
    });
  });
}

template <class L>
vd PenaltyLinks::energy(const L& law, std::size_t block, const Grid& grid, const GrainSide& s) const {
  const LinkBlock& b = blocks_[block];
  vd q[3], delta[3], n[3];
  with_basis(basis_, [&](auto type) { place<decltype(type)>(b, grid, s, q, delta, n); });
  return of(b.attached, b.area) * law.energy(separation_of(delta, n), state(law, block));
}

void PenaltyLinks::follow(PointStore& points, const Grid& grid, const GrainSide* side, LinkStep& step) {
  step.dissipated = step.released = 0.0;
  step.let_go.clear();
  if (blocks_.empty() || p_.law->fields() == 0) return;
  with_traction(*p_.law, [&](const auto& law) {
    using L = std::decay_t<decltype(law)>;
    if constexpr (L::kFields > 0) {
      for (std::size_t i = 0; i < blocks_.size(); ++i) {
        LinkBlock& b = blocks_[i];
        if (!b.attached) continue;
        vd q[3], delta[3], n[3];
        with_basis(basis_, [&](auto type) { place<decltype(type)>(b, grid, side[b.side], q, delta, n); });
        const LinkSeparation apart = separation_of(delta, n);
        typename L::State s = state(law, i);
        const TractionUpdate u = law.update(apart, s);
        if (!any(u.grown & lanes(b.attached))) continue;
        const vd area = of(b.attached, b.area), left = area * law.energy(apart, s);
        step.dissipated += sum_lanes(area * u.dissipated);
        std::memcpy(&states_[L::kFields * i], &s, sizeof s);
        std::uint8_t freed = 0;
        for (int l = 0; l < kLanes; ++l) {
          if (!(b.attached >> l & 1) || !u.grown[l]) continue;
          for (int k = 0; k < L::kFields; ++k) points.links[b.link[l]].state[k] = states_[L::kFields * i + k][l];
          if (!u.let_go[l]) continue;
          freed |= static_cast<std::uint8_t>(1u << l);
          step.let_go.push_back(b.link[l]);
        }
        release(b, freed, left, points, step.released);
      }
    }
  });
  std::sort(step.let_go.begin(), step.let_go.end());
}

void PenaltyLinks::release(LinkBlock& b, std::uint8_t freed, vd energy, PointStore& points, double& released) {
  for (int l = 0; l < kLanes; ++l) {
    if (!(freed >> l & 1)) continue;
    released += energy[l];
    points.links[b.link[l]].attached = false;
    points.links[b.link[l]].inert = true;
  }
  b.attached &= static_cast<std::uint8_t>(~freed);
}

void PenaltyLinks::let_go(PointStore& points, const std::vector<int>& failed, const Grid& grid, const GrainSide* side,
                          double& released) {
  if (failed.empty() || blocks_.empty()) return;
  with_traction(*p_.law, [&](const auto& law) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      LinkBlock& b = blocks_[i];
      if (!b.attached) continue;
      std::uint8_t freed = 0;
      for (int l = 0; l < kLanes; ++l) {
        if (!(b.attached >> l & 1)) continue;
        if (std::binary_search(failed.begin(), failed.end(), points.links[b.link[l]].slot))
          freed |= static_cast<std::uint8_t>(1u << l);
      }
      if (freed) release(b, freed, energy(law, i, grid, side[b.side]), points, released);
    }
  });
}

void PenaltyLinks::add_spring_energy(const Grid& grid, const GrainSide* side, double& U) const {
  if (blocks_.empty()) return;
  with_traction(*p_.law, [&](const auto& law) {
    for (std::size_t i = 0; i < blocks_.size(); ++i)
      if (blocks_[i].attached) U += sum_lanes(energy(law, i, grid, side[blocks_[i].side]));
  });
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

void PenaltyLinks::drop_inertia(PointStore& points) {
  for (LinkBlock& b : blocks_) {
    if (b.inert == b.attached) continue;
    b.inert = b.attached;
    for (int l = 0; l < kLanes; ++l)
      if (b.link[l] >= 0) points.links[b.link[l]].inert = false;
  }
}

void PenaltyLinks::add_stiffness(const GrainSide* side, double dt, double* penalty) const {
  if (blocks_.empty()) return;
  const TractionStiffness& bound = p_.law->stiffness();
  const double k = std::max(bound.kn, bound.kt), damper = 2.0 * std::sqrt(k) / dt;
  with_basis(basis_, [&](auto type) {
    for (const LinkBlock& b : blocks_) {
      if (!b.inert) continue;
      const vd inertia = (1.0 + side[b.side].mass_ratio) * (k * of(b.inert, b.area) + damper * of(b.inert, b.damper));
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      const vd row = inertia * row_sum(b, w);
      for_each_free_node(b, w, [&](long node, vd weight) { penalty[2 * node + b.side] += sum_lanes(row * abs(weight)); });
    }
  });
}

std::size_t PenaltyLinks::memory_usage() const {
  std::size_t bytes = blocks_.capacity() * sizeof(LinkBlock) + states_.capacity() * sizeof(vd) + reduced_.capacity() * sizeof(Reduced);
  for (const Reduced& r : reduced_) bytes += r.node.capacity() * sizeof(int) + r.weight.capacity() * sizeof(vd);
  return bytes;
}

}  // namespace mpdem
