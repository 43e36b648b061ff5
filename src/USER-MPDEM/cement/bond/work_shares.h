// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Decides which rank has which bond. A host deals its atoms out by place, in bricks of the box. Awake bonds take all
// the time, and a crack gathers them in a few bricks. So whole bonds go from ranks with much work to ranks with less.
// They stay beside their place: the bricks of both ranks touch. So the host can bring a bond there and back by one
// exchange with neighbours, and messages are between neighbours as before.
#ifndef MPDEM_CEMENT_BOND_WORK_SHARES_H
#define MPDEM_CEMENT_BOND_WORK_SHARES_H

#include <array>
#include <vector>

namespace mpdem {

using SubdomainIndex = std::array<int, 3>;  // number of a brick along each direction

// A bond that is whole on a rank.
struct MovableBond {
  int row = 0, rank = 0;
  double work = 0.0;                   // work in any unit
  SubdomainIndex low = {}, high = {};  // the bricks in which its points lie
};

struct BondMove {
  int row, rank;
};

// Does the brick of a rank touch all of these bricks, or is it one of them?
bool is_beside(const SubdomainIndex& brick, const SubdomainIndex& low, const SubdomainIndex& high);

// The largest work of a rank over the mean; 1 if there is none.
double unevenness(const std::vector<double>& work_of_ranks);

// Unevenness below which the work counts as even.
constexpr double kUneven = 1.1;

// Returns moves from the rank that has most work, one at a time and the best first. They end when that rank has at most
// 2 % more than the mean, or when no move makes it less. There are none if the work is even already. bricks: brick of
// each rank. work: work of each rank, with that of its movable bonds. The result depends on the numbers alone, so ranks
// that have the same numbers agree.
std::vector<BondMove> rebalance(const std::vector<SubdomainIndex>& bricks, std::vector<MovableBond> bonds, std::vector<double> work);

}  // namespace mpdem

#endif
