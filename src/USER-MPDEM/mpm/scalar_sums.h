// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Sums of scalars of intact points at the nodes, made many times with the same positions and volumes of the points.
//
// Most points of a bond are in a lattice: a quarter of a cell off the middle of their cell in each direction. Their
// weights are products of the 1-D shape functions at a quarter of h below and above the middle. So values are
// interpolated and summed one direction at a time (sum factorisation, Orszag, J. Comput. Phys. 37 (1980) 70). Cells
// that follow each other along the columns of nodes make a run. A vector has eight cells of a run, so no lanes are
// summed. Each other point, a single point, keeps its own weights, and vectors run along its columns of nodes. Neither
// kernel reads the points. A sum by blocks (gather.h, scatter.h) finds the weights of eight points each time, and sums
// over their lanes.
#ifndef MPDEM_MPM_SCALAR_SUMS_H
#define MPDEM_MPM_SCALAR_SUMS_H

#include <array>
#include <vector>

#include "grid.h"
#include "point_store.h"

namespace mpdem {

class ScalarSums {
 public:
  // Arrays of nodal values must be longer than the number of nodes by this, since vectors reach beyond the nodes.
  static constexpr int kRoom = kLanes;

  // Finds positions and volumes of the intact points. They stay valid until a point moves, fails or changes its block
  // or lane, or nodes of the grid change.
  void find(const PointStore& points, const Grid& grid);
  // Number of single points, which are not in the lattice.
  int single() const { return single_; }

  // sum_I += sum over the points of V N_I
  void add_volumes(double* sum) const { add(volume_.data(), sum); }
  // sum_I += sum over the points of V N_I f, where f is the interpolation of `mean`
  void add_means(const double* mean, double* sum) const;
  // sum_I += sum over the points of N_I f. value(b) returns f at the points of block b.
  template <class F>
  void add_values(F value, double* sum) {
    value_.assign(volume_.size(), vd{});
    double* values = reinterpret_cast<double*>(value_.data());
    for (std::size_t n = 0; n < blocks_.size(); ++n) {
      const vd of_block = value(blocks_[n]);
      for (int l = 0; l < kLanes; ++l)
        if (place_[n][l] >= 0) values[place_[n][l]] += of_block[l];
    }
    add(value_.data(), sum);
  }

  std::size_t memory_usage() const;

 private:
  struct Run {
    int column[kMostColumns];  // first nodes
    int cells;
    int first;  // index of the first vector of the run in volume_
  };
  // First node of a column of the cell of a lane.
  int node_of_cell(const BlockMeta& m, int lane, int column) const;
  void find_points(const PointStore& points, double h, std::vector<int>& cell_at);
  template <class W>
  void add_single(const BlockMeta& m, const W& weights, std::uint8_t which, std::array<int, kLanes>& place);
  void make_runs(const PointStore& points, std::vector<int>& cell_at);
  void add(const vd* values, double* sum) const;

  Basis basis_ = Basis::quadratic;
  std::vector<Run> runs_;
  // Volumes and values of points, first those of runs: eight vectors for eight cells, one vector for each position in a cell.
  // A position has a bit for each direction, 1 for the upper half; the bit of x is the highest. Then come single points.
  std::vector<vd> volume_, value_;
  int first_single_ = 0, single_ = 0;           // index in volume_ of the first single point, and number of single points
  std::vector<int> column_;                     // for each single point: first nodes of its columns; at the end padding
  std::vector<double> weight_;                  // for each single point: weights of its columns, and of the nodes of a column; then padding
  std::vector<int> blocks_;                     // blocks with intact points, ascending
  std::vector<std::array<int, kLanes>> place_;  // for each lane of blocks_: index of a double in volume_, -1 without an intact point
};

}  // namespace mpdem

#endif
