// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Passes over points of several materials. A block has points of one material, and blocks of one material follow each other,
// so a pass picks the class of the law a few times, and once where there is one material.
#ifndef MPDEM_MPM_MATERIAL_RUNS_H
#define MPDEM_MPM_MATERIAL_RUNS_H

#include "../material/laws.h"
#include "point_store.h"

namespace mpdem {

// Calls f(law, first, last) for runs of blocks [first, last) of one material, with its law as an object of its own class.
// law: that of material 0.
template <class F>
void for_each_material(const PointStore& points, const Law& law, int first, int last, F f) {
  if (law.materials() == 1) {
    with_law(law, [&](const auto& l) { f(l, first, last); });
    return;
  }
  for (int b = first; b < last;) {
    const int material = points.meta[b].material;
    int end = b;
    while (end < last && points.meta[end].material == material) ++end;
    with_law(law.of_material(material), [&](const auto& l) { f(l, b, end); });
    b = end;
  }
}
template <class F>
void for_each_material(const PointStore& points, const Law& law, F f) {
  for_each_material(points, law, 0, static_cast<int>(points.blocks.size()), f);
}

// Law of the points of a block; law: that of material 0.
inline const Law& law_of_block(const PointStore& points, const Law& law, int b) {
  return law.materials() == 1 ? law : law.of_material(points.meta[b].material);
}

// Law of the points of a bond that are all of one material.
inline const Law& law_of_bond(const PointStore& points, const Law& law) { return points.meta.empty() ? law : law_of_block(points, law, 0); }

}  // namespace mpdem

#endif
