// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Accelerations of free grains whose links have added mass. The added mass c of a node is the inertia of its velocity
// relative to the grain. The kinetic energy of nodes u and grains R is
//
//   m u'^2/2 + c (u' - P R')^2/2 + R'.M R'/2,   P R' = V + Omega x r
//
// With N = m + c a node has N u'' = f + c P R''. Without the nodes the grains have
//
//   (M + sum P^T c (1 - c/N) P) R'' = F + sum P^T (c/N) f.
//
// A node with links to both grains, c = c0 + c1, couples these by -P0^T (c0 c1/N) P1. The mass matrix is symmetric
// and positive definite, so energy is kept, and the bound of the time step is rigorous (added_mass.h). The matrix of
// each grain, 6 by 6, is solved directly. The coupling between grains is solved by Chebyshev's acceleration of block
// Jacobi (Golub & Varga, Numer. Math. 3 (1961) 147). The number of sweeps follows from a bound of the spectral
// radius,
//   2 R0.B R1 <= R0.W0 R0 + R1.W1 R1,
// with W the matrix of c0 c1/N about either grain. Whatever accelerations come out, the links take from grains what
// they give to nodes.
//
// Prescribed components of the motion of a grain are not unknowns. Lengths are from the body's origin, force and
// torque about the centre of the grain. A grain is solved for in the axes of the box.
#ifndef MPDEM_GRAIN_ACCELERATIONS_H
#define MPDEM_GRAIN_ACCELERATIONS_H

#include <mpi.h>

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "../mpm/grid.h"
#include "../numerics/sym6.h"
#include "added_mass.h"
#include "condensed_pack.h"
#include "grain.h"
#include "grain_sides.h"

namespace mpdem {

// A mass distribution about a grain's centre: its sum, first and second moments.
struct MassMoments {
  static constexpr int kSize = 10;
  std::array<double, kSize> m{};  // sum, x, y, z, xx, yy, zz, yz, xz, xy

  // Of double, or of eight side by side.
  template <class T>
  static void add(T mass, const T* r, T* m);
  Eigen::Matrix<double, 6, 6> matrix() const;  // sum of P^T P
  // Sum of P^T Q. Q is P of another centre, from which places are farther by the vector e.
  Eigen::Matrix<double, 6, 6> coupling(const double* e) const;
};

// Of mass that goes with both grains of a bond: about one, and that which couples it to the other.
struct SideMoments {
  MassMoments own, shared;
};

class GrainAccelerations {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  // The added mass of one bond.
  struct OfBond {
    const AddedMass* added;
    const Grid* grid;
    int side;  // place of its first side
  };

  // Bonds may be added up one by one before find(), each when the forces on its nodes are complete and its memory is at hand. find() is given
  // the others then.
  void begin(const GrainSides& sides) {
    sum_.assign(kWidth * sides.sides.size(), 0.0);
    begun_ = true;
  }
  void add(const OfBond& bond, const GrainSides& sides);

  // Collective. Writes accelerations to the grains, where those that are given stay, and into a and alpha of the sides. Forces on nodes must be
  // complete, and forces of links be with the sides of this rank. load: that on each grain, without that of the links and of
  // condensed bonds. fresh: the added mass or what is condensed changed since the last call.
  void find(MPI_Comm comm, const std::vector<OfBond>& bonds, std::vector<Grain>& grains, const std::vector<Vector6>& load,
            GrainSides& sides, bool fresh, CondensedPack* condensed = nullptr);

  // Collective. What a load on the grains alone accelerates, with this mass, for each side on this rank, and that of condensed bonds. The sides
  // must have no forces, and the grains no accelerations.
  void find_impulse(MPI_Comm comm, const std::vector<SideMoments>& mass, std::vector<Grain>& grains, const std::vector<Vector6>& load,
                    GrainSides& sides, CondensedPack* condensed);

  int sweeps() const { return sweeps_; }

 private:
  // Ranks add these numbers of a side up: force and moment, moments of c (1 - c/N), and of c0 c1/N.
  static constexpr int kWidth = 6 + 2 * MassMoments::kSize, kPadded = (kWidth + kLanes - 1) / kLanes * kLanes;
  // Eight grains side by side.
  struct Unknowns {
    vd D[kSym6], inverse[kSym6];  // the matrix of what is free
    vd load[6], given[6], free[6], now[6], before[6];  // free: 1 or 0
  };
  struct Coupling {
    int grain, other;  // into the grains and the sides
    Matrix6 B;  // from accelerations of the other side, in its axes, to loads in those of the box
  };
  void solve(MPI_Comm comm, std::vector<Grain>& grains, const std::vector<Vector6>& load, GrainSides& sides, bool fresh, CondensedPack* condensed,
             bool loads_of_condensed);
  double set_up(const std::vector<Grain>& grains, const std::vector<Vector6>& load, const GrainSides& sides, bool fresh, const CondensedPack* condensed,
                bool loads_of_condensed);
  void sweep(double omega, bool first, const GrainSides& sides, CondensedPack* condensed);

  std::vector<double> sum_;
  bool begun_ = false;
  std::vector<Unknowns> unknowns_;
  std::vector<Coupling> couplings_;
  std::vector<double> of_grains_, from_others_;  // six numbers each
  std::vector<std::array<double, 6>> found_;
  int sweeps_ = 1;
  double radius_ = 0;
};

}  // namespace mpdem

#endif
