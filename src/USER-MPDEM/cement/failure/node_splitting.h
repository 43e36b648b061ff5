// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Phantom nodes of all bonds (fracture/phantom_nodes.h), and the constraints that follow from them. Nodes of several
// layers that are one copy move as one: they are constrained to the representative, the node of the first of these
// layers. A node at the edge of the cement keeps its constraint of the start (mpm/extension_constraints.h) until the
// node itself, one of its masters or one of its mass receivers splits.
//
// Nodes split at an unbonded gap (fracture/unbonded_gap.h) when a bond is new, and between pieces when the bond separates.
// With `cracks split` they also split wherever material is not connected, when a bond is new and as its points fail.
// Where points meet other nodes as they move (CementOptions::reprojects()) nodes have no copies, see separate_pieces.h.
//
// One rank (row modulo number of ranks) examines a bond as a whole, when it is new and from its first failure on. That
// rank stores its phantom nodes, and the ranks with points of the bond have a copy of them. Nothing is stored of a bond
// without phantom nodes, except its edge constraints with `cracks split`.
//
// Throws OnOneRank if a bond needs more than kMaxLayers layers, and std::logic_error if ranks disagree.
#ifndef MPDEM_CEMENT_FAILURE_NODE_SPLITTING_H
#define MPDEM_CEMENT_FAILURE_NODE_SPLITTING_H

#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

#include "../../fracture/unbonded_gap.h"
#include "../../fracture/phantom_nodes.h"
#include "../../mpm/extension_constraints.h"
#include "../bond/bond.h"
#include "../bond/options.h"

namespace mpdem {

// How layers of a bond change: points that move to another layer, and nodes that get the motion of another, their source.
struct NewLayers {
  std::map<int, int> layer_of_slot;
  std::map<Key, Key> source;
  std::vector<Key> split;  // nodes whose copies changed, with the keys of layer 0
};
using NewLayersOfBonds = std::map<int, NewLayers>;  // by row of the table

class NodeSplitting {
 public:
  virtual ~NodeSplitting() = default;
  virtual std::unique_ptr<NodeSplitting> copy() const { return std::make_unique<NodeSplitting>(*this); }

  // Collective. Splits nodes at the start, in bonds that are new: those from row `first_new()` of the table on, and
  // `with_new_points`, which had no points before. Points that failed in a file are left to find_splits().
  virtual NewLayersOfBonds start(MPI_Comm comm, Bonds& bonds, const CementOptions& options, const std::vector<int>& with_new_points = {});
  // Density of the inertia of the cement, on which the volumes of copies depend (PhantomNodes::Entry).
  void set_density(const CementDensity& density) { density_ = density; }
  int first_new() const { return static_cast<int>(known_.size()); }
  // Collective. Splits nodes at points that failed since the last call, in resolved bonds, or else in bonds from row
  // `from` on.
  static constexpr int kResolved = -1;
  struct Found {
    std::vector<int> lay_out;  // rows whose layout changes, ascending, the same on all ranks
    NewLayersOfBonds layers;
  };
  Found find_splits(MPI_Comm comm, Bonds& bonds, const CementOptions& options, int from = kResolved);
  // A point of a separated bond. piece: the piece to which it is assigned. layer: its present layer. between: it is at
  // equal distance from the material of both grains.
  struct PointOfPiece {
    int tag, piece, layer;
    bool between;
  };
  struct SeparatedBonds {
    std::vector<int> rows;                            // newly separated bonds, ascending, the same on all ranks
    std::map<int, std::vector<PointOfPiece>> pieces;  // points of bonds with pieces to separate, on the examining ranks
  };
  // Collective. Separates the nodes of the pieces of these bonds.
  virtual Found split_pieces(MPI_Comm comm, Bonds& bonds, const CementOptions& options, SeparatedBonds newly_separated);
  // Collective. Fetches the phantom nodes of bonds whose points came to this rank.
  virtual void fetch_copies(MPI_Comm comm, const Bonds& bonds);

  // Collective. Removes the volume of points that left the simulation from the phantom nodes of these bonds. rows:
  // ascending, the same on all ranks.
  virtual void remove_volume(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<int>& rows);

  // These two are for restart files. rows_to_keep() returns the rows of the bonds that this rank examines, restore() takes
  // those of all bonds.
  std::map<Key, PhantomNodes::Row> rows_to_keep(MPI_Comm comm) const;
  void restore(std::size_t bonds, std::map<Key, PhantomNodes::Row> rows) {
    rows_.clear();
    known_.assign(bonds, {});
    restored_ = std::move(rows);
    is_restored_ = true;
  }

  // Edge constraints of the start, of these bonds on this rank, ascending in the constrained node. They hold until they
  // are dropped, or until fetch_copies() finds that points of the bond went to other ranks.
  bool edges_known(const std::vector<int>& rows) const;
  void keep_edges(const std::vector<int>& rows, std::vector<ExtensionConstraint> edges);
  void drop_edges(const std::vector<int>& rows);
  // Nodes that a grid needs besides those of the blocks of points: representatives of nodes of layers above 0, and masters
  // and mass receivers of edge constraints.
  virtual std::vector<Key> nodes_beside(const PointStore& points, int bond_row, int support) const;
  // All phantom nodes of a bond that are representatives with a volume above 0.
  std::vector<Key> copies_of(int bond_row) const;
  virtual Key representative_of(const Key& node) const;
  // The nodes of a block and their representatives, in the order of for_each_node() of mpm/block_nodes.h.
  static std::vector<Key> nodes_of(const BlockMeta& block, int support);
  std::vector<Key> representatives_of(const BlockMeta& block, int support) const;
  // Representatives of all copies of the nodes that split in a bond.
  std::vector<Key> representatives_at(int bond_row, const std::vector<Key>& split) const;
  // Indices in `grid`, ascending, of the nodes whose constraints or masses depend on the copies of the nodes that split.
  std::vector<int> nodes_touched(const Grid& grid, int bond_row, const std::vector<Key>& split);
  // The node of the start from which this node descends.
  Key at_start(const Key& node) const;
  // The next node of the start in a direction (see EdgeNodes), or kNoNode.
  Key next(const Key& at_start, int direction) const;
  // Volumes of the copies at these nodes of one bond: 0 for a node that is not the representative of its copy, -1 for a
  // node that is not split. The list is empty if the masses of all nodes follow from the volumes of the points.
  std::vector<double> volumes(const std::vector<Key>& keys, const CementOptions& options) const;
  // Constraints of a grid with these nodes.
  virtual std::vector<ExtensionConstraint> constraints(const std::vector<Key>& keys) const;

 protected:
  void know_bonds(std::size_t bonds) { known_.resize(bonds); }
  // Collective. Collects the points of the bonds marked in `wanted` as not yet collected, and makes their lattices.
  virtual void find_lattices(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<char>& wanted);
  // Separates the pieces of a bond that this rank examines.
  virtual NodeChange separate(int row, const std::vector<PointOfPiece>& pieces, const CementOptions& options);

 private:
  struct Row {
    PhantomNodes copies;
    std::vector<ExtensionConstraint> edges;
    // Each master or mass receiver, with the index of its constraint in `edges`. Ascending, made on first use.
    std::vector<std::pair<Key, int>> dependents;
    std::shared_ptr<NodeSplitter> lattice;  // set on the rank that examines the bond
  };
  struct Known {
    bool copies = false;  // this rank has the phantom nodes
    bool edges = false;   // edge constraints are stored; the same on all ranks
  };
  static const Row kWhole;  // row of a bond without phantom nodes
  const Row& row(int bond_row) const {
    const auto at = rows_.find(bond_row);
    return at == rows_.end() ? kWhole : at->second;
  }
  const PhantomNodes& copies(int bond_row) const { return row(bond_row).copies; }
  Key present_representative(const Key& at_start) const;
  void find_dependents(Row& row) const;
  NewLayersOfBonds apply(MPI_Comm comm, const Bonds& bonds, const std::vector<int>& rows, const std::vector<NodeChange>& changes);

  CementDensity density_ = 1.0;
  std::unordered_map<int, Row> rows_;          // of bonds of which something is stored
  std::vector<Known> known_;                   // of all bonds
  std::map<Key, PhantomNodes::Row> restored_;  // rows of a restart file until start(), by the node of layer 0
  bool is_restored_ = false;
};

}  // namespace mpdem

#endif
