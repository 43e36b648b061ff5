// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Power of the present forces. `stored` is that with the stored velocities, which are half a step old. `growth` is its
// rate as the accelerations change the velocities. Units: energy per time, and energy per time squared.
#ifndef MPDEM_MPM_POWER_H
#define MPDEM_MPM_POWER_H

namespace mpdem {

struct Power {
  double stored = 0.0, growth = 0.0;
  double after(double time) const { return stored + time * growth; }
  void add(double force, double velocity, double acceleration) {
    stored += force * velocity;
    growth += force * acceleration;
  }
  void add(const Power& other) {
    stored += other.stored;
    growth += other.growth;
  }
};

}  // namespace mpdem

#endif
