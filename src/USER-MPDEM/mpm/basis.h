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

// 1-D factors of weights and gradients for the eight points of a block.
template <class Type>
struct Weights {
  static constexpr int kSupport = Type::kSupport;
  vd w[3][kSupport];   // [direction][node]
  vd dw[3][kSupport];  // per length

  Weights(const vd* X, const int* base, double inverse_h) {
    for (int d = 0; d < 3; ++d) Type::factors(X[d] * inverse_h - base[d], inverse_h, w[d], dw[d]);
  }
};

// With the first moments w_I (X_I - X) in the place of the gradients.
template <class Type>
inline Weights<Type> with_moments(const Weights<Type>& s, const vd* X, const int* base, double h) {
  Weights<Type> m(s);
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i < Type::kSupport; ++i) m.dw[d][i] = s.w[d][i] * ((base[d] + i) * h - X[d]);
  return m;
}

}  // namespace mpdem

#endif
