// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds an unbonded gap inside a bond. The cement of one grain may run close to that of the other without
// touching it, as coatings do beyond the ring in which they meet. Shared nodes would bridge this gap: the bond behaves
// as if the ring were wider, 8 % too stiff with cells of 0.2 mm. A bond with such a gap has two sides, the material
// nearer to the one grain and that nearer to the other. Nodes are split between the sides (phantom_nodes.h), except
// where these are joined.
//
// Rows of lattice points cross from side to side either from a point to its neighbour, over a bridge, or over a gap. A
// bond has an unbonded gap if for some node half of all rows in its support cross over gaps. A row is weighted by the
// shape function in the directions across it. In a bond with an unbonded gap, neighbours in cut cells are examined
// again: their material may end before it meets. Volume and centroid show this, except for points of a file, which may
// lie anywhere in their cells.
//
// A node is joined if bridges have at least an eighth of the weight of its crossings. The displacement jump begins to
// open half a support before the first split node, so this node must lie inside the gap, not at its edge. (With a half
// the coatings of test_bond_stiffness.py are 3 to 5 % too soft. A tenth gives the same result as an eighth.)
//
// All nodes of points in the very middle of the bond are joined as well. The material of these points belongs to both
// sides, so it must not matter to which side the point is assigned. If no node is joined, the points have no lattice,
// and the bond counts as one without an unbonded gap.
//
// The code is serial and takes all points of a bond near its middle. The result does not depend on their order.
#ifndef MPDEM_FRACTURE_UNBONDED_GAP_H
#define MPDEM_FRACTURE_UNBONDED_GAP_H

#include <array>
#include <vector>

#include "../mpm/basis.h"
#include "../mpm/bond_record.h"
#include "../mpm/point_store.h"

namespace mpdem {

struct GapPoint {
  double X[3];          // centroid of the material
  int cell[3];          // cell of the lattice
  int nearer_grain;     // grain of its side of the gap, by nearer_grain() of bond_record.h
  double share;         // filled share of the cell
  bool middle = false;  // it belongs to both sides, by is_equidistant() of bond_record.h
};

struct UnbondedGap {
  bool found = false;
  std::vector<std::array<int, 3>> joined;  // nodes, ascending
};

GapPoint gap_point(const PointStore& points, const BondRecord& record, int block, int lane);

// The search needs only points with |nearer_to_first()| (bond_record.h) of at most this reach.
inline double gap_reach(Basis basis, double cell) { return 2.0 * support(basis) * cell; }

// Empty space, in spacings, between the material of a point and the face of its cell in direction d, upwards (side 1)
// or downwards (-1). Material is taken as a box about its centroid, and the volume missing in the box as a slit.
// Returns 0 in a bond that is not regular (BondRecord::regular).
double space_ahead(const GapPoint& p, const BondRecord& record, int d, int side);
// True if the material of neighbours touches. space: sum of the empty space between them, in spacings.
inline bool touches(double space) { return space <= 0.1 + 1e-6; }

// Changes the order of the points. cell: width of a cell of the grid.
UnbondedGap find_unbonded_gap(std::vector<GapPoint>& points, const BondRecord& record, Basis basis, double cell);

}  // namespace mpdem

#endif
