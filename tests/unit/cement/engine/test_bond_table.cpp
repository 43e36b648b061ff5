// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The columns of the table of bonds.
#include "cement/engine/bond_table.h"
#include "cement/engine/cement_values.h"

#include <fstream>
#include <set>
#include <string>

#include "cement_host.h"
#include "lanes.h"
#include "mpi_ranks.h"

namespace mpdem {
namespace {

using test::Row;
using test::RowOfGrains;

int grid_index_of(const std::string& name) {
  for (std::size_t n = 0; n < bond_columns().size(); ++n)
    if (bond_columns()[n].name == name) return static_cast<int>(n);
  ADD_FAILURE() << "no column " << name;
  return 0;
}

double value(RowOfGrains& host, int bond, const std::string& name) {
  const BondColumn& c = bond_columns()[grid_index_of(name)];
  return c.of_all() ? c.value(host.cement->report().totals(0.1)) : c.value(host.cement->report().bond_states()[bond]);
}

// Scripts number the columns.
TEST(BondTable, PlacesStay) {
  const std::vector<std::string> first = {"fx1",
                                          "fy1",
                                          "fz1",
                                          "mx1",
                                          "my1",
                                          "mz1",
                                          "fx2",
                                          "fy2",
                                          "fz2",
                                          "mx2",
                                          "my2",
                                          "mz2",
                                          "gap",
                                          "tension",
                                          "points",
                                          "attached",
                                          "debonded",
                                          "failed",
                                          "largest_damage",
                                          "mean_damage",
                                          "peak_tension",
                                          "separated",
                                          "share_grain1",
                                          "share_grain2",
                                          "elastic_energy",
                                          "kinetic_energy",
                                          "coupling_energy",
                                          "dissipated_energy",
                                          "released_energy",
                                          "damped_energy",
                                          "external_work",
                                          "energy_imbalance"};
  ASSERT_GE(bond_columns().size(), first.size());
  std::set<std::string> names;
  for (std::size_t n = 0; n < bond_columns().size(); ++n) {
    const std::string name = bond_columns()[n].name;
    if (n < first.size()) {
      EXPECT_EQ(name, first[n]) << "column " << n + 1;
    }
    EXPECT_TRUE(names.insert(name).second) << name;
  }
}

// The rows below this head of a page are those of the list, numbered.
template <class List>
void expect_rows(const std::string& name, const std::string& head, const List& list) {
  std::ifstream page(MPDEM_DOC + name);
  std::vector<std::string> rows;
  std::string line;
  while (std::getline(page, line) && line != head) {
  }
  std::getline(page, line);  // the rule below
  while (std::getline(page, line) && !line.empty()) rows.push_back(line);
  EXPECT_EQ(rows.size(), list.size());
  for (std::size_t n = 0; n < list.size(); ++n) {
    const std::string row = "| " + std::to_string(n + 1) + " | `" + list[n].name + "` | " + list[n].description + " |";
    EXPECT_EQ(n < rows.size() ? rows[n] : "", row);
  }
}

TEST(BondTable, PagesHaveEachColumnAndValue) {
  expect_rows("/fix_mpm_couple.md", "| | column | |", bond_columns());
  expect_rows("/fix_mpm.md", "| | value | |", cement_values());
}

// Each bond has its own numbers, summed over all its ranks.
TEST(BondTable, SumsGoOverRanksNotOverBonds) {
  Row r;
  r.bonds = 3;
  r.free_middle = true;
  r.speed = 8.0;
  RowOfGrains host(MPI_COMM_WORLD, r);
  host.setup();
  host.run(480);
  double links[3] = {}, gone[3] = {}, failed[3] = {};
  for (const Bond& b : host.bonds) {
    for (const Link& k : b.points.links) (k.attached ? links : gone)[b.row] += 1.0;
    for (const BlockMeta& m : b.points.meta) failed[b.row] += __builtin_popcount(m.failed);
  }
  for (int b = 0; b < 3; ++b) {
    EXPECT_EQ(value(host, b, "points"), host.bonds.table[b].points);
    EXPECT_EQ(value(host, b, "attached"), host.sum(links[b]));
    EXPECT_EQ(value(host, b, "debonded"), host.sum(gone[b]));
    EXPECT_EQ(value(host, b, "failed"), host.sum(failed[b]));
  }
  EXPECT_GT(value(host, 0, "debonded"), 0.0);
  EXPECT_NE(value(host, 0, "debonded"), value(host, 1, "debonded"));  // bonds at the ends of the row and in its middle
  EXPECT_EQ(value(host, 0, "external_work"), host.cement->report().totals(0.1).external_work);

  // Columns that need no points are there without a pass over them. The rest are 0.
  for (std::size_t n = 0; n < bond_columns().size(); ++n) {
    const BondColumn& c = bond_columns()[n];
    if (c.of_all()) continue;
    for (int b = 0; b < 3; ++b) {
      const double whole = c.value(host.cement->report().bond_states()[b]), alone = c.value(host.cement->report().bond_loads()[b]);
      EXPECT_EQ(alone, c.needs_points() ? 0.0 : whole) << c.name;
    }
  }
}

// The half of the links at the second grain that lies at positive x has debonded before the start. Later whole rings debond.
TEST(BondTable, AttachedShareIsThatOfTheArea) {
  Row r;
  r.speed = 8.0;
  RowOfGrains host(MPI_COMM_WORLD, r);
  for (Bond& b : host.bonds)
    for (Link& k : b.points.links) k.attached = k.grain == 1 || k.foot[0] < 0.0;
  host.setup();
  host.step();
  EXPECT_NEAR(value(host, 0, "attached_grain1"), 1.0, 1e-12);
  EXPECT_NEAR(value(host, 0, "attached_grain2"), 0.5, 1e-12);

  RowOfGrains whole(MPI_COMM_WORLD, r);
  whole.setup();
  double last = 2.0;
  int steps_of_loss = 0;
  while (whole.number < 400) {
    whole.run(10);
    double area[2] = {0.0, 0.0};
    for (const Bond& b : whole.bonds)
      for (const Link& k : b.points.links) area[k.grain - 1] += k.attached ? k.area : 0.0;
    const double cap =
        2.0 * M_PI * test::kRadius * (test::kRadius - std::sqrt(test::kRadius * test::kRadius - test::kOuter * test::kOuter));
    const double share[2] = {value(whole, 0, "attached_grain1"), value(whole, 0, "attached_grain2")};
    for (int s = 0; s < 2; ++s) EXPECT_NEAR(share[s], whole.sum(area[s]) / cap, 1e-12);
    EXPECT_EQ(share[0] + share[1]<2.0 - 1e-9, value(whole, 0, "debonded")> 0.0);
    EXPECT_LE(share[0] + share[1], last + 1e-12);
    steps_of_loss += share[0] + share[1] < last - 1e-9;
    last = share[0] + share[1];
  }
  EXPECT_GT(steps_of_loss, 0);
  EXPECT_LT(last, 1.9);
}

}  // namespace
}  // namespace mpdem
