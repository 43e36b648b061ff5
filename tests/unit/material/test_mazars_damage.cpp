// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "material/mazars_damage.h"

#include <gtest/gtest.h>

#include "damage_reference.h"

namespace mpdem {
namespace {

using test::Matrix;
using test::on_all_lanes;

constexpr double kStart = 2e-4, kAt = 0.8, kBt = 4e3, kCutoff = 0.95;

MazarsDamage mazars(double cutoff = kCutoff, double At = kAt, double interface = 1.0) {
  LawValues v;
  v.set("kappa0", kStart);
  v.set("At", At);
  v.set("Bt", kBt);
  v.set("cutoff", cutoff);
  v.set("interface", interface);
  return MazarsDamage(VtiElasticity(test::calcite()), v);
}

double formula(double kappa, double At) { return 1.0 - (1.0 - At) * kStart / kappa - At * std::exp(-kBt * (kappa - kStart)); }

// Strains of uniaxial stress along axis `a` of the material, for a strain e along it.
Matrix uniaxial(int a, double e) {
  const VtiConstants c = test::calcite();
  Matrix m = Matrix::Zero();
  if (a == 2) m.diagonal() << -c.nu_zp * e, -c.nu_zp * e, e;
  else m.diagonal() << e, -c.nu_p * e, -c.nu_zp * c.Ep / c.Ez * e;
  return m;
}

// Pulled along the axis and in the plane, in any frame of the lab: stress, damage, failure and energy.
TEST(Mazars, UniaxialTensionFollowsTheFormula) {
  const VtiConstants c = test::calcite();
  for (const double At : {kAt, 1.0})
    for (const int a : {0, 2}) {
      const MazarsDamage law = mazars(kCutoff, At);
      const double E = a == 2 ? c.Ez : c.Ep, unit = E * kStart;
      MazarsDamage::State s{};
      Matrix before = Matrix::Zero(), along = Matrix::Zero();
      along(a, a) = 1.0;
      test::Worst damage, stress;
      double work = 0.0, dissipated = 0.0, released = 0.0, last = 0.0, failed_at = 0.0, peak = 0.0;
      const double step = 0.9997e-3 * kStart;  // no step ends at the threshold
      for (int n = 1; failed_at == 0.0 && n < 100000; ++n) {
        const double e = n * step;
        const Matrix strain = uniaxial(a, e);
        const LawUpdate u = law.update(on_all_lanes(before), on_all_lanes(strain), s, splat_mask(true), splat(1.0), 1.0);
        before = strain;
        EXPECT_EQ(u.grown[3] != 0, e > kStart);
        const double now = test::tensor(u.stress, 3)(a, a), d = e > kStart ? formula(e, At) : 0.0;
        dissipated += u.dissipated[3];
        released += u.released[3];
        if (u.failed[3]) {
          failed_at = e;
          EXPECT_EQ(test::tensor(u.stress, 3), Matrix(Matrix::Zero()));
          work += 0.5 * (last + (1.0 - d) * E * e) * step;
          EXPECT_NEAR(law.largest_damage(s)[3], kCutoff, 1e-12);
          break;
        }
        work += 0.5 * (last + now) * step;
        last = now;
        peak = std::max(peak, now);
        damage.add(std::fabs(law.largest_damage(s)[3] - d));
        stress.add(test::tensor(u.stress, 3) - (1.0 - d) * E * e * along, unit);
      }
      expect_within(damage, 1e-13, "damage");
      expect_within(stress, 1e-12, "stress over E kappa0");
      EXPECT_GE(formula(failed_at, At), kCutoff);
      EXPECT_LT(formula(failed_at - step, At), kCutoff);
      // Work, and what the law counts, against the closed form that it prints.
      const ImpliedStrength s_of = law.implied_strength(E);
      EXPECT_NEAR(s_of.failure_strain, failed_at, step);
      EXPECT_NEAR(work / s_of.work_per_volume, 1.0, 1e-3);
      EXPECT_NEAR((dissipated + released) / work, 1.0, 1e-3);
      EXPECT_NEAR(released / (0.5 * E * failed_at * failed_at * (1.0 - kCutoff)), 1.0, 2e-3);
      EXPECT_NEAR(peak / s_of.tensile_strength, 1.0, 1e-3);
    }
}

// Energy of any path, with rotations and unloading: the trapezoidal work is what is stored and what was counted.
double imbalance(const MazarsDamage& law, int steps) {
  test::Random random(301);
  const Matrix A = 3e-3 * random.sym(), B = 3e-3 * random.sym();
  MazarsDamage::State s{};
  Matrix before = Matrix::Zero(), stress = Matrix::Zero();
  double work = 0.0, counted = 0.0;
  for (int n = 1; n <= steps; ++n) {
    const double t = static_cast<double>(n) / steps;
    const Matrix strain = std::sin(5.0 * t) * t * A + std::sin(3.0 * t) * t * B;
    const LawUpdate u = law.update(on_all_lanes(before), on_all_lanes(strain), s, splat_mask(true), splat(1.0), 1.0);
    EXPECT_FALSE(u.failed[0]);
    const Matrix now = test::tensor(u.stress, 0);
    work += 0.5 * test::contract(stress + now, strain - before);
    counted += u.dissipated[0];
    EXPECT_GE(u.dissipated[0], u.grown[0] ? -1e-12 * work : 0.0);
    before = strain;
    stress = now;
  }
  EXPECT_GT(counted, 0.3 * work);
  return (work - counted - 0.5 * test::contract(stress, before)) / work;
}

TEST(Mazars, EnergyBalances) {
  const MazarsDamage law = mazars(0.9999999);
  test::expect_within(std::fabs(imbalance(law, 1000)), 1e-5, "imbalance over the work");
}

TEST(Mazars, CompressionIsElasticUntilTheStrainAcross) {
  const MazarsDamage law = mazars();
  const double across = test::calcite().nu_zp * std::sqrt(2.0);
  for (const double level : {0.999, 1.001}) {
    MazarsDamage::State s{};
    const Sym3<vd> strain = on_all_lanes(uniaxial(2, -level * kStart / across));
    const LawUpdate u = law.update(Sym3<vd>{}, strain, s, splat_mask(true), splat(1.0), 1.0);
    EXPECT_EQ(u.grown[5] != 0, level > 1.0);
  }
}

// The strength of a lane multiplies the strains of its curve; lanes do not touch each other.
TEST(Mazars, StrengthAndLanes) {
  const MazarsDamage law = mazars(kCutoff, kAt, 0.5);
  EXPECT_EQ(law.interface(), 0.5);
  MazarsDamage::State s{}, alone{};
  vd strength = splat(1.0);
  strength[2] = 0.5;
  Sym3<vd> strain = on_all_lanes(uniaxial(2, 1.5 * kStart));
  const LawUpdate u = law.update(Sym3<vd>{}, strain, s, ~test::only_lane(7), strength, 1.0);
  EXPECT_NEAR(law.largest_damage(s)[2], formula(3.0 * kStart, kAt), 1e-13);
  EXPECT_NEAR(law.largest_damage(s)[1], formula(1.5 * kStart, kAt), 1e-13);
  EXPECT_EQ(s.kappa[7], 0.0);
  EXPECT_EQ(test::tensor(u.stress, 7), Matrix(Matrix::Zero()));
  EXPECT_EQ(law.drive(strain, s).B[7], kStart);
  // the trial misses no lane that grows, and shows the lanes that may not
  const LawTrial t = law.trial(strain, alone);
  for (int l = 0; l < kLanes; ++l) EXPECT_GT(std::sqrt(t.square_bound[l]), strength[l] * t.least_threshold[l]);
  const LawTrial below = law.trial(on_all_lanes(uniaxial(2, 0.8 * kStart)), alone);
  EXPECT_LT(std::sqrt(below.square_bound[0]), below.least_threshold[0]);
}

TEST(Mazars, BoundIsNeverBelowTheDrive) {
  test::Random random(302);
  const MazarsDamage law = mazars();
  for (int n = 0; n < 200; ++n) {
    const Sym3<vd> e = on_all_lanes(1e-3 * random.sym());
    const double drive = law.drive(e, MazarsDamage::State{}).Yeq[0];
    EXPECT_GE(MazarsDamage::square_bound(law.elasticity().stress(e), e)[0] * (1.0 + 1e-12), drive * drive);
  }
}

// The curves by which the crack of `nonlocal` takes its energy, from the formula: with x = -ln(1 - d) the compliance is e^x, the threshold
// kappa/kappa0, and dx/dkappa = d'/(1 - d). The slope is that of a difference over 1e-4.
TEST(Mazars, SofteningCurveIsThatOfTheFormula) {
  const std::optional<SofteningCurve> curve = mazars().softening_curve();
  ASSERT_TRUE(curve);
  test::Worst value, slope;
  for (const double over : {1.0, 1.001, 1.5, 3.0, 10.0}) {
    const double kappa = over * kStart, kept = 1.0 - formula(kappa, kAt), x = -std::log(kept);
    const double rate = (1.0 - kAt) * kStart / (kappa * kappa) + kAt * kBt * std::exp(-kBt * (kappa - kStart));
    const SofteningCurve::Value c = curve->compliance(x), k = curve->threshold(x);
    value.add(c.value - x, std::to_string(over));
    value.add(c.slope - 1.0, std::to_string(over));
    value.add(k.value - std::log(over), std::to_string(over));
    slope.add(k.slope / (kept / (rate * kappa)) - 1.0, std::to_string(over));
  }
  expect_within(value, 1e-12, "values");
  expect_within(slope, 2e-4, "slope of the threshold");
}

TEST(Mazars, StateFromATensor) {
  const MazarsDamage law = mazars();
  double state[6] = {};
  const double same[6] = {0.6, 0.6, 0.6, 0, 0, 0}, other[6] = {0.6, 0.5, 0.6, 0, 0, 0}, whole[6] = {1, 1, 1, 0, 0, 0};
  law.state_from_tensor(same, state);
  EXPECT_NEAR(formula(state[0], kAt), 0.6, 1e-12);
  EXPECT_THROW(law.state_from_tensor(other, state), std::domain_error);
  EXPECT_THROW(law.state_from_tensor(whole, state), std::domain_error);
}

}  // namespace
}  // namespace mpdem
