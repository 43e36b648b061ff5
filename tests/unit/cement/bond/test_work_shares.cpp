// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement/bond/work_shares.h"

#include <gtest/gtest.h>

#include <numeric>

#include "lanes.h"

namespace mpdem {
namespace {

// Ranks in a row along z.
std::vector<SubdomainIndex> row_of_subdomains(int ranks) {
  std::vector<SubdomainIndex> subdomains;
  for (int r = 0; r < ranks; ++r) subdomains.push_back({0, 0, r});
  return subdomains;
}

MovableBond bond(int row, int rank, double work, int low, int high) { return {row, rank, work, {0, 0, low}, {0, 0, high}}; }

TEST(WorkShares, BesideTouchesAllBricks) {
  EXPECT_TRUE(is_adjacent({1, 1, 1}, {0, 1, 2}, {1, 1, 2}));
  EXPECT_FALSE(is_adjacent({1, 1, 1}, {0, 1, 1}, {3, 1, 1}));
  EXPECT_FALSE(is_adjacent({0, 0, 0}, {0, 0, 2}, {0, 0, 2}));
  EXPECT_FALSE(is_adjacent({0, 3, 0}, {0, 1, 0}, {0, 1, 0}));
}

TEST(WorkShares, EvenWorkStays) {
  EXPECT_DOUBLE_EQ(load_imbalance({3.0, 5.0}), 1.25);
  EXPECT_DOUBLE_EQ(load_imbalance({0.0, 0.0}), 1.0);
  EXPECT_TRUE(rebalance(row_of_subdomains(2), {bond(0, 1, 5.0, 1, 1)}, {100.0, 105.0}).empty());
}

TEST(WorkShares, HalfOfTheBondsGo) {
  std::vector<MovableBond> bonds;
  for (int n = 0; n < 10; ++n) bonds.push_back(bond(n, 0, 1.0, 0, 0));
  const std::vector<BondMove> moves = rebalance(row_of_subdomains(2), bonds, {10.0, 0.0});
  ASSERT_EQ(moves.size(), 5u);
  for (int n = 0; n < 5; ++n) {
    EXPECT_EQ(moves[n].row, n);
    EXPECT_EQ(moves[n].rank, 1);
  }
}

// A bond that would go too far is left where it is. So is a bond that is larger than the difference.
TEST(WorkShares, OnlyToRanksBeside) {
  const std::vector<BondMove> moves = rebalance(row_of_subdomains(3), {bond(7, 0, 4.0, 0, 0), bond(8, 0, 4.0, 1, 1)}, {8.0, 5.0, 0.0});
  ASSERT_EQ(moves.size(), 1u);
  EXPECT_EQ(moves[0].row, 8);
  EXPECT_EQ(moves[0].rank, 2);
  EXPECT_TRUE(rebalance(row_of_subdomains(2), {bond(1, 0, 10.0, 0, 0)}, {10.0, 0.0}).empty());
}

// Random work: the largest share falls, the sum stays, and every bond is beside its place.
TEST(WorkShares, RandomWork) {
  test::Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<SubdomainIndex> subdomains;
    for (int r = 0; r < 8; ++r) subdomains.push_back({r / 4, r / 2 % 2, r % 2});
    std::vector<MovableBond> bonds;
    std::vector<double> work(8, 1.0);
    for (int n = 0; n < 100; ++n) {
      const int rank = static_cast<int>(random.uniform(0, 1) * random.uniform(0, 1) * 7.99);
      bonds.push_back({n, rank, random.uniform(0.5, 2.0), subdomains[rank], subdomains[rank]});
      work[rank] += bonds.back().work;
    }
    std::vector<double> after = work;
    for (const BondMove& m : rebalance(subdomains, bonds, work)) {
      after[bonds[m.row].rank] -= bonds[m.row].work;
      after[m.rank] += bonds[m.row].work;
    }
    EXPECT_NEAR(std::accumulate(after.begin(), after.end(), 0.0), std::accumulate(work.begin(), work.end(), 0.0), 1e-9);
    EXPECT_LT(load_imbalance(after), 1.1);
  }
}

}  // namespace
}  // namespace mpdem
