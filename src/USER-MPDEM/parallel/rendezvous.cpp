// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "rendezvous.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "all_to_all.h"
#include "ranks.h"

namespace mpdem {

namespace {

int home_rank(const Key& k, int ranks) {
  std::uint64_t h = 1469598103934665603ull;
  for (std::uint64_t v : {k.low(), k.high()}) {
    h ^= v;
    h *= 1099511628211ull;
    h ^= h >> 29;
  }
  return static_cast<int>(h % static_cast<std::uint64_t>(ranks));
}

struct Holder {
  Key key;
  int rank, index;
};

// Holders of all ranks for the keys at home here, ordered by key, then rank.
std::vector<Holder> gather_at_home(MPI_Comm comm, const std::vector<Key>& keys) {
  const int ranks = ranks_of(comm), me = rank_in(comm);
  std::vector<std::vector<Holder>> out(ranks);
  for (std::size_t i = 0; i < keys.size(); ++i) out[home_rank(keys[i], ranks)].push_back({keys[i], me, static_cast<int>(i)});
  std::vector<Holder> all = all_to_all(comm, out).data;
  std::sort(all.begin(), all.end(), [](const Holder& a, const Holder& b) { return std::tie(a.key, a.rank) < std::tie(b.key, b.rank); });
  return all;
}

}  // namespace

Sharing find_sharing(MPI_Comm comm, const std::vector<Key>& keys) {
  Sharing shared;
  const int ranks = ranks_of(comm);
  if (ranks == 1) return shared;
  const std::vector<Holder> all = gather_at_home(comm, keys);
  struct Answer {
    int index, other;
  };
  std::vector<std::vector<Answer>> answers(ranks);
  for (std::size_t i = 0; i < all.size();) {
    std::size_t j = i;
    while (j < all.size() && all[j].key == all[i].key) ++j;
    for (std::size_t a = i; a < j; ++a)
      for (std::size_t b = i; b < j; ++b)
        if (a != b) answers[all[a].rank].push_back({all[a].index, all[b].rank});
    i = j;
  }
  const std::vector<Answer> mine = all_to_all(comm, answers).data;
  std::vector<std::vector<int>> items(ranks);
  for (const Answer& a : mine) items[a.other].push_back(a.index);
  for (int r = 0; r < ranks; ++r) {
    if (items[r].empty()) continue;
    std::sort(items[r].begin(), items[r].end());
    shared.ranks.push_back(r);
    shared.items.push_back(std::move(items[r]));
  }
  return shared;
}

std::vector<double> fetch_values(MPI_Comm comm, int width, const std::vector<Key>& keys, const std::vector<double>& values,
                                 const std::vector<Key>& wanted, std::vector<char>& found) {
  const int ranks = ranks_of(comm);
  std::vector<double> result(wanted.size() * width, 0.0);
  found.assign(wanted.size(), 0);
  const auto take = [&](std::size_t w, const double* v) {
    std::copy(v, v + width, result.begin() + w * width);
    found[w] = 1;
  };
  // Values of this rank need no message. If many keys are wanted, one walk over `keys` is cheaper than a search for each.
  std::vector<Key> missing;
  std::vector<int> missing_at;
  const bool many = wanted.size() > keys.size() / 8;
  auto it = keys.begin();
  for (std::size_t w = 0; w < wanted.size(); ++w) {
    if (many) {
      while (it != keys.end() && *it < wanted[w]) ++it;
    } else {
      it = std::lower_bound(it, keys.end(), wanted[w]);
    }
    if (it != keys.end() && *it == wanted[w]) {
      take(w, &values[(it - keys.begin()) * width]);
    } else {
      missing.push_back(wanted[w]);
      missing_at.push_back(static_cast<int>(w));
    }
  }
  if (ranks == 1) return result;

  // The homes collect which ranks have and want each key. Then they order the lowest rank that has it to send it to those that want it.
  const std::vector<Holder> have = gather_at_home(comm, keys);
  const std::vector<Holder> want = gather_at_home(comm, missing);
  struct SendRequest {
    int holder_index, wanter, wanter_index;
  };
  std::vector<std::vector<SendRequest>> requests(ranks);
  for (const Holder& w : want) {
    const auto it = std::lower_bound(have.begin(), have.end(), w.key, [](const Holder& a, const Key& k) { return a.key < k; });
    if (it != have.end() && it->key == w.key) requests[it->rank].push_back({it->index, w.rank, w.index});
  }
  const std::vector<SendRequest> mine = all_to_all(comm, requests).data;
  std::vector<std::vector<double>> out(ranks);
  for (const SendRequest& o : mine) {
    out[o.wanter].push_back(o.wanter_index);
    out[o.wanter].insert(out[o.wanter].end(), values.begin() + static_cast<long>(o.holder_index) * width,
                         values.begin() + static_cast<long>(o.holder_index + 1) * width);
  }
  const std::vector<double> in = all_to_all(comm, out).data;
  for (std::size_t m = 0; m < in.size(); m += width + 1) take(missing_at[static_cast<int>(in[m])], &in[m + 1]);
  return result;
}

}  // namespace mpdem
