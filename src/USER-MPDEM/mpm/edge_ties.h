// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Ties of nodes at the edge of the cement. They are the extended B-splines of K. Hoellig, U. Reif and J. Wipper
// (Weighted extended B-spline approximation of Dirichlet problems, SIAM J. Numer. Anal. 39, 2001, 442-462), applied
// along the axes of the grid. A node at the edge whose cells hold little cement has next to no stiffness, and the
// points sample that badly. A bonded surface that depends on such a node slides. So the node is tied: it moves as the
// line through the two nodes behind it does. Its force goes to these by the same weights. Its mass goes to the nearer
// of them, so that no mass is negative.
//
// Node i is tied along an axis where its mass is less than a share of the mass of the next node inwards. The weights
// of the next two nodes are 2 and -1. The axis is that with the smallest share. If the shares of several axes are
// alike, the node is tied along all of these. A node behind may be tied itself. Its own masters then take its place,
// until only free nodes are left. A master is heavier than its slave by a factor, so there are no circles. The
// weights of a slave sum to one and keep linear fields, so forces and moments are kept. Lines are used although the
// splines have parabolas: errors are no larger, and the weights 3, -3, 1 would couple what is bonded to nodes deep
// inside, which the added mass of stiff links then burdens (coupling/added_mass.h).
//
// Where the two sheets of a body (fracture/crevice.h) are joined, they move as one: the node of the second sheet is
// tied to that of the first by weight 1, and the edge is looked for with the mass of both.
#ifndef MPDEM_EDGE_TIES_H
#define MPDEM_EDGE_TIES_H

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

struct EdgeTie {
  Key slave{};
  std::vector<std::pair<Key, double>> masters, heirs;  // heirs take the mass, in shares
  // The two nodes behind along each axis, which may be tied themselves; empty: not known.
  std::vector<std::pair<Key, double>> behind;
};

struct TiedNodes {
  std::vector<Key> keys;     // ascending, each once
  std::vector<double> mass;  // summed over ranks
  std::vector<char> sheets;  // of each: kNoSheets, kApart or kJoined with that of the other sheet, if there is one
  std::vector<char> edge;    // of each: may be tied as an edge
  // The next node in direction -x +x -y +y -z +z, kNoNode if there is none; empty: that of the same field. See fracture/node_copies.h.
  std::function<Key(const Key&, int direction)> next;
};
constexpr char kNoSheets = 0, kApart = 1, kJoined = 2;

// Finds the ties of the nodes of this rank. Collective.
std::vector<EdgeTie> find_edge_ties(MPI_Comm comm, Basis basis, const TiedNodes& nodes);

// Ties with places of nodes instead of keys. Slaves, heirs and masters are all on this rank.
class EdgeTies {
 public:
  // Slaves ascend. Throws std::logic_error if one is not among the keys. whole: no other rank has nodes of the grid.
  void bind(const std::vector<EdgeTie>& ties, const std::vector<Key>& keys, bool whole = false);
  void clear();
  // Nodes went to other places, in the same order.
  void renumber(const std::vector<int>& place);
  // Ties of these nodes (ascending) are these now, whatever they were. Answers whether one that was tied as an edge is not any more, or to
  // others: that takes momentum to another place.
  bool exchange(const std::vector<int>& nodes, const std::vector<EdgeTie>& wanted, const std::vector<Key>& keys);
  // The ties that were bound, by keys, in the order of the slaves.
  std::vector<EdgeTie> by_key(const std::vector<Key>& keys) const;

  bool empty() const { return slave_.empty(); }
  std::size_t size() const { return slave_.size(); }
  // Rows of the nodes before this one.
  int rows_before(int node) const {
    return slave_.with([&](const auto* slaves) { return static_cast<int>(std::lower_bound(slaves, slaves + slave_.size(), node) - slaves); });
  }
  // Row of a node; -1 if it is free.
  int row(int node) const {
    const int at = rows_before(node);
    return at < static_cast<int>(size()) && slave_[at] == node ? at : -1;
  }
  // row() of so many nodes, for who asks for many of them.
  std::vector<int> row_of_each(int nodes) const {
    std::vector<int> rows(nodes, -1);
    for (std::size_t t = 0; t < size(); ++t) rows[slave_[t]] = static_cast<int>(t);
    return rows;
  }
  // Multiplies the value of each slave by the sum of the sizes of its weights.
  void scale_by_weight_sums(double* values) const;
  // Calls f(node, weight) for the masters of a row.
  template <class F>
  void for_each_master(int row, F f) const {
    masters_.for_each(row, f);
  }

  // Moves values of slaves to their masters, by the weights. Three numbers a node.
  void pull_back(double* values) const;
  // As pull_back(), with absolute weights, for one number a node.
  void pull_back_sizes(double* values) const;
  // Moves values of slaves to their heirs, as mass goes. `width` numbers a node.
  void give_to_heirs(double* values, int width) const;
  // Slaves take the mean of what their heirs have, in the same shares.
  void take_of_heirs(double* values, int width) const;
  // Slaves take the value of their masters' polynomial, three numbers a node.
  void extend(double* values) const;

  void share(AlikeLists& alike);
  std::size_t memory_usage() const;

 private:
  // Nodes with a weight each, of each row. Weights of a row are those of many others, and small bonds have many ties, so a row has the place
  // where its weights begin in a list.
  class Rows {
   public:
    void add(int node, double weight) {
      node_.push_back(node);
      weight_.own().push_back(weight);
    }
    void end_row();
    void append(const Rows& other, int row);
    // To begin with rows of another that keep their weights where they are.
    void take_weights(const Rows& other) { weight_ = other.weight_; }
    // Rows [first, end) of one whose weights were taken.
    void append_with_weights(const Rows& other, int first, int end);
    int length(int row) const { return first_[row + 1] - first_[row]; }
    bool same_nodes(int row, const Rows& other, int of_other) const;
    bool same_weights(int row, const Rows& other, int of_other) const;
    void renumber(const std::vector<int>& place);
    void shrink_to_fit();
    void share(AlikeLists& alike);
    template <class F>
    void for_each(int row, F f) const {
      const double* weight = weight_.data() + weights_[row];
      for (int n = first_[row]; n < first_[row + 1]; ++n) f(node_[n], *weight++);
    }
    // Calls f(row, its length, pointer to its nodes, to its weights) for all rows, from the first or from the last one.
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
  void append(const EdgeTies& other, int row);
  void append_with_weights(const EdgeTies& other, int first, int end);
  void bind_chain(const std::vector<EdgeTie>& ties, const std::vector<Key>& keys);
  bool is_chained() const { return !chain_slave_.empty(); }

  ShortList slave_;  // ascending
  Rows masters_, heirs_;
  // The same ties node by node, if they are known: each slave with the nodes behind it, and after those of them that are tied. Where edges meet
  // a slave has more masters than nodes behind it. Sums are rounded in another order by that, so nodes that ranks
  // share, whose nodes behind may not be here, go by their masters.
  ShortList chain_slave_;
  Rows chain_;
};

}  // namespace mpdem

#endif
