// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The implicit step of the damage once more, as plainly as it can be put: along the direction
// of the drive, the first place (in steps of a constant factor over six decades up to the
// cut-off, then bisected) where the drive has come down to the threshold; the direction is
// taken again there, three times at most. From any state, not only those a path leads to.
#include <sstream>

#include "damage_reference.h"

namespace mpdem {
namespace {

using test::Matrix;
using test::tensor;

struct PlainStep {
  const test::DamageReference& reference;
  DamageParameters p;
  Matrix strain;

  Matrix drive(const Matrix& D) const {
    const Matrix Y = reference.force(strain, D);
    return p.monotone ? test::positive_part(Y) : Y;
  }
  static double largest(const Matrix& D) { return Eigen::SelfAdjointEigenSolver<Matrix>(D).eigenvalues()[2]; }

  template <class F>
  static double bisect(double in, double out, F outside) {
    for (int i = 0; i < 200; ++i) {
      const double m = 0.5 * (in + out);
      if (m == in || m == out) break;
      (outside(m) ? out : in) = m;
    }
    return in;
  }

  // True if the point fails.
  bool operator()(Matrix& D) const {
    const Matrix start = D;
    if (test::equivalent(drive(start)) <= p.B0 * (1 + 1e-14)) return false;
    Matrix N = drive(start).normalized();
    for (int iteration = 0; iteration < 3; ++iteration) {
      const double top = bisect(0.0, 10.0, [&](double x) { return largest(start + x * N) >= p.Dcut; });
      const auto inside = [&](double x) { return test::equivalent(drive(start + x * N)) <= p.B0; };
      double low = 0.0, high = -1.0;
      for (int k = 0; k <= 16; ++k) {
        const double x = top * std::pow(10.0, 6.0 * (k / 16.0 - 1.0));
        if (inside(x)) {
          high = x;
          break;
        }
        low = x;
      }
      if (high < 0.0) {
        D = start + top * N;
        return true;
      }
      D = start + bisect(low, high, inside) * N;
      const Matrix before = N;
      N = drive(D).normalized();
      if ((N - before).norm() <= 1e-10) break;
    }
    return false;
  }
};

// Loads between `from` and `to` times the threshold.
void expect_plain_step(bool monotone, double from, double to, double largest_damage) {
  const TensorDamage law = test::law_of(monotone);
  const test::DamageReference reference(test::calcite());
  test::Random random(201);
  test::Worst worst;
  int failed = 0, other = 0;
  for (int n = 0; n < 60; ++n) {
    Sym3<vd> strain{}, damage{};
    Matrix expected[kLanes];
    bool fails[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const Matrix D = random.damage(largest_damage);
      const Matrix e = test::strain_at(law, random.uniform(from, to), random.sym(), D);
      test::set_tensor(damage, l, D);
      test::set_tensor(strain, l, e);
      expected[l] = D;
      fails[l] = PlainStep{reference, law.parameters(), e}(expected[l]);
    }
    const TensorDamage::Update u = law.update(strain, strain, damage, splat_mask(true));
    for (int l = 0; l < kLanes; ++l) {
      failed += fails[l];
      other += bool(u.failed[l]) != fails[l];
      worst.add(tensor(damage, l) - expected[l], 1.0);
    }
  }
  std::ostringstream what;
  what << "D, " << from << " to " << to << " times the threshold, D so far up to " << largest_damage;
  expect_within(worst, 1e-12, what.str());
  EXPECT_EQ(other, 0) << what.str();
  if (from >= 1.2) {
    EXPECT_GT(failed, 0) << what.str();
  }
}

void expect_plain_steps(bool monotone) {
  for (double D : {0.0, 0.5, 0.85}) {
    expect_plain_step(monotone, 1.0, 1.2, D);
    expect_plain_step(monotone, 1.2, 3.0, D);
    expect_plain_step(monotone, 3.0, 10.0, D);
  }
}

TEST(TensorDamageRoot, MonotoneFromAnyState) { expect_plain_steps(true); }
TEST(TensorDamageRoot, FullFromAnyState) { expect_plain_steps(false); }

}  // namespace
}  // namespace mpdem
