// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A column of cells along z that tests of cracks cut. The first grain is below, the second above.
#ifndef MPDEM_TEST_CRACK_COLUMN_H
#define MPDEM_TEST_CRACK_COLUMN_H

#include <utility>
#include <vector>

#include "lanes.h"
#include "fracture/neighbours.h"

namespace mpdem::test {

constexpr int kWidth = 8, kHeight = 10;
constexpr double kLinkArea = 0.9;
const double kFace[3] = {0.0, 0.0, 1.0};

inline std::vector<CrackPoint> column(int width = kWidth, int height = kHeight) {
  std::vector<CrackPoint> all;
  int tag = 1;
  for (int k = 0; k < height; ++k)
    for (int j = 0; j < width; ++j)
      for (int i = 0; i < width; ++i) {
        CrackPoint p{};
        p.tag = tag++;
        p.cell[0] = i - width / 2;
        p.cell[1] = j - width / 2;
        p.cell[2] = k - height / 2;
        p.attached[0] = k == 0;
        p.attached[1] = k == height - 1;
        for (int s = 0; s < 2; ++s) p.link_area[s] = p.attached[s] ? kLinkArea : 0.0;
        p.nearer = k >= height / 2;
        p.above[0] = k + 0.5f;
        p.above[1] = height - k - 0.5f;
        all.push_back(p);
      }
  return all;
}

inline void fail(CrackPoint& p) {
  p.failed = true;
  p.attached[0] = p.attached[1] = false;
}

// Makes residue of a point: it has failed, but its link is intact.
inline void make_residue(CrackPoint& p) { p.failed = true; }

// A bond with the first and the second grain swapped.
inline std::vector<CrackPoint> swapped(std::vector<CrackPoint> points) {
  for (CrackPoint& p : points) {
    std::swap(p.attached[0], p.attached[1]);
    std::swap(p.link_area[0], p.link_area[1]);
    std::swap(p.link_damage[0], p.link_damage[1]);
    std::swap(p.above[0], p.above[1]);
    p.nearer = 1 - p.nearer;
  }
  return points;
}

inline int level(const CrackPoint& p, int height = kHeight) { return p.cell[2] + height / 2; }

// Sets failed points, debonded points and damage of this many values at random. Sets layers (kind 1), or empty space
// in half of the cells (kind 2).
inline void make_random(std::vector<CrackPoint>& points, Random& random, double share, int values, int kind) {
  for (CrackPoint& p : points) {
    p.damage = static_cast<float>(0.9 * random.index(values) / values);
    if (random.uniform(0.0, 1.0) < share) fail(p);
    for (bool& a : p.attached) a = a && random.index(3) > 0;
    if (kind == 1) p.layer = p.cell[0] < 0 ? 0 : 2;
    for (float& s : p.space) s = kind == 2 && random.index(2) > 0 ? 0.2f : 0.0f;
  }
}

}  // namespace mpdem::test

#endif
