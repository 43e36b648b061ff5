// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "contacts.h"

#include <algorithm>
#include <set>
#include <unordered_map>

namespace mpdem {

std::vector<std::pair<int, int>> contacts(const std::vector<Sphere>& spheres, const SceneBox& box, double gap) {
  struct SortedSphere {
    double x;
    const Sphere* grain;
  };
  std::vector<SortedSphere> sorted;
  double widest = 0.0;
  for (const Sphere& g : spheres) widest = std::max(widest, g.radius);
  const double reach = 2.0 * widest + gap;
  for (const Sphere& g : spheres) {
    sorted.push_back({g.x[0], &g});
    // A grain near the lower face has an image beyond the upper face, for the grains there.
    if (box.periodic[0] && g.x[0] - box.low[0] <= reach) sorted.push_back({g.x[0] + box.period[0], &g});
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const SortedSphere& a, const SortedSphere& b) { return a.x != b.x ? a.x < b.x : a.grain->tag < b.grain->tag; });
  std::set<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < sorted.size(); ++i)
    for (std::size_t j = i + 1; j < sorted.size() && sorted[j].x - sorted[i].x <= reach; ++j) {
      const Sphere &a = *sorted[i].grain, &b = *sorted[j].grain;
      const Vector3 d = box.shortest(b.x - a.x);
      const double distance = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      if (&a == &b || distance - a.radius - b.radius > gap) continue;
      pairs.insert(std::minmax(a.tag, b.tag));
    }
  return {pairs.begin(), pairs.end()};
}

int contacts_twice(const std::vector<Sphere>& spheres, const std::vector<std::pair<int, int>>& pairs, const SceneBox& box, double gap) {
  std::unordered_map<int, const Sphere*> of;
  for (const Sphere& g : spheres) of.emplace(g.tag, &g);
  const std::vector<Vector3> images = box.images();
  int twice = 0;
  for (const auto& p : pairs) {
    const Sphere &a = *of.at(p.first), &b = *of.at(p.second);
    const Vector3 d = box.shortest(b.x - a.x);
    const auto touches = [&](const Vector3& image) { return (d + image).norm() - a.radius - b.radius <= gap; };
    twice += std::count_if(images.begin(), images.end(), touches) > 1;
  }
  return twice;
}

}  // namespace mpdem
