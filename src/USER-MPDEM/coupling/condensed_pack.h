// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The condensed bonds of a rank in a step: those of the grains that it owns, and those of which it has points. Eight
// bonds lie side by side, one per lane. One pass over them finds all loads and masses. The equations are in
// condensed_bond.h.
//
// Grains have slots here: the grains that this rank owns, and the other grains of its bonds, whose owners send their
// motion. Every owner of a grain has all its condensed bonds. So it finds their loads itself, in the same order on any
// number of ranks.
//
// Models are in the axes of their bonds, and Q rotates these to the box. Loads and masses are in the axes of the box.
//
// A load on a grain is the sum over all its condensed bonds, force and moment about its centre. Loads due to
// accelerations are
//
//   -(sum M_ss) a - sum M_st a_t,   a_t: of the other grain of a bond; M: for motions of the centres, in the axes of the box.
#ifndef MPDEM_COUPLING_CONDENSED_PACK_H
#define MPDEM_COUPLING_CONDENSED_PACK_H

#include <mpi.h>

#include <array>
#include <vector>

#include "../numerics/simd.h"
#include "../numerics/sym6.h"
#include "../parallel/halo_sum.h"
#include "condensed_bond.h"
#include "grain.h"

namespace mpdem {

class CondensedPack {
 public:
  struct Entry {
    const CondensedModel* model;
    const BondRecord* record;
    const double* bound;  // bounds of the root of the driving force for each of the six motions, see mpm/field_drive.h
  };
  // Collective. grains: those that this rank owns, ascending in tag.
  void build(MPI_Comm comm, const std::vector<Entry>& entries, const std::vector<Grain>& grains);
  // empty(): this rank has no condensed bonds. any(): some rank has one. A pack without any has no loads and no mass,
  // and needs no build().
  bool empty() const { return blocks_.empty(); }
  bool any() const { return any_; }

  // Collective. Sends the motion of the grains to all ranks with a slot for them. Accelerations are the expected ones.
  void distribute(const std::vector<Grain>& grains);
  // Collective. Send six numbers of each owned grain to all its slots.
  void set_accelerations(const double* of_owned);
  void set_jumps(const double* of_owned);

  // Finds the loads that do not depend on accelerations, the masses, and the level() of each bond. gravity acts on
  // their mass.
  void find_loads(const double* gravity);
  // Finds the loads due to jumps of velocity, as forces over the step dt.
  void find_jump_loads(double dt);
  void find_inertial_loads();

  // Component d of the loads on an owned grain.
  double load(int grain, int d) const { return of_owned(load_, 6, grain, d); }
  double jump_load(int grain, int d) const { return of_owned(jump_load_, 6, grain, d); }
  double inertial_load(int grain, int d) const { return of_owned(inertial_load_, 6, grain, d); }
  double weight(int grain, int d) const { return of_owned(weight_, 6, grain, d); }
  // mass() has the lower triangle of the sum of M_ss of an owned grain. inertial_coupling() is the largest
  // CondensedModel::inertial_coupling of all bonds.
  double mass(int grain, int k) const { return of_owned(mass_, kSym6, grain, k); }
  double inertial_coupling() const { return inertial_coupling_; }
  // Subtracts sum M_st a_t from the six numbers of each owned grain.
  void subtract_coupling(double* of_owned);
  bool at_rest() const;  // true if no grain here has an acceleration

  // Calls f(member, tension) with the mean force of each bond along the line of centres, positive in tension, once all
  // loads are known. member: index in the list of build().
  template <class F>
  void each_tension(F f) const {
    for (std::size_t n = 0; n < blocks_.size(); ++n) {
      const vd tension = tension_of(blocks_[n]);
      for (int lane = 0; lane < blocks_[n].count; ++lane) f(kLanes * n + lane, tension[lane]);
    }
  }
  // Component j of the relative motion d of a bond.
  double relative(int member, int j) const { return blocks_[member / kLanes].d[j][member % kLanes]; }
  // Upper bound of the root of the driving force over its threshold.
  double level(int member) const { return blocks_[member / kLanes].level[member % kLanes]; }
  bool any_level_reaches(double level) const;
  std::array<BondEnd, 2> ends(int member, const BondRecord& record) const;
  int orphan() const;  // tag of a grain that no rank owns; 0 if there is none

  std::size_t memory_usage() const;

 private:
  // Triangles are lower ones, by rows. N: the last six rows of that of the model, for xx, yy, zz, yz, xz, xy. The other six
  // follow from the moments of the mass about the middle, first and second. tension: that without accelerations. lag: what
  // each acceleration subtracts from it.
  struct Block {
    int slot[2][kLanes], count;
    vd inverse_orientation[2][4];  // inverse of the orientations at the creation
    vd arm[2][3], shift[3];        // arm: from centres to the middle; shift: between the coordinates of both grains
    vd K[kSym6], M[78], N[36], first[3], second[6];
    vd bound[6], d[6], level;
    vd C[36];  // M_01 in the axes of the box, by rows
    vd tension, lag[2][6];
  };
  static void fill(Block& b, int lane, const Entry& entry);
  void find_loads(Block& b, const double* gravity);
  void find_masses(Block& b, const RelativeMotion<vd>& m, const Three<vd>& along);
  void find_weight(Block& b, const RelativeMotion<vd>& m, const double* gravity, const Three<vd>& along);
  vd tension_of(const Block& b) const;
  void add_loads(const Block& b, const RelativeMotion<vd>& m, const vd* generalized, std::vector<double>& to) const;
  void subtract_coupling_loads(const std::vector<double>& rates, std::vector<double>& loads) const;  // loads -= sum M_st rates_t
  void send_to_slots(double* values, int width);  // sends values of owners to all slots; all other values must be 0
  // Number i of an owned grain; 0 if there are none.
  double of_owned(const std::vector<double>& values, int width, int grain, int i) const {
    return values.empty() ? 0.0 : values[width * slot_of_owned_[grain] + i];
  }

  static constexpr int kMotion = 24;  // present (1 if some rank owns the grain), x, q, omega, v, a, jump, mass_ratio
  enum { kX = 1, kQ = 4, kOmega = 8, kV = 11, kA = 14, kJump = 17, kRatio = 23 };
  std::vector<Block> blocks_;
  std::vector<int> tags_, slot_of_owned_;  // tags_: of slots, ascending
  std::vector<char> owned_;
  HaloSum halo_;
  std::vector<double> motion_, acceleration_, work_, load_, jump_load_, inertial_load_, weight_, mass_;  // of slots; work_: work array
  double inertial_coupling_ = 0.0;
  bool any_ = false;
};

}  // namespace mpdem

#endif
