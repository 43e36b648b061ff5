// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Decides when bonds are condensed (condensed_bonds.h), wake, and are condensed again, and which of them ask for their
// points first. A bond may have energy in one form that it does not have in the other. This energy is booked. Functions
// are collective, except those of one line here.
#ifndef MPDEM_CEMENT_STEP_CONDENSING_H
#define MPDEM_CEMENT_STEP_CONDENSING_H

#include <vector>

#include "added_masses.h"
#include "layout_manager.h"
#include "../condensed/condensed_bonds.h"
#include "../failure/cracks.h"
#include "../failure/load_history.h"
#include "../bond/scene.h"
#include "../bond/shared_nodes.h"
#include "work_of_step.h"

namespace mpdem {

class Condensing {
 public:
  Condensing(Scene& scene, CondensedBonds& condensed, const Cracks& cracks, const LoadHistory& load_history, LayoutManager& layout_manager,
             SharedNodes& shared, AddedMasses& added, const WorkOfStep& work)
      : scene_(scene),
        condensed_(condensed),
        cracks_(cracks),
        load_history_(load_history),
        layout_manager_(layout_manager),
        shared_(shared),
        added_(added),
        work_(work) {}

  // Call before the layout of a run. Marks bonds that no step has moved yet. Throws BadState if the words of the script
  // are others than those of the steps before.
  void choose();
  // Call after a layout of bonds, or when grains came from other ranks or are new. Binds the sides of the grains, and
  // what condensed bonds need of them.
  void bind();
  // Condenses those of these bonds that are to be condensed. Call after bind(), with the links of the run.
  void condense(const std::vector<int>& rows, bool at_start);
  // Call at the end of the forces of a step. Bonds near their threshold are resolved. After a check, bonds are
  // condensed again if they are awake, whole on a rank, and far from their threshold, and if force and energy hardly
  // change by it: their waves have gone. They keep their damage, and have the stiffness of the present. Bonds that came
  // apart are condensed too, if their pieces rest with their grains. Returns true if something changed. Then the forces
  // of the step are to be found anew, as at the start of a run, so that a run in parts is the run as a whole.
  // count_changes() has to follow.
  bool change();
  void count_changes();

  // Rows of bonds that ask for their points before the next step, the same on all ranks. They wake in it.
  const std::vector<int>& rows_that_want_points() const { return rows_that_want_points_; }
  void points_were_made() { rows_that_want_points_.clear(); }

 private:
  void activate();
  void condense_again();
  void take_patterns(bool at_start);
  std::vector<int> ask_for_points(const std::vector<int>& rows);
  // Collective. Bonds that have to wake. All ranks look together at bonds that they cut, where averages count.
  std::vector<int> rows_to_activate();
  std::vector<int> rows_that_rest();
  bool rests(Bond& b);
  void mark_pieces(const std::vector<int>& rows);
  std::vector<int> rows_with_loose_pieces(const std::vector<int>& rows) const;

  Scene& scene_;
  CondensedBonds& condensed_;
  const Cracks& cracks_;
  const LoadHistory& load_history_;
  LayoutManager& layout_manager_;
  SharedNodes& shared_;
  AddedMasses& added_;
  const WorkOfStep& work_;
  std::vector<int> rows_that_want_points_;
  struct Change {
    std::vector<int> rows;
    double energy = 0.0;     // energy that the rows had before, on this rank
    double to_grains = 0.0;  // energy that went to grains of this rank at once
  };
  Change woken_, again_;  // changes of this step: bonds that woke, and bonds condensed again
};

}  // namespace mpdem

#endif
