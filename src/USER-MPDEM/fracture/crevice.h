// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The cement of one grain may run close to that of the other without touching it. Coatings do so beyond the ring in
// which they meet. Shared nodes would bridge this gap: the bond behaves as if the ring were wider, 8 % too stiff with
// cells of 0.2 mm. A body with such a crevice has two sheets: the material nearer to the one grain, and that nearer to the other. Nodes
// are split between the sheets (phantom_nodes.h), except where these are joined.
//
// Rows of lattice points cross from sheet to sheet either from a point to its neighbour, over a bridge, or over a gap.
// A body has a crevice if for some node half of all rows in its support cross over gaps. Each row has the weight of the
// shape function across it. In a body with a crevice, neighbours in cut cells are examined again: their material may
// end before it meets. Volume and centroid tell, except for points of a file that lie anywhere in their cells.
//
// A node is then joined if bridges make up at least an eighth of what crosses. The splines begin to open the jump of a
// crack half their support before the first node that is its own, so that node lies beyond the end. (With a half the
// coatings of test_bond_stiffness.py are 3 to 5 % too soft. A tenth gives the same result as an eighth.)
//
// All nodes of points in the very middle of the bond are joined as well. The material of these points is of both
// sheets, so it must not matter which sheet has the point. If the halves meet nowhere, they are points without a
// lattice and no bond with a crevice. The body then has no crevice.
//
// The code is serial and takes all points of a body that lie near the middle. The result does not depend on their order.
#ifndef MPDEM_FRACTURE_CREVICE_H
#define MPDEM_FRACTURE_CREVICE_H

#include <array>
#include <vector>

#include "../mpm/basis.h"
#include "../mpm/bond_record.h"
#include "../mpm/point_store.h"

namespace mpdem {

struct CrevicePoint {
  double X[3];          // centroid of the material
  int cell[3];          // cell of the lattice
  int sheet;            // nearer_side() of bond_record.h
  double share;         // share of the cell that is filled
  bool middle = false;  // in_the_middle() of bond_record.h
};

struct Crevice {
  bool found = false;
  std::vector<std::array<int, 3>> joined;  // nodes, ascending
};

// A point of the store.
CrevicePoint crevice_point(const PointStore& points, const BondRecord& record, int block, int lane);

// The search needs only points with |nearer_to_first()| (bond_record.h) of at most this reach.
inline double crevice_reach(Basis basis, double cell) { return 2.0 * support(basis) * cell; }

// Empty space on the way out of the cell of a point, in direction d and upwards (side 1) or downwards (-1), in
// spacings. Material is taken as a box about its centroid, and the volume missing in the box as a slit. Returns 0 in a body that is not regular.
double space_ahead(const CrevicePoint& p, const BondRecord& record, int d, int side);
// True if material of neighbours touches, with `space` the sum of the empty space between them.
inline bool touches(double space) { return space <= 0.1 + 1e-6; }

// Finds the crevice. Changes the order of the points.
Crevice find_crevice(std::vector<CrevicePoint>& points, const BondRecord& record, Basis basis, double cell);

}  // namespace mpdem

#endif
