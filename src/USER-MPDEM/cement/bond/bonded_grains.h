// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The bonded grains of this rank: velocities, accelerations and loads, and how the added mass of links follows them.
// Units are those of the scene. Arrays of six have translation, then rotation about the centre.
//
// A node of mass m has the added mass c, which moves with its grain. So the acceleration a of the node follows from its
// force f by N a = f + c A, with N = m + c and the acceleration A = (W+ - W-)/dt of the grain. W- and W+ are the
// velocities of the grain half a step before and after time n. For grains that follow forces, A is solved for at time
// n. For prescribed motion, W+ is known only after the grain has moved. Until then a smooth A' is predicted. The jump is
// J = dt (A - A'). Nodes follow it by c/N J before they drift. So a grain that suddenly has the velocity V moves its
// nodes in the first step. Otherwise added mass would get the energy c V^2/2 relative to the grain, for which no work is
// done. The grain gets the reaction p = c (c/N - 1) J as momentum. Central differences conserve
//
//   E - W = const,  W = -sum (F_n + F_n+1)/2 . (x_n+1 - x_n) - sum p . (W- + W+)/2,
//
// where F is the force on a grain without p. This is exact for jumps and for smooth motion. A velocity that a command
// gives to a grain between runs is also a jump. Then the grain loses p at once. The added mass of a new bond starts with
// the velocity of its grain.
#ifndef MPDEM_CEMENT_BOND_BONDED_GRAINS_H
#define MPDEM_CEMENT_BOND_BONDED_GRAINS_H

#include <mpi.h>

#include <array>
#include <vector>

#include "../../coupling/grain.h"
#include "../../coupling/grain_accelerations.h"
#include "bond.h"
#include "energy_balance.h"

namespace mpdem {

class BondedGrains {
 public:
  using Six = std::array<double, 6>;
  std::vector<Grain> grains;  // ascending in tag
  BondEnds ends;

  BondedGrains() = default;
  BondedGrains(const BondedGrains&) = delete;  // a copy would share the states of the grains; use ends_of_all()

  // Replaces the bonded grains of this rank. Call bind() if their tags changed, see changed().
  void replace(std::vector<Grain> now);
  bool changed() const { return changed_; }
  // Returns null if the grain is not on this rank.
  const Grain* find(int tag) const;

  // An end of a bond whose grain is on this rank. grain: index in `grains`. at: index in ends.ends. side: 0 or 1.
  struct OwnedEnd {
    int grain, at, row, side;
  };
  const std::vector<OwnedEnd>& owned() const { return owned_; }
  BondEnd* ends_of(const Bond& b) { return &ends.ends[b.first_end_index]; }
  const BondEnd* ends_of(const Bond& b) const { return &ends.ends[b.first_end_index]; }
  bool any_free() const { return any_free_; }  // true if a grain of any rank is free

  // Bound of the inertia of the cement of a grain over that of the grain, if both move as one body in the free directions
  // of the grain. cement: mass of this cement, with mass scaling. A mass m within the radius r of the grain has at most
  // the kinetic energy of a sphere of mass 7/2 m and moment of inertia 2/5 (7/2 m) r^2. This follows for t = 5/2 from
  //   m (V + Omega r)^2 <= (1 + t) m V^2 + (1 + 1/t) m r^2 Omega^2.
  static double mass_ratio(const Grain& g, double cement);

  // Collective. Call after grains or bonds changed rank. Finds the ends of the resolved bonds, and their owners.
  // density: density of the inertia of the cement.
  void bind(MPI_Comm comm, Bonds& bonds, const CementDensity& density);
  // Collective. Call when bonds were activated in a step. They get ends, and the other ends keep their state. activated:
  // state of the new ends, ascending, on ranks that had the condensed bonds.
  void rebind_ends(MPI_Comm comm, Bonds& bonds, const CementDensity& density, const std::vector<BondEnd>& activated);
  // Collective. Sends the motion of the grains to all ranks that have ends of bonds on them.
  void distribute(const Bonds& bonds);
  // Collective. Returns ends of all bonds, condensed ones too, with the present motion of the grains.
  struct EndsOfAll {
    BondEnds ends;
    std::vector<OwnedEnd> owned;
  };
  EndsOfAll ends_of_all(MPI_Comm comm, const Bonds& bonds) const;
  // Collective. Does what distribute() does, for a call within a step of dt after the host moved the grains and before
  // the cement moved. Sends the positions and orientations from before the move.
  void distribute_as_before(const Bonds& bonds, double dt);
  // Rotates the grains over dt by the angular velocities that the host gave them.
  void rotate(double dt);

  // Call once a step, before distribute(). Finds the velocities with which grains came to their positions, and the
  // jumps of prescribed velocities. The acceleration predicted for prescribed motion is the minmod of two estimates:
  // that of the last step, and that from the present velocity. They disagree after a jump, and zero is predicted.
  void update_kinematics(double dt, double dt_last, long step, EnergyBalance& energy);
  // Keeps the velocities at the end of a step. find_commands() compares with them.
  void keep_velocities(double dt_last);
  // Finds the loads that the host adds after the cement in a step. Call before (false) and after (true) them.
  void record_late_loads(bool after);

  // Collective. Finds the accelerations of free grains in one of n sub-steps of a step. If n = 1, the load of the host is
  // Grain::force plus the late load of the last step. Otherwise it is the load GrainState::held() of each sub-step.
  void find_accelerations(MPI_Comm comm, const Bonds& bonds, int n, CondensedPack& condensed);
  // Add the sums of bonds to those of the grains while the bonds are in cache. Call begin_sums() first, then sum_up()
  // for each resolved bond once its forces are complete, then find_accelerations().
  void begin_sums() {
    accelerations_.begin(ends);
    summed_ = true;
  }
  void sum_up(const Bond& b) {
    if (summed_ && !b.added.empty()) accelerations_.add({&b.added, &b.grid, b.first_end_index}, ends);
  }
  void added_mass_changed() { mass_changed_ = true; }  // the next solution makes its mass matrix anew
  // Did the iteration for some accelerations end before it reached its precision? The same on all ranks.
  bool accelerations_are_imprecise() const { return accelerations_.imprecise() || impulses_.imprecise(); }

  // Jumps in a step: call clear_sudden_forces() first, then follow_jumps() for each bond before its nodes drift.
  void clear_sudden_forces();
  // Call at the start of a run, before its accelerations are found. Restores the second half of the impulses of jumps
  // and transfers of the last step, which acts in the next step.
  void resume_sudden_loads(double dt);
  // weight: acceleration by gravity that acts on the inertia of the bond. Counts the work of weight and inertial forces
  // in the second half of the last step on the change of nodal velocity by the jump.
  void follow_jumps(Bond& b, double dt, double dt_last, const std::array<double, 3>& weight, EnergyBalance& energy);
  // Collective. Adds the forces of the cement to the grains in one of n sub-steps of a step, once the ends have the
  // forces of all bonds. A grain gets 1/n of the cement load, and loses the load of the host that is spread.
  void react(double dt, int n, EnergyBalance& energy, const CondensedPack& condensed);
  // These three serve to find the loads of the cement a second time in a step. save_loads(), before react(), stores the
  // loads without those of the cement. restore_loads() restores them for another react(), which does not count the work
  // of jumps again. The work of the half step before has been counted with the loads taken back:
  // correct_work_of_withdrawn_loads() corrects it.
  void save_loads();
  void restore_loads();
  void correct_work_of_withdrawn_loads(double dt_last, EnergyBalance& energy) const;
  // Collective. Gives momentum, and angular momentum about its centre, to each grain. The grain and its condensed bonds
  // change velocity at once, in the free directions of the grain. Accelerations are those of this impulse until
  // distribute(). Returns the energy that grains of this rank gain, including the work on prescribed directions.
  double apply_impulse(MPI_Comm comm, const std::vector<Six>& momentum, CondensedPack& condensed);
  // Find the load that is spread over the n sub-steps of the next step: start_spreading() at the start of a run,
  // spread_loads() at the end of a step. Nothing is spread if n = 1.
  void start_spreading(int n);
  void spread_loads(int n);
  // Collective, in the last of n sub-steps. Applies the part of the load of the host that is not spread, as an impulse of
  // all sub-steps at once, n (F - u) - S of cement/step/substeps.cpp. Finds its forces on nodes and grains, and adds its
  // accelerations to those of the grains.
  void share_impulses(MPI_Comm comm, Bonds& bonds, int n, CondensedPack& condensed);
  // Sets the forces that are reported after a step of n sub-steps: all loads of host and cement.
  void set_reported_loads(int n);
  // Collective. Finds the reaction of added mass that followed jumps, or whose nodes changed velocity by transfer, and
  // counts its work. react() calls this, and adds the reaction to the grains.
  void react_to_jumps(double dt, EnergyBalance& energy);
  // Call in each step in which added mass may follow jumps, or nodes change velocity by transfer.
  void expect_sudden_forces() { sudden_forces_are_due_ = true; }

  // Collective. Exchanges momentum between nodes and grains at once. jump: of the owned ends. Added mass of bonds from
  // first_row on follows the jumps; at_start: see AddedMass::add_jumps(). Changes the velocity of grains, and leaves that
  // of nodes as it is: its change is in their acceleration. Counts the work on bonds before row end_of_work.
  void exchange_momentum(MPI_Comm comm, Bonds& bonds, const std::vector<Six>& jump, int first_row, bool at_start, int end_of_work,
                         EnergyBalance& energy);
  // Changes of velocity by commands between runs: call find_commands(), read_commanded_velocities(), count_commands() in
  // this order. count_commands() counts the work of the last loads on these changes, over the half step ahead.
  void count_commands(double dt_last, EnergyBalance& energy) const;
  // Collective. Applies the changes of velocity that find_commands() found to the added mass.
  void read_commanded_velocities(MPI_Comm comm, Bonds& bonds, double dt, double dt_last, EnergyBalance& energy);
  // Collective. Sets the jumps of the ends to the changes of velocity of free grains by commands. Returns false if
  // there are none.
  bool find_commands(MPI_Comm comm, CondensedPack& condensed);
  // Collective. Gives the added mass of new bonds the velocity of its grains. The velocities of new grains are those at
  // the time of the step.
  void start_added_mass(MPI_Comm comm, Bonds& bonds, int first_row, bool any_added_mass, EnergyBalance& energy);
  // Sets the velocities of new grains back to the middle of the last step, as for the nodes of new bonds.
  void stagger_velocities(const Bonds& bonds, double dt_last);

  // Work of the grains on bonds from first_row on, in a step, without that of jumps and transfers, counted elsewhere.
  EnergyBalance::StepWork work(double dt_last, int first_row) const;
  // Work of the loads of all condensed bonds, in a step.
  EnergyBalance::StepWork work_of(const CondensedPack& condensed, double dt_last) const;

  // The first jump of a prescribed velocity in this run on this rank that exceeds a limit and half of the velocity.
  struct Jump {
    int tag = 0;  // 0: none
    double size = 0.0;
    long step = 0;
  };
  void start_watch(double limit);  // forgets the jump and the start found so far
  // The bond on this rank whose cement had the largest speed against its grains when it started in this run.
  struct Start {
    int row = -1;
    double speed = 0.0;
  };
  const Start& fastest_start() const { return fastest_start_; }
  const Jump& worst_jump() const { return worst_jump_; }

 private:
  void find_loads(int n);
  void solve(MPI_Comm comm, const Bonds& bonds, CondensedPack& condensed);
  void add_loads_of_cement(double dt, EnergyBalance& energy, const CondensedPack& condensed);
  std::size_t slot_of(int tag) const;  // index in `grains`, or their number if the grain is not on this rank
  // Collective. Finds ends of bonds, and returns those that this rank owns. all: of condensed bonds, too.
  std::vector<OwnedEnd> find_ends(MPI_Comm comm, const Bonds& bonds, bool all, BondEnds& found) const;
  void send_motion(const Bonds& bonds, const std::vector<OwnedEnd>& owned, BondEnds& to) const;
  void watch_jump(const Grain& g);

  std::vector<OwnedEnd> owned_;
  GrainAccelerations accelerations_, impulses_;
  bool summed_ = false;  // begin_sums() was called
  std::vector<GrainAccelerations::Vector6> host_load_;
  std::vector<Six> saved_loads_, withdrawn_loads_,
      sudden_loads_;             // for each grain: load of the host, saved load of the cement, load of jumps and transfers in this step
  bool loads_restored_ = false;  // restore_loads() was called in this step
  bool changed_ = true, any_free_ = false, mass_changed_ = false, sudden_forces_are_due_ = false;
  double jump_limit_ = 0.0;  // jumps up to this size are not noted
  long step_ = 0;
  Jump worst_jump_;
  Start fastest_start_;
};

}  // namespace mpdem

#endif
