// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "consistent_mass.h"

#include "gather.h"
#include "scatter.h"

namespace mpdem {

void add_consistent_mass(const PointStore& points, const Grid& grid, double density, double scale, std::vector<double> field,
                         std::vector<double>& out) {
  grid.ties.take_of_heirs(field.data(), 3);
  const double inverse_h = 1.0 / grid.h;
  with_basis(grid.basis, [&](auto type) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const PointBlock& p = points.blocks[b];
      const BlockMeta& m = points.meta[b];
      with_weights<decltype(type)>(p, m, inverse_h, [&](const auto& s) {
        const vd mass = scale * density * p.volume;
        vd v[3];
        gather_value(field.data(), m.column, s, v);
        for (int i = 0; i < 3; ++i) v[i] *= mass;
        scatter_value(out.data(), m.column, s, v);
      });
    }
  });
  grid.ties.bequeath(out.data(), 3);
}

}  // namespace mpdem
