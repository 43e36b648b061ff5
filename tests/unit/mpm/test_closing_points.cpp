// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mpm/closing_points.h"

#include <algorithm>
#include <memory>

#include "bodies.h"
#include "cement.h"
#include "lanes.h"
#include "mpm/largest_eigenvalue.h"

namespace mpdem {
namespace {

using test::kCell;
using test::Vector;

// Cement all of whose points failed, with cracks across one direction of the box.
class FailedBody : public ::testing::Test {
 protected:
  FailedBody() : random(917), body(kCell, test::lattice(kCell, 2), std::pow(0.5 * kCell, 3), Eigen::Quaterniond(random.frame())) {
    normal = random.direction();
    law = std::make_shared<TensorDamage>(test::law_of(9.6e3));
    body.points.set_law(law);
    body.for_points([&](int b, int l) {
      const PointBlock& p = body.points.blocks[b];
      const Mat3<vd> Q = rotation_matrix(p.q);
      double n[3];
      for (int i = 0; i < 3; ++i) n[i] = Q.a[0][i][l] * normal[0] + Q.a[1][i][l] * normal[1] + Q.a[2][i][l] * normal[2];
      const double D[6] = {0.9 * n[0] * n[0], 0.9 * n[1] * n[1], 0.9 * n[2] * n[2],
                           0.9 * n[1] * n[2], 0.9 * n[0] * n[2], 0.9 * n[0] * n[1]};
      body.points.set_state(kLanes * b + l, D);
      body.points.meta[b].failed |= static_cast<std::uint8_t>(1u << l);
      body.points.meta[b].damaged = true;
    });
    closing = ClosingPoints(body.points, law->elasticity(), 0.0);
  }
  template <class F>
  void displace(F u) {
    for (int n = 0; n < body.grid.size(); ++n) {
      const Vector at = u(body.place(n));
      for (int d = 0; d < 3; ++d) body.grid.displacement[3 * n + d] = at[d];
    }
  }
  double energy() const { return closing.energy(body.points, body.grid); }
  // Gives all points a slip of this size along the crack.
  void slip_by(double size) {
    body.points.start_slip();
    const Vector slip = size * normal.unitOrthogonal();
    for (PointSlip& s : body.points.slip)
      for (int d = 0; d < 3; ++d) s.at[d] = splat(slip[d]);
  }
  // All points keep the deformation F in which they failed, and with it the strain in the frame of the material.
  void keep_deformation(const test::Matrix& F) {
    body.for_points([&](int b, int l) {
      PointBlock& p = body.points.blocks[b];
      const Mat3<vd> Q = rotation_matrix(p.q);
      test::Matrix frame;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          p.F.a[i][j][l] = F(i, j);
          frame(i, j) = Q.a[i][j][l];
        }
      const test::Matrix e = frame.transpose() * (0.5 * (F + F.transpose()) - test::Matrix::Identity()) * frame;
      const double strain[6] = {e(0, 0), e(1, 1), e(2, 2), e(1, 2), e(0, 2), e(0, 1)};
      double* of = reinterpret_cast<double*>(&p.strain);
      for (int i = 0; i < 6; ++i) of[kLanes * i + l] = strain[i];
    });
  }
  // The tensor n n of the normal, in the frame of the material.
  Sym3<double> normal_squared(int b, int l) const {
    const Mat3<vd> Q = rotation_matrix(body.points.blocks[b].q);
    double n[3];
    for (int i = 0; i < 3; ++i) n[i] = Q.a[0][i][l] * normal[0] + Q.a[1][i][l] * normal[1] + Q.a[2][i][l] * normal[2];
    return {n[0] * n[0], n[1] * n[1], n[2] * n[2], n[1] * n[2], n[0] * n[2], n[0] * n[1]};
  }
  // Energy of the cement compressed along the normal by this share.
  double energy_of(double share) const {
    double sum = 0.0;
    body.for_points([&](int b, int l) {
      const Sym3<double> along = normal_squared(b, l);
      sum += 0.5 * body.points.blocks[b].volume[l] * contract(along, law->elasticity().stress(along)) * share * share;
    });
    return sum;
  }

  test::Random random;
  test::Cement body;
  Vector normal;
  std::shared_ptr<TensorDamage> law;
  ClosingPoints closing;
};

TEST_F(FailedBody, StoresEnergyWhileClosedAlone) {
  const Vector side = normal.unitOrthogonal();
  displace([&](const Vector& X) { return Vector(-0.01 * normal.dot(X) * normal); });
  const double closed = energy();
  EXPECT_NEAR(closed, energy_of(0.01), 1e-9 * closed);
  displace([&](const Vector& X) { return Vector(0.01 * normal.dot(X) * normal); });
  EXPECT_EQ(energy(), 0.0);
  displace([&](const Vector& X) { return Vector(-0.01 * side.dot(X) * side); });
  EXPECT_LT(energy(), 1e-20 * closed);
  // slip along the crack, and rotations of the whole, do not matter
  const test::Matrix R = test::rotation(random.direction(), 2.0);
  displace([&](const Vector& X) { return Vector(R * (X - 0.01 * normal.dot(X) * normal + 0.3 * normal.dot(X) * side) - X); });
  EXPECT_NEAR(energy(), closed, 1e-9 * closed);
}

class PressedWhenFailed : public FailedBody {
 protected:
  void fail_at(const test::Matrix& F) {
    keep_deformation(F);
    closing = ClosingPoints(body.points, law->elasticity(), 0.0);
  }
  // Energy of the stress n.tau n that intact points would have in the state in which these failed.
  double energy_of_stress() const {
    double sum = 0.0;
    body.for_points([&](int b, int l) {
      const Sym3<double> along = normal_squared(b, l);
      const Sym3<vd> s = law->stress(body.points.blocks[b].strain, test::damage_of(body.points, b));
      const double stress = contract(along, Sym3<double>{s.xx[l], s.yy[l], s.zz[l], s.yz[l], s.xz[l], s.xy[l]});
      sum += 0.5 * body.points.blocks[b].volume[l] * stress * stress / contract(along, law->elasticity().stress(along));
    });
    return sum;
  }
  test::Matrix along(double share) const { return test::Matrix::Identity() + share * normal * normal.transpose(); }
  void displace_by(const test::Matrix& F) {
    displace([&](const Vector& X) { return Vector(F * X - X); });
  }
};

// A point that failed under pressure keeps that pressure, and is as stiff as whole cement from there on. It is not that of undamaged cement at
// this width, a hundred times as much with damage 0.9.
TEST_F(PressedWhenFailed, GoOnWithThePressureThatTheyHad) {
  constexpr double kWidth = 0.98;
  const test::Matrix F = along(kWidth - 1.0);
  fail_at(F);
  displace_by(F);
  const double stored = energy_of_stress() / (kWidth * kWidth);
  ASSERT_GT(stored, 0.0);
  ASSERT_LT(stored, 1e-3 * energy_of(1.0 - kWidth));
  EXPECT_NEAR(energy(), stored, 1e-9 * stored);
  // further by 0.01
  displace_by(along(kWidth - 1.01));
  const double more = std::sqrt(energy_of(0.01)) + std::sqrt(stored);
  EXPECT_NEAR(energy(), more * more, 1e-9 * more * more);
  // the opening that takes the pressure away, which is that of a hundredth of the stiffness, and some
  displace_by(along(kWidth - 1.0 + 1.001 * 0.01 * (1.0 - kWidth) / kWidth));
  EXPECT_EQ(energy(), 0.0);
}

// The points are pulled across the crack although it is narrower than at first. The crack is closed from there on.
TEST_F(PressedWhenFailed, AreClosedFromTheWidthAtWhichTheyFailed) {
  test::Matrix F = test::Matrix::Identity() + 0.03 * (test::Matrix::Identity() - normal * normal.transpose());
  F -= 0.001 * normal * normal.transpose();
  fail_at(F);
  displace_by(F);
  EXPECT_LT(energy(), 1e-20 * energy_of(0.001));
  displace_by(F - 0.01 * normal * normal.transpose());
  EXPECT_NEAR(energy(), energy_of(0.01), 1e-9 * energy_of(0.01));
}

// A point that opened before it failed closes at its first width.
TEST_F(PressedWhenFailed, CloseAtTheReferenceIfTheyOpened) {
  fail_at(along(0.02));
  displace_by(along(0.001));
  EXPECT_EQ(energy(), 0.0);
  displace_by(along(-0.01));
  EXPECT_NEAR(energy(), energy_of(0.01), 1e-9 * energy_of(0.01));
}

// A force that began in the last step has worked with its present value on half of the displacement of that step:
// K x(t) x(t - dt)/2 was there before.
TEST_F(FailedBody, BeginsWithTheProductOfBothEndsOfAStep) {
  constexpr double kDt = 0.25;
  std::vector<int> all, half;
  body.for_points([&](int b, int l) { all.push_back(kLanes * b + l); });
  std::sort(all.begin(), all.end());
  for (std::size_t n = 0; n < all.size(); n += 2) half.push_back(all[n]);
  body.grid.velocity.assign(3 * body.grid.size(), 0.0);
  for (int n = 0; n < body.grid.size(); ++n)
    for (int d = 0; d < 3; ++d) body.grid.velocity[3 * n + d] = -0.002 / kDt * normal.dot(body.place(n)) * normal[d];
  displace([&](const Vector& X) { return Vector(-0.01 * normal.dot(X) * normal); });
  const auto begun = [&](const std::vector<int>& slots, double dt) {
    return closing.energy_at_beginning(body.points, body.grid, slots, dt);
  };
  EXPECT_NEAR(begun(all, 0.0), energy(), 1e-9 * energy());
  EXPECT_NEAR(begun(all, kDt), std::sqrt(energy_of(0.01) * energy_of(0.008)), 1e-9 * energy());
  EXPECT_EQ(begun({}, kDt), 0.0);
  EXPECT_GT(begun(half, kDt), 0.3 * begun(all, kDt));
  EXPECT_LT(begun(half, kDt), 0.7 * begun(all, kDt));
}

// Points that failed may be as stiff as whole ones, and count like these for the eigenvalue.
TEST_F(FailedBody, CountsForTheEigenvalueAsWhole) {
  test::Cement whole(kCell, test::lattice(kCell, 2), std::pow(0.5 * kCell, 3));
  for (test::Cement* c : {&body, &whole}) {
    c->points.set_law(law);
    c->grid.lump_mass(c->points, test::kCalcite);
  }
  std::copy(whole.points.blocks.begin(), whole.points.blocks.end(), body.points.blocks.begin());  // frames too
  const auto found = [&](test::Cement& c, bool hold) {
    return largest_eigenvalue(MPI_COMM_SELF, {{&c.points, &c.grid, hold}}, *law).value;
  };
  const double expected = found(whole, false);
  EXPECT_NEAR(found(body, true), expected, 2e-3 * expected);
  EXPECT_LT(found(body, false), 1e-6 * expected);
}

// The force is the slope of the energy, also where the pressure is at its bound, a tenth of the stiffness, and with
// friction that sticks after a large slip.
TEST_F(FailedBody, ForceIsTheSlopeOfTheEnergy) {
  for (const auto& [share, friction] : {std::pair<double, double>{0.02, 0.0}, {0.3, 0.0}, {0.02, 0.4}, {0.3, 0.4}}) {
    closing = ClosingPoints(body.points, law->elasticity(), friction);
    if (friction > 0.0) slip_by(0.5);
    displace([&](const Vector& X) { return Vector(-share * normal.dot(X) * normal + 0.005 * kCell * random.vector()); });
    body.grid.clear_force();
    EXPECT_EQ(closing.add_force(body.points, body.grid, 0.0).released, 0.0);
    Vector sum = Vector::Zero(), moment = Vector::Zero();
    double size = 0.0;
    test::Worst slope;
    for (int n = 0; n < body.grid.size(); ++n) {
      const Vector f = body.at(body.grid.force, n);
      sum += f;
      moment += (body.place(n) + body.at(body.grid.displacement, n)).cross(f);
      size = std::max(size, f.norm());
    }
    ASSERT_GT(size, 0.0);
    for (int i = 0; i < 3 * body.grid.size(); ++i) {
      constexpr double kStep = 1e-6 * kCell;
      double& u = body.grid.displacement[i];
      u += kStep;
      const double more = energy();
      u -= 2.0 * kStep;
      const double less = energy();
      u += kStep;
      slope.add(std::fabs(body.grid.force[i] + (more - less) / (2.0 * kStep)) / size);
    }
    test::expect_within(slope, 1e-5, "force against the slope of the energy");
    test::expect_within(sum.norm() / size, 1e-12, "resultant");
    test::expect_within(moment.norm() / (size * kCell), 1e-11, "moment");
  }
}

// The points are pressed, slide to and fro in both directions of the crack, rotate, and open.
class Sliding : public FailedBody {
 protected:
  static constexpr double kMu = 0.3, kPressed = 0.01, kSlide = 0.5, kDt = 1e-8;
  Sliding() : across(normal.cross(normal.unitOrthogonal())) {
    closing = ClosingPoints(body.points, law->elasticity(), kMu);
    body.grid.velocity.assign(3 * body.grid.size(), 0.0);
  }
  // Moves on to the deformation F in one step, and sums up what the forces do.
  void go(const test::Matrix& F) {
    const std::vector<double> was = body.grid.displacement, force = body.grid.force;
    displace([&](const Vector& X) { return Vector(F * X - X); });
    for (std::size_t i = 0; i < was.size(); ++i) body.grid.velocity[i] = (body.grid.displacement[i] - was[i]) / kDt;
    body.grid.clear_force();
    const Losses losses = closing.add_force(body.points, body.grid, kDt);
    frictional += losses.frictional;
    for (std::size_t i = 0; i < was.size(); ++i) work -= 0.5 * (force[i] + body.grid.force[i]) * (body.grid.displacement[i] - was[i]);
  }
  test::Matrix pressed_and_slid(double press, const Vector& slide) const {
    return test::Matrix::Identity() - press * normal * normal.transpose() + slide * normal.transpose();
  }
  // Stress n.T of the whole, from the virtual work of the forces in a motion n.x v.
  Vector traction() const {
    Vector sum = Vector::Zero();
    double volume = 0.0;
    body.for_points([&](int b, int l) { volume += body.points.blocks[b].volume[l]; });
    for (int n = 0; n < body.grid.size(); ++n)
      sum -= normal.dot(body.place(n) + body.at(body.grid.displacement, n)) * body.at(body.grid.force, n);
    return sum / volume;
  }
  // Shear over the pressure, where the crack is wider than in the reference by no more than the pressure makes it.
  double shear_over_pressure() const {
    const Vector t = traction();
    return (t - t.dot(normal) * normal).norm() / -t.dot(normal);
  }
  Vector across;
  double frictional = 0.0, work = 0.0;
};

TEST_F(Sliding, BearsMuTimesThePressure) {
  const Vector along = normal.unitOrthogonal();
  go(pressed_and_slid(kPressed, Vector::Zero()));
  EXPECT_LT(shear_over_pressure(), 1e-9);
  go(pressed_and_slid(kPressed, 1e-4 * along));  // sticks
  const double sticks = shear_over_pressure();
  EXPECT_GT(sticks, 0.0);
  EXPECT_LT(sticks, kMu);
  EXPECT_EQ(frictional, 0.0);
  for (int n = 1; n <= 100; ++n) go(pressed_and_slid(kPressed, 0.01 * n * kSlide * along));
  test::expect_within(std::fabs(shear_over_pressure() / kMu - 1.0), 1e-6, "shear over pressure, over mu");
  EXPECT_GT(traction().dot(along), 0.0);
  for (int n = 1; n <= 100; ++n) go(pressed_and_slid(kPressed, kSlide * along + 0.01 * n * kSlide * across));
  test::expect_within(std::fabs(shear_over_pressure() / kMu - 1.0), 1e-6, "shear over pressure, over mu");
  EXPECT_GT(traction().dot(across), 0.99 * kMu * -traction().dot(normal));
  // the pressure falls to half while it sticks, so the shear follows it
  go(pressed_and_slid(0.5 * kPressed, kSlide * (along + across)));
  EXPECT_LT(shear_over_pressure(), kMu * (1.0 + 1e-6));
}

TEST_F(Sliding, KeepsTheBooks) {
  const Vector along = normal.unitOrthogonal();
  constexpr int kSteps = 200;
  double most = 0.0;
  for (int n = 0; n <= 4 * kSteps; ++n) {  // a closed path of slip while the pressure comes and goes, and the crack opens in between
    const double turn = 2.0 * M_PI * n / kSteps, press = kPressed * std::sin(0.5 * turn);
    const Vector slide = kSlide * ((std::cos(turn) - 1.0) * along + 0.5 * std::sin(2.0 * turn) * across);
    go(test::rotation(across, 0.3 * std::sin(turn)) * pressed_and_slid(press, slide));
    EXPECT_GE(frictional, (1.0 - 1e-9) * most);
    most = std::max(most, frictional);
    test::expect_within(std::fabs(work - energy() - frictional) / energy_of(kPressed), 1e-2,
                        "work less energies, over that of the pressure");
  }
  EXPECT_GT(frictional, 0.9 * work);
  EXPECT_GT(frictional, 10.0 * energy_of(kPressed));
}

// What a crack slid while it was open does not matter when it closes, and a crack that failed in a sheared state starts without shear.
TEST_F(Sliding, ForgetsWhatItSlidWhileOpen) {
  const Vector along = normal.unitOrthogonal();
  go(pressed_and_slid(kPressed, 0.2 * along));
  for (const Vector& slide : {Vector(-kSlide * along), Vector(kSlide * across)}) {
    go(pressed_and_slid(-kPressed, slide));
    EXPECT_LT(energy(), 1e-20 * energy_of(kPressed));
    EXPECT_LT(traction().norm(), 1e-9 * law->elasticity().C33);
    go(pressed_and_slid(kPressed, slide));
    EXPECT_LT(shear_over_pressure(), 1e-6);
  }
}

// Points fail under pressure at the end of a step that closed them and sheared them. They carry shear from there on alone.
TEST_F(Sliding, StartsWithoutShearWhereAPointFails) {
  const Vector along = normal.unitOrthogonal();
  const test::Matrix F = pressed_and_slid(kPressed, 0.1 * along);
  keep_deformation(F);
  std::vector<int> slots;
  body.for_points([&](int b, int l) {
    body.points.meta[b].failed = 0;
    slots.push_back(kLanes * b + l);
  });
  std::sort(slots.begin(), slots.end());
  closing = ClosingPoints(body.points, law->elasticity(), kMu);
  go(pressed_and_slid(-kPressed, Vector::Zero()));
  for (int slot : slots) body.points.meta[slot / kLanes].failed |= static_cast<std::uint8_t>(1u << slot % kLanes);
  closing.add(body.points, law->elasticity(), slots);
  go(F);
  EXPECT_GT(energy(), 0.0);
  EXPECT_LT(shear_over_pressure(), 1e-9);
  EXPECT_LT(frictional, 1e-20 * energy());
  EXPECT_TRUE(body.points.slip.empty());
  go(pressed_and_slid(kPressed, 0.1 * along + 1e-3 * across));
  test::expect_within(std::fabs(shear_over_pressure() / kMu - 1.0), 1e-6, "shear over pressure, over mu");
  EXPECT_GT(frictional, 0.0);
}

// Points fail at the end of a step in which a crack that was closed and sheared opened. Their crack is new, so it has nothing to slide off.
TEST_F(Sliding, DoesNotSlideInTheStepInWhichAPointFails) {
  const Vector along = normal.unitOrthogonal();
  std::vector<int> slots;
  body.for_points([&](int b, int l) {
    body.points.meta[b].failed = 0;
    slots.push_back(kLanes * b + l);
  });
  std::sort(slots.begin(), slots.end());
  closing = ClosingPoints(body.points, law->elasticity(), kMu);
  go(pressed_and_slid(kPressed, 0.3 * along));
  const test::Matrix F = pressed_and_slid(-kPressed, 0.1 * along);
  keep_deformation(F);
  for (int slot : slots) body.points.meta[slot / kLanes].failed |= static_cast<std::uint8_t>(1u << slot % kLanes);
  closing.add(body.points, law->elasticity(), slots);
  go(F);
  EXPECT_EQ(energy(), 0.0);
  EXPECT_EQ(frictional, 0.0);
  EXPECT_TRUE(body.points.slip.empty());
}

// A point that is squeezed or torn too far has no crack that closes any more, also where it comes back. What it stored is counted.
TEST_F(FailedBody, DistortedPointsAreDebrisForGood) {
  const Vector side = normal.unitOrthogonal();
  const auto squeeze = [&](double share) {
    return [&, share](const Vector& X) { return Vector(-0.05 * normal.dot(X) * normal - share * side.dot(X) * side); };
  };
  const double dt = 1e-8;
  displace(squeeze(0.5));
  const double stored = energy();
  ASSERT_GT(stored, 0.0);
  body.grid.clear_force();
  EXPECT_EQ(closing.add_force(body.points, body.grid, dt).released, 0.0);
  double work = 0.0;  // of the last force, on half of the displacement of the step in which it ends
  for (int n = 0; n < body.grid.size(); ++n) {
    const Vector way = -0.4 * side.dot(body.place(n)) * side;
    for (int d = 0; d < 3; ++d) body.grid.velocity[3 * n + d] = way[d] / dt;
    work += 0.5 * body.at(body.grid.force, n).dot(way);
  }
  displace(squeeze(0.9));
  body.grid.clear_force();
  const double released = closing.add_force(body.points, body.grid, dt).released;
  EXPECT_NEAR(released, stored - work, 1e-9 * stored);
  EXPECT_EQ(body.grid.force, std::vector<double>(body.grid.force.size(), 0.0));
  displace(squeeze(0.0));
  EXPECT_EQ(energy(), 0.0);
  body.for_points([&](int b, int l) { EXPECT_TRUE(body.points.record(kLanes * b + l).distorted); });
  EXPECT_EQ(ClosingPoints(body.points, law->elasticity(), 0.0).energy(body.points, body.grid), 0.0);
}

}  // namespace
}  // namespace mpdem
