// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Energy of motion and the work of a step, as central differences keep them: what goes into the books (energy_balance.h),
// and what a change of velocities takes. The functions change nothing. Each number is the share of this rank, over the
// nodes that count here. Numbers are energies and powers.
#ifndef MPDEM_CEMENT_STEP_WORK_OF_STEP_H
#define MPDEM_CEMENT_STEP_WORK_OF_STEP_H

#include <vector>

#include "../condensed/condensed_bonds.h"
#include "../bond/scene.h"

namespace mpdem {

class WorkOfStep {
 public:
  using StepWork = EnergyBalance::StepWork;

  WorkOfStep(const Scene& scene, const CondensedBonds& condensed) : scene_(scene), condensed_(condensed) {}

  // Kinetic energy of the nodes of a bond. Velocities are ahead of the stored ones by `later` times the acceleration.
  static double kinetic_energy(const Bond& b, double later);
  // Energy of points, nodes, links and places of a bond that is awake.
  double energy_of(const Bond& b) const;
  // What the books have of a bond for the second half of the last step, which is still to come: work of gravity, less what dampers take.
  double ahead_of(const Bond& b) const;
  // Power of the weight of the nodes of a bond on a velocity of these. An empty velocity gives 0.
  double gravity_power(const Bond& b, const std::vector<double>& velocity) const;
  // Power of all loads of the host on the nodes of a bond, and of inertial forces (`mass_order 2`).
  double load_power(const Bond& b, const std::vector<double>& velocity) const;
  double inertial_power(const Bond& b, const std::vector<double>& velocity) const;
  // Energy that a change of velocity takes of that which central differences keep, beyond that of the stored velocity.
  // The change meets the acceleration, too. jump: change of the velocities of the nodes, or empty.
  double half_kick(const Bond& b, const std::vector<double>& jump) const;

  // Work on the cement of bodies from first_row on. of_loads() is the work of grains, gravity and impulses of the
  // host. of_inertial_forces() is that of inertial forces (`mass_order 2`).
  StepWork of_loads(int first_row) const;
  StepWork of_inertial_forces(int first_row) const;
  // of_dampers() is the power that dampers take of bodies from first_row on, or of one bond. of_friction() is the power that friction
  // of crack faces takes.
  Power of_dampers(int first_row) const;
  Power of_dampers(const Bond& b) const;
  Power of_friction() const;
  // Work of a power in this step.
  StepWork over_step(const Power& power) const;

 private:
  StepWork over_step(double power, double of_acceleration) const;

  const Scene& scene_;
  const CondensedBonds& condensed_;
};

}  // namespace mpdem

#endif
