// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "stiffness_matrix.h"

#include <algorithm>

#include "../material/laws.h"
#include "block_nodes.h"
#include "material_runs.h"
#include "point_state.h"

namespace mpdem {

namespace {

using Strains = std::array<Sym3<vd>, 3>;  // strains due to a unit displacement in each direction

// Strain in the material frame by a displacement of one node in each direction. gradient: of its shape function, in the
// present configuration. R: from the material frame.
Strains strains_by(const vd* gradient, const Mat3<vd>& R) {
  Strains by;
  for (int c = 0; c < 3; ++c) {
    Mat3<vd> G{};
    for (int d = 0; d < 3; ++d) G.a[c][d] = gradient[d];
    by[c] = rotate_back(
        R, {G.a[0][0], G.a[1][1], G.a[2][2], 0.5 * (G.a[1][2] + G.a[2][1]), 0.5 * (G.a[0][2] + G.a[2][0]), 0.5 * (G.a[0][1] + G.a[1][0])});
  }
  return by;
}

bool is_stiff(const BlockMeta& m) { return m.failed != m.occupied; }

}  // namespace

void UnknownSet::clear() {
  for (int u : list) place_[u] = -1;
  list.clear();
}

int UnknownSet::place(int unknown) {
  if (place_[unknown] < 0) {
    place_[unknown] = static_cast<int>(list.size());
    list.push_back(unknown);
  }
  return place_[unknown];
}

UnknownsOfNodes::UnknownsOfNodes(const Grid& grid, const std::vector<char>& is_unknown) {
  const std::vector<int> row = grid.constraints.row_of_each(grid.size());
  std::vector<int> unknown_of(grid.size(), -1);
  for (int i = 0; i < grid.size(); ++i)
    if (row[i] < 0 && is_unknown[i]) {
      unknown_of[i] = static_cast<int>(node_.size());
      node_.push_back(i);
    }
  const auto add = [&](int node, double weight) {
    if (unknown_of[node] < 0) return;
    unknown_.push_back(unknown_of[node]);
    weight_.push_back(weight);
  };
  for (int i = 0; i < grid.size(); ++i) {
    if (row[i] < 0) add(i, 1.0);
    else grid.constraints.for_each_master(row[i], add);
    first_.push_back(static_cast<int>(unknown_.size()));
  }
}

StiffnessMatrix::StiffnessMatrix(const Grid& grid, const std::vector<char>& is_unknown)
    : grid_(grid), unknowns_(grid, is_unknown), set_(unknowns_.size()) {}

void StiffnessMatrix::couple(const PointStore& points) {
  std::vector<int> nodes;
  for (const BlockMeta& m : points.meta) {
    if (!is_stiff(m)) continue;
    nodes.clear();
    for_each_node(grid_, m, [&](int node) { nodes.push_back(node); });
    couple(nodes);
  }
}

void StiffnessMatrix::couple(const std::vector<int>& nodes) {
  set_.clear();
  for (int node : nodes) unknowns_.for_each(node, [&](int u, double) { set_.place(u); });
  sets_.insert(sets_.end(), set_.list.begin(), set_.list.end());
  first_of_set_.push_back(static_cast<int>(sets_.size()));
}

double StiffnessMatrix::Levels::multiplications() const {
  double sum = 0.0;
  for (std::size_t g = 0; g + 1 < first.size(); ++g) {
    const double size = 3.0 * (first[g + 1] - first[g]), next = g + 2 < first.size() ? 3.0 * (first[g + 2] - first[g + 1]) : 0.0;
    sum += size * size * (size / 6.0 + 0.5 * next) + 0.5 * size * next * next;
  }
  return sum;
}

StiffnessMatrix::Levels StiffnessMatrix::levels_from(int start) const {
  const int unknowns = static_cast<int>(unknowns_.size()), sets = static_cast<int>(first_of_set_.size()) - 1;
  std::vector<int> first(unknowns + 1, 0), set_of(sets_.size());  // sets of each unknown
  for (int u : sets_) ++first[u + 1];
  for (int u = 0; u < unknowns; ++u) first[u + 1] += first[u];
  std::vector<int> next(first.begin(), first.end() - 1);
  for (int s = 0; s < sets; ++s)
    for (int n = first_of_set_[s]; n < first_of_set_[s + 1]; ++n) set_of[next[sets_[n]]++] = s;
  std::vector<char> found(unknowns, 0), done(sets, 0);
  Levels l;
  l.first.push_back(0);
  for (int from = start, other = 0; from < unknowns;) {  // once for each connected part
    found[from] = 1;
    l.unknowns.push_back(from);
    for (int begin = static_cast<int>(l.unknowns.size()) - 1; begin < static_cast<int>(l.unknowns.size());) {
      const int end = static_cast<int>(l.unknowns.size());
      l.first.push_back(end);
      for (; begin < end; ++begin)
        for (int n = first[l.unknowns[begin]]; n < first[l.unknowns[begin] + 1]; ++n) {
          const int s = set_of[n];
          if (done[s]) continue;
          done[s] = 1;
          for (int k = first_of_set_[s]; k < first_of_set_[s + 1]; ++k)
            if (!found[sets_[k]]) {
              found[sets_[k]] = 1;
              l.unknowns.push_back(sets_[k]);
            }
        }
    }
    while (other < unknowns && found[other]) ++other;
    from = other;
  }
  return l;
}

bool StiffnessMatrix::order(double most) {
  if (unknowns_.size() == 0) return false;
  Levels best = levels_from(0);
  const Levels back = levels_from(best.unknowns.back());
  if (back.multiplications() < best.multiplications()) best = back;
  if (best.multiplications() > most) return false;
  level_.assign(unknowns_.size(), 0);
  place_.assign(unknowns_.size(), 0);
  std::vector<int> sizes;
  for (std::size_t g = 0; g + 1 < best.first.size(); ++g) {
    sizes.push_back(3 * (best.first[g + 1] - best.first[g]));
    for (int n = best.first[g]; n < best.first[g + 1]; ++n) {
      level_[best.unknowns[n]] = static_cast<int>(g);
      place_[best.unknowns[n]] = n - best.first[g];
    }
  }
  first_of_level_ = best.first;
  matrix_ = BlockTridiagonal(sizes);
  in_order_.resize(3 * static_cast<Eigen::Index>(unknowns_.size()));
  return true;
}

void StiffnessMatrix::add_product(int rows, int columns) {
  product_.resize(columns, columns);
  product_.triangularView<Eigen::Lower>() = motion_.topLeftCorner(rows, columns).transpose() * load_.topLeftCorner(rows, columns);
  for (int j = 0; j < columns / 3; ++j) {
    product_.block<3, 3>(3 * j, 3 * j).triangularView<Eigen::StrictlyUpper>() = product_.block<3, 3>(3 * j, 3 * j).transpose();
    for (int i = j; i < columns / 3; ++i) {
      const int I = set_.list[i], J = set_.list[j];
      const auto entries = product_.block<3, 3>(3 * i, 3 * j);
      if (level_[I] > level_[J]) matrix_.below(level_[J]).block<3, 3>(3 * place_[I], 3 * place_[J]) += entries;
      else if (level_[I] < level_[J]) matrix_.below(level_[I]).block<3, 3>(3 * place_[J], 3 * place_[I]) += entries.transpose();
      else if (place_[I] >= place_[J]) matrix_.diagonal(level_[I]).block<3, 3>(3 * place_[I], 3 * place_[J]) += entries;
      else matrix_.diagonal(level_[I]).block<3, 3>(3 * place_[J], 3 * place_[I]) += entries.transpose();
    }
  }
}

template <class Type, class L>
void StiffnessMatrix::add_blocks(const PointStore& points, int first, int last, const L& law) {
  std::vector<int> nodes;
  std::vector<Strains> strains;  // for each unknown of the block
  for (int b = first; b < last; ++b) {
    const PointBlock& p = points.blocks[b];
    const BlockMeta& m = points.meta[b];
    if (!is_stiff(m)) continue;
    const vd weight_of_stress = points.scatter.empty() ? p.volume : p.volume * points.scatter[b].stiffness;
    nodes.clear();
    for_each_node(grid_, m, [&](int node) { nodes.push_back(node); });
    set_.clear();
    strains.clear();
    const Mat3<vd> to_present = inverse(p.F), R = rotation_matrix(p.q);
    with_weights<Type>(p, m, 1.0 / grid_.h, [&](const auto& s) {
      using W = std::decay_t<decltype(s)>;
      const int* node = nodes.data();
      for (int i = 0; i < W::kI; ++i)
        for (int j = 0; j < W::kJ; ++j)
          for (int k = 0; k < W::kK; ++k, ++node) {
            const vd slope[3] = {s.dw[0][i] * s.w[1][j] * s.w[2][k], s.w[0][i] * s.dw[1][j] * s.w[2][k],
                                 s.w[0][i] * s.w[1][j] * s.dw[2][k]};
            vd gradient[3];
            for (int d = 0; d < 3; ++d)
              gradient[d] = slope[0] * to_present.a[0][d] + slope[1] * to_present.a[1][d] + slope[2] * to_present.a[2][d];
            const Strains by = strains_by(gradient, R);
            unknowns_.for_each(*node, [&](int u, double weight) {
              const std::size_t at = set_.place(u);
              if (at == strains.size()) strains.push_back(Strains{});
              for (int c = 0; c < 3; ++c) strains[at][c] = strains[at][c] + splat(weight) * by[c];
            });
          }
    });
    const int columns = 3 * static_cast<int>(strains.size()), live = m.occupied & ~m.failed;
    motion_.resize(6 * kLanes, columns);
    load_.resize(6 * kLanes, columns);
    int rows = 0;
    for (int n = 0; n < columns; ++n) {
      const Sym3<vd>& e = strains[n / 3][n % 3];
      const Sym3<vd> t = weight_of_stress * (m.damaged ? law.stress(e, state_of<L>(points, b)) : law.elasticity().stress(e));
      rows = 0;
      for (int l = 0; l < kLanes; ++l) {
        if (!(live >> l & 1)) continue;
        const double of_e[6] = {e.xx[l], e.yy[l], e.zz[l], 2.0 * e.yz[l], 2.0 * e.xz[l], 2.0 * e.xy[l]},
                     of_t[6] = {t.xx[l], t.yy[l], t.zz[l], t.yz[l], t.xz[l], t.xy[l]};
        std::copy(of_e, of_e + 6, &motion_(rows, n));
        std::copy(of_t, of_t + 6, &load_(rows, n));
        rows += 6;
      }
    }
    add_product(rows, columns);
  }
}

void StiffnessMatrix::add(const PointStore& points, const Law& law) {
  for_each_material(points, law, [&](const auto& l, int first, int last) {
    with_basis(grid_.basis, [&](auto type) { add_blocks<decltype(type)>(points, first, last, l); });
  });
}

void StiffnessMatrix::add(const std::vector<int>& nodes, const std::vector<Spring>& springs) {
  set_.clear();
  for (int node : nodes) unknowns_.for_each(node, [&](int u, double) { set_.place(u); });
  const Eigen::Index columns = 3 * static_cast<Eigen::Index>(set_.list.size()), rows = 3 * static_cast<Eigen::Index>(springs.size());
  motion_.setZero(rows, columns);
  load_.resize(rows, columns);
  for (std::size_t n = 0; n < springs.size(); ++n) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(n);
    for (std::size_t k = 0; k < nodes.size(); ++k)
      unknowns_.for_each(nodes[k], [&](int u, double weight) {
        motion_.block<3, 3>(row, 3 * set_.place(u)).diagonal().array() += weight * springs[n].weight[k];
      });
    for (Eigen::Index c = 0; c < columns; c += 3) load_.block<3, 3>(row, c) = motion_(row, c) * springs[n].stiffness;
  }
  add_product(static_cast<int>(rows), static_cast<int>(columns));
}

void StiffnessMatrix::add_to_diagonal(const std::vector<double>& of_node) {
  for (std::size_t u = 0; u < unknowns_.size(); ++u)
    for (int d = 0; d < 3; ++d) matrix_.diagonal(level_[u])(3 * place_[u] + d, 3 * place_[u] + d) += of_node[unknowns_.node(u)];
}

void StiffnessMatrix::solve(const std::vector<double>& r, std::vector<double>& x) {
  const auto at = [&](std::size_t u) { return 3 * static_cast<Eigen::Index>(first_of_level_[level_[u]] + place_[u]); };
  for (std::size_t u = 0; u < unknowns_.size(); ++u)
    for (int d = 0; d < 3; ++d) in_order_[at(u) + d] = r[3 * unknowns_.node(u) + d];
  matrix_.solve(in_order_);
  std::fill(x.begin(), x.end(), 0.0);
  for (std::size_t u = 0; u < unknowns_.size(); ++u)
    for (int d = 0; d < 3; ++d) x[3 * unknowns_.node(u) + d] = in_order_[at(u) + d];
}

}  // namespace mpdem
