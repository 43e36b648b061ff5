// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "grid.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "../numerics/sort_unique.h"
#include "../parallel/ranks.h"
#include "block_nodes.h"
#include "scatter.h"

namespace mpdem {

NodeKinematics Grid::kinematics() const {
  NodeKinematics k;
  k.keys = keys;
  k.values.resize(NodeKinematics::kWidth * keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      double* v = &k.values[NodeKinematics::kWidth * i + c];
      v[0] = velocity[3 * i + c];
      v[3] = displacement[3 * i + c];
      v[6] = acceleration[3 * i + c];
    }
  return k;
}

namespace {

// Adds to each key its neighbours from `low` to `high` in direction d. Keys are ascending and unique, before and after.
// A shifted copy of all keys is still ascending, so the copies are merged and not sorted.
void widen(std::vector<Key>& keys, int d, int low, int high) {
  const auto moved = [&](int by) {
    std::vector<Key> copy(keys);
    for (Key& k : copy) k = k.moved(d, by);
    return copy;
  };
  std::vector<Key> wide = moved(low), both;
  for (int i = low + 1; i <= high; ++i) {
    const std::vector<Key> next = moved(i);
    both.clear();
    both.reserve(wide.size() + next.size());
    std::set_union(wide.begin(), wide.end(), next.begin(), next.end(), std::back_inserter(both));
    wide.swap(both);
  }
  keys.swap(wide);
}

}  // namespace

int Grid::base_node(Field field, const int* base) const { return node_at({field, base}); }

int Grid::node_at(const Key& k) const {
  const auto it = std::lower_bound(keys.begin(), keys.end(), k);
  return it != keys.end() && *it == k ? static_cast<int>(it - keys.begin()) : -1;
}

bool Grid::find_columns(Field field, const int* base, int* column) const {
  const int S = support(basis);
  for (int i = 0; i < S; ++i)
    for (int j = 0; j < S; ++j) {
      const int at[3] = {base[0] + i, base[1] + j, base[2]};
      column[S * i + j] = base_node(field, at);
      // An incomplete column belongs to the margin alone.
      const Key last{field, at[0], at[1], at[2] + S - 1};
      const int end = column[S * i + j] + S - 1;
      if (column[S * i + j] < 0 || end >= size() || keys[end] != last) return false;
    }
  return true;
}

// Lays out the nodes and finds the columns of the cells. Returns the bytes that they take. If these exceed most_bytes,
// no nodes are laid out.
double Grid::lay_out(const GridRequest& r, double cell_size, int margin, double most_bytes) {
  h = cell_size;
  std::vector<Key> unique;
  unique.reserve(r.cells.size());
  for (const Cell& c : r.cells) {
    unique.push_back(c.key());
    if (c.joined != kOneCell) unique.push_back(c.last());
  }
  sort_unique(unique);

  const int S = support(basis), columns_of_cell = S * S;
  std::vector<Key> next = unique;
  // Memory has two peaks: keys of neighbours while these are merged, and later all that is stored and sent of the nodes.
  constexpr double kBytesOfNode = 500.0;
  const double times = S + 2 * margin;
  double bytes = 0.0;
  for (int d = 2; d >= 0 && bytes <= most_bytes; --d) {
    bytes = std::max(sizeof(Key) * (1.0 + times), kBytesOfNode) * next.size();
    if (bytes <= most_bytes) widen(next, d, -margin, S - 1 + margin);
  }
  if (!r.extra.empty()) {
    next.insert(next.end(), r.extra.begin(), r.extra.end());
    sort_unique(next);
  }
  bytes = std::max(bytes, kBytesOfNode * next.size());
  if (bytes > most_bytes) return bytes;
  keys.swap(next);
  keys.shrink_to_fit();

  // Cells ascend, so for each n the first nodes of their nth columns ascend, too.
  std::vector<int> columns(columns_of_cell * unique.size()), walk(columns_of_cell, 0);
  for (std::size_t u = 0; u < unique.size(); ++u)
    for (int n = 0; n < columns_of_cell; ++n) {
      const Key first = unique[u].moved(0, n / S).moved(1, n % S);
      while (keys[walk[n]] < first) ++walk[n];
      columns[columns_of_cell * u + n] = walk[n];
    }
  std::size_t u = 0;  // last cell found: the wanted cells mostly ascend, so it or the next one is tried before a search
  const auto columns_at = [&](const Key& k) {
    if (unique[u] != k && (++u == unique.size() || unique[u] != k)) u = std::lower_bound(unique.begin(), unique.end(), k) - unique.begin();
    return &columns[columns_of_cell * u];
  };
  for (const Cell& c : r.cells) {
    const int* of_cell = columns_at(c.key());
    const int more_i = reach_along(c.joined, 0), more_j = reach_along(c.joined, 1);
    if (more_i + more_j == 0) {  // one cell, or a row along the columns, which are then just longer
      std::copy(of_cell, of_cell + columns_of_cell, c.column);
      continue;
    }
    const int* of_last = columns_at(c.last());
    for (int i = 0; i < S + more_i; ++i)
      for (int j = 0; j < S + more_j; ++j)
        c.column[(S + more_j) * i + j] = i < S && j < S ? of_cell[S * i + j] : of_last[S * (i - more_i) + j - more_j];
  }
  inside_.clear();
  if (margin > 0) {
    inside_.assign(keys.size(), 0);
    for (int d = 2; d >= 0; --d) widen(unique, d, 1 - margin, margin - 1);
    for (const Key& k : unique) inside_[node_at(k)] = 1;
  }
  return bytes;
}

namespace {

// Node from which node k inherits its motion.
Key source_of(const Key& k, const GridRequest& r) {
  const auto other = r.source.find(k);
  return other != r.source.end() ? other->second : k;
}

}  // namespace

// Sets the motion of the nodes from the values of the wanted nodes, which ascend and include the sources of all nodes
// of this grid. Clears mass, forces and constraints.
void Grid::set_motion(GridRequest& r, const std::vector<Key>& wanted, const std::vector<double>& values, const std::vector<char>& found) {
  const std::size_t n = keys.size();
  velocity.resize(3 * n);
  displacement.resize(3 * n);
  acceleration.resize(3 * n);
  r.fresh.resize(n);
  const bool as_they_are = r.source.empty();
  std::size_t w = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Key k = as_they_are ? keys[i] : source_of(keys[i], r);
    if (as_they_are && w < wanted.size() && i > 0) ++w;  // mostly the next one, which saves the search
    if (w >= wanted.size() || wanted[w] != k) w = std::lower_bound(wanted.begin(), wanted.end(), k) - wanted.begin();
    r.fresh[i] = !found[w];
    for (int c = 0; c < 3; ++c) {
      const double* v = &values[NodeKinematics::kWidth * w + c];
      velocity[3 * i + c] = v[0];
      displacement[3 * i + c] = v[3];
      acceleration[3 * i + c] = v[6];
    }
  }
  mass = {};
  mass.own().assign(n, 0.0);
  force.assign(3 * n, 0.0);
  momentum.clear();
  forget_averages();
  constraints.clear();
  any_constraints_ = false;
  constraint_factor_.clear();
  largest_constraint_factor_ = 1.0;
}

void build_grids(MPI_Comm comm, double cell_size, int margin, double most_bytes, std::vector<GridRequest>& requests) {
  double mine = 0.0, most;
  for (GridRequest& r : requests)
    if (mine <= most_bytes) mine += r.grid->lay_out(r, cell_size, margin, most_bytes - mine);
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, comm);
  if (most > most_bytes) throw GridTooLarge(most);

  // With several ranks one exchange serves all grids. Keys of bonds with several layers interleave, so they are sorted again.
  const int ranks = ranks_of(comm);
  constexpr int W = NodeKinematics::kWidth;
  if (ranks == 1) {
    for (GridRequest& r : requests) {
      std::vector<Key> wanted(r.grid->keys);
      if (!r.source.empty()) {
        for (Key& k : wanted) k = source_of(k, r);
        sort_unique(wanted);
      }
      std::vector<char> found;
      const std::vector<double> values = fetch_values(comm, W, r.before.keys, r.before.values, wanted, found);
      r.grid->set_motion(r, wanted, values, found);
      r.grid->halo.build(comm, r.grid->keys);
    }
    return;
  }
  struct Held {
    Key key;
    const double* values;
  };
  std::vector<Held> held;
  std::vector<Key> wanted;
  struct Node {
    Key key;
    int request, index;
  };
  std::vector<Node> nodes;
  for (std::size_t n = 0; n < requests.size(); ++n) {
    const GridRequest& r = requests[n];
    for (std::size_t i = 0; i < r.before.keys.size(); ++i) held.push_back({r.before.keys[i], &r.before.values[W * i]});
    for (std::size_t i = 0; i < r.grid->keys.size(); ++i) {
      wanted.push_back(source_of(r.grid->keys[i], r));
      nodes.push_back({r.grid->keys[i], static_cast<int>(n), static_cast<int>(i)});
    }
  }
  std::sort(held.begin(), held.end(), [](const Held& a, const Held& b) { return a.key < b.key; });
  std::vector<Key> keys;
  std::vector<double> values;
  for (const Held& x : held) {
    keys.push_back(x.key);
    values.insert(values.end(), x.values, x.values + W);
  }
  sort_unique(wanted);
  std::vector<char> found;
  const std::vector<double> carried = fetch_values(comm, W, keys, values, wanted, found);
  for (GridRequest& r : requests) r.grid->set_motion(r, wanted, carried, found);

  std::sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) { return a.key < b.key; });
  keys.clear();
  for (const Node& x : nodes) keys.push_back(x.key);
  const Sharing all = find_sharing(comm, keys);
  std::vector<Sharing> of(requests.size());
  for (std::size_t rank = 0; rank < all.ranks.size(); ++rank)
    for (int item : all.items[rank]) {
      Sharing& s = of[nodes[item].request];
      if (s.ranks.empty() || s.ranks.back() != all.ranks[rank]) {
        s.ranks.push_back(all.ranks[rank]);
        s.items.emplace_back();
      }
      s.items.back().push_back(nodes[item].index);
    }
  for (std::size_t n = 0; n < requests.size(); ++n) requests[n].grid->halo.build(comm, of[n], requests[n].grid->keys.size());
}

void Grid::build(MPI_Comm comm, double cell_size, const std::vector<Cell>& cells, const NodeKinematics& restored, std::vector<char>& fresh,
                 int margin, const std::vector<Key>& extra) {
  std::vector<GridRequest> one(1);
  GridRequest& r = one.front();
  r.grid = this;
  r.cells = cells;
  r.before = restored.keys.empty() ? kinematics() : restored;
  r.extra = extra;
  build_grids(comm, cell_size, margin, std::numeric_limits<double>::infinity(), one);
  fresh.swap(r.fresh);
}

namespace {

// Moves the values of nodes to their new indices, which keep the order, `width` numbers per node. New nodes get the value
// `fresh`. Consecutive nodes move together, the last ones first, since new indices are never smaller.
void spread(std::vector<double>& values, int width, const std::vector<int>& new_index, std::size_t size, double fresh) {
  if (values.empty()) return;
  values.resize(width * size, fresh);
  const auto at = [&](std::size_t node) { return values.begin() + static_cast<std::ptrdiff_t>(width * node); };
  std::size_t end = new_index.size(), beyond = size;
  while (end > 0) {
    std::size_t first = end - 1;
    while (first > 0 && new_index[first - 1] == new_index[first] - 1) --first;
    const std::size_t to = new_index[first];
    if (to != first) std::copy_backward(at(first), at(end), at(to + end - first));
    std::fill(at(to + end - first), at(beyond), fresh);
    beyond = to;
    end = first;
  }
  std::fill(at(0), at(beyond), fresh);
}

}  // namespace

std::vector<int> Grid::add_nodes(const std::vector<Key>& more) {
  std::vector<int> new_index(keys.size());
  std::vector<Key> all;
  all.reserve(keys.size() + more.size());
  std::size_t n = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    while (n < more.size() && more[n] < keys[i]) all.push_back(more[n++]);
    new_index[i] = static_cast<int>(all.size());
    all.push_back(keys[i]);
  }
  all.insert(all.end(), more.begin() + n, more.end());
  if (more.empty()) return new_index;
  forget_averages();
  keys.swap(all);
  for (auto* v : {&velocity, &displacement, &force, &acceleration, &momentum, &inertial_force}) spread(*v, 3, new_index, keys.size(), 0.0);
  spread(mass.own(), 1, new_index, keys.size(), 0.0);
  constraint_factor_.clear();
  spread(given_volume, 1, new_index, keys.size(), -1.0);
  constraints.renumber(new_index);
  for (int& i : aliases) i = new_index[i];
  halo.resize(keys.size());
  return new_index;
}

void Grid::copy_motion(const std::map<Key, Key>& source) {
  struct Move {
    int to;
    double v[3][3];
  };
  std::vector<Move> moves;
  for (const auto& s : source) {
    const int to = node_at(s.first), from = node_at(s.second);
    if (to < 0 || from < 0) continue;
    moves.push_back({to, {}});
    for (int d = 0; d < 3; ++d) {
      moves.back().v[0][d] = velocity[3 * from + d];
      moves.back().v[1][d] = displacement[3 * from + d];
      moves.back().v[2][d] = acceleration[3 * from + d];
    }
  }
  for (const Move& m : moves)
    for (int d = 0; d < 3; ++d) {
      velocity[3 * m.to + d] = m.v[0][d];
      displacement[3 * m.to + d] = m.v[1][d];
      acceleration[3 * m.to + d] = m.v[2][d];
    }
}

void Grid::find_columns(BlockMeta& m) const {
  const int S = support(basis), nodes_i = nodes_along(m, 0, S), nodes_j = nodes_along(m, 1, S);
  for (int i = 0; i < nodes_i; ++i)
    for (int j = 0; j < nodes_j; ++j) {
      const int at[3] = {m.base[0] + i, m.base[1] + j, m.base[2]};
      const int node = m.column[nodes_j * i + j] = base_node(field_of(m.row, m.layer), at);
      if (node < 0) throw std::logic_error("a block of points at nodes that the grid does not have");
    }
}

bool Grid::replace_constraints(const std::vector<int>& nodes, const std::vector<ExtensionConstraint>& wanted) {
  constraint_factor_.clear();
  forget_averages();
  const bool freed = constraints.replace(nodes, wanted, keys);
  any_constraints_ = any_constraints_ || !constraints.empty();
  return freed;
}

void Grid::constrain(const std::vector<ExtensionConstraint>& wanted, bool any, bool chained) {
  constraints.bind(wanted, keys, chained && !halo.shares_any());
  forget_averages();
  any_constraints_ = any;
}

std::vector<double> Grid::local_mass(const PointStore& points, const CementDensity& density, bool intact_only) const {
  std::vector<double> mass(keys.size(), 0.0);
  const double inverse_h = 1.0 / h;
  with_basis(basis, [&](auto type) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const BlockMeta& m = points.meta[b];
      vd of_point = density.of(m.material) * points.blocks[b].volume;
      if (intact_only) of_point = select(lanes(m.failed), vd{}, of_point);
      with_weights<decltype(type)>(points.blocks[b], m, inverse_h, [&](const auto& s) {
        with_sums<1>(*this, m, mass.data(), [&](double* sums, const int* column) { scatter_scalar(sums, column, s, of_point); });
      });
    }
  });
  return mass;
}

void Grid::lump_mass(const PointStore& points, const CementDensity& density) {
  std::vector<double> mass = local_mass(points, density);
  // A given volume is no less than the volume of the intact points. So the bound of the eigenvalue remains valid.
  for (std::size_t i = 0; i < given_volume.size(); ++i)
    if (given_volume[i] >= 0.0) mass[i] = halo.counts_here()[i] ? density.of_scene * given_volume[i] : 0.0;
  // The bound of the eigenvalue holds at each node of the unconstrained grid. The kinetic energy of a constrained node
  // satisfies (sum w v)^2 <= (sum |w|) (sum |w| v^2), with sums over its masters.
  constraint_factor_.clear();
  largest_constraint_factor_ = 1.0;
  if (any_constraints_) {
    constraint_factor_ = mass;
    constraints.scale_by_weight_sums(constraint_factor_.data());
    constraints.gather_sizes_to_masters(constraint_factor_.data());
  }
  constraints.add_to_mass_receivers(mass.data(), 1);
  halo.sum(mass.data(), 1);
  // If points end just at the support of a node, rounding leaves a tiny mass there. No time step is stable for that
  // mass, and the force is of the order of its root. The mass is set to zero: a node without inertia does not
  // accelerate.
  constexpr double kRounding = 1e-24;
  for (double& m : mass)
    if (m < kRounding * density.of_scene * h * h * h) m = 0.0;
  if (any_constraints_) {
    halo.sum(constraint_factor_.data(), 1);
    const std::vector<int> row = constraints.row_of_each(size());
    std::size_t kept = 0;
    for (int i = 0; i < size(); ++i) {
      if (row[i] >= 0) continue;
      const double factor = mass[i] > 0.0 ? constraint_factor_[i] / mass[i] : 1.0;
      constraint_factor_[kept++] = factor;
      largest_constraint_factor_ = std::max(largest_constraint_factor_, factor);
    }
    constraint_factor_.resize(kept);
    constraint_factor_.shrink_to_fit();
  }
  this->mass = std::move(mass);
}

void Grid::clear_force() { std::fill(force.begin(), force.end(), 0.0); }

void Grid::update_acceleration(const SharedList<double>& added_mass) {
  const int n = size();
  const double* __restrict m = mass.data();
  const double* __restrict c = added_mass.empty() ? nullptr : added_mass.data();
  double* __restrict f = force.data();
  for (int i = 0; i < n; ++i) {
    const double inertia = c ? m[i] + c[i] : m[i];
    const double r = inertia > 0.0 ? 1.0 / inertia : 0.0;
    for (int d = 0; d < 3; ++d) f[3 * i + d] *= r;
  }
  finish_accelerations();
}

void Grid::finish_accelerations() {
  constraints.extend(force.data());
  force.swap(acceleration);
}

void Grid::accelerate(int first, int end) {
  const double* __restrict m = mass.data();
  double* __restrict f = force.data();
  for (int i = first; i < end; ++i) {
    const double r = m[i] > 0.0 ? 1.0 / m[i] : 0.0;
    for (int d = 0; d < 3; ++d) f[3 * i + d] *= r;
  }
}

void Grid::drift(double dt_v, double dt_u) {
  const int n = 3 * size();
  double* __restrict v = velocity.data();
  double* __restrict u = displacement.data();
  const double* __restrict a = acceleration.data();
  for (int i = 0; i < n; ++i) {
    v[i] += dt_v * a[i];
    u[i] += dt_u * v[i];
  }
}

void Grid::share(AlikeLists& alike) {
  alike.share(mass);
  constraints.share(alike);
}

std::size_t Grid::memory_usage() const {
  return keys.capacity() * sizeof(Key) + mass.memory_usage() +
         sizeof(double) *
             (velocity.capacity() + displacement.capacity() + force.capacity() + acceleration.capacity() + momentum.capacity() +
              inertial_force.capacity() + constraint_factor_.capacity() + given_volume.capacity() + drive_average.capacity()) +
         sizeof(vd) * drive_limit.capacity() + sizeof(int) * aliases.capacity() + constraints.memory_usage();
}

bool Grid::is_at_rest() const {
  return std::all_of(velocity.begin(), velocity.end(), [](double v) { return v == 0.0; });
}

bool Grid::finite() const {
  // A sum is not finite if any term is not. The sum itself overflows only with velocities beyond 1e150.
  double sum = 0.0;
  for (double v : velocity) sum += v * v;
  for (double u : displacement) sum += u * u;
  for (double a : acceleration) sum += std::fabs(a);
  return std::isfinite(sum);
}

}  // namespace mpdem
