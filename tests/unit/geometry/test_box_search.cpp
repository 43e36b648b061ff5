// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "geometry/box_search.h"

#include "lanes.h"

namespace mpdem {
namespace {

using test::Vector;

std::vector<Box> random_boxes(test::Random& random, int count, double widest) {
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) {
    const Vector x(random.uniform(-3, 5), random.uniform(0, 1), random.uniform(-9, 2));
    const Vector size(random.uniform(0, widest), random.uniform(0, 0.3 * widest), random.uniform(0, widest));
    boxes.push_back(i % 17 == 3 ? Box() : Box(x, i % 13 == 5 ? x : Vector(x + size)));
  }
  return boxes;
}

// Compares the search with a test of each box.
TEST(BoxSearch, FindsWhatIsThere) {
  test::Random random(411);
  for (int count : {0, 1, 2, 30, 800})
    for (double widest : {1e-3, 0.5, 20.0}) {
      const std::vector<Box> boxes = random_boxes(random, count, widest);
      const BoxSearch search(boxes);
      int hits = 0;
      for (const Box& other : random_boxes(random, 200, 0.7)) {
        std::vector<int> expected, found;
        for (int i = 0; i < count; ++i)
          if (!boxes[i].isEmpty() && !other.isEmpty() && boxes[i].intersects(other)) expected.push_back(i);
        search.meeting(other, [&](int n) { found.push_back(n); });
        std::sort(found.begin(), found.end());
        EXPECT_EQ(found, expected);
        hits += static_cast<int>(expected.size());
      }
      for (int k = 0; k < 500; ++k) {
        Vector x(random.uniform(-4, 6), random.uniform(0, 1), random.uniform(-9, 3));
        if (count > 0 && k % 3 == 0 && !boxes[k % count].isEmpty()) x = k % 2 ? boxes[k % count].max() : boxes[k % count].min();
        std::vector<int> expected, found;
        for (int i = 0; i < count; ++i)
          if (boxes[i].contains(x)) expected.push_back(i);
        search.holding(x, [&](int n) { found.push_back(n); });
        EXPECT_EQ(found, expected);
      }
      if (count == 800 && widest > 0.1) {
        EXPECT_GT(hits, 50);
      }
    }
}

}  // namespace
}  // namespace mpdem
