// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The stiffness of one bond as an assembled matrix with its Cholesky factor. Unknowns are the displacements of free
// nodes. A constrained node is the sum of its masters. Nodes are ordered in levels, so that each level is coupled with
// itself and its neighbours alone (BlockTridiagonal): a breadth-first search from one end of the bond to the other.
//
// Call couple() for all sets of nodes that share stiffness, then order(), then the functions that add stiffness, then
// factorise(). The whole bond must be on this rank.
#ifndef MPDEM_MPM_STIFFNESS_MATRIX_H
#define MPDEM_MPM_STIFFNESS_MATRIX_H

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "../material/law.h"
#include "../numerics/block_tridiagonal.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

// The unknown nodes of each node, with weights: a free node is its own unknown, a constrained one is the sum of its masters.
class UnknownsOfNodes {
 public:
  UnknownsOfNodes(const Grid& grid, const std::vector<char>& is_unknown);
  std::size_t size() const { return node_.size(); }
  int node(std::size_t unknown) const { return node_[unknown]; }
  // Calls f(unknown, weight).
  template <class F>
  void for_each(int node, F f) const {
    for (int n = first_[node]; n < first_[node + 1]; ++n) f(unknown_[n], weight_[n]);
  }

 private:
  std::vector<int> node_;  // for each unknown, its node
  std::vector<int> first_ = {0}, unknown_;
  std::vector<double> weight_;
};

// Unknowns in the order in which they were added, each once.
class UnknownSet {
 public:
  explicit UnknownSet(std::size_t unknowns) : place_(unknowns, -1) {}
  void clear();
  int place(int unknown);  // index of the unknown in the list; adds it if it is new
  std::vector<int> list;

 private:
  std::vector<int> place_;
};

class StiffnessMatrix {
 public:
  // is_unknown: whether a node is an unknown, for each free node.
  StiffnessMatrix(const Grid& grid, const std::vector<char>& is_unknown);

  // Nodes of blocks with intact points, and other nodes that share stiffness.
  void couple(const PointStore& points);
  void couple(const std::vector<int>& nodes);

  // Orders the unknowns. Returns false if the factorisation would take more than `most` multiplications.
  bool order(double most);

  // Adds the stiffness of add_stiffness_force(), without failed points.
  void add(const PointStore& points, const Law& law);
  // Adds springs to weighted sums over the same nodes. stiffness: force by displacement, symmetric.
  struct Spring {
    std::array<double, kMostColumns * Bases::kMostSupport> weight;  // weight of each node in the sum
    Eigen::Matrix3d stiffness;
  };
  void add(const std::vector<int>& nodes, const std::vector<Spring>& springs);
  // Adds a number to the diagonal entries of each free node.
  void add_to_diagonal(const std::vector<double>& of_node);

  // See BlockTridiagonal::factorise().
  bool factorise(double least) { return matrix_.factorise(least); }
  // Finds the displacement x of the free nodes by the nodal force r, three numbers per node. It is zero at nodes that are
  // no unknowns.
  void solve(const std::vector<double>& r, std::vector<double>& x);

 private:
  // Levels of the unknowns by a breadth-first search from `start`, in one list with the first index of each level.
  struct Levels {
    std::vector<int> unknowns, first;
    double multiplications() const;
  };
  Levels levels_from(int start) const;
  // Adds the matrix motion_^T load_ for the unknowns in set_, three columns each. It must be symmetric.
  void add_product(int rows, int columns);
  template <class Type, class L>
  void add_blocks(const PointStore& points, int first, int last, const L& law);

  const Grid& grid_;
  UnknownsOfNodes unknowns_;
  std::vector<int> sets_, first_of_set_ = {0};  // coupled unknowns
  UnknownSet set_;                              // unknowns of the block or links that are added
  std::vector<int> level_, place_;              // level of each unknown, and its index in the level
  std::vector<int> first_of_level_;
  BlockTridiagonal matrix_;
  Eigen::VectorXd in_order_;
  Eigen::MatrixXd motion_, load_, product_;  // of the block or links that are added: rows by columns of unknowns
};

}  // namespace mpdem

#endif
