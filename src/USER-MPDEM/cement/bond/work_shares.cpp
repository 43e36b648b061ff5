// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "work_shares.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace mpdem {

namespace {

constexpr double kTargetImbalance = 1.02;  // largest work of a rank over the mean, at which the algorithm ends

double mean(const std::vector<double>& work) { return std::accumulate(work.begin(), work.end(), 0.0) / static_cast<double>(work.size()); }

}  // namespace

bool is_adjacent(const SubdomainIndex& subdomain, const SubdomainIndex& low, const SubdomainIndex& high) {
  for (int d = 0; d < 3; ++d)
    if (subdomain[d] < high[d] - 1 || subdomain[d] > low[d] + 1) return false;
  return true;
}

double load_imbalance(const std::vector<double>& work) {
  const double all = mean(work);
  return all > 0.0 ? *std::max_element(work.begin(), work.end()) / all : 1.0;
}

// In each turn the rank with most work gives one bond to another rank.
std::vector<BondMove> rebalance(const std::vector<SubdomainIndex>& subdomains, std::vector<MovableBond> bonds, std::vector<double> work) {
  if (load_imbalance(work) <= kAllowedImbalance) return {};
  std::sort(bonds.begin(), bonds.end(), [](const MovableBond& a, const MovableBond& b) { return a.row < b.row; });
  std::map<int, int> moved;  // rank by row
  while (load_imbalance(work) > kTargetImbalance) {
    const int from = static_cast<int>(std::max_element(work.begin(), work.end()) - work.begin());
    MovableBond* best = nullptr;
    int to = from;
    double most = 0.0;  // largest gain so far: decrease of the larger work of the two ranks
    for (MovableBond& b : bonds) {
      if (b.rank != from) continue;
      for (std::size_t rank = 0; rank < work.size(); ++rank) {
        const double gain = std::min(b.work, work[from] - work[rank] - b.work);
        if (gain <= most || !is_adjacent(subdomains[rank], b.low, b.high)) continue;
        most = gain;
        best = &b;
        to = static_cast<int>(rank);
      }
    }
    if (!best) break;
    work[from] -= best->work;
    work[to] += best->work;
    best->rank = moved[best->row] = to;
  }
  std::vector<BondMove> moves;
  for (const auto& [row, rank] : moved) moves.push_back({row, rank});
  return moves;
}

}  // namespace mpdem
