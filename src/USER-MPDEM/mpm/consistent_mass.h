// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Consistent mass M of the points, M_IJ = sum_p m_p N_I N_J. Its row sums are the lumped mass M_L of the nodes. M is
// never formed: one product is one gather and one scatter over the points.
//
// Nodes are accelerated with the first k terms, k = `mass_order`, of the series
//   M^-1 = sum over j of (1 - M_L^-1 M)^j M_L^-1.
// This is the FMPM(k) of J. A. Nairn and C. C. Hammerquist (Comput. Methods Appl. Mech. Eng. 377 (2021) 113667).
// The eigenvalues of M_L^-1 M lie in [0, 1]. So the truncated inverse is symmetric and positive definite and at most k
// times that of the lumped mass. The largest eigenvalue of the step is thus at most k times that of M_L^-1 K.
//
// A constrained node has the mean value of its mass receivers, which carry its mass (extension_constraints.h). So the
// row sums of M stay M_L, and momentum is conserved. The inertial force leaves out failed points, which have
// lumped mass alone: split nodes distribute the mass of failed points otherwise (fracture/phantom_nodes.h).
#ifndef MPDEM_MPM_CONSISTENT_MASS_H
#define MPDEM_MPM_CONSISTENT_MASS_H

#include <vector>

#include "bond_mechanism.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

enum class MassOf { all_points, unfailed_points };

// out += scale M field for the points of this rank, three numbers a node. Constrained nodes pass theirs on to their mass receivers.
void add_consistent_mass(const PointStore& points, const Grid& grid, const CementDensity& density, MassOf which, double scale,
                         const std::vector<double>& field, std::vector<double>& out);

// Inertial force (M_L - M) a of one bond. Caches the row sums of M until points fail.
class ConsistentMass : public BondMechanism {
 public:
  void points_failed(const BondContext&, const std::vector<int>&, const std::vector<int>&, Losses&) override { row_sums_.clear(); }
  // Sets Grid::inertial_force to (M_L - M) a with the acceleration a of the nodes. M and M_L are those of unfailed
  // points of this rank.
  void find_inertial_force(const PointStore& points, Grid& grid, const CementDensity& density);
  std::size_t memory_usage() const override { return row_sums_.capacity() * sizeof(double); }

 private:
  std::vector<double> row_sums_;  // one number per node
};

}  // namespace mpdem

#endif
