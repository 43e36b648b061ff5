// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The step of the damage once more, as plainly as it can be put: along the direction
// of the drive, the first place (in steps of a constant factor over six decades up to the
// cut-off, then bisected) where the drive has come down to the threshold. The direction is that at the middle of
// the step near the surface; far from it, that at its start, taken again at the place found, three times at
// most. From any state, not only those a path leads to.
#include <sstream>

#include "damage_reference.h"

namespace mpdem {
namespace {

using test::Matrix;
using test::tensor;

struct PlainStep {
  const test::DamageReference& reference;
  DamageParameters p;
  Matrix before, strain;

  Matrix drive_at(const Matrix& e, const Matrix& D) const {
    const Matrix Y = reference.force(e, D);
    return p.monotone ? test::positive_part(Y) : Y;
  }
  Matrix drive(const Matrix& D) const { return drive_at(strain, D); }
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

  double range(const Matrix& start, const Matrix& N) const {
    return bisect(0.0, 10.0, [&](double x) { return largest(start + x * N) >= p.Dcut; });
  }

  Matrix middle_direction(const Matrix& start) const {
    const Matrix N = drive(start).normalized();
    const auto slope = [&](double h) {
      return (test::equivalent(drive(start + h * N)) - test::equivalent(drive(start - h * N))) / (2.0 * h);
    };
    const double tangent = (4.0 * slope(1e-5) - slope(2e-5)) / 3.0, top = range(start, N);
    const double growth = tangent < 0.0 ? std::min(top, (p.B0 - test::equivalent(drive(start))) / tangent) : top;
    const Matrix middle = drive_at(0.5 * (before + strain), start + 0.5 * growth * N);
    return test::contract(middle, N) > 0.5 * middle.norm() ? middle.normalized() : N;
  }

  // D along N; true if the point fails.
  bool along(const Matrix& N, const Matrix& start, Matrix& D, bool fine) const {
    const double top = range(start, N);
    const auto inside = [&](double x) { return test::equivalent(drive(start + x * N)) <= p.B0; };
    double low = 0.0, high = -1.0;
    for (int k = fine ? 1 : 0; k <= (fine ? 400 : 16); ++k) {
      const double x = fine ? top * k / 400.0 : top * std::pow(10.0, 6.0 * (k / 16.0 - 1.0));
      if (inside(x)) {
        high = x;
        break;
      }
      low = x;
    }
    D = start + (high < 0.0 ? top : bisect(low, high, inside)) * N;
    return high < 0.0;
  }

  bool operator()(Matrix& D) const {
    const Matrix start = D;
    const double Yeq = test::equivalent(drive(start));
    if (Yeq <= p.B0 * (1 + 1e-14)) return false;
    if (p.monotone && Yeq < 1.2 * p.B0) return along(middle_direction(start), start, D, true);
    Matrix N = drive(start).normalized();
    for (int iteration = 0; iteration < 3; ++iteration) {
      if (along(N, start, D, false)) return true;
      const Matrix last = N;
      N = drive(D).normalized();
      if ((N - last).norm() <= 1e-10) break;
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
    Sym3<vd> before{}, strain{}, damage{};
    Matrix expected[kLanes];
    bool fails[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const Matrix D = random.damage(largest_damage);
      const Matrix e = test::strain_at(law, random.uniform(from, to), random.sym(), D);
      const Matrix e_before = random.uniform(0.9, 1.0) * e + random.uniform(0.0, 0.2) * e.norm() * random.sym();
      test::set_tensor(damage, l, D);
      test::set_tensor(before, l, e_before);
      test::set_tensor(strain, l, e);
      expected[l] = D;
      fails[l] = PlainStep{reference, law.parameters(), e_before, e}(expected[l]);
    }
    const TensorDamage::Update u = law.update(before, strain, damage, splat_mask(true));
    for (int l = 0; l < kLanes; ++l) {
      failed += fails[l];
      other += bool(u.failed[l]) != fails[l];
      worst.add(tensor(damage, l) - expected[l], 1.0);
    }
  }
  std::ostringstream what;
  what << "D, " << from << " to " << to << " times the threshold, D so far up to " << largest_damage;
  expect_within(worst, test::kRootTolerance, what.str());
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
