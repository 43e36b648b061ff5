// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mechanisms.h"

#include "../../coupling/crack_faces.h"
#include "../../coupling/debonded_contact.h"
#include "../../coupling/relative_damping.h"
#include "../../coupling/shared_impulse.h"
#include "../../mpm/closing_points.h"
#include "../../mpm/consistent_mass.h"

namespace mpdem {

Bond::Mechanisms mechanisms_of(const Scene& scene, const Bond& b, const NodeSplitting& splits) {
  const CementOptions& o = scene.options;
  const double friction = scene.friction();
  const BondRecord& record = scene.bonds().record(b);
  Bond::Mechanisms mechanisms;
  if (scene.touches_in(b)) mechanisms.push_back(std::make_unique<DebondedContact>(b.points, record, *scene.penalty, b.grid));
  if (o.unilateral) mechanisms.push_back(std::make_unique<ClosingPoints>(b.points, scene.law->elasticity(), friction));
  if (scene.penalty && o.relative_damping > 0.0)
    mechanisms.push_back(std::make_unique<RelativeDamping>(record, o.relative_damping, scene.shear_speed()));
  if (scene.faces_touch() && scene.touches_in(b))
    mechanisms.push_back(std::make_unique<CrackFaces>(
        b.points, b.grid, [&](const Key& k) { return splits.at_start(k); }, friction));
  if (scene.penalty && o.subcycle != 1) mechanisms.push_back(std::make_unique<SharedImpulse>());
  if (o.mass_order > 1) mechanisms.push_back(std::make_unique<ConsistentMass>());
  return mechanisms;
}

}  // namespace mpdem
