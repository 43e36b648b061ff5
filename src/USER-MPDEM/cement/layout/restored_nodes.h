// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Takes the motion of nodes into a restart file and out of one. In the file, it stands with the points of its bond, on
// whichever rank has these. After the file is read, it waits here for the first layout. Before that layout it goes to
// all ranks that have points of the bond. Units are those of the nodes.
#ifndef MPDEM_CEMENT_LAYOUT_RESTORED_NODES_H
#define MPDEM_CEMENT_LAYOUT_RESTORED_NODES_H

#include <map>
#include <vector>

#include "cement_restart.h"
#include "../bond/scene.h"

namespace mpdem {

// Packs the nodes of bonds that are awake: rows of each bond (NodeRow) that this rank counts, one after the other, by
// row of the table.
std::map<int, std::vector<double>> packed_nodes(const Scene& scene);
// Collective. Number of these rows on all ranks.
double nodes_to_pack(const Scene& scene);

class RestoredNodes {
 public:
  explicit RestoredNodes(const Scene& scene) : scene_(scene) {}

  // Keeps rows that this rank read. of_all: number of rows on all ranks.
  void keep(std::vector<NodeRow> rows, double of_all);
  // Collective, before a layout. Brings rows to the ranks that have points of their bond, since points may have gone to
  // other ranks since they were read. Throws BadState if rows are missing.
  void bring();
  // Motion of the nodes of a bond, once bring() was called. any() is false if the motion is not that of a file.
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
  std::vector<NodeRow> rows_;           // rows as the ranks read them
  double of_all_ = -1.0;                // number of these rows over all ranks; below 0: there are none to come
};

}  // namespace mpdem

#endif
