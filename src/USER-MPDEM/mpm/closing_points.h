// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Unilateral damage: failed points of a bond regain stiffness while their crack is closed. n0 is the unit normal of the
// crack in the reference configuration, and F = 1 + grad u the deformation gradient. The width of the crack, its energy
// and its stress are
//
//   lambda = 1/|F^-T n0|        the distance of two planes of the material across n0, over that of the reference
//   p      = K min(<lambda_0 - lambda>, 0.1)     K = n.C0:(n n).n, the stiffness of the undamaged material along n
//   w      = V int p d(-lambda),  tau = -V p lambda n n^T,  n = lambda F^-T n0
//
// The stress derives from w, which is a function of F alone. So a closed cycle yields no energy. Slip along the crack
// gives no stress, and the bond may rotate. n0 is the normal of the crack when the point failed (crack_of()). A crack
// that opened closes at its width in the reference. A crack that was narrower when its point failed is closed below
// that width. A crack that was under pressure keeps its pressure:
//
//   lambda_0 = min(1, lambda_f) + <-tau_nn>/(K lambda_f)        lambda_f, tau_nn: width, and stress n.tau n, at failure
//
// With a friction coefficient mu > 0 a closed crack carries shear too. It sticks with the smallest shear modulus G of
// the undamaged material, and slides where the traction would exceed mu p:
//
//   gamma  = n0 - lambda^2 C^-1 n0, C = F^T F    sliding of the crack faces over the width, in the reference
//   e      = gamma - gamma_f - s                 gamma_f: gamma at failure; s: slip
//   g      = G (I - n n) F^-T e                  shear traction per area of the reference
//   |g| <= mu p; else s grows along e until equality holds. An open crack has e = 0
//   w_e    = V G |e|^2/2,  tau_e = V lambda (n g^T + g n^T)
//
// The points store the slip s (PointStore::slip). That of an open crack is not updated: when the crack closes, s is set
// such that e = 0 at the beginning of the step. tau_e is the derivative of w_e, since F times the rate of gamma is the
// projection of 2 lambda D n onto the plane of the crack. In a step friction takes V G (e + e')/2 . ds, with e and e'
// at the beginning and the end. So the energy balance of central differences closes.
//
// A point that fails never becomes stronger, and w is at most the energy that it had (Cauchy's inequality with K >=
// n.C(D):(n n).n). Failed points keep deformation, strain and state, from which lambda_0 is found. A point that a file
// gave as failed without damage never exerts a force. The operator K n n n n is at most C0. Pressure on a distorted
// point has a geometric stiffness of up to 1.5 p |F^-1|^2. So p is at most a tenth of K, and a point loses its crack
// for good (BlockMeta::distorted) once |F| or |F^-1| exceeds kMostDistorted. Then the bound of the largest eigenvalue
// stays valid (mpm/largest_eigenvalue.h). This needs `total` kinematics, where displacements start at the reference.
#ifndef MPDEM_MPM_CLOSING_POINTS_H
#define MPDEM_MPM_CLOSING_POINTS_H

#include <vector>

#include "../material/vti_elasticity.h"
#include "bond_mechanism.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

class ClosingPoints : public BondMechanism {
 public:
  ClosingPoints() = default;
  // Takes all points that failed in earlier steps. undamaged: must outlive this object. friction: mu, or 0 for none.
  ClosingPoints(const PointStore& points, const VtiElasticity& undamaged, double friction);
  // Adds the points of these slots (ascending), which failed in this step.
  void add(const PointStore& points, const VtiElasticity& undamaged, const std::vector<int>& failed);

  void points_failed(const BondContext& b, const std::vector<int>& slots, const std::vector<int>& links, Losses& losses) override;
  void add_force(const BondContext& b, Losses& losses) override;
  void add_energy(const PointStore& points, const Grid& grid, const BondEnd* ends, double& of_points, double& of_coupling) const override;

  // Adds the forces to the nodes, whose last displacement is dt times their velocity. With dt = 0 nothing slips. Must
  // be called before constrained nodes pass on their forces. Points that became too distorted in this step lose their
  // crack (BlockMeta::distorted). Returns as `released` the energy that these had, less the work of their force in the
  // first half of the step, and as `frictional` the energy that friction took.
  Losses add_force(PointStore& points, Grid& grid, double dt);
  double energy(const PointStore& points, const Grid& grid) const;
  // Energy that the closed points among these slots (ascending) had when their force set in. They failed in the step of
  // dt that ends now. A force that sets in during a step acts with its new value over half of the motion of that step.
  // So the result is the present energy less its gain over that half.
  double energy_at_beginning(const PointStore& points, const Grid& grid, const std::vector<int>& failed, double dt) const;
  bool empty() const { return blocks_.empty(); }
  std::size_t memory_usage() const override { return blocks_.capacity() * sizeof(Block); }

 private:
  struct Block {
    int block;              // index in PointStore::blocks
    vd n0[3], K, lambda_0;  // K is zero in lanes without a crack
    vd gamma_f[3];
    std::uint8_t fresh;  // lanes that failed in this step
    bool carried_shear;  // a crack of the block may have carried shear in the last step
  };
  struct Crack {
    vmask undistorted, closed;    // lanes that are not too distorted; those of them whose crack is closed
    vd overlap, lambda;           // overlap: lambda_0 - lambda where it is closed, else 0
    vd across[3], back[3];        // F^-T n0 and C^-1 n0 = F^-1 F^-T n0
    Mat3<vd> inverse_transposed;  // F^-T
  };
  // Shear of a crack: e, and traction = g/G.
  struct Shear {
    vd e[3], traction[3];
  };
  static Crack crack_of_block(const Block& b, const Mat3<vd>& F);
  // Calls f(block, weights, crack, F) for each block with a lane that is closed, too distorted, or may have carried shear.
  template <class Blocks, class F>
  static void for_each_block(Blocks& blocks, const PointStore& points, const Grid& grid, F f);
  static vd pressure(const Block& b, const Crack& c);
  // Shear of the lanes `bear`, zero in the others and without friction.
  Shear shear_of(const PointStore& points, const Block& b, const Crack& c, vmask bear) const;
  // Energy of pressure and shear, and their stress as in weighted_piola() of point_stress.h.
  vd energy_of(const PointStore& points, const Block& b, const Crack& c) const;
  Mat3<vd> weighted_piola(const PointStore& points, const Block& b, const Crack& c, const Shear& shear) const;
  // Updates slip and shear and returns the energy that friction takes. before: the crack at the beginning of the step.
  double slide(PointStore& points, const Block& b, const Crack& before, const Crack& now, Shear& shear) const;
  // Removes the cracks of the lanes `lost` and returns the energy released. rate: velocity gradient of the step.
  double lose(PointStore& points, Block& b, const Crack& before, const Mat3<vd>& rate, vmask lost, double dt) const;
  // Adds the failed points of one block. fresh: those of them that failed in this step.
  void set(const PointStore& points, const VtiElasticity& undamaged, int block, std::uint8_t failed, std::uint8_t fresh);
  const VtiElasticity* undamaged_ = nullptr;
  double friction_ = 0.0, G_ = 0.0;
  std::vector<Block> blocks_;  // ascending in block
};

}  // namespace mpdem

#endif
