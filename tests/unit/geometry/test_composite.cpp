// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "geometry/composite.h"

#include "bodies.h"
#include "geometry/coating.h"
#include "geometry/flat.h"
#include "geometry/lattice_fill.h"
#include "geometry/meniscus.h"

namespace mpdem {
namespace {

using test::Vector;

template <class... S>
Composite join(const S&... shapes) {
  std::vector<std::unique_ptr<Shape>> parts;
  (parts.push_back(std::make_unique<S>(shapes)), ...);
  return Composite(std::move(parts));
}

struct Parts {
  GrainPair pair;
  Meniscus meniscus;
  Coating coating;
  Flat flat;
};
std::vector<Parts> all_parts() {
  std::vector<Parts> all;
  for (const GrainPair& p : test::pairs())
    for (double inner : {0.0, 2e-4})
      all.push_back({p, Meniscus(p, 0.6, 0.1, inner), Coating(p, 2e-4, M_PI, inner), Flat(p, 1.6e-3, inner)});
  return all;
}

TEST(Composite, OfOneShapeIsThatShape) {
  test::Worst worst;
  for (const Parts& s : all_parts()) {
    worst.add(std::fabs(join(s.meniscus).volume() / s.meniscus.volume() - 1.0), "meniscus " + test::name_of(s.pair));
    worst.add(std::fabs(join(s.coating).volume() / s.coating.volume() - 1.0), "coating " + test::name_of(s.pair));
    worst.add(std::fabs(join(s.flat).volume() / s.flat.volume() - 1.0), "flat " + test::name_of(s.pair));
  }
  expect_within(worst, 1e-12, "volume");
}

TEST(Composite, InsideIsInsideAnyPart) {
  test::Random random(171);
  for (const Parts& s : all_parts()) {
    const Composite c = join(s.coating, s.meniscus);
    int wrong = 0, inside = 0;
    for (int i = 0; i < 3000; ++i) {
      const double z = random.uniform(-1.5e-3, 1.5e-3), r = random.uniform(0, 4e-3);
      const Vector x = test::place(s.pair, z, r, random.uniform(0, 6.3));
      const bool expected = s.coating.inside(x) || s.meniscus.inside(x);
      inside += expected;
      wrong += c.inside(x) != expected;
    }
    EXPECT_GT(inside, 100);
    EXPECT_EQ(wrong, 0) << test::name_of(s.pair);
    test::expect_consistent(c, random, 1000);
  }
}

TEST(Composite, VolumeAgainstQuadrature) {
  test::Worst worst;
  for (const Parts& s : all_parts()) {
    const Composite c = join(s.coating, s.meniscus);
    // corners: where the outlines of the parts end and where they cross
    std::vector<double> breaks{s.meniscus.lowest(), s.meniscus.highest()};
    const double t = s.coating.thickness();
    for (int i = 0; i < 2; ++i)
      for (double offset : {-(s.pair.radius(i) + t), s.pair.radius(i) + t}) breaks.push_back(s.pair.height(i) + offset);
    const auto difference = [&](double z) { return s.coating.top(z) - s.meniscus.top(z); };
    constexpr int kScan = 20000;
    const double lo = s.meniscus.lowest(), step = (s.meniscus.highest() - lo) / kScan;
    for (int i = 0; i < kScan; ++i) {
      double a = lo + i * step, b = a + step;
      if ((difference(a) > 0.0) == (difference(b) > 0.0)) continue;
      for (int k = 0; k < 60; ++k) {
        const double m = 0.5 * (a + b);
        ((difference(m) > 0.0) == (difference(a) > 0.0) ? a : b) = m;
      }
      breaks.push_back(0.5 * (a + b));
    }
    const double V = test::volume_of_revolution(c, breaks);
    worst.add(std::fabs(c.volume() / V - 1.0), test::name_of(s.pair));
    EXPECT_GT(c.volume(), std::max(s.coating.volume(), s.meniscus.volume()));
    EXPECT_LT(c.volume(), s.coating.volume() + s.meniscus.volume());
  }
  expect_within(worst, 1e-12, "volume");
}

// The lattice fill has to serve every shape.
TEST(Composite, LatticeFill) {
  const GrainPair p{1e-3, 0.8e-3, 2e-5, Vector(1.0, -2.0, 0.7).normalized()};
  const Composite c = join(Coating(p, 5e-5, M_PI / 3, 0.0), Meniscus(p, 0.5, 0.0, 0.0));
  double V = 0, A[2] = {0, 0};
  for (const FillPoint& q : fill_with_points(c, 2e-5)) {
    V += q.volume;
    for (int i = 0; i < q.link_count; ++i) A[q.link[i].side] += q.link[i].area;
  }
  EXPECT_NEAR(V / c.volume(), 1.0, 1e-12);
  for (int s = 0; s < 2; ++s) EXPECT_NEAR(A[s] / c.attached_area(s), 1.0, 1e-12);
}

}  // namespace
}  // namespace mpdem
