// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "shared_impulse.h"

#include <algorithm>

#include "relative_damping.h"
#include "rigid_motion.h"

namespace mpdem {

namespace {

void subtract_from_grain(const double* r, const double* f, double scale, BondEnd& s) {
  add_to_grain(r, f, -scale, s);
  add_to_grain(r, f, -scale, s.impulse, s.impulse + 3);
}

}  // namespace

void SharedImpulse::follow_grains(const Grid& grid, const BondRecord& record, const std::vector<char>& connected) {
  *this = SharedImpulse();
  share_ = shares_of_second_grain(grid, record, connected);
}

// If nothing failed, the mass is bitwise that of the nodes.
void SharedImpulse::find_intact_mass(const PointStore& points, const Grid& grid, const CementDensity& density) {
  if (stale_) {
    const bool some_failed = points.any_failed();
    here_.clear();
    if (some_failed || grid.halo.shares_any()) {
      here_ = grid.local_mass(points, density, true);
      grid.constraints.add_to_mass_receivers(here_.data(), 1);
    }
    stale_ = false;
  }
  intact_mass_ = here_;
}

double SharedImpulse::intact_share(const Grid& grid, int node) const {
  return intact_mass_.empty() || grid.mass[node] == 0.0 ? 1.0 : std::min(1.0, intact_mass_[node] / grid.mass[node]);
}

void SharedImpulse::add_moments(const Grid& grid, const BondEnd* ends, EndMoments* of_ends) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  for (int i = 0; i < grid.size(); ++i) {
    if (share_[i] < 0.0 || !counts[i] || grid.mass[i] == 0.0) continue;
    const double share[2] = {1.0 - share_[i], share_[i]}, mass = intact_share(grid, i) * grid.mass[i];
    for (int s = 0; s < 2; ++s) {
      double r[3];
      lever_arm(grid, i, ends[s], r);
      MassMoments::add(mass * share[s] * share[s], r, of_ends[s].own.m.data());
      MassMoments::add(mass * share[0] * share[1], r, of_ends[s].shared.m.data());
    }
  }
}

void SharedImpulse::apply_impulse(Grid& grid, BondEnd* ends, const AddedMass& added) {
  const std::vector<char>& counts = grid.halo.counts_here();
  force_.assign(3 * grid.size(), 0.0);
  const std::vector<AddedMass::OfNode> shares = added.shares();
  auto extra = shares.begin();
  for (int i = 0; i < grid.size(); ++i) {
    while (extra != shares.end() && extra->node < i) ++extra;
    if (share_[i] < 0.0) continue;
    const double held = intact_share(grid, i), mass = held * grid.mass[i];
    const double share[2] = {1.0 - share_[i], share_[i]};
    double r[2][3], of_grain[2][3], a[3], *f = &grid.force[3 * i];
    for (int s = 0; s < 2; ++s) {
      lever_arm(grid, i, ends[s], r[s]);
      acceleration_at(ends[s], r[s], of_grain[s]);
    }
    for (int d = 0; d < 3; ++d) {
      a[d] = share[0] * of_grain[0][d] + share[1] * of_grain[1][d];
      f[d] += force_[3 * i + d] = mass * a[d];
    }
    for (int s = 0; s < 2 && counts[i]; ++s) subtract_from_grain(r[s], a, share[s] * mass, ends[s]);
    if (extra == shares.end() || extra->node != i) continue;
    for (int s = 0; s < 2; ++s) {
      double relative[3];
      for (int d = 0; d < 3; ++d) {
        relative[d] = a[d] - of_grain[s][d];
        f[d] += held * extra->mass[s] * relative[d];
        force_[3 * i + d] += held * extra->mass[s] * relative[d];
      }
      if (counts[i]) subtract_from_grain(r[s], relative, held * extra->mass[s], ends[s]);
    }
  }
}

double SharedImpulse::load_power(const Grid& grid, const std::vector<double>& velocity) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  double power = 0.0;
  for (std::size_t n = 0; n < force_.size(); ++n)
    if (counts[n / 3]) power += force_[n] * velocity[n];
  return power;
}

}  // namespace mpdem
