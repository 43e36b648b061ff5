// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_template.h"

#include <algorithm>

#include "../numerics/text_of.h"

namespace mpdem {

PointRecord PointTemplate::record(std::size_t n, int row, const BondRecord& record) const {
  const TemplatePoint& p = points[n];
  PointRecord r;
  r.row = row;
  std::copy(p.X, p.X + 3, r.X);
  r.volume = p.volume;
  r.links = p.links;
  r.film = p.film;
  r.material = p.material;
  for (int k = 0; k < p.links; ++k) {
    r.link[k].grain = record.grain[p.link[k].side];
    std::copy(p.link[k].foot, p.link[k].foot + 3, r.link[k].foot);
    r.link[k].area = p.link[k].area;
    r.link[k].attached = true;
  }
  return r;
}

std::vector<double> packed(const std::vector<PointTemplate>& templates) {
  std::vector<double> numbers;
  for (const PointTemplate& p : templates) {
    append(p.head, numbers);
    for (const TemplatePoint& point : p.points) append(point, numbers);
  }
  return numbers;
}

void read(RecordReader& in, int count, std::vector<PointTemplate>& templates) {
  templates.clear();
  for (int n = 0; n < count && in.trouble().empty(); ++n) {
    templates.emplace_back();
    PointTemplate& p = templates.back();
    in.read(p.head);
    for (int k = 0; k < p.head.points && in.trouble().empty(); ++k) {
      p.points.emplace_back();
      in.read(p.points.back());
    }
  }
}

std::string trouble_of(const std::vector<PointTemplate>& templates, const std::vector<BondRecord>& records) {
  std::vector<char> known(templates.size() + 1, 0);
  for (std::size_t row = 0; row < records.size(); ++row) {
    const BondRecord& b = records[row];
    if (b.point_template == 0) continue;
    const std::string bond = text_of("the bond of grains ", b.grain[0], " and ", b.grain[1]);
    if (b.point_template > static_cast<int>(templates.size()))
      return text_of(bond, " is to have template ", b.point_template, " of ", templates.size());
    const PointTemplate& p = templates[b.point_template - 1];
    if (p.head.points != b.points) return text_of(bond, " is to have ", b.points, " points, its template has ", p.head.points);
    if (known[b.point_template]) continue;
    known[b.point_template] = 1;
    BondRecord made(b);
    made.point_template = 0;
    for (std::size_t n = 0; n < p.points.size(); ++n) {
      PointRecord r = p.record(n, 0, b);
      const std::string trouble = trouble_of(r, {made});
      if (!trouble.empty()) return text_of("of the template of ", bond, ", ", trouble);
    }
  }
  return "";
}

}  // namespace mpdem
