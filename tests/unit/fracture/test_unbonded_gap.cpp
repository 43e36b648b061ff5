// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Cement on both sides of the plane z = 0 of a frame that may be rotated, cut by a lattice as create_cement does. Between
// the sides is no gap, or a wedge that opens from a line x = tip on.
#include "fracture/unbonded_gap.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "lanes.h"

namespace mpdem {
namespace {

using test::Vector;

constexpr double kSpacing = 0.25, kCell = 0.5;
constexpr int kSub = 6, kHalf = 14;  // of lattice cells
constexpr double kThick = 1.0, kWide = 2.4;

UnbondedGap look(std::vector<GapPoint> points, Basis basis = Basis::quadratic, const Vector& lattice = Vector::Zero(), double regular = 1) {
  BondRecord record;
  record.spacing = kSpacing;
  record.regular = regular;
  for (int d = 0; d < 3; ++d) record.lattice[d] = lattice[d];
  return find_unbonded_gap(points, record, basis, kCell);
}

// Half the width of the wedge at x.
using Opening = std::function<double(double)>;

std::vector<GapPoint> layers(const Eigen::Quaterniond& turn, const Vector& shift, const Opening& opening) {
  std::vector<GapPoint> points;
  for (int i = -kHalf; i < kHalf; ++i)
    for (int j = -kHalf; j < kHalf; ++j)
      for (int k = -kHalf; k < kHalf; ++k) {
        Vector sum(0, 0, 0);
        int count = 0;
        for (int n = 0; n < kSub * kSub * kSub; ++n) {
          const Vector at(i + (n % kSub + 0.5) / kSub, j + (n / kSub % kSub + 0.5) / kSub, k + (n / kSub / kSub + 0.5) / kSub);
          const Vector x = turn * (kSpacing * at - shift);
          const double z = std::fabs(x[2]);
          if (z > kThick || z < opening(x[0]) || std::fabs(x[0]) > kWide || std::fabs(x[1]) > kWide) continue;
          sum += kSpacing * at;
          ++count;
        }
        if (count == 0) continue;
        GapPoint p;
        const Vector X = sum / count;
        for (int d = 0; d < 3; ++d) p.X[d] = X[d];
        p.cell[0] = i;
        p.cell[1] = j;
        p.cell[2] = k;
        p.share = count / static_cast<double>(kSub * kSub * kSub);
        p.nearer_grain = (turn * (X - shift))[2] > 1e-6;
        points.push_back(p);
      }
  return points;
}

std::vector<std::pair<Eigen::Quaterniond, Vector>> placements() {
  std::vector<std::pair<Eigen::Quaterniond, Vector>> all;
  test::Random random(23);
  for (int n = 0; n < 3; ++n)
    for (double angle : {0.0, 0.4, 0.75}) {
      const Vector shift(random.uniform(-0.25, 0.25), random.uniform(-0.25, 0.25),
                         angle == 0.0 && n == 0 ? 0.0 : random.uniform(-0.25, 0.25));
      all.push_back({Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector(0.6, 0.8, 0.0))), shift});
    }
  return all;
}

TEST(UnbondedGap, NoneWhereLayersTouch) {
  for (const auto& at : placements()) {
    const auto closed = [](double) { return 0.0; };
    EXPECT_FALSE(look(layers(at.first, at.second, closed)).found);
  }
}

TEST(UnbondedGap, EndsWhereTheWedgeDoes) {
  constexpr double kTip = -0.4;
  for (double slope : {0.3, 0.6}) {
    const auto wedge = [&](double x) { return slope * std::max(0.0, x - kTip); };
    for (const auto& at : placements()) {
      const UnbondedGap c = look(layers(at.first, at.second, wedge));
      EXPECT_TRUE(c.found);
      EXPECT_TRUE(std::is_sorted(c.joined.begin(), c.joined.end()));
      // Nodes of the middle, away from the rims: a node is joined as far as about a cell beyond the tip.
      double nearest_apart = 1e9, farthest_joined = -1e9;
      for (int i = -8; i <= 8; ++i)
        for (int j = -8; j <= 8; ++j)
          for (int k = -8; k <= 8; ++k) {
            const Vector x = at.first * (kCell * Vector(i, j, k) - at.second);
            if (std::fabs(x[2]) > 0.6 * kCell || std::fabs(x[1]) > 1.2 || std::fabs(x[0]) > 1.2) continue;
            if (std::binary_search(c.joined.begin(), c.joined.end(), std::array<int, 3>{i, j, k}))
              farthest_joined = std::max(farthest_joined, x[0]);
            else nearest_apart = std::min(nearest_apart, x[0]);
          }
      EXPECT_GT(nearest_apart, kTip + 0.1 * kCell) << slope << " " << at.second.transpose();
      EXPECT_LT(nearest_apart, kTip + 2.0 * kCell);
      EXPECT_GT(farthest_joined, kTip - 0.5 * kCell);
      EXPECT_LT(farthest_joined, kTip + 1.6 * kCell) << slope << " " << at.second.transpose();
    }
  }
}

TEST(UnbondedGap, DoesNotDependOnTheOrder) {
  const auto wedge = [](double x) { return 0.4 * std::max(0.0, x); };
  for (Basis basis : {Basis::linear, Basis::quadratic, Basis::cubic}) {
    std::vector<GapPoint> points = layers(placements()[1].first, placements()[1].second, wedge);
    const UnbondedGap a = look(points, basis);
    std::reverse(points.begin(), points.end());
    const UnbondedGap b = look(points, basis);
    EXPECT_TRUE(a.found);
    EXPECT_EQ(a.joined, b.joined);
  }
}

// Points in the very middle belong to both sides of the gap alike: which of them has them does not matter.
TEST(UnbondedGap, OfPointsInTheMiddleTheSheetDoesNotMatter) {
  const auto wedge = [](double x) { return 0.4 * std::max(0.0, x); };
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(M_PI / 4.0, Vector::UnitY()));
  for (Basis basis : {Basis::linear, Basis::quadratic, Basis::cubic}) {
    std::vector<GapPoint> one = layers(turn, Vector::Zero(), wedge), other;
    for (GapPoint& p : one) p.middle = std::fabs((turn * Vector(p.X[0], p.X[1], p.X[2]))[2]) < 1e-6;
    other = one;
    for (GapPoint& p : other) p.nearer_grain = p.nearer_grain || p.middle;
    const UnbondedGap c = look(one, basis);
    EXPECT_TRUE(c.found);
    EXPECT_EQ(c.joined, look(other, basis).joined);
    EXPECT_TRUE(std::is_sorted(c.joined.begin(), c.joined.end()));
    EXPECT_EQ(std::adjacent_find(c.joined.begin(), c.joined.end()), c.joined.end());
    int middle = 0, missing = 0;
    for (const GapPoint& p : one) {
      if (!p.middle) continue;
      ++middle;
      int base[3];
      for (int d = 0; d < 3; ++d) base[d] = support_base(p.X[d], 1.0 / kCell, cell_shift(basis));
      for (int n = 0, S = support(basis); n < S * S * S; ++n)
        missing += !std::binary_search(c.joined.begin(), c.joined.end(),
                                       std::array<int, 3>{base[0] + n % S, base[1] + n / S % S, base[2] + n / S / S});
    }
    EXPECT_GT(middle, 50);
    EXPECT_EQ(missing, 0);
  }
}

// All coordinates are shifted by whole cells of the grid, and the lattice with them.
TEST(UnbondedGap, LatticeOffTheOrigin) {
  const auto wedge = [](double x) { return 0.4 * std::max(0.0, x); };
  std::vector<GapPoint> points = layers(placements()[1].first, placements()[1].second, wedge);
  const UnbondedGap a = look(points);
  const Vector lattice(2 * kCell, -kCell, 3 * kCell);
  for (GapPoint& p : points)
    for (int d = 0; d < 3; ++d) p.X[d] += lattice[d];
  UnbondedGap b = look(points, Basis::quadratic, lattice);
  for (auto& n : b.joined)
    for (int d = 0; d < 3; ++d) n[d] -= static_cast<int>(lattice[d] / kCell);
  EXPECT_TRUE(a.found);
  EXPECT_EQ(a.joined, b.joined);
}

// Points anywhere in their cells, as files may have them, do not cut a bond.
TEST(UnbondedGap, PointsThatAreNoLattice) {
  const auto wedge = [](double x) { return 0.4 * std::max(0.0, x); };
  std::vector<GapPoint> points = layers(placements()[1].first, placements()[1].second, wedge);
  const std::size_t joined = look(points, Basis::quadratic, Vector::Zero(), 0).joined.size();
  EXPECT_GT(joined, look(points).joined.size());
  for (GapPoint& p : points)
    for (int d = 0; d < 3; ++d) p.X[d] += 0.3 * kSpacing;
  EXPECT_EQ(look(points, Basis::quadratic, Vector::Zero(), 0).joined.size(), joined);
  // every other plane of cells empty, since the spacing is not that of the points: no gap
  for (GapPoint& p : points)
    for (int d = 0; d < 3; ++d) p.cell[d] *= 2;
  EXPECT_FALSE(look(points).found);
}

TEST(UnbondedGap, OfNothing) { EXPECT_FALSE(look({}).found); }

}  // namespace
}  // namespace mpdem
