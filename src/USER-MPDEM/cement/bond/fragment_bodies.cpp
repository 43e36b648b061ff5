// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "fragment_bodies.h"

#include <algorithm>

#include "../../numerics/sort_unique.h"
#include "../../parallel/ranks.h"

namespace mpdem {

namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Map3 = Eigen::Map<const Vector3>;

Vector3 place_of(const Grid& grid, int i) { return grid.h * Vector3(grid.keys[i].at(0), grid.keys[i].at(1), grid.keys[i].at(2)); }

// Motion of a node after a drift, with the roundings of Grid::drift(): a run that starts after it has the same.
struct MovedNode {
  Vector3 v, u;
  MovedNode(const Grid& grid, int i, const FragmentBodies::Drift& ahead) {
    for (int d = 0; d < 3; ++d) {
      v[d] = grid.velocity[3 * i + d];
      v[d] += ahead.kick * grid.acceleration[3 * i + d];
      u[d] = grid.displacement[3 * i + d];
      u[d] += ahead.dt * v[d];
    }
  }
};

Matrix3 box_axes(const BondRecord& record) {
  const Mat3<double> R = axes_of(record);
  Matrix3 Q;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) Q(i, j) = R.a[i][j];
  return Q;
}

// The rotation R for which tr(R^T A) is the largest.
Matrix3 nearest_rotation(const Matrix3& A) {
  const Eigen::JacobiSVD<Matrix3> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3 sign = Matrix3::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

void sum_over(MPI_Comm comm, std::vector<double>& sums) {
  if (ranks_of(comm) > 1) MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, comm);
}

}  // namespace

bool FragmentBodies::has(int row) const { return !rows_.empty() && std::binary_search(rows_.begin(), rows_.end(), row); }

void FragmentBodies::add_rows(const std::vector<int>& rows) {
  if (rows.empty()) return;
  rows_.insert(rows_.end(), rows.begin(), rows.end());
  sort_unique(rows_);
  ++changes_;
}

void FragmentBodies::remove_rows(const std::vector<int>& rows) {
  const auto removed =
      std::remove_if(rows_.begin(), rows_.end(), [&](int row) { return std::binary_search(rows.begin(), rows.end(), row); });
  changes_ += removed != rows_.end();
  rows_.erase(removed, rows_.end());
}

void FragmentBodies::set(const std::vector<NodesOf>& fragments) {
  fragments_.clear();
  for (const NodesOf& f : fragments) {
    fragments_.emplace_back();
    fragments_.back().of = f;
  }
  motions_.assign(fragments_.size(), BodyOfNodes());
}

void FragmentBodies::find_nodes(const Bonds& bonds) {
  for (Fragment& f : fragments_) {
    const Bond* b = bonds.find(f.of.row);
    const int layout = b ? b->layout : -1, size = b ? b->grid.size() : -1;
    if (layout == f.layout && size == f.size) continue;
    f.layout = layout;
    f.size = size;
    f.here.clear();
    for (const Key& k : f.of.nodes) {
      const int i = b ? b->grid.node_at(k) : -1;
      if (i >= 0 && b->grid.mass[i] > 0.0) f.here.push_back(i);
    }
  }
}

// Sums over the nodes of all ranks. Moments are about the centre, since a fragment may be far from where it was made.
void FragmentBodies::sum_up(MPI_Comm comm, const Bonds& bonds, const Drift& ahead) {
  find_nodes(bonds);
  constexpr int kFirst = 10, kSecond = 21;
  const auto each_here = [&](const Fragment& f, auto add) {
    const Bond* b = bonds.find(f.of.row);
    for (int i : f.here) {
      if (!b->grid.halo.counts_here()[i]) continue;
      const Vector3 X = place_of(b->grid, i);
      const MovedNode node(b->grid, i, ahead);
      add(b->grid.mass[i], X, Vector3(X + node.u), node.v);
    }
  };
  std::vector<double> sums(kFirst * fragments_.size(), 0.0);
  for (std::size_t n = 0; n < fragments_.size(); ++n)
    each_here(fragments_[n], [&](double m, const Vector3& X, const Vector3& x, const Vector3& v) {
      double* s = &sums[kFirst * n];
      s[0] += m;
      for (int d = 0; d < 3; ++d) {
        s[1 + d] += m * X[d];
        s[4 + d] += m * x[d];
        s[7 + d] += m * v[d];
      }
    });
  sum_over(comm, sums);
  for (std::size_t n = 0; n < fragments_.size(); ++n) {
    Fragment& f = fragments_[n];
    const double* s = &sums[kFirst * n];
    f.mass = s[0];
    const double inverse = f.mass > 0.0 ? 1.0 / f.mass : 0.0;
    f.X = inverse * Map3(s + 1);
    f.x = inverse * Map3(s + 4);
    f.v = inverse * Map3(s + 7);
  }
  sums.assign(kSecond * fragments_.size(), 0.0);
  for (std::size_t n = 0; n < fragments_.size(); ++n) {
    const Fragment& f = fragments_[n];
    Eigen::Map<Matrix3> inertia(&sums[kSecond * n]), spread(&sums[kSecond * n + 9]);
    Eigen::Map<Vector3> momentum(&sums[kSecond * n + 18]);
    each_here(f, [&](double m, const Vector3& X, const Vector3& x, const Vector3& v) {
      const Vector3 r = x - f.x;
      inertia += m * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
      spread += m * r * (X - f.X).transpose();
      momentum += m * r.cross(v);
    });
  }
  sum_over(comm, sums);
  for (std::size_t n = 0; n < fragments_.size(); ++n) {
    Fragment& f = fragments_[n];
    f.inertia = Eigen::Map<const Matrix3>(&sums[kSecond * n]);
    f.spread = Eigen::Map<const Matrix3>(&sums[kSecond * n + 9]);
    f.momentum = Map3(&sums[kSecond * n + 18]);
  }
}

const std::vector<BodyOfNodes>& FragmentBodies::find_motions(MPI_Comm comm, const Bonds& bonds, const Drift& ahead) {
  if (any()) sum_up(comm, bonds, ahead);
  for (std::size_t n = 0; n < fragments_.size(); ++n) {
    Fragment& f = fragments_[n];
    f.about = f.x;
    if (!(f.mass > 0.0)) continue;
    const BondRecord& record = bonds.table[f.of.row];
    const Matrix3 Q = box_axes(record), R = nearest_rotation(f.spread);
    BodyOfNodes& m = motions_[n];
    const Vector3 arm = -(Q * (R * f.X));
    m.centre = Map3(record.origin) + Q * f.x;
    m.R = Q * R;
    m.omega = Q * Vector3(f.inertia.inverse() * f.momentum);
    m.x = m.centre + arm;
    m.v = Q * f.v + m.omega.cross(arm);
  }
  return motions_;
}

void FragmentBodies::set_forces(const std::vector<double>& forces, const Bonds& bonds) {
  for (std::size_t n = 0; n < fragments_.size(); ++n) {
    Fragment& f = fragments_[n];
    const Matrix3 Q = box_axes(bonds.table[f.of.row]);
    const Vector3 force = Map3(&forces[6 * n]), moment = Map3(&forces[6 * n + 3]);
    f.force = Q.transpose() * force;
    f.moment = Q.transpose() * Vector3(moment + (motions_[n].x - motions_[n].centre).cross(force));
  }
}

void FragmentBodies::find_accelerations(MPI_Comm comm, const Bonds& bonds, const Drift& ahead, double factor) {
  if (!any()) return;
  sum_up(comm, bonds, ahead);
  for (Fragment& f : fragments_) {
    f.a = f.alpha = Vector3::Zero();
    if (!(f.mass > 0.0)) continue;
    f.a = factor / f.mass * f.force;
    f.alpha = factor * f.inertia.inverse() * Vector3(f.moment + (f.about - f.x).cross(f.force));
  }
}

// Calls f(node, force) for the nodes of fragments of a bond on this rank.
template <class F>
void FragmentBodies::for_each_force(const Bond& b, F f) const {
  for (const Fragment& of : fragments_) {
    if (of.of.row != b.row || of.layout != b.layout || of.size != b.grid.size()) continue;
    for (int i : of.here) {
      const Vector3 r = place_of(b.grid, i) + Map3(&b.grid.displacement[3 * i]) - of.x;
      f(i, Vector3(b.grid.mass[i] * (of.a + of.alpha.cross(r))));
    }
  }
}

void FragmentBodies::add_forces(Bond& b) const {
  for_each_force(b, [&](int i, const Vector3& force) {
    for (int d = 0; d < 3; ++d) b.grid.force[3 * i + d] += force[d];
  });
}

double FragmentBodies::power(const Bond& b, const std::vector<double>& velocity) const {
  double sum = 0.0;
  if (velocity.empty()) return sum;
  for_each_force(b, [&](int i, const Vector3& force) {
    if (b.grid.halo.counts_here()[i]) sum += force.dot(Map3(&velocity[3 * i]));
  });
  return sum;
}

std::size_t FragmentBodies::memory_usage() const {
  std::size_t bytes = fragments_.capacity() * (sizeof(Fragment) + sizeof(BodyOfNodes)) + rows_.capacity() * sizeof(int);
  for (const Fragment& f : fragments_) bytes += f.of.nodes.capacity() * sizeof(Key) + f.here.capacity() * sizeof(int);
  return bytes;
}

}  // namespace mpdem
