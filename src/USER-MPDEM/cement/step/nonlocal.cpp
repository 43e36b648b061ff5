// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "nonlocal.h"

#include <algorithm>

namespace mpdem {

namespace {

// Rows of cut bonds near their threshold, ascending, the same on all ranks.
std::vector<int> cut_rows_near_threshold(const Scene& scene) {
  std::vector<int> mine;
  for (const Bond& b : scene.bonds().resolved())
    if (b.cut_by_ranks() && b.near_threshold) mine.push_back(b.row);
  return scene.agreed_rows(mine);
}

Imperfection imperfection_of(const Scene& scene, const Bond& b) { return {&scene.bonds().record(b), scene.options.imperfection}; }

Bond* cut_bond(Scene& scene, int row) {
  Bond* b = scene.bonds().find(row);
  return b && b->cut_by_ranks() ? b : nullptr;
}

}  // namespace

void average_cut_drives(Scene& scene, const std::vector<int>& rows) {
  const SmoothingPasses passes = smoothing_passes_for(scene.options.length, scene.options.cell, scene.options.basis);
  std::vector<Bond*> cut;
  for (int row : rows)
    if (Bond* b = cut_bond(scene, row)) cut.push_back(b);
  std::vector<const HaloSum*> halos;
  for (Bond* b : cut) halos.push_back(&b->grid.halo);
  HaloSums shared;
  shared.build(halos);
  const auto sum = [&](double* (DriveAverage::*values)()) {
    scene.timer.start(StepTimer::kHalo);
    std::vector<double*> of_bonds;
    for (Bond* b : cut) of_bonds.push_back((b->average.*values)());
    shared.sum(of_bonds, 1);
    scene.timer.start(StepTimer::kPoints);
  };
  for (Bond* b : cut) {
    b->average.start(b->points, b->grid, *scene.law, imperfection_of(scene, *b));
    b->average.find_volumes(b->grid);
  }
  sum(&DriveAverage::volumes);
  sum(&DriveAverage::sums);
  for (int k = 0; k < passes.count; ++k) {
    for (Bond* b : cut) b->average.smooth(b->grid, passes, k);
    if (!passes.is_last(k)) sum(&DriveAverage::sums);
  }
}

void find_near_threshold(const Scene& scene, Bond& b) {
  b.near_threshold = scene.options.advance.nonlocal && is_near_threshold(b.points, *scene.law);
}

void average_drives(Scene& scene, bool any_bond_is_cut) {
  if (!scene.options.advance.nonlocal) return;
  scene.timer.start(StepTimer::kPoints);
  const SmoothingPasses passes = smoothing_passes_for(scene.options.length, scene.options.cell, scene.options.basis);
  std::vector<int> rows;
  if (any_bond_is_cut) rows = cut_rows_near_threshold(scene);
  for (Bond& b : scene.bonds().resolved()) {
    if (b.cut_by_ranks()) {
      if (!std::binary_search(rows.begin(), rows.end(), b.row)) b.grid.drive_average.clear();
      continue;
    }
    if (!b.near_threshold) {
      b.grid.drive_average.clear();
      continue;
    }
    b.average.find(b.points, b.grid, *scene.law, passes, imperfection_of(scene, b));
    DriveAverage::find_limits(b.points, b.grid, *scene.law, b.average.largest_to_come(b.points, b.grid));
  }
  if (rows.empty()) return;
  average_cut_drives(scene, rows);
  std::vector<double> largest(rows.size(), 0.0);
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (const Bond* b = cut_bond(scene, rows[n])) largest[n] = b->average.largest_to_come(b->points, b->grid);
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX, scene.comm);
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (Bond* b = cut_bond(scene, rows[n])) DriveAverage::find_limits(b->points, b->grid, *scene.law, largest[n]);
}

}  // namespace mpdem
