// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Axis of elasticity of crystals that grow out of the grains (`axis radial`): the normal of the nearer of two spheres.
// The normals of both spheres differ where a point is equally near to both, the more the further it is from the line of
// centres. A choice of one of them there would depend on rounding and break every symmetry of a pair. So the axis
// rotates from the one to the other in a layer one spacing thick:
//
//   w = S(1/2 + (d1 - d0)/spacing),  S(t) = t^2 (3 - 2t) between 0 and 1,  axis = w n0 - (1 - w) n1,
//
// Here d are the distances and n the outward normals. S has no kink at its ends. The axis is a line, so n0 and -n1,
// which both point from the first sphere to the second, have the same sense. Their sum is zero only if n0 = n1 and d0 =
// d1, which needs one sphere inside the other.
#ifndef MPDEM_GEOMETRY_RADIAL_AXIS_H
#define MPDEM_GEOMETRY_RADIAL_AXIS_H

#include <algorithm>

#include "shape.h"

namespace mpdem {

// Unit vector of either sense. Swapping the spheres may reverse it. centre, radius: of both spheres.
inline Vector3 radial_axis(const Vector3& X, const Vector3* centre, const double* radius, double spacing) {
  Vector3 normal[2];
  double distance[2];
  for (int s = 0; s < 2; ++s) {
    normal[s] = X - centre[s];
    distance[s] = normal[s].norm() - radius[s];
    normal[s].normalize();
  }
  const double t = std::clamp(0.5 + (distance[1] - distance[0]) / spacing, 0.0, 1.0);
  if (t == 1.0) return normal[0];
  if (t == 0.0) return normal[1];
  const double w = t * t * (3.0 - 2.0 * t);
  return (w * normal[0] - (1.0 - w) * normal[1]).normalized();
}

}  // namespace mpdem

#endif
