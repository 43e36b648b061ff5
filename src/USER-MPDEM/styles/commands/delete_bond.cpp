// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "delete_bond.h"

#include <algorithm>
#include <string>

#include "../../numerics/sort_unique.h"
#include "../../parallel/gather_ranks.h"
#include "../words/arguments.h"
#include "atom.h"
#include "../atoms/atom_vec_mpdem.h"
#include "domain.h"
#include "../fixes/fix_mpm.h"
#include "group.h"
#include "modify.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::text_of;

namespace {

// Rows that have cement and meet a condition.
template <class Condition>
std::vector<int> rows_where(const std::vector<mpdem::BondRecord>& table, Condition is_wanted) {
  std::vector<int> rows;
  for (std::size_t row = 0; row < table.size(); ++row)
    if (table[row].points > 0 && is_wanted(row)) rows.push_back(static_cast<int>(row));
  return rows;
}

}  // namespace

void DeleteBond::command(int narg, char** arg) {
  Arguments args(lmp, "delete_bond", narg, arg, 0);
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  if (!domain->box_exist) args.complain("the simulation box does not exist yet; use create_box or read_restart before");
  if (!avec) args.complain(text_of("atom style '", atom->atom_style, "' has no cement; use 'atom_style mpdem'"));
  const std::vector<mpdem::BondRecord>& table = avec->bonds.table;
  if (table.empty()) args.complain("there is no cement; use create_cement before");
  FixMpm* const cement = FixMpm::of(*modify);
  if (!cement) args.complain("there is no fix mpm, which counts what leaves; define one before");
  const std::string which = args.keyword({"pair", "group", "separated", "broken", "all"});
  std::vector<int> rows;
  const mpdem::Cracks& cracks = cement->engine().cracks();
  if (which == "pair") {
    do {
      const std::vector<int> of_pair = rows_of_pair(args);
      rows.insert(rows.end(), of_pair.begin(), of_pair.end());
    } while (args.accept("pair"));
  } else if (which == "group") {
    rows = rows_of_group(args);
  } else if (which == "separated") {
    rows = rows_where(table, [&](std::size_t row) { return cracks.separated(row); });
  } else if (which == "broken") {
    rows = rows_where(table, [&](std::size_t row) { return cracks.broken(row); });
  } else {
    rows = rows_where(table, [](std::size_t) { return true; });
  }
  if (!args.empty())
    args.complain("'" + args.word("") +
                  "' is one word too many; the forms are 'delete_bond pair I J', 'group ID', 'separated', 'broken' and 'all'");
  mpdem::sort_unique(rows);
  if (!cement->engine().built()) args.complain("no run has laid out the cement since create_cement or read_restart; use 'run 0' before");
  const mpdem::EnergyBalance::Left before = cement->totals().left;
  if (!rows.empty()) cement->delete_bonds(rows);
  const mpdem::EnergyBalance::Left after = cement->totals().left;
  mpdem::tell(lmp, text_of("delete_bond: ", rows.size(), " of ", table.size(), " bonds, ", after.points - before.points, " points, mass ",
                           after.mass - before.mass, ", energy ", after.energy - before.energy, "\n"));
}

std::vector<int> DeleteBond::rows_of_pair(Arguments& args) const {
  const std::vector<mpdem::BondRecord>& table = AtomVecMpdem::of(lmp)->bonds.table;
  const auto [i, j] = args.pair();
  const int first = std::min(i, j), second = std::max(i, j);
  const std::vector<int> rows =
      rows_where(table, [&](std::size_t row) { return table[row].grain[0] == first && table[row].grain[1] == second; });
  if (rows.empty())
    args.complain(text_of("'pair ", i, " ", j,
                          "': no cement is between these grains; use the IDs of two grains that a bond joins, as in the columns grain1 and "
                          "grain2 of the table of fix mpm/couple"));
  return rows;
}

// Bonds of which both grains are in the group.
std::vector<int> DeleteBond::rows_of_group(Arguments& args) const {
  const std::string name = args.word("a group ID");
  const int number = group->find(name.c_str());
  if (number < 0) args.complain("'group " + name + "': there is no such group; define it before");
  std::vector<int> mine;
  for (int i = 0; i < atom->nlocal; ++i)
    if (atom->mask[i] & group->bitmask[number]) mine.push_back(atom->tag[i]);
  std::vector<int> tags = mpdem::gather_all(world, mine);
  mpdem::sort_unique(tags);
  const auto is_in = [&](int tag) { return std::binary_search(tags.begin(), tags.end(), tag); };
  const std::vector<mpdem::BondRecord>& table = AtomVecMpdem::of(lmp)->bonds.table;
  return rows_where(table, [&](std::size_t row) { return is_in(table[row].grain[0]) && is_in(table[row].grain[1]); });
}

}  // namespace LAMMPS_NS
