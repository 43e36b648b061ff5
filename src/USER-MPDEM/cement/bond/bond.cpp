// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "bond.h"

#include <algorithm>

namespace mpdem {

void Bond::sort_links() {
  const auto by_slot = [](const Link& x, const Link& y) { return x.slot < y.slot; };
  if (!std::is_sorted(points.links.begin(), points.links.end(), by_slot)) links.renumber(points.sort_links());
}

std::vector<Bonds::Slot>::const_iterator Bonds::slot_of(int bond_row) const {
  return std::lower_bound(here_.begin(), here_.end(), bond_row, [](const Slot& b, int row) { return b->row < row; });
}

Bond* Bonds::find(int bond_row) {
  const auto at = slot_of(bond_row);
  return at != here_.end() && (*at)->row == bond_row ? at->get() : nullptr;
}

const Bond* Bonds::find(int bond_row) const {
  const auto at = slot_of(bond_row);
  return at != here_.end() && (*at)->row == bond_row ? at->get() : nullptr;
}

Bond& Bonds::make(int bond_row) {
  if (!here_.empty() && here_.back()->row == bond_row) return *here_.back();
  auto at = slot_of(bond_row);
  if (at == here_.end() || (*at)->row != bond_row) {
    at = here_.insert(at, std::make_unique<Bond>());
    resolved_is_known_ = false;
    (*at)->row = bond_row;
  }
  return **at;
}

void Bonds::drop_empty(const std::vector<int>& rows) {
  const auto is_empty = [](const Slot& b) {
    const auto stores = b->stores();
    return std::all_of(stores.begin(), stores.end(), [](const PointStore* s) { return s->blocks.empty(); });
  };
  const bool some = std::any_of(rows.begin(), rows.end(), [&](int row) {
    const auto at = slot_of(row);
    return at != here_.end() && (*at)->row == row && is_empty(*at);
  });
  if (some) here_.erase(std::remove_if(here_.begin(), here_.end(), is_empty), here_.end());
  if (some) resolved_is_known_ = false;
  here_.shrink_to_fit();
  table.shrink_to_fit();
}

std::vector<int> Bonds::resolved_rows() const {
  std::vector<int> rows;
  for (std::size_t row = 0; row < table.size(); ++row)
    if (!table[row].condensed) rows.push_back(static_cast<int>(row));
  return rows;
}

std::vector<int> Bonds::rows_without_points() const {
  std::vector<int> rows;
  for (std::size_t row = 0; row < table.size(); ++row)
    if (table[row].point_template > 0) rows.push_back(static_cast<int>(row));
  return rows;
}

const std::vector<int>& Bonds::resolved_indices() const {
  if (resolved_is_known_) return resolved_;
  resolved_is_known_ = true;
  resolved_.clear();
  for (std::size_t n = 0; n < here_.size(); ++n)
    if (is_resolved(*here_[n])) resolved_.push_back(static_cast<int>(n));
  return resolved_;
}

std::size_t Bonds::memory_usage() const {
  std::size_t bytes = table.capacity() * sizeof(BondRecord) + here_.capacity() * sizeof(Slot);
  for (const PointTemplate& p : templates) bytes += p.memory_usage();
  for (const Slot& b : here_) bytes += sizeof(Bond) + b->memory_usage();
  return bytes;
}

}  // namespace mpdem
