// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "largest_eigenvalue.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "block_nodes.h"
#include "stiffness_force.h"

namespace mpdem {

namespace {

constexpr int kMostProducts = 200;

// Component c of the start vector at the node of this key: a pseudo-random number in [-1, 1], the same on every rank and in every run.
double start_value(const Key& k, int c) {
  std::uint64_t z = 0x9e3779b97f4a7c15ull * (c + 1);
  const auto row = static_cast<std::uint32_t>(row_of(k.field())), layer = static_cast<std::uint32_t>(layer_of_field(k.field()));
  for (std::uint32_t i : {row ^ (layer << 20), static_cast<std::uint32_t>(k.at(0)), static_cast<std::uint32_t>(k.at(1)),
                          static_cast<std::uint32_t>(k.at(2))}) {
    z = (z ^ i) * 0xbf58476d1ce4e5b9ull;
    z ^= z >> 29;
  }
  z *= 0x94d049bb133111ebull;
  z ^= z >> 32;
  return static_cast<double>(z >> 11) * 0x1p-52 - 1.0;
}

// Nodes of one bond that can move: all nodes, or those of EigenvalueSystem::blocks with their masters.
struct MovingNodes {
  struct Constrained {
    int node, row;  // index of the node, and the row of its constraint
  };
  std::vector<int> nodes;  // ascending
  // Constrained nodes of EigenvalueSystem::blocks. Without such a list this is empty, since the grid knows all of them.
  std::vector<Constrained> constrained_nodes;

  explicit MovingNodes(const EigenvalueSystem& system) {
    const Grid& grid = *system.grid;
    std::vector<char> moves(grid.size(), system.blocks == nullptr);
    for (std::size_t n = 0; system.blocks && n < system.blocks->size(); ++n)
      for_each_node(grid, system.points->meta[(*system.blocks)[n]], [&](int i) { moves[i] = 1; });
    for (int i = 0; i < grid.size() && system.blocks; ++i)
      if (const int row = moves[i] ? grid.constraints.row(i) : -1; row >= 0) constrained_nodes.push_back({i, row});
    for (const Constrained& c : constrained_nodes) grid.constraints.for_each_master(c.row, [&](int master, double) { moves[master] = 1; });
    for (int i = 0; i < grid.size(); ++i)
      if (moves[i]) nodes.push_back(i);
  }

  // Both as in ExtensionConstraints, for these nodes alone. values: three numbers per node.
  void extend(const EigenvalueSystem& system, double* values) const {
    const ExtensionConstraints& constraints = system.grid->constraints;
    if (!system.blocks) return constraints.extend(values);
    for (const Constrained& c : constrained_nodes) {
      double sum[3] = {0.0, 0.0, 0.0};
      constraints.for_each_master(c.row, [&](int master, double weight) {
        for (int d = 0; d < 3; ++d) sum[d] += weight * values[3 * master + d];
      });
      std::copy(sum, sum + 3, values + 3 * c.node);
    }
  }
  void gather_to_masters(const EigenvalueSystem& system, double* values) const {
    const ExtensionConstraints& constraints = system.grid->constraints;
    if (!system.blocks) return constraints.gather_to_masters(values);
    for (const Constrained& c : constrained_nodes) {
      double of_constrained[3];
      for (int d = 0; d < 3; ++d) {
        of_constrained[d] = values[3 * c.node + d];
        values[3 * c.node + d] = 0.0;
      }
      constraints.for_each_master(c.row, [&](int master, double weight) {
        for (int d = 0; d < 3; ++d) values[3 * master + d] += weight * of_constrained[d];
      });
    }
  }
};

// Largest eigenvalue of the tridiagonal matrix of a Lanczos iteration. beta: the next number beside its diagonal.
EigenvalueEstimate largest_of_tridiagonal(std::vector<double>& diagonal, std::vector<double>& off_diagonal, double beta) {
  const int m = static_cast<int>(diagonal.size());
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  const Eigen::VectorXd d = Eigen::Map<Eigen::VectorXd>(diagonal.data(), m);
  const Eigen::VectorXd e = Eigen::Map<Eigen::VectorXd>(off_diagonal.data(), m - 1);
  solver.computeFromTridiagonal(d, e);
  return {solver.eigenvalues()[m - 1], beta * std::fabs(solver.eigenvectors()(m - 1, m - 1)), m, 0.0};
}

}  // namespace

double eigenvalue_bound(Basis basis, double largest_stiffness, double density, double h) {
  const double most = with_basis(basis, [](auto type) { return decltype(type)::kSteepest; });
  return most * largest_stiffness / (density * h * h);
}

// Lanczos iteration. v is the vector of this step and `previous` that of the last step. w is M^-1 K v, then the part of it
// that is orthogonal to v and `previous`. The projected operator is the tridiagonal matrix with `diagonal` beside `off_diagonal`.
EigenvalueEstimate largest_eigenvalue(MPI_Comm comm, const std::vector<EigenvalueSystem>& systems, const Law& law, double tolerance) {
  // The vectors have the nodes of all bonds, one bond after the other.
  std::vector<std::size_t> first(systems.size() + 1, 0);
  std::vector<const HaloSum*> halos;
  std::vector<MovingNodes> moving;
  std::vector<int> nodes;  // moving nodes of all bonds
  for (std::size_t p = 0; p < systems.size(); ++p) {
    first[p + 1] = first[p] + static_cast<std::size_t>(systems[p].grid->size());
    halos.push_back(&systems[p].grid->halo);
    moving.emplace_back(systems[p]);
    for (int i : moving.back().nodes) nodes.push_back(static_cast<int>(first[p]) + i);
  }
  HaloSums shared;
  shared.build(halos);
  const int n = static_cast<int>(first.back());
  std::vector<double> mass(n);
  std::vector<char> counts(n);  // true on one of the ranks that share a node
  for (std::size_t p = 0; p < systems.size(); ++p) {
    std::copy(systems[p].grid->mass.begin(), systems[p].grid->mass.end(), mass.begin() + first[p]);
    std::copy(systems[p].grid->halo.counts_here().begin(), systems[p].grid->halo.counts_here().end(), counts.begin() + first[p]);
  }
  const auto dot = [&](const std::vector<double>& a, const std::vector<double>& b) {
    double mine = 0.0, all;
    for (int i : nodes)
      if (counts[i]) mine += mass[i] * (a[3 * i] * b[3 * i] + a[3 * i + 1] * b[3 * i + 1] + a[3 * i + 2] * b[3 * i + 2]);
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, comm);
    return all;
  };
  // Start with a unit vector of random components.
  std::vector<double> v(3 * n, 0.0), previous(3 * n, 0.0), w(3 * n, 0.0);
  for (std::size_t p = 0; p < systems.size(); ++p)
    for (int node : moving[p].nodes) {
      const std::size_t i = first[p] + node;
      for (int c = 0; c < 3; ++c) v[3 * i + c] = mass[i] > 0.0 ? start_value(systems[p].grid->keys[node], c) : 0.0;
    }
  const double norm = std::sqrt(dot(v, v));
  EigenvalueEstimate best{0.0, 0.0, 0, 0.0};
  if (!(norm > 0.0)) return best;
  for (double& x : v) x /= norm;

  std::vector<double> diagonal, off_diagonal;
  double beta = 0.0;
  for (int k = 0; k < kMostProducts; ++k) {
    // w = -K v, with the forces of constrained nodes on their masters, summed over the ranks.
    for (int i : nodes) std::fill(&w[3 * i], &w[3 * i] + 3, 0.0);
    std::vector<double*> of_systems;
    for (std::size_t p = 0; p < systems.size(); ++p) {
      of_systems.push_back(&w[3 * first[p]]);
      moving[p].extend(systems[p], &v[3 * first[p]]);
      add_stiffness_force(*systems[p].points, *systems[p].grid, law, &v[3 * first[p]], of_systems.back(),
                          {systems[p].failed_as_undamaged, systems[p].blocks});
      moving[p].gather_to_masters(systems[p], of_systems.back());
    }
    shared.sum(of_systems, 3);
    // w = M^-1 K v
    for (int i : nodes) {
      const double factor = mass[i] > 0.0 ? -1.0 / mass[i] : 0.0;
      for (int c = 0; c < 3; ++c) w[3 * i + c] *= factor;
    }
    // The new row of the tridiagonal matrix, alpha on its diagonal and beta beside it.
    const double alpha = dot(v, w);
    for (int i : nodes)
      for (int j = 3 * i; j < 3 * i + 3; ++j) w[j] -= alpha * v[j] + beta * previous[j];
    diagonal.push_back(alpha);
    beta = std::sqrt(dot(w, w));
    if (!std::isfinite(alpha) || !std::isfinite(beta)) {
      best.value = best.most = std::numeric_limits<double>::infinity();
      break;
    }
    best = largest_of_tridiagonal(diagonal, off_diagonal, beta);
    best.most = best.value + std::max(best.residual, tolerance * best.value);
    if (best.residual <= tolerance * best.value || beta == 0.0) break;
    off_diagonal.push_back(beta);
    previous.swap(v);
    for (int i : nodes)
      for (int j = 3 * i; j < 3 * i + 3; ++j) v[j] = w[j] / beta;
  }
  return best;
}

}  // namespace mpdem
