// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Cement that `fragments drop` of fix mpm removes (FragmentRule). It finds loose cement and for how long it has been loose:
// * a loose point belongs to a resolved bond that is separated. It is a point of a fragment, or a failed point whose nodes
//   have no cement that is attached to a grain. The size of a failed point is one point;
// * with `bonds`, all cement of a separated bond is loose.
//
// The clock is the sum of the steps from check to check, so that dividing a run changes nothing. All ranks have the same
// times. Departures (departures.h) removes what is due.
#ifndef MPDEM_CEMENT_STEP_LOOSE_CEMENT_H
#define MPDEM_CEMENT_STEP_LOOSE_CEMENT_H

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "../bond/scene.h"
#include "../failure/cracks.h"

namespace mpdem {

class LooseCement {
 public:
  // Since when a point is loose, by the clock. tag: 0 for all cement of the bond.
  struct Loose {
    int row, tag;
    double since;
  };
  // Cement to be dropped: slots of this rank by row of the table, and bonds with all of their cement, the same on all ranks.
  struct Due {
    std::map<int, std::vector<int>> slots;
    std::vector<int> bonds;
  };

  LooseCement(Scene& scene, const Cracks& cracks) : scene_(scene), cracks_(cracks) {}

  // Collective. Call at a check, at the end of the step, and once more if a run starts there. Notes what has come loose. Returns
  // true if some is due.
  bool examine();
  // Collective. What is due, by the last examine(). Slots may have changed since.
  Due due() const;
  // Call when points left their bonds.
  void forget(const std::vector<int>& rows);

  // State for restart files: the clock, the step that it shows, and all times, the same on all ranks.
  double clock() const { return clock_; }
  std::int64_t step() const { return step_; }
  std::vector<Loose> times() const;
  void restore(double clock, std::int64_t step, const std::vector<Loose>& times);

 private:
  using Place = std::pair<int, int>;  // row and tag
  void note_points();
  void note_bonds();
  bool is_old(double since) const;
  std::vector<int> rows_with_old_cement() const;

  Scene& scene_;
  const Cracks& cracks_;
  double clock_ = 0.0;
  std::int64_t step_ = -1;         // step of the last examine(); -1: none
  std::map<Place, double> since_;  // time since which each fragment is loose, the same on all ranks
};

}  // namespace mpdem

#endif
