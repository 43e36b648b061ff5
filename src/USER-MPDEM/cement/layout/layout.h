// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The layout of bonds: blocks of points by cell, links, grid, constraints of its edge nodes
// (mpm/extension_constraints.h), and lumped mass. It is a function of the points and of the previous nodal motion, and
// changes only its arguments. So a layout may also be made for a query, and dropped.
//
// In separated bonds, too, edge nodes remain constrained unless they are split, see node_splitting.h.
#ifndef MPDEM_CEMENT_LAYOUT_LAYOUT_H
#define MPDEM_CEMENT_LAYOUT_LAYOUT_H

#include <mpi.h>

#include <memory>
#include <vector>

#include "../bond/bond.h"
#include "../bond/options.h"
#include "../bond/formulation.h"
#include "../failure/node_splitting.h"

namespace mpdem {

struct LayoutRequest {
  int row = 0;
  PointStore points;
  NodeKinematics before;  // previous motion of nodes of the bond: of those of this rank, or of those of all ranks
  NewLayers layers;
};

struct LayoutRules {
  MPI_Comm comm = MPI_COMM_NULL;
  const std::vector<BondRecord>& table;
  const CementOptions& options;
  const std::shared_ptr<const Law>& law;       // law of all points, also of those from other ranks
  CementDensity density = 0.0;                 // of the inertia
  const PenaltyParameters* penalty = nullptr;  // null: no links
  NodeSplitting& splits;
  const Formulation& formulation;
  bool arrange = true;  // false: keep the blocks as they are
};

struct BondLayout {
  int row = 0;
  PointStore points;
  Film film;  // set only in layouts for queries; make_layout() leaves it empty
  Grid grid;
  PenaltyLinks links;
  std::vector<char> fresh;    // for each node: 1 if no rank had it before
  std::vector<int> new_slot;  // new slot of each former slot, -1 for an empty one
};

// Collective. Lays out the bonds of these rows of the table, ascending, the same on all ranks. requests: one for each
// of them with points or nodes on this rank. Throws BadState on all ranks if the grids would exceed
// CementOptions::most_bytes.
std::vector<BondLayout> make_layout(const LayoutRules& rules, const std::vector<int>& rows, std::vector<LayoutRequest> requests);

// Lays out the film of a bond. Not collective, since a film has no nodes.
void lay_out_film(Film& film, const BondRecord& record, const CementOptions& options, const std::shared_ptr<const Law>& law);

}  // namespace mpdem

#endif
