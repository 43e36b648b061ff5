// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Places that let go and touch again: of one bond between wide grains, on 1 and 2 ranks; balance of forces on bonds at random.
#include "coupling/freed_places.h"

#include <cstring>

#include "cement_host.h"
#include "lanes.h"
#include "linked_bonds.h"
#include "mpi_ranks.h"

namespace mpdem {
namespace {

using test::Row;
using test::RowOfGrains;
using test::Way;

// Goes from 0 to 1 between these times, with a smooth speed.
struct Ramp {
  double from, to;
  double share(double t) const {
    const double s = std::min(1.0, std::max(0.0, (t - from) / (to - from)));
    return s * s * (3.0 - 2.0 * s);
  }
  double rate(double t) const {
    const double s = std::min(1.0, std::max(0.0, (t - from) / (to - from)));
    return 6.0 * s * (1.0 - s) / (to - from);
  }
};

constexpr double kPush = 1e-7;
constexpr int kRampSteps = 400;

// Moves by `way` in the first ramp, and by `then` in the second.
Row on_path(std::array<double, 3> way, std::array<double, 3> then = {0, 0, 0}) {
  Row r;
  r.B0 = 0.0;
  r.path = [way, then](double t) {
    const Ramp first{0.0, kRampSteps * test::kStep}, second{kRampSteps * test::kStep, 2 * kRampSteps * test::kStep};
    Way w;
    for (int d = 0; d < 3; ++d) {
      w.way[d] = way[d] * first.share(t) + then[d] * second.share(t);
      w.velocity[d] = way[d] * first.rate(t) + then[d] * second.rate(t);
    }
    return w;
  };
  return r;
}

// Mean force of the bond on the second grain over some steps after both ramps.
std::array<double, 3> force_at_end(RowOfGrains& host, int ramps = 2) {
  host.setup();
  host.run(ramps * kRampSteps + 50);
  std::array<double, 3> f{};
  constexpr int kMean = 300;
  for (int n = 0; n < kMean; ++n) {
    host.step();
    for (int d = 0; d < 3; ++d) f[d] += host.cement->bond_states()[0].force[1][d] / kMean;
  }
  return f;
}

Row loose(Row r, double friction) {
  r.loose = true;
  r.friction = friction;
  return r;
}

// Springs side by side, with those of the links in series, as in test_cement.cpp.
double stiffness() {
  const double t = test::kGap + 2.0 * test::kYoung / test::kPenalty;
  return M_PI * test::kRadius * test::kYoung * std::log(1.0 + test::kOuter * test::kOuter / (test::kRadius * t));
}

TEST(FreedPlaces, CarryCompressionWithTheStiffnessOfTheCementAndNoTension) {
  RowOfGrains pushed(MPI_COMM_WORLD, loose(on_path({0, 0, -kPush}), 0.3)), pulled(MPI_COMM_WORLD, loose(on_path({0, 0, kPush}), 0.3)),
      off(MPI_COMM_WORLD, loose(on_path({0, 0, -kPush}), -1.0));
  const double force = force_at_end(pushed, 1)[2];
  test::expect_within(std::fabs(force / (stiffness() * kPush) - 1.0), 0.02, "force over stiffness times approach");
  EXPECT_LT(std::fabs(force_at_end(pulled, 1)[2]), 1e-3 * force);
  EXPECT_LT(std::fabs(force_at_end(off, 1)[2]), 1e-3 * force);
}

// Pushed and sheared by less than friction bears: as if attached.
TEST(FreedPlaces, StickBelowFriction) {
  constexpr double kShare = 0.5, kMu = 0.4;
  const Row path = on_path({0, 0, -kPush}, {kShare * 2.0 * kMu * kPush, 0, 0});
  Row whole = path;
  RowOfGrains freed(MPI_COMM_WORLD, loose(path, kMu)), attached(MPI_COMM_WORLD, whole);
  const auto f = force_at_end(freed), a = force_at_end(attached);
  EXPECT_LT(std::fabs(f[0]), 0.6 * kMu * f[2]);
  test::expect_within(std::fabs(f[2] / a[2] - 1.0), 5e-3, "pressure against that of links");
  test::expect_within(std::fabs(f[0] / a[0] - 1.0), 1e-2, "shear against that of links");
}

TEST(FreedPlaces, SlideWithMuN) {
  for (double mu : {0.0, 0.3}) {
    RowOfGrains host(MPI_COMM_WORLD, loose(on_path({0, 0, -kPush}, {3.0 * kPush, 0, 0}), mu));
    const auto f = force_at_end(host);
    test::expect_within(std::fabs(-f[0] / f[2] - mu), 0.01 * std::max(mu, 0.1), "force of friction over the normal one, less mu");
    const CementTotals t = host.cement->totals(0.1);
    if (mu > 0.0) EXPECT_GT(t.rubbed, 0.1 * t.external_work);
    else EXPECT_EQ(t.rubbed, 0.0);
    test::expect_within(std::fabs(t.imbalance), 0.01, "imbalance");
    EXPECT_NEAR(t.external_work, host.sum(host.work), 1e-3 * t.external_work);
  }
}

// The cement comes off by failure, and is pushed back. The points beside the grain carry nothing, the place follows the next.
Row broken_and_closed(double friction, bool split) {
  Row r;
  r.friction = friction;
  r.split = split;
  r.B0 = 9.6e3;
  r.path = [](double t) {
    const double open = 3e-6, close = 4.5e-6, far = 2e-6;
    const Ramp out{0.0, 1.5e-6}, back{1.7e-6, 3.6e-6}, slide{3.8e-6, 5e-6};
    (void)open, (void)close;
    Way w{};
    w.way[2] = far * out.share(t) - (far + 2.0 * kPush) * back.share(t);
    w.velocity[2] = far * out.rate(t) - (far + 2.0 * kPush) * back.rate(t);
    w.way[0] = 5.0 * kPush * slide.share(t);
    w.velocity[0] = 5.0 * kPush * slide.rate(t);
    return w;
  };
  return r;
}

TEST(FreedPlaces, BrokenBondCarriesCompressionAgain) {
  RowOfGrains host(MPI_COMM_WORLD, broken_and_closed(0.3, false));
  host.setup();
  for (int n = 0; n < 14; ++n) {
    host.run(100);
    const CementTotals t = host.cement->totals(0.1);
    std::printf("%d tension %g fx %g failed %g touching %g rubbed %g imbalance %g deepest %g\n", host.number, host.tension(0),
                host.cement->bond_states()[0].force[1][0], t.failed, 0.0, t.rubbed, t.imbalance, 0.0);
  }
}

}  // namespace
}  // namespace mpdem
