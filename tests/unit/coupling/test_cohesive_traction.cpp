// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "coupling/cohesive_traction.h"

#include <algorithm>
#include <cmath>

#include "bounce.h"
#include "linked_bonds.h"

namespace mpdem {
namespace {

constexpr TractionStiffness kStiff{900.0, 250.0};
constexpr double kTn = 3.0, kTt = 2.0, kGn = 0.02, kGt = 0.05;

LawValues values(double tn = kTn, double tt = kTt, double Gn = kGn, double Gt = kGt) {
  LawValues v;
  v.set("tn", tn);
  v.set("tt", tt);
  v.set("Gn", Gn);
  v.set("Gt", Gt);
  return v;
}

// One link on a path of separations (n, t): work of its traction by trapezoids, and what became of it. released: what a link under
// compression releases as it softens and debonds.
struct Path {
  CohesiveTraction law{kStiff, values()};
  CohesiveTraction::State state{};
  double n = 0, t = 0, work = 0, dissipated = 0, released = 0, stored = 0, peak = 0, d = 0;
  bool debond = false;

  void go(double to_n, double to_t, int steps) {
    const double from_n = n, from_t = t;
    TractionSecant before = law.secant(separation(), state);
    for (int i = 1; i <= steps; ++i) {
      const double dn = (to_n - from_n) / steps, dt = (to_t - from_t) / steps, old_n = n, old_t = t;
      n = from_n + i * dn;
      t = from_t + i * dt;
      const double pressed = law.secant(separation(), state).kn[0];
      const TractionUpdate u = law.update(separation(), state);
      dissipated += u.dissipated[0];
      debond = debond || u.debond[0];
      const TractionSecant k = law.secant(separation(), state);
      if (n < 0.0) released += 0.5 * (pressed - k.kn[0]) * n * n;
      work += 0.5 * ((before.kn[0] * old_n + k.kn[0] * n) * dn + (before.kt[0] * old_t + k.kt[0] * t) * dt);
      peak = std::max(peak, std::hypot(k.kn[0] * n, k.kt[0] * t));
      before = k;
    }
    stored = law.energy(separation(), state)[0];
    d = state.d[0];
  }
  LinkSeparation separation() const { return {splat(n), splat(n * n + t * t)}; }
};

TEST(CohesiveTraction, TakesItsStrengthAndEnergyOfEitherMode) {
  for (int steps : {7, 20000}) {
    Path opening, shear;
    opening.go(2.01 * kGn / kTn, 0.0, steps);
    shear.go(0.0, -2.01 * kGt / kTt, steps);
    for (const Path* p : {&opening, &shear}) {
      const bool open = p == &opening;
      EXPECT_TRUE(p->debond);
      EXPECT_EQ(p->d, 1.0);
      EXPECT_EQ(p->stored, 0.0);
      EXPECT_EQ(p->released, 0.0);
      EXPECT_NEAR(p->dissipated / (open ? kGn : kGt), 1.0, 1e-12);
      if (steps < 1000) continue;
      EXPECT_NEAR(p->work / (open ? kGn : kGt), 1.0, 1e-4);
      EXPECT_NEAR(p->peak / (open ? kTn : kTt), 1.0, 1e-3);
    }
    Path held;
    held.go(1.99 * kGn / kTn, 0.0, steps);
    EXPECT_FALSE(held.debond);
  }
}

// Along a straight path the share of shear in the energy stays constant.
TEST(CohesiveTraction, MixesByEnergyAndStress) {
  for (double angle : {0.2, 0.7, 1.2}) {
    Path p;
    const double cn = std::cos(angle), ct = std::sin(angle), e = kStiff.kn * cn * cn + kStiff.kt * ct * ct, B = kStiff.kt * ct * ct / e;
    p.go(cn, ct, 200000);
    EXPECT_TRUE(p.debond);
    EXPECT_NEAR(p.dissipated * ((1 - B) / kGn + B / kGt), 1.0, 1e-12);
    EXPECT_NEAR(p.work * ((1 - B) / kGn + B / kGt), 1.0, 1e-3);
    const double a = 1.0 / std::hypot(kStiff.kn * cn / kTn, kStiff.kt * ct / kTt);  // where the stresses reach the strength
    EXPECT_NEAR(p.peak / (a * std::hypot(kStiff.kn * cn, kStiff.kt * ct)), 1.0, 2e-2);
  }
}

TEST(CohesiveTraction, DamageNeverHeals) {
  Path p;
  p.go(1.0 * kGn / kTn, 0.0, 5000);
  const double d = p.d, spent = p.dissipated;
  EXPECT_GT(d, 0.5);
  EXPECT_LT(d, 1.0);
  p.go(0.0, 0.0, 5000);
  EXPECT_EQ(p.d, d);
  EXPECT_EQ(p.dissipated, spent);
  EXPECT_NEAR(p.work / spent, 1.0, 1e-4);  // back to the start along a straight line
  p.go(1.0 * kGn / kTn, 0.0, 100);
  EXPECT_EQ(p.d, d);
  EXPECT_NEAR(p.law.secant(p.separation(), p.state).kn[0], (1 - d) * kStiff.kn, 1e-10);
  p.go(-1.0, 0.0, 100);  // far into the grain
  EXPECT_EQ(p.d, d);
  EXPECT_NEAR(p.law.secant(p.separation(), p.state).kn[0], (1.0 - 0.5 * d) * kStiff.kn, 1e-10);
  Path fresh;
  fresh.go(-1.0, 0.0, 100);
  EXPECT_EQ(fresh.d, 0.0);
  EXPECT_EQ(fresh.law.secant(fresh.separation(), fresh.state).kn[0], kStiff.kn);
}

// Some links debond under compression, some debond open, some do not debond at all.
TEST(CohesiveTraction, EnergyBalancesOnAnyPath) {
  test::Random random(331);
  int open = 0, pressed = 0, held = 0;
  for (int trial = 0; trial < 40; ++trial) {
    Path p;
    for (int leg = 0; leg < 12; ++leg) {
      p.go(random.uniform(-0.3, 1.0) * kGn / kTn, random.uniform(-1.0, 1.0) * (trial < 20 ? 1.0 : 4.0) * kGt / kTt, 4000);
      EXPECT_NEAR(p.work, p.stored + p.dissipated + p.released, 1e-3 * kGn) << trial << ' ' << leg;
    }
    EXPECT_GT(p.d, 0.0);
    ++(!p.debond ? held : p.released > 0.0 ? pressed : open);
  }
  EXPECT_GT(open, 0);
  EXPECT_GT(pressed, 0);
  EXPECT_GT(held, 0);
}

// A link is pressed by 0.002, then sheared until it debonds. The energy of the pressure is released; it is not damage.
TEST(CohesiveTraction, ReleasesWhatPressureStores) {
  constexpr double kIn = 0.002;
  Path p;
  p.go(-kIn, 0.0, 10);
  p.go(-kIn, 2.01 * kGt / kTt, 20000);
  EXPECT_TRUE(p.debond);
  EXPECT_EQ(p.stored, 0.0);
  EXPECT_NEAR(p.dissipated / kGt, 1.0, 1e-12);
  EXPECT_NEAR(p.released / (0.5 * kStiff.kn * kIn * kIn), 1.0, 1e-12);
  EXPECT_NEAR(p.work, p.dissipated + p.released, 1e-4 * kGt);
}

// Nothing but a link holds a node. The mass of the node leaves the undamaged link just stable at this step (added_mass.h).
// The node flies against the closed link and off again. The test takes the mean, over the phases of the steps, of the energy
// that it leaves with. The mean is 3.0 with the whole stiffness.
TEST(CohesiveTraction, ANodeThatBouncesGainsLittle) {
  const CohesiveTraction law(kStiff, values());
  const double mass = 1.05 * kStiff.kn / 4.0;  // the step is 1
  const double mean = test::energy_after_bounce(test::Random(91), [&](double x) {
    return law.secant({splat(x), splat(x * x)}, {splat(0.9999)}).kn[0] / mass;
  });
  EXPECT_GT(mean, 0.9);
  EXPECT_LT(mean, 1.05);
}

// On a path whose mode changes the energy is that of the path. This holds with equal energies of both modes too.
// With r = lambdaf/lambda0 of a mode, a link that opens to the damage 1/2 has taken G/(r + 1).
TEST(CohesiveTraction, EnergyOfTwoModesIsThatOfThePath) {
  const double G = 0.02, r[2] = {2.0, 100.0}, k[2] = {kStiff.kn, kStiff.kt};
  const double strength[2] = {std::sqrt(2.0 * G * k[0] / r[0]), std::sqrt(2.0 * G * k[1] / r[1])};
  for (int first : {0, 1}) {
    const int last = 1 - first;
    const double half = 2.0 * r[first] / (r[first] + 1.0) * strength[first] / k[first], end = 2.01 * G / strength[last];
    Path p{CohesiveTraction(kStiff, values(strength[0], strength[1], G, G))};
    p.go(first == 0 ? half : 0.0, first == 1 ? half : 0.0, 20000);
    EXPECT_NEAR(p.d, 0.5, 1e-12);
    p.go(0.0, 0.0, 1);
    p.go(last == 0 ? end : 0.0, last == 1 ? end : 0.0, 20000);
    EXPECT_TRUE(p.debond);
    EXPECT_NEAR(p.dissipated / G, 1.0 + 1.0 / (r[first] + 1.0) - 1.0 / (r[last] + 1.0), 1e-9);
    EXPECT_NEAR(p.dissipated / G, first == 0 ? 1.3234 : 0.6766, 1e-4);
    EXPECT_NEAR(p.work / p.dissipated, 1.0, 1e-3);
  }
}

TEST(CohesiveTraction, RefusesAnEnergyBelowTheElasticOne) {
  const auto trouble = [](const LawValues& v) { return CohesiveTraction(kStiff, v).trouble(); };
  EXPECT_EQ(trouble(values()), "");
  EXPECT_NE(trouble(values(3.0, 2.0, 0.00499)).find("'Gn 0.00499' must be above 0.005"), std::string::npos);
  EXPECT_NE(trouble(values(3.0, 2.0, 0.02, 0.0079)).find("'Gt 0.0079' must be above 0.008"), std::string::npos);
}

// Links of two bonds whose grains move away.
TEST(CohesiveTraction, LinksKeepItsStateAndLetGo) {
  PenaltyParameters p = test::penalty(true, 0.0);
  p.law = std::make_shared<CohesiveTraction>(kStiff, values());
  test::Scene s(332, p);
  s.place_grains(0.008, 0.0);
  for (Bond& b : s.bonds) {
    std::vector<Link>& links = b.points.links;
    double area = 0.0, spent = 0.0;
    for (const Link& k : links) area += k.attached * k.area;
    b.links.update_and_add_force(b.points, b.grid, s.ends_of(b), test::kDt, b.link_step);
    spent += b.link_step.dissipated;
    EXPECT_GT(spent, 0.0);
    EXPECT_TRUE(std::any_of(links.begin(), links.end(), [](const Link& k) { return k.attached && k.state[0] > 0.0 && k.state[0] < 1.0; }));
    b.links.update_and_add_force(b.points, b.grid, s.ends_of(b), test::kDt, b.link_step);
    EXPECT_EQ(b.link_step.dissipated, 0.0);
    EXPECT_TRUE(b.link_step.debond.empty());

    PenaltyLinks anew = s.links_anew(b);
    double stored = 0.0, of_anew = 0.0;
    b.links.add_spring_energy(b.grid, s.ends_of(b), stored);
    anew.add_spring_energy(b.grid, s.ends_of(b), of_anew);
    EXPECT_GT(stored, 0.0);
    EXPECT_NEAR(of_anew / stored, 1.0, 1e-14);

    const auto held = std::count_if(links.begin(), links.end(), [](const Link& k) { return k.attached; });
    for (double& u : b.grid.displacement) u *= 100.0;
    b.links.update_and_add_force(b.points, b.grid, s.ends_of(b), test::kDt, b.link_step);
    spent += b.link_step.dissipated;
    const std::vector<int>& gone = b.link_step.debond;
    EXPECT_TRUE(std::is_sorted(gone.begin(), gone.end()));
    for (int k : gone) EXPECT_TRUE(!links[k].attached && links[k].keeps_added_mass && links[k].state[0] == 1.0);
    EXPECT_EQ(held - static_cast<long>(gone.size()), std::count_if(links.begin(), links.end(), [](const Link& k) { return k.attached; }));
    EXPECT_GT(gone.size(), links.size() / 2);
    EXPECT_LT(spent, kGt * area);
    EXPECT_TRUE(b.points.meta.front().failed == 0);
  }
}

// Links that are pressed and almost debond, all in one step: what is counted is the work of the step's forces. With friction contact points
// open, and their energy is not counted with the links.
TEST(CohesiveTraction, PressureThatEndsIsReleasedByItsWork) {
  constexpr double kIn = 0.02, kSlide = 0.08;
  for (double friction : {-1.0, 0.3}) {
    PenaltyParameters p = test::penalty(true, 0.0);
    p.law = std::make_shared<CohesiveTraction>(kStiff, values());
    p.friction = friction;
    test::Scene s(333, p);
    for (Bond& b : s.bonds) {
      for (Link& k : b.points.links) k.state[0] = 1.0 - 1e-9;
      b.links = s.links_anew(b);
      const BondRecord& record = s.records[b.row];
      const test::Vector n = (Eigen::Map<const test::Vector>(record.centre[1]) - Eigen::Map<const test::Vector>(record.centre[0]))
                                 .normalized(),
                         t = n.unitOrthogonal();
      const test::Vector pressed = -kIn * n, moves = pressed + kSlide * t;
      const auto find_forces = [&](double& energy) {
        b.grid.clear_force();
        b.links.add_force(b.grid, s.ends_of(b));
        energy = 0.0;
        b.links.add_spring_energy(b.grid, s.ends_of(b), energy);
        return b.grid.force;
      };
      for (std::size_t i = 0; i < b.grid.displacement.size(); ++i) b.grid.displacement[i] = pressed[i % 3];
      double before, after, work = 0.0;
      const std::vector<double> f = find_forces(before);
      for (std::size_t i = 0; i < b.grid.velocity.size(); ++i) {
        b.grid.velocity[i] = moves[i % 3] / test::kDt;
        b.grid.displacement[i] += moves[i % 3];
      }
      b.links.update_and_add_force(b.points, b.grid, s.ends_of(b), test::kDt, b.link_step);
      const std::vector<double> g = find_forces(after);
      for (std::size_t i = 0; i < f.size(); ++i) work += 0.5 * (f[i] + g[i]) * moves[i % 3];
      EXPECT_GT(before, 0.0);
      EXPECT_LT(after, 1e-6 * before);
      EXPECT_NEAR((b.link_step.released + b.link_step.dissipated) / (before - after - work), 1.0, 1e-6) << friction;
      EXPECT_GT(std::abs(work / before), 0.5);  // the step is large enough to tell
    }
  }
}

}  // namespace
}  // namespace mpdem
