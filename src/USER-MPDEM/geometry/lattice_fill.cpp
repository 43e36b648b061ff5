// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "lattice_fill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

namespace mpdem {

namespace {

constexpr int kSubSamples = 6;      // samples in each direction, in cells that the surface cuts
constexpr int kSharedSamples = 16;  // samples in each direction, in cells that a neighbouring bond cuts
constexpr int kSurfaceSamples = 6;  // samples in a length of one spacing on the surface of a grain

using Cell = std::array<int, 3>;

struct Patch {
  Vector3 sum = Vector3::Zero();  // sum of sample times area
  double area = 0;
};

Cell lattice_cell_of(const Vector3& x, double spacing) {
  Cell c;
  for (int d = 0; d < 3; ++d) c[d] = static_cast<int>(std::floor(x[d] / spacing));
  return c;
}

enum class Owner { shape, neighbour, several };

// Finds the owner of the material inside the shape within `reach` of x. A neighbour owns the material inside its own shape that
// is nearer to its middle than to that of this shape.
Owner owner_around(const std::vector<Neighbour>& neighbours, const Vector3& x, double reach) {
  Owner owner = Owner::shape;
  for (const Neighbour& n : neighbours) {
    const double apart = n.middle.norm();
    const double beyond = 0.5 * apart - x.dot(n.middle) / apart;  // distance from the plane half-way to the other middle
    if (beyond > reach) continue;
    // whole: the ball of this reach is all inside or all outside of the shape of the neighbour.
    const bool whole = n.shape->clearance(n.own(x)) >= reach, inside = n.shape->inside(n.own(x));
    if (whole && !inside) continue;
    if (whole && beyond < -reach) return Owner::neighbour;
    owner = Owner::several;
  }
  return owner;
}

// Index of the point whose cell contains x, or of the nearest one in cells around it; -1: none within three cells.
int owner_of(const std::vector<Cell>& cells, const std::vector<FillPoint>& points, const Vector3& x, double spacing) {
  const Cell at = lattice_cell_of(x, spacing);
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

// Cuts the attached band of one grain into patches, one for each point.
void attach(const Shape& shape, int side, double spacing, const std::vector<Neighbour>& neighbours, const std::vector<Cell>& cells,
            std::vector<FillPoint>& points) {
  const GrainPair& pair = shape.pair();
  const double exact = shape.attached_area(side);
  if (!(exact > 0.0)) return;
  double from, to;
  shape.attached_band(side, from, to);
  const double R = pair.radius(side);
  // Right-handed frame with its pole at the contact. The second direction is chosen along a coordinate axis, so that a bond
  // along an axis is sampled with the symmetry of the lattice.
  const Vector3 pole = side == 0 ? pair.n : Vector3(-pair.n);
  int least = 0;
  for (int d = 1; d < 3; ++d)
    if (std::fabs(pole[d]) < std::fabs(pole[least]) - 1e-12) least = d;
  const Vector3 e1 = (Vector3::Unit(least) - pole[least] * pole).normalized();
  const Vector3 e2 = pole.cross(e1);

  const int rings = std::max(1, static_cast<int>(std::ceil((to - from) * R * kSurfaceSamples / spacing)));
  std::vector<Patch> patches(points.size());
  double lost = 0.0, all = 0.0, own = 0.0;
  for (int i = 0; i < rings; ++i) {
    const double a = from + (to - from) * i / rings, b = from + (to - from) * (i + 1) / rings;
    const double ring_area = 2.0 * M_PI * R * R * 2.0 * std::sin(0.5 * (a + b)) * std::sin(0.5 * (b - a));
    const double theta = 0.5 * (a + b);
    // A multiple of eight keeps the four-fold symmetry and the mirror planes.
    const int around = 8 * std::max(1, static_cast<int>(std::ceil(2.0 * M_PI * R * std::sin(theta) * kSurfaceSamples / spacing / 8)));
    for (int j = 0; j < around; ++j) {
      const double phi = 2.0 * M_PI * (j + 0.5) / around;
      const Vector3 out = std::cos(theta) * pole + std::sin(theta) * (std::cos(phi) * e1 + std::sin(phi) * e2);
      const Vector3 x = pair.centre(side) + R * out;
      // The position is tested a little above the surface, where shapes begin.
      const double part = neighbours.empty() ? 1.0 : share_at(neighbours, x + 1e-3 * spacing * out);
      const double area = part * ring_area / around;
      all += ring_area / around;
      own += area;
      if (part == 0.0) continue;
      const int p = owner_of(cells, points, x, spacing);
      if (p < 0) {
        lost += area;
        continue;
      }
      patches[p].sum += area * x;
      patches[p].area += area;
    }
  }
  const double attached = exact * (own / all);  // exact area of the part that neighbours do not own
  double total = 0.0;
  for (const Patch& q : patches) total += q.area;
  if (!(own > 0.0)) throw ShapeError("neighbours take all of the cement at the surface of a grain; make the shapes smaller");
  if (!(total > 0.0) || lost > 0.05 * exact) {
    std::ostringstream why;
    why << "the lattice of spacing " << spacing << " does not reach the surface of the grain (area " << exact << ", reached " << total
        << "); use a smaller spacing";
    throw ShapeError(why.str());
  }
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (patches[p].area <= 0.0) continue;
    FillPoint& f = points[p];
    auto& k = f.link[f.link_count++];
    k.side = side;
    k.area = patches[p].area * attached / total;
    const Vector3 q = patches[p].sum / patches[p].area - pair.centre(side);
    k.foot = pair.centre(side) + R * q.normalized();
  }
}

// Finds the cells of the lattice that the shape fills or cuts, by halving boxes of cells. A box whose middle is further
// from the surface than from its corners is all inside or all outside.
void find_cells(const Shape& shape, double spacing, const Cell& from, const Cell& to, std::vector<Cell>& full, std::vector<Cell>& cut) {
  Vector3 middle, size;
  int longest = 0;
  for (int d = 0; d < 3; ++d) {
    middle[d] = 0.5 * spacing * (from[d] + to[d]);
    size[d] = spacing * (to[d] - from[d]);
    if (to[d] - from[d] > to[longest] - from[longest]) longest = d;
  }
  if (shape.clearance(middle) >= 0.5 * size.norm()) {
    if (!shape.inside(middle)) return;
    for (int i = from[0]; i < to[0]; ++i)
      for (int j = from[1]; j < to[1]; ++j)
        for (int k = from[2]; k < to[2]; ++k) full.push_back({i, j, k});
    return;
  }
  if (to[longest] - from[longest] == 1) {
    cut.push_back(from);
    return;
  }
  Cell upper = to, lower = from;
  upper[longest] = lower[longest] = (from[longest] + to[longest]) / 2;
  if (upper[longest] == from[longest]) upper[longest] = lower[longest] = from[longest] + 1;  // neither half may be empty
  find_cells(shape, spacing, from, upper, full, cut);
  find_cells(shape, spacing, lower, to, full, cut);
}

// Sum of weights and their centroid over samples in a cell. weight(x) is from 0 to 1. Returns false if the sum is zero.
template <class Weight>
bool sample_cell(double spacing, const Cell& cell, int samples, Weight weight, double& sum, Vector3& centroid) {
  const Vector3 centre = spacing * Vector3(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5);
  sum = 0.0;
  Vector3 moment = Vector3::Zero();
  for (int a = 0; a < samples; ++a)
    for (int b = 0; b < samples; ++b)
      for (int c = 0; c < samples; ++c) {
        const Vector3 local((a + 0.5) / samples - 0.5, (b + 0.5) / samples - 0.5, (c + 0.5) / samples - 0.5);
        const double w = weight(centre + spacing * local);
        sum += w;
        moment += w * local;
      }
  if (sum == 0.0) return false;
  centroid = centre + spacing / sum * moment;
  return true;
}

// Finds volume and centroid of the inside of a cut cell. Returns false if nothing is inside.
bool cut_cell(const Shape& shape, double spacing, const Cell& cell, FillPoint& p) {
  double count;
  if (!sample_cell(
          spacing, cell, kSubSamples, [&](const Vector3& x) { return shape.inside(x) ? 1.0 : 0.0; }, count, p.X))
    return false;
  p.volume = spacing * spacing * spacing * count / (kSubSamples * kSubSamples * kSubSamples);
  return true;
}

// Reduces a point to the region of its cell that neighbours do not own. Returns false if that is empty.
bool keep_own(const Shape& shape, double spacing, const std::vector<Neighbour>& neighbours, const Cell& cell, FillPoint& p) {
  const Vector3 centre = spacing * Vector3(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5);
  const Owner owner = owner_around(neighbours, centre, 0.5 * std::sqrt(3.0) * spacing);
  if (owner != Owner::several) return owner == Owner::shape;
  double whole, own;
  Vector3 centroid;
  const auto inside = [&](const Vector3& x) { return shape.inside(x) ? 1.0 : 0.0; };
  const auto mine = [&](const Vector3& x) { return shape.inside(x) ? share_at(neighbours, x) : 0.0; };
  if (!sample_cell(spacing, cell, kSharedSamples, mine, own, centroid)) return false;
  Vector3 unused;
  sample_cell(spacing, cell, kSharedSamples, inside, whole, unused);
  if (own == whole) return true;
  p.X = centroid;
  p.volume *= own / whole;
  return true;
}

}  // namespace

double share_at(const std::vector<Neighbour>& neighbours, const Vector3& x) {
  const double own = x.squaredNorm();
  int ties = 1;
  for (const Neighbour& n : neighbours) {
    const double other = (x - n.middle).squaredNorm(), tolerance = 1e-9 * (own + other);
    if (other > own + tolerance || !n.shape->inside(n.own(x))) continue;
    if (other < own - tolerance) return 0.0;
    ++ties;
  }
  return 1.0 / ties;
}

std::vector<FillPoint> fill_with_points(const Shape& shape, double spacing, double most, const std::vector<Neighbour>& neighbours) {
  const Vector3 extent = shape.half_extent();
  const double expected = shape.volume() / (spacing * spacing * spacing);
  constexpr double kMostCells = 1e9;  // along an axis
  if (!(expected < most) || !(extent.maxCoeff() < kMostCells * spacing)) {
    std::ostringstream why;
    why << "spacing " << spacing << " would take " << expected << " points, more than the " << most
        << " that there is memory for; use a spacing of at least "
        << std::max(std::cbrt(shape.volume() / most), extent.maxCoeff() / kMostCells) << " or more machines";
    throw ShapeError(why.str());
  }
  Cell from, to;
  for (int d = 0; d < 3; ++d) {
    to[d] = static_cast<int>(std::ceil(extent[d] / spacing)) + 1;
    from[d] = -to[d];
  }
  std::vector<Cell> full, cut;
  find_cells(shape, spacing, from, to, full, cut);

  std::vector<std::pair<Cell, FillPoint>> filled;
  filled.reserve(full.size() + cut.size());
  for (const Cell& c : full) {
    FillPoint p;
    p.X = spacing * Vector3(c[0] + 0.5, c[1] + 0.5, c[2] + 0.5);
    p.volume = spacing * spacing * spacing;
    filled.emplace_back(c, p);
  }
  for (const Cell& c : cut) {
    FillPoint p;
    if (cut_cell(shape, spacing, c, p)) filled.emplace_back(c, p);
  }
  if (filled.empty()) {
    std::ostringstream why;
    why << "no cell of a lattice of spacing " << spacing << " lies in the cement (" << shape.describe() << "); use a smaller spacing";
    throw ShapeError(why.str());
  }
  std::sort(filled.begin(), filled.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Cell> cells;
  std::vector<FillPoint> points;
  double total = 0.0;
  for (auto& f : filled) {
    total += f.second.volume;  // includes what neighbours own
    if (!neighbours.empty() && !keep_own(shape, spacing, neighbours, f.first, f.second)) continue;
    cells.push_back(f.first);
    points.push_back(f.second);
  }
  const double scale = shape.volume() / total;
  for (FillPoint& p : points) p.volume *= scale;
  for (int side = 0; side < 2; ++side) attach(shape, side, spacing, neighbours, cells, points);
  return points;
}

}  // namespace mpdem
