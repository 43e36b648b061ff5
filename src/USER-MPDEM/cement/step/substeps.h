// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The grains in a step of the host that the cement takes in n sub-steps: where they are at the end of each, and the
// kicks of the loads on free grains. substeps.cpp describes the scheme. Nothing is sent between ranks. Units are those
// of the scene.
#ifndef MPDEM_CEMENT_STEP_SUBSTEPS_H
#define MPDEM_CEMENT_STEP_SUBSTEPS_H

#include <vector>

#include "../bond/scene.h"

namespace mpdem {

class Substeps {
 public:
  explicit Substeps(Scene& scene) : scene_(scene) {}

  // Call before the host moves its grains, when they have their velocities and loads of the end of the last step.
  void begin();
  // Call after the host has moved its grains. Finds where they came from, and the motion of grains that do not follow
  // forces.
  void find_paths();
  // Moves the grains to the end of sub-step Scene::substep. The last sub-step leaves the place before it in the state,
  // for the host to find the motion.
  void move_grains();
  // Gives free grains the first half of the kick by the loads of this sub-step.
  void kick_grains();

 private:
  // Motion of a grain in a step of the host.
  struct HermitePath {
    double from[3], length[3], start[6], end[6];  // start and end are velocities
    // Place and velocity at the share t of the time of the step.
    double position(int d, double time, double t) const;
    double velocity(int d, double time, double t) const;
  };

  Scene& scene_;
  std::vector<HermitePath> paths_;  // motion of each grain
};

}  // namespace mpdem

#endif
