// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A node is split into as many copies (phantom nodes) as its support has connected components of material. Material on
// the two sides of a crack then shares no node, wherever the crack ends, so no force acts across it. Two points are
// connected if a path leads from one to the other that stays in the support, over intact points whose lattice cells
// share a face. At a crack tip such a path leads around the tip, and the node is whole. The cement of one grain may run
// close to that of the other without touching it, as coatings do beyond the ring in which they meet. There nodes are
// split from the start: faces of lattice cells between the two sides connect points only if the material reaches them
// (touches()), and only at nodes where enough of it does (unbonded_gap.h). Copies never merge.
//
// Nodes are duplicated by material, not by position, as in the phantom-node method (A. Hansbo, P. Hansbo, Comput.
// Methods Appl. Mech. Engrg. 193, 2004, 3523-3540).
//
// The points of a cell that have the same copies of all nodes of their support are a class. A class lies in one layer
// of its bond (bond_record.h), and a layer has one node at each grid index. So classes are coloured: classes of one
// layer have the same copy of each node that they share. If nodes of several layers are one copy, they are constrained
// to the node of the first of these layers (`representative`). A whole node is that of layer 0.
//
// A copy keeps the mass that it had when it was made. When a copy is split, the new copies share its mass in proportion
// to their intact material. So mass and momentum of a node are sums over its copies, whatever failed between them, and
// no copy has less mass than its intact material. When points leave the simulation, a copy keeps the mass of its intact
// material, and that of failed points is shared in the former ratio by the copies that still have points.
//
// Failed points carry no stress. Each is assigned to the nearest component of intact points, in steps from cell to cell
// in the support, so that output shows it on its side of the crack. Of components at equal distance it is the largest,
// then the one whose centre is nearer. Cells are few, so these distances are often equal, too. Then criteria about the
// line of centres decide, which are invariant to reflection in the plane between the grains and to quarter turns about
// the line. In this order: the centre is nearer to the line; it is nearer to that plane; it is farther from the plane
// through the line and the point, then on the left of it; it is on the point's side of the plane between the grains.
//
// The code is serial and takes all points of one bond. The result does not depend on their order. An unknown tag throws
// std::logic_error.
#ifndef MPDEM_FRACTURE_PHANTOM_NODES_H
#define MPDEM_FRACTURE_PHANTOM_NODES_H

#include <array>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../mpm/basis.h"
#include "../numerics/grid_index.h"
#include "unbonded_gap.h"

namespace mpdem {

// The split nodes of one bond.
class PhantomNodes {
 public:
  struct Entry {
    int layer, copy;
    int first;      // the copy at the start from which it descends
    double volume;  // volume of the copy: its mass over the density of the scene
  };
  using Row = std::vector<Entry>;  // entries of one node, ascending in layer

  bool empty() const { return rows_.empty(); }
  const Row* row(const GridIndex& node) const;  // null if the node is whole
  // Entry of a layer at a node, {layer, 0, 0, 0} if the node is whole. A split node must have the layer.
  Entry at(int layer, const GridIndex& node) const { return entry_of(row(node), layer); }
  static Entry entry_of(const Row* row, int layer);
  static int copy_of(const Row& row, int layer) { return entry_of(&row, layer).copy; }
  // First layer that has the same copy of the node as this layer.
  int representative(int layer, const GridIndex& node) const;
  // First layer that has the copy `first` of the start; -1 if that copy has been split since.
  int representative_of_first(int first, const GridIndex& node) const;
  using Rows = std::unordered_map<GridIndex, Row, GridIndexHash, SameGridIndex>;
  const Rows& rows() const { return rows_; }
  void set(const GridIndex& node, Row row) { rows_[node] = std::move(row); }
  void forget_rows() { rows_.clear(); }
  void clear() { *this = PhantomNodes(); }
  // Makes the present copies those of the start.
  void start();

  // Copy of the start at the next node in direction -x +x -y +y -z +z that shares a cell of material with this copy of the start. 0
  // if both nodes are whole. -1 if there is no such copy, or if there are several.
  int continuation(const GridIndex& node, int first, int direction) const;
  struct Continuation {
    int first;
    std::array<int, 6> to;
  };
  using Continuations = std::unordered_map<GridIndex, std::vector<Continuation>, GridIndexHash, SameGridIndex>;
  Continuations& continuations() { return continuations_; }
  const Continuations& continuations() const { return continuations_; }

 private:
  Rows rows_;
  Continuations continuations_;  // for nodes that are split at the start, and for their neighbours
};

// A point of the bond, as NodeSplitter needs it.
struct SplitterPoint {
  int tag;
  int cell[3];  // cell of the lattice
  int base[3];  // first node of its support
  int layer;
  int nearer;  // nearer and space: as in CrackPoint
  float space[6];
  bool failed, middle;
  double at[3];  // position relative to the first node of its support, in cells of the grid
  double volume;
  int piece = 0;
};

struct NodeChange {
  struct Moved {
    int tag, layer;
  };
  std::vector<Moved> moved;  // points that change their layer
  // Node of a layer that inherits its motion, and the layer whose node had the motion of its points before the change.
  struct Source {
    GridIndex node;
    int layer, from;
  };
  std::vector<Source> sources;
  std::vector<GridIndex> rows;  // nodes whose rows in PhantomNodes changed
};

// The points of a bond, for as long as they stay in their cells.
class NodeSplitter {
 public:
  // Axis (of the bond's coordinates) of the line of centres, and the middle between the grains in cells of the grid.
  struct Line {
    int axis = 2;
    double middle[3] = {0, 0, 0};
  };
  NodeSplitter(std::vector<SplitterPoint> points, Basis basis, const Line& line);
  NodeSplitter(std::vector<SplitterPoint> points, Basis basis) : NodeSplitter(std::move(points), basis, Line()) {}
  // Splits nodes at the start. In a bond with an unbonded gap (unbonded_gap.h) the two sides are not connected at nodes that
  // are not joined.
  NodeChange start(PhantomNodes& copies, const UnbondedGap& unbonded_gap = {});
  // Splits nodes after the points with these tags failed.
  NodeChange fail(const std::vector<int>& tags, PhantomNodes& copies);
  // Splits nodes after separation. pieces: the piece (separation.h) to which each point of the bond is assigned. Points
  // of different pieces are not connected, even if a narrow bridge is between them.
  struct OfPiece {
    int tag, piece;
  };
  NodeChange split_pieces(const std::vector<OfPiece>& pieces, PhantomNodes& copies);
  // Finds the volumes of the copies from these points, after others left the simulation. Returns all split nodes.
  std::vector<GridIndex> leave(PhantomNodes& copies) const;
  const std::vector<SplitterPoint>& points() const { return points_; }

 private:
  struct Class {
    GridIndex base;
    int layer;                              // present layer
    std::vector<PhantomNodes::Entry> copy;  // copy of each node of the support
    bool operator<(const Class& o) const;
  };
  struct NewEntry : PhantomNodes::Entry {
    int old_layer;  // layer that some of its points had before
  };
  using NewRow = std::map<int, NewEntry>;  // new row of a node, by layer
  class Around;

  template <class F>
  void for_each_node(const int* base, F f) const;
  int number_of(const GridIndex& node, const GridIndex& base) const;
  template <class F>
  void for_each_point(const GridIndex& node, F f) const;
  template <class F>
  void for_each_neighbour(int i, F f) const;
  std::vector<GridIndex> nodes_of(const std::vector<int>& points) const;
  void add_nodes_split_by(int point, const PhantomNodes& copies, std::vector<GridIndex>& nodes) const;
  NodeChange split(const std::vector<GridIndex>& nodes, PhantomNodes& copies);
  bool may_connect(int from, int to) const;
  double volume_at(const GridIndex& node, const std::vector<int>& points) const;
  void share_volume(const GridIndex& node, const std::vector<int>& group, int copy, int next, const PhantomNodes& copies,
                    const std::vector<std::vector<int>>& components, const std::vector<int>& rank);
  void examine(const GridIndex& node, const PhantomNodes& copies);
  void split_group(const GridIndex& node, const std::vector<int>& group, int copy, int& next, const PhantomNodes& copies);
  void find_middles(const std::vector<std::vector<int>>& components, const std::vector<int>& rank);
  std::array<double, 3> position_from_middle(int i) const;
  bool prefers_component(int i, int a, int b) const;
  void assign_failed(const std::vector<int>& group);
  NodeChange colour(PhantomNodes& copies);
  int free_layer(const Class& c, const std::vector<NewRow*>& rows) const;
  void find_continuations(PhantomNodes& copies) const;

  std::vector<SplitterPoint> points_;  // ascending in cell and tag
  Basis basis_;
  int S_;  // nodes of a support in each direction
  Line line_;
  std::unordered_map<GridIndex, int, GridIndexHash, SameGridIndex> at_;  // first point of a cell of the lattice
  bool one_a_cell_ = true;                                               // no cell of the lattice has two points
  std::vector<std::array<int, 6>> next_;  // for each point the first points of the cells across its faces -x +x -y +y -z +z; -1: none
  std::vector<int> by_tag_;               // points, ascending in tag
  std::vector<int> by_base_;              // points, ascending in base
  std::unordered_map<GridIndex, std::pair<int, int>, GridIndexHash, SameGridIndex> base_;  // range in by_base_ of the points with a base
  // State while a node is examined.
  std::vector<int> component_of_;              // for each point: its component, or kOut or kIn of node_splitter.cpp
  const UnbondedGap* unbonded_gap_ = nullptr;  // set during start() alone
  struct Middle {
    int size;
    long long sum[3];    // sum of the cells
    double position[3];  // along the line of centres and across, from the middle between the grains
  };
  std::vector<Middle> middles_;                           // centres of the components of a copy
  bool sides_split_ = false;                              // the two sides of a gap are not connected at this node
  std::map<int, std::map<GridIndex, int>> wanted_;        // by point and node: the new copy
  std::map<GridIndex, std::map<int, double>> split_now_;  // by node and new copy: the volume
};

template <class F>
void NodeSplitter::for_each_node(const int* base, F f) const {
  int n = 0;
  for (int i = 0; i < S_; ++i)
    for (int j = 0; j < S_; ++j)
      for (int k = 0; k < S_; ++k) f(GridIndex{base[0] + i, base[1] + j, base[2] + k}, n++);
}

template <class F>
void NodeSplitter::for_each_point(const GridIndex& node, F f) const {
  for (int i = 0; i < S_; ++i)
    for (int j = 0; j < S_; ++j)
      for (int k = 0; k < S_; ++k) {
        const auto cell = base_.find({node[0] - i, node[1] - j, node[2] - k});
        if (cell == base_.end()) continue;
        for (int n = cell->second.first; n < cell->second.second; ++n) f(by_base_[n]);
      }
}

}  // namespace mpdem

#endif
