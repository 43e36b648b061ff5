// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// How a patch of an elastic sphere moves under loads on another patch. Only resultants count, since patches are apart
// (principle of Saint-Venant): the six loads of a patch are tractions linear in position,
//
//   t = G A^-1 F,   G = (1, -[r]),   A = integral of G'G over the patch,   F = (force, moment about the centre),
//
// and its motion is the mean w = A^-1 (integral of G'u). Their compliance is c = A_b^-1 (integral of G_b' u_a), by vector
// spherical harmonics (elastic_sphere.h) up to degree 24, with those of the response to balanced loads.
#ifndef MPDEM_GRAIN_FAR_FIELD_H
#define MPDEM_GRAIN_FAR_FIELD_H

#include <Eigen/Dense>

#include "elastic_sphere.h"

namespace mpdem {

class FarField {
 public:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  // Angles of the patch from its pole; axes of the patch by columns, z to the pole, in axes fixed in the grain.
  FarField(double inner, double outer, const Eigen::Matrix3d& axes);

  // Mean motion of this patch, translation and rotation, for unit loads on the other one, in the axes of each patch. The
  // matrix is the transpose of that of the other patch by this one.
  Matrix6 moved_by(const FarField& other, const GrainElasticity& grain, double radius) const;

 private:
  // Of the loads on the unit sphere: t_r, t_s, t_t of each harmonic, in order of their degree.
  Eigen::Matrix<double, Eigen::Dynamic, 6> radial_, spheroidal_, toroidal_;
};

}  // namespace mpdem

#endif
