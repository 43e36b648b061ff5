// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "added_mass.h"

#include <algorithm>
#include <cmath>

#include "eight_inertias.h"
#include "rigid_motion.h"

namespace mpdem {

// The added mass of a node is divided between the two grains by their shares of its stiffness.
void AddedMass::find(const PenaltyLinks& links, Grid& grid, const BondEnd* ends, const Stability& s,
                     const std::vector<std::unique_ptr<BondMechanism>>& mechanisms) {
  constexpr double kMargin = 1.05;
  std::vector<double> penalty(2 * grid.size(), 0.0);
  links.add_stiffness(grid, ends, s.dt, penalty.data());
  for (const auto& p : mechanisms) p->add_stiffness(grid, ends, penalty.data());
  grid.halo.sum(penalty.data(), 2);
  std::vector<double> mass(grid.size(), 0.0);
  std::vector<OfNode> shares;
  for (int i = 0; i < grid.size(); ++i) {
    const double* k = &penalty[2 * i];
    if (k[0] + k[1] == 0.0) continue;
    const double share = std::min(1.0, s.dt * s.dt * s.lambda * (s.lambda_is_bound ? grid.constraint_factor(i) : 1.0) / s.bound);
    mass[i] = std::max(0.0, kMargin * s.dt * s.dt / s.bound * (k[0] + k[1]) - grid.mass[i] * (1.0 - share));
    if (mass[i] == 0.0) continue;
    const double unit = mass[i] / (k[0] + k[1]);
    shares.push_back({i, {unit * k[0], unit * k[1]}});
  }
  mass_ = std::move(mass);
  keep(shares, grid);
}

void AddedMass::keep(const std::vector<OfNode>& shares, const Grid& grid) {
  const std::size_t eights = (shares.size() + kLanes - 1) / kLanes;
  masses_.assign(eights, EightMasses{});
  masses_.shrink_to_fit();
  std::vector<EightNodes> nodes;
  nodes.reserve(eights);
  for (std::size_t n = 0; n < eights; ++n) {
    EightMasses& m = masses_[n];
    const int count = static_cast<int>(std::min<std::size_t>(kLanes, shares.size() - kLanes * n));
    int of[kLanes];
    for (int l = 0; l < count; ++l) {
      const OfNode& a = shares[kLanes * n + l];
      of[l] = a.node;
      for (int s = 0; s < 2; ++s) m.mass[s][l] = a.mass[s];
    }
    nodes.emplace_back(grid, of, count);
    m.added = nodes.back().take_scalar(mass_.data());
  }
  nodes_ = std::move(nodes);
  std::vector<std::array<int, 2>> without;
  const std::vector<int> tie = grid.constraints.row_of_each(grid.size());
  for (int i = 0; i < grid.size(); ++i) {
    if (tie[i] >= 0 || mass_[i] > 0.0) continue;
    if (without.empty() || without.back()[1] != i) without.push_back({i, i});
    without.back()[1] = i + 1;
  }
  without_ = std::move(without);
}

std::vector<AddedMass::OfNode> AddedMass::shares() const {
  std::vector<OfNode> shares;
  for (std::size_t n = 0; n < masses_.size(); ++n)
    for (int l = 0; l < nodes_[n].count; ++l) shares.push_back({nodes_[n].node[l], {masses_[n].mass[0][l], masses_[n].mass[1][l]}});
  return shares;
}

namespace {

bool jumps(const BondEnd& s) {
  return std::any_of(s.jump, s.jump + 6, [](double j) { return j != 0.0; });
}

template <class F>
void for_each_share(const AddedMass& added, F f) {
  for (std::size_t n = 0; n < added.masses().size(); ++n) {
    const AddedMass::EightMasses& m = added.masses()[n];
    const EightNodes& e = added.nodes()[n];
    for (int l = 0; l < e.count; ++l) f(AddedMass::OfNode{e.node[l], {m.mass[0][l], m.mass[1][l]}});
  }
}

// Calls f(node, mass, end, vector from the centre of its grain) for all added mass.
template <class Side, class F>
void for_each(const AddedMass& added, const Grid& grid, Side* side, F f) {
  for_each_share(added, [&](const AddedMass::OfNode& a) {
    for (int n = 0; n < 2; ++n) {
      if (a.mass[n] == 0.0) continue;
      double r[3];
      lever_arm(grid, a.node, side[n], r);
      f(a.node, a.mass[n], side[n], r);
    }
  });
}

}  // namespace

void AddedMass::move_added_mass(Grid& grid, const BondEnd* ends) const {
  for_each(*this, grid, ends, [&](int node, double mass, const BondEnd& s, const double* r) {
    double of_grain[3];
    acceleration_at(s, r, of_grain);
    for (int d = 0; d < 3; ++d) grid.force[3 * node + d] += mass * of_grain[d];
  });
}

void AddedMass::accelerate_with_grains(Grid& grid, BondEnd* ends) const {
  EightLoads loads[2];
  for (std::size_t m = 0; m < masses_.size(); ++m) {
    const EightMasses& own = masses_[m];
    const EightInertias e(own, nodes_[m], grid);
    vd r[2][3], of_grain[2][3], f[3];
    e.nodes.take(grid.force.data(), f);
    for (int n = 0; n < 2; ++n) {
      e.lever_arm(ends[n], r[n]);
      acceleration_at(ends[n], r[n], of_grain[n]);
      for (int d = 0; d < 3; ++d) f[d] += own.mass[n] * of_grain[n][d];
    }
    const vd inverse = 1.0 / e.inertia;
    for (int d = 0; d < 3; ++d) f[d] *= inverse;
    e.nodes.put(f, grid.force.data());
    for (int n = 0; n < 2; ++n) {
      vd relative[3];
      for (int d = 0; d < 3; ++d) relative[d] = e.nodes.counted * own.mass[n] * (f[d] - of_grain[n][d]);
      loads[n].add(r[n], relative);
    }
  }
  for (int n = 0; n < 2; ++n) loads[n].add_to(ends[n]);
}

void AddedMass::accelerate(Grid& grid, BondEnd* ends) const {
  if (empty()) return grid.update_acceleration();
  accelerate_with_grains(grid, ends);
  for (const std::array<int, 2>& row : without_) grid.accelerate(row[0], row[1]);
  grid.finish_accelerations();
}

AddedMass::Followed AddedMass::follow_jumps(Grid& grid, BondEnd* ends, double rate, double grain_rate,
                                            const std::array<double, 3>& weight) const {
  Followed power;
  if (!jumps(ends[0]) && !jumps(ends[1])) return power;
  const std::vector<char>& counts = grid.halo.counts_here();
  const double* inertial = grid.inertial_force.empty() ? nullptr : grid.inertial_force.data();
  for_each_share(*this, [&](const OfNode& a) {
    const double inverse = 1.0 / (grid.mass[a.node] + mass_[a.node]);
    double r[2][3], of_grain[2][3], of_node[3] = {0, 0, 0};
    for (int n = 0; n < 2; ++n) {
      lever_arm(grid, a.node, ends[n], r[n]);
      jump_at(ends[n], r[n], of_grain[n]);
      for (int d = 0; d < 3; ++d) of_node[d] += inverse * a.mass[n] * of_grain[n][d];
    }
    for (int d = 0; d < 3; ++d) grid.acceleration[3 * a.node + d] += rate * of_node[d];
    if (!counts[a.node]) return;
    for (int d = 0; d < 3; ++d) {
      power.of_weight += grid.mass[a.node] * weight[d] * of_node[d];
      if (inertial) power.of_inertial_force += inertial[3 * a.node + d] * of_node[d];
    }
    for (int n = 0; n < 2; ++n) {
      double relative[3];
      for (int d = 0; d < 3; ++d) relative[d] = of_node[d] - of_grain[n][d];
      add_to_grain(r[n], relative, grain_rate * a.mass[n], ends[n].jump_force, ends[n].jump_force + 3);
    }
  });
  grid.constraints.extend(grid.acceleration.data());
  return power;
}

void AddedMass::add_jumps(Grid& grid, BondEnd* ends, bool at_start) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(*this, grid, ends, [&](int node, double mass, BondEnd& s, const double* r) {
    double jump[3];
    jump_at(s, r, jump);
    for (int d = 0; d < 3; ++d) {
      if (at_start) jump[d] -= grid.velocity[3 * node + d];
      grid.force[3 * node + d] += mass * jump[d];
    }
    if (counts[node]) add_to_grain(r, jump, -mass, s);
  });
}

// A node of inertia N relative to its grain that gains C more is slowed to (N/(N + C))^(1/2) of its velocity relative
// to the grain. The force of the last step acts on half of the motion of this one, so the change of the velocity
// changes its work. The loss is that of the kinetic energy of the node, less the work of the transfer force on the
// grain and less this change.
double AddedMass::slow_nodes(const std::vector<OfNode>& before, Grid& grid, BondEnd* ends, double later, double dt) const {
  std::vector<double> change(grid.velocity.size(), 0.0);
  const std::vector<char>& counts = grid.halo.counts_here();
  double lost = 0.0;
  bool any = false;
  auto old = before.begin();
  for_each_share(*this, [&](const OfNode& now) {
    while (old != before.end() && old->node < now.node) ++old;
    const bool had = old != before.end() && old->node == now.node;
    const double m = grid.mass[now.node];
    double inertia = m + (had ? old->mass[0] + old->mass[1] : 0.0);
    for (int n = 0; n < 2; ++n) {
      const double more = now.mass[n] - (had ? old->mass[n] : 0.0);
      if (!(more > 0.0)) continue;
      double r[3], of_grain[3], jump[3], slower[3];
      lever_arm(grid, now.node, ends[n], r);
      for (int d = 0; d < 3; ++d) r[d] += dt * ends[n].v[d];  // the grain went on, and the node did not
      velocity_at(ends[n], r, of_grain);
      jump_at(ends[n], r, jump);
      const double share = std::sqrt(inertia / (inertia + more)) - 1.0;
      for (int d = 0; d < 3; ++d) {
        const int i = 3 * now.node + d;
        const double v = grid.velocity[i] + change[i] + later * grid.acceleration[i];
        slower[d] = share * (v - (of_grain[d] - jump[d]));
        change[i] += slower[d];
        if (counts[now.node]) lost -= slower[d] * (m * (v + 0.5 * slower[d] - of_grain[d]) - 0.5 * dt * inertia * grid.acceleration[i]);
      }
      if (counts[now.node]) add_to_grain(r, slower, -m / dt, ends[n].transfer_force, ends[n].transfer_force + 3);
      inertia += more;
      any = true;
    }
  });
  if (!any) return 0.0;
  grid.constraints.extend(change.data());
  for (std::size_t i = 0; i < change.size(); ++i) grid.velocity[i] += change[i];
  return lost;
}

double AddedMass::energy_ahead(const Grid& grid, const BondEnd* ends, double later) const {
  double energy = 0.0;
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(*this, grid, ends, [&](int node, double mass, const BondEnd& s, const double* from) {
    if (!counts[node]) return;
    double r[3], of_grain[3], jump[3];
    for (int d = 0; d < 3; ++d) r[d] = from[d] + later * s.v[d];  // the grain went on, and the node did not
    velocity_at(s, r, of_grain);
    jump_at(s, r, jump);
    for (int d = 0; d < 3; ++d) {
      const double v = grid.velocity[3 * node + d] + later * grid.acceleration[3 * node + d] - (of_grain[d] - jump[d]);
      energy += 0.5 * mass * v * v;
    }
  });
  return energy;
}

void AddedMass::add_reaction(const Grid& grid, const std::vector<double>& field, double scale, BondEnd* ends) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(*this, grid, ends, [&](int node, double mass, BondEnd& s, const double* r) {
    if (counts[node]) add_to_grain(r, &field[3 * node], scale * mass, s.transfer_force, s.transfer_force + 3);
  });
}

double AddedMass::work_of_reaction(const Grid& grid, const BondEnd* ends, const std::vector<double>& field) const {
  double work = 0.0;
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(*this, grid, ends, [&](int node, double mass, const BondEnd& s, const double* r) {
    if (!counts[node]) return;
    double of_grain[3];
    velocity_at(s, r, of_grain);
    for (int d = 0; d < 3; ++d) work += mass * field[3 * node + d] * of_grain[d];
  });
  return work;
}

double AddedMass::power(const Grid& grid, const BondEnd* ends, const std::vector<double>& field) const {
  double power = 0.0;
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(*this, grid, ends, [&](int node, double mass, const BondEnd& s, const double* r) {
    if (!counts[node]) return;
    double a[3];
    acceleration_at(s, r, a);
    for (int d = 0; d < 3; ++d) power += mass * (grid.acceleration[3 * node + d] - a[d]) * field[3 * node + d];
  });
  return power;
}

double AddedMass::energy(const Grid& grid, const BondEnd* ends, double early, double late) const {
  double energy = 0.0;
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each(*this, grid, ends, [&](int node, double mass, const BondEnd& s, const double* r) {
    if (!counts[node]) return;
    double rate[3], of_grain[3];
    acceleration_at(s, r, rate);
    velocity_at(s, r, of_grain);
    for (int d = 0; d < 3; ++d) {
      const double v = grid.velocity[3 * node + d] - of_grain[d];
      const double a = grid.acceleration[3 * node + d] - rate[d];
      energy += 0.5 * mass * (v + early * a) * (v + late * a);
    }
  });
  return energy;
}

void AddedMass::add_to_ends(const Grid& grid, double* mass) const {
  for_each_share(*this, [&](const OfNode& a) {
    for (int n = 0; n < 2; ++n)
      if (grid.halo.counts_here()[a.node]) mass[n] += a.mass[n];
  });
}

void AddedMass::share(AlikeLists& alike) {
  alike.share(mass_);
  alike.share(nodes_);
  alike.share(without_);
}

std::size_t AddedMass::memory_usage() const {
  return mass_.memory_usage() + masses_.capacity() * sizeof(EightMasses) + nodes_.memory_usage() + without_.memory_usage();
}

}  // namespace mpdem
