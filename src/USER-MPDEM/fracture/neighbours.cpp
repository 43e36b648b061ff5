// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "neighbours.h"

#include <algorithm>
#include <utility>

#include "crevice.h"

namespace mpdem {

namespace {

bool meet(const CrackPoint& a, const CrackPoint& b, const JoinedNodes& joined, int support) {
  int low[3], high[3];
  for (int d = 0; d < 3; ++d) {
    low[d] = std::max(a.base[d], b.base[d]);
    high[d] = std::min(a.base[d], b.base[d]) + support;
  }
  for (int i = low[0]; i < high[0]; ++i)
    for (int j = low[1]; j < high[1]; ++j) {
      const auto at = std::lower_bound(joined.begin(), joined.end(), std::array<int, 3>{i, j, low[2]});
      if (at != joined.end() && *at < std::array<int, 3>{i, j, high[2]}) return true;
    }
  return false;
}

}  // namespace

Neighbours::Neighbours(const std::vector<CrackPoint>& p, const JoinedNodes& joined, int support) : order_(p.size()), face_(p.size()) {
  std::vector<std::pair<std::array<int, 3>, int>> cells(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) cells[i] = {{p[i].cell[0], p[i].cell[1], p[i].cell[2]}, static_cast<int>(i)};
  std::sort(cells.begin(), cells.end());
  for (std::size_t n = 0; n < p.size(); ++n) order_[n] = cells[n].second;
  for (int f = 0; f < 6; ++f) {
    std::size_t at = 0;  // the cells across this face come in the order of the cells themselves
    for (const auto& [cell, i] : cells) {
      face_[i][f] = -1;
      std::array<int, 3> across = cell;
      across[f / 2] += f % 2 == 0 ? -1 : 1;
      while (at < cells.size() && cells[at].first < across) ++at;
      if (at == cells.size() || cells[at].first != across) continue;
      const int j = cells[at].second;
      if (p[i].sheet == p[j].sheet || p[i].middle || p[j].middle ||
          (touches(p[i].space[f] + p[j].space[f ^ 1]) && meet(p[i], p[j], joined, support)))
        face_[i][f] = j;
    }
  }
}

}  // namespace mpdem
