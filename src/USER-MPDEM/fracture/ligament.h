// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds the ligament of a bond: the least number of intact points that must still fail to separate it (separation.h).
// It is the minimum vertex cut between the grains. Points attached to a grain may be in the cut, since debonding cuts
// too. By Menger's theorem the ligament is the largest number of paths from grain to grain over intact points that have
// no point in common. Its share is the ratio to the minimum cut of the same bond with no point failed and all links
// attached. All points count the same, for any damage and any direction of the cut.
//
// Several cuts may be minimal, such as the points of a bridge and those that lead to it from either side. The cut
// nearest to the first grain and the one nearest to the second are unique. Of these two, the one whose points are more
// damaged is taken. If their mean damage is equal within kSameDamage, both are taken and count half each. Either may
// bulge from a bridge towards its grain, as long as that takes no more points.
//
// The code is serial and takes all points of one bond. The result does not depend on their order.
#ifndef MPDEM_FRACTURE_LIGAMENT_H
#define MPDEM_FRACTURE_LIGAMENT_H

#include <vector>

#include "neighbours.h"

namespace mpdem {

struct Ligament {
  std::vector<std::vector<int>> cuts;  // indices of points, one or two cuts of the same size; one empty cut if the bond is separated
  int whole = 0;                       // number of points in the minimum cut of the undamaged bond
  int left() const { return static_cast<int>(cuts.front().size()); }
  double share() const { return whole > 0 ? static_cast<double>(left()) / whole : 0.0; }
};

// Far above rounding, so a symmetric bond has the same ligament on any number of ranks and with any compiler.
constexpr double kSameDamage = 1e-3;

Ligament find_ligament(const std::vector<CrackPoint>& points);

// Returns the points as if those of the cut had failed and so debonded from their grains. With residue
// (TractionLaw::leaves_residue()) the more damaged of link and point fails. If the link fails, the point stays intact,
// unless other points connect it to that grain. If the point fails, it stays on the grain.
std::vector<CrackPoint> cut_through(const std::vector<int>& cut, std::vector<CrackPoint> points, bool residue = false);

}  // namespace mpdem

#endif
