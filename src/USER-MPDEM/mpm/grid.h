// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Background grid of one body in the reference configuration: the nodes that its points or links on this
// rank touch, and nothing else. It is anchored at the body's origin,
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

struct GridRequest;

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
  std::vector<Key> keys;
  std::vector<double> mass;        // lumped
  std::vector<double> velocity, displacement, force, acceleration;
  std::vector<double> momentum;  // of the points, `updated` only
  EdgeTies ties;

  int size() const { return static_cast<int>(keys.size()); }

  // A cell that needs its nodes, and where to put the first node of each column.
  struct Cell {
    Cell(int field, const int* base, int* column, int joined = kOneCell)
        : field(field), base{base[0], base[1], base[2]}, column(column), joined(joined) {}
    int field;  // field_of(body, part)
    int base[3];
    int* column;
    int joined;  // with the next cell in this direction: columns of a block of both, see basis.h
    Key key() const { return {field, base[0], base[1], base[2]}; }
    Key next() const {
      Key k = key();
      ++k[1 + joined];
      return k;
    }
  };

  // Collective. Lays out the nodes of `cells`, carries the motion over
  // from the nodes that any rank had before, and finds the ranks to share them with.
  // Nodes new to everybody start at rest, `fresh` is set for them. The nodes of a new field
  // take the motion of the field it came from. margin: cells around the wanted ones that get
  // nodes too. extra: nodes of no cell.
  void build(MPI_Comm comm, double cell_size, const std::vector<Cell>& cells, const NodeKinematics& restored,
             std::vector<char>& fresh, const std::map<int, int>& parent_field = {}, int margin = 0, const std::vector<Key>& extra = {});

  // Columns of a cell after build(); false if it has no nodes here. base_node: first of all.
  bool find_columns(int field, const int* base, int* column) const;
  int base_node(int field, const int* base) const;
  // Is the cell with this first node at least one cell away from the end of the margin?
  bool well_inside(int base_node) const { return inside_[base_node]; }

  // Ties nodes of this rank from here on, to the next build(); before lump_mass(). any: on some rank of those that share the grid.
  void tie(const std::vector<EdgeTie>& wanted, bool any);

  // Collective among the ranks that share nodes. Lumped mass of the points, density uniform; that of tied nodes with their heirs.
  void lump_mass(const PointStore& points, double density);

  void clear_force();
  void sum_force() {
    ties.pull_back(force.data());
    halo.sum(force.data(), 3);
  }

  // Factor of a bound of the largest eigenvalue that ties ask for: of a node, and the largest of this rank's.
  double tie_factor(int node) const { return tie_factor_.empty() ? 1.0 : tie_factor_[node]; }
  double largest_tie_factor() const { return largest_tie_factor_; }

  // a = f / (m + added mass), of each node; no added mass if empty.
  void update_acceleration(const std::vector<double>& added_mass = {});
  // v += dt_v a, u += dt_u v
  void drift(double dt_v, double dt_u);

  bool finite() const;

  NodeKinematics kinematics() const;
  std::size_t memory_usage() const;

  HaloSum halo;

 private:
  friend void build_grids(MPI_Comm, double, int, double, std::vector<GridRequest>&);
  double lay_out(const GridRequest& r, double cell_size, int margin, double most_bytes);
  void set_motion(GridRequest& r, const std::vector<Key>& wanted, const std::vector<double>& values, const std::vector<char>& found);

  bool any_ties_ = false;  // on any rank
  std::vector<double> tie_factor_;  // of the bound, a node; empty without ties
  double largest_tie_factor_ = 1.0;
  std::vector<char> inside_;  // of first nodes, with a margin only
};

// What build() takes, for one of many grids.
struct GridRequest {
  Grid* grid = nullptr;
  std::vector<Grid::Cell> cells;
  NodeKinematics before;            // motion that this rank knows of the body; may be that of all ranks
  std::map<int, int> parent_field;  // of the parts that are new
  std::vector<Key> extra;
  std::vector<char> fresh;          // answer
};

// Collective, for grids of different bodies, ascending. Throws GridTooLarge on all ranks if those of any would take more
// than most_bytes, which is the same number on all ranks.
void build_grids(MPI_Comm comm, double cell_size, int margin, double most_bytes, std::vector<GridRequest>& requests);

}  // namespace mpdem

#endif
