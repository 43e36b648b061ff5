// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "grain_accelerations.h"

#include <algorithm>
#include <cmath>

#include "../numerics/cross_matrix.h"
#include "eight_inertias.h"

namespace mpdem {

namespace {

// Relative errors of the iteration. They affect the conservation of energy, but not of momentum. Condensed bonds have a
// small share of the energy.
constexpr double kPrecision = 1e-10, kPrecisionOfCondensed = 1e-8;
constexpr double kLargestRadius = 1.0 - 1e-6;  // spectral radius, which takes 17 000 sweeps

using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;

// Sum of [r][q]^T for the second moments T of r and q. A single term is (r.q) - q r^T.
Matrix3 turning(const Matrix3& T) { return T.trace() * Matrix3::Identity() - T.transpose(); }

Vector3 distance(const BondEnd& from, const BondEnd& to) { return Eigen::Map<const Vector3>(from.x) - Eigen::Map<const Vector3>(to.x); }

Matrix3 second(const std::array<double, MassMoments::kSize>& m) {
  Matrix3 T;
  T << m[4], m[9], m[8], m[9], m[5], m[7], m[8], m[7], m[6];
  return T;
}

void add_first(vd v, int count, double* to) {
  for (int l = 0; l < count; ++l) to[l] += v[l];
}

// Rotation of six numbers from the axes of an end to those of the box.
Eigen::Matrix<double, 6, 6> turn_of(const BondEnd& s) {
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = matrix_of(s.axes);
  return turn;
}

}  // namespace

template <class T>
void MassMoments::add(T mass, const T* r, T* m) {
  const T x = mass * r[0], y = mass * r[1], z = mass * r[2];
  const T add[kSize] = {mass, x, y, z, x * r[0], y * r[1], z * r[2], y * r[2], x * r[2], x * r[1]};
  for (int i = 0; i < kSize; ++i) m[i] += add[i];
}
template void MassMoments::add(double mass, const double* r, double* m);

Eigen::Matrix<double, 6, 6> MassMoments::matrix() const {
  const double none[3] = {0, 0, 0};
  return coupling(none);
}

Eigen::Matrix<double, 6, 6> MassMoments::coupling(const double* e) const {
  const Vector3 S(m[1], m[2], m[3]), E(e[0], e[1], e[2]);
  Eigen::Matrix<double, 6, 6> B;
  B.topLeftCorner<3, 3>() = m[0] * Matrix3::Identity();
  B.topRightCorner<3, 3>() = -cross_matrix(S + m[0] * E);
  B.bottomLeftCorner<3, 3>() = cross_matrix(S);
  B.bottomRightCorner<3, 3>() = turning(second(m) + S * E.transpose());
  return B;
}

// Sums over the nodes that this rank counts. Eight nodes lie side by side, so their lanes are added up last.
void GrainAccelerations::add(const OfBond& bond, const BondEnds& ends) {
  const Grid& grid = *bond.grid;
  vd of_end[2][kPadded] = {};
  for (std::size_t m = 0; m < bond.added->masses().size(); ++m) {
    const AddedMass::EightMasses& own = bond.added->masses()[m];
    const EightInertias e(own, bond.added->nodes()[m], grid);
    vd f[3];
    e.nodes.take(grid.force.data(), f);
    const vd inverse = 1.0 / e.inertia;
    for (int s = 0; s < 2; ++s) {
      const vd c = e.nodes.counted * own.mass[s], share = c * inverse;
      vd r[3], *to = of_end[s];
      e.lever_arm(ends.ends[bond.end_0 + s], r);
      for (int d = 0; d < 3; ++d) {
        const int e1 = (d + 1) % 3, e2 = (d + 2) % 3;
        to[d] += share * f[d];
        to[3 + d] += share * (r[e1] * f[e2] - r[e2] * f[e1]);
      }
      MassMoments::add(c * (1.0 - share), r, to + 6);
      MassMoments::add(share * own.mass[1 - s], r, to + 6 + MassMoments::kSize);
    }
  }
  for (int s = 0; s < 2; ++s)
    for (int i = 0; i < kPadded; i += kLanes)
      add_first(sum_lanes_of_8(of_end[s] + i), std::min(kLanes, kWidth - i), &sum_[kWidth * (bond.end_0 + s) + i]);
}

// Sets up the equations. Returns a bound of the spectral radius.
double GrainAccelerations::set_up(const std::vector<Grain>& grains, const std::vector<Vector6>& load, const BondEnds& ends, bool fresh,
                                  const CondensedPack& condensed, bool loads_of_condensed) {
  const std::vector<int>& owned = ends.owned();
  unknowns_.assign((grains.size() + kLanes - 1) / kLanes, Unknowns{});
  couplings_.clear();
  double radius = 0.0;
  for (std::size_t g = 0; g < kLanes * unknowns_.size(); ++g) {
    Unknowns& u = unknowns_[g / kLanes];
    const int lane = static_cast<int>(g % kLanes);
    if (g >= grains.size()) {
      for (int i = 0; i < 6; ++i) u.D[lower_triangle(i, i)][lane] = 1.0;
      continue;
    }
    const Grain& grain = grains[g];
    double D[kSym6];
    for (int k = 0; k < kSym6; ++k) D[k] = condensed.mass(static_cast<int>(g), k);
    Matrix6 W = Matrix6::Zero();
    for (int i = 0; fresh && i < 6; ++i)
      for (int j = 0; j < 6; ++j) W(i, j) = condensed.inertial_coupling() * D[lower_triangle(i, j)];
    Vector6 sum = load[g];
    for (int i = 0; i < 6; ++i) {
      D[lower_triangle(i, i)] += i < 3 ? grain.mass : grain.inertia;
      if (loads_of_condensed) sum[i] += condensed.load(static_cast<int>(g), i) + condensed.jump_load(static_cast<int>(g), i);
    }
    for (int k : grain.ends) {
      const int at = owned[k], other = at + (ends.ends[at].side == 0 ? 1 : -1);
      const double* of = &sum_[kWidth * at];
      const Matrix6 turn = turn_of(ends.ends[at]);
      sum += turn * Eigen::Map<const Vector6>(of);
      MassMoments own, shared;
      std::copy(of + 6, of + 6 + MassMoments::kSize, own.m.begin());
      std::copy(of + 6 + MassMoments::kSize, of + kWidth, shared.m.begin());
      const Matrix6 m = turn * own.matrix() * turn.transpose();
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j <= i; ++j) D[lower_triangle(i, j)] += m(i, j);
      if (shared.m[0] == 0.0) continue;
      couplings_.push_back({static_cast<int>(g), other, turn * shared.coupling(distance(ends.ends[at], ends.ends[other]).data())});
      if (fresh) W += std::copysign(1.0, shared.m[0]) * (turn * shared.matrix() * turn.transpose());  // negative in find_impulse()
    }
    for (int i = 0; i < 6; ++i) {
      u.now[i][lane] = grain.acceleration[i];
      u.free[i][lane] = grain.free[i];
      u.given[i][lane] = grain.free[i] ? 0.0 : grain.acceleration[i];
      for (int j = 0; j < 6; ++j)
        if (!grain.free[j]) sum[i] -= D[lower_triangle(i, j)] * grain.acceleration[j];
      u.load[i][lane] = sum[i];
    }
    // Rows and columns of prescribed components become those of the identity.
    for (int i = 0; i < 6; ++i) {
      if (grain.free[i]) continue;
      for (int j = 0; j < 6; ++j) D[lower_triangle(i, j)] = i == j ? 1.0 : 0.0;
      W.row(i).setZero();
      W.col(i).setZero();
    }
    for (int k = 0; k < kSym6; ++k) u.D[k][lane] = D[k];
    if (!fresh || W.isZero(0.0)) continue;
    Matrix6 whole;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) whole(i, j) = D[lower_triangle(i, j)];
    radius = std::max(radius, Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6>(W, whole, Eigen::EigenvaluesOnly).eigenvalues()[5]);
  }
  for (Unknowns& u : unknowns_) invert_sym6(u.D, u.inverse);
  return radius;
}

// One sweep of block Jacobi, accelerated by omega.
void GrainAccelerations::sweep(double omega, bool first, const BondEnds& ends, CondensedPack& condensed) {
  from_others_.assign(6 * kLanes * unknowns_.size(), 0.0);
  for (const Coupling& c : couplings_) {
    const BondEnd& s = ends.ends[c.other];
    const Vector6 b = c.B.leftCols<3>() * Eigen::Map<const Vector3>(s.a) + c.B.rightCols<3>() * Eigen::Map<const Vector3>(s.alpha);
    for (int d = 0; d < 6; ++d) from_others_[6 * c.grain + d] += b[d];
  }
  if (!(first && condensed.at_rest())) condensed.subtract_coupling(from_others_.data());
  for (std::size_t b = 0; b < unknowns_.size(); ++b) {
    Unknowns& u = unknowns_[b];
    const double* from = &from_others_[6 * kLanes * b];
    double* to = &of_grains_[6 * kLanes * b];
    vd load[6], next[6] = {};
    for (int i = 0; i < 6; ++i) {
      for (int l = 0; l < kLanes; ++l) load[i][l] = from[6 * l + i];
      load[i] += u.load[i];
    }
    add_product_sym6(u.inverse, load, next);
    for (int i = 0; i < 6; ++i) {
      if (!first) next[i] = omega * (next[i] - u.before[i]) + u.before[i];
      next[i] = select(u.free[i] != 0.0, next[i], u.given[i]);
      u.before[i] = u.now[i];
      u.now[i] = next[i];
      for (int l = 0; l < kLanes; ++l) to[6 * l + i] = next[i][l];
    }
  }
}

void GrainAccelerations::find(MPI_Comm comm, const std::vector<OfBond>& bonds, std::vector<Grain>& grains, const std::vector<Vector6>& load,
                              BondEnds& ends, bool fresh, CondensedPack& condensed) {
  if (!begun_) begin(ends);
  for (const OfBond& b : bonds) add(b, ends);
  begun_ = false;
  for (std::size_t i = 0; i < ends.ends.size(); ++i) {
    const BondEnd& s = ends.ends[i];
    for (int d = 0; d < 3; ++d) {
      sum_[kWidth * i + d] += s.force[d] + s.jump_force[d] + s.transfer_force[d];
      sum_[kWidth * i + 3 + d] += s.torque[d] + s.jump_force[3 + d] + s.transfer_force[3 + d];
    }
  }
  ends.sum(sum_.data(), kWidth);
  solve(comm, grains, load, ends, fresh, condensed, true);
}

void GrainAccelerations::find_impulse(MPI_Comm comm, const std::vector<EndMoments>& mass, std::vector<Grain>& grains,
                                      const std::vector<Vector6>& load, BondEnds& ends, CondensedPack& condensed) {
  sum_.assign(kWidth * ends.ends.size(), 0.0);
  for (std::size_t i = 0; i < mass.size(); ++i)
    for (int n = 0; n < MassMoments::kSize; ++n) {
      sum_[kWidth * i + 6 + n] = mass[i].own.m[n];
      sum_[kWidth * i + 6 + MassMoments::kSize + n] = -mass[i].shared.m[n];  // c0 c1/N of added mass is on the other side of the equations
    }
  ends.sum(sum_.data(), kWidth);
  solve(comm, grains, load, ends, true, condensed, false);
}

void GrainAccelerations::solve(MPI_Comm comm, std::vector<Grain>& grains, const std::vector<Vector6>& load, BondEnds& ends, bool fresh,
                               CondensedPack& condensed, bool loads_of_condensed) {
  const double radius = set_up(grains, load, ends, fresh, condensed, loads_of_condensed);
  if (fresh) {
    double most[2] = {radius, couplings_.empty() ? 0.0 : 1.0};
    MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_DOUBLE, MPI_MAX, comm);
    radius_ = std::min(most[0], kLargestRadius);
    imprecise_ = imprecise_ || most[0] > kLargestRadius;
    const double rate = radius_ / (1.0 + std::sqrt(1.0 - radius_ * radius_)),
                 precision = most[1] > 0.0 ? kPrecision : kPrecisionOfCondensed;
    sweeps_ = rate > 0.0 ? 1 + static_cast<int>(std::log(0.5 * precision) / std::log(rate)) : 1;
  }
  of_grains_.resize(6 * kLanes * unknowns_.size());
  found_.resize(ends.owned().size());
  double omega = 1.0;
  for (int k = 0; k < sweeps_; ++k) {
    if (k > 0) omega = k == 1 ? 2.0 / (2.0 - radius_ * radius_) : 1.0 / (1.0 - 0.25 * radius_ * radius_ * omega);
    sweep(omega, k == 0, ends, condensed);
    for (std::size_t g = 0; g < grains.size(); ++g) {
      std::copy(&of_grains_[6 * g], &of_grains_[6 * g] + 6, grains[g].acceleration);
      for (int at : grains[g].ends) std::copy(grains[g].acceleration, grains[g].acceleration + 6, found_[at].begin());
    }
    ends.set_accelerations(found_);
    condensed.set_accelerations(of_grains_.data());
  }
}

}  // namespace mpdem
