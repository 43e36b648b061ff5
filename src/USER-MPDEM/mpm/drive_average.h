// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nonlocal damage: the strain that drives the damage of a point is an average over a length (Pijaudier-Cabot & Bazant, J. Eng. Mech.
// 113 (1987) 1512), on the grid of the bond. With e the norm of the strain that the law has in its drive,
//
//   ebar^(1/2) = S^k e^(1/2),   S f = sum_I N_I(X_p) (sum_q N_I(X_q) V_q f_q) / (sum_q N_I(X_q) V_q)
//
// where tied nodes (edge_ties.h), copies of split nodes among them, give their sums to their heirs and have the means of these.
// S keeps constants, and with the volumes as weights it is symmetric and keeps the sum. It takes no neighbour list, and ends
// where unfailed points share no node. With splines of degree p a sweep adds (p + 1)/6 h^2 to the variance of the kernel, and
// the strain of a point is an average with the variance (p + 1)/12 h^2 already. All together has the variance L^2: some whole
// sweeps and a last one of weight theta, (1 - theta) f + theta S f.
//
// The law is asked with its strain scaled by ebar/e, whose direction is that of the point: with a drive Yeq of degree n in the
// strain, that is a threshold divided by the amplification a = (ebar/e)^n. Two choices make the band of a crack as wide for every
// cell (doc/theory.md, tests/unit/test_localisation.cpp). The norm is that of the strain, not of the drive Yeq(D): where the
// threshold B does not rise with damage, an average of Yeq(D) shrinks to a single layer of points. The root makes the band
// nearly as wide in the end as in the beginning: the strain in it is some hundred times that beside it then.
//
// Where e is next to nothing beside high averages its direction says nothing: a is at most kMostAmplification. The average is that of the
// state that a step starts from, e that of its end: what waves do to a point within a step has no part in its drive. Failed points
// have no part in averages.
#ifndef MPDEM_DRIVE_AVERAGE_H
#define MPDEM_DRIVE_AVERAGE_H

#include <vector>

#include "gather.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

constexpr double kMostAmplification = 100.0;
// A bond is averaged while the undamaged material would have this share of the lowest threshold at some point: no average of the
// strain is above the largest. Once it has been averaged, find_limits() knows better.
constexpr double kNearThreshold = 0.9;

// How often to sweep for the length L, and with what weight the last time. A single sweep is whole: a part of it would need the roots at the points.
struct AverageSweeps {
  int count = 0;
  double last_weight = 1.0;  // in (0, 1]
  bool is_last(int k) const { return k == count - 1; }
  double weight(int k) const { return is_last(k) ? last_weight : 1.0; }
};
AverageSweeps sweeps_for(double length, double cell, Basis basis);

// Has a point that kNearThreshold share of a drive? By an upper bound of it.
bool is_near_threshold(const PointStore& points, const Law& law);

// Of the points of a block with weights s. 0 without an average: nothing grows.
template <class W>
vd average_at(const Grid& grid, const BlockMeta& m, const W& s) {
  return grid.drive_average.empty() ? vd{} : gather_scalar(grid.drive_average.data(), m.column, s);
}

// One bond. find() is for one whose points are all on this rank. The average of points that are on other ranks, too, needs the sums of the nodes over
// the ranks: after start() of volumes() and sums(), after every sweep() but the last of sums().
class DriveAverage {
 public:
  void find(const PointStore& points, Grid& grid, const Law& law, const AverageSweeps& sweeps, bool volumes_stand = false) {
    start(points, grid, law, volumes_stand);
    for (int k = 0; k < sweeps.count; ++k) sweep(points, grid, sweeps, k);
  }
  // Takes the roots of the norms to the nodes. volumes_stand: points are where they were in the last start. The volumes of the nodes are found anew then
  // only if a point has failed since, or the nodes have changed.
  void start(const PointStore& points, Grid& grid, const Law& law, bool volumes_stand = false);
  // The kth of the sweeps. Sets grid.drive_average, whose interpolation is the average at a point. Between two sweeps it is taken to the points and
  // back. After the last one the pass over the points interpolates it, whose weights are there already.
  void sweep(const PointStore& points, Grid& grid, const AverageSweeps& sweeps, int k);

  // An average is a mean of the roots of points with weights that are not negative: it grows by no more than the root grows that grows most. So
  // there is nothing to average until some root has grown by what the largest average lacks of the threshold. Sets grid.drive_limit to the drives
  // of that, and takes the averages away, if the largest is below the threshold. Else the points have no limits.
  // After the sweeps, with the strain that was averaged; `largest` of the averages of all ranks.
  static void find_limits(const PointStore& points, Grid& grid, const Law& law, double largest);
  // The largest average of these points; infinite if some have damage, which grows under any average.
  static double largest(const PointStore& points, const Grid& grid);

  double* volumes() { return volume_.data(); }
  double* sums() { return sum_.data(); }
  std::size_t memory_usage() const { return (volume_.capacity() + sum_.capacity()) * sizeof(double); }

 private:
  std::vector<double> volume_, sum_;  // of the nodes
  int holding_ = -1;                  // points that volume_ is of
};

}  // namespace mpdem

#endif
