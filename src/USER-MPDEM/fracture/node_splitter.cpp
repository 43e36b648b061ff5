// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Class NodeSplitter, see phantom_nodes.h.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "phantom_nodes.h"
#include "../numerics/index_in.h"
#include "../numerics/sort_unique.h"
#include "points_around.h"

namespace mpdem {

namespace {

constexpr int kOut = -2, kIn = -1;  // values of component_of_: not in the group; in it, but in no component yet

bool same_cell(const SplitterPoint& a, const SplitterPoint& b) {
  return a.cell[0] == b.cell[0] && a.cell[1] == b.cell[1] && a.cell[2] == b.cell[2];
}

bool before(const SplitterPoint& a, const SplitterPoint& b) {
  const GridIndex x = grid_index(a.cell), y = grid_index(b.cell);
  return x != y ? x < y : a.tag < b.tag;
}

}  // namespace

NodeSplitter::NodeSplitter(std::vector<SplitterPoint> points, Basis basis, const Line& line)
    : points_(std::move(points)), basis_(basis), S_(support(basis)), line_(line) {
  std::sort(points_.begin(), points_.end(), before);
  const int n = static_cast<int>(points_.size());
  at_.reserve(n);
  for (int i = 0; i < n; ++i) one_a_cell_ = at_.emplace(grid_index(points_[i].cell), i).second && one_a_cell_;
  next_.resize(n);
  for (int i = 0; i < n; ++i)
    for (int face = 0; face < 6; ++face) {
      GridIndex c = grid_index(points_[i].cell);
      c[face / 2] += face % 2 == 0 ? -1 : 1;
      const auto next = at_.find(c);
      next_[i][face] = next == at_.end() ? -1 : next->second;
    }
  by_tag_.resize(n);
  std::iota(by_tag_.begin(), by_tag_.end(), 0);
  std::sort(by_tag_.begin(), by_tag_.end(), [&](int a, int b) { return points_[a].tag < points_[b].tag; });
  by_base_.resize(n);
  std::iota(by_base_.begin(), by_base_.end(), 0);
  std::stable_sort(by_base_.begin(), by_base_.end(),
                   [&](int a, int b) { return grid_index(points_[a].base) < grid_index(points_[b].base); });
  for (int k = 0; k < n;) {
    const GridIndex base = grid_index(points_[by_base_[k]].base);
    const int first = k;
    while (k < n && grid_index(points_[by_base_[k]].base) == base) ++k;
    base_[base] = {first, k};
  }
  component_of_.assign(n, kOut);
}

// Returns the number that for_each_node() gives to a node of the support with this base.
int NodeSplitter::number_of(const GridIndex& node, const GridIndex& base) const {
  return (S_ * (node[0] - base[0]) + node[1] - base[1]) * S_ + node[2] - base[2];
}

// Calls f for the points connected to a point. All points of one cell are connected.
template <class F>
void NodeSplitter::for_each_neighbour(int i, F f) const {
  const SplitterPoint& p = points_[i];
  const int n = static_cast<int>(points_.size());
  const auto of_cell = [&](int first, int j) { return j < n && (j == first || (!one_a_cell_ && same_cell(points_[j], points_[first]))); };
  if (!one_a_cell_) {
    for (int j = i - 1; j >= 0 && same_cell(points_[j], p); --j) f(j);
    for (int j = i + 1; of_cell(i, j); ++j) f(j);
  }
  for (int face = 0; face < 6; ++face) {
    const int first = next_[i][face];
    if (first < 0) continue;
    for (int j = first; of_cell(first, j); ++j)
      if (connected(p, points_[j], face)) f(j);
  }
}

NodeChange NodeSplitter::start(PhantomNodes& copies, const UnbondedGap& unbonded_gap) {
  unbonded_gap_ = &unbonded_gap;
  std::vector<int> all(by_base_);
  NodeChange change = split(nodes_of(all), copies);
  unbonded_gap_ = nullptr;
  copies.start();
  find_continuations(copies);
  return change;
}

std::vector<GridIndex> NodeSplitter::nodes_of(const std::vector<int>& points) const {
  std::vector<GridIndex> nodes;
  for (int i : points) for_each_node(points_[i].base, [&](const GridIndex& n, int) { nodes.push_back(n); });
  sort_unique(nodes);
  return nodes;
}

NodeChange NodeSplitter::fail(const std::vector<int>& tags, PhantomNodes& copies) {
  std::vector<GridIndex> nodes;
  for (int tag : tags) {
    const int i = by_tag_[index_in(
        by_tag_, tag, [&](int p) { return points_[p].tag; }, "point")];
    points_[i].failed = true;
    add_nodes_split_by(i, copies, nodes);
  }
  sort_unique(nodes);
  return split(nodes, copies);
}

// Adds the nodes that a failed point may split. It splits a node only if the points that share a face with it are not
// connected around it in the support. Most are connected over the 26 points around it, so few nodes must be examined as
// a whole. Points that fail in the same step are taken one after the other.
void NodeSplitter::add_nodes_split_by(int i, const PhantomNodes& copies, std::vector<GridIndex>& nodes) const {
  const SplitterPoint& p = points_[i];
  if (!one_a_cell_) {
    for_each_node(p.base, [&](const GridIndex& n, int) { nodes.push_back(n); });
    return;
  }
  const Around around(*this, i);
  for_each_node(p.base, [&](const GridIndex& n, int) {
    unsigned mask = 0;
    for (unsigned left = around.intact; left; left &= left - 1) {
      const int q = __builtin_ctz(left);
      const SplitterPoint& other = points_[around.point_at[q]];
      bool in_support = true;
      for (int d = 0; d < 3; ++d) in_support = in_support && n[d] >= other.base[d] && n[d] < other.base[d] + S_;
      mask |= static_cast<unsigned>(in_support) << q;
    }
    if (const PhantomNodes::Row* row = (mask & around.faces) ? copies.row(n) : nullptr) {
      const int mine = PhantomNodes::copy_of(*row, p.layer);
      for (unsigned left = mask; left; left &= left - 1) {
        const int q = __builtin_ctz(left);
        if (PhantomNodes::copy_of(*row, points_[around.point_at[q]].layer) != mine) mask &= ~(1u << q);
      }
    }
    if (!around.are_connected(mask)) nodes.push_back(n);
  });
}

NodeChange NodeSplitter::split_pieces(const std::vector<OfPiece>& pieces, PhantomNodes& copies) {
  std::vector<OfPiece> sorted(pieces);
  const auto by_tag = [](const OfPiece& a, const OfPiece& b) { return a.tag < b.tag; };
  std::sort(sorted.begin(), sorted.end(), by_tag);
  for (SplitterPoint& p : points_)
    p.piece = sorted[index_in(
                         sorted, p.tag, [](const OfPiece& o) { return o.tag; }, "piece of point")]
                  .piece;
  constexpr int kSeveral = std::numeric_limits<int>::min();
  std::unordered_map<GridIndex, int, GridIndexHash, SameGridIndex> piece_at;  // of the points in the support of a node
  for (const auto& b : base_) {
    const int piece = points_[by_base_[b.second.first]].piece;
    bool one = true;
    for (int n = b.second.first; n < b.second.second; ++n) one = one && points_[by_base_[n]].piece == piece;
    for_each_node(b.first.data(), [&](const GridIndex& node, int) {
      int& at = piece_at.emplace(node, piece).first->second;
      if (!one || at != piece) at = kSeveral;
    });
  }
  std::vector<GridIndex> between;
  for (const auto& n : piece_at)
    if (n.second == kSeveral) between.push_back(n.first);
  std::sort(between.begin(), between.end());
  return split(between, copies);
}

NodeChange NodeSplitter::split(const std::vector<GridIndex>& nodes, PhantomNodes& copies) {
  wanted_.clear();
  split_now_.clear();
  for (const GridIndex& n : nodes) examine(n, copies);
  return wanted_.empty() ? NodeChange() : colour(copies);
}

// True if `to` may be in the component of `from`. All points of a component have the same side and piece where these
// count, so its first point represents them.
bool NodeSplitter::may_connect(int from, int to) const {
  const SplitterPoint &a = points_[from], &b = points_[to];
  return a.piece == b.piece && !(sides_split_ && a.nearer != b.nearer);
}

// Splits each copy of a node whose points are not connected.
void NodeSplitter::examine(const GridIndex& node, const PhantomNodes& copies) {
  std::map<int, std::vector<int>> groups;
  if (const PhantomNodes::Row* row = copies.row(node))
    for_each_point(node, [&](int p) { groups[PhantomNodes::copy_of(*row, points_[p].layer)].push_back(p); });
  else for_each_point(node, [&](int p) { groups[0].push_back(p); });
  sides_split_ =
      unbonded_gap_ && unbonded_gap_->found && !std::binary_search(unbonded_gap_->joined.begin(), unbonded_gap_->joined.end(), node);
  int next = groups.empty() ? 0 : groups.rbegin()->first + 1;
  if (const PhantomNodes::Row* row = copies.row(node))  // copies without points keep their numbers
    for (const PhantomNodes::Entry& e : *row) next = std::max(next, e.copy + 1);
  for (const auto& g : groups) split_group(node, g.second, g.first, next, copies);
}

void NodeSplitter::split_group(const GridIndex& node, const std::vector<int>& group, int copy, int& next, const PhantomNodes& copies) {
  for (int i : group) component_of_[i] = kIn;
  std::vector<std::vector<int>> components;
  for (int first : group) {
    if (points_[first].failed || component_of_[first] != kIn) continue;
    const int c = static_cast<int>(components.size());
    components.emplace_back(1, first);
    component_of_[first] = c;
    for (std::size_t n = 0; n < components[c].size(); ++n)
      for_each_neighbour(components[c][n], [&](int j) {
        if (component_of_[j] != kIn || points_[j].failed || !may_connect(first, j)) return;
        component_of_[j] = c;
        components[c].push_back(j);
      });
  }
  if (components.size() > 1) {
    // From here on components are numbered by size. The largest one, 0, keeps the copy.
    std::vector<int> rank(components.size()), of(components.size());
    std::iota(rank.begin(), rank.end(), 0);
    std::stable_sort(rank.begin(), rank.end(), [&](int a, int b) { return components[a].size() > components[b].size(); });
    for (std::size_t n = 0; n < rank.size(); ++n) of[rank[n]] = static_cast<int>(n);
    for (int i : group)
      if (component_of_[i] >= 0) component_of_[i] = of[component_of_[i]];
    find_middles(components, rank);
    assign_failed(group);
    for (int i : group)
      if (component_of_[i] > 0) wanted_[i][node] = next + component_of_[i] - 1;
    share_volume(node, group, copy, next, copies, components, rank);
    next += static_cast<int>(components.size()) - 1;
  }
  for (int i : group) component_of_[i] = kOut;
}

void NodeSplitter::find_middles(const std::vector<std::vector<int>>& components, const std::vector<int>& rank) {
  middles_.clear();
  for (int c : rank) {
    Middle m{static_cast<int>(components[c].size()), {0, 0, 0}, {0, 0, 0}};
    for (int i : components[c]) {
      const std::array<double, 3> position = position_from_middle(i);
      for (int d = 0; d < 3; ++d) {
        m.sum[d] += points_[i].cell[d];
        m.position[d] += position[d] / m.size;
      }
    }
    middles_.push_back(m);
  }
}

// Position of a point from the middle between the grains: along the line of centres, then along the next two axes.
std::array<double, 3> NodeSplitter::position_from_middle(int i) const {
  const auto along = [&](int d) { return points_[i].base[d] + points_[i].at[d] - line_.middle[d]; };
  return {along(line_.axis), along((line_.axis + 1) % 3), along((line_.axis + 2) % 3)};
}

// True if point i is assigned to component a rather than b, which are at equal distance, by the criteria of
// phantom_nodes.h. They let mirrored and rotated cracks split alike.
bool NodeSplitter::prefers_component(int i, int a, int b) const {
  if (middles_[a].size != middles_[b].size) return middles_[a].size > middles_[b].size;
  long long distance[2] = {0, 0};
  for (int d = 0; d < 3; ++d) {
    const long long of_a = static_cast<long long>(middles_[a].size) * points_[i].cell[d] - middles_[a].sum[d];
    const long long of_b = static_cast<long long>(middles_[b].size) * points_[i].cell[d] - middles_[b].sum[d];
    distance[0] += of_a * of_a;
    distance[1] += of_b * of_b;
  }
  if (distance[0] != distance[1]) return distance[0] < distance[1];
  const std::array<double, 3> p = position_from_middle(i);
  std::array<double, 5> order[2];
  for (int n = 0; n < 2; ++n) {
    const double* m = middles_[n == 0 ? a : b].position;
    const double aside = p[1] * m[2] - p[2] * m[1];
    order[n] = {m[1] * m[1] + m[2] * m[2], std::fabs(m[0]), -std::fabs(aside), -aside, -p[0] * m[0]};
  }
  constexpr double kAlike = 1e-6;  // smaller differences are rounding; lengths are in cells
  for (std::size_t k = 0; k < order[0].size(); ++k)
    if (std::fabs(order[0][k] - order[1][k]) > kAlike) return order[0][k] < order[1][k];
  return a < b;
}

// Assigns failed points to the nearest component. Points that no component reaches stay with the first one.
void NodeSplitter::assign_failed(const std::vector<int>& group) {
  std::vector<int> front;
  for (int i : group)
    if (component_of_[i] >= 0) front.push_back(i);
  while (!front.empty()) {
    std::map<int, int> claims;
    for (int i : front)
      for_each_neighbour(i, [&](int j) {
        if (component_of_[j] != kIn) return;
        const auto c = claims.emplace(j, component_of_[i]).first;
        if (prefers_component(j, component_of_[i], c->second)) c->second = component_of_[i];
      });
    front.clear();
    for (const auto& c : claims) {
      component_of_[c.first] = c.second;
      front.push_back(c.first);
    }
  }
  for (int i : group)
    if (component_of_[i] == kIn) component_of_[i] = 0;
}

bool NodeSplitter::Class::operator<(const Class& o) const {
  if (base != o.base) return base < o.base;
  if (layer != o.layer) return layer < o.layer;
  return std::lexicographical_compare(copy.begin(), copy.end(), o.copy.begin(), o.copy.end(),
                                      [](const PhantomNodes::Entry& a, const PhantomNodes::Entry& b) { return a.copy < b.copy; });
}

// Gives points the copies in wanted_, class by class. A class goes to a layer in which no node of its support is another copy. Writes
// the rows of the affected nodes, and lists which nodes inherit the motion of which.
NodeChange NodeSplitter::colour(PhantomNodes& copies) {
  std::map<Class, std::vector<int>> classes;  // points that change, by their new class; its layer is still the old one
  Class was{{}, -1, {}};                      // old class of the last point; points of a class mostly follow each other
  for (const auto& w : wanted_) {
    const SplitterPoint& p = points_[w.first];
    if (was.layer != p.layer || was.base != grid_index(p.base)) {
      was = {grid_index(p.base), p.layer, {}};
      for_each_node(p.base, [&](const GridIndex& n, int) { was.copy.push_back(copies.at(p.layer, n)); });
    }
    Class c = was;
    for (const auto& n : w.second) c.copy[number_of(n.first, c.base)].copy = n.second;
    classes[c].push_back(w.first);
  }
  // Rows of the affected nodes, from the points that do not change.
  std::map<GridIndex, NewRow> rows;
  for (const auto& n : split_now_) rows[n.first];
  for (const auto& c : classes)
    for_each_node(c.first.base.data(), [&](const GridIndex& n, int) {
      if (copies.row(n)) rows[n];
    });
  std::vector<char> changes(points_.size(), 0);
  for (const auto& w : wanted_) changes[w.first] = 1;
  for (auto& r : rows) {
    const PhantomNodes::Row* before = copies.row(r.first);
    int last = -1;
    std::vector<int> with_points;
    for_each_point(r.first, [&](int p) {
      const int layer = points_[p].layer;
      if (before) with_points.push_back(PhantomNodes::copy_of(*before, layer));
      if (changes[p] || layer == last) return;
      r.second.emplace(layer, NewEntry{PhantomNodes::entry_of(before, layer), layer});
      last = layer;
    });
    sort_unique(with_points);
    if (!before) continue;
    for (const PhantomNodes::Entry& e : *before)  // a node stays split when the points of a copy left the simulation
      if (!std::binary_search(with_points.begin(), with_points.end(), e.copy)) r.second.emplace(e.layer, NewEntry{e, e.layer});
  }
  NodeChange change;
  std::vector<NewRow*> of_class;  // row of each node; null if the node is whole
  for (const auto& c : classes) {
    of_class.clear();
    for_each_node(c.first.base.data(), [&](const GridIndex& n, int) {
      const auto row = rows.find(n);
      of_class.push_back(row == rows.end() ? nullptr : &row->second);
    });
    const int layer = free_layer(c.first, of_class);
    for_each_node(c.first.base.data(), [&](const GridIndex& n, int at) {
      if (of_class[at])
        (*of_class[at])[layer] = {{layer, c.first.copy[at].copy, c.first.copy[at].first, c.first.copy[at].volume}, c.first.layer};
      if (layer != c.first.layer) change.sources.push_back({n, layer, copies.representative(c.first.layer, n)});
    });
    if (layer == c.first.layer) continue;
    for (int i : c.second) {
      points_[i].layer = layer;
      change.moved.push_back({points_[i].tag, layer});
    }
  }
  for (const auto& r : rows) {
    PhantomNodes::Row row;
    const auto split = split_now_.find(r.first);
    for (const auto& e : r.second) {
      // The first layer with a copy stands for it: its node has the motion. `stood`: the layer that did so before the change.
      const bool stands = std::none_of(row.begin(), row.end(), [&](const PhantomNodes::Entry& o) { return o.copy == e.second.copy; });
      const int stood = stands ? copies.representative(e.second.old_layer, r.first) : 0;
      if (stands && stood != e.first) change.sources.push_back({r.first, e.first, stood});
      row.push_back(e.second);
      if (split == split_now_.end()) continue;
      const auto volume = split->second.find(e.second.copy);
      if (volume != split->second.end()) row.back().volume = volume->second;
    }
    copies.set(r.first, std::move(row));
    change.rows.push_back(r.first);
  }
  return change;
}

// The layer of the class if its nodes there have no other copies, else the first such layer.
int NodeSplitter::free_layer(const Class& c, const std::vector<NewRow*>& rows) const {
  const auto fits = [&](int layer) {
    for (std::size_t at = 0; at < rows.size(); ++at) {
      if (!rows[at]) continue;
      const auto e = rows[at]->find(layer);
      if (e != rows[at]->end() && e->second.copy != c.copy[at].copy) return false;
    }
    return true;
  };
  if (fits(c.layer)) return c.layer;
  int layer = 0;
  while (!fits(layer)) ++layer;
  return layer;
}

// Finds continuations from cells: in each layer of a cell, neighbouring nodes of its support have one copy each, which continue each other.
void NodeSplitter::find_continuations(PhantomNodes& copies) const {
  constexpr int kUnknown = -2, kNone = -1;
  PhantomNodes::Continuations& continuations = copies.continuations();
  continuations.clear();
  const auto entry = [&](const GridIndex& node, int first) -> std::array<int, 6>& {
    std::vector<PhantomNodes::Continuation>& row = continuations[node];
    for (PhantomNodes::Continuation& t : row)
      if (t.first == first) return t.to;
    row.push_back({first, {}});
    row.back().to.fill(kUnknown);
    return row.back().to;
  };
  std::vector<int> layers, first(S_ * S_ * S_);
  for (const auto& b : base_) {
    bool near = false;
    for_each_node(b.first.data(), [&](const GridIndex& n, int) { near = near || copies.row(n); });
    if (!near) continue;
    layers.clear();
    for (int n = b.second.first; n < b.second.second; ++n) layers.push_back(points_[by_base_[n]].layer);
    sort_unique(layers);
    for (int layer : layers) {
      for_each_node(b.first.data(), [&](const GridIndex& n, int i) { first[i] = copies.at(layer, n).first; });
      for_each_node(b.first.data(), [&](const GridIndex& n, int i) {
        std::array<int, 6>& to = entry(n, first[i]);
        const int stride[3] = {S_ * S_, S_, 1};
        for (int f = 0; f < 6; ++f) {
          const int d = f / 2, step = f % 2 == 0 ? -1 : 1;
          if (n[d] + step < b.first[d] || n[d] + step >= b.first[d] + S_) continue;
          const int next = first[i + step * stride[d]];
          to[f] = to[f] == kUnknown || to[f] == next ? next : kNone;
        }
      });
    }
  }
  // If only cells without split nodes have both nodes of a pair in their support, these nodes are whole.
  for (auto& n : continuations) {
    const bool split = copies.row(n.first);
    for (PhantomNodes::Continuation& t : n.second)
      for (int f = 0; f < 6; ++f) {
        GridIndex next = n.first;
        next[f / 2] += f % 2 == 0 ? -1 : 1;
        if (t.to[f] == kUnknown) t.to[f] = split || copies.row(next) ? kNone : 0;
      }
  }
}

}  // namespace mpdem
