// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "total.h"

namespace mpdem {

// Nothing happens before the nodes of a bond drift. After its points, the forces of links and mechanisms follow.
void Total::advance() {
  pass([](Bond&) {}, [this](Bond& b) { forces_.add_forces(b); });
}

void Total::find_internal_force() {
  for (Bond& b : scene_.bonds().resolved()) {
    b.grid.clear_force();
    add_internal_force(b.points, b.grid, *scene_.law);
  }
}

// Counts the energy that added mass releases, with velocities that are ahead by `later` times the acceleration.
void Total::renew_added_mass(double later) {
  if (scene_.penalty) scene_.energy.release_by([&] { return added_.energy_ahead(scene_.all_rows(), later); }, [&] { added_.refresh(); });
}

std::unique_ptr<Kinematics> make_total(const KinematicsContext& context) { return std::make_unique<Total>(context); }

}  // namespace mpdem
