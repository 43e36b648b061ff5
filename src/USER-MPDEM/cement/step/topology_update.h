// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Updates bonds that separate and nodes that split during a run: when bonds are examined, and what follows. Nodes split
// in place, or by a new layout of the bond. Energy of added mass that is lost counts as released. All functions are
// collective, except those of one line here.
#ifndef MPDEM_CEMENT_STEP_TOPOLOGY_UPDATE_H
#define MPDEM_CEMENT_STEP_TOPOLOGY_UPDATE_H

#include <vector>

#include "added_masses.h"
#include "layout_manager.h"
#include "../failure/discontinuities.h"
#include "../failure/load_history.h"
#include "../bond/scene.h"

namespace mpdem {

class TopologyUpdate {
 public:
  TopologyUpdate(Scene& scene, Discontinuities& divisions, LayoutManager& layout_manager, AddedMasses& added)
      : scene_(scene), discontinuities_(divisions), layout_manager_(layout_manager), added_(added) {}

  // Call after the layout of a run. Examines new bonds, since they may be cracked. Others are examined in the step
  // after their next check.
  void add_bonds();
  // Call at the start of a step. Examines bonds after a check, and where a path of intact points is cut. It is not part
  // of the check itself: there the forces of the step are still to be output, and the step may be that of a restart
  // file. Throws BadState if the step is too long for the changed bonds.
  void update();
  // Call at the end of a step. Stores loads, which show when a bond no longer carries any.
  void watch_loads() {
    if (scene_.can_break()) load_history_.add(scene_.grains, scene_.bonds().table, scene_.dt_last);
  }
  // Ligaments of connected bonds. rows: rows of the table, ascending.
  std::vector<Cracks::LigamentReport> find_ligaments(const std::vector<int>& rows);

  LoadHistory& load_history() { return load_history_; }  // for restart files

 private:
  struct Found : NodeSplitting::Found {
    std::vector<int> connected;  // see Cracks::Found
  };
  Found find_separations(bool with_separated, int from = 0);  // see Cracks::detect_separations()
  void update_after_check();
  void update_cut_paths();
  void split_at_failed_points();
  void separate_pieces(bool with_separated);
  void sort_links();
  void split_nodes();
  void change_bonds(const std::vector<int>& rows, NewLayersOfBonds layers, const char* event);
  std::vector<int> split_in_place(Bond& b, const NewLayers& layers);
  void find_relative_damping(const std::vector<int>& rows);

  Scene& scene_;
  Discontinuities& discontinuities_;
  LayoutManager& layout_manager_;
  AddedMasses& added_;
  LoadHistory load_history_;
};

}  // namespace mpdem

#endif
