// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "numerics/simd.h"

#include "lanes.h"
#include "mpm/point_store.h"
#include "numerics/flush_denormals.h"

namespace mpdem {
namespace {

vd random_lanes(test::Random& random) {
  vd v;
  for (int l = 0; l < kLanes; ++l) v[l] = random.uniform(-10, 10);
  return v;
}

TEST(Simd, ElementwiseFunctionsActOnEveryLane) {
  test::Random random(1);
  const vd a = random_lanes(random), b = random_lanes(random);
  const vd root = sqrt(a * a), size = abs(a), high = max(a, b), low = min(a, b), picked = select(a < b, a, b);
  for (int l = 0; l < kLanes; ++l) {
    const double x = a[l], y = b[l];
    EXPECT_EQ(double(root[l]), std::sqrt(x * x));
    EXPECT_EQ(double(size[l]), std::fabs(x));
    EXPECT_EQ(double(high[l]), std::max(x, y));
    EXPECT_EQ(double(low[l]), std::min(x, y));
    EXPECT_EQ(double(picked[l]), std::min(x, y));
  }
}

TEST(Simd, SumOfLanes) {
  test::Random random(2);
  vd a[8];
  for (vd& v : a) v = random_lanes(random);
  const vd sums = sum_lanes_of_8(a);
  for (int r = 0; r < 8; ++r) {
    double expected = 0.0;
    for (int l = 0; l < kLanes; ++l) expected += a[r][l];
    EXPECT_NEAR(double(sums[r]), expected, 1e-13);
    EXPECT_NEAR(sum_lanes(a[r]), expected, 1e-13);
  }
}

TEST(Simd, MasksAndBitsAgree) {
  for (int bit_mask = 0; bit_mask < 256; ++bit_mask) {
    const vmask m = lanes(static_cast<std::uint8_t>(bit_mask));
    EXPECT_EQ(bits(m), bit_mask);
    EXPECT_EQ(any(m), bit_mask != 0);
    for (int l = 0; l < kLanes; ++l) EXPECT_EQ(std::int64_t(m[l]), bit_mask >> l & 1 ? -1 : 0);
  }
  EXPECT_TRUE(any(splat_mask(true)));
  EXPECT_FALSE(any(splat_mask(false)));
}

#if defined(__SSE2__)
TEST(Simd, TinyNumbersAreZeroWhileFlushed) {
  volatile double tiny = 1e-300, factor = 1e-10;
  {
    const FlushDenormals flush;
    EXPECT_EQ(tiny * factor, 0.0);
    EXPECT_GT(tiny * 1e-5, 0.0);
  }
  EXPECT_GT(tiny * factor, 0.0);
}
#endif

}  // namespace
}  // namespace mpdem
