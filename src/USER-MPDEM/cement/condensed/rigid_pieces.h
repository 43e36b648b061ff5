// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A bond that came apart and is condensed: what holds to a grain is a rigid piece of it. The piece has the mass, the
// weight and the inertia of its nodes. It has no other force, for any motion of the two grains. It is a condensed bond
// (coupling/condensed_bond.h) between its grain and the same grain once more,
//
//   d = 0,   K = 0,   q = (w_0, omega_0, w_0, omega_0),   M_00 = sum m P^T P,   all other blocks zero.
//
// So loads, masses, energy and ranks are handled as for the other condensed bonds.
//
// Dust is points that failed and points that hold to no grain. It goes with the piece whose nodes it has, or with the
// nearer grain. A bond with kLeastLoose (fracture/separation.h) or more points that hold to no grain stays as it is,
// since a loose piece follows no grain.
#ifndef MPDEM_CEMENT_CONDENSED_RIGID_PIECES_H
#define MPDEM_CEMENT_CONDENSED_RIGID_PIECES_H

#include <array>
#include <vector>

#include "../../coupling/condensed_bond.h"
#include "../../fracture/separation.h"
#include "../../material/law.h"
#include "../bond/bond.h"

namespace mpdem {

// The body as its piece on grain s sees it: both grains are that grain.
BondRecord record_of_piece(const BondRecord& record, int s);
// Both sides of a piece.
std::array<BondEnd, 2> loaded_ends_of_piece(const BondEnd& end);

// Number of points of this rank that did not fail and hold to no grain. The bond came apart.
int loose_points(const PointStore& points);

// Energy of dust: energy of the motion of nodes that are -1 in `holding`, and of the strain of points that hold to no
// grain.
double energy_of_fragments(const Bond& bond, const std::vector<signed char>& holding, const Law& law, double dt_last);

// The grain, 0 or 1, that each node holds to; -1 for dust. Collective for the ranks that share the nodes.
std::vector<signed char> grains_that_hold_nodes(Bond& bond);
// The grain, 0 or 1, that each node of a bond that came apart goes with. Collective for the ranks that share the nodes.
std::vector<signed char> grains_of_nodes(Bond& bond, const BondRecord& record);

// The models of both pieces, from the nodes that count on this rank and have a grain. middle: middle of the contact at
// the creation.
std::vector<CondensedModel> models_of_pieces(const Bond& bond, const std::vector<signed char>& grain_of_node,
                                             const Eigen::Vector3d& middle);

// Momentum of a node, and its angular momentum about the point to which the grains have brought the middle. By the
// stored velocity, in the axes of `motion`.
Eigen::Matrix<double, 6, 1> momentum_of_node(const Grid& grid, int node, const CondensedMotion& motion);
// Momentum of both pieces half a step behind, as loads on the sides of the body. momentum_of_pieces() is the momentum
// of their nodes. momentum_of_rigid_pieces() is that of the models with the motion of the sides.
GrainLoads momentum_of_pieces(const Bond& bond, const std::vector<signed char>& grain_of_node, const std::vector<CondensedModel>& models,
                              const BondRecord& record, const BondEnd* ends);
GrainLoads momentum_of_rigid_pieces(const std::vector<CondensedModel>& models, const BondRecord& record, const BondEnd* ends, double half);

}  // namespace mpdem

#endif
