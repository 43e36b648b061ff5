// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The motion of nodes on its way into a restart file and out of one. It stands with the points of its bond in the file, on whichever rank has these,
// and waits here for the first layout, before which it goes to all ranks that have points of the bond. Units of the nodes.
#ifndef MPDEM_CEMENT_RESTORED_NODES_H
#define MPDEM_CEMENT_RESTORED_NODES_H

#include <map>
#include <vector>

#include "cement_restart.h"
#include "scene.h"

namespace mpdem {

// Of bonds that are awake: rows of each bond (NodeRow) that this rank counts, one after the other, by row of the table.
std::map<int, std::vector<double>> packed_nodes(const Scene& scene);
// Collective. How many rows these are on all ranks.
double nodes_to_pack(const Scene& scene);

class RestoredNodes {
 public:
  explicit RestoredNodes(const Scene& scene) : scene_(scene) {}

  // Rows that this rank read; of_all: of how many on all ranks.
  void keep(std::vector<NodeRow> rows, double of_all);
  // Collective, before a layout. Points may have gone to other ranks since they were read. Throws BadState if rows are missing.
  void bring();
  // What came for a bond, once bring() was called: nothing if the motion of its nodes is not that of a file.
  bool any() const { return !motion_.empty(); }
  NodeKinematics& of(int body) { return motion_[body]; }
  void clear() { motion_.clear(); }

 private:
  void take(std::vector<NodeRow> rows);

  const Scene& scene_;
  std::vector<NodeKinematics> motion_;  // by row of the table
  std::vector<NodeRow> rows_;           // as the ranks read them
  double of_all_ = -1.0;                // of all ranks among these; below 0: there are none to come
};

}  // namespace mpdem

#endif
