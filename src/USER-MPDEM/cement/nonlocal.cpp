// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nonlocal damage: averages of the drive over a length, of bonds that are near the threshold. See mpm/drive_average.h.
#include <algorithm>

#include "cement.h"

namespace mpdem {

// Those of cut bonds, which all their ranks average together.
std::vector<Bond*> Cement::cut_bonds_near_threshold() {
  std::vector<int> mine;
  for (const Bond& b : bonds_.awake())
    if (b.cut_by_ranks() && b.near_threshold) mine.push_back(b.body);
  std::vector<Bond*> near;
  for (int row : agreed_rows(mine)) {
    Bond* b = bonds_.find(row);
    if (b && b->cut_by_ranks()) near.push_back(b);
  }
  return near;
}

void Cement::average_drives() {
  if (!options_.skip.nonlocal) return;
  timer_.start(StepTimer::kPoints);
  const AverageSweeps sweeps = sweeps_for(options_.length, options_.cell, options_.basis);
  const auto weight = [&sweeps](int k) { return k == sweeps.count - 1 ? sweeps.last_weight : 1.0; };
  std::vector<Bond*> cut;
  if (layout_.any_bond_is_cut) cut = cut_bonds_near_threshold();
  for (Bond& b : bonds_.awake()) {
    // In sleep the averages are those of before.
    if (b.resting.asleep()) continue;
    if (b.cut_by_ranks()) {
      if (!std::binary_search(cut.begin(), cut.end(), &b)) b.points.average.clear();
      continue;
    }
    if (!b.near_threshold) {
      b.points.average.clear();
      continue;
    }
    b.average.start(b.points, b.grid, *law_);
    for (int k = 0; k < sweeps.count; ++k) b.average.sweep(b.points, b.grid, weight(k), k == sweeps.count - 1);
  }
  if (cut.empty()) return;
  std::vector<HaloSum*> halos;
  for (Bond* b : cut) halos.push_back(&b->grid.halo);
  HaloSums shared;
  shared.build(halos);
  const auto sum = [&](double* (DriveAverage::*values)()) {
    timer_.start(StepTimer::kHalo);
    std::vector<double*> of_bonds;
    for (Bond* b : cut) of_bonds.push_back((b->average.*values)());
    shared.sum(of_bonds, 1);
    timer_.start(StepTimer::kPoints);
  };
  for (Bond* b : cut) b->average.start(b->points, b->grid, *law_);
  sum(&DriveAverage::volumes);
  sum(&DriveAverage::sums);
  for (int k = 0; k < sweeps.count; ++k) {
    const bool last = k == sweeps.count - 1;
    for (Bond* b : cut) b->average.sweep(b->points, b->grid, weight(k), last);
    if (!last) sum(&DriveAverage::sums);
  }
}

}  // namespace mpdem
