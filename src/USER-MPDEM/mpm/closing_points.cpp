// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "closing_points.h"

#include <algorithm>
#include <cmath>

#include "../material/corotational.h"
#include "../material/coulomb.h"
#include "../material/laws.h"
#include "gather.h"
#include "material_runs.h"
#include "point_state.h"
#include "scatter.h"

namespace mpdem {

namespace {
// Limits that bound the stiffness that pressure adds. kMostDistorted: of |F| and |F^-1|, which are 3^(1/2) undeformed.
constexpr double kMostDistorted = 4.0;
constexpr double kMostPressed = 0.1;  // largest pressure, over K

// Finds lambda_0 of points with the crack normals n0. along: n n, with the normal n of the present crack in the material frame.
vd width_when_closed(const PointStore& points, int block, const vd* n0, const Sym3<vd>& along, vd K) {
  const Mat3<vd> back = mpdem::inverse(points.blocks[block].F);
  vd square{};
  for (int i = 0; i < 3; ++i) {
    const vd across = back.a[0][i] * n0[0] + back.a[1][i] * n0[1] + back.a[2][i] * n0[2];
    square += across * across;
  }
  const vd width = 1.0 / sqrt(square);
  const Sym3<vd> stress = with_law(law_of_block(points, *points.law(), block), [&](const auto& law) -> Sym3<vd> {
    return law.stress(points.blocks[block].strain, state_of<std::decay_t<decltype(law)>>(points, block));
  });
  return min(splat(1.0), width) + max(-contract(along, stress), vd{}) / (K * width);
}

}  // namespace

ClosingPoints::ClosingPoints(const PointStore& points, const VtiElasticity& undamaged, double friction)
    : undamaged_(&undamaged), friction_(std::max(friction, 0.0)), G_(undamaged.softest_shear()) {
  for (std::size_t b = 0; b < points.meta.size(); ++b) set(points, undamaged, static_cast<int>(b), points.meta[b].failed, 0);
}

void ClosingPoints::add(const PointStore& points, const VtiElasticity& undamaged, const std::vector<int>& failed) {
  for (auto slot = failed.begin(); slot != failed.end();) {
    const int block = *slot / kLanes;
    std::uint8_t fresh = 0;
    for (; slot != failed.end() && *slot / kLanes == block; ++slot) fresh |= static_cast<std::uint8_t>(1u << *slot % kLanes);
    set(points, undamaged, block, fresh, fresh);
  }
}

void ClosingPoints::set(const PointStore& points, const VtiElasticity& undamaged, int block, std::uint8_t failed, std::uint8_t fresh) {
  failed &= static_cast<std::uint8_t>(~points.meta[block].distorted);
  if (!failed) return;
  const CracksOfBlock cracks = cracks_of(points, block);
  const vmask taken = lanes(failed) & (cracks.damage[0] > 0.0);
  if (!any(taken)) return;
  auto at = std::lower_bound(blocks_.begin(), blocks_.end(), block, [](const Block& b, int n) { return b.block < n; });
  if (at == blocks_.end() || at->block != block) at = blocks_.insert(at, Block{block, {}, {}, {}, {}, 0, friction_ > 0.0});
  const PointBlock& p = points.blocks[block];
  const Mat3<vd> Q = rotation_matrix(p.q);
  vd n0[3], n[3];  // n: in the material frame
  for (int i = 0; i < 3; ++i) {
    n0[i] = p.F.a[0][i] * cracks.normal[0] + p.F.a[1][i] * cracks.normal[1] + p.F.a[2][i] * cracks.normal[2];
    n[i] = Q.a[0][i] * cracks.normal[0] + Q.a[1][i] * cracks.normal[1] + Q.a[2][i] * cracks.normal[2];
  }
  const vd inverse = 1.0 / sqrt(n0[0] * n0[0] + n0[1] * n0[1] + n0[2] * n0[2]);
  for (vd& x : n0) x *= inverse;
  const Sym3<vd> along{n[0] * n[0], n[1] * n[1], n[2] * n[2], n[1] * n[2], n[0] * n[2], n[0] * n[1]};
  const vd K = contract(along, undamaged.stress(along));
  for (int i = 0; i < 3; ++i) at->n0[i] = select(taken, n0[i], at->n0[i]);
  at->K = select(taken, K, at->K);
  at->lambda_0 = select(taken, width_when_closed(points, block, n0, along, K), at->lambda_0);
  at->fresh |= fresh;
  if (friction_ <= 0.0) return;
  const Crack failing = crack_of_block(*at, p.F);
  for (int i = 0; i < 3; ++i) at->gamma_f[i] = select(taken, at->n0[i] - failing.lambda * failing.lambda * failing.back[i], at->gamma_f[i]);
}

ClosingPoints::Crack ClosingPoints::crack_of_block(const Block& b, const Mat3<vd>& F) {
  Crack c;
  const Mat3<vd> cof = cofactor(F);
  const vd J = F.a[0][0] * cof.a[0][0] + F.a[0][1] * cof.a[0][1] + F.a[0][2] * cof.a[0][2];
  vd of_F{}, of_cof{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      of_F += F.a[i][j] * F.a[i][j];
      of_cof += cof.a[i][j] * cof.a[i][j];
    }
  constexpr double kMostSquare = kMostDistorted * kMostDistorted;
  c.undistorted = (J > 0.0) & (of_F < kMostSquare) & (of_cof < kMostSquare * J * J) & (b.K > 0.0);
  const vd inverse = 1.0 / select(c.undistorted, J, splat(1.0));
  vd square{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) c.inverse_transposed.a[i][j] = inverse * cof.a[i][j];
    c.across[i] = c.inverse_transposed.a[i][0] * b.n0[0] + c.inverse_transposed.a[i][1] * b.n0[1] + c.inverse_transposed.a[i][2] * b.n0[2];
    square += c.across[i] * c.across[i];
  }
  c.lambda = 1.0 / sqrt(select(c.undistorted, square, splat(1.0)));
  c.closed = c.undistorted & (c.lambda < b.lambda_0);
  c.overlap = select(c.closed, b.lambda_0 - c.lambda, vd{});
  for (int j = 0; j < 3; ++j)
    c.back[j] = c.inverse_transposed.a[0][j] * c.across[0] + c.inverse_transposed.a[1][j] * c.across[1] +
                c.inverse_transposed.a[2][j] * c.across[2];
  return c;
}

template <class Blocks, class F>
void ClosingPoints::for_each_block(Blocks& blocks, const PointStore& points, const Grid& grid, F f) {
  with_basis(grid.basis, [&](auto type) {
    for (auto& b : blocks) {
      const BlockMeta& m = points.meta[b.block];
      with_weights<decltype(type)>(points.blocks[b.block], m, 1.0 / grid.h, [&](const auto& w) {
        Mat3<vd> D = gather_gradient(grid.displacement.data(), m.column, w);
        for (int i = 0; i < 3; ++i) D.a[i][i] += 1.0;
        const Crack c = crack_of_block(b, D);
        if (b.carried_shear || any(c.closed | (~c.undistorted & (b.K > 0.0)))) f(b, w, c, D);
      });
    }
  });
}

vd ClosingPoints::pressure(const Block& b, const Crack& c) { return b.K * min(c.overlap, splat(kMostPressed)); }

ClosingPoints::Shear ClosingPoints::shear_of(const PointStore& points, const Block& b, const Crack& c, vmask bear) const {
  Shear s{};
  if (friction_ <= 0.0) return s;
  vd slope{};  // e.gamma
  for (int i = 0; i < 3; ++i) {
    const vd gamma = b.n0[i] - c.lambda * c.lambda * c.back[i];
    const vd slip = points.slip.empty() ? vd{} : points.slip[b.block].at[i];
    s.e[i] = select(bear, gamma - b.gamma_f[i] - slip, vd{});
    slope += s.e[i] * gamma;
  }
  // g/G = F^-T e without its component along n = lambda F^-T n0, which is -e.gamma/lambda.
  const Mat3<vd>& m = c.inverse_transposed;
  for (int i = 0; i < 3; ++i) s.traction[i] = m.a[i][0] * s.e[0] + m.a[i][1] * s.e[1] + m.a[i][2] * s.e[2] + slope * c.across[i];
  return s;
}

vd ClosingPoints::energy_of(const PointStore& points, const Block& b, const Crack& c) const {
  const vd bounded = min(c.overlap, splat(kMostPressed)), volume = points.blocks[b.block].volume;
  const Shear s = shear_of(points, b, c, c.closed);
  return volume * (b.K * bounded * (c.overlap - 0.5 * bounded) + 0.5 * G_ * (s.e[0] * s.e[0] + s.e[1] * s.e[1] + s.e[2] * s.e[2]));
}

Mat3<vd> ClosingPoints::weighted_piola(const PointStore& points, const Block& b, const Crack& c, const Shear& shear) const {
  const vd volume = points.blocks[b.block].volume, k = volume * pressure(b, c) * c.lambda * c.lambda * c.lambda;
  const vd G = G_ * volume * c.lambda * c.lambda;  // lambda of tau_e, and that of n = lambda F^-T n0
  const Mat3<vd>& m = c.inverse_transposed;
  Mat3<vd> T;
  for (int j = 0; j < 3; ++j) {
    const vd traction = m.a[0][j] * shear.traction[0] + m.a[1][j] * shear.traction[1] + m.a[2][j] * shear.traction[2];
    for (int i = 0; i < 3; ++i) T.a[i][j] = k * c.across[i] * c.back[j] - G * (shear.traction[i] * c.back[j] + c.across[i] * traction);
  }
  return T;
}

double ClosingPoints::slide(PointStore& points, const Block& b, const Crack& before, const Crack& now, Shear& shear) const {
  const vmask old = ~lanes(b.fresh), was_closed = before.closed & old;  // the shear of points that failed in this step begins at 0
  const Shear first = shear_of(points, b, before, was_closed);
  const vmask closes = now.closed & ~before.closed & old;
  if (any(closes)) {
    points.start_slip();
    for (int i = 0; i < 3; ++i) {
      vd& slip = points.slip[b.block].at[i];
      slip = select(closes, b.n0[i] - before.lambda * before.lambda * before.back[i] - b.gamma_f[i], slip);
    }
  }
  // A crack that opens slides until it has no shear.
  shear = shear_of(points, b, now, now.closed | (now.undistorted & was_closed));
  const vd size =
      G_ * sqrt(shear.traction[0] * shear.traction[0] + shear.traction[1] * shear.traction[1] + shear.traction[2] * shear.traction[2]);
  const vd most = friction_ * pressure(b, now);
  const vd share = sliding_share(most, size);
  if (!any(share > 0.0)) return 0.0;
  points.start_slip();
  vd taken{};
  for (int i = 0; i < 3; ++i) {
    const vd slip = share * shear.e[i];
    shear.e[i] -= slip;
    shear.traction[i] *= 1.0 - share;
    taken += 0.5 * G_ * (first.e[i] + shear.e[i]) * slip;
    points.slip[b.block].at[i] += slip;
  }
  return sum_lanes(points.blocks[b.block].volume * taken);
}

Losses ClosingPoints::add_force(PointStore& points, Grid& grid, double dt) {
  Losses losses;
  for_each_block(blocks_, points, grid, [&](Block& b, const auto& w, const Crack& c, const Mat3<vd>& F) {
    const int* column = points.meta[b.block].column;
    const vmask lost = ~c.undistorted & (b.K > 0.0);
    Shear shear{};
    if (dt > 0.0 && (friction_ > 0.0 || any(lost))) {
      const Mat3<vd> rate = gather_gradient(grid.velocity.data(), column, w);
      Mat3<vd> F_before = F;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) F_before.a[i][j] -= dt * rate.a[i][j];
      const Crack before = crack_of_block(b, F_before);
      if (any(lost)) losses.released += lose(points, b, before, rate, lost, dt);
      if (friction_ > 0.0) losses.frictional += slide(points, b, before, c, shear);
    } else {
      shear = shear_of(points, b, c, c.closed);
    }
    b.carried_shear = friction_ > 0.0 && any(c.closed);
    if (any(c.closed)) scatter_gradient(grid.force.data(), column, w, weighted_piola(points, b, c, shear));
  });
  for (Block& b : blocks_) b.fresh = 0;
  return losses;
}

double ClosingPoints::lose(PointStore& points, Block& b, const Crack& before, const Mat3<vd>& rate, vmask lost, double dt) const {
  const Mat3<vd> T = weighted_piola(points, b, before, shear_of(points, b, before, before.closed));
  vd energy = energy_of(points, b, before);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) energy -= 0.5 * dt * T.a[i][j] * rate.a[i][j];
  points.meta[b.block].distorted |= bits(lost);
  b.K = select(lost, vd{}, b.K);
  return sum_lanes(select(lost, energy, vd{}));
}

double ClosingPoints::energy_at_beginning(const PointStore& points, const Grid& grid, const std::vector<int>& failed, double dt) const {
  double sum = 0.0;
  for_each_block(blocks_, points, grid, [&](const Block& b, const auto& w, const Crack& c, const Mat3<vd>&) {
    std::uint8_t began = 0;
    for (auto slot = std::lower_bound(failed.begin(), failed.end(), kLanes * b.block); slot != failed.end() && *slot / kLanes == b.block;
         ++slot)
      began |= static_cast<std::uint8_t>(1u << *slot % kLanes);
    if (!began) return;
    const Mat3<vd> T = weighted_piola(points, b, c, shear_of(points, b, c, c.closed)),
                   rate = gather_gradient(grid.velocity.data(), points.meta[b.block].column, w);
    vd energy = energy_of(points, b, c);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) energy += 0.5 * dt * T.a[i][j] * rate.a[i][j];
    sum += sum_lanes(select(lanes(began), energy, vd{}));
  });
  return sum;
}

double ClosingPoints::energy(const PointStore& points, const Grid& grid) const {
  double sum = 0.0;
  for_each_block(blocks_, points, grid,
                 [&](const Block& b, const auto&, const Crack& c, const Mat3<vd>&) { sum += sum_lanes(energy_of(points, b, c)); });
  return sum;
}

void ClosingPoints::points_failed(const BondContext& b, const std::vector<int>& slots, const std::vector<int>&, Losses& losses) {
  add(b.points, *undamaged_, slots);
  losses.released -= energy_at_beginning(b.points, b.grid, slots, b.dt);
}

void ClosingPoints::add_force(const BondContext& b, Losses& losses) {
  const Losses of_step = add_force(b.points, b.grid, b.dt);
  losses.released += of_step.released;
  losses.frictional += of_step.frictional;
}

void ClosingPoints::add_energy(const PointStore& points, const Grid& grid, const BondEnd*, double& of_points, double&) const {
  of_points += energy(points, grid);
}

}  // namespace mpdem
