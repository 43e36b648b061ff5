// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "lattice_fill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

namespace mpdem {

namespace {

constexpr int kSubSamples = 6;        // a direction, in cut cells
constexpr int kSurfaceSamples = 6;    // a spacing, on the grains

using Cell = std::array<int, 3>;

struct Patch {
  Vector3 sum = Vector3::Zero();  // of sample times area
  double area = 0;
};

Cell cell_of(const Vector3& x, double spacing) {
  Cell c;
  for (int d = 0; d < 3; ++d) c[d] = static_cast<int>(std::floor(x[d] / spacing));
  return c;
}

// Index of the point whose cell holds x, or the nearest one around it.
int owner_of(const std::vector<Cell>& cells, const std::vector<FillPoint>& points, const Vector3& x,
             double spacing) {
  const Cell at = cell_of(x, spacing);
  const auto find = [&](const Cell& c) {
    const auto it = std::lower_bound(cells.begin(), cells.end(), c);
    return it != cells.end() && *it == c ? static_cast<int>(it - cells.begin()) : -1;
  };
  const int own = find(at);
  if (own >= 0) return own;
  for (int reach = 1; reach <= 3; ++reach) {
    int best = -1;
    double nearest = 0;
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j)
        for (int k = -reach; k <= reach; ++k) {
          const int p = find({at[0] + i, at[1] + j, at[2] + k});
          if (p < 0) continue;
          const double d = (points[p].X - x).squaredNorm();
          if (best < 0 || d < nearest * (1.0 - 1e-9)) {
            best = p;
            nearest = d;
          }
        }
    if (best >= 0) return best;
  }
  return -1;
}

// Cuts the attached band of one grain into patches, one a point.
void attach(const Shape& shape, int side, double spacing, const std::vector<Cell>& cells,
            std::vector<FillPoint>& points) {
  const GrainPair& pair = shape.pair();
  const double exact = shape.attached_area(side);
  if (!(exact > 0.0)) return;
  double from, to;
  shape.attached_band(side, from, to);
  const double R = pair.radius(side);
  // Right-handed frame with its pole at the contact; the second direction is chosen along
  // a coordinate axis, so that a bond along an axis is sampled with the lattice's symmetry.
  const Vector3 pole = side == 0 ? pair.n : Vector3(-pair.n);
  int least = 0;
  for (int d = 1; d < 3; ++d)
    if (std::fabs(pole[d]) < std::fabs(pole[least]) - 1e-12) least = d;
  const Vector3 e1 = (Vector3::Unit(least) - pole[least] * pole).normalized();
  const Vector3 e2 = pole.cross(e1);

  const int rings = std::max(1, static_cast<int>(std::ceil((to - from) * R * kSurfaceSamples / spacing)));
  std::vector<Patch> patches(points.size());
  double lost = 0.0;
  for (int i = 0; i < rings; ++i) {
    const double a = from + (to - from) * i / rings, b = from + (to - from) * (i + 1) / rings;
    const double ring_area = 2.0 * M_PI * R * R * 2.0 * std::sin(0.5 * (a + b)) * std::sin(0.5 * (b - a));
    const double theta = 0.5 * (a + b);
    // A multiple of eight keeps the four-fold symmetry and the mirror planes.
    const int around =
        8 * std::max(1, static_cast<int>(std::ceil(2.0 * M_PI * R * std::sin(theta) * kSurfaceSamples / spacing / 8)));
    for (int j = 0; j < around; ++j) {
      const double phi = 2.0 * M_PI * (j + 0.5) / around;
      const Vector3 x = pair.centre(side) + R * (std::cos(theta) * pole + std::sin(theta) * (std::cos(phi) * e1 +
                                                                                           std::sin(phi) * e2));
      const int p = owner_of(cells, points, x, spacing);
      const double area = ring_area / around;
      if (p < 0) {
        lost += area;
        continue;
      }
      patches[p].sum += area * x;
      patches[p].area += area;
    }
  }
  double total = 0.0;
  for (const Patch& q : patches) total += q.area;
  if (!(total > 0.0) || lost > 0.05 * exact) {
    std::ostringstream why;
    why << "the lattice of spacing " << spacing << " does not reach the surface of the grain (area " << exact
        << ", reached " << total << "); use a smaller spacing";
    throw ShapeError(why.str());
  }
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (patches[p].area <= 0.0) continue;
    FillPoint& f = points[p];
    auto& k = f.link[f.links++];
    k.side = side;
    k.area = patches[p].area * exact / total;
    const Vector3 q = patches[p].sum / patches[p].area - pair.centre(side);
    k.foot = pair.centre(side) + R * q.normalized();
  }
}

}  // namespace

std::vector<FillPoint> fill_with_points(const Shape& shape, double spacing) {
  const Vector3 extent = shape.half_extent();
  int n[3];
  double cells_in_box = 1.0;
  for (int d = 0; d < 3; ++d) {
    n[d] = static_cast<int>(std::ceil(extent[d] / spacing)) + 1;
    cells_in_box *= 2.0 * n[d];
  }
  if (cells_in_box > 4e9) {
    std::ostringstream why;
    why << "spacing " << spacing << " would need a lattice of " << cells_in_box << " cells; use a larger spacing";
    throw ShapeError(why.str());
  }
  const double half_diagonal = 0.5 * std::sqrt(3.0) * spacing;
  std::vector<Cell> cells;
  std::vector<FillPoint> points;
  for (int i = -n[0]; i < n[0]; ++i)
    for (int j = -n[1]; j < n[1]; ++j)
      for (int k = -n[2]; k < n[2]; ++k) {
        const Vector3 centre = spacing * Vector3(i + 0.5, j + 0.5, k + 0.5);
        FillPoint p;
        if (shape.clearance(centre) >= half_diagonal) {
          if (!shape.inside(centre)) continue;
          p.X = centre;
          p.volume = spacing * spacing * spacing;
        } else {
          int count = 0;
          Vector3 sum = Vector3::Zero();
          for (int a = 0; a < kSubSamples; ++a)
            for (int b = 0; b < kSubSamples; ++b)
              for (int c = 0; c < kSubSamples; ++c) {
                const Vector3 local((a + 0.5) / kSubSamples - 0.5, (b + 0.5) / kSubSamples - 0.5,
                                    (c + 0.5) / kSubSamples - 0.5);
                if (!shape.inside(centre + spacing * local)) continue;
                ++count;
                sum += local;
              }
          if (count == 0) continue;
          p.X = centre + spacing / count * sum;
          p.volume = spacing * spacing * spacing * count / (kSubSamples * kSubSamples * kSubSamples);
        }
        cells.push_back({i, j, k});
        points.push_back(p);
      }
  if (points.empty()) {
    std::ostringstream why;
    why << "no cell of a lattice of spacing " << spacing << " lies in the cement (" << shape.describe()
        << "); use a smaller spacing";
    throw ShapeError(why.str());
  }
  double total = 0.0;
  for (const FillPoint& p : points) total += p.volume;
  const double scale = shape.volume() / total;
  for (FillPoint& p : points) p.volume *= scale;
  for (int side = 0; side < 2; ++side) attach(shape, side, spacing, cells, points);
  return points;
}

}  // namespace mpdem
