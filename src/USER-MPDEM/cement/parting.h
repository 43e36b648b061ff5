// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Parts bonds that come apart in a run, and nodes that split: when bonds are looked at, and what follows. Nodes split in
// place, or by a new layout of the bond. What added mass gives up is booked as released. All functions are collective,
// except those of one line here.
#ifndef MPDEM_CEMENT_PARTING_H
#define MPDEM_CEMENT_PARTING_H

#include <vector>

#include "added_masses.h"
#include "arrangement.h"
#include "divisions.h"
#include "load_watch.h"
#include "scene.h"

namespace mpdem {

class Parting {
 public:
  Parting(Scene& scene, Divisions& divisions, Arrangement& arrangement, AddedMasses& added)
      : scene_(scene), divisions_(divisions), arrangement_(arrangement), added_(added) {}

  // Call after the layout of a run. Bonds that are new may be cracked, so it looks at them. Others wait for the step of
  // their next look.
  void take_up();
  // Call at the start of a step. Looks at bonds after a check, and where a path of intact points is cut. It is not part
  // of the check itself. There the forces of the step are still to be shown, and the step may be that of a restart
  // file. Throws BadState if the step is too long for what came of it.
  void look();
  // Call at the end of a step. Notes loads that tell when a bond carries nothing any more.
  void watch_loads() {
    if (scene_.can_break()) load_watch_.add(scene_.grains, scene_.bonds().table, scene_.dt_last);
  }
  // Ligaments of bonds that hold. rows: rows of the table, ascending.
  std::vector<Cracks::Ahead> ahead(const std::vector<int>& rows);

  LoadWatch& load_watch() { return load_watch_; }  // for restart files

 private:
  struct Found : Splits::Found {
    std::vector<int> held;  // see Cracks::Found
  };
  Found look_at_bonds(bool debris, int from = 0);  // from: the first row
  void look_after_check();
  void look_at_paths();
  void look_at_points();
  void part_pieces(bool debris);
  void sort_links();
  void split_nodes();
  void part_bonds(const std::vector<int>& rows, NewPartsOfBonds parts, const char* event);
  std::vector<int> part_nodes(Bond& b, const NewParts& parts);
  void find_relaxation(const std::vector<int>& rows);

  Scene& scene_;
  Divisions& divisions_;
  Arrangement& arrangement_;
  AddedMasses& added_;
  LoadWatch load_watch_;
};

}  // namespace mpdem

#endif
