// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include <algorithm>

#include "coupling/penalty_links.h"
#include "linked_bonds.h"

namespace mpdem {
namespace {

using test::copy;
using test::Scene;
using test::Vector;

constexpr double kSoft = 20.0;  // Young's modulus of grains whose compliance is of the order of that of the links

Scene soft_scene(std::uint64_t seed, double E = kSoft) { return Scene(seed, test::penalty(true, 0.0), Basis::quadratic, 2, 0.15, E); }

double energy_of_balance(Scene& s) {
  s.add_force();
  return s.spring_energy();
}

TEST(ElasticLinks, ForceAndMomentDeriveFromTheEnergy) {
  Scene s = soft_scene(231);
  s.place_grains(0.3, 0.0);
  s.add_force();
  const std::vector<std::vector<double>> f = s.forces();
  const std::vector<BondEnd> felt = s.ends.ends;
  double f_size = 0, F_size = 0;
  for (const auto& of_bond : f)
    for (double one : of_bond) f_size = std::max(f_size, std::fabs(one));
  for (const BondEnd& g : felt)
    for (int d = 0; d < 3; ++d) F_size = std::max({F_size, std::fabs(g.force[d]), std::fabs(g.torque[d])});
  test::Worst node, grain, torque;
  for (Bond& b : s.bonds)
    for (std::size_t i = 0; i < b.grid.force.size(); i += 7) {
      double& u = b.grid.displacement[i];
      const double u0 = u, step = 0.1;
      u = u0 + step;
      const double ahead = energy_of_balance(s);
      u = u0 - step;
      const double behind = energy_of_balance(s);
      u = u0;
      node.add(std::fabs(f[b.row][i] + (ahead - behind) / (2 * step)) / f_size);
    }
  for (int i = 0; i < 4; ++i)
    for (int d = 0; d < 3; ++d) {
      const BondEnds::Motion at = s.motion[i];
      const auto moved = [&](double step) {
        s.motion[i] = at;
        s.motion[i].x[d] += step;
        return energy_of_balance(s);
      };
      const auto slope = [&](double a) {
        s.motion[i] = at;
        s.turn(i, a * Vector::Unit(d));
        const double ahead = energy_of_balance(s);
        s.motion[i] = at;
        s.turn(i, -a * Vector::Unit(d));
        return (ahead - energy_of_balance(s)) / (2 * a);
      };
      grain.add(std::fabs(felt[i].force[d] + (moved(0.1) - moved(-0.1)) / 0.2) / F_size);
      const double fine = slope(0.01), middle = slope(0.02), coarse = slope(0.04);
      const double one = (4 * fine - middle) / 3, two = (4 * middle - coarse) / 3;
      torque.add(std::fabs(felt[i].torque[d] + (16 * one - two) / 15) / F_size);
      s.motion[i] = at;
    }
  expect_within(node, 1e-10, "nodes");
  expect_within(grain, 1e-10, "force on the grains");
  expect_within(torque, 1e-8, "moment on the grains");
}

TEST(ElasticLinks, ActionIsReaction) {
  Scene s = soft_scene(232);
  s.place_grains(0.3, 0.0);
  s.add_force();
  s.expect_balanced(s.forces(), 1e-13, "springs");
}

TEST(ElasticLinks, StiffGrainsAreRigid) {
  Scene rigid(233, test::penalty(true, 0.0)), stiff = soft_scene(233, 1e16), soft = soft_scene(233);
  for (Scene* s : {&rigid, &stiff, &soft}) {
    s->place_grains(0.3, 0.0);
    s->add_force();
  }
  const double all = rigid.spring_energy();
  EXPECT_NEAR(stiff.spring_energy(), all, 1e-10 * all);
  EXPECT_LT(soft.spring_energy(), 0.9 * all);
  for (int b = 0; b < 2; ++b)
    for (std::size_t i = 0; i < rigid.bonds[b].grid.force.size(); ++i)
      ASSERT_NEAR(stiff.bonds[b].grid.force[i], rigid.bonds[b].grid.force[i], 1e-8);
  // added mass covers softer links
  const std::vector<double> of_rigid = rigid.row_sums(rigid.bonds[0]), of_soft = soft.row_sums(soft.bonds[0]);
  for (std::size_t i = 0; i < of_rigid.size(); ++i) EXPECT_LE(of_soft[i], of_rigid[i]);
}

TEST(ElasticLinks, SmallMotionsGiveTheForceOfTheStep) {
  Scene s = soft_scene(234);
  s.place_grains(0.0, 0.0);
  for (Bond& b : s.bonds)
    for (double& u : b.grid.displacement) u = 1e-3 * s.random.uniform(-1, 1);
  s.add_force();
  for (const Bond& b : s.bonds) {
    const BondEnd* ends = s.ends_of(b);
    const auto secants = b.links.secants(b.grid, ends);
    const double none[2][6] = {};
    double load[2][6] = {};
    std::vector<double> force(b.grid.force.size(), 0.0);
    b.links.add_small_force(secants, b.grid.displacement.data(), none, force.data(), load);
    auto modes = b.links.small_modal_loads(secants, ends, b.grid.displacement.data(), none);
    for (int side = 0; side < 2; ++side) modes[side] = b.links.modal_response(side, b.links.modal_stiffness(side)) * modes[side];
    b.links.add_small_elastic_force(secants, ends, modes, force.data(), load);
    for (std::size_t i = 0; i < force.size(); ++i) ASSERT_NEAR(force[i], b.grid.force[i], 1e-12);
    for (int side = 0; side < 2; ++side)
      for (int d = 0; d < 3; ++d) {
        ASSERT_NEAR(load[side][d], ends[side].force[d], 1e-12);
        ASSERT_NEAR(load[side][3 + d], ends[side].torque[d], 1e-12);
      }
  }
}

// Work of the mean force over a step, change of energy, and what links that debond in it release.
TEST(ElasticLinks, DebondingReleasesWhatIsMissing) {
  Scene s = soft_scene(235);
  s.place_grains(0.02, 0.3);
  for (BondEnds::Motion& m : s.motion) copy(Vector::Zero(), m.omega);
  s.ends.distribute(s.records, s.motion);
  s.add_force();
  for (Bond& b : s.bonds) {
    BondEnd* ends = s.ends_of(b);
    const std::vector<double> f0 = b.grid.force;
    const BondEnd before[2] = {ends[0], ends[1]};
    double U0 = 0.0, U1 = 0.0, released = 0.0;
    b.links.add_spring_energy(b.grid, ends, U0);
    const double dt = 0.05;
    for (std::size_t i = 0; i < b.grid.displacement.size(); ++i) b.grid.displacement[i] += dt * b.grid.velocity[i];
    for (int side = 0; side < 2; ++side)
      for (int d = 0; d < 3; ++d) {
        ends[side].x[d] += dt * ends[side].v[d];
        ends[side].force[d] = ends[side].torque[d] = 0.0;
      }
    b.grid.clear_force();
    std::vector<int> failed;
    for (std::size_t n = 0; n < s.slots[b.row].size(); n += 2) failed.push_back(s.slots[b.row][n]);
    std::sort(failed.begin(), failed.end());
    b.sort_links();
    EXPECT_GT(b.links.debond(b.points, failed, b.grid, ends, dt, released).size(), 10u);
    LinkStep step;
    b.links.update_and_add_force(b.points, b.grid, ends, dt, step);
    released += step.released;
    b.links.add_spring_energy(b.grid, ends, U1);
    double work = 0.0;
    for (std::size_t i = 0; i < f0.size(); ++i) work += 0.5 * (f0[i] + b.grid.force[i]) * dt * b.grid.velocity[i];
    for (int side = 0; side < 2; ++side)
      for (int d = 0; d < 3; ++d) work += 0.5 * (before[side].force[d] + ends[side].force[d]) * dt * ends[side].v[d];
    EXPECT_GT(std::fabs(released), 0.05 * U0);
    EXPECT_NEAR(work + released, U0 - U1, 1e-11 * U0);
  }
}

}  // namespace
}  // namespace mpdem
