// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_scatter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "material_runs.h"

namespace mpdem {

namespace {

// Softening for factors on the energy of a crack, tabulated over the logarithm of the factor: the search takes long.
class SofteningTable {
 public:
  explicit SofteningTable(const Law& law) {
    for (int n = 0; n <= kSteps; ++n) value_.push_back(law.softening_for(std::exp(kLeast + n * kStep)));
  }
  double at(double factor) const {
    const double t = std::clamp((std::log(factor) - kLeast) / kStep, 0.0, kSteps - 1e-9);
    const std::size_t n = static_cast<std::size_t>(t);
    return value_[n] + (t - static_cast<double>(n)) * (value_[n + 1] - value_[n]);
  }

 private:
  static constexpr int kSteps = 400;
  static constexpr double kLeast = -3.0, kStep = 0.015;  // factors from 0.05 to 20
  std::vector<double> value_;
};

using Position = std::array<double, 3>;

// Calls f(block, lane, position in the axes of the bond) for the points of blocks [first, last).
template <class F>
void for_each_point(const PointStore& points, int first, int last, F f) {
  for (int b = first; b < last; ++b) {
    const vd* X = points.created_at(b);
    for (int l = 0; l < kLanes; ++l)
      if (points.meta[b].occupied >> l & 1) f(b, l, Position{X[0][l], X[1][l], X[2][l]});
  }
}

struct Extent {
  Position low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void add(const Position& x) {
    for (int d = 0; d < 3; ++d) {
      low[d] = std::min(low[d], x[d]);
      high[d] = std::max(high[d], x[d]);
    }
  }
  bool empty() const { return low[0] > high[0]; }
};

ScatterOfBond scatter_of_bond(const Scatter& scatter, const BondRecord& record, const Extent& e) {
  return ScatterOfBond(scatter, record.grain[0], record.grain[1], e.low, e.high);
}

}  // namespace

void find_softening(PointStore& points, const BondRecord& record, double cell) {
  points.softening.clear();
  const Law& base = *points.law();
  const bool is_seam = record.is_thinner_than(cell);
  bool any = is_seam;
  for (int n = 0; n < base.materials(); ++n) any = any || base.of_material(n).softens_by_position();
  if (!any) return;
  points.softening.resize(points.blocks.size());
  for_each_material(points, base, [&](const auto& law, int first, int last) {
    for (int b = first; b < last; ++b) {
      const vd* at = points.created_at(b);
      for (int l = 0; l < kLanes; ++l) {
        const double X[3] = {at[0][l], at[1][l], at[2][l]};
        const double above[2] = {above_grain(record, 0, X), above_grain(record, 1, X)};
        points.softening[b][l] = is_seam                     ? law.softening_of_layer(above[0] + above[1])
                                 : law.softens_by_position() ? law.softening_at(above[0], above[1])
                                                             : law.softening();
      }
    }
  });
}

namespace {

// Calls f(law, values of the scatter of the bond, first, last) for each material that has scatter.
template <class F>
void for_each_scatter(const PointStore& points, const BondRecord& record, const Mat3<double>& axes, F f) {
  for_each_material(points, *points.law(), [&](const auto& law, int first, int last) {
    if (law.scatter().rules.empty()) return;
    Extent extent;
    for_each_point(points, first, last, [&](int, int, const Position& X) { extent.add(position_in_box(record, axes, X.data())); });
    if (!extent.empty()) f(law, scatter_of_bond(law.scatter(), record, extent), first, last);
  });
}

}  // namespace

void find_scatter(PointStore& points, const BondRecord& record) {
  points.scatter.clear();
  if (!points.law()->any_scatter()) return;
  points.scatter.resize(points.blocks.size());
  const Mat3<double> axes = axes_of(record);
  for_each_scatter(points, record, axes, [&](const auto& law, const ScatterOfBond& drawn, int first, int last) {
    const int degree = law.degree();
    for_each_point(points, first, last, [&](int b, int l, const Position& X) {
      const Position x = position_in_box(record, axes, X.data());
      const double moduli = drawn.factor(Scattered::moduli, x.data());
      double strength = drawn.factor(Scattered::strength, x.data());
      if (points.meta[b].linked >> l & 1) strength *= drawn.factor(Scattered::interface, x.data());
      points.scatter[b].stiffness[l] = moduli;
      points.scatter[b].strength[l] = degree == 2 ? strength * strength / moduli : strength;
    });
  });
}

void scatter_softening(PointStore& points, const BondRecord& record) {
  if (!points.law()->any_scatter(Scattered::energy)) return;
  if (points.softening.empty()) {
    points.softening.resize(points.blocks.size());
    for_each_material(points, *points.law(), [&](const auto& law, int first, int last) {
      std::fill(points.softening.begin() + first, points.softening.begin() + last, splat(law.softening()));
    });
  }
  const Mat3<double> axes = axes_of(record);
  for_each_scatter(points, record, axes, [&](const auto& law, const ScatterOfBond& drawn, int first, int last) {
    if (!law.scatter().has(Scattered::energy)) return;
    const SofteningTable table(law);
    for_each_point(points, first, last, [&](int b, int l, const Position& X) {
      points.softening[b][l] = table.at(drawn.factor(Scattered::energy, position_in_box(record, axes, X.data()).data()));
    });
  });
}

vd drawn_strength(const PointStore& points, int b) {
  if (points.scatter.empty()) return splat(1.0);
  const PointScatter& s = points.scatter[b];
  return points.law()->degree() == 2 ? sqrt(s.strength * s.stiffness) : s.strength;
}

std::vector<double> interface_factors(const Scatter& scatter, const BondRecord& record, const std::vector<std::array<double, 3>>& at) {
  std::vector<double> factors;
  if (!scatter.has(Scattered::interface) || at.empty()) return factors;
  const Mat3<double> axes = axes_of(record);
  Extent extent;
  for (const Position& X : at) extent.add(position_in_box(record, axes, X.data()));
  const ScatterOfBond drawn = scatter_of_bond(scatter, record, extent);
  for (const Position& X : at) factors.push_back(drawn.factor(Scattered::interface, position_in_box(record, axes, X.data()).data()));
  return factors;
}

}  // namespace mpdem
