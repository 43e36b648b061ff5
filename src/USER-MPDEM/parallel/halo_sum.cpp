// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "halo_sum.h"

#include <algorithm>

namespace mpdem {

void HaloSum::build(MPI_Comm comm, const std::vector<Key>& keys) {
  comm_ = comm;
  MPI_Comm_rank(comm, &me_);
  shared_ = find_sharing(comm, keys);
  counts_here_.assign(keys.size(), 1);
  union_.clear();
  for (std::size_t n = 0; n < shared_.ranks.size(); ++n) {
    union_.insert(union_.end(), shared_.items[n].begin(), shared_.items[n].end());
    if (shared_.ranks[n] < me_)
      for (int i : shared_.items[n]) counts_here_[i] = 0;
  }
  std::sort(union_.begin(), union_.end());
  union_.erase(std::unique(union_.begin(), union_.end()), union_.end());
  requests_.resize(2 * shared_.ranks.size());
}

std::size_t HaloSum::shared_items() const { return union_.size(); }

void HaloSum::sum(double* values, int width) {
  if (shared_.ranks.empty()) return;
  const std::size_t neighbours = shared_.ranks.size();
  std::size_t total = 0;
  for (const auto& v : shared_.items) total += v.size();
  send_.resize(total * width);
  recv_.resize(total * width);
  std::size_t at = 0;
  for (std::size_t n = 0; n < neighbours; ++n) {
    const auto& items = shared_.items[n];
    const int count = static_cast<int>(items.size()) * width;
    MPI_Irecv(&recv_[at], count, MPI_DOUBLE, shared_.ranks[n], 7301, comm_, &requests_[2 * n]);
    double* s = &send_[at];
    for (int i : items)
      for (int c = 0; c < width; ++c) *s++ = values[static_cast<long>(i) * width + c];
    MPI_Isend(&send_[at], count, MPI_DOUBLE, shared_.ranks[n], 7301, comm_, &requests_[2 * n + 1]);
    at += count;
  }
  // The own part enters at the own rank's place of the order.
  own_.resize(union_.size() * width);
  for (std::size_t u = 0; u < union_.size(); ++u)
    for (int c = 0; c < width; ++c) {
      double& v = values[static_cast<long>(union_[u]) * width + c];
      own_[u * width + c] = v;
      v = 0.0;
    }
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
  const auto add_own = [&] {
    for (std::size_t u = 0; u < union_.size(); ++u)
      for (int c = 0; c < width; ++c) values[static_cast<long>(union_[u]) * width + c] += own_[u * width + c];
  };
  bool own_added = false;
  at = 0;
  for (std::size_t n = 0; n < neighbours; ++n) {
    if (!own_added && shared_.ranks[n] > me_) {
      add_own();
      own_added = true;
    }
    const auto& items = shared_.items[n];
    const double* r = &recv_[at];
    for (int i : items)
      for (int c = 0; c < width; ++c) values[static_cast<long>(i) * width + c] += *r++;
    at += items.size() * width;
  }
  if (!own_added) add_own();
}

}  // namespace mpdem
