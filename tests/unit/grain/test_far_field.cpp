// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "grain/far_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "grain/patch_compliance.h"

namespace mpdem {
namespace {

using Matrix6 = FarField::Matrix6;

const GrainElasticity kGlass{70e9, 0.22};
constexpr double kRadius = 5e-3;

Eigen::Matrix3d turned(double angle, const Eigen::Vector3d& axis) { return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(); }

// Moments and rotations times the radius, so that all numbers have one unit.
Matrix6 scaled(const Matrix6& c) {
  Eigen::Matrix<double, 6, 1> s;
  s << 1, 1, 1, kRadius, kRadius, kRadius;
  return s.asDiagonal() * c * s.asDiagonal();
}

TEST(FarField, IsReciprocalAndTurnsWithTheGrain) {
  const Eigen::Matrix3d first = turned(0.4, {1, 2, -1}), second = turned(1.7, {0, 1, 0.3});
  const FarField a(0.2, 0.4, first), b(0.0, 0.3, second);
  const Matrix6 c = scaled(a.moved_by(b, kGlass, kRadius)), transposed = scaled(b.moved_by(a, kGlass, kRadius)).transpose();
  EXPECT_LT((c - transposed).norm(), 1e-12 * c.norm());
  const Eigen::Matrix3d turn = turned(2.1, {3, -1, 1});
  const Matrix6 other = scaled(FarField(0.2, 0.4, turn * first).moved_by(FarField(0.0, 0.3, turn * second), kGlass, kRadius));
  EXPECT_LT((other - c).norm(), 1e-9 * c.norm());
}

// A patch by itself, with loads that do not bend it: the same sum over degrees as that of the modes, which goes further.
TEST(FarField, IsTheComplianceOfTheModes) {
  const SurfaceModes modes(0.0, 1.2, 5, 2);
  const PatchCompliance patch(modes, kGlass, kRadius);
  const Eigen::MatrixXd B = kRadius / kGlass.shear_modulus() * compliance_of_modes(modes, kGlass.nu), &g = patch.rigid();
  const Matrix6 inverse = Matrix6(g.transpose() * g).inverse(), expected = inverse * g.transpose() * B * g * inverse;
  const FarField field(0.0, 1.2, Eigen::Matrix3d::Identity());
  const Matrix6 found = field.moved_by(field, kGlass, kRadius);
  EXPECT_LT((scaled(found) - scaled(expected)).norm(), 4e-3 * scaled(expected).norm());
}

// The modes carry translations exactly, and rotations where they can be as the sine of an angle.
TEST(FarField, ModesMoveAsRigidBodies) {
  for (double inner : {0.0, 0.2}) {
    const PatchCompliance patch(SurfaceModes(inner, 0.4, 5, 2), kGlass, kRadius);
    const Matrix6 A = patch.rigid().transpose() * patch.rigid();
    const double area = 2.0 * M_PI * kRadius * kRadius * (std::cos(inner) - std::cos(0.4));
    EXPECT_NEAR(A(0, 0) / area, 1.0, 1e-12);
    EXPECT_NEAR(A(2, 2) / area, 1.0, 1e-12);
    const double z2 = (std::pow(std::cos(inner), 3) - std::pow(std::cos(0.4), 3)) / 3.0 / (std::cos(inner) - std::cos(0.4));
    EXPECT_NEAR(A(5, 5) / (area * kRadius * kRadius * (1.0 - z2)), 1.0, 1e-6);
  }
}

}  // namespace
}  // namespace mpdem
