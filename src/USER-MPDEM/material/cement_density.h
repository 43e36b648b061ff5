// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Density of the cement of a scene. A material may have a density of its own (Law::density()); the others have that of
// the scene, with which their points were made. Mass per volume, times the factor on the inertia.
#ifndef MPDEM_MATERIAL_CEMENT_DENSITY_H
#define MPDEM_MATERIAL_CEMENT_DENSITY_H

#include "law.h"

namespace mpdem {

struct CementDensity {
  double of_scene;           // of materials without a density of their own, times `scale`
  double scale = 1.0;        // factor on the inertia, of `quasistatic` of fix mpm
  const Law* law = nullptr;  // of material 0, which has those of the others; null: no material has a density of its own

  // A number is the density of all cement.
  CementDensity(double density, double factor = 1.0, const Law* laws = nullptr) : of_scene(density), scale(factor), law(laws) {}

  // Density of its own of a material, without `scale`; 0: none.
  double own(int material) const { return law && law->materials() > 1 ? law->of_material(material).density() : 0.0; }
  double of(int material) const {
    const double density = own(material);
    return density > 0.0 ? scale * density : of_scene;
  }
};

// A volume of cement. own_volume, own_mass: volume and mass of its share with densities of their own.
struct CementVolume {
  double volume = 0.0, own_volume = 0.0, own_mass = 0.0;

  // own: density of its own of this cement; 0: none.
  void add(double more, double own) {
    volume += more;
    if (own > 0.0) own_volume += more, own_mass += own * more;
  }
  double mass(const CementDensity& density) const { return density.of_scene * (volume - own_volume) + density.scale * own_mass; }
};

}  // namespace mpdem

#endif
