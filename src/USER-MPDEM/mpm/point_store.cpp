// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_store.h"

#include <algorithm>
#include <numeric>

#include "../material/laws.h"

namespace mpdem {

namespace {

// Lane l of a field of a block. Its components are kLanes doubles apart.
template <class Field>
double* lane(Field& field, int l) {
  return reinterpret_cast<double*>(&field) + l;
}
template <class Field>
const double* lane(const Field& field, int l) {
  return reinterpret_cast<const double*>(&field) + l;
}

// Calls f(field of the block, field of the record) for each field that both have.
template <class Store, class Record, class F>
void each_field(Store& s, int b, Record& r, F f) {
  f(s.blocks[b].X, r.X);
  f(s.blocks[b].volume, r.volume);
  f(s.blocks[b].F, r.F);
  f(s.blocks[b].q, r.q);
  f(s.blocks[b].strain, r.strain);
  if (!s.slip.empty()) f(s.slip[b].at, r.slip);
  if (s.motion.empty()) return;
  f(s.motion[b].X0, r.X0);
  f(s.motion[b].v, r.v);
  f(s.motion[b].C, r.C);
}

// Number of components of a field that a block and a record have.
template <class InBlock, class InRecord>
constexpr std::size_t components(const InBlock&, const InRecord&) {
  static_assert(sizeof(InBlock) == kLanes * sizeof(InRecord), "a lane of the block is the field of the record");
  return sizeof(InRecord) / sizeof(double);  // NOLINT(bugprone-sizeof-expression): a field is a number or an array of numbers
}

PointBlock empty_block() {
  PointBlock b{};
  for (int i = 0; i < 3; ++i) b.F.a[i][i] = splat(1.0);
  b.q.w = splat(1.0);
  return b;
}

}  // namespace

const vd PointStore::kNoState[kMostStateFields] = {};

void PointStore::clear() {
  each_array(*this, [](auto& array) { array.clear(); });
  state_fields_ = kMostStateFields;
  law_number_ = 0;
  law_.reset();
  arranged_blocks_ = 0;
  changed_ = false;
  homes_ = 0;
  copies_.clear();
}

void PointStore::set(int slot, const PointRecord& r, int tag) {
  const int b = slot / kLanes, l = slot % kLanes;
  if (r.moving) start_motion();
  if (r.has_slip) start_slip();
  forget_root_of_norm(b);
  each_field(*this, b, r, [l](auto& in_block, const auto& in_record) {
    double* to = lane(in_block, l);
    const double* from = reinterpret_cast<const double*>(&in_record);
    for (std::size_t i = 0; i < components(in_block, in_record); ++i) to[kLanes * i] = from[i];
  });
  set_state(slot, r.damage);
  if (!motion.empty() && !r.moving)
    for (int d = 0; d < 3; ++d) motion[b].X0[d][l] = r.X[d];
  BlockMeta& m = meta[b];
  const std::uint8_t bit = static_cast<std::uint8_t>(1u << l);
  m.occupied |= bit;
  m.material = static_cast<std::uint8_t>(r.material);
  if (r.failed) m.failed |= bit;
  if (r.split_checked) m.split_checked |= bit;
  if (r.distorted) m.distorted |= bit;
  set_connected(slot, r.connected);
  if (r.has_frame) m.framed |= bit;
  if (r.links > 0) m.linked |= bit;
  for (double v : r.damage) m.damaged |= v != 0.0;
  m.damaged |= r.failed;  // a file may give failed points without damage
  tags[b][l] = tag;
}

vd* PointStore::change_state(int b) {
  if (state_.empty()) state_.resize(blocks.size() * state_fields_);
  return &state_[state_fields_ * static_cast<std::size_t>(b)];
}

void PointStore::set_law(const std::shared_ptr<const Law>& law) {
  set_state_fields(law->fields());
  law_ = law;
  law_number_ = mpdem::law_number(*law);
}

void PointStore::set_state_fields(int fields) {
  if (!state_.empty() && fields != state_fields_) {
    std::vector<vd> next(fields * blocks.size());
    for (std::size_t b = 0; b < blocks.size(); ++b)
      std::copy_n(state_.data() + state_fields_ * b, std::min(fields, state_fields_), next.data() + fields * b);
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
  // A block of the tail has points of one bond, layer and material, as all blocks do.
  const bool fresh = blocks.size() == arranged_blocks_ || tail_lanes_ == kLanes || meta.back().row != r.row ||
                     meta.back().layer != r.layer || meta.back().material != r.material;
  if (fresh) {
    if (blocks.empty()) law_number_ = r.law;
    append_block();
    meta.back().row = r.row;
    meta.back().layer = r.layer;
    tail_lanes_ = 0;
  }
  const int l = tail_lanes_++;  // never the lane of a point that left, whose links are still there
  const int slot = kLanes * (static_cast<int>(blocks.size()) - 1) + l;
  set(slot, r, tag);
  for (int i = 0; i < r.links; ++i) {
    links.push_back(r.link[i]);
    links.back().slot = slot;
  }
  for (int i = 0; i < r.contacts; ++i) {
    contacts.push_back(r.contact[i]);
    contacts.back().slot = slot;
  }
  changed_ = true;
  return slot;
}

PointRecord PointStore::record(int slot) const {
  const int b = slot / kLanes, l = slot % kLanes;
  PointRecord r;
  r.row = meta[b].row;
  r.layer = meta[b].layer;
  r.material = meta[b].material;
  r.failed = meta[b].failed >> l & 1;
  r.split_checked = meta[b].split_checked >> l & 1;
  r.distorted = meta[b].distorted >> l & 1;
  r.connected = connected(slot);
  r.has_frame = meta[b].framed >> l & 1;
  r.moving = !motion.empty();
  each_field(*this, b, r, [l](const auto& in_block, auto& in_record) {
    const double* from = lane(in_block, l);
    double* to = reinterpret_cast<double*>(&in_record);
    for (std::size_t i = 0; i < components(in_block, in_record); ++i) to[i] = from[kLanes * i];
  });
  r.has_slip = std::any_of(r.slip, r.slip + 3, [](double s) { return s != 0.0; });
  r.law = law_number_;
  for (int i = 0; i < state_fields_; ++i) r.damage[i] = state(b)[i][l];
  const auto [links_of, links_end] = of_slot(links, slot);
  for (auto it = links_of; it != links_end; ++it) r.link[r.links++] = *it;
  const auto [places_of, places_end] = of_slot(contacts, slot);
  for (auto it = places_of; it != places_end; ++it) r.contact[r.contacts++] = *it;
  return r;
}

void PointStore::release(int slot) {
  const std::uint8_t others = static_cast<std::uint8_t>(~(1u << slot % kLanes));
  BlockMeta& m = meta[slot / kLanes];
  for (std::uint8_t* bits : {&m.occupied, &m.failed, &m.split_checked, &m.framed, &m.linked, &m.distorted}) *bits &= others;
  set_connected(slot, 0);
  blocks[slot / kLanes].volume[slot % kLanes] = 0.0;
  changed_ = true;
}

int PointStore::size() const {
  int n = 0;
  for (const BlockMeta& m : meta) n += __builtin_popcount(m.occupied);
  return n;
}

bool PointStore::unstrained() const {
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const Sym3<vd>& e = blocks[b].strain;
    vmask strained = (e.xx != 0.0) | (e.yy != 0.0) | (e.zz != 0.0) | (e.yz != 0.0) | (e.xz != 0.0) | (e.xy != 0.0);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) strained |= blocks[b].F.a[i][j] != (i == j ? 1.0 : 0.0);
    if (any(strained & lanes(meta[b].occupied))) return false;
  }
  return true;
}

bool PointStore::any_failed() const {
  return std::any_of(meta.begin(), meta.end(), [](const BlockMeta& m) { return m.failed != 0; });
}

void PointStore::reserve_like(const PointStore& other, std::size_t n) {
  links.reserve(other.links.size());
  blocks.reserve(n);
  state_fields_ = other.state_fields_;
  law_ = other.law_;
  law_number_ = other.law_number_;
  if (!other.state_.empty()) state_.reserve(n * state_fields_);
  meta.reserve(n);
  tags.reserve(n);
  if (!other.motion.empty()) motion.reserve(n);
  if (!other.slip.empty()) slip.reserve(n);
  if (!other.root_of_norm.empty()) root_of_norm.reserve(n);
  if (!other.softening.empty()) softening.reserve(n);
  if (!other.scatter.empty()) scatter.reserve(n);
}

// Adds a record with its links and contact points. Slots must ascend from call to call.
void PointStore::add_record(int slot, const PointRecord& r, int tag) {
  set(slot, r, tag);
  for (int k = 0; k < r.links; ++k) {
    links.push_back(r.link[k]);
    links.back().slot = slot;
  }
  for (int k = 0; k < r.contacts; ++k) {
    contacts.push_back(r.contact[k]);
    contacts.back().slot = slot;
  }
}

void PointStore::start_motion() {
  if (!motion.empty() || blocks.empty()) return;
  motion.assign(blocks.size(), PointMotion{});
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (int d = 0; d < 3; ++d) motion[b].X0[d] = blocks[b].X[d];
}

void PointStore::start_slip() {
  if (slip.empty()) slip.assign(blocks.size(), PointSlip{});
}

void PointStore::append_block() {
  blocks.push_back(empty_block());
  if (!state_.empty()) state_.resize(blocks.size() * state_fields_);
  if (!motion.empty()) motion.emplace_back(PointMotion{});
  if (!slip.empty()) slip.emplace_back(PointSlip{});
  if (!root_of_norm.empty()) root_of_norm.push_back(splat(kUnknown));
  if (!softening.empty()) softening.emplace_back(vd{});
  if (!scatter.empty()) scatter.emplace_back();
  meta.emplace_back();
  tags.emplace_back();
  tags.back().fill(0);
}

int PointStore::add_block(int row, int layer, const int* base, double cell, Basis basis) {
  append_block();
  BlockMeta& m = meta.back();
  m.row = row;
  m.layer = layer;
  const double middle = cell_middle(basis);
  for (int d = 0; d < 3; ++d) {
    m.base[d] = base[d];
    // Empty lanes lie at the middle of the cell, where every weight is finite.
    blocks.back().X[d] = splat((base[d] + middle) * cell);
    if (!motion.empty()) motion.back().X0[d] = blocks.back().X[d];
  }
  arranged_blocks_ = blocks.size();
  return static_cast<int>(blocks.size()) - 1;
}

void PointStore::take(const PointStore& from, int slot, int new_slot) {
  const int b = slot / kLanes, l = slot % kLanes, to = new_slot / kLanes, new_lane = new_slot % kLanes;
  const auto copy = [l, new_lane](auto& target, const auto& source) {
    double* t = lane(target, new_lane);
    const double* s = lane(source, l);
    for (std::size_t i = 0; i < sizeof source / sizeof(double); i += kLanes) t[i] = s[i];
  };
  copy(blocks[to], from.blocks[b]);
  forget_root_of_norm(to);
  if (!from.softening.empty()) {
    if (softening.empty()) softening.resize(blocks.size());
    softening[to][new_lane] = from.softening[b][l];
  }
  if (!from.scatter.empty()) {
    if (scatter.empty()) scatter.resize(blocks.size());
    copy(scatter[to], from.scatter[b]);
  }
  meta[to].material = from.meta[b].material;
  double numbers[kMostStateFields] = {};
  for (int i = 0; i < from.state_fields_; ++i) numbers[i] = from.state(b)[i][l];
  set_state(new_slot, numbers);
  if (!motion.empty()) copy(motion[to], from.motion[b]);
  if (!from.slip.empty()) start_slip();
  if (!slip.empty()) copy(slip[to], from.slip.empty() ? PointSlip{} : from.slip[b]);
  tags[to][new_lane] = from.tags[b][l];
  const BlockMeta& m = from.meta[b];
  BlockMeta& n = meta[to];
  const auto hand_over = [l, new_lane](std::uint8_t& target, std::uint8_t source) {
    target = static_cast<std::uint8_t>((target & ~(1u << new_lane)) | (source >> l & 1u) << new_lane);
  };
  hand_over(n.occupied, m.occupied);
  hand_over(n.failed, m.failed);
  hand_over(n.split_checked, m.split_checked);
  hand_over(n.distorted, m.distorted);
  set_connected(new_slot, from.connected(slot));
  hand_over(n.framed, m.framed);
  hand_over(n.linked, m.linked);
  n.damaged =
      n.damaged || (n.failed >> new_lane & 1) || std::any_of(numbers, numbers + kMostStateFields, [](double v) { return v != 0.0; });
}

void PointStore::empty_lane(int slot, double cell, Basis basis) {
  const int b = slot / kLanes, l = slot % kLanes;
  const double middle = cell_middle(basis);
  PointRecord nothing;
  nothing.material = meta[b].material;
  for (int d = 0; d < 3; ++d) nothing.X[d] = (meta[b].base[d] + middle) * cell;
  set(slot, nothing, 0);
  const std::uint8_t others = static_cast<std::uint8_t>(~(1u << l));
  meta[b].occupied &= others;
  meta[b].failed &= others;
  meta[b].split_checked &= others;
  meta[b].distorted &= others;
  meta[b].framed &= others;
  meta[b].linked &= others;
  set_connected(slot, 0);
}

std::vector<int> PointStore::sort_links() {
  std::vector<int> order(links.size()), new_index(links.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return links[a].slot < links[b].slot; });
  std::vector<Link> sorted(links.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    sorted[i] = links[order[i]];
    new_index[order[i]] = static_cast<int>(i);
  }
  links.swap(sorted);
  return new_index;
}

std::size_t PointStore::memory_usage() const {
  std::size_t bytes = 0;
  each_array(*this, [&bytes](const auto& array) { bytes += array.capacity() * sizeof array[0]; });
  return bytes;
}

}  // namespace mpdem
