// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds which share of the load F of the host acts in each sub-step of its next step, see cement/step/substeps.cpp: a
// mean S of F over the steps before. Any S conserves the impulse of F and its moment. For an oscillating load the means
// must be slow, since a mean that lags behind it feeds energy into the oscillation. For a permanent change they must be
// fast, since F - S acts in kicks. With e = F - S, and <> an average over some ten steps, the ratio
//
//   |<e>|^2 / <|e|^2>
//
// is near 0 for an oscillation and near 1 for a permanent change. The means are faster where it is larger. Torques are
// divided by the radius.
#include <cmath>

#include "bonded_grains.h"

namespace mpdem {

namespace {
constexpr double kWeight = 0.1;              // weight of the last load in <>
constexpr double kSlow = 0.02, kFast = 0.5;  // weight of the last load in a mean
constexpr double kOscillating = 0.5;         // below this ratio the load oscillates

// Updates the averages <e> and <|e|^2> of a grain. Returns the weight of the last load in a mean.
double weight_of_last(const double* load, double radius, GrainState& s) {
  double squared = 0.0, of_mean = 0.0;
  for (int d = 0; d < 6; ++d) {
    const double off = (load[d] - s.held()[d]) / (d < 3 ? 1.0 : radius);
    s.off[d] += kWeight * (off - s.off[d]);
    squared += off * off;
    of_mean += s.off[d] * s.off[d];
  }
  s.off_squared += kWeight * (squared - s.off_squared);
  const double share = s.off_squared > 0.0 ? of_mean / s.off_squared : 0.0;
  return kSlow + (kFast - kSlow) * std::fmax(0.0, share - kOscillating) / (1.0 - kOscillating);
}
}  // namespace

void BondedGrains::start_spreading(int n) {
  for (Grain& g : grains) {
    GrainState& s = *g.state;
    if (n > 1 && !s.spread) {
      for (int d = 0; d < 6; ++d) {
        s.mean[d] = s.mean[6 + d] = s.mean[12 + d] = s.mean_at_end[d] = g.force[d] + s.late_load[d];
        s.off[d] = 0.0;
      }
      s.off_squared = 0.0;
    }
    s.spread = n > 1;
  }
}

void BondedGrains::spread_loads(int n) {
  if (n == 1) return;
  for (Grain& g : grains) {
    GrainState& s = *g.state;
    double load[6], before[6];
    for (int d = 0; d < 6; ++d) {
      load[d] = g.force[d] + s.late_load[d];
      before[d] = s.held()[d];
    }
    const double weight = weight_of_last(load, g.radius, s);
    for (int d = 0; d < 6; ++d) {
      double last = load[d];
      for (int mean = d; mean < 18; mean += 6) last = s.mean[mean] += weight * (last - s.mean[mean]);
      s.mean_at_end[d] = 0.5 * (before[d] + s.held()[d]);
    }
    // The held load acted at the positions of the sub-steps, not at the ends of the step. This torque conserves its moment.
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      s.mean_at_end[3 + d] -= (s.path_offset[e] * before[f] - s.path_offset[f] * before[e]) / (n - 1);
    }
  }
}

void BondedGrains::find_loads(int n) {
  host_load_.resize(grains.size());
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const GrainState& g = *grains[i].state;
    for (int d = 0; d < 6; ++d) host_load_[i][d] = sudden_loads_[i][d] + (n == 1 ? grains[i].force[d] + g.late_load[d] : g.held()[d]);
  }
}

void BondedGrains::react(double dt, int n, EnergyBalance& energy, const CondensedPack& condensed) {
  if (n == 1) return add_loads_of_cement(dt, energy, condensed);
  for (Grain& g : grains) {
    std::copy(g.force, g.force + 6, g.kick);
    std::fill(g.force, g.force + 6, 0.0);
  }
  add_loads_of_cement(dt, energy, condensed);
  for (Grain& g : grains)
    for (int d = 0; d < 6; ++d) {
      g.cement_load[d] = g.force[d];
      g.force[d] = g.kick[d] - g.spread_part(d, n) + g.cement_load[d] / n;
      g.load_of_other_substeps[d] = 0.0;
    }
  for (const OwnedEnd& o : owned_) {
    const BondEnd& s = ends.ends[o.at];
    const Six impulse = in_box(s, s.impulse, s.impulse + 3);
    for (int d = 0; d < 6; ++d) {
      grains[o.grain].load_of_other_substeps[d] += (1.0 - 1.0 / n) * impulse[d];
      grains[o.grain].state->load[d] -= impulse[d];  // its work is counted on the nodes
    }
  }
}

void BondedGrains::set_reported_loads(int n) {
  if (n == 1) return;
  for (Grain& g : grains)
    for (int d = 0; d < 6; ++d) g.force[d] += g.cement_load[d] - g.cement_load[d] / n - g.load_of_other_substeps[d] + g.spread_part(d, n);
}

}  // namespace mpdem
