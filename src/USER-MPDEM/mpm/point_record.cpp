// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_record.h"

#include <cmath>

#include "../material/laws.h"

namespace mpdem {

std::string trouble_of(const PointRecord& p, const std::vector<BondRecord>& records) {
  FirstTrouble found;
  if (!found.check_whole("its bond", p.row, from(0.0, static_cast<double>(records.size()) - 1.0))) return found.trouble();
  const BondRecord& of = records[p.row];
  if (of.point_template > 0) return "its bond has no points yet";
  const double reach = 1e8 * of.spacing;  // cell indices are int
  for (int d = 0; d < 3; ++d) {
    const Range near = from(of.lattice[d] - reach, of.lattice[d] + reach);
    found.check("its position", p.X[d], near);
    if (p.moving) found.check("its first position", p.X0[d], near);
  }
  found.check_whole("the number of its law of damage", p.law, from(0.0, static_cast<double>(law_entries().size())));
  if (p.law == 0 || p.law == kLawNumber<TensorDamage>)
    for (double D : p.damage) found.check("its damage", D, from(-1.0, 1.0));
  constexpr double kRounding = 1.0 + 1e-9;
  found.check("its volume", p.volume, from(0.0, kRounding * of.volume));
  for (int k = 0; k < p.links; ++k) {
    const Link& link = p.link[k];
    const int side = link.grain == of.grain[1];
    if (link.grain != of.grain[side]) found.tell("the grain of a link is " + std::to_string(link.grain) + ", which is none of its bond");
    found.check("the area of a link", link.area, from(0.0, kRounding * of.attached_area[side]));
    double square = 0.0;
    for (int d = 0; d < 3; ++d) square += std::pow(link.foot[d] - of.centre[side][d], 2);
    found.check("the distance of the foot of a link from the centre of the grain", std::sqrt(square),
                from(0.99 * of.radius[side], 1.01 * of.radius[side]));
  }
  if (p.film) {
    if (p.links != PointRecord::kMaxLinks || p.link[0].grain == p.link[1].grain)
      found.tell("it is film, and has no link to either grain of its bond");
    if (p.contacts > 0) found.tell("it is film, and has contact points");
  }
  for (int k = 0; k < p.contacts; ++k) {
    const ContactPoint& contact = p.contact[k];
    if (contact.grain != of.grain[0] && contact.grain != of.grain[1])
      found.tell("the grain of a contact point is " + std::to_string(contact.grain) + ", which is none of its bond");
    for (int d = 0; d < 3; ++d) found.check("where a contact point is", contact.X[d], from(of.lattice[d] - reach, of.lattice[d] + reach));
  }
  return found.trouble();
}

}  // namespace mpdem
