// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nodes of copies, and their ties and volumes (splits.h).
#include <algorithm>

#include "node_places.h"
#include "../numerics/sort_unique.h"
#include "splits.h"

namespace mpdem {

namespace {

// Calls f for each node of all cells of a block.
template <class F>
void for_each_node(const BlockMeta& m, int S, F f) {
  for (int i = 0; i < nodes_along(m, 0, S); ++i)
    for (int j = 0; j < nodes_along(m, 1, S); ++j)
      for (int k = 0; k < nodes_along(m, 2, S); ++k) f(Place{m.base[0] + i, m.base[1] + j, m.base[2] + k});
}

}  // namespace

bool Splits::edges_known(const std::vector<int>& rows) const {
  return std::all_of(rows.begin(), rows.end(), [&](int r) { return known_[r].edges; });
}

void Splits::keep_edges(const std::vector<int>& rows, std::vector<EdgeTie> edges) {
  drop_edges(rows);
  for (int r : rows) known_[r].edges = true;
  for (EdgeTie& t : edges) rows_[body_of(t.slave.field())].edges.push_back(std::move(t));
}

void Splits::drop_edges(const std::vector<int>& rows) {
  for (int r : rows) {
    known_[r].edges = false;
    const auto row = rows_.find(r);
    if (row == rows_.end()) continue;
    std::vector<EdgeTie>().swap(row->second.edges);
    std::vector<std::pair<Key, int>>().swap(row->second.users);
    if (row->second.copies.empty() && !row->second.lattice) rows_.erase(row);
  }
}

// Returns the node that stands now for a node of the start, or none if that node has been split.
Key Splits::now(const Key& at_start) const {
  const int body = body_of(at_start.field());
  const int part = copies(body).canonical_of_first(part_of_field(at_start.field()), place_of(at_start));
  return part < 0 ? kNoNode : key_at(body, part, place_of(at_start));
}

std::vector<Key> Splits::nodes_beside(const PointStore& points, int body, int S) const {
  std::vector<Key> nodes;
  const NodeCopies& copies = this->copies(body);
  const BlockMeta* last = nullptr;
  for (const BlockMeta& m : points.meta) {
    if (m.part == 0) continue;
    if (last && m.part == last->part && m.joined == last->joined && std::equal(m.base, m.base + 3, last->base)) continue;
    last = &m;
    for_each_node(m, S, [&](const Place& p) { nodes.push_back(key_at(body, copies.canonical(m.part, p), p)); });
  }
  // Edges of nodes that have split since need no masters. Which of these edges a rank knows depends on when it found them.
  for (const EdgeTie& t : row(body).edges) {
    if (now(t.slave) == kNoNode) continue;
    for (const auto* of_tie : {&t.masters, &t.heirs})
      for (const auto& m : *of_tie) nodes.push_back(now(m.first));
  }
  sort_unique(nodes);
  if (!nodes.empty() && nodes.front() == kNoNode) nodes.erase(nodes.begin());
  return nodes;
}

std::vector<Key> Splits::copies_of(int body) const {
  std::vector<Key> nodes;
  const NodeCopies& copies = this->copies(body);
  for (const auto& row : copies.rows())
    for (const NodeCopies::Entry& e : row.second)
      if (e.volume > 0.0 && copies.canonical(e.part, row.first) == e.part) nodes.push_back(key_at(body, e.part, row.first));
  return nodes;
}

std::vector<Key> Splits::nodes_of(const BlockMeta& m, int S) {
  std::vector<Key> nodes;
  for_each_node(m, S, [&](const Place& p) { nodes.push_back(key_at(m.body, m.part, p)); });
  return nodes;
}

Key Splits::standing_for(const Key& k) const {
  const int body = body_of(k.field());
  return key_at(body, copies(body).canonical(part_of_field(k.field()), place_of(k)), place_of(k));
}

std::vector<Key> Splits::standing_for(const BlockMeta& m, int S) const {
  std::vector<Key> nodes;
  const NodeCopies& copies = this->copies(m.body);
  for_each_node(m, S, [&](const Place& p) { nodes.push_back(key_at(m.body, copies.canonical(m.part, p), p)); });
  return nodes;
}

std::vector<Key> Splits::standing_at(int body, const std::vector<Key>& split) const {
  std::vector<Key> nodes;
  const NodeCopies& copies = this->copies(body);
  for (const Key& k : split)
    for (const NodeCopies::Entry& e : *copies.row(place_of(k))) nodes.push_back(key_at(body, copies.canonical(e.part, place_of(k)), place_of(k)));
  return nodes;
}

void Splits::find_users(Row& row) const {
  for (std::size_t n = 0; n < row.edges.size(); ++n)
    for (const auto* of_tie : {&row.edges[n].masters, &row.edges[n].heirs})
      for (const auto& m : *of_tie) row.users.emplace_back(m.first, static_cast<int>(n));
  sort_unique(row.users);
}

// Finds nodes of all parts at the places that split, and edges that were tied to nodes there at the start. Most parts
// are small, so each is searched by itself.
std::vector<int> Splits::nodes_touched(const Grid& grid, int body, const std::vector<Key>& split) {
  Row& row = rows_[body];
  if (row.users.empty()) find_users(row);
  struct OfField {
    Field field;
    std::vector<Key>::const_iterator begin, end;
  };
  std::vector<OfField> fields;
  for (auto k = grid.keys.begin(); k != grid.keys.end();) {
    const auto end = std::lower_bound(k, grid.keys.end(), Key::before(k->field() + 1));
    fields.push_back({k->field(), k, end});
    k = end;
  }
  std::vector<int> nodes;
  const auto node_in = [&](const OfField& f, const Key& k) {
    if (k < *f.begin || *(f.end - 1) < k) return -1;
    const auto at = std::lower_bound(f.begin, f.end, k);
    return at != f.end && *at == k ? static_cast<int>(at - grid.keys.begin()) : -1;
  };
  std::vector<Key> slaves;
  for (const Key& k : split) {
    for (const OfField& f : fields)
      if (const int node = node_in(f, k.with_field(f.field)); node >= 0) nodes.push_back(node);
    for (const NodeCopies::Entry& e : *row.copies.row(place_of(k))) {
      const Key first = key_at(body, e.first, place_of(k));
      for (auto u = std::lower_bound(row.users.begin(), row.users.end(), std::make_pair(first, 0)); u != row.users.end() && u->first == first; ++u)
        slaves.push_back(row.edges[u->second].slave);
    }
  }
  sort_unique(slaves);
  for (const Key& s : slaves)
    for (const OfField& f : fields) {
      const Key k = s.with_field(f.field);
      if (const int node = node_in(f, k); node >= 0 && at_start(k) == s) nodes.push_back(node);
    }
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

Key Splits::at_start(const Key& k) const {
  const int body = body_of(k.field());
  const NodeCopies& copies = this->copies(body);
  return copies.empty() ? key_at(body, 0, place_of(k)) : key_at(body, copies.at(part_of_field(k.field()), place_of(k)).first, place_of(k));
}

Key Splits::next(const Key& k, int direction) const {
  const int body = body_of(k.field()), first = copies(body).toward(place_of(k), part_of_field(k.field()), direction);
  if (first < 0) return kNoNode;
  Place p = place_of(k);
  p[direction / 2] += direction % 2 == 0 ? -1 : 1;
  return key_at(body, first, p);
}

std::vector<EdgeTie> Splits::ties(const std::vector<Key>& keys) const {
  std::vector<EdgeTie> ties;
  ties.reserve(keys.size());
  for (const Key& k : keys) {
    EdgeTie t;
    t.slave = k;
    const Key start = at_start(k);
    const std::vector<EdgeTie>& edges = row(body_of(k.field())).edges;
    const auto edge = std::lower_bound(edges.begin(), edges.end(), start, [](const EdgeTie& a, const Key& b) { return a.slave < b; });
    if (edge != edges.end() && edge->slave == start && now(start) != kNoNode) {
      for (const auto& m : edge->masters) t.masters.emplace_back(now(m.first), m.second);
      for (const auto& h : edge->heirs) t.heirs.emplace_back(now(h.first), h.second);
      for (const auto& b : edge->behind) t.behind.emplace_back(now(b.first), b.second);
    }
    const bool whole = !t.masters.empty() && std::none_of(t.masters.begin(), t.masters.end(), [](const auto& m) { return m.first == kNoNode; }) &&
                       std::none_of(t.heirs.begin(), t.heirs.end(), [](const auto& h) { return h.first == kNoNode; });
    if (!whole) {
      const int part = part_of_field(k.field()), stands = copies(body_of(k.field())).canonical(part, place_of(k));
      if (stands == part) continue;
      const Key master = key_at(body_of(k.field()), stands, place_of(k));
      t.masters.assign(1, {master, 1.0});
      t.heirs = t.behind = t.masters;
    }
    std::sort(t.masters.begin(), t.masters.end());
    ties.push_back(std::move(t));
  }
  return ties;
}

std::vector<double> Splits::volumes(const std::vector<Key>& keys, const CementOptions& options) const {
  if (!options.shares_failed_mass()) return {};
  if (keys.empty() || copies(body_of(keys.front().field())).empty()) return {};
  const NodeCopies& copies = this->copies(body_of(keys.front().field()));
  std::vector<double> given(keys.size(), -1.0);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Place place = place_of(keys[i]);
    if (!copies.row(place)) continue;
    const int part = part_of_field(keys[i].field());
    given[i] = copies.canonical(part, place) == part ? copies.at(part, place).volume : 0.0;
  }
  return given;
}

}  // namespace mpdem
