// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Bonds with a crevice get two sheets (fracture/crevice.h). Points near the middle of a bond go to one rank. It looks
// at the bond as a whole and keeps the nodes where the sheets are joined.
#ifndef MPDEM_CEMENT_SHEETS_H
#define MPDEM_CEMENT_SHEETS_H

#include <map>
#include <vector>

#include "../fracture/crevice.h"
#include "../fracture/neighbours.h"
#include "bond.h"
#include "options.h"

namespace mpdem {

// Points that go to another part, and the field from which each new field has its motion.
struct NewParts {
  std::map<int, int> part_of_slot;
  std::map<Field, Field> parent_field;
  std::map<Key, Key> source;
  std::vector<Key> split;  // nodes whose copies changed, with the keys of part 0
};
using NewPartsOfBonds = std::map<int, NewParts>;  // by row of the table

class Sheets {
 public:
  // Collective. Divides the bonds from row `first()` of the table on, and others that had no points before. Returns
  // which points change their part.
  NewPartsOfBonds divide(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<int>& others = {});
  int first() const { return static_cast<int>(has_sheets_.size()); }

  // Nodes where the sheets of a bond are joined. This rank must be the one that looks at the bond as a whole.
  JoinedNodes joined_nodes(int body) const;
  // Collective. Returns for each of the nodes what find_edge_ties() asks: kNoSheets, kJoined or kApart.
  std::vector<char> at(MPI_Comm comm, const std::vector<int>& rows, const std::vector<Key>& keys) const;

 private:
  std::vector<signed char> has_sheets_;  // for each bond: has it two sheets
  std::vector<Key> joined_;              // joined nodes of bonds that this rank looked at, by row of the table; ascending
};

// A point as crevice.h and neighbours.h see it, without its sheet.
SheetPoint sheet_point(const PointStore& points, const Body& body, int block, int lane);

}  // namespace mpdem

#endif
