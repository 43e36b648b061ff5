// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Links to elastic grains, see elastic_end.h.
#include <algorithm>
#include <cmath>
#include <utility>

#include "../mpm/lane_by_lane.h"
#include "../numerics/cross_matrix.h"
#include "link_states.h"
#include "rigid_motion.h"
#include "traction_laws.h"

namespace mpdem {

namespace {

using Sums = vd[3 * ElasticEnd::kMostModes];

// K' d for links of stiffness k along n and across it.
void traction(const TractionSecant& k, const vd* d, const vd* n, vd* f) {
  const vd along = (k.kn - k.kt) * (d[0] * n[0] + d[1] * n[1] + d[2] * n[2]);
  for (int i = 0; i < 3; ++i) f[i] = k.kt * d[i] + along * n[i];
}

Eigen::VectorXd in_axes(const Mat3<double>& axes, const vd* sums, int size) {
  Eigen::VectorXd v(size);
  for (int i = 0; i < size; ++i) v[i] = sum_lanes(sums[i]);
  return turned_modes(transpose(axes), v);
}

}  // namespace

void PenaltyLinks::lay_out_elastic(const PointStore& points, const BondRecord& record) {
  elastic_.emplace();
  if (p_.law->fields() > 0) elastic_->tags.resize(blocks_.size());
  for (std::size_t i = 0; i < elastic_->tags.size(); ++i)
    for (int l = 0; l < kLanes; ++l)
      if (const int link = blocks_[i].link[l]; link >= 0) {
        const int slot = points.links[static_cast<std::size_t>(link)].slot;
        elastic_->tags[i][static_cast<std::size_t>(l)] = points.tags[static_cast<std::size_t>(slot / kLanes)][slot % kLanes];
      }
  std::size_t first = 0;
  for (int s = 0; s < 2; ++s) {
    ElasticEnds::Side& e = elastic_->side[static_cast<std::size_t>(s)];
    e.first_block = first;
    std::size_t end = first;
    while (end < blocks_.size() && blocks_[end].side == s) ++end;
    first = end;
    if (record.grain_E[s] == 0.0) continue;
    const Mat3<double> axes = mpdem::axes_of_patch(record, s);
    e.end = ElasticEnd(patch_of(record, s, cell_), axes);
    for (std::size_t i = e.first_block; i < end; ++i) {
      const vd* X = created_at(blocks_[i]);
      vd from[3], direction[3];
      for (int d = 0; d < 3; ++d) from[d] = X[d] - record.centre[s][d];
      const vd inverse = 1.0 / sqrt(from[0] * from[0] + from[1] * from[1] + from[2] * from[2]);
      for (int d = 0; d < 3; ++d) direction[d] = inverse * (axes.a[0][d] * from[0] + axes.a[1][d] * from[1] + axes.a[2][d] * from[2]);
      e.end.add_block(direction);
    }
    e.loads = e.before = e.debonded_loads = Eigen::VectorXd::Zero(e.end.size());
  }
}

Mat3<double> PenaltyLinks::axes_of_patch(int side, const BondEnd& s) const {
  return product(s.R, product(transpose(orientation_[side]), elastic_->side[static_cast<std::size_t>(side)].end.axes()));
}

TractionSecant PenaltyLinks::springs(std::size_t block) const {
  if (!elastic_->secants.empty()) return elastic_->secants[block];
  const LinkBlock& b = blocks_[block];
  const TractionStiffness& k = p_.law->of_material(b.material).stiffness();
  return softened(b.side, {splat(k.kn), splat(k.kt)});
}

std::vector<double> PenaltyLinks::modal_stiffness(int side) const {
  const ElasticEnds::Side& e = elastic_->side[static_cast<std::size_t>(side)];
  std::size_t end = e.first_block;
  while (end < blocks_.size() && blocks_[end].side == side) ++end;
  e.chunks.resize((end - e.first_block + ElasticEnds::kChunk - 1) / ElasticEnds::kChunk);
  std::vector<double> sums(static_cast<std::size_t>(e.end.size()) * static_cast<std::size_t>(e.end.modes() + 1), 0.0);
  std::vector<TractionSecant> of_blocks;
  for (std::size_t n = 0; n < e.chunks.size(); ++n) {
    const std::size_t first = ElasticEnds::kChunk * n;
    if (e.chunks[n].empty()) {
      of_blocks.clear();
      for (std::size_t i = e.first_block + first; i < std::min(end, e.first_block + first + ElasticEnds::kChunk); ++i) {
        const vd area = masked(link_flags_[i].attached, blocks_[i].area);
        const TractionSecant k = springs(i);
        of_blocks.push_back({area * k.kn, area * k.kt});
      }
      e.chunks[n] = e.end.stiffness(first, of_blocks);
    }
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += e.chunks[n][i];
  }
  return sums;
}

void PenaltyLinks::take_modal_stiffness(int side, const std::vector<double>& of_all, bool debonded) {
  ElasticEnds::Side& e = elastic_->side[static_cast<std::size_t>(side)];
  e.response = e.end.response(of_all);
  elastic_->some_debonded = elastic_->some_debonded || (debonded && e.amplitudes.size() > 0);
  elastic_->stiffness_changed = false;
}

void PenaltyLinks::note_debonding() {
  for (const ElasticEnds::Side& e : elastic_->side) elastic_->some_debonded = elastic_->some_debonded || e.amplitudes.size() > 0;
}

void PenaltyLinks::find_modal_loads(const Grid& grid, const BondEnd* ends, double dt) {
  with_basis(basis_, [&](auto type) {
    for (int side = 0; side < 2; ++side) {
      ElasticEnds::Side& e = elastic_->side[static_cast<std::size_t>(side)];
      if (e.end.is_rigid()) continue;
      const BondEnd& s = ends[side];
      Sums sums, sums_before;
      std::fill(sums, sums + e.end.size(), vd{});
      std::fill(sums_before, sums_before + e.end.size(), vd{});
      for (std::size_t i = e.first_block; i < blocks_.size() && blocks_[i].side == side; ++i) {
        const LinkBlock& b = blocks_[i];
        if (!link_flags_[i].attached) continue;
        const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
        const vd area = masked(link_flags_[i].attached, b.area);
        const TractionSecant k = springs(i);
        vd q[3], delta[3], n[3], f[3];
        find_separation(b, grid, s, w, q, delta, n);
        traction(k, delta, n, f);
        for (vd& component : f) component *= area;
        e.end.add_loads(i - e.first_block, f, sums);
        if (!elastic_->some_debonded) continue;
        vd v[3];
        find_velocity(b, grid, s, w, q, v);
        for (int d = 0; d < 3; ++d) delta[d] -= dt * v[d];
        traction(k, delta, n, f);
        for (vd& component : f) component *= area;
        e.end.add_loads(i - e.first_block, f, sums_before);
      }
      const Mat3<double> axes = axes_of_patch(side, s);
      e.loads = in_axes(axes, sums, e.end.size());
      if (e.softened_from.size() > 0) e.debonded_loads += e.softened_from - e.loads;
      e.softened_from.resize(0);
      if (elastic_->some_debonded) e.before = in_axes(axes, sums_before, e.end.size());
    }
  });
}

// Central differences of the springs of all links, before and after some of them debond. See energy_at_debonding(), which has the
// part without the modes.
void PenaltyLinks::find_amplitudes(int side, const Vector6& w) {
  ElasticEnds::Side& e = elastic_->side[static_cast<std::size_t>(side)];
  Eigen::VectorXd now = e.response.M * e.of_all;
  if (elastic_->coupled) now += e.response.H * w;
  elastic_->released += elastic_->some_debonded ? 0.5 * (e.before.dot(now) - (e.loads + e.debonded_loads).dot(e.amplitudes)) : 0.0;
  e.amplitudes = now;
  e.debonded_loads.setZero();
}

double PenaltyLinks::add_elastic_force(Grid& grid, BondEnd* ends) {
  with_basis(basis_, [&](auto type) {
    for (int side = 0; side < 2; ++side) {
      const ElasticEnds::Side& e = elastic_->side[static_cast<std::size_t>(side)];
      BondEnd& s = ends[side];
      const Eigen::VectorXd amplitudes = e.end.is_rigid() ? Eigen::VectorXd() : turned_modes(axes_of_patch(side, s), e.amplitudes);
      for (std::size_t i = e.first_block; i < blocks_.size() && blocks_[i].side == side; ++i) {
        const LinkBlock& b = blocks_[i];
        const std::uint8_t attached = link_flags_[i].attached;
        if (!attached) continue;
        const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
        const vd area = masked(attached, b.area);
        const TractionSecant k = springs(i);
        vd q[3], delta[3], n[3], u[3] = {}, f[3];
        find_separation(b, grid, s, w, q, delta, n);
        if (!e.end.is_rigid()) e.end.displacement(i - e.first_block, amplitudes.data(), u);
        for (int d = 0; d < 3; ++d) u[d] = delta[d] - u[d];
        traction(k, u, n, f);
        for (int d = 0; d < 3; ++d) f[d] *= -area;
        add_with_damper(b, w, k, q, n, f, grid, s);
      }
    }
  });
  const double released = elastic_->released;
  elastic_->released = 0.0;
  elastic_->some_debonded = false;
  return released;
}

void PenaltyLinks::add_whole_elastic_force(PointStore* points, Grid& grid, BondEnd* ends, double dt, LinkStep& step) {
  const auto find_loads = [&] {
    for (int side = 0; side < 2 && elastic_->stiffness_changed; ++side)
      if (ElasticEnds::Side& e = elastic_->side[static_cast<std::size_t>(side)]; !e.end.is_rigid())
        e.response = e.end.response(modal_stiffness(side));
    elastic_->stiffness_changed = false;
    find_modal_loads(grid, ends, dt);
    for (int side = 0; side < 2; ++side)
      if (modal_size(side) > 0) take_modal_loads(side, modal_loads(side));
  };
  find_secants(grid, ends);
  find_loads();
  const std::array<Vector6, 2> alone{Vector6::Zero(), Vector6::Zero()};
  if (points && update_elastic(*points, grid, ends, dt, alone, step)) find_loads();
  for (std::size_t side = 0; side < 2; ++side)
    if (modal_size(static_cast<int>(side)) > 0) find_amplitudes(static_cast<int>(side), alone[side]);
  step.released += add_elastic_force(grid, ends);
  std::sort(step.debond.begin(), step.debond.end());
}

// Secants of a layout follow from the present states and positions.
void PenaltyLinks::find_secants(const Grid& grid, const BondEnd* ends) {
  if (p_.law->fields() == 0 || !elastic_->secants.empty()) return;
  elastic_->secants.resize(blocks_.size());
  with_traction(*p_.law, [&](const auto& law) {
    with_basis(basis_, [&](auto type) {
      for (std::size_t i = 0; i < blocks_.size(); ++i) {
        const LinkBlock& b = blocks_[i];
        vd q[3], delta[3], n[3];
        find_separation(b, grid, ends[b.side], Weights<decltype(type)>(b.X, b.base, inverse_h_), q, delta, n);
        elastic_->secants[i] = secant_of(law.same_kind(b.material), i, delta, n, state(law, i));
      }
    });
  });
}

bool PenaltyLinks::update_elastic(PointStore& points, const Grid& grid, const BondEnd* ends, double dt, const std::array<Vector6, 2>& w,
                                  LinkStep& step) {
  if (p_.law->fields() == 0) return false;
  bool changed = false;
  std::array<Eigen::VectorXd, 2> loads;
  with_traction(*p_.law, [&](const auto& of_first) {
    if constexpr (std::decay_t<decltype(of_first)>::kFields > 0)
      with_basis(basis_, [&](auto type) {
        for (std::size_t side = 0; side < 2; ++side) {
          ElasticEnds::Side& e = elastic_->side[side];
          const BondEnd& s = ends[side];
          Eigen::VectorXd amplitudes;
          if (!e.end.is_rigid()) {
            amplitudes = e.response.M * e.of_all;
            if (elastic_->coupled) amplitudes += e.response.H * w[side];
            amplitudes = turned_modes(axes_of_patch(static_cast<int>(side), s), amplitudes);
          }
          loads[side] = e.loads;
          for (std::size_t i = e.first_block; i < blocks_.size() && blocks_[i].side == side; ++i) {
            const LinkBlock& b = blocks_[i];
            if (!link_flags_[i].attached) continue;
            vd q[3], delta[3], n[3], v[3], u[3] = {};
            const Weights<decltype(type)> weights(b.X, b.base, inverse_h_);
            find_separation(b, grid, s, weights, q, delta, n);
            find_velocity(b, grid, s, weights, q, v);
            if (!e.end.is_rigid()) e.end.displacement(i - e.first_block, amplitudes.data(), u);
            if (!update_elastic_block(of_first.same_kind(b.material), i, delta, n, u, v, dt, points, step)) continue;
            changed = true;
            if (!e.chunks.empty()) e.chunks[(i - e.first_block) / ElasticEnds::kChunk].clear();
          }
        }
      });
  });
  if (!changed) return false;
  elastic_->stiffness_changed = true;
  note_debonding();
  for (std::size_t side = 0; side < 2; ++side) elastic_->side[side].softened_from = loads[side];
  return true;
}

// Returns true if the secants changed. delta: separation from the undeformed surface, u: motion of the surface by the modes.
template <class L>
bool PenaltyLinks::update_elastic_block(const L& law, std::size_t i, const vd* delta, const vd* n, const vd* u, const vd* v, double dt,
                                        PointStore& points, LinkStep& step) {
  const std::uint8_t attached = link_flags_[i].attached;
  const vd area = masked(attached, blocks_[i].area);
  const TractionSecant before = elastic_->secants[i], share = elastic_->side[blocks_[i].side].end.share_of_link(before);
  const vd from_surface[3] = {delta[0] - u[0], delta[1] - u[1], delta[2] - u[2]};
  const LinkSeparation of_both = separation_of(from_surface, n);
  const vd opening = share.kn * of_both.n;
  typename L::State now = state(law, i);
  TractionUpdate change = law.update(counted({opening, opening * opening + share.kt * share.kt * of_both.tangential_square()}, i), now);
  const TractionSecant after = secant_of(law, i, delta, n, now);
  if (!any(((after.kn != before.kn) | (after.kt != before.kt) | change.grown) & lanes(attached))) return false;
  if (!strength_.empty()) change.dissipated *= strength_[i] * strength_[i];
  vd old[3];
  for (int d = 0; d < 3; ++d) old[d] = delta[d] - dt * v[d];
  const LinkSeparation then = separation_of(old, n), at = separation_of(delta, n);
  const vd product = old[0] * delta[0] + old[1] * delta[1] + old[2] * delta[2], kt = before.kt - after.kt;
  const vd taken = 0.5 * area * (kt * product + (before.kn - after.kn - kt) * then.n * at.n), dissipated = area * change.dissipated;
  step.dissipated += sum_lanes(dissipated);
  step.released += sum_lanes(taken - dissipated);
  elastic_->secants[i] = after;
  double none = 0.0;
  release(i, store_state(law, i, now, change, points, step), vd{}, false, points, none);
  return true;
}

void PenaltyLinks::add_freed(std::size_t i, std::uint8_t freed, const Grid& grid, const BondEnd& s) {
  const LinkBlock& b = blocks_[i];
  ElasticEnds::Side& e = elastic_->side[b.side];
  elastic_->stiffness_changed = true;
  if (!e.chunks.empty()) e.chunks[(i - e.first_block) / ElasticEnds::kChunk].clear();
  if (e.end.is_rigid() || e.amplitudes.size() == 0) return;
  elastic_->some_debonded = true;
  const TractionSecant k = springs(i);
  vd q[3], delta[3], n[3], f[3];
  with_basis(basis_, [&](auto type) { find_separation(b, grid, s, Weights<decltype(type)>(b.X, b.base, inverse_h_), q, delta, n); });
  traction(k, delta, n, f);
  for (vd& component : f) component *= masked(freed, b.area);
  Sums sums;
  std::fill(sums, sums + e.end.size(), vd{});
  e.end.add_loads(i - e.first_block, f, sums);
  e.debonded_loads += in_axes(axes_of_patch(b.side, s), sums, e.end.size());
}

double PenaltyLinks::modal_energy() const {
  double energy = 0.0;
  for (const ElasticEnds::Side& e : elastic_->side)
    if (e.amplitudes.size() > 0) energy += 0.5 * e.loads.dot(e.amplitudes);
  return energy;
}

void PenaltyLinks::continue_from(const PenaltyLinks& before) {
  if (!elastic_ || !before.elastic_) return;
  elastic_->coupled = before.elastic_->coupled;
  for (std::size_t s = 0; s < 2; ++s) {
    ElasticEnds::Side& to = elastic_->side[s];
    const ElasticEnds::Side& from = before.elastic_->side[s];
    if (to.end.size() != from.end.size()) continue;
    to.amplitudes = from.amplitudes;
    to.loads = from.loads;
  }
  if (before.elastic_->secants.empty()) return;
  using Key = std::pair<int, int>;  // ID of the point, and side
  const auto each_link = [](const PenaltyLinks& links, const auto& f) {
    for (std::size_t i = 0; i < links.blocks_.size(); ++i)
      for (int l = 0; l < kLanes; ++l)
        if (links.blocks_[i].link[l] >= 0) f(Key(links.elastic_->tags[i][static_cast<std::size_t>(l)], links.blocks_[i].side), i, l);
  };
  std::vector<std::pair<Key, std::array<double, 2>>> known;
  each_link(before, [&](const Key& key, std::size_t i, int l) {
    const TractionSecant& k = before.elastic_->secants[i];
    known.push_back({key, {k.kn[l], k.kt[l]}});
  });
  std::sort(known.begin(), known.end());
  std::vector<TractionSecant> secants(blocks_.size(), TractionSecant{vd{}, vd{}});
  bool all = true;
  each_link(*this, [&](const Key& key, std::size_t i, int l) {
    const auto found = std::lower_bound(known.begin(), known.end(), key, [](const auto& k, const Key& of) { return k.first < of; });
    if (found == known.end() || found->first != key) all = false;
    else secants[i].kn[l] = found->second[0], secants[i].kt[l] = found->second[1];
  });
  if (all) elastic_->secants = std::move(secants);
}

std::array<Eigen::VectorXd, 2> PenaltyLinks::small_modal_loads(const std::vector<Secant>& secants, const BondEnd* ends, const double* x,
                                                               const double (*motion)[6]) const {
  std::array<Eigen::VectorXd, 2> loads;
  with_basis(basis_, [&](auto type) {
    for (int side = 0; side < 2; ++side) {
      const ElasticEnds::Side& e = elastic_->side[static_cast<std::size_t>(side)];
      Sums sums;
      std::fill(sums, sums + e.end.size(), vd{});
      const double* g = motion[side];
      for (std::size_t i = e.first_block; i < blocks_.size() && blocks_[i].side == side && !e.end.is_rigid(); ++i) {
        const LinkBlock& b = blocks_[i];
        const Secant& s = secants[i];
        vd u[3], f[3];
        gather_value_by_lane(x, b.taken(), columns(b), Weights<decltype(type)>(b.X, b.base, inverse_h_), u);
        for (int d = 0; d < 3; ++d) {
          const int e1 = (d + 1) % 3, e2 = (d + 2) % 3;
          u[d] -= g[d] + g[3 + e1] * s.arm[e2] - g[3 + e2] * s.arm[e1];
        }
        traction({s.kn, s.kt}, u, s.n, f);
        e.end.add_loads(i - e.first_block, f, sums);
      }
      loads[static_cast<std::size_t>(side)] =
          e.end.is_rigid() ? Eigen::VectorXd() : in_axes(axes_of_patch(side, ends[side]), sums, e.end.size());
    }
  });
  return loads;
}

void PenaltyLinks::add_small_elastic_force(const std::vector<Secant>& secants, const BondEnd* ends,
                                           const std::array<Eigen::VectorXd, 2>& amplitudes, double* force, double (*load)[6]) const {
  with_basis(basis_, [&](auto type) {
    for (int side = 0; side < 2; ++side) {
      const ElasticEnds::Side& e = elastic_->side[static_cast<std::size_t>(side)];
      if (e.end.is_rigid()) continue;
      const Eigen::VectorXd turned = turned_modes(axes_of_patch(side, ends[side]), amplitudes[static_cast<std::size_t>(side)]);
      double* to = load[side];
      for (std::size_t i = e.first_block; i < blocks_.size() && blocks_[i].side == side; ++i) {
        const LinkBlock& b = blocks_[i];
        const std::uint8_t attached = link_flags_[i].attached;
        if (!attached) continue;
        const Secant& s = secants[i];
        vd u[3], f[3];
        e.end.displacement(i - e.first_block, turned.data(), u);
        traction({s.kn, s.kt}, u, s.n, f);
        scatter_value_by_lane(force, attached, columns(b), Weights<decltype(type)>(b.X, b.base, inverse_h_), f);
        for (int d = 0; d < 3; ++d) {
          const int e1 = (d + 1) % 3, e2 = (d + 2) % 3;
          to[d] -= sum_lanes(f[d]);
          to[3 + d] -= sum_lanes(s.arm[e1] * f[e2] - s.arm[e2] * f[e1]);
        }
      }
    }
  });
}

}  // namespace mpdem
