// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// gather_value and scatter_value (gather.h, scatter.h) for eight points that need not be of one cell: each has columns of
// its own. The vectors then run along a column, whose 3 kSupport doubles are consecutive, and not across the points. Where
// points are few in their cells this is less work for a point than blocks of one cell with empty lanes.
#ifndef MPDEM_LANE_BY_LANE_H
#define MPDEM_LANE_BY_LANE_H

#include <cstring>
#include <type_traits>

#include "basis.h"

namespace mpdem {

namespace detail {

// The 3 S doubles of a column, in two vectors.
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

// Weights of the columns: those of the first two directions.
template <class Type>
inline void column_weights(const Weights<Type>& s, vd* w) {
  for (int i = 0; i < Type::kSupport; ++i)
    for (int j = 0; j < Type::kSupport; ++j) w[Type::kSupport * i + j] = s.w[0][i] * s.w[1][j];
}

}  // namespace detail

// out[c] = sum_I nodal_Ic N_I of the lanes of `which`, a bit each; zero in the others. column: kSupport^2 of each lane.
template <class Type>
inline void gather_value_by_lane(const double* __restrict nodal, std::uint8_t which, const int* column, const Weights<Type>& s, vd* out) {
  constexpr int S = Type::kSupport;
  using Row = detail::ColumnRow<S>;
  vd of_column[S * S];
  detail::column_weights(s, of_column);
  double sum[Row::kValues][kLanes] = {};
  for (int l = 0; l < kLanes; ++l) {
    if (!(which >> l & 1)) continue;
    Row all;
    for (int n = 0; n < S * S; ++n) {
      Row r;
      r.load(nodal + 3 * static_cast<long>(column[S * S * l + n]));
      all.add(of_column[n][l], r);
    }
    double values[Row::kValues];
    all.store(values);
    for (int k = 0; k < Row::kValues; ++k) sum[k][l] = values[k];
  }
  for (int c = 0; c < 3; ++c) {
    out[c] = vd{};
    for (int k = 0; k < S; ++k) {
      vd of_lanes;
      std::memcpy(&of_lanes, sum[3 * k + c], sizeof of_lanes);
      out[c] += s.w[2][k] * of_lanes;
    }
  }
}

// nodal_Ic += sum of T[c] N_I over the lanes of `which`.
template <class Type>
inline void scatter_value_by_lane(double* __restrict nodal, std::uint8_t which, const int* column, const Weights<Type>& s, const vd* T) {
  constexpr int S = Type::kSupport;
  using Row = detail::ColumnRow<S>;
  vd of_column[S * S], values[Row::kValues];
  detail::column_weights(s, of_column);
  for (int k = 0; k < S; ++k)
    for (int c = 0; c < 3; ++c) values[3 * k + c] = T[c] * s.w[2][k];
  for (int l = 0; l < kLanes; ++l) {
    if (!(which >> l & 1)) continue;
    double of_lane[Row::kValues];
    for (int k = 0; k < Row::kValues; ++k) of_lane[k] = values[k][l];
    Row add;
    add.load(of_lane);
    for (int n = 0; n < S * S; ++n) {
      double* p = nodal + 3 * static_cast<long>(column[S * S * l + n]);
      Row r;
      r.load(p);
      r.add(of_column[n][l], add);
      r.store(p);
    }
  }
}

}  // namespace mpdem

#endif
