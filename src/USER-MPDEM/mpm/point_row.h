// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Text form of a point: a row of the file that write_cement writes and `create_cement ... file` reads. The columns and
// their order are documented in doc/write_cement.md and doc/point_files.md. Positions are present ones in the box.
#ifndef MPDEM_MPM_POINT_ROW_H
#define MPDEM_MPM_POINT_ROW_H

#include "bond_record.h"

namespace mpdem {

struct PointRow {
  struct Side {
    double area = 0.0;  // 0: no link
    double foot[3] = {0, 0, 0};
    bool attached = false;
    double damage = 0.0;  // damage of the link
  };
  // Names of columns. Columns of one group are all present or all absent.
  static constexpr const char *kGrain[2] = {"grain_i", "grain_j"}, *kPlace[4] = {"x", "y", "z", "volume"}, *kAxis[3] = {"ax", "ay", "az"},
                              *kDamage[6] = {"dxx", "dyy", "dzz", "dyz", "dxz", "dxy"}, *kFailed[1] = {"failed"},
                              *kArea[2] = {"area_i", "area_j"},
                              *kFoot[6] = {"foot_ix", "foot_iy", "foot_iz", "foot_jx", "foot_jy", "foot_jz"},
                              *kAttached[2] = {"attached_i", "attached_j"}, *kLinkDamage[2] = {"damage_i", "damage_j"},
                              *kMaterial[1] = {"material"};

  int grain[2] = {0, 0};
  double x[3] = {0, 0, 0}, volume = 0.0;
  bool has_axis = false;  // not a column: all points of a file have an axis, or none has
  double axis[3] = {0, 0, 0};
  double damage[6] = {0, 0, 0, 0, 0, 0};
  bool failed = false;
  bool has_link_damage = false;  // not a column: all rows have it, or none has; with it a failed point may be residue on a grain
  Side side[2];
  bool has_material = false;  // not a column: all rows have it, or none has
  int material = 0;           // number of its material

  template <class Self, class Visitor>
  static constexpr void describe(Self& r, Visitor& visit) {
    const auto columns = [&visit](const char* const* names, auto& field, Range range) {
      for (auto& v : field) visit(*names++, v, range);
    };
    columns(kGrain, r.grain, from(1, kLargestInt));
    columns(kPlace, r.x, kFinite);
    visit(kPlace[3], r.volume, kPositive);
    visit.left_out(r.has_axis);
    if (visit.present(r.has_axis)) columns(kAxis, r.axis, kFinite);
    columns(kDamage, r.damage, from(-1.0, 1.0));
    visit(kFailed[0], r.failed);
    visit.left_out(r.has_link_damage);
    for (int s = 0; s < 2; ++s) {
      visit(kArea[s], r.side[s].area, kNotNegative);
      columns(kFoot + 3 * s, r.side[s].foot, kFinite);
      visit(kAttached[s], r.side[s].attached);
      if (visit.present(r.has_link_damage)) visit(kLinkDamage[s], r.side[s].damage, from(0.0, 1.0));
    }
    visit.left_out(r.has_material);
    if (visit.present(r.has_material)) visit(kMaterial[0], r.material, from(0, kMostMaterials - 1));
  }
};

}  // namespace mpdem

#endif
