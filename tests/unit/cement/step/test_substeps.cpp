// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Sub-steps of the cement in a step of the host, on 1, 2 and 4 ranks.
#include "cement/step/formulations.h"
#include "cement/engine/cement.h"

#include <cstring>

#include "lanes.h"
#include "cement_host.h"
#include "mpi_ranks.h"

namespace mpdem {
namespace {

using test::Row;
using test::RowOfGrains;

// Largest difference over the largest number of the kind, over all points and grains. Of grains three numbers are one kind. What is almost nothing has
// no digits.
double difference(const std::map<int, std::vector<double>>& a, const std::map<int, std::vector<double>>& b) {
  constexpr double kNothing = 1e-7;
  EXPECT_EQ(a.size(), b.size());
  std::map<std::pair<bool, std::size_t>, std::array<double, 2>> most;  // of points or grains, by place in the record
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end(); ++i, ++j) {
    EXPECT_EQ(i->first, j->first);
    for (std::size_t n = 0; n < std::min(i->second.size(), j->second.size()); ++n) {
      std::array<double, 2>& m = most[{i->first > 0, i->first > 0 ? n : n / 3}];
      m[0] = std::max(m[0], std::fabs(i->second[n] - j->second[n]));
      m[1] = std::max(m[1], std::fabs(j->second[n]));
    }
  }
  double worst = 0.0;
  for (const auto& m : most) worst = std::max(worst, m.second[0] / std::max(kNothing, m.second[1]));
  return worst;
}

struct Case {
  int mass_order;
  double length;
  int substeps;
};
class Divided : public ::testing::TestWithParam<Case> {};

// A step with n sub-steps is n steps, if the load of the host is nothing: by prescribed and free grains, while points fail.
TEST_P(Divided, IsThatManySteps) {
  const Case& c = GetParam();
  Row r;
  r.bonds = 2;
  r.free_middle = true;
  r.ramp = 0.0;
  r.speed = 2.0;
  r.mass_order = c.mass_order;
  r.length = c.length;
  RowOfGrains fine(MPI_COMM_WORLD, r);
  r.substeps = c.substeps;
  RowOfGrains coarse(MPI_COMM_WORLD, r);
  coarse.dt = c.substeps * test::kStep;
  fine.setup();
  coarse.setup();
  double worst = 0.0;
  for (int n = 0; n < 900 / c.substeps && fine.all_failed().size() < 20; ++n) {
    coarse.step();
    fine.run(c.substeps);
    if (n % 10 == 0) worst = std::max(worst, difference(coarse.content(), fine.content()));
  }
  test::expect_within(worst, 1e-6, "points and grains");
  EXPECT_GE(fine.all_failed().size(), 20u);
  std::vector<std::array<int, 2>> expected;
  for (const auto& e : fine.all_failed()) expected.push_back({(e[0] + c.substeps - 1) / c.substeps, e[1]});
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(coarse.all_failed(), expected);
  const CementTotals a = coarse.cement->report().totals(0.1), b = fine.cement->report().totals(0.1);
  for (double CementTotals::*sum :
       {&CementTotals::kinetic, &CementTotals::elastic, &CementTotals::dissipated, &CementTotals::released, &CementTotals::external_work})
    EXPECT_NEAR(a.*sum, b.*sum, 1e-9 * b.external_work);
  test::expect_within(std::fabs(a.imbalance), 1e-3, "imbalance of the energy");
}

INSTANTIATE_TEST_SUITE_P(Substeps, Divided,
                         ::testing::Values(Case{1, 0.0, 2}, Case{1, 0.0, 7}, Case{2, 0.0, 7}, Case{1, 2.5 * test::kSpacing, 7}),
                         [](const ::testing::TestParamInfo<Case>& p) {
                           return "order" + std::to_string(p.param.mass_order) + (p.param.length > 0.0 ? "_nonlocal_" : "_") +
                                  std::to_string(p.param.substeps);
                         });

// Cement of one bond, kg.
double cement_mass() { return 2710 * M_PI * (test::kGap * test::kOuter * test::kOuter + 0.5 * std::pow(test::kOuter, 4) / test::kRadius); }

struct Sums {
  double momentum[3], angular_momentum[3], energy;
};
// Sums over grains and cement, with the energy of the springs between them.
Sums sums_of(RowOfGrains& host) {
  const CementTotals t = host.cement->report().totals(0.1);
  Sums s{};
  for (const Grain& g : host.cement->grains().grains)
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      s.momentum[d] += g.mass * g.velocity[d];
      s.angular_momentum[d] += g.mass * (g.x[e] * g.velocity[f] - g.x[f] * g.velocity[e]) + g.inertia * g.velocity[3 + d];
      s.energy += 0.5 * g.mass * g.velocity[d] * g.velocity[d] + 0.5 * g.inertia * g.velocity[3 + d] * g.velocity[3 + d];
    }
  for (int d = 0; d < 3; ++d) {
    s.momentum[d] = host.sum(s.momentum[d]) + t.momentum[d];
    s.angular_momentum[d] = host.sum(s.angular_momentum[d]) + t.angular_momentum[d];
  }
  s.energy = host.sum(s.energy) + t.kinetic + t.elastic + t.coupling + host.contact_energy();
  return s;
}

struct Pair {
  double ratio;    // mass of both grains over that of their cement
  double contact;  // its frequency times the step of the host, 2 is its limit
  int substeps;
};
double step_of_host(const Pair& p) { return p.substeps * test::kStep; }

Row free_row(const Pair& p) {
  Row r;
  r.free_ends = true;
  r.substeps = p.substeps;
  r.B0 = 0.0;
  r.grain_mass = 0.5 * p.ratio * cement_mass();
  r.contact = 0.5 * r.grain_mass * p.contact * p.contact / (step_of_host(p) * step_of_host(p));
  return r;
}

// Sets all components of the velocity of both grains.
void spin(RowOfGrains& host, double first, double second) {
  for (Grain& g : host.cement->grains().grains)
    for (int d = 0; d < 6; ++d) g.velocity[d] = (g.tag == 1 ? first : second) * (d + 1) * (d < 3 ? 1.0 : 20.0);
}

// Free grains in a spin, pulled apart by the host with forces along z that have no sum, as a contact has none.
TEST(Substeps, MomentumStays) {
  Row r = free_row({40.0, 0.0, 9});
  r.contact = 1e6;
  r.pull[2] = 5.0;
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.dt = r.substeps * test::kStep;
  host.setup();
  spin(host, 0.02, -0.03);
  host.step();
  const Sums from = sums_of(host);
  double most[2] = {0.0, 0.0};
  for (int n = 0; n < 60; ++n) {
    host.step();
    const Sums s = sums_of(host);
    for (int d = 0; d < 3; ++d) most[0] = std::max(most[0], std::fabs(s.momentum[d] - from.momentum[d]));
    most[1] = std::max(most[1], std::fabs(s.angular_momentum[2] - from.angular_momentum[2]));
  }
  test::expect_within(most[0] / (r.grain_mass * 0.1), 1e-11, "momentum");
  test::expect_within(most[1] / (r.grain_mass * 0.1 * test::kRadius), 1e-11, "angular momentum");
}

class FreePair : public ::testing::TestWithParam<Pair> {};

// The energy stays. Without a contact it stays as in the step itself. With one it swings by what a spring at that step makes it
// swing, (w dt/2)^2 of it. With a contact that is known at the ends of the step alone there are bands of steps in which energy
// grows. None of these pairs is in one.
TEST_P(FreePair, EnergyStays) {
  if (test::ranks() > 1) GTEST_SKIP() << "each rank would do the same";
  const Pair& p = GetParam();
  Row r = free_row(p);
  RowOfGrains host(MPI_COMM_SELF, r);
  host.dt = step_of_host(p);
  host.setup();
  for (Grain& g : host.cement->grains().grains) g.velocity[2] = g.tag == 1 ? -0.01 : 0.01;
  host.step();
  const double from = sums_of(host).energy;
  double worst = 0.0;
  for (int n = 0; n < 300; ++n) {
    host.step();
    worst = std::max(worst, std::fabs(sums_of(host).energy / from - 1.0));
  }
  test::expect_within(worst, (p.ratio < 1.0 ? 0.03 : 0.003) + 0.5 * p.contact * p.contact, "energy");
}

INSTANTIATE_TEST_SUITE_P(Substeps, FreePair,
                         ::testing::Values(Pair{0.1, 0.0, 5}, Pair{0.1, 0.0, 9}, Pair{1.0, 0.0, 14}, Pair{10.0, 0.0, 23},
                                           Pair{100.0, 0.0, 14}, Pair{1e4, 0.0, 14}, Pair{10.0, 0.4, 14}, Pair{100.0, 0.4, 9},
                                           Pair{1e4, 0.4, 14}, Pair{1e4, 1.0, 9}));

// The work of loads of the host on cement that they move along is in the energy balance.
// With compliant links and cement it is not that of the grains alone.
TEST_P(FreePair, BooksBalance) {
  const Pair& p = GetParam();
  Row r = free_row(p);
  r.pull[2] = 3.0 * p.ratio;  // of the order of the inertia, so that rounding of places does not count
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.dt = step_of_host(p);
  host.setup();
  double worst = 0.0, most = 0.0;  // it swings back to almost no work
  for (int n = 0; n < 200; ++n) {
    host.step();
    if (n % 10 != 9) continue;
    const CementTotals t = host.cement->report().totals(0.1);
    worst = std::max(worst, std::fabs(t.imbalance * t.external_work));
    most = std::max(most, t.external_work);
  }
  test::expect_within(worst / most, 1e-6, "imbalance of the energy");
}

// Half of the points of a bond failed and are connected to nothing. The host has forces for long, and the other half carries them.
// These forces do not set the failed points in motion.
TEST(Substeps, FailedPointsAreNotPushed) {
  Row r;
  r.free_ends = true;
  r.crumbled = 1e-9;
  r.pull[2] = 30.0;
  r.grain_mass = 50 * cement_mass();
  CementTotals t[2];
  for (int divided = 0; divided < 2; ++divided) {
    r.substeps = divided ? 10 : 1;
    RowOfGrains host(MPI_COMM_WORLD, r);
    host.dt = r.substeps * test::kStep;
    host.setup();
    for (int n = 0; n < (divided ? 100 : 1000); ++n) {
      for (Grain& g : host.cement->grains().grains) {  // as if the load began now: all of it is a kick, and nothing is spread
        GrainState& state = *g.state;
        for (double* numbers : {state.mean_at_end, state.off}) std::fill(numbers, numbers + 6, 0.0);
        std::fill(state.mean, state.mean + 18, 0.0);
        state.off_squared = 0.0;
      }
      host.step();
    }
    t[divided] = host.cement->report().totals(0.1);
    EXPECT_EQ(t[divided].separated, 0.0);
    test::expect_within(std::fabs(t[divided].imbalance), 1e-6, "imbalance of the energy");
  }
  EXPECT_NEAR(t[1].external_work / t[0].external_work, 1.0, 2e-3);
  EXPECT_NEAR(t[1].kinetic / t[0].kinetic, 1.0, 0.05);
}

// A load of the host that stays acts as in short steps, through failure: nothing of it is a kick of the whole step.
class SteadyLoads : public ::testing::TestWithParam<double> {};
TEST_P(SteadyLoads, AreThoseOfShortSteps) {
  Row r;
  r.stiffer = GetParam();
  r.free_ends = true;
  r.grain_mass = 3 * cement_mass();
  r.pull[0] = 20.0;
  r.pull[2] = 60.0;
  RowOfGrains fine(MPI_COMM_WORLD, r);
  r.substeps = 8;
  RowOfGrains coarse(MPI_COMM_WORLD, r);
  coarse.dt = r.substeps * test::kStep;
  fine.setup();
  coarse.setup();
  EXPECT_EQ(coarse.cement->report().added_mass_of_ends()[0] > 0.0, GetParam() > 1.0);
  double worst = 0.0;
  for (int n = 0; n < 200 && fine.all_failed().size() < 20; ++n) {
    coarse.step();
    fine.run(r.substeps);
    if (n % 10 == 0) worst = std::max(worst, difference(coarse.content(), fine.content()));
  }
  test::expect_within(worst, 1e-6, "points and grains");
  EXPECT_GE(fine.all_failed().size(), 20u);
  EXPECT_EQ(coarse.all_failed().size(), fine.all_failed().size());
}
// At 40.0 the links add mass to the nodes, which goes along with the accelerations of the grains. At 1.0 they add none.
INSTANTIATE_TEST_SUITE_P(Substeps, SteadyLoads, ::testing::Values(1.0, 40.0));

// Forces are spread over a step in which grains move on curves. They have the moment of forces at the ends of the step.
TEST(Substeps, MomentOfSpreadLoads) {
  Row r = free_row({40.0, 0.0, 9});
  r.pull[0] = 3.0;
  r.pull[1] = -2.0;
  r.pull[2] = 5.0;
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.dt = r.substeps * test::kStep;
  host.setup();
  spin(host, 0.2, -0.3);
  host.step();
  const auto moment = [&](int d) {
    double here = 0.0;
    for (const Grain& g : host.cement->grains().grains) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      here += (g.tag == 1 ? -1.0 : 1.0) * (g.x[e] * r.pull[f] - g.x[f] * r.pull[e]);
    }
    return host.sum(here);
  };
  double worst = 0.0, expected[3], before[3];
  const Sums from = sums_of(host);
  for (int d = 0; d < 3; ++d) {
    expected[d] = from.angular_momentum[d];
    before[d] = moment(d);
  }
  for (int n = 0; n < 60; ++n) {
    if (n % 2) host.hand_over_at(host.number + 1, -1, 0);  // atoms are exchanged between the sub-steps and the forces
    host.step();
    const Sums s = sums_of(host);
    for (int d = 0; d < 3; ++d) {
      const double now = moment(d);
      expected[d] += 0.5 * host.dt * (before[d] + now);
      before[d] = now;
      worst = std::max(worst, std::fabs(s.angular_momentum[d] - expected[d]));
    }
  }
  test::expect_within(worst / (r.grain_mass * test::kRadius), 2e-11, "angular momentum");
}

// Stiffness of a row of grains along z on massless springs, in all their motions.
Eigen::MatrixXd stiffness_of_row(const std::vector<StiffnessOfBond>& bonds) {
  const int n = static_cast<int>(bonds.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(6 * (n + 1), 6 * (n + 1));
  for (int b = 0; b < n; ++b) {
    Eigen::Matrix<double, 6, 12> motion = Eigen::Matrix<double, 6, 12>::Zero();
    for (int s = 0; s < 2; ++s)
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, f = (d + 2) % 3;
        const double sign = s == 0 ? -1.0 : 1.0,
                     arm = d < 2 ? 0.0 : -sign * (test::kRadius + 0.5 * test::kGap);  // from the grain to the middle
        motion(d, 6 * s + d) = motion(3 + d, 6 * s + 3 + d) = sign;
        if (arm != 0.0) {
          motion(f, 6 * s + 3 + e) = -sign * arm;  // a rotation about e takes what lies along d along -f
          motion(e, 6 * s + 3 + f) = sign * arm;
        }
      }
    K.block<12, 12>(6 * b, 6 * b) += motion.transpose() * Eigen::Map<const Matrix6>(bonds[b].K) * motion;
  }
  return K;
}

void scale_by_mass(Eigen::MatrixXd& K, int grain, double mass) {
  for (int d = 0; d < 6; ++d) {
    const double scale = 1.0 / std::sqrt(d < 3 ? mass : 0.4 * mass * test::kRadius * test::kRadius);
    K.row(6 * grain + d) *= scale;
    K.col(6 * grain + d) *= scale;
  }
}

// Twice the largest eigenvalue of each grain alone is the bound. A grain between two others has the levers of both.
TEST(Substeps, StepOfAGrainBetweenTwo) {
  Row r;
  r.bonds = 2;
  r.free_ends = r.free_middle = true;
  r.substeps = 20;
  r.B0 = 0.0;
  r.grain_mass = 500 * cement_mass();
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.dt = r.substeps * test::kStep;
  host.setup();
  const double light = 0.1 * r.grain_mass;
  for (Grain& g : host.cement->grains().grains)
    if (g.tag == 2) {
      g.mass = light;
      g.inertia = 0.4 * light * test::kRadius * test::kRadius;
    }
  Eigen::MatrixXd K = stiffness_of_row(host.cement->stiffness_of_bonds());
  scale_by_mass(K, 1, light);
  const double largest = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K.block<6, 6>(6, 6)).eigenvalues()[5];
  test::expect_within(std::fabs(host.cement->grains_step() * std::sqrt(2.0 * largest) / 2.0 - 1.0), 3e-15,
                      "step of the grain in the middle");
}

// Grains weigh much more than the cement between them. The frequency of the pair is that of the static stiffness, and not that of
// the step of the host.
TEST(Substeps, FrequencyOfAFreePair) {
  Row r;
  r.free_ends = true;
  r.substeps = 20;
  r.B0 = 0.0;
  r.grain_mass = 500 * cement_mass();
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.dt = r.substeps * test::kStep;
  host.setup();
  const StiffnessOfBond found = host.cement->stiffness_of_bonds()[0];
  const double w =
      std::sqrt(2.0 * found.K[14] / (r.grain_mass + 0.5 * cement_mass() / 3.0));  // z, z; a third of either half of the cement moves along
  Eigen::MatrixXd K = stiffness_of_row(host.cement->stiffness_of_bonds());
  scale_by_mass(K, 0, r.grain_mass);
  scale_by_mass(K, 1, r.grain_mass);
  const double largest = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues()[11];
  const double share = host.cement->grains_step() * std::sqrt(largest);  // of a bound
  EXPECT_LE(share, 2.0 * (1.0 + 1e-9));
  EXPECT_GE(share, 1.995);
  for (Grain& g : host.cement->grains().grains) g.velocity[2] = g.tag == 1 ? -0.01 : 0.01;
  double last = 0.0, first = 0.0, end = 0.0;
  int crossings = 0;
  for (int n = 1; n < 4000 && crossings < 5; ++n) {
    host.step();
    const double stretch = host.contact_stretch();
    if (n > 1 && stretch * last < 0.0) {
      end = (n - 1 + last / (last - stretch)) * host.dt;
      if (crossings++ == 0) first = end;
    }
    last = stretch;
  }
  ASSERT_EQ(crossings, 5);
  EXPECT_NEAR(M_PI * 4 / (end - first) / w, 1.0, 2e-3);
}

// Pulled to failure: the same peak and events of all ranks, as one alone has them; the energies balance.
TEST(Substeps, PulledThroughFailure) {
  Row r;
  r.ramp = 8e-6;
  r.speed = 2.0;
  double peak[2];
  for (int divided = 0; divided < 2; ++divided) {
    r.substeps = divided ? 10 : 1;
    RowOfGrains host(MPI_COMM_WORLD, r), alone(MPI_COMM_SELF, r);
    host.dt = alone.dt = r.substeps * test::kStep;
    host.setup();
    alone.setup();
    peak[divided] = 0.0;
    for (int n = 0; n < 300; ++n) {
      host.run(divided ? 1 : 10);
      alone.run(divided ? 1 : 10);
      peak[divided] = std::max(peak[divided], host.tension(0));
    }
    const CementTotals t = host.cement->report().totals(0.1);
    EXPECT_EQ(t.separated, 1.0);
    test::expect_within(std::fabs(t.imbalance), 2e-3, "imbalance of the energy");
    EXPECT_EQ(host.all_failed(), alone.all_failed());
    EXPECT_EQ(host.separated, alone.separated);
  }
  EXPECT_NEAR(peak[1] / peak[0], 1.0, 5e-3);
}

TEST(Substeps, RestartsToTheBit) {
  Row r;
  r.bonds = 2;
  r.free_middle = true;
  r.substeps = 6;
  r.pull[2] = 3.0;
  RowOfGrains whole(MPI_COMM_WORLD, r);
  whole.dt = r.substeps * test::kStep;
  whole.setup();
  for (int at : {50, 95}) test::expect_restart_to_the_bit(whole, r, at, 17, whole.dt, [](RowOfGrains&) {});
  EXPECT_GT(whole.cement->report().totals(0.1).failed, 50.0);
}

// A host that nobody asks.
class NoHost : public CementHost {
 public:
  std::array<double, 3> initial_velocity(int) override { return {0.0, 0.0, 0.0}; }
  void points_failed(const Bond&) override {}
  void links_debonded(const Bond&) override {}
  void slots_changed(const Bond&) override {}
};

// The grains by themselves: one that is moved at an even acceleration, and one that follows an even load, are where they
// have to be in each sub-step.
TEST(Substeps, BringGrainsToWhereTheStepEnds) {
  constexpr int kSubsteps = 4;
  constexpr double kTime = 1.0, kLoad = 6.0, kMass = 2.0;
  Bonds bonds;
  NoHost host;
  Scene scene(MPI_COMM_SELF, bonds, host, CementOptions(), formulation_of(CementOptions()), nullptr);
  scene.now.substeps = kSubsteps;
  scene.now.dt = kTime / kSubsteps;
  GrainState state[2];
  std::vector<Grain> grains(2);
  for (int g = 0; g < 2; ++g) {
    grains[g].tag = 1 + g;
    grains[g].mass = kMass;
    grains[g].inertia = 1.0;
    grains[g].radius = 1.0;
    grains[g].velocity[0] = 1.0;
    grains[g].velocity[3] = g == 0 ? 0.5 : 0.0;
    grains[g].state = &state[g];
    for (bool& f : grains[g].free) f = g == 1;
  }
  grains[1].force[0] = state[1].mean_at_end[0] = state[1].mean[12] = kLoad;
  scene.grains.replace(grains);

  Substeps substeps(scene);
  substeps.begin();
  Grain &moved = scene.grains.grains[0], &pulled = scene.grains.grains[1];
  moved.x[0] = 2.0;  // the host moves them
  moved.velocity[0] = 3.0;
  moved.velocity[3] = 1.5;
  pulled.x[0] = 77.0;  // which does not matter for one that is free
  substeps.find_paths();
  for (scene.substep = 1; scene.substep <= kSubsteps; ++scene.substep) {
    const double t = scene.now.dt * scene.substep, a = kLoad / kMass;
    substeps.move_grains();
    EXPECT_NEAR(moved.x[0], t + t * t, 1e-14) << scene.substep;
    EXPECT_NEAR(moved.velocity[0], 1.0 + 2.0 * t, 1e-14) << scene.substep;
    EXPECT_NEAR(moved.velocity[3], 0.5 + (t - 0.5 * scene.now.dt), 1e-14) << scene.substep;
    EXPECT_NEAR(2.0 * std::atan2(state[0].q[1], state[0].q[0]), 0.5 * t + 0.5 * t * t, 1e-14) << scene.substep << ", its turn";
    EXPECT_NEAR(pulled.x[0], t + 0.5 * a * t * t, 1e-14) << scene.substep;
    EXPECT_NEAR(pulled.velocity[0], 1.0 + a * (t - 0.5 * scene.now.dt), 1e-14) << scene.substep;
    if (!scene.ends_step()) substeps.kick_grains();
  }
  EXPECT_NEAR(state[0].x[0], 0.75 + 0.75 * 0.75, 1e-14) << "the place before the last sub-step";
}

}  // namespace
}  // namespace mpdem
