// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Contact points that touch again after debonding: of one bond between wide grains, on 1 and 2 ranks; balance of forces on bonds at random.
#include "coupling/debonded_contact.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <numeric>

#include "bounce.h"
#include "lanes.h"
#include "parallel/agree.h"
#include "coupling/crack_faces.h"
#include "cement_host.h"
#include "coupling/cohesive_traction.h"
#include "linked_bonds.h"
#include "numerics/length.h"
#include "mpi_ranks.h"

namespace mpdem {
namespace {

using test::Row;
using test::RowOfGrains;
using test::Way;

DebondedContact& places_of(const Bond& b) { return *b.mechanism<DebondedContact>(); }

void set_places(Bond& b, DebondedContact contact) {
  b.mechanisms.clear();
  b.mechanisms.push_back(std::make_unique<DebondedContact>(std::move(contact)));
}

// A ramp that rises from 0 to 1 between two times.
struct Ramp {
  double from, to;
  double at(double t) const { return std::min(1.0, std::max(0.0, (t - from) / (to - from))); }
  double share(double t) const {
    const double s = at(t);
    return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
  }
  double rate(double t) const {
    const double s = at(t), r = 1.0 - s;
    return 30.0 * s * s * r * r / (to - from);
  }
};

constexpr double kPush = 1e-7;
constexpr int kRampSteps = 800, kMeanSteps = 970;  // whole periods of the cement on one grain, 4 of shear and nearly 6 of pressure
constexpr double kRampTime = kRampSteps * test::kStep;

// Moves by `way` in the first ramp. In the second it comes to the speed `then`, which it keeps.
Row on_path(std::array<double, 3> way, std::array<double, 3> then = {0, 0, 0}) {
  Row r;
  r.B0 = 0.0;
  r.path = [way, then](double t) {
    const Ramp first{0.0, kRampTime};
    Way w;
    const double s = std::max(0.0, t / kRampTime - 1.0);
    const double gone = s < 1.0 ? s * s * s - 0.5 * s * s * s * s : s - 0.5, speed = s < 1.0 ? 3.0 * s * s - 2.0 * s * s * s : 1.0;
    for (int d = 0; d < 3; ++d) {
      w.way[d] = way[d] * first.share(t) + then[d] * kRampTime * gone;
      w.velocity[d] = way[d] * first.rate(t) + then[d] * speed;
    }
    return w;
  };
  return r;
}

// Mean force of the bond on the second grain over some steps after the ramps.
std::array<double, 3> force_at_end(RowOfGrains& host, int ramps) {
  host.setup();
  host.run(ramps * kRampSteps);
  std::array<double, 3> f{};
  for (int n = 0; n < kMeanSteps; ++n) {
    host.step();
    for (int d = 0; d < 3; ++d) f[d] += host.cement->report().bond_states()[0].force[1][d] / kMeanSteps;
  }
  return f;
}

Row loose(Row r, double friction, bool skin_failed = false) {
  r.loose = true;
  r.friction = friction;
  r.skin_failed = skin_failed;
  return r;
}

// Springs side by side, with those of the links in series, as in test_cement.cpp. less: of their lengths.
double stiffness(double less = 0.0) {
  const double t = test::kGap - less + 2.0 * test::kYoung / test::kPenalty;
  return M_PI * test::kRadius * test::kYoung * std::log(1.0 + test::kOuter * test::kOuter / (test::kRadius * t));
}

TEST(DebondedContact, CarryCompressionWithTheStiffnessOfTheCementAndNoTension) {
  if (test::ranks() > 1) GTEST_SKIP();
  RowOfGrains pushed(MPI_COMM_WORLD, loose(on_path({0, 0, -kPush}), 0.3)), pulled(MPI_COMM_WORLD, loose(on_path({0, 0, kPush}), 0.3)),
      off(MPI_COMM_WORLD, loose(on_path({0, 0, -kPush}), -1.0));
  const double force = force_at_end(pushed, 1)[2];
  test::expect_within(std::fabs(force / (stiffness() * kPush) - 1.0), 0.02, "force over stiffness times approach");
  EXPECT_LT(std::fabs(force_at_end(pulled, 1)[2]), 2e-3 * force);
  EXPECT_LT(std::fabs(force_at_end(off, 1)[2]), 2e-3 * force);
}

// The points beside the grain carry nothing: the contact point follows the next layer, over what failed as over something stiff. A layer is
// half a cell, which the edge of the cement blurs.
TEST(DebondedContact, FollowTheNearestPointsThatHold) {
  if (test::ranks() > 1) GTEST_SKIP();
  RowOfGrains host(MPI_COMM_WORLD, loose(on_path({0, 0, -kPush}), 0.3, true));
  const double force = force_at_end(host, 1)[2], least = stiffness() * kPush, most = stiffness(test::kSpacing) * kPush;
  EXPECT_GT(host.cement->report().totals(0.1).failed, 300.0);
  EXPECT_GT(force, 1.03 * least);
  EXPECT_LT(force, 1.02 * most);
}

// Grains that are pushed, and sheared by less than friction carries, move as if attached.
TEST(DebondedContact, StickBelowFriction) {
  if (test::ranks() > 1) GTEST_SKIP();
  constexpr double kMu = 0.4;
  const Row path = on_path({0, 0, -kPush}, {0.2 * kMu * kPush / kRampTime, 0, 0});
  RowOfGrains freed(MPI_COMM_WORLD, loose(path, kMu)), attached(MPI_COMM_WORLD, path);
  const auto f = force_at_end(freed, 2), a = force_at_end(attached, 2);
  EXPECT_LT(std::fabs(f[0]), 0.6 * kMu * f[2]);
  EXPECT_GT(std::fabs(f[0]), 0.05 * kMu * f[2]);
  test::expect_within(std::fabs(f[2] / a[2] - 1.0), 5e-3, "pressure against that of links");
  test::expect_within(std::fabs(f[0] / a[0] - 1.0), 1e-2, "shear against that of links");
}

TEST(DebondedContact, SlideWithMuN) {
  if (test::ranks() > 1) GTEST_SKIP();
  for (double mu : {0.0, 0.3}) {
    RowOfGrains host(MPI_COMM_WORLD, loose(on_path({0, 0, -kPush}, {1.5 * kPush / kRampTime, 0, 0}), mu));
    host.setup();
    host.run(3 * kRampSteps);
    test::Worst off_mu;
    for (int n = 0; n < 100; ++n) {
      host.run(5);
      const BondState& b = host.cement->report().bond_states()[0];
      EXPECT_LT(b.force[0][2], -10.0);
      // pressure has no moment about the centre
      off_mu.add(std::fabs(std::fabs(b.torque[0][1] / (test::kRadius * b.force[0][2])) - mu));
      EXPECT_GT(b.force[0][0] * mu, 0.0 - 1e-12);
      EXPECT_LT(std::fabs(b.force[0][1]), 1e-3 * std::fabs(b.force[0][2]));
    }
    test::expect_within(off_mu, std::max(0.01 * mu, 1e-9), "moment of friction over radius and normal force, less mu");
    const CementTotals t = host.cement->report().totals(0.1);
    if (mu > 0.0) {
      EXPECT_GT(t.frictional, 0.1 * t.external_work);
    } else {
      EXPECT_EQ(t.frictional, 0.0);
    }
    test::expect_within(std::fabs(t.imbalance), 0.01, "imbalance");
    EXPECT_NEAR(t.external_work, host.sum(host.work), 1e-3 * t.external_work);
  }
}

// The cement comes off by failure, is pushed back, and slides. Points beside the grains carry nothing, contact points follow the next.
struct Method {
  bool split, unilateral;
};
Row broken_and_closed(double friction, Method m) {
  Row r;
  r.friction = friction;
  r.split = m.split;
  r.unilateral = m.unilateral;
  r.interface = 0.2;
  r.path = [](double t) {
    constexpr double kFar = 5e-7, kClose = 3.0 * kPush, kSlide = 6.0 * kPush;
    const Ramp out{0.0, 2.4e-6}, back{2.4e-6, 6e-6}, slide{4.4e-6, 8e-6};
    Way w{};
    w.way[2] = kFar * out.share(t) - (kFar + kClose) * back.share(t);
    w.velocity[2] = kFar * out.rate(t) - (kFar + kClose) * back.rate(t);
    w.way[0] = kSlide * slide.share(t);
    w.velocity[0] = kSlide * slide.rate(t);
    return w;
  };
  return r;
}

class Broken : public ::testing::TestWithParam<Method> {};

// Pairs of unconstrained nodes at one place.
int pairs_of_nodes(const Grid& grid) {
  std::map<std::array<int, 3>, int> free;
  for (int i = 0; i < grid.size(); ++i)
    if (grid.constraints.row(i) < 0) ++free[grid.keys[i].index()];
  int pairs = 0;
  for (const auto& n : free) pairs += n.second * (n.second - 1) / 2;
  return pairs;
}

// The energies are those that the grains paid for, and all ranks see what one alone sees.
TEST_P(Broken, CarriesCompressionAgain) {
  const Row r = broken_and_closed(0.3, GetParam());
  RowOfGrains host(MPI_COMM_WORLD, r), alone(MPI_COMM_SELF, r), off(MPI_COMM_SELF, broken_and_closed(-1.0, GetParam()));
  host.setup();
  alone.setup();
  off.setup();
  double peak = 0.0, pressed = 0.0, pressed_off = 0.0, frictional = 0.0;
  for (int n = 0; n < 40; ++n) {
    host.run(50);
    off.run(50);
    if (test::ranks() > 1) alone.run(50);
    peak = std::max(peak, host.tension(0));
    if (test::ranks() > 1)
      test::expect_within(std::fabs(host.tension(0) - alone.tension(0)) / peak, 1e-6, "tension against that of one rank");
    const CementTotals t = host.cement->report().totals(0.1);
    EXPECT_GT(t.frictional, frictional - 1e-9 * t.external_work);
    frictional = t.frictional;
    if (host.number < 300) continue;
    test::expect_within(std::fabs(t.imbalance), 0.005, "imbalance of the energy");
    const double spent = t.kinetic + t.elastic + t.coupling + t.dissipated + t.released + t.damped + t.frictional;
    test::expect_within(std::fabs(spent / host.sum(host.work) - 1.0), 0.005, "energies against the work of the grains");
    if (host.number <= 1500) continue;
    pressed += 0.1 * host.tension(0);
    pressed_off += 0.1 * off.tension(0);
  }
  const CementTotals t = host.cement->report().totals(0.1);
  EXPECT_EQ(t.separated, 1.0);
  EXPECT_GT(t.failed, 300.0);
  EXPECT_GT(t.frictional, 0.05 * t.external_work);
  EXPECT_LT(pressed, -0.1 * peak);
  if (!GetParam().unilateral) {
    EXPECT_GT(pressed_off, -0.01 * peak);
  }
  for (const Bond& b : host.bonds)
    EXPECT_EQ(b.mechanism<CrackFaces>() ? b.mechanism<CrackFaces>()->pairs() : 0, GetParam().split ? pairs_of_nodes(b.grid) : 0);
  host.cement->check_state();
  if (test::ranks() == 1) return;
  EXPECT_EQ(host.all_failed(), alone.all_failed());
  EXPECT_EQ(host.separated, alone.separated);
}

TEST_P(Broken, RestartsToTheBit) {
  const Row r = broken_and_closed(0.3, GetParam());
  RowOfGrains whole(MPI_COMM_WORLD, r);
  whole.setup();
  for (int at : {502, 1303, 1804}) {  // as points fail, closing, sliding; between checks for remapping
    test::expect_restart_to_the_bit(whole, r, at, 100, whole.dt, [&](RowOfGrains& again) {
      EXPECT_NEAR(whole.cement->report().totals(0.1).frictional, again.cement->report().totals(0.1).frictional,
                  1e-12 * whole.cement->report().totals(0.1).external_work);
    });
  }
  EXPECT_GT(whole.cement->report().totals(0.1).frictional, 0.0);
}

INSTANTIATE_TEST_SUITE_P(DebondedContact, Broken, ::testing::Values(Method{false, false}, Method{true, false}, Method{true, true}),
                         [](const auto& p) {
                           return std::string(p.param.split ? "split" : "bonds") + (p.param.unilateral ? "_unilateral" : "");
                         });

// Two layers have failed from the start, and nodes split there.
Row cracked(Row r, double friction, int layers = 2) {
  r.B0 = 1e12;  // nothing else fails
  r.split = true;
  r.cracked = layers;
  r.friction = friction;
  return r;
}

TEST(CrackFaces, CarryCompressionAndNoTension) {
  if (test::ranks() > 1) GTEST_SKIP();
  RowOfGrains pushed(MPI_COMM_WORLD, cracked(on_path({0, 0, -kPush}), 0.3)), pulled(MPI_COMM_WORLD, cracked(on_path({0, 0, kPush}), 0.3)),
      off(MPI_COMM_WORLD, cracked(on_path({0, 0, -kPush}), -1.0));
  const double force = force_at_end(pushed, 1)[2];
  // the cell that failed between the faces is soft: about 3 of the 4 + 2 cells that this would be
  test::expect_within(std::fabs(force / (stiffness() * kPush) - 0.65), 0.05, "force over stiffness of whole cement times approach");
  const CrackFaces& faces = *pushed.bonds.begin()->mechanism<CrackFaces>();
  EXPECT_GT(faces.pairs(), 100);
  EXPECT_EQ(faces.touching(), faces.pairs());
  test::expect_within(faces.largest_penetration() / (2.0 * test::kSpacing), 1e-9, "overlap over a cell");
  EXPECT_LT(std::fabs(force_at_end(pulled, 1)[2]), 2e-3 * force);
  EXPECT_LT(std::fabs(force_at_end(off, 1)[2]), 2e-3 * force);
}

// An odd layer leaves more material on one face than on the other. With `unilateral` the points of the crack carry a part of both forces.
TEST(CrackFaces, SlideWithMuN) {
  if (test::ranks() > 1) GTEST_SKIP();
  for (const auto& [mu, layers, unilateral] : {std::tuple<double, int, bool>{0.0, 2, false},
                                               {0.3, 2, false},
                                               {0.0, 1, false},
                                               {0.3, 1, false},
                                               {0.0, 2, true},
                                               {0.3, 2, true},
                                               {0.3, 1, true},
                                               {0.3, 4, true}}) {
    Row r = cracked(on_path({0, 0, -kPush}, {(unilateral ? 8.0 : 1.5) * kPush / kRampTime, 0, 0}), mu, layers);
    r.unilateral = unilateral;
    RowOfGrains host(MPI_COMM_WORLD, r);
    host.setup();
    host.run(3 * kRampSteps);
    double N = 0.0, T = 0.0;
    for (int n = 0; n < kMeanSteps; ++n) {
      host.step();
      const BondState& b = host.cement->report().bond_states()[0];
      N += b.force[1][2] - b.force[0][2];
      T += b.force[0][0] - b.force[1][0];
    }
    const CementTotals t = host.cement->report().totals(0.1);
    test::expect_within(std::fabs(T / N - mu), std::max(0.01 * mu, 1e-4), "force of friction over the normal one, less mu");
    test::expect_within(std::fabs(t.imbalance), 0.003, "imbalance");
    EXPECT_GE(t.frictional, (mu > 0.0 ? 0.1 : -1e-6) * t.external_work);
  }
}

// Faces that overlap, as where the normal rotated: they separate, and the force that does it gives no energy.
TEST(CrackFaces, GiveNoEnergyWhereTheyOverlap) {
  if (test::ranks() > 1) GTEST_SKIP();
  int overlapped = 0;
  for (double way : {-kPush, kPush}) {
    RowOfGrains host(MPI_COMM_WORLD, cracked(on_path({0, 0, 0}), 0.3));
    host.setup();
    host.run(20);
    Bond& bond = *host.bonds.begin();
    std::vector<char> above(bond.grid.size(), 0);  // nodes of what is intact above the crack
    for (std::size_t b = 0; b < bond.points.blocks.size(); ++b) {
      const BlockMeta& m = bond.points.meta[b];
      if (bond.points.blocks[b].X[2][0] < test::kSpacing || m.failed) continue;
      with_weights<QuadraticBspline>(bond.points.blocks[b], m, 1.0 / bond.grid.h, [&](const auto& w) {
        using W = std::decay_t<decltype(w)>;
        for (int c = 0; c < W::kI * W::kJ; ++c)
          for (int k = 0; k < W::kK; ++k) above[m.column[c] + k] = 1;
      });
    }
    for (int i = 0; i < bond.grid.size(); ++i)
      if (above[i]) {
        bond.grid.displacement[3 * i + 2] += way;
        bond.grid.velocity[3 * i + 2] = 1e5 * way;
      }
    host.step();
    overlapped += host.bonds.begin()->mechanism<CrackFaces>()->largest_penetration() > 0.5 * kPush;
    host.run(100);
    const CementTotals t = host.cement->report().totals(0.1);
    EXPECT_GT(t.frictional, -1e-6 * (t.elastic + t.kinetic));
  }
  EXPECT_EQ(overlapped, 1);
}

bool any_of_ranks(bool mine) {
  int all = mine;
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return all > 0;
}

TEST(CrackFaces, AlikeOnRanksAndAfterARestart) {
  for (bool unilateral : {false, true}) {
    Row r = cracked(on_path({0, 0, -kPush}, {1.5 * kPush / kRampTime, 0, 0}), 0.3);
    r.loose = true;  // contact points at the grain, too
    r.unilateral = unilateral;
    RowOfGrains host(MPI_COMM_WORLD, r), alone(MPI_COMM_SELF, r);
    host.setup();
    alone.setup();
    host.run(1203);
    alone.run(1203);
    const BondState &a = host.cement->report().bond_states()[0], &b = alone.cement->report().bond_states()[0];
    for (int d : {0, 2})
      test::expect_within(std::fabs(a.force[1][d] - b.force[1][d]) / a.force[1][2], 1e-9, "force against that of one rank");
    const RowOfGrains::Saved saved = host.save();
    RowOfGrains again(MPI_COMM_WORLD, r, saved, host.bonds.table);
    again.setup();
    host.setup();
    host.run(30);
    again.run(30);
    test::expect_same_bits(host.content(), again.content());
    int touching = 0;
    bool slid = false;
    for (const Bond& bond : again.bonds) {
      touching += bond.mechanism<CrackFaces>()->touching();
      slid = slid || !bond.points.slip.empty();
    }
    EXPECT_GT(touching, 100);
    EXPECT_EQ(any_of_ranks(slid), unilateral);
  }
}

// Faces that slid by more than a cell belong to rigid pieces from then on.
TEST(CrackFaces, SlideByUpToACell) {
  if (test::ranks() > 1) GTEST_SKIP();
  constexpr double kCell = 2.0 * test::kSpacing, kSlide = 1.5 * kCell;
  RowOfGrains host(MPI_COMM_WORLD, cracked(on_path({0, 0, -5.0 * kPush}, {kSlide / kRampTime, 0, 0}), 0.0));
  host.setup();
  double slid = 0.0, apart_at = 0.0;
  while (slid < 1.4 * kCell && host.number < 3 * kRampSteps) {
    host.run(20);
    for (const Grain& g : host.cement->grains().grains) slid = std::max(slid, g.x[0]);
    EXPECT_NO_THROW(host.cement->check_state());
    if (apart_at == 0.0 && host.cement->is_apart(0)) apart_at = slid;
  }
  EXPECT_GT(apart_at, 0.99 * kCell);
  EXPECT_LT(apart_at, 1.2 * kCell);
}

// Points that failed are stiff again while the crack is closed, so the bond is what it was. A closed cycle leaves the energy as it was.
TEST(ClosingPoints, CarryCompressionWithTheStiffnessOfWholeCement) {
  if (test::ranks() > 1) GTEST_SKIP();
  Row r = cracked(on_path({0, 0, -kPush}), 0.3);
  r.unilateral = true;
  RowOfGrains pushed(MPI_COMM_WORLD, r);
  const double force = force_at_end(pushed, 1)[2];
  test::expect_within(std::fabs(force / (stiffness() * kPush) - 1.0), 0.005, "force over stiffness of whole cement times approach");
  r.path = [](double t) {  // and pulled as far, and back
    const Ramp in{0.0, kRampTime}, out{kRampTime, 3.0 * kRampTime}, back{3.0 * kRampTime, 4.0 * kRampTime};
    return Way{{0, 0, kPush * (-in.share(t) + 2.0 * out.share(t) - back.share(t))},
               {0, 0, kPush * (-in.rate(t) + 2.0 * out.rate(t) - back.rate(t))}};
  };
  RowOfGrains cycled(MPI_COMM_WORLD, r);
  cycled.setup();
  double most = 0.0;
  for (int n = 0; n < 400; ++n) {
    cycled.run(10);
    const CementTotals t = cycled.cement->report().totals(0.1);
    most = std::max(most, t.external_work);
    const double spent = t.kinetic + t.elastic + t.coupling + t.dissipated + t.released + t.frictional;
    if (n > 20) test::expect_within(std::fabs(t.external_work - spent) / most, 1e-3, "work less energies, over the largest work");
  }
  const CementTotals t = cycled.cement->report().totals(0.1);
  EXPECT_GT(most, 8e-7);
  EXPECT_GT(t.external_work, -1e-3 * most);  // nothing came out of the cycle
}

// The largest stable step is stable with a crack that closes and slides, too: a long run just below it.
TEST(ClosingPoints, LeaveTheBoundOfTheStep) {
  if (test::ranks() > 1) GTEST_SKIP();
  Row r = cracked(on_path({0, 0, -kPush}), 0.3);
  r.unilateral = true;
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.setup();
  const double step = host.cement->stable_step().find();
  r.path = [](double t) {
    const Ramp in{0.0, kRampTime}, slide{kRampTime, 2.0 * kRampTime};
    return Way{{4.0 * kPush * slide.share(t), 0, -kPush * in.share(t)}, {4.0 * kPush * slide.rate(t), 0, -kPush * in.rate(t)}};
  };
  RowOfGrains at_limit(MPI_COMM_WORLD, r);
  at_limit.dt = 0.98 * step;
  at_limit.setup();
  at_limit.run(3000);
  const CementTotals t = at_limit.cement->report().totals(0.1);
  EXPECT_GT(step, test::kStep);
  EXPECT_LT(t.kinetic, 0.1 * t.elastic);
  EXPECT_GT(t.frictional, t.elastic);
  test::expect_within(std::fabs(t.imbalance), 1e-2, "imbalance");
}

// Bonds at random whose links have all debonded, with contact points that touch.
test::Scene scene_of_places(std::uint64_t seed, const PenaltyParameters& p) {
  test::Scene s(seed, p);
  for (Bond& b : s.bonds) {
    for (Link& k : b.points.links) k.attached = false;
    b.links = s.links_anew(b);
    set_places(b, DebondedContact(b.points, s.records[b.row], p, b.grid));
    places_of(b).add_debonded_at_creation(b.points, s.records[b.row], b.grid, s.ends_of(b));
  }
  for (double size : {0.02, 0.03, 0.03}) {
    s.place_grains(size, 0.0);
    for (Bond& b : s.bonds) places_of(b).follow(b.points, b.grid, s.ends_of(b));
  }
  return s;
}

double sum_of_stiffness(const test::Scene& s, const Bond& b) {
  std::vector<double> k(2 * b.grid.size(), 0.0);
  places_of(b).add_stiffness(b.grid, s.ends_of(b), k.data());
  return std::accumulate(k.begin(), k.end(), 0.0);
}

// A node with the added mass of a contact point alone flies at a grain and comes back, from all positions it may have a step
// before. A step is 1.
TEST(DebondedContact, ANodeThatBouncesGainsLittle) {
  if (test::ranks() > 1) GTEST_SKIP();
  PenaltyParameters p = test::penalty(false, 0.0);
  p.friction = 0.3;
  test::Scene s = scene_of_places(832, p);
  Bond& b = s.bonds[0];
  places_of(b).update_added_mass(b.points, b.grid, s.ends_of(b), 0.0, 1e3);
  double stiffness = 0.0;
  for (const ContactPoint& contact : b.points.contacts)
    stiffness +=
        (1.0 + s.ends_of(b)[contact.grain == s.records[0].grain[0] ? 0 : 1].mass_ratio) * p.stiffest_contact() * contact.added_mass_area;
  const double rate = 4.0 / 1.05 * stiffness / sum_of_stiffness(s, b),
               mean = test::energy_after_bounce(test::Random(92), [&](double) { return rate; });
  EXPECT_GT(mean, 0.9);
  EXPECT_LT(mean, 1.05);
}

// Contact points far from their grains have no added mass, unless they are fast. Those that have it keep it up to twice as far.
TEST(DebondedContact, HaveAddedMassNearTheirGrainsAlone) {
  if (test::ranks() > 1) GTEST_SKIP();
  PenaltyParameters p = test::penalty(false, 0.0);
  p.friction = 0.3;
  test::Scene s(834, p);
  Bond& b = s.bonds[0];
  for (Link& k : b.points.links) k.attached = false;
  b.links = s.links_anew(b);
  set_places(b, DebondedContact(b.points, s.records[b.row], p, b.grid));
  b.grid.displacement.assign(b.grid.displacement.size(), 0.0);
  b.grid.velocity.assign(b.grid.velocity.size(), 0.0);
  places_of(b).add_debonded_at_creation(b.points, s.records[b.row], b.grid, s.ends_of(b));
  const auto at = [&](double gap) {  // lifts all contact points of one grain along the line of centres
    BondEnd* ends = s.ends_of(b);
    double along[3], centre[3];
    for (int d = 0; d < 3; ++d) centre[d] = s.records[b.row].centre[0][d];
    const double r = length(centre);
    for (int d = 0; d < 3; ++d) along[d] = centre[d] / r;
    for (int i = 0; i < 2; ++i)
      for (int d = 0; d < 3; ++d) ends[i].x[d] = s.records[b.row].centre[i][d] + (i == 0 ? gap : -gap) * along[d];
    return ends;
  };
  const double h = b.grid.h;
  const auto inert = [&] {
    double area = 0.0;
    for (const ContactPoint& contact : b.points.contacts) area += contact.added_mass_area;
    return area;
  };
  double all = 0.0;
  for (const ContactPoint& contact : b.points.contacts) all += contact.area;
  EXPECT_FALSE(places_of(b).update_added_mass(b.points, b.grid, at(0.1 * h), 0.0, 0.0));
  EXPECT_EQ(inert(), 0.0);
  EXPECT_TRUE(places_of(b).update_added_mass(b.points, b.grid, at(0.0), 0.0, 0.0));
  EXPECT_NEAR(inert(), all, 1e-12 * all);
  EXPECT_FALSE(places_of(b).update_added_mass(b.points, b.grid, at(0.0015 * h), 0.0, 0.0));
  EXPECT_TRUE(places_of(b).update_added_mass(b.points, b.grid, at(0.1 * h), 0.0, 0.0));
  EXPECT_EQ(inert(), 0.0);
  BondEnd* ends = at(0.1 * h);
  for (int i = 0; i < 2; ++i)
    for (int d = 0; d < 3; ++d) ends[i].v[d] = -(ends[i].x[d] - s.records[b.row].centre[i][d]);  // back in a time of 1
  EXPECT_TRUE(places_of(b).update_added_mass(b.points, b.grid, ends, 0.0, 0.6));
  EXPECT_GT(inert(), 0.9 * all);
}

// A contact point has its added mass from update_added_mass() on until it is remapped.
TEST(DebondedContact, HaveAddedMassFromWhenItIsFoundUntilTheyGoOn) {
  if (test::ranks() > 1) GTEST_SKIP();
  PenaltyParameters p = test::penalty(false, 0.0);
  p.friction = 0.3;
  test::Scene s = scene_of_places(833, p);
  Bond& b = s.bonds[0];
  EXPECT_EQ(sum_of_stiffness(s, b), 0.0);
  places_of(b).update_added_mass(b.points, b.grid, s.ends_of(b), 0.0, 1e3);
  const double whole = sum_of_stiffness(s, b);
  EXPECT_GT(whole, 0.0);
  const int slot = b.points.contacts.front().slot;
  double area = 0.0, all = 0.0;
  for (const ContactPoint& contact : b.points.contacts) (contact.slot == slot ? area : all) += contact.area;
  b.points.meta[slot / kLanes].failed |= static_cast<std::uint8_t>(1u << slot % kLanes);
  places_of(b).end(b.points, b.grid, s.ends_of(b), {slot}, 0.0);
  EXPECT_EQ(sum_of_stiffness(s, b), whole);
  DebondedContact anew(b.points, s.records[0], p, b.grid);
  std::vector<double> k(2 * b.grid.size(), 0.0);
  anew.add_stiffness(b.grid, s.ends_of(b), k.data());
  EXPECT_EQ(std::accumulate(k.begin(), k.end(), 0.0), whole);
  std::vector<DebondedContact::Arrival> arrivals;
  std::vector<std::array<int, 2>> gone;
  for (const DebondedContact::OrphanedContact& m : places_of(b).orphans(b.points, s.records[0])) {
    const DebondedContact::Found to = DebondedContact::nearest(b.points, m);
    ASSERT_FALSE(to.slots.empty());
    for (int near : to.slots) {
      EXPECT_NE(near, slot);
      arrivals.push_back({m, near, 1.0 / static_cast<double>(to.slots.size())});
    }
    gone.push_back({m.tag, m.grain});
  }
  ASSERT_FALSE(arrivals.empty());
  places_of(b).move(b.points, s.records[0], b.grid, s.ends_of(b), arrivals, gone);
  EXPECT_LT(sum_of_stiffness(s, b), whole);
  double after = 0.0;
  for (const ContactPoint& contact : b.points.contacts) after += contact.area;
  EXPECT_NEAR(after, area + all, 1e-12 * after);
}

// Contact points of failed points carry nothing, and are remapped without a force. So what acts on each node and grain stays as it is where
// they join contact points that are pressed and sheared already.
TEST(DebondedContact, KeepTheirForceWhereOthersCome) {
  if (test::ranks() > 1) GTEST_SKIP();
  PenaltyParameters p = test::penalty(false, 0.0);
  p.friction = 0.3;
  test::Scene s = scene_of_places(837, p);
  int joined = 0;  // arrivals at closed contact points
  test::Worst change;
  for (Bond& b : s.bonds) {
    const BondRecord& record = s.records[b.row];
    const auto forces = [&] {
      s.ends.clear_forces();
      b.grid.clear_force();
      places_of(b).add_force(b.grid, s.ends_of(b));
      std::vector<double> f(b.grid.force);
      for (int side = 0; side < 2; ++side) {
        f.insert(f.end(), s.ends_of(b)[side].force, s.ends_of(b)[side].force + 3);
        f.insert(f.end(), s.ends_of(b)[side].torque, s.ends_of(b)[side].torque + 3);
      }
      return f;
    };
    std::vector<int> failed;
    for (const ContactPoint& contact : b.points.contacts)
      if (contact.slot % 3 == 0) failed.push_back(contact.slot);
    failed.erase(std::unique(failed.begin(), failed.end()), failed.end());
    for (int slot : failed) b.points.meta[slot / kLanes].failed |= static_cast<std::uint8_t>(1u << slot % kLanes);
    places_of(b).end(b.points, b.grid, s.ends_of(b), failed, 0.0);
    const std::vector<double> before = forces();
    std::vector<DebondedContact::Arrival> arrivals;
    std::vector<std::array<int, 2>> gone;
    for (const DebondedContact::OrphanedContact& m : places_of(b).orphans(b.points, record)) {
      const DebondedContact::Found to = DebondedContact::nearest(b.points, m);
      for (int slot : to.slots) {
        arrivals.push_back({m, slot, 1.0 / static_cast<double>(to.slots.size())});
        for (const ContactPoint& contact : b.points.contacts) joined += contact.closed && contact.slot == slot && contact.grain == m.grain;
      }
      gone.push_back({m.tag, m.grain});
    }
    places_of(b).move(b.points, record, b.grid, s.ends_of(b), arrivals, gone);
    const std::vector<double> after = forces();
    double size = 0.0;
    for (double f : before) size = std::max(size, std::fabs(f));
    for (std::size_t i = 0; i < before.size(); ++i) change.add(std::fabs(after[i] - before[i]) / size);
  }
  EXPECT_GT(joined, 10);
  test::expect_within(change, 1e-13, "change of a force, over the largest");
}

// Points fail one after another, and their contact points are remapped to points that fail later: links and contact points have all of
// the area at any time, with links that stay on as residue too.
TEST(DebondedContact, KeepTheAreaOfTheLinks) {
  if (test::ranks() > 1) GTEST_SKIP();
  for (bool residue : {false, true}) {
    PenaltyParameters p = test::penalty(false, 0.0);
    p.friction = 0.3;
    if (residue) p.law = std::make_shared<CohesiveTraction>(TractionStiffness{1e13, 1e13}, LawValues());
    test::Scene s(835, p);
    Bond& b = s.bonds[0];
    const BondRecord& record = s.records[0];
    set_places(b, DebondedContact(b.points, record, p, b.grid));
    const auto area = [&] {
      double sum = 0.0;
      for (const ContactPoint& contact : b.points.contacts) sum += contact.area;
      for (const Link& k : b.points.links) sum += k.attached && !b.points.has_failed(k.slot) ? k.area : 0.0;
      return sum;
    };
    const double whole = area();
    int carried = 0;  // points that fail with a contact point of another point
    for (std::size_t n = 0; n + 1 < s.slots[0].size(); ++n) {
      const std::vector<int> failed{s.slots[0][n]};
      for (const ContactPoint& contact : b.points.contacts) carried += contact.slot == failed[0];
      double released = 0.0;
      const std::vector<int> links = b.links.debond(b.points, failed, b.grid, s.ends_of(b), 0.0, released);
      b.points.meta[failed[0] / kLanes].failed |= static_cast<std::uint8_t>(1u << failed[0] % kLanes);
      places_of(b).end(b.points, b.grid, s.ends_of(b), failed, 0.0);
      places_of(b).open(b.points, record, b.grid, s.ends_of(b), links, test::kDt);
      if (n % 3 != 0) continue;
      std::vector<DebondedContact::Arrival> arrivals;
      std::vector<std::array<int, 2>> gone;
      for (const DebondedContact::OrphanedContact& m : places_of(b).orphans(b.points, record)) {
        const DebondedContact::Found to = DebondedContact::nearest(b.points, m);
        for (int near : to.slots) arrivals.push_back({m, near, 1.0 / static_cast<double>(to.slots.size())});
        gone.push_back({m.tag, m.grain});
      }
      places_of(b).move(b.points, record, b.grid, s.ends_of(b), arrivals, gone);
      ASSERT_NEAR(area(), whole, 1e-12 * whole) << (residue ? "residue, " : "") << n + 1 << " points failed";
    }
    EXPECT_GT(carried, 20);
  }
}

// Points fail: what their contact points store is released, and these carry nothing until they are remapped. A force that ends within a
// step has worked with its value before on all of the displacement of that step: for short steps that is the mean of the energies at both
// ends of it.
TEST(DebondedContact, GiveUpTheirEnergyWhenTheirPointFails) {
  if (test::ranks() > 1) GTEST_SKIP();
  PenaltyParameters p = test::penalty(false, 0.0);
  p.friction = 0.3;
  for (double dt : {0.0, 1e-4}) {
    test::Scene s = scene_of_places(834, p);
    s.place_grains(0.03, 0.7);
    for (BondEnd& end : s.ends.ends)  // so that nodes alone are elsewhere a step before
      for (int d = 0; d < 3; ++d) end.v[d] = end.omega[d] = 0.0;
    for (Bond& b : s.bonds) places_of(b).follow(b.points, b.grid, s.ends_of(b));
    for (Bond& b : s.bonds) {
      const auto energy_before = [&](double time) {
        Grid then = b.grid;
        for (std::size_t i = 0; i < then.displacement.size(); ++i) then.displacement[i] -= time * then.velocity[i];
        double U = 0.0;
        places_of(b).add_energy(then, s.ends_of(b), U);
        return U;
      };
      std::vector<int> failed;
      for (const ContactPoint& contact : b.points.contacts)
        if (contact.closed && contact.slot % 3 != 0) failed.push_back(contact.slot);
      failed.erase(std::unique(failed.begin(), failed.end()), failed.end());
      ASSERT_GT(failed.size(), 5u);
      const double whole = energy_before(0.0), whole_then = energy_before(dt);
      for (int slot : failed) b.points.meta[slot / kLanes].failed |= static_cast<std::uint8_t>(1u << slot % kLanes);
      const double released = places_of(b).end(b.points, b.grid, s.ends_of(b), failed, dt);
      const double left = energy_before(0.0), given = whole - left, given_then = whole_then - energy_before(dt);
      EXPECT_NEAR(released / (0.5 * (given + given_then)), 1.0, 1e-5);
      if (dt > 0.0) {
        EXPECT_GT(std::fabs(given_then / given - 1.0), 2e-5);
      }
      for (const ContactPoint& contact : b.points.contacts) {
        if (std::binary_search(failed.begin(), failed.end(), contact.slot)) {
          EXPECT_FALSE(contact.closed);
        }
      }
      places_of(b).follow(b.points, b.grid, s.ends_of(b));
      EXPECT_NEAR(energy_before(0.0), left, 1e-9 * whole);
      EXPECT_EQ(places_of(b).orphans(b.points, s.records[b.row]).size(),
                static_cast<std::size_t>(std::count_if(b.points.contacts.begin(), b.points.contacts.end(), [&](const ContactPoint& f) {
                  return std::binary_search(failed.begin(), failed.end(), f.slot);
                })));
    }
  }
}

// Links debond under pressure. What the energy balance has of the contact points that open is what these release if they end in the same
// step, by the rule of the test above. With a step of no length that is the energy that they store.
TEST(DebondedContact, BeginWithTheProductOfBothEndsOfAStep) {
  if (test::ranks() > 1) GTEST_SKIP();
  PenaltyParameters p = test::penalty(false, 0.0);
  p.friction = 0.3;
  for (double dt : {0.0, test::kDt}) {
    test::Scene s(836, p);
    s.place_grains(0.03, 0.7);
    for (Bond& b : s.bonds) {
      const BondRecord& record = s.records[b.row];
      set_places(b, DebondedContact(b.points, record, p, b.grid));
      std::vector<int> links(b.points.links.size()), slots;
      for (std::size_t i = 0; i < links.size(); ++i) links[i] = static_cast<int>(i);
      const double begun = places_of(b).open(b.points, record, b.grid, s.ends_of(b), links, dt);
      EXPECT_EQ(places_of(b).follow(b.points, b.grid, s.ends_of(b)), 0.0);
      double stored = 0.0;
      places_of(b).add_energy(b.grid, s.ends_of(b), stored);
      ASSERT_GT(stored, 0.0);
      for (const ContactPoint& contact : b.points.contacts) slots.push_back(contact.slot);
      EXPECT_NEAR(begun, places_of(b).end(b.points, b.grid, s.ends_of(b), slots, dt), 1e-12 * std::fabs(begun));
      if (dt > 0.0) {
        EXPECT_GT(std::fabs(begun / stored - 1.0), 1e-3);
      } else {
        EXPECT_NEAR(begun, stored, 1e-12 * stored);
      }
    }
  }
}

// Checks a random state: resultant and moment of what acts on nodes and grains, and the force as the slope of the energy.
TEST(DebondedContact, ActAndReactAlike) {
  if (test::ranks() > 1) GTEST_SKIP();
  PenaltyParameters p = test::penalty(true, 0.0);
  p.friction = 0.3;
  test::Scene s(831, p);
  for (Bond& b : s.bonds) {
    for (Link& k : b.points.links) k.attached = false;
    b.links = s.links_anew(b);
    set_places(b, DebondedContact(b.points, s.records[b.row], p, b.grid));
    places_of(b).add_debonded_at_creation(b.points, s.records[b.row], b.grid, s.ends_of(b));
  }
  const auto follow = [&](double size) {
    s.place_grains(size, 0.0);
    double frictional = 0.0;
    for (Bond& b : s.bonds) frictional += places_of(b).follow(b.points, b.grid, s.ends_of(b));
    return frictional;
  };
  const auto energy = [&] {
    double U = 0.0;
    for (Bond& b : s.bonds) places_of(b).add_energy(b.grid, s.ends_of(b), U);
    return U;
  };
  follow(0.02);
  EXPECT_GT(follow(0.03), 0.0);
  EXPECT_GT(follow(0.03), 0.0);
  int closed = 0, open = 0;
  for (const Bond& b : s.bonds)
    for (const ContactPoint& contact : b.points.contacts) (contact.closed ? closed : open) += 1;
  EXPECT_GT(closed, 20);
  EXPECT_GT(open, 20);
  for (Bond& b : s.bonds) {
    EXPECT_EQ(places_of(b).follow(b.points, b.grid, s.ends_of(b)), 0.0);  // those that closed just now begin to stick
    const PointStore before(b.points);
    EXPECT_EQ(places_of(b).follow(b.points, b.grid, s.ends_of(b)), 0.0);
    EXPECT_EQ(std::memcmp(before.contacts.data(), b.points.contacts.data(), before.contacts.size() * sizeof(ContactPoint)), 0);
  }
  s.ends.clear_forces();
  for (Bond& b : s.bonds) {
    b.grid.clear_force();
    places_of(b).add_force(b.grid, s.ends_of(b));
  }
  s.expect_balanced(s.forces(), 1e-13, "contact points");
  // friction that sticks, and pressure, by differences
  Grid& grid = s.bonds[0].grid;
  test::Worst slope;
  double size = 0.0;
  for (double f : grid.force) size = std::max(size, std::fabs(f));
  for (int i = 0; i < 3 * grid.size(); i += 7) {
    constexpr double kStep = 1e-7;
    double U[2];
    for (int n = 0; n < 2; ++n) {
      grid.displacement[i] += (n == 0 ? 1 : -2) * kStep;
      U[n] = energy();
    }
    grid.displacement[i] += kStep;
    slope.add(std::fabs(grid.force[i] + (U[0] - U[1]) / (2 * kStep)) / size);
  }
  test::expect_within(slope, 0.02, "force against the slope of the energy");
}

}  // namespace
}  // namespace mpdem
