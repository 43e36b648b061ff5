// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Constraints of nodes at the edge of the cement: extended B-splines (K. Hoellig, U. Reif and J. Wipper, Weighted
// extended B-spline approximation of Dirichlet problems, SIAM J. Numer. Anal. 39, 2001, 442-462), applied along the
// axes of the grid. A node at the edge whose cells hold little cement has very little stiffness, which the points
// sample badly. A bonded surface that depends on such a node slides. So the node is constrained: its motion is
// extrapolated linearly from the two nodes behind it, and its force goes to these by the same weights. Its mass goes to
// the nearer of them, the mass receiver, so that no mass is negative.
//
// A node is constrained along an axis if its mass is less than a share of the mass of the next node inwards, and at
// most half of that of the second. The weights of these two nodes are 2 and -1. The second may be at an edge itself. In
// cement one cell wide the points resolve the motion of two nodes, but not of three: a third free node has almost no
// stiffness, and static solutions displace it by many times the motion of the grains. The chosen axis is that with the
// smallest share. If the shares of several axes are alike, the node is constrained along all of these.
//
// A node behind may be constrained itself. It is then replaced by its own masters, until only free nodes are left. A
// master is heavier than its constrained node by a factor, so there are no cycles. The weights of a constrained node
// sum to one and reproduce linear fields, so forces and moments are conserved. Extrapolation is linear although the
// splines are parabolas: errors are no larger, and the weights 3, -3, 1 would couple bonded nodes to nodes deep inside,
// which would then get the added mass of stiff links (coupling/added_mass.h).
#ifndef MPDEM_MPM_EXTENSION_CONSTRAINTS_H
#define MPDEM_MPM_EXTENSION_CONSTRAINTS_H

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "../numerics/short_list.h"
#include "../parallel/rendezvous.h"
#include "basis.h"

namespace mpdem {

struct ExtensionConstraint {
  Key constrained{};
  std::vector<std::pair<Key, double>> masters, mass_receivers;  // mass receivers with their shares of the mass
  // The two nodes behind along each axis of the constraint, which may be constrained themselves. Empty if not known.
  std::vector<std::pair<Key, double>> behind;
};

struct EdgeNodes {
  std::vector<Key> keys;     // ascending, each once
  std::vector<double> mass;  // summed over ranks
  // Returns the next node in direction 0 to 5, which are -x +x -y +y -z +z; kNoNode if there is none. If the function
  // is empty, the next node is that of the same field. See fracture/phantom_nodes.h.
  std::function<Key(const Key&, int direction)> next;
};

// Finds the constraints of the nodes of this rank. Collective.
std::vector<ExtensionConstraint> find_extension_constraints(MPI_Comm comm, Basis basis, const EdgeNodes& nodes);

// Constraints with node indices instead of keys. Constrained nodes, mass receivers and masters are all on this rank.
class ExtensionConstraints {
 public:
  // The constrained nodes must ascend. Throws std::logic_error if they do not, or if a node is not among the keys.
  // chained: make the chain, see below. No other rank may then have nodes of the grid.
  void bind(const std::vector<ExtensionConstraint>& constraints, const std::vector<Key>& keys, bool chained = false);
  void clear();
  // Follows nodes that got other indices. Their order must be the same.
  void renumber(const std::vector<int>& new_index);
  // Replaces the constraints of these nodes (ascending) by the wanted ones. Returns true if a node at the edge becomes free or gets
  // other masters, weights or mass receivers, which moves momentum between nodes. Nodes at the edge are those with several masters.
  bool replace(const std::vector<int>& nodes, const std::vector<ExtensionConstraint>& wanted, const std::vector<Key>& keys);
  // Returns the constraints with keys instead of indices, in the order of the constrained nodes.
  std::vector<ExtensionConstraint> by_key(const std::vector<Key>& keys) const;

  bool empty() const { return constrained_.empty(); }
  std::size_t size() const { return constrained_.size(); }
  int rows_before(int node) const {
    return constrained_.with([&](const auto* constrained_nodes) {
      return static_cast<int>(std::lower_bound(constrained_nodes, constrained_nodes + constrained_.size(), node) - constrained_nodes);
    });
  }
  // Row of a node, or -1 if it is free.
  int row(int node) const {
    const int at = rows_before(node);
    return at < static_cast<int>(size()) && constrained_[at] == node ? at : -1;
  }
  // row() of all nodes [0, nodes).
  std::vector<int> row_of_each(int nodes) const {
    std::vector<int> rows(nodes, -1);
    for (std::size_t t = 0; t < size(); ++t) rows[constrained_[t]] = static_cast<int>(t);
    return rows;
  }
  // Multiplies the value of each constrained node by the sum of the absolute values of its weights.
  void scale_by_weight_sums(double* values) const;
  // Calls f(node, weight) for the masters of a row.
  template <class F>
  void for_each_master(int row, F f) const {
    masters_.for_each(row, f);
  }

  // Both add the values of constrained nodes to their masters by the weights, and zero them. Three numbers per node, or one.
  void gather_to_masters(double* values) const;
  void gather_scalars_to_masters(double* values) const;
  // Adds with the absolute values of the weights, one number per node.
  void gather_sizes_to_masters(double* values) const;
  // Adds the values of constrained nodes to their mass receivers by the shares, and zeroes them. `width` numbers per node.
  void add_to_mass_receivers(double* values, int width) const;
  // Sets each constrained node to the mean of its mass receivers, weighted by the same shares.
  void mean_of_mass_receivers(double* values, int width) const;
  // Sets each constrained node to the value extrapolated from its masters, three numbers per node.
  void extend(double* values) const;

  void share(AlikeLists& alike);
  std::size_t memory_usage() const;

 private:
  // Rows of nodes with weights. Small bonds have many constraints, and many of these have the same weights. So a row
  // has the index in a common list at which its weights begin.
  class Rows {
   public:
    void add(int node, double weight) {
      node_.push_back(node);
      weight_.own().push_back(weight);
    }
    void end_row();  // the row has the entries that add() has added since the last row
    void append(const Rows& other, int row);
    // Uses the list of weights of another object, whose rows can then be appended with append_sharing_weights().
    void take_weights(const Rows& other) { weight_ = other.weight_; }
    // Appends the rows [first, end) of an object whose list of weights is in use.
    void append_sharing_weights(const Rows& other, int first, int end);
    int length(int row) const { return first_[row + 1] - first_[row]; }
    bool same_nodes(int row, const Rows& other, int of_other) const;
    bool same_weights(int row, const Rows& other, int of_other) const;
    void renumber(const std::vector<int>& new_index);
    void shrink_to_fit();
    void share(AlikeLists& alike);
    template <class F>
    void for_each(int row, F f) const {
      const double* weight = weight_.data() + first_weight_[row];
      for (int n = first_[row]; n < first_[row + 1]; ++n) f(node_[n], *weight++);
    }
    // Calls f(row, length, pointer to its nodes, pointer to its weights) for all rows, ascending or backwards.
    template <class F>
    void for_each_row(bool backwards, F f) const;
    std::size_t memory_usage() const;

   private:
    // first_: first entry of each row, and the number of entries; node_: of each entry; first_weight_: index in weight_ of each row.
    ShortList first_ = begun(), node_, first_weight_;
    SharedList<double> weight_;
    static ShortList begun() {
      ShortList list;
      list.push_back(0);
      return list;
    }
  };
  void append(const ExtensionConstraints& other, int row);
  void append_sharing_weights(const ExtensionConstraints& other, int first, int end);
  void bind_chain(const std::vector<ExtensionConstraint>& constraints, const std::vector<Key>& keys);
  template <class T>
  void gather_to_masters_as(double* values) const;
  bool is_chained() const { return !chain_constrained_.empty(); }

  ShortList constrained_;  // ascending
  Rows masters_, mass_receivers_;
  // The chain: each constrained node with the nodes directly behind it, after those of them that are constrained
  // themselves. Empty if the nodes behind are not known. Where edges meet, a node has more masters than nodes behind
  // it, so the chain takes less work. But it rounds sums in another order. So nodes that ranks share use the masters,
  // since the nodes behind may be on another rank.
  ShortList chain_constrained_;
  Rows chain_;
};

}  // namespace mpdem

#endif
