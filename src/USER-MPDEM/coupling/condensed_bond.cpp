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

Vector3 vector(const Three<double>& x) { return Vector3(x.a[0], x.a[1], x.a[2]); }
Three<double> three(const Vector3& x) { return {{x[0], x[1], x[2]}}; }

}  // namespace

void CondensedModel::add_node(double m, const Vector3& X, const Eigen::Matrix<double, 3, 6>& field) {
  const Vector3 Y = X - middle;
  Eigen::Matrix<double, 3, 6> P;
  P << Matrix3::Identity(), -cross_matrix(Y);
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
  n = std::copy(N.data(), N.data() + 108, n);
  *n = inertial_coupling;
}

void CondensedModel::unpack(const double* n) {
  std::copy(n, n + 3, middle.data());
  std::copy(n + 3, n + 39, K.data());
  std::copy(n + 39, n + 183, M.data());
  std::copy(n + 183, n + 291, N.data());
  inertial_coupling = n[291];
}

void GrainLoads::add_to(BondEnd* ends) const {
  for (int s = 0; s < 2; ++s)
    for (int d = 0; d < 3; ++d) {
      ends[s].force[d] += of[s][d];
      ends[s].torque[d] += of[s][3 + d];
    }
}

void CondensedModel::find_inertial_coupling() {
  inertial_coupling = 0.0;
  if (M.topRightCorner<6, 6>().isZero(0.0)) return;
  inertial_coupling = 1.0;  // the bound for any positive semidefinite M
  const Eigen::LLT<Matrix6> first(M.topLeftCorner<6, 6>()), second(M.bottomRightCorner<6, 6>());
  if (first.info() != Eigen::Success || second.info() != Eigen::Success) return;
  const Matrix6 half = first.matrixL().solve(Matrix6(M.topRightCorner<6, 6>()));
  const Matrix6 both = second.matrixL().solve(Matrix6(half.transpose()));  // L_1^-1 M_10 L_0^-T
  inertial_coupling = std::min(1.0, Eigen::JacobiSVD<Matrix6>(both).singularValues()[0]);
}

CondensedMotion::CondensedMotion(const CondensedModel& model, const BondRecord& record, const BondEnd* ends) {
  Mat3<double> turn[2];
  Three<double> arm[2];
  for (int s = 0; s < 2; ++s) {
    turn[s] = product(ends[s].R, transpose(rotation_of(record.orientation[s])));
    arm[s] = three(model.middle - vector(record.centre[s]));
  }
  motion_ = RelativeMotion<double>(turn, arm, three(vector(ends[1].x) - vector(ends[0].x)));
  for (int s = 0; s < 2; ++s) {
    r_[s] = mpdem::vector(motion_.r[s]);
    p_[s] = vector(ends[s].x) + r_[s];
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) Q_(i, j) = motion_.Q.a[i][j];
  d_ << mpdem::vector(motion_.delta), mpdem::vector(motion_.theta);
}

GrainLoads CondensedMotion::elastic(const CondensedModel& model) const {
  const Vector6 f = model.K * d_;
  Three<double> force, moment;
  motion_.load(three(f.head<3>()), three(f.tail<3>()), force, moment);
  const Three<double> moment0 = cross(force, motion_.apart) - moment;
  GrainLoads l;
  for (int d = 0; d < 3; ++d) {
    l.of[1][d] = force.a[d];
    l.of[0][d] = -force.a[d];
    l.of[1][3 + d] = moment.a[d];
    l.of[0][3 + d] = moment0.a[d];
  }
  return l;
}

GrainLoads CondensedMotion::all_loads(const CondensedModel& model, const BondEnd* ends, const double* gravity) const {
  GrainLoads sum = elastic(model);
  const GrainLoads inertial = loads(-(model.M * (acceleration(ends) - uniform(gravity)) + centripetal(model, ends)));
  for (int s = 0; s < 2; ++s)
    for (int d = 0; d < 6; ++d) sum.of[s][d] += inertial.of[s][d];
  return sum;
}

CondensedMotion::Vector12 CondensedMotion::to_q(const double* first, const double* second) const {
  Vector12 q;
  const double* of[2] = {first, second};
  for (int s = 0; s < 2; ++s) {
    const Vector3 turn = vector(of[s] + 3);
    q.segment<3>(6 * s) = Q_.transpose() * (vector(of[s]) + turn.cross(r_[s]));
    q.segment<3>(6 * s + 3) = Q_.transpose() * turn;
  }
  return q;
}

CondensedMotion::Vector12 CondensedMotion::velocity(const BondEnd* ends, double later) const {
  double v[2][6];
  for (int s = 0; s < 2; ++s)
    for (int d = 0; d < 3; ++d) {
      v[s][d] = ends[s].v[d] + later * ends[s].a[d];
      v[s][3 + d] = ends[s].omega[d] + later * ends[s].alpha[d];
    }
  return to_q(v[0], v[1]);
}

CondensedMotion::Vector12 CondensedMotion::acceleration(const BondEnd* ends) const {
  double a[2][6];
  for (int s = 0; s < 2; ++s) {
    const Vector3 w = vector(ends[s].omega), to_axis = w.cross(w.cross(r_[s]));
    for (int d = 0; d < 3; ++d) {
      a[s][d] = ends[s].a[d] + to_axis[d];
      a[s][3 + d] = ends[s].alpha[d];
    }
  }
  return to_q(a[0], a[1]);
}

// Half a step before, the vector to p_s was r_s - half omega x r_s. So the velocity of p_s lacked half times its
// centripetal acceleration, which is acceleration() of ends that do not accelerate. That of nodes lacked half times N : B.
CondensedMotion::Vector12 CondensedMotion::momentum_before(const CondensedModel& model, const BondEnd* ends, double half) const {
  BondEnd turning_alone[2] = {ends[0], ends[1]};
  for (BondEnd& s : turning_alone)
    for (int d = 0; d < 3; ++d) s.a[d] = s.alpha[d] = 0.0;
  return model.M * (velocity(ends, 0.0) - half * acceleration(turning_alone)) - half * centripetal(model, ends);
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

CondensedMotion::Vector12 CondensedMotion::generalized(const double* first, const double* second) const {
  Vector12 g;
  const double* of[2] = {first, second};
  for (int s = 0; s < 2; ++s) {
    const Vector3 f = vector(of[s]);
    g.segment<3>(6 * s) = Q_.transpose() * f;
    g.segment<3>(6 * s + 3) = Q_.transpose() * (vector(of[s] + 3) - r_[s].cross(f));
  }
  return g;
}

CondensedMotion::Vector12 CondensedMotion::centripetal(const CondensedModel& model, const BondEnd* ends) const {
  const Vector3 w = angular_velocity(ends);
  const Matrix3 B = w * w.transpose() - w.squaredNorm() * Matrix3::Identity();
  Vector12 f = Vector12::Zero();
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) f += B(a, b) * model.N.col(3 * a + b);
  return f;
}

}  // namespace mpdem
