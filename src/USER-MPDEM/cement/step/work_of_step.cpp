// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "work_of_step.h"

#include <array>

#include "../bond/point_sums.h"

namespace mpdem {

double WorkOfStep::energy_of(const Bond& b) const {
  PointSums points;
  points.add(b.points, *scene_.law, true);
  points.add(b.film.points, *scene_.law, true);
  double energy = points.elastic + b.added.energy(b.grid, scene_.grains.ends_of(b), 0.0, scene_.dt_last);
  b.links.add_spring_energy(b.grid, scene_.grains.ends_of(b), energy);
  for (const auto& p : b.mechanisms) p->add_energy(b.points, b.grid, scene_.grains.ends_of(b), energy, energy);
  energy += b.film.energy_of_faces(scene_.penalty ? scene_.penalty->law.get() : nullptr);
  for (int i = 0; i < b.grid.size(); ++i) {
    if (!b.grid.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) {
      const double v = b.grid.velocity[3 * i + d];
      energy += 0.5 * b.grid.mass[i] * v * (v + scene_.dt_last * b.grid.acceleration[3 * i + d]);
    }
  }
  return energy;
}

double WorkOfStep::kinetic_energy(const Bond& b, double later) {
  const Grid& grid = b.grid;
  double twice[3] = {};  // one sum for each component, so that the sums do not wait for each other
  for (int i = 0; i < grid.size(); ++i) {
    if (!grid.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) {
      const double v = grid.velocity[3 * i + d] + later * grid.acceleration[3 * i + d];
      twice[d] += grid.mass[i] * v * v;
    }
  }
  return 0.5 * (twice[0] + twice[1] + twice[2]);
}

EnergyBalance::StepWork WorkOfStep::over_step(const Power& power) const {
  return {scene_.dt_last * power.after(0.5 * scene_.dt_last), scene_.dt_last * power.stored};
}

Power WorkOfStep::of_dampers(int first_row) const {
  Power power;
  for (const Bond& b : scene_.bonds().resolved())
    if (b.row >= first_row) power.add(of_dampers(b));
  return power;
}

Power WorkOfStep::of_dampers(const Bond& b) const {
  Power power;
  power.add(b.links.damper_power(b.grid, scene_.grains.ends_of(b)));
  for (const auto& p : b.mechanisms) p->add_damping_power(b.grid, scene_.grains.ends_of(b), power);
  return power;
}

double WorkOfStep::ahead_of(const Bond& b) const {
  const double dt = scene_.dt_last;
  const StepWork damped = over_step(of_dampers(b));
  return 0.5 * dt * (gravity_power(b, b.grid.velocity) + dt * gravity_power(b, b.grid.acceleration)) -
         (damped.now - 0.5 * damped.with_velocity_before);
}

Power WorkOfStep::of_friction() const {
  Power power;
  for (const Bond& b : scene_.bonds().resolved())
    for (const auto& p : b.mechanisms) p->add_friction_power(b.grid, power);
  return power;
}

double WorkOfStep::gravity_power(const Bond& b, const std::vector<double>& velocity) const {
  const std::array<double, 3> weight = scene_.weight_of(b);
  if (weight == std::array<double, 3>{} || velocity.empty()) return 0.0;
  double power = 0.0;
  for (int i = 0; i < b.grid.size(); ++i) {
    if (!b.grid.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) power += b.grid.mass[i] * weight[d] * velocity[3 * i + d];
  }
  return power;
}

double WorkOfStep::load_power(const Bond& b, const std::vector<double>& velocity) const {
  double power = gravity_power(b, velocity);
  for (const auto& p : b.mechanisms) power += p->load_power(b.grid, velocity);
  if (scene_.fragments.has(b.row)) power += scene_.fragments.power(b, velocity);
  return power;
}

double WorkOfStep::inertial_power(const Bond& b, const std::vector<double>& velocity) const {
  double power = 0.0;
  const std::vector<char>& counts = b.grid.halo.counts_here();
  for (std::size_t n = 0; n < b.grid.inertial_force.size(); ++n)
    if (counts[n / 3]) power += b.grid.inertial_force[n] * velocity[n];
  return power;
}

double WorkOfStep::half_kick(const Bond& b, const std::vector<double>& jump) const {
  if (jump.empty()) return 0.0;
  double power[3] = {};  // one sum for each component, so that the sums do not wait for each other
  for (int i = 0; i < b.grid.size(); ++i) {
    if (!b.grid.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) power[d] += b.grid.mass[i] * b.grid.acceleration[3 * i + d] * jump[3 * i + d];
  }
  return -0.5 * scene_.dt_last * (power[0] + power[1] + power[2] + b.added.power(b.grid, scene_.grains.ends_of(b), jump));
}

EnergyBalance::StepWork WorkOfStep::over_step(double power, double of_acceleration) const {
  const double dt = scene_.dt_last;
  return {dt * power + 0.5 * dt * dt * of_acceleration, dt * power};
}

EnergyBalance::StepWork WorkOfStep::of_inertial_forces(int first_row) const {
  double power = 0.0, of_acceleration = 0.0;
  for (const Bond& b : scene_.bonds().resolved()) {
    if (b.row < first_row) continue;
    power += inertial_power(b, b.grid.velocity);
    of_acceleration += inertial_power(b, b.grid.acceleration);
  }
  return over_step(power, of_acceleration);
}

EnergyBalance::StepWork WorkOfStep::of_loads(int first_row) const {
  EnergyBalance::StepWork work = scene_.penalty ? scene_.grains.work(scene_.dt_last, first_row) : EnergyBalance::StepWork();
  for (const Bond& b : scene_.bonds().resolved()) {
    if (b.row < first_row) continue;
    const EnergyBalance::StepWork of_bond = over_step(load_power(b, b.grid.velocity), load_power(b, b.grid.acceleration));
    work.now += of_bond.now;
    work.with_velocity_before += of_bond.with_velocity_before;
  }
  const EnergyBalance::StepWork of_condensed =
      condensed_.work(scene_.grains, scene_.bonds(), scene_.weight().data(), scene_.dt_last, first_row);
  work.now += of_condensed.now;
  work.with_velocity_before += of_condensed.with_velocity_before;
  return work;
}

}  // namespace mpdem
