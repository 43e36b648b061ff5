// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Unilateral damage: points of one bond that failed are stiff again while their crack is closed. With the unit normal n0 of the crack in the
// reference and the deformation F = 1 + grad u, the crack is as wide as
//
//   lambda = 1/|F^-T n0|        the distance of two planes of the material across n0, over that of the reference
//   w      = V K <lambda_0 - lambda>^2/2     K = n.C0:(n n).n, the stiffness of the undamaged material along n
//   tau    = V K (lambda - lambda_0) lambda n n^T,  n = lambda F^-T n0        where lambda < lambda_0, else zero
//
// It derives from w, which is a function of F alone: no energy comes of a closed cycle. It does not feel slip along the crack, and the bond
// may turn. n0 is that of the largest damage when the point failed (crack_of()). A crack that opened closes at its width in the reference. One
// that was narrower when its point failed is closed from there on, and one that was pressed goes on with the pressure that it had:
//
//   lambda_0 = min(1, lambda_f) + <-tau_nn>/(K lambda_f)        lambda_f, tau_nn: width, and stress n.tau n, when the point failed
//
// So a point that fails never becomes stronger, and w is at most the energy that it had (Cauchy's inequality with K >= n.C(D):(n n).n). Failed
// points keep deformation, strain and state, from which lambda_0 is found. A point that a file gave as failed without damage stays without
// force. The operator K n n n n is at most C0, so the bound of the largest eigenvalue stays (mpm/largest_eigenvalue.h).
// Total kinematics alone: displacements are those from the reference.
#ifndef MPDEM_CLOSING_POINTS_H
#define MPDEM_CLOSING_POINTS_H

#include <vector>

#include "../material/vti_elasticity.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

class ClosingPoints {
 public:
  ClosingPoints() = default;
  // Of all points that failed.
  ClosingPoints(const PointStore& points, const VtiElasticity& undamaged);
  // And of these slots, ascending.
  void add(const PointStore& points, const VtiElasticity& undamaged, const std::vector<int>& failed);

  // Adds to the forces of nodes before tied ones hand theirs on.
  void add_force(const PointStore& points, Grid& grid) const;
  double energy(const PointStore& points, const Grid& grid) const;
  // What those of these slots stored when their force began, in the step of dt that ends here: a force that begins within a step works with its
  // value after on half of the way of that step.
  double energy_at_beginning(const PointStore& points, const Grid& grid, const std::vector<int>& failed, double dt) const;
  bool empty() const { return blocks_.empty(); }
  std::size_t memory_usage() const { return blocks_.capacity() * sizeof(Block); }

 private:
  struct Block {
    int block;
    vd n0[3], K, lambda_0;  // K is zero in lanes that hold
  };
  // f(block, weights, lambda - lambda_0 where the crack is closed, else 0; lambda, F^-T n0, F^-1 F^-T n0).
  template <class F>
  void for_each_closed(const PointStore& points, const Grid& grid, F f) const;
  static Mat3<vd> weighted_piola(const PointStore& points, const Block& b, vd width, vd lambda, const vd* across, const vd* back);
  void set(const PointStore& points, const VtiElasticity& undamaged, int slot);
  std::vector<Block> blocks_;  // ascending in block
};

}  // namespace mpdem

#endif
