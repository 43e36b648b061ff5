// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Where the cement of one grain runs close to that of the other without touching it, as coatings do
// beyond the ring in which they meet, shared nodes would bridge the gap: the bond is as if the ring
// were wider, 8 % too stiff with cells of 0.2 mm. A body with such a crevice has two sheets, what is
// nearer to the one grain and to the other, with nodes of their own. They are joined again
// (edge_ties.h) where the material is: nodes double by material, not by place, as for cracks in the
// phantom-node method (A. Hansbo, P. Hansbo, Comput. Methods Appl. Mech. Engrg. 193, 2004, 3523-3540).
//
// Rows of lattice points cross from sheet to sheet either from a point to its neighbour, a bridge, or
// over a gap. A body has a crevice if there is a node for which half of all rows cross over gaps,
// within its support, each weighted by the shape function across the row. If so, neighbours in cells that
// are cut are looked at again: their material may end before it meets. Volume and centroid tell, unless the
// points are those of a file that lie anywhere in their cells. Joined
// are the nodes for which bridges make up at least an eighth then: of the jump of a crack the splines begin
// to open half their support before the first node that is its own, so that node lies beyond the end.
// (With a half the coatings of test_bond_stiffness.py are 3 to 5 % too soft; a tenth does as an eighth.)
// Joined are also all nodes that points in the very middle of the bond have: their material is of both sheets, so it must not
// matter which of them holds it.
// Halves that meet nowhere are not a bond with a crevice but points that are no lattice, and stay one.
// Serial, on all points of a body that lie near the middle; the result does not depend on their order.
#ifndef MPDEM_CREVICE_H
#define MPDEM_CREVICE_H

#include <array>
#include <vector>

#include "../mpm/basis.h"
#include "../mpm/body.h"

namespace mpdem {

struct SheetPoint {
  double X[3];   // centroid of the material
  int cell[3];   // of the lattice
  int sheet;     // 0 or 1
  double share;  // of the cell that is filled
  bool middle = false;  // in_the_middle() of body.h
};

struct Crevice {
  bool found = false;
  std::vector<std::array<int, 3>> joined;  // nodes, ascending
};

// Points with |nearer_to_first()| (body.h) of at most this reach are all that matter.
inline double sheet_reach(Basis basis, double cell) { return 2.0 * support(basis) * cell; }

// Empty space on the way out of the cell of a point, in direction d and upwards (side 1) or downwards (-1), in
// spacings. Material is taken as a box about its centroid, and what is missing in it as a slit. 0 in a body that is not regular.
double space_ahead(const SheetPoint& p, const Body& body, int d, int side);
// Does material of neighbours touch, with this much empty space between in all?
inline bool touches(double space) { return space <= 0.1 + 1e-6; }

// Sorts the points.
Crevice find_crevice(std::vector<SheetPoint>& points, const Body& body, Basis basis, double cell);

}  // namespace mpdem

#endif
