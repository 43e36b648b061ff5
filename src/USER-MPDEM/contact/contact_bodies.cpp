// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "contact_bodies.h"

#include <algorithm>

#include "../numerics/rotation.h"
#include "../numerics/sort_unique.h"

namespace mpdem {

Eigen::Matrix3d matrix_of(const double* q) {
  const Mat3<double> R = rotation_of(q);
  Eigen::Matrix3d M;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) M(i, j) = R.a[i][j];
  return M;
}

int BodyMotions::index_of(int tag) const { return static_cast<int>(std::lower_bound(tags_.begin(), tags_.end(), tag) - tags_.begin()); }

void BodyMotions::set(MPI_Comm comm, const std::vector<ContactBody>& bodies, const std::vector<int>& others,
                      const std::vector<CementPiece>& pieces) {
  tags_ = others;
  for (const ContactBody& b : bodies) tags_.push_back(b.tag);
  sort_unique(tags_);
  std::vector<Key> keys;
  for (int tag : tags_) keys.push_back({tag, 0, 0, 0});
  halo_.build(comm, keys);
  motions_.assign(tags_.size(), BodyMotion());
  for (const CementPiece& p : pieces) {
    const std::size_t m = static_cast<std::size_t>(index_of(p.grain));
    if (m < tags_.size() && tags_[m] == p.grain) motions_[m].reach = std::max(motions_[m].reach, vector3(p.middle).norm() + p.reach);
  }
  of_body_.clear();
  for (const ContactBody& b : bodies) of_body_.push_back(index_of(b.tag));
  take(bodies);
}

void BodyMotions::take(const std::vector<ContactBody>& bodies) {
  constexpr int kNumbers = 14;
  buffer_.assign(kNumbers * tags_.size(), 0.0);
  for (std::size_t n = 0; n < bodies.size(); ++n) {
    const ContactBody& b = bodies[n];
    double* to = &buffer_[static_cast<std::size_t>(kNumbers) * of_body_[n]];
    std::copy(b.x, b.x + 3, to);
    std::copy(b.v, b.v + 3, to + 3);
    std::copy(b.omega, b.omega + 3, to + 6);
    std::copy(b.q, b.q + 4, to + 9);
    to[13] = b.radius;
  }
  halo_.sum(buffer_.data(), kNumbers);
  const double* from = buffer_.data();
  for (BodyMotion& m : motions_) {
    m.x = vector3(from);
    m.v = vector3(from + 3);
    m.omega = vector3(from + 6);
    m.R = matrix_of(from + 9);
    m.radius = from[13];
    m.force = m.torque = Eigen::Vector3d::Zero();
    from += kNumbers;
  }
}

void BodyMotions::give_forces(std::vector<ContactBody>& bodies) {
  buffer_.resize(6 * motions_.size());
  for (std::size_t n = 0; n < motions_.size(); ++n)
    for (int d = 0; d < 3; ++d) {
      buffer_[6 * n + d] = motions_[n].force[d];
      buffer_[6 * n + 3 + d] = motions_[n].torque[d];
    }
  halo_.sum(buffer_.data(), 6);
  for (std::size_t n = 0; n < bodies.size(); ++n) {
    const double* of_body = &buffer_[6 * static_cast<std::size_t>(of_body_[n])];
    std::copy(of_body, of_body + 3, bodies[n].force);
    std::copy(of_body + 3, of_body + 6, bodies[n].torque);
  }
}

}  // namespace mpdem
