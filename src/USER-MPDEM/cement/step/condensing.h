// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Decides when bonds are condensed (condensed_bonds.h), activated, and condensed again, and which bonds get their
// points before. The two forms of a bond may differ in energy; the difference enters the energy balance. Functions are
// collective, except those of one line here.
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

  // Call before the layout of a run. Marks bonds that no step has moved yet (BondRecord::condensed). Throws BadState if
  // bonds are condensed, but the options of the script do not allow that.
  void choose();
  // Call after a layout of bonds, or when grains came from other ranks or are new. Binds the ends of bonds to their
  // grains, and gives condensed bonds the data of their grains.
  void bind();
  // Condenses the marked ones of these bonds. Call after bind(), with the links of the run.
  void condense(const std::vector<int>& rows, bool at_start);
  // Call once the forces of a step are known. Activates bonds near their threshold. After a check, it also condenses
  // resolved bonds again. Such a bond lies on one rank, is far from its threshold, and its waves have decayed: force and
  // energy hardly change as it is condensed. It keeps its damage, and its solution has the present stiffness. A separated
  // bond is condensed if its pieces rest with their grains, and at once where cement has contact: contact/piece_contact.h
  // then takes over what the pieces feel. Returns true if something changed. Then compute the forces of
  // the step again as the start of a run does, so that a divided run gives the result of a single run, and call
  // count_changes().
  bool change();
  void count_changes();

  // Rows of bonds that need their points before the next step, the same on all ranks. They are activated in it.
  const std::vector<int>& rows_that_want_points() const { return rows_that_want_points_; }
  void points_were_made() { rows_that_want_points_.clear(); }

 private:
  void activate();
  void condense_again();
  void install_templates(bool at_start);
  std::vector<int> ask_for_points(const std::vector<int>& rows);
  // Collective. Bonds to activate. With nonlocal damage, all ranks of a cut bond examine it together.
  std::vector<int> rows_to_activate();
  std::vector<int> rows_that_rest();
  bool rests(Bond& b);
  // Separated bonds that go on with contact of their surfaces: without large fragments as rigid pieces, else resolved.
  struct Parting {
    std::vector<int> in_pieces, with_fragments;
  };
  Parting rows_to_part();
  void release_fragments(const std::vector<int>& rows);
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
    double energy = 0.0;     // energy that the rows had before, on this rank; count_changes() subtracts what they have after
    double to_grains = 0.0;  // energy that grains of this rank gained by BondedGrains::apply_impulse()
  };
  Change activated_, recondensed_, released_;  // bonds activated in this step, condensed again, and whose fragments became bodies
};

}  // namespace mpdem

#endif
