// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Moves points of a store to other layers without a new arrangement, see PointStore::arrange(), where families are explained. Homes stay
// where they are. All copies are appended anew: those of families that change are filled, others are copied.
#include <algorithm>
#include <numeric>

#include "../numerics/sort_unique.h"

#include "point_store.h"

namespace mpdem {

int PointStore::Family::first() const {
  int least = -1;
  for (int p : layer)
    if (p >= 0 && (least < 0 || p < least)) least = p;
  return least;
}

std::vector<int> PointStore::Family::others() const {
  std::vector<int> layers;
  const int home = first();
  for (int p : layer)
    if (p >= 0 && p != home) layers.push_back(p);
  sort_unique(layers);
  return layers;
}

void PointStore::Family::shape(int of, BlockMeta& m) const {
  const std::array<int, 3>*least = nullptr, *most = nullptr;
  for (int l = 0; l < kLanes; ++l) {
    if (layer[l] != of) continue;
    if (!least || cell[l] < *least) least = &cell[l];
    if (!most || *most < cell[l]) most = &cell[l];
  }
  std::copy(least->begin(), least->end(), m.base);
  m.joined = kOneCell;
  int along = 0;
  for (int d = 0; d < 3; ++d)
    if ((*most)[d] != (*least)[d]) along = d;
  m.joined = cells_in_a_row(along, (*most)[along] - (*least)[along]);
  m.second = m.third = 0;
  for (int l = 0; l < kLanes; ++l) {
    if (layer[l] != of) continue;
    const int ahead = cell[l][along] - (*least)[along];
    if (ahead > 0) (ahead == 1 ? m.second : m.third) |= static_cast<std::uint8_t>(1u << l);
  }
}

int PointStore::add_block(int row, int layer, const Family& family, double cell, Basis basis) {
  BlockMeta m;
  family.shape(layer, m);
  const int b = add_block(row, layer, m.base, cell, basis);
  meta[b].joined = m.joined;
  meta[b].second = m.second;
  meta[b].third = m.third;
  return b;
}

// Returns the blocks of a family: the home, then its copies.
std::vector<int> PointStore::blocks_of_family(int home) const {
  std::vector<int> of{home};
  const auto before = [](const Copy& c, int h) { return c.home < h; };
  for (auto c = std::lower_bound(copies_.begin(), copies_.end(), home, before); c != copies_.end() && c->home == home; ++c)
    of.push_back(homes_ + static_cast<int>(c - copies_.begin()));
  return of;
}

std::map<int, PointStore::Family> PointStore::families_that_divide(const std::map<int, int>& layer_of_slot) const {
  std::map<int, Family> families;
  for (const auto& s : layer_of_slot) {
    const int b = s.first / kLanes, home = b < homes_ ? b : copies_[b - homes_].home;
    const auto f = families.emplace(home, Family()).first;
    for (int of : f->second.layer[s.first % kLanes] < 0 ? blocks_of_family(home) : std::vector<int>())
      for (int l = 0; l < kLanes; ++l)
        if (meta[of].occupied >> l & 1) {
          f->second.layer[l] = meta[of].layer;
          f->second.from[l] = of;
          for (int d = 0; d < 3; ++d) f->second.cell[l][d] = cell_of(meta[of], l, d);
        }
  }
  for (const auto& s : layer_of_slot) {
    const int b = s.first / kLanes;
    families[b < homes_ ? b : copies_[b - homes_].home].layer[s.first % kLanes] = s.second;
  }
  return families;
}

// Copies these blocks, without links and contact points.
PointStore PointStore::copy_of_blocks(const std::vector<int>& which) const {
  PointStore s;
  s.reserve_like(*this, which.size());
  for (int b : which) s.append_copy(*this, b);
  return s;
}

void PointStore::append_copy(const PointStore& from, int b) {
  blocks.push_back(from.blocks[b]);
  meta.push_back(from.meta[b]);
  tags.push_back(from.tags[b]);
  if (!from.motion.empty()) motion.push_back(from.motion[b]);
  if (!from.slip.empty()) slip.push_back(from.slip[b]);
  if (!from.root_of_norm.empty()) root_of_norm.push_back(from.root_of_norm[b]);
  if (!from.softening.empty()) softening.push_back(from.softening[b]);
  if (!from.scatter.empty()) scatter.push_back(from.scatter[b]);
  if (!from.state_.empty()) state_.insert(state_.end(), from.state(b), from.state(b) + state_fields_);
}

// Fills block b with the points of its layer and empties its other lanes. b is a home that still has its old points, or a new copy.
// `from` has copies of the old blocks: old block n is its block new_index[n].
void PointStore::fill_lanes(int b, const Family& family, const PointStore& from, const std::map<int, int>& new_index,
                            std::vector<int>& new_slot, double cell, Basis basis) {
  for (int l = 0; l < kLanes; ++l) {
    if (family.layer[l] != meta[b].layer) {
      empty_lane(kLanes * b + l, cell, basis);
      continue;
    }
    if (b >= homes_ || family.from[l] != b) take(from, kLanes * new_index.at(family.from[l]) + l, kLanes * b + l);
    new_slot[kLanes * family.from[l] + l] = kLanes * b + l;
  }
  find_damaged(b);
  find_lattice(b);
}

void PointStore::find_damaged(int b) {
  BlockMeta& m = meta[b];
  m.damaged = m.failed != 0;
  const double* numbers = reinterpret_cast<const double*>(state(b));
  for (int i = 0; i < kLanes * state_fields_; ++i) m.damaged = m.damaged || numbers[i] != 0.0;
}

PointStore::LayerMove PointStore::move_to_layers(const std::map<int, int>& layer_of_slot, double cell, Basis basis) {
  LayerMove done;
  const std::map<int, Family> families = families_that_divide(layer_of_slot);
  // Blocks from which points are taken.
  std::vector<int> sources;
  for (const auto& f : families) sources.push_back(f.first);
  for (int b = homes_; b < static_cast<int>(blocks.size()); ++b) sources.push_back(b);
  const PointStore before = copy_of_blocks(sources);
  std::map<int, int> new_index;
  for (std::size_t n = 0; n < sources.size(); ++n) new_index[sources[n]] = static_cast<int>(n);

  std::vector<int> new_slot(kLanes * blocks.size());
  std::iota(new_slot.begin(), new_slot.end(), 0);
  each_array_of_blocks(*this, [&](auto& array, std::size_t width) { array.resize(width * homes_); });
  for (const auto& f : families) {
    meta[f.first].layer = f.second.first();
    f.second.shape(meta[f.first].layer, meta[f.first]);
    done.blocks.push_back(f.first);
    fill_lanes(f.first, f.second, before, new_index, new_slot, cell, basis);
  }
  const std::vector<Copy> copies_before = std::move(copies_);
  copies_.clear();
  auto f = families.begin();
  const auto add_copies_until = [&](int home) {
    for (; f != families.end() && f->first < home; ++f)
      for (int layer : f->second.others()) {
        const int b = add_block(meta[f->first].row, layer, f->second, cell, basis);
        meta[b].material = meta[f->first].material;
        copies_.push_back({f->first, layer});
        fill_lanes(b, f->second, before, new_index, new_slot, cell, basis);
        done.blocks.push_back(b);
      }
  };
  for (std::size_t n = 0; n < copies_before.size(); ++n) {
    const Copy& c = copies_before[n];
    add_copies_until(c.home);
    if (families.count(c.home)) continue;
    const int was = homes_ + static_cast<int>(n), b = static_cast<int>(blocks.size());
    append_copy(before, new_index.at(was));
    copies_.push_back(c);
    for (int l = 0; l < kLanes; ++l) new_slot[kLanes * was + l] = kLanes * b + l;
  }
  add_copies_until(homes_);
  arranged_blocks_ = blocks.size();
  for (Link& k : links) k.slot = new_slot[k.slot];
  for (ContactPoint& p : contacts) p.slot = new_slot[p.slot];
  done.new_link_index = sort_links();
  std::stable_sort(contacts.begin(), contacts.end(), [](const ContactPoint& a, const ContactPoint& b) { return a.slot < b.slot; });
  return done;
}

}  // namespace mpdem
