// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "box_search.h"

namespace mpdem {

BoxSearch::BoxSearch(std::vector<Box> boxes) : boxes_(std::move(boxes)) {
  Vector3 widest = Vector3::Zero();
  double count = 0;
  for (const Box& b : boxes_) {
    if (b.isEmpty()) continue;
    bounds_.extend(b);
    widest = widest.cwiseMax(b.sizes());
    ++count;
  }
  if (count > 0) {
    // Limits the bins along an axis to those along an edge of a cube that has eight bins for each box.
    const double most = std::cbrt(8.0 * count) + 1.0;
    for (int d = 0; d < 3; ++d) {
      const double size = bounds_.sizes()[d];
      bins_[d] = static_cast<int>(std::clamp(widest[d] > 0.0 ? std::floor(size / widest[d]) : most, 1.0, most));
      width_[d] = size > 0.0 ? size / bins_[d] : 1.0;
    }
  }
  begin_.assign(bins_[0] * bins_[1] * bins_[2] + 1, 0);
  const auto for_bins = [&](const Box& b, auto f) {
    if (b.isEmpty()) return;
    const Cell from = cell(b.min()), to = cell(b.max());
    for (int i = from[0]; i <= to[0]; ++i)
      for (int j = from[1]; j <= to[1]; ++j)
        for (int k = from[2]; k <= to[2]; ++k) f(bin({i, j, k}));
  };
  for (const Box& b : boxes_) for_bins(b, [&](int n) { ++begin_[n + 1]; });
  for (std::size_t n = 1; n < begin_.size(); ++n) begin_[n] += begin_[n - 1];
  item_.resize(begin_.back());
  std::vector<int> next = begin_;
  for (std::size_t b = 0; b < boxes_.size(); ++b) for_bins(boxes_[b], [&](int n) { item_[next[n]++] = static_cast<int>(b); });
}

}  // namespace mpdem
