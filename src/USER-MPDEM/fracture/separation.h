// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Has a bond come apart, and how? The crack is the set of failed points; intact points hold
// together as neighbours.h says. A bond is separated when no such piece is attached to both grains. Then
// * the cement gets parts that share no nodes: what is attached to the first grain, to the
//   second, and every loose piece of at least kLeastLoose points. Failed points and smaller
//   crumbs go with the nearest of these (in steps from cell to cell) of their part: of a grain's and a loose one as near with the
//   grain's, of two loose ones with the larger. As near to what is attached to the first grain and to the second, or where no
//   step leads, they go with the grain whose surface is nearer (nearer_side() of body.h);
// * the separating surface lies where the material that goes with the first grain meets the
//   material that goes with the second: inside the cement, or at a grain where that grain's
//   own links are to material of the other. What lies inside but lower than `reach` above a grain is at that grain, too: there the band
//   of damage about a crack reaches the grain, and no cell tells where in its band a crack runs. If that is so at both grains, it is half
//   at each. Points as near to either count half to each, whichever part they got. Where neither
//   grain holds to anything but there is a loose piece, it is the surface of both. Its areas are projected on the plane across the
//   line of centres.
// Which of the grains is the first does not matter but for what is told of either.
// While a path of intact points leads from grain to grain the bond holds. The one that is named is one whose most
// damaged point or link is the least damaged, since it is expected to hold longest: so there is seldom reason to look
// again.
// Serial, on all points of one body; the result does not depend on their order.
#ifndef MPDEM_SEPARATION_H
#define MPDEM_SEPARATION_H

#include <vector>

#include "../parallel/record.h"
#include "neighbours.h"

namespace mpdem {

struct SeparatingSurface {
  bool separated = false;
  double at_grain[2] = {0, 0}, inside = 0;  // area, projected: at either grain, and inside

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

struct Separation : SeparatingSurface {
  // New part of each point, in the order given; without sheets too.
  std::vector<int> part;
  std::vector<char> between;  // of each point: as near to what holds to the first grain as to what holds to the second
  // Of each point, once separated: bits of the grains that its piece is attached to; 0 of failed ones.
  std::vector<char> holds;
  // Tags of the points, ascending, of that path: while none of them fails the bond is not separated.
  std::vector<int> path;
};

constexpr int kLeastLoose = 64;

// face_area[d]: projected area of a lattice face across direction d. joined: ascending, where there are sheets;
// support: nodes a direction; across: of Neighbours; again: the bond was separated before, so that points have the parts of a separation;
// reach: see above, 0 for a crack without a band.
Separation separate(const std::vector<CrackPoint>& points, const double* face_area, const JoinedNodes& joined = {}, int support = 0,
                    bool again = false, int across = 1, double reach = 0.0);

}  // namespace mpdem

#endif
