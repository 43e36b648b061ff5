// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "scalar_sums.h"

#include <cstring>
#include <utility>

namespace mpdem {

namespace {

constexpr double kRoundingOfPositions = 1e-9;  // rounding of the positions of points, in cells
constexpr int kNone = -1;
constexpr int kSingle = -2;  // while indices are found, single point n has the index kSingle - n

using v4 = double __attribute__((vector_size(32)));
constexpr int kAlong = 4;  // weights along the column of a single point; no basis has more
static_assert(Bases::kMostSupport <= kAlong && kAlong <= ScalarSums::kRoom, "vectors along a column fit");

template <class V>
inline V load(const double* p) {
  V v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
template <class V>
inline void store(double* p, V v) {
  std::memcpy(p, &v, sizeof v);
}

// The vector that begins k lanes before `now`, where `before` is the vector before it.
template <int k>
inline vd shifted(const vd& before, const vd& now) {
  static_assert(k >= 0 && k < 4, "no basis has more nodes");
  if constexpr (k == 0) return now;
  if constexpr (k == 1) return __builtin_shufflevector(before, now, 7, 8, 9, 10, 11, 12, 13, 14);
  if constexpr (k == 2) return __builtin_shufflevector(before, now, 6, 7, 8, 9, 10, 11, 12, 13);
  return __builtin_shufflevector(before, now, 5, 6, 7, 8, 9, 10, 11, 12);
}

// Kernels for eight cells of a run. Lane n belongs to cell n, or to the node at its beginning. `half` is 0 for lower
// and 1 for upper points.
template <class Type>
class RunKernels {
 public:
  static constexpr int S = Type::kSupport, kColumns = S * S;

  RunKernels() {
    vd of[S], slope[S];
    Type::factors(Type::kMiddle + vd{-0.25, 0.25}, 1.0, of, slope);
    for (int half = 0; half < 2; ++half)
      for (int i = 0; i < S; ++i) w_[half][i] = of[i][half];
  }

  // Interpolates f at the points of eight cells, times their factors. `first`: the first of these cells in their run.
  void gather(const double* f, const int* column, int first, const vd* factor, vd* value) const {
    for (int half = 0; half < 2; ++half) {
      vd of_column[kColumns], of_plane[S][2];
      for (int c = 0; c < kColumns; ++c) {
        const double* nodes = f + column[c] + first;
        of_column[c] = w_[half][0] * load<vd>(nodes);
        for (int k = 1; k < S; ++k) of_column[c] += w_[half][k] * load<vd>(nodes + k);
      }
      for (int i = 0; i < S; ++i)
        for (int b = 0; b < 2; ++b) of_plane[i][b] = weighted(of_column + S * i, 1, w_[b]);
      for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) value[4 * a + 2 * b + half] = factor[4 * a + 2 * b + half] * weighted(&of_plane[0][b], 2, w_[a]);
    }
  }

  // Adds the values of the points of a run to its nodes. values(first) returns those of eight cells.
  template <class Values>
  void scatter(const int* column, int cells, double* __restrict sum, Values values) const {
    vd of_column[2][kColumns][2]{};  // [half][column][cells before, cells now]
    // A node gets values of the cell that begins there, and of the S - 1 cells before it.
    for (int first = 0; first < cells + S - 1; first += kLanes) {
      const vd* value = first < cells ? values(first) : nullptr;
      for (int half = 0; half < 2; ++half) {
        vd now[kColumns]{};
        if (value) scatter_across(value, half, now);
        for (int c = 0; c < kColumns; ++c) {
          of_column[half][c][0] = of_column[half][c][1];
          of_column[half][c][1] = now[c];
        }
      }
      for (int c = 0; c < kColumns; ++c)
        scatter_along(of_column[0][c], of_column[1][c], sum + column[c] + first, std::make_integer_sequence<int, S>());
    }
  }

 private:
  static vd weighted(const vd* f, int stride, const double* w) {
    vd s = w[0] * f[0];
    for (int k = 1; k < S; ++k) s += w[k] * f[stride * k];
    return s;
  }
  // of_column[c] = sum over the points of half a cell
  void scatter_across(const vd* value, int half, vd* of_column) const {
    for (int i = 0; i < S; ++i) {
      vd of_plane[2];
      for (int b = 0; b < 2; ++b) of_plane[b] = w_[0][i] * value[2 * b + half] + w_[1][i] * value[4 + 2 * b + half];
      for (int j = 0; j < S; ++j) of_column[S * i + j] = w_[0][j] * of_plane[0] + w_[1][j] * of_plane[1];
    }
  }
  template <int... k>
  void scatter_along(const vd* lower, const vd* upper, double* nodes, std::integer_sequence<int, k...>) const {
    vd s = load<vd>(nodes);
    ((s += w_[0][k] * shifted<k>(lower[0], lower[1]) + w_[1][k] * shifted<k>(upper[0], upper[1])), ...);
    store(nodes, s);
  }

  double w_[2][S];
};

// Kernels for one point. weight: of its S^2 columns, then of the nodes along a column.
template <int S>
inline double gather_alone(const double* f, const int* column, const double* weight) {
  v4 of_nodes = weight[0] * load<v4>(f + column[0]);
  for (int c = 1; c < S * S; ++c) of_nodes += weight[c] * load<v4>(f + column[c]);
  of_nodes *= load<v4>(weight + S * S);
  return (of_nodes[0] + of_nodes[1]) + (of_nodes[2] + of_nodes[3]);
}
template <int S>
inline void scatter_single(double value, const int* column, const double* weight, double* sum) {
  const v4 of_nodes = value * load<v4>(weight + S * S);
  for (int c = 0; c < S * S; ++c) store(sum + column[c], load<v4>(sum + column[c]) + weight[c] * of_nodes);
}

// Finds the lanes that are in the lattice, and their positions in their cells.
std::uint8_t in_lattice(const PointBlock& p, const BlockMeta& m, double inverse_h, double middle, int (&place)[kLanes]) {
  vmask upper[3], in = lanes(m.occupied & static_cast<std::uint8_t>(~m.failed));
  for (int d = 0; d < 3; ++d) {
    vd base = splat(m.base[d]);
    if (reach_along(m.joined, d) > 0) base += select(lanes(m.second), splat(1.0), vd{}) + select(lanes(m.third), splat(2.0), vd{});
    const vd off = p.X[d] * inverse_h - (base + middle);
    in &= abs(abs(off) - 0.25) < kRoundingOfPositions;
    upper[d] = off > 0.0;
  }
  for (int l = 0; l < kLanes; ++l) place[l] = 4 * (upper[0][l] != 0) + 2 * (upper[1][l] != 0) + (upper[2][l] != 0);
  return bits(in);
}

}  // namespace

// A cell is identified by its first node. The lanes of a block in a row of cells may be in different cells.
int ScalarSums::node_of_cell(const BlockMeta& m, int lane, int column) const {
  const int S = support(basis_);
  int off[3];
  for (int d = 0; d < 3; ++d) off[d] = cell_of(m, lane, d) - m.base[d];
  return m.column[nodes_along(m, 1, S) * (off[0] + column / S) + off[1] + column % S] + off[2];
}

void ScalarSums::find(const PointStore& points, const Grid& grid) {
  basis_ = grid.basis;
  std::vector<int> cell_at(grid.size(), kNone);  // for the cell that begins at a node: slot of a point, later index in volume_
  find_points(points, grid.h, cell_at);
  make_runs(points, cell_at);
  first_single_ = static_cast<int>(kLanes * volume_.size());
  volume_.resize(volume_.size() + (single_ + kLanes - 1) / kLanes, vd{});
  double* volumes = reinterpret_cast<double*>(volume_.data());
  for (std::size_t n = 0; n < blocks_.size(); ++n)
    for (int l = 0; l < kLanes; ++l) {
      int& at = place_[n][l];
      if (at == kNone) continue;
      // Replaces what find_points() has set by the index of a double in volume_.
      at = at >= 0 ? cell_at[at / kLanes] + kLanes * (at % kLanes) : first_single_ + (kSingle - at);
      volumes[at] += points.blocks[blocks_[n]].volume[l];
    }
}

// Sets place_ for the points of a lattice to eight times the first node of their cell, plus their position in the cell.
void ScalarSums::find_points(const PointStore& points, double h, std::vector<int>& cell_at) {
  blocks_.clear();
  place_.clear();
  single_ = 0;
  const double inverse_h = 1.0 / h, middle = cell_middle(basis_);
  for (int b = 0; b < static_cast<int>(points.blocks.size()); ++b) {
    const PointBlock& p = points.blocks[b];
    const BlockMeta& m = points.meta[b];
    const std::uint8_t intact = m.occupied & static_cast<std::uint8_t>(~m.failed);
    if (intact == 0) continue;
    blocks_.push_back(b);
    place_.emplace_back();
    place_.back().fill(kNone);
    int place[kLanes];
    const std::uint8_t in = points.motion.empty() ? in_lattice(p, m, inverse_h, middle, place) : 0;
    for (int l = 0; l < kLanes; ++l) {
      if (!(in >> l & 1)) continue;
      const int node = node_of_cell(m, l, 0);
      cell_at[node] = kLanes * b + l;
      place_.back()[l] = kLanes * node + place[l];
    }
    const std::uint8_t others = intact & static_cast<std::uint8_t>(~in);
    if (others == 0) continue;
    with_basis(basis_, [&](auto type) {
      with_weights<decltype(type)>(p, m, inverse_h, [&](const auto& s) { add_single(m, s, others, place_.back()); });
    });
  }
}

template <class W>
void ScalarSums::add_single(const BlockMeta& m, const W& s, std::uint8_t which, std::array<int, kLanes>& place) {
  constexpr int S = W::kSupport, kColumns = S * S, kWeights = kColumns + kAlong;
  // The lists keep their length, since with `updated` they are filled in each step.
  const std::size_t room = single_ + kLanes;
  if (column_.size() < kColumns * room) {
    column_.resize(kColumns * 2 * room);
    weight_.resize(kWeights * 2 * room);
  }
  for (int l = 0; l < kLanes; ++l) {
    if (!(which >> l & 1)) continue;
    int off[3] = {0, 0, 0};
    if constexpr (W::kReach > 0)
      for (int d = 0; d < 3; ++d) off[d] = cell_of(m, l, d) - m.base[d];
    int* column = &column_[kColumns * single_];
    double* weight = &weight_[kWeights * single_];
    for (int i = 0; i < S; ++i)
      for (int j = 0; j < S; ++j) {
        column[S * i + j] = m.column[W::kJ * (off[0] + i) + off[1] + j] + off[2];
        weight[S * i + j] = s.w[0][off[0] + i][l] * s.w[1][off[1] + j][l];
      }
    for (int k = 0; k < kAlong; ++k) weight[kColumns + k] = k < S ? s.w[2][off[2] + k][l] : 0.0;
    place[l] = kSingle - single_++;
  }
}

// Replaces the slots of cells by indices into volume_.
void ScalarSums::make_runs(const PointStore& points, std::vector<int>& cell_at) {
  runs_.clear();
  volume_.clear();
  const int columns = support(basis_) * support(basis_);
  bool follows = false;  // true if the node before is the first one of a cell
  for (int& at : cell_at) {
    if (at == kNone) {
      follows = false;
      continue;
    }
    // A cell that begins at the node after the first one of a cell is the next of the run.
    if (!std::exchange(follows, true)) {
      runs_.push_back({{}, 0, static_cast<int>(volume_.size())});
      for (int c = 0; c < columns; ++c) runs_.back().column[c] = node_of_cell(points.meta[at / kLanes], at % kLanes, c);
    }
    const int lane = runs_.back().cells++ % kLanes;
    if (lane == 0) volume_.insert(volume_.end(), kLanes, vd{});
    at = static_cast<int>(kLanes * (volume_.size() - kLanes)) + lane;
  }
}

void ScalarSums::add(const vd* values, double* sum) const {
  with_basis(basis_, [&](auto type) {
    constexpr int S = decltype(type)::kSupport;
    const RunKernels<decltype(type)> kernels;
    for (const Run& r : runs_) kernels.scatter(r.column, r.cells, sum, [&](int first) { return values + r.first + first; });
    const double* of_single = reinterpret_cast<const double*>(values) + first_single_;
    for (int n = 0; n < single_; ++n) scatter_single<S>(of_single[n], &column_[S * S * n], &weight_[(S * S + kAlong) * n], sum);
  });
}

void ScalarSums::add_means(const double* mean, double* sum) const {
  with_basis(basis_, [&](auto type) {
    constexpr int S = decltype(type)::kSupport;
    const RunKernels<decltype(type)> kernels;
    vd value[kLanes];
    for (const Run& r : runs_)
      kernels.scatter(r.column, r.cells, sum, [&](int first) -> const vd* {
        kernels.gather(mean, r.column, first, &volume_[r.first + first], value);
        return value;
      });
    const double* volume = reinterpret_cast<const double*>(volume_.data()) + first_single_;
    for (int n = 0; n < single_; ++n) {
      const int* column = &column_[S * S * n];
      const double* weight = &weight_[(S * S + kAlong) * n];
      scatter_single<S>(volume[n] * gather_alone<S>(mean, column, weight), column, weight, sum);
    }
  });
}

std::size_t ScalarSums::memory_usage() const {
  return runs_.capacity() * sizeof(Run) + (volume_.capacity() + value_.capacity()) * sizeof(vd) +
         (column_.capacity() + blocks_.capacity()) * sizeof(int) + weight_.capacity() * sizeof(double) +
         place_.capacity() * sizeof(place_[0]);
}

}  // namespace mpdem
