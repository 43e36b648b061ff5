// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "closing_points.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "../material/corotational.h"
#include "../material/laws.h"
#include "gather.h"
#include "point_state.h"
#include "scatter.h"

namespace mpdem {

namespace {
// Debris may turn inside out. A point has no crack any more if its volume ratio is outside these bounds.
constexpr double kLeastVolume = 0.2, kMostVolume = 5.0;

// lambda_0 of a point with the crack normal n0. along: n n in the frame of the material.
double width_when_closed(const PointStore& points, int slot, const std::array<double, 3>& n0, const Sym3<double>& along, double K) {
  const int block = slot / kLanes, l = slot % kLanes;
  const Mat3<vd> back = mpdem::inverse(points.blocks[block].F);
  double square = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double across = back.a[0][i][l] * n0[0] + back.a[1][i][l] * n0[1] + back.a[2][i][l] * n0[2];
    square += across * across;
  }
  const double width = 1.0 / std::sqrt(square);
  const Sym3<vd> stress = with_law(*points.law(), [&](const auto& law) -> Sym3<vd> {
    return law.stress(points.blocks[block].strain, state_of<std::decay_t<decltype(law)>>(points, block));
  });
  const double pressed = -contract(along, Sym3<double>{stress.xx[l], stress.yy[l], stress.zz[l], stress.yz[l], stress.xz[l], stress.xy[l]});
  return std::min(1.0, width) + std::max(pressed, 0.0) / (K * width);
}

}  // namespace

ClosingPoints::ClosingPoints(const PointStore& points, const VtiElasticity& undamaged) {
  std::vector<int> failed;
  for (std::size_t b = 0; b < points.meta.size(); ++b)
    for (int l = 0; l < kLanes; ++l)
      if (points.meta[b].failed >> l & 1) failed.push_back(kLanes * static_cast<int>(b) + l);
  add(points, undamaged, failed);
}

void ClosingPoints::add(const PointStore& points, const VtiElasticity& undamaged, const std::vector<int>& failed) {
  for (int slot : failed) set(points, undamaged, slot);
}

void ClosingPoints::set(const PointStore& points, const VtiElasticity& undamaged, int slot) {
  const int block = slot / kLanes, l = slot % kLanes;
  const CrackOfPoint crack = crack_of(points, slot);
  if (!(crack.damage[0] > 0.0)) return;
  auto at = std::lower_bound(blocks_.begin(), blocks_.end(), block, [](const Block& b, int n) { return b.block < n; });
  if (at == blocks_.end() || at->block != block) at = blocks_.insert(at, Block{block, {}, {}, {}});
  const PointBlock& p = points.blocks[block];
  const Mat3<vd> Q = rotation_matrix(p.q);
  double n0[3], n[3], size = 0.0;  // n: in the frame of the material
  for (int i = 0; i < 3; ++i) {
    n0[i] = n[i] = 0.0;
    for (int j = 0; j < 3; ++j) {
      n0[i] += p.F.a[j][i][l] * crack.normal[j];
      n[i] += Q.a[j][i][l] * crack.normal[j];
    }
    size += n0[i] * n0[i];
  }
  for (int i = 0; i < 3; ++i) at->n0[i][l] = n0[i] / std::sqrt(size);
  const Sym3<double> along{n[0] * n[0], n[1] * n[1], n[2] * n[2], n[1] * n[2], n[0] * n[2], n[0] * n[1]};
  at->K[l] = contract(along, undamaged.stress(along));
  at->lambda_0[l] = width_when_closed(points, slot, {at->n0[0][l], at->n0[1][l], at->n0[2][l]}, along, at->K[l]);
}

template <class F>
void ClosingPoints::for_each_closed(const PointStore& points, const Grid& grid, F f) const {
  with_basis(grid.basis, [&](auto type) {
    for (const Block& b : blocks_) {
      const PointBlock& p = points.blocks[b.block];
      const BlockMeta& m = points.meta[b.block];
      with_weights<decltype(type)>(p, m, 1.0 / grid.h, [&](const auto& w) {
        Mat3<vd> D = gather_gradient(grid.displacement.data(), m.column, w);
        for (int i = 0; i < 3; ++i) D.a[i][i] += 1.0;
        const Mat3<vd> cof = cofactor(D);
        const vd J = D.a[0][0] * cof.a[0][0] + D.a[0][1] * cof.a[0][1] + D.a[0][2] * cof.a[0][2];
        const vmask sound = (J > kLeastVolume) & (J < kMostVolume) & (b.K > 0.0);
        if (!any(sound)) return;
        const vd inverse = 1.0 / select(sound, J, splat(1.0));
        vd across[3], back[3], square{};
        for (int i = 0; i < 3; ++i) {
          across[i] = inverse * (cof.a[i][0] * b.n0[0] + cof.a[i][1] * b.n0[1] + cof.a[i][2] * b.n0[2]);
          square += across[i] * across[i];
        }
        const vd lambda = 1.0 / sqrt(select(sound, square, splat(1.0)));
        const vmask closed = sound & (lambda < b.lambda_0);
        if (!any(closed)) return;
        for (int j = 0; j < 3; ++j) back[j] = inverse * (cof.a[0][j] * across[0] + cof.a[1][j] * across[1] + cof.a[2][j] * across[2]);
        f(b, w, select(closed, lambda - b.lambda_0, vd{}), lambda, across, back);
      });
    }
  });
}

Mat3<vd> ClosingPoints::weighted_piola(const PointStore& points, const Block& b, vd width, vd lambda, const vd* across, const vd* back) {
  const vd k = -points.blocks[b.block].volume * b.K * width * lambda * lambda * lambda;
  Mat3<vd> T;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) T.a[i][j] = k * across[i] * back[j];
  return T;
}

void ClosingPoints::add_force(const PointStore& points, Grid& grid) const {
  for_each_closed(points, grid, [&](const Block& b, const auto& w, vd width, vd lambda, const vd* across, const vd* back) {
    scatter_gradient(grid.force.data(), points.meta[b.block].column, w, weighted_piola(points, b, width, lambda, across, back));
  });
}

double ClosingPoints::energy_at_beginning(const PointStore& points, const Grid& grid, const std::vector<int>& failed, double dt) const {
  double sum = 0.0;
  for_each_closed(points, grid, [&](const Block& b, const auto& w, vd width, vd lambda, const vd* across, const vd* back) {
    std::uint8_t began = 0;
    for (auto slot = std::lower_bound(failed.begin(), failed.end(), kLanes * b.block); slot != failed.end() && *slot / kLanes == b.block; ++slot)
      began |= static_cast<std::uint8_t>(1u << *slot % kLanes);
    if (!began) return;
    const Mat3<vd> T = weighted_piola(points, b, width, lambda, across, back), rate = gather_gradient(grid.velocity.data(), points.meta[b.block].column, w);
    vd energy = 0.5 * points.blocks[b.block].volume * b.K * width * width;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) energy += 0.5 * dt * T.a[i][j] * rate.a[i][j];
    sum += sum_lanes(select(lanes(began), energy, vd{}));
  });
  return sum;
}

double ClosingPoints::energy(const PointStore& points, const Grid& grid) const {
  double sum = 0.0;
  for_each_closed(points, grid, [&](const Block& b, const auto&, vd width, vd, const vd*, const vd*) {
    sum += sum_lanes(0.5 * points.blocks[b.block].volume * b.K * width * width);
  });
  return sum;
}

}  // namespace mpdem
