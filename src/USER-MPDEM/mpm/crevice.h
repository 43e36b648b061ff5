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
// are cut are looked at again: their material may end before it meets (volume and centroid tell). Joined
// are the nodes for which bridges make up at least an eighth then: of the jump of a crack the splines begin
// to open half their support before the first node that is its own, so that node lies beyond the end.
// (With a half the coatings of test_bond_stiffness.py are 3 to 5 % too soft; a tenth does as an eighth.)
// Serial, on all points of a body that lie near the middle; the result does not depend on their order.
#ifndef MPDEM_CREVICE_H
#define MPDEM_CREVICE_H

#include <array>
#include <vector>

#include "basis.h"

namespace mpdem {

struct SheetPoint {
  double X[3];   // centroid of the material
  int cell[3];   // of the lattice
  int sheet;     // 0 or 1
  double share;  // of the cell that is filled
};

struct Crevice {
  bool found = false;
  std::vector<std::array<int, 3>> joined;  // nodes, ascending
};

// Points with |depth below the one grain's surface - below the other's| of at most this reach are all that matter.
inline double sheet_reach(Basis basis, double cell) { return 2.0 * support(basis) * cell; }

// spacing: of the lattice.
Crevice find_crevice(std::vector<SheetPoint> points, Basis basis, double cell, double spacing);

}  // namespace mpdem

#endif
