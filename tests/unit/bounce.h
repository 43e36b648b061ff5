// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A node flies at a spring that acts at x < 0 alone, and comes back. It moves by central differences whose step is 1.
#ifndef MPDEM_TESTS_BOUNCE_H
#define MPDEM_TESTS_BOUNCE_H

namespace mpdem::test {

// Energy of the node after the bounce over that before. It is the mean over the places at which the node may be a step before it
// reaches the spring. rate(x): stiffness over mass.
template <class Random, class Rate>
double energy_after_bounce(Random random, Rate rate) {
  constexpr int kBounces = 5000;
  double mean = 0.0;
  for (int n = 0; n < kBounces; ++n) {
    double x = random.uniform(0.0, 1.0), v = -1.0;
    do {
      if (x < 0.0) v -= rate(x) * x;
      x += v;
    } while (x <= 0.0 || v < 0.0);
    mean += v * v / kBounces;
  }
  return mean;
}

}  // namespace mpdem::test

#endif
