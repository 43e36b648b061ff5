// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mpm/advance_points.h"

#include <algorithm>

#include "cement.h"

namespace mpdem {
namespace {

using test::Cement;
using test::kCell;
using test::law_of;
using test::Matrix;
using test::Vector;

constexpr double kDt = 1e-9;

// Random motion of the nodes that damages some points and fails a few a step.
void shake(Cement& c, test::Random& random) {
  c.set_velocity([&](const Vector&) { return Vector(3e-3 * kCell / kDt * random.vector()); });
}

// Damage, failures and energies are the same as those of the law applied point by point. The law has the factor of
// the interface on points that are linked and the share of growth that viscosity leaves.
template <class L>
void expect_law_at_every_point(const L& law, bool fails = true) {
  test::Random random(101);
  Cement c(kCell, test::scattered(random, kCell, 3, 7), kCell * kCell * kCell / 7);
  for (BlockMeta& m : c.points.meta) m.linked = static_cast<std::uint8_t>(m.occupied & random.bits());
  // One number of a lane, and the state of a lane in all lanes.
  const auto number = [](typename L::State& s, int i, int l) -> double& { return reinterpret_cast<double*>(&s)[kLanes * i + l]; };
  const double growth = law.growth(kDt);
  test::Worst energy;
  std::size_t failures = 0;
  for (int step = 0; step < 8; ++step) {
    const PointStore before = c.points;
    shake(c, random);
    const AdvanceResult result = c.advance(law, kDt);
    double dissipated = 0, released = 0;
    std::vector<int> failed;
    for (std::size_t b = 0; b < c.points.blocks.size(); ++b)
      for (int l = 0; l < kLanes; ++l) {
        if (!(before.meta[b].occupied >> l & 1) || (before.meta[b].failed >> l & 1)) continue;
        typename L::State was = state_of<L>(before, static_cast<int>(b)), now = state_of<L>(c.points, static_cast<int>(b)), s = was;
        for (int i = 0; i < L::kFields; ++i)
          for (int k = 0; k < kLanes; ++k) number(s, i, k) = number(was, i, l);
        const double strength = before.meta[b].linked >> l & 1 ? law.interface() : 1.0;
        const auto u =
            law.update(test::on_all_lanes(test::tensor(before.blocks[b].strain, l)),
                       test::on_all_lanes(test::tensor(c.points.blocks[b].strain, l)), s, test::only_lane(0), splat(strength), growth);
        // Points whose damage grows are computed in vectors with others: results are bitwise identical.
        for (int i = 0; i < L::kFields; ++i) EXPECT_EQ(number(now, i, l), number(s, i, 0));
        dissipated += u.dissipated[0] * c.points.blocks[b].volume[l];
        released += u.released[0] * c.points.blocks[b].volume[l];
        if (u.failed[0]) failed.push_back(static_cast<int>(kLanes * b) + l);
      }
    EXPECT_EQ(result.failed, failed);
    EXPECT_TRUE(std::is_sorted(result.failed.begin(), result.failed.end()));
    for (int slot : failed) EXPECT_TRUE(c.points.meta[slot / kLanes].failed >> slot % kLanes & 1);
    failures += failed.size();
    if (dissipated > 0) energy.add(std::fabs(result.dissipated / dissipated - 1.0));
    if (released > 0) energy.add(std::fabs(result.released / released - 1.0));
  }
  if (fails) {
    EXPECT_GT(failures, 5u);
  }
  expect_within(energy, 1e-12, "energies");
}

TEST(AdvancePoints, EveryPointFollowsTheLaw) { expect_law_at_every_point(law_of(9.6e4)); }
TEST(AdvancePoints, EveryPointFollowsTheLawWeakInterface) { expect_law_at_every_point(law_of(9.6e4, 0.4)); }
TEST(AdvancePoints, EveryPointFollowsTheLawStrongInterface) { expect_law_at_every_point(law_of(9.6e4, 3.0)); }
TEST(AdvancePoints, EveryPointFollowsTheLawViscous) { expect_law_at_every_point(law_of(9.6e4, 0.7, 2 * kDt), false); }
TEST(AdvancePoints, EveryPointFollowsMazars) {
  LawValues v;
  v.set("kappa0", 2e-3);
  v.set("At", 0.9);
  v.set("Bt", 500.0);
  v.set("interface", 0.7);
  expect_law_at_every_point(MazarsDamage(test::elastic_calcite(), v));
}

TEST(AdvancePoints, FailedPointsAreFrozenAndGiveNoForce) {
  test::Random random(102);
  const TensorDamage law = law_of(9.6e4);
  const std::vector<Vector> X = test::scattered(random, kCell, 3, 7);
  Cement c(kCell, X, kCell * kCell * kCell / 7);
  for (int step = 0; step < 8; ++step) {
    shake(c, random);
    c.advance(law, kDt);
  }
  const PointStore before = c.points;
  shake(c, random);
  c.advance(law, kDt);
  int dead = 0;
  c.for_points([&](int b, int l) {
    if (!(before.meta[b].failed >> l & 1)) return;
    ++dead;
    EXPECT_EQ(test::matrix(c.points.blocks[b].F, l), test::matrix(before.blocks[b].F, l));
    EXPECT_EQ(test::tensor(test::damage_of(c.points, b), l), test::tensor(test::damage_of(before, b), l));
    EXPECT_EQ(test::tensor(c.points.blocks[b].strain, l), test::tensor(before.blocks[b].strain, l));
  });
  EXPECT_GT(dead, 5);

  // The force is that of the intact points alone: take the volume of the failed ones away.
  const std::vector<double> force = c.grid.force;
  for (std::size_t b = 0; b < c.points.blocks.size(); ++b)
    for (int l = 0; l < kLanes; ++l)
      if (c.points.meta[b].failed >> l & 1) c.points.blocks[b].volume[l] = 0.0;
  c.grid.clear_force();
  add_internal_force(c.points, c.grid, law);
  double size = 0;
  for (double f : force) size = std::max(size, std::fabs(f));
  test::Worst worst;
  for (std::size_t i = 0; i < force.size(); ++i) worst.add(std::fabs(force[i] - c.grid.force[i]) / size);
  expect_within(worst, 1e-13, "force");
}

TEST(AdvancePoints, WithoutDamageNothingIsDamaged) {
  test::Random random(103);
  const NoDamage law(test::elastic_calcite());
  Cement c(kCell, test::scattered(random, kCell, 3, 7), kCell * kCell * kCell / 7);
  for (int step = 0; step < 5; ++step) {
    shake(c, random);
    const AdvanceResult r = c.advance(law, kDt);
    EXPECT_TRUE(r.failed.empty());
    EXPECT_EQ(r.dissipated, 0.0);
  }
  for (const BlockMeta& m : c.points.meta) EXPECT_FALSE(m.damaged);
  EXPECT_TRUE(c.points.states().empty());
}

// The work of the mean force over a step is the change of the stored energy, up to the
// third order of the step: the stress is work-conjugate to the strain that the energy is of.
TEST(AdvancePoints, ElasticForceDerivesFromTheEnergy) {
  test::Random random(104);
  const NoDamage law(test::elastic_calcite());
  const std::vector<Vector> X = test::scattered(random, kCell, 3, 7);
  const auto energy_of = [&](const Cement& c) {
    double U = 0;
    for (const PointBlock& p : c.points.blocks) U += 0.5 * sum_lanes(p.volume * contract(p.strain, law.elasticity().stress(p.strain)));
    return U;
  };
  const auto error_at = [&](double size) {
    test::Random same(105);
    Cement c(kCell, X, kCell * kCell * kCell / 7);
    c.set_velocity([&](const Vector&) { return Vector(0.05 * kCell / kDt * same.vector()); });
    c.advance(law, kDt);
    const std::vector<double> force = c.grid.force;
    const double U = energy_of(c);
    c.set_velocity([&](const Vector&) { return Vector(size * kCell / kDt * same.vector()); });
    c.advance(law, kDt);
    double work = 0;
    for (std::size_t i = 0; i < force.size(); ++i) work -= 0.5 * (force[i] + c.grid.force[i]) * kDt * c.grid.velocity[i];
    return std::fabs(energy_of(c) - U - work) / U;
  };
  const double coarse = error_at(8e-4), fine = error_at(4e-4);
  test::expect_within(fine, 1e-9, "work over a step");
  test::expect_within(std::fabs(std::log2(coarse / fine) - 3.0), 0.1, "order minus 3");
}

}  // namespace
}  // namespace mpdem
