// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Row sums of the stiffness of springs that act on the cement, added up at free nodes. Added mass is proportional to
// them.
#ifndef MPDEM_COUPLING_FREE_WEIGHTS_H
#define MPDEM_COUPLING_FREE_WEIGHTS_H

#include <cmath>
#include <vector>

#include "../mpm/grid.h"

namespace mpdem {

// Weights of one position at free nodes. A constrained node passes its weight to its masters.
class FreeWeights {
 public:
  explicit FreeWeights(const Grid& grid)
      : ties_(grid.constraints), row_(grid.constraints.row_of_each(grid.size())), weight_(grid.size(), 0.0), used_(grid.size(), 0) {}

  // Adds the row sums of a link of stiffness k at the position given by its columns and lane l of its weights. `sums`
  // points to the number of one grain at the first node. Each node has two such numbers.
  template <class Type>
  void add_row_sums(const int* column, const Weights<Type>& w, int l, double k, double* sums) {
    constexpr int S = Type::kSupport;
    clear();
    for (int i = 0; i < S; ++i)
      for (int j = 0; j < S; ++j)
        for (int n = 0; n < S; ++n) add(column[S * i + j] + n, w.w[0][i][l] * w.w[1][j][l] * w.w[2][n][l]);
    const double row = k * sum_of_sizes();
    for (int node : nodes_) sums[2 * static_cast<long>(node)] += row * size_at(node);
  }

 private:
  void clear() {
    for (int n : nodes_) {
      weight_[n] = 0.0;
      used_[n] = 0;
    }
    nodes_.clear();
  }
  void add(int node, double weight) {
    const int row = row_[node];
    if (row < 0) add_free(node, weight);
    else ties_.for_each_master(row, [&](int master, double share) { add_free(master, share * weight); });
  }
  // A row of the stiffness matrix of a link has the entries k |w_I| |w_J| at most.
  double sum_of_sizes() const {
    double sum = 0.0;
    for (int n : nodes_) sum += std::fabs(weight_[n]);
    return sum;
  }
  double size_at(int node) const { return std::fabs(weight_[node]); }
  void add_free(int node, double weight) {
    if (!used_[node]) nodes_.push_back(node);
    used_[node] = 1;
    weight_[node] += weight;
  }
  const ExtensionConstraints& ties_;
  std::vector<int> row_;        // for each node, ExtensionConstraints::row()
  std::vector<double> weight_;  // for each node, the sum of weights so far
  std::vector<char> used_;
  std::vector<int> nodes_;  // nodes with a weight
};

}  // namespace mpdem

#endif
