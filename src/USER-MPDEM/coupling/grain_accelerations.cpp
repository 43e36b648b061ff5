// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "grain_accelerations.h"

#include <algorithm>
#include <cmath>

#include "../numerics/cross_matrix.h"

namespace mpdem {

namespace {

constexpr double kPrecision = 1e-10;  // of the energy that is kept, not of the momentum
constexpr int kMostSweeps = 200;

using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;

// Sum of [r][q]^T with second moments T of r and q: (r.q) - q r^T.
Matrix3 turning(const Matrix3& T) { return T.trace() * Matrix3::Identity() - T.transpose(); }

Vector3 distance(const GrainSide& from, const GrainSide& to) { return Eigen::Map<const Vector3>(from.x) - Eigen::Map<const Vector3>(to.x); }

Matrix3 second(const std::array<double, MassMoments::kSize>& m) {
  Matrix3 T;
  T << m[4], m[9], m[8], m[9], m[5], m[7], m[8], m[7], m[6];
  return T;
}

// From the axes of a side to those of the box.
Eigen::Matrix<double, 6, 6> turn_of(const GrainSide& s) {
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) turn(i, j) = turn(3 + i, 3 + j) = s.axes.a[i][j];
  return turn;
}

}  // namespace

void MassMoments::add(double mass, const double* r, double* m) {
  const double x = mass * r[0], y = mass * r[1], z = mass * r[2];
  const double add[kSize] = {mass, x, y, z, x * r[0], y * r[1], z * r[2], y * r[2], x * r[2], x * r[1]};
  for (int i = 0; i < kSize; ++i) m[i] += add[i];
}

Eigen::Matrix<double, 6, 6> MassMoments::matrix() const {
  const double none[3] = {0, 0, 0};
  return coupling(none);
}

Eigen::Matrix<double, 6, 6> MassMoments::coupling(const double* e) const {
  const Vector3 S(m[1], m[2], m[3]), E(e[0], e[1], e[2]);
  Eigen::Matrix<double, 6, 6> B;
  B.topLeftCorner<3, 3>() = m[0] * Matrix3::Identity();
  B.topRightCorner<3, 3>() = -cross(S + m[0] * E);
  B.bottomLeftCorner<3, 3>() = cross(S);
  B.bottomRightCorner<3, 3>() = turning(second(m) + S * E.transpose());
  return B;
}

// Of the nodes that count on this rank.
void GrainAccelerations::add_up(const std::vector<OfBond>& bonds, GrainSides& sides) {
  sum_.assign(kWidth * sides.sides.size(), 0.0);
  for (std::size_t i = 0; i < sides.sides.size(); ++i) {
    const GrainSide& s = sides.sides[i];
    for (int d = 0; d < 3; ++d) {
      sum_[kWidth * i + d] = s.force[d] + s.jump_force[d] + s.transfer_force[d];
      sum_[kWidth * i + 3 + d] = s.torque[d] + s.jump_force[3 + d] + s.transfer_force[3 + d];
    }
  }
  for (const OfBond& bond : bonds) {
    const Grid& grid = *bond.grid;
    const std::vector<char>& counts = grid.halo.counts_here();
    for (const AddedMass::Share& a : bond.added->shares()) {
      if (!counts[a.node]) continue;
      const double N = grid.mass[a.node] + bond.added->of_nodes()[a.node], *f = &grid.force[3 * a.node];
      for (int s = 0; s < 2; ++s) {
        const double c = a.mass[s], share = c / N;
        if (c == 0.0) continue;
        double r[3];
        a.lever_arm(grid, sides.sides[bond.side + s], r);
        double* to = &sum_[kWidth * (bond.side + s)];
        for (int d = 0; d < 3; ++d) {
          const int e = (d + 1) % 3, g = (d + 2) % 3;
          to[d] += share * f[d];
          to[3 + d] += share * (r[e] * f[g] - r[g] * f[e]);
        }
        MassMoments::add(c * (1.0 - share), r, to + 6);
        if (a.mass[1 - s] != 0.0) MassMoments::add(share * a.mass[1 - s], r, to + 6 + MassMoments::kSize);
      }
    }
  }
  sides.sum(sum_.data(), kWidth);
}

// radius: of this rank.
void GrainAccelerations::choose_sweeps(MPI_Comm comm, double radius) {
  MPI_Allreduce(&radius, &radius_, 1, MPI_DOUBLE, MPI_MAX, comm);
  radius_ = std::min(radius_, 1.0 - 1e-6);
  const double rate = radius_ / (1.0 + std::sqrt(1.0 - radius_ * radius_));
  sweeps_ = rate > 0.0 ? std::min(kMostSweeps, 2 + static_cast<int>(std::log(kPrecision) / std::log(rate))) : 1;
}

void GrainAccelerations::find(MPI_Comm comm, const std::vector<OfBond>& bonds, const std::vector<Grain>& grains,
                              const std::vector<Vector6>& load, GrainSides& sides, bool fresh, const CondensedMass* condensed) {
  add_up(bonds, sides);
  const std::vector<int>& owned = sides.owned();
  unknowns_.resize(grains.size());
  couplings_.clear();
  double radius = 0.0;
  for (std::size_t g = 0; g < grains.size(); ++g) {
    const Grain& grain = grains[g];
    Unknown& u = unknowns_[g];
    const GrainSide& first = sides.sides[owned[grain.sides.front()]];
    const std::array<double, 6> now = in_box(first, first.a, first.alpha);
    u.now = Eigen::Map<const Vector6>(now.data());
    Matrix6 D = Matrix6::Zero(), W = Matrix6::Zero();
    for (int i = 0; i < 6; ++i) {
      D(i, i) = i < 3 ? grain.mass : grain.inertia;
      u.given[i] = grain.free[i] ? 0.0 : u.now[i];
    }
    u.load = load[g];
    for (int k : grain.sides) {
      const int at = owned[k], other = at + (sides.sides[at].side == 0 ? 1 : -1);
      const double* of = &sum_[kWidth * at];
      const Matrix6 turn = turn_of(sides.sides[at]);
      u.load += turn * Eigen::Map<const Vector6>(of);
      MassMoments own, shared;
      std::copy(of + 6, of + 6 + MassMoments::kSize, own.m.begin());
      std::copy(of + 6 + MassMoments::kSize, of + kWidth, shared.m.begin());
      D += turn * own.matrix() * turn.transpose();
      const int c = condensed ? condensed->of_side[at] : -1;
      if (c >= 0) {
        const Matrix6 mass = turn * condensed->own[c] * turn.transpose();
        D += mass;
        W += mass;  // 2 |R0.C R1| is at most R0.A R0 + R1.B R1, of a matrix of masses
        couplings_.push_back({static_cast<int>(g), other, -turn * condensed->other[c]});
      }
      if (shared.m[0] == 0.0) continue;
      couplings_.push_back({static_cast<int>(g), other, turn * shared.coupling(distance(sides.sides[at], sides.sides[other]).data())});
      W += turn * shared.matrix() * turn.transpose();
    }
    u.load -= D * u.given;
    // rows and columns of what is given become those of the identity
    for (int i = 0; i < 6; ++i) {
      if (grain.free[i]) continue;
      for (Matrix6* m : {&D, &W}) {
        m->row(i).setZero();
        m->col(i).setZero();
      }
      D(i, i) = 1.0;
    }
    u.inverse = D.ldlt().solve(Matrix6::Identity());
    if (fresh && !W.isZero(0.0))
      radius = std::max(radius, Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6>(W, D, Eigen::EigenvaluesOnly).eigenvalues()[5]);
  }
  if (fresh) choose_sweeps(comm, radius);

  found_.resize(owned.size());
  double omega = 1.0;
  for (int sweep = 0; sweep < sweeps_; ++sweep) {
    if (sweep > 0) omega = sweep == 1 ? 2.0 / (2.0 - radius_ * radius_) : 1.0 / (1.0 - 0.25 * radius_ * radius_ * omega);
    std::size_t n = 0;
    for (std::size_t g = 0; g < grains.size(); ++g) {
      Unknown& u = unknowns_[g];
      Vector6 next = u.load;
      for (; n < couplings_.size() && couplings_[n].grain == static_cast<int>(g); ++n) {
        const GrainSide& s = sides.sides[couplings_[n].other];
        next += couplings_[n].B.leftCols<3>() * Eigen::Map<const Vector3>(s.a) + couplings_[n].B.rightCols<3>() * Eigen::Map<const Vector3>(s.alpha);
      }
      next = u.inverse * next;
      if (sweep > 0) next = omega * (next - u.before) + u.before;
      for (int i = 0; i < 6; ++i)
        if (!grains[g].free[i]) next[i] = u.given[i];
      u.before = u.now;
      u.now = next;
      for (int k : grains[g].sides) std::copy(next.data(), next.data() + 6, found_[k].begin());
    }
    sides.set_accelerations(found_);
  }
}

}  // namespace mpdem
