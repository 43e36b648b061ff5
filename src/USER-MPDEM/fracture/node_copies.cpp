// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "node_copies.h"

namespace mpdem {

const NodeCopies::Row* NodeCopies::row(const Place& node) const {
  const auto row = rows_.find(node);
  return row == rows_.end() ? nullptr : &row->second;
}

NodeCopies::Entry NodeCopies::entry_of(const Row* row, int part) {
  if (row)
    for (const Entry& e : *row)
      if (e.part == part) return e;
  return {part, 0, 0, 0.0};
}

int NodeCopies::canonical(int part, const Place& node) const {
  const Row* r = row(node);
  if (!r) return 0;
  const int mine = entry_of(r, part).copy;
  for (const Entry& e : *r)
    if (e.copy == mine) return e.part;
  return part;
}

int NodeCopies::canonical_of_first(int first, const Place& node) const {
  const Row* r = row(node);
  if (!r) return 0;
  const Entry* found = nullptr;
  for (const Entry& e : *r) {
    if (e.first != first) continue;
    if (found && found->copy != e.copy) return -1;
    if (!found) found = &e;
  }
  return found ? found->part : -1;
}

void NodeCopies::start() {
  for (auto& r : rows_)
    for (Entry& e : r.second) e.first = e.copy;
}

int NodeCopies::toward(const Place& node, int first, int direction) const {
  const auto row = towards_.find(node);
  if (row == towards_.end()) return 0;
  for (const Toward& t : row->second)
    if (t.first == first) return t.to[direction];
  return -1;
}

}  // namespace mpdem
