// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "material/effective_strain.h"

#include "damage_reference.h"

namespace mpdem {
namespace {

using test::DamageReference;
using test::Matrix;
using test::sym3;
using test::tensor;

constexpr double kTolerance = 1e-13;

TEST(EffectiveStrain, IsTheHarmonicMeanInPrincipalAxes) {
  test::Random random(41);
  test::Worst map, amplified;
  for (int n = 0; n < 20000; ++n) {
    const Matrix D = random.damage(0.9), e = random.sym();
    const EffectiveStrain<double> effective(sym3(D));
    const Matrix exact = DamageReference::effective(e, D), phi_x = (Matrix::Identity() - D).inverse() * exact;
    map.add(tensor(effective(sym3(e))) - exact, e.norm());
    const Mat3<double> y = effective.amplified(sym3(e));
    for (int i = 0; i < 9; ++i) amplified.add(std::fabs(y.a[i / 3][i % 3] - phi_x(i / 3, i % 3)) / phi_x.norm());
  }
  expect_within(map, kTolerance, "M^-1:e");
  expect_within(amplified, kTolerance, "phi M^-1:e");
}

// Principal values of the damage are equal, vanish or are extreme, along the axes and not.
TEST(EffectiveStrain, SpecialDamage) {
  test::Random random(42);
  test::Worst map;
  const double values[] = {0.0, 1e-12, 0.3, 0.3 + 1e-9, 0.9};
  for (double a : values)
    for (double b : values)
      for (double c : values)
        for (int n = 0; n < 4; ++n) {
          const test::Vector v(a, b, c);
          const Matrix D = n == 0 ? Matrix(v.asDiagonal()) : random.with_values(v), e = random.sym();
          map.add(tensor(EffectiveStrain<double>(sym3(D))(sym3(e))) - DamageReference::effective(e, D), e.norm());
        }
  expect_within(map, kTolerance, "M^-1:e");
}

TEST(EffectiveStrain, WithoutDamageNothingChanges) {
  test::Random random(43);
  const EffectiveStrain<double> effective(sym3(Matrix::Zero()));
  for (int n = 0; n < 100; ++n) {
    const Matrix e = random.sym();
    EXPECT_EQ(tensor(effective(sym3(e))), e);
  }
}

// M : (M^-1 : e) = e with M : s = sym(phi s), and (M^-1:a):b = a:(M^-1:b).
TEST(EffectiveStrain, InvertsTheAmplificationAndIsSymmetric) {
  test::Random random(44);
  test::Worst inverse, symmetry;
  for (int n = 0; n < 20000; ++n) {
    const Matrix D = random.damage(0.9), a = random.sym(), b = random.sym();
    const EffectiveStrain<double> effective(sym3(D));
    const Matrix x = tensor(effective(sym3(a)));
    const double size = (Matrix::Identity() - D).inverse().norm();
    inverse.add(DamageReference::amplified(x, D) - a, size * a.norm());
    const double other = test::contract(a, tensor(effective(sym3(b))));
    symmetry.add(std::fabs(test::contract(x, b) - other) / (a.norm() * b.norm()));
  }
  expect_within(inverse, kTolerance, "M:M^-1:e - e");
  expect_within(symmetry, kTolerance, "major symmetry");
}

TEST(EffectiveStrain, LanesAgreeWithTheScalar) {
  test::Random random(45);
  Sym3<vd> D{}, e{};
  for (int l = 0; l < kLanes; ++l) {
    test::set_tensor(D, l, random.damage(0.9));
    test::set_tensor(e, l, random.sym());
  }
  const Sym3<vd> x = EffectiveStrain<vd>(D)(e);
  test::Worst worst;
  for (int l = 0; l < kLanes; ++l) {
    const EffectiveStrain<double> scalar(sym3(test::tensor(D, l)));
    worst.add(test::tensor(x, l) - tensor(scalar(sym3(test::tensor(e, l)))), 1.0);
  }
  expect_within(worst, 1e-14, "difference");
}

}  // namespace
}  // namespace mpdem
