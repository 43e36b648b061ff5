// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "loose_cement.h"

#include <algorithm>

#include "../../mpm/block_nodes.h"
#include "../../numerics/sort_unique.h"
#include "../../parallel/gather_ranks.h"
#include "../condensed/rigid_pieces.h"

namespace mpdem {

namespace {

// Slots of the loose points of a separated bond on this rank. Collective for the ranks that share its nodes.
std::vector<int> loose_slots(Bond& b) {
  const std::vector<signed char> grain_of_node = attached_grains_of_nodes(b);
  std::vector<int> slots;
  b.for_each_slot_of(Bond::kOnGrid, [&](int slot) {
    bool attached = b.points.connected(slot) != 0;
    if (b.points.has_failed(slot)) {
      attached = false;
      for_each_node_of_lane(b.grid, b.points.meta[slot / kLanes], slot % kLanes,
                            [&](int i) { attached = attached || grain_of_node[i] >= 0; });
    }
    if (!attached) slots.push_back(slot);
  });
  return slots;
}

}  // namespace

bool LooseCement::examine() {
  const FragmentRule& rule = scene_.options.fragments;
  if (!rule.drop || !scene_.laid_out) return false;
  const std::int64_t now = scene_.now.number;
  if (step_ >= 0 && now > step_) clock_ += static_cast<double>(now - step_) * scene_.now.dt * scene_.now.substeps;
  step_ = now;
  if (rule.bonds) note_bonds();
  else note_points();
  if (std::none_of(since_.begin(), since_.end(), [this](const auto& one) { return is_old(one.second); })) return false;
  const Due found = due();
  int mine = !found.slots.empty() || !found.bonds.empty(), any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, scene_.comm);
  return any != 0;
}

void LooseCement::note_bonds() {
  const std::vector<BondRecord>& table = scene_.bonds().table;
  for (std::size_t row = 0; row < table.size(); ++row)
    if (cracks_.separated(row) && table[row].points > 0) since_.emplace(Place{static_cast<int>(row), 0}, clock_);
}

void LooseCement::note_points() {
  std::vector<Place> mine;
  for (int row : scene_.bonds().resolved_rows()) {
    Bond* b = cracks_.separated(row) ? scene_.bonds().find(row) : nullptr;
    if (!b) continue;
    for (int slot : loose_slots(*b)) {
      const Place place{row, b->points.tag(slot)};
      if (since_.count(place) == 0) mine.push_back(place);
    }
  }
  for (const Place& place : gather_all(scene_.comm, mine)) since_.emplace(place, clock_);
}

// Times are sums of steps, and may miss the limit by rounding.
bool LooseCement::is_old(double since) const { return clock_ - since >= scene_.options.fragments.age - 0.5 * scene_.now.dt; }

// With `bonds` condensed ones too. The fragments of another condensed bond belong to its pieces.
std::vector<int> LooseCement::rows_with_old_cement() const {
  std::vector<int> rows;
  for (const auto& one : since_) {
    const BondRecord& record = scene_.bonds().table[one.first.first];
    const bool of_all = one.first.second == 0;
    if (is_old(one.second) && record.points > 0 && of_all == scene_.options.fragments.bonds && (of_all || !record.condensed))
      rows.push_back(one.first.first);
  }
  sort_unique(rows);
  return rows;
}

LooseCement::Due LooseCement::due() const {
  const FragmentRule& rule = scene_.options.fragments;
  Due due;
  if (!rule.drop || !scene_.laid_out) return due;
  const std::vector<int> rows = rows_with_old_cement();
  if (rule.bonds) {
    due.bonds = rows;
    return due;
  }
  const bool of_any_size = rule.below_points == 0 && rule.below_share == 0.0;
  std::map<int, std::vector<int>> sizes;
  if (!of_any_size) sizes = cracks_.piece_sizes(scene_.comm, scene_.bonds(), scene_.options, rows);
  const auto is_small = [&](int row, int slot) {
    if (of_any_size) return true;
    const int size = sizes[row][slot];
    return (rule.below_points == 0 || size < rule.below_points) &&
           (rule.below_share == 0.0 || size < rule.below_share * scene_.bonds().table[row].points);
  };
  for (int row : rows) {
    const Bond* b = scene_.bonds().find(row);
    if (!b) continue;
    b->for_each_slot_of(Bond::kOnGrid, [&](int slot) {
      const auto at = since_.find({row, b->points.tag(slot)});
      if (at != since_.end() && is_old(at->second) && is_small(row, slot)) due.slots[row].push_back(slot);
    });
  }
  return due;
}

// Times of points that are still there stay as they are.
void LooseCement::forget(const std::vector<int>& rows) {
  std::vector<Place> mine;
  for (int row : rows)
    if (const Bond* b = scene_.bonds().find(row))
      b->for_each_slot_of(Bond::kOnGrid, [&](int slot) {
        const Place place{row, b->points.tag(slot)};
        if (since_.count(place) != 0) mine.push_back(place);
      });
  std::map<Place, double> kept;
  for (const Place& place : gather_all(scene_.comm, mine)) kept.emplace(place, since_[place]);
  for (int row : rows) {
    const int first = scene_.bonds().table[row].points > 0 ? 1 : 0;  // the time of all cement of a bond has the tag 0
    since_.erase(since_.lower_bound({row, first}), since_.lower_bound({row + 1, 0}));
  }
  since_.insert(kept.begin(), kept.end());
}

std::vector<LooseCement::Loose> LooseCement::times() const {
  std::vector<Loose> all;
  for (const auto& one : since_) all.push_back({one.first.first, one.first.second, one.second});
  return all;
}

void LooseCement::restore(double clock, std::int64_t step, const std::vector<Loose>& times) {
  clock_ = clock;
  step_ = step;
  since_.clear();
  for (const Loose& l : times) since_[{l.row, l.tag}] = l.since;
}

}  // namespace mpdem
