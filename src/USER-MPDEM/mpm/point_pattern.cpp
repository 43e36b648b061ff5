// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_pattern.h"

#include <algorithm>

#include "../numerics/text_of.h"

namespace mpdem {

PointRecord PointPattern::record(std::size_t n, int row, const Body& body) const {
  const PatternPoint& p = points[n];
  PointRecord r;
  r.body = row;
  std::copy(p.X, p.X + 3, r.X);
  r.volume = p.volume;
  r.links = p.links;
  r.film = p.film;
  for (int k = 0; k < p.links; ++k) {
    r.link[k].grain = body.grain[p.link[k].side];
    std::copy(p.link[k].foot, p.link[k].foot + 3, r.link[k].foot);
    r.link[k].area = p.link[k].area;
    r.link[k].attached = true;
  }
  return r;
}

std::vector<double> packed(const std::vector<PointPattern>& patterns) {
  std::vector<double> numbers;
  for (const PointPattern& p : patterns) {
    append(p.head, numbers);
    for (const PatternPoint& point : p.points) append(point, numbers);
  }
  return numbers;
}

void read(RecordReader& in, int count, std::vector<PointPattern>& patterns) {
  patterns.clear();
  for (int n = 0; n < count && in.trouble().empty(); ++n) {
    patterns.emplace_back();
    PointPattern& p = patterns.back();
    in.read(p.head);
    for (int k = 0; k < p.head.points && in.trouble().empty(); ++k) {
      p.points.emplace_back();
      in.read(p.points.back());
    }
  }
}

std::string trouble_of(const std::vector<PointPattern>& patterns, const std::vector<Body>& bodies) {
  std::vector<char> known(patterns.size() + 1, 0);
  for (std::size_t row = 0; row < bodies.size(); ++row) {
    const Body& b = bodies[row];
    if (b.pattern == 0) continue;
    const std::string bond = text_of("the bond of grains ", b.grain[0], " and ", b.grain[1]);
    if (b.pattern > static_cast<int>(patterns.size())) return text_of(bond, " is to have pattern ", b.pattern, " of ", patterns.size());
    const PointPattern& p = patterns[b.pattern - 1];
    if (p.head.points != b.points) return text_of(bond, " is to have ", b.points, " points, its pattern has ", p.head.points);
    if (known[b.pattern]) continue;
    known[b.pattern] = 1;
    Body made(b);
    made.pattern = 0;
    for (std::size_t n = 0; n < p.points.size(); ++n) {
      PointRecord r = p.record(n, 0, b);
      const std::string trouble = trouble_of(r, {made});
      if (!trouble.empty()) return text_of("of the pattern of ", bond, ", ", trouble);
    }
  }
  return "";
}

}  // namespace mpdem
