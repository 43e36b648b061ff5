// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "halo_sum.h"

#include <algorithm>
#include <stdexcept>

#include "../numerics/sort_unique.h"
#include "ranks.h"

namespace mpdem {

namespace {
constexpr int kTag = 7301;
}

void HaloSum::build(MPI_Comm comm, const std::vector<Key>& keys) { build(comm, find_sharing(comm, keys), keys.size()); }

void HaloSum::build(MPI_Comm comm, Sharing shared, std::size_t size) {
  comm_ = comm;
  me_ = rank_in(comm);
  shared_ = std::move(shared);
  counts_here_.assign(size, 1);
  shared_items_.clear();
  for (std::size_t n = 0; n < shared_.ranks.size(); ++n) {
    shared_items_.insert(shared_items_.end(), shared_.items[n].begin(), shared_.items[n].end());
    if (shared_.ranks[n] < me_)
      for (int i : shared_.items[n]) counts_here_[i] = 0;
  }
  sort_unique(shared_items_);
  const HaloSum* const self = this;
  messages_.build(&self, 1);
}

std::size_t HaloSum::shared_items() const { return shared_items_.size(); }

// Sets the values of shared keys to zero. add_own() adds them again when it is the turn of this rank in the order of the ranks.
void HaloSum::take_own(double* values, int width) const {
  own_.resize(shared_items_.size() * width);
  for (std::size_t u = 0; u < shared_items_.size(); ++u)
    for (int c = 0; c < width; ++c) {
      double& v = values[static_cast<long>(shared_items_[u]) * width + c];
      own_[u * width + c] = v;
      v = 0.0;
    }
}

void HaloSum::add_own(double* values, int width) const {
  for (std::size_t u = 0; u < shared_items_.size(); ++u)
    for (int c = 0; c < width; ++c) values[static_cast<long>(shared_items_[u]) * width + c] += own_[u * width + c];
}

void HaloSum::sum(double* values, int width) {
  const HaloSum* const self = this;
  messages_.sum(&self, &values, 1, width);
}

void HaloSums::build(const std::vector<const HaloSum*>& parts) {
  parts_ = parts;
  messages_.build(parts_.data(), parts_.size());
}

void HaloSums::sum(const std::vector<double*>& values, int width) {
  if (values.size() != parts_.size()) throw std::logic_error("sums of nodes need the values of each grid");
  messages_.sum(parts_.data(), values.data(), parts_.size(), width);
}

std::size_t HaloMessages::index_of(int rank) const {
  return static_cast<std::size_t>(std::lower_bound(ranks_.begin(), ranks_.end(), rank) - ranks_.begin());
}

void HaloMessages::build(const HaloSum* const* parts, std::size_t n) {
  ranks_.clear();
  for (std::size_t p = 0; p < n; ++p) ranks_.insert(ranks_.end(), parts[p]->shared_.ranks.begin(), parts[p]->shared_.ranks.end());
  sort_unique(ranks_);
  items_.assign(ranks_.size(), 0);
  for (std::size_t p = 0; p < n; ++p)
    for (std::size_t s = 0; s < parts[p]->shared_.ranks.size(); ++s)
      items_[index_of(parts[p]->shared_.ranks[s])] += parts[p]->shared_.items[s].size();
  send_.resize(ranks_.size());
  recv_.resize(ranks_.size());
  requests_.resize(2 * ranks_.size());
}

void HaloMessages::sum(const HaloSum* const* parts, double* const* values, std::size_t n, int width) {
  if (ranks_.empty()) return;
  const MPI_Comm comm = parts[0]->comm_;
  for (std::size_t r = 0; r < ranks_.size(); ++r) {
    recv_[r].resize(items_[r] * width);
    send_[r].clear();
    send_[r].reserve(items_[r] * width);
    MPI_Irecv(recv_[r].data(), static_cast<int>(recv_[r].size()), MPI_DOUBLE, ranks_[r], kTag, comm, &requests_[2 * r]);
  }
  for (std::size_t p = 0; p < n; ++p) {
    const Sharing& s = parts[p]->shared_;
    for (std::size_t k = 0; k < s.ranks.size(); ++k) {
      std::vector<double>& to = send_[index_of(s.ranks[k])];
      for (int i : s.items[k]) to.insert(to.end(), values[p] + static_cast<long>(i) * width, values[p] + static_cast<long>(i + 1) * width);
    }
  }
  for (std::size_t r = 0; r < ranks_.size(); ++r)
    MPI_Isend(send_[r].data(), static_cast<int>(send_[r].size()), MPI_DOUBLE, ranks_[r], kTag, comm, &requests_[2 * r + 1]);
  for (std::size_t p = 0; p < n; ++p) parts[p]->take_own(values[p], width);
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
  read_.assign(ranks_.size(), 0);
  for (std::size_t p = 0; p < n; ++p) {
    const HaloSum& part = *parts[p];
    bool own_added = false;  // own values come between those of the lower and the higher ranks
    for (std::size_t k = 0; k < part.shared_.ranks.size(); ++k) {
      if (!own_added && part.shared_.ranks[k] > part.me_) {
        part.add_own(values[p], width);
        own_added = true;
      }
      const std::size_t r = index_of(part.shared_.ranks[k]);
      const double* in = &recv_[r][read_[r]];
      for (int i : part.shared_.items[k])
        for (int c = 0; c < width; ++c) values[p][static_cast<long>(i) * width + c] += *in++;
      read_[r] += part.shared_.items[k].size() * width;
    }
    if (!own_added) part.add_own(values[p], width);
  }
}

}  // namespace mpdem
