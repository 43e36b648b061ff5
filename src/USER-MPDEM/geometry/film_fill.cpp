// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "film_fill.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "flat.h"

namespace mpdem {

namespace {

constexpr int kSectors = 16;  // of a ring of a film; a multiple of eight keeps the mirror planes of the lattice
constexpr int kLeastRings = 4, kMostRings = 8;
constexpr int kLeastRingsOfSeam = 2;
constexpr double kRingsOfRatio = 3.0;  // rings for a thickness e times that at the inner rim
constexpr double kThinnest = 1e-3;     // of the smaller radius
constexpr double kNoFilm = 1e-9;       // cement thinner than a cell by less than this share is no film

// Points and weights of the Gauss-Legendre rule with n points on (0, 1), by Newton's method.
void gauss_rule(int n, std::vector<double>& at, std::vector<double>& weight) {
  at.resize(n);
  weight.resize(n);
  for (int i = 0; i < n; ++i) {
    double x = std::cos(M_PI * (i + 0.75) / (n + 0.5)), slope = 1.0;
    for (int k = 0; k < 50; ++k) {
      double p = 1.0, before = 0.0;
      for (int j = 0; j < n; ++j) {
        const double next = ((2.0 * j + 1.0) * x * p - j * before) / (j + 1.0);
        before = p;
        p = next;
      }
      slope = n * (x * p - before) / (x * x - 1.0);
      x -= p / slope;
      if (std::fabs(p / slope) < 1e-15) break;
    }
    at[n - 1 - i] = 0.5 * (1.0 + x);
    weight[n - 1 - i] = 1.0 / ((1.0 - x * x) * slope * slope);
  }
}

double between_rims(const GrainPair& pair, int side, double from, double to) {  // area of the surface of a grain
  const double R = pair.radius(side);
  return 2.0 * M_PI * R * (sag(R, to) - sag(R, from));
}

// Directions across the line of centres, along axes of the coordinates where the line is.
void across(const Vector3& n, Vector3& e1, Vector3& e2) {
  int least = 0;
  for (int d = 1; d < 3; ++d)
    if (std::fabs(n[d]) < std::fabs(n[least]) - 1e-12) least = d;
  e1 = (Vector3::Unit(least) - n[least] * n).normalized();
  e2 = n.cross(e1);
}

struct Column {
  Vector3 end[2];
  Vector3 middle() const { return 0.5 * (end[0] + end[1]); }
};

// Columns at the radius r, which stand for those between two radii. area: of their cross-sections together, up to a factor of all rings.
struct Ring {
  double r, inside, outside, area;
  int sectors;
};

class FilmFiller {
 public:
  explicit FilmFiller(const GrainPair& pair) : pair_(pair) { across(pair.n, e1_, e2_); }

  Column column(double r, double angle) const {
    const Vector3 out = r * (std::cos(angle) * e1_ + std::sin(angle) * e2_);
    const double middle = 0.5 * (sag(pair_.R2, r) - sag(pair_.R1, r)), half = 0.5 * pair_.thickness(r);
    return {{out + (middle - half) * pair_.n, out + (middle + half) * pair_.n}};
  }

  // Share of the shape in a sector of a ring between these radii.
  double share_of_sector(const std::vector<Neighbour>& neighbours, const Ring& ring, double angle) const {
    constexpr int kAlong = 2, kAround = 4, kUp = 3;
    double sum = 0.0;
    for (int i = 0; i < kAlong; ++i)
      for (int j = 0; j < kAround; ++j) {
        const Column c = column(ring.inside + (ring.outside - ring.inside) * (i + 0.5) / kAlong,
                                angle + 2.0 * M_PI / ring.sectors * ((j + 0.5) / kAround - 0.5));
        for (int k = 0; k < kUp; ++k) sum += share_at(neighbours, c.end[0] + (k + 0.5) / kUp * (c.end[1] - c.end[0]));
      }
    return sum / (kAlong * kAround * kUp);
  }

 private:
  const GrainPair& pair_;
  Vector3 e1_, e2_;
};

}  // namespace

FilmFill film_fill(const Shape& shape, double spacing) {
  FilmFill film;
  const GrainPair& pair = shape.pair();
  const double cell = kCellOfPoints * spacing, smaller = std::min(pair.R1, pair.R2);
  film.from = film.to = shape.inner();
  if (!(pair.thickness(film.from) < (1.0 - kNoFilm) * cell))
    return film;  // near the line of centres a rounding error e of the thickness would make a film of the radius sqrt(e R)
  const double thin = pair.radius_of_thickness(cell);
  std::ostringstream why;
  const double rim = shape.spans() - thin;
  film.all = rim < cell;
  if (film.all && !shape.ends_where_it_spans())
    why << "spacing " << spacing << " leaves a rim of " << std::max(rim, 0.0)
        << " where the grains are two spacings apart, less than a cell of two points, and this shape (" << shape.describe()
        << ") cannot be film as a whole; use a smaller spacing, or 'film grid'";
  else if (!(pair.thickness(film.from) >= kThinnest * smaller))
    why << "inner radius " << film.from << ": the grains are " << std::max(pair.thickness(film.from), 0.0)
        << " apart there, and the stiffness of a film between rigid grains grows without bound where they come together; use a larger "
           "'inner', where they are at least "
        << kThinnest * smaller << " apart (a radius of " << pair.radius_of_thickness(kThinnest * smaller) << "), or 'film grid'";
  if (!why.str().empty()) throw ShapeError(why.str());
  film.to = film.all ? Flat::outer_for_volume(pair, shape.volume(), film.from) : thin;
  film.volume = film.all ? shape.volume() : pair.volume_within(film.to) - pair.volume_within(film.from);
  for (int s = 0; s < 2; ++s) film.area[s] = film.all ? shape.attached_area(s) : between_rims(pair, s, film.from, film.to);
  return film;
}

namespace {

// Heights of the surfaces rise by r/c, so dA = 2 pi r dr = 2 pi t/(1/c0 + 1/c1) d ln t.
std::vector<Ring> rings_of_film(const GrainPair& pair, const FilmFill& film) {
  const double low = std::log(pair.thickness(film.from)), high = std::log(pair.thickness(film.to));
  const int count = std::clamp(static_cast<int>(std::ceil(kRingsOfRatio * (high - low))), kLeastRings, kMostRings);
  std::vector<double> at, weight;
  gauss_rule(count, at, weight);
  const auto radius_at = [&](double share) {
    return share <= 0.0 ? film.from : share >= 1.0 ? film.to : pair.radius_of_thickness(std::exp(low + share * (high - low)));
  };
  std::vector<Ring> rings;
  double passed = 0.0;
  for (int i = 0; i < count; ++i) {
    Ring ring{radius_at(at[i]), radius_at(passed), radius_at(passed + weight[i]), 0.0, kSectors};
    passed += weight[i];
    double slopes = 0.0;
    for (int s = 0; s < 2; ++s) slopes += 1.0 / std::sqrt((pair.radius(s) - ring.r) * (pair.radius(s) + ring.r));
    ring.area = 2.0 * M_PI * pair.thickness(ring.r) / slopes * weight[i];
    rings.push_back(ring);
  }
  return rings;
}

std::vector<Ring> rings_of_seam(const FilmFill& film, double spacing) {
  const double width = film.to - film.from;
  const int count = std::max(kLeastRingsOfSeam, static_cast<int>(std::ceil(width / spacing)));
  std::vector<double> at, weight;
  gauss_rule(count, at, weight);
  std::vector<Ring> rings;
  double passed = 0.0;
  for (int i = 0; i < count; ++i) {
    const double r = film.from + width * at[i], inside = film.from + width * passed;
    passed += weight[i];
    const int sectors = 8 * std::max(1, static_cast<int>(std::ceil(2.0 * M_PI * r / (8.0 * spacing))));
    rings.push_back({r, inside, film.from + width * passed, 2.0 * M_PI * r * weight[i], sectors});
  }
  return rings;
}

std::vector<FillPoint> fill_rings(const GrainPair& pair, const FilmFill& film, const std::vector<Ring>& rings, bool of_film,
                                  const std::vector<Neighbour>& neighbours) {
  std::vector<FillPoint> points;
  const FilmFiller filler(pair);
  double volume = 0.0, area[2] = {0.0, 0.0};
  for (const Ring& ring : rings) {
    double c[2];
    for (int s = 0; s < 2; ++s) c[s] = std::sqrt((pair.radius(s) - ring.r) * (pair.radius(s) + ring.r));
    const double across_line = ring.area / ring.sectors;
    for (int j = 0; j < ring.sectors; ++j) {
      const double angle = 2.0 * M_PI * (j + 0.5) / ring.sectors;
      const Column column = filler.column(ring.r, angle);
      const double share = neighbours.empty() ? 1.0 : filler.share_of_sector(neighbours, ring, angle);
      const double of_column = across_line * pair.thickness(ring.r);
      FillPoint::Attachment ends[2];
      for (int s = 0; s < 2; ++s) {
        ends[s].side = s;
        ends[s].foot = column.end[s];
        ends[s].area = across_line * pair.radius(s) / c[s];
        area[s] += ends[s].area;
        ends[s].area *= share;
      }
      volume += of_column;
      if (share == 0.0) continue;
      FillPoint p;
      if (of_film) {
        p.film = true;
        p.X = column.middle();
        p.volume = share * of_column;
        p.link_count = 2;
        std::copy(ends, ends + 2, p.link);
        points.push_back(p);
        continue;
      }
      p.volume = 0.5 * share * of_column;
      p.link_count = 1;
      for (int s = 0; s < 2; ++s) {
        p.X = 0.5 * (column.middle() + column.end[s]);
        p.link[0] = ends[s];
        points.push_back(p);
      }
    }
  }
  for (FillPoint& p : points) {
    p.volume *= film.volume / volume;
    for (auto& k : p.link) k.area *= film.area[k.side] / area[k.side];
  }
  return points;
}

}  // namespace

std::vector<FillPoint> fill_film(const GrainPair& pair, const FilmFill& film, const std::vector<Neighbour>& neighbours) {
  if (film.empty()) return {};
  return fill_rings(pair, film, rings_of_film(pair, film), true, neighbours);
}

bool is_seam(const Shape& shape, double spacing) {
  return shape.ends_where_it_spans() && shape.largest_thickness() < kCellOfPoints * spacing;
}

std::vector<FillPoint> fill_seam(const Shape& shape, double spacing, const std::vector<Neighbour>& neighbours) {
  FilmFill seam;
  seam.all = true;
  seam.from = shape.inner();
  seam.to = Flat::outer_for_volume(shape.pair(), shape.volume(), seam.from);
  seam.volume = shape.volume();
  for (int s = 0; s < 2; ++s) seam.area[s] = shape.attached_area(s);
  return fill_rings(shape.pair(), seam, rings_of_seam(seam, spacing), false, neighbours);
}

}  // namespace mpdem
