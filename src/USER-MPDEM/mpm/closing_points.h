// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Unilateral damage: points of one bond that failed are stiff again while their crack is closed. n0 is the unit normal
// of the crack in the reference, and F = 1 + grad u the deformation. The width of the crack, its energy and its stress
// are
//
//   lambda = 1/|F^-T n0|        the distance of two planes of the material across n0, over that of the reference
//   p      = K min(<lambda_0 - lambda>, 0.1)     K = n.C0:(n n).n, the stiffness of the undamaged material along n
//   w      = V int p d(-lambda),  tau = -V p lambda n n^T,  n = lambda F^-T n0
//
// The stress derives from w, which is a function of F alone. So a closed cycle yields no energy. Slip along the crack
// gives no stress, and the bond may turn. n0 is the normal of the crack when the point failed (crack_of()). A
// crack that opened closes at its width in the reference. A crack that was narrower when its point failed is closed
// below that width. A crack that was under pressure keeps its pressure:
//
//   lambda_0 = min(1, lambda_f) + <-tau_nn>/(K lambda_f)        lambda_f, tau_nn: width, and stress n.tau n, when the point failed
//
// With a friction mu > 0 a closed crack bears shear too. It sticks with the softest shear modulus G of the undamaged material, and
// slides where that would be more than mu p:
//
//   gamma  = n0 - lambda^2 C^-1 n0, C = F^T F    motion of its sides along the crack, over the width, in the reference
//   e      = gamma - gamma_f - s                 gamma_f: gamma when the point failed
//   g      = G (I - n n) F^-T e                  shear per area of the reference
//   |g| <= mu p; else s moves along e until it is so. An open crack has e = 0
//   w_e    = V G |e|^2/2,  tau_e = V lambda (n g^T + g n^T)
//
// The slip s is kept by the points (PointStore::slip). That of an open crack is not kept up: when the crack closes, s is what leaves
// e = 0 at the beginning of the step. tau_e is the slope of w_e, since the rate of gamma has the part 2 lambda D n of the plane. In a
// step friction takes V G (e + e')/2 . ds, with e and e' at its ends. So the books of central differences close.
//
// So a point that fails never becomes stronger, and w is at most the energy that it had (Cauchy's inequality with K >=
// n.C(D):(n n).n). Failed points keep deformation, strain and state, and lambda_0 is found from these. A point that a
// file gave as failed without damage stays without force. The operator K n n n n is at most C0. Pressure on a distorted
// point has a stiffness of its own, of up to 1.5 p |F^-1|^2. So pressure ends at a tenth of K, and a point is debris for
// good once |F| or |F^-1| exceeds kMostDistorted. Then the bound of the largest eigenvalue stays
// (mpm/largest_eigenvalue.h). This needs total kinematics, where displacements start at the reference.
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
  // Takes all points that failed in earlier steps. undamaged: must stay. friction: mu; 0 or less: closed cracks slide freely.
  ClosingPoints(const PointStore& points, const VtiElasticity& undamaged, double friction);
  // Adds the points of these slots, which ascend and failed in this step.
  void add(const PointStore& points, const VtiElasticity& undamaged, const std::vector<int>& failed);

  void points_failed(const BondAtWork& b, const std::vector<int>& slots, const std::vector<int>& links, Losses& losses) override;
  void add_force(const BondAtWork& b, Losses& losses) override;
  void add_energy(const PointStore& points, const Grid& grid, const BondEnd* ends, double& of_points, double& of_coupling) const override;

  // Energies that a step takes. Points that are too distorted since this step become debris, BlockMeta::debris. `released`
  // has the energy that they had in excess of what their force did in the first half of the step. `rubbed` is the
  // energy that friction took.
  // Adds the forces to the nodes. Must be called before tied nodes hand on their forces. The nodes moved by dt times
  // their velocity to where they are. With dt = 0 nothing slips.
  Losses add_force(PointStore& points, Grid& grid, double dt);
  double energy(const PointStore& points, const Grid& grid) const;
  // Energy that the closed points among these slots (ascending) had when their force began. The step of dt in which
  // they failed ends now. A force that begins within a step acts with its new value over half of the motion of that
  // step. So the result is the present energy less what it gained over that half.
  double energy_at_beginning(const PointStore& points, const Grid& grid, const std::vector<int>& failed, double dt) const;
  bool empty() const { return blocks_.empty(); }
  std::size_t memory_usage() const override { return blocks_.capacity() * sizeof(Block); }

 private:
  struct Block {
    int block;
    vd n0[3], K, lambda_0;  // K is zero in lanes that hold
    vd gamma_f[3];
    std::uint8_t fresh;  // lanes that failed in this step
    bool stuck;          // may a crack of the block have borne shear a step ago
  };
  struct Crack {
    vmask sound, closed;          // lanes that are not too distorted; of these, lanes whose crack is closed
    vd overlap, lambda;           // overlap: lambda_0 - lambda where it is closed, else 0
    vd across[3], back[3];        // F^-T n0, F^-1 F^-T n0
    Mat3<vd> inverse_transposed;  // F^-T
  };
  // Shear of a crack: e, and g/G.
  struct Shear {
    vd e[3], traction[3];
  };
  static Crack crack_of_block(const Block& b, const Mat3<vd>& F);
  // Calls f(block, weights, crack, F) for each block with a lane that is closed, not sound, or may have borne shear.
  template <class Blocks, class F>
  static void for_each_block(Blocks& blocks, const PointStore& points, const Grid& grid, F f);
  static vd pressure(const Block& b, const Crack& c);
  // The shear of the lanes that bear it. Nothing without friction.
  Shear shear_of(const PointStore& points, const Block& b, const Crack& c, vmask bear) const;
  // Energy and stress of the pressure and of the shear.
  vd energy_of(const PointStore& points, const Block& b, const Crack& c) const;
  Mat3<vd> weighted_piola(const PointStore& points, const Block& b, const Crack& c, const Shear& shear) const;
  // Moves the slip, and has the shear after it. before: the crack at the beginning of the step. Returns the energy that friction takes.
  double slide(PointStore& points, const Block& b, const Crack& before, const Crack& now, Shear& shear) const;
  // Makes debris of lanes, and returns the energy that they release. rate: the velocity gradient of the step.
  double lose(PointStore& points, Block& b, const Crack& before, const Mat3<vd>& rate, vmask lost, double dt) const;
  // Takes the points of one block that failed. fresh: those of them that failed in this step.
  void set(const PointStore& points, const VtiElasticity& undamaged, int block, std::uint8_t failed, std::uint8_t fresh);
  const VtiElasticity* undamaged_ = nullptr;
  double friction_ = 0.0, G_ = 0.0;
  std::vector<Block> blocks_;  // ascending in block
};

}  // namespace mpdem

#endif
