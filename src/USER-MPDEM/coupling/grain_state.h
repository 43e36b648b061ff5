// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Data of a bonded grain that LIGGGHTS does not keep. They move with the grain to other ranks and into restart files.
// Arrays of six have three components of translation, then three of rotation.
#ifndef MPDEM_COUPLING_GRAIN_STATE_H
#define MPDEM_COUPLING_GRAIN_STATE_H

#include "../parallel/record.h"

namespace mpdem {

struct GrainState {
  int tag = 0;                              // ID of the grain when its cement was made; 0: not known
  double q[4] = {1.0, 0.0, 0.0, 0.0};       // orientation
  bool velocities_known = false;            // the velocities below are known, since a run began
  double v[6] = {0, 0, 0, 0, 0, 0};         // velocities with which it moved to the present position
  double v_before[6] = {0, 0, 0, 0, 0, 0};  // velocities of the step before
  double jump[6] = {0, 0, 0, 0, 0, 0};      // the share of the change of velocity that was a jump
  double v_end[6] = {0, 0, 0, 0, 0, 0};     // velocities at the end of the step
  double a[3] = {0, 0, 0};                  // expected acceleration of a prescribed v
  double load[6] = {0, 0, 0, 0, 0, 0};      // force and moment of the cement
  double pending_impulse[6] = {
      0, 0, 0, 0, 0, 0};        // second half of the impulse of jumps and transfers of the last step; it acts in the first half of the next
  bool position_known = false;  // x is known, since cement was made or forces were computed
  double x[3] = {0, 0, 0};      // unwrapped position when forces were computed last, or cement was made
  double late_load[6] = {0, 0, 0, 0, 0, 0};  // force and torque that fixes after fix mpm added in the last step
  // Used with sub-steps, see cement/bond/spread_loads.cpp. spread: the loads of the host are spread. mean: three
  // running means, each of the one before, the first of the load. off and off_squared: running averages of the
  // deviation of the load from held(), and of its square. mean_at_end: (S + S')/2 of cement/step/substeps.cpp. path_offset: sum
  // of the distances of the positions in the sub-steps from the mean of the ends of the step. It is found before grains
  // move to other ranks, and used after that.
  bool spread = false;
  double mean[18] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  double off[6] = {0, 0, 0, 0, 0, 0}, off_squared = 0.0;
  double mean_at_end[6] = {0, 0, 0, 0, 0, 0};
  double path_offset[3] = {0, 0, 0};

  // Load in each sub-step of the next step of the host.
  const double* held() const { return mean + 12; }

  // See parallel/record.h.
  template <class Self, class Visitor>
  static constexpr void describe(Self& g, Visitor& visit) {
    visit("the ID of a bonded grain", g.tag, kNotNegative);
    visit.rotation("the orientation of a bonded grain", g.q);
    visit("'velocities are known' of a bonded grain", g.velocities_known);
    visit("the velocity of a bonded grain", g.v, kFinite);
    visit("the earlier velocity of a bonded grain", g.v_before, kFinite);
    visit("the jump of velocity of a bonded grain", g.jump, kFinite);
    visit("the last velocity of a bonded grain", g.v_end, kFinite);
    visit("the acceleration of a bonded grain", g.a, kFinite);
    visit("the load of a bonded grain", g.load, kFinite);
    visit("the impulse that a bonded grain is yet to take", g.pending_impulse, kFinite);
    visit("'position is known' of a bonded grain", g.position_known);
    visit("the position of a bonded grain", g.x, kFinite);
    visit("the late load of a bonded grain", g.late_load, kFinite);
    visit("'loads are spread' of a bonded grain", g.spread);
    if (visit.present(g.spread)) {
      visit("the mean load of a bonded grain", g.mean, kFinite);
      visit("how far the load of a bonded grain is off its mean", g.off, kFinite);
      visit("how far the square of the load of a bonded grain is off its mean", g.off_squared, kNotNegative);
      visit("the load of a bonded grain between steps", g.mean_at_end, kFinite);
      visit("how far the path of a bonded grain in its sub-steps is bent", g.path_offset, kFinite);
    }
  }
};

}  // namespace mpdem

#endif
