// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "phantom_nodes.h"

namespace mpdem {

const PhantomNodes::Row* PhantomNodes::row(const GridIndex& node) const {
  const auto row = rows_.find(node);
  return row == rows_.end() ? nullptr : &row->second;
}

PhantomNodes::Entry PhantomNodes::entry_of(const Row* row, int layer) {
  if (row)
    for (const Entry& e : *row)
      if (e.layer == layer) return e;
  return {layer, 0, 0, 0.0};
}

int PhantomNodes::representative(int layer, const GridIndex& node) const {
  const Row* r = row(node);
  if (!r) return 0;
  const int mine = entry_of(r, layer).copy;
  for (const Entry& e : *r)
    if (e.copy == mine) return e.layer;
  return layer;
}

int PhantomNodes::representative_of_first(int first, const GridIndex& node) const {
  const Row* r = row(node);
  if (!r) return 0;
  const Entry* found = nullptr;
  for (const Entry& e : *r) {
    if (e.first != first) continue;
    if (found && found->copy != e.copy) return -1;
    if (!found) found = &e;
  }
  return found ? found->layer : -1;
}

void PhantomNodes::start() {
  for (auto& r : rows_)
    for (Entry& e : r.second) e.first = e.copy;
}

int PhantomNodes::continuation(const GridIndex& node, int first, int direction) const {
  if (continuations_.empty()) return 0;
  const auto row = continuations_.find(node);
  if (row == continuations_.end()) return 0;
  for (const Continuation& t : row->second)
    if (t.first == first) return t.to[direction];
  return -1;
}

}  // namespace mpdem
