// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// coupling/condensed_bond.h: loads as derivatives of the energy for any rotation, and what they keep; masses against sums over nodes.
#include "coupling/condensed_bond.h"

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "cement/condensed/rigid_pieces.h"
#include "coupling/condensed_pack.h"

#include "lanes.h"

namespace mpdem {
namespace {

using Vector3 = Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

class CondensedBond : public ::testing::Test {
 protected:
  test::Random random{5};
  BondRecord record;
  CondensedModel model;
  BondEnd ends[2] = {};

  CondensedBond() {
    for (int s = 0; s < 2; ++s) {
      record.radius[s] = 1.0 + 0.2 * s;
      set(record.centre[s], (s ? 1.3 : -1.1) * Vector3(0.36, -0.48, 0.8));
      write(record.orientation[s], Eigen::Quaterniond(random.frame()));
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
  // Grains as at the creation, all of it rotated and moved, then each by itself by up to `apart`.
  void place(double apart) {
    const Eigen::Quaterniond turn(random.frame());
    const Vector3 way = random.vector();
    for (int s = 0; s < 2; ++s) {
      const Eigen::Quaterniond own(Eigen::AngleAxisd(apart * random.uniform(0.5, 1), random.direction()));
      const double* q = record.orientation[s];
      double turned[4];
      write(turned, own * turn * Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
      ends[s].R = rotation_of(turned);
      set(ends[s].x, way + turn * CondensedMotion::vector(record.centre[s]) + apart * random.vector());
    }
  }
  void move(BondEnd& s, int component, double by) const {
    if (component < 3) {
      s.x[component] += by;
      return;
    }
    const Eigen::Matrix3d T = Eigen::AngleAxisd(by, Vector3::Unit(component - 3)).toRotationMatrix();
    const Mat3<double> R = s.R;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) s.R.a[i][j] = T(i, 0) * R.a[0][j] + T(i, 1) * R.a[1][j] + T(i, 2) * R.a[2][j];
  }
  double energy(const BondEnd* at) const { return CondensedMotion(model, record, at).energy(model); }
};

TEST_F(CondensedBond, LoadsAreDerivativesOfTheEnergy) {
  for (double apart : {1e-6, 0.01, 0.8}) {
    place(apart);
    const GrainLoads loads = CondensedMotion(model, record, ends).elastic(model);
    const double h = 1e-4 * apart + 1e-9;
    double worst = 0.0, most = 0.0;
    for (int s = 0; s < 2; ++s)
      for (int c = 0; c < 6; ++c) {
        BondEnd plus[2] = {ends[0], ends[1]}, minus[2] = {ends[0], ends[1]};
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
  EXPECT_LT(energy(ends), 1e-24);  // as made, but rotated
  place(0.5);
  const double before = energy(ends);
  const GrainLoads l = CondensedMotion(model, record, ends).elastic(model);
  Vector3 F = Vector3::Zero(), M = F;
  for (int s = 0; s < 2; ++s) {
    const Vector3 f(l.of[s][0], l.of[s][1], l.of[s][2]);
    F += f;
    M += Vector3(l.of[s][3], l.of[s][4], l.of[s][5]) + CondensedMotion::vector(ends[s].x).cross(f);
  }
  EXPECT_LT(F.norm() + M.norm(), 1e-12);
  const Eigen::Matrix3d T(random.frame());
  for (BondEnd& s : ends) {
    const Mat3<double> R = s.R;
    set(s.x, T * CondensedMotion::vector(s.x) + Vector3(1, 2, 3));
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) s.R.a[i][j] = T(i, 0) * R.a[0][j] + T(i, 1) * R.a[1][j] + T(i, 2) * R.a[2][j];
  }
  test::expect_within(std::fabs(energy(ends) / before - 1.0), 1e-12, "energy after a motion of both");
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
      ends[s].omega[c] = w[c];
      ends[s].v[c] = 0.0;
    }
  // and a resultant of centripetal forces
  for (int s = 0; s < 2; ++s) {
    set(ends[s].x, CondensedMotion::vector(record.centre[s]));
    ends[s].R = rotation_of(record.orientation[s]);
  }
  const CondensedMotion motion(rigid, record, ends);
  const CondensedMotion::Vector12 f = motion.centripetal(rigid, ends);
  const Vector3 resultant = f.segment<3>(0) + f.segment<3>(6), expected = w.cross(w.cross(centre));
  EXPECT_LT((resultant - expected).norm(), 1e-12);
}

// A piece that is rigid with a grain, as a bond between the grain and itself (cement/condensed/rigid_pieces.h), after any rotation: loads against a sum over its nodes,
// in the pack and alone.
// It is the largest eigenvalue of the coupling blocks in the metric of the others.
TEST_F(CondensedBond, CouplingIsAnEigenvalue) {
  CondensedModel::Matrix12 own = model.M, between = model.M;
  own.topRightCorner<6, 6>().setZero();
  own.bottomLeftCorner<6, 6>().setZero();
  between -= own;
  model.find_inertial_coupling();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver{Eigen::MatrixXd(between), Eigen::MatrixXd(own)};
  EXPECT_NEAR(model.inertial_coupling, solver.eigenvalues().maxCoeff(), 1e-12);
  EXPECT_GT(model.inertial_coupling, 0.01);
  double numbers[CondensedModel::kNumbers];
  model.pack(numbers);
  CondensedModel other;
  other.unpack(numbers);
  EXPECT_EQ(other.inertial_coupling, model.inertial_coupling);
  EXPECT_EQ((other.N - model.N).norm(), 0.0);
}

TEST_F(CondensedBond, RigidPieceIsTheSumOfItsNodes) {
  for (int s = 0; s < 2; ++s) {
    place(0.9);
    const BondRecord piece = record_of_piece(record, s);
    CondensedModel rigid;
    rigid.middle = model.middle;
    std::vector<std::pair<double, Vector3>> nodes;
    for (int n = 0; n < 30; ++n) {
      nodes.emplace_back(random.uniform(0.5, 1.0), random.vector());
      rigid.add_node(nodes.back().first, nodes.back().second, Eigen::Matrix<double, 3, 6>::Zero());
    }
    rigid.find_inertial_coupling();
    EXPECT_EQ(rigid.inertial_coupling, 0.0);
    GrainState state;
    std::vector<Grain> grain(1);
    grain[0].tag = piece.grain[0];
    grain[0].state = &state;
    write(state.q, Eigen::Quaterniond(random.frame()));
    Vector6 rate;
    for (int d = 0; d < 6; ++d) {
      state.v[d] = random.uniform(-1, 1);
      rate[d] = random.uniform(-1, 1);
      if (d < 3) grain[0].x[d] = random.uniform(-2, 2);
    }
    CondensedPack pack;
    const double bound[6] = {}, gravity[3] = {0.3, -0.2, -9.81};
    pack.build(MPI_COMM_SELF, {{&rigid, &piece, bound}}, grain);
    EXPECT_EQ(pack.inertial_coupling(), 0.0);
    pack.distribute(grain);
    pack.find_loads(gravity);
    pack.set_accelerations(rate.data());
    pack.find_inertial_loads();

    const Eigen::Matrix3d turn =
        Eigen::Quaterniond(state.q[0], state.q[1], state.q[2], state.q[3]).toRotationMatrix() *
        Eigen::Quaterniond(record.orientation[s][0], record.orientation[s][1], record.orientation[s][2], record.orientation[s][3])
            .conjugate();
    const Vector3 w = CondensedMotion::vector(state.v + 3);
    Vector3 force = Vector3::Zero(), moment = force;
    for (const auto& n : nodes) {
      const Vector3 r = turn * (n.second - CondensedMotion::vector(record.centre[s]));
      const Vector3 f =
          n.first * (Vector3(gravity[0], gravity[1], gravity[2]) - rate.head<3>() - Vector3(rate.tail<3>()).cross(r) - w.cross(w.cross(r)));
      force += f;
      moment += r.cross(f);
    }
    const auto bond_ends = pack.ends(0, piece);
    const GrainLoads alone = CondensedMotion(rigid, piece, bond_ends.data()).all_loads(rigid, bond_ends.data(), gravity);
    double worst = 0.0;
    for (int d = 0; d < 6; ++d) {
      const double expected = d < 3 ? force[d] : moment[d - 3];
      EXPECT_EQ(alone.of[1][d], 0.0);
      worst = std::max({worst, std::fabs(alone.of[0][d] - expected), std::fabs(pack.load(0, d) + pack.inertial_load(0, d) - expected)});
    }
    test::expect_within(worst / force.norm(), 1e-13, "loads of a rigid piece against its nodes");
  }
}

// Eleven bonds between five grains, in lanes, against one by one: large and small rotations.
TEST_F(CondensedBond, PackIsTheSumOfItsBonds) {
  constexpr int kGrains = 5, kBonds = 11;
  for (double apart : {1e-5, 0.05, 0.9}) {
    std::array<GrainState, kGrains> state;
    std::vector<Grain> grains(kGrains);
    Eigen::Matrix<double, 6, 1> rate[kGrains];
    const Eigen::Quaterniond turn(random.frame());
    for (int g = 0; g < kGrains; ++g) {
      grains[g].tag = 10 + 3 * g;
      grains[g].state = &state[g];
      grains[g].mass_ratio = 0.1 * g;
      write(state[g].q, Eigen::Quaterniond(Eigen::AngleAxisd(apart * random.uniform(0.3, 1), random.direction())) * turn);
      for (int d = 0; d < 3; ++d) grains[g].x[d] = random.uniform(-2, 2);
      for (int d = 0; d < 6; ++d) {
        state[g].v[d] = random.uniform(-1, 1);
        state[g].jump[d] = random.uniform(-1, 1);
        rate[g][d] = random.uniform(-1, 1);
      }
    }
    std::vector<CondensedModel> models(kBonds, model);
    std::vector<BondRecord> records(kBonds, record);
    const double bound[6] = {1, 2, 3, 4, 5, 6};
    std::vector<CondensedPack::Entry> entries;
    std::vector<std::array<int, 2>> ends;
    for (int b = 0; b < kBonds; ++b) {
      const int first = b % (kGrains - 1), second = first + 1 + (b % 3) % (kGrains - 1 - first);
      ends.push_back({first, second});
      for (int s = 0; s < 2; ++s) {
        const int g = ends.back()[s];
        records[b].grain[s] = grains[g].tag;
        write(records[b].orientation[s], Eigen::Quaterniond(random.frame()).slerp(0.9, Eigen::Quaterniond::Identity()));
        const Vector3 centre = turn.inverse() * CondensedMotion::vector(grains[g].x) + 0.1 * random.vector();
        set(records[b].centre[s], centre);
        for (int d = 0; d < 3; ++d) records[b].shift[s][d] = random.uniform(-0.01, 0.01) * apart;
      }
      models[b].add_node(0.7 + 0.1 * b, random.vector(), Eigen::Matrix<double, 3, 6>::Constant(0.1 * b));
      entries.push_back({&models[b], &records[b], bound});
    }
    CondensedPack pack;
    pack.build(MPI_COMM_SELF, entries, grains);
    const double gravity[3] = {0.3, -0.2, -9.81}, dt = 0.5;
    pack.distribute(grains);
    pack.find_loads(gravity);
    pack.find_jump_loads(dt);
    std::vector<double> rates;
    for (const auto& r : rate) rates.insert(rates.end(), r.data(), r.data() + 6);
    pack.set_accelerations(rates.data());
    pack.find_inertial_loads();

    std::array<double, kBonds> tension{};
    pack.each_tension([&](std::size_t member, double t) { tension.at(member) += t; });
    double sum[kGrains][6] = {}, still[kGrains][6] = {}, jump[kGrains][6] = {}, most = 0.0, worst = 0.0, worst_d = 0.0, worst_tension = 0.0;
    for (int b = 0; b < kBonds; ++b) {
      auto bond_ends = pack.ends(b, records[b]);
      const CondensedMotion motion(models[b], records[b], bond_ends.data());
      double level = 0.0;
      for (int j = 0; j < 6; ++j) {
        worst_d = std::max(worst_d, std::fabs(motion.relative()[j] - pack.relative(b, j)));
        level += bound[j] * std::fabs(motion.relative()[j]);
      }
      EXPECT_NEAR(pack.level(b), level, 1e-11 * (1 + level));
      const GrainLoads all = motion.all_loads(models[b], bond_ends.data(), gravity);
      const Vector3 apart = CondensedMotion::vector(bond_ends[1].x) - CondensedMotion::vector(bond_ends[0].x);
      const Vector3 pull = 0.5 * (CondensedMotion::vector(all.of[0]) - CondensedMotion::vector(all.of[1]));
      worst_tension = std::max(worst_tension, std::fabs(tension[b] - pull.dot(apart) / apart.norm()));
      const GrainLoads of_jump = motion.loads(-1.0 / dt * (models[b].M * motion.to_q(bond_ends[0].jump, bond_ends[1].jump)));
      for (BondEnd& s : bond_ends) {
        std::fill(s.a, s.a + 3, 0.0);
        std::fill(s.alpha, s.alpha + 3, 0.0);
      }
      const GrainLoads without = motion.all_loads(models[b], bond_ends.data(), gravity);
      for (int s = 0; s < 2; ++s)
        for (int d = 0; d < 6; ++d) {
          sum[ends[b][s]][d] += all.of[s][d];
          still[ends[b][s]][d] += without.of[s][d];
          jump[ends[b][s]][d] += of_jump.of[s][d];
        }
    }
    EXPECT_LT(worst_d, 1e-12);
    for (int g = 0; g < kGrains; ++g)
      for (int d = 0; d < 6; ++d) {
        most = std::max({most, std::fabs(sum[g][d]), std::fabs(jump[g][d])});
        worst = std::max({worst, std::fabs(pack.load(g, d) - still[g][d]),
                          std::fabs(pack.load(g, d) + pack.inertial_load(g, d) - sum[g][d]), std::fabs(pack.jump_load(g, d) - jump[g][d])});
      }
    EXPECT_GT(most, 1.0);
    test::expect_within(worst / most, 1e-13, "loads on grains, in lanes and one by one");
    test::expect_within(worst_tension / most, 1e-13, "tension, in lanes and one by one");
  }
}

}  // namespace
}  // namespace mpdem
