// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// gather_value and scatter_value (gather.h, scatter.h) for eight points that may be in different cells: each lane has
// its own columns. The vectors run along a column, whose 3 kSupport doubles are consecutive, and not across the points.
// If cells have few points, this is less work for a point than blocks of one cell with empty lanes. Neighbouring lanes
// of one cell read the nodes once, and are summed before they are added to the nodes.
#ifndef MPDEM_MPM_LANE_BY_LANE_H
#define MPDEM_MPM_LANE_BY_LANE_H

#include <cstring>
#include <type_traits>

#include "basis.h"

namespace mpdem {

namespace detail {

// The 3 S doubles of a column of S nodes in two vectors, `head` and `tail`: node by node, three components each.
template <int S>
struct ColumnRow {
  using v2 = double __attribute__((vector_size(16)));
  using v4 = double __attribute__((vector_size(32)));
  using Head = std::conditional_t<S == 2, v4, vd>;
  using Tail = std::conditional_t<S == 2, v2, std::conditional_t<S == 3, double, v4>>;
  static constexpr int kHead = sizeof(Head) / sizeof(double), kValues = 3 * S;
  static_assert(sizeof(Head) + sizeof(Tail) == kValues * sizeof(double), "a head and a tail are a column");

  Head head{};
  Tail tail{};

  void load(const double* p) {
    std::memcpy(&head, p, sizeof head);
    std::memcpy(&tail, p + kHead, sizeof tail);
  }
  void store(double* p) const {
    std::memcpy(p, &head, sizeof head);
    std::memcpy(p + kHead, &tail, sizeof tail);
  }
  void add(double factor, const ColumnRow& r) {
    head += factor * r.head;
    tail += factor * r.tail;
  }
};

// Weights of the columns: products of the weights in the first two directions.
template <class Type>
inline void column_weights(const Weights<Type>& s, vd* w) {
  for (int i = 0; i < Type::kSupport; ++i)
    for (int j = 0; j < Type::kSupport; ++j) w[Type::kSupport * i + j] = s.w[0][i] * s.w[1][j];
}

// Lane k of output l is lane l of input k.
inline void transpose_8(const vd* a, vd* out) {
  vd s[8], t[8];
  for (int p = 0; p < 8; p += 2) {
    s[p] = __builtin_shufflevector(a[p], a[p + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    s[p + 1] = __builtin_shufflevector(a[p], a[p + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int p = 0; p < 8; p += 4)
    for (int k = p; k < p + 2; ++k) {
      t[k] = __builtin_shufflevector(s[k], s[k + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      t[k + 2] = __builtin_shufflevector(s[k], s[k + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  for (int k = 0; k < 4; ++k) {
    out[k] = __builtin_shufflevector(t[k], t[4 + k], 0, 1, 2, 3, 8, 9, 10, 11);
    out[4 + k] = __builtin_shufflevector(t[k], t[4 + k], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

// row[l] has the values of one column for the point of lane l. values[k] has number k of these rows for all eight lanes.
// values_of() finds `values`, rows_of() finds `row`.
template <int S>
inline void values_of(const ColumnRow<S>* row, vd* values) {
  using Row = ColumnRow<S>;
  if constexpr (Row::kHead == kLanes) {
    vd heads[kLanes];
    for (int l = 0; l < kLanes; ++l) heads[l] = row[l].head;
    transpose_8(heads, values);
  }
  constexpr int kDone = Row::kHead == kLanes ? kLanes : 0;
  for (int l = 0; l < kLanes; ++l) {
    double of_lane[Row::kValues];
    row[l].store(of_lane);
    for (int k = kDone; k < Row::kValues; ++k) values[k][l] = of_lane[k];
  }
}
template <int S>
inline void rows_of(const vd* values, ColumnRow<S>* row) {
  using Row = ColumnRow<S>;
  if constexpr (Row::kHead == kLanes) {
    vd heads[kLanes];
    transpose_8(values, heads);
    for (int l = 0; l < kLanes; ++l) {
      row[l].head = heads[l];
      double tail[Row::kValues - kLanes];
      for (int k = kLanes; k < Row::kValues; ++k) tail[k - kLanes] = values[k][l];
      std::memcpy(&row[l].tail, tail, sizeof tail);
    }
  } else {
    for (int l = 0; l < kLanes; ++l) {
      double of_lane[Row::kValues];
      for (int k = 0; k < Row::kValues; ++k) of_lane[k] = values[k][l];
      row[l].load(of_lane);
    }
  }
}

// Calls f(std::integral_constant<int, N>, first lane) for each run of N lanes of `which` in one cell. A cell is
// identified by its first node. N is at most 4, so longer runs are divided.
template <int columns, class F>
inline void for_each_cell(std::uint8_t which, const int* column, F f) {
  for (int l = 0; l < kLanes;) {
    if (!(which >> l & 1)) {
      ++l;
      continue;
    }
    int n = 1;
    while (l + n < kLanes && (which >> (l + n) & 1) && column[columns * (l + n)] == column[columns * l]) ++n;
    if (n >= 4) {
      f(std::integral_constant<int, 4>(), l);
      l += 4;
    } else if (n == 3) {
      f(std::integral_constant<int, 3>(), l);
      l += 3;
    } else if (n == 2) {
      f(std::integral_constant<int, 2>(), l);
      l += 2;
    } else {
      f(std::integral_constant<int, 1>(), l);
      l += 1;
    }
  }
}

}  // namespace detail

// out[c] = sum_I nodal_Ic N_I for the lanes with a bit in `which`, zero in the others. column: first nodes of the kSupport^2
// columns of each lane, one lane after the other.
template <class Type>
inline void gather_value_by_lane(const double* __restrict nodal, std::uint8_t which, const int* column, const Weights<Type>& s, vd* out) {
  constexpr int S = Type::kSupport;
  using Row = detail::ColumnRow<S>;
  vd of_column[S * S], values[Row::kValues];
  detail::column_weights(s, of_column);
  Row row[kLanes];
  detail::for_each_cell<S * S>(which, column, [&](auto lanes, int l) {
    constexpr int N = decltype(lanes)::value;
    Row sum[N];
    for (int n = 0; n < S * S; ++n) {
      Row r;
      r.load(nodal + 3 * static_cast<long>(column[S * S * l + n]));
      for (int i = 0; i < N; ++i) sum[i].add(of_column[n][l + i], r);
    }
    for (int i = 0; i < N; ++i) row[l + i] = sum[i];
  });
  detail::values_of(row, values);
  for (int c = 0; c < 3; ++c) {
    out[c] = vd{};
    for (int k = 0; k < S; ++k) out[c] += s.w[2][k] * values[3 * k + c];
  }
}

// nodal_Ic += sum of T[c] N_I over the lanes whose bits are set in `which`.
template <class Type>
inline void scatter_value_by_lane(double* __restrict nodal, std::uint8_t which, const int* column, const Weights<Type>& s, const vd* T) {
  constexpr int S = Type::kSupport;
  using Row = detail::ColumnRow<S>;
  vd of_column[S * S], values[Row::kValues];
  detail::column_weights(s, of_column);
  for (int k = 0; k < S; ++k)
    for (int c = 0; c < 3; ++c) values[3 * k + c] = T[c] * s.w[2][k];
  Row row[kLanes];
  detail::rows_of(values, row);
  detail::for_each_cell<S * S>(which, column, [&](auto lanes, int l) {
    constexpr int N = decltype(lanes)::value;
    for (int n = 0; n < S * S; ++n) {
      double* p = nodal + 3 * static_cast<long>(column[S * S * l + n]);
      Row r;
      r.load(p);
      for (int i = 0; i < N; ++i) r.add(of_column[n][l + i], row[l + i]);
      r.store(p);
    }
  });
}

}  // namespace mpdem

#endif
