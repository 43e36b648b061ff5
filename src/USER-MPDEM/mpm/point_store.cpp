// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_store.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "checked_numbers.h"

namespace mpdem {

namespace {

template <class T>
void set_lane(Sym3<vd>& s, int l, const T* v) {
  s.xx[l] = v[0];
  s.yy[l] = v[1];
  s.zz[l] = v[2];
  s.yz[l] = v[3];
  s.xz[l] = v[4];
  s.xy[l] = v[5];
}

void get_lane(const Sym3<vd>& s, int l, double* v) {
  v[0] = s.xx[l];
  v[1] = s.yy[l];
  v[2] = s.zz[l];
  v[3] = s.yz[l];
  v[4] = s.xz[l];
  v[5] = s.xy[l];
}

PointBlock empty_block() {
  PointBlock b{};
  for (int i = 0; i < 3; ++i) b.F.a[i][i] = splat(1.0);
  b.q.w = splat(1.0);
  return b;
}

}  // namespace

const vd PointStore::kNoState[kMostStateFields] = {};

int PointRecord::pack(double* buf) const {
  int m = 0;
  buf[m++] = body;
  buf[m++] = part;
  buf[m++] = failed;
  buf[m++] = has_frame;
  buf[m++] = moving;
  for (double v : X) buf[m++] = v;
  buf[m++] = volume;
  for (double v : F) buf[m++] = v;
  for (double v : q) buf[m++] = v;
  for (double v : strain) buf[m++] = v;
  for (double v : damage) buf[m++] = v;
  if (moving) {
    for (double w : X0) buf[m++] = w;
    for (double w : v) buf[m++] = w;
    for (double w : C) buf[m++] = w;
  }
  buf[m++] = links;
  for (int i = 0; i < kMaxLinks; ++i) {
    const bool used = i < links;
    buf[m++] = used ? link[i].grain : 0;
    for (int d = 0; d < 3; ++d) buf[m++] = used ? link[i].foot[d] : 0.0;
    buf[m++] = used ? link[i].area : 0.0;
    buf[m++] = used ? link[i].attached + 2 * link[i].inert : 0;
    for (int d = 0; d < 3; ++d) buf[m++] = used ? link[i].moved[d] : 0.0;
  }
  return m;
}

template <class Numbers>
void PointRecord::take(Numbers& in) {
  body = in.integer("its bond", 0, kMaxBodies - 1);
  part = in.integer("its part", 0, kMaxParts - 1);
  failed = in.flag("'failed'");
  has_frame = in.flag("'has a frame'");
  moving = in.flag("'is moving'");
  in.finite("its place", X);
  volume = in.positive("its volume");
  in.finite("its deformation", F);
  in.quaternion("its frame", q);
  in.finite("its strain", strain);
  for (double& v : damage) v = in.within("its damage", -1.0, 1.0);
  if (moving) {
    in.finite("its first place", X0);
    in.finite("its velocity", v);
    in.finite("its velocity gradient", C);
  }
  links = in.integer("its number of links", 0, kMaxLinks);
  for (int i = 0; i < kMaxLinks; ++i) {
    link[i].slot = -1;
    link[i].grain = in.integer("the grain of a link", 0, std::numeric_limits<int>::max());
    in.finite("the foot of a link", link[i].foot);
    link[i].area = in.not_negative("the area of a link");
    const int state = in.integer("the state of a link", 0, 3);
    link[i].attached = state & 1;
    link[i].inert = state >> 1 & 1;
    in.finite("the way of a link", link[i].moved);
  }
}

int PointRecord::unpack(const double* buf) {
  TrustedNumbers in(buf);
  take(in);
  return static_cast<int>(in.next() - buf);
}

std::string PointRecord::unpack_checked(const double* buf, const std::vector<Body>& bodies) {
  CheckedNumbers in(buf);
  take(in);
  if (in.trouble().empty()) in.check("its bond", body, 0, static_cast<double>(bodies.size()) - 1);
  if (!in.trouble().empty()) return in.trouble();
  const Body& of = bodies[body];
  const double reach = 1e8 * of.spacing;  // cells are numbered by int
  for (int d = 0; d < 3; ++d) {
    in.check("its place", X[d], of.lattice[d] - reach, of.lattice[d] + reach);
    if (moving) in.check("its first place", X0[d], of.lattice[d] - reach, of.lattice[d] + reach);
  }
  constexpr double kRounding = 1.0 + 1e-9;
  in.check("its volume", volume, 0.0, kRounding * of.volume);
  for (int k = 0; k < links; ++k) {
    const int side = link[k].grain == of.grain[1];
    if (link[k].grain != of.grain[side]) in.tell("the grain of a link is " + std::to_string(link[k].grain) + ", which is none of its bond");
    in.check("the area of a link", link[k].area, 0.0, kRounding * of.attached_area[side]);
    double square = 0.0;
    for (int d = 0; d < 3; ++d) square += std::pow(link[k].foot[d] - of.centre[side][d], 2);
    in.check("the distance of the foot of a link from the centre of the grain", std::sqrt(square), 0.99 * of.radius[side], 1.01 * of.radius[side]);
  }
  return in.trouble();
}

void PointStore::clear() {
  blocks.clear();
  state_.clear();
  motion.clear();
  meta.clear();
  tags.clear();
  links.clear();
  settled_ = 0;
}

void PointStore::set(int slot, const PointRecord& r, int tag) {
  const int b = slot / kLanes, l = slot % kLanes;
  PointBlock& p = blocks[b];
  for (int d = 0; d < 3; ++d) p.X[d][l] = r.X[d];
  p.volume[l] = r.volume;
  for (int i = 0; i < 9; ++i) p.F.a[i / 3][i % 3][l] = r.F[i];
  p.q.w[l] = r.q[0];
  p.q.x[l] = r.q[1];
  p.q.y[l] = r.q[2];
  p.q.z[l] = r.q[3];
  set_lane(p.strain, l, r.strain);
  set_state(slot, r.damage);
  if (r.moving) let_move();
  if (!motion.empty()) {
    PointMotion& u = motion[b];
    for (int d = 0; d < 3; ++d) {
      u.X0[d][l] = r.moving ? r.X0[d] : r.X[d];
      u.v[d][l] = r.v[d];
    }
    for (int i = 0; i < 9; ++i) u.C.a[i / 3][i % 3][l] = r.C[i];
  }
  BlockMeta& m = meta[b];
  const std::uint8_t bit = static_cast<std::uint8_t>(1u << l);
  m.occupied |= bit;
  if (r.failed) m.failed |= bit;
  if (r.has_frame) m.framed |= bit;
  if (r.links > 0) m.linked |= bit;
  for (double v : r.damage) m.damaged |= v != 0.0;
  m.damaged |= r.failed;  // such points may come from a file without damage
  tags[b][l] = tag;
}

vd* PointStore::change_state(int b) {
  if (state_.empty()) state_.resize(blocks.size() * state_fields_);
  return &state_[state_fields_ * static_cast<std::size_t>(b)];
}

void PointStore::set_law(const std::shared_ptr<const Law>& law) {
  set_state_fields(law->fields());
  law_ = law;
}

void PointStore::set_state_fields(int fields) {
  if (!state_.empty() && fields != state_fields_) {
    std::vector<vd> next(fields * blocks.size());
    for (std::size_t b = 0; b < blocks.size(); ++b)
      std::copy_n(&state_[state_fields_ * b], std::min(fields, state_fields_), &next[fields * b]);
    state_.swap(next);
  }
  state_fields_ = fields;
}

void PointStore::set_state(int slot, const double* numbers) {
  int used = kMostStateFields;
  while (used > 0 && numbers[used - 1] == 0.0) --used;
  if (used == 0 && state_.empty()) return;
  if (used > state_fields_) set_state_fields(kMostStateFields);
  vd* s = change_state(slot / kLanes);
  for (int i = 0; i < state_fields_; ++i) s[i][slot % kLanes] = numbers[i];
}

int PointStore::add(const PointRecord& r, int tag) {
  // The tail keeps one body a block, as everywhere.
  const bool fresh = blocks.size() == settled_ || meta.back().occupied == 0xff || meta.back().body != r.body ||
                     meta.back().part != r.part;
  if (fresh) {
    blocks.push_back(empty_block());
    if (!state_.empty()) state_.resize(blocks.size() * state_fields_);
    if (!motion.empty()) motion.emplace_back(PointMotion{});
    meta.emplace_back();
    meta.back().body = r.body;
    meta.back().part = r.part;
    tags.emplace_back();
    tags.back().fill(0);
  }
  int l = 0;
  while (meta.back().occupied >> l & 1) ++l;
  const int slot = kLanes * (static_cast<int>(blocks.size()) - 1) + l;
  set(slot, r, tag);
  for (int i = 0; i < r.links; ++i) {
    links.push_back(r.link[i]);
    links.back().slot = slot;
  }
  return slot;
}

PointRecord PointStore::record(int slot) const {
  const int b = slot / kLanes, l = slot % kLanes;
  const PointBlock& p = blocks[b];
  PointRecord r;
  r.body = meta[b].body;
  r.part = meta[b].part;
  r.failed = meta[b].failed >> l & 1;
  r.has_frame = meta[b].framed >> l & 1;
  for (int d = 0; d < 3; ++d) r.X[d] = p.X[d][l];
  r.volume = p.volume[l];
  for (int i = 0; i < 9; ++i) r.F[i] = p.F.a[i / 3][i % 3][l];
  r.q[0] = p.q.w[l];
  r.q[1] = p.q.x[l];
  r.q[2] = p.q.y[l];
  r.q[3] = p.q.z[l];
  get_lane(p.strain, l, r.strain);
  for (int i = 0; i < state_fields_; ++i) r.damage[i] = state(b)[i][l];
  if (!motion.empty()) {
    const PointMotion& u = motion[b];
    r.moving = true;
    for (int d = 0; d < 3; ++d) {
      r.X0[d] = u.X0[d][l];
      r.v[d] = u.v[d][l];
    }
    for (int i = 0; i < 9; ++i) r.C[i] = u.C.a[i / 3][i % 3][l];
  }
  const auto range = std::equal_range(links.begin(), links.end(), Link{slot, 0, {0, 0, 0}, 0, 0, {0, 0, 0}},
                                      [](const Link& a, const Link& c) { return a.slot < c.slot; });
  for (auto it = range.first; it != range.second; ++it) r.link[r.links++] = *it;
  return r;
}

void PointStore::arrange(const std::vector<int>& live, const std::vector<int>& live_tags, double cell,
                         std::vector<int>& new_slot, const std::vector<int>& new_part, Basis basis) {
  struct Item {
    int body, part, base[3], tag, index;
  };
  const double inverse_h = 1.0 / cell, shift = cell_shift(basis);
  std::vector<Item> items(live.size());
  for (std::size_t i = 0; i < live.size(); ++i) {
    const int b = live[i] / kLanes, l = live[i] % kLanes;
    Item& it = items[i];
    it.body = meta[b].body;
    it.part = new_part.empty() ? meta[b].part : new_part[i];
    for (int d = 0; d < 3; ++d) it.base[d] = support_base(blocks[b].X[d][l], inverse_h, shift);
    it.tag = live_tags[i];
    it.index = static_cast<int>(i);
  }
  const auto same_cell = [](const Item& a, const Item& b) {
    return a.body == b.body && a.part == b.part && a.base[0] == b.base[0] && a.base[1] == b.base[1] && a.base[2] == b.base[2];
  };
  std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
    if (a.body != b.body) return a.body < b.body;
    if (a.part != b.part) return a.part < b.part;
    for (int d = 0; d < 3; ++d)
      if (a.base[d] != b.base[d]) return a.base[d] < b.base[d];
    return a.tag < b.tag;
  });

  std::size_t count = 0;
  for (std::size_t i = 0; i < items.size(); ++count) {
    const std::size_t first = i;
    for (int l = 0; l < kLanes && i < items.size() && same_cell(items[first], items[i]); ++l) ++i;
  }
  PointStore next;
  next.links.reserve(links.size());
  next.blocks.reserve(count);
  next.state_fields_ = state_fields_;
  next.law_ = law_;
  if (!state_.empty()) next.state_.reserve(count * state_fields_);
  next.meta.reserve(count);
  next.tags.reserve(count);
  if (!motion.empty()) next.motion.reserve(count);
  new_slot.assign(live.size(), -1);
  for (std::size_t i = 0; i < items.size();) {
    next.add_block(items[i].body, items[i].part, items[i].base, cell, basis);
    if (!motion.empty()) next.let_move();
    const std::size_t first = i;
    for (int l = 0; l < kLanes && i < items.size() && same_cell(items[first], items[i]); ++l, ++i) {
      const int slot = kLanes * (static_cast<int>(next.blocks.size()) - 1) + l;
      const PointRecord r = record(live[items[i].index]);
      next.set(slot, r, items[i].tag);
      for (int k = 0; k < r.links; ++k) {
        next.links.push_back(r.link[k]);
        next.links.back().slot = slot;
      }
      new_slot[items[i].index] = slot;
    }
  }
  *this = std::move(next);
}

void PointStore::let_move() {
  if (!motion.empty() || blocks.empty()) return;
  motion.assign(blocks.size(), PointMotion{});
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (int d = 0; d < 3; ++d) motion[b].X0[d] = blocks[b].X[d];
}

int PointStore::add_block(int body, int part, const int* base, double cell, Basis basis) {
  blocks.push_back(empty_block());
  if (!state_.empty()) state_.resize(blocks.size() * state_fields_);
  if (!motion.empty()) motion.emplace_back(PointMotion{});
  meta.emplace_back();
  tags.emplace_back();
  tags.back().fill(0);
  BlockMeta& m = meta.back();
  m.body = body;
  m.part = part;
  const double middle = cell_middle(basis);
  for (int d = 0; d < 3; ++d) {
    m.base[d] = base[d];
    // Empty lanes sit at the middle of the cell, where every weight is finite.
    blocks.back().X[d] = splat((base[d] + middle) * cell);
  }
  settled_ = blocks.size();
  return static_cast<int>(blocks.size()) - 1;
}

void PointStore::take(const PointStore& from, int slot, int new_slot) {
  const int b = slot / kLanes, l = slot % kLanes, to = new_slot / kLanes, lane = new_slot % kLanes;
  // Blocks are arrays of vectors, so a lane is every eighth number of them.
  const auto copy = [l, lane](auto& target, const auto& source) {
    double* t = reinterpret_cast<double*>(&target);
    const double* s = reinterpret_cast<const double*>(&source);
    for (std::size_t i = 0; i < sizeof source / sizeof(double); i += kLanes) t[i + lane] = s[i + l];
  };
  copy(blocks[to], from.blocks[b]);
  double numbers[kMostStateFields] = {};
  bool damaged = false;
  for (int i = 0; i < from.state_fields_; ++i) {
    numbers[i] = from.state(b)[i][l];
    damaged |= numbers[i] != 0.0;
  }
  set_state(new_slot, numbers);
  if (!motion.empty()) copy(motion[to], from.motion[b]);
  tags[to][lane] = from.tags[b][l];
  const BlockMeta& m = from.meta[b];
  BlockMeta& n = meta[to];
  const auto hand_over = [l, lane](std::uint8_t& target, std::uint8_t source) {
    target = static_cast<std::uint8_t>((target & ~(1u << lane)) | (source >> l & 1u) << lane);
  };
  hand_over(n.occupied, m.occupied);
  hand_over(n.failed, m.failed);
  hand_over(n.framed, m.framed);
  hand_over(n.linked, m.linked);
  n.damaged = n.damaged || (n.failed >> lane & 1) || damaged;
}

void PointStore::empty_lane(int slot, double cell, Basis basis) {
  const int b = slot / kLanes, l = slot % kLanes;
  const double middle = cell_middle(basis);
  PointRecord nothing;
  for (int d = 0; d < 3; ++d) nothing.X[d] = (meta[b].base[d] + middle) * cell;
  set(slot, nothing, 0);
  const std::uint8_t others = static_cast<std::uint8_t>(~(1u << l));
  meta[b].occupied &= others;
  meta[b].failed &= others;
  meta[b].framed &= others;
  meta[b].linked &= others;
}

std::vector<int> PointStore::sort_links() {
  std::vector<int> order(links.size()), new_place(links.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return links[a].slot < links[b].slot; });
  std::vector<Link> sorted(links.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    sorted[i] = links[order[i]];
    new_place[order[i]] = static_cast<int>(i);
  }
  links.swap(sorted);
  return new_place;
}

std::size_t PointStore::memory_usage() const {
  return motion.capacity() * sizeof(PointMotion) + blocks.capacity() * sizeof(PointBlock) + state_.capacity() * sizeof(vd) +
         meta.capacity() * sizeof(BlockMeta) + tags.capacity() * sizeof(tags[0]) +
         links.capacity() * sizeof(Link);
}

}  // namespace mpdem
