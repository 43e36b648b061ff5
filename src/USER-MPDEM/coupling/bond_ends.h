// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The two sides of every body. A side has its grain, the motion of the grain as the links see it, and the force and
// moment of the bond on it. The rank that owns the grain holds the side, and so does every rank with links to it. The
// owner hands out the motion, and the forces of all holders are summed. So a grain may live on any rank. A side is in
// the axes of its body. Arguments and results of the functions are in the axes of the box.
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
  Mat3<double> axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // axes of the body: the rotation of its vectors to the axes of the box
  // Motion of the grain. Lengths are from the origin of the body.
  double x[3], v[3], omega[3];
  double a[3], alpha[3];  // rates of v and omega; expected ones of distribute() until set_accelerations()
  double jump[6];         // change of v and omega in the last step that a and alpha did not predict
  double mass_ratio;      // see AddedMass; 0 if prescribed
  Mat3<double> R;         // rotation from axes fixed in the grain
  // Force and moment of the bond on the grain, about its centre.
  double force[3], torque[3];
  double impulse[6];  // part of force and torque that is of shared impulses, see shared_impulse.h
  // Force and moment of added mass whose nodes change their velocity at once: by jumps of grains, and by transfers.
  double jump_force[6], transfer_force[6];
};

// Translation and rotation, or force and moment, of a side in the axes of the box.
inline std::array<double, 6> in_box(const BondEnd& s, const double* first, const double* second) {
  const std::array<double, 3> a = turned(s.axes, first), b = turned(s.axes, second);
  return {a[0], a[1], a[2], b[0], b[1], b[2]};
}

class BondEnds {
 public:
  std::vector<BondEnd> ends;  // ascending in body, side

  // Collective. here: bodies of which this rank has nodes. owned: (body, side) whose grain is an atom of this rank,
  // each once. Both are ascending. Both sides of a body in either list are on this rank, in sequence.
  void build(MPI_Comm comm, const std::vector<BondRecord>& records, const std::vector<int>& here, const std::vector<Key>& owned);

  int find(int row, int side) const;

  // Motion of a grain that this rank owns. x is unwrapped and global, q the unit quaternion of the orientation.
  struct Motion {
    double x[3], v[3], omega[3], q[4], a[3] = {0, 0, 0}, alpha[3] = {0, 0, 0}, mass_ratio = 0, jump[6] = {0, 0, 0, 0, 0, 0};
  };

  // Hands out the motion. motion[i] belongs to owned key i. Collective.
  void distribute(const std::vector<BondRecord>& records, const std::vector<Motion>& motion);

  // Hands out a and alpha. acceleration[i] belongs to owned key i. Collective.
  void set_accelerations(const std::vector<std::array<double, 6>>& acceleration);
  // Hands out jumps. jump[i] belongs to owned key i. Collective.
  void set_jumps(const std::vector<std::array<double, 6>>& jump);

  void clear_forces();
  void clear_sudden_forces();
  // Sums force and torque over the holders. Collective.
  void sum_forces();
  void sum_sudden_forces();  // sums the forces of jumps and transfers over the holders; collective
  // Sums values over the holders of each side, `width` numbers a side. Collective.
  void sum(double* values, int width) { halo_.sum(values, width); }
  // Place in `sides` of each owned key.
  const std::vector<int>& owned() const { return owned_at_; }

  // Place of a side whose grain no rank owns though it is to be there; -1 if there is none. Known after distribute().
  int orphan() const { return orphan_; }

 private:
  void hand_out(const std::vector<std::array<double, 6>>& values);  // writes the values of the owners to the buffer of all holders

  std::vector<int> owned_at_;
  std::vector<double> buffer_;
  HaloSum halo_;
  int orphan_ = -1;
};

}  // namespace mpdem

#endif
