// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nonlocal damage: the driving force Yeq of the points of a bond (material/law.h) is averaged over a length before it is
// compared with its threshold (Pijaudier-Cabot & Bazant, J. Eng. Mech. 113 (1987) 1512), on the grid of the bond:
//
//   S Y = sum_I N_I(X_p) (sum_q N_I(X_q) V_q Y_q) / (sum_q N_I(X_q) V_q)
//
// S keeps constants, and with the volumes as weights it is symmetric and keeps the sum. It takes no neighbour list, and ends
// where unfailed points share no node. A sweep adds (p + 1)/6 h^2 to the variance of the kernel with splines of degree p;
// the average over the length L has the variance L^2: some whole sweeps and a last one of weight theta,
// (1 - theta) Y + theta S Y.
//
// The law is asked with its threshold divided by the amplification a = average/Yeq of the point: its surface is then
// a Yeq = B, and with laws homogeneous in the strain damage is what a strain would make whose drive is the average.
// Its direction is that of the point. Where Yeq is next to nothing under a high average it has none: a is at
// most kMostAmplification. Averages are those of the state that a step starts from.
#ifndef MPDEM_DRIVE_AVERAGE_H
#define MPDEM_DRIVE_AVERAGE_H

#include <vector>

#include "grid.h"
#include "point_store.h"

namespace mpdem {

constexpr double kMostAmplification = 100.0;
// A bond is averaged while a point has this share of the lowest threshold of its law. No average is above the largest Yeq.
constexpr double kNearThreshold = 0.9;

// How often to sweep for the length L, and with what weight the last time.
struct AverageSweeps {
  int count = 0;
  double last_weight = 1.0;  // in (0, 1]
};
AverageSweeps sweeps_for(double length, double cell, Basis basis);

// Has a point that kNearThreshold share of a drive? By an upper bound of it.
bool is_near_threshold(const PointStore& points, const Law& law);

// One bond. The average of points that are on other ranks, too, needs the sums of the nodes over the ranks: after start() of
// volumes() and sums(), after every sweep() but the last of sums().
class DriveAverage {
 public:
  void start(const PointStore& points, const Grid& grid, const Law& law);
  void sweep(const PointStore& points, const Grid& grid, double weight, bool last);
  // Gives the points their amplification.
  void finish(PointStore& points) const;

  double* volumes() { return volume_.data(); }
  double* sums() { return sum_.data(); }
  std::size_t memory_usage() const { return (volume_.capacity() + sum_.capacity() + mean_.capacity()) * sizeof(double) + 2 * own_.capacity() * sizeof(vd); }

 private:
  void find_means();
  std::vector<double> volume_, sum_, mean_;  // of the nodes
  std::vector<vd> own_, field_;              // of the points, 0 where they have failed
};

}  // namespace mpdem

#endif
