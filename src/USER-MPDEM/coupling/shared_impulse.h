// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Impulses on grains that their cement shares. With sub-steps the load of the host acts on a grain only once in several
// sub-steps. It would excite vibrations of the cement, and some of its modes would be in resonance. So such an impulse
// moves grains and cement together. With the change of acceleration A_g of the grains a node has
//
//   a = (1 - s) P_0 A_0 + s P_1 A_1,   P_g the rigid motion of grain g at the node, s as in relative_damping.h,
//
// due to the force m a, and c (a - P_g A_g) for its added mass c of grain g. The reaction to the first acts on the
// grains by the same shares, and that to the second on grain g, each at the position of the node. So momentum and
// angular momentum are kept. The mass of the node is then part of the mass matrix of the grains, as that of a condensed
// bond is (grain_accelerations.h). Fragments follow no grain. The share of m and c that belongs to failed points does
// not follow either: no stress would hold such points back, and they would gain speed with each step.
//
// If the cement moves with the grains by these shares, the work of the impulse on nodes equals the work of the reaction
// on the grains. Otherwise it does not. So the energy balance counts the work on the nodes.
#ifndef MPDEM_COUPLING_SHARED_IMPULSE_H
#define MPDEM_COUPLING_SHARED_IMPULSE_H

#include <vector>

#include "../mpm/bond_mechanism.h"
#include "../mpm/grid.h"
#include "../mpm/point_store.h"
#include "added_mass.h"
#include "grain_accelerations.h"
#include "bond_ends.h"

namespace mpdem {

// Shared impulse of one bond. `ends` points to end 0 of the bond. End 1 follows it.
class SharedImpulse : public BondMechanism {
 public:
  // Must be called before the first impulse.
  void follow_grains(const Grid& grid, const BondRecord& record, const std::vector<char>& connected) override;
  void points_failed(const BondContext&, const std::vector<int>&, const std::vector<int>&, Losses&) override { stale_ = true; }
  // Forgets the last impulse, which acts only at the end of its step.
  void add_force(const BondContext&, Losses&) override { force_.clear(); }
  // Finds the nodal mass of the intact points of this rank. Call it before an impulse. The caller sums intact_mass()
  // over the ranks that share nodes.
  void find_intact_mass(const PointStore& points, const Grid& grid, const CementDensity& density);
  std::vector<double>& intact_mass() { return intact_mass_; }

  // Adds the moments of the mass m of the nodes that this rank counts: `own` with m (1-s)^2 for grain 0 and m s^2 for
  // grain 1, and `shared` with m s (1-s).
  void add_moments(const Grid& grid, const BondEnd* ends, EndMoments* of_ends) const;
  // Reads the change of acceleration of the grains from the ends. Adds the forces to nodes after their sum over ranks,
  // and the reaction to grains before their sum over ranks.
  void apply_impulse(Grid& grid, BondEnd* ends, const AddedMass& added);
  // Power of the last impulse, at the nodes that this rank counts.
  double load_power(const Grid& grid, const std::vector<double>& velocity) const override;
  std::size_t memory_usage() const override {
    return (share_.capacity() + intact_mass_.capacity() + here_.capacity() + force_.capacity()) * sizeof(double);
  }

 private:
  double intact_share(const Grid& grid, int node) const;

  std::vector<double> share_;               // share s of grain 1; below 0: no grain
  std::vector<double> intact_mass_, here_;  // nodal mass of intact points, on all ranks and on this rank; empty: the mass of the nodes
  std::vector<double> force_;               // forces of the last impulse on the nodes
  bool stale_ = true;
};

}  // namespace mpdem

#endif
