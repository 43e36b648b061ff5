// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "elastic_coupling.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "../../coupling/elastic_end.h"

namespace mpdem {

namespace {

constexpr double kMostNegative = 0.9;

// Axes of the patch in axes fixed in the grain.
Eigen::Matrix3d axes_in_grain(const BondRecord& record, int side) {
  const Mat3<double> axes = product(transpose(rotation_of(record.orientation[side])), axes_of_patch(record, side));
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&axes.a[0][0]);
}

}  // namespace

void ElasticCoupling::find(const Bonds& bonds, double cell) {
  std::map<int, std::vector<std::pair<int, int>>> of_grain;
  for (int row = 0; row < static_cast<int>(bonds.table.size()); ++row) {
    const BondRecord& record = bonds.table[static_cast<std::size_t>(row)];
    for (int s = 0; s < 2; ++s)
      if (record.has_grain(s) && record.grain_E[s] > 0.0 && record.patch[s][1] > 0.0) of_grain[record.grain[s]].push_back({row, s});
  }
  grains_.clear();
  end_of_.clear();
  int ends = 0;
  for (const auto& [tag, keys] : of_grain) {
    if (keys.size() < 2) continue;
    OnGrain g;
    for (const auto& key : keys) {
      g.ends.push_back(ends);
      end_of_[key] = ends++;
      const BondRecord& record = bonds.table[static_cast<std::size_t>(key.first)];
      if (far_fields_.count(key) == 0)
        far_fields_.emplace(key, FarField(record.patch[key.second][0], record.patch[key.second][1], axes_in_grain(record, key.second)));
    }
    const Eigen::Index n = static_cast<Eigen::Index>(keys.size());
    g.C.setZero(6 * n, 6 * n);
    Eigen::MatrixXd own = g.C;  // stiffness of the patches as rigid bodies, root
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto& [row, side] = keys[static_cast<std::size_t>(i)];
      const BondRecord& record = bonds.table[static_cast<std::size_t>(row)];
      const GrainElasticity grain{record.grain_E[side], record.grain_nu[side]};
      for (Eigen::Index j = 0; j < i; ++j) {
        const Matrix6 c = far_fields_.at(keys[static_cast<std::size_t>(i)])
                              .moved_by(far_fields_.at(keys[static_cast<std::size_t>(j)]), grain, record.radius[side]);
        g.C.block<6, 6>(6 * i, 6 * j) = c;
        g.C.block<6, 6>(6 * j, 6 * i) = c.transpose();
      }
      own.block<6, 6>(6 * i, 6 * i) =
          Eigen::SelfAdjointEigenSolver<Matrix6>(patch_of(record, side, cell)->of_rigid_patch()).operatorInverseSqrt();
    }
    const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(own * g.C * own, Eigen::EigenvaluesOnly).eigenvalues()[0];
    if (least < -kMostNegative) g.C *= -kMostNegative / least;
    grains_.push_back(std::move(g));
  }
  loads_.assign(static_cast<std::size_t>(ends), Vector6::Zero());
  motions_ = loads_;
}

int ElasticCoupling::end_of(int bond_row, int side) const {
  const auto found = end_of_.find({bond_row, side});
  return found == end_of_.end() ? -1 : found->second;
}

void ElasticCoupling::set_stiffness(const std::vector<Matrix6>& k) {
  for (OnGrain& g : grains_) {
    Eigen::MatrixXd equations(g.C.rows(), g.C.cols());
    for (std::size_t i = 0; i < g.ends.size(); ++i) {
      const Eigen::Index at = 6 * static_cast<Eigen::Index>(i);
      equations.middleRows<6>(at) = k[static_cast<std::size_t>(g.ends[i])] * g.C.middleRows<6>(at);
    }
    equations.diagonal().array() += 1.0;
    g.equations.compute(equations);
  }
}

void ElasticCoupling::find_motions(const std::vector<Vector6>& loads) {
  for (const OnGrain& g : grains_) {
    Eigen::VectorXd F(g.C.rows());
    for (std::size_t i = 0; i < g.ends.size(); ++i)
      F.segment<6>(6 * static_cast<Eigen::Index>(i)) = loads[static_cast<std::size_t>(g.ends[i])];
    const Eigen::VectorXd w = g.C * g.equations.solve(F);
    for (std::size_t i = 0; i < g.ends.size(); ++i)
      motions_[static_cast<std::size_t>(g.ends[i])] = w.segment<6>(6 * static_cast<Eigen::Index>(i));
  }
}

std::vector<char> ElasticCoupling::neighbours(const std::vector<char>& of_ends) const {
  std::vector<char> found(of_ends.size(), 0);
  for (const OnGrain& g : grains_) {
    const bool any = std::any_of(g.ends.begin(), g.ends.end(), [&](int e) { return of_ends[static_cast<std::size_t>(e)] != 0; });
    for (int e : g.ends) found[static_cast<std::size_t>(e)] = any;
  }
  return found;
}

}  // namespace mpdem
