// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A list of all numbers on which the static stiffness of a bond depends, except the law and the cell size. Bonds with
// equal descriptions share one static solution. Numbers are rounded, so that equal bonds at different positions have
// equal descriptions. A description takes about forty numbers of 8 bytes per point, so only its hash is kept.
#ifndef MPDEM_CEMENT_CONDENSED_BOND_DESCRIPTION_H
#define MPDEM_CEMENT_CONDENSED_BOND_DESCRIPTION_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include "../../coupling/bond_ends.h"
#include "../../mpm/grid.h"
#include "../../mpm/point_store.h"

namespace mpdem {

// The grain ends of a bond at its creation.
struct EndsAtCreation {
  BondEnd ends[2] = {};
  explicit EndsAtCreation(const BondRecord& record) {
    for (int s = 0; s < 2; ++s) {
      std::copy(record.centre[s], record.centre[s] + 3, ends[s].x);
      ends[s].R = rotation_of(record.orientation[s]);
    }
  }
};

class BondDescription {
 public:
  // ends: both grain ends of the bond.
  BondDescription(const PointStore& points, const PointStore& film, const Grid& grid, const BondRecord& record, const BondEnd* ends) {
    const double h = grid.h;
    for (int s = 0; s < 2; ++s) {
      add(&record.radius[s], 1, h);
      if (record.grain_E[s] > 0.0) {
        numbers_.insert(numbers_.end(), {record.grain_E[s], record.grain_nu[s]});
        add(record.patch[s], 2, 1.0);
      }
      add(record.centre[s], 3, h);
      add(ends[s].x, 3, h);
      // Only the rotation since creation matters, not the orientation at creation.
      add(product(ends[s].R, transpose(rotation_of(record.orientation[s]))).a[0], 9, 1.0);
    }
    add(grid.displacement.data(), grid.displacement.size(), h);
    numbers_.push_back(film.size());
    for (const PointStore* store : {&points, &film}) add_points(*store, record, h);
  }
  bool operator==(const BondDescription& d) const { return numbers_ == d.numbers_; }
  std::size_t hash() const {
    std::size_t h = numbers_.size();
    for (double n : numbers_) h = (h ^ std::hash<double>()(n)) * 0x9e3779b97f4a7c15ull + (h >> 29);
    return h;
  }

 private:
  void add_points(const PointStore& points, const BondRecord& record, double h) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const PointBlock& p = points.blocks[b];
      add_vectors(p.X, 3, h);
      add_vectors(&p.volume, 1, h * h * h);
      add_vectors(&p.F, 9, 1.0);
      add_vectors(&p.q, 4, 1.0);
      numbers_.push_back(points.meta[b].failed);
      numbers_.push_back(points.meta[b].layer);
      numbers_.push_back(points.meta[b].linked);
      numbers_.push_back(points.meta[b].material);
      if (!points.scatter.empty()) add_vectors(&points.scatter[b], 2, 1.0);
    }
    if (!points.scatter.empty())
      for (const vd& softening : points.softening) add_vectors(&softening, 1, 1.0);
    for (const vd& state : points.states()) add_vectors(&state, 1, 1.0);
    for (const Link& k : points.links) {
      add(k.foot, 3, h);
      add(k.moved, 3, h);
      add(&k.area, 1, h * h);
      add(k.state, kMostLinkFields, 1.0);
      numbers_.push_back(k.slot);
      numbers_.push_back(k.attached + 2 * (k.grain == record.grain[1]));
    }
  }
  static constexpr double kAlike = 1e-9;  // rounding unit of dimensionless numbers; lengths are divided by the cell size
  void add(const double* values, std::size_t count, double unit) {
    for (std::size_t i = 0; i < count; ++i) numbers_.push_back(std::nearbyint(values[i] / (kAlike * unit)) + 0.0);
  }
  void add_vectors(const void* vectors, std::size_t count, double unit) { add(static_cast<const double*>(vectors), kLanes * count, unit); }
  std::vector<double> numbers_;
};

}  // namespace mpdem

#endif
