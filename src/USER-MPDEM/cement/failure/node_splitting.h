// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Copies of the nodes of all bonds (fracture/phantom_nodes.h), and the ties that follow. Nodes of several parts that are
// one copy move as one. A node at the edge stays tied (mpm/extension_constraints.h) as it was at the start, until it splits itself, or one
// of its masters or heirs does.
//
// Nodes split at a crevice (fracture/crevice.h) when a bond is new, and between its pieces when it comes apart. With
// `cracks split` they also split wherever material is not connected, when a bond is new and as its points fail.
//
// Where points meet other nodes as they move (CementOptions::reprojects()) no node has copies, see separate_pieces.h.
//
// Each bond has a rank that looks at it as a whole, when it is new and from its first failure on. That rank keeps its
// copies. The ranks that have points of the bond know them too. Nothing is kept of a bond without copies, except with
// `cracks split` its edges.
#ifndef MPDEM_CEMENT_FAILURE_NODE_SPLITTING_H
#define MPDEM_CEMENT_FAILURE_NODE_SPLITTING_H

#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

#include "../../fracture/crevice.h"
#include "../../fracture/phantom_nodes.h"
#include "../../mpm/extension_constraints.h"
#include "../bond/bond.h"
#include "../bond/options.h"

namespace mpdem {

// Points that go to another part, and nodes that take over the motion of another node.
struct NewLayers {
  std::map<int, int> layer_of_slot;
  std::map<Key, Key> source;
  std::vector<Key> split;  // nodes whose copies changed, with the keys of part 0
};
using NewLayersOfBonds = std::map<int, NewLayers>;  // by row of the table

class NodeSplitting {
 public:
  virtual ~NodeSplitting() = default;
  virtual std::unique_ptr<NodeSplitting> copy() const { return std::make_unique<NodeSplitting>(*this); }

  // Collective. Finds what comes apart at the start in bonds that are new: those from row `first()` of the table on, and
  // others that had no points before. Points that failed in a file are looked at by look().
  virtual NewLayersOfBonds start(MPI_Comm comm, Bonds& bonds, const CementOptions& options, const std::vector<int>& others = {});
  int first() const { return static_cast<int>(known_.size()); }
  // Collective. Looks at bonds in which points failed since the last look: those that are not condensed, or new ones from
  // row `from` on.
  static constexpr int kResolved = -1;
  struct Found {
    std::vector<int> lay_out;  // ascending, the same on all ranks
    NewLayersOfBonds layers;
  };
  Found find_splits(MPI_Comm comm, Bonds& bonds, const CementOptions& options, int from = kResolved);
  // A point of a bond that came apart. piece: that with which it goes. part: that which it has. between: it is as
  // far from the material of the one grain as from that of the other.
  struct PointOfPiece {
    int tag, piece, layer;
    bool between;
  };
  struct CameApart {
    std::vector<int> rows;                            // bonds that came apart now, ascending, the same on all ranks
    std::map<int, std::vector<PointOfPiece>> pieces;  // points of bonds whose pieces are to part, on the ranks that look at them
  };
  // Collective. Parts bonds that came apart.
  virtual Found come_apart(MPI_Comm comm, Bonds& bonds, const CementOptions& options, CameApart came);
  // Collective. Brings copies of bonds whose points came to this rank.
  virtual void bring(MPI_Comm comm, const Bonds& bonds);

  // Collective. Takes the volume of points that left the scene out of the copies of these bonds. rows: ascending, the same on all ranks.
  virtual void leave(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<int>& rows);

  // Restart: rows_to_keep() returns rows of the bonds that this rank looks at. restore() takes the rows of all bonds.
  std::map<Key, PhantomNodes::Row> rows_to_keep(MPI_Comm comm) const;
  void restore(std::size_t bonds, std::map<Key, PhantomNodes::Row> rows) {
    rows_.clear();
    known_.assign(bonds, {});
    restored_ = std::move(rows);
    is_restored_ = true;
  }

  // Ties that nodes at the edge have at the start, of these rows of the table on this rank, ascending in slave. They
  // are kept until they are dropped, or until bring() finds that points went to other ranks.
  bool edges_known(const std::vector<int>& rows) const;
  void keep_edges(const std::vector<int>& rows, std::vector<ExtensionConstraint> edges);
  void drop_edges(const std::vector<int>& rows);
  // Nodes that stand for those of the blocks of a bond, and masters and heirs at the edge.
  virtual std::vector<Key> nodes_beside(const PointStore& points, int bond_row, int support) const;
  // All nodes of a bond that are copies with a volume.
  std::vector<Key> copies_of(int bond_row) const;
  // The node that stands for this one.
  virtual Key representative_of(const Key& node) const;
  // nodes_of() returns the nodes of a block, representative_of() those that stand for them. Both are in the order of
  // for_each_node() of mpm/block_nodes.h.
  static std::vector<Key> nodes_of(const BlockMeta& block, int support);
  std::vector<Key> representative_of(const BlockMeta& block, int support) const;
  // Nodes that stand for copies of the nodes that split in a bond.
  std::vector<Key> representatives_at(int bond_row, const std::vector<Key>& split) const;
  // Nodes of a grid whose ties or masses depend on the copies of the nodes that split.
  std::vector<int> nodes_touched(const Grid& grid, int bond_row, const std::vector<Key>& split);
  // Returns a node as one of the start: the first copy that its part had.
  Key at_start(const Key& node) const;
  // Returns the next node of the start in a direction, see TiedNodes.
  Key next(const Key& at_start, int direction) const;
  // Volumes of the copies that these nodes of one bond stand for. 0: another node stands for the copy. -1: the node is
  // whole. Returns an empty list if all are.
  std::vector<double> volumes(const std::vector<Key>& keys, const CementOptions& options) const;
  // Ties of a grid that has these keys.
  virtual std::vector<ExtensionConstraint> ties(const std::vector<Key>& keys) const;

 protected:
  void know_bonds(std::size_t bonds) { known_.resize(bonds); }
  // Collective. Makes the lattices of those of the bonds that are wanted whose points have to come as a whole.
  virtual void find_lattices(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<char>& wanted);
  // Parts the pieces of a bond at which this rank looks.
  virtual NodeChange separate(int row, const std::vector<PointOfPiece>& pieces, const CementOptions& options);

 private:
  struct Row {
    PhantomNodes copies;
    std::vector<ExtensionConstraint> edges;
    std::vector<std::pair<Key, int>>
        dependents;                         // master or heir, and place of its tie in `edges`; ascending, empty until they are asked for
    std::shared_ptr<NodeSplitter> lattice;  // set on the rank that looks at the bond
  };
  struct Known {
    bool copies = false;  // true if this rank knows the copies
    bool edges = false;   // the same on all ranks
  };
  static const Row kWhole;
  const Row& row(int bond_row) const {
    const auto at = rows_.find(bond_row);
    return at == rows_.end() ? kWhole : at->second;
  }
  const PhantomNodes& copies(int bond_row) const { return row(bond_row).copies; }
  Key now(const Key& at_start) const;
  void find_users(Row& row) const;
  NewLayersOfBonds apply(MPI_Comm comm, const Bonds& bonds, const std::vector<int>& rows, const std::vector<NodeChange>& changes);

  std::unordered_map<int, Row> rows_;          // of bonds of which something is kept
  std::vector<Known> known_;                   // of all bonds
  std::map<Key, PhantomNodes::Row> restored_;  // rows of a restart file, until the start; by body and place
  bool is_restored_ = false;
};

}  // namespace mpdem

#endif
