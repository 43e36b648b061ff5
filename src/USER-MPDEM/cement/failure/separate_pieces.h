// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Separation of bonds without phantom nodes, whose points meet other nodes as they move (CementOptions::reprojects()).
#ifndef MPDEM_CEMENT_FAILURE_SEPARATE_PIECES_H
#define MPDEM_CEMENT_FAILURE_SEPARATE_PIECES_H

#include "node_splitting.h"

namespace mpdem {

// Each piece of a separated bond is a layer with nodes of its own, so pieces share no node.
class SeparatePieces : public NodeSplitting {
 public:
  std::unique_ptr<NodeSplitting> copy() const override { return std::make_unique<SeparatePieces>(*this); }
  NewLayersOfBonds start(MPI_Comm comm, Bonds& bonds, const CementOptions& options, const std::vector<int>& with_new_points = {}) override;
  Found split_pieces(MPI_Comm comm, Bonds& bonds, const CementOptions& options, SeparatedBonds newly_separated) override;
  void fetch_copies(MPI_Comm, const Bonds&) override {}
  void remove_volume(MPI_Comm, const Bonds&, const CementOptions&, const std::vector<int>&) override {}
  std::vector<Key> nodes_beside(const PointStore&, int, int) const override { return {}; }
  Key representative_of(const Key& node) const override { return node; }
  std::vector<ExtensionConstraint> constraints(const std::vector<Key>&) const override { return {}; }

 protected:
  void find_lattices(MPI_Comm, const Bonds&, const CementOptions&, const std::vector<char>&) override {}
  NodeChange separate(int row, const std::vector<PointOfPiece>& pieces, const CementOptions& options) override;
};

// Pieces may touch again: they keep the nodes that they share.
class JoinedPieces : public SeparatePieces {
 public:
  std::unique_ptr<NodeSplitting> copy() const override { return std::make_unique<JoinedPieces>(*this); }
  Found split_pieces(MPI_Comm, Bonds&, const CementOptions&, SeparatedBonds) override { return {}; }
};

}  // namespace mpdem

#endif
