// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// How much of a bond is left? Its ligament is the least number of intact points that would still have to fail for
// the bond to be separated (separation.h): the least cut between the grains through points, those attached to a
// grain included, as letting go of a grain cuts too. By Menger's theorem it is the largest number of paths from
// grain to grain over intact points that have no point in common. Its share is that of the least cut of the
// same bond with no point failed and all links holding. Points count alike, however damaged and whichever way
// the cut runs.
// Several cuts may be least, as the points of a bridge and those that lead to it from either side. Of the one
// nearest to the first grain and the one nearest to the second, which are unique, the one whose points are more
// damaged is taken; both, to count half each, if their mean damage is the same within kSameDamage. Either may bulge
// from a bridge towards its grain, as long as that takes no more points.
// Serial, on all points of one body; the result does not depend on their order.
#ifndef MPDEM_LIGAMENT_H
#define MPDEM_LIGAMENT_H

#include <vector>

#include "neighbours.h"

namespace mpdem {

struct Ligament {
  std::vector<std::vector<int>> cuts;  // of the points given, one or two of the same size; one of none if the bond is separated
  int whole = 0;                       // points of the least cut of the unbroken bond
  int left() const { return static_cast<int>(cuts.front().size()); }
  double share() const { return whole > 0 ? static_cast<double>(left()) / whole : 0.0; }
};

// Far above what ranks and compilers change, so that bonds that are alike on both sides have the same ligaments on all.
constexpr double kSameDamage = 1e-3;

// joined, support: of Neighbours.
Ligament find_ligament(const std::vector<CrackPoint>& points, const JoinedNodes& joined = {}, int support = 0);

// The points as if those of the cut had failed, and let go of their grains with that. With skins (coupling/traction_law.h) what is damaged
// more breaks: the link, and the point holds, unless it leads to others that hold to that grain; or the point, and it stays on the grain. joined,
// support: of Neighbours.
std::vector<CrackPoint> cut_through(const std::vector<int>& cut, std::vector<CrackPoint> points, bool skins = false, const JoinedNodes& joined = {},
                                    int support = 0);

}  // namespace mpdem

#endif
