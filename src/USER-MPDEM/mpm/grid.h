// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Background grid in the reference configuration: the nodes that points or links of this
// rank touch, and nothing else. Each body has a grid of its own, anchored at its origin,
// so distant bonds cost nothing between them and a bond is meshed alike wherever it lies.
// Nodes are ordered by field (body and part), i, j, k; three consecutive k of a cell are neighbours in
// memory and make a column.
//
// Leap-frog state after step n: displacement u_n, velocity v_n-1/2, acceleration a_n. Where
// the reference is taken anew in every step (`updated`), displacements are zero, and mass and
// momentum come from the points each time.
#ifndef MPDEM_GRID_H
#define MPDEM_GRID_H

#include <limits>
#include <map>
#include <stdexcept>
#include <vector>

#include "../parallel/halo_sum.h"
#include "body.h"
#include "edge_ties.h"
#include "point_store.h"

namespace mpdem {

struct NodeKinematics {
  std::vector<Key> keys;       // ascending
  std::vector<double> values;  // velocity, displacement, acceleration of each
  static constexpr int kWidth = 9;
};

// With the number of bytes that some rank needs at least.
struct GridTooLarge : std::length_error {
  explicit GridTooLarge(double bytes) : std::length_error("grid too large"), bytes(bytes) {}
  double bytes;
};

class Grid {
 public:
  double h = 0.0;
  Basis basis = Basis::quadratic;
  double most_bytes = std::numeric_limits<double>::infinity();
  std::vector<Key> keys;
  std::vector<double> mass;        // lumped
  std::vector<double> penalty;     // row sums of the penalty stiffness, of the two sides of each node; see coupling/
  std::vector<double> added_mass;  // of the semi-implicit penalty
  std::vector<double> velocity, displacement, force, acceleration;
  std::vector<double> momentum;  // of the points, `updated` only
  EdgeTies ties;

  int size() const { return static_cast<int>(keys.size()); }

  // A cell that needs its nodes, and where to put the first node of each column.
  struct Cell {
    int field;  // field_of(body, part)
    const int* base;
    int* column;
  };

  // Collective. Lays out the nodes of `cells`, carries the motion over
  // from the nodes that any rank had before, and finds the ranks to share them with.
  // Nodes new to everybody start at rest, `fresh` is set for them. The nodes of a new field
  // take the motion of the field it came from. margin: cells around the wanted ones that get
  // nodes too. extra: nodes of no cell. Throws GridTooLarge on all ranks if any would take more
  // than most_bytes.
  void build(MPI_Comm comm, double cell_size, const std::vector<Cell>& cells, const NodeKinematics& restored,
             std::vector<char>& fresh, const std::map<int, int>& parent_field = {}, int margin = 0, const std::vector<Key>& extra = {});

  // Columns of a cell after build(); false if it has no nodes here. base_node: first of all.
  bool find_columns(int field, const int* base, int* column) const;
  int base_node(int field, const int* base) const;
  // Is the cell with this first node at least one cell away from the end of the margin?
  bool well_inside(int base_node) const { return inside_[base_node]; }

  // Collective. Ties nodes of this rank from here on, to the next build(); before lump_mass().
  void tie(MPI_Comm comm, const std::vector<EdgeTie>& wanted);

  // Collective. Lumped mass of the points, density uniform; that of tied nodes with their heirs. of_bodies: of
  // these only, where the grid was built for no others; empty: of all.
  void lump_mass(const PointStore& points, double density, const std::vector<char>& of_bodies = {});

  void clear_force();
  void sum_force() {
    ties.pull_back(force.data());
    halo.sum(force.data(), 3);
  }

  // Collective. The least mass that keeps the central difference stable when the penalty
  // (its row sums, summed over ranks here) comes on top of the cement: every node gets
  // dt^2 (lambda m + k) <= bound (m + c), lambda the largest eigenvalue of the cement; with a bound
  // of it instead, that of a grid without ties, the ties come on top. Most nodes need none.
  void set_added_mass(double dt, double lambda, bool lambda_is_bound, double bound);
  // Factor of a bound of the largest eigenvalue that ties ask for; of this rank's nodes.
  double largest_tie_factor() const;

  // a = f / (m + added mass)
  void update_acceleration();
  // v += dt_v a, u += dt_u v
  void drift(double dt_v, double dt_u);

  bool finite() const;

  NodeKinematics kinematics() const;
  std::size_t memory_usage() const;

  HaloSum halo;

 private:
  bool any_ties_ = false;  // on any rank
  std::vector<double> tie_factor_;  // of the bound, a node; empty without ties
  std::vector<char> inside_;  // of first nodes, with a margin only
};

}  // namespace mpdem

#endif
