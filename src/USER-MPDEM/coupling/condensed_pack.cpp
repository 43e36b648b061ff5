// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "condensed_pack.h"

#include <algorithm>
#include <cmath>

#include "../numerics/rotation.h"
#include "../numerics/sort_unique.h"

namespace mpdem {

namespace {

using Vec = Three<vd>;
using Mat = Mat3<vd>;

// Returns q x q^T.
Mat turned(const Mat& q, const Mat& x) { return product(product(q, x), transpose(q)); }

// Returns x [r], where [r] v = r x v. cross_times() returns [r] x.
Mat times_cross(const Mat& x, const Vec& r) {
  Mat y;
  for (int i = 0; i < 3; ++i) {
    const Vec row = cross(Vec{{x.a[i][0], x.a[i][1], x.a[i][2]}}, r);
    for (int j = 0; j < 3; ++j) y.a[i][j] = row.a[j];
  }
  return y;
}
Mat cross_times(const Vec& r, const Mat& x) {
  Mat y;
  for (int j = 0; j < 3; ++j) {
    const Vec column = cross(r, Vec{{x.a[0][j], x.a[1][j], x.a[2][j]}});
    for (int i = 0; i < 3; ++i) y.a[i][j] = column.a[i];
  }
  return y;
}
Mat operator+(const Mat& x, const Mat& y) {
  Mat z;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) z.a[i][j] = x.a[i][j] + y.a[i][j];
  return z;
}
Mat operator-(const Mat& x, const Mat& y) {
  Mat z;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) z.a[i][j] = x.a[i][j] - y.a[i][j];
  return z;
}

// generalized: forces on the twelve velocities in the axes Q, with the opposite sign. along: direction of the line of
// centres, in these axes.
vd tension_of(const vd* generalized, const Vec& along) {
  vd sum{};
  for (int d = 0; d < 3; ++d) sum += (generalized[6 + d] - generalized[d]) * along.a[d];
  return splat(0.5) * sum;
}

}  // namespace

void CondensedPack::fill(Block& b, int lane, const Entry& entry) {
  const CondensedModel& m = *entry.model;
  const BondRecord& record = *entry.record;
  for (int s = 0; s < 2; ++s) {
    const double* q = record.orientation[s];
    for (int d = 0; d < 4; ++d) b.inverse_orientation[s][d][lane] = d == 0 ? q[0] : -q[d];
    for (int d = 0; d < 3; ++d) b.arm[s][d][lane] = m.middle[d] - record.centre[s][d];
  }
  for (int d = 0; d < 3; ++d) b.shift[d][lane] = record.shift[1][d] - record.shift[0][d];
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) b.K[lower_triangle(i, j)][lane] = m.K(i, j);
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j <= i; ++j) b.M[lower_triangle(i, j)][lane] = m.M(i, j);
  constexpr int column[6][2] = {{0, 0}, {4, 4}, {8, 8}, {5, 7}, {2, 6}, {1, 3}};  // xx, yy, zz, both yz, both xz, both xy
  for (int i = 0; i < 6; ++i)
    for (int c = 0; c < 6; ++c)
      b.N[6 * i + c][lane] = column[c][0] == column[c][1] ? m.N(6 + i, column[c][0]) : m.N(6 + i, column[c][0]) + m.N(6 + i, column[c][1]);
  // First and second moments of the mass about the middle, for both grains moving as one.
  const Eigen::Matrix<double, 6, 9> rigid = m.N.topRows<6>() + m.N.bottomRows<6>();
  for (int d = 0; d < 3; ++d) b.first[d][lane] = rigid(0, d);
  const double second[6] = {rigid(5, 3), -rigid(5, 1), rigid(4, 2), rigid(4, 1), rigid(4, 0), -rigid(5, 0)};
  for (int c = 0; c < 6; ++c) b.second[c][lane] = second[c];
  for (int j = 0; j < 6; ++j) b.bound[j][lane] = entry.bound[j];
}

void CondensedPack::build(MPI_Comm comm, const std::vector<Entry>& entries, const std::vector<Grain>& grains) {
  int some = !entries.empty(), any;
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, comm);
  any_ = any != 0;
  blocks_.clear();
  tags_.clear();
  slot_of_owned_.clear();
  for (auto* of_slots : {&load_, &jump_load_, &inertial_load_, &weight_, &mass_}) of_slots->clear();
  inertial_coupling_ = 0.0;
  if (!any_) return;
  for (const Grain& g : grains) tags_.push_back(g.tag);
  for (const Entry& p : entries) tags_.insert(tags_.end(), p.record->grain, p.record->grain + 2);
  sort_unique(tags_);
  const auto slot_of = [&](int tag) { return static_cast<int>(std::lower_bound(tags_.begin(), tags_.end(), tag) - tags_.begin()); };
  owned_.assign(tags_.size(), 0);
  for (const Grain& g : grains) {
    slot_of_owned_.push_back(slot_of(g.tag));
    owned_[slot_of_owned_.back()] = 1;
  }
  std::vector<Key> keys;
  for (int tag : tags_) keys.push_back({tag, 0, 0, 0});
  halo_.build(comm, keys);
  blocks_.resize((entries.size() + kLanes - 1) / kLanes);
  double most = 0.0;
  for (std::size_t n = 0; n < kLanes * blocks_.size(); ++n) {  // spare lanes have the last bond, but do not add its loads
    Block& b = blocks_[n / kLanes];
    const int lane = static_cast<int>(n % kLanes);
    const Entry& entry = entries[std::min(n, entries.size() - 1)];
    fill(b, lane, entry);
    for (int s = 0; s < 2; ++s) b.slot[s][lane] = slot_of(entry.record->grain[s]);
    if (n >= entries.size()) continue;
    b.count = lane + 1;
    most = std::max(most, entry.model->inertial_coupling);
  }
  MPI_Allreduce(&most, &inertial_coupling_, 1, MPI_DOUBLE, MPI_MAX, comm);
  motion_.assign(kMotion * tags_.size(), 0.0);
  acceleration_.assign(6 * tags_.size(), 0.0);
  load_.assign(6 * tags_.size(), 0.0);
  inertial_load_.assign(6 * tags_.size(), 0.0);
  mass_.assign(kSym6 * tags_.size(), 0.0);
}

void CondensedPack::send_to_slots(double* values, int width) { halo_.sum(values, width); }

void CondensedPack::distribute(const std::vector<Grain>& grains) {
  if (!any_) return;
  std::fill(motion_.begin(), motion_.end(), 0.0);
  for (std::size_t n = 0; n < grains.size(); ++n) {
    double* to = &motion_[static_cast<std::size_t>(kMotion) * slot_of_owned_[n]];
    const Grain& g = grains[n];
    const GrainState& state = *g.state;
    to[0] = 1.0;
    std::copy(g.x, g.x + 3, to + kX);
    std::copy(state.q, state.q + 4, to + kQ);
    std::copy(state.v + 3, state.v + 6, to + kOmega);
    std::copy(state.v, state.v + 3, to + kV);
    std::copy(state.a, state.a + 3, to + kA);
    std::copy(state.jump, state.jump + 6, to + kJump);
    to[kRatio] = g.mass_ratio;
  }
  send_to_slots(motion_.data(), kMotion);
  for (std::size_t i = 0; i < tags_.size(); ++i)
    for (int d = 0; d < 6; ++d) acceleration_[6 * i + d] = d < 3 ? motion_[kMotion * i + kA + d] : 0.0;
}

void CondensedPack::set_accelerations(const double* of_owned) {
  if (!any_) return;
  for (std::size_t i = 0; i < tags_.size(); ++i)
    if (!owned_[i]) std::fill(&acceleration_[6 * i], &acceleration_[6 * i] + 6, 0.0);
  for (std::size_t n = 0; n < slot_of_owned_.size(); ++n)
    std::copy(of_owned + 6 * n, of_owned + 6 * n + 6, &acceleration_[6 * slot_of_owned_[n]]);
  send_to_slots(acceleration_.data(), 6);
}

void CondensedPack::set_jumps(const double* of_owned) {
  if (!any_) return;
  work_.assign(6 * tags_.size(), 0.0);
  for (std::size_t n = 0; n < slot_of_owned_.size(); ++n) std::copy(of_owned + 6 * n, of_owned + 6 * n + 6, &work_[6 * slot_of_owned_[n]]);
  send_to_slots(work_.data(), 6);
  for (std::size_t i = 0; i < tags_.size(); ++i) std::copy(&work_[6 * i], &work_[6 * i] + 6, &motion_[kMotion * i + kJump]);
}

void CondensedPack::find_loads(const double* gravity) {
  if (!any_) return;
  const bool weighs = gravity[0] != 0.0 || gravity[1] != 0.0 || gravity[2] != 0.0;
  std::fill(load_.begin(), load_.end(), 0.0);
  std::fill(inertial_load_.begin(), inertial_load_.end(), 0.0);
  std::fill(mass_.begin(), mass_.end(), 0.0);
  weight_.assign(weighs ? load_.size() : 0, 0.0);
  jump_load_.clear();
  for (Block& b : blocks_) find_loads(b, weighs ? gravity : nullptr);
  for (std::size_t i = 0; i < weight_.size(); ++i) load_[i] += weight_[i];
}

// generalized: forces on the twelve velocities in the axes Q, with the opposite sign.
void CondensedPack::add_loads(const Block& b, const RelativeMotion<vd>& m, const vd* generalized, std::vector<double>& to) const {
  vd l[2][6];
  for (int s = 0; s < 2; ++s) {
    const vd* g = generalized + 6 * s;
    const Vec f = turned(m.Q, Vec{{-g[0], -g[1], -g[2]}}), t = turned(m.Q, Vec{{-g[3], -g[4], -g[5]}}) + cross(m.r[s], f);
    for (int d = 0; d < 3; ++d) {
      l[s][d] = f.a[d];
      l[s][3 + d] = t.a[d];
    }
  }
  for (int lane = 0; lane < b.count; ++lane)
    for (int s = 0; s < 2; ++s) {
      double* of = &to[6 * b.slot[s][lane]];
      for (int d = 0; d < 6; ++d) of[d] += l[s][d][lane];
    }
}

void CondensedPack::find_weight(Block& b, const RelativeMotion<vd>& m, const double* gravity, const Vec& along) {
  const Vec g = turned_back(m.Q, Vec{{splat(gravity[0]), splat(gravity[1]), splat(gravity[2])}});
  vd of_weight[12];
  for (int i = 0; i < 12; ++i) {
    of_weight[i] = vd{};
    for (int d = 0; d < 3; ++d) of_weight[i] -= (b.M[lower_triangle(i, d)] + b.M[lower_triangle(i, 6 + d)]) * g.a[d];
  }
  add_loads(b, m, of_weight, weight_);
  b.tension += mpdem::tension_of(of_weight, turned_back(m.Q, along));
}

void CondensedPack::find_loads(Block& b, const double* gravity) {
  Mat turn[2];
  Vec arm[2], x[2], omega[2];
  for (int s = 0; s < 2; ++s) {
    const auto lanes_of = [&](int number) {
      vd v{};
      for (int l = 0; l < kLanes; ++l) v[l] = motion_[static_cast<std::size_t>(kMotion) * b.slot[s][l] + number];
      return v;
    };
    for (int d = 0; d < 3; ++d) {
      x[s].a[d] = lanes_of(kX + d);
      omega[s].a[d] = lanes_of(kOmega + d);
    }
    const vd q[4] = {lanes_of(kQ), lanes_of(kQ + 1), lanes_of(kQ + 2), lanes_of(kQ + 3)};
    turn[s] = rotation_of(quaternion_product(q, b.inverse_orientation[s]).data());
    arm[s] = Vec{{b.arm[s][0], b.arm[s][1], b.arm[s][2]}};
  }
  const Vec apart = x[1] - x[0] + Vec{{b.shift[0], b.shift[1], b.shift[2]}};
  const RelativeMotion<vd> m(turn, arm, apart);
  const Vec along = splat(1.0) / sqrt(dot(apart, apart)) * apart;
  vd f[6], *const d = b.d;
  for (int c = 0; c < 3; ++c) {
    d[c] = m.delta.a[c];
    d[3 + c] = m.theta.a[c];
  }
  b.level = vd{};
  for (int i = 0; i < 6; ++i) {
    b.level += abs(d[i]) * b.bound[i];
    f[i] = vd{};
    for (int j = 0; j < 6; ++j) f[i] += b.K[lower_triangle(i, j)] * d[j];
  }
  Vec force, moment;
  m.load(Vec{{f[0], f[1], f[2]}}, Vec{{f[3], f[4], f[5]}}, force, moment);
  const Vec moment0 = cross(force, m.apart) - moment;
  // Inertia forces that do not depend on the accelerations: N : B, and M times the centripetal accelerations of the p_s.
  // The rows of N for grain 0 are those of a rigid body less those for grain 1.
  Vec to_axis[2];
  for (int s = 0; s < 2; ++s) to_axis[s] = turned_back(m.Q, cross(omega[s], cross(omega[s], m.r[s])));
  const Vec w = splat(0.5) * turned_back(m.Q, omega[0] + omega[1]);
  const vd w2 = dot(w, w);
  const vd B[6] = {w.a[0] * w.a[0] - w2, w.a[1] * w.a[1] - w2, w.a[2] * w.a[2] - w2, w.a[1] * w.a[2], w.a[0] * w.a[2], w.a[0] * w.a[1]};
  const Vec first{{b.first[0], b.first[1], b.first[2]}};
  const Vec resultant = dot(w, first) * w - w2 * first;
  const vd* T = b.second;
  const Vec couple = cross(Vec{{T[0] * w.a[0] + T[5] * w.a[1] + T[4] * w.a[2], T[5] * w.a[0] + T[1] * w.a[1] + T[3] * w.a[2],
                                T[4] * w.a[0] + T[3] * w.a[1] + T[2] * w.a[2]}},
                           w);
  vd generalized[12];
  for (int i = 0; i < 6; ++i) {
    vd of_second = vd{};
    for (int c = 0; c < 6; ++c) of_second += b.N[6 * i + c] * B[c];
    generalized[i] = (i < 3 ? resultant.a[i % 3] : couple.a[i % 3]) - of_second;
    generalized[6 + i] = of_second;
  }
  for (int i = 0; i < 12; ++i)
    for (int c = 0; c < 3; ++c)
      generalized[i] += b.M[lower_triangle(i, c)] * to_axis[0].a[c] + b.M[lower_triangle(i, 6 + c)] * to_axis[1].a[c];
  add_loads(b, m, generalized, load_);
  b.tension = mpdem::tension_of(generalized, turned_back(m.Q, along)) - dot(force, along);
  for (int lane = 0; lane < b.count; ++lane) {
    double *l0 = &load_[6 * b.slot[0][lane]], *l1 = &load_[6 * b.slot[1][lane]];
    for (int c = 0; c < 3; ++c) {
      l0[c] -= force.a[c][lane];
      l0[3 + c] += moment0.a[c][lane];
      l1[c] += force.a[c][lane];
      l1[3 + c] += moment.a[c][lane];
    }
  }
  if (gravity) find_weight(b, m, gravity, along);
  find_masses(b, m, along);
}

void CondensedPack::find_masses(Block& b, const RelativeMotion<vd>& m, const Vec& along) {
  // Centres move p_s by T = (1, -[r]; 0, 1), so M becomes T^T M T. The tension is (F_0 - F_1).along/2 with F = -M a.
  const Vec half = splat(0.5) * along;
  const auto add_lag = [&](int s, const Vec& of_force, const Mat& of_v, const Mat& of_omega) {
    const Vec v = turned_back(of_v, of_force), omega = turned_back(of_omega, of_force);
    for (int d = 0; d < 3; ++d) {
      b.lag[s][d] += v.a[d];
      b.lag[s][3 + d] += omega.a[d];
    }
  };
  for (auto& side : b.lag) std::fill(side, side + 6, vd{});

  const auto block = [&](int row, int column) {
    Mat x;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) x.a[i][j] = b.M[lower_triangle(row + i, column + j)];
    return turned(m.Q, x);
  };
  for (int s = 0; s < 2; ++s) {
    const Vec& r = m.r[s];
    const Mat a = block(6 * s, 6 * s), b0 = block(6 * s, 6 * s + 3);
    const Mat upper_right = b0 - times_cross(a, r), lower_left = transpose(upper_right);
    const Mat lower_right = block(6 * s + 3, 6 * s + 3) - times_cross(transpose(b0), r) + cross_times(r, upper_right);
    add_lag(s, s == 0 ? half : splat(-1.0) * half, a, upper_right);
    for (int lane = 0; lane < b.count; ++lane) {
      double* to = &mass_[kSym6 * b.slot[s][lane]];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j <= i; ++j) {
          to[lower_triangle(i, j)] += a.a[i][j][lane];
          to[lower_triangle(3 + i, 3 + j)] += lower_right.a[i][j][lane];
        }
        for (int j = 0; j < 3; ++j) to[lower_triangle(3 + i, j)] += lower_left.a[i][j][lane];
      }
    }
  }
  const Vec &r0 = m.r[0], &r1 = m.r[1];
  const Mat a = block(0, 6), c = block(3, 6);
  const Mat upper_right = block(0, 9) - times_cross(a, r1);
  const Mat lower_left = c + cross_times(r0, a), lower_right = block(3, 9) - times_cross(c, r1) + cross_times(r0, upper_right);
  add_lag(0, splat(-1.0) * half, transpose(a), transpose(lower_left));
  add_lag(1, half, a, upper_right);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      b.C[6 * i + j] = a.a[i][j];
      b.C[6 * i + 3 + j] = upper_right.a[i][j];
      b.C[6 * (3 + i) + j] = lower_left.a[i][j];
      b.C[6 * (3 + i) + 3 + j] = lower_right.a[i][j];
    }
}

void CondensedPack::subtract_coupling_loads(const std::vector<double>& rates, std::vector<double>& loads) const {
  for (const Block& b : blocks_) {
    vd rate[2][6], load[2][6] = {};
    for (int s = 0; s < 2; ++s)
      for (int l = 0; l < kLanes; ++l) {
        const double* from = &rates[6 * b.slot[s][l]];
        for (int d = 0; d < 6; ++d) rate[s][d][l] = from[d];
      }
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) {
        load[0][i] += b.C[6 * i + j] * rate[1][j];
        load[1][j] += b.C[6 * i + j] * rate[0][i];
      }
    for (int lane = 0; lane < b.count; ++lane)
      for (int s = 0; s < 2; ++s) {
        double* to = &loads[6 * b.slot[s][lane]];
        for (int d = 0; d < 6; ++d) to[d] -= load[s][d][lane];
      }
  }
}

vd CondensedPack::tension_of(const Block& b) const {
  vd tension = b.tension;
  for (int s = 0; s < 2; ++s)
    for (int d = 0; d < 6; ++d) {
      vd rate;
      for (int l = 0; l < kLanes; ++l) rate[l] = acceleration_[6 * b.slot[s][l] + d];
      tension -= b.lag[s][d] * rate;
    }
  return tension;
}

bool CondensedPack::at_rest() const {
  return std::all_of(acceleration_.begin(), acceleration_.end(), [](double a) { return a == 0.0; });
}

void CondensedPack::subtract_coupling(double* of_owned) {
  if (!any_) return;
  work_.assign(6 * tags_.size(), 0.0);
  subtract_coupling_loads(acceleration_, work_);
  for (std::size_t n = 0; n < slot_of_owned_.size(); ++n)
    for (int d = 0; d < 6; ++d) of_owned[6 * n + d] += work_[6 * slot_of_owned_[n] + d];
}

void CondensedPack::find_inertial_loads() {
  if (!any_) return;
  std::fill(inertial_load_.begin(), inertial_load_.end(), 0.0);
  subtract_coupling_loads(acceleration_, inertial_load_);
  for (int slot : slot_of_owned_) {
    double of_own[6] = {};
    add_product_sym6(&mass_[kSym6 * slot], &acceleration_[6 * slot], of_own);
    for (int d = 0; d < 6; ++d) inertial_load_[6 * slot + d] -= of_own[d];
  }
}

void CondensedPack::find_jump_loads(double dt) {
  if (!any_) return;
  work_.assign(6 * tags_.size(), 0.0);
  bool jumps = false;
  for (std::size_t i = 0; i < tags_.size(); ++i)
    for (int d = 0; d < 6; ++d) {
      work_[6 * i + d] = motion_[kMotion * i + kJump + d] / dt;
      jumps = jumps || work_[6 * i + d] != 0.0;
    }
  if (!jumps) return;
  jump_load_.assign(6 * tags_.size(), 0.0);
  subtract_coupling_loads(work_, jump_load_);
  for (int slot : slot_of_owned_) {
    double of_own[6] = {};
    add_product_sym6(&mass_[kSym6 * slot], &work_[6 * slot], of_own);
    for (int d = 0; d < 6; ++d) jump_load_[6 * slot + d] -= of_own[d];
  }
}

bool CondensedPack::any_level_reaches(double level) const {
  vmask reached = splat_mask(false);
  for (const Block& b : blocks_) reached |= b.level >= level;
  return mpdem::any(reached);
}

std::array<BondEnd, 2> CondensedPack::ends(int member, const BondRecord& record) const {
  const Block& b = blocks_[member / kLanes];
  std::array<BondEnd, 2> ends{};
  for (int s = 0; s < 2; ++s) {
    const int slot = b.slot[s][member % kLanes];
    const double *m = &motion_[static_cast<std::size_t>(kMotion) * slot], *a = &acceleration_[6 * slot];
    ends[s].side = s;
    ends[s].mass_ratio = m[kRatio];
    ends[s].tag = tags_[slot];
    ends[s].axes = axes_of(record);
    const auto take = [&](const double* of_box, double* to) {
      const std::array<double, 3> v = turned_back(ends[s].axes, of_box);
      std::copy(v.begin(), v.end(), to);
    };
    double x[3];
    for (int d = 0; d < 3; ++d) x[d] = m[kX + d] + record.shift[s][d] - record.origin[d];
    take(x, ends[s].x);
    take(m + kV, ends[s].v);
    take(m + kOmega, ends[s].omega);
    take(a, ends[s].a);
    take(a + 3, ends[s].alpha);
    take(m + kJump, ends[s].jump);
    take(m + kJump + 3, ends[s].jump + 3);
    ends[s].R = product(transpose(ends[s].axes), rotation_of(m + kQ));
  }
  return ends;
}

int CondensedPack::orphan() const {
  for (std::size_t i = 0; i < tags_.size(); ++i)
    if (motion_[kMotion * i] != 1.0) return tags_[i];
  return 0;
}

std::size_t CondensedPack::memory_usage() const { return blocks_.capacity() * sizeof(Block) + motion_.capacity() * sizeof(double); }

}  // namespace mpdem
