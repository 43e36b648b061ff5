// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Text form of a point: a row of the file that write_cement writes and create_cement ... file reads. Names are those of the
// columns (doc/write_cement.md), in their order. All is where it is now, in the box.
#ifndef MPDEM_POINT_ROW_H
#define MPDEM_POINT_ROW_H

#include "../parallel/record.h"

namespace mpdem {

struct PointRow {
  struct Side {
    double area = 0.0;  // 0: no link
    double foot[3] = {0, 0, 0};
    bool attached = false;
  };
  int grain[2] = {0, 0};
  double x[3] = {0, 0, 0}, volume = 0.0;
  bool has_axis = false;  // no column: all points have one or none has
  double axis[3] = {0, 0, 0};
  double damage[6] = {0, 0, 0, 0, 0, 0};
  bool failed = false;
  Side side[2];

  template <class Self, class Visitor>
  static constexpr void describe(Self& r, Visitor& visit) {
    const auto columns = [&visit](auto names, auto& field, Range range) {
      int n = 0;
      for (auto& v : field) visit(names[n++], v, range);
    };
    using Three = const char* const[3];
    using Six = const char* const[6];
    constexpr Three kPlace = {"x", "y", "z"}, kAxis = {"ax", "ay", "az"};
    constexpr Three kFoot[2] = {{"foot_ix", "foot_iy", "foot_iz"}, {"foot_jx", "foot_jy", "foot_jz"}};
    constexpr Six kDamage = {"dxx", "dyy", "dzz", "dyz", "dxz", "dxy"};
    visit("grain_i", r.grain[0], from(1, kLargestInt));
    visit("grain_j", r.grain[1], from(1, kLargestInt));
    columns(kPlace, r.x, kFinite);
    visit("volume", r.volume, kPositive);
    visit.left_out(r.has_axis);
    if (visit.present(r.has_axis)) columns(kAxis, r.axis, kFinite);
    columns(kDamage, r.damage, from(-1.0, 1.0));
    visit("failed", r.failed);
    for (int s = 0; s < 2; ++s) {
      visit(s == 0 ? "area_i" : "area_j", r.side[s].area, kNotNegative);
      columns(kFoot[s], r.side[s].foot, kFinite);
      visit(s == 0 ? "attached_i" : "attached_j", r.side[s].attached);
    }
  }
};

}  // namespace mpdem

#endif
