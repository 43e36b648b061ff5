// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Two bonds between pairs of grains that have moved and rotated. The second bond has two layers. Some
// points are linked to both grains, some to none.
#ifndef MPDEM_TESTS_LINKED_BONDS_H
#define MPDEM_TESTS_LINKED_BONDS_H

#include <algorithm>
#include <string>
#include <vector>

#include "cement.h"
#include "cement/bond/bond.h"
#include "coupling/penalty_traction.h"

namespace mpdem::test {

constexpr double kH = 0.1, kDensity = 2.0;
constexpr double kDt = 0.05, kBound = 4.0;

inline void copy(const Vector& from, double* to) { std::copy(from.data(), from.data() + 3, to); }
inline void copy(const Eigen::Quaterniond& q, double* to) {
  to[0] = q.w();
  to[1] = q.x();
  to[2] = q.y();
  to[3] = q.z();
}

struct Scene {
  std::vector<BondRecord> records{2};
  std::vector<Bond> bonds{2};
  std::vector<int> slots[2];  // slots of the points of either bond, in the order they were made
  BondEnds ends;
  std::vector<BondEnds::Motion> motion{4};  // motion of the ends 0 and 1 of bond 0, then of bond 1
  Random random;

  // parts: number of layers of the second bond; width: points lie within this of the origin along each axis; grain_E: Young's modulus
  // of the first grain of each bond, and half of that of the second; 0: rigid
  Scene(std::uint64_t seed, const PenaltyParameters& p, Basis basis = Basis::quadratic, int parts = 2, double width = 0.15,
        double grain_E = 0.0)
      : random(seed) {
    int tag = 1;
    for (int b = 0; b < 2; ++b) {
      BondRecord& record = records[b];
      bonds[b].row = b;
      const Vector n = random.direction();
      copy(random.vector(), record.origin);
      for (int s = 0; s < 2; ++s) {
        record.grain[s] = 10 * b + s + 1;
        record.radius[s] = 1.0 + 0.3 * s;
        copy((s ? 1.0 : -1.0) * (record.radius[s] + 0.02) * n, record.centre[s]);
        copy(Eigen::Quaterniond(random.frame()), record.orientation[s]);
        copy(10.0 * random.vector(), record.shift[s]);
        record.grain_E[s] = (1.0 + s) * grain_E;
        record.grain_nu[s] = 0.22;
        record.patch[s][1] = 0.35;  // all points are within this angle
      }
      for (int i = 0; i < 60; ++i) {
        PointRecord r;
        r.row = b;
        r.layer = b * random.index(parts);
        r.volume = random.uniform(0.5, 1.0) * kH * kH * kH / 8;
        const Vector X = width * random.vector();
        copy(X, r.X);
        for (int s = 0; s < 2; ++s) {
          if (random.index(3) == 0) continue;
          const Vector centre = Eigen::Map<const Vector>(record.centre[s]);
          Link& k = r.link[r.links++];
          k.grain = record.grain[s];
          k.area = random.uniform(0.5, 1.0) * kH * kH / 4;
          k.attached = 1;
          copy(centre + record.radius[s] * (X - centre).normalized(), k.foot);
        }
        slots[b].push_back(bonds[b].points.add(r, tag++));
      }
      lay_out(bonds[b], p, basis);
    }
    const std::vector<Key> all{{0, 0, 0, 0}, {0, 1, 0, 0}, {1, 0, 0, 0}, {1, 1, 0, 0}};
    ends.build(MPI_COMM_SELF, records, {0, 1}, all);
    for (Bond& b : bonds) b.first_end_index = ends.find(b.row, 0);
    place_grains(0.0, 0.0);
  }

  void lay_out(Bond& b, const PenaltyParameters& p, Basis basis) {
    const std::vector<int> place = b.points.arrange(kH, basis);
    for (int& slot : slots[b.row]) slot = place[slot];
    b.links = PenaltyLinks(b.points, records[b.row], p, kH, kDensity, basis);
    std::vector<Grid::Cell> cells;
    for (BlockMeta& m : b.points.meta) cells.push_back({field_of(m.row, m.layer), m.base, m.column});
    b.links.add_cells(cells);
    std::vector<char> fresh;
    b.grid.basis = basis;
    b.grid.build(MPI_COMM_SELF, kH, cells, NodeKinematics(), fresh);
    b.grid.lump_mass(b.points, kDensity);
  }
  // Links made from the store as it is now, on the grid as it is.
  PenaltyLinks links_anew(const Bond& b) const {
    PenaltyLinks links(b.points, records[b.row], b.links.parameters(), kH, kDensity, b.grid.basis);
    EXPECT_TRUE(links.find_columns(b.grid));
    return links;
  }
  void tie() {
    for (Bond& b : bonds) {
      b.grid.constrain(find_extension_constraints(MPI_COMM_SELF, b.grid.basis, edges_of(b.grid)), true);
      b.grid.lump_mass(b.points, kDensity);
    }
  }
  BondEnd* ends_of(const Bond& b) { return &ends.ends[b.first_end_index]; }
  const BondEnd* ends_of(const Bond& b) const { return &ends.ends[b.first_end_index]; }
  // Row sums of the stiffness of the links: two numbers a node, one for the links to each grain.
  std::vector<double> row_sums(const Bond& b, double dt = kDt) const {
    std::vector<double> k(2 * b.grid.size(), 0.0);
    b.links.add_stiffness(b.grid, ends_of(b), dt, k.data());
    return k;
  }
  // Sets all the mass that the penalty asks for, and the mass that a cement of eigenvalue `lambda` asks for.
  void set_added_mass(double dt = kDt, double lambda = 0.0) {
    for (Bond& b : bonds) b.added.find(b.links, b.grid, ends_of(b), {dt, lambda, false, kBound});
  }

  // Gives grains and nodes random displacements and velocities.
  void place_grains(double displacement, double velocity) {
    for (int i = 0; i < 4; ++i) {
      const BondRecord& record = records[i / 2];
      const Eigen::Map<const Vector> centre(record.centre[i % 2]), origin(record.origin), shift(record.shift[i % 2]);
      copy(origin - shift + centre + displacement * random.vector(), motion[i].x);
      copy(velocity * random.vector(), motion[i].v);
      copy(velocity * random.vector(), motion[i].omega);
      const double* q = record.orientation[i % 2];
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(displacement * random.uniform(-1, 1), random.direction()));
      copy(turn * Eigen::Quaterniond(q[0], q[1], q[2], q[3]), motion[i].q);
    }
    for (Bond& b : bonds)
      for (double& u : b.grid.displacement) u = displacement * random.uniform(-1, 1);
    for (Bond& b : bonds)
      for (double& v : b.grid.velocity) v = velocity * random.uniform(-1, 1);
    for (Bond& b : bonds) {
      b.grid.constraints.extend(b.grid.displacement.data());
      b.grid.constraints.extend(b.grid.velocity.data());
    }
    ends.distribute(records, motion);
  }
  // Gives grains random accelerations.
  void accelerate_grains() {
    for (BondEnds::Motion& m : motion) {
      copy(random.vector(), m.a);
      copy(random.vector(), m.alpha);
    }
    ends.distribute(records, motion);
  }
  double spring_energy() const {
    double energy = 0.0;
    for (const Bond& b : bonds) b.links.add_spring_energy(b.grid, ends_of(b), energy);
    return energy;
  }
  double energy() {
    ends.distribute(records, motion);
    return spring_energy();
  }
  void add_force() {
    ends.distribute(records, motion);
    ends.clear_forces();
    for (Bond& b : bonds) {
      b.grid.clear_force();
      b.links.add_force(b.grid, ends_of(b));
      b.grid.sum_force();
    }
  }
  void turn(int i, const Vector& rotation) {
    const Eigen::Quaterniond q(motion[i].q[0], motion[i].q[1], motion[i].q[2], motion[i].q[3]);
    copy(Eigen::Quaterniond(Eigen::AngleAxisd(rotation.norm(), rotation.normalized())) * q, motion[i].q);
  }
  static Vector node(const Grid& grid, int n) {
    const auto& k = grid.keys[n];
    return kH * Vector(k.at(0), k.at(1), k.at(2)) + Eigen::Map<const Vector>(&grid.displacement[3 * n]);
  }
  static Vector at(const std::vector<double>& field, int n) { return {field[3 * n], field[3 * n + 1], field[3 * n + 2]}; }
  // Nodal forces of each bond.
  std::vector<std::vector<double>> forces() const { return {bonds[0].grid.force, bonds[1].grid.force}; }

  // Expects that nodal forces `f` and what the grains feel balance in each bond. Checks their resultant and their moment
  // about the origin, over their sizes.
  void expect_balanced(const std::vector<std::vector<double>>& f, double tolerance, const std::string& what) const {
    Worst resultant, moment;
    for (const Bond& b : bonds) {
      Vector F = Vector::Zero(), M = Vector::Zero();
      double F_size = 0, M_size = 0;
      const auto add = [&](const Vector& x, const Vector& force, const Vector& torque) {
        F += force;
        M += x.cross(force) + torque;
        F_size += force.norm();
        M_size += x.norm() * force.norm();
      };
      for (int n = 0; n < b.grid.size(); ++n) add(node(b.grid, n), at(f[b.row], n), Vector::Zero());
      for (int s = 0; s < 2; ++s) {
        const BondEnd& g = ends_of(b)[s];
        add(Eigen::Map<const Vector>(g.x), Eigen::Map<const Vector>(g.force), Eigen::Map<const Vector>(g.torque));
      }
      EXPECT_GT(F_size, 0.0);
      resultant.add(F.norm() / F_size);
      moment.add(M.norm() / M_size);
    }
    expect_within(resultant, tolerance, what + ": resultant");
    expect_within(moment, tolerance, what + ": moment");
  }
};

inline PenaltyParameters penalty(bool at_surface, double damping) {
  PenaltyParameters p;
  p.law = std::make_shared<PenaltyTraction>(TractionStiffness{900.0, 250.0});
  p.damping = damping;
  p.at_surface = at_surface;
  return p;
}

}  // namespace mpdem::test

#endif
