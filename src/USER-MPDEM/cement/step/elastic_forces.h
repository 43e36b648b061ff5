// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Forces of links to elastic grains that are not known from one bond on one rank: where ranks cut a bond, or a grain has several
// bonds. Ranks sum the loads of the modes, and their stiffness where links debonded, and bonds on one grain move each other.
#ifndef MPDEM_CEMENT_STEP_ELASTIC_FORCES_H
#define MPDEM_CEMENT_STEP_ELASTIC_FORCES_H

#include <array>
#include <functional>
#include <vector>

#include "../bond/scene.h"
#include "elastic_coupling.h"

namespace mpdem {

class ElasticForces {
 public:
  explicit ElasticForces(Scene& scene) : scene_(scene) {}

  // Collective. Finds the bonds on one grain, if bonds were resolved, condensed or made since the last call.
  void find_coupling(bool anew);
  // Does this bond wait for find()?
  bool waits(Bond& b);
  // Collective. Adds the forces of the links of the bonds that wait, with the result in Bond::link_step, and calls then(b) for each of
  // them. at_start: states of links do not change.
  void find(bool at_start, const std::function<void(Bond&)>& then);

 private:
  void update_links();
  void find_loads(double dt);
  void note_departures();
  std::array<ElasticCoupling::Vector6, 2> motions_of(const Bond& b) const;  // of the patches of both grains, by other bonds
  void share_stiffness();
  void share_loads(double dt);
  void couple();
  template <class Get, class Take>
  void sum_modes(int most, Get get, Take take);
  // Calls f(bond, side, end) for the ends of waiting bonds that are coupled to others.
  template <class F>
  void each_coupled(F f);
  // Sums numbers of the ends over the ranks; each end has those of its lowest rank.
  void sum_over_ranks(double* values, std::size_t width) const;

  Scene& scene_;
  ElasticCoupling coupling_;
  std::vector<char> counts_here_;          // of the coupled ends: this is the lowest of the ranks with a share of the bond
  int found_at_ = -1;                      // Bonds::resolved_changes() at find_coupling()
  std::vector<std::array<int, 2>> pairs_;  // of grains with bonds that act on others, ascending
  struct Waiting {
    Bond* bond;
    bool shared;  // by ranks
  };
  std::vector<Waiting> waiting_;
};

}  // namespace mpdem

#endif
