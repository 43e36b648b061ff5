// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The data of a bonded grain that the cement needs in a step. A grain is a rigid sphere. Arrays of six have three
// components of translation, then three of rotation about the centre.
#ifndef MPDEM_COUPLING_GRAIN_H
#define MPDEM_COUPLING_GRAIN_H

#include <algorithm>
#include <vector>

#include "grain_state.h"

namespace mpdem {

// State of a grain, owned by the host. A const grain gives read access only.
class HostState {
 public:
  HostState(GrainState* of_host = nullptr) : at_(of_host) {}
  GrainState& operator*() { return *at_; }
  GrainState* operator->() { return at_; }
  const GrainState& operator*() const { return *at_; }
  const GrainState* operator->() const { return at_; }

 private:
  GrainState* at_;
};

// A bonded grain that this rank owns. The host writes all members before it calls the engine. The engine adds to
// `force` and `velocity`. `state` points to data of the host.
struct Grain {
  int tag = 0;
  double x[3] = {0, 0, 0};  // unwrapped
  double velocity[6] = {0, 0, 0, 0, 0, 0};
  double force[6] = {0, 0, 0, 0, 0, 0};  // all load so far in the step
  double mass = 0, inertia = 0, radius = 0;
  bool free[6] = {};            // the component follows forces; otherwise it is prescribed
  double mass_ratio = 0;        // inertia of its cement over its own, see added_mass.h; 0 if prescribed
  double moved[3] = {0, 0, 0};  // displacement in this step
  // Used with sub-steps only. start: velocity at the start of the step. cement_load: load of the cement at the present
  // time. load_of_other_substeps: the share of it that is the impulse of other sub-steps. kick: load that accelerates
  // the grain in the next sub-step.
  double start[6] = {0, 0, 0, 0, 0, 0}, cement_load[6] = {0, 0, 0, 0, 0, 0}, load_of_other_substeps[6] = {0, 0, 0, 0, 0, 0},
         kick[6] = {0, 0, 0, 0, 0, 0};
  double acceleration[6] = {0, 0, 0, 0, 0, 0};  // in this step: expected for prescribed motion, or found by the cement
  double radius_at_creation = 0;                // radius when its cement was made
  HostState state;
  std::vector<int> ends;  // indices of all its ends in BondEnds::owned()

  // Component d of u of cement/step/substeps.cpp: the part of the load of the host at the end of a step of n sub-steps that
  // acts within the steps before and after this time, and not at this time.
  double spread_part(int d, int n) const { return free[d] ? (1.0 - 1.0 / n) * state->mean_at_end[d] : 0.0; }
  bool any_free() const { return std::find(free, free + 6, true) != free + 6; }
};

}  // namespace mpdem

#endif
