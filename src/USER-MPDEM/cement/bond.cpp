// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "bond.h"

#include <algorithm>

namespace mpdem {

void Bond::sort_links() {
  const auto by_slot = [](const Link& x, const Link& y) { return x.slot < y.slot; };
  if (!std::is_sorted(points.links.begin(), points.links.end(), by_slot)) links.renumber(points.sort_links());
}

std::vector<Bonds::Place>::const_iterator Bonds::place_of(int body) const {
  return std::lower_bound(here_.begin(), here_.end(), body, [](const Place& b, int row) { return b->body < row; });
}

Bond* Bonds::find(int body) {
  const auto at = place_of(body);
  return at != here_.end() && (*at)->body == body ? at->get() : nullptr;
}

const Bond* Bonds::find(int body) const {
  const auto at = place_of(body);
  return at != here_.end() && (*at)->body == body ? at->get() : nullptr;
}

Bond& Bonds::make(int body) {
  if (!here_.empty() && here_.back()->body == body) return *here_.back();
  auto at = place_of(body);
  if (at == here_.end() || (*at)->body != body) {
    at = here_.insert(at, std::make_unique<Bond>());
    awake_is_known_ = false;
    (*at)->body = body;
  }
  return **at;
}

void Bonds::drop_empty(const std::vector<int>& rows) {
  const auto is_empty = [](const Place& b) {
    const auto stores = b->stores();
    return std::all_of(stores.begin(), stores.end(), [](const PointStore* s) { return s->blocks.empty(); });
  };
  const bool some = std::any_of(rows.begin(), rows.end(), [&](int row) {
    const auto at = place_of(row);
    return at != here_.end() && (*at)->body == row && is_empty(*at);
  });
  if (some) here_.erase(std::remove_if(here_.begin(), here_.end(), is_empty), here_.end());
  if (some) awake_is_known_ = false;
  here_.shrink_to_fit();
  table.shrink_to_fit();
}

std::vector<int> Bonds::awake_rows() const {
  std::vector<int> rows;
  for (std::size_t row = 0; row < table.size(); ++row)
    if (!table[row].condensed) rows.push_back(static_cast<int>(row));
  return rows;
}

std::vector<int> Bonds::rows_without_points() const {
  std::vector<int> rows;
  for (std::size_t row = 0; row < table.size(); ++row)
    if (table[row].pattern > 0) rows.push_back(static_cast<int>(row));
  return rows;
}

const std::vector<int>& Bonds::awake_places() const {
  if (awake_is_known_) return awake_;
  awake_is_known_ = true;
  awake_.clear();
  for (std::size_t n = 0; n < here_.size(); ++n)
    if (is_awake(*here_[n])) awake_.push_back(static_cast<int>(n));
  return awake_;
}

std::size_t Bonds::memory_usage() const {
  std::size_t bytes = table.capacity() * sizeof(Body) + here_.capacity() * sizeof(Place);
  for (const PointPattern& p : patterns) bytes += p.memory_usage();
  for (const Place& b : here_) bytes += sizeof(Bond) + b->memory_usage();
  return bytes;
}

}  // namespace mpdem
