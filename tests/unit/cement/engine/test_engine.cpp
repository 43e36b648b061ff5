// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The engine without LIGGGHTS, on 1 and 2 ranks: order of its calls, condensed bonds, added mass, stable step, cracks,
// report. Without Poisson's ratio the cement between wide flat grains is springs side by side, so forces and energies
// have closed forms.
#include "cement/engine/cement.h"

#include <stdexcept>

#include "cement_host.h"
#include "lanes.h"
#include "mpi_ranks.h"

namespace mpdem {
namespace {

using test::Row;
using test::RowOfGrains;

// Attached area of the bond over the compliance of cement and links, force over length. The outermost points are half a
// spacing from the grains, whose surface is flat within 2 % of the gap.
double spring(double area) { return area / (test::kGap / test::kYoung + 2.0 / test::kPenalty); }

// Pulled slowly against the time of a wave, and far from the threshold of damage.
Row slow_row() {
  Row r;
  r.B0 = 1e9;
  r.ramp = 4e-5;
  r.speed = 0.02;
  r.relax = 0.3;
  r.whole_bonds = true;
  return r;
}

TEST(Engine, CallsInAnotherOrderThrow) {
  Row r;
  RowOfGrains host(MPI_COMM_WORLD, r);
  Cement& c = *host.cement;
  EXPECT_THROW(c.start_run(), std::logic_error);  // no layout
  EXPECT_THROW(c.step(), std::logic_error);
  host.setup();
  EXPECT_THROW(c.start_run(), std::logic_error);  // started twice
  EXPECT_THROW(c.grains_moved(), std::logic_error);
  EXPECT_THROW(c.end_step(), std::logic_error);
  EXPECT_THROW(c.lay_out_exchanged(), std::logic_error);  // outside of a step
  c.start_step(true);
  EXPECT_THROW(c.start_step(false), std::logic_error);
  EXPECT_THROW(c.step(), std::logic_error);  // grains have not moved
  c.grains_moved();
  c.lay_out_exchanged();
  c.step();
  try {
    c.step();
    ADD_FAILURE() << "a step was taken twice";
  } catch (const std::logic_error& e) {
    EXPECT_STREQ(e.what(), "Cement: step was called after step");
  }
  c.end_step();
  host.run(1);
}

// Resolved and condensed, the bond is the spring of its cement and its links in a row; half the work is its energy.
TEST(Engine, ForceAndEnergyAreThoseOfASpring) {
  for (bool condense : {false, true}) {
    Row r = slow_row();
    r.condense = condense;
    RowOfGrains host(MPI_COMM_WORLD, r);
    host.setup();
    EXPECT_EQ(host.cement->report().resolved_bonds(), condense ? 0 : 1);
    host.run(20000);
    const double stretch = host.stretch(), K = spring(host.bonds.table[0].attached_area[0]);
    ASSERT_GT(stretch, 1e-7);
    EXPECT_NEAR(host.tension(0) / (K * stretch), 1.0, 0.03) << condense;
    const CementTotals t = host.cement->report().totals(0.1);
    EXPECT_NEAR((t.elastic + t.coupling) / (0.5 * host.tension(0) * stretch), 1.0, 0.01) << condense;
    EXPECT_NEAR(host.sum(host.work) / (0.5 * host.tension(0) * stretch), 1.0, 0.02) << condense;
    test::expect_within(std::fabs(t.imbalance), 1e-3, "imbalance of the energy");
  }
}

// The middle grain of two bonds follows forces. Condensed and resolved bonds give it the same place.
TEST(Engine, CondensedBondsCarryAFreeGrain) {
  double z[2];
  for (int condensed = 0; condensed < 2; ++condensed) {
    Row r = slow_row();
    r.bonds = 2;
    r.free_middle = true;
    r.condense = condensed == 1;
    RowOfGrains host(MPI_COMM_WORLD, r);
    host.setup();
    host.run(15000);
    double mine = 0.0;
    for (const Grain& g : host.cement->grains().grains)
      if (g.tag == 2) mine = g.x[2] - (2 * test::kRadius + test::kGap);
    z[condensed] = host.sum(mine);
    test::expect_within(std::fabs(host.cement->report().totals(0.1).imbalance), 1e-3, "imbalance of the energy");
    EXPECT_NEAR(host.tension(0) / host.tension(1), 1.0, 0.1) << condensed;
  }
  EXPECT_LT(std::fabs(z[1] - z[0]), 2e-3 * test::kGap * 1e-2);
}

// A condensed bond is activated, breaks as a resolved one does, and is condensed again in two pieces.
TEST(Engine, ACondensedBondWakesBreaksAndIsCondensedAgain) {
  Row r;
  r.ramp = 8e-6;
  r.speed = 1.0;
  r.relax = 0.3;
  r.length = 2e-4;  // with an average comes an imperfection, so that one side breaks first
  r.whole_bonds = true;
  RowOfGrains resolved(MPI_COMM_WORLD, r);
  r.condense = true;
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.setup();
  resolved.setup();
  EXPECT_EQ(host.cement->report().resolved_bonds(), 0);
  double peak[2] = {0.0, 0.0};
  std::vector<int> bonds;
  for (int n = 0; n < 500; ++n) {
    host.run(20);
    resolved.run(20);
    peak[0] = std::max(peak[0], resolved.tension(0));
    peak[1] = std::max(peak[1], host.tension(0));
    bonds.push_back(host.cement->report().resolved_bonds());
  }
  EXPECT_TRUE(std::count(bonds.begin(), bonds.end(), 1) > 0);
  EXPECT_EQ(bonds.back(), 0);
  EXPECT_TRUE(host.cement->cracks().separated(0));
  EXPECT_NEAR(peak[1] / peak[0], 1.0, 5e-3);
  const auto tags = [](const std::vector<std::array<int, 2>>& events) {
    std::vector<int> t;
    for (const auto& e : events) t.push_back(e[1]);
    std::sort(t.begin(), t.end());
    return t;
  };
  EXPECT_EQ(tags(host.all_failed()), tags(resolved.all_failed()));
  test::expect_within(std::fabs(host.cement->report().totals(0.1).imbalance), 5e-3, "imbalance of the energy");
}

TEST(Engine, CondensedBondsRestartToTheBit) {
  Row r;
  r.bonds = 2;
  r.free_middle = true;
  r.condense = true;
  r.whole_bonds = true;
  r.ramp = 8e-6;
  RowOfGrains whole(MPI_COMM_WORLD, r);
  whole.setup();
  EXPECT_EQ(whole.cement->report().resolved_bonds(), 0);
  test::expect_restart_to_the_bit(whole, r, 50, 2000, test::kStep, [&](RowOfGrains& again) {
    EXPECT_EQ(again.cement->report().resolved_bonds(), whole.cement->report().resolved_bonds());
    EXPECT_FALSE(whole.all_failed().empty());
  });
}

// A push of the last grain, which comes back to its place, leaves the bond ringing. Its energy stays what it is below the
// largest stable step, and grows without bound above it. The limit is that of cement without links, whose added mass makes the nodes at the grains slower.
TEST(StableStep, IsTheLargest) {
  double limit = 0.0;
  for (double share : {0.0, 0.98, 1.15}) {  // the first finds the limit
    Row r;
    r.B0 = 0.0;
    const double push = 5.0 * limit;
    r.path = [=](double t) {
      if (t >= push) return test::Way{};
      const double w = 2.0 * M_PI / push;
      return test::Way{{0, 0, 1e-9 * (1.0 - std::cos(w * t))}, {0, 0, 1e-9 * w * std::sin(w * t)}};
    };
    RowOfGrains host(MPI_COMM_WORLD, r);
    host.dt = share > 0.0 ? share * limit : test::kStep;
    host.setup();
    if (share == 0.0) {
      limit = host.cement->stable_step().find();
      continue;
    }
    const auto energy = [&] {
      const CementTotals t = host.cement->report().totals(0.1);
      return t.kinetic + t.elastic + t.coupling;
    };
    host.run(10);
    const double before = energy();
    ASSERT_GT(before, 0.0);
    host.run(600);
    if (share < 1.0) EXPECT_LT(energy(), 3.0 * before);
    else EXPECT_GT(energy(), 1e3 * before);
  }
}

// Stiff links add mass to the nodes, which both grains give. The free row keeps its momentum.
TEST(AddedMasses, OfStiffLinksKeepMomentum) {
  Row r;
  r.free_ends = r.free_middle = true;
  r.bonds = 2;
  r.B0 = 0.0;
  r.stiffer = 40.0;
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.setup();
  const std::vector<double> added = host.cement->report().added_mass_of_ends();
  ASSERT_EQ(added.size(), 4u);
  for (double m : added) EXPECT_GT(m, 0.0);
  EXPECT_NEAR(added[0] / added[3], 1.0, 1e-9);  // the row is its own mirror image
  EXPECT_NEAR(added[1] / added[2], 1.0, 1e-9);
  for (Grain& g : host.cement->grains().grains) g.velocity[2] = g.tag == 3 ? 0.3 : 0.0;
  host.run(400);
  const CementTotals t = host.cement->report().totals(0.1);
  double mine = 0.0;
  for (const Grain& g : host.cement->grains().grains) mine += g.mass * g.velocity[2];
  const double all = host.sum(mine) + t.momentum[2], start = 0.3 * r.grain_mass;
  test::expect_within(std::fabs(all / start - 1.0), 1e-9, "momentum of grains and cement");
  test::expect_within(std::fabs(t.imbalance), 1e-5, "imbalance of the energy");
}

// Points of a layer across the bond have failed from the start: it is separated at the first check, through its middle.
TEST(Cracks, ALayerThatFailedSeparatesTheBond) {
  Row r;
  r.cracked = 2;
  r.speed = 0.04;
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.setup();
  host.run(5);
  EXPECT_TRUE(host.cement->cracks().separated(0));
  EXPECT_EQ(host.cement->cracks().mode(0), "internal");
  host.run(400);
  // its halves follow the grains, which take half of the speed in the time of the ramp
  const double inertia = 0.5 * 2710 * host.bonds.table[0].volume * 0.5 * r.speed / r.ramp;
  EXPECT_LT(std::fabs(host.tension(0)), 3.0 * inertia);
  EXPECT_GT(spring(host.bonds.table[0].attached_area[0]) * host.stretch(), 10.0 * inertia);  // what it would carry
  const BondState s = host.cement->report().bond_states()[0];
  EXPECT_EQ(s.separated, 1.0);
  EXPECT_EQ(s.share[0] + s.share[1], 0.0);
}

// Half of the bond leaves the middle part connected: nothing is separated.
TEST(Cracks, AHalfLayerDoesNot) {
  Row r;
  r.crumbled = 0.2e-3;  // points beyond are connected to no grain
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.setup();
  host.run(10);
  EXPECT_FALSE(host.cement->cracks().separated(0));
  EXPECT_GT(host.cement->report().bond_states()[0].failed, 0.0);
}

}  // namespace
}  // namespace mpdem
