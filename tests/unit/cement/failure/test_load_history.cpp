// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A pair of grains whose load and relative motion are prescribed, each grain on a rank of its own where there are several: which loads are gone.
#include "cement/failure/load_history.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

namespace mpdem {
namespace {

using Vector = Eigen::Vector3d;
using Quaternion = Eigen::Quaterniond;

constexpr double kSpeed = 4.0;  // with the radius 1 of the area at the grains a window takes a time of 1
constexpr int kSteps = 50;      // in a window

// The pair as it is placed in the box.
struct Placed {
  Quaternion turn = Quaternion::Identity();
  Vector origin = Vector::Zero();
  bool swapped = false;  // which is the first
  double upper_radius = 1.0;
};

class Pair {
 public:
  explicit Pair(const Placed& placed = {}) : placed_(placed) {
    MPI_Comm_rank(MPI_COMM_WORLD, &me_);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks_);
    BondRecord record;
    record.points = 1;
    for (int s = 0; s < 2; ++s) {
      record.grain[s] = s + 1;
      record.radius[s] = is_upper(s) ? placed_.upper_radius : 1.0;
      record.attached_area[s] = M_PI;
      const Vector centre = placed_.turn * -arm(is_upper(s));
      std::copy(centre.data(), centre.data() + 3, record.centre[s]);
    }
    std::copy(placed_.origin.data(), placed_.origin.data() + 3, record.origin);
    bonds_.table = {record};
    watch.add_bonds(1);
    std::vector<Grain> mine;
    for (int s = 0; s < 2; ++s)
      if (me_ == s % ranks_) {
        Grain g;
        g.tag = s + 1;
        g.mass = g.inertia = g.radius = 1.0;
        g.state = &state_[s];
        mine.push_back(g);
      }
    grains_.replace(std::move(mine));
    grains_.bind(MPI_COMM_WORLD, bonds_, 1.0);
  }

  // Runs a window with this load on the upper grain and this relative motion of it. Both are functions of the time from 0 to 1.
  // True if the bond is broken.
  using Six = Eigen::Matrix<double, 6, 1>;
  bool window(const std::function<Six(double)>& load, const std::function<Six(double)>& motion, double part = 1.0) {
    for (int n = 0; n < kSteps * part; ++n) {
      const double t = (n + 0.5) / kSteps;
      step(load(t), motion(t));
      watch.add(grains_, bonds_.table, 1.0 / kSteps * (1.0 + 1e-12));
    }
    return !watch.find_failed(MPI_COMM_WORLD, bonds_.table, kSpeed).empty();
  }
  // Runs a window in which load and motion are constant and along one component.
  bool window(int component, double load, double motion) {
    const auto along = [component](double value) { return [component, value](double) { return Six(value * Six::Unit(component)); }; };
    return window(along(load), along(motion));
  }
  LoadHistory watch;

 private:
  bool is_upper(int s) const { return (s == 1) != placed_.swapped; }
  // From the centre of a grain to the middle of the bond.
  Vector arm(bool upper) const { return Vector(0, 0, upper ? -placed_.upper_radius : 1.0); }
  void step(const Six& load, const Six& motion) {
    for (Grain& g : grains_.grains) {
      const bool upper = is_upper(g.tag - 1);
      const double half = upper ? 0.5 : -0.5;
      const Quaternion turned(Eigen::AngleAxisd(half * motion.tail<3>().norm(),
                                                motion.tail<3>().norm() > 0 ? Vector(motion.tail<3>().normalized()) : Vector::UnitX()));
      // the middle of the bond, fixed in the grain, goes half of the displacement
      const Vector x = half * motion.head<3>() - turned * arm(upper);
      const Vector in_box = placed_.origin + placed_.turn * x;
      const Quaternion q = placed_.turn * turned * placed_.turn.conjugate();
      std::copy(in_box.data(), in_box.data() + 3, g.x);
      const double four[4] = {q.w(), q.x(), q.y(), q.z()};
      std::copy(four, four + 4, g.state->q);
    }
    grains_.distribute(bonds_);
    for (BondEnd& s : grains_.ends.ends) {
      const bool upper = is_upper(s.side);
      const Vector force = (upper ? 1.0 : -1.0) * (placed_.turn * load.head<3>());
      const Vector r = placed_.turn * arm(upper);
      const Vector moment = (upper ? 1.0 : -1.0) * (placed_.turn * load.tail<3>()) + r.cross(force);
      std::copy(force.data(), force.data() + 3, s.force);
      std::copy(moment.data(), moment.data() + 3, s.torque);
    }
  }

  Placed placed_;
  Bonds bonds_;
  GrainState state_[2];
  BondedGrains grains_;
  int me_ = 0, ranks_ = 1;
};

constexpr double kUnit = 1e-4;  // of motions, so that arms do not rotate

// A bond that softens is broken where less than 1 % is left, beyond the displacement of its largest load. This holds along each component.
TEST(LoadHistory, SofteningBondIsBroken) {
  for (int c = 0; c < 6; ++c) {
    Pair pair;
    for (double q : {0.5, 1.0, 1.5}) EXPECT_FALSE(pair.window(c, -10.0 * q, q * kUnit)) << c;
    EXPECT_FALSE(pair.window(c, -5.0, 2.0 * kUnit));
    EXPECT_FALSE(pair.window(c, -0.16, 3.0 * kUnit));
    EXPECT_TRUE(pair.window(c, -0.14, 3.0 * kUnit)) << c;
  }
}

// Damage leaves no strain behind: unloaded along any secant, or through zero to the other sign, it holds.
TEST(LoadHistory, UnloadedBondHolds) {
  for (double secant : {10.0, 3.0, 0.3}) {
    Pair pair;
    EXPECT_FALSE(pair.window(0, 10.0, kUnit));
    for (double q : {2.0, 1.0, 0.1, 0.03, 0.0, -0.03, -0.5}) EXPECT_FALSE(pair.window(0, secant * q, q * kUnit)) << secant << " " << q;
  }
}

// Cycles within a window have means of zero, of load and of displacement, also about a displacement that is not zero.
TEST(LoadHistory, CyclesHold) {
  for (double middle : {0.0, 0.5}) {
    Pair pair;
    EXPECT_FALSE(pair.window(2, 10.0, kUnit));
    for (int n = 0; n < 4; ++n) {
      const auto swing = [&](double unit) {
        return [=](double t) { return Pair::Six(unit * (middle + 5.0 * std::sin(2 * M_PI * t)) * Pair::Six::Unit(2)); };
      };
      EXPECT_FALSE(pair.window(swing(10.0), swing(kUnit)));
    }
  }
}

// The largest load was one of compression. In tension as much displacement is needed before the bond is known to be broken.
TEST(LoadHistory, CompressionFirst) {
  Pair pair;
  EXPECT_FALSE(pair.window(2, -1000.0, -3.0 * kUnit));
  EXPECT_FALSE(pair.window(2, 50.0, 0.2 * kUnit));
  EXPECT_FALSE(pair.window(2, 0.0, 2.9 * kUnit));
  EXPECT_TRUE(pair.window(2, 0.0, 3.1 * kUnit));
}

// Loads are those about the middle of the gap, also between grains of two sizes, whose centres are not equally far from it.
TEST(LoadHistory, LoadAboutTheMiddle) {
  for (bool swapped : {false, true}) {
    Placed placed;
    placed.swapped = swapped;
    placed.upper_radius = 3.0;
    for (int c = 0; c < 6; ++c) {
      Pair pair(placed);
      EXPECT_FALSE(pair.window(c, 2.0, kUnit));
      EXPECT_NEAR(pair.watch.largest(0).load, 2.0, 1e-14) << c;
    }
  }
}

// A load that rings is judged by its mean, over a window that is long enough.
TEST(LoadHistory, RingingIsLeftOut) {
  Pair pair;
  EXPECT_FALSE(pair.window(0, 10.0, kUnit));
  const auto ringing = [](double t) { return Pair::Six(2.0 * std::sin(4 * M_PI * t) * Pair::Six::Unit(0)); };
  const auto way = [](double) { return Pair::Six(5.0 * kUnit * Pair::Six::Unit(0)); };
  EXPECT_FALSE(pair.window(ringing, way, 0.5));  // too short, and not forgotten
  EXPECT_TRUE(pair.window(ringing, way, 0.5));
}

// The sums are the same somewhere else in the box, rotated, and with the grains swapped. The sums of a restart file are the same, too.
TEST(LoadHistory, PlaceOrderAndRestart) {
  const auto load = [](double t) { return (Pair::Six() << 3.0 + t, -2.0, 1.0, 0.5, 0.25 * t, -1.0).finished(); };
  const auto motion = [](double t) {
    return (1e-2 * Pair::Six((Pair::Six() << 1.0, -2.0 * t, 3.0, 0.3, 0.2, -0.1 * t).finished())).eval();
  };
  Placed turned;
  turned.turn = Quaternion(Eigen::AngleAxisd(0.7, Vector(1, 2, -3).normalized()));
  turned.origin = Vector(3, -2, 5);
  Placed swapped = turned;
  swapped.swapped = true;
  Pair first;
  first.window(load, motion, 0.5);
  const double size = std::fabs(first.watch.gather_on_first(MPI_COMM_WORLD)[0][1]);
  first.window(load, motion, 0.5);
  EXPECT_GT(first.watch.largest(0).load, 0.4);
  for (const Placed& p : {turned, swapped}) {
    Pair other(p);
    other.window(load, motion, 0.5);
    std::vector<LoadHistory::Sums> sums = other.watch.gather_on_first(MPI_COMM_WORLD);
    EXPECT_NEAR(sums[0][0], 0.5, 1e-9);
    EXPECT_GT(size, 1.0);
    int me;
    MPI_Comm_rank(MPI_COMM_WORLD, &me);
    if (me != 0) sums[0] = LoadHistory::Sums{};
    other.watch.restore({other.watch.largest(0)}, sums);
    other.window(load, motion, 0.5);
    EXPECT_NEAR(other.watch.largest(0).load, first.watch.largest(0).load, 1e-12);
    EXPECT_NEAR(other.watch.largest(0).motion, first.watch.largest(0).motion, 1e-14);
  }
}

}  // namespace
}  // namespace mpdem
