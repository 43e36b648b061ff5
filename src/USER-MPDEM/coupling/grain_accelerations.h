// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Accelerations of free grains whose links have added mass. The added mass c of a node is the inertia of its velocity
// relative to the grain. The kinetic energy of nodes u and grains R is
//
//   m u'^2/2 + c (u' - P R')^2/2 + R'.M R'/2,   P R' = V + Omega x r
//
// With N = m + c a node has N u'' = f + c P R''. Elimination of the nodes gives for the grains
//
//   (M + sum P^T c (1 - c/N) P) R'' = F + sum P^T (c/N) f.
//
// A node with links to both grains, c = c0 + c1, couples these by -P0^T (c0 c1/N) P1. The mass matrix is symmetric and
// positive definite, so energy is kept, and the bound of the time step is rigorous (added_mass.h). The matrix of each
// grain, 6 by 6, is solved directly. The coupling between grains is solved by block Jacobi with Chebyshev acceleration
// (Golub & Varga, Numer. Math. 3 (1961) 147). The number of sweeps follows from a bound of the spectral radius,
//   2 R0.B R1 <= R0.W0 R0 + R1.W1 R1,
// with W the matrix of c0 c1/N about each grain. The links keep momentum for any result of the iteration.
//
// Prescribed components of the motion of a grain are not unknowns. Positions are from the origin of the bond. Force and
// torque are about the centre of the grain. The equations of a grain are in the axes of the box.
#ifndef MPDEM_COUPLING_GRAIN_ACCELERATIONS_H
#define MPDEM_COUPLING_GRAIN_ACCELERATIONS_H

#include <mpi.h>

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "../mpm/grid.h"
#include "../numerics/sym6.h"
#include "added_mass.h"
#include "condensed_pack.h"
#include "grain.h"
#include "bond_ends.h"

namespace mpdem {

// A mass distribution about a grain's centre: its sum, first and second moments.
struct MassMoments {
  static constexpr int kSize = 10;
  std::array<double, kSize> m{};  // sum, x, y, z, xx, yy, zz, yz, xz, xy

  // Adds a mass at r to the moments m. T is double, or vd with one mass a lane.
  template <class T>
  static void add(T mass, const T* r, T* m);
  Eigen::Matrix<double, 6, 6> matrix() const;  // sum of P^T P
  // Sum of P^T Q, where Q is P about another centre. e: vector from that centre to this one.
  Eigen::Matrix<double, 6, 6> coupling(const double* e) const;
};

// Moments of mass that moves with both grains of a bond: `own` about one grain, and `shared`, which couples it to the
// other grain.
struct EndMoments {
  MassMoments own, shared;
};

class GrainAccelerations {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  struct OfBond {
    const AddedMass* added;
    const Grid* grid;
    int end_0;  // index of its end 0 in BondEnds::ends
  };

  // Adds bonds one by one before find(). A bond can be added as soon as the forces on its nodes are complete, while its
  // data are in the cache. find() then takes the other bonds.
  void begin(const BondEnds& ends) {
    sum_.assign(kWidth * ends.ends.size(), 0.0);
    begun_ = true;
  }
  void add(const OfBond& bond, const BondEnds& ends);

  // Collective. Writes accelerations to the grains, where prescribed ones stay, and to a and alpha of the ends. Forces
  // on nodes must be complete, and the ends of this rank must have the forces of its links. load: on each grain,
  // without that of links and of condensed bonds. fresh: the added mass or the condensed bonds changed since the last
  // call.
  void find(MPI_Comm comm, const std::vector<OfBond>& bonds, std::vector<Grain>& grains, const std::vector<Vector6>& load, BondEnds& ends,
            bool fresh, CondensedPack& condensed);

  // Collective. Finds the accelerations due to a load on the grains alone. `mass` has the moments of each end on this
  // rank. The mass of condensed bonds is added. The ends must have no forces, and the grains no accelerations.
  void find_impulse(MPI_Comm comm, const std::vector<EndMoments>& mass, std::vector<Grain>& grains, const std::vector<Vector6>& load,
                    BondEnds& ends, CondensedPack& condensed);

  int sweeps() const { return sweeps_; }
  // True if some call ended before its precision, at the limit of sweeps. This happens if links of both grains share
  // nodes and grains are far lighter than the mass that these links add.
  bool imprecise() const { return imprecise_; }

 private:
  // Numbers of an end that are summed over ranks: force and moment, moments of c (1 - c/N), and moments of c0 c1/N.
  static constexpr int kWidth = 6 + 2 * MassMoments::kSize, kPadded = (kWidth + kLanes - 1) / kLanes * kLanes;
  // Eight grains, one per lane. D: matrix of the free components. free: 1 or 0. given: prescribed acceleration, or 0. now,
  // before: the last two iterates.
  struct Unknowns {
    vd D[kSym6], inverse[kSym6];
    vd load[6], given[6], free[6], now[6], before[6];
  };
  struct Coupling {
    int grain, other;  // index of the grain, and index of the other end of the bond
    Matrix6 B;         // maps accelerations of the other end, in its axes, to loads in the axes of the box
  };
  void solve(MPI_Comm comm, std::vector<Grain>& grains, const std::vector<Vector6>& load, BondEnds& ends, bool fresh,
             CondensedPack& condensed, bool loads_of_condensed);
  double set_up(const std::vector<Grain>& grains, const std::vector<Vector6>& load, const BondEnds& ends, bool fresh,
                const CondensedPack& condensed, bool loads_of_condensed);
  void sweep(double omega, bool first, const BondEnds& ends, CondensedPack& condensed);

  std::vector<double> sum_;  // kWidth numbers per end
  bool begun_ = false;
  std::vector<Unknowns> unknowns_;
  std::vector<Coupling> couplings_;
  std::vector<double> of_grains_, from_others_;  // six numbers each
  std::vector<std::array<double, 6>> found_;     // acceleration of the grain of each owned end
  int sweeps_ = 1;
  double radius_ = 0;
  bool imprecise_ = false;
};

}  // namespace mpdem

#endif
