// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "elastic_end.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mpdem {

namespace {

// Modes in use. The radial functions are of the degree that the cells resolve, at most kMostDegree; harmonics of an intact patch
// have at most order 2, and those beyond it belong to the tail.
constexpr int kOrders = 2, kLeastDegree = 2, kMostDegreeOfRing = 8, kMostDegreeOfCap = 5;

}  // namespace

std::shared_ptr<const PatchCompliance> patch_of(const BondRecord& record, int side, double cell) {
  const double inner = record.patch[side][0], outer = record.patch[side][1], radius = record.radius[side];
  const int across = static_cast<int>(std::lround(radius * (outer - inner) / cell));
  const int degree = std::clamp(across, kLeastDegree, inner > 0.0 ? kMostDegreeOfRing : kMostDegreeOfCap);
  return PatchCompliance::of(inner, outer, degree, kOrders, {record.grain_E[side], record.grain_nu[side]}, radius);
}

Mat3<double> axes_of_patch(const BondRecord& record, int side) {
  const Eigen::Vector3d pole = (Eigen::Map<const Eigen::Vector3d>(record.centre[1 - side]) -
                                Eigen::Map<const Eigen::Vector3d>(record.centre[side]))
                                   .normalized(),
                        x = pole.unitOrthogonal(), y = pole.cross(x);
  Mat3<double> axes;
  for (int d = 0; d < 3; ++d) axes.a[d][0] = x[d], axes.a[d][1] = y[d], axes.a[d][2] = pole[d];
  return axes;
}

ElasticEnd::ElasticEnd(std::shared_ptr<const PatchCompliance> patch, const Mat3<double>& axes) : patch_(std::move(patch)), axes_(axes) {
  const SurfaceModes& modes = patch_->modes();
  radials_ = modes.radials();
  stride_ = radials_ + static_cast<int>(modes.harmonics().size()) + 3;
  for (const SurfaceModes::Scalar& s : modes.modes()) {
    if (groups_.empty() || groups_.back().harmonic != s.harmonic) groups_.push_back({s.harmonic, s.radial, s.radial});
    groups_.back().end = s.radial + 1;
  }
}

void ElasticEnd::add_block(const vd* direction) {
  const SurfaceModes& modes = patch_->modes();
  const std::size_t first = values_.size();
  values_.resize(first + stride_);
  std::vector<double> radial(radials_), harmonic(modes.harmonics().size());
  for (int l = 0; l < kLanes; ++l) {
    const double x = direction[0][l], y = direction[1][l], off = std::hypot(x, y);
    modes.find_radials(direction[2][l], radial.data());
    modes.find_harmonics(off > 0.0 ? x / off : 1.0, off > 0.0 ? y / off : 0.0, harmonic.data());
    for (int a = 0; a < radials_; ++a) values_[first + a][l] = patch_->scale_of_modes() * radial[a];
    for (std::size_t h = 0; h < harmonic.size(); ++h) values_[first + radials_ + h][l] = harmonic[h];
  }
  std::copy(direction, direction + 3, &values_[first + stride_ - 3]);
}

void ElasticEnd::add_loads(std::size_t block, const vd* force, vd* sums) const {
  const vd* radial = &values_[stride_ * block];
  for (const Group& g : groups_) {
    const vd h = radial[radials_ + g.harmonic], f0 = h * force[0], f1 = h * force[1], f2 = h * force[2];
    for (int a = g.first; a < g.end; ++a, sums += 3) {
      sums[0] += radial[a] * f0;
      sums[1] += radial[a] * f1;
      sums[2] += radial[a] * f2;
    }
  }
}

void ElasticEnd::displacement(std::size_t block, const double* q, vd* u) const {
  const vd* radial = &values_[stride_ * block];
  u[0] = u[1] = u[2] = vd{};
  for (const Group& g : groups_) {
    vd s[3] = {};
    for (int a = g.first; a < g.end; ++a, q += 3)
      for (int d = 0; d < 3; ++d) s[d] += radial[a] * q[d];
    for (int d = 0; d < 3; ++d) u[d] += radial[radials_ + g.harmonic] * s[d];
  }
}

// K' = kt 1 + (kn - kt) n n'.
std::vector<double> ElasticEnd::stiffness(std::size_t first, const std::vector<TractionSecant>& K) const {
  constexpr int kOf[6][2] = {{0, 0}, {1, 0}, {1, 1}, {2, 0}, {2, 1}, {2, 2}};
  const Eigen::Index n = modes(), links = kLanes * static_cast<Eigen::Index>(K.size());
  Eigen::MatrixXd Phi(links, n), weighted;
  std::vector<Eigen::MatrixXd> S(6, Eigen::MatrixXd::Zero(n, n));
  std::vector<vd> of_mode(static_cast<std::size_t>(n));
  Eigen::VectorXd k[6];
  for (auto& component : k) component.resize(links);
  for (std::size_t i = 0; i < K.size(); ++i) {
    const vd *radial = &values_[stride_ * (first + i)], *direction = radial + stride_ - 3;
    int mode = 0;
    for (const Group& g : groups_)
      for (int a = g.first; a < g.end; ++a) of_mode[mode++] = radial[radials_ + g.harmonic] * radial[a];
    for (int l = 0; l < kLanes; ++l) {
      const Eigen::Index row = static_cast<Eigen::Index>(kLanes * i) + l;
      for (Eigen::Index j = 0; j < n; ++j) Phi(row, j) = of_mode[j][l];
      for (int c = 0; c < 6; ++c)
        k[c][row] =
            (K[i].kn[l] - K[i].kt[l]) * direction[kOf[c][0]][l] * direction[kOf[c][1]][l] + (kOf[c][0] == kOf[c][1] ? K[i].kt[l] : 0.0);
    }
  }
  for (int c = 0; c < 6; ++c) {
    weighted = k[c].asDiagonal() * Phi;
    S[c].triangularView<Eigen::Lower>() += Phi.transpose() * weighted;
  }
  std::vector<double> out;
  out.reserve(static_cast<std::size_t>(3 * n * (n + 1)));
  for (const Eigen::MatrixXd& s : S)
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index i = j; i < n; ++i) out.push_back(s(i, j));
  return out;
}

ElasticEnd::Response ElasticEnd::response(const std::vector<double>& sums) const {
  constexpr int kOf[6][2] = {{0, 0}, {1, 0}, {1, 1}, {2, 0}, {2, 1}, {2, 2}};
  const Eigen::Index n = modes();
  Eigen::MatrixXd S(3 * n, 3 * n);
  auto next = sums.begin();
  for (const auto& of : kOf)
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index i = j; i < n; ++i, ++next)
        for (const auto& [a, b] : {std::pair(of[0], of[1]), std::pair(of[1], of[0])})
          S(3 * i + a, 3 * j + b) = S(3 * j + b, 3 * i + a) = *next;
  const Eigen::MatrixXd& L = patch_->factor();
  Eigen::MatrixXd inner = L.transpose() * S * L;
  inner.diagonal().array() += 1.0;
  Response r;
  r.M = L * inner.llt().solve(L.transpose());
  r.M = 0.5 * (r.M + r.M.transpose()).eval();
  const Eigen::MatrixXd& g = patch_->rigid();
  const Eigen::MatrixXd Sg = S * g;
  r.H = g - r.M * Sg;
  const Eigen::Matrix<double, 6, 6> k = Sg.transpose() * r.H;
  r.k = 0.5 * (k + k.transpose());
  return r;
}

std::size_t ElasticEnds::memory_usage() const {
  std::size_t bytes = sizeof(ElasticEnds);
  for (const Side& s : side) {
    bytes += s.end.memory_usage() + static_cast<std::size_t>(s.response.M.size()) * sizeof(double);
    for (const std::vector<double>& c : s.chunks) bytes += c.capacity() * sizeof(double);
  }
  return bytes;
}

}  // namespace mpdem
