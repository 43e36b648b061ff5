// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <tuple>
#include <vector>

#include "cement/layout/cement_restart.h"
#include "mpm/bond_record.h"
#include "mpm/grid.h"
#include "cement.h"

namespace mpdem {
namespace {

constexpr int kLastBody = std::numeric_limits<int>::max();

TEST(Key, SaysWhatItWasMadeOf) {
  for (int row : {0, 1, (1 << 20) - 1, 1 << 20, 1 << 25, kLastBody})
    for (int layer : {0, 1, 1023, 1024, kMaxLayers - 2})
      for (int x : {-Key::kFarthest, -1, 0, 7, Key::kFarthest}) {
        const Field field = field_of(row, layer);
        const Key k(field, x, -x, x / 2);
        EXPECT_EQ(k.field(), field);
        EXPECT_EQ(row_of(field), row);
        EXPECT_EQ(layer_of_field(field), layer);
        EXPECT_EQ(k.index(), (std::array<int, 3>{x, -x, x / 2}));
        EXPECT_EQ(k.with_field(5), Key(5, x, -x, x / 2));
        EXPECT_TRUE(Key::before(field) < k && k < Key::before(field + 1));
        EXPECT_TRUE(kNoNode < k);
      }
  EXPECT_EQ(Key(3, 5, 6, 7).moved(1, -9), Key(3, 5, -3, 7));
}

TEST(Key, IsInTheOrderOfPartBondAndPlace) {
  test::Random random(801);
  const auto any = [&] {
    return std::make_tuple(random.index(3), random.index(2) == 0 ? random.index(4) : (1 << 20) + random.index(4), random.index(5) - 2,
                           random.index(5) - 2, random.index(5) - 2);
  };
  const auto key = [](const auto& t) {
    return Key(field_of(std::get<1>(t), std::get<0>(t)), std::get<2>(t), std::get<3>(t), std::get<4>(t));
  };
  for (int n = 0; n < 5000; ++n) {
    const auto a = any(), b = any();
    EXPECT_EQ(a < b, key(a) < key(b));
    EXPECT_EQ(a == b, key(a) == key(b));
  }
}

TEST(Key, TellsOfPlacesThatAreTooFar) {
  EXPECT_NO_THROW(Key(0, 0, 0, Key::kFarthest));
  EXPECT_THROW(Key(0, 0, Key::kFarthest + 1, 0), OnOneRank);
  EXPECT_THROW(Key(0, -Key::kFarthest - 1, 0, 0), OnOneRank);
  EXPECT_THROW(Key(0, Key::kFarthest, 0, 0).moved(0, 1), OnOneRank);
}

// Bonds beyond the first million, and layers beyond a thousand, keep their motion to themselves.
TEST(Key, NodesOfManyBondsAndPartsAreApart) {
  const std::vector<Field> fields{field_of(0, 0),       field_of(0, 1),       field_of(0, 1024),     field_of(1 << 20, 0),
                                  field_of(1 << 20, 1), field_of(3 << 20, 0), field_of(kLastBody, 2)};
  EXPECT_EQ(std::set<Field>(fields.begin(), fields.end()).size(), fields.size());
  const int base[3] = {0, 0, 0};
  std::vector<std::array<int, 9>> columns(fields.size());
  std::vector<Grid> grids(fields.size());
  std::vector<GridRequest> requests(fields.size());
  for (std::size_t n = 0; n < fields.size(); ++n) {
    requests[n].grid = &grids[n];
    requests[n].cells.push_back({fields[n], base, columns[n].data()});
    for (int i = 0; i < 27; ++i) requests[n].before.keys.push_back(Key(fields[n], i / 9, i / 3 % 3, i % 3));
    requests[n].before.values.assign(27 * NodeKinematics::kWidth, 1.0 + static_cast<double>(n));
  }
  build_grids(MPI_COMM_SELF, 0.5, 0, 1e9, requests);
  for (std::size_t n = 0; n < fields.size(); ++n) {
    ASSERT_EQ(grids[n].size(), 27);
    for (double v : grids[n].velocity) EXPECT_EQ(v, 1.0 + static_cast<double>(n));
  }
}

}  // namespace
}  // namespace mpdem
