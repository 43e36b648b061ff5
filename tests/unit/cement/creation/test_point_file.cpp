// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Points of a file: what a row without areas is attached to, damage by components and by principal values, complaints.
#include "cement/creation/point_file.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mpdem {
namespace {

constexpr double kRadius = 5e-3, kGap = 4e-4, kSpacing = 2e-4;
const GrainPair kPair{kRadius, kRadius, kGap, Vector3(0, 0, 1)};

PointCloud read(const std::string& text) {
  PointFileOptions o;
  o.tag[0] = 3;
  o.tag[1] = 7;
  o.spacing = kSpacing;
  return read_points(text, "cement.txt", kPair, o);
}

std::string complaint(const std::string& text) {
  try {
    read(text);
  } catch (const ShapeError& e) {
    return e.what();
  }
  return "";
}

// Two points on the axis of the bond, each half a spacing from a grain.
const char* const kTwo = "# of a scan\nz x y volume\n-1e-4 0 0 8e-12  # near the first\n\n1e-4 0 0 8e-12\n";

TEST(PointFile, PointsNearASurfaceAreAttachedByTheShell) {
  const PointCloud c = read(kTwo);
  ASSERT_EQ(c.points.size(), 2u);
  EXPECT_NEAR(c.volume, 1.6e-11, 1e-24);
  for (int s = 0; s < 2; ++s) {
    const FillPoint& p = c.points[s];
    ASSERT_EQ(p.link_count, 1);
    EXPECT_EQ(p.link[0].side, s);
    const double r = kRadius + 0.5 * kSpacing;
    EXPECT_NEAR(p.link[0].area / (8e-12 * kRadius * kRadius / (r * r * kSpacing)), 1.0, 1e-12);
    EXPECT_NEAR((p.link[0].foot - kPair.centre(s)).norm(), kRadius, 1e-15);
    EXPECT_NEAR(c.attached_area[s], p.link[0].area, 1e-20);
  }
}

// The same tensor by components and by principal values: 0.4 and 0.1 across, rotated by 30 degrees about y.
TEST(PointFile, DamageByPrincipalValuesIsThatByComponents) {
  const double c = std::cos(M_PI / 6), s = std::sin(M_PI / 6);
  char principal[400], tensor[400];
  std::snprintf(
      principal, sizeof principal,
      "x y z volume d1 d2 d3 v1x v1y v1z v2x v2y v2z\n0 0 1e-4 8e-12 0.4 0.1 0 %.17g 0 %.17g 0 1 0\n0 0 -1e-4 8e-12 0 0 0 1 0 0 0 1 0\n", s,
      c);
  std::snprintf(tensor, sizeof tensor,
                "x y z volume dxx dyy dzz dyz dxz dxy\n0 0 1e-4 8e-12 %.17g 0.1 %.17g 0 %.17g 0\n0 0 -1e-4 8e-12 0 0 0 0 0 0\n",
                0.4 * s * s, 0.4 * c * c, 0.4 * s * c);
  const PointCloud a = read(principal), b = read(tensor);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(a.points[0].damage[k], b.points[0].damage[k], 1e-15) << k;
  EXPECT_NEAR(a.points[0].damage[4], 0.4 * s * c, 1e-15);
}

TEST(PointFile, LinesOfOtherPairsAreLeftOutAndTold) {
  const PointCloud c = read("grain_i grain_j x y z volume\n3 7 0 0 1e-4 8e-12\n3 7 0 0 -1e-4 8e-12\n3 9 0 0 3e-4 8e-12\n");
  EXPECT_EQ(c.points.size(), 2u);
  EXPECT_EQ(c.other_grains.count(9), 1u);
}

TEST(PointFile, ComplaintsNameFileLineAndColumn) {
  const struct {
    const char *text, *part;
  } cases[] = {
      {"x y z volum\n", "unknown column 'volum'"},
      {"x y volume\n", "column 'z' is missing"},
      {"x y z volume x\n", "column 'x' is named twice"},
      {"x,y,z,volume\n", "has commas"},
      {"x y z volume\n0 0 1e-4\n", "3 numbers, but 4 columns"},
      {"x y z volume\n0 0 1e-4 nan\n", "finite number"},
      {"x y z volume\n0 0 1e-4 8e-12 # ok\n0 0 one 8e-12\n", "'one' in column 'z' is not a number"},
      {"x y z volume failed\n0 0 1e-4 8e-12 2\n", "must be 0 or 1"},
      {"x y z volume dxx dyy dzz dyz dxz dxy\n0 0 1e-4 8e-12 1.2 0 0 0 0 0\n", "eigenvalues"},
      {"x y z volume foot_ix foot_iy foot_iz\n", "column"},
  };
  for (const auto& c : cases) {
    const std::string told = complaint(c.text);
    EXPECT_NE(told.find(c.part), std::string::npos) << c.text << told;
    EXPECT_NE(told.find("cement.txt"), std::string::npos) << told;
  }
  EXPECT_NE(complaint("x y z volume\n0 0 1e-4 8e-12\n0 0 one 8e-12\n").find("3"), std::string::npos);
}

}  // namespace
}  // namespace mpdem
