// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Extended B-splines (K. Hoellig, U. Reif, J. Wipper, Weighted extended B-spline approximation of
// Dirichlet problems, SIAM J. Numer. Anal. 39, 2001, 442-462), along the axes of the grid. A node
// at the edge of the cement whose cells hold little of it has next to no stiffness, and what
// stiffness it has the points miss, so a bonded surface that reads it slides. Such a node is tied:
// it moves as the line through the two nodes behind it does, its force goes to them by the same
// weights, and its mass to the nearer of them, so that no mass is negative.
//
// Node i is tied along an axis where its mass is less than a share of that of the next node
// inwards, by 2, -1 from the next two; along the axis with the smallest share, or along several if
// they are alike. Nodes behind may be tied themselves, to others: only free ones are left in the end.
// All masters are heavier than their slave by a factor, so there are no circles. Sums of the weights
// are one, linear fields are kept, so forces and moments are. Lines and not the parabolas of the
// splines: errors are no larger, and weights of 3, -3, 1 couple what is bonded to nodes deep
// inside, which the added mass of stiff links then burdens (coupling/penalty_links.h).
//
// Nodes of the two sheets of a body (crevice.h) are one where the sheets are joined: that of the second
// sheet is tied to that of the first by weight 1, and the edge is looked for with the mass of both.
#ifndef MPDEM_EDGE_TIES_H
#define MPDEM_EDGE_TIES_H

#include <mpi.h>

#include <utility>
#include <vector>

#include "../parallel/rendezvous.h"
#include "basis.h"

namespace mpdem {

struct EdgeTie {
  Key slave{};
  std::vector<std::pair<Key, double>> masters, heirs;  // heirs take the mass, in shares
};

struct TiedNodes {
  std::vector<Key> keys;     // ascending, each once
  std::vector<double> mass;  // summed over ranks
  std::vector<char> sheets;  // of each: kNoSheets, kApart or kJoined with that of the other sheet, if there is one
  std::vector<char> edge;    // of each: may be tied as an edge
};
constexpr char kNoSheets = 0, kApart = 1, kJoined = 2;

// Collective. Ties of the nodes of this rank.
std::vector<EdgeTie> find_edge_ties(MPI_Comm comm, Basis basis, const TiedNodes& nodes);

// The same with places of nodes for keys; slaves, heirs and masters are all on this rank.
class EdgeTies {
 public:
  void bind(const std::vector<EdgeTie>& ties, const std::vector<Key>& keys);
  void clear();
  // What was bound, by the keys it was bound to, in the order of the slaves.
  std::vector<EdgeTie> by_key(const std::vector<Key>& keys) const;

  bool empty() const { return slave_.empty(); }
  std::size_t size() const { return slave_.size(); }
  // Row of a node; -1 if it is free.
  int row(long node) const { return row_.empty() ? -1 : row_[node]; }
  // Sum of the sizes of the weights of a row.
  double weight_sum(int row) const { return weight_sum_[row]; }
  // Calls f(node, weight) for the masters of a row.
  template <class F>
  void for_each_master(int row, F f) const {
    for (int n = first_[row]; n < first_[row + 1]; ++n) f(master_[n], weight_[n]);
  }

  // What slaves have goes to their masters by the weights, three numbers a node...
  void pull_back(double* values) const;
  // ...or by the sizes of the weights, one number a node...
  void pull_back_sizes(double* values) const;
  // ...or to their heirs, as mass does, `width` numbers a node.
  void bequeath(double* values, int width) const;
  // Slaves take the mean of what their heirs have, in the same shares, one number a node.
  void take_of_heirs(double* values) const;
  // Slaves take the value of their masters' polynomial, three numbers a node.
  void extend(double* values) const;

  std::size_t memory_usage() const;

 private:
  std::vector<int> slave_, row_;
  std::vector<int> first_, master_, first_heir_, heir_;
  std::vector<double> weight_, weight_sum_, heir_share_;
};

}  // namespace mpdem

#endif
