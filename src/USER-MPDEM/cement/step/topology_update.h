// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Parts bonds that come apart in a run, and nodes that split: when bonds are looked at, and what follows. Nodes split in
// place, or by a new layout of the bond. What added mass gives up is booked as released. All functions are collective,
// except those of one line here.
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

  // Call after the layout of a run. Bonds that are new may be cracked, so it looks at them. Others wait for the step of
  // their next look.
  void add_bonds();
  // Call at the start of a step. Looks at bonds after a check, and where a path of intact points is cut. It is not part
  // of the check itself. There the forces of the step are still to be shown, and the step may be that of a restart
  // file. Throws BadState if the step is too long for what came of it.
  void update();
  // Call at the end of a step. Notes loads that tell when a bond carries nothing any more.
  void watch_loads() {
    if (scene_.can_break()) load_history_.add(scene_.grains, scene_.bonds().table, scene_.dt_last);
  }
  // Ligaments of bonds that hold. rows: rows of the table, ascending.
  std::vector<Cracks::Ahead> ahead(const std::vector<int>& rows);

  LoadHistory& load_history() { return load_history_; }  // for restart files

 private:
  struct Found : NodeSplitting::Found {
    std::vector<int> held;  // see Cracks::Found
  };
  Found find_separations(bool fragment, int from = 0);  // from: the first row
  void update_after_check();
  void update_cut_paths();
  void split_at_failed_points();
  void separate_pieces(bool fragment);
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
