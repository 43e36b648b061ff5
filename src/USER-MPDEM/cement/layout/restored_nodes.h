// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Motion of nodes in restart files. The file has it with the points of their bond. packed_nodes() packs it for writing.
// RestoredNodes keeps what was read until the first layout, and sends it to all ranks that have points of the bond
// before that. Units are those of the nodes.
#ifndef MPDEM_CEMENT_LAYOUT_RESTORED_NODES_H
#define MPDEM_CEMENT_LAYOUT_RESTORED_NODES_H

#include <map>
#include <vector>

#include "cement_restart.h"
#include "../bond/scene.h"

namespace mpdem {

// Packs the nodes of resolved bonds: for each row of the table, the NodeRow of all nodes that this rank counts.
std::map<int, std::vector<double>> packed_nodes(const Scene& scene);
// Collective. Number of these rows on all ranks.
double nodes_to_pack(const Scene& scene);

class RestoredNodes {
 public:
  explicit RestoredNodes(const Scene& scene) : scene_(scene) {}

  // Stores the rows that this rank read. of_all: number of rows on all ranks.
  void keep(std::vector<NodeRow> rows, double of_all);
  // Collective, before a layout. Sends rows to the ranks that have points of their bond, since points may have changed
  // rank since the file was read. Throws BadState if rows are missing.
  void send_to_holders();
  // of(): motion of the nodes of a bond, once send_to_holders() was called. any() is true if a restart file gave motion.
  bool any() const { return !motion_.empty(); }
  NodeKinematics& of(int row) {
    if (static_cast<std::size_t>(row) >= motion_.size()) motion_.resize(row + 1);  // the bond was made after the file was read
    return motion_[row];
  }
  void clear() { motion_.clear(); }

 private:
  void take(std::vector<NodeRow> rows);

  const Scene& scene_;
  std::vector<NodeKinematics> motion_;  // by row of the table
  std::vector<NodeRow> rows_;           // rows that this rank read
  double of_all_ = -1.0;                // number of these rows on all ranks; below 0: none to send
};

}  // namespace mpdem

#endif
