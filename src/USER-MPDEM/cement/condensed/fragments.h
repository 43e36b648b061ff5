// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds the fragments of separated bonds that move as bodies (cement/bond/fragment_bodies.h). Intact points that share a
// node move together. So do a constrained node and its masters. A fragment is such a clump of points of which none has a
// node of cement that is attached to a grain. Fragments below kLeastBody points stay without contact: they have few points
// to touch with. Failed points belong to a fragment or to a grain if all of their nodes do.
#ifndef MPDEM_CEMENT_CONDENSED_FRAGMENTS_H
#define MPDEM_CEMENT_CONDENSED_FRAGMENTS_H

#include <mpi.h>

#include <map>
#include <vector>

#include "../bond/bond.h"

namespace mpdem {

constexpr int kLeastBody = 8;  // points

struct Fragments {
  static constexpr int kNone = -1, kFirst = 2;
  // By row, for each node of this rank: grain 0 or 1 with which it moves, kFirst and more for a fragment, or kNone.
  std::map<int, std::vector<int>> side_of_node;
  // By row, the nodes of each fragment, ascending. The same on all ranks, in the order of their first nodes.
  std::map<int, std::vector<std::vector<Key>>> nodes;

  // The side of a point on the grid, or kNone. slot: of a bond whose row was examined.
  int side_of(const Bond& b, int slot) const;
};

// Collective. rows: separated bonds that are resolved, ascending, the same on all ranks.
Fragments find_fragments(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows);

}  // namespace mpdem

#endif
