// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Rigid motion of a grain at a position, and the load on the grain of a force there. r is the vector from the centre of
// the grain to the position. T is a number, or the numbers of eight positions, one per lane.
#ifndef MPDEM_COUPLING_RIGID_MOTION_H
#define MPDEM_COUPLING_RIGID_MOTION_H

#include "../mpm/grid.h"
#include "../numerics/simd.h"
#include "bond_ends.h"

namespace mpdem {

inline void lever_arm(const Grid& grid, int node, const BondEnd& s, double* r) {
  for (int d = 0; d < 3; ++d) r[d] = grid.keys[node].at(d) * grid.h + grid.displacement[3 * node + d] - s.x[d];
}

// Velocity, acceleration or jump of velocity at r. linear, angular: that of the centre, and that of the rotation.
template <class T>
void rigid_at(const double* linear, const double* angular, const T* r, T* at) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    at[d] = linear[d] + angular[e] * r[g] - angular[g] * r[e];
  }
}
template <class T>
void velocity_at(const BondEnd& s, const T* r, T* v) {
  rigid_at(s.v, s.omega, r, v);
}
template <class T>
void acceleration_at(const BondEnd& s, const T* r, T* a) {
  rigid_at(s.a, s.alpha, r, a);
}
template <class T>
void jump_at(const BondEnd& s, const T* r, T* v) {
  rigid_at(s.jump, s.jump + 3, r, v);
}

// Adds the force scale * f at r to force and moment of a grain.
inline void add_to_grain(const double* r, const double* f, double scale, double* force, double* torque) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    force[d] += scale * f[d];
    torque[d] += scale * (r[e] * f[g] - r[g] * f[e]);
  }
}
inline void add_to_grain(const double* r, const double* f, double scale, BondEnd& s) { add_to_grain(r, f, scale, s.force, s.torque); }

inline void subtract_from_grain(const vd* r, const vd* f, BondEnd& s) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    s.force[d] -= sum_lanes(f[d]);
    s.torque[d] -= sum_lanes(r[e] * f[g] - r[g] * f[e]);
  }
}

}  // namespace mpdem

#endif
