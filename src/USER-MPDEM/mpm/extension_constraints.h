// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Ties of nodes at the edge of the cement. They are the extended B-splines of K. Hoellig, U. Reif and J. Wipper
// (Weighted extended B-spline approximation of Dirichlet problems, SIAM J. Numer. Anal. 39, 2001, 442-462), applied
// along the axes of the grid. A node at the edge whose cells hold little cement has next to no stiffness, and the
// points sample that badly. A bonded surface that depends on such a node slides. So the node is tied: it moves by
// linear extrapolation from the two nodes behind it. Its force goes to these by the same weights. Its mass goes to the
// nearer of them, so that no mass is negative.
//
// A node is tied along an axis if its mass is less than a share of the mass of the next node inwards, and at most half
// of that of the second. The weights of these two nodes are 2 and -1. The second may be at an edge itself. In cement one
// cell wide the points see how two nodes move, and not how three do: one that is free besides has next to no stiffness,
// and statics have it off by many times the motion of the grains. The chosen axis is that with the smallest share. If the shares of several axes are
// alike, the node is tied along all of these. A node behind may be tied itself. Its own masters then take its place,
// until only free nodes are left. A master is heavier than its slave by a factor, so there are no circles. The weights
// of a slave sum to one and keep linear fields, so forces and moments are kept. Extrapolation is linear although the
// splines are parabolas. Errors are no larger. Also, the weights 3, -3, 1 would couple bonded nodes to nodes deep
// inside, and the added mass of stiff links would burden these (coupling/added_mass.h).
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
  Key slave{};
  std::vector<std::pair<Key, double>> masters, mass_receivers;  // heirs take the mass, in shares
  // The two nodes behind along each axis, which may be tied themselves. Empty if they are not known.
  std::vector<std::pair<Key, double>> behind;
};

struct TiedNodes {
  std::vector<Key> keys;     // ascending, each once
  std::vector<double> mass;  // summed over ranks
  // Gives the next node in direction 0 to 5, which are -x +x -y +y -z +z; kNoNode if there is none. If the function is
  // empty, the next node is that of the same field. See fracture/phantom_nodes.h.
  std::function<Key(const Key&, int direction)> next;
};

// Finds the ties of the nodes of this rank. Collective.
std::vector<ExtensionConstraint> find_extension_constraints(MPI_Comm comm, Basis basis, const TiedNodes& nodes);

// Ties with places of nodes instead of keys. Slaves, heirs and masters are all on this rank.
class ExtensionConstraints {
 public:
  // The slaves must ascend. Throws std::logic_error if they do not, or if a node is not among the keys. chained: make the chain, see below. No other rank may have nodes of the grid then.
  void bind(const std::vector<ExtensionConstraint>& ties, const std::vector<Key>& keys, bool chained = false);
  void clear();
  // Follows nodes that went to other places, in the same order.
  void renumber(const std::vector<int>& new_index);
  // Replaces the ties of these nodes (ascending) by the wanted ones. Returns true if a node that was tied as an edge is
  // now free or has other masters, weights or heirs. This takes momentum to another place.
  bool exchange(const std::vector<int>& nodes, const std::vector<ExtensionConstraint>& wanted, const std::vector<Key>& keys);
  // Returns the ties with keys instead of places, in the order of the slaves.
  std::vector<ExtensionConstraint> by_key(const std::vector<Key>& keys) const;

  bool empty() const { return slave_.empty(); }
  std::size_t size() const { return slave_.size(); }
  // Number of rows that belong to nodes before this one.
  int rows_before(int node) const {
    return slave_.with(
        [&](const auto* slaves) { return static_cast<int>(std::lower_bound(slaves, slaves + slave_.size(), node) - slaves); });
  }
  // Row of a node, or -1 if it is free.
  int row(int node) const {
    const int at = rows_before(node);
    return at < static_cast<int>(size()) && slave_[at] == node ? at : -1;
  }
  // row() of the nodes [0, nodes), for callers that need many of them.
  std::vector<int> row_of_each(int nodes) const {
    std::vector<int> rows(nodes, -1);
    for (std::size_t t = 0; t < size(); ++t) rows[slave_[t]] = static_cast<int>(t);
    return rows;
  }
  // Multiplies the value of each slave by the sum of the absolute values of its weights.
  void scale_by_weight_sums(double* values) const;
  // Calls f(node, weight) for the masters of a row.
  template <class F>
  void for_each_master(int row, F f) const {
    masters_.for_each(row, f);
  }

  // Moves values of slaves to their masters by the weights, three numbers a node, or one.
  void gather_to_masters(double* values) const;
  void gather_scalars_to_masters(double* values) const;
  // Moves values of slaves to their masters by the absolute weights, one number a node.
  void gather_sizes_to_masters(double* values) const;
  // Moves values of slaves to their heirs, as mass goes. Values have `width` numbers a node.
  void add_to_mass_receivers(double* values, int width) const;
  // Gives each slave the mean of the values of its heirs, in the same shares as their mass.
  void mean_of_mass_receivers(double* values, int width) const;
  // Gives each slave the value extrapolated from its masters, three numbers a node.
  void extend(double* values) const;

  void share(AlikeLists& alike);
  std::size_t memory_usage() const;

 private:
  // Rows of nodes with weights. Many rows have the same weights, and small bonds have many ties. So a row keeps the
  // place where its weights begin in a common list.
  class Rows {
   public:
    void add(int node, double weight) {
      node_.push_back(node);
      weight_.own().push_back(weight);
    }
    void end_row();
    void append(const Rows& other, int row);
    // Takes over the list of weights of another object. Its rows can then be appended with append_with_weights().
    void take_weights(const Rows& other) { weight_ = other.weight_; }
    // Appends the rows [first, end) of an object whose weights were taken over.
    void append_with_weights(const Rows& other, int first, int end);
    int length(int row) const { return first_[row + 1] - first_[row]; }
    bool same_nodes(int row, const Rows& other, int of_other) const;
    bool same_weights(int row, const Rows& other, int of_other) const;
    void renumber(const std::vector<int>& new_index);
    void shrink_to_fit();
    void share(AlikeLists& alike);
    template <class F>
    void for_each(int row, F f) const {
      const double* weight = weight_.data() + weights_[row];
      for (int n = first_[row]; n < first_[row + 1]; ++n) f(node_[n], *weight++);
    }
    // Calls f(row, its length, pointer to its nodes, pointer to its weights) for all rows, in ascending order or backwards.
    template <class F>
    void for_each_row(bool backwards, F f) const;
    std::size_t memory_usage() const;

   private:
    ShortList first_ = begun(), node_, weights_;  // first entry of a row, nodes of entries, first weight of a row
    SharedList<double> weight_;
    static ShortList begun() {
      ShortList list;
      list.push_back(0);
      return list;
    }
  };
  void append(const ExtensionConstraints& other, int row);
  void append_with_weights(const ExtensionConstraints& other, int first, int end);
  void bind_chain(const std::vector<ExtensionConstraint>& ties, const std::vector<Key>& keys);
  template <class T>
  void gather_to_masters_as(double* values) const;
  bool is_chained() const { return !chain_slave_.empty(); }

  ShortList slave_;  // ascending
  Rows masters_, mass_receivers_;
  // The ties link by link, if the nodes behind are known: each slave with the nodes directly behind it, in an order in
  // which a slave follows those of these nodes that are tied themselves. Where edges meet, a slave has more masters
  // than nodes behind it, so this takes less work. But it rounds sums in another order. So nodes that ranks share,
  // whose nodes behind may be on another rank, use the masters.
  ShortList chain_slave_;
  Rows chain_;
};

}  // namespace mpdem

#endif
