// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "far_field.h"

#include <cmath>
#include <vector>

#include "polar_rule.h"

namespace mpdem {

namespace {

constexpr int kHighest = 24;  // degree

using Loads = Eigen::Matrix<double, Eigen::Dynamic, 6>;

}  // namespace

FarField::FarField(double inner, double outer, const Eigen::Matrix3d& axes) {
  // The rule integrates harmonics of the highest degree on the patch.
  const int across = 6 + static_cast<int>(std::ceil(0.5 * kHighest * (outer - inner)));
  const int around = 10 + static_cast<int>(std::ceil(kHighest * std::sin(std::min(outer, 0.5 * M_PI))));
  const PolarRule rule = polar_rule(inner, outer, across);
  const Eigen::Index points = static_cast<Eigen::Index>(across) * around;
  // Any axes serve for the harmonics. In these no point of a patch on an axis of the grain is a pole.
  const Eigen::Matrix3d to_polar = Eigen::AngleAxisd(1.0, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  std::vector<double> angle, longitude;
  Loads normal(points, 6), south(points, 6), east(points, 6);  // components of G, then those of the loads times the weights
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::VectorXd weight(points);
  for (int i = 0; i < across; ++i)
    for (int j = 0; j < around; ++j) {
      const Eigen::Index k = static_cast<Eigen::Index>(i) * around + j;
      const double a = rule.angle[i], phi = 2.0 * M_PI * (j + 0.5) / around;
      const Eigen::Vector3d n = axes * Eigen::Vector3d(std::sin(a) * std::cos(phi), std::sin(a) * std::sin(phi), std::cos(a));
      const Eigen::Vector3d p = to_polar * n;
      angle.push_back(std::acos(p[2]));
      longitude.push_back(std::atan2(p[1], p[0]));
      const double c = std::cos(angle.back()), s = std::sin(angle.back()), cl = std::cos(longitude.back()), sl = std::sin(longitude.back());
      Eigen::Matrix<double, 3, 6> G;
      for (int d = 0; d < 3; ++d) {
        G.col(d) = axes.col(d);
        G.col(3 + d) = axes.col(d).cross(n);
      }
      weight[k] = rule.weight[i] * 2.0 * M_PI / around;
      A += weight[k] * G.transpose() * G;
      const Eigen::Matrix<double, 3, 6> polar = to_polar * G;
      normal.row(k) = p.transpose() * polar;
      south.row(k) = Eigen::RowVector3d(c * cl, c * sl, -s) * polar;
      east.row(k) = Eigen::RowVector3d(-sl, cl, 0.0) * polar;
    }
  const Eigen::Matrix<double, 6, 6> inverse = A.inverse();
  for (Loads* of : {&normal, &south, &east}) *of = weight.asDiagonal() * (*of * inverse);
  const Eigen::Index harmonics = (kHighest + 1) * (kHighest + 1);
  radial_.resize(harmonics, 6);
  spheroidal_.setZero(harmonics, 6);
  toroidal_.setZero(harmonics, 6);
  Eigen::VectorXd Y(points), by_angle(points), by_longitude(points);
  for (int m = 0; m <= kHighest; ++m)
    for (LegendreFunctions P(m, angle); P.degree() <= kHighest; P.next())
      for (int sine = 0; sine <= (m > 0 ? 1 : 0); ++sine) {
        for (Eigen::Index k = 0; k < points; ++k) {
          const std::size_t i = static_cast<std::size_t>(k);
          const double cm = std::cos(m * longitude[i]), sm = std::sin(m * longitude[i]);
          Y[k] = P.value()[i] * (sine ? sm : cm);
          by_angle[k] = P.slope()[i] * (sine ? sm : cm);
          by_longitude[k] = m * P.value()[i] / std::sin(angle[i]) * (sine ? cm : -sm);
        }
        const int l = P.degree();
        const Eigen::Index at = static_cast<Eigen::Index>(l) * l + (m == 0 ? 0 : 2 * m - 1 + sine);
        radial_.row(at) = Y.transpose() * normal;
        if (l == 0) continue;
        spheroidal_.row(at) = (by_angle.transpose() * south + by_longitude.transpose() * east) / (l * (l + 1.0));
        toroidal_.row(at) = (by_angle.transpose() * east - by_longitude.transpose() * south) / (l * (l + 1.0));
      }
}

FarField::Matrix6 FarField::moved_by(const FarField& other, const GrainElasticity& grain, double radius) const {
  Matrix6 c = Matrix6::Zero();
  for (int l = 0; l <= kHighest; ++l) {
    const SphereResponse a = sphere_response(l, grain.nu);
    const double twice = l * (l + 1.0);
    const Eigen::Index first = static_cast<Eigen::Index>(l) * l, count = 2 * l + 1;
    const auto of = [&](const Loads& all) { return all.middleRows(first, count); };
    c += of(radial_).transpose() * (a.rr * of(other.radial_) + a.rs * of(other.spheroidal_));
    c += twice * of(spheroidal_).transpose() * (a.sr * of(other.radial_) + a.ss * of(other.spheroidal_));
    c += twice * a.tt * of(toroidal_).transpose() * of(other.toroidal_);
  }
  // From the unit sphere of unit shear modulus: moments are forces times the radius, displacements rotations times it.
  Eigen::Matrix<double, 6, 1> scale;
  scale << 1.0, 1.0, 1.0, 1.0 / radius, 1.0 / radius, 1.0 / radius;
  return scale.asDiagonal() * c * scale.asDiagonal() / (grain.shear_modulus() * radius);
}

}  // namespace mpdem
