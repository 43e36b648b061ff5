// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Template of the points that a bond will have when they are made. Bonds of equal geometry share one, since they are
// equal in their own axes. Every rank has all templates. BondRecord::point_template is the number of the template of a bond that has
// no points yet.
#ifndef MPDEM_MPM_POINT_TEMPLATE_H
#define MPDEM_MPM_POINT_TEMPLATE_H

#include <string>
#include <vector>

#include "point_record.h"

namespace mpdem {

struct TemplatePoint {
  static constexpr int kMaxLinks = PointRecord::kMaxLinks;
  struct Attachment {
    int side = 0;  // 0: linked to the first grain, 1: to the second
    double foot[3] = {0, 0, 0}, area = 0;

    template <class Self, class Visitor>
    static constexpr void describe(Self& a, Visitor& visit) {
      visit("the end of a link", a.side, from(0, 1));
      visit("the foot of a link", a.foot, kFinite);
      visit("the area of a link", a.area, kNotNegative);
    }
  };
  double X[3] = {0, 0, 0}, volume = 0;
  int links = 0;
  bool film = false;
  int material = 0;
  Attachment link[kMaxLinks];

  template <class Self, class Visitor>
  static constexpr void describe(Self& p, Visitor& visit) {
    visit("its position", p.X, kFinite);
    visit("its volume", p.volume, kPositive);
    visit("'is film'", p.film);
    visit("the number of its material", p.material, from(0, kMostMaterials - 1));
    const int n = visit.length("its number of links", p.links, kMaxLinks);
    for (int k = 0; k < n; ++k) visit.part(p.link[k]);
  }
};

// Values common to all points of a template: type and mask of their atoms, and the density of the calcite.
struct TemplateHead {
  int type = 1, mask = 1;
  double density = 1.0;
  int points = 0;

  template <class Self, class Visitor>
  static constexpr void describe(Self& h, Visitor& visit) {
    visit("the atom type of a template", h.type, from(1, kLargestInt));
    visit("the groups of a template", h.mask, from(-kLargestInt - 1.0, kLargestInt));
    visit("the density of a template", h.density, kPositive);
    visit("the number of points of a template", h.points, from(1, kLargestInt));
  }
};

struct PointTemplate {
  TemplateHead head;
  std::vector<TemplatePoint> points;

  // Makes the record of point n for the bond in this row of the table.
  PointRecord record(std::size_t n, int row, const BondRecord& record) const;
  std::size_t memory_usage() const { return points.capacity() * sizeof(TemplatePoint); }
};

// Packs all templates into numbers. read() unpacks them. The reader reports what is wrong with the numbers of a file.
std::vector<double> packed(const std::vector<PointTemplate>& templates);
void read(RecordReader& in, int count, std::vector<PointTemplate>& templates);
// Text of what is wrong between the templates and the bonds that refer to them, or an empty string.
std::string trouble_of(const std::vector<PointTemplate>& templates, const std::vector<BondRecord>& records);

}  // namespace mpdem

#endif
