// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "crevice.h"

#include <algorithm>
#include <cmath>

namespace mpdem {

namespace {

constexpr double kGapFound = 0.5;       // of what crosses where all rows do
constexpr double kShareJoined = 0.125;  // of bridges in what crosses
constexpr double kTouch = 0.1;    // of the spacing, between material that counts as joined

struct Crossing {
  std::array<int, 3> node;
  double bridge, gap;
};

struct Lattice {
  double spacing, inverse_h;
};

// Empty space on the way out of the cell of a point, in direction d and upwards (side 1) or downwards (-1), in
// spacings. Material is taken as a box about its centroid, and what is missing in it as a slit.
double space_ahead(const SheetPoint& p, int d, int side, double spacing) {
  double box = 1.0, ahead = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double shift = p.X[c] / spacing - (p.cell[c] + 0.5);
    box *= 1.0 - 2.0 * std::fabs(shift);
    if (c == d) ahead = std::max(0.0, -2.0 * side * shift);
  }
  return ahead + std::max(0.0, 1.0 - p.share / box);
}

// What crosses along axis d from point a to point b of a row, to the nodes that have both in their support.
template <class Type>
void add_crossing(const SheetPoint& a, const SheetPoint& b, int d, const Lattice& lattice, bool closely, std::vector<Crossing>& out) {
  constexpr int S = Type::kSupport;
  const int e = (d + 1) % 3, g = (d + 2) % 3;
  bool bridge = b.cell[d] - a.cell[d] == 1;
  if (bridge && closely) bridge = space_ahead(a, d, 1, lattice.spacing) + space_ahead(b, d, -1, lattice.spacing) <= kTouch;
  int base[3];
  vd X[3];
  for (int c = 0; c < 3; ++c) {
    const double middle = (a.cell[c] + 0.5) * lattice.spacing;
    base[c] = support_base(middle, lattice.inverse_h, Type::kShift);
    X[c] = splat(middle);
  }
  const int first = support_base((b.cell[d] + 0.5) * lattice.spacing, lattice.inverse_h, Type::kShift), last = base[d] + S;
  const Weights<Type> w(X, base, lattice.inverse_h);
  Crossing c;
  for (int i = first; i < last; ++i)
    for (int j = 0; j < S; ++j)
      for (int k = 0; k < S; ++k) {
        c.node[d] = i;
        c.node[e] = base[e] + j;
        c.node[g] = base[g] + k;
        const double weight = w.w[e][j][0] * w.w[g][k][0];
        c.bridge = bridge ? weight : 0.0;
        c.gap = bridge ? 0.0 : weight;
        out.push_back(c);
      }
}

Crevice look(std::vector<SheetPoint>& points, Basis basis, const Lattice& lattice, bool closely) {
  const double all_rows = 1.0 / std::pow(lattice.spacing * lattice.inverse_h, 2);
  std::vector<Crossing> all;
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    const auto row = [&](const SheetPoint& p) { return std::array<int, 3>{p.cell[e], p.cell[g], p.cell[d]}; };
    std::sort(points.begin(), points.end(), [&](const SheetPoint& a, const SheetPoint& b) { return row(a) < row(b); });
    with_basis(basis, [&](auto type) {
      for (std::size_t n = 1; n < points.size(); ++n) {
        const SheetPoint &a = points[n - 1], &b = points[n];
        if (a.cell[e] == b.cell[e] && a.cell[g] == b.cell[g] && a.sheet != b.sheet)
          add_crossing<decltype(type)>(a, b, d, lattice, closely, all);
      }
    });
  }
  std::sort(all.begin(), all.end(), [](const Crossing& a, const Crossing& b) { return a.node < b.node; });
  Crevice result;
  for (std::size_t n = 0; n < all.size();) {
    const std::array<int, 3> node = all[n].node;
    double bridge = 0.0, gap = 0.0;
    for (; n < all.size() && all[n].node == node; ++n) {
      bridge += all[n].bridge;
      gap += all[n].gap;
    }
    // no share of a lattice is near enough for rounding to decide
    if (bridge >= (kShareJoined - 1e-6) * (bridge + gap)) result.joined.push_back(node);
    result.found = result.found || gap > (kGapFound + 1e-6) * all_rows;
  }
  return result;
}

}  // namespace

Crevice find_crevice(std::vector<SheetPoint> points, Basis basis, double cell, double spacing) {
  const Lattice lattice{spacing, 1.0 / cell};
  const Crevice at_sight = look(points, basis, lattice, false);
  return at_sight.found ? look(points, basis, lattice, true) : at_sight;
}

}  // namespace mpdem
