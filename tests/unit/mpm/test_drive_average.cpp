// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mpm/drive_average.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "cement.h"
#include "mpm/advance_points.h"
#include "mpm/field_drive.h"
#include "mpm/strain_norm.h"

namespace mpdem {
namespace {

using test::Cement;
using test::kCell;
using test::Vector;

const TensorDamage kLaw = test::law_of(1.0);

// Strain along the axis of the material at each point, so that the root of its norm is `root(b, l)`.
template <class F>
void set_roots(Cement& c, F root) {
  for (std::size_t b = 0; b < c.points.blocks.size(); ++b) {
    Sym3<vd> unit{};
    unit.zz = splat(1.0);
    const vd of_unit = root_of_norm(kLaw, unit);
    c.points.blocks[b].strain = Sym3<vd>{};
    for (int l = 0; l < kLanes; ++l) c.points.blocks[b].strain.zz[l] = std::pow(root(static_cast<int>(b), l) / of_unit[l], 2);
  }
}

BondRecord equal_grains() {
  BondRecord record;
  record.spacing = kCell / 2;
  for (int side = 0; side < 2; ++side) {
    record.radius[side] = 50 * kCell;
    record.centre[side][2] = (side == 0 ? -1 : 1) * 51 * kCell;  // a gap of two cells about z = 0
  }
  return record;
}

BondRecord swapped(const BondRecord& record) {
  BondRecord other = record;
  for (int side = 0; side < 2; ++side) {
    other.radius[side] = record.radius[1 - side];
    std::copy_n(record.centre[1 - side], 3, other.centre[side]);
  }
  return other;
}

void average(Cement& c, const SmoothingPasses& s, const Imperfection& imperfection = {}) {
  DriveAverage average;
  average.find(c.points, c.grid, kLaw, s, imperfection);
}

double average_of(const Cement& c, int b, int l) {
  double f = 0.0;
  with_basis(c.grid.basis, [&](auto type) {
    with_weights<decltype(type)>(c.points.blocks[b], c.points.meta[b], 1.0 / c.grid.h,
                                 [&](const auto& s) { f = average_at(c.grid, c.points.meta[b], s)[l]; });
  });
  return f;
}

bool holds(const Cement& c, int b, int l) { return !(c.points.meta[b].failed >> l & 1); }

// Sum of volume times average over the intact points.
double volume_times_average(const Cement& c) {
  double sum = 0.0;
  c.for_points([&](int b, int l) { sum += holds(c, b, l) ? c.points.blocks[b].volume[l] * average_of(c, b, l) : 0.0; });
  return sum;
}
double volume_times_root(const Cement& c) {
  double sum = 0.0;
  c.for_points(
      [&](int b, int l) { sum += holds(c, b, l) ? c.points.blocks[b].volume[l] * root_of_norm(kLaw, c.points.blocks[b].strain)[l] : 0.0; });
  return sum;
}

void fail(Cement& c, std::size_t every) {
  for (std::size_t i = 0; i < c.slots.size(); i += every)
    c.points.meta[c.slots[i] / kLanes].failed |= static_cast<std::uint8_t>(1u << c.slots[i] % kLanes);
}

TEST(DriveAverage, KeepsConstantsBesideFailedPoints) {
  test::Random random(301);
  Cement c(kCell, test::scattered(random, kCell, 4, 6), kCell * kCell * kCell / 6);
  set_roots(c, [](int, int) { return 3.0; });
  fail(c, 5);
  average(c, smoothing_passes_for(1.7 * kCell, kCell, Basis::quadratic));
  test::Worst worst;
  for (std::size_t i = 0; i < c.slots.size(); ++i) {
    if (i % 5 != 0) worst.add(std::fabs(average_of(c, c.slots[i] / kLanes, c.slots[i] % kLanes) - 3.0));
  }
  expect_within(worst, 1e-13, "average of a constant");
}

TEST(DriveAverage, KeepsTheSum) {
  test::Random random(302);
  Cement c(kCell, test::scattered(random, kCell, 4, 6), kCell * kCell * kCell / 6);
  set_roots(c, [&](int, int) { return random.uniform(0, 2); });
  fail(c, 7);
  average(c, smoothing_passes_for(2.2 * kCell, kCell, Basis::quadratic));
  const double sum = volume_times_root(c);
  EXPECT_NEAR(volume_times_average(c), sum, 1e-13 * sum);
}

// Nodes at the edge are constrained: they have the means of their mass receivers.
TEST(DriveAverage, KeepsConstantsAndTheSumWithTiedNodes) {
  test::Random random(304);
  Cement c(kCell, test::scattered(random, kCell, 4, 6), kCell * kCell * kCell / 6);
  c.grid.lump_mass(c.points, test::kCalcite);
  c.grid.constrain(find_extension_constraints(MPI_COMM_SELF, Basis::quadratic, test::edges_of(c.grid)), true);
  ASSERT_GT(c.grid.constraints.size(), 10u);
  set_roots(c, [](int, int) { return 3.0; });
  average(c, smoothing_passes_for(1.7 * kCell, kCell, Basis::quadratic));
  test::Worst worst;
  c.for_points([&](int b, int l) { worst.add(std::fabs(average_of(c, b, l) - 3.0)); });
  expect_within(worst, 1e-13, "average of a constant");
  set_roots(c, [&](int, int) { return random.uniform(0, 2); });
  average(c, smoothing_passes_for(1.7 * kCell, kCell, Basis::quadratic));
  const double sum = volume_times_root(c);
  EXPECT_NEAR(volume_times_average(c), sum, 1e-13 * sum);
}

// Variance of the average of one point in the middle of a regular bond. The spline of its strain has the rest of the variance.
class Variance : public ::testing::TestWithParam<std::tuple<Basis, double>> {};

TEST_P(Variance, IsThatOfTheLength) {
  const auto [basis, length] = GetParam();
  const int n = 22;
  Cement c(kCell, test::lattice(kCell, n), kCell * kCell * kCell / 8, Eigen::Quaterniond::Identity(), basis);
  // a plane of points, so that a direction is left
  const double middle = kCell * (0.5 * n + 0.25);
  set_roots(c, [&](int b, int l) { return std::fabs(c.points.blocks[b].X[0][l] - middle) < 0.1 * kCell ? 1.0 : 0.0; });
  average(c, smoothing_passes_for(length * kCell, kCell, basis));
  double sum = 0.0, second = 0.0;
  c.for_points([&](int b, int l) {
    const double x = (c.points.blocks[b].X[0][l] - middle) / kCell, f = average_of(c, b, l);
    sum += f;
    second += f * x * x;
  });
  // linear hat functions: points of a lattice have their own variance, of h^2/4 in place of h^2/6
  const double of_strain = support(basis) / 12.0, tolerance = basis == Basis::linear ? 0.2 : 1e-3;
  EXPECT_NEAR(second / sum + of_strain, length * length, tolerance * length * length);
}

INSTANTIATE_TEST_SUITE_P(DriveAverage, Variance,
                         ::testing::Combine(::testing::Values(Basis::linear, Basis::quadratic, Basis::cubic),
                                            ::testing::Values(1.0, 1.3, 2.0)));

// A crack that no node reaches across ends the average.
TEST(DriveAverage, EndsAtAWideCrack) {
  const int n = 12;
  Cement c(kCell, test::lattice(kCell, n), kCell * kCell * kCell / 8);
  const auto x = [&](int b, int l) { return c.points.blocks[b].X[0][l] / kCell; };
  set_roots(c, [&](int b, int l) { return x(b, l) < 5.0 ? 1.0 : 0.0; });
  for (std::size_t i = 0; i < c.slots.size(); ++i) {
    const int b = c.slots[i] / kLanes, l = c.slots[i] % kLanes;
    if (x(b, l) > 5.0 && x(b, l) < 8.0) c.points.meta[b].failed |= static_cast<std::uint8_t>(1u << l);
  }
  average(c, smoothing_passes_for(3.0 * kCell, kCell, Basis::quadratic));
  test::Worst worst;
  c.for_points([&](int b, int l) {
    if (x(b, l) < 5.0) worst.add(std::fabs(average_of(c, b, l) - 1.0));
    if (x(b, l) > 8.0) worst.add(std::fabs(average_of(c, b, l)));
  });
  expect_within(worst, 1e-13, "what comes across");
}

// The length may be the cell but for rounding (fix_mpm_words.cpp), and cubic splines need one smoothing pass there.
TEST(DriveAverage, KeepsConstantsWhereTheLengthIsTheCell) {
  test::Random random(306);
  for (double ratio : {1.0 - 5e-7, 1.0, 1.0 + 5e-7}) {
    Cement c(kCell, test::scattered(random, kCell, 4, 6), kCell * kCell * kCell / 6, Eigen::Quaterniond::Identity(), Basis::cubic);
    set_roots(c, [](int, int) { return 3.0; });
    average(c, smoothing_passes_for(ratio * kCell, kCell, Basis::cubic));
    test::Worst worst;
    c.for_points([&](int b, int l) { worst.add(std::fabs(average_of(c, b, l) - 3.0)); });
    expect_within(worst, 1e-13, "average of a constant");
  }
}

// Weights and volumes that are kept are those that are found anew: after points failed, after they went to other blocks, and after nodes changed. Half of the points are in a lattice.
TEST(DriveAverage, WeightsThatStand) {
  test::Random random(305);
  std::vector<Vector> X = test::lattice(kCell, 4);
  for (std::size_t i = 0; i < X.size(); i += 2) X[i] += 0.2 * kCell * random.vector();
  Cement c(kCell, X, kCell * kCell * kCell / 8);
  set_roots(c, [&](int, int) { return random.uniform(0, 2); });
  const SmoothingPasses passes = smoothing_passes_for(1.7 * kCell, kCell, Basis::quadratic);
  BondRecord record = equal_grains();
  for (auto& centre : record.centre) centre[2] += 2 * kCell;  // the middle is that of the lattice
  const Imperfection imperfection{&record, 0.1};
  DriveAverage kept;
  kept.set_points_fixed(true);
  for (const char* state : {"fresh", "the same", "some failed", "in other blocks", "nodes tied"}) {
    if (state == std::string("in other blocks")) {
      std::swap(c.points.blocks.front(), c.points.blocks.back());
      std::swap(c.points.meta.front(), c.points.meta.back());
      c.grid.drive_average.clear();
    }
    if (state == std::string("some failed")) fail(c, 6);
    if (state == std::string("nodes tied")) {
      c.grid.lump_mass(c.points, test::kCalcite);
      c.grid.constrain(find_extension_constraints(MPI_COMM_SELF, Basis::quadratic, test::edges_of(c.grid)), true);
      ASSERT_GT(c.grid.constraints.size(), 10u);
    }
    kept.find(c.points, c.grid, kLaw, passes, imperfection);
    const std::vector<double> of_kept = c.grid.drive_average;
    average(c, passes, imperfection);
    EXPECT_EQ(of_kept, c.grid.drive_average) << state;
  }
}

// The stronger side carries more by the share, the weaker side carries what it carries alone, and between them is no more and no less.
TEST(DriveAverage, Imperfection) {
  const double share = 0.05;
  const BondRecord record = equal_grains();
  std::vector<Vector> X = test::lattice(kCell, 8);
  Vector middle = Vector::Zero();
  for (const Vector& x : X) middle += x / X.size();
  for (Vector& x : X) x -= middle;
  Cement c(kCell, X, kCell * kCell * kCell / 8);
  set_roots(c, [](int, int) { return 2.0; });
  const SmoothingPasses one{1, 1.0};  // reaches 3 cells
  average(c, one, {&record, share});
  const double strong = 2.0 / std::sqrt(1.0 + share);  // the root of the strain by 1 + share
  int above = 0, below = 0, between = 0;
  c.for_points([&](int b, int l) {
    const double z = c.points.blocks[b].X[2][l], f = average_of(c, b, l);
    EXPECT_GT(f, strong * (1 - 1e-13));
    EXPECT_LT(f, 2.0 * (1 + 1e-13));
    if (z > 3.1 * kCell) {
      EXPECT_NEAR(f, strong, 1e-13);
      ++above;
    } else if (z < -3.1 * kCell) {
      EXPECT_NEAR(f, 2.0, 1e-13);
      ++below;
    } else if (std::fabs(z) < 0.3 * kCell && f > strong + 1e-3 && f < 2.0 - 1e-3) {
      ++between;
    }
  });
  EXPECT_GT(above, 100);
  EXPECT_GT(below, 100);
  EXPECT_GT(between, 100);
  const std::vector<double> of_other = c.grid.drive_average;
  const BondRecord other = swapped(record);
  average(c, one, {&other, share});
  EXPECT_EQ(of_other, c.grid.drive_average) << "the order of the grains does not matter";
  // With `updated` a side is where points were made, not where they went.
  for (const PointBlock& b : c.points.blocks) {
    c.points.motion.emplace_back();
    for (int d = 0; d < 3; ++d) c.points.motion.back().X0[d] = d == 2 ? -b.X[d] : b.X[d];
  }
  average(c, one, {&record, share});
  c.for_points([&](int b, int l) {
    const double z = c.points.blocks[b].X[2][l];
    if (std::fabs(z) > 3.1 * kCell) {
      EXPECT_NEAR(average_of(c, b, l), z > 0.0 ? 2.0 : strong, 1e-13);
    }
  });
}

TEST(Imperfection, IsOnTheSideOfTheSmallerGrain) {
  for (int larger : {0, 1}) {
    BondRecord record = equal_grains();
    record.radius[larger] *= 1.01;
    record.centre[larger][2] *= 1.01 * 50 / 51 + 1.0 / 51;  // its surface stays
    for (const BondRecord& b : {record, swapped(record)}) {
      const double z = (larger == 0 ? 1 : -1) * 0.2 * kCell;
      const vd X[3] = {{}, {}, {z, -z}};
      EXPECT_EQ(bits(nearer_to_stronger_grain(b, X)) & 3, 1) << "larger grain " << larger;
    }
  }
}

// The axis nearest to the line of centres decides, of axes equally near the first, and what is as near to both belongs to the weaker side.
TEST(Imperfection, OfEqualGrainsIsOnTheSideOfLargerCoordinates) {
  const Vector lines[] = {{0, 0, 1}, {0, 1, -1}, {1, -1, -1}, {-1e-4, 0, 1}, {-0.3, 0.1, 1}, {-0.2, 1, 0}};
  for (const Vector& line : lines)
    for (int first : {0, 1}) {
      BondRecord record = equal_grains();
      for (int side = 0; side < 2; ++side)
        for (int d = 0; d < 3; ++d) record.centre[side][d] = (side == first ? -1 : 1) * 51 * kCell * line.normalized()[d];
      vd X[3];
      for (int d = 0; d < 3; ++d) X[d] = vd{0.2, -0.2, 0.0} * kCell * line.normalized()[d];
      EXPECT_EQ(bits(nearer_to_stronger_grain(record, X)) & 7, 1) << line.transpose() << ", first grain " << first;
    }
}

// Blocks with damage keep the root that their last pass found. It is that of the strain they have, also after points went to other blocks.
TEST(DriveAverage, RootsThatStand) {
  Cement c(kCell, test::lattice(kCell, 4), kCell * kCell * kCell / 8, Eigen::Quaterniond::Identity(), Basis::quadratic, 0, {}, true);
  const double dt = 1e-3, rate = 2.5e-7 / (kCell * dt);  // damage from above, over some steps
  c.set_velocity([&](const Vector& X) { return Vector(0.0, 0.0, rate * X[2] * X[2]); });
  AdvanceOptions options;
  options.nonlocal = true;
  const auto blocks = [&] { return static_cast<int>(c.points.blocks.size()); };
  const auto known = [&] {
    int count = 0;
    for (int b = 0; b < blocks(); ++b) {
      if (!c.points.knows_root_of_norm(b)) continue;
      ++count;
      const vd root = root_of_norm(kLaw, c.points.blocks[b].strain);
      for (int l = 0; l < kLanes; ++l)
        if (c.points.meta[b].occupied >> l & 1) {
          EXPECT_EQ(c.points.root_of_norm[b][l], root[l]) << "block " << b << ", lane " << l;
        }
    }
    return count;
  };
  int damaged = 0;
  for (int step = 0; step < 30 && damaged < blocks() / 2; ++step) {
    average(c, smoothing_passes_for(1.7 * kCell, kCell, Basis::quadratic));
    damaged = static_cast<int>(std::count_if(c.points.meta.begin(), c.points.meta.end(), [](const BlockMeta& m) { return m.damaged; }));
    AdvanceResult result;
    advance_points(c.points, 0, blocks(), c.grid, kLaw, dt, options, result);
    EXPECT_EQ(known(), damaged) << "step " << step;
  }
  ASSERT_GE(damaged, blocks() / 2);
  ASSERT_LT(damaged, blocks());
  const int first = static_cast<int>(
      std::find_if(c.points.meta.begin(), c.points.meta.end(), [](const BlockMeta& m) { return m.damaged; }) - c.points.meta.begin());
  PointStore other = c.points;
  other.take(c.points, 0, kLanes * first);
  EXPECT_FALSE(other.knows_root_of_norm(first));
  std::map<int, int> part;
  for (int b = first; b < blocks(); b += 3)
    for (int l = 0; l < kLanes; l += 2)
      if (c.points.meta[b].occupied >> l & 1) part[kLanes * b + l] = 1;
  c.points.move_to_layers(part, kCell, Basis::quadratic);
  EXPECT_GT(known(), 0);
  EXPECT_LT(known(), damaged);
  c.points.forget_roots_of_norm();
  EXPECT_EQ(known(), 0);
}

// Limits hold what they promise, and no less: while no root has grown by what the largest average lacks of the threshold, no average reaches
// it, and where all have grown by that it is there. Single points may be far above the threshold. It is that of points at a grain where these are weaker.
TEST(DriveAverage, LimitsOfTheDrive) {
  test::Random random(307);
  for (const auto& [basis, interface, weakest] :
       {std::tuple(Basis::quadratic, 1.0, 1.0), {Basis::cubic, 1.0, 1.0}, {Basis::quadratic, 0.25, 0.25}, {Basis::quadratic, 4.0, 1.0}}) {
    const TensorDamage law = test::law_of(1.0, interface);
    const double threshold = root_of_drive<TensorDamage>(splat(weakest * kLaw.threshold()))[0];
    Cement c(kCell, test::scattered(random, kCell, 4, 6), kCell * kCell * kCell / 6, Eigen::Quaterniond::Identity(), basis);
    const SmoothingPasses passes = smoothing_passes_for(1.7 * kCell, kCell, basis);
    std::map<int, double> roots;
    for (int slot : c.slots) roots[slot] = threshold * (random.index(50) == 0 ? 1.3 : random.uniform(0.3, 0.8));
    const auto set = [&](auto grown) {
      set_roots(c, [&](int b, int l) { return roots.count(kLanes * b + l) ? roots[kLanes * b + l] + grown() : 0.0; });
    };
    set([] { return 0.0; });
    average(c, passes);
    const double lacking = threshold - DriveAverage::largest(c.points, c.grid);
    ASSERT_GT(lacking, 0.05 * threshold);
    DriveAverage::find_limits(c.points, c.grid, law, threshold - lacking);
    ASSERT_EQ(c.grid.drive_limit.size(), c.points.blocks.size());
    EXPECT_TRUE(c.grid.drive_average.empty());
    const auto largest_over_limit = [&] {
      double most = 0.0;
      c.for_points([&](int b, int l) {
        const Sym3<vd>& strain = c.points.blocks[b].strain;
        most = std::max(most, TensorDamage::square_bound(kLaw.elasticity().stress(strain), strain)[l] / c.grid.drive_limit[b][l]);
      });
      return most;
    };
    const auto largest_average = [&] {
      average(c, passes);
      return DriveAverage::largest(c.points, c.grid);
    };
    for (const auto& [part, reaches] : {std::pair(0.999, false), std::pair(1.001, true)}) {
      set([&, part = part] { return part * lacking; });
      EXPECT_EQ(largest_over_limit() > 1.0, reaches);
      EXPECT_EQ(largest_average() > threshold, reaches);
    }
    set([&] { return random.uniform(-2.0, 0.999) * lacking; });
    EXPECT_LT(largest_over_limit(), 1.0);
    EXPECT_LT(largest_average(), threshold);
  }
}

TEST(DriveAverage, NoLimitsAtTheThresholdOrWithDamage) {
  test::Random random(308);
  Cement c(kCell, test::scattered(random, kCell, 3, 6), kCell * kCell * kCell / 6);
  const double threshold = root_of_drive<TensorDamage>(splat(kLaw.threshold()))[0];
  const SmoothingPasses passes = smoothing_passes_for(kCell, kCell, Basis::quadratic);
  for (double share : {0.9, 1.1}) {
    set_roots(c, [&](int, int) { return share * threshold; });
    average(c, passes);
    DriveAverage::find_limits(c.points, c.grid, kLaw, DriveAverage::largest(c.points, c.grid));
    EXPECT_EQ(c.grid.drive_limit.empty(), share > 1.0);
    EXPECT_EQ(c.grid.drive_average.empty(), share < 1.0);
  }
  c.points.meta[c.slots.back() / kLanes].damaged = true;
  set_roots(c, [&](int, int) { return 0.9 * threshold; });
  average(c, passes);
  EXPECT_GT(DriveAverage::largest(c.points, c.grid), 1e300);
}

// The pass reports a point that is above its limit, wherever the threshold is.
TEST(DriveAverage, ThePassComparesWithTheLimits) {
  test::Random random(309);
  Cement c(kCell, test::scattered(random, kCell, 3, 6), kCell * kCell * kCell / 6);
  const double threshold = root_of_drive<TensorDamage>(splat(kLaw.threshold()))[0];
  AdvanceOptions options;
  options.nonlocal = true;
  const auto is_near = [&] {
    AdvanceResult result;
    advance_points(c.points, 0, static_cast<int>(c.points.blocks.size()), c.grid, kLaw, 1e-9, options, result);  // at rest
    return result.near_threshold;
  };
  set_roots(c, [&](int, int) { return 0.99 * threshold; });
  EXPECT_TRUE(is_near());
  c.grid.drive_limit.assign(c.points.blocks.size(), splat(kLaw.threshold() * kLaw.threshold()));
  EXPECT_FALSE(is_near());
  const int slot = c.slots[c.slots.size() / 3];
  c.grid.drive_limit[slot / kLanes][slot % kLanes] *= 0.5;
  EXPECT_TRUE(is_near());
}

// A condensed bond is checked when the bounds of its points allow an average at the threshold. Here one motion strains some points and another motion the
// others, whose roots grow from nothing. Points with a link have a lower threshold, and less strain here.
TEST(DriveAverage, BoundsOfFieldsHoldForAverages) {
  test::Random random(310);
  const TensorDamage law = test::law_of(1.0, 0.3);
  double nearest = 0.0;
  for (int k = 0; k < 200; ++k) {
    Cement c(kCell, test::scattered(random, kCell, 3, 6), kCell * kCell * kCell / 6);
    const std::size_t blocks = c.points.blocks.size();
    std::array<std::vector<Sym3<vd>>, 6> fields;
    for (auto& field : fields) field.assign(blocks, Sym3<vd>{});
    for (int slot : c.slots) {
      const int b = slot / kLanes, l = slot % kLanes;
      const bool linked = random.index(8) == 0;
      if (linked) c.points.meta[b].linked |= static_cast<std::uint8_t>(1u << l);
      fields[k % 2 ? random.index(2) : 0][b].zz[l] = linked ? 0.4 : 1.0;
    }
    double bound[6];
    find_strain_bounds(c.points, fields, law, bound);
    const auto root_of_average = [&](double first, double second) {
      for (std::size_t b = 0; b < blocks; ++b) c.points.blocks[b].strain = splat(first) * fields[0][b] + splat(second) * fields[1][b];
      DriveAverage average;
      average.find(c.points, c.grid, law, smoothing_passes_for(1.7 * kCell, kCell, Basis::quadratic));
      return largest_root_of_drive(c.points, law, &c.grid);
    };
    const double times = bound_of_averages(law), first = 1.0 / bound[0], root = root_of_average(first, 0.0),
                 level = times * first * bound[0];
    EXPECT_LE(root, level * (1.0 + 1e-12));
    nearest = std::max(nearest, root / level);
    const double most = random.uniform(1.001, 1.1) * root, margin = margin_of_average(law, level, root, most);
    EXPECT_GT(margin, 0.0);
    const double share = random.uniform(0, 1);
    const double of_second = bound[1] > 0.0 ? (1.0 - share) * margin / (times * bound[1]) : 0.0;
    EXPECT_LE(root_of_average(first + share * margin / (times * bound[0]), of_second), most);
  }
  EXPECT_GT(nearest, 0.5);
  EXPECT_EQ(margin_of_average(law, 3.0, 1.0, 0.9), 0.0);
}

TEST(DriveAverage, NearWhereSomePointIs) {
  test::Random random(303);
  Cement c(kCell, test::scattered(random, kCell, 3, 6), kCell * kCell * kCell / 6);
  const double at_threshold = root_of_drive<TensorDamage>(splat(kLaw.threshold()))[0];
  const int slot = c.slots[c.slots.size() / 2];
  for (const auto& [interface, weakest] :
       {std::pair(1.0, 1.0), std::pair(0.25, 0.25), std::pair(4.0, 1.0)})  // points at a grain may be the weakest
    for (const auto& [share, near] : {std::pair(0.85, false), std::pair(0.95, true)}) {
      set_roots(c,
                [&, share = share * weakest](int b, int l) { return kLanes * b + l == slot ? std::pow(share, 0.25) * at_threshold : 0.0; });
      EXPECT_EQ(is_near_threshold(c.points, test::law_of(1.0, interface)), near) << share << " of the threshold, interface " << interface;
    }
  c.points.meta[slot / kLanes].failed |= static_cast<std::uint8_t>(1u << slot % kLanes);
  EXPECT_FALSE(is_near_threshold(c.points, kLaw));
}

}  // namespace
}  // namespace mpdem
