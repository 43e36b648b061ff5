// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "numerics/short_list.h"

#include <gtest/gtest.h>

#include <vector>

namespace mpdem {
namespace {

std::vector<int> all(const ShortList& list) {
  std::vector<int> values;
  list.with([&](const auto* v) { values.assign(v, v + list.size()); });
  for (std::size_t i = 0; i < list.size(); ++i) EXPECT_EQ(list[i], values[i]);
  return values;
}

// Two bytes for each while they fit, four from the first that does not.
TEST(ShortList, WidensForWhatDoesNotFit) {
  ShortList list;
  EXPECT_TRUE(list.empty());
  for (int v : {0, 7, 65535}) list.push_back(v);
  list.shrink_to_fit();
  EXPECT_EQ(all(list), (std::vector<int>{0, 7, 65535}));
  EXPECT_EQ(list.memory_usage(), 6u);
  list.push_back(65536);
  list.push_back(3);
  list.shrink_to_fit();
  EXPECT_EQ(all(list), (std::vector<int>{0, 7, 65535, 65536, 3}));
  EXPECT_EQ(list.memory_usage(), 20u);
}

TEST(ShortList, WidensWhereAValueIsSet) {
  ShortList list;
  for (int v : {1, 2, 3}) list.push_back(v);
  list.set(0, 9);
  EXPECT_EQ(all(list), (std::vector<int>{9, 2, 3}));
  list.set(1, 100000);
  EXPECT_EQ(all(list), (std::vector<int>{9, 100000, 3}));
  list.set(1, 4);
  EXPECT_EQ(all(list), (std::vector<int>{9, 4, 3}));
  list.resize(4);
  EXPECT_EQ(all(list), (std::vector<int>{9, 4, 3, 0}));
}

// The first of all does not fit.
TEST(ShortList, BeginsWide) {
  ShortList list;
  list.push_back(70000);
  list.push_back(1);
  EXPECT_EQ(all(list), (std::vector<int>{70000, 1}));
}

}  // namespace
}  // namespace mpdem
