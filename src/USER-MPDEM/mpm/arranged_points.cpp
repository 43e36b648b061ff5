// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Assigns points to blocks and lanes for PointStore::arrange().
#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "point_store.h"

namespace mpdem {

namespace {

struct Item {
  int row, layer, material, base[3], tag, slot;
  int to_layer;  // new layer of the point; `layer` is the same, or 0 where a block may have several layers (`stay` of arrange())
};

bool same_cell(const Item& a, const Item& b) {
  return a.row == b.row && a.layer == b.layer && a.material == b.material && a.base[0] == b.base[0] && a.base[1] == b.base[1] &&
         a.base[2] == b.base[2];
}

bool cell_before(const Item& a, const Item& b) {
  if (a.row != b.row) return a.row < b.row;
  if (a.layer != b.layer) return a.layer < b.layer;
  if (a.material != b.material) return a.material < b.material;
  for (int d = 0; d < 3; ++d)
    if (a.base[d] != b.base[d]) return a.base[d] < b.base[d];
  return false;
}

// Items of a block: those of its first cell, and those of the next cells in its row.
struct Plan {
  int first = 0, count = 0;
  int joined = kOneCell;  // code of the row of cells
  struct Cell {
    int first = 0, count = 0;
  } more[kMostReach];
  int total() const { return count + more[0].count + more[1].count; }
  int lane[kLanes] = {0, 1, 2, 3, 4, 5, 6, 7};  // lane of each item, in the order of the items
  // Item of each lane, -1 if it is empty.
  std::array<int, kLanes> by_lane() const {
    std::array<int, kLanes> items;
    items.fill(-1);
    int n = 0;
    const auto give = [&](int begin, int many) {
      for (int i = 0; i < many; ++i) items[lane[n++]] = begin + i;
    };
    give(first, count);
    for (const Cell& c : more) give(c.first, c.count);
    return items;
  }
};

// Merges partly filled blocks of cells in a row.
class BlockMerger {
 public:
  // partial: plans of the blocks that are not full, in the order of their cells.
  BlockMerger(const std::vector<Item>& items, std::vector<Plan>& plans, const std::vector<int>& partial)
      : items_(items), plans_(plans), partial_(partial), gone_(plans.size(), 0) {}

  // Merges partial block a with those of the next cells along an axis, if their points fit into one block. Takes the
  // choice with most points. Among equals, two cells come before three, and the last direction comes first, since there
  // columns only get longer.
  void join(int a) {
    Plan& p = plans_[a];
    if (gone_[a] || p.joined != kOneCell) return;
    int best = 0, joined = kOneCell, with[kMostReach] = {-1, -1};
    const auto consider = [&](int d, int reach, int one, int other) {
      const int more = count(one) + count(other);
      if (more <= best || p.count + more > kLanes) return;
      best = more;
      joined = cells_in_a_row(d, reach);
      with[0] = one;
      with[1] = other;
    };
    int next[3][kMostReach];
    for (int d = 2; d >= 0; --d) {
      for (int r = 1; r <= kMostReach; ++r) next[d][r - 1] = beside(a, d, r);
      consider(d, 1, next[d][0], -1);
    }
    for (int d = 2; d >= 0; --d)
      if (next[d][1] >= 0) {
        consider(d, 2, -1, next[d][1]);
        consider(d, 2, next[d][0], next[d][1]);
      }
    p.joined = joined;
    for (int r = 0; r < kMostReach; ++r) {
      if (with[r] < 0) continue;
      p.more[r] = {plans_[with[r]].first, plans_[with[r]].count};
      gone_[with[r]] = 1;
    }
  }

  bool gone(int a) const { return gone_[a]; }

 private:
  int count(int a) const { return a < 0 ? 0 : plans_[a].count; }
  // The partial block of the cell `reach` ahead along d, or -1 if there is none or it is merged already.
  int beside(int a, int d, int reach) const {
    Item next = items_[plans_[a].first];
    next.base[d] += reach;
    const auto at = std::lower_bound(partial_.begin(), partial_.end(), next,
                                     [&](int b, const Item& i) { return cell_before(items_[plans_[b].first], i); });
    if (at == partial_.end() || !same_cell(items_[plans_[*at].first], next)) return -1;
    return gone_[*at] || plans_[*at].joined != kOneCell ? -1 : *at;
  }
  const std::vector<Item>& items_;
  std::vector<Plan>& plans_;
  const std::vector<int>& partial_;
  std::vector<char> gone_;
};

// Plans blocks for items that are sorted by cell. join: partial blocks may be merged.
std::vector<Plan> plan_blocks(const std::vector<Item>& items, bool join) {
  std::vector<Plan> plans;
  std::vector<int> partial;  // blocks that are not full, each the last of its cell, in the order of cells
  const int n = static_cast<int>(items.size());
  for (int i = 0; i < n;) {
    Plan p;
    p.first = i;
    while (p.count < kLanes && i < n && same_cell(items[p.first], items[i])) ++p.count, ++i;
    if (p.count < kLanes) partial.push_back(static_cast<int>(plans.size()));
    plans.push_back(p);
  }
  if (!join) return plans;
  BlockMerger joiner(items, plans, partial);
  for (const int a : partial) joiner.join(a);
  std::size_t kept = 0;
  for (std::size_t b = 0; b < plans.size(); ++b)
    if (!joiner.gone(static_cast<int>(b))) plans[kept++] = plans[b];
  plans.resize(kept);
  return plans;
}

// Finds the lanes of the items of one cell, if these are in columns of a lattice (columns.h); else the lanes stay. Columns of a box are
// numbered by the halves of the cell along x and y in which they lie, others as they come. X, middle: positions, and middle of the cell.
void assign_column_lanes(Plan& p, const double (*X)[3], const double* middle) {
  int lane[kLanes];
  const double *height[2] = {}, *column[4] = {};
  bool box = true;
  for (int n = 0; n < p.count; ++n) {
    const int q = 2 * (X[n][0] > middle[0]) + (X[n][1] > middle[1]);
    if (!column[q]) column[q] = X[n];
    box = box && column[q][0] == X[n][0] && column[q][1] == X[n][1];
  }
  if (!box) std::fill_n(column, 4, nullptr);
  unsigned taken = 0;
  for (int n = 0; n < p.count; ++n) {
    const int upper = X[n][2] > middle[2];
    if (!height[upper]) height[upper] = &X[n][2];
    int q = 0;
    while (q < 4 && column[q] && (column[q][0] != X[n][0] || column[q][1] != X[n][1])) ++q;
    if (box) q = 2 * (X[n][0] > middle[0]) + (X[n][1] > middle[1]);
    lane[n] = 2 * q + upper;
    if (q == 4 || *height[upper] != X[n][2] || (taken >> lane[n] & 1)) return;
    column[q] = X[n];
    taken |= 1u << lane[n];
  }
  std::copy_n(lane, p.count, p.lane);
}

// Gives empty lanes the coordinate of the points in their group. A group without points gets the coordinate of another
// group. Returns false and changes nothing if points of a group differ in this coordinate.
bool share_coordinates(vd& X, std::uint8_t occupied, const int (&group)[kLanes], int groups) {
  double place[4];
  unsigned found = 0;
  for (int l = 0; l < kLanes; ++l) {
    if (!(occupied >> l & 1)) continue;
    if ((found >> group[l] & 1) && place[group[l]] != X[l]) return false;
    place[group[l]] = X[l];
    found |= 1u << group[l];
  }
  for (int g = 0; g < groups; ++g)
    if (!(found >> g & 1)) place[g] = found ? place[__builtin_ctz(found)] : X[0];
  for (int l = 0; l < kLanes; ++l) X[l] = place[group[l]];
  return true;
}

}  // namespace

void PointStore::find_lattice(int b) {
  // Groups of lanes with the same coordinate: x and y of a box, z of all lattices, and x and y of single columns.
  const int first[kLanes] = {0, 0, 0, 0, 1, 1, 1, 1}, second[kLanes] = {0, 0, 1, 1, 0, 0, 1, 1}, height[kLanes] = {0, 1, 0, 1, 0, 1, 0, 1};
  const int column[kLanes] = {0, 0, 1, 1, 2, 2, 3, 3};
  BlockMeta& m = meta[b];
  m.lattice = Lattice::none;
  if (m.joined != kOneCell || !motion.empty()) return;
  vd(&X)[3] = blocks[b].X;
  if (!share_coordinates(X[2], m.occupied, height, 2)) return;
  vd x = X[0], y = X[1];
  if (share_coordinates(x, m.occupied, first, 2) && share_coordinates(y, m.occupied, second, 2)) m.lattice = Lattice::box;
  else if (share_coordinates(x = X[0], m.occupied, column, 4) && share_coordinates(y = X[1], m.occupied, column, 4))
    m.lattice = Lattice::columns;
  else return;
  X[0] = x;
  X[1] = y;
}

std::vector<int> PointStore::arrange(double cell, Basis basis, const std::map<int, int>& new_layer, bool stay) {
  const double inverse_h = 1.0 / cell, shift = cell_shift(basis);
  std::vector<Item> items;
  items.reserve(kLanes * blocks.size());
  auto moved = new_layer.begin();
  for (int slot = 0; slot < kLanes * static_cast<int>(blocks.size()); ++slot) {
    const int b = slot / kLanes, l = slot % kLanes;
    if (!(meta[b].occupied >> l & 1)) continue;
    Item it{meta[b].row, 0, meta[b].material, {}, tags[b][l], slot, meta[b].layer};
    while (moved != new_layer.end() && moved->first < slot) ++moved;
    if (moved != new_layer.end() && moved->first == slot) it.to_layer = moved->second;
    if (!stay) it.layer = it.to_layer;
    for (int d = 0; d < 3; ++d) it.base[d] = support_base(blocks[b].X[d][l], inverse_h, shift);
    items.push_back(it);
  }
  std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return same_cell(a, b) ? a.tag < b.tag : cell_before(a, b); });

  std::vector<Plan> plans = plan_blocks(items, stay && may_join_cells(basis));
  for (Plan& p : plans) {
    if (!stay || p.joined != kOneCell) continue;
    double X[kLanes][3], middle[3];
    for (int d = 0; d < 3; ++d) {
      middle[d] = (items[p.first].base[d] + cell_middle(basis)) * cell;
      for (int n = 0; n < p.count; ++n) X[n][d] = blocks[items[p.first + n].slot / kLanes].X[d][items[p.first + n].slot % kLanes];
    }
    assign_column_lanes(p, X, middle);
  }
  std::vector<std::array<int, kLanes>> lanes_of;
  std::vector<Family> families;
  for (const Plan& p : plans) {
    families.emplace_back();
    lanes_of.push_back(p.by_lane());
    for (int l = 0; l < kLanes; ++l) {
      if (lanes_of.back()[l] < 0) continue;
      const Item& item = items[lanes_of.back()[l]];
      families.back().layer[l] = item.to_layer;
      std::copy(item.base, item.base + 3, families.back().cell[l].begin());
    }
  }
  PointStore next;
  next.homes_ = static_cast<int>(plans.size());
  for (int h = 0; h < next.homes_; ++h)
    for (int layer : families[h].others()) next.copies_.push_back({h, layer});
  next.reserve_like(*this, plans.size() + next.copies_.size());
  std::vector<int> new_slot(kLanes * blocks.size(), -1);
  for (std::size_t n = 0; n < plans.size() + next.copies_.size(); ++n) {
    const bool is_home = n < plans.size();
    const int home = is_home ? static_cast<int>(n) : next.copies_[n - plans.size()].home;
    const int layer = is_home ? families[home].first() : next.copies_[n - plans.size()].layer;
    next.add_block(items[plans[home].first].row, layer, families[home], cell, basis);
    next.meta.back().material = static_cast<std::uint8_t>(items[plans[home].first].material);
    if (!motion.empty()) next.start_motion();
    for (int l = 0; l < kLanes; ++l) {
      if (lanes_of[home][l] < 0) continue;
      const Item& item = items[lanes_of[home][l]];
      if (item.to_layer != layer) continue;
      next.add_record(kLanes * static_cast<int>(n) + l, record(item.slot), item.tag);
      new_slot[item.slot] = kLanes * static_cast<int>(n) + l;
    }
    if (stay) next.find_lattice(static_cast<int>(n));
  }
  *this = std::move(next);
  return new_slot;
}

}  // namespace mpdem
