// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "debonded_contact.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "../material/coulomb.h"
#include "../mpm/lane_by_lane.h"
#include "../parallel/agree.h"
#include "free_weights.h"
#include "rigid_motion.h"

namespace mpdem {

namespace {

constexpr double kOneSided = 2.0;  // factor of the stiffness for the added mass, see the header
// A contact point is about to touch within this share of a cell, about the stretch of a cell at the strength, or if it
// would come that near in kMargin times the time `soon`.
constexpr double kNear = 1e-3, kMargin = 2.0;

vd dot(const vd* a, const vd* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

int side_of(const BondRecord& record, int grain) { return record.grain[0] == grain ? 0 : 1; }

double distance(const double* a, const double* b) {
  double square = 0.0;
  for (int d = 0; d < 3; ++d) square += (a[d] - b[d]) * (a[d] - b[d]);
  return std::sqrt(square);
}

bool before(const ContactPoint& a, const ContactPoint& b) { return a.slot != b.slot ? a.slot < b.slot : a.grain < b.grain; }

ContactPoint* find(std::vector<ContactPoint>& contacts, int slot, int grain) {
  ContactPoint wanted;
  wanted.slot = slot;
  wanted.grain = grain;
  const auto p = std::lower_bound(contacts.begin(), contacts.end(), wanted, before);
  return p != contacts.end() && p->slot == slot && p->grain == grain ? &*p : nullptr;
}

}  // namespace

DebondedContact::DebondedContact(const PointStore& points, const BondRecord& record, const PenaltyParameters& parameters, const Grid& grid)
    : p_(parameters), columns_of_cell_(support(grid.basis) * support(grid.basis)), inverse_h_(1.0 / grid.h) {
  lay_out(points, record, grid);
}

// Lays out the contact points in blocks of one grain, in the order of the tags of their points.
void DebondedContact::lay_out(const PointStore& points, const BondRecord& record, const Grid& grid) {
  blocks_.clear();
  const auto key = [&](int i) {
    const ContactPoint& p = points.contacts[i];
    return std::make_pair(side_of(record, p.grain), points.tag(p.slot));
  };
  std::vector<int> order(points.contacts.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  columns_.clear();
  for (auto i = order.begin(); i != order.end();) {
    Block b{};
    b.side = key(*i).first;
    std::fill(b.contact, b.contact + kLanes, -1);
    columns_.resize(columns_.size() + kLanes * columns_of_cell_, 0);
    int lane = 0;
    for (; lane < kLanes && i != order.end() && key(*i).first == b.side; ++lane, ++i) {
      const ContactPoint& p = points.contacts[*i];
      const int block = p.slot / kLanes;
      int base[3];
      for (int d = 0; d < 3; ++d) {
        base[d] = support_base(points.blocks[block].X[d][p.slot % kLanes], inverse_h_, cell_shift(grid.basis));
        b.base[d][lane] = base[d];
        b.X[d][lane] = p.X[d];
        b.stick_point[d][lane] = p.stick_point[d];
      }
      b.area[lane] = p.area;
      b.added_mass_area[lane] = p.added_mass_area;
      b.friction_traction[lane] = p.friction_traction;
      b.radius[lane] = p.radius;
      b.contact[lane] = *i;
      b.taken |= static_cast<std::uint8_t>(1u << lane);
      if (!points.has_failed(p.slot)) b.intact |= static_cast<std::uint8_t>(1u << lane);
      if (p.closed) b.closed |= static_cast<std::uint8_t>(1u << lane);
      if (!grid.find_columns(field_of(points.meta[block].row, points.meta[block].layer), base,
                             &columns_[columns_.size() - (kLanes - lane) * columns_of_cell_]))
        throw std::logic_error("a contact point is outside of the grid of its bond");
    }
    for (; lane < kLanes; ++lane)  // empty lanes have the position of the first lane
      for (int d = 0; d < 3; ++d) {
        b.X[d][lane] = b.X[d][0];
        b.base[d][lane] = b.base[d][0];
      }
    blocks_.push_back(b);
  }
}

void DebondedContact::touch(const Block& b, const Grid& grid, const BondEnd& s, Touch& t) const {
  vd u[3];
  with_basis(grid.basis, [&](auto type) {
    gather_value_by_lane(grid.displacement.data(), b.taken, columns(b), Weights<decltype(type)>(b.X, b.base, inverse_h_), u);
  });
  for (int i = 0; i < 3; ++i) t.q[i] = (b.X[i] - s.x[i]) + u[i];
  const vd size = sqrt(dot(t.q, t.q)), inverse = 1.0 / size;
  t.gap = size - b.radius;
  for (int i = 0; i < 3; ++i) t.n[i] = inverse * t.q[i];
  find_stretch(b, s, t);
}

// Not inlined, so that it rounds alike wherever it is called: a run from a restart file finds the same forces.
__attribute__((noinline)) void DebondedContact::find_stretch(const Block& b, const BondEnd& s, Touch& t) {
  vd d[3];
  for (int i = 0; i < 3; ++i)
    d[i] = t.q[i] - (s.R.a[i][0] * b.stick_point[0] + s.R.a[i][1] * b.stick_point[1] + s.R.a[i][2] * b.stick_point[2]);
  const vd along = dot(d, t.n);
  for (int i = 0; i < 3; ++i) t.e[i] = masked(b.closed, d[i] - along * t.n[i]);
}

vd DebondedContact::energy(const Block& b, const Touch& t) const {
  const vd in = max(-t.gap, vd{});
  const TractionStiffness k = p_.contact();
  return masked(b.intact, 0.5 * b.area * (k.kn * in * in + k.kt * dot(t.e, t.e)));
}

double DebondedContact::follow(Block& b, PointStore& points, const BondEnd& s, Touch& t) {
  const std::uint8_t was = b.closed;
  b.closed = static_cast<std::uint8_t>(bits(t.gap < 0.0) & b.intact);
  if (!b.closed && !was) return 0.0;
  const TractionStiffness k = p_.contact();
  const vmask starts = lanes(static_cast<std::uint8_t>(b.closed & ~was));
  const vd limit = p_.friction * k.kn * max(-t.gap, vd{}), size = k.kt * sqrt(dot(t.e, t.e));  // mu p, |kt e|
  const vd share = masked(was, sliding_share(limit, size));  // all of e slips where the gap opens, since limit is 0
  for (int i = 0; i < 3; ++i) {
    const vd at = s.R.a[0][i] * t.q[0] + s.R.a[1][i] * t.q[1] + s.R.a[2][i] * t.q[2];
    const vd slip = share * (s.R.a[0][i] * t.e[0] + s.R.a[1][i] * t.e[1] + s.R.a[2][i] * t.e[2]);
    b.stick_point[i] = select(starts, at, b.stick_point[i] + slip);
  }
  // The slip happened between the last step and this one, so the mean of the tractions of both works on it.
  const vd slides = select(size > (1.0 - 1e-9) * limit, limit, size);
  const double frictional =
      sum_lanes(masked(static_cast<std::uint8_t>(b.closed | was), 0.5 * b.area * (b.friction_traction + slides) * share * size / k.kt));
  b.friction_traction = masked(b.closed, slides);
  find_stretch(b, s, t);
  for (int l = 0; l < kLanes; ++l) {
    if (!((b.closed | was) >> l & 1)) continue;
    ContactPoint& p = points.contacts[b.contact[l]];
    p.closed = b.closed >> l & 1;
    p.friction_traction = b.friction_traction[l];
    for (int i = 0; i < 3; ++i) p.stick_point[i] = b.stick_point[i][l];
    if (p.closed) largest_penetration_ = std::max(largest_penetration_, -t.gap[l]);
  }
  return frictional;
}

void DebondedContact::add_force(const Block& b, const Touch& t, Grid& grid, BondEnd& s) const {
  const TractionStiffness k = p_.contact();
  vd f[3];
  for (int i = 0; i < 3; ++i) f[i] = masked(b.closed, b.area * (k.kn * max(-t.gap, vd{}) * t.n[i] - k.kt * t.e[i]));
  with_basis(grid.basis, [&](auto type) {
    scatter_value_by_lane(grid.force.data(), b.closed, columns(b), Weights<decltype(type)>(b.X, b.base, inverse_h_), f);
  });
  subtract_from_grain(t.q, f, s);
}

double DebondedContact::follow(PointStore& points, const Grid& grid, const BondEnd* ends) {
  double frictional = 0.0;
  largest_penetration_ = 0.0;
  for (Block& b : blocks_) {
    if (b.has_failed_points_only()) continue;
    Touch t;
    touch(b, grid, ends[b.side], t);
    frictional += follow(b, points, ends[b.side], t);
  }
  return frictional;
}

void DebondedContact::add_force(Grid& grid, BondEnd* bond_ends) const {
  for (const Block& b : blocks_) {
    if (!b.closed) continue;
    Touch t;
    touch(b, grid, bond_ends[b.side], t);
    add_force(b, t, grid, bond_ends[b.side]);
  }
}

double DebondedContact::update_and_add_force(PointStore& points, Grid& grid, BondEnd* bond_ends) {
  double frictional = 0.0;
  largest_penetration_ = 0.0;
  for (Block& b : blocks_) {
    if (b.has_failed_points_only()) continue;
    Touch t;
    touch(b, grid, bond_ends[b.side], t);
    frictional += follow(b, points, bond_ends[b.side], t);
    if (b.closed) add_force(b, t, grid, bond_ends[b.side]);
  }
  return frictional;
}

void DebondedContact::add_energy(const Grid& grid, const BondEnd* bond_ends, double& U) const {
  for (const Block& b : blocks_) {
    if (b.has_failed_points_only()) continue;
    Touch t;
    touch(b, grid, bond_ends[b.side], t);
    U += sum_lanes(energy(b, t));
  }
}

void DebondedContact::find_velocity(const Block& b, const Grid& grid, const BondEnd& s, const Touch& t, vd* v, vd* of_grain) const {
  with_basis(grid.basis, [&](auto type) {
    gather_value_by_lane(grid.velocity.data(), b.taken, columns(b), Weights<decltype(type)>(b.X, b.base, inverse_h_), v);
  });
  velocity_at(s, t.q, of_grain);
  for (int d = 0; d < 3; ++d) v[d] -= of_grain[d];
}

// A contact point keeps its added mass up to twice the distance at which it gets it, so that it does not alternate.
bool DebondedContact::update_added_mass(PointStore& points, const Grid& grid, const BondEnd* bond_ends, double dt, double soon) {
  if (blocks_.empty()) return false;  // `bond_ends` may be empty
  bool changes = false;
  BondEnd before[2] = {bond_ends[0], bond_ends[1]};
  for (BondEnd& s : before)
    for (int d = 0; d < 3; ++d) s.x[d] -= dt * s.v[d];  // the grains have moved already, and the nodes have not
  for (Block& b : blocks_) {
    Touch t;
    touch(b, grid, before[b.side], t);
    vd v[3], of_grain[3];
    find_velocity(b, grid, before[b.side], t, v, of_grain);
    const vd least = t.gap + kMargin * soon * min(dot(v, t.n), vd{});
    const vd reach = select(b.added_mass_area > 0.0, splat(2.0 * kNear * grid.h), splat(kNear * grid.h));
    const vd wanted = masked(static_cast<std::uint8_t>(b.intact & bits(least < reach)), b.area);
    for (int l = 0; l < kLanes; ++l) {
      if (!(b.taken >> l & 1)) continue;
      changes = changes || wanted[l] != b.added_mass_area[l];
      points.contacts[b.contact[l]].added_mass_area = wanted[l];
    }
    b.added_mass_area = wanted;
  }
  return changes;
}

void DebondedContact::add_stiffness(const Grid& grid, const BondEnd* bond_ends, double* penalty) const {
  if (blocks_.empty()) return;
  FreeWeights free(grid);
  with_basis(grid.basis, [&](auto type) {
    for (const Block& b : blocks_) {
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      for (int l = 0; l < kLanes; ++l)
        if (b.added_mass_area[l] > 0.0)
          free.add_row_sums(columns(b) + columns_of_cell_ * l, w, l,
                            kOneSided * (1.0 + bond_ends[b.side].mass_ratio) * p_.stiffest_contact() * b.added_mass_area[l],
                            penalty + b.side);
    }
  });
}

namespace {

// Contact point of a debonded link, where the link acts in the reference.
ContactPoint contact_of_link(const PointStore& points, const Link& k, bool at_surface) {
  ContactPoint p;
  p.slot = k.slot;
  p.grain = k.grain;
  p.area = k.area;
  for (int d = 0; d < 3; ++d) p.X[d] = at_surface ? k.foot[d] : points.blocks[k.slot / kLanes].X[d][k.slot % kLanes];
  return p;
}

}  // namespace

vd DebondedContact::energy_across(const Block& b, const Touch& t, const Grid& grid, const BondEnd& s, double dt) const {
  const TractionStiffness k = p_.contact();
  vd v[3], of_grain[3];
  find_velocity(b, grid, s, t, v, of_grain);
  const vd normal = t.gap * (t.gap - dt * dot(v, t.n)), tangential = dot(t.e, t.e) - dt * dot(v, t.e);
  return 0.5 * b.area * (k.kn * normal + k.kt * tangential);
}

double DebondedContact::end(PointStore& points, const Grid& grid, const BondEnd* bond_ends, const std::vector<int>& failed, double dt) {
  double released = 0.0;
  for (Block& b : blocks_) {
    std::uint8_t ends = 0;
    for (int l = 0; l < kLanes; ++l)
      if ((b.intact >> l & 1) && std::binary_search(failed.begin(), failed.end(), points.contacts[b.contact[l]].slot))
        ends |= static_cast<std::uint8_t>(1u << l);
    if (!ends) continue;
    const BondEnd& s = bond_ends[b.side];
    Touch t;
    touch(b, grid, s, t);
    released += sum_lanes(masked(static_cast<std::uint8_t>(ends & b.closed), energy_across(b, t, grid, s, dt)));
    b.intact &= static_cast<std::uint8_t>(~ends);
    b.closed &= b.intact;
    b.friction_traction = masked(b.closed, b.friction_traction);
    for (int l = 0; l < kLanes; ++l)
      if (ends >> l & 1) {
        points.contacts[b.contact[l]].closed = false;
        points.contacts[b.contact[l]].friction_traction = 0.0;
      }
  }
  return released;
}

double DebondedContact::open(PointStore& points, const BondRecord& record, const Grid& grid, const BondEnd* bond_ends,
                             const std::vector<int>& links, double dt) {
  if (links.empty()) return 0.0;
  const auto pressed = [&] {
    double sum = 0.0;
    for (const Block& b : blocks_) {
      Touch t;
      touch(b, grid, bond_ends[b.side], t);
      sum += sum_lanes(masked(static_cast<std::uint8_t>(bits(t.gap < 0.0) & b.intact), energy_across(b, t, grid, bond_ends[b.side], dt)));
    }
    return sum;
  };
  std::vector<ContactPoint> opened;
  for (int link : links) opened.push_back(contact_of_link(points, points.links[link], p_.at_surface));
  const double before_it = pressed();
  add(points, record, grid, std::move(opened));
  return pressed() - before_it;
}

void DebondedContact::add_debonded_at_creation(PointStore& points, const BondRecord& record, const Grid& grid, const BondEnd* bond_ends) {
  std::vector<ContactPoint> opened;
  for (const Link& k : points.links) {
    const bool failed = points.has_failed(k.slot);
    if ((!k.attached || failed) && !find(points.contacts, k.slot, k.grain)) opened.push_back(contact_of_link(points, k, p_.at_surface));
  }
  if (opened.empty()) return;
  add(points, record, grid, std::move(opened));
  for (Block& b : blocks_) {
    Touch t;
    touch(b, grid, bond_ends[b.side], t);
    b.radius = min(b.radius, b.radius + t.gap);  // so that a contact point nearer than that begins without a force
    for (int l = 0; l < kLanes; ++l)
      if (b.taken >> l & 1) points.contacts[b.contact[l]].radius = b.radius[l];
  }
}

void DebondedContact::add(PointStore& points, const BondRecord& record, const Grid& grid, std::vector<ContactPoint> opened) {
  for (ContactPoint& o : opened) {
    o.radius = distance(o.X, record.centre[side_of(record, o.grain)]);
    if (ContactPoint* there = find(points.contacts, o.slot, o.grain)) {
      there->area += o.area;
      o.slot = -1;
    }
  }
  for (const ContactPoint& o : opened)
    if (o.slot >= 0) points.contacts.push_back(o);
  std::sort(points.contacts.begin(), points.contacts.end(), before);
  lay_out(points, record, grid);
}

std::vector<DebondedContact::OrphanedContact> DebondedContact::orphans(const PointStore& points, const BondRecord& record) const {
  std::vector<OrphanedContact> all;
  for (const Block& b : blocks_)
    for (int l = 0; l < kLanes; ++l) {
      if (!((b.taken & ~b.intact) >> l & 1)) continue;
      const ContactPoint& p = points.contacts[b.contact[l]];
      OrphanedContact m{points.meta[p.slot / kLanes].row, p.grain, points.tag(p.slot), p.area, {}, {}, record.spacing};
      const double* centre = record.centre[b.side];
      const double r = distance(p.X, centre);
      // Distances are from the surface of the grain, not from the failed point: that may have been the last one at the
      // bottom of a hole, and the material beside the hole begins at the surface.
      for (int d = 0; d < 3; ++d) {
        m.n[d] = (p.X[d] - centre[d]) / r;
        m.X[d] = centre[d] + record.radius[b.side] * m.n[d];
      }
      all.push_back(m);
    }
  return all;
}

DebondedContact::Found DebondedContact::nearest(const PointStore& points, const OrphanedContact& m) {
  Found best;
  const double part = Found::kTie * m.spacing * m.spacing;
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const int intact = points.meta[b].occupied & ~points.meta[b].failed;
    if (!intact) continue;
    vd along{}, square{};
    for (int d = 0; d < 3; ++d) {
      const vd x = points.blocks[b].X[d] - m.X[d];
      along += m.n[d] * x;
      square += x * x;
    }
    const vd apart = 9.0 * square - 8.0 * along * along;  // along^2 + (3 across)^2
    for (int l = 0; l < kLanes; ++l) {
      if (!(intact >> l & 1)) continue;
      const double far = std::floor(apart[l] / part);
      if (!best.slots.empty() && far > best.far) continue;
      if (far < best.far) best.slots.clear();
      best.far = far;
      best.slots.push_back(kLanes * static_cast<int>(b) + l);
    }
  }
  return best;
}

namespace {

// Contact point half a spacing from a material point towards the grain.
ContactPoint contact_at_point(const PointStore& points, const BondRecord& record, int slot, int grain) {
  ContactPoint p;
  p.slot = slot;
  p.grain = grain;
  const int side = side_of(record, grain);
  const double* centre = record.centre[side];
  double X[3];
  for (int d = 0; d < 3; ++d) X[d] = points.blocks[slot / kLanes].X[d][slot % kLanes];
  const double r = distance(X, centre), to = std::max(record.radius[side], r - 0.5 * record.spacing);
  for (int d = 0; d < 3; ++d) p.X[d] = centre[d] + to / r * (X[d] - centre[d]);
  p.radius = distance(p.X, centre);
  return p;
}

}  // namespace

double DebondedContact::move(PointStore& points, const BondRecord& record, const Grid& grid, const BondEnd* ends,
                             const std::vector<Arrival>& arrivals, std::vector<std::array<int, 2>> gone) {
  std::sort(gone.begin(), gone.end());
  struct Sum {
    double area = 0, pressed = 0,
           slip[3] = {0, 0, 0};  // pressed and slip: sums over closed contact points of area times -g, and of area times e
  };
  std::map<std::pair<int, int>, Sum> sums;  // by slot and grain
  double before_it = 0.0, after = 0.0;
  add_energy(grid, ends, before_it);
  for (const Arrival& a : arrivals) sums[{a.slot, a.orphan.grain}].area += a.share * a.orphan.area;
  // Contact points that the slots have already keep their force.
  for (const Block& b : blocks_) {
    Touch t;
    touch(b, grid, ends[b.side], t);
    for (int l = 0; l < kLanes; ++l) {
      if (!(b.taken >> l & 1)) continue;
      const ContactPoint& p = points.contacts[b.contact[l]];
      const auto s = sums.find({p.slot, p.grain});
      if (s == sums.end()) continue;
      s->second.area += p.area;
      if (!p.closed) continue;
      s->second.pressed += p.area * std::max(0.0, -t.gap[l]);
      for (int d = 0; d < 3; ++d) s->second.slip[d] += p.area * t.e[d][l];
    }
  }
  std::vector<ContactPoint>& contacts = points.contacts;
  contacts.erase(std::remove_if(contacts.begin(), contacts.end(),
                                [&](const ContactPoint& p) {
                                  return points.has_failed(p.slot) &&
                                         std::binary_search(gone.begin(), gone.end(), std::array<int, 2>{points.tag(p.slot), p.grain});
                                }),
                 contacts.end());
  std::vector<ContactPoint> fresh;
  for (const auto& s : sums) {
    ContactPoint* p = find(contacts, s.first.first, s.first.second);
    if (p) {
      p->area = s.second.area;
      continue;
    }
    fresh.push_back(contact_at_point(points, record, s.first.first, s.first.second));
    fresh.back().area = s.second.area;
  }
  contacts.insert(contacts.end(), fresh.begin(), fresh.end());
  std::sort(contacts.begin(), contacts.end(), before);
  lay_out(points, record, grid);
  for (const Block& b : blocks_) {
    const BondEnd& side_of_it = ends[b.side];
    Touch t;
    touch(b, grid, side_of_it, t);
    for (int l = 0; l < kLanes; ++l) {
      if (!(b.taken >> l & 1)) continue;
      ContactPoint& p = contacts[b.contact[l]];
      const auto s = sums.find({p.slot, p.grain});
      if (s == sums.end()) continue;
      const double size = p.radius + t.gap[l];  // |q|
      p.closed = s->second.pressed > 0.0;
      double square = 0.0;
      for (double e : s->second.slip) square += e * e;
      p.friction_traction = p_.contact().kt * std::sqrt(square) / p.area;
      p.radius = p.closed ? size + s->second.pressed / p.area : std::min(p.radius, size);
      for (int i = 0; i < 3; ++i) {
        p.stick_point[i] = 0.0;
        for (int d = 0; d < 3; ++d) p.stick_point[i] += side_of_it.R.a[d][i] * (t.q[d][l] - s->second.slip[d] / p.area);
      }
    }
  }
  lay_out(points, record, grid);  // the blocks have copies of the contact points
  add_energy(grid, ends, after);
  return after - before_it;
}

std::size_t DebondedContact::memory_usage() const { return blocks_.capacity() * sizeof(Block) + columns_.capacity() * sizeof(int); }

void DebondedContact::points_failed(const BondContext& b, const std::vector<int>& slots, const std::vector<int>& links, Losses& losses) {
  losses.released += end(b.points, b.grid, b.ends, slots, b.dt);
  links_debonded(b, links, losses);
}

void DebondedContact::links_debonded(const BondContext& b, const std::vector<int>& links, Losses& losses) {
  losses.released -= open(b.points, b.record, b.grid, b.ends, links, b.dt);
  changed_ = true;
}

void DebondedContact::add_force(const BondContext& b, Losses& losses) {
  if (b.dt > 0.0) losses.frictional += update_and_add_force(b.points, b.grid, b.ends);
  else add_force(b.grid, b.ends);
}

void DebondedContact::add_energy(const PointStore&, const Grid& grid, const BondEnd* ends, double&, double& of_coupling) const {
  add_energy(grid, ends, of_coupling);
}

std::string DebondedContact::trouble(const PointStore&, Grid& grid, long step) const {
  constexpr double kLargestPenetration = 0.01;
  if (!(largest_penetration_ > kLargestPenetration * grid.h)) return std::string();
  return text_of("cement is pressed ", largest_penetration_, " deep into a grain at step ", step, ", the most is ", kLargestPenetration,
                 " of a cell, ", kLargestPenetration * grid.h,
                 "; use slower grains, a smaller time step, or a larger 'kn' of fix mpm/couple");
}

}  // namespace mpdem
