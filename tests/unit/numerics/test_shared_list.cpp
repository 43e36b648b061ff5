// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Lists that are held together: one copy of equal ones, and changes that nobody else sees.
#include "numerics/shared_list.h"

#include <gtest/gtest.h>

#include "numerics/short_list.h"

namespace mpdem {
namespace {

TEST(SharedList, EqualListsAreHeldOnce) {
  AlikeLists alike;
  SharedList<int> a(std::vector<int>{1, 2, 3}), b(std::vector<int>{1, 2, 3}), other(std::vector<int>{1, 2, 4});
  const std::size_t alone = a.memory_usage();
  EXPECT_EQ(alone, 3 * sizeof(int));
  for (SharedList<int>* l : {&a, &b, &other}) alike.share(*l);
  EXPECT_EQ(a.data(), b.data());
  EXPECT_NE(a.data(), other.data());
  EXPECT_EQ(a.memory_usage() + b.memory_usage(), alone);
  EXPECT_EQ(other.memory_usage(), alone);
}

TEST(SharedList, ChangesAreOfOneHolderAlone) {
  AlikeLists alike;
  SharedList<double> a(std::vector<double>{1.0, 2.0}), b(a), c(std::vector<double>{1.0, 2.0});
  for (SharedList<double>* l : {&a, &b, &c}) alike.share(*l);
  b.own()[1] = 5.0;
  EXPECT_EQ(a[1], 2.0);
  EXPECT_EQ(c[1], 2.0);
  EXPECT_EQ(b[1], 5.0);
  EXPECT_EQ(a.data(), c.data());
  // A list that changed after it was shared is not taken for what it was.
  SharedList<double> d(std::vector<double>{7.0}), e(std::vector<double>{7.0});
  alike.share(d);
  d.own()[0] = 8.0;
  alike.share(e);
  EXPECT_EQ(d[0], 8.0);
  EXPECT_EQ(e[0], 7.0);
}

TEST(SharedList, BytesAloneDoNotMakeListsEqual) {
  AlikeLists alike;
  SharedList<int> a(std::vector<int>{0, 0});
  SharedList<double> b(std::vector<double>{0.0});
  SharedList<int> empty, none;
  alike.share(a);
  alike.share(b);
  alike.share(empty);
  EXPECT_EQ(a.size(), 2u);
  EXPECT_EQ(b.size(), 1u);
  EXPECT_TRUE(empty.empty());
  EXPECT_EQ(empty.begin(), empty.end());
  none.own().push_back(4);
  EXPECT_EQ(none[0], 4);
}

// The last holder of a list takes it away. Many lists that came and went leave nothing behind.
TEST(SharedList, ListsThatAreGoneAreForgotten) {
  AlikeLists alike;
  SharedList<int> kept(std::vector<int>{-1, -2});
  alike.share(kept);
  for (int i = 0; i < 5000; ++i) {
    SharedList<int> passing(std::vector<int>{i, i + 1});
    alike.share(passing);
    EXPECT_EQ(passing.memory_usage(), 2 * sizeof(int));
  }
  EXPECT_LT(alike.size(), 2000u);
  SharedList<int> again(std::vector<int>{-1, -2});
  alike.share(again);
  EXPECT_EQ(again.data(), kept.data());
}

TEST(SharedList, ShortListsOfEitherWidth) {
  AlikeLists alike;
  ShortList a, b;
  for (int v : {3, 4, 5}) {
    a.push_back(v);
    b.push_back(v);
  }
  const std::size_t alone = a.memory_usage();
  a.shrink_to_fit();
  b.shrink_to_fit();
  a.share(alike);
  b.share(alike);
  EXPECT_LT(a.memory_usage() + b.memory_usage(), 2 * alone);
  b.renumber({0, 1, 2, 3, 100000, 5});
  EXPECT_EQ(a[1], 4);
  EXPECT_EQ(b[1], 100000);
  EXPECT_EQ(b[2], 5);
}

}  // namespace
}  // namespace mpdem
