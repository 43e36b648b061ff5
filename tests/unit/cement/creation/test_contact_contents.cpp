// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement/creation/contact_contents.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "parallel/agree.h"

namespace mpdem {
namespace {

TEST(ContactContents, QuantilesInvertTheDistribution) {
  for (double p : {1e-15, 1e-9, 1e-4, 0.02, 0.3, 0.5, 0.7, 0.99, 1.0 - 1e-9})
    EXPECT_NEAR(0.5 * std::erfc(-normal_quantile(p) / std::sqrt(2.0)) / p, 1.0, 1e-12) << p;
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-14);
}

// 4000 pairs: uniform numbers fill 20 classes evenly, and those of neighbouring seeds, IDs and streams do not follow each other.
TEST(ContactContents, DrawsAreUniformAndIndependent) {
  constexpr int kDraws = 4000, kClasses = 20;
  std::vector<double> u[4];
  for (int n = 0; n < kDraws; ++n) {
    u[0].push_back(draw_of_pair(1, {n + 1, n + 2}, 0));
    u[1].push_back(draw_of_pair(2, {n + 1, n + 2}, 0));
    u[2].push_back(draw_of_pair(1, {n + 1, n + 3}, 0));
    u[3].push_back(draw_of_pair(1, {n + 1, n + 2}, 1));
  }
  for (const std::vector<double>& one : u) {
    std::vector<double> count(kClasses, 0.0);
    for (double x : one) ++count[static_cast<std::size_t>(kClasses * x)];
    double chi = 0.0;
    for (double c : count) chi += std::pow(c - kDraws / kClasses, 2) / (kDraws / kClasses);
    EXPECT_LT(chi, 45.0);  // of 19 degrees of freedom: once in a thousand
  }
  for (int k = 1; k < 4; ++k) {
    double sum = 0.0;
    for (int n = 0; n < kDraws; ++n) sum += (u[0][n] - 0.5) * (u[k][n] - 0.5);
    EXPECT_LT(std::fabs(12.0 * sum / kDraws), 4.0 / std::sqrt(kDraws));
  }
}

std::vector<PairToCement> many(int number) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(0.5, 1.5);
  std::vector<PairToCement> pairs;
  for (int n = 0; n < number; ++n) pairs.push_back({{n + 1, n + 2}, n % 3 == 0 ? 0.1 * u(random) : 0.0, 1.0, u(random)});
  return pairs;
}
std::pair<double, double> wide(std::size_t) { return {1e-9, 0.5}; }

TEST(ContactContents, LognormalHasMeanAndVariation) {
  ContentWish wish;
  wish.spread = ContentWish::lognormal;
  wish.first = 0.01;
  wish.second = 0.5;
  wish.seed = 11;
  const std::vector<double> c = ContactContents(wish, 0.0, 1.0, {}).choose(many(20000), wide);
  double mean = 0.0, square = 0.0, middle = 0.0;
  for (double x : c) mean += x / c.size();
  for (double x : c) square += (x - mean) * (x - mean) / c.size(), middle += std::log(x) / c.size();
  EXPECT_NEAR(mean / 0.01, 1.0, 4.0 * 0.5 / std::sqrt(20000.0));
  EXPECT_NEAR(std::sqrt(square) / mean, 0.5, 0.03);
  EXPECT_NEAR(middle, std::log(0.01) - 0.5 * std::log(1.25), 0.02);
}

// The order of pairs does not matter, nor do other pairs.
TEST(ContactContents, DrawsBelongToThePair) {
  ContentWish wish;
  wish.spread = ContentWish::uniform;
  wish.first = 0.01;
  wish.second = 0.02;
  wish.seed = 4;
  std::vector<PairToCement> pairs = many(100), turned(pairs.rbegin(), pairs.rend() - 40);
  const std::vector<double> c = ContactContents(wish, 0.0, 1.0, {}).choose(pairs, wide),
                            d = ContactContents(wish, 0.0, 1.0, {}).choose(turned, wide);
  for (std::size_t n = 0; n < d.size(); ++n) EXPECT_EQ(d[n], c[99 - n]);
}

TEST(ContactContents, ShareIsExact) {
  ContentWish wish;
  wish.share = 0.3;
  wish.seed = 5;
  const std::vector<PairToCement> pairs = many(900);
  for (bool nearest : {false, true}) {
    wish.nearest = nearest;
    ContactContents contents(wish, 0.01, 1.0, {});
    const std::vector<double> c = contents.choose(pairs, wide);
    EXPECT_EQ(std::count(c.begin(), c.end(), 0.01), 270);
    EXPECT_EQ(contents.cemented(ContentWish::contact), 180);
    if (!nearest) continue;
    double last = 0.0;
    for (std::size_t n = 0; n < pairs.size(); ++n)
      if (c[n] > 0.0) last = std::max(last, pairs[n].gap);
    for (std::size_t n = 0; n < pairs.size(); ++n) EXPECT_TRUE(pairs[n].gap <= 0.01 || c[n] > 0.0 || pairs[n].gap >= last);
  }
}

// Contents that meet their bounds leave the rest to others: the sum is that asked for, up to all bounds, and not beyond.
TEST(ContactContents, CalciteIsReachedWithinBounds) {
  ContentWish wish;
  wish.spread = ContentWish::lognormal;
  wish.first = 1.0;
  wish.second = 1.0;
  wish.seed = 6;
  wish.pattern = {0.75, 0.25, 0.0, 0.0};
  const std::vector<PairToCement> pairs = many(300);
  const auto bounds = [](std::size_t n) { return std::make_pair(0.001, n % 2 ? 0.01 : 0.03); };
  double most[2] = {0.0, 0.0}, least[2] = {0.0, 0.0};
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    most[pairs[n].gap > 0.01] += bounds(n).second * pairs[n].mass;
    least[pairs[n].gap > 0.01] += bounds(n).first * pairs[n].mass;
  }
  const double grains = 100.0;
  for (double part : {0.2, 0.6, 0.99}) {
    wish.calcite = part * std::min(most[0] / 0.75, most[1] / 0.25) / grains;
    ContactContents contents(wish, 1.0, grains, {});
    const std::vector<double> c = contents.choose(pairs, bounds);
    double sum[2] = {0.0, 0.0};
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      sum[pairs[n].gap > 0.01] += c[n] * pairs[n].mass;
      EXPECT_LE(c[n], bounds(n).second);
      EXPECT_GE(c[n], bounds(n).first);
    }
    EXPECT_NEAR(sum[0] / (0.75 * wish.calcite * grains), 1.0, 1e-12);
    EXPECT_NEAR(sum[1] / (0.25 * wish.calcite * grains), 1.0, 1e-12);
    EXPECT_GT(contents.cut(), 0);
  }
  for (double calcite :
       {1.001 * std::max(most[0] / 0.75, most[1] / 0.25) / grains, 0.999 * std::min(least[0] / 0.75, least[1] / 0.25) / grains}) {
    wish.calcite = calcite;
    EXPECT_THROW(ContactContents(wish, 1.0, grains, {}).choose(pairs, bounds), BadState);
  }
}

TEST(ContactContents, CoatHasTheMass) {
  const std::vector<double> radii = {1e-3, 1.7e-3, 2e-3};
  const double t = coat_of_mass(radii, 2710.0, 1e-6, "test");
  double volume = 0.0;
  for (double R : radii) volume += 4.0 / 3.0 * M_PI * (std::pow(R + t, 3) - std::pow(R, 3));
  EXPECT_NEAR(2710.0 * volume / 1e-6, 1.0, 1e-10);
  EXPECT_NEAR(volume_of_coats(radii, t) / volume, 1.0, 1e-10);
  EXPECT_THROW(coat_of_mass(radii, 2710.0, 2710.0 * volume_of_coats(radii, 2.01e-4), "test"), BadState);
}

TEST(ContactContents, FilesNameBadLines) {
  const std::vector<std::pair<int, int>> pairs = {{1, 2}, {1, 3}, {2, 3}};
  const auto found = read_contents("# c\n3 1 0.02\n\n 1 2 1e-3 # x\n", "f", pairs);
  EXPECT_EQ(found.size(), 2u);
  EXPECT_EQ(found.at({1, 3}), 0.02);
  for (const char* bad :
       {"1 2\n", "1 2 x\n", "1 2 0\n", "1 2 -3\n", "1 2 0.1 7\n", "1 4 0.1\n", "2 2 0.1\n", "1 2 0.1\n2 1 0.1\n", "", "1 2 nan\n"})
    EXPECT_THROW(read_contents(bad, "f", pairs), BadState) << bad;
}

}  // namespace
}  // namespace mpdem
