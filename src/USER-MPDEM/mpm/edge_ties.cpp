// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "edge_ties.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "body.h"

namespace mpdem {

namespace {

// Shares of mass. None of them is near what a lattice gives whose cells are full, so that rounding decides nothing.
double tied_below(Basis basis) { return basis == Basis::cubic ? 0.05 : 0.12; }  // of the next node
constexpr double kSecond = 0.3;   // the second has at least this share of the next
constexpr double kAlike = 1e-6;

constexpr int kDirections = 6;  // -x +x -y +y -z +z
// Of a node: bit n, tied along direction n; the next or the second there is one of the other sheet; it is a copy.
using Code = int;
constexpr int kNextOther = kDirections, kSecondOther = 2 * kDirections;
constexpr Code kCopy = 1 << 3 * kDirections;

using Next = std::function<Key(const Key&, int)>;

Key neighbour(const Next& next, Key k, int direction, int steps, bool other = false) {
  if (next) {
    for (int n = 0; n < steps && k != kNoNode; ++n) k = next(k, direction);
    return k;
  }
  k[1 + direction / 2] += direction % 2 == 0 ? -steps : steps;
  if (other) k[0] = other_sheet(k[0]);
  return k;
}

Key copy_of(Key k) {
  k[0] = other_sheet(k[0]);
  return k;
}

void make_unique(std::vector<Key>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

int place_of(const std::vector<Key>& keys, const Key& k) {
  const auto it = std::lower_bound(keys.begin(), keys.end(), k);
  return it != keys.end() && *it == k ? static_cast<int>(it - keys.begin()) : -1;
}

int directions_of(Code code) { return (code & kCopy) ? 1 : __builtin_popcount(code & ((1 << kDirections) - 1)); }

// Calls f(master, weight, does it take mass) for what a code asks for.
template <class F>
void for_each_term(const Next& next, const Key& k, Code code, F f) {
  if (code & kCopy) {
    f(copy_of(k), 1.0, true);
    return;
  }
  const double share = 1.0 / directions_of(code);
  for (int n = 0; n < kDirections; ++n) {
    if (!(code >> n & 1)) continue;
    f(neighbour(next, k, n, 1, code >> (kNextOther + n) & 1), 2.0 * share, true);
    f(neighbour(next, k, n, 2, code >> (kSecondOther + n) & 1), -share, false);
  }
}

class Resolver {
 public:
  Resolver(const Next& next, const std::map<Key, Code>& codes) : next_(next), codes_(codes) {}

  const EdgeTie& tie(const Key& k) {
    const auto known = done_.find(k);
    if (known != done_.end()) return known->second;
    EdgeTie t;
    t.slave = k;
    std::map<Key, double> weights, shares;
    const double share = 1.0 / directions_of(codes_.at(k));
    for_each_term(next_, k, codes_.at(k), [&](const Key& master, double weight, bool next) {
      const auto code = codes_.find(master);
      const bool is_free = code == codes_.end() || code->second == 0;
      if (is_free) {
        weights[master] += weight;
        if (next) shares[master] += share;
        return;
      }
      const EdgeTie& behind = tie(master);
      for (const auto& m : behind.masters) weights[m.first] += weight * m.second;
      if (next)
        for (const auto& h : behind.heirs) shares[h.first] += share * h.second;
    });
    t.masters.assign(weights.begin(), weights.end());
    t.heirs.assign(shares.begin(), shares.end());
    return done_.emplace(k, t).first->second;
  }

 private:
  const Next& next_;
  const std::map<Key, Code>& codes_;
  std::map<Key, EdgeTie> done_;
};

// What a node looks for in its neighbourhood: nodes of its own sheet, or of both where they are joined.
class Surroundings {
 public:
  static constexpr int kWidth = 2;  // mass, is it joined

  // Collective. Nodes that stand for themselves or for both sheets, and their values, are looked up.
  Surroundings(MPI_Comm comm, const Next& next, const std::vector<Key>& keys, const std::vector<double>& values, std::vector<Key> wanted)
      : next_(next), wanted_(std::move(wanted)) {
    make_unique(wanted_);
    values_ = fetch_values(comm, kWidth, keys, values, wanted_, found_);
  }

  // Mass of the node some steps on, 0 if there is none; `other` says that it is one of the other sheet.
  double mass(const Key& k, bool has_sheets, bool joined, int direction, int steps, bool& other) const {
    const int same = at(neighbour(next_, k, direction, steps));
    other = false;
    if (!has_sheets) return same < 0 ? 0.0 : values_[kWidth * same];
    const int beside = at(neighbour(next_, k, direction, steps, true));
    if (joined && same >= 0 && beside >= 0) return 0.0;  // here the crevice begins, and either is as good
    if (same >= 0) return values_[kWidth * same];
    if (beside < 0 || !(joined || values_[kWidth * beside + 1] != 0.0)) return 0.0;
    other = true;
    return values_[kWidth * beside];
  }

 private:
  int at(const Key& k) const {
    const int n = place_of(wanted_, k);
    return n >= 0 && found_[n] ? n : -1;
  }
  const Next& next_;
  std::vector<Key> wanted_;
  std::vector<char> found_;
  std::vector<double> values_;
};

// Codes of the nodes of this rank, the same on all ranks that hold a node, as sums over ranks are (halo_sum.h).
std::vector<double> find_codes(MPI_Comm comm, Basis basis, const TiedNodes& nodes) {
  const std::vector<Key>& keys = nodes.keys;
  std::vector<Key> copies;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (nodes.sheets[i] == kJoined) copies.push_back(copy_of(keys[i]));
  make_unique(copies);
  std::vector<char> found;
  const std::vector<double> of_copies = fetch_values(comm, 1, keys, nodes.mass, copies, found);
  std::vector<double> mass = nodes.mass, codes(keys.size(), 0.0);
  std::vector<char> joined(keys.size(), 0);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (nodes.sheets[i] != kJoined) continue;
    const int c = place_of(copies, copy_of(keys[i]));
    if (!found[c]) continue;
    joined[i] = 1;
    mass[i] += of_copies[c];
    if (is_second_sheet(keys[i][0])) codes[i] = kCopy;
  }

  double mine = 0.0, most;
  for (double m : mass) mine = std::max(mine, m);
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, comm);
  const double below = tied_below(basis);
  std::vector<Key> wanted, present;
  std::vector<double> values;
  std::vector<int> candidates;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (codes[i] != 0.0) continue;
    present.push_back(keys[i]);
    values.push_back(mass[i]);
    values.push_back(joined[i]);
    if (!nodes.edge[i] || !(mass[i] < below * most)) continue;
    candidates.push_back(static_cast<int>(i));
    for (int n = 0; n < kDirections; ++n)
      for (int s = 1; s <= 2; ++s)
        for (bool other : {false, true})
          if (!other || nodes.sheets[i] != kNoSheets) wanted.push_back(neighbour(nodes.next, keys[i], n, s, other));
  }
  const Surroundings near(comm, nodes.next, present, values, std::move(wanted));
  for (int i : candidates) {
    double share[kDirections], least = below;
    Code code = 0, others = 0;
    for (int n = 0; n < kDirections; ++n) {
      share[n] = below;
      bool other[2];
      const double first = near.mass(keys[i], nodes.sheets[i] != kNoSheets, joined[i], n, 1, other[0]);
      const double second = near.mass(keys[i], nodes.sheets[i] != kNoSheets, joined[i], n, 2, other[1]);
      if (!(first > 0.0) || second < kSecond * first) continue;
      share[n] = mass[i] / first;
      least = std::min(least, share[n]);
      others |= other[0] << (kNextOther + n) | other[1] << (kSecondOther + n);
    }
    for (int n = 0; n < kDirections; ++n)
      if (share[n] < below && share[n] <= least * (1.0 + kAlike))
        code |= 1 << n;
    codes[i] = code == 0 ? 0 : code | others;
  }
  return codes;
}

}  // namespace

std::vector<EdgeTie> find_edge_ties(MPI_Comm comm, Basis basis, const TiedNodes& nodes) {
  const std::vector<Key>& keys = nodes.keys;
  const std::vector<double> own = find_codes(comm, basis, nodes);
  std::map<Key, Code> codes;
  std::vector<Key> open;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (own[i] != 0.0) {
      codes.emplace_hint(codes.end(), keys[i], static_cast<Code>(own[i]));
      open.push_back(keys[i]);
    }
  // Are the masters that other ranks hold tied too, and their masters?
  for (int more = 1; more;) {
    std::vector<Key> ask;
    for (const Key& k : open)
      for_each_term(nodes.next, k, codes.at(k), [&](const Key& master, double, bool) {
        if (!codes.count(master) && place_of(keys, master) < 0) ask.push_back(master);
      });
    make_unique(ask);
    std::vector<char> found;
    const std::vector<double> answer = fetch_values(comm, 1, keys, own, ask, found);
    open.clear();
    for (std::size_t n = 0; n < ask.size(); ++n) {
      codes[ask[n]] = found[n] ? static_cast<Code>(answer[n]) : 0;
      if (codes[ask[n]] != 0) open.push_back(ask[n]);
    }
    const int mine = !open.empty();
    MPI_Allreduce(&mine, &more, 1, MPI_INT, MPI_MAX, comm);
  }
  std::vector<EdgeTie> ties;
  Resolver resolver(nodes.next, codes);
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (own[i] != 0.0) ties.push_back(resolver.tie(keys[i]));
  return ties;
}

void EdgeTies::clear() { *this = EdgeTies(); }

void EdgeTies::bind(const std::vector<EdgeTie>& ties, const std::vector<Key>& keys) {
  clear();
  if (ties.empty()) return;
  row_.assign(keys.size(), -1);
  first_.push_back(0);
  first_heir_.push_back(0);
  const auto node = [&keys](const Key& k) {
    const int n = place_of(keys, k);
    if (n < 0) throw std::logic_error("a tie to a node that the grid does not have");
    return n;
  };
  for (const EdgeTie& t : ties) {
    slave_.push_back(node(t.slave));
    row_[slave_.back()] = static_cast<int>(slave_.size()) - 1;
    for (const auto& h : t.heirs) {
      heir_.push_back(node(h.first));
      heir_share_.push_back(h.second);
    }
    first_heir_.push_back(static_cast<int>(heir_.size()));
    double sum = 0.0;
    for (const auto& m : t.masters) {
      master_.push_back(node(m.first));
      weight_.push_back(m.second);
      sum += std::fabs(m.second);
    }
    weight_sum_.push_back(sum);
    first_.push_back(static_cast<int>(master_.size()));
  }
  for (auto* v : {&slave_, &first_, &master_, &first_heir_, &heir_}) v->shrink_to_fit();
  for (auto* v : {&weight_, &weight_sum_, &heir_share_}) v->shrink_to_fit();
}

void EdgeTies::find_rows(std::size_t nodes) {
  row_.assign(slave_.empty() ? 0 : nodes, -1);
  for (std::size_t t = 0; t < slave_.size(); ++t) row_[slave_[t]] = static_cast<int>(t);
}

void EdgeTies::renumber(const std::vector<int>& place, std::size_t nodes) {
  for (auto* numbers : {&slave_, &master_, &heir_})
    for (int& n : *numbers) n = place[n];
  find_rows(nodes);
}

void EdgeTies::append(const EdgeTies& other, int row) {
  if (first_.empty()) first_.assign(1, 0);
  if (first_heir_.empty()) first_heir_.assign(1, 0);
  slave_.push_back(other.slave_[row]);
  weight_sum_.push_back(other.weight_sum_[row]);
  const int first = other.first_[row], last = other.first_[row + 1], heir = other.first_heir_[row], last_heir = other.first_heir_[row + 1];
  master_.insert(master_.end(), &other.master_[first], &other.master_[0] + last);
  weight_.insert(weight_.end(), &other.weight_[first], &other.weight_[0] + last);
  heir_.insert(heir_.end(), &other.heir_[heir], &other.heir_[0] + last_heir);
  heir_share_.insert(heir_share_.end(), &other.heir_share_[heir], &other.heir_share_[0] + last_heir);
  first_.push_back(static_cast<int>(master_.size()));
  first_heir_.push_back(static_cast<int>(heir_.size()));
}

bool EdgeTies::same_row(int row, const EdgeTies& other, int of_other) const {
  const int n = first_[row + 1] - first_[row], heirs = first_heir_[row + 1] - first_heir_[row];
  return other.first_[of_other + 1] - other.first_[of_other] == n && other.first_heir_[of_other + 1] - other.first_heir_[of_other] == heirs &&
         std::equal(&master_[first_[row]], &master_[first_[row]] + n, &other.master_[other.first_[of_other]]) &&
         std::equal(&weight_[first_[row]], &weight_[first_[row]] + n, &other.weight_[other.first_[of_other]]) &&
         std::equal(&heir_[first_heir_[row]], &heir_[first_heir_[row]] + heirs, &other.heir_[other.first_heir_[of_other]]);
}

bool EdgeTies::exchange(const std::vector<int>& nodes, const std::vector<EdgeTie>& wanted, const std::vector<Key>& keys) {
  EdgeTies fresh, next;
  fresh.bind(wanted, keys);
  bool freed = false;
  std::size_t f = 0;
  for (std::size_t t = 0; t < slave_.size(); ++t) {
    while (f < fresh.size() && fresh.slave_[f] < slave_[t]) next.append(fresh, static_cast<int>(f++));
    if (!std::binary_search(nodes.begin(), nodes.end(), slave_[t])) {
      next.append(*this, static_cast<int>(t));
      continue;
    }
    const int row = fresh.row(slave_[t]);
    const bool is_edge = first_[t + 1] - first_[t] > 1;
    freed = freed || (is_edge && (row < 0 || !same_row(static_cast<int>(t), fresh, row)));
  }
  while (f < fresh.size()) next.append(fresh, static_cast<int>(f++));
  next.find_rows(keys.size());
  *this = std::move(next);
  return freed;
}

std::vector<EdgeTie> EdgeTies::by_key(const std::vector<Key>& keys) const {
  std::vector<EdgeTie> ties(slave_.size());
  for (std::size_t t = 0; t < slave_.size(); ++t) {
    ties[t].slave = keys[slave_[t]];
    for (int n = first_[t]; n < first_[t + 1]; ++n) ties[t].masters.emplace_back(keys[master_[n]], weight_[n]);
    for (int n = first_heir_[t]; n < first_heir_[t + 1]; ++n) ties[t].heirs.emplace_back(keys[heir_[n]], heir_share_[n]);
  }
  return ties;
}

void EdgeTies::pull_back(double* values) const {
  for (std::size_t t = 0; t < slave_.size(); ++t) {
    double v[3];
    for (int d = 0; d < 3; ++d) {
      v[d] = values[3 * slave_[t] + d];
      values[3 * slave_[t] + d] = 0.0;
    }
    for (int n = first_[t]; n < first_[t + 1]; ++n)
      for (int d = 0; d < 3; ++d) values[3 * master_[n] + d] += weight_[n] * v[d];
  }
}

void EdgeTies::pull_back_sizes(double* values) const {
  for (std::size_t t = 0; t < slave_.size(); ++t) {
    double& v = values[slave_[t]];
    for (int n = first_[t]; n < first_[t + 1]; ++n) values[master_[n]] += std::fabs(weight_[n]) * v;
    v = 0.0;
  }
}

void EdgeTies::bequeath(double* values, int width) const {
  for (std::size_t t = 0; t < slave_.size(); ++t)
    for (int c = 0; c < width; ++c) {
      double& v = values[width * slave_[t] + c];
      for (int n = first_heir_[t]; n < first_heir_[t + 1]; ++n) values[width * heir_[n] + c] += heir_share_[n] * v;
      v = 0.0;
    }
}

void EdgeTies::take_of_heirs(double* values, int width) const {
  for (std::size_t t = 0; t < slave_.size(); ++t)
    for (int c = 0; c < width; ++c) {
      double sum = 0.0;
      for (int n = first_heir_[t]; n < first_heir_[t + 1]; ++n) sum += heir_share_[n] * values[width * heir_[n] + c];
      values[width * slave_[t] + c] = sum;
    }
}

void EdgeTies::extend(double* values) const {
  for (std::size_t t = 0; t < slave_.size(); ++t) {
    double sum[3] = {0.0, 0.0, 0.0};
    for (int n = first_[t]; n < first_[t + 1]; ++n)
      for (int d = 0; d < 3; ++d) sum[d] += weight_[n] * values[3 * master_[n] + d];
    for (int d = 0; d < 3; ++d) values[3 * slave_[t] + d] = sum[d];
  }
}

std::size_t EdgeTies::memory_usage() const {
  return sizeof(int) * (slave_.capacity() + row_.capacity() + first_.capacity() + master_.capacity() + first_heir_.capacity() + heir_.capacity()) +
         sizeof(double) * (weight_.capacity() + weight_sum_.capacity() + heir_share_.capacity());
}

}  // namespace mpdem
