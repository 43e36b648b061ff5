// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "condensed_bond.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "../numerics/cross_matrix.h"

namespace mpdem {

namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

Matrix3 matrix(const Mat3<double>& R) {
  Matrix3 m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = R.a[i][j];
  return m;
}

constexpr double kSmallAngle = 1e-4;

// Rotation vector of a small or large turn, less than half of one. Off the diagonal the sine is exact where the cosine has lost its digits.
Vector3 logarithm(const Matrix3& E) {
  const Vector3 twice_sine(E(2, 1) - E(1, 2), E(0, 2) - E(2, 0), E(1, 0) - E(0, 1));
  const double sine = 0.5 * twice_sine.norm(), cosine = 0.5 * (E.trace() - 1.0);
  const double angle = std::atan2(sine, cosine);
  return (sine > 1e-12 ? 0.5 * angle / sine : 0.5) * twice_sine;
}

Matrix3 exponential(const Vector3& t) {
  const double angle = t.norm();
  if (angle < kSmallAngle) {
    const Matrix3 T = cross(t);
    return Matrix3::Identity() + T * (Matrix3::Identity() + 0.5 * T * (Matrix3::Identity() + T / 3.0));
  }
  return Eigen::AngleAxisd(angle, t / angle).toRotationMatrix();
}

// exp(t + dt) = exp(J dt) exp(t)
Matrix3 left_jacobian(const Vector3& t) {
  const double a2 = t.squaredNorm(), a = std::sqrt(a2);
  const Matrix3 T = cross(t);
  if (a < kSmallAngle) return Matrix3::Identity() + 0.5 * T + T * T / 6.0;
  return Matrix3::Identity() + (1.0 - std::cos(a)) / a2 * T + (a - std::sin(a)) / (a2 * a) * T * T;
}

Matrix3 inverse_left_jacobian(const Vector3& t) {
  const double a2 = t.squaredNorm(), a = std::sqrt(a2);
  const Matrix3 T = cross(t);
  const double factor = a < kSmallAngle ? 1.0 / 12.0 : 1.0 / a2 - (1.0 + std::cos(a)) / (2.0 * a * std::sin(a));
  return Matrix3::Identity() - 0.5 * T + factor * T * T;
}

}  // namespace

void CondensedModel::add_node(double m, const Vector3& X, const Eigen::Matrix<double, 3, 6>& field) {
  const Vector3 Y = X - middle;
  Eigen::Matrix<double, 3, 6> P;
  P << Matrix3::Identity(), -cross(Y);
  Eigen::Matrix<double, 3, 12> both;
  both << P - field, field;
  M += m * both.transpose() * both;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) N.col(3 * a + b) += m * Y[b] * both.row(a).transpose();
}

void CondensedModel::pack(double* n) const {
  n = std::copy(middle.data(), middle.data() + 3, n);
  n = std::copy(K.data(), K.data() + 36, n);
  n = std::copy(M.data(), M.data() + 144, n);
  std::copy(N.data(), N.data() + 108, n);
}

void CondensedModel::unpack(const double* n) {
  std::copy(n, n + 3, middle.data());
  std::copy(n + 3, n + 39, K.data());
  std::copy(n + 39, n + 183, M.data());
  std::copy(n + 183, n + kNumbers, N.data());
}

void GrainLoads::add_to(GrainSide* side) const {
  for (int s = 0; s < 2; ++s)
    for (int d = 0; d < 3; ++d) {
      side[s].force[d] += of[s][d];
      side[s].torque[d] += of[s][3 + d];
    }
}

CondensedMotion::CondensedMotion(const CondensedModel& model, const Body& body, const GrainSide* side) {
  Matrix3 Q[2];
  for (int s = 0; s < 2; ++s) {
    Q[s] = matrix(side[s].R) * matrix(rotation_of(body.orientation[s])).transpose();
    r_[s] = Q[s] * (model.middle - vector(body.centre[s]));
    p_[s] = vector(side[s].x) + r_[s];
  }
  Q0_ = Q[0];
  theta_ = logarithm(Q[0].transpose() * Q[1]);
  Q_ = Q[0] * exponential(0.5 * theta_);
  d_ << Q_.transpose() * (p_[1] - p_[0]), theta_;
}

GrainLoads CondensedMotion::elastic(const CondensedModel& model) const {
  const Vector6 f = model.K * d_;
  const Vector3 of_delta = f.head<3>(), delta = d_.head<3>();
  // the axes turn with half of theta
  const Vector3 of_theta = f.tail<3>() + 0.5 * left_jacobian(-0.5 * theta_).transpose() * of_delta.cross(delta);
  const Vector3 F = -Q_ * of_delta;
  const Vector3 M = -Q0_ * (inverse_left_jacobian(theta_).transpose() * of_theta) + r_[1].cross(F);
  const Vector3 apart = p_[1] - r_[1] - (p_[0] - r_[0]), M0 = -M - apart.cross(F);
  GrainLoads l;
  for (int d = 0; d < 3; ++d) {
    l.of[1][d] = F[d];
    l.of[0][d] = -F[d];
    l.of[1][3 + d] = M[d];
    l.of[0][3 + d] = M0[d];
  }
  return l;
}

CondensedMotion::Vector12 CondensedMotion::of_sides(const double* first, const double* second) const {
  Vector12 q;
  const double* of[2] = {first, second};
  for (int s = 0; s < 2; ++s) {
    const Vector3 turn = vector(of[s] + 3);
    q.segment<3>(6 * s) = Q_.transpose() * (vector(of[s]) + turn.cross(r_[s]));
    q.segment<3>(6 * s + 3) = Q_.transpose() * turn;
  }
  return q;
}

CondensedMotion::Vector12 CondensedMotion::velocity(const GrainSide* side, double later) const {
  double v[2][6];
  for (int s = 0; s < 2; ++s)
    for (int d = 0; d < 3; ++d) {
      v[s][d] = side[s].v[d] + later * side[s].a[d];
      v[s][3 + d] = side[s].omega[d] + later * side[s].alpha[d];
    }
  return of_sides(v[0], v[1]);
}

CondensedMotion::Vector12 CondensedMotion::rate(const GrainSide* side) const {
  double a[2][6];
  for (int s = 0; s < 2; ++s) {
    const Vector3 w = vector(side[s].omega), to_axis = w.cross(w.cross(r_[s]));
    for (int d = 0; d < 3; ++d) {
      a[s][d] = side[s].a[d] + to_axis[d];
      a[s][3 + d] = side[s].alpha[d];
    }
  }
  return of_sides(a[0], a[1]);
}

CondensedMotion::Vector12 CondensedMotion::uniform(const double* g) const {
  const Vector3 of_axes = Q_.transpose() * vector(g);
  Vector12 q = Vector12::Zero();
  q.segment<3>(0) = q.segment<3>(6) = of_axes;
  return q;
}

GrainLoads CondensedMotion::loads(const Vector12& generalized) const {
  GrainLoads l;
  for (int s = 0; s < 2; ++s) {
    const Vector3 f = Q_ * generalized.segment<3>(6 * s), m = Q_ * generalized.segment<3>(6 * s + 3) + r_[s].cross(f);
    std::copy(f.data(), f.data() + 3, l.of[s]);
    std::copy(m.data(), m.data() + 3, l.of[s] + 3);
  }
  return l;
}

CondensedMotion::Vector12 CondensedMotion::centripetal(const CondensedModel& model, const GrainSide* side) const {
  const Vector3 w = turning(side);
  const Matrix3 B = w * w.transpose() - w.squaredNorm() * Matrix3::Identity();
  Vector12 f = Vector12::Zero();
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) f += B(a, b) * model.N.col(3 * a + b);
  return f;
}

CondensedMotion::Matrix6 CondensedMotion::mass(const CondensedModel& model, int s, int t) const {
  const auto turned = [&](int i, int j) { return Matrix3(Q_ * model.M.block<3, 3>(6 * s + i, 6 * t + j) * Q_.transpose()); };
  const Matrix3 of_s = cross(r_[s]), of_t = cross(r_[t]), a = turned(0, 0), c = turned(3, 0);
  const Matrix3 b = turned(0, 3) - a * of_t, d = turned(3, 3) - c * of_t;
  Matrix6 m;
  m.topLeftCorner<3, 3>() = a;
  m.topRightCorner<3, 3>() = b;
  m.bottomLeftCorner<3, 3>() = c + of_s * a;
  m.bottomRightCorner<3, 3>() = d + of_s * b;
  return m;
}

}  // namespace mpdem
