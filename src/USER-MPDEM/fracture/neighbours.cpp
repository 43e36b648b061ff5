// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "neighbours.h"

#include <algorithm>
#include <utility>

#include "unbonded_gap.h"

namespace mpdem {

int Neighbours::at(const std::array<int, 3>& cell) const {
  const int x = cell[0] - least_x_;
  if (x < 0 || x + 1 >= static_cast<int>(first_.size())) return -1;
  const auto end = cells_.begin() + first_[x + 1];
  const auto it = std::lower_bound(cells_.begin() + first_[x], end, std::make_pair(cell, -1));
  return it != end && it->first == cell ? it->second : -1;
}

bool Neighbours::find_bridge(int i, int face, std::vector<int>* beside) const {
  const int other = face_[i][face];
  if (other < 0 || points_[i].failed || points_[other].failed) return false;
  const int m = across_, width = 2 * m - 1, d = face / 2, e = (d + 1) % 3, g = (d + 2) % 3;
  constexpr int kMostFaces = (2 * kMostAcross - 1) * (2 * kMostAcross - 1);
  std::array<int, 2> pairs[kMostFaces];
  bool cut[kMostFaces], present[kMostFaces];
  if (m == 1) {
    if (beside) *beside = {i, other};
    return true;
  }
  // The faces in a square of `width` by `width` about this face. All squares of m by m that have this face lie in it.
  for (int j = 0; j < width; ++j)
    for (int k = 0; k < width; ++k) {
      std::array<int, 3> here{points_[i].cell[0], points_[i].cell[1], points_[i].cell[2]};
      here[e] += j - m + 1;
      here[g] += k - m + 1;
      std::array<int, 3> next = here;
      next[d] += face % 2 == 0 ? -1 : 1;
      std::array<int, 2>& pair = pairs[width * j + k] = {at(here), at(next)};
      present[width * j + k] = pair[0] >= 0 && pair[1] >= 0;
      cut[width * j + k] = std::any_of(pair.begin(), pair.end(), [&](int p) { return p >= 0 && points_[p].failed; });
    }
  // Finds the first of the squares with most faces that has no failed point. At a rim even these lack some faces.
  int most = 0, j_whole = -1, k_whole = -1;
  for (int j0 = 0; j0 < m; ++j0)
    for (int k0 = 0; k0 < m; ++k0) {
      bool whole = true;
      int faces = 0;
      for (int j = j0; j < j0 + m; ++j)
        for (int k = k0; k < k0 + m; ++k) {
          whole = whole && !cut[width * j + k];
          faces += present[width * j + k];
        }
      if (faces > most) {
        most = faces;
        j_whole = -1;
      }
      if (faces < most || !whole || j_whole >= 0) continue;
      j_whole = j0;
      k_whole = k0;
    }
  if (j_whole < 0) return false;
  for (int j = j_whole; j < j_whole + m && beside; ++j)
    for (int k = k_whole; k < k_whole + m; ++k)
      for (int p : pairs[width * j + k])
        if (p >= 0) beside->push_back(p);
  return true;
}

std::vector<int> Neighbours::bridge(int i, int face) const {
  std::vector<int> beside;
  find_bridge(i, face, &beside);
  return beside;
}

Neighbours::Neighbours(const std::vector<CrackPoint>& p, int across)
    : order_(p.size()), face_(p.size()), points_(p), across_(across), cells_(p.size()) {
  std::vector<std::pair<std::array<int, 3>, int>>& cells = cells_;
  for (std::size_t i = 0; i < p.size(); ++i) cells[i] = {{p[i].cell[0], p[i].cell[1], p[i].cell[2]}, static_cast<int>(i)};
  std::sort(cells.begin(), cells.end());
  for (std::size_t n = 0; n < p.size(); ++n) order_[n] = cells[n].second;
  if (!cells.empty()) {
    least_x_ = cells.front().first[0];
    first_.assign(cells.back().first[0] - least_x_ + 2, 0);
    for (const auto& c : cells) ++first_[c.first[0] - least_x_ + 1];
    for (std::size_t x = 1; x < first_.size(); ++x) first_[x] += first_[x - 1];
  }
  for (int f = 0; f < 6; ++f) {
    std::size_t at = 0;  // increases only: the cells across this face are ordered as the cells themselves
    for (const auto& [cell, i] : cells) {
      face_[i][f] = -1;
      std::array<int, 3> across = cell;
      across[f / 2] += f % 2 == 0 ? -1 : 1;
      while (at < cells.size() && cells[at].first < across) ++at;
      if (at == cells.size() || cells[at].first != across) continue;
      const int j = cells[at].second;
      if (p[i].nearer == p[j].nearer || p[i].middle || p[j].middle || touches(p[i].space[f] + p[j].space[f ^ 1])) face_[i][f] = j;
    }
  }
}

}  // namespace mpdem
