// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Shape functions of the background grid: products of 1-D functions. Each 1-D function is a type (linear_hat.h,
// quadratic_bspline.h, cubic_bspline.h), so that kernels are compiled for each of them. In each direction a point at X
// uses kSupport nodes, the first of which is base = floor(X/h - kShift). Points with the same base form a cell. The
// weights of a point, which are the values of the shape functions there, sum to one and reproduce linear fields.
//
// A new basis needs a file with such a type, and an entry at the end of the two lists below; the order is fixed, since
// restart files store the index. The keywords of fix mpm, its messages, the bound of the time step and the kernels
// follow from the type. Members of a type Type, with t = X/h - base:
//   kName           the option of `basis`
//   kSupport        nodes in each direction
//   kShift          see above
//   kMiddle         middle of a cell, measured from its base in units of h
//   factors()       weights and gradients of eight points
//   kAffine         h^2 over the second moment of the weights along an axis, sum w_I (X_I - X)^2; 0 if that moment depends on X
//   kSteepest       maximum over t of sum_I (dN_I/dt)^2 / N_I, 0 if unbounded (eigenvalue_bound, largest_eigenvalue.h)
//   kConstrainedBelow   a node at the edge with less than this share of the mass of the next node inside is constrained
//                   (extension_constraints.h)
//   kMayJoinCells   true if a block may have points of several cells in a row; this does not pay with many nodes
#ifndef MPDEM_MPM_BASIS_H
#define MPDEM_MPM_BASIS_H

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cubic_bspline.h"
#include "linear_hat.h"
#include "quadratic_bspline.h"

namespace mpdem {

template <class... Type>
struct BasisList {
  static constexpr int kNumber = sizeof...(Type), kMostSupport = std::max({Type::kSupport...});
  static std::vector<std::string> names() { return {Type::kName...}; }
};

using Bases = BasisList<LinearHat, QuadraticBspline, CubicBspline>;
enum class Basis { linear, quadratic, cubic };  // index in the list

constexpr int kMostColumns = Bases::kMostSupport * Bases::kMostSupport;

template <class Type, class... Rest, class F>
decltype(auto) with_index_in(BasisList<Type, Rest...>, int index, F& f) {
  if constexpr (sizeof...(Rest) > 0) {
    if (index > 0) return with_index_in(BasisList<Rest...>(), index - 1, f);
  }
  return f(Type());
}

// Calls f with an object of the type of the basis. Kernels have their loop over points in f, so that it is compiled for
// each basis. Helpers such as support() dispatch in each call, by one or two comparisons of integers, which is cheap
// beside the work on a block.
template <class F>
decltype(auto) with_basis(Basis basis, F f) {
  return with_index_in(Bases(), static_cast<int>(basis), f);
}

inline const char* name_of(Basis basis) {
  return with_basis(basis, [](auto type) { return decltype(type)::kName; });
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

// First node of the support of X. shift is cell_shift(basis), a whole number of half cells. For a point on a face of
// cells all callers must get the same cell, or its block and its link would use different ones. So the shift is
// subtracted as an integer. X/h - 1/2 would be rounded once where the compiler contracts the two operations and twice
// elsewhere, which depends on the surrounding code.
inline int support_base(double X, double inverse_h, double shift) {
  return (static_cast<int>(std::floor(X * (2.0 * inverse_h))) - static_cast<int>(2.0 * shift)) >> 1;
}

// A block may have points of two or three neighbouring cells in a row along direction d. `reach` is the number of cells
// beyond the first, 1 or 2. The block has `reach` more nodes in direction d. Templates and BlockMeta::joined have the
// code d + 3 (reach - 1) of the row, or kOneCell. The middle one of three cells may have no point of the block.
constexpr int kOneCell = -1, kMostReach = 2;
constexpr int cells_in_a_row(int d, int reach) { return reach == 0 ? kOneCell : d + 3 * (reach - 1); }
constexpr int reach_along(int joined, int d) { return joined != kOneCell && joined % 3 == d ? 1 + joined / 3 : 0; }
inline bool may_join_cells(Basis basis) {
  return with_basis(basis, [](auto type) { return decltype(type)::kMayJoinCells; });
}

// The node of a column for which the kernels form no products. Its terms follow from those of the others, since weights
// sum to one and gradients to zero. First moments, which can replace gradients, sum to zero as well.
constexpr int kLeftOut = 1;

// 1-D factors of weights and gradients for the eight points of a block. Joined: code of its row of cells, or kOneCell. kI, kJ,
// kK: numbers of nodes of the block in the three directions. kMost: the largest of them.
template <class Type, int Joined = kOneCell>
struct Weights {
  static constexpr int kSupport = Type::kSupport;
  static constexpr int nodes(int d) { return kSupport + reach_along(Joined, d); }
  static constexpr int kReach = Joined == kOneCell ? 0 : 1 + Joined / 3;
  static constexpr int kI = kSupport + reach_along(Joined, 0), kJ = kSupport + reach_along(Joined, 1),
                       kK = kSupport + reach_along(Joined, 2);
  static constexpr int kMost = kSupport + kReach;
  vd w[3][kMost];   // values, [direction][node]
  vd dw[3][kMost];  // derivatives, per length

  // Weights of a block of cells in a row. base: base of the first cell. second, third: lanes in the second and third cell.
  Weights(const vd* X, const int* base, vmask second, vmask third, double inverse_h) {
    static_assert(Joined != kOneCell, "blocks of cells in a row");
    for (int d = 0; d < 3; ++d) {
      if (reach_along(Joined, d) == 0) {
        Type::factors(X[d] * inverse_h - base[d], inverse_h, w[d], dw[d]);
        continue;
      }
      vd of_cell[kSupport], slope[kSupport];
      Type::factors(X[d] * inverse_h - in_cell(second, third, splat(base[d]), splat(base[d] + 1), splat(base[d] + 2)), inverse_h, of_cell,
                    slope);
      for (int i = 0; i < kMost; ++i) {
        w[d][i] = in_cell(second, third, at(of_cell, i), at(of_cell, i - 1), at(of_cell, i - 2));
        dw[d][i] = in_cell(second, third, at(slope, i), at(slope, i - 1), at(slope, i - 2));
      }
    }
  }

  Weights(const vd* X, const int* base, double inverse_h) {
    for (int d = 0; d < 3; ++d) Type::factors(X[d] * inverse_h - base[d], inverse_h, w[d], dw[d]);
  }
  // Weights of points in any cells. base[d] has the base of each lane.
  Weights(const vd* X, const vint* base, double inverse_h) {
    for (int d = 0; d < 3; ++d) Type::factors(X[d] * inverse_h - __builtin_convertvector(base[d], vd), inverse_h, w[d], dw[d]);
  }

 private:
  static vd at(const vd* of_cell, int i) { return i >= 0 && i < kSupport ? of_cell[i] : vd{}; }
  static vd in_cell(vmask second, vmask third, vd of_first, vd of_second, vd of_third) {
    if constexpr (kReach > 1) of_first = select(third, of_third, of_first);
    return select(second, of_second, of_first);
  }
};

// Weights with the first moments w_I (X_I - X) instead of the gradients.
template <class Type, int Joined>
inline Weights<Type, Joined> with_moments(const Weights<Type, Joined>& s, const vd* X, const int* base, double h) {
  Weights<Type, Joined> m(s);
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i < s.nodes(d); ++i) m.dw[d][i] = s.w[d][i] * ((base[d] + i) * h - X[d]);
  return m;
}

}  // namespace mpdem

#endif
