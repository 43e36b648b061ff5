// SPDX-License-Identifier: GPL-2.0-or-later
// Fragments as bodies: mean motion of nodes that turn as a rigid body, and the forces that nodes get.
#include "../../../../src/USER-MPDEM/cement/bond/fragment_bodies.h"

#include <gtest/gtest.h>

#include "../../linked_bonds.h"

namespace mpdem {
namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Map3 = Eigen::Map<const Vector3>;

// The second bond of a scene of two, all of whose nodes are one fragment.
struct Loose {
  test::Scene scene{77, test::penalty(true, 0.0)};
  Bonds bonds;
  FragmentBodies fragments;
  Matrix3 Q;
  Loose() {
    bonds.table = scene.records;
    const Eigen::Quaterniond axes(scene.random.frame());
    test::copy(axes, bonds.table[1].axes);
    Q = axes.toRotationMatrix();
    Bond& b = bonds.make(1);
    b.grid = std::move(scene.bonds[1].grid);
    b.grid.acceleration.assign(b.grid.velocity.size(), 0.0);
    b.grid.force.assign(b.grid.velocity.size(), 0.0);
    fragments.add_rows({1});
    fragments.set({{1, b.grid.keys}});
  }
  Grid& grid() { return bonds.find(1)->grid; }
  Vector3 place(int i) { return grid().h * Vector3(grid().keys[i].at(0), grid().keys[i].at(1), grid().keys[i].at(2)); }
  Vector3 in_box(const Vector3& X) { return Map3(bonds.table[1].origin) + Q * X; }
};

TEST(FragmentBodies, MotionOfARigidBody) {
  Loose f;
  Grid& grid = f.grid();
  const Matrix3 R = Eigen::AngleAxisd(2.1, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  const Vector3 shift(30.0, -4.0, 7.0), v0(1.0, 2.0, -3.0), omega(4.0, -5.0, 6.0);
  for (int i = 0; i < grid.size(); ++i) {
    const Vector3 x = R * f.place(i) + shift, v = v0 + omega.cross(x - shift);
    test::copy(Vector3(x - f.place(i)), &grid.displacement[3 * i]);
    test::copy(v, &grid.velocity[3 * i]);
  }
  const BodyOfNodes m = f.fragments.find_motions(MPI_COMM_SELF, f.bonds, {}).at(0);
  EXPECT_LT((m.x - f.in_box(shift)).norm(), 1e-12);
  EXPECT_LT((m.v - f.Q * v0).norm(), 1e-11);
  EXPECT_LT((m.omega - f.Q * omega).norm(), 1e-11);
  EXPECT_LT((m.R - f.Q * R).norm(), 1e-12);
  // where the nodes will be
  const double dt = 1e-3;
  const BodyOfNodes later = f.fragments.find_motions(MPI_COMM_SELF, f.bonds, {0.5 * dt, dt}).at(0);
  EXPECT_LT((later.centre - m.centre - dt * (m.v + m.omega.cross(m.centre - m.x))).norm(), 1e-12);
}

TEST(FragmentBodies, ForcesHaveResultantMomentAndPower) {
  Loose f;
  Grid& grid = f.grid();
  for (std::vector<double>* values : {&grid.displacement, &grid.velocity})
    for (double& v : *values) v = 0.3 * f.scene.random.uniform(-1, 1);
  const BodyOfNodes m = f.fragments.find_motions(MPI_COMM_SELF, f.bonds, {}).at(0);
  const Vector3 force(1.5, -2.0, 0.7), moment(-0.3, 0.2, 0.9);
  f.fragments.set_forces({force[0], force[1], force[2], moment[0], moment[1], moment[2]}, f.bonds);
  // mass that a node gets before the forces act changes where the centre is, but not what the forces sum up to
  for (double share : {1.0, 3.0}) {
    grid.mass.own()[grid.size() / 2] *= share;
    std::fill(grid.force.begin(), grid.force.end(), 0.0);
    f.fragments.find_accelerations(MPI_COMM_SELF, f.bonds, {}, 1.0);
    f.fragments.add_forces(*f.bonds.find(1));
    Vector3 sum = Vector3::Zero(), sum_of_moments = sum;
    for (int i = 0; i < grid.size(); ++i) {
      const Vector3 at = f.in_box(f.place(i) + Map3(&grid.displacement[3 * i])), of_node = f.Q * Map3(&grid.force[3 * i]);
      sum += of_node;
      sum_of_moments += (at - m.x).cross(of_node);
    }
    EXPECT_LT((sum - force).norm(), 1e-12);
    EXPECT_LT((sum_of_moments - moment).norm(), 1e-12);
    if (share > 1.0) continue;
    EXPECT_NEAR(f.fragments.power(*f.bonds.find(1), grid.velocity), force.dot(m.v) + moment.dot(m.omega), 1e-12);
  }
}

}  // namespace
}  // namespace mpdem
