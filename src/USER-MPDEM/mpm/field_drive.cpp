// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "field_drive.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "../material/laws.h"
#include "block_nodes.h"
#include "drive_average.h"
#include "gather.h"
#include "material_runs.h"
#include "point_state.h"
#include "strain_norm.h"

namespace mpdem {

namespace {

template <class L>
double root(double share) {
  return L::kDegree == 2 ? std::sqrt(share) : share;
}

// Largest root of the drive for a strain of norm 1. Yeq is at most |stress| |strain|/sqrt(2) for laws of degree 2, and
// at most |strain| for laws of degree 1.
template <class L>
double root_of_unit_strain(const L& law) {
  return L::kDegree == 2 ? std::sqrt(law.elasticity().largest_stiffness() / std::sqrt(2.0)) : 1.0;
}

double largest(vmask active, vd values) {
  double most = 0.0;
  for (int l = 0; l < kLanes; ++l)
    if (active[l]) most = std::max(most, values[l]);
  return most;
}

// Factor on the threshold for each point of a block.
template <class L>
vd strength_of(const PointStore& points, int b, const L& law) {
  return points.strength_factor(b) * select(lanes(points.meta[b].linked), splat(law.interface()), splat(1.0));
}

}  // namespace

double root_of_share(const Law& law, double share) {
  return with_law(law, [&](const auto& l) {
    using L = std::decay_t<decltype(l)>;
    if constexpr (L::kFields > 0) return root<L>(share);
    return share;
  });
}

double margin_of_root(const Law& law, double b, double root, double most) {
  return with_law(law, [&](const auto& l) {
    using L = std::decay_t<decltype(l)>;
    if constexpr (L::kFields > 0)
      if (L::kDegree == 2) return std::sqrt(std::max(0.0, b * b + most * most - root * root)) - b;
    return most - root;
  });
}

double bound_of_averages(const Law& law) {
  double most = 1.0;
  for (int n = 0; n < law.materials(); ++n)
    with_law(law.of_material(n), [&](const auto& l) {
      using L = std::decay_t<decltype(l)>;
      if constexpr (L::kFields > 0) most = std::max(most, root<L>(1.0 / std::min(1.0, l.interface())));
    });
  return most;
}

double margin_of_average(const Law& law, double b, double root, double most) {
  const double lacking = std::sqrt(most) - std::sqrt(root), norm = lacking > 0.0 ? lacking * lacking : 0.0;
  return with_law(law, [&](const auto& l) {
    using L = std::decay_t<decltype(l)>;
    if constexpr (L::kFields > 0)
      if (L::kDegree == 2) return std::sqrt(b * b + norm * norm) - b;
    return norm;
  });
}

void find_strain_bounds(const PointStore& points, const std::array<std::vector<Sym3<vd>>, 6>& strain, const Law& law, double* bound) {
  std::fill(bound, bound + 6, 0.0);
  for_each_material(points, law, [&](const auto& l, int first, int last) {
    using L = std::decay_t<decltype(l)>;
    if constexpr (L::kFields > 0) {
      const double unit = root_of_unit_strain(l);
      for (int b = first; b < last; ++b) {
        const BlockMeta& m = points.meta[b];
        const vd threshold = l.lowest_threshold() * strength_of(points, b, l);
        const vd scale = unit / (L::kDegree == 2 ? sqrt(threshold) : threshold);
        for (int j = 0; j < 6; ++j)
          bound[j] = std::max(bound[j], largest(lanes(m.occupied & ~m.failed), scale * sqrt(contract(strain[j][b], strain[j][b]))));
      }
    }
  });
}

double largest_root_of_drive(const PointStore& points, const Law& law, const Grid* averages) {
  double most = 0.0;
  int degree = 1;
  for_each_material(points, law, [&](const auto& l, int first, int last) {
    using L = std::decay_t<decltype(l)>;
    if constexpr (L::kFields > 0) {
      degree = L::kDegree;
      for (int b = first; b < last; ++b) {
        const BlockMeta& m = points.meta[b];
        if (m.failed == m.occupied) continue;
        const vmask active = lanes(m.occupied & ~m.failed);
        const Sym3<vd>& strain = points.blocks[b].strain;
        vd Yeq, B = splat(l.lowest_threshold());
        if (m.damaged) {
          const LawDrive drive = l.drive(strain, state_of<L>(points, b), softening_of(points, b, l));
          Yeq = drive.Yeq, B = drive.B;
        } else {
          Yeq = l.undamaged_drive(strain);
        }
        if (averages) {
          vd average{};
          with_basis(averages->basis, [&](auto type) {
            with_weights<decltype(type)>(points.blocks[b], m, 1.0 / averages->h,
                                         [&](const auto& s) { average = average_at(*averages, m, s); });
          });
          Yeq = drive_factor<L>(average);
        }
        const vd share = Yeq / (B * strength_of(points, b, l));
        most = std::max(most, largest(active, share));
      }
    }
  });
  return degree == 2 ? std::sqrt(most) : most;
}

void set_field(PointStore& points, const Grid& grid, const double Q[3][3]) {
  Eigen::Matrix3d turn;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) turn(i, j) = Q[i][j];
  with_basis(grid.basis, [&](auto type) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      PointBlock& p = points.blocks[b];
      const BlockMeta& m = points.meta[b];
      with_values<3>(grid, m, grid.displacement.data(), [&](const double* values, const int* column) {
        with_weights<decltype(type)>(p, m, 1.0 / grid.h, [&](const auto& s) { p.F = gather_gradient(values, column, s); });
      });
      for (int i = 0; i < 3; ++i) p.F.a[i][i] += 1.0;
      for (int l = 0; l < kLanes; ++l) {
        if (!(m.occupied >> l & 1)) continue;
        Eigen::Matrix3d F;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) F(i, j) = p.F.a[i][j][l];
        const Eigen::Matrix3d small = turn.transpose() * F;  // 1 + a small gradient, whose skew part rotates by `spin`
        const Eigen::Vector3d spin = 0.5 * Eigen::Vector3d(small(2, 1) - small(1, 2), small(0, 2) - small(2, 0), small(1, 0) - small(0, 1));
        const double angle = spin.norm();
        Eigen::Quaterniond q(turn);
        if (angle > 0.0) q = q * Eigen::Quaterniond(Eigen::AngleAxisd(angle, spin / angle));
        q = (q * Eigen::Quaterniond(p.q.w[l], p.q.x[l], p.q.y[l], p.q.z[l])).normalized();
        p.q.w[l] = q.w();
        p.q.x[l] = q.x();
        p.q.y[l] = q.y();
        p.q.z[l] = q.z();
      }
    }
  });
}

void revert_field(PointStore& points) {
  points.forget_roots_of_norm();
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    PointBlock& p = points.blocks[b];
    for (int l = 0; l < kLanes; ++l) {
      if (!(points.meta[b].occupied >> l & 1)) continue;
      Eigen::Matrix3d F;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          F(i, j) = p.F.a[i][j][l];
          p.F.a[i][j][l] = i == j ? 1.0 : 0.0;
        }
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
      const Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
      if (!(R.determinant() > 0.0)) continue;  // an inverted failed point
      const Eigen::Quaterniond q =
          (Eigen::Quaterniond(R).conjugate() * Eigen::Quaterniond(p.q.w[l], p.q.x[l], p.q.y[l], p.q.z[l])).normalized();
      p.q.w[l] = q.w();
      p.q.x[l] = q.x();
      p.q.y[l] = q.y();
      p.q.z[l] = q.z();
    }
    p.strain = Sym3<vd>{};
  }
}

}  // namespace mpdem
