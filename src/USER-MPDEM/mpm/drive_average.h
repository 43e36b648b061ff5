// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nonlocal damage: the strain that drives the damage of a point is an average over a length L (Pijaudier-Cabot &
// Bazant, J. Eng. Mech. 113 (1987) 1512), taken on the grid of the bond. With e the norm of the strain in the driving
// force of the law,
//
//   ebar^(1/2) = S^k e^(1/2),   S f = sum_I N_I(X_p) (sum_q N_I(X_q) V_q f_q) / (sum_q N_I(X_q) V_q)
//
// Constrained nodes (extension_constraints.h), including phantom nodes, give their sums to their mass receivers and
// take the means of these. S preserves constants. With the volumes as weights it is symmetric and conserves the sum. It
// needs no neighbour list, and it ends where unfailed points share no node. With splines of degree
// p a smoothing pass adds (p + 1)/6 h^2 to the variance of the kernel. The strain of a point is itself an average with
// the variance (p + 1)/12 h^2. The sum of the variances is L^2. So there are some whole passes and a last one of weight
// theta, (1 - theta) f + theta S f.
//
// The law takes the strain of the point scaled by ebar/e, with unchanged direction. For a driving force Yeq of degree n
// in the strain this divides the threshold by the amplification a = (ebar/e)^n. Two choices make the band of a crack
// equally wide for every cell size (doc/theory.md, tests/unit/material/test_localisation.cpp). First, the norm is that of the
// strain, not of Yeq(D): if the threshold B does not rise with damage, an average of Yeq(D) shrinks to a single layer
// of points. Second, the square root makes the band nearly as wide at the end as at the beginning, when the strain in
// it is some hundred times that beside it.
//
// The direction of the strain means nothing if e is tiny beside high averages. So a is at most kMostAmplification. The
// average belongs to the state at the start of a step, e to the end of the step. So waves within a step do not change
// the driving force of a point. Failed points take no part in averages.
//
// In the stronger half of a bond (imperfection.h) the roots e^(1/2) count a little less. So an average never exceeds the average of
// the roots themselves, and bounds of this hold for it.
#ifndef MPDEM_MPM_DRIVE_AVERAGE_H
#define MPDEM_MPM_DRIVE_AVERAGE_H

#include <vector>

#include "gather.h"
#include "grid.h"
#include "imperfection.h"
#include "point_store.h"
#include "scalar_sums.h"

namespace mpdem {

constexpr double kMostAmplification = 100.0;
// Averages of a bond begin when the undamaged material would reach this share of the lowest threshold at some point.
// This is safe, since no average exceeds the largest strain. Later, find_limits() gives a better criterion.
constexpr double kNearThreshold = 0.9;

// Number of smoothing passes for the length L, and the weight theta of the last one. A single pass has weight 1, since a smaller
// weight would need the roots of the points themselves beside their means.
struct SmoothingPasses {
  int count = 0;
  double last_weight = 1.0;  // weight theta of the last pass, in (0, 1]
  bool is_last(int k) const { return k == count - 1; }
  double weight(int k) const { return is_last(k) ? last_weight : 1.0; }
};
SmoothingPasses smoothing_passes_for(double length, double cell, Basis basis);

// True if a bound of the driving force of some unfailed point reaches kNearThreshold times the lowest threshold.
bool is_near_threshold(const PointStore& points, const Law& law);

// Average at the points of a block with weights s. Zero if the grid has no average, so that no damage grows.
template <class W>
vd average_at(const Grid& grid, const BlockMeta& m, const W& s) {
  return grid.drive_average.empty() ? vd{} : gather_scalar(grid.drive_average.data(), m.column, s);
}

// Average of one bond. find() is for a bond whose points are all on this rank. Otherwise the caller must sum over the
// ranks: sums() after start(), volumes() after find_volumes(), and sums() after every smooth() but the last.
class DriveAverage {
 public:
  void find(const PointStore& points, Grid& grid, const Law& law, const SmoothingPasses& passes, const Imperfection& imperfection = {}) {
    if (start(points, grid, law, imperfection)) find_volumes(grid);
    for (int k = 0; k < passes.count; ++k) smooth(grid, passes, k);
  }
  // Sets whether points keep their reference positions (default: no). If so, start() finds their weights anew only if a point failed
  // since the last start(), or if the grid has no average. The grid loses its average when nodes or constraints change, which they do
  // whenever points get other lanes or blocks.
  void set_points_fixed(bool fixed) { points_fixed_ = fixed; }
  // Scatters the roots of the norms to the nodes. Returns true if the weights are new. Then find_volumes() must follow.
  bool start(const PointStore& points, Grid& grid, const Law& law, const Imperfection& imperfection);
  // Finds the volumes of the nodes from the points of this rank. For a bond on several ranks it must always follow
  // start(), since points may have failed on other ranks.
  void find_volumes(const Grid& grid);
  // Does smoothing pass k. Between two of them the average is gathered at the points and scattered back. The last one
  // sets grid.drive_average, which the pass over the points interpolates with the weights that it has anyway.
  void smooth(Grid& grid, const SmoothingPasses& passes, int k);

  // Sets grid.drive_limit and clears grid.drive_average if `largest`, the largest average on all ranks, is below the
  // threshold. Else there are no limits, nor with scatter. An average is a mean of roots with weights that are not negative. So it grows
  // no more than the root that grows most, and no point needs an average until some root has grown by the difference of
  // threshold and `largest`. The limit is the square of the driving force of that root. Call it after the smoothing
  // passes, with the strain that was averaged.
  static void find_limits(const PointStore& points, Grid& grid, const Law& law, double largest);
  // Largest average of these points. Infinite if a point has damage, which may grow under any average.
  static double largest(const PointStore& points, const Grid& grid);
  // Bound of largest() for later steps: infinite if points move, since then other points are averaged.
  double largest_to_come(const PointStore& points, const Grid& grid) const;

  double* volumes() { return volume_.data(); }
  double* sums() { return sum_.data(); }
  std::size_t memory_usage() const {
    return (volume_.capacity() + inverse_volume_.capacity() + sum_.capacity() + mean_.capacity()) * sizeof(double) +
           counted_volumes_.capacity() * sizeof(vd) + of_points_.memory_usage();
  }

 private:
  bool points_fixed_ = false;
  std::vector<double> inverse_volume_;       // one number per node
  std::vector<double> volume_, sum_, mean_;  // the same, padded, see scalar_sums.h
  bool volume_is_new_ = false;               // inverse_volume_ is not updated yet
  std::vector<vd> counted_volumes_;          // for each block: volumes times the factor of the imperfection
  int intact_at_start_ = -1;                 // number of unfailed points of this rank at the last start()
  ScalarSums of_points_;
};

}  // namespace mpdem

#endif
