// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The engine without LIGGGHTS, on 1, 2 and 4 ranks.
#include "cement/engine/cement.h"

#include <chrono>
#include <cstring>
#include <ctime>
#include <thread>

#include "lanes.h"
#include "cement_host.h"
#include "mpi_ranks.h"

namespace mpdem {
namespace {

using test::Row;
using test::RowOfGrains;

struct Method {
  bool updated, nonlocal;
  int mass_order = 1;
};

class Kinematic : public ::testing::TestWithParam<Method> {
 protected:
  Row row() const {
    Row r;
    r.updated = GetParam().updated;
    r.mass_order = GetParam().mass_order;
    r.length = GetParam().nonlocal ? 2.5 * test::kSpacing : 0.0;  // 1.25 cells: one smoothing pass and a fraction of one
    return r;
  }
};

// Springs side by side, with those of the links in series: E/(t + 2 E/k) on each ring of area, t = gap + r^2/R.
double stiffness() {
  const double t = test::kGap + 2.0 * test::kYoung / test::kPenalty;
  return M_PI * test::kRadius * test::kYoung * std::log(1.0 + test::kOuter * test::kOuter / (test::kRadius * t));
}

// Bonds come in any order from other ranks and from files. Those that are there do not move for them.
TEST(Bonds, StayWhereTheyAre) {
  Bonds bonds;
  bonds.table.resize(50);
  const Bond* const first = &bonds.make(49);
  for (int n = 0; n < 49; ++n) bonds.make(n * 18 % 49);
  EXPECT_EQ(bonds.find(49), first);
  int row = 0;
  for (const Bond& b : bonds) EXPECT_EQ(b.row, row++);
  EXPECT_EQ(row, 50);
}

TEST_P(Kinematic, ForceIsStiffnessTimesStretch) {
  Row r = row();
  r.B0 = 0.0;
  r.speed = 0.2;
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.setup();
  host.run(200);  // a wave crosses in 17
  double force = 0.0, stretch = 0.0;
  for (int n = 0; n < 200; ++n) {
    host.step();
    force += host.tension(0);
    stretch += host.stretch();
  }
  test::expect_within(std::fabs(force / stretch / stiffness() - 1.0), 0.02, "force over stiffness times stretch");
  EXPECT_EQ(host.sum(host.points_here()), host.bonds.table[0].points);
}

// Pulled through failure: the energies are those that the grains paid for, and all ranks together see what one alone sees.
TEST_P(Kinematic, PulledThroughFailure) {
  RowOfGrains host(MPI_COMM_WORLD, row()), alone(MPI_COMM_SELF, row());
  double peak = 0.0;
  int checked = 0;
  host.setup();
  alone.setup();
  for (int layer = 0; layer < 75; ++layer) {
    host.run(20);
    alone.run(20);
    peak = std::max(peak, host.tension(0));
    const CementTotals t = host.cement->report().totals(0.1);
    const double work = host.sum(host.work);
    if (host.number < 200) continue;
    ++checked;
    const double spent = t.kinetic + t.elastic + t.coupling + t.dissipated + t.released + t.damped;
    test::expect_within(std::fabs(spent / work - 1.0), 1e-3, "energies against the work of the grains");
    test::expect_within(std::fabs(t.external_work / work - 1.0), 1e-3, "work in the energy balance against that of the grains");
    test::expect_within(std::fabs(t.imbalance), 1e-3, "imbalance of the energy");
  }
  EXPECT_EQ(checked, 66);
  const CementTotals t = host.cement->report().totals(0.1);
  EXPECT_EQ(t.separated, 1.0);
  EXPECT_GT(t.failed, 50.0);
  EXPECT_GT(t.dissipated + t.released, 0.5 * t.external_work);
  EXPECT_LT(std::fabs(host.tension(0)), 0.05 * peak);
  host.cement->check_state();
  const auto failed = host.all_failed(), failed_alone = alone.all_failed();
  EXPECT_EQ(static_cast<double>(failed.size()), t.failed);
  EXPECT_EQ(host.separated.size(), 1u);
  EXPECT_EQ(host.separated, alone.separated);
  std::set<int> tags, tags_alone;
  for (const auto& e : failed) EXPECT_TRUE(tags.insert(e[1]).second);
  for (const auto& e : failed_alone) tags_alone.insert(e[1]);
  EXPECT_EQ(tags, tags_alone);
  EXPECT_EQ(failed, failed_alone);
  if (test::ranks() > 1) {
    EXPECT_LT(host.points_here(), host.bonds.table[0].points);
  }
}

// The run restarts in the middle of failure and after it. The head, points and grains hold all there is.
TEST_P(Kinematic, RestartsToTheBit) {
  Row r = row();
  r.bonds = 2;
  r.free_middle = true;
  if (GetParam().nonlocal) r.exponent = 0.0;  // fails in time
  RowOfGrains whole(MPI_COMM_WORLD, r);
  whole.setup();
  for (int at : {300, 560}) {
    // with a shorter step from here on: the velocities that were kept lie half of the old one behind
    const double dt = (at == 300 ? 0.8 : 0.7) * test::kStep;
    test::expect_restart_to_the_bit(whole, r, at, 100, dt, [&](RowOfGrains& again) {
      EXPECT_EQ(again.cement->rows_started(), 2);
      const CementTotals a = whole.cement->report().totals(0.1), b = again.cement->report().totals(0.1);
      for (double CementTotals::*sum : {&CementTotals::dissipated, &CementTotals::released, &CementTotals::external_work})
        EXPECT_NEAR(a.*sum, b.*sum, 1e-12 * a.external_work);
      EXPECT_EQ(a.separated, b.separated);
      for (int bond = 0; bond < 2; ++bond)
        EXPECT_EQ(whole.cement->report().bond_states()[bond].tension, again.cement->report().bond_states()[bond].tension);
    });
  }
  EXPECT_GT(whole.cement->report().totals(0.1).failed, 50.0);
}

// A bond goes to another rank while it fails, and again later. At these steps, each after a check, results stay bitwise identical. At
// other steps they stay equal to rounding: an exchange lays the links out anew and finds the added mass anew.
TEST_P(Kinematic, HandsABondOver) {
  if (test::ranks() == 1) GTEST_SKIP() << "there is no other rank";
  if (test::ranks() > 2 && !(GetParam().updated && GetParam().nonlocal))
    GTEST_SKIP() << "on two ranks, and that which has most to hand over here";
  Row r = row();
  r.bonds = 3;
  r.free_middle = true;
  r.whole_bonds = true;
  r.speed = 16.0;
  RowOfGrains stays(MPI_COMM_WORLD, r), goes(MPI_COMM_WORLD, r);
  stays.setup();
  goes.setup();
  const int next = (1 + test::ranks() / 2) % test::ranks();
  for (const auto& [at, row, to] :
       {std::tuple(141, 1, next), std::tuple(321, 1, 0), std::tuple(341, 0, test::ranks() - 1), std::tuple(521, 1, next)}) {
    goes.hand_over_at(at, row, to);
    stays.hand_over_at(at, -1, 0);  // with `updated` kinematics points are arranged at any exchange
    const int steps = at + 2 - goes.number;
    stays.run(steps);
    goes.run(steps);
    EXPECT_EQ(goes.bonds.find(row) != nullptr, test::rank() == to);
    test::expect_same_bits(stays.content(), goes.content());
  }
  stays.run(50);
  goes.run(50);
  test::expect_same_bits(stays.content(), goes.content());
  EXPECT_EQ(stays.all_failed(), goes.all_failed());
  EXPECT_EQ(stays.separated, goes.separated);
  EXPECT_GT(stays.all_failed().size(), 50u);
}

INSTANTIATE_TEST_SUITE_P(Cement, Kinematic,
                         ::testing::Values(Method{false, false}, Method{true, false}, Method{false, true}, Method{true, true},
                                           Method{false, false, 2}),
                         [](const ::testing::TestParamInfo<Method>& p) {
                           return std::string(p.param.updated ? "updated" : "total") + (p.param.nonlocal ? "_nonlocal" : "") +
                                  (p.param.mass_order > 1 ? "_order2" : "");
                         });

// A link debonds, and then its point fails. Each needs a new check.
TEST(Cracks, SeePointsFailWhoseLinksLetGoBefore) {
  RowOfGrains host(MPI_COMM_SELF, Row());
  host.setup();
  Bond& bond = *host.bonds.find(0);
  CementOptions options = host.cement->options();
  options.split = true;
  Cracks cracks;
  cracks.add_bonds(1);
  const auto look = [&] { cracks.detect_separations(MPI_COMM_SELF, host.bonds, options, true, false); };
  look();
  EXPECT_TRUE(cracks.has_seen(bond.row, Cracks::count_broken(bond)));
  Link& link = bond.points.links.front();
  link.attached = false;
  EXPECT_FALSE(cracks.has_seen(bond.row, Cracks::count_broken(bond)));
  bond.link_step.debond = {0};
  cracks.note_debonded_links(bond);
  ASSERT_TRUE(cracks.some_path_is_cut(MPI_COMM_SELF));
  look();
  EXPECT_TRUE(cracks.has_seen(bond.row, Cracks::count_broken(bond)));
  EXPECT_FALSE(cracks[0].path.empty());
  bond.points.meta[link.slot / kLanes].failed |= static_cast<std::uint8_t>(1u << link.slot % kLanes);
  EXPECT_FALSE(cracks.has_seen(bond.row, Cracks::count_broken(bond)));
}

// With central differences the velocity at a step is the displacement from the step before to the step after it, over twice the time step.
TEST(Report, VelocityOfPointsIsThatOfTheirWay) {
  Row r;
  r.B0 = 0.0;
  r.speed = 0.2;
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.setup();
  host.run(150);
  std::vector<Report::PointMotionNow> motion[3];  // of one step after the other
  for (int n = 0; n < 3; ++n) {
    host.step();
    for (const Bond& b : host.bonds) host.cement->report().motion_of_points(b, motion[n]);
  }
  test::Worst worst;
  double fastest = 0.0;
  for (const Bond& b : host.bonds)
    host.for_points(b, [&](int slot, int tag) {
      const int block = slot / kLanes, lane = slot % kLanes;
      for (int d = 0; d < 3; ++d) {
        const double v = motion[1][block].v[d][lane], way = motion[2][block].u[d][lane] - motion[0][block].u[d][lane];
        worst.add(v - way / (2.0 * host.dt), std::to_string(tag));
        fastest = std::max(fastest, std::fabs(v));
      }
    });
  EXPECT_GT(host.sum(fastest), 0.01);
  test::expect_within(worst, 1e-12, "velocity of points, m/s");
}

// Messages of the host that wait in its communicator, of whatever tag, do not get into the sums over nodes.
TEST(Cement, LeavesMessagesOfTheHostAlone) {
  const int n = test::ranks(), last_tag = 9000;
  RowOfGrains host(MPI_COMM_WORLD, Row()), alone(MPI_COMM_SELF, Row());
  host.setup();
  std::vector<int> sent(last_tag), received(last_tag);
  std::vector<MPI_Request> requests(last_tag);
  const int next = (test::rank() + 1) % n, before = (test::rank() + n - 1) % n;
  for (int tag = 0; tag < last_tag; ++tag) {
    sent[tag] = tag;
    MPI_Isend(&sent[tag], 1, MPI_INT, next, tag, MPI_COMM_WORLD, &requests[tag]);
  }
  host.run(20);
  for (int tag = 0; tag < last_tag; ++tag) MPI_Recv(&received[tag], 1, MPI_INT, before, tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  MPI_Waitall(last_tag, requests.data(), MPI_STATUSES_IGNORE);
  EXPECT_EQ(received, sent);
  alone.setup();
  alone.run(20);
  EXPECT_NEAR(host.tension(0), alone.tension(0), 1e-9 * std::fabs(alone.tension(0)));
}

void work_for(double seconds) {
  const std::clock_t from = std::clock();
  while (std::clock() - from < seconds * CLOCKS_PER_SEC) {
  }
}

// A phase that waits takes no CPU time, and none from other phases. The wait is long, so that it is the longest interval on a busy machine.
TEST(StepTimer, CpuTimeIsWithoutWaiting) {
  StepTimer timer;
  timer.start(StepTimer::kNodes);
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  timer.start(StepTimer::kHalo);
  work_for(0.03);
  timer.stop();
  EXPECT_GE(timer.wall_seconds(), 0.43);
  EXPECT_LT(timer.seconds()[StepTimer::kNodes], 0.01);
  EXPECT_NEAR(timer.seconds()[StepTimer::kHalo], 0.03, 0.02);
  timer.start(StepTimer::kNodes);
  work_for(0.05);
  timer.stop();
  timer.stop();
  EXPECT_NEAR(timer.cpu_seconds(), 0.08, 0.03);
  timer.clear();
  EXPECT_EQ(timer.cpu_seconds(), 0.0);
}

TEST(StepTimer, HeldPhase) {
  StepTimer timer;
  timer.hold(StepTimer::kCondensing);
  timer.start(StepTimer::kNodes);
  work_for(0.02);
  timer.stop();
  timer.start(StepTimer::kNodes);
  work_for(0.01);
  timer.stop();
  EXPECT_NEAR(timer.seconds()[StepTimer::kCondensing], 0.02, 0.01);
  EXPECT_NEAR(timer.seconds()[StepTimer::kNodes], 0.01, 0.009);
}

}  // namespace
}  // namespace mpdem
