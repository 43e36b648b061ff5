// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds whether a bond is separated, and its fracture surface. The crack is the set of failed points. A piece is a
// connected set of intact points (neighbours.h). A bond is separated when no piece is attached to both grains. Then
// * the cement gets layers that share no nodes: the material attached to the first grain, that attached to the second,
//   and every loose piece of at least kLeastLoose points. Failed points and smaller fragments are assigned to the
//   nearest of these in their layer, in steps from cell to cell. At equal distance a grain's material comes before a
//   loose piece, and of two loose pieces the larger. Points at equal distance from the material of both grains are
//   assigned to the grain whose surface is nearer (nearer_grain() of bond_record.h). So are points that no step reaches
//   at the first separation. Later such points keep their layer;
// * the fracture surface lies where material assigned to the first grain meets that assigned to the second. This is
//   inside the cement, or at a grain whose own links lead to material assigned to the other grain. An area inside that
//   is lower than `reach` above a grain counts as at that grain: there the damage band of a crack reaches the grain,
//   and no cell shows where in its band a crack runs. If this is true for both grains, half counts at each. Points at
//   equal distance from both count half to each, in whichever layer they are. If neither grain has attached material
//   but there is a loose piece, the surface is that of both grains. Areas are projected along the line of centres.
// The order of the grains affects only results that name a grain.
//
// While a path of intact points leads from grain to grain, the bond is connected. The path that is returned is one
// whose most damaged point or link is the least damaged. It is expected to stay intact longest, so searches are rare.
//
// The code is serial and takes all points of one bond. The result does not depend on their order.
#ifndef MPDEM_FRACTURE_SEPARATION_H
#define MPDEM_FRACTURE_SEPARATION_H

#include <vector>

#include "../parallel/record.h"
#include "neighbours.h"

namespace mpdem {

struct FractureSurface {
  bool separated = false;
  double at_grain[2] = {0, 0}, inside = 0;  // projected areas: at each grain, and inside

  double debonded_share() const {
    const double all = at_grain[0] + at_grain[1] + inside;
    return all > 0.0 ? (at_grain[0] + at_grain[1]) / all : 0.0;
  }

  template <class Self, class Visitor>
  static constexpr void describe(Self& s, Visitor& visit) {
    visit("'is separated' of a bond", s.separated);
    visit("the area of separation at a grain", s.at_grain, kNotNegative);
    visit("the area of separation inside", s.inside, kNotNegative);
  }
};

struct Separation : FractureSurface {
  // New layer of each point, in the order given. Layers are pieces, as in CrackPoint::layer.
  std::vector<int> piece;
  std::vector<char> between;  // for each point: true if it is at equal distance from the material of both grains
  // For each point of a separated bond the bits of the grains that its piece is attached to, 0 for failed points.
  std::vector<char> attached_grains;
  // Tags of the points of the path, ascending. The bond is connected while none of them fails.
  std::vector<int> path;
};

constexpr int kLeastLoose = 64;  // points

// face_area[d]: projected area of a lattice face normal to direction d. again: the bond was separated before, so points
// have the layers of a separation. across: see Neighbours. reach: see above, 0 for a crack without a band.
Separation separate(const std::vector<CrackPoint>& points, const double* face_area, bool again = false, int across = 1, double reach = 0.0);

// Returns for each intact point the bits of the grains to which its piece is attached, whether the bond is separated or not, and for
// each failed point those of the grains on which it stays as residue. across: see Neighbours.
std::vector<char> attached_grains(const std::vector<CrackPoint>& points, int across);

// Returns for each intact point the number of points of its piece, and 1 for each failed point. across: see Neighbours.
std::vector<int> piece_sizes(const std::vector<CrackPoint>& points, int across);

}  // namespace mpdem

#endif
