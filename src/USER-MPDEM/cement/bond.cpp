// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "bond.h"

#include <algorithm>

namespace mpdem {

void Bond::sort_links() {
  const auto by_slot = [](const Link& x, const Link& y) { return x.slot < y.slot; };
  if (!std::is_sorted(points.links.begin(), points.links.end(), by_slot)) links.renumber(points.sort_links());
}

namespace {
bool comes_before(const Bond& b, int body) { return b.body < body; }
}  // namespace

Bond* Bonds::find(int body) {
  const auto at = std::lower_bound(here_.begin(), here_.end(), body, comes_before);
  return at != here_.end() && at->body == body ? &*at : nullptr;
}

Bond& Bonds::make(int body) {
  if (!here_.empty() && here_.back().body == body) return here_.back();
  auto at = std::lower_bound(here_.begin(), here_.end(), body, comes_before);
  if (at == here_.end() || at->body != body) {
    at = here_.emplace(at);
    awake_is_known_ = false;
    at->body = body;
  }
  return *at;
}

void Bonds::drop_empty(const std::vector<int>& rows) {
  const auto is_empty = [](const Bond& b) { return b.points.blocks.empty(); };
  const bool some = std::any_of(rows.begin(), rows.end(), [&](int row) {
    const Bond* b = find(row);
    return b && is_empty(*b);
  });
  if (some) here_.erase(std::remove_if(here_.begin(), here_.end(), is_empty), here_.end());
  if (some || here_.capacity() > here_.size()) awake_is_known_ = false;
  here_.shrink_to_fit();
  table.shrink_to_fit();
}

const std::vector<int>& Bonds::awake_places() const {
  if (awake_is_known_) return awake_;
  awake_is_known_ = true;
  awake_.clear();
  for (std::size_t n = 0; n < here_.size(); ++n)
    if (is_awake(here_[n])) awake_.push_back(static_cast<int>(n));
  return awake_;
}

std::size_t Bonds::memory_usage() const {
  std::size_t bytes = table.capacity() * sizeof(Body) + here_.capacity() * sizeof(Bond);
  for (const PointPattern& p : patterns) bytes += p.memory_usage();
  for (const Bond& b : here_) bytes += b.memory_usage();
  return bytes;
}

}  // namespace mpdem
