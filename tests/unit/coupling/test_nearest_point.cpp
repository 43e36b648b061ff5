// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement.h"
#include "coupling/debonded_contact.h"
#include "mpi_ranks.h"

namespace mpdem {
namespace {

// Of two points that are equally far, neither rounding, which depends on the units, nor the order of the points may decide which is nearer.
TEST(DebondedContact, AreSharedByPointsThatAreAsNear) {
  if (test::ranks() > 1) GTEST_SKIP();
  const double a = test::kCell;
  const test::Cement two(2.0 * a, {{0.25 * a, 0, 0.5 * a}, {-0.25 * a, 0, 0.5 * a}}, a * a * a);
  DebondedContact::OrphanedContact m{0, 1, 0, 1.0, {0, 0, 0}, {0, 0, 1}, 0.5 * a};
  for (double off : {0.0, 1e-14, -1e-14}) {
    m.X[0] = off * a;
    EXPECT_EQ(DebondedContact::nearest(two.points, m).slots.size(), 2u) << off;
  }
  m.X[0] = -1e-4 * a;
  const std::vector<int> slots = DebondedContact::nearest(two.points, m).slots;
  ASSERT_EQ(slots.size(), 1u);
  EXPECT_EQ(two.points.tag(slots[0]), 2);
}

}  // namespace
}  // namespace mpdem
