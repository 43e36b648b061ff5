// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "unbonded_gap.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "../numerics/grid_index.h"
#include "../numerics/sort_unique.h"

namespace mpdem {

GapPoint gap_point(const PointStore& points, const BondRecord& record, int block, int lane) {
  GapPoint p;
  for (int d = 0; d < 3; ++d) {
    p.X[d] = points.created_at(block)[d][lane];
    p.cell[d] = lattice_cell(record, d, p.X[d]);
  }
  p.share = points.blocks[block].volume[lane] / (record.spacing * record.spacing * record.spacing);
  const double nearer = nearer_to_first(record, p.X);
  p.nearer_grain = nearer_grain(record, nearer);
  p.middle = is_equidistant(record, nearer);
  return p;
}

double space_ahead(const GapPoint& p, const BondRecord& record, int d, int side) {
  if (!record.regular) return 0.0;
  double box = 1.0, ahead = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double shift = (p.X[c] - record.lattice[c]) / record.spacing - (p.cell[c] + 0.5);
    box *= 1.0 - 2.0 * std::fabs(shift);
    if (c == d) ahead = std::max(0.0, -2.0 * side * shift);
  }
  return ahead + std::max(0.0, 1.0 - p.share / box);
}

namespace {

constexpr double kGapFound = 0.5;       // weight of gaps over the weight of all rows
constexpr double kShareJoined = 0.125;  // weight of bridges over that of all crossings

// Sum of the weights of the crossings of a node.
struct Crossings {
  double bridge = 0.0, gap = 0.0;
};
using Table = std::unordered_map<GridIndex, Crossings, GridIndexHash, SameGridIndex>;

// Adds a crossing along axis d, from point a up to point b of a row, to the nodes that are in the supports of both.
template <class Type>
void add_crossing(const GapPoint& a, const GapPoint& b, int d, const BondRecord& record, double inverse_h, bool bridge, Table& table) {
  constexpr int S = Type::kSupport;
  const int e = (d + 1) % 3, g = (d + 2) % 3;
  const auto middle = [&](const GapPoint& p, int c) { return (p.cell[c] + 0.5) * record.spacing + record.lattice[c]; };
  int base[3];
  vd X[3];
  for (int c = 0; c < 3; ++c) {
    base[c] = support_base(middle(a, c), inverse_h, Type::kShift);
    X[c] = splat(middle(a, c));
  }
  const int first = support_base(middle(b, d), inverse_h, Type::kShift), last = base[d] + S;
  const Weights<Type> w(X, base, inverse_h);
  std::array<int, 3> node;
  for (int i = first; i < last; ++i)
    for (int j = 0; j < S; ++j)
      for (int k = 0; k < S; ++k) {
        node[d] = i;
        node[e] = base[e] + j;
        node[g] = base[g] + k;
        const double weight = w.w[e][j][0] * w.w[g][k][0];
        (bridge ? table[node].bridge : table[node].gap) += weight;
      }
}

// Calls f(a, b, axis) for successive points of a row, lower first, that are on different sides.
template <class F>
void for_each_crossing(std::vector<GapPoint>& points, F f) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    const auto row = [&](const GapPoint& p) { return std::array<int, 3>{p.cell[e], p.cell[g], p.cell[d]}; };
    std::sort(points.begin(), points.end(), [&](const GapPoint& a, const GapPoint& b) { return row(a) < row(b); });
    for (std::size_t n = 1; n < points.size(); ++n) {
      const GapPoint &a = points[n - 1], &b = points[n];
      if (a.cell[e] == b.cell[e] && a.cell[g] == b.cell[g] && a.nearer_grain != b.nearer_grain) f(a, b, d);
    }
  }
}

}  // namespace

// Comparisons have a margin of 1e-6, so that rounding does not decide where a share equals its limit.
UnbondedGap find_unbonded_gap(std::vector<GapPoint>& points, const BondRecord& record, Basis basis, double cell) {
  UnbondedGap result;
  const double all_rows = std::pow(cell / record.spacing, 2);  // sum of the weights of all rows in the support of a node
  with_basis(basis, [&](auto type) {
    using Type = decltype(type);
    const auto adjacent = [](const GapPoint& a, const GapPoint& b, int d) { return b.cell[d] - a.cell[d] == 1; };
    Table gaps;  // first without bridges: most bonds have no gaps
    for_each_crossing(points, [&](const GapPoint& a, const GapPoint& b, int d) {
      if (!adjacent(a, b, d)) add_crossing<Type>(a, b, d, record, 1.0 / cell, false, gaps);
    });
    for (const auto& n : gaps) result.found = result.found || n.second.gap > (kGapFound + 1e-6) * all_rows;
    if (!result.found) return;
    Table table;
    for_each_crossing(points, [&](const GapPoint& a, const GapPoint& b, int d) {
      const bool bridge = adjacent(a, b, d) && touches(space_ahead(a, record, d, 1) + space_ahead(b, record, d, -1));
      add_crossing<Type>(a, b, d, record, 1.0 / cell, bridge, table);
    });
    for (const auto& n : table)
      if (n.second.bridge >= (kShareJoined - 1e-6) * (n.second.bridge + n.second.gap)) result.joined.push_back(n.first);
    for (const GapPoint& p : points) {
      if (!p.middle) continue;
      int base[3];
      for (int d = 0; d < 3; ++d) base[d] = support_base(p.X[d], 1.0 / cell, Type::kShift);
      for (int i = 0; i < Type::kSupport; ++i)
        for (int j = 0; j < Type::kSupport; ++j)
          for (int k = 0; k < Type::kSupport; ++k) result.joined.push_back({base[0] + i, base[1] + j, base[2] + k});
    }
  });
  sort_unique(result.joined);
  result.found = result.found && !result.joined.empty();
  return result;
}

}  // namespace mpdem
