// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "body.h"

#include <limits>

#include "checked_numbers.h"

namespace mpdem {

std::string trouble_of(const Body& b) {
  constexpr double kLargest = CheckedNumbers::kLargest, kSmallest = CheckedNumbers::kSmallest;
  CheckedNumbers in(nullptr);
  const auto finite = [&in](const char* name, const auto& values) {
    for (double v : values) in.check(name, v, -kLargest, kLargest);
  };
  if (!(b.grain[0] > 0 && b.grain[1] > b.grain[0]))
    in.tell("the IDs of its grains are " + std::to_string(b.grain[0]) + " and " + std::to_string(b.grain[1]) + ", allowed are positive ones in this order");
  finite("its origin", b.origin);
  for (int s = 0; s < 2; ++s) {
    in.check("the radius of a grain", b.radius[s], kSmallest, kLargest);
    finite("the centre of a grain", b.centre[s]);
    in.check_quaternion("the orientation of a grain", b.orientation[s]);
    finite("the shift of a grain", b.shift[s]);
    // Patches of point files are flat and may add up to a little more than the sphere.
    in.check("an attached area", b.attached_area[s], 0.0, 1.1 * 4.0 * M_PI * b.radius[s] * b.radius[s]);
  }
  for (double v : b.box) in.check("the period of the box", v, 0.0, kLargest);
  in.check_integer("the rule of its axis", b.axis[0], 0.0, kAxisRules);
  for (int d = 1; d < 4; ++d) in.check("the direction of its axis", b.axis[d], -kLargest, kLargest);
  in.check_integer("'is in motion'", b.in_motion, 0.0, 1.0);
  in.check("its volume", b.volume, kSmallest, kLargest);
  // As many cells as int can number across the grains.
  const double widest = 2.0 * (b.radius[0] + b.radius[1]);
  in.check("its spacing", b.spacing, 1e-8 * widest, widest);
  for (double v : b.lattice) in.check("the corner of its lattice", v, -1e3 * widest, 1e3 * widest);
  in.check_integer("'is regular'", b.regular, 0.0, 1.0);
  in.check("its thickness", b.thickness, 0.0, widest);
  in.check_integer("its number of points", b.points, 1.0, std::numeric_limits<int>::max());
  return in.trouble();
}

}  // namespace mpdem
