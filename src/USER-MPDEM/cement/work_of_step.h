// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Energy of motion and the work of a step, as central differences keep them: what goes into the books (energy_books.h), and what a change
// of velocities takes. It changes nothing. Each number is this rank's share, of the nodes that count here: energies, and powers.
#ifndef MPDEM_CEMENT_WORK_OF_STEP_H
#define MPDEM_CEMENT_WORK_OF_STEP_H

#include <vector>

#include "condensed_bonds.h"
#include "scene.h"

namespace mpdem {

class WorkOfStep {
 public:
  using StepWork = EnergyBooks::StepWork;

  WorkOfStep(const Scene& scene, const CondensedBonds& condensed) : scene_(scene), condensed_(condensed) {}

  // Of the nodes of a bond, with the velocity that is so long of the acceleration later than the stored one.
  static double kinetic_energy(const Bond& b, double later);
  // Of points, nodes and links of a bond that is awake, all of it.
  double energy_of(const Bond& b) const;
  // Of the weight of the nodes of a bond on a velocity of these, or none.
  double gravity_power(const Bond& b, const std::vector<double>& velocity) const;
  // What a change of velocity takes of the energy that central differences keep, beyond that of the stored velocity: it meets
  // the acceleration, too. jump: of the nodes, or none.
  double half_kick(const Bond& b, const std::vector<double>& jump) const;

  // On the cement of bodies from first_body on: of grains, gravity and impulses of the host; of inertial forces (`mass_order 2`).
  StepWork of_loads(int first_body) const;
  StepWork of_inertial_forces(int first_body) const;
  // What dampers take of bodies from first_body on, and what friction of crack faces takes.
  Power of_dampers(int first_body) const;
  Power of_rubbing() const;
  // Work of such a power in this step.
  StepWork over_step(const Power& power) const;

 private:
  const Scene& scene_;
  const CondensedBonds& condensed_;
};

}  // namespace mpdem

#endif
