// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A separated bond that is condensed: the cement attached to each grain moves as a rigid piece with it. The piece has
// the mass, weight and inertia of its nodes, and no other force for any motion of the two grains. It is modelled as a
// condensed bond (coupling/condensed_bond.h) whose two ends are the same grain,
//
//   d = 0,   K = 0,   q = (w_0, omega_0, w_0, omega_0),   M_00 = sum m P^T P,   all other blocks zero.
//
// So loads, masses, energy and communication are those of other condensed bonds.
//
// Failed points and fragments (intact points attached to no grain) belong to the piece with which they share nodes, or
// to the nearer grain. A bond with kLeastLoose (fracture/separation.h) or more points in fragments stays resolved,
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

// The record of the piece on grain s of the bond: both of its grains are that grain.
BondRecord record_of_piece(const BondRecord& record, int s);
// Both ends of a piece: each is the end of the bond on the grain of the piece.
std::array<BondEnd, 2> both_ends_on(const BondEnd& end);

// Number of points in fragments on this rank. The bond must be separated.
int points_in_fragments(const PointStore& points);

// Energy of fragments: kinetic energy of the nodes that are -1 in `attached_grain`, and strain energy of points in fragments.
double energy_of_fragments(const Bond& bond, const std::vector<signed char>& attached_grain, const Law& law, double dt_last);

// Grain 0 or 1 to which the cement at each node is attached; -1: none. Collective for the ranks that share the nodes.
std::vector<signed char> attached_grains_of_nodes(Bond& bond);
// Grain 0 or 1 whose piece has each node of a separated bond: where attached_grains_of_nodes() has none, the nearer one
// that is still there. Collective for the ranks that share the nodes.
std::vector<signed char> grains_of_nodes(Bond& bond, const BondRecord& record);

// The models of both pieces, summed over the nodes that count on this rank and have a grain. middle: middle of the
// contact at creation.
std::vector<CondensedModel> models_of_pieces(const Bond& bond, const std::vector<signed char>& grain_of_node,
                                             const Eigen::Vector3d& middle);

// Momentum of a node and its angular momentum about the present middle of the contact, by the stored velocity, in the
// axes of `motion`.
Eigen::Matrix<double, 6, 1> momentum_of_node(const Grid& grid, int node, const CondensedMotion& motion);
// Momentum of both pieces half a step earlier, as loads on the ends of the bond: that of their nodes, and that of the
// rigid models with the motion of the ends. half: half a step.
GrainLoads momentum_of_pieces(const Bond& bond, const std::vector<signed char>& grain_of_node, const std::vector<CondensedModel>& models,
                              const BondRecord& record, const BondEnd* ends);
GrainLoads momentum_of_rigid_pieces(const std::vector<CondensedModel>& models, const BondRecord& record, const BondEnd* ends, double half);

}  // namespace mpdem

#endif
