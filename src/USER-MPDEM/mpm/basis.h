// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Shape functions of the background grid. They are products of 1-D functions. Each 1-D function is a type
// (linear_tent.h, quadratic_bspline.h, cubic_bspline.h), so that a kernel is compiled for each of them. In each
// direction a point at X uses kSupport nodes, the first of which is base = floor(X/h - kShift). Points with the same
// base form a cell. The weights of a point sum to one and reproduce linear fields.
//
// kAffine is h^2 over the second moment of the weights, sum w_I (X_I - X)^2, if that moment is the same at all
// places, and 0 if it is not.
#ifndef MPDEM_BASIS_H
#define MPDEM_BASIS_H

#include <cmath>

#include "cubic_bspline.h"
#include "linear_tent.h"
#include "quadratic_bspline.h"

namespace mpdem {

enum class Basis { linear, quadratic, cubic };

constexpr int kMostColumns = CubicBspline::kSupport * CubicBspline::kSupport;

// Calls f with an object of the type of the basis; never inside a loop over points.
template <class F>
decltype(auto) with_basis(Basis basis, F f) {
  if (basis == Basis::linear) return f(LinearTent());
  if (basis == Basis::cubic) return f(CubicBspline());
  return f(QuadraticBspline());
}

inline int support(Basis basis) {
  return with_basis(basis, [](auto type) { return decltype(type)::kSupport; });
}
inline double cell_shift(Basis basis) {
  return with_basis(basis, [](auto type) { return decltype(type)::kShift; });
}
inline double cell_middle(Basis basis) {
  return with_basis(basis, [](auto type) { return decltype(type)::kMiddle; });
}

// First node of the support, shift = cell_shift(basis).
inline int support_base(double X, double inverse_h, double shift) {
  return static_cast<int>(std::floor(X * inverse_h - shift));
}

// Blocks of points of two cells next to each other: the direction in which the second lies. They have a node more there.
constexpr int kOneCell = -1;
// Cubic splines have too many nodes for it to pay.
template <class Type>
constexpr bool kMayJoinCells = Type::kSupport < CubicBspline::kSupport;
inline bool may_join_cells(Basis basis) {
  return with_basis(basis, [](auto type) { return kMayJoinCells<decltype(type)>; });
}

// 1-D factors of weights and gradients for the eight points of a block.
template <class Type, int Joined = kOneCell>
struct Weights {
  static constexpr int kSupport = Type::kSupport;
  // Nodes in each direction.
  static constexpr int kI = kSupport + (Joined == 0), kJ = kSupport + (Joined == 1), kK = kSupport + (Joined == 2);
  static constexpr int nodes(int d) { return kSupport + (d == Joined); }
  static constexpr int kMost = kSupport + (Joined != kOneCell);
  vd w[3][kMost];   // [direction][node]
  vd dw[3][kMost];  // per length

  // Lanes of `second` are in the second cell, base is that of the first.
  Weights(const vd* X, const int* base, vmask second, double inverse_h) {
    static_assert(Joined != kOneCell, "blocks of two cells");
    for (int d = 0; d < 3; ++d) {
      if (d != Joined) {
        Type::factors(X[d] * inverse_h - base[d], inverse_h, w[d], dw[d]);
        continue;
      }
      vd of_cell[kSupport], slope[kSupport];
      Type::factors(X[d] * inverse_h - select(second, splat(base[d] + 1), splat(base[d])), inverse_h, of_cell, slope);
      for (int i = 0; i <= kSupport; ++i) {
        w[d][i] = select(second, i > 0 ? of_cell[i - 1] : vd{}, i < kSupport ? of_cell[i] : vd{});
        dw[d][i] = select(second, i > 0 ? slope[i - 1] : vd{}, i < kSupport ? slope[i] : vd{});
      }
    }
  }

  Weights(const vd* X, const int* base, double inverse_h) {
    for (int d = 0; d < 3; ++d) Type::factors(X[d] * inverse_h - base[d], inverse_h, w[d], dw[d]);
  }
  // Of points of different cells, a base for each.
  Weights(const vd* X, const vint* base, double inverse_h) {
    for (int d = 0; d < 3; ++d) Type::factors(X[d] * inverse_h - __builtin_convertvector(base[d], vd), inverse_h, w[d], dw[d]);
  }
};

// With the first moments w_I (X_I - X) in the place of the gradients.
template <class Type, int Joined>
inline Weights<Type, Joined> with_moments(const Weights<Type, Joined>& s, const vd* X, const int* base, double h) {
  Weights<Type, Joined> m(s);
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i < s.nodes(d); ++i) m.dw[d][i] = s.w[d][i] * ((base[d] + i) * h - X[d]);
  return m;
}

}  // namespace mpdem

#endif
