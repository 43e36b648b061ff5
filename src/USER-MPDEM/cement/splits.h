// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Copies of the nodes of all bonds (fracture/node_copies.h), and the ties that follow. Nodes of several parts that are one copy move as
// one. A node at the edge stays tied (mpm/edge_ties.h) as it was at the start, until a point fails in its support, or one of its
// masters splits.
// Each bond has a rank that looks at it as a whole, when it is new and from its first failure on, and keeps its copies. The ranks that have
// points of the bond know them too.
#ifndef MPDEM_CEMENT_SPLITS_H
#define MPDEM_CEMENT_SPLITS_H

#include <map>
#include <memory>
#include <vector>

#include "../fracture/node_copies.h"
#include "../mpm/edge_ties.h"
#include "bond.h"
#include "options.h"
#include "sheets.h"

namespace mpdem {

class Splits {
 public:
  // Collective. Bonds that are new, from row `first()` of the table on: what comes apart at the start. Points that failed in a file are
  // looked at when look() comes.
  NewPartsOfBonds start(MPI_Comm comm, Bonds& bonds, const CementOptions& options);
  int first() const { return static_cast<int>(rows_.size()); }
  // Collective. Bonds in which points failed since the last look.
  struct Found {
    std::vector<int> lay_out;  // ascending, the same on all ranks
    NewPartsOfBonds parts;
  };
  Found look(MPI_Comm comm, Bonds& bonds, const CementOptions& options);
  // Collective. Bonds that came apart: pieces of their points, on the ranks that look at them.
  Found come_apart(MPI_Comm comm, const Bonds& bonds, const CementOptions& options,
                   const std::map<int, std::vector<CopyLattice::OfPiece>>& pieces);
  // Collective. Copies of the bonds that came to this rank.
  void bring(MPI_Comm comm, const Bonds& bonds);

  // Restart: rows of the bonds that this rank looks at, and those of all bonds again.
  std::map<Key, NodeCopies::Row> rows_to_keep(MPI_Comm comm) const;
  void restore(std::size_t bonds, std::map<Key, NodeCopies::Row> rows) {
    rows_.clear();
    rows_.resize(bonds);
    restored_ = std::move(rows);
    is_restored_ = true;
  }

  // Ties of nodes of the start at the edge, of these rows of the table on this rank, ascending in slave. They are kept until bring() finds that points went
  // to other ranks.
  bool edges_known(const std::vector<int>& rows) const;
  void keep_edges(const std::vector<int>& rows, std::vector<EdgeTie> edges);
  // Nodes that stand for those of the blocks of a bond, and masters at the edge.
  std::vector<Key> nodes_beside(const PointStore& points, int body, int support) const;
  // All nodes that are copies.
  std::vector<Key> copies_of(int body) const;
  // The node that stands for this one.
  Key standing_for(const Key& node) const;
  // Nodes of a block, and those that stand for them, in the order of for_each_node() of mpm/block_nodes.h.
  static std::vector<Key> nodes_of(const BlockMeta& block, int support);
  std::vector<Key> standing_for(const BlockMeta& block, int support) const;
  // Of a bond in which these nodes split: those that stand for copies of these.
  std::vector<Key> standing_at(int body, const std::vector<Key>& split) const;
  // Nodes of a grid whose ties or masses hang on the copies of these.
  std::vector<int> nodes_touched(const Grid& grid, int body, const std::vector<Key>& split);
  // A node as one of the start: its copy for a part.
  Key at_start(const Key& node) const;
  // The next one of the start, see TiedNodes.
  Key next(const Key& at_start, int direction) const;
  // Volumes of the copies that these nodes stand for, 0 where another does, -1 of nodes that are whole.
  std::vector<double> volumes(const std::vector<Key>& keys) const;
  // Ties of a grid with these keys.
  std::vector<EdgeTie> ties(const std::vector<Key>& keys) const;

 private:
  Key now(const Key& at_start) const;
  struct Row {
    NodeCopies copies;
    bool known = false;                    // on this rank
    std::vector<EdgeTie> edges;
    bool edges_known = false;              // the same on all ranks
    std::vector<std::pair<Key, int>> users;  // master or heir, place of its edge; ascending, empty until they are asked for
    std::shared_ptr<CopyLattice> lattice;  // on the rank that looks at the bond
  };
  void find_users(Row& row) const;
  void find_lattices(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<char>& wanted);
  NewPartsOfBonds apply(MPI_Comm comm, const Bonds& bonds, const std::vector<int>& rows, const std::vector<CopyChange>& changes);
  std::vector<Row> rows_;
  std::map<Key, NodeCopies::Row> restored_;  // of a restart file, until the start; by body and place
  bool is_restored_ = false;
};

}  // namespace mpdem

#endif
