// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Background grid of one bond in the reference configuration. It has only the nodes that points or links of this rank
// touch. It is anchored at the origin of the bond, so the space between distant bonds costs nothing, and a bond is
// meshed alike wherever it lies. Nodes are ordered by field (bond and layer), i, j and k. The nodes of a cell with
// consecutive k are neighbours in memory and form a column.
//
// After step n the nodes have the state of the leap-frog scheme: displacement u_n, velocity v_n-1/2, acceleration a_n.
// With `updated` kinematics the reference is new in every step: displacements are zero, and mass and momentum come from
// the points each time. Vector fields have three numbers per node.
#ifndef MPDEM_MPM_GRID_H
#define MPDEM_MPM_GRID_H

#include <limits>
#include <map>
#include <stdexcept>
#include <vector>

#include "../numerics/shared_list.h"
#include "../parallel/halo_sum.h"
#include "bond_record.h"
#include "extension_constraints.h"
#include "point_store.h"

namespace mpdem {

struct GridRequest;

struct NodeKinematics {
  std::vector<Key> keys;       // ascending
  std::vector<double> values;  // velocity, displacement and acceleration of each node
  static constexpr int kWidth = 9;
};

// Thrown if the grids of some rank are too large. bytes: the least that this rank needs.
struct GridTooLarge : std::length_error {
  explicit GridTooLarge(double bytes) : std::length_error("grid too large"), bytes(bytes) {}
  double bytes;
};

class Grid {
 public:
  double h = 0.0;
  Basis basis = Basis::quadratic;
  std::vector<Key> keys;
  SharedList<double> mass;  // lumped
  std::vector<double> velocity, displacement, force, acceleration;
  std::vector<double> momentum;        // momentum that points gave to the nodes; with `updated` kinematics only
  std::vector<double> inertial_force;  // (M_L - M) a, see consistent_mass.h; empty with the lumped mass alone
  ExtensionConstraints constraints;
  // Volume of each node from which its mass follows; -1 where the mass follows from the points. Empty if that is so at all nodes. See
  // fracture/phantom_nodes.h.
  std::vector<double> given_volume;
  // Nodes of the blocks without columns, in the order of for_each_node(). See BlockMeta::aliases.
  std::vector<int> aliases;
  // Nodal values whose interpolation is the average of the root of the norm of strain, see drive_average.h. Empty while
  // nothing is averaged, and after nodes or constraints change.
  std::vector<double> drive_average;
  // Limits for the points of each block: while no square_bound() of the law exceeds its limit, no average reaches the
  // threshold. Empty if limits are not known, and after nodes or constraints change. See DriveAverage::find_limits().
  std::vector<vd> drive_limit;

  int size() const { return static_cast<int>(keys.size()); }

  // A cell that needs nodes. `column` receives the first node of each column.
  struct Cell {
    Cell(Field field, const int* base, int* column, int joined = kOneCell)
        : field(field), base{base[0], base[1], base[2]}, column(column), joined(joined) {}
    Field field;  // field_of(row, layer)
    int base[3];
    int* column;
    int joined;  // code of a row of cells with one block, see basis.h; `column` then receives the columns of the whole row
    Key key() const { return {field, base}; }
    Key last() const {
      int last[3];
      for (int d = 0; d < 3; ++d) last[d] = base[d] + reach_along(joined, d);
      return {field, last};
    }
  };

  // Collective. Lays out the nodes of `cells`, sets the motion of nodes that any rank had before, and finds the ranks
  // that share nodes. A node that no rank had before starts at rest, and `fresh` is set for it. margin: width of the
  // rim of cells around the wanted ones that gets nodes, too, in cells. extra: nodes that belong to no cell.
  void build(MPI_Comm comm, double cell_size, const std::vector<Cell>& cells, const NodeKinematics& restored, std::vector<char>& fresh,
             int margin = 0, const std::vector<Key>& extra = {});

  // Finds the columns of a cell after build(). Returns false if this rank lacks a node of the cell. base_node() returns the first node
  // of the cell, or -1, and node_at() the node with this key, or -1.
  bool find_columns(Field field, const int* base, int* column) const;
  int base_node(Field field, const int* base) const;
  int node_at(const Key& k) const;
  // True if the cell with this first node is at least one cell away from the end of the margin.
  bool well_inside(int base_node) const { return inside_[base_node]; }

  // Adds new nodes (ascending) at rest and returns the new index of each old node. No other rank may share the grid.
  std::vector<int> add_nodes(const std::vector<Key>& more);
  // Gives each node (first key) the motion of another (second key) at the call. Leaves out pairs with an absent node.
  void copy_motion(const std::map<Key, Key>& source);
  // Finds the columns of a block. Throws std::logic_error if the grid does not have its nodes.
  void find_columns(BlockMeta& m) const;
  // Replaces the constraints of these nodes (ascending). Returns true if a node that was constrained at the edge is now
  // free or constrained in another way. Call lump_mass() then. No other rank may share the grid.
  bool replace_constraints(const std::vector<int>& nodes, const std::vector<ExtensionConstraint>& wanted);

  // Constrains nodes of this rank until the next build(). Must be called before lump_mass(). any: true if some rank
  // that shares the grid has constraints. chained: see ExtensionConstraints; false if replace_constraints() is to give the same
  // result as constrain().
  void constrain(const std::vector<ExtensionConstraint>& wanted, bool any, bool chained = true);

  // Finds the lumped mass from the points, or from given_volume where that is set. The mass
  // of constrained nodes goes to their mass receivers. Collective among the ranks that share nodes.
  void lump_mass(const PointStore& points, const CementDensity& density);
  // Lumped mass of the points of this rank alone, without constraints. intact_only: only of intact points.
  std::vector<double> local_mass(const PointStore& points, const CementDensity& density, bool intact_only = false) const;

  void clear_force();
  void sum_force() {
    constraints.gather_to_masters(force.data());
    halo.sum(force.data(), 3);
  }

  // Constraints raise the bound of the largest eigenvalue (largest_eigenvalue.h) by a factor. constraint_factor() is the factor at a
  // node, and largest_constraint_factor() is the largest one of the nodes of this rank.
  double constraint_factor(int node) const {
    return constraint_factor_.empty() || constraints.row(node) >= 0 ? 1.0 : constraint_factor_[node - constraints.rows_before(node)];
  }
  double largest_constraint_factor() const { return largest_constraint_factor_; }

  // Sets a = f / (m + added mass) for each node. There is no added mass if the list is empty. Accelerations overwrite
  // the forces in their array, so that a step passes over one array and not over two.
  void update_acceleration(const SharedList<double>& added_mass = {});
  // update_acceleration() in two steps. accelerate() divides the forces of the nodes [first, end), which must have no
  // added mass and no constraint. All free nodes must be divided before finish_accelerations(), which extends them to
  // constrained nodes.
  void accelerate(int first, int end);
  void finish_accelerations();
  // Starts the forces of a step in the array of the accelerations, which are overwritten.
  void begin_forces() {
    force.swap(acceleration);
    clear_force();
  }
  // v += dt_v a, then u += dt_u v.
  void drift(double dt_v, double dt_u);

  bool finite() const;
  bool is_at_rest() const;  // true if all velocities are zero

  NodeKinematics kinematics() const;
  // Shares lists with other grids that have equal ones, to save memory.
  void share(AlikeLists& alike);
  std::size_t memory_usage() const;

  HaloSum halo;

 private:
  void forget_averages() {
    drive_average.clear();
    drive_limit.clear();
  }
  friend void build_grids(MPI_Comm, double, int, double, std::vector<GridRequest>&);
  double lay_out(const GridRequest& r, double cell_size, int margin, double most_bytes);
  void set_motion(GridRequest& r, const std::vector<Key>& wanted, const std::vector<double>& values, const std::vector<char>& found);

  bool any_constraints_ = false;           // true if any rank that shares the grid has constraints
  std::vector<double> constraint_factor_;  // factor of the bound for each free node; empty without constraints
  double largest_constraint_factor_ = 1.0;
  std::vector<char> inside_;  // for each node that is the first of a cell: well_inside(); empty without a margin
};

// Arguments and result of build_grids() for one of many grids.
struct GridRequest {
  Grid* grid = nullptr;
  std::vector<Grid::Cell> cells;
  NodeKinematics before;      // motion of the bond that this rank knows; may be that of all ranks
  std::map<Key, Key> source;  // for each node that inherits the motion of another node, that node
  std::vector<Key> extra;
  std::vector<char> fresh;  // result: 1 for nodes that no rank had before
};

// Builds the grids of different bonds, given in ascending order. Collective. Throws GridTooLarge on all ranks if the
// grids of some rank would take more than most_bytes. All ranks must pass the same most_bytes.
void build_grids(MPI_Comm comm, double cell_size, int margin, double most_bytes, std::vector<GridRequest>& requests);

}  // namespace mpdem

#endif
