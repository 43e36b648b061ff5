// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement/resting.h"

#include <cstring>

#include "linked_bonds.h"

namespace mpdem {
namespace {

using test::Cement;
using test::kCell;
using test::Vector;

// Velocity comes and goes; asleep or not, points and forces are the same to the bit.
TEST(Resting, SleepsAndWakesExactly) {
  test::Random random(161);
  DamageParameters p;
  p.B0 = 1e6;
  const TensorDamage law(VtiElasticity(VtiConstants{60e9, 40e9, 0.25, 0.2, 18e9}), p);
  Cement one(kCell, test::scattered(random, kCell, 3, 8), kCell * kCell * kCell / 8);
  Cement two = one;
  Resting on, off;
  AdvanceOptions all;
  all.skip_resting = false;
  int slept = 0;
  for (int n = 0; n < 60; ++n) {
    const bool moving = n / 10 % 2 == 1;
    for (double& v : one.grid.velocity) v = moving ? random.uniform(-1, 1) * 3e-3 * kCell : 0.0;
    two.grid.velocity = one.grid.velocity;
    AdvanceResult a, b;
    one.grid.clear_force();
    two.grid.clear_force();
    on.advance(one.points, one.grid, law, 1.0, AdvanceOptions(), a);
    off.advance(two.points, two.grid, law, 1.0, all, b);
    slept += on.asleep();
    EXPECT_FALSE(off.asleep());
    EXPECT_EQ(a.failed, b.failed);
    EXPECT_EQ(a.dissipated, b.dissipated);
    EXPECT_EQ(one.grid.force, two.grid.force) << "step " << n;
    EXPECT_EQ(std::memcmp(one.points.blocks.data(), two.points.blocks.data(), one.points.blocks.size() * sizeof(PointBlock)), 0);
    ASSERT_EQ(one.points.states().size(), two.points.states().size());
    if (!one.points.states().empty()) {
      EXPECT_EQ(std::memcmp(one.points.states().data(), two.points.states().data(), one.points.states().size() * sizeof(vd)), 0);
    }
  }
  EXPECT_GE(slept, 15);  // of 30 steps at rest
}

// Damage that begins at rest, where no point has a state yet, and goes on because it is viscous.
TEST(Resting, FirstDamageAtRestKeepsAwake) {
  test::Random random(164);
  const TensorDamage law = test::law_of(1e3, 1.0, 5.0);
  Cement one(kCell, test::scattered(random, kCell, 3, 8), kCell * kCell * kCell / 8);
  for (PointBlock& p : one.points.blocks) p.strain.zz = splat(2e-3);
  Cement two = one;
  Resting on, off;
  AdvanceOptions all;
  all.skip_resting = false;
  for (int n = 0; n < 5; ++n) {
    AdvanceResult a, b;
    one.grid.clear_force();
    two.grid.clear_force();
    on.advance(one.points, one.grid, law, 1.0, AdvanceOptions(), a);
    off.advance(two.points, two.grid, law, 1.0, all, b);
    EXPECT_GT(b.dissipated, 0.0);
    EXPECT_EQ(a.dissipated, b.dissipated) << "step " << n;
    EXPECT_EQ(one.grid.force, two.grid.force) << "step " << n;
  }
}

// Bonds and grains come to rest and move on, together or not; with the links too all forces are the same to the bit.
TEST(Resting, LinksSleepAndWakeExactly) {
  DamageParameters p;
  p.B0 = 1e6;
  const TensorDamage law(VtiElasticity(VtiConstants{60, 40, 0.25, 0.2, 18}), p);
  for (const double damping : {0.0, 0.3}) {
    test::Scene one(163, test::penalty(true, damping)), two(163, test::penalty(true, damping));
    AdvanceOptions all;
    all.skip_resting = false;
    int slept = 0, alone = 0;
    for (int n = 0; n < 120; ++n) {
      // 10 steps a stage: bond 0 moves, a grain of bond 0 moves, bond 1 moves, or nothing
      const int stage = n / 10 % 5;
      for (Bond& b : one.bonds) {
        const bool moves = (stage == 1 && b.body == 0) || (stage == 3 && b.body == 1);
        for (double& v : b.grid.velocity) v = moves ? one.random.uniform(-1, 1) * 1e-3 : 0.0;
        two.bonds[b.body].grid.velocity = b.grid.velocity;
      }
      GrainSides::Motion& m = one.motion[1];
      for (int d = 0; d < 3; ++d) {
        m.v[d] = stage == 2 ? one.random.uniform(-1, 1) * 1e-2 : 0.0;
        m.x[d] += m.v[d];
      }
      two.motion = one.motion;
      for (test::Scene* s : {&one, &two}) {
        s->sides.distribute(s->bodies, s->motion);
        s->sides.clear_forces();
        for (Bond& b : s->bonds) {
          AdvanceResult result;
          b.grid.drift(0.0, 1.0);
          b.grid.clear_force();
          b.resting.advance(b.points, b.grid, law, 1.0, s == &one ? AdvanceOptions() : all, result);
          if (!b.resting.hand_out_links(b.grid, s->side(b))) {
            b.links.add_force(b.grid, s->side(b));
            b.resting.keep_links(b.grid, s->side(b));
          }
          EXPECT_TRUE(s == &one || !b.resting.asleep());
        }
      }
      const int asleep = one.bonds[0].resting.asleep() + one.bonds[1].resting.asleep();
      slept += asleep;
      alone += asleep == 1;
      for (int b = 0; b < 2; ++b) {
        const std::vector<double>&kept = one.bonds[b].grid.force, &anew = two.bonds[b].grid.force;
        EXPECT_EQ(std::memcmp(kept.data(), anew.data(), kept.size() * sizeof(double)), 0) << "step " << n;
      }
      for (std::size_t i = 0; i < one.sides.sides.size(); ++i)
        for (int d = 0; d < 3; ++d) {
          EXPECT_EQ(one.sides.sides[i].force[d], two.sides.sides[i].force[d]);
          EXPECT_EQ(one.sides.sides[i].torque[d], two.sides.sides[i].torque[d]);
        }
    }
    EXPECT_GT(slept, 60);
    EXPECT_GT(alone, 20);
  }
}

// Points that the bound lets pass, and blocks that failed, change nothing either.
TEST(Skip, UndamagedAndFailedPoints) {
  test::Random random(162);
  DamageParameters p;
  p.B0 = 1e6;
  const TensorDamage law(VtiElasticity(VtiConstants{60e9, 40e9, 0.25, 0.2, 18e9}), p);
  Cement one(kCell, test::scattered(random, kCell, 3, 8), kCell * kCell * kCell / 8);
  Cement two = one;
  AdvanceOptions none;
  none.skip_undamaged = none.skip_failed = none.skip_resting = false;
  double largest = 0;
  test::Worst worst;
  std::size_t failed = 0;
  for (int n = 0; n < 60; ++n) {
    one.set_velocity([&](const Vector& x) { return Vector(2e-3 * x[0] * x[0] / kCell, 0, 0); });
    two.grid.velocity = one.grid.velocity;
    AdvanceResult a, b;
    one.grid.clear_force();
    two.grid.clear_force();
    const int blocks = static_cast<int>(one.points.blocks.size());
    advance_points(one.points, 0, blocks, one.grid, law, 1.0, AdvanceOptions(), a);
    advance_points(two.points, 0, blocks, two.grid, law, 1.0, none, b);
    failed += a.failed.size();
    EXPECT_EQ(a.failed, b.failed);
    for (double f : one.grid.force) largest = std::max(largest, std::fabs(f));
    for (std::size_t i = 0; i < one.grid.force.size(); ++i) worst.add(std::fabs(one.grid.force[i] - two.grid.force[i]) / largest);
  }
  EXPECT_GT(failed, one.slots.size() / 4);
  // the stress of an undamaged point by M^-1 differs from C0 : strain by rounding
  expect_within(worst, 1e-12, "force");
}

}  // namespace
}  // namespace mpdem
