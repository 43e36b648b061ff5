// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// One bond in static equilibrium under small relative motions of its grains. The result is the stiffness of the bond, 6
// by 6, and the six fields that go with it. The operator is that of the step, about the present state: the same grid,
// ties, links and damage (mpm/stiffness_force.h, PenaltyLinks::add_small_force()).
//
// Motion j is that of the second grain against the first, which is held. j = 0, 1, 2 is a translation along x, y, z of
// the body. j = 3, 4, 5 is a turn about x, y, z and the middle of the contact. K_ij is the force (i < 3) or the moment
// about the middle (i > 2) that holds the second grain there. The middle lies on the line of centres, half-way between
// the surfaces. K is symmetric, and zero for a bond that holds one grain only.
//
// Conjugate gradients find the nodes, without a matrix. The preconditioner is a diagonal: that of the points, and the
// row sums of the links that the added mass has, too. The method takes a few vectors of the nodes.
// doc/bond_stiffness.md has measurements of a sparse Cholesky factor of the same problem. K is found from the energies
// of the fields, so its error is the square of theirs.
#ifndef MPDEM_CEMENT_CONDENSED_STATIC_BOND_H
#define MPDEM_CEMENT_CONDENSED_STATIC_BOND_H

#include <mpi.h>

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "../../coupling/film.h"
#include "../../coupling/penalty_links.h"
#include "../../material/law.h"
#include "../../mpm/grid.h"
#include "../../mpm/point_store.h"

namespace mpdem {

// The frame of a bond, in the coordinates of its body.
struct BondFrame {
  Eigen::Vector3d axis;    // unit vector from the first grain to the second
  Eigen::Vector3d middle;  // middle of the contact
};
// side: first side of the bond, followed by the second.
BondFrame frame_of(const BondRecord& record, const BondEnd* ends);

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Most iterations for each field. A bond that holds by next to nothing may need more: BadState is thrown then.
constexpr int kMostStaticSteps = 20000;
constexpr int kMostStepsOfCandidate = 2000;  // most iterations for a bond that need not be condensed; intact bonds take some hundred

// A bond on its layout. side: first side of the bond, followed by the second.
struct StaticSystem {
  const PointStore& points;
  Grid& grid;
  const PenaltyLinks& links;
  const BondEnd* ends;
  const BondRecord& record;
  const Law& law;
  const Film& film;  // it adds its stiffness and moves no node
};

struct StaticBond {
  BondFrame frame{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  Matrix6 stiffness = Matrix6::Zero();
  std::array<std::vector<double>, 6> displacement;  // three numbers a node, of tied nodes too
  std::array<std::vector<Sym3<vd>>, 6> strain;      // strain of each block, in the material frames
  Film::Strains strain_of_film;
  Matrix6 stiffness_of_film = Matrix6::Zero();  // part of `stiffness`, of the columns of this rank
  int products = 0;                             // products with the operator, for all fields
  std::size_t memory_usage() const;
};

// Collective over comm: if ranks cut the bond, the ranks that share it. All of them pass their parts of the same bond,
// or null if they have nothing of it. Throws BadState if the iteration does not end.
StaticBond solve_static(MPI_Comm comm, const StaticSystem* system, int most = kMostStaticSteps);
// Solves a bond that no other rank shares.
inline StaticBond solve_static(const StaticSystem& system) { return solve_static(MPI_COMM_SELF, &system); }

// Displacement of the nodes by a force on them, while both grains are held. The force is complete, with that of tied
// nodes on their masters. Nodes that hold next to nothing move little: inertia holds all of them back. So slow motions
// of the bond are held back a little, too. Collective as solve_static().
std::vector<double> static_displacement(MPI_Comm comm, const StaticSystem* system, std::vector<double> force);

// The stiffness in the frame of the bond. Values across the axis are the two principal ones, the smaller one first. For
// each value, the other five motions are held.
struct PrincipalStiffness {
  double tension, shear[2], torsion, bending[2];
};
PrincipalStiffness principal_stiffness(const Matrix6& K, const Eigen::Vector3d& axis);

}  // namespace mpdem

#endif
