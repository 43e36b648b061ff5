// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "bonded_grains.h"

#include <algorithm>
#include <cmath>

#include "../../coupling/shared_impulse.h"
#include "../../numerics/length.h"
#include "../../numerics/rotation.h"

namespace mpdem {

namespace {
// Returns the estimate that is nearer to zero, or zero if the two differ in sign.
double minmod(double a, double b) {
  if (a * b <= 0.0) return 0.0;
  return std::fabs(a) < std::fabs(b) ? a : b;
}
}  // namespace

double BondedGrains::mass_ratio(const Grain& g, double cement) {
  const bool moves = g.free[0] || g.free[1] || g.free[2];
  return ((moves ? 1.0 : 0.0) + (g.free[3] ? 2.5 : 0.0)) * cement / g.mass;
}

std::size_t BondedGrains::slot_of(int tag) const {
  const auto at = std::lower_bound(grains.begin(), grains.end(), tag, [](const Grain& g, int t) { return g.tag < t; });
  return at != grains.end() && at->tag == tag ? static_cast<std::size_t>(at - grains.begin()) : grains.size();
}

const Grain* BondedGrains::find(int tag) const {
  const std::size_t at = slot_of(tag);
  return at < grains.size() ? &grains[at] : nullptr;
}

void BondedGrains::replace(std::vector<Grain> now) {
  const auto same = [](const Grain& a, const Grain& b) { return a.tag == b.tag; };
  changed_ = changed_ || !std::equal(now.begin(), now.end(), grains.begin(), grains.end(), same);
  for (std::size_t n = 0; n < now.size() && !changed_; ++n) {
    now[n].ends = std::move(grains[n].ends);
    now[n].mass_ratio = grains[n].mass_ratio;
    now[n].radius_at_creation = grains[n].radius_at_creation;
  }
  grains = std::move(now);
  sudden_loads_.assign(grains.size(), Six{});
}

std::vector<BondedGrains::OwnedEnd> BondedGrains::find_ends(MPI_Comm comm, const Bonds& bonds, bool all, BondEnds& found) const {
  std::vector<OwnedEnd> owned;
  std::vector<Key> keys;
  const auto has_ends = [&](std::size_t row) { return all || !bonds.table[row].condensed; };
  for (std::size_t b = 0; b < bonds.table.size(); ++b)
    for (int s = 0; s < 2; ++s) {
      if (!has_ends(b) || !bonds.table[b].has_grain(s)) continue;
      const std::size_t grain = slot_of(bonds.table[b].grain[s]);
      if (grain == grains.size()) continue;
      owned.push_back({static_cast<int>(grain), -1, static_cast<int>(b), s});
      keys.push_back({static_cast<int>(b), s, 0, 0});
    }
  std::vector<int> here;
  for (const Bond& b : bonds)
    if (has_ends(b.row)) here.push_back(b.row);
  found.build(comm, bonds.table, here, keys);
  for (std::size_t k = 0; k < owned.size(); ++k) owned[k].at = found.owned()[k];
  return owned;
}

void BondedGrains::bind(MPI_Comm comm, Bonds& bonds, const CementDensity& density) {
  owned_ = find_ends(comm, bonds, false, ends);
  for (Bond& b : bonds) b.first_end_index = ends.find(b.row, 0);
  for (Grain& g : grains) g.ends.clear();
  for (std::size_t k = 0; k < owned_.size(); ++k) grains[owned_[k].grain].ends.push_back(static_cast<int>(k));
  std::vector<double> cement(grains.size(), 0.0);
  for (const BondRecord& record : bonds.table)
    for (int s = 0; s < 2; ++s) {
      const std::size_t grain = record.has_grain(s) ? slot_of(record.grain[s]) : grains.size();
      if (grain == grains.size()) continue;
      cement[grain] += record.mass(density);
      grains[grain].radius_at_creation = record.radius[s];
    }
  changed_ = false;
  int some = 0, any;
  for (std::size_t n = 0; n < grains.size(); ++n) {
    grains[n].mass_ratio = mass_ratio(grains[n], cement[n]);
    some = some || grains[n].any_free();
  }
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, comm);
  any_free_ = any != 0;
}

BondedGrains::EndsOfAll BondedGrains::ends_of_all(MPI_Comm comm, const Bonds& bonds) const {
  EndsOfAll of_all;
  of_all.owned = find_ends(comm, bonds, true, of_all.ends);
  send_motion(bonds, of_all.owned, of_all.ends);
  return of_all;
}

void BondedGrains::rebind_ends(MPI_Comm comm, Bonds& bonds, const CementDensity& density, const std::vector<BondEnd>& activated) {
  std::vector<BondEnd> before(ends.ends);
  before.insert(before.end(), activated.begin(), activated.end());
  const auto comes_before = [](const BondEnd& a, const BondEnd& b) {
    return std::make_pair(a.row, a.side) < std::make_pair(b.row, b.side);
  };
  std::sort(before.begin(), before.end(), comes_before);
  bind(comm, bonds, density);
  for (BondEnd& s : ends.ends) {
    const auto was = std::lower_bound(before.begin(), before.end(), s, comes_before);
    if (was != before.end() && !comes_before(s, *was)) s = *was;
  }
}

void BondedGrains::distribute(const Bonds& bonds) {
  for (Grain& grain : grains)
    for (int d = 0; d < 6; ++d) grain.acceleration[d] = d < 3 ? grain.state->a[d] : 0.0;
  send_motion(bonds, owned_, ends);
}

void BondedGrains::send_motion(const Bonds& bonds, const std::vector<OwnedEnd>& owned, BondEnds& to) const {
  std::vector<BondEnds::Motion> motion(owned.size());
  for (std::size_t k = 0; k < owned.size(); ++k) {
    const Grain& grain = grains[owned[k].grain];
    const GrainState& g = *grain.state;
    std::copy(grain.x, grain.x + 3, motion[k].x);
    std::copy(g.v, g.v + 3, motion[k].v);
    std::copy(g.v + 3, g.v + 6, motion[k].omega);
    std::copy(g.q, g.q + 4, motion[k].q);
    std::copy(g.a, g.a + 3, motion[k].a);
    std::copy(g.jump, g.jump + 6, motion[k].jump);
    motion[k].mass_ratio = grain.mass_ratio;
  }
  to.distribute(bonds.table, motion);
}

void BondedGrains::distribute_as_before(const Bonds& bonds, double dt) {
  struct Pose {
    std::array<double, 3> x;
    std::array<double, 4> q;
  };
  std::vector<Pose> now;
  for (Grain& grain : grains) {
    Pose& p = now.emplace_back();
    std::copy(grain.x, grain.x + 3, p.x.begin());
    std::copy(grain.state->q, grain.state->q + 4, p.q.begin());
    if (grain.state->position_known) std::copy(grain.state->x, grain.state->x + 3, grain.x);
  }
  rotate(-dt);
  distribute(bonds);
  for (std::size_t n = 0; n < grains.size(); ++n) {
    std::copy(now[n].x.begin(), now[n].x.end(), grains[n].x);
    std::copy(now[n].q.begin(), now[n].q.end(), grains[n].state->q);
  }
}

void BondedGrains::rotate(double dt) {
  for (Grain& g : grains) {
    double* q = g.state->q;
    const double* w = g.velocity + 3;
    const double rate = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    if (rate == 0.0) continue;
    const double c = std::cos(0.5 * rate * dt), s = std::sin(0.5 * rate * dt) / rate;
    const double p[4] = {c, s * w[0], s * w[1], s * w[2]};
    const std::array<double, 4> r = quaternion_product(p, q);
    const double n = 1.0 / std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
    for (int d = 0; d < 4; ++d) q[d] = n * r[d];
  }
}

void BondedGrains::update_kinematics(double dt, double dt_last, long step, EnergyBalance& energy) {
  const double since = 0.5 * (dt_last + dt);
  step_ = step;
  sudden_loads_.assign(grains.size(), Six{});
  for (Grain& grain : grains) {
    GrainState& g = *grain.state;
    for (int d = 0; d < 6; ++d) {
      const bool free = grain.free[d];
      g.v_before[d] = g.v[d];
      g.v[d] = free || d >= 3 ? grain.velocity[d] : grain.moved[d] / dt;
      const double change = g.v[d] - g.v_before[d];
      g.jump[d] = free ? 0.0 : change - (d < 3 ? since * g.a[d] : 0.0);
      // keep_velocities() predicted g.v by 2 v_end - v_before. This corrects the work of the second half of the last step.
      if (!free) energy.do_work(-0.5 * dt * g.load[d] * (change - 2.0 * (g.v_end[d] - g.v_before[d])));
      if (d < 3) g.a[d] = free ? 0.0 : minmod(change / since, 2.0 * (grain.velocity[d] - g.v[d]) / dt);
    }
    watch_jump(grain);
    g.velocities_known = true;
  }
}

void BondedGrains::keep_velocities(double dt_last) {
  for (Grain& grain : grains) {
    GrainState& g = *grain.state;
    for (int d = 0; d < 6; ++d) g.v_end[d] = grain.free[d] ? grain.velocity[d] : g.v[d] + (d < 3 ? 0.5 * dt_last * g.a[d] : 0.0);
  }
}

void BondedGrains::record_late_loads(bool after) {
  for (Grain& g : grains)
    for (int d = 0; d < 6; ++d) g.state->late_load[d] = after ? g.state->late_load[d] + g.force[d] : -g.force[d];
}

void BondedGrains::find_accelerations(MPI_Comm comm, const Bonds& bonds, int n, CondensedPack& condensed) {
  find_loads(n);
  solve(comm, bonds, condensed);
}

// The loads of the grains are in host_load_.
void BondedGrains::solve(MPI_Comm comm, const Bonds& bonds, CondensedPack& condensed) {
  std::vector<GrainAccelerations::OfBond> of_bonds;
  if (!summed_)
    for (const Bond& b : bonds.resolved())
      if (!b.added.empty()) of_bonds.push_back({&b.added, &b.grid, b.first_end_index});
  summed_ = false;
  accelerations_.find(comm, of_bonds, grains, host_load_, ends, mass_changed_, condensed);
  mass_changed_ = false;
}

void BondedGrains::share_impulses(MPI_Comm comm, Bonds& bonds, int n, CondensedPack& condensed) {
  if (!any_free_) return;
  std::vector<EndMoments> moments(ends.ends.size());
  for (const Bond& b : bonds.resolved())
    if (const SharedImpulse* shared = b.mechanism<SharedImpulse>()) shared->add_moments(b.grid, ends_of(b), &moments[b.first_end_index]);
  host_load_.resize(grains.size());
  for (std::size_t g = 0; g < grains.size(); ++g)
    for (int d = 0; d < 6; ++d) {
      const Grain& grain = grains[g];
      host_load_[g][d] = n * (grain.force[d] + grain.state->late_load[d] - grain.spread_part(d, n)) - grain.state->held()[d];
    }
  const std::vector<BondEnd> kept(ends.ends);
  std::vector<double> total;  // accelerations of the grains so far; like the ends in `kept`, they are put aside for the solution
  for (Grain& g : grains) {
    total.insert(total.end(), g.acceleration, g.acceleration + 6);
    std::fill(g.acceleration, g.acceleration + 6, 0.0);
  }
  ends.set_accelerations(std::vector<Six>(owned_.size(), Six{}));
  ends.clear_forces();
  ends.clear_sudden_forces();
  impulses_.find_impulse(comm, moments, grains, host_load_, ends, condensed);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    BondEnd& s = ends.ends[i];
    std::copy(kept[i].force, kept[i].force + 3, s.force);
    std::copy(kept[i].torque, kept[i].torque + 3, s.torque);
    std::copy(kept[i].jump_force, kept[i].jump_force + 6, s.jump_force);
    std::copy(kept[i].transfer_force, kept[i].transfer_force + 6, s.transfer_force);
  }
  for (Bond& b : bonds.resolved())
    if (SharedImpulse* shared = b.mechanism<SharedImpulse>()) shared->apply_impulse(b.grid, ends_of(b), b.added);
  std::vector<Six> impulse(kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) std::copy(ends.ends[i].impulse, ends.ends[i].impulse + 6, impulse[i].begin());
  ends.sum(reinterpret_cast<double*>(impulse.data()), 6);
  for (std::size_t i = 0; i < kept.size(); ++i) std::copy(impulse[i].begin(), impulse[i].end(), ends.ends[i].impulse);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    BondEnd& s = ends.ends[i];
    for (int d = 0; d < 3; ++d) {
      s.a[d] += kept[i].a[d];
      s.alpha[d] += kept[i].alpha[d];
    }
  }
  for (std::size_t n = 0; n < grains.size(); ++n)
    for (int d = 0; d < 6; ++d) grains[n].acceleration[d] = total[6 * n + d] += grains[n].acceleration[d];
  condensed.set_accelerations(total.data());
}

void BondedGrains::clear_sudden_forces() {
  ends.clear_sudden_forces();
  sudden_forces_are_due_ = false;
}

void BondedGrains::resume_sudden_loads(double dt) {
  sudden_loads_.assign(grains.size(), Six{});
  for (std::size_t n = 0; n < grains.size(); ++n)
    for (int d = 0; d < 6; ++d) sudden_loads_[n][d] = 2.0 / dt * grains[n].state->pending_impulse[d];
}

void BondedGrains::follow_jumps(Bond& b, double dt, double dt_last, const std::array<double, 3>& weight, EnergyBalance& balance) {
  const AddedMass::Followed power = b.added.follow_jumps(b.grid, ends_of(b), 2.0 / (dt_last + dt), 1.0 / dt, weight);
  balance.do_work(0.5 * dt_last * power.of_weight);
  balance.do_inertial_work(0.5 * dt_last * power.of_inertial_force);
}

void BondedGrains::add_loads_of_cement(double dt, EnergyBalance& balance, const CondensedPack& condensed) {
  ends.sum_forces();
  for (Grain& g : grains) std::fill(g.state->load, g.state->load + 6, 0.0);
  for (const OwnedEnd& o : owned_) {
    const BondEnd& s = ends.ends[o.at];
    const Six load = in_box(s, s.force, s.torque);
    Grain& g = grains[o.grain];
    for (int d = 0; d < 6; ++d) {
      g.force[d] += load[d];
      g.state->load[d] += load[d];
    }
  }
  for (std::size_t n = 0; n < grains.size(); ++n) {
    Grain& g = grains[n];
    double of_jumps = 0.0;
    for (int d = 0; d < 6; ++d) {
      const double load = condensed.load(n, d) + condensed.inertial_load(n, d);
      g.force[d] += load;
      g.state->load[d] += load;
      of_jumps += condensed.jump_load(n, d) * 0.5 * (g.state->v_before[d] + g.state->v[d]);
    }
    if (!loads_restored_) balance.do_work(-dt * of_jumps);
  }
  react_to_jumps(dt, balance);
  for (std::size_t n = 0; n < grains.size(); ++n)
    for (int d = 0; d < 6; ++d) {
      const double sudden = sudden_loads_[n][d] + condensed.jump_load(n, d);
      grains[n].force[d] += sudden;
      grains[n].state->pending_impulse[d] = 0.5 * dt * sudden;
    }
}

void BondedGrains::save_loads() {
  loads_restored_ = false;
  saved_loads_.resize(grains.size());
  for (std::size_t n = 0; n < grains.size(); ++n) std::copy(grains[n].force, grains[n].force + 6, saved_loads_[n].begin());
}

void BondedGrains::restore_loads() {
  loads_restored_ = true;
  withdrawn_loads_.resize(grains.size());
  for (std::size_t n = 0; n < grains.size(); ++n) {
    std::copy(saved_loads_[n].begin(), saved_loads_[n].end(), grains[n].force);
    std::copy(grains[n].state->load, grains[n].state->load + 6, withdrawn_loads_[n].begin());
  }
}

void BondedGrains::correct_work_of_withdrawn_loads(double dt_last, EnergyBalance& balance) const {
  for (std::size_t n = 0; n < grains.size(); ++n) {
    const GrainState& g = *grains[n].state;
    for (int d = 0; d < 6; ++d) balance.do_work(-0.5 * dt_last * (withdrawn_loads_[n][d] - g.load[d]) * g.v[d]);
  }
}

// Condensed bonds pass a part of the momentum of a grain to their other grain.
double BondedGrains::apply_impulse(MPI_Comm comm, const std::vector<Six>& momentum, CondensedPack& condensed) {
  host_load_.resize(grains.size());
  for (std::size_t n = 0; n < grains.size(); ++n) {
    std::fill(grains[n].acceleration, grains[n].acceleration + 6, 0.0);
    for (int d = 0; d < 6; ++d) host_load_[n][d] = momentum[n][d];
  }
  ends.set_accelerations(std::vector<Six>(owned_.size(), Six{}));
  condensed.set_accelerations(std::vector<double>(6 * grains.size(), 0.0).data());
  impulses_.find_impulse(comm, std::vector<EndMoments>(ends.ends.size()), grains, host_load_, ends, condensed);
  double energy = 0.0;
  for (std::size_t n = 0; n < grains.size(); ++n) {
    Grain& g = grains[n];
    for (int d = 0; d < 6; ++d) {
      if (!g.free[d]) {
        energy += momentum[n][d] * g.velocity[d];
        continue;
      }
      energy += (d < 3 ? g.mass : g.inertia) * g.acceleration[d] * (g.velocity[d] + 0.5 * g.acceleration[d]);
      g.velocity[d] += g.acceleration[d];
      g.state->v[d] += g.acceleration[d];
    }
  }
  return energy;
}

void BondedGrains::react_to_jumps(double dt, EnergyBalance& balance) {
  if (!sudden_forces_are_due_) return;
  sudden_forces_are_due_ = false;
  ends.sum_sudden_forces();
  for (BondEnd& s : ends.ends)
    for (int d = 0; d < 3; ++d) {
      s.force[d] += s.jump_force[d] + s.transfer_force[d];
      s.torque[d] += s.jump_force[3 + d] + s.transfer_force[3 + d];
    }
  for (const OwnedEnd& o : owned_) {
    const BondEnd& s = ends.ends[o.at];
    const GrainState& g = *grains[o.grain].state;
    const Six of_jump = in_box(s, s.jump_force, s.jump_force + 3), of_transfer = in_box(s, s.transfer_force, s.transfer_force + 3);
    double power = 0.0;
    for (int d = 0; d < 6; ++d) {
      sudden_loads_[o.grain][d] += of_jump[d] + of_transfer[d];
      power += of_jump[d] * 0.5 * (g.v_before[d] + g.v[d]) + of_transfer[d] * g.v[d];
    }
    balance.do_work(-dt * power);
  }
}

void BondedGrains::exchange_momentum(MPI_Comm comm, Bonds& bonds, const std::vector<Six>& jump, int first_row, bool at_start,
                                     int end_of_work, EnergyBalance& balance) {
  ends.set_jumps(jump);
  ends.set_accelerations(std::vector<Six>(owned_.size(), Six{}));
  for (Grain& grain : grains) std::fill(grain.acceleration, grain.acceleration + 6, 0.0);
  ends.clear_forces();
  ends.clear_sudden_forces();
  for (Bond& b : bonds.resolved()) {
    b.grid.clear_force();
    if (b.row >= first_row) b.added.add_jumps(b.grid, ends_of(b), at_start);
  }
  host_load_.assign(grains.size(), GrainAccelerations::Vector6::Zero());
  CondensedPack none;
  if (any_free_) solve(comm, bonds, none);
  added_mass_changed();  // solve() left out condensed bonds
  for (Bond& b : bonds.resolved()) b.added.accelerate(b.grid, ends_of(b));
  ends.sum_forces();
  for (Grain& grain : grains)
    for (int d = 0; d < 6; ++d)
      if (grain.free[d]) grain.velocity[d] += grain.acceleration[d];
  for (const OwnedEnd& o : owned_) {
    if (o.row >= end_of_work) continue;
    const BondEnd& s = ends.ends[o.at];
    const Grain& grain = grains[o.grain];
    const Six load = in_box(s, s.force, s.torque);
    for (int d = 0; d < 6; ++d) balance.do_work(-load[d] * 0.5 * (grain.state->v_end[d] + grain.velocity[d]));
  }
}

bool BondedGrains::find_commands(MPI_Comm comm, CondensedPack& condensed) {
  int some = 0, any;
  std::vector<Six> jump(owned_.size(), Six{}), of_grains(grains.size(), Six{});
  for (std::size_t n = 0; n < grains.size(); ++n)
    for (int d = 0; d < 6; ++d) {
      const Grain& grain = grains[n];
      const double change = grain.free[d] ? grain.velocity[d] - grain.state->v_end[d] : 0.0;
      of_grains[n][d] = change;
      for (int k : grain.ends) jump[k][d] = change;
      some = some || change != 0.0;
    }
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, comm);
  if (!any) return false;
  ends.set_jumps(jump);
  condensed.set_jumps(of_grains.empty() ? nullptr : of_grains.front().data());
  return true;
}

void BondedGrains::read_commanded_velocities(MPI_Comm comm, Bonds& bonds, double dt, double dt_last, EnergyBalance& balance) {
  std::vector<Six> jump(owned_.size());
  for (std::size_t k = 0; k < jump.size(); ++k) {
    const BondEnd& s = ends.ends[owned_[k].at];
    jump[k] = in_box(s, s.jump, s.jump + 3);
  }
  std::vector<std::vector<double>> acceleration;
  for (const Bond& b : bonds.resolved()) acceleration.push_back(b.grid.acceleration);
  exchange_momentum(comm, bonds, jump, 0, false, static_cast<int>(bonds.table.size()), balance);
  const double rate = 2.0 / (dt_last + dt);
  auto before = acceleration.begin();
  for (Bond& b : bonds.resolved()) {
    for (std::size_t k = 0; k < before->size(); ++k) (*before)[k] += rate * b.grid.acceleration[k];
    b.grid.acceleration.swap(*before++);
  }
}

void BondedGrains::count_commands(double dt_last, EnergyBalance& energy) const {
  for (const Grain& grain : grains)
    for (int d = 0; d < 6; ++d)
      if (grain.free[d]) energy.do_work(-0.5 * dt_last * grain.state->load[d] * (grain.velocity[d] - grain.state->v_end[d]));
}

void BondedGrains::start_added_mass(MPI_Comm comm, Bonds& bonds, int first_row, bool any_added_mass, EnergyBalance& energy) {
  for (Grain& grain : grains) {
    GrainState& g = *grain.state;
    for (int d = 0; d < 6 && !g.velocities_known; ++d) g.v[d] = g.v_before[d] = g.v_end[d] = grain.velocity[d];
  }
  distribute(bonds);
  for (Bond& b : bonds.resolved()) {
    const double speed = b.row < first_row ? 0.0 : b.links.fastest(b.grid, ends_of(b));
    if (speed > fastest_start_.speed) fastest_start_ = {b.row, speed};
  }
  if (any_added_mass) {
    std::vector<Six> jump(owned_.size());
    for (std::size_t k = 0; k < owned_.size(); ++k) {
      const double* v_end = grains[owned_[k].grain].state->v_end;
      std::copy(v_end, v_end + 6, jump[k].begin());
    }
    std::vector<Six> before(grains.size());
    for (std::size_t n = 0; n < before.size(); ++n) std::copy(grains[n].velocity, grains[n].velocity + 6, before[n].begin());
    exchange_momentum(comm, bonds, jump, first_row, true, first_row, energy);
    for (Bond& b : bonds.resolved())
      for (std::size_t k = 0; k < b.grid.velocity.size(); ++k) b.grid.velocity[k] += b.grid.acceleration[k];
    for (std::size_t n = 0; n < before.size(); ++n)
      for (int d = 0; d < 6; ++d) {
        const double change = grains[n].velocity[d] - before[n][d];
        grains[n].state->v[d] += change;
        grains[n].state->v_end[d] += change;
      }
  }
  distribute(bonds);
}

void BondedGrains::stagger_velocities(const Bonds& bonds, double dt_last) {
  std::vector<Six> rates(owned_.size()), found(grains.size());
  for (std::size_t n = 0; n < grains.size(); ++n) {
    std::copy(grains[n].acceleration, grains[n].acceleration + 6, found[n].begin());
    for (int k : grains[n].ends) rates[k] = found[n];
    GrainState& g = *grains[n].state;
    if (g.velocities_known) continue;
    g.velocities_known = true;
    for (int d = 0; d < 6; ++d) g.v[d] -= 0.5 * dt_last * found[n][d];
  }
  distribute(bonds);
  ends.set_accelerations(rates);
  for (std::size_t n = 0; n < grains.size(); ++n) std::copy(found[n].begin(), found[n].end(), grains[n].acceleration);
}

EnergyBalance::StepWork BondedGrains::work(double dt_last, int first_row) const {
  EnergyBalance::StepWork power;
  for (const OwnedEnd& o : owned_) {
    if (o.row < first_row) continue;
    const BondEnd& s = ends.ends[o.at];
    const GrainState& g = *grains[o.grain].state;
    double force[6];  // without the force of impulses, whose work is counted on the nodes
    for (int d = 0; d < 6; ++d) force[d] = (d < 3 ? s.force[d] : s.torque[d - 3]) - s.jump_force[d] - s.transfer_force[d] - s.impulse[d];
    const Six f = in_box(s, force, force + 3);
    for (int d = 0; d < 6; ++d) {
      power.now -= f[d] * g.v_end[d];
      power.with_velocity_before -= f[d] * g.v[d];
    }
  }
  return {dt_last * power.now, dt_last * power.with_velocity_before};
}

EnergyBalance::StepWork BondedGrains::work_of(const CondensedPack& condensed, double dt_last) const {
  EnergyBalance::StepWork power;
  for (std::size_t n = 0; n < grains.size(); ++n) {
    const GrainState& g = *grains[n].state;
    for (int d = 0; d < 6; ++d) {
      // The work of the weight is not counted here: it is work of gravity.
      const double f = condensed.load(n, d) - condensed.weight(n, d) + condensed.inertial_load(n, d);
      power.now -= f * g.v_end[d];
      power.with_velocity_before -= f * g.v[d];
    }
  }
  return {dt_last * power.now, dt_last * power.with_velocity_before};
}

void BondedGrains::start_watch(double limit) {
  jump_limit_ = limit;
  worst_jump_ = Jump();
  fastest_start_ = Start();
}

void BondedGrains::watch_jump(const Grain& grain) {
  if (worst_jump_.tag) return;
  const GrainState& g = *grain.state;
  double change[6] = {};
  for (int d = 0; d < 6; ++d)
    if (!grain.free[d]) change[d] = g.v[d] - g.v_before[d];
  const double r = grain.radius;
  const double jump = length(change) + r * length(change + 3);
  const double fastest = std::max(length(g.v) + r * length(g.v + 3), length(g.v_before) + r * length(g.v_before + 3));
  if (jump > jump_limit_ && jump > 0.5 * fastest) worst_jump_ = {grain.tag, jump, step_};
}

}  // namespace mpdem
