// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mechanisms.h"

#include "../coupling/freed_places.h"
#include "../coupling/relaxation.h"
#include "../coupling/shared_impulse.h"
#include "../mpm/closing_points.h"
#include "../mpm/consistent_mass.h"
#include "crack_faces.h"

namespace mpdem {

Bond::Parts parts_of(const Scene& scene, const Bond& b, const Splits& splits) {
  const CementOptions& o = scene.options;
  const double friction = scene.friction();
  const Body& body = scene.bonds().body(b);
  Bond::Parts parts;
  if (scene.touches()) parts.push_back(std::make_unique<FreedPlaces>(b.points, body, *scene.penalty, b.grid));
  if (o.unilateral) parts.push_back(std::make_unique<ClosingPoints>(b.points, scene.law->elasticity(), friction));
  if (scene.penalty && o.relax > 0.0) parts.push_back(std::make_unique<Relaxation>(body, o.relax, scene.shear_speed()));
  if (scene.faces_touch()) parts.push_back(std::make_unique<CrackFaces>(b.points, b.grid, splits, friction));
  if (scene.penalty && o.subcycle != 1) parts.push_back(std::make_unique<SharedImpulse>());
  if (o.mass_order > 1) parts.push_back(std::make_unique<ConsistentMass>());
  return parts;
}

}  // namespace mpdem
