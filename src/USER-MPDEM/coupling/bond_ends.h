// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The two ends of every bond. An end has the motion of its grain as the links see it, and the force and moment of the
// bond on that grain. The rank that owns the grain has a copy of the end, and so has every rank with links to it. The
// owner sends the motion to all of them, and their forces are summed. So a grain may be on any rank. An end is in the
// axes of its bond. Arguments and results of the functions are in the axes of the box.
#ifndef MPDEM_COUPLING_BOND_ENDS_H
#define MPDEM_COUPLING_BOND_ENDS_H

#include <array>
#include <vector>

#include "../mpm/bond_record.h"
#include "../numerics/rotation.h"
#include "../parallel/halo_sum.h"

namespace mpdem {

struct BondEnd {
  int row, side;
  int tag;
  Mat3<double> axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // axes of the bond: the rotation of its vectors to the axes of the box
  // Motion of the grain. Positions are from the origin of the bond.
  double x[3], v[3], omega[3];
  double a[3], alpha[3];  // rates of v and omega; the expected ones of distribute() until set_accelerations()
  double jump[6];         // change of v and omega in the last step that a and alpha did not predict
  double mass_ratio;      // inertia of the cement over that of the grain, see AddedMass; 0 if the grain is prescribed
  Mat3<double> R;         // rotation from axes fixed in the grain
  // Force and moment of the bond on the grain, about its centre.
  double force[3], torque[3];
  double impulse[6];  // the share of force and torque that comes from shared impulses, see shared_impulse.h
  // Force and moment of added mass whose nodes change their velocity at once, by jumps of grains and by transfers.
  double jump_force[6], transfer_force[6];
};

// Translation and rotation, or force and moment, of an end in the axes of the box.
inline std::array<double, 6> in_box(const BondEnd& s, const double* first, const double* second) {
  const std::array<double, 3> a = turned(s.axes, first), b = turned(s.axes, second);
  return {a[0], a[1], a[2], b[0], b[1], b[2]};
}

class BondEnds {
 public:
  std::vector<BondEnd> ends;  // ascending in row, side

  // Collective. here: bonds of which this rank has nodes. owned: (bond, side) whose grain is an atom of this rank, each
  // once. Both are ascending. Both ends of a bond in either list are on this rank, in sequence.
  void build(MPI_Comm comm, const std::vector<BondRecord>& records, const std::vector<int>& here, const std::vector<Key>& owned);

  int find(int row, int side) const;

  // Motion of a grain that this rank owns. x is unwrapped and global, q the unit quaternion of the orientation.
  struct Motion {
    double x[3], v[3], omega[3], q[4], a[3] = {0, 0, 0}, alpha[3] = {0, 0, 0}, mass_ratio = 0, jump[6] = {0, 0, 0, 0, 0, 0};
  };

  // Collective. Sends the motion to all copies of the ends. motion[i] belongs to owned key i.
  void distribute(const std::vector<BondRecord>& records, const std::vector<Motion>& motion);

  // Collective. Sends a and alpha to all copies. acceleration[i] belongs to owned key i.
  void set_accelerations(const std::vector<std::array<double, 6>>& acceleration);
  // Collective. Sends jumps to all copies. jump[i] belongs to owned key i.
  void set_jumps(const std::vector<std::array<double, 6>>& jump);

  void clear_forces();
  void clear_sudden_forces();
  // Collective. Sums force and torque over the copies.
  void sum_forces();
  void sum_sudden_forces();  // sums the forces of jumps and transfers over the copies; collective
  // Collective. Sums values over the copies of each end, `width` numbers per end.
  void sum(double* values, int width) { halo_.sum(values, width); }
  // Index in `ends` of each owned key.
  const std::vector<int>& owned() const { return owned_at_; }

  // Index of an end whose grain should exist but is owned by no rank; -1 if there is none. Known after distribute().
  int orphan() const { return orphan_; }

 private:
  void send_to_copies(const std::vector<std::array<double, 6>>& values);  // writes the values of the owners to the buffers of all copies

  std::vector<int> owned_at_;
  std::vector<double> buffer_;
  HaloSum halo_;
  int orphan_ = -1;
};

}  // namespace mpdem

#endif
