// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "penalty_links.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "../mpm/lane_by_lane.h"
#include "../mpm/point_scatter.h"
#include "link_states.h"
#include "rigid_motion.h"
#include "traction_laws.h"

namespace mpdem {

// Position of the link when its bond was created.
double PenaltyLinks::created(const PointStore& points, const Link& k, int d) const {
  const int b = k.slot / kLanes, l = k.slot % kLanes;
  if (p_.at_surface) return k.foot[d];
  return points.motion.empty() ? points.blocks[b].X[d][l] : points.motion[b].X0[d][l];
}

// Position at which the link acts, in the reference.
double PenaltyLinks::acts_at(const PointStore& points, const Link& k, int d) const {
  return p_.at_surface ? k.foot[d] + k.moved[d] : points.blocks[k.slot / kLanes].X[d][k.slot % kLanes];
}

PenaltyLinks::PenaltyLinks(const PointStore& points, const BondRecord& record, const PenaltyParameters& parameters, double cell,
                           const CementDensity& density, Basis basis)
    : p_(parameters),
      basis_(basis),
      cell_(cell),
      inverse_h_(1.0 / cell),
      density_(density),
      columns_of_cell_(support(basis) * support(basis)) {
  if (!points.meta.empty()) row_ = points.meta.front().row;
  for (int s = 0; s < 2; ++s) {
    std::copy(record.centre[s], record.centre[s] + 3, centre_[s]);
    orientation_[s] = rotation_of(record.orientation[s]);
  }
  std::vector<Item> items;
  for (std::size_t i = 0; i < points.links.size(); ++i) {
    const Link& k = points.links[i];
    if (!is_bonded(points, k) && !k.keeps_added_mass) continue;
    const int b = k.slot / kLanes, l = k.slot % kLanes;
    const auto cell_along = [&](int d) { return support_base(k.foot[d], inverse_h_, cell_shift(basis_)); };
    items.push_back(
        {{record.grain[0] == k.grain ? 0 : 1, points.meta[b].material, cell_along(0), cell_along(1), cell_along(2), points.tags[b][l]},
         static_cast<int>(i)});
  }
  std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.key < b.key; });
  std::size_t count = 0;
  for (std::size_t n = 0, in_block = 0; n < items.size(); ++n) {
    const bool fresh = n == 0 || in_block == kLanes || !items[n].same_block(items[n - 1]);
    in_block = fresh ? 1 : in_block + 1;
    count += fresh;
  }
  std::vector<LinkBlock>& blocks = blocks_.own();
  blocks.reserve(count);
  link_flags_.reserve(count);
  const auto has_moved = [&](const Item& i) {
    const Link& k = points.links[i.link];
    return created(points, k, 0) != acts_at(points, k, 0) || created(points, k, 1) != acts_at(points, k, 1) ||
           created(points, k, 2) != acts_at(points, k, 2);
  };
  if (std::any_of(items.begin(), items.end(), has_moved)) created_.resize(count);
  if (p_.damping > 0.0) dampers_.resize(count);
  for (auto i = items.begin(); i != items.end();) {
    blocks.emplace_back();
    link_flags_.emplace_back();
    LinkBlock& b = blocks.back();
    const std::size_t n = blocks.size() - 1;
    const Item first = *i;
    b.side = static_cast<std::uint8_t>(first.key[0]);
    b.material = static_cast<std::uint8_t>(first.key[1]);
    b.area = vd{};
    std::fill(b.link, b.link + kLanes, -1);
    int lane = 0;
    for (; lane < kLanes && i != items.end() && i->same_block(first); ++lane, ++i) set_lane(n, lane, points, i->link);
    for (; lane < kLanes; ++lane)  // empty lanes have the position of the first lane, and no area
      for (int d = 0; d < 3; ++d) {
        b.X[d][lane] = b.X[d][0];
        if (!created_.empty()) created_[n].X[d][lane] = created_[n].X[d][0];
        b.base[d][lane] = b.base[d][0];
      }
  }
  columns_.own().assign(kLanes * blocks_.size() * columns_of_cell_, 0);
  std::vector<int>& layers = layers_.own();
  layers.assign(kLanes * blocks_.size(), 0);
  for (std::size_t n = 0; n < blocks_.size(); ++n)
    for (int l = 0; l < kLanes; ++l)
      if (blocks_[n].link[l] >= 0) layers[kLanes * n + l] = points.meta[points.links[blocks_[n].link[l]].slot / kLanes].layer;
  take_states(points);
  find_strength(points, record);
  if (record.grain_E[0] + record.grain_E[1] > 0.0) lay_out_elastic(points, record);
}

// Draws the factors at the foot points.
void PenaltyLinks::find_strength(const PointStore& points, const BondRecord& record) {
  strength_.clear();
  if (p_.law->fields() == 0) return;
  for (int m = 0; m < p_.law->materials(); ++m) {
    std::vector<std::array<double, 3>> feet;
    std::vector<std::size_t> lane;
    for (std::size_t n = 0; n < blocks_.size(); ++n)
      for (int l = 0; l < kLanes && blocks_[n].material == m; ++l) {
        if (blocks_[n].link[l] < 0) continue;
        const double* foot = points.links[blocks_[n].link[l]].foot;
        feet.push_back({foot[0], foot[1], foot[2]});
        lane.push_back(kLanes * n + static_cast<std::size_t>(l));
      }
    const std::vector<double> factors = interface_factors(p_.law->of_material(m).scatter(), record, feet);
    if (factors.empty()) continue;
    if (strength_.empty()) strength_.assign(blocks_.size(), splat(1.0));
    for (std::size_t n = 0; n < lane.size(); ++n) strength_[lane[n] / kLanes][lane[n] % kLanes] = factors[n];
  }
}

void PenaltyLinks::set_lane(std::size_t block, int lane, const PointStore& points, int link) {
  LinkBlock& b = blocks_.own()[block];
  LinkFlags& h = link_flags_[block];
  const Link& k = points.links[link];
  const std::uint8_t bit = static_cast<std::uint8_t>(1u << lane);
  b.link[lane] = link;
  h.counts_for_added_mass |= bit;
  if (is_bonded(points, k)) h.attached |= bit;
  b.area[lane] = k.area;
  const double point_mass = density_.of(b.material) * points.blocks[k.slot / kLanes].volume[k.slot % kLanes];
  if (!dampers_.empty()) dampers_[block][lane] = 2.0 * p_.damping * std::sqrt(k.area * point_mass);
  int base[3];
  base_of(points, k, base);
  for (int d = 0; d < 3; ++d) {
    b.X[d][lane] = acts_at(points, k, d);
    b.base[d][lane] = base[d];
    if (!created_.empty()) created_[block].X[d][lane] = created(points, k, d);
  }
}

// Stores the positions at creation. Must be called before positions change.
void PenaltyLinks::keep_created() {
  if (!created_.empty()) return;
  created_.resize(blocks_.size());
  for (std::size_t n = 0; n < blocks_.size(); ++n) std::copy(blocks_[n].X, blocks_[n].X + 3, created_[n].X);
}

void PenaltyLinks::take_states(const PointStore& points) {
  const int fields = p_.law->fields();
  states_.assign(fields * blocks_.size(), vd{});
  for (std::size_t b = 0; b < blocks_.size() && fields > 0; ++b)
    for (int l = 0; l < kLanes; ++l)
      for (int i = 0; i < fields && blocks_[b].link[l] >= 0; ++i) states_[fields * b + i][l] = points.links[blocks_[b].link[l]].state[i];
}

void PenaltyLinks::base_of(const PointStore& points, const Link& k, int* base) const {
  for (int d = 0; d < 3; ++d) base[d] = support_base(points.blocks[k.slot / kLanes].X[d][k.slot % kLanes], inverse_h_, cell_shift(basis_));
}

void PenaltyLinks::add_cells(std::vector<Grid::Cell>& cells) {
  for (std::size_t n = 0; n < blocks_.size(); ++n)
    for (int l = 0; l < kLanes; ++l) {
      const LinkBlock& b = blocks_[n];
      const int base[3] = {b.base[0][l], b.base[1][l], b.base[2][l]};
      if (b.link[l] >= 0) cells.push_back({field_of(row_, layers_[kLanes * n + l]), base, columns(n, l)});
    }
}

bool PenaltyLinks::find_columns(const Grid& grid) {
  std::vector<Grid::Cell> cells;
  add_cells(cells);
  bool all = true;
  const Grid::Cell* last = nullptr;  // links of one cell follow each other
  for (const Grid::Cell& c : cells) {
    if (last && last->key() == c.key()) std::copy_n(last->column, columns_of_cell_, c.column);
    else all = grid.find_columns(c.field, c.base, c.column) && all;
    last = &c;
  }
  return all;
}

template <class Type>
void PenaltyLinks::gather(const std::vector<double>& nodal, const LinkBlock& b, const Weights<Type>& w, vd* out) const {
  gather_value_by_lane(nodal.data(), b.taken(), columns(b), w, out);
}

void PenaltyLinks::find_moves(const Grid& grid, double dt) {
  with_basis(basis_, [&](auto type) {
    moves_.resize(blocks_.size());
    auto move = moves_.begin();
    for (const LinkBlock& b : blocks_) {
      gather(grid.velocity, b, Weights<decltype(type)>(b.X, b.base, inverse_h_), move->X);
      for (vd& m : (move++)->X) m *= dt;
    }
  });
}

bool PenaltyLinks::move_links(PointStore& points) {
  keep_created();
  gone_ = false;
  bool left = false;
  auto move = moves_.begin();
  for (LinkBlock& b : blocks_.own()) {
    const vd* moved = (move++)->X;
    for (int l = 0; l < kLanes; ++l) {
      if (b.link[l] < 0) continue;
      Link& k = points.links[b.link[l]];
      int base[3];
      base_of(points, k, base);
      for (int d = 0; d < 3; ++d) {
        k.moved[d] += moved[d][l];
        b.X[d][l] = acts_at(points, k, d);  // computed anew and not incremented, so that blocks are bitwise those of a new layout
        left = left || base[d] != b.base[d][l];
      }
      gone_ = gone_ || !(k.attached || k.keeps_added_mass);
    }
  }
  return left || gone_;
}

bool PenaltyLinks::follow_points(const PointStore& points, const BondRecord& record, const Grid& grid) {
  if (gone_) {
    *this = PenaltyLinks(points, record, p_, cell_, density_, basis_);
    return find_columns(grid);
  }
  bool all = true;
  for (std::size_t n = 0; n < blocks_.size(); ++n) {
    const LinkBlock& b = blocks_[n];
    for (int l = 0; l < kLanes; ++l) {
      if (b.link[l] < 0) continue;
      int base[3];
      base_of(points, points.links[b.link[l]], base);
      if (base[0] == b.base[0][l] && base[1] == b.base[1][l] && base[2] == b.base[2][l]) continue;
      set_lane(n, l, points, b.link[l]);
      all = grid.find_columns(field_of(row_, layers_[kLanes * n + l]), base, columns(n, l)) && all;
    }
  }
  return all;
}

void PenaltyLinks::move_to_present(PointStore& points, const Grid& grid) const {
  with_basis(basis_, [&](auto type) {
    for (const LinkBlock& b : blocks_) {
      vd u[3];
      gather(grid.displacement, b, Weights<decltype(type)>(b.X, b.base, inverse_h_), u);
      for (int l = 0; l < kLanes; ++l)
        if (b.link[l] >= 0)
          for (int d = 0; d < 3; ++d) points.links[b.link[l]].moved[d] += u[d][l];
    }
  });
}

void PenaltyLinks::renumber(const std::vector<int>& new_index) {
  for (LinkBlock& b : blocks_.own())
    for (int& k : b.link)
      if (k >= 0) k = new_index[k];
}

void PenaltyLinks::follow_layers(const PointStore& points, const Grid& grid, const std::vector<int>& new_index) {
  for (int& c : columns_.own()) c = new_index[c];
  for (std::size_t n = 0; n < blocks_.size(); ++n)
    for (int l = 0; l < kLanes; ++l) {
      const LinkBlock& b = blocks_[n];
      if (b.link[l] < 0) continue;
      const int now = points.meta[points.links[b.link[l]].slot / kLanes].layer;
      if (now == layers_[kLanes * n + l]) continue;
      layers_.own()[kLanes * n + l] = now;
      const int base[3] = {b.base[0][l], b.base[1][l], b.base[2][l]};
      if (!grid.find_columns(field_of(row_, now), base, columns(n, l)))
        throw std::logic_error("a link to nodes that the grid does not have");
    }
}

// Finds the current vector q from the centre of the grain, its deviation delta from R q0, and the direction n.
template <class Type>
void PenaltyLinks::find_separation(const LinkBlock& b, const Grid& grid, const BondEnd& s, const Weights<Type>& w, vd* q, vd* delta,
                                   vd* n) const {
  vd u[3], r[3], at[3], q0[3];
  gather(grid.displacement, b, w, u);
  // q0 in the frame of the grain.
  const vd* created = created_at(b);
  const Mat3<double>& R = orientation_[b.side];
  for (int d = 0; d < 3; ++d) at[d] = created[d] - centre_[b.side][d];
  for (int d = 0; d < 3; ++d) q0[d] = R.a[0][d] * at[0] + R.a[1][d] * at[1] + R.a[2][d] * at[2];
  for (int d = 0; d < 3; ++d) {
    // u is added last. Its rounding then depends on u and not on the position, so ranks agree.
    const vd X = b.X[d] - s.x[d];
    r[d] = s.R.a[d][0] * q0[0] + s.R.a[d][1] * q0[1] + s.R.a[d][2] * q0[2];
    q[d] = X + u[d];
    delta[d] = (X - r[d]) + u[d];
  }
  const vd inverse = 1.0 / sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  for (int d = 0; d < 3; ++d) n[d] = inverse * r[d];
}

template <class Type>
void PenaltyLinks::find_velocity(const LinkBlock& b, const Grid& grid, const BondEnd& s, const Weights<Type>& w, const vd* q, vd* v) const {
  gather(grid.velocity, b, w, v);
  vd of_grain[3];
  velocity_at(s, q, of_grain);
  for (int d = 0; d < 3; ++d) v[d] -= of_grain[d];
}

template <class Type>
void PenaltyLinks::damper(const LinkBlock& b, const Grid& grid, const BondEnd& s, const Weights<Type>& w, const TractionSecant& k,
                          const vd* q, const vd* n, vd* v, vd* f) const {
  const vd sqrt_kn = sqrt(k.kn), sqrt_kt = sqrt(k.kt);
  find_velocity(b, grid, s, w, q, v);
  const vd vn = v[0] * n[0] + v[1] * n[1] + v[2] * n[2];
  const vd g = masked(link_flags_[number_of(b)].attached, dampers_[number_of(b)]);
  for (int d = 0; d < 3; ++d) f[d] = -g * (sqrt_kt * v[d] + (sqrt_kn - sqrt_kt) * vn * n[d]);
}

template <class Type>
void PenaltyLinks::add_with_damper(const LinkBlock& b, const Weights<Type>& w, const TractionSecant& k, const vd* q, const vd* n, vd* f,
                                   Grid& grid, BondEnd& s) const {
  if (p_.damping > 0.0) {
    vd v[3], by_damper[3];
    damper(b, grid, s, w, k, q, n, v, by_damper);
    for (int d = 0; d < 3; ++d) f[d] += by_damper[d];
  }
  scatter_value_by_lane(grid.force.data(), link_flags_[number_of(b)].attached, columns(b), w, f);
  subtract_from_grain(q, f, s);
}

Power PenaltyLinks::damper_power(const Grid& grid, const BondEnd* ends) const {
  Power power;
  if (p_.damping == 0.0 || blocks_.empty()) return power;
  with_traction(*p_.law, [&](const auto& law) {
    with_basis(basis_, [&](auto type) {
      using Type = decltype(type);
      for (std::size_t i = 0; i < blocks_.size(); ++i) {
        const LinkBlock& b = blocks_[i];
        if (!link_flags_[i].attached) continue;
        const BondEnd& s = ends[b.side];
        const Weights<Type> w(b.X, b.base, inverse_h_);
        vd q[3], delta[3], n[3], v[3], f[3], a[3];
        find_separation(b, grid, s, w, q, delta, n);
        damper(b, grid, s, w, softened(b.side, law.same_kind(b.material).secant(separation_of(delta, n), state(law, i))), q, n, v, f);
        gather(grid.acceleration, b, w, a);
        for (int d = 0; d < 3; ++d) {
          const int e = (d + 1) % 3, g = (d + 2) % 3;
          power.stored -= sum_lanes(f[d] * v[d]);
          power.growth -= sum_lanes(f[d] * (a[d] - s.a[d] - (s.alpha[e] * q[g] - s.alpha[g] * q[e])));
        }
      }
    });
  });
  return power;
}

double PenaltyLinks::fastest(const Grid& grid, const BondEnd* ends) const {
  double square = 0.0;
  if (blocks_.empty()) return square;
  with_basis(basis_, [&](auto type) {
    for (const LinkBlock& b : blocks_) {
      const BondEnd& s = ends[b.side];
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      vd q[3], delta[3], n[3], v[3];
      find_separation(b, grid, s, w, q, delta, n);
      find_velocity(b, grid, s, w, q, v);
      const vd speed = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
      for (int l = 0; l < kLanes; ++l)
        if (link_flags_[number_of(b)].attached >> l & 1) square = std::max(square, speed[l]);
    }
  });
  return std::sqrt(square);
}

template <class F>
void PenaltyLinks::each_attached(const Grid& grid, const BondEnd* ends, F f) const {
  with_basis(basis_, [&](auto type) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const LinkBlock& b = blocks_[i];
      if (i + 1 < blocks_.size()) {
        prefetch_bytes(&blocks_[i + 1], sizeof(LinkBlock));
        prefetch_bytes(columns(blocks_[i + 1]), kLanes * columns_of_cell_ * sizeof(int));
      }
      if (!link_flags_[i].attached) continue;
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      vd q[3], delta[3], n[3];
      find_separation(b, grid, ends[b.side], w, q, delta, n);
      f(i, w, q, delta, n);
    }
  });
}

template <class L, class Type>
void PenaltyLinks::add_force_of(const L& law, std::size_t i, const Weights<Type>& w, const vd* q, const vd* delta, const vd* n, Grid& grid,
                                BondEnd& s) const {
  const LinkBlock& b = blocks_[i];
  const std::uint8_t attached = link_flags_[i].attached;
  if (!attached) return;
  const LinkSeparation apart = separation_of(delta, n);
  const TractionSecant k = law.secant(apart, state(law, i));
  const vd area = masked(attached, b.area);
  vd f[3];
  for (int d = 0; d < 3; ++d) f[d] = -area * (k.kt * delta[d] + (k.kn - k.kt) * apart.n * n[d]);
  add_with_damper(b, w, k, q, n, f, grid, s);
}

double PenaltyLinks::add_force(Grid& grid, BondEnd* ends) {
  LinkStep step;
  if (is_elastic()) {
    add_whole_elastic_force(nullptr, grid, ends, 0.0, step);
    return step.released;
  }
  if (blocks_.empty()) return 0.0;
  with_traction(*p_.law, [&](const auto& law) {
    each_attached(grid, ends, [&](std::size_t i, const auto& w, const vd* q, const vd* delta, const vd* n) {
      add_force_of(law.same_kind(blocks_[i].material), i, w, q, delta, n, grid, ends[blocks_[i].side]);
    });
  });
  return 0.0;
}

void PenaltyLinks::update_and_add_force(PointStore& points, Grid& grid, BondEnd* ends, double dt, LinkStep& step) {
  step.dissipated = step.released = 0.0;
  step.debond.clear();
  if (is_elastic()) return add_whole_elastic_force(&points, grid, ends, dt, step);
  if (blocks_.empty()) return;
  with_traction(*p_.law, [&](const auto& of_first) {
    each_attached(grid, ends, [&](std::size_t i, const auto& w, const vd* q, const vd* delta, const vd* n) {
      BondEnd& s = ends[blocks_[i].side];
      const auto& law = of_first.same_kind(blocks_[i].material);
      if constexpr (std::decay_t<decltype(law)>::kFields > 0) update_block(law, i, w, q, delta, n, points, grid, s, dt, step);
      add_force_of(law, i, w, q, delta, n, grid, s);
    });
  });
  std::sort(step.debond.begin(), step.debond.end());
}

template <class L, class Type>
void PenaltyLinks::update_block(const L& law, std::size_t i, const Weights<Type>& w, const vd* q, const vd* delta, const vd* n,
                                PointStore& points, const Grid& grid, const BondEnd& s, double dt, LinkStep& step) {
  const LinkBlock& b = blocks_[i];
  const std::uint8_t attached = link_flags_[i].attached;
  typename L::State now = state(law, i);
  const vmask was_damaged = states_[L::kFields * i] > 0.0;
  TractionUpdate u = law.update(counted(separation_of(delta, n), i), now);
  if (!any((u.grown | was_damaged) & lanes(attached))) return;
  if (!strength_.empty()) u.dissipated *= strength_[i] * strength_[i];
  const vd area = masked(attached, b.area);
  vd v[3];
  find_velocity(b, grid, s, w, q, v);
  const vd taken = area * energy_loss_in_step(law, state(law, i), now, delta, n, v, dt);  // energy that is dissipated or released
  step.dissipated += sum_lanes(area * u.dissipated);
  const std::uint8_t freed = store_state(law, i, now, u, points, step);
  const vd released = taken - area * u.dissipated;
  release(i, freed, released, false, points, step.released);
  step.released += sum_lanes(select(lanes(freed), vd{}, released));
}

template <class L>
vd PenaltyLinks::energy(const L& law, std::size_t block, const Grid& grid, const BondEnd& s) const {
  const LinkBlock& b = blocks_[block];
  vd q[3], delta[3], n[3];
  with_basis(basis_, [&](auto type) { find_separation(b, grid, s, Weights<decltype(type)>(b.X, b.base, inverse_h_), q, delta, n); });
  if (is_elastic())
    return masked(link_flags_[block].attached, b.area) *
           softened(b.side, law.secant(separation_of(delta, n), state(law, block))).energy(separation_of(delta, n));
  return masked(link_flags_[block].attached, b.area) * law.energy(separation_of(delta, n), state(law, block));
}

// Energy per area that a spring with a stiffness that changes in a step takes from central differences: delta(t -
// dt).(K(t - dt) - K(t)).delta(t)/2. This is what damage dissipates and closed links release, with two exceptions: the
// damage of a step that jumps over the peak, and links that open or close.
template <class L>
vd PenaltyLinks::energy_loss_in_step(const L& law, const typename L::State& before, const typename L::State& after, const vd* delta,
                                     const vd* n, const vd* v, double dt) {
  vd old[3];
  for (int d = 0; d < 3; ++d) old[d] = delta[d] - dt * v[d];
  const LinkSeparation then = separation_of(old, n), now = separation_of(delta, n);
  const TractionSecant k0 = law.secant(then, before), k1 = law.secant(now, after);
  const vd product = old[0] * delta[0] + old[1] * delta[1] + old[2] * delta[2];
  return 0.5 * ((k0.kt - k1.kt) * product + ((k0.kn - k0.kt) - (k1.kn - k1.kt)) * then.n * now.n);
}

void PenaltyLinks::release(std::size_t block, std::uint8_t freed, vd energy, bool is_residue, PointStore& points, double& released) {
  const LinkBlock& b = blocks_[block];
  for (int l = 0; l < kLanes; ++l) {
    if (!(freed >> l & 1)) continue;
    released += energy[l];
    points.links[b.link[l]].attached = is_residue;
    points.links[b.link[l]].keeps_added_mass = true;
  }
  link_flags_[block].attached &= static_cast<std::uint8_t>(~freed);
}

// Energy that is released if a force ends within a step, k delta(t) delta(t - dt)/2. The force works with its last
// value over half of the motion of that step. Stiff links move much within a step.
template <class L>
vd PenaltyLinks::energy_at_debonding(const L& law, std::size_t block, const Grid& grid, const BondEnd& s, double dt) const {
  const LinkBlock& b = blocks_[block];
  vd q[3], delta[3], n[3], v[3], before[3];
  with_basis(basis_, [&](auto type) {
    const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
    find_separation(b, grid, s, w, q, delta, n);
    find_velocity(b, grid, s, w, q, v);
  });
  const LinkSeparation apart = separation_of(delta, n);
  for (int d = 0; d < 3; ++d) before[d] = delta[d] - dt * v[d];
  const vd product = before[0] * delta[0] + before[1] * delta[1] + before[2] * delta[2];
  const vd n_before = before[0] * n[0] + before[1] * n[1] + before[2] * n[2];
  const TractionSecant k = softened(b.side, law.secant(apart, state(law, block)));
  return masked(link_flags_[block].attached, 0.5 * b.area) * (k.kt * product + (k.kn - k.kt) * apart.n * n_before);
}

std::vector<int> PenaltyLinks::debond(PointStore& points, const std::vector<int>& failed, const Grid& grid, const BondEnd* ends, double dt,
                                      double& released) {
  if (is_elastic()) find_secants(grid, ends);
  std::vector<int> of_failed;  // ascending; most points have no links
  for (int slot : failed) {
    const auto [first, end] = of_slot(points.links, slot);
    for (auto k = first; k != end; ++k) of_failed.push_back(static_cast<int>(k - points.links.begin()));
  }
  std::vector<int> gone;
  if (of_failed.empty() || blocks_.empty()) return gone;
  with_traction(*p_.law, [&](const auto& law) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const LinkBlock& b = blocks_[i];
      const std::uint8_t attached = link_flags_[i].attached;
      std::uint8_t freed = 0;
      for (int l = 0; l < kLanes; ++l)
        if ((attached >> l & 1) && std::binary_search(of_failed.begin(), of_failed.end(), b.link[l]))
          freed |= static_cast<std::uint8_t>(1u << l);
      if (freed && is_elastic()) add_freed(i, freed, grid, ends[b.side]);
      if (freed)
        release(i, freed, energy_at_debonding(law.same_kind(b.material), i, grid, ends[b.side], dt), law.leaves_residue(), points,
                released);
      for (int l = 0; l < kLanes; ++l)
        if (freed >> l & 1) gone.push_back(b.link[l]);
    }
  });
  std::sort(gone.begin(), gone.end());
  return gone;
}

void PenaltyLinks::add_spring_energy(const Grid& grid, const BondEnd* ends, double& U) const {
  if (blocks_.empty()) return;
  with_traction(*p_.law, [&](const auto& law) {
    for (std::size_t i = 0; i < blocks_.size(); ++i)
      if (link_flags_[i].attached) U += sum_lanes(energy(law.same_kind(blocks_[i].material), i, grid, ends[blocks_[i].side]));
  });
  if (is_elastic()) U -= modal_energy();
}

void PenaltyLinks::remove_dropped(const PointStore& points, const BondRecord& record) {
  PenaltyLinks left(points, record, p_, cell_, density_, basis_);
  std::vector<const int*> columns_of(points.links.size(), nullptr);
  for (const LinkBlock& b : blocks_)
    for (int l = 0; l < kLanes; ++l)
      if (b.link[l] >= 0) columns_of[b.link[l]] = columns(b) + l * columns_of_cell_;
  int* to = left.columns_.own().data();
  for (const LinkBlock& b : left.blocks_)
    for (int l = 0; l < kLanes; ++l, to += columns_of_cell_)
      if (b.link[l] >= 0) std::copy_n(columns_of[b.link[l]], columns_of_cell_, to);
  left.continue_from(*this);
  *this = std::move(left);
}

std::vector<PenaltyLinks::Secant> PenaltyLinks::secants(const Grid& grid, const BondEnd* ends) const {
  std::vector<Secant> secants(blocks_.size());
  if (blocks_.empty()) return secants;
  with_traction(*p_.law, [&](const auto& law) {
    with_basis(basis_, [&](auto type) {
      for (std::size_t i = 0; i < blocks_.size(); ++i) {
        const LinkBlock& b = blocks_[i];
        Secant& s = secants[i];
        vd delta[3];
        find_separation(b, grid, ends[b.side], Weights<decltype(type)>(b.X, b.base, inverse_h_), s.arm, delta, s.n);
        const TractionSecant k = softened(b.side, law.same_kind(b.material).secant(separation_of(delta, s.n), state(law, i)));
        const vd area = masked(link_flags_[i].attached, b.area);
        s.kn = area * k.kn;
        s.kt = area * k.kt;
      }
    });
  });
  return secants;
}

void PenaltyLinks::share(AlikeLists& alike) {
  alike.share(blocks_);
  alike.share(columns_);
  alike.share(layers_);
}

std::size_t PenaltyLinks::memory_usage() const {
  return blocks_.memory_usage() + columns_.memory_usage() + layers_.memory_usage() + link_flags_.capacity() * sizeof(LinkFlags) +
         states_.capacity() * sizeof(vd) + (moves_.capacity() + created_.capacity()) * sizeof(Positions) +
         (dampers_.capacity() + strength_.capacity()) * sizeof(vd) + (elastic_ ? elastic_->memory_usage() : 0);
}

// Used in elastic_links.cpp.
template void PenaltyLinks::find_separation(const LinkBlock&, const Grid&, const BondEnd&, const Weights<LinearHat>&, vd*, vd*, vd*) const;
template void PenaltyLinks::find_velocity(const LinkBlock&, const Grid&, const BondEnd&, const Weights<LinearHat>&, const vd*, vd*) const;
template void PenaltyLinks::add_with_damper(const LinkBlock&, const Weights<LinearHat>&, const TractionSecant&, const vd*, const vd*, vd*,
                                            Grid&, BondEnd&) const;
template void PenaltyLinks::find_separation(const LinkBlock&, const Grid&, const BondEnd&, const Weights<QuadraticBspline>&, vd*, vd*,
                                            vd*) const;
template void PenaltyLinks::find_velocity(const LinkBlock&, const Grid&, const BondEnd&, const Weights<QuadraticBspline>&, const vd*,
                                          vd*) const;
template void PenaltyLinks::add_with_damper(const LinkBlock&, const Weights<QuadraticBspline>&, const TractionSecant&, const vd*, const vd*,
                                            vd*, Grid&, BondEnd&) const;
template void PenaltyLinks::find_separation(const LinkBlock&, const Grid&, const BondEnd&, const Weights<CubicBspline>&, vd*, vd*,
                                            vd*) const;
template void PenaltyLinks::find_velocity(const LinkBlock&, const Grid&, const BondEnd&, const Weights<CubicBspline>&, const vd*,
                                          vd*) const;
template void PenaltyLinks::add_with_damper(const LinkBlock&, const Weights<CubicBspline>&, const TractionSecant&, const vd*, const vd*,
                                            vd*, Grid&, BondEnd&) const;

}  // namespace mpdem
