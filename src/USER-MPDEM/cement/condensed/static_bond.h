// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Static equilibrium of one bond under small relative motions of its grains: the 6 by 6 stiffness K of the bond and six
// static displacement fields, one for each motion. The operator is that of the step, linearised about the present
// state, with the same grid, constrained nodes, links and damage (mpm/stiffness_force.h,
// PenaltyLinks::add_small_force()).
//
// Motion j moves the second grain while the first is fixed. j = 0, 1, 2 is a translation along x, y, z of the bond
// coordinates. j = 3, 4, 5 is a rotation about x, y, z through the middle of the contact. K_ij is the force (i < 3) or
// the moment about the middle (i > 2) that keeps the second grain there. The middle lies on the line of centres,
// half-way between the surfaces. K is symmetric, and zero for a bond that is attached to one grain only.
//
// The solver is a conjugate gradient method on the matrix-free operator. A bond that is whole on its rank is
// preconditioned with the Cholesky factor of its stiffness (mpm/stiffness_matrix.h), so one step finds a field. The
// preconditioner of a bond that ranks share, of a very large one, and of one with nodes that are connected by almost
// nothing is a diagonal: that of the stiffness of the points plus the row sums of the link stiffness that the added
// mass uses. It needs a few nodal vectors. doc/bond_stiffness.md has the cost of both. K is computed from the energies
// of the fields, so its error is the square of theirs.
#ifndef MPDEM_CEMENT_CONDENSED_STATIC_BOND_H
#define MPDEM_CEMENT_CONDENSED_STATIC_BOND_H

#include <mpi.h>

#include <Eigen/Dense>
#include <array>
#include <string>
#include <vector>

#include "../../coupling/film.h"
#include "../../coupling/penalty_links.h"
#include "../../material/law.h"
#include "../../mpm/grid.h"
#include "../../mpm/point_store.h"

namespace mpdem {

// In bond coordinates.
struct BondFrame {
  Eigen::Vector3d axis;    // unit vector from the first grain to the second
  Eigen::Vector3d middle;  // middle of the contact
};
// ends: both grain ends of the bond.
BondFrame frame_of(const BondRecord& record, const BondEnd* ends);

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Iteration limits for each field. Beyond them BadState is thrown: the bond carries almost nothing.
constexpr int kMostStaticSteps = 20000;
constexpr int kMostStepsOfCandidate = 2000;  // for a bond that may stay resolved; intact bonds take some hundred

// A bond with its layout. ends: both grain ends.
struct StaticSystem {
  const PointStore& points;
  Grid& grid;
  const PenaltyLinks& links;
  const BondEnd* ends;
  const BondRecord& record;
  const Law& law;
  const Film& film;  // adds stiffness between the grains, but has no nodes
};

struct StaticBond {
  BondFrame frame{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  Matrix6 stiffness = Matrix6::Zero();
  std::array<std::vector<double>, 6> displacement;           // three numbers per node, constrained nodes included
  std::array<std::vector<Sym3<vd>>, 6> strain;               // of each block, in the material frames
  std::array<std::array<Eigen::VectorXd, 2>, 6> amplitudes;  // of the modes of elastic grains, by field and side
  Film::Strains strain_of_film;
  Matrix6 stiffness_of_film = Matrix6::Zero();  // of its columns: share of this rank in `stiffness`
  // With a traction law that has a state: what the interface between cement and grains feels.
  PenaltyLinks::SmallSeparations separations;
  Film::FaceResponse faces;
  int products = 0;  // applications of the operator, for all fields
  std::size_t memory_usage() const;
};

// What to do about a bond with nodes that are connected by almost nothing, for messages.
inline constexpr char kCureOfLooseNodes[] =
    "use 'edge tied' where edges are free, more intact points or 'condense no', and for a bond whose points come later 'points now' or "
    "'overlap skip' of create_cement";

// Motions of both grains, translation of the centre and rotation, for six numbers d of the second against the first.
std::array<std::array<double, 6>, 2> motions_of(const BondFrame& frame, const BondEnd* ends, const double* d);

// Collective over comm, which has all ranks that share the bond. Each rank passes its share of the same bond, or null
// if it has none. Throws BadState if the iteration does not converge.
StaticBond solve_static(MPI_Comm comm, const StaticSystem* system, int most = kMostStaticSteps);
// For a bond that is whole on this rank.
inline StaticBond solve_static(const StaticSystem& system) { return solve_static(MPI_COMM_SELF, &system); }

// Displacement of the nodes due to a nodal force while both grains are fixed. The force must be summed over ranks, with
// the force of constrained nodes on their master nodes. The operator has a small shift in proportion to the mass, so
// that nodes of almost no stiffness stay near. It reduces slow modes of the bond slightly. Collective as
// solve_static().
std::vector<double> static_displacement(MPI_Comm comm, const StaticSystem* system, std::vector<double> force);

// Stiffness along the bond axis and across it. Across it there are two principal values, the smaller one first. Each
// value is for its motion alone, while the other five are zero.
struct PrincipalStiffness {
  double tension, shear[2], torsion, bending[2];
};
PrincipalStiffness principal_stiffness(const Matrix6& K, const Eigen::Vector3d& axis);

}  // namespace mpdem

#endif
