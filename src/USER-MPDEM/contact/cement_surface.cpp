// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "../numerics/rotation.h"

namespace mpdem {

namespace {

using Cell = std::array<int, 3>;

// Lattice cells that have a point of each side: one bit a side in a box of cells.
struct OccupiedCells {
  Cell low{}, size{};
  std::vector<unsigned char> sides;
  OccupiedCells(const BondRecord& record, const std::vector<PointOfCement>& points) {
    Cell high{};
    bool first = true;
    for (const PointOfCement& p : points) {
      if (p.thickness > 0.0 || p.side > 1) continue;
      const Cell c = cell_of(record, p.X);
      for (int d = 0; d < 3; ++d) {
        low[d] = first ? c[d] : std::min(low[d], c[d]);
        high[d] = first ? c[d] : std::max(high[d], c[d]);
      }
      first = false;
    }
    if (first) return;
    for (int d = 0; d < 3; ++d) size[d] = high[d] - low[d] + 1;
    sides.assign(static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]), 0);
    for (const PointOfCement& p : points)
      if (p.thickness == 0.0 && p.side < 2) sides[index_of(cell_of(record, p.X))] |= static_cast<unsigned char>(1 << p.side);
  }
  std::size_t index_of(const Cell& c) const {
    const auto along = [&](int d) { return static_cast<std::size_t>(c[d] - low[d]); };
    return (along(0) * static_cast<std::size_t>(size[1]) + along(1)) * static_cast<std::size_t>(size[2]) + along(2);
  }
  static Cell cell_of(const BondRecord& record, const double* X) {
    return {lattice_cell(record, 0, X[0]), lattice_cell(record, 1, X[1]), lattice_cell(record, 2, X[2])};
  }
  bool has(int side, const Cell& c) const {
    for (int d = 0; d < 3; ++d)
      if (c[d] < low[d] || c[d] >= low[d] + size[d]) return false;
    return sides[index_of(c)] >> side & 1;
  }
};

// Direction from the cement that is around a point to the empty places, zero if there is cement all around. exposed: is
// one of the six nearest places empty? on_grain: the grain of the piece fills places.
std::array<double, 3> outward(const BondRecord& record, const OccupiedCells& cells, const PointOfCement& p, bool apart, bool on_grain,
                              bool& exposed) {
  std::array<double, 3> sum{};
  const Cell own = OccupiedCells::cell_of(record, p.X);
  exposed = false;
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k) {
        const int step[3] = {i, j, k}, steps = i * i + j * j + k * k;
        if (steps == 0) continue;
        double place[3];
        for (int d = 0; d < 3; ++d) place[d] = p.X[d] + record.spacing * step[d];
        bool filled = false;
        for (int s = 0; s < 2; ++s)
          if (!apart || s == p.side)
            filled = filled || cells.has(s, {own[0] + i, own[1] + j, own[2] + k}) || (on_grain && above_grain(record, s, place) < 0.0);
        if (filled) continue;
        exposed = exposed || steps == 1;
        for (int d = 0; d < 3; ++d) sum[d] += step[d] / std::sqrt(steps);
      }
  return sum;
}

// Unit vector along the first vector. Empty places on opposite sides leave no direction but the second one.
struct Direction {
  double n[3];
  Direction(const std::array<double, 3>& out, const std::array<double, 3>& instead) {
    double size = 0.0, size_of_out = 0.0;
    for (int d = 0; d < 3; ++d) {
      size += instead[d] * instead[d];
      size_of_out += out[d] * out[d];
    }
    constexpr double kClear = 0.5;
    const bool clear = std::sqrt(size_of_out) > kClear;
    for (int d = 0; d < 3; ++d) n[d] = clear ? out[d] / std::sqrt(size_of_out) : instead[d] / std::sqrt(size);
  }
};

// Radius and area of a point of the lattice.
void set_size(const PointOfCement& p, SurfacePoint& q) {
  const double side = std::cbrt(p.volume);
  q.radius = 0.5 * side;
  q.area = side * side;
}

// The surface of a fragment, whose points have that side. Returns a piece without points if there is none.
CementPiece fragment_of(const BondRecord& record, int row, int side, const std::vector<PointOfCement>& points) {
  CementPiece piece;
  piece.row = row;
  piece.side = side;
  piece.other = record.grain[0];
  piece.second = record.grain[1];
  piece.apart = true;
  piece.spacing = record.spacing;
  std::vector<PointOfCement> own;
  double middle[3] = {0, 0, 0};
  for (const PointOfCement& p : points) {
    if (p.side != side || p.thickness > 0.0) continue;
    own.push_back(p);
    own.back().side = 0;
    for (int d = 0; d < 3; ++d) middle[d] += p.X[d];
  }
  for (double& m : middle) m /= static_cast<double>(std::max<std::size_t>(own.size(), 1));
  const OccupiedCells cells(record, own);
  for (const PointOfCement& p : own) {
    bool exposed = true;
    const std::array<double, 3> out = outward(record, cells, p, true, false, exposed);
    if (!exposed) continue;
    SurfacePoint q;
    const Direction direction(out, {p.X[0] - middle[0], p.X[1] - middle[1], p.X[2] - middle[2]});
    for (int d = 0; d < 3; ++d) {
      q.X[d] = p.X[d];
      q.normal[d] = direction.n[d];
    }
    set_size(p, q);
    piece.points.push_back(q);
  }
  if (!piece.points.empty()) piece.find_bounds();
  return piece;
}

}  // namespace

void CementPiece::find_bounds() {
  size = static_cast<int>(points.size());
  for (int d = 0; d < 3; ++d) {
    double low = points.front().X[d], high = low;
    for (const SurfacePoint& p : points) {
      low = std::min(low, p.X[d]);
      high = std::max(high, p.X[d]);
    }
    middle[d] = 0.5 * (low + high);
  }
  reach = 0.0;
  for (const SurfacePoint& p : points) {
    double square = 0.0;
    for (int d = 0; d < 3; ++d) square += (p.X[d] - middle[d]) * (p.X[d] - middle[d]);
    reach = std::max(reach, std::sqrt(square) + std::max(p.radius, 0.0));
  }
}

std::vector<CementPiece> pieces_of(const BondRecord& record, int row, const std::vector<PointOfCement>& points, bool apart,
                                   const std::vector<std::vector<Key>>& fragments) {
  const OccupiedCells cells(record, points);
  std::vector<CementPiece> both(2), pieces;
  for (int s = 0; s < 2; ++s) {
    CementPiece& piece = both[s];
    piece.row = row;
    piece.side = s;
    piece.grain = record.grain[s];
    piece.other = record.grain[1 - s];
    piece.apart = apart;
    piece.spacing = record.spacing;
    double apart_by[3];
    for (int d = 0; d < 3; ++d) apart_by[d] = record.centre[1 - s][d] - record.centre[s][d];
    const std::array<double, 3> at = turned_back(rotation_of(record.orientation[s]), apart_by);
    std::copy(at.begin(), at.end(), piece.other_at);
    const double* q = record.orientation[s];
    const double back[4] = {q[0], -q[1], -q[2], -q[3]};
    const std::array<double, 4> turn = quaternion_product(back, record.orientation[1 - s]);
    std::copy(turn.begin(), turn.end(), piece.other_turned);
  }
  for (const PointOfCement& p : points) {
    if (p.side > 1 || !record.has_grain(p.side) || (p.thickness > 0.0 && !apart)) continue;
    bool exposed = true;
    std::array<double, 3> out{};
    if (p.thickness == 0.0) out = outward(record, cells, p, apart, true, exposed);
    if (!exposed) continue;
    std::array<double, 3> from_grain;
    for (int d = 0; d < 3; ++d) from_grain[d] = p.X[d] - record.centre[p.side][d];
    const Mat3<double> R = rotation_of(record.orientation[p.side]);
    const Direction direction(out, from_grain);
    SurfacePoint q;
    const std::array<double, 3> X = turned_back(R, from_grain.data()), n = turned_back(R, direction.n);
    std::copy(X.begin(), X.end(), q.X);
    std::copy(n.begin(), n.end(), q.normal);
    if (p.thickness > 0.0) {
      q.radius = 0.5 * p.thickness;
      q.area = p.volume / p.thickness;
    } else {
      set_size(p, q);
    }
    both[p.side].points.push_back(q);
  }
  for (CementPiece& piece : both) {
    if (piece.points.empty()) continue;
    piece.find_bounds();
    pieces.push_back(std::move(piece));
  }
  for (std::size_t k = 0; k < fragments.size(); ++k) {
    CementPiece piece = fragment_of(record, row, static_cast<int>(k) + 2, points);
    piece.nodes = fragments[k];
    piece.held = static_cast<int>(piece.nodes.size());
    if (!piece.points.empty()) pieces.push_back(std::move(piece));
  }
  return pieces;
}

}  // namespace mpdem
