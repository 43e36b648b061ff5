// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "advance_updated.h"

#include <algorithm>

#include "../material/laws.h"
#include "gather.h"
#include "material_runs.h"
#include "point_stress.h"
#include "scatter.h"

namespace mpdem {

namespace {

const Mat3<vd>& unit() {
  static const Mat3<vd> one{{{splat(1), splat(0), splat(0)}, {splat(0), splat(1), splat(0)}, {splat(0), splat(0), splat(1)}}};
  return one;
}

// APIC affine velocity matrix C of the points of a block. `gradient` is the velocity gradient there.
template <class Type, int Joined>
Mat3<vd> affine_part(const double* velocity, const int* column, const Weights<Type, Joined>& s, const vd* X, const int* base, double h,
                     const Mat3<vd>& gradient) {
  if constexpr (Type::kAffine == 0.0) return gradient;  // both are equal for linear hat functions
  Mat3<vd> C = gather_gradient(velocity, column, with_moments(s, X, base, h));
  const double scale = Type::kAffine / (h * h);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) C.a[i][j] *= scale;
  return C;
}

// Scatters mass, momentum and internal force of the lanes `which` of block b to the nodes, with the weights s.
template <class W>
void give(const PointStore& points, int b, const W& s, vmask which, const Sym3<vd>& stress, Grid& grid, const CementDensity& density,
          const Transfer& transfer) {
  const PointBlock& p = points.blocks[b];
  const BlockMeta& m = points.meta[b];
  const PointMotion& u = points.motion[b];
  const vd volume = select(which, p.volume, vd{});
  const vd mass = density.of(m.material) * volume;
  scatter_scalar(grid.mass.own().data(), m.column, s, mass);
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

// Weights of a block at the present positions of its points.
template <class Type>
Weights<Type> weights_of(const PointStore& points, int b, const Grid& grid) {
  return Weights<Type>(points.blocks[b].X, points.meta[b].base, 1.0 / grid.h);
}

}  // namespace

void UpdatedPass::bind(const PointStore& points, const Grid& grid) {
  first_in_cell_.assign(grid.size(), -1);
  next_in_cell_.resize(points.blocks.size());
  for (int b = static_cast<int>(points.blocks.size()) - 1; b >= 0; --b) {
    int& first = first_in_cell_[points.meta[b].column[0]];
    next_in_cell_[b] = first;
    first = b;
  }
  fresh_.assign(points.blocks.size(), 0);
  stale_ = false;
}

void UpdatedPass::start(PointStore& points, const Grid& grid, int first_row) {
  points.start_motion();
  with_basis(grid.basis, [&](auto type) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const BlockMeta& m = points.meta[b];
      if (m.row < first_row) continue;
      const PointBlock& p = points.blocks[b];
      with_weights<decltype(type)>(p, m, 1.0 / grid.h, [&](const auto& s) {
        vd v[3];
        const Mat3<vd> L = gather_value_and_gradient(grid.velocity.data(), m.column, s, v);
        for (int d = 0; d < 3; ++d) points.motion[b].v[d] = v[d];
        points.motion[b].C = affine_part(grid.velocity.data(), m.column, s, p.X, m.base, grid.h, L);
      });
    }
  });
}

void move_to_present(PointStore& points, const Grid& grid) {
  with_basis(grid.basis, [&](auto type) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      PointBlock& p = points.blocks[b];
      const BlockMeta& m = points.meta[b];
      vd u[3];
      with_weights<decltype(type)>(p, m, 1.0 / grid.h, [&](const auto& s) { gather_value(grid.displacement.data(), m.column, s, u); });
      const vmask here = lanes(m.occupied);
      for (int d = 0; d < 3; ++d) p.X[d] += select(here, u[d], vd{});
      p.F = unit();
    }
  });
}

void UpdatedPass::project(const PointStore& points, Grid& grid, const Law& law, const CementDensity& density, const Transfer& transfer) {
  std::fill(grid.mass.own().begin(), grid.mass.own().end(), 0.0);
  grid.momentum.assign(grid.force.size(), 0.0);
  grid.clear_force();
  const int n = static_cast<int>(points.blocks.size());
  with_law(law_of_bond(points, law), [&](const auto& l) {
    with_basis(grid.basis, [&](auto type) {
      for (int b = 0; b < n; ++b)
        if (points.meta[b].occupied)
          with_weights<decltype(type)>(points.blocks[b], points.meta[b], 1.0 / grid.h, [&](const auto& s) {
            give(points, b, s, lanes(points.meta[b].occupied), stress_of(points, b, l), grid, density, transfer);
          });
    });
  });
}

void UpdatedPass::advance(PointStore& points, Grid& grid, const Law& law, const CementDensity& density, double dt, double dt_v,
                          const Transfer& transfer, const AdvanceOptions& options, AdvanceResult& result) {
  std::fill(grid.mass.own().begin(), grid.mass.own().end(), 0.0);
  grid.momentum.assign(grid.force.size(), 0.0);
  grid.clear_force();
  moves_.clear();
  with_law(law_of_bond(points, law), [&](const auto& l) {
    with_basis(grid.basis, [&](auto type) {
      pass<decltype(type)>(points, grid, l, density, dt, dt_v, transfer, options, result);
      relocate(points, grid, result);
      for (int b : targets_) {
        give(points, b, weights_of<decltype(type)>(points, b, grid), lanes(fresh_[b]), stress_of(points, b, l), grid, density, transfer);
        fresh_[b] = 0;
      }
    });
  });
}

template <class Type, class L>
void UpdatedPass::pass(PointStore& points, Grid& grid, const L& law, const CementDensity& density, double dt, double dt_v,
                       const Transfer& transfer, const AdvanceOptions& options, AdvanceResult& result) {
  const double inverse_h = 1.0 / grid.h;
  const double* velocity = grid.velocity.data();
  PointStress<L> stress_at_end(points, law, dt, options, grid.drive_limit, result);
  PassClock clock(result.ticks);
  // Lanes that stayed in their cell, for each block whose stress is deferred (point_stress.h). These blocks scatter in settle().
  std::uint8_t stayed[PointStress<L>::kMost];
  int waiting = 0, given = 0;
  const auto scatter_deferred = [&](int b, const Sym3<vd>& stress) {
    give(points, b, weights_of<Type>(points, b, grid), lanes(stayed[given++]), stress, grid, density, transfer);
  };
  const auto settle = [&] {
    given = 0;
    stress_at_end.flush(clock, scatter_deferred);
    waiting = 0;
  };
  const double keep_share = transfer.method == Transfer::flip ? transfer.flip_share : 0.0;
  const int n = static_cast<int>(points.blocks.size());
  for (int b = 0; b < n; ++b) {
    BlockMeta& m = points.meta[b];
    if (!m.occupied) continue;
    clock.start();
    PointBlock& p = points.blocks[b];
    PointMotion& u = points.motion[b];
    const Weights<Type> s(p.X, m.base, inverse_h);
    vd v[3];
    Mat3<vd> dL = gather_value_and_gradient(velocity, m.column, s, v);
    if (transfer.method == Transfer::apic) u.C = affine_part(velocity, m.column, s, p.X, m.base, grid.h, dL);
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
    if (m.failed) dL = blend(lanes(m.failed), Mat3<vd>{}, dL);
    advance_strain(unit(), dL, p.q, p.strain);
    Sym3<vd> stress;
    const bool known = stress_at_end(
        b, strain_start, [&] { return average_at(grid, m, s); }, stress);
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
    if (known) {
      give(points, b, weights_of<Type>(points, b, grid), staying, stress, grid, density, transfer);
    } else {
      stayed[waiting++] = bits(staying);
      if (stress_at_end.full()) settle();
    }
    clock.scattered();
  }
  settle();
}

// If the points of a cell fit into one block less, moves those of the emptiest block to the others. `node` is the first node of the
// cell. Returns true if points with links moved.
bool UpdatedPass::pack(PointStore& points, const Grid& grid, int node) {
  int in_cell = 0, blocks = 0, least = -1;
  for (int b = first_in_cell_[node]; b >= 0; b = next_in_cell_[b]) {
    const int n = __builtin_popcount(points.meta[b].occupied);
    if (n == 0) continue;
    in_cell += n;
    ++blocks;
    if (least < 0 || n < __builtin_popcount(points.meta[least].occupied)) least = b;
  }
  if (blocks < 2 || in_cell > kLanes * (blocks - 1)) return false;
  const bool linked = points.meta[least].linked;
  int to = first_in_cell_[node];
  for (int l = 0; l < kLanes; ++l) {
    if (!(points.meta[least].occupied >> l & 1)) continue;
    while (to == least || points.meta[to].occupied == 0xff || points.meta[to].occupied == 0) to = next_in_cell_[to];
    int lane = 0;
    while (points.meta[to].occupied >> lane & 1) ++lane;
    const Move m{kLanes * least + l, kLanes * to + lane};
    points.take(points, m.from, m.to);
    points.empty_lane(m.from, grid.h, grid.basis);
    // A point may move twice: a block that received points in an earlier call may be the emptiest now.
    const auto earlier = std::find_if(packed_.begin(), packed_.end(), [&](const Move& p) { return p.to == m.from; });
    if (earlier != packed_.end()) earlier->to = m.to;
    else packed_.push_back(m);
  }
  return linked;
}

// Moves points that left their cell to blocks of the new cell. Few points do so in a step, so searches are cheap. All
// points leave before the first one arrives. So arriving points take the lanes of leaving ones, and blocks stay full.
void UpdatedPass::relocate(PointStore& points, const Grid& grid, AdvanceResult& result) {
  targets_.clear();
  crossings_ = static_cast<int>(moves_.size());
  if (moves_.empty()) return;
  const double inverse_h = 1.0 / grid.h, shift = cell_shift(grid.basis);
  bool linked = false;
  in_transit_.resize(moves_.size());
  hold_.clear();
  const int nowhere[3] = {0, 0, 0};
  for (std::size_t i = 0; i < moves_.size(); i += kLanes) hold_.add_block(0, 0, nowhere, grid.h, grid.basis);
  hold_.start_motion();
  for (std::size_t i = 0; i < moves_.size(); ++i) {
    const int from = moves_[i].from / kLanes, l = moves_[i].from % kLanes, row = points.meta[from].row, layer = points.meta[from].layer;
    MovingPoint& t = in_transit_[i];
    t.node = -1;
    bool finite = true;
    for (int d = 0; d < 3; ++d) {
      const double X = points.blocks[from].X[d][l] * inverse_h;
      finite = finite && std::fabs(X) < 1e9;
      t.base[d] = finite ? support_base(X, 1.0, shift) : 0;
    }
    if (finite) t.node = grid.base_node(field_of(row, layer), t.base);
    if (t.node < 0 || !grid.find_columns(field_of(row, layer), t.base, t.column)) {
      t.node = -1;
      lost_ = points.tags[from][l];
      moves_[i].to = moves_[i].from;
      continue;
    }
    hold_.take(points, moves_[i].from, static_cast<int>(i));
    linked = linked || (points.meta[from].linked >> l & 1);
    points.empty_lane(moves_[i].from, grid.h, grid.basis);
  }
  packed_.clear();
  for (const Move& m : moves_)
    if (m.to < 0) linked = pack(points, grid, points.meta[m.from / kLanes].column[0]) || linked;
  for (std::size_t i = 0; i < moves_.size(); ++i) {
    const MovingPoint& t = in_transit_[i];
    if (t.node < 0) continue;
    int to = first_in_cell_[t.node];
    while (to >= 0 && points.meta[to].occupied == 0xff) to = next_in_cell_[to];
    if (to < 0) {
      const BlockMeta& m = points.meta[moves_[i].from / kLanes];
      to = points.add_block(m.row, m.layer, t.base, grid.h, grid.basis);
      points.meta[to].material = points.meta[moves_[i].from / kLanes].material;
      std::copy(t.column, t.column + kMostColumns, points.meta[to].column);
      fresh_.push_back(0);
      next_in_cell_.push_back(first_in_cell_[t.node]);
      first_in_cell_[t.node] = to;
    }
    int lane = 0;
    while (points.meta[to].occupied >> lane & 1) ++lane;
    moves_[i].to = kLanes * to + lane;
    points.take(hold_, static_cast<int>(i), moves_[i].to);
    if (!fresh_[to]) targets_.push_back(to);
    fresh_[to] |= static_cast<std::uint8_t>(1u << lane);
    stale_ = stale_ || !grid.well_inside(t.node);
  }
  if (!packed_.empty()) {
    moves_.insert(moves_.end(), packed_.begin(), packed_.end());
    std::sort(moves_.begin(), moves_.end(), [](const Move& a, const Move& b) { return a.from < b.from; });
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
