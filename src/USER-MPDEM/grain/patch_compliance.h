// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Compliance of an elastic sphere between the modes of a patch of its surface: B = Phi' C Phi, where C maps tractions to
// displacements (elastic_sphere.h) and Phi has the modes of surface_modes.h, orthonormal over the area of the patch. What
// modes leave out counts as soft springs in series with the links, of compliance
//
//   c = lambda_min(B)/2,
//
// so that C is replaced by Phi (B - c 1) Phi' + c 1. Modes with the residual compliance of what they leave out: MacNeal,
// Computers and Structures 1 (1971) 581; Rubin, AIAA Journal 13 (1975) 995.
#ifndef MPDEM_GRAIN_PATCH_COMPLIANCE_H
#define MPDEM_GRAIN_PATCH_COMPLIANCE_H

#include <Eigen/Dense>
#include <memory>

#include "elastic_sphere.h"
#include "surface_modes.h"

namespace mpdem {

// B for R/mu = 1 and modes that are orthonormal on the unit sphere.
Eigen::MatrixXd compliance_of_modes(const SurfaceModes& modes, double nu);

class PatchCompliance {
 public:
  // radius: of the sphere. Modes are scaled to the area of its surface.
  PatchCompliance(const SurfaceModes& modes, const GrainElasticity& grain, double radius);

  const SurfaceModes& modes() const { return modes_; }
  double tail() const { return tail_; }                      // c, length over pressure
  const Eigen::MatrixXd& factor() const { return factor_; }  // L with L L' = B - c 1
  // Phi'G: amplitudes of the modes for unit motions of the patch as a rigid body, translations and rotations about the centre, in
  // its axes.
  const Eigen::Matrix<double, Eigen::Dynamic, 6>& rigid() const { return rigid_; }
  // Motion for unit force and moment about the centre of the patch as a rigid body.
  Eigen::Matrix<double, 6, 6> of_rigid_patch() const;
  double scale_of_modes() const { return 1.0 / radius_; }  // of the values of the modes

  // The same object for equal patches of this process while one of them is in use.
  static std::shared_ptr<const PatchCompliance> of(double inner, double outer, int degree, int orders, const GrainElasticity& grain,
                                                   double radius);

 private:
  void find_rigid();
  SurfaceModes modes_;
  double radius_, tail_ = 0.0;
  Eigen::MatrixXd factor_;
  Eigen::Matrix<double, Eigen::Dynamic, 6> rigid_;
};

}  // namespace mpdem

#endif
