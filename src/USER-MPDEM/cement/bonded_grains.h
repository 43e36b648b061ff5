// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The bonded grains of this rank: their velocities as the added mass of links sees them, and their accelerations.
//
// W- and W+ are the velocities of the steps that end and begin at time n, half a step before and after it.
// Added mass c goes along with its grain, N a = f + c A with N = m + c and A = (W+ - W-)/dt. Of grains that follow forces A
// is solved for at time n. Of prescribed motion W+ is known when the grain has moved: until then a smooth A' is
// expected, and dt (A - A') is the jump J, which nodes follow by c/N J before they drift. A grain that starts with
// velocity V so takes the nodes along in its first step; would it not, their c V^2/2 against the grain would be
// energy that nothing paid for. The reaction p = c (c/N - 1) J is momentum of the grains. Central differences keep
//
//   E - W = const,  W = -sum (F_n + F_n+1)/2 . (x_n+1 - x_n) - sum p . (W- + W+)/2,
//
// F the force on a grain without p: exact for jumps as for smooth motion. A velocity that a
// command gives to a grain between runs is such a jump, too; then p is taken from the grain at once. Bodies start
// with added mass that has the velocity of its grain.
#ifndef MPDEM_CEMENT_BONDED_GRAINS_H
#define MPDEM_CEMENT_BONDED_GRAINS_H

#include <mpi.h>

#include <array>
#include <vector>

#include "../coupling/grain.h"
#include "../coupling/grain_accelerations.h"
#include "bond.h"
#include "energy_books.h"

namespace mpdem {

class BondedGrains {
 public:
  using Six = std::array<double, 6>;
  std::vector<Grain> grains;  // ascending in tag
  GrainSides sides;

  // The bonded grains of this rank, anew; bind() if others than before.
  void replace(std::vector<Grain> now);
  bool changed() const { return changed_; }
  // Null if it is not on this rank.
  const Grain* find(int tag) const;

  // A side whose grain is here.
  struct OwnedSide {
    int grain, at, body, side;
  };
  const std::vector<OwnedSide>& owned() const { return owned_; }
  GrainSide* side_of(const Bond& b) { return &sides.sides[b.side]; }
  const GrainSide* side_of(const Bond& b) const { return &sides.sides[b.side]; }
  bool any_free() const { return any_free_; }  // on any rank

  // Inertia of its cement over what a grain has of inertia against it where its motion is not prescribed: a mass m at places up
  // to the radius r that moves with the grain has no more kinetic energy than a sphere of 7/2 m, since with t = 5/2
  //   m (V + Omega r)^2 <= (1 + t) m V^2 + (1 + 1/t) m r^2 Omega^2   and its moment of inertia is 2/5 m r^2.
  static double mass_ratio(const Grain& g, double cement);

  // Collective. After grains or bonds changed place: sides of the bonds that are awake, or of all, and who owns them. density: of the
  // inertia of the cement.
  void bind(MPI_Comm comm, Bonds& bonds, double density, bool all = false);
  // Collective. Bonds woke in a step: they get sides, and the others keep theirs with all they have. woken: the state of the new sides on ranks
  // that had the condensed bonds, ascending.
  void wake(MPI_Comm comm, Bonds& bonds, double density, const std::vector<GrainSide>& woken);
  // Collective. Motion to all who have a side.
  void distribute(const Bonds& bonds);
  // The same in the course of a step of dt, when the host has moved grains but the cement has not: places and orientations are those before.
  void distribute_as_before(const Bonds& bonds, double dt);
  // By the velocities that the host gave them.
  void turn(double dt);

  // Once a step, before distribute(): velocities with which grains came to their positions; jumps of prescribed ones. The
  // acceleration that is expected of prescribed motion is the lesser of that of the last step and of what its velocity at
  // the step tells: after a jump they differ, and none is expected.
  void find_rates(double dt, double dt_last, EnergyBooks& books);
  // At the end of a step: commands that change velocities show against these.
  void keep_velocities(double dt_last);
  // Loads of the host that come after the cement in a step; before and after them.
  void watch_late_loads(bool after);

  // Which loads of the host act: none, those so far and what came late in the last step, or what is spread over sub-steps.
  enum class Loads { none, all, spread };
  // Collective. Accelerations of free grains.
  void find_accelerations(MPI_Comm comm, const Bonds& bonds, Loads loads, CondensedPack* condensed = nullptr);
  // Call before find_accelerations(), for a bond that ranks do not cut and whose forces are complete: adds its sums while it is in cache.
  void begin_sums() {
    accelerations_.begin(sides);
    summed_ = true;
  }
  void sum_up(const Bond& b) {
    if (summed_ && !b.added.empty()) accelerations_.add({&b.added, &b.grid, b.side}, sides);
  }
  void added_mass_changed() { fresh_ = true; }

  // Jumps in a step, before nodes drift.
  void clear_sudden_forces();
  void follow_jumps(Bond& b, double dt, double dt_last);
  // Collective. Forces of the cement on the grains, once those of all bonds are with the sides. condensed: or null.
  void react(double dt, EnergyBooks& books, const CondensedPack* condensed);
  // Loads without those of the cement, which are to be found anew by another react(). What was booked of the jumps stays. The half step that came
  // to here had the work of the loads that are taken back, see book_loads_taken_back().
  void keep_loads();
  void take_back_loads();
  void book_loads_taken_back(double dt_last, EnergyBooks& books) const;
  // Collective. Momentum and angular momentum about its centre of each grain, which it and its condensed bonds take up at once, where it is free.
  // Accelerations are then those of this impulse, until distribute().
  void push(MPI_Comm comm, const std::vector<Six>& momentum, CondensedPack& condensed);
  // At the start of a run, and at the end of a step of n sub-steps: what is spread over those of the next one.
  void start_spreading(int n);
  void spread_loads(int n);
  // Collective. What is not spread of the load of the host so far and what came late in the last step acts for n sub-steps at once: forces of this impulse on nodes
  // and grains, and what grains are accelerated by beyond their accelerations so far.
  void share_impulses(MPI_Comm comm, Bonds& bonds, int n, CondensedPack* condensed);
  // Collective. react() in one of n sub-steps. What is added to the loads of the grains is the n-th part, and what is spread is taken from them.
  void react_in_substep(double dt, int n, EnergyBooks& books, const CondensedPack* condensed);
  // Sets the loads that are shown after a step: all of those of host and cement.
  void show_loads(int substeps);
  // Collective. Of that, the reaction of added mass that followed jumps, or whose nodes changed velocity by transfer, and its work.
  void react_to_jumps(double dt, EnergyBooks& books);
  void expect_sudden_forces() { sudden_forces_are_due_ = true; }

  // Collective. Jumps of the owned sides, for all added mass or for that of bodies from first_body on, exchange momentum
  // between nodes and grains at once: the change of velocity of nodes is left in their acceleration, that of grains is theirs.
  // The work is that on bodies before end_of_work.
  void exchange_momentum(MPI_Comm comm, Bonds& bonds, const std::vector<Six>& jump, int first_body, bool at_start, int end_of_work,
                         EnergyBooks& books);
  // Collective. Takes up what commands did to velocities since the last step, by find_commands().
  void take_up_commands(MPI_Comm comm, Bonds& bonds, double dt, double dt_last, EnergyBooks& books);
  // Collective. Leaves in the jumps of the sides what commands did to velocities of free grains; false if nothing.
  bool find_commands(MPI_Comm comm, CondensedPack* condensed);
  // Collective. Added mass of new bodies gets the velocity of its grains, which are at a full step where they have not been seen before.
  void start_added_mass(MPI_Comm comm, Bonds& bonds, int first_body, bool any_added_mass, EnergyBooks& books);
  // Grains that were not seen before go back to the middle of the step before, like the nodes of new bodies.
  void go_back_half_a_step(const Bonds& bonds, double dt_last);

  // Work on the cement of bodies from first_body on, in a step. That of jumps and transfers has been counted.
  EnergyBooks::StepWork work(double dt_last, int first_body) const;
  // That of loads of condensed bonds, of all of them.
  EnergyBooks::StepWork work_of(const CondensedPack& condensed, double dt_last) const;

  // The first jump of a prescribed velocity above a limit that is no small part of it, in this run on this rank.
  struct Jump {
    int tag = 0;  // 0: none
    double size = 0.0;
    long step = 0;
  };
  void watch_jumps(double limit, long first_step);  // from here on
  const Jump& worst_jump() const { return worst_jump_; }

 private:
  void watch_jump(const Grain& g);

  std::vector<OwnedSide> owned_;
  GrainAccelerations accelerations_, impulses_;
  bool summed_ = false;  // bonds that ranks do not cut
  std::vector<GrainAccelerations::Vector6> load_;
  std::vector<Six> kept_loads_, taken_loads_;  // of each grain: of the host, of the cement
  bool taken_back_ = false;
  bool changed_ = true, any_free_ = false, fresh_ = false, sudden_forces_are_due_ = false;
  double jump_limit_ = 0.0;  // of velocity
  long step_ = 0;            // steps of this run
  Jump worst_jump_;
};

}  // namespace mpdem

#endif
