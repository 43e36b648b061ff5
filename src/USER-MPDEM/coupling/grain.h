// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A bonded grain: a rigid sphere. What its cement needs to know of it in a step. Six numbers are three of translation and three of rotation about the centre.
#ifndef MPDEM_GRAIN_H
#define MPDEM_GRAIN_H

#include <algorithm>
#include <vector>

#include "grain_state.h"

namespace mpdem {

// A bonded grain that this rank owns. All but `state`, which is the host's, is written by the host before the engine is
// called; the engine adds to `force` and `velocity`.
struct Grain {
  int tag = 0;
  double x[3] = {0, 0, 0};                 // unwrapped
  double velocity[6] = {0, 0, 0, 0, 0, 0};
  double force[6] = {0, 0, 0, 0, 0, 0};    // all load so far in the step
  double mass = 0, inertia = 0, radius = 0;
  bool free[6] = {};                       // follows forces; what does not is prescribed
  double mass_ratio = 0;                   // of its cement's inertia to its own, see penalty_links.h; 0 if prescribed
  double moved[3] = {0, 0, 0};             // in this step
  GrainState* state = nullptr;
  std::vector<int> sides;                  // places in GrainSides::owned(), all of its sides

  bool any_free() const { return std::find(free, free + 6, true) != free + 6; }
};

}  // namespace mpdem

#endif
