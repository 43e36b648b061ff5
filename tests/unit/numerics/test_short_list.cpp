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

// Each value takes two bytes while all fit, and four from the first that does not.
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

// Values are renumbered to other places, some of which do not fit.
TEST(ShortList, WidensWhereAPlaceDoesNotFit) {
  std::vector<int> place(10);
  for (int i = 0; i < 10; ++i) place[i] = 10 * i;
  ShortList list, none;
  for (int v : {1, 2, 3}) list.push_back(v);
  list.renumber(place);
  none.renumber(place);
  EXPECT_EQ(all(list), (std::vector<int>{10, 20, 30}));
  EXPECT_TRUE(none.empty());
  place.assign(31, 4);
  place[20] = 100000;
  list.renumber(place);
  EXPECT_EQ(all(list), (std::vector<int>{4, 100000, 4}));
  place.assign(100001, 5);
  list.renumber(place);
  EXPECT_EQ(all(list), (std::vector<int>{5, 5, 5}));
  list.resize(4);
  EXPECT_EQ(all(list), (std::vector<int>{5, 5, 5, 0}));
}

TEST(ShortList, AppendsOfEitherWidthToEither) {
  ShortList narrow, wide, list;
  for (int v : {1, 2, 3}) narrow.push_back(v);
  for (int v : {70000, 1, 2}) wide.push_back(v);
  list.append(narrow, 1, 1);
  EXPECT_TRUE(list.empty());
  list.append(narrow, 1, 3);
  list.append(wide, 1, 3);
  list.shrink_to_fit();
  EXPECT_EQ(all(list), (std::vector<int>{2, 3, 1, 2}));
  EXPECT_EQ(list.memory_usage(), 8u);
  list.append(narrow, 0, 2, -1);
  EXPECT_EQ(all(list), (std::vector<int>{2, 3, 1, 2, 0, 1}));
  list.append(narrow, 0, 1, 65535);
  EXPECT_EQ(all(list), (std::vector<int>{2, 3, 1, 2, 0, 1, 65536}));
  list.append(wide, 0, 2);
  list.append(narrow, 0, 1);
  EXPECT_EQ(all(list), (std::vector<int>{2, 3, 1, 2, 0, 1, 65536, 70000, 1, 1}));
}

// The first value of all does not fit.
TEST(ShortList, BeginsWide) {
  ShortList list;
  list.push_back(70000);
  list.push_back(1);
  EXPECT_EQ(all(list), (std::vector<int>{70000, 1}));
}

}  // namespace
}  // namespace mpdem
