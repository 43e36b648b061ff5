// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds how much of a bond is left. The ligament of a bond is the least number of intact points that would still have
// to fail for the bond to be separated (separation.h). It is the least cut between the grains through points. Points
// attached to a grain may be in the cut, since letting go of a grain cuts too. By Menger's theorem the ligament is the
// largest number of paths from grain to grain over intact points that have no point in common. Its share is the ratio
// to the least cut of the same bond with no point failed and all links holding. All points count the same, with any
// damage and for any direction of the cut.
//
// Several cuts may be least, as the points of a bridge and those that lead to it from either side. The cut nearest to
// the first grain and the one nearest to the second are unique. Of these two, the one whose points are more damaged is
// taken. If their mean damage is equal within kSameDamage, both are taken and count half each. Either may bulge from a
// bridge towards its grain, as long as that takes no more points.
//
// The code is serial and takes all points of one body. The result does not depend on their order.
#ifndef MPDEM_FRACTURE_LIGAMENT_H
#define MPDEM_FRACTURE_LIGAMENT_H

#include <vector>

#include "neighbours.h"

namespace mpdem {

struct Ligament {
  std::vector<std::vector<int>>
      cuts;       // places in the given points, one or two cuts of the same size; one empty cut if the bond is separated
  int whole = 0;  // number of points in the least cut of the unbroken bond
  int left() const { return static_cast<int>(cuts.front().size()); }
  double share() const { return whole > 0 ? static_cast<double>(left()) / whole : 0.0; }
};

// Far above the differences between numbers of ranks and compilers. So bonds that are equal on both sides have the same ligaments everywhere.
constexpr double kSameDamage = 1e-3;

Ligament find_ligament(const std::vector<CrackPoint>& points);

// Returns the points as if those of the cut had failed and so let go of their grains. With skins
// (coupling/traction_law.h) the more damaged of link and point breaks. If the link breaks, the point holds, unless it
// leads to others that hold to that grain. If the point breaks, it stays on the grain.
std::vector<CrackPoint> cut_through(const std::vector<int>& cut, std::vector<CrackPoint> points, bool residue = false);

}  // namespace mpdem

#endif
