// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The bonded grains of this rank: their velocities as the added mass of links sees them, and their accelerations.
//
// W- and W+ are the velocities of the steps that end and begin at time n, half a step before and after it. Added mass c
// goes along with its grain: N a = f + c A with N = m + c and A = (W+ - W-)/dt. For grains that follow forces, A is
// solved for at time n. For prescribed motion, W+ is known only when the grain has moved. Until then a smooth A' is
// expected, and dt (A - A') is the jump J. Nodes follow the jump by c/N J before they drift. So a grain that starts
// with velocity V takes the nodes along in its first step. Otherwise their c V^2/2 against the grain would be energy
// that nothing paid for. The reaction p = c (c/N - 1) J is momentum of the grains. Central differences keep
//
//   E - W = const,  W = -sum (F_n + F_n+1)/2 . (x_n+1 - x_n) - sum p . (W- + W+)/2,
//
// where F is the force on a grain without p. This is exact for jumps and for smooth motion. A velocity that a command
// gives to a grain between runs is such a jump, too. Then p is taken from the grain at once. Bodies start with added
// mass that has the velocity of its grain.
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
  BondedGrains(const BondedGrains&) = delete;  // a copy would have the states of the same grains, see EndsOfAll

  // Replaces the bonded grains of this rank. Call bind() if they are others than before, see changed().
  void replace(std::vector<Grain> now);
  bool changed() const { return changed_; }
  // Returns null if the grain is not on this rank.
  const Grain* find(int tag) const;

  // A side whose grain is on this rank. grain: place in `grains`. at: place in sides.sides.
  struct OwnedEnd {
    int grain, at, row, side;
  };
  const std::vector<OwnedEnd>& owned() const { return owned_; }
  BondEnd* ends_of(const Bond& b) { return &ends.ends[b.first_end]; }
  const BondEnd* ends_of(const Bond& b) const { return &ends.ends[b.first_end]; }
  bool any_free() const { return any_free_; }  // true if a grain of any rank is free

  // Inertia of the cement of a grain over the inertia of the grain against it, where the motion of the grain is not
  // prescribed. A mass m at places up to the radius r that moves with the grain has no more kinetic energy than a
  // sphere of 7/2 m. With t = 5/2
  //   m (V + Omega r)^2 <= (1 + t) m V^2 + (1 + 1/t) m r^2 Omega^2,
  // and the moment of inertia of a sphere of mass m is 2/5 m r^2.
  static double mass_ratio(const Grain& g, double cement);

  // Collective. Call after grains or bonds changed place. Finds the sides of the bonds that are awake, and who owns
  // them. density: density of the inertia of the cement.
  void bind(MPI_Comm comm, Bonds& bonds, double density);
  // Collective. Call when bonds woke in a step. They get sides, and the other sides keep all they have. woken: state of
  // the new sides, ascending, on ranks that had the condensed bonds.
  void wake(MPI_Comm comm, Bonds& bonds, double density, const std::vector<BondEnd>& woken);
  // Collective. Sends the motion of the grains to all ranks that have a side of them.
  void distribute(const Bonds& bonds);
  // Collective. Sides of all bonds, condensed ones too, with the present motion of the grains, for those who look.
  struct EndsOfAll {
    BondEnds ends;
    std::vector<OwnedEnd> owned;
  };
  EndsOfAll ends_of_all(MPI_Comm comm, const Bonds& bonds) const;
  // Collective. Does what distribute() does in the course of a step of dt, when the host has moved grains but the cement has not.
  // Sends the places and orientations of before the move.
  void distribute_as_before(const Bonds& bonds, double dt);
  // Turns the grains over dt by the velocities that the host gave them.
  void turn(double dt);

  // Call once a step, before distribute(). Finds the velocities with which grains came to their positions, and the
  // jumps of prescribed velocities. The acceleration that is expected of prescribed motion is the lesser of two: that
  // of the last step, and that which the velocity at the step tells. After a jump the two differ, and none is expected.
  void update_kinematics(double dt, double dt_last, long step, EnergyBalance& energy);
  // Keeps the velocities at the end of a step. find_commands() compares with them.
  void keep_velocities(double dt_last);
  // Finds loads of the host that come after the cement in a step. Call before and after them.
  void watch_late_loads(bool after);

  // Collective. Finds the accelerations of free grains in one of n sub-steps of a step. The load of the host is that so
  // far and what came late in the last step, or what is spread over several sub-steps.
  void find_accelerations(MPI_Comm comm, const Bonds& bonds, int n, CondensedPack& condensed);
  // Add the sums of bonds to those of the grains while the bonds are in cache. Call begin_sums() first, then sum_up()
  // for each awake bond once its forces are complete. find_accelerations() comes after them.
  void begin_sums() {
    accelerations_.begin(ends);
    summed_ = true;
  }
  void sum_up(const Bond& b) {
    if (summed_ && !b.added.empty()) accelerations_.add({&b.added, &b.grid, b.first_end}, ends);
  }
  void added_mass_changed() { fresh_ = true; }
  // Did some accelerations end before their precision? The same on all ranks.
  bool accelerations_are_imprecise() const { return accelerations_.imprecise() || impulses_.imprecise(); }

  // Jumps in a step: clear_sudden_forces() comes first, then follow_jumps() for each bond before its nodes drift.
  void clear_sudden_forces();
  // Call at the start of a run, before its accelerations are found. What jumps and transfers of the last step leave for the next acts again.
  void resume_sudden_loads(double dt);
  // weight: acceleration by gravity that acts on the inertia of the bond. Books the work of weight and inertial forces in
  // the second half of the last step on what the jump adds to the velocities of nodes.
  void follow_jumps(Bond& b, double dt, double dt_last, const std::array<double, 3>& weight, EnergyBalance& energy);
  // Collective. Adds the forces of the cement to the grains in one of n sub-steps of a step, once the sides have the
  // forces of all bonds. The loads of the grains get the n-th part, less what of the load of the host is spread.
  void react(double dt, int n, EnergyBalance& energy, const CondensedPack& condensed);
  // keep_loads() keeps the loads without those of the cement. take_back_loads() goes back to them, so that another
  // react() finds the loads of the cement anew. What was booked of jumps stays. The half step that came to here had
  // the work of the loads that are taken back. count_loads_taken_back() corrects that.
  void keep_loads();
  void take_back_loads();
  void count_loads_taken_back(double dt_last, EnergyBalance& energy) const;
  // Collective. Gives momentum, and angular momentum about its centre, to each grain. The grain and its condensed bonds
  // take it up at once, in the free directions of the grain. Accelerations are then those of this impulse, until
  // distribute(). Returns the energy that grains of this rank gain, and prescribed ones take.
  double apply_impulse(MPI_Comm comm, const std::vector<Six>& momentum, CondensedPack& condensed);
  // Find what is spread over the n sub-steps of the next step. start_spreading() is for the start of a run,
  // spread_loads() for the end of a step. In a single one all loads act, and nothing is spread.
  void start_spreading(int n);
  void spread_loads(int n);
  // Collective. Applies the load of the host that is not spread (the load so far and what came late in the last step)
  // for n sub-steps at once. Finds the forces of this impulse on nodes and grains, and adds its accelerations to those
  // of the grains.
  void share_impulses(MPI_Comm comm, Bonds& bonds, int n, CondensedPack& condensed);
  // Sets the loads that are shown after a step of n sub-steps: all loads of host and cement.
  void show_loads(int n);
  // Collective. Finds the part of the reaction that comes from added mass which followed jumps, or whose nodes changed
  // velocity by transfer. Books its work. react() does this, and adds that part to the grains.
  void react_to_jumps(double dt, EnergyBalance& energy);
  void expect_sudden_forces() { sudden_forces_are_due_ = true; }

  // Collective. Jumps of the owned sides exchange momentum between nodes and grains at once, for the added mass of
  // bodies from first_row on. The change of velocity of nodes is left in their acceleration. Grains change their
  // velocity. Books the work on bodies before end_of_work.
  void exchange_momentum(MPI_Comm comm, Bonds& bonds, const std::vector<Six>& jump, int first_row, bool at_start, int end_of_work,
                         EnergyBalance& energy);
  // Books what the loads of the last step do over the half step ahead at velocities that commands changed. Call after
  // read_commanded_velocities().
  void count_commands(double dt_last, EnergyBalance& energy) const;
  // Collective. Takes up what commands did to velocities since the last step, as found by find_commands(): added mass
  // follows the grains.
  void read_commanded_velocities(MPI_Comm comm, Bonds& bonds, double dt, double dt_last, EnergyBalance& energy);
  // Collective. Leaves in the jumps of the sides what commands did to velocities of free grains. Returns false if they
  // did nothing.
  bool find_commands(MPI_Comm comm, CondensedPack& condensed);
  // Collective. Gives the added mass of new bodies the velocity of its grains. Grains that were not seen before have
  // velocities of a full step.
  void start_added_mass(MPI_Comm comm, Bonds& bonds, int first_row, bool any_added_mass, EnergyBalance& energy);
  // Takes grains that were not seen before back to the middle of the step before, like the nodes of new bodies.
  void go_back_half_a_step(const Bonds& bonds, double dt_last);

  // Work on the cement of bodies from first_row on, in a step. Work of jumps and transfers is not in it, since it has
  // been counted.
  EnergyBalance::StepWork work(double dt_last, int first_row) const;
  // Work of the loads of all condensed bonds, in a step.
  EnergyBalance::StepWork work_of(const CondensedPack& condensed, double dt_last) const;

  // The first jump of a prescribed velocity in this run on this rank that is above a limit and no small part of the
  // velocity.
  struct Jump {
    int tag = 0;  // 0: none
    double size = 0.0;
    long step = 0;
  };
  void watch_jumps(double limit);  // starts a new watch
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
  std::size_t slot_of(int tag) const;  // place in `grains`, or their number if the grain is not on this rank
  // Collective. Finds sides of bonds, and returns those that this rank owns.
  std::vector<OwnedEnd> find_ends(MPI_Comm comm, const Bonds& bonds, bool all, BondEnds& found) const;
  void hand_out(const Bonds& bonds, const std::vector<OwnedEnd>& owned, BondEnds& to) const;
  void watch_jump(const Grain& g);

  std::vector<OwnedEnd> owned_;
  GrainAccelerations accelerations_, impulses_;
  bool summed_ = false;  // true: bonds are summed already
  std::vector<GrainAccelerations::Vector6> load_;
  std::vector<Six> kept_loads_, taken_loads_,
      sudden_loads_;  // loads of each grain: of the host, of the cement, of jumps and transfers in this step
  bool taken_back_ = false;
  bool changed_ = true, any_free_ = false, fresh_ = false, sudden_forces_are_due_ = false;
  double jump_limit_ = 0.0;  // largest jump of a velocity that is not noted
  long step_ = 0;            // number of the step
  Jump worst_jump_;
  Start fastest_start_;
};

}  // namespace mpdem

#endif
