// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Kinetic energy and work of a step in the sense of central differences: terms of the energy balance
// (energy_balance.h), and the energy that a change of velocities takes. The functions change nothing. Values are
// energies and powers, each the share of this rank over the nodes that count here.
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
  // Energy of points, nodes, links and contact points of a resolved bond.
  double energy_of(const Bond& b) const;
  // Counted in advance for the second half of the last step of a bond: work of gravity, less damping.
  double ahead_of(const Bond& b) const;
  // Power of the weight of the nodes of a bond at this velocity. An empty velocity gives 0.
  double gravity_power(const Bond& b, const std::vector<double>& velocity) const;
  // Power of all loads of the host on the nodes of a bond, and of inertial forces (`mass_order 2`).
  double load_power(const Bond& b, const std::vector<double>& velocity) const;
  double inertial_power(const Bond& b, const std::vector<double>& velocity) const;
  // Central differences conserve m v.(v + dt a)/2 with the stored velocity v. Returns the loss of the second term as v
  // changes: minus dt/2 times the power of the nodal forces on `jump`, the change of the nodal velocities, or empty.
  double half_kick(const Bond& b, const std::vector<double>& jump) const;

  // Work on the cement of bonds from first_row on. of_loads() is the work of grains, gravity and impulses of the host.
  // of_inertial_forces() is that of inertial forces (`mass_order 2`).
  StepWork of_loads(int first_row) const;
  StepWork of_inertial_forces(int first_row) const;
  // of_dampers() is the power that dampers dissipate in bonds from first_row on, or in one bond. of_friction() is the
  // power that friction of crack faces dissipates.
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
