// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// coupling/condensed_bond.h: loads as derivatives of the energy for any rotation, and what they keep; masses against sums over nodes.
#include "coupling/condensed_bond.h"

#include <Eigen/Geometry>

#include "lanes.h"

namespace mpdem {
namespace {

using Vector3 = Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

class CondensedBond : public ::testing::Test {
 protected:
  test::Random random{5};
  Body body;
  CondensedModel model;
  GrainSide side[2] = {};

  CondensedBond() {
    for (int s = 0; s < 2; ++s) {
      body.radius[s] = 1.0 + 0.2 * s;
      set(body.centre[s], (s ? 1.3 : -1.1) * Vector3(0.36, -0.48, 0.8));
      write(body.orientation[s], Eigen::Quaterniond(random.frame()));
    }
    model.middle = Vector3(0.05, 0.02, 0.04);
    Eigen::Matrix<double, 6, 6> A;
    for (int i = 0; i < 36; ++i) A.data()[i] = random.uniform(-1, 1);
    model.K = A * A.transpose() + Eigen::Matrix<double, 6, 6>::Identity();
    for (int n = 0; n < 40; ++n) {
      Eigen::Matrix<double, 3, 6> u;
      for (int i = 0; i < 18; ++i) u.data()[i] = random.uniform(-1, 1);
      model.add_node(random.uniform(0.5, 1.0), 0.3 * random.vector(), u);
    }
    place(0.0);
  }
  static void set(double* to, const Vector3& from) { std::copy(from.data(), from.data() + 3, to); }
  static void write(double* to, const Eigen::Quaterniond& q) {
    to[0] = q.w();
    to[1] = q.x();
    to[2] = q.y();
    to[3] = q.z();
  }
  // Grains as at the creation, all of it turned and moved, then each by itself by up to `apart`.
  void place(double apart) {
    const Eigen::Quaterniond turn(random.frame());
    const Vector3 way = random.vector();
    for (int s = 0; s < 2; ++s) {
      const Eigen::Quaterniond own(Eigen::AngleAxisd(apart * random.uniform(0.5, 1), random.direction()));
      const double* q = body.orientation[s];
      double turned[4];
      write(turned, own * turn * Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
      side[s].R = rotation_of(turned);
      set(side[s].x, way + turn * CondensedMotion::vector(body.centre[s]) + apart * random.vector());
    }
  }
  void move(GrainSide& s, int component, double by) const {
    if (component < 3) {
      s.x[component] += by;
      return;
    }
    const Eigen::Matrix3d T = Eigen::AngleAxisd(by, Vector3::Unit(component - 3)).toRotationMatrix();
    const Mat3<double> R = s.R;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) s.R.a[i][j] = T(i, 0) * R.a[0][j] + T(i, 1) * R.a[1][j] + T(i, 2) * R.a[2][j];
  }
  double energy(const GrainSide* at) const { return CondensedMotion(model, body, at).energy(model); }
};

TEST_F(CondensedBond, LoadsAreDerivativesOfTheEnergy) {
  for (double apart : {1e-6, 0.01, 0.8}) {
    place(apart);
    const GrainLoads loads = CondensedMotion(model, body, side).elastic(model);
    const double h = 1e-4 * apart + 1e-9;
    double worst = 0.0, most = 0.0;
    for (int s = 0; s < 2; ++s)
      for (int c = 0; c < 6; ++c) {
        GrainSide plus[2] = {side[0], side[1]}, minus[2] = {side[0], side[1]};
        move(plus[s], c, h);
        move(minus[s], c, -h);
        worst = std::max(worst, std::fabs(loads.of[s][c] + (energy(plus) - energy(minus)) / (2 * h)));
        most = std::max(most, std::fabs(loads.of[s][c]));
      }
    EXPECT_GT(most, 0.1 * apart);
    test::expect_within(worst / most, apart < 1e-3 ? 1e-4 : 1e-6, "load against the slope of the energy");
  }
}

TEST_F(CondensedBond, KeepsMomentumAndDoesNotSeeAMotionOfBoth) {
  EXPECT_LT(energy(side), 1e-24);  // as made, but turned
  place(0.5);
  const double before = energy(side);
  const GrainLoads l = CondensedMotion(model, body, side).elastic(model);
  Vector3 F = Vector3::Zero(), M = F;
  for (int s = 0; s < 2; ++s) {
    const Vector3 f(l.of[s][0], l.of[s][1], l.of[s][2]);
    F += f;
    M += Vector3(l.of[s][3], l.of[s][4], l.of[s][5]) + CondensedMotion::vector(side[s].x).cross(f);
  }
  EXPECT_LT(F.norm() + M.norm(), 1e-12);
  const Eigen::Matrix3d T(random.frame());
  for (GrainSide& s : side) {
    const Mat3<double> R = s.R;
    set(s.x, T * CondensedMotion::vector(s.x) + Vector3(1, 2, 3));
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) s.R.a[i][j] = T(i, 0) * R.a[0][j] + T(i, 1) * R.a[1][j] + T(i, 2) * R.a[2][j];
  }
  test::expect_within(std::fabs(energy(side) / before - 1.0), 1e-12, "energy after a motion of both");
}

TEST_F(CondensedBond, MassIsThatOfItsNodes) {
  // both grains as one: the mass matrix of a rigid body, in the axes of the box
  double mass = 0.0;
  Vector3 centre = Vector3::Zero();
  CondensedModel rigid;
  rigid.middle = model.middle;
  test::Random r(9);
  std::vector<std::pair<double, Vector3>> nodes;
  for (int n = 0; n < 30; ++n) {
    nodes.emplace_back(r.uniform(0.5, 1.0), r.vector());
    Eigen::Matrix<double, 3, 6> u;
    for (int i = 0; i < 18; ++i) u.data()[i] = r.uniform(-1, 1);
    rigid.add_node(nodes.back().first, nodes.back().second, u);
    mass += nodes.back().first;
    centre += nodes.back().first * (nodes.back().second - model.middle);
  }
  const Vector3 V(0.3, -0.2, 0.5), w(0.7, 0.4, -0.6);
  CondensedMotion::Vector12 q;
  for (int n = 0; n < 4; ++n) q.segment<3>(3 * n) = n % 2 == 0 ? V : w;
  double energy = 0.0;
  for (const auto& n : nodes) energy += 0.5 * n.first * (V + w.cross(n.second - model.middle)).squaredNorm();
  EXPECT_NEAR(0.5 * q.dot(rigid.M * q), energy, 1e-12 * energy);
  for (int s = 0; s < 2; ++s)
    for (int c = 0; c < 3; ++c) {
      side[s].omega[c] = w[c];
      side[s].v[c] = 0.0;
    }
  // and a resultant of centripetal forces
  for (int s = 0; s < 2; ++s) {
    set(side[s].x, CondensedMotion::vector(body.centre[s]));
    side[s].R = rotation_of(body.orientation[s]);
  }
  const CondensedMotion motion(rigid, body, side);
  const CondensedMotion::Vector12 f = motion.centripetal(rigid, side);
  const Vector3 resultant = f.segment<3>(0) + f.segment<3>(6), expected = w.cross(w.cross(centre));
  EXPECT_LT((resultant - expected).norm(), 1e-12);
}

}  // namespace
}  // namespace mpdem
