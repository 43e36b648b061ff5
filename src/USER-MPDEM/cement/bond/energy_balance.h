// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Energy balance of the cement. Central differences conserve
//
//   E + dissipated + released + damped + frictional + left - work = start,
//
// where E is strain energy, energy of springs and kinetic energy. `dissipated` is by growth of damage, `released` by
// failed points, debonded links and changes of added mass, `damped` by dampers and transfers. `left` is the energy of
// cement that left the scene, and `work` that of grains, gravity and impulses of the host on the cement.
//
// The work of a step is that of its forces, from half a step before their time to half a step after it. Each half has
// its own velocity. The same holds for dampers and for friction of crack faces. The second half of the last step is
// counted in advance: the `_ahead` sums are this half, and the others include it.
//
// With `mass_order 2` the kinetic energy is v.M* v/2, with M* the inertia of mpm/consistent_mass.h. It is counted as
// the energy of the lumped mass, less the work of the force by which the two differ.
//
// Each number is the share of this rank, in units of energy.
#ifndef MPDEM_CEMENT_BOND_ENERGY_BALANCE_H
#define MPDEM_CEMENT_BOND_ENERGY_BALANCE_H

#include <mpi.h>

#include "../../parallel/ranks.h"
#include "../../parallel/record.h"

namespace mpdem {

class EnergyBalance {
 public:
  // Cement that left the scene, see cement/step/departures.h. momentum: in the axes of the box.
  struct Left {
    double points = 0.0, mass = 0.0, momentum[3] = {0, 0, 0}, energy = 0.0;
    double dropped = 0.0, dropped_mass = 0.0;  // number and mass of those of these points that were dropped, see cement/step/loose_cement.h

    template <class Self, class Visitor>
    static constexpr void describe(Self& l, Visitor& visit) {
      visit("the number of points that left", l.points, kNotNegative);
      visit("the mass that left", l.mass, kNotNegative);
      visit("the momentum that left", l.momentum, kFinite);
      visit("the energy that left", l.energy, kFinite);
      visit("the number of points that were dropped", l.dropped, kNotNegative);
      visit("the mass that was dropped", l.dropped_mass, kNotNegative);
    }
  };
  struct Sums {
    double dissipated = 0.0, released = 0.0, damped = 0.0, frictional = 0.0, work = 0.0, work_ahead = 0.0;
    double inertial_work = 0.0, inertial_work_ahead = 0.0;  // work of Grid::inertial_force
    double damped_ahead = 0.0, frictional_ahead = 0.0;
    Left left;

    template <class Self, class Visitor>
    static constexpr void describe(Self& s, Visitor& visit) {
      visit("the dissipated energy", s.dissipated, kFinite);
      visit("the released energy", s.released, kFinite);
      visit("the damped energy", s.damped, kFinite);
      visit("the energy of friction", s.frictional, kFinite);
      visit("the work of grains", s.work, kFinite);
      visit("the work ahead of its step", s.work_ahead, kFinite);
      visit("the work of the inertial forces", s.inertial_work, kFinite);
      visit("the work of the inertial forces ahead of its step", s.inertial_work_ahead, kFinite);
      visit("the damped energy ahead of its step", s.damped_ahead, kFinite);
      visit("the energy of friction ahead of its step", s.frictional_ahead, kFinite);
      visit.part(s.left);
    }
  };
  // Work of the present forces over a whole step. now: with the velocities at their time. with_velocity_before: with those of half a
  // step before. So the first half of the step has half of the work with_velocity_before, and the second half now less that.
  struct StepWork {
    double now = 0.0, with_velocity_before = 0.0;
  };

  void dissipate(double energy) { sums_.dissipated += energy; }
  void release(double energy) { sums_.released += energy; }
  void damp(double energy) { sums_.damped += energy; }
  void add_friction(double energy) { sums_.frictional += energy; }
  void do_work(double work) { sums_.work += work; }
  void do_inertial_work(double work) { sums_.inertial_work += work; }
  void leave(const Left& l) {
    sums_.left.points += l.points;
    sums_.left.mass += l.mass;
    for (int d = 0; d < 3; ++d) sums_.left.momentum[d] += l.momentum[d];
    sums_.left.energy += l.energy;
    sums_.left.dropped += l.dropped;
    sums_.left.dropped_mass += l.dropped_mass;
  }

  // Counts the decrease of energy() by `action` as released. damp_by() counts it as damped.
  template <class Energy, class Action>
  void release_by(Energy energy, Action action) {
    const double before = energy();
    action();
    release(before - energy());
  }
  template <class Energy, class Action>
  void damp_by(Energy energy, Action action) {
    const double before = energy();
    action();
    damp(before - energy());
  }

  // Counts the work of dampers and of friction of crack faces in a step. Call as soon as its accelerations are known.
  void end_step_of_dampers(const StepWork& damped, const StepWork& frictional) {
    sums_.damped += damped.now;
    sums_.damped_ahead = damped.now - 0.5 * damped.with_velocity_before;
    sums_.frictional += frictional.now;
    sums_.frictional_ahead = frictional.now - 0.5 * frictional.with_velocity_before;
  }
  // Counts the work of a step at its end.
  void end_step(const StepWork& w, const StepWork& inertial) {
    sums_.work += w.now;
    sums_.work_ahead = w.now - 0.5 * w.with_velocity_before;
    sums_.inertial_work += inertial.now;
    sums_.inertial_work_ahead = inertial.now - 0.5 * inertial.with_velocity_before;
  }
  // Counts new cement, whose first step is the half step ahead. energy_of_all: its energy, of all ranks. The others are
  // the work of that half step, and the energy that dampers take in it.
  void start(double energy_of_all, const StepWork& w, const StepWork& inertial, double damped_ahead) {
    sums_.work += w.now - 0.5 * w.with_velocity_before;
    sums_.work_ahead += w.now - 0.5 * w.with_velocity_before;
    sums_.inertial_work += inertial.now - 0.5 * inertial.with_velocity_before;
    sums_.inertial_work_ahead += inertial.now - 0.5 * inertial.with_velocity_before;
    sums_.damped += damped_ahead;
    sums_.damped_ahead += damped_ahead;
    start_ += energy_of_all;
  }

  const Sums& sums() const { return sums_; }
  // Collective. Returns sums over all ranks, and moves them to the first rank, where a run that reads the restart file has
  // them. The run that writes it then continues with the same rounding, which depends on the order of additions.
  Sums gather_on_first(MPI_Comm comm) {
    double numbers[kMostNumbers<Sums>];
    pack(sums_, numbers);
    MPI_Allreduce(MPI_IN_PLACE, numbers, kMostNumbers<Sums>, MPI_DOUBLE, MPI_SUM, comm);
    Sums all;
    unpack(numbers, all);
    sums_ = rank_in(comm) == 0 ? all : Sums();
    return all;
  }
  double start_energy() const { return start_; }  // energy of all ranks
  void restore(const Sums& sums, double start_energy) {
    sums_ = sums;
    start_ = start_energy;
  }

 private:
  Sums sums_;
  double start_ = 0.0;
};

}  // namespace mpdem

#endif
