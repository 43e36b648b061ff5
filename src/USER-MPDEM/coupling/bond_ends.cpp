// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "bond_ends.h"

#include <algorithm>

#include "../numerics/sort_unique.h"

namespace mpdem {

namespace {
constexpr int kMotion = 27;  // present, x, v, omega, q, a, alpha, mass_ratio, jump

// Rotates a vector from the axes of the box to those of an end.
void take(const BondEnd& s, const double* of_box, double* to) {
  const std::array<double, 3> v = turned_back(s.axes, of_box);
  std::copy(v.begin(), v.end(), to);
}
}  // namespace

void BondEnds::build(MPI_Comm comm, const std::vector<BondRecord>& records, const std::vector<int>& here, const std::vector<Key>& owned) {
  std::vector<Key> keys = owned;
  for (const Key& k : owned) keys.push_back({k.field(), 1 - k.at(0), 0, 0});
  for (int row : here)
    for (int s = 0; s < 2; ++s) keys.push_back({row, s, 0, 0});
  sort_unique(keys);
  ends.assign(keys.size(), BondEnd{});
  for (std::size_t i = 0; i < keys.size(); ++i) {
    ends[i].row = row_of(keys[i].field());
    ends[i].side = keys[i].at(0);
    ends[i].tag = records[ends[i].row].grain[ends[i].side];
    ends[i].axes = axes_of(records[ends[i].row]);
  }
  owned_at_.clear();
  for (const Key& k : owned) owned_at_.push_back(static_cast<int>(std::lower_bound(keys.begin(), keys.end(), k) - keys.begin()));
  halo_.build(comm, keys);
}

int BondEnds::find(int row, int side) const {
  const auto it = std::lower_bound(ends.begin(), ends.end(), std::make_pair(row, side),
                                   [](const BondEnd& a, const std::pair<int, int>& b) { return std::make_pair(a.row, a.side) < b; });
  return it != ends.end() && it->row == row && it->side == side ? static_cast<int>(it - ends.begin()) : -1;
}

void BondEnds::distribute(const std::vector<BondRecord>& records, const std::vector<Motion>& motion) {
  buffer_.assign(kMotion * ends.size(), 0.0);
  for (std::size_t i = 0; i < owned_at_.size(); ++i) {
    double* b = &buffer_[kMotion * owned_at_[i]];
    const BondEnd& s = ends[owned_at_[i]];
    const BondRecord& record = records[s.row];
    const Motion& m = motion[i];
    b[0] = 1.0;
    for (int d = 0; d < 3; ++d) {
      b[1 + d] = m.x[d] + record.shift[s.side][d] - record.origin[d];
      b[4 + d] = m.v[d];
      b[7 + d] = m.omega[d];
    }
    for (int d = 0; d < 4; ++d) b[10 + d] = m.q[d];
    for (int d = 0; d < 3; ++d) {
      b[14 + d] = m.a[d];
      b[17 + d] = m.alpha[d];
    }
    b[20] = m.mass_ratio;
    std::copy(m.jump, m.jump + 6, b + 21);
  }
  // All ranks but the owner contribute zero, so the sum is exactly the value of the owner.
  halo_.sum(buffer_.data(), kMotion);
  orphan_ = -1;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const double* b = &buffer_[kMotion * i];
    BondEnd& s = ends[i];
    if (b[0] != 1.0 && records[s.row].has_grain(s.side)) orphan_ = static_cast<int>(i);
    take(s, b + 1, s.x);
    take(s, b + 4, s.v);
    take(s, b + 7, s.omega);
    take(s, b + 14, s.a);
    take(s, b + 17, s.alpha);
    s.mass_ratio = b[20];
    take(s, b + 21, s.jump);
    take(s, b + 24, s.jump + 3);
    s.R = product(transpose(s.axes), rotation_of(b + 10));
  }
}

void BondEnds::send_to_copies(const std::vector<std::array<double, 6>>& values) {
  buffer_.assign(6 * ends.size(), 0.0);
  for (std::size_t i = 0; i < owned_at_.size(); ++i) std::copy(values[i].begin(), values[i].end(), &buffer_[6 * owned_at_[i]]);
  halo_.sum(buffer_.data(), 6);
}

void BondEnds::set_jumps(const std::vector<std::array<double, 6>>& jump) {
  send_to_copies(jump);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    take(ends[i], &buffer_[6 * i], ends[i].jump);
    take(ends[i], &buffer_[6 * i + 3], ends[i].jump + 3);
  }
}

void BondEnds::set_accelerations(const std::vector<std::array<double, 6>>& acceleration) {
  send_to_copies(acceleration);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    take(ends[i], &buffer_[6 * i], ends[i].a);
    take(ends[i], &buffer_[6 * i + 3], ends[i].alpha);
  }
}

void BondEnds::clear_forces() {
  for (BondEnd& s : ends)
    for (int d = 0; d < 3; ++d) s.force[d] = s.torque[d] = s.impulse[d] = s.impulse[3 + d] = 0.0;
}

void BondEnds::clear_sudden_forces() {
  for (BondEnd& s : ends)
    for (int d = 0; d < 6; ++d) s.jump_force[d] = s.transfer_force[d] = 0.0;
}

void BondEnds::sum_sudden_forces() {
  buffer_.resize(12 * ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    std::copy(ends[i].jump_force, ends[i].jump_force + 6, &buffer_[12 * i]);
    std::copy(ends[i].transfer_force, ends[i].transfer_force + 6, &buffer_[12 * i + 6]);
  }
  halo_.sum(buffer_.data(), 12);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    std::copy(&buffer_[12 * i], &buffer_[12 * i] + 6, ends[i].jump_force);
    std::copy(&buffer_[12 * i + 6], &buffer_[12 * i] + 12, ends[i].transfer_force);
  }
}

void BondEnds::sum_forces() {
  buffer_.resize(6 * ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i)
    for (int d = 0; d < 3; ++d) {
      buffer_[6 * i + d] = ends[i].force[d];
      buffer_[6 * i + 3 + d] = ends[i].torque[d];
    }
  halo_.sum(buffer_.data(), 6);
  for (std::size_t i = 0; i < ends.size(); ++i)
    for (int d = 0; d < 3; ++d) {
      ends[i].force[d] = buffer_[6 * i + d];
      ends[i].torque[d] = buffer_[6 * i + 3 + d];
    }
}

}  // namespace mpdem
