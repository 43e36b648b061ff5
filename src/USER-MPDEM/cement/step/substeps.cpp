// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Multiple time stepping. The host moves its grains with a long step. The cement, and the free grains bonded to it,
// take n short ones in it, all by the same central difference. The load of the host is known at the ends of its step.
// Its average acts in each sub-step (spread_loads.cpp). The rest acts at the ends, as an impulse of the whole step.
// This is the integrator of Tuckerman, Berne and Martyna (doc/theory.md): the stability of the cement depends on its
// own step alone, momentum is exact, and n = 1 gives the plain step. The impulse moves grains and cement together, see
// coupling/shared_impulse.h.
//
// Let w be the velocity of a grain of mass M in a sub-step dt, and v that at the end of a step of the host. F is the load of
// the host at this time, f that of the cement. The grain has the constant load S of the host in the sub-steps of the step
// before this time, and S' in those of the step after it; spread_loads.cpp finds both. The impulse of
// u = (1 - 1/n) (S + S')/2 has acted within these steps, so only F - u acts at this time. Then
//
//   start of the step    w = v + dt/2 (n (F - u) + f)/M
//   within it            w <- w + dt (S + f)/M
//   end of the step      v = w + dt/2 (n (F - u) + f)/M = w + n dt/2 (F - u + f/n)/M, by the host with its step n dt
#include <cmath>

#include "substeps.h"

namespace mpdem {

namespace {
double inertia_of(const Grain& g, int d) { return d < 3 ? g.mass : g.inertia; }
}  // namespace

double Substeps::HermitePath::position(int d, double time, double t) const {
  return from[d] + length[d] * t * t * (3.0 - 2.0 * t) + time * t * (1.0 - t) * (start[d] * (1.0 - t) - end[d] * t);
}

double Substeps::HermitePath::velocity(int d, double time, double t) const {
  return 6.0 * length[d] / time * t * (1.0 - t) + start[d] * (1.0 - t) * (1.0 - 3.0 * t) + end[d] * t * (3.0 * t - 2.0);
}

void Substeps::begin() {
  const int n = scene_.now.substeps;
  if (n == 1) return;
  for (Grain& g : scene_.grains.grains)
    for (int d = 0; d < 6; ++d) {
      g.start[d] = g.velocity[d];
      // The kick is n (F - u) + f. F is the load of the host alone: Grain::force has the load of the cement, too, without the
      // part that came as an impulse in other sub-steps.
      g.kick[d] = n * (g.force[d] + g.load_of_other_substeps[d] - g.cement_load[d] - g.spread_part(d, n)) + g.cement_load[d];
    }
}

// Positions and velocities of prescribed motion are known at both ends of the step. The path between is a cubic (Hermite),
// so that the velocity is continuous. Where the velocities do not fit the displacement, as when a grain starts suddenly, the
// motion is uniform within the step. They fit if the mean velocity differs from the mean of both ends by at most a quarter
// of their difference. The host has moved free grains already, which take their sub-steps from the start of the step.
void Substeps::find_paths() {
  const int n = scene_.now.substeps;
  const double dt = scene_.now.dt;
  paths_.clear();
  for (Grain& g : scene_.grains.grains) {
    HermitePath path;
    for (int d = 0; d < 3; ++d) {
      path.from[d] = g.state->x[d];
      path.length[d] = g.x[d] - g.state->x[d];
      g.x[d] = g.state->x[d];
    }
    for (int d = 0; d < 6; ++d) {
      path.start[d] = g.start[d];
      path.end[d] = g.velocity[d];
      const double mean = d < 3 ? path.length[d] / (n * dt) : 0.5 * (path.start[d] + path.end[d]);
      if (std::fabs(mean - 0.5 * (path.start[d] + path.end[d])) > 0.25 * std::fabs(path.end[d] - path.start[d]))
        path.start[d] = path.end[d] = mean;
      if (g.free[d]) g.velocity[d] = g.start[d];
    }
    paths_.push_back(path);
  }
}

// Free grains get the second half of the last kick, and drift. Other grains follow their paths, with the velocity of
// the end of the sub-step; angular velocities are those of its middle and change linearly.
void Substeps::move_grains() {
  const int n = scene_.now.substeps;
  const double dt = scene_.now.dt;
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    Grain& g = scene_.grains.grains[i];
    for (int d = 0; d < 6; ++d) {
      if (g.free[d]) g.velocity[d] += 0.5 * dt * g.kick[d] / inertia_of(g, d);
      else if (d < 3) g.velocity[d] = paths_[i].velocity(d, n * dt, double(scene_.substep) / n);
      else g.velocity[d] = paths_[i].start[d] + (scene_.substep - 0.5) / n * (paths_[i].end[d] - paths_[i].start[d]);
    }
    for (int d = 0; d < 3; ++d) {
      const double before = g.x[d];
      g.x[d] = g.free[d] ? before + dt * g.velocity[d] : paths_[i].position(d, n * dt, double(scene_.substep) / n);
      g.moved[d] = g.x[d] - before;
      g.state->x[d] = scene_.ends_step() ? before : g.x[d];
      // path_offset is the sum of (middle between the two ends of the step - position) over all sub-steps but the last. It
      // gives the torque that conserves the moment of the load S (spread_loads.cpp).
      if (scene_.substep == 1) g.state->path_offset[d] = 0.0;
      g.state->path_offset[d] += scene_.ends_step() ? 0.5 * (n - 1) * (g.x[d] - paths_[i].from[d]) : paths_[i].from[d] - g.x[d];
    }
  }
  scene_.grains.rotate(dt);
}

// held() is the load S of the host.
void Substeps::kick_grains() {
  for (Grain& g : scene_.grains.grains)
    for (int d = 0; d < 6; ++d) {
      g.kick[d] = g.cement_load[d] + g.state->held()[d];
      if (g.free[d]) g.velocity[d] += 0.5 * scene_.now.dt * g.kick[d] / inertia_of(g, d);
    }
}

}  // namespace mpdem
