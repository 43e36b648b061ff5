// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "geometry/film_fill.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/coating.h"
#include "geometry/flat.h"
#include "geometry/meniscus.h"

namespace mpdem {
namespace {

constexpr double kRadius = 5e-3;
const Vector3 kAlong(0, 0, 1);

GrainPair touching(double R2 = kRadius, double gap = 0.0) { return {kRadius, R2, gap, kAlong}; }

struct Sums {
  double volume = 0, over_t = 0, area[2] = {0, 0};
};
Sums sums(const std::vector<FillPoint>& points) {
  Sums s;
  for (const FillPoint& p : points) {
    const double t = (p.link[1].foot - p.link[0].foot).norm();
    s.volume += p.volume;
    s.over_t += p.volume / (t * t);
    for (const auto& k : p.link) s.area[k.side] += k.area;
  }
  return s;
}

// Integral of 2 pi r/t between equal touching spheres, t = 2 (R - sqrt(R^2 - r^2)).
double sum_of_a_over_t(double from, double to) {
  const double a = std::sqrt(kRadius * kRadius - from * from), b = std::sqrt(kRadius * kRadius - to * to);
  return M_PI * (kRadius * std::log((kRadius - b) / (kRadius - a)) - (a - b));
}

// Where the gap is two spacings rounding may have it less, and radii there have the root of that.
TEST(FilmFill, CementAsThickAsACellIsNoFilm) {
  for (const double spacing : {2e-4, 1.7e-4, 1e-4 / 3})
    for (const double rounded : {1.0 - 4e-16, 1.0, 1.0 + 4e-16})
      EXPECT_TRUE(film_fill(Flat(touching(kRadius, 2.0 * spacing * rounded), 1.5e-3, 0.0), spacing).empty());
}

TEST(FilmFill, InnerRadiusScalesWithTheGrainsAndNotWithTheSpacing) {
  EXPECT_DOUBLE_EQ(touching().usual_inner(), 0.2 * kRadius);
  EXPECT_DOUBLE_EQ(touching(2 * kRadius).usual_inner(), 0.2 * kRadius);
  const GrainPair apart = touching(kRadius, 1e-5), wide = touching(kRadius, 0.05 * kRadius), pressed = touching(kRadius, -1e-4);
  const double thickness = touching().thickness(0.2 * kRadius);
  EXPECT_NEAR(apart.thickness(apart.usual_inner()), thickness, 1e-12 * kRadius);
  EXPECT_LT(apart.usual_inner(), 0.2 * kRadius);
  EXPECT_EQ(wide.usual_inner(), 0.0);
  EXPECT_NEAR(pressed.thickness(pressed.usual_inner()), thickness, 1e-12 * kRadius);
  EXPECT_GT(pressed.usual_inner(), pressed.contact_radius());
}

TEST(FilmFill, FilmEndsWhereACellFits) {
  const Flat flat(touching(), 3e-3, 1e-3);
  const FilmFill film = film_fill(flat, 2e-4);
  EXPECT_FALSE(film.all);
  EXPECT_NEAR(flat.pair().thickness(film.to), 4e-4, 1e-15);
  EXPECT_TRUE(film_fill(flat, 1e-4).empty());  // 0.202 mm at 1 mm
  const FilmFill all = film_fill(Flat(touching(), 1.6e-3, 1e-3), 2e-4);
  EXPECT_TRUE(all.all);
  EXPECT_NEAR(all.to, 1.6e-3, 1e-12);
}

TEST(FilmFill, SumsAreThoseOfVolumeAreaAndStiffness) {
  const Flat flat(touching(), 1.6e-3, 1e-3);
  const Sums s = sums(fill_film(flat.pair(), film_fill(flat, 2e-4)));
  EXPECT_NEAR(s.volume / flat.volume(), 1.0, 1e-12);
  for (int g = 0; g < 2; ++g) EXPECT_NEAR(s.area[g] / flat.attached_area(g), 1.0, 1e-12);
  EXPECT_NEAR(s.over_t / sum_of_a_over_t(1e-3, 1.6e-3), 1.0, 3e-7);
  const Flat wide(touching(), 3e-3, 1e-3);
  const FilmFill part = film_fill(wide, 3.5e-4);
  EXPECT_NEAR(sums(fill_film(wide.pair(), part)).over_t / sum_of_a_over_t(1e-3, part.to), 1.0, 3e-7);
}

TEST(FilmFill, ColumnsDoNotDependOnTheSpacingWhereAllIsFilm) {
  const Meniscus meniscus(touching(), 0.25, 0.3, 1e-3);
  const FilmFill one = film_fill(meniscus, 2e-4), other = film_fill(meniscus, 1.5e-4);
  ASSERT_TRUE(one.all && other.all);
  const std::vector<FillPoint> a = fill_film(meniscus.pair(), one), b = fill_film(meniscus.pair(), other);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t n = 0; n < a.size(); ++n) {
    EXPECT_EQ(a[n].X, b[n].X);
    EXPECT_EQ(a[n].volume, b[n].volume);
  }
  const Sums s = sums(a);
  EXPECT_NEAR(s.volume / meniscus.volume(), 1.0, 1e-12);
  for (int g = 0; g < 2; ++g) EXPECT_NEAR(s.area[g] / meniscus.attached_area(g), 1.0, 1e-12);
}

TEST(FilmFill, FilmAndCellsTogetherAreTheShape) {
  const Meniscus meniscus(touching(3.5e-3), 0.6, 0.3, 7e-4);
  const FilmFill film = film_fill(meniscus, 1e-4);
  ASSERT_FALSE(film.all || film.empty());
  const std::unique_ptr<Shape> cells = meniscus.with_inner(film.to);
  EXPECT_NEAR((film.volume + cells->volume()) / meniscus.volume(), 1.0, 1e-12);
  for (int s = 0; s < 2; ++s) EXPECT_NEAR((film.area[s] + cells->attached_area(s)) / meniscus.attached_area(s), 1.0, 1e-12);
}

TEST(FilmFill, SeamHasOnePointAtEitherGrain) {
  const Flat flat(touching(3.5e-3), 5e-4, 0.0);  // from the contact on
  const double spacing = 1e-4;
  ASSERT_TRUE(is_seam(flat, spacing));
  EXPECT_FALSE(is_seam(flat, 2e-5));
  const std::vector<FillPoint> points = fill_seam(flat, spacing);
  double volume = 0.0, area[2] = {0.0, 0.0}, square = 0.0;
  Vector3 moment = Vector3::Zero();
  for (const FillPoint& p : points) {
    ASSERT_EQ(p.link_count, 1);
    EXPECT_FALSE(p.film);
    EXPECT_TRUE(flat.inside(p.X));
    EXPECT_GT(p.volume, 0.0);
    const int side = p.link[0].side;
    EXPECT_NEAR((p.link[0].foot - flat.pair().centre(side)).norm() / flat.pair().radius(side), 1.0, 1e-12);
    EXPECT_LT((p.link[0].foot - p.X).norm(), 0.3 * flat.largest_thickness());
    volume += p.volume;
    area[side] += p.link[0].area;
    moment += p.volume * Vector3(p.X[0], p.X[1], 0.0);
    square += p.volume * (p.X[0] * p.X[0] + p.X[1] * p.X[1]);
    double nearest = 1.0;
    for (const FillPoint& q : points)
      if (&q != &p && q.link[0].side == side) nearest = std::min(nearest, (q.link[0].foot - p.link[0].foot).norm());
    EXPECT_LT(nearest, 1.2 * spacing);
  }
  EXPECT_NEAR(volume / flat.volume(), 1.0, 1e-12);
  for (int s = 0; s < 2; ++s) EXPECT_NEAR(area[s] / flat.attached_area(s), 1.0, 1e-12);
  EXPECT_LT(moment.norm() / volume, 1e-12 * kRadius);
  // between paraboloids t goes with r^2, so the mean of r^2 over the volume is two thirds of the square of the outer radius
  EXPECT_NEAR(square / volume / (2.0 / 3.0 * 5e-4 * 5e-4), 1.0, 0.01);
}

TEST(FilmFill, NeighboursTakeTheirShareOfASeam) {
  const Flat flat(touching(), 5e-4, 1e-4);
  const std::vector<Neighbour> neighbours = {{&flat, Vector3(1e-6, 0, 0)}};
  double volume = 0.0;
  for (const FillPoint& p : fill_seam(flat, 1e-4, neighbours)) {
    volume += p.volume;
    EXPECT_LT(p.X[0], 1e-4);
  }
  EXPECT_NEAR(volume / flat.volume(), 0.5, 0.01);
}

TEST(FilmFill, NeighboursTakeTheirShare) {
  // the same bond again, a little beside: each keeps the half that is nearer to its own middle
  const Flat flat(touching(), 1.6e-3, 1e-3);
  const FilmFill film = film_fill(flat, 2e-4);
  const std::vector<Neighbour> neighbours = {{&flat, Vector3(1e-6, 0, 0)}};
  const Sums rest = sums(fill_film(flat.pair(), film, neighbours));
  const double kept = rest.volume / flat.volume();
  EXPECT_GT(kept, 0.45);
  EXPECT_LT(kept, 0.55);
  for (int s = 0; s < 2; ++s) EXPECT_NEAR(rest.area[s] / flat.attached_area(s), kept, 1e-3);  // by halves of rings
}

// A neighbour farther away takes from what is nearer to its middle, of the outer rings alone. It is thinner there than this bond.
TEST(FilmFill, NeighboursTakeWhatIsNearerToThem) {
  const Flat flat(touching(), 1.6e-3, 1e-3);
  const FilmFill film = film_fill(flat, 2e-4);
  const double between = 1.3e-3;
  const std::vector<FillPoint> all = fill_film(flat.pair(), film),
                               rest = fill_film(flat.pair(), film, {{&flat, Vector3(2.0 * between, 0, 0)}});
  ASSERT_EQ(rest.size(), all.size());
  int taken = 0;
  for (std::size_t n = 0; n < all.size(); ++n) {
    const double kept = rest[n].volume / all[n].volume;
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(rest[n].link[k].area / all[n].link[k].area, kept, 1e-12);
    if (all[n].X[0] < 0.8 * between) {
      EXPECT_EQ(kept, 1.0) << all[n].X.transpose();
    }
    if (all[n].X[0] < 1.1 * between) continue;
    EXPECT_LT(kept, 0.8) << all[n].X.transpose();
    ++taken;
  }
  EXPECT_GE(taken, 2);
}

// Foot points are on the grains, along the line of centres from each other. Faces have the area that is seen as the cross-section.
TEST(FilmFill, ColumnsReachFromGrainToGrain) {
  const Flat flat(touching(2.5 * kRadius, 2e-5), 1.6e-3, 1e-3);
  for (const FillPoint& p : fill_film(flat.pair(), film_fill(flat, 2e-4))) {
    const Vector3 along = p.link[1].foot - p.link[0].foot;
    EXPECT_NEAR(along.cross(kAlong).norm(), 0.0, 1e-15);
    EXPECT_NEAR((p.link[0].foot + p.link[1].foot - 2.0 * p.X).norm(), 0.0, 1e-15);
    for (const auto& k : p.link) {
      const Vector3 normal = (k.foot - flat.pair().centre(k.side)) / flat.pair().radius(k.side);
      EXPECT_NEAR(normal.norm(), 1.0, 1e-12);
      EXPECT_NEAR(k.area * std::fabs(normal.dot(kAlong)) * along.norm() / p.volume, 1.0, 1e-6);
    }
  }
}

TEST(FilmFill, RefusesWhatCannotBeFilm) {
  EXPECT_THROW(film_fill(Coating(touching(), 3e-4, M_PI, 1e-3), 4e-4), ShapeError);  // its shells go on
  EXPECT_THROW(film_fill(Flat(touching(), 1.6e-3, 1e-5), 2e-4), ShapeError);         // no bound of the stiffness
}

}  // namespace
}  // namespace mpdem
