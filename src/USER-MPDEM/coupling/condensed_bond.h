// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A condensed bond: cement in static equilibrium under its two grains. Six numbers d, their relative motion, describe
// it. It has no state but the motion of its grains.
//
// Q_s is the rotation of grain s since the creation, c the middle of the contact at that time, and p_s the material
// point of grain s that was at c:
//
//   theta = log(Q_0^T Q_1)     Q = Q_0 exp(theta/2)     delta = Q^T (p_1 - p_0)     d = (delta, theta)
//   U = d.K d/2
//
// Forces and moments are derivatives of U. U does not change when both grains move as one rigid body, so momentum,
// angular momentum and energy are kept for any rotation. Forces and moments differ from those of the resolved bond by
// terms of the order of its strain.
//
// The nodes move with q = (w_0, omega_0, w_1, omega_1): velocity of p_s and angular velocity, in the axes Q:
//
//   v(X) = Q [ (P - u) (w_0, omega_0) + u (w_1, omega_1) ]
//
// P (3 by 6) is the rigid motion about the middle. u (3 by 6) has the six static fields: what unit motions of grain 1
// cause at the node while grain 0 rests. With M = sum m (P - u, u)^T (P - u, u) over the nodes, the kinetic energy is
// q.M q/2 and the inertia loads are -M q'. Here q' includes the centripetal accelerations of p_s. A node at Y from the
// middle has the further centripetal acceleration B Y, B = omega omega^T - omega^2 with the mean omega of both grains.
// It adds N : B to M q', with N = sum m (P - u, u)^T (x) Y.
#ifndef MPDEM_COUPLING_CONDENSED_BOND_H
#define MPDEM_COUPLING_CONDENSED_BOND_H

#include <Eigen/Dense>
#include <vector>

#include "../mpm/bond_record.h"
#include "../mpm/grid.h"
#include "bond_ends.h"
#include "relative_motion.h"

namespace mpdem {

struct CondensedModel {
  using Vector3 = Eigen::Vector3d;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Matrix12 = Eigen::Matrix<double, 12, 12>;

  Vector3 middle = Vector3::Zero();  // middle of the contact at creation, from the origin of the bond
  Matrix6 K = Matrix6::Zero();
  Matrix12 M = Matrix12::Zero();
  Eigen::Matrix<double, 12, 9> N = Eigen::Matrix<double, 12, 9>::Zero();  // its columns follow the rows of a 3 by 3 matrix

  // Adds a node of mass m at X with its values of the six static fields, field(component, motion).
  void add_node(double m, const Vector3& X, const Eigen::Matrix<double, 3, 6>& field);
  // Largest value of 2 |q_0.M_01 q_1| over q_0.M_00 q_0 + q_1.M_11 q_1, from 0 to 1. Call find_inertial_coupling() when M is
  // complete.
  double inertial_coupling = 0.0;
  void find_inertial_coupling();
  static constexpr int kNumbers = 3 + 36 + 144 + 108 + 1;  // middle, K, M, N, inertial_coupling
  void pack(double* numbers) const;
  void unpack(const double* numbers);
};

// Loads on both grains, force and moment about the centre, in the axes of the bond.
struct GrainLoads {
  double of[2][6] = {};
  void add_to(BondEnd* ends) const;
};

// `ends` points to end 0 of the bond. End 1 follows it.
class CondensedMotion {
 public:
  using Vector3 = Eigen::Vector3d;
  using Matrix3 = Eigen::Matrix3d;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Vector12 = Eigen::Matrix<double, 12, 1>;

  CondensedMotion() = default;
  CondensedMotion(const CondensedModel& model, const BondRecord& record, const BondEnd* ends);

  const Vector6& relative() const { return d_; }
  double energy(const CondensedModel& model) const { return 0.5 * d_.dot(model.K * d_); }
  GrainLoads elastic(const CondensedModel& model) const;

  // velocity() returns the velocities (v, omega) of the ends plus `later` times their accelerations, as q. acceleration()
  // returns the accelerations as q'.
  Vector12 velocity(const BondEnd* ends, double later) const;
  Vector12 acceleration(const BondEnd* ends) const;
  // Converts six numbers of each end, about the centre of its grain, to the form of q.
  Vector12 to_q(const double* first, const double* second) const;
  // Converts the uniform field g to the form of q.
  Vector12 uniform(const double* g) const;
  // loads() converts generalized forces on q to loads on the grains. generalized() converts six numbers of each end
  // back.
  GrainLoads loads(const Vector12& generalized) const;
  Vector12 generalized(const double* first, const double* second) const;
  // N : B, which the centripetal accelerations of nodes add to M q'.
  Vector12 centripetal(const CondensedModel& model, const BondEnd* ends) const;
  // M q of half a step before, for ends with the velocities of that time and the present positions.
  Vector12 momentum_before(const CondensedModel& model, const BondEnd* ends, double half) const;
  // All loads on the grains for these velocities and accelerations of the ends: elastic, inertial and weight.
  GrainLoads all_loads(const CondensedModel& model, const BondEnd* ends, const double* gravity) const;

  const Matrix3& axes() const { return Q_; }
  Vector3 middle() const { return 0.5 * (p_[0] + p_[1]); }
  // Angular velocity of the bond, in its axes.
  Vector3 angular_velocity(const BondEnd* ends) const { return 0.5 * Q_.transpose() * (vector(ends[0].omega) + vector(ends[1].omega)); }
  static Vector3 vector(const double* x) { return Vector3(x[0], x[1], x[2]); }

 private:
  RelativeMotion<double> motion_;
  Matrix3 Q_ = Matrix3::Identity();
  Vector3 p_[2], r_[2];  // the p_s, and the vectors from the centres of the grains to them
  Vector6 d_ = Vector6::Zero();
};

}  // namespace mpdem

#endif
