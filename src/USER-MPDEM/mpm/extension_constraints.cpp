// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "extension_constraints.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace mpdem {

void ExtensionConstraints::clear() { *this = ExtensionConstraints(); }

// Ends a row, whose weights are the last of the list. If the same sequence occurs earlier in the list, the row uses
// that, and its own weights are removed.
void ExtensionConstraints::Rows::end_row() {
  constexpr std::size_t kLast = 256;  // number of recent weights to search; older ones may be stored twice
  const std::size_t length = node_.size() - first_[first_.size() - 1], old = weight_.size() - length;
  const double* const row = weight_.begin() + old;
  const double* const at = std::search(weight_.begin() + (old - std::min(old, kLast)), row, row, weight_.end());
  const bool is_new = at == row;
  first_weight_.push_back(static_cast<int>(at - weight_.begin()));
  if (!is_new) weight_.own().resize(old);
  first_.push_back(static_cast<int>(node_.size()));
}

void ExtensionConstraints::Rows::append(const Rows& other, int row) {
  other.for_each(row, [this](int node, double weight) { add(node, weight); });
  end_row();
}

void ExtensionConstraints::Rows::append_sharing_weights(const Rows& other, int first, int end) {
  const int from = other.first_[first], to = other.first_[end];
  first_.append(other.first_, first + 1, end + 1, static_cast<int>(node_.size()) - from);
  node_.append(other.node_, from, to);
  first_weight_.append(other.first_weight_, first, end);
}

bool ExtensionConstraints::Rows::same_nodes(int row, const Rows& other, int of_other) const {
  bool same = length(row) == other.length(of_other);
  for (int n = 0; same && n < length(row); ++n) same = node_[first_[row] + n] == other.node_[other.first_[of_other] + n];
  return same;
}

bool ExtensionConstraints::Rows::same_weights(int row, const Rows& other, int of_other) const {
  const double* weights = &weight_[first_weight_[row]];
  return std::equal(weights, weights + length(row), &other.weight_[other.first_weight_[of_other]]);
}

void ExtensionConstraints::Rows::renumber(const std::vector<int>& new_index) { node_.renumber(new_index); }

void ExtensionConstraints::Rows::shrink_to_fit() {
  for (ShortList* v : {&first_, &node_, &first_weight_}) v->shrink_to_fit();
  weight_.own().shrink_to_fit();
}

void ExtensionConstraints::Rows::share(AlikeLists& alike) {
  for (ShortList* v : {&first_, &node_, &first_weight_}) v->share(alike);
  alike.share(weight_);
}

template <class F>
void ExtensionConstraints::Rows::for_each_row(bool backwards, F f) const {
  const int rows = static_cast<int>(first_weight_.size());
  const double* weight = weight_.data();
  first_.with([&](const auto* first) {
    node_.with([&](const auto* nodes) {
      first_weight_.with([&](const auto* weights) {
        for (int n = 0; n < rows; ++n) {
          const int row = backwards ? rows - 1 - n : n;
          f(row, first[row + 1] - first[row], nodes + first[row], weight + weights[row]);
        }
      });
    });
  });
}

std::size_t ExtensionConstraints::Rows::memory_usage() const {
  return first_.memory_usage() + node_.memory_usage() + first_weight_.memory_usage() + weight_.memory_usage();
}

void ExtensionConstraints::bind(const std::vector<ExtensionConstraint>& constraints, const std::vector<Key>& keys, bool chained) {
  clear();
  const auto node = [&keys](const Key& k) {
    const int n = index_of(keys, k);
    if (n < 0) throw std::logic_error("a tie to a node that the grid does not have");
    return n;
  };
  for (const ExtensionConstraint& t : constraints) {
    constrained_.push_back(node(t.constrained));
    for (const auto& h : t.mass_receivers) mass_receivers_.add(node(h.first), h.second);
    mass_receivers_.end_row();
    for (const auto& m : t.masters) masters_.add(node(m.first), m.second);
    masters_.end_row();
  }
  if (!constrained_.with(
          [this](const auto* constrained_nodes) { return std::is_sorted(constrained_nodes, constrained_nodes + constrained_.size()); }))
    throw std::logic_error("ties that are not in the order of their nodes");
  constrained_.shrink_to_fit();
  mass_receivers_.shrink_to_fit();
  masters_.shrink_to_fit();
  if (chained) bind_chain(constraints, keys);
}

// Makes the chain unless some node behind is not known or not on this rank.
void ExtensionConstraints::bind_chain(const std::vector<ExtensionConstraint>& constraints, const std::vector<Key>& keys) {
  const int count = static_cast<int>(constraints.size());
  std::vector<std::vector<std::pair<int, double>>> behind(constraints.size());
  for (int t = 0; t < count; ++t) {
    for (const auto& b : constraints[t].behind) behind[t].emplace_back(index_of(keys, b.first), b.second);
    if (behind[t].empty() || std::any_of(behind[t].begin(), behind[t].end(), [](const auto& b) { return b.first < 0; })) return;
  }
  // Nodes whose nodes behind are free come first. There are no cycles.
  const std::vector<int> row = row_of_each(static_cast<int>(keys.size()));
  std::vector<int> depth(constraints.size(), -1);
  const std::function<int(int)> find_depth = [&](int t) {
    if (depth[t] >= 0) return depth[t];
    int d = 0;
    for (const auto& b : behind[t])
      if (row[b.first] >= 0) d = std::max(d, 1 + find_depth(row[b.first]));
    return depth[t] = d;
  };
  std::vector<int> order(constraints.size());
  for (int t = 0; t < count; ++t) {
    order[t] = t;
    find_depth(t);
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return depth[a] < depth[b]; });
  for (int t : order) {
    chain_constrained_.push_back(constrained_[t]);
    for (const auto& b : behind[t]) chain_.add(b.first, b.second);
    chain_.end_row();
  }
  chain_constrained_.shrink_to_fit();
  chain_.shrink_to_fit();
}

void ExtensionConstraints::renumber(const std::vector<int>& new_index) {
  constrained_.renumber(new_index);
  masters_.renumber(new_index);
  mass_receivers_.renumber(new_index);
  chain_constrained_.renumber(new_index);
  chain_.renumber(new_index);
}

void ExtensionConstraints::append(const ExtensionConstraints& other, int row) {
  constrained_.push_back(other.constrained_[row]);
  masters_.append(other.masters_, row);
  mass_receivers_.append(other.mass_receivers_, row);
}

void ExtensionConstraints::append_sharing_weights(const ExtensionConstraints& other, int first, int end) {
  constrained_.append(other.constrained_, first, end);
  masters_.append_sharing_weights(other.masters_, first, end);
  mass_receivers_.append_sharing_weights(other.mass_receivers_, first, end);
}

// Few constraints change, so the rows between them are copied together.
bool ExtensionConstraints::replace(const std::vector<int>& nodes, const std::vector<ExtensionConstraint>& wanted,
                                   const std::vector<Key>& keys) {
  ExtensionConstraints fresh, next;
  fresh.bind(wanted, keys);
  next.masters_.take_weights(masters_);
  next.mass_receivers_.take_weights(mass_receivers_);
  bool freed = false;
  int t = 0, f = 0;  // next row of *this, and next row of fresh
  const auto keep_until = [&](int end) {
    next.append_sharing_weights(*this, t, end);
    t = end;
  };
  for (int node : nodes) {
    while (f < static_cast<int>(fresh.size()) && fresh.constrained_[f] < node) {
      keep_until(rows_before(fresh.constrained_[f]));
      next.append(fresh, f++);
    }
    keep_until(rows_before(node));
    const int row = f < static_cast<int>(fresh.size()) && fresh.constrained_[f] == node ? f : -1;
    if (t < static_cast<int>(size()) && constrained_[t] == node) {
      const bool is_edge = masters_.length(t) > 1;
      const bool same = row >= 0 && masters_.same_nodes(t, fresh.masters_, row) && masters_.same_weights(t, fresh.masters_, row) &&
                        mass_receivers_.same_nodes(t, fresh.mass_receivers_, row);
      freed = freed || (is_edge && !same);
      ++t;
    }
    if (row >= 0) next.append(fresh, f++);
  }
  while (f < static_cast<int>(fresh.size())) {
    keep_until(rows_before(fresh.constrained_[f]));
    next.append(fresh, f++);
  }
  keep_until(static_cast<int>(size()));
  *this = std::move(next);
  return freed;
}

std::vector<ExtensionConstraint> ExtensionConstraints::by_key(const std::vector<Key>& keys) const {
  std::vector<ExtensionConstraint> constraints(constrained_.size());
  for (std::size_t t = 0; t < size(); ++t) {
    constraints[t].constrained = keys[constrained_[t]];
    masters_.for_each(t, [&](int node, double weight) { constraints[t].masters.emplace_back(keys[node], weight); });
    mass_receivers_.for_each(t, [&](int node, double share) { constraints[t].mass_receivers.emplace_back(keys[node], share); });
  }
  return constraints;
}

namespace {

// Three numbers of a node, read and written as a pair and a single number, so that store-to-load forwarding works.
struct Three {
  static constexpr int kWidth = 3;
  using v2 = double __attribute__((vector_size(16)));
  v2 xy;
  double z;
  static Three load(const double* p) {
    Three t;
    std::memcpy(&t.xy, p, sizeof t.xy);
    t.z = p[2];
    return t;
  }
  void store(double* p) const {
    std::memcpy(p, &xy, sizeof xy);
    p[2] = z;
  }
  void add(double weight, const Three& t) {
    xy += weight * t.xy;
    z += weight * t.z;
  }
};

// One number of a node.
struct One {
  static constexpr int kWidth = 1;
  double x;
  static One load(const double* p) { return {*p}; }
  void store(double* p) const { *p = x; }
  void add(double weight, const One& t) { x += weight * t.x; }
};

}  // namespace

template <class T>
void ExtensionConstraints::gather_to_masters_as(double* values) const {
  (is_chained() ? chain_constrained_ : constrained_).with([&](const auto* constrained_nodes) {
    (is_chained() ? chain_ : masters_).for_each_row(is_chained(), [&, values](int row, int length, const auto* node, const double* weight) {
      double* constrained = values + T::kWidth * static_cast<long>(constrained_nodes[row]);
      const T v = T::load(constrained);
      T{}.store(constrained);
      for (int n = 0; n < length; ++n) {
        double* master = values + T::kWidth * static_cast<long>(node[n]);
        T sum = T::load(master);
        sum.add(weight[n], v);
        sum.store(master);
      }
    });
  });
}

void ExtensionConstraints::gather_to_masters(double* values) const { gather_to_masters_as<Three>(values); }
void ExtensionConstraints::gather_scalars_to_masters(double* values) const { gather_to_masters_as<One>(values); }

void ExtensionConstraints::scale_by_weight_sums(double* values) const {
  constrained_.with([&](const auto* constrained_nodes) {
    masters_.for_each_row(false, [=](int row, int length, const auto*, const double* weight) {
      double sum = 0.0;
      for (int n = 0; n < length; ++n) sum += std::fabs(weight[n]);
      values[constrained_nodes[row]] *= sum;
    });
  });
}

void ExtensionConstraints::gather_sizes_to_masters(double* values) const {
  constrained_.with([&](const auto* constrained_nodes) {
    masters_.for_each_row(false, [=](int row, int length, const auto* node, const double* weight) {
      double& v = values[constrained_nodes[row]];
      for (int n = 0; n < length; ++n) values[node[n]] += std::fabs(weight[n]) * v;
      v = 0.0;
    });
  });
}

namespace {

// Calls f with the width. The width 1 is passed as a constant, so that the compiler drops the loop over it.
template <class F>
void with_width(int width, F f) {
  if (width == 1) f(std::integral_constant<int, 1>());
  else f(width);
}

}  // namespace

void ExtensionConstraints::add_to_mass_receivers(double* values, int width) const {
  with_width(width, [&](auto w) {
    constrained_.with([&](const auto* constrained_nodes) {
      mass_receivers_.for_each_row(false, [=](int row, int length, const auto* node, const double* share) {
        double* constrained = values + w * static_cast<long>(constrained_nodes[row]);
        for (int n = 0; n < length; ++n) {
          double* receiver = values + w * static_cast<long>(node[n]);
          for (int c = 0; c < w; ++c) receiver[c] += share[n] * constrained[c];
        }
        std::fill(constrained, constrained + w, 0.0);
      });
    });
  });
}

void ExtensionConstraints::mean_of_mass_receivers(double* values, int width) const {
  with_width(width, [&](auto w) {
    constrained_.with([&](const auto* constrained_nodes) {
      mass_receivers_.for_each_row(false, [=](int row, int length, const auto* node, const double* share) {
        double* constrained = values + w * static_cast<long>(constrained_nodes[row]);
        for (int c = 0; c < w; ++c) {
          double sum = 0.0;
          for (int n = 0; n < length; ++n) sum += share[n] * values[w * static_cast<long>(node[n]) + c];
          constrained[c] = sum;
        }
      });
    });
  });
}

void ExtensionConstraints::extend(double* values) const {
  (is_chained() ? chain_constrained_ : constrained_).with([&](const auto* constrained_nodes) {
    (is_chained() ? chain_ : masters_).for_each_row(false, [&, values](int row, int length, const auto* node, const double* weight) {
      Three sum{};
      for (int n = 0; n < length; ++n) sum.add(weight[n], Three::load(values + 3 * static_cast<long>(node[n])));
      sum.store(values + 3 * static_cast<long>(constrained_nodes[row]));
    });
  });
}

void ExtensionConstraints::share(AlikeLists& alike) {
  for (ShortList* v : {&constrained_, &chain_constrained_}) v->share(alike);
  for (Rows* r : {&masters_, &mass_receivers_, &chain_}) r->share(alike);
}

std::size_t ExtensionConstraints::memory_usage() const {
  return constrained_.memory_usage() + masters_.memory_usage() + mass_receivers_.memory_usage() + chain_constrained_.memory_usage() +
         chain_.memory_usage();
}

}  // namespace mpdem
