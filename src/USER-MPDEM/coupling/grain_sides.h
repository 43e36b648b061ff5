// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The two sides of every body: the grain there, its motion as seen by the links, and the
// force and moment of the bond on it. A side is held by the rank that owns the grain and
// by every rank with links to it; the owner hands out the motion, the forces of all are
// added up, so a grain may live on any rank.
#ifndef MPDEM_GRAIN_SIDES_H
#define MPDEM_GRAIN_SIDES_H

#include <vector>

#include "../material/tensor3.h"
#include "../mpm/body.h"
#include "../parallel/halo_sum.h"

namespace mpdem {

struct GrainSide {
  int body, side;
  int tag;
  // motion, lengths from the body's origin
  double x[3], v[3], omega[3];
  double a[3], alpha[3];  // rates of v and omega where they are prescribed, else zero
  double frequency2;      // bound of the square of its frequency on all its links, the cement held; 0 if prescribed
  Mat3<double> R;  // body frame of the grain to global
  // bond force and moment about the grain's centre, on the grain
  double force[3], torque[3];
};

class GrainSides {
 public:
  std::vector<GrainSide> sides;  // ascending in body, side

  // Collective. needed: (body, side) with links here; owned: (body, side) whose grain is
  // an atom of this rank. Both ascending, each once.
  void build(MPI_Comm comm, const std::vector<Body>& bodies, const std::vector<Key>& needed,
             const std::vector<Key>& owned);

  int find(int body, int side) const;

  // Motion of a grain this rank owns; x unwrapped and global, q the unit quaternion.
  struct Motion {
    double x[3], v[3], omega[3], q[4], a[3] = {0, 0, 0}, alpha[3] = {0, 0, 0}, frequency2 = 0;
  };

  // Collective. motion[i] belongs to owned key i.
  void distribute(const std::vector<Body>& bodies, const std::vector<Motion>& motion);

  void clear_forces();
  // Collective. Sums force and torque over the holders.
  void sum_forces();

  // Sides whose grain is owned by no rank, after distribute(): the grain is gone.
  int orphan() const { return orphan_; }

 private:
  std::vector<int> owned_at_;
  std::vector<double> buffer_;
  HaloSum halo_;
  int orphan_ = -1;
};

Mat3<double> rotation_of(const double* q);

}  // namespace mpdem

#endif
