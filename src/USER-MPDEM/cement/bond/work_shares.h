// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Load balance: decides which rank has which bond. The host assigns atoms to ranks by position, in subdomains of the
// box. Resolved bonds take almost all the time, and a crack concentrates them in a few subdomains. So whole bonds move
// from ranks with much work to ranks with less. The new rank is one whose subdomain touches that of the bond. So the
// host can move a bond there and back by one exchange with neighbours, and all messages remain between neighbours.
#ifndef MPDEM_CEMENT_BOND_WORK_SHARES_H
#define MPDEM_CEMENT_BOND_WORK_SHARES_H

#include <array>
#include <vector>

namespace mpdem {

using SubdomainIndex = std::array<int, 3>;  // number of a subdomain along each direction

// A bond whose points are all on one rank.
struct MovableBond {
  int row = 0, rank = 0;
  double work = 0.0;                   // work in any unit
  SubdomainIndex low = {}, high = {};  // range of the subdomains in which its points lie
};

struct BondMove {
  int row, rank;
};

// True if the subdomain touches all of those from `low` to `high`, or is one of them.
bool is_adjacent(const SubdomainIndex& subdomain, const SubdomainIndex& low, const SubdomainIndex& high);

// The largest work of a rank over the mean; 1 if there is no work.
double load_imbalance(const std::vector<double>& work_of_ranks);

// Unevenness below which the work counts as even.
constexpr double kAllowedImbalance = 1.1;

// Greedy algorithm: each move is the best one from the rank that has most work. It ends when that rank has at most 2 %
// more than the mean, or when no move reduces the larger work of the two ranks. Returns the moves, ascending in row; none
// if the work is even. subdomains: subdomain of each rank. work: of each rank, with its movable bonds. Equal arguments give
// equal results.
std::vector<BondMove> rebalance(const std::vector<SubdomainIndex>& subdomains, std::vector<MovableBond> bonds, std::vector<double> work);

}  // namespace mpdem

#endif
