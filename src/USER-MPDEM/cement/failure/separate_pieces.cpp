// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "separate_pieces.h"

#include <algorithm>

namespace mpdem {

namespace {

// Nodes of points that move to a new layer take over the motion of the nodes that these points had.
void add_sources(const Bond& bond, int support, NewLayers& layers) {
  int block = -1, layer = -1;  // block and layer of the last point; points of a block mostly move together
  for (const auto& p : layers.layer_of_slot) {
    if (p.first / kLanes == block && p.second == layer) continue;
    block = p.first / kLanes;
    layer = p.second;
    for (const Key& k : NodeSplitting::nodes_of(bond.points.meta[block], support))
      layers.source[k.with_field(field_of(bond.row, layer))] = k;
  }
}

}  // namespace

NewLayersOfBonds SeparatePieces::start(MPI_Comm, Bonds& bonds, const CementOptions&, const std::vector<int>&) {
  know_bonds(bonds.table.size());
  return {};
}

NodeSplitting::Found SeparatePieces::split_pieces(MPI_Comm comm, Bonds& bonds, const CementOptions& options,
                                                  SeparatedBonds newly_separated) {
  for (auto p = newly_separated.pieces.begin(); p != newly_separated.pieces.end();) {
    std::vector<PointOfPiece>& points = p->second;
    points.erase(std::remove_if(points.begin(), points.end(), [](const PointOfPiece& point) { return point.piece == point.layer; }),
                 points.end());
    p = points.empty() ? newly_separated.pieces.erase(p) : std::next(p);
  }
  Found found = NodeSplitting::split_pieces(comm, bonds, options, std::move(newly_separated));
  for (auto& p : found.layers) add_sources(*bonds.find(p.first), support(options.basis), p.second);
  return found;
}

NodeChange SeparatePieces::separate(int, const std::vector<PointOfPiece>& pieces, const CementOptions&) {
  NodeChange change;
  for (const PointOfPiece& p : pieces) change.moved.push_back({p.tag, p.piece});
  return change;
}

}  // namespace mpdem
