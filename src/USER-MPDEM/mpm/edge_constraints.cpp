// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds which nodes at the edge of the cement are constrained, and by which nodes. The rule stands in
// extension_constraints.h.
#include <algorithm>
#include <array>
#include <map>

#include "../numerics/sort_unique.h"
#include "extension_constraints.h"

namespace mpdem {

namespace {

// Thresholds of mass. kConstrainedBelow of the basis is relative to the mass of the next node inwards. No threshold is near a
// ratio of masses of a lattice with full cells, so rounding decides nothing.
double constrained_below(Basis basis) {
  return with_basis(basis, [](auto type) { return decltype(type)::kConstrainedBelow; });
}
constexpr double kSecond = 2.0;  // the second node must have at least so many times the mass of the constrained one
constexpr double kAlike = 1e-6;  // directions whose ratios of mass differ by less are as good as each other

constexpr int kDirections = 6;  // -x +x -y +y -z +z
using Code = int;               // bit n: the node follows masters in direction n; 0: it is free

using Next = std::function<Key(const Key&, int)>;

// The next node in a direction and the one after it.
std::array<Key, 2> nodes_towards(const Next& next, const Key& k, int direction) {
  const auto one_on = [&](const Key& from) {
    if (!next) return from.moved(direction / 2, direction % 2 == 0 ? -1 : 1);
    return from == kNoNode ? kNoNode : next(from, direction);
  };
  const Key first = one_on(k);
  return {first, one_on(first)};
}

int directions_of(Code code) { return __builtin_popcount(code); }

// Calls f(node, weight, true if the node receives mass) for each node behind k in the directions of the code.
template <class F>
void for_each_term(const Next& next, const Key& k, Code code, F f) {
  const double share = 1.0 / directions_of(code);
  for (int n = 0; n < kDirections; ++n) {
    if (!(code >> n & 1)) continue;
    const std::array<Key, 2> behind = nodes_towards(next, k, n);
    f(behind[0], 2.0 * share, true);
    f(behind[1], -share, false);
  }
}

class Resolver {  // replaces masters that are constrained by their own masters
 public:
  Resolver(const Next& next, const std::map<Key, Code>& codes) : next_(next), codes_(codes) {}

  const ExtensionConstraint& constraint_of(const Key& k) {
    const auto known = done_.find(k);
    if (known != done_.end()) return known->second;
    ExtensionConstraint t;
    t.constrained = k;
    Terms weights, shares;
    const double share = 1.0 / directions_of(codes_.at(k));  // share of the mass
    for_each_term(next_, k, codes_.at(k), [&](const Key& master, double weight, bool next) {
      t.behind.emplace_back(master, weight);
      const auto code = codes_.find(master);
      const bool is_free = code == codes_.end() || code->second == 0;
      if (is_free) {
        add(weights, master, weight);
        if (next) add(shares, master, share);
        return;
      }
      const ExtensionConstraint& behind = constraint_of(master);
      for (const auto& m : behind.masters) add(weights, m.first, weight * m.second);
      if (next)
        for (const auto& h : behind.mass_receivers) add(shares, h.first, share * h.second);
    });
    t.masters = std::move(weights);
    t.mass_receivers = std::move(shares);
    return done_.emplace(k, std::move(t)).first->second;
  }

 private:
  using Terms = std::vector<std::pair<Key, double>>;  // ascending in the node
  // A constraint has few terms, so they are inserted one by one.
  static void add(Terms& terms, const Key& k, double value) {
    const auto at = std::lower_bound(terms.begin(), terms.end(), k, [](const auto& term, const Key& other) { return term.first < other; });
    if (at != terms.end() && at->first == k) at->second += value;
    else terms.insert(at, {k, value});
  }

  const Next& next_;
  const std::map<Key, Code>& codes_;
  std::map<Key, ExtensionConstraint> done_;
};

// Codes of the nodes of this rank, as doubles for fetch_values(). All ranks that have a node find the same code, since sums over ranks
// are equal on all of them (halo_sum.h).
std::vector<double> find_codes(MPI_Comm comm, Basis basis, const EdgeNodes& nodes) {
  const std::vector<Key>& keys = nodes.keys;
  const std::vector<double>& mass = nodes.mass;
  double mine = 0.0, most;
  for (double m : mass) mine = std::max(mine, m);
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, comm);
  const double below = constrained_below(basis);
  std::vector<int> candidates;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (mass[i] < below * most) candidates.push_back(static_cast<int>(i));
  std::vector<std::array<Key, 2>> behind(candidates.size() * kDirections);
  for (std::size_t i = 0; i < behind.size(); ++i)
    behind[i] = nodes_towards(nodes.next, keys[candidates[i / kDirections]], static_cast<int>(i % kDirections));
  std::vector<Key> wanted;
  wanted.reserve(2 * behind.size());
  for (const auto& pair : behind) wanted.insert(wanted.end(), pair.begin(), pair.end());
  sort_unique(wanted);
  std::vector<char> found;
  const std::vector<double> near = fetch_values(comm, 1, keys, mass, wanted, found);
  const auto mass_of = [&](const Key& k) {
    const int at = index_of(wanted, k);
    return found[at] ? near[at] : 0.0;
  };
  std::vector<double> codes(keys.size(), 0.0);
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const int i = candidates[c];
    double share[kDirections], least = below;
    for (int n = 0; n < kDirections; ++n) {
      share[n] = below;
      const std::array<Key, 2>& pair = behind[kDirections * c + n];
      const double first = mass_of(pair[0]);
      if (!(first > 0.0) || mass_of(pair[1]) < kSecond * mass[i]) continue;
      share[n] = mass[i] / first;
      least = std::min(least, share[n]);
    }
    Code code = 0;
    for (int n = 0; n < kDirections; ++n)
      if (share[n] < below && share[n] <= least * (1.0 + kAlike)) code |= 1 << n;
    codes[i] = code;
  }
  return codes;
}

}  // namespace

std::vector<ExtensionConstraint> find_extension_constraints(MPI_Comm comm, Basis basis, const EdgeNodes& nodes) {
  const std::vector<Key>& keys = nodes.keys;
  const std::vector<double> own = find_codes(comm, basis, nodes);
  std::map<Key, Code> codes;
  std::vector<Key> open;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (own[i] != 0.0) {
      codes.emplace_hint(codes.end(), keys[i], static_cast<Code>(own[i]));
      open.push_back(keys[i]);
    }
  // Asks other ranks for the codes of nodes behind that they have, and repeats this for those that are constrained.
  for (int more = 1; more;) {
    std::vector<Key> ask;
    for (const Key& k : open)
      for_each_term(nodes.next, k, codes.at(k), [&](const Key& master, double, bool) {
        if (!codes.count(master) && index_of(keys, master) < 0) ask.push_back(master);
      });
    sort_unique(ask);
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
  std::vector<ExtensionConstraint> constraints;
  Resolver resolver(nodes.next, codes);
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (own[i] != 0.0) constraints.push_back(resolver.constraint_of(keys[i]));
  return constraints;
}

}  // namespace mpdem
