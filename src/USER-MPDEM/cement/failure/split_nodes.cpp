// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Class NodeSplitting: nodes with copies, their constraints and volumes.
#include <algorithm>

#include "node_index.h"
#include "../../numerics/sort_unique.h"
#include "node_splitting.h"

namespace mpdem {

namespace {

template <class F>
void for_each_node(const BlockMeta& m, int support, F f) {
  for (int i = 0; i < nodes_along(m, 0, support); ++i)
    for (int j = 0; j < nodes_along(m, 1, support); ++j)
      for (int k = 0; k < nodes_along(m, 2, support); ++k) f(GridIndex{m.base[0] + i, m.base[1] + j, m.base[2] + k});
}

}  // namespace

bool NodeSplitting::edges_known(const std::vector<int>& rows) const {
  return std::all_of(rows.begin(), rows.end(), [&](int r) { return known_[r].edges; });
}

void NodeSplitting::keep_edges(const std::vector<int>& rows, std::vector<ExtensionConstraint> edges) {
  drop_edges(rows);
  for (int r : rows) known_[r].edges = true;
  for (ExtensionConstraint& t : edges) rows_[row_of(t.constrained.field())].edges.push_back(std::move(t));
}

void NodeSplitting::drop_edges(const std::vector<int>& rows) {
  for (int r : rows) {
    known_[r].edges = false;
    const auto row = rows_.find(r);
    if (row == rows_.end()) continue;
    std::vector<ExtensionConstraint>().swap(row->second.edges);
    std::vector<std::pair<Key, int>>().swap(row->second.dependents);
    if (row->second.copies.empty() && !row->second.lattice) rows_.erase(row);
  }
}

// Returns the present representative of a node of the start, or kNoNode if that node has been split since.
Key NodeSplitting::present_representative(const Key& at_start) const {
  const int bond_row = row_of(at_start.field());
  const int layer = copies(bond_row).representative_of_first(layer_of_field(at_start.field()), grid_index_of(at_start));
  return layer < 0 ? kNoNode : key_at(bond_row, layer, grid_index_of(at_start));
}

std::vector<Key> NodeSplitting::nodes_beside(const PointStore& points, int bond_row, int support) const {
  std::vector<Key> nodes;
  const PhantomNodes& copies = this->copies(bond_row);
  const BlockMeta* last = nullptr;
  for (const BlockMeta& m : points.meta) {
    if (m.layer == 0) continue;
    if (last && m.layer == last->layer && m.joined == last->joined && std::equal(m.base, m.base + 3, last->base)) continue;
    last = &m;
    for_each_node(m, support, [&](const GridIndex& p) { nodes.push_back(key_at(bond_row, copies.representative(m.layer, p), p)); });
  }
  // The constraint of a node that has split since is void, and is stored only on ranks that found it before.
  for (const ExtensionConstraint& t : row(bond_row).edges) {
    if (present_representative(t.constrained) == kNoNode) continue;
    for (const auto* of_constraint : {&t.masters, &t.mass_receivers})
      for (const auto& m : *of_constraint) nodes.push_back(present_representative(m.first));
  }
  sort_unique(nodes);
  if (!nodes.empty() && nodes.front() == kNoNode) nodes.erase(nodes.begin());
  return nodes;
}

std::vector<Key> NodeSplitting::copies_of(int bond_row) const {
  std::vector<Key> nodes;
  const PhantomNodes& copies = this->copies(bond_row);
  for (const auto& row : copies.rows())
    for (const PhantomNodes::Entry& e : row.second)
      if (e.volume > 0.0 && copies.representative(e.layer, row.first) == e.layer) nodes.push_back(key_at(bond_row, e.layer, row.first));
  return nodes;
}

std::vector<Key> NodeSplitting::nodes_of(const BlockMeta& m, int support) {
  std::vector<Key> nodes;
  for_each_node(m, support, [&](const GridIndex& p) { nodes.push_back(key_at(m.row, m.layer, p)); });
  return nodes;
}

Key NodeSplitting::representative_of(const Key& k) const {
  const int bond_row = row_of(k.field());
  return key_at(bond_row, copies(bond_row).representative(layer_of_field(k.field()), grid_index_of(k)), grid_index_of(k));
}

std::vector<Key> NodeSplitting::representatives_of(const BlockMeta& m, int support) const {
  std::vector<Key> nodes;
  const PhantomNodes& copies = this->copies(m.row);
  for_each_node(m, support, [&](const GridIndex& p) { nodes.push_back(key_at(m.row, copies.representative(m.layer, p), p)); });
  return nodes;
}

std::vector<Key> NodeSplitting::representatives_at(int bond_row, const std::vector<Key>& split) const {
  std::vector<Key> nodes;
  const PhantomNodes& copies = this->copies(bond_row);
  for (const Key& k : split)
    for (const PhantomNodes::Entry& e : *copies.row(grid_index_of(k)))
      nodes.push_back(key_at(bond_row, copies.representative(e.layer, grid_index_of(k)), grid_index_of(k)));
  return nodes;
}

void NodeSplitting::find_dependents(Row& row) const {
  for (std::size_t n = 0; n < row.edges.size(); ++n)
    for (const auto* of_constraint : {&row.edges[n].masters, &row.edges[n].mass_receivers})
      for (const auto& m : *of_constraint) row.dependents.emplace_back(m.first, static_cast<int>(n));
  sort_unique(row.dependents);
}

// Finds nodes of all layers at the grid indices that split, and edge nodes with masters or mass receivers there at the
// start. Most layers are small, so each is searched by itself.
std::vector<int> NodeSplitting::nodes_touched(const Grid& grid, int bond_row, const std::vector<Key>& split) {
  Row& row = rows_[bond_row];
  if (row.dependents.empty()) find_dependents(row);
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
  std::vector<Key> constrained_nodes;
  for (const Key& k : split) {
    for (const OfField& f : fields)
      if (const int node = node_in(f, k.with_field(f.field)); node >= 0) nodes.push_back(node);
    for (const PhantomNodes::Entry& e : *row.copies.row(grid_index_of(k))) {
      const Key first = key_at(bond_row, e.first, grid_index_of(k));
      for (auto u = std::lower_bound(row.dependents.begin(), row.dependents.end(), std::make_pair(first, 0));
           u != row.dependents.end() && u->first == first; ++u)
        constrained_nodes.push_back(row.edges[u->second].constrained);
    }
  }
  sort_unique(constrained_nodes);
  for (const Key& s : constrained_nodes)
    for (const OfField& f : fields) {
      const Key k = s.with_field(f.field);
      if (const int node = node_in(f, k); node >= 0 && at_start(k) == s) nodes.push_back(node);
    }
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

Key NodeSplitting::at_start(const Key& k) const {
  const int bond_row = row_of(k.field());
  const PhantomNodes& copies = this->copies(bond_row);
  return copies.empty() ? key_at(bond_row, 0, grid_index_of(k))
                        : key_at(bond_row, copies.at(layer_of_field(k.field()), grid_index_of(k)).first, grid_index_of(k));
}

Key NodeSplitting::next(const Key& k, int direction) const {
  const int bond_row = row_of(k.field()), first = copies(bond_row).continuation(grid_index_of(k), layer_of_field(k.field()), direction);
  if (first < 0) return kNoNode;
  GridIndex p = grid_index_of(k);
  p[direction / 2] += direction % 2 == 0 ? -1 : 1;
  return key_at(bond_row, first, p);
}

// An edge constraint is void once its node, a master or a mass receiver has split. A copy then follows its representative.
std::vector<ExtensionConstraint> NodeSplitting::constraints(const std::vector<Key>& keys) const {
  std::vector<ExtensionConstraint> constraints;
  constraints.reserve(keys.size());
  for (const Key& k : keys) {
    ExtensionConstraint t;
    t.constrained = k;
    const Key start = at_start(k);
    const std::vector<ExtensionConstraint>& edges = row(row_of(k.field())).edges;
    const auto edge =
        std::lower_bound(edges.begin(), edges.end(), start, [](const ExtensionConstraint& a, const Key& b) { return a.constrained < b; });
    if (edge != edges.end() && edge->constrained == start && present_representative(start) != kNoNode) {
      for (const auto& m : edge->masters) t.masters.emplace_back(present_representative(m.first), m.second);
      for (const auto& h : edge->mass_receivers) t.mass_receivers.emplace_back(present_representative(h.first), h.second);
      for (const auto& b : edge->behind) t.behind.emplace_back(present_representative(b.first), b.second);
    }
    const bool whole = !t.masters.empty() &&
                       std::none_of(t.masters.begin(), t.masters.end(), [](const auto& m) { return m.first == kNoNode; }) &&
                       std::none_of(t.mass_receivers.begin(), t.mass_receivers.end(), [](const auto& h) { return h.first == kNoNode; });
    if (!whole) {
      const int layer = layer_of_field(k.field()), stands = copies(row_of(k.field())).representative(layer, grid_index_of(k));
      if (stands == layer) continue;
      const Key master = key_at(row_of(k.field()), stands, grid_index_of(k));
      t.masters.assign(1, {master, 1.0});
      t.mass_receivers = t.behind = t.masters;
    }
    std::sort(t.masters.begin(), t.masters.end());
    constraints.push_back(std::move(t));
  }
  return constraints;
}

std::vector<double> NodeSplitting::volumes(const std::vector<Key>& keys, const CementOptions& options) const {
  if (!options.shares_failed_mass()) return {};
  if (keys.empty() || copies(row_of(keys.front().field())).empty()) return {};
  const PhantomNodes& copies = this->copies(row_of(keys.front().field()));
  std::vector<double> given(keys.size(), -1.0);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const GridIndex node = grid_index_of(keys[i]);
    if (!copies.row(node)) continue;
    const int layer = layer_of_field(keys[i].field());
    given[i] = copies.representative(layer, node) == layer ? copies.at(layer, node).volume : 0.0;
  }
  return given;
}

}  // namespace mpdem
