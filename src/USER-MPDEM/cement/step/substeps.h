// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Motion of the grains in a step of the host that the cement divides into n sub-steps: positions at the end of each,
// and kicks by the loads on free grains. substeps.cpp describes the scheme. Nothing is sent between ranks. Units are
// those of the scene.
#ifndef MPDEM_CEMENT_STEP_SUBSTEPS_H
#define MPDEM_CEMENT_STEP_SUBSTEPS_H

#include <vector>

#include "../bond/scene.h"

namespace mpdem {

class Substeps {
 public:
  explicit Substeps(Scene& scene) : scene_(scene) {}

  // Call before the host moves its grains, while they have the velocities and loads of the end of the last step.
  void begin();
  // Call after the host has moved its grains. Finds their former positions, and the paths of prescribed motion.
  void find_paths();
  // Moves the grains to the end of sub-step Scene::substep. After the last sub-step the state keeps the position before
  // it, from which the host finds the motion.
  void move_grains();
  // Applies the first half of the kick by the loads of this sub-step to free grains.
  void kick_grains();

 private:
  // Motion of a grain in a step of the host.
  struct HermitePath {
    double from[3], length[3], start[6], end[6];  // start and end are velocities
    // Position and velocity at the share t of the duration `time` of the step.
    double position(int d, double time, double t) const;
    double velocity(int d, double time, double t) const;
  };

  Scene& scene_;
  std::vector<HermitePath> paths_;  // one for each grain
};

}  // namespace mpdem

#endif
