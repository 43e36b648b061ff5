// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "advance_updated.h"

#include <algorithm>

#include "gather.h"
#include "point_stress.h"
#include "scatter.h"

namespace mpdem {

namespace {

const Mat3<vd>& unit() {
  static const Mat3<vd> one{{{splat(1), splat(0), splat(0)}, {splat(0), splat(1), splat(0)}, {splat(0), splat(0), splat(1)}}};
  return one;
}

// Affine part of the velocity at the points of a block.
template <class Type>
Mat3<vd> affine_part(const double* velocity, const int* column, const Weights<Type>& s, const vd* X, const int* base,
                     double h, const Mat3<vd>& gradient) {
  if constexpr (Type::kAffine == 0.0) return gradient;  // equal for tents
  Mat3<vd> C = gather_gradient(velocity, column, with_moments(s, X, base, h));
  const double scale = Type::kAffine / (h * h);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) C.a[i][j] *= scale;
  return C;
}

// Mass, momentum and internal force of the lanes in `which` of block b.
template <class Type>
void give(const PointStore& points, int b, vmask which, const Sym3<vd>& stress, Grid& grid, double density,
          const Transfer& transfer) {
  const PointBlock& p = points.blocks[b];
  const BlockMeta& m = points.meta[b];
  const PointMotion& u = points.motion[b];
  const Weights<Type> s(p.X, m.base, 1.0 / grid.h);
  const vd volume = select(which, p.volume, vd{});
  const vd mass = density * volume;
  scatter_scalar(grid.mass.data(), m.column, s, mass);
  vd momentum[3];
  for (int d = 0; d < 3; ++d) momentum[d] = mass * u.v[d];
  if (transfer.method == Transfer::apic) {
    Mat3<vd> A;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) A.a[i][j] = mass * u.C.a[i][j];
    scatter_affine(grid.momentum.data(), m.column, with_moments(s, p.X, m.base, grid.h), momentum, A);
  } else {
    scatter_value(grid.momentum.data(), m.column, s, momentum);
  }
  if (m.failed != m.occupied) scatter_gradient(grid.force.data(), m.column, s, weighted_kirchhoff(p.q, stress, volume));
}

}  // namespace

void UpdatedPass::bind(const PointStore& points, const Grid& grid) {
  block_with_room_.assign(grid.size(), -1);
  for (std::size_t b = 0; b < points.blocks.size(); ++b)
    if (points.meta[b].occupied != 0xff) block_with_room_[points.meta[b].column[0]] = static_cast<int>(b);
  fresh_.assign(points.blocks.size(), 0);
  stale_ = false;
}

void UpdatedPass::start(PointStore& points, const Grid& grid, int first_body) {
  points.let_move();
  with_basis(grid.basis, [&](auto type) {
    using Type = decltype(type);
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const BlockMeta& m = points.meta[b];
      if (m.body < first_body) continue;
      const PointBlock& p = points.blocks[b];
      const Weights<Type> s(p.X, m.base, 1.0 / grid.h);
      vd v[3];
      const Mat3<vd> L = gather_value_and_gradient(grid.velocity.data(), m.column, s, v);
      for (int d = 0; d < 3; ++d) points.motion[b].v[d] = v[d];
      points.motion[b].C = affine_part<Type>(grid.velocity.data(), m.column, s, p.X, m.base, grid.h, L);
    }
  });
}

void move_to_present(PointStore& points, const Grid& grid) {
  with_basis(grid.basis, [&](auto type) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      PointBlock& p = points.blocks[b];
      const BlockMeta& m = points.meta[b];
      const Weights<decltype(type)> s(p.X, m.base, 1.0 / grid.h);
      vd u[3];
      gather_value(grid.displacement.data(), m.column, s, u);
      const vmask here = lanes(m.occupied);
      for (int d = 0; d < 3; ++d) p.X[d] += select(here, u[d], vd{});
      p.F = unit();
    }
  });
}

void UpdatedPass::project(const PointStore& points, Grid& grid, const TensorDamage& law, double density,
                          const Transfer& transfer) {
  std::fill(grid.mass.begin(), grid.mass.end(), 0.0);
  grid.momentum.assign(grid.force.size(), 0.0);
  grid.clear_force();
  const int n = static_cast<int>(points.blocks.size());
  with_basis(grid.basis, [&](auto type) {
    for (int b = 0; b < n; ++b)
      if (points.meta[b].occupied)
        give<decltype(type)>(points, b, lanes(points.meta[b].occupied), stress_of(points, b, law), grid, density, transfer);
  });
}

void UpdatedPass::advance(PointStore& points, Grid& grid, const TensorDamage& law, double density, double dt, double dt_v,
                          const Transfer& transfer, const AdvanceOptions& options, AdvanceResult& result) {
  std::fill(grid.mass.begin(), grid.mass.end(), 0.0);
  grid.momentum.assign(grid.force.size(), 0.0);
  grid.clear_force();
  moves_.clear();
  with_basis(grid.basis, [&](auto type) {
    pass<decltype(type)>(points, grid, law, density, dt, dt_v, transfer, options, result);
    relocate(points, grid, result);
    for (int b : targets_) {
      give<decltype(type)>(points, b, lanes(fresh_[b]), stress_of(points, b, law), grid, density, transfer);
      fresh_[b] = 0;
    }
  });
}

template <class Type>
void UpdatedPass::pass(PointStore& points, Grid& grid, const TensorDamage& law, double density, double dt, double dt_v,
                       const Transfer& transfer, const AdvanceOptions& options, AdvanceResult& result) {
  const double inverse_h = 1.0 / grid.h;
  const double* velocity = grid.velocity.data();
  PointStress stress_at_end(points, law, dt, options, result);
  PassClock clock(result.ticks);
  const double keep_share = transfer.method == Transfer::flip ? transfer.flip_share : 0.0;
  const int n = static_cast<int>(points.blocks.size());
  for (int b = 0; b < n; ++b) {
    BlockMeta& m = points.meta[b];
    if (!m.occupied) continue;
    clock.start(b);
    PointBlock& p = points.blocks[b];
    PointMotion& u = points.motion[b];
    const Weights<Type> s(p.X, m.base, inverse_h);
    vd v[3];
    Mat3<vd> dL = gather_value_and_gradient(velocity, m.column, s, v);
    if (transfer.method == Transfer::apic) u.C = affine_part<Type>(velocity, m.column, s, p.X, m.base, grid.h, dL);
    if (keep_share > 0.0) {
      vd a[3];
      gather_value(grid.acceleration.data(), m.column, s, a);
      for (int d = 0; d < 3; ++d) u.v[d] = keep_share * (u.v[d] + dt_v * a[d]) + (1.0 - keep_share) * v[d];
    } else {
      for (int d = 0; d < 3; ++d) u.v[d] = v[d];
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) dL.a[i][j] *= dt;
    clock.gathered();

    const Sym3<vd> strain_start = p.strain;
    if (m.failed) dL = keep(lanes(m.failed), Mat3<vd>{}, dL);
    advance_strain(unit(), dL, p.q, p.strain);
    const Sym3<vd> stress = stress_at_end(b, strain_start);
    clock.stressed();

    const vmask here = lanes(m.occupied);
    vmask staying = here;
    for (int d = 0; d < 3; ++d) {
      p.X[d] += select(here, dt * v[d], vd{});
      const vd t = p.X[d] * inverse_h - (Type::kShift + m.base[d]);
      staying &= (t >= 0.0) & (t < 1.0);
    }
    const std::uint8_t gone = static_cast<std::uint8_t>(m.occupied & ~bits(staying));
    if (gone)
      for (int l = 0; l < kLanes; ++l)
        if (gone >> l & 1) moves_.push_back({kLanes * b + l, -1});
    give<Type>(points, b, staying, stress, grid, density, transfer);
    clock.scattered();
  }
}

// Few points in a step, so this may look things up.
void UpdatedPass::relocate(PointStore& points, const Grid& grid, AdvanceResult& result) {
  targets_.clear();
  if (moves_.empty()) return;
  const double inverse_h = 1.0 / grid.h, shift = cell_shift(grid.basis);
  bool linked = false;
  for (Move& move : moves_) {
    const int from = move.from / kLanes, l = move.from % kLanes;
    int base[3], node = -1;
    bool finite = true;
    for (int d = 0; d < 3; ++d) {
      const double X = points.blocks[from].X[d][l] * inverse_h;
      finite = finite && std::fabs(X) < 1e9;
      base[d] = finite ? support_base(X, 1.0, shift) : 0;
    }
    const int body = points.meta[from].body, part = points.meta[from].part;
    if (finite) node = grid.base_node(field_of(body, part), base);
    int to = node >= 0 ? block_with_room_[node] : -1;
    if (to < 0 || points.meta[to].occupied == 0xff) {
      int column[kMostColumns];
      if (node < 0 || !grid.find_columns(field_of(body, part), base, column)) {
        lost_ = points.tags[from][l];
        move.to = move.from;
        continue;
      }
      to = points.add_block(body, part, base, grid.h, grid.basis);
      std::copy(column, column + kMostColumns, points.meta[to].column);
      fresh_.push_back(0);
      block_with_room_[node] = to;
    }
    int lane = 0;
    while (points.meta[to].occupied >> lane & 1) ++lane;
    linked = linked || (points.meta[from].linked >> l & 1);
    move.to = kLanes * to + lane;
    points.move(move.from, move.to, grid.h, grid.basis);
    block_with_room_[points.meta[from].column[0]] = from;
    if (!fresh_[to]) targets_.push_back(to);
    fresh_[to] |= static_cast<std::uint8_t>(1u << lane);
    stale_ = stale_ || !grid.well_inside(node);
  }
  const auto renamed = [&](int slot) {
    const auto it = std::lower_bound(moves_.begin(), moves_.end(), slot, [](const Move& a, int s) { return a.from < s; });
    return it != moves_.end() && it->from == slot ? it->to : slot;
  };
  if (linked)
    for (Link& k : points.links) k.slot = renamed(k.slot);
  if (!result.failed.empty()) {
    for (int& slot : result.failed) slot = renamed(slot);
    std::sort(result.failed.begin(), result.failed.end());
  }
}

}  // namespace mpdem
