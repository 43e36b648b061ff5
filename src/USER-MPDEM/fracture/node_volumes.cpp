// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Class NodeSplitter: volumes of copies, see phantom_nodes.h.
#include <algorithm>

#include "phantom_nodes.h"

namespace mpdem {

// Sum of the volumes of points times their weights at a node.
double NodeSplitter::volume_at(const GridIndex& node, const std::vector<int>& points) const {
  double sum = 0.0;
  with_basis(basis_, [&](auto type) {
    using Type = decltype(type);
    for (int i : points) {
      const SplitterPoint& p = points_[i];
      vd w[Type::kSupport], slope[Type::kSupport];
      Type::factors(vd{p.at[0], p.at[1], p.at[2]}, 1.0, w, slope);
      sum += p.volume * w[node[0] - p.base[0]][0] * w[node[1] - p.base[1]][1] * w[node[2] - p.base[2]][2];
    }
  });
  return sum;
}

// A copy of a node is split between the components of its points, which share its volume. rank: components by size. The
// largest, rank[0], keeps the number `copy`, and the others get the numbers from `next` on. group: all points of the copy.
// If the weights of all points are zero at the node, the largest component gets the whole volume.
void NodeSplitter::share_volume(const GridIndex& node, const std::vector<int>& group, int copy, int next, const PhantomNodes& copies,
                                const std::vector<std::vector<int>>& components, const std::vector<int>& rank) {
  double whole = -1.0, intact = 0.0;
  if (const PhantomNodes::Row* row = copies.row(node)) {
    for (const PhantomNodes::Entry& e : *row)
      if (e.copy == copy) whole = e.volume;
  } else {
    whole = volume_at(node, group);
  }
  std::vector<double> of_component;
  for (const std::vector<int>& c : components) {
    of_component.push_back(volume_at(node, c));
    intact += of_component.back();
  }
  std::map<int, double>& volumes = split_now_[node];
  for (std::size_t n = 0; n < rank.size(); ++n)
    volumes[n == 0 ? copy : next + static_cast<int>(n) - 1] = intact > 0.0 ? whole * of_component[rank[n]] / intact : n == 0 ? whole : 0.0;
}

// A copy keeps the volume of its intact points. The volume of the failed points that are left is divided between the copies
// that have points, in the ratio in which they had volume of failed points before.
std::vector<GridIndex> NodeSplitter::leave(PhantomNodes& copies) const {
  // The points of a copy that are left.
  struct Left {
    std::vector<int> intact, failed;   // points
    double volume = 0.0, share = 0.0;  // volume of intact points; volume that the copy had for failed points before
  };
  std::vector<GridIndex> nodes;
  for (const auto& r : copies.rows()) nodes.push_back(r.first);
  std::sort(nodes.begin(), nodes.end());
  for (const GridIndex& node : nodes) {
    PhantomNodes::Row row = *copies.row(node);
    std::map<int, Left> left;  // by copy of the node: what is left of it
    for_each_point(node, [&](int p) {
      Left& l = left[PhantomNodes::copy_of(row, points_[p].layer)];
      (points_[p].failed ? l.failed : l.intact).push_back(p);
    });
    double failed = 0.0, shares = 0.0;
    for (const PhantomNodes::Entry& e : row)
      if (const auto l = left.find(e.copy); l != left.end()) l->second.share = e.volume;
    for (auto& l : left) {
      failed += volume_at(node, l.second.failed);
      l.second.volume = volume_at(node, l.second.intact);
      l.second.share = std::max(0.0, l.second.share - l.second.volume);
      shares += l.second.share;
    }
    for (PhantomNodes::Entry& e : row) {
      const auto l = left.find(e.copy);
      if (l == left.end()) e.volume = 0.0;
      else e.volume = l->second.volume + (shares > 0.0 ? failed * l->second.share / shares : volume_at(node, l->second.failed));
    }
    copies.set(node, std::move(row));
  }
  return nodes;
}

}  // namespace mpdem
