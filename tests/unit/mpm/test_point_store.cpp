// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mpm/point_store.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include "lanes.h"

namespace mpdem {
namespace {

constexpr double kCell = 0.2;

PointRecord random_record(test::Random& random) {
  PointRecord r;
  r.row = random.index(3);
  r.layer = random.index(2);
  r.failed = random.index(5) == 0;
  r.has_frame = random.index(2);
  r.connected = random.index(4);
  for (double& v : r.X) v = random.uniform(-0.5, 0.5);
  r.volume = random.uniform(0.1, 1);
  for (double& v : r.F) v += random.uniform(-0.1, 0.1);
  const Eigen::Quaterniond q(random.frame());
  r.q[0] = q.w();
  r.q[1] = q.x();
  r.q[2] = q.y();
  r.q[3] = q.z();
  for (double& v : r.strain) v = random.uniform(-0.01, 0.01);
  if (random.index(2))
    for (double& v : r.damage) v = random.uniform(-0.1, 0.1);
  r.links = random.index(3);
  for (int i = 0; i < r.links; ++i) {
    Link& k = r.link[i];
    k.slot = -1;
    k.grain = 1 + random.index(1000);
    for (double& v : k.foot) v = random.uniform(-1, 1);
    k.area = random.uniform(0, 1);
    k.attached = random.index(2);
  }
  r.contacts = random.index(3);
  for (int i = 0; i < r.contacts; ++i) r.contact[i].grain = 1 + i;
  return r;
}

std::vector<double> packed(const PointRecord& r) {
  std::vector<double> buf(numbers_of(r), -1.0);
  pack(r, buf.data());
  return buf;
}

// Everything a store says about its points and links, to compare two of them.
std::vector<double> content(const PointStore& s) {
  std::vector<double> all;
  for (std::size_t b = 0; b < s.blocks.size(); ++b) {
    const BlockMeta& m = s.meta[b];
    for (int d = 0; d < 3; ++d) all.push_back(m.base[d]);
    for (int v : {m.row, m.layer, int(m.occupied), int(m.failed), int(m.framed), int(m.linked), int(m.damaged), int(m.second), int(m.third),
                  m.joined})
      all.push_back(v);
    for (int l = 0; l < kLanes; ++l) {
      all.push_back(s.tags[b][l]);
      const std::vector<double> p = packed(s.record(static_cast<int>(kLanes * b) + l));
      all.insert(all.end(), p.begin(), p.end());
    }
  }
  for (const Link& k : s.links) all.insert(all.end(), {double(k.slot), double(k.grain), k.foot[0], k.area});
  for (const ContactPoint& p : s.contacts) all.insert(all.end(), {double(p.slot), double(p.grain)});
  return all;
}

struct Filled {
  PointStore store;
  std::vector<PointRecord> records;
  std::vector<int> slots, tags;

  Filled(std::uint64_t seed, int n) {
    test::Random random(seed);
    for (int i = 0; i < n; ++i) {
      EXPECT_EQ(store.size(), i);
      records.push_back(random_record(random));
      tags.push_back(1000 + 7 * i);
      slots.push_back(store.add(records.back(), tags.back()));
      EXPECT_TRUE(store.changed());
    }
  }
  // Answers the slots, of the points in the order they were given.
  const std::vector<int>& arrange(const std::map<int, int>& new_layer = {}) {
    const std::vector<int> place = store.arrange(kCell, Basis::quadratic, new_layer);
    for (int& slot : slots) slot = place[slot];
    return slots;
  }
};

TEST(PointStore, AddAndRecordRoundTrip) {
  const Filled f(82, 300);
  std::set<int> different(f.slots.begin(), f.slots.end());
  EXPECT_EQ(different.size(), f.slots.size());
  for (std::size_t i = 0; i < f.records.size(); ++i) {
    const int b = f.slots[i] / kLanes, l = f.slots[i] % kLanes;
    EXPECT_EQ(packed(f.store.record(f.slots[i])), packed(f.records[i]));
    EXPECT_EQ(f.store.tags[b][l], f.tags[i]);
    EXPECT_EQ(f.store.meta[b].row, f.records[i].row);
    EXPECT_EQ(f.store.meta[b].layer, f.records[i].layer);
    EXPECT_TRUE(f.store.meta[b].occupied >> l & 1);
    EXPECT_EQ(f.store.meta[b].linked >> l & 1, f.records[i].links > 0);
    for (int k = 0; k < f.store.record(f.slots[i]).links; ++k) EXPECT_EQ(f.store.record(f.slots[i]).link[k].slot, f.slots[i]);
  }
  EXPECT_GT(f.store.memory_usage(), 300u * sizeof(double) * 30);
}

// Checks what `arrange` promises, given what the store held before.
void expect_arranged(const PointStore& s, const std::vector<PointRecord>& records, const std::vector<int>& tags,
                     const std::vector<int>& new_slot) {
  ASSERT_EQ(new_slot.size(), records.size());
  std::size_t occupied = 0;
  for (const BlockMeta& m : s.meta) occupied += __builtin_popcount(m.occupied);
  EXPECT_EQ(occupied, records.size());
  ASSERT_EQ(s.states().size(), 6 * s.blocks.size());
  ASSERT_EQ(s.meta.size(), s.blocks.size());
  ASSERT_EQ(s.tags.size(), s.blocks.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const PointRecord& r = records[i];
    const int b = new_slot[i] / kLanes, l = new_slot[i] % kLanes;
    EXPECT_EQ(packed(s.record(new_slot[i])), packed(r));
    EXPECT_EQ(s.tags[b][l], tags[i]);
    EXPECT_EQ(s.meta[b].row, r.row);
    EXPECT_EQ(s.meta[b].layer, r.layer);
    EXPECT_EQ(s.meta[b].linked >> l & 1, r.links > 0);
    for (int d = 0; d < 3; ++d) EXPECT_EQ(s.meta[b].base[d], support_base(r.X[d], 1.0 / kCell, 0.5));
  }
  std::vector<std::array<int, 6>> order;  // bond, layer, cell, tag
  for (std::size_t b = 0; b < s.blocks.size(); ++b) {
    const BlockMeta& m = s.meta[b];
    bool damaged = false;
    for (int l = 0; l < kLanes; ++l) {
      if (m.occupied >> l & 1) {
        order.push_back({m.row, m.layer, m.base[0], m.base[1], m.base[2], s.tags[b][l]});
        for (double v : s.record(static_cast<int>(kLanes * b) + l).damage) damaged |= v != 0.0;
        continue;
      }
      // empty lanes: nothing of their own, finite weights, at the end of the block
      EXPECT_EQ(m.occupied >> l, 0);
      EXPECT_EQ(double(s.blocks[b].volume[l]), 0.0);
      EXPECT_FALSE((m.failed | m.framed | m.linked) >> l & 1);
      for (int d = 0; d < 3; ++d) EXPECT_EQ(support_base(s.blocks[b].X[d][l], 1.0 / kCell, 0.5), m.base[d]);
      EXPECT_EQ(test::matrix(s.blocks[b].F, l), test::Matrix(test::Matrix::Identity()));
    }
    EXPECT_NE(m.occupied, 0);
    EXPECT_EQ(m.damaged, damaged || m.failed != 0);
  }
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  // a block is only left unfilled where its cell ends
  for (std::size_t b = 0; b + 1 < s.blocks.size(); ++b) {
    const bool same_cell = s.meta[b].row == s.meta[b + 1].row && s.meta[b].layer == s.meta[b + 1].layer &&
                           std::equal(s.meta[b].base, s.meta[b].base + 3, s.meta[b + 1].base);
    if (same_cell) {
      EXPECT_EQ(s.meta[b].occupied, 0xff);
    }
  }
  const auto by_slot = [](const Link& a, const Link& b) { return a.slot < b.slot; };
  EXPECT_TRUE(std::is_sorted(s.links.begin(), s.links.end(), by_slot));
}

TEST(PointStore, ArrangeGroupsByBodyPartAndCell) {
  Filled f(83, 2000);
  std::size_t links = 0;
  for (const PointRecord& r : f.records) links += r.links;
  const std::vector<int> where = f.arrange();
  expect_arranged(f.store, f.records, f.tags, where);
  EXPECT_EQ(f.store.links.size(), links);
  // and again, from the new places
  const std::vector<double> before = content(f.store);
  const std::vector<int> again = f.store.arrange(kCell);
  for (int slot : where) EXPECT_EQ(again[slot], slot);
  EXPECT_EQ(std::count(again.begin(), again.end(), -1), static_cast<long>(again.size() - where.size()));
  EXPECT_EQ(content(f.store), before);
}

TEST(PointStore, ArrangeDoesNotDependOnTheOrderOfArrival) {
  Filled f(84, 1000);
  std::vector<int> order(f.records.size());
  std::iota(order.begin(), order.end(), 0);
  test::Random random(85);
  const std::vector<int> where = f.arrange();
  for (int n = 0; n < 5; ++n) {
    random.shuffle(order);
    PointStore other;
    std::vector<int> slots;
    for (int i : order) slots.push_back(other.add(f.records[i], f.tags[i]));
    const std::vector<int> place = other.arrange(kCell);
    EXPECT_EQ(content(other), content(f.store));
    for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(place[slots[i]], where[order[i]]);
  }
}

TEST(PointStore, ArrangeDropsWhatWasReleasedAndTakesInArrivals) {
  Filled f(86, 500);
  const std::vector<int> where = f.arrange();
  EXPECT_FALSE(f.store.changed());
  std::vector<int> live, tags;
  std::vector<PointRecord> records;
  std::set<int> gone;
  for (std::size_t i = 0; i < f.records.size(); ++i) {
    if (i % 3 != 0) {
      f.store.release(where[i]);
      gone.insert(where[i]);
      EXPECT_TRUE(f.store.changed());
      continue;
    }
    live.push_back(where[i]);
    tags.push_back(f.tags[i]);
    records.push_back(f.records[i]);
  }
  EXPECT_EQ(f.store.size(), static_cast<int>(live.size()));
  test::Random random(87);
  for (int n = 0; n < 40; ++n) {
    records.push_back(random_record(random));
    tags.push_back(100000 + n);
    live.push_back(f.store.add(records.back(), tags.back()));
    EXPECT_FALSE(gone.count(live.back()));
    EXPECT_EQ(packed(f.store.record(live.back())), packed(records.back()));
    // one that comes and leaves again before all are arranged, whose lane and links are nobody else's
    PointRecord passing = random_record(random);
    passing.links = 2;
    const int slot = f.store.add(passing, 200000 + n);
    f.store.release(slot);
    EXPECT_TRUE(gone.insert(slot).second);
  }
  EXPECT_EQ(f.store.size(), static_cast<int>(live.size()));
  std::size_t links = 0;
  for (const PointRecord& r : records) links += r.links;
  EXPECT_GT(f.store.links.size(), links);  // those of the released are still there
  const std::vector<int> place = f.store.arrange(kCell);
  for (int slot : gone) EXPECT_EQ(place[slot], -1);
  for (int& slot : live) slot = place[slot];
  expect_arranged(f.store, records, tags, live);
  EXPECT_EQ(f.store.links.size(), links);
  EXPECT_EQ(f.store.size(), static_cast<int>(live.size()));
  EXPECT_FALSE(f.store.changed());

  // All points leave. Nothing is left, and the store is as new.
  for (int slot : live) f.store.release(slot);
  EXPECT_EQ(f.store.size(), 0);
  f.store.arrange(kCell);
  EXPECT_TRUE(f.store.blocks.empty() && f.store.links.empty());
}

// A released point gives nothing to a pass that comes before the next arrange(). It has no state left that would.
TEST(PointStore, ReleasedLanesAreEmpty) {
  Filled f(92, 100);
  f.arrange();
  for (std::size_t i = 0; i < f.slots.size(); i += 2) f.store.release(f.slots[i]);
  for (std::size_t i = 0; i < f.slots.size(); ++i) {
    const int b = f.slots[i] / kLanes, l = f.slots[i] % kLanes;
    const BlockMeta& m = f.store.meta[b];
    EXPECT_EQ(m.occupied >> l & 1, i % 2);
    if (i % 2 != 0) {
      EXPECT_EQ(packed(f.store.record(f.slots[i])), packed(f.records[i]));
      continue;
    }
    EXPECT_EQ(double(f.store.blocks[b].volume[l]), 0.0);
    EXPECT_FALSE((m.failed | m.framed | m.linked) >> l & 1);
  }
}

// Points of one slot keep the order of their links; slots ascend.
TEST(PointStore, LinksFollowTheirPoints) {
  Filled f(93, 300);
  f.arrange();
  std::size_t at = 0;
  std::vector<int> by_slot(f.slots.size());
  std::iota(by_slot.begin(), by_slot.end(), 0);
  std::sort(by_slot.begin(), by_slot.end(), [&](int a, int b) { return f.slots[a] < f.slots[b]; });
  for (int i : by_slot)
    for (int k = 0; k < f.records[i].links; ++k, ++at) {
      ASSERT_LT(at, f.store.links.size());
      EXPECT_EQ(f.store.links[at].slot, f.slots[i]);
      EXPECT_EQ(f.store.links[at].grain, f.records[i].link[k].grain);
      EXPECT_EQ(f.store.links[at].area, f.records[i].link[k].area);
      EXPECT_EQ(f.store.links[at].attached, f.records[i].link[k].attached);
    }
  EXPECT_EQ(at, f.store.links.size());
}

TEST(PointStore, ArrangeMovesPointsToOtherParts) {
  Filled f(90, 400);
  std::map<int, int> layer;
  test::Random random(91);
  for (std::size_t i = 0; i < f.records.size(); ++i) {
    if (random.index(3) == 0) continue;  // stays
    f.records[i].layer = random.index(4);
    layer[f.slots[i]] = f.records[i].layer;
  }
  expect_arranged(f.store, f.records, f.tags, f.arrange(layer));
}

// Points go to layers in place, round by round, as where nodes split. The store is bitwise that of a layout of the same points.
TEST(PointStore, PartsInPlace) {
  for (bool moving : {false, true}) {
    Filled f(93, 400);
    std::map<int, std::size_t> of_tag;
    for (std::size_t i = 0; i < f.tags.size(); ++i) of_tag[f.tags[i]] = i;
    if (moving) f.store.start_motion();
    f.store.arrange(kCell, Basis::quadratic, {}, true);
    // any number that tells points apart
    f.store.softening.resize(f.store.blocks.size());
    for (std::size_t b = 0; b < f.store.blocks.size(); ++b)
      for (int l = 0; l < kLanes; ++l) f.store.softening[b][l] = 0.5 * f.store.tags[b][l];
    test::Random random(94);
    for (int round = 0; round < 6; ++round) {
      std::map<int, int> moves;
      std::vector<int> slot_of_link;
      for (const Link& k : f.store.links) slot_of_link.push_back(f.store.tags[k.slot / kLanes][k.slot % kLanes]);
      for (std::size_t b = 0; b < f.store.blocks.size(); ++b)
        for (int l = 0; l < kLanes; ++l) {
          if (!(f.store.meta[b].occupied >> l & 1)) continue;
          // some blocks as a whole, of others a few points; some to the layer where they are, or back
          const bool whole = (b + round) % 7 == 0;
          if (!whole && random.index(6) != 0) continue;
          const int layer = whole ? 3 - round % 3 : random.index(4);
          moves[static_cast<int>(kLanes * b) + l] = layer;
          f.records[of_tag.at(f.store.tags[b][l])].layer = layer;
        }
      PointStore anew(f.store);
      anew.arrange(kCell, Basis::quadratic, moves, true);
      const PointStore::LayerMove moved = f.store.move_to_layers(moves, kCell, Basis::quadratic);
      EXPECT_EQ(content(f.store), content(anew));
      ASSERT_EQ(moved.new_link_index.size(), f.store.links.size());
      for (std::size_t k = 0; k < slot_of_link.size(); ++k) {
        const int slot = f.store.links[moved.new_link_index[k]].slot;
        EXPECT_EQ(f.store.tags[slot / kLanes][slot % kLanes], slot_of_link[k]);
      }
      EXPECT_EQ(f.store.size(), 400);
      for (std::size_t b = 0; b < f.store.blocks.size(); ++b)
        for (int l = 0; l < kLanes; ++l) {
          if (!(f.store.meta[b].occupied >> l & 1)) continue;
          const int tag = f.store.tags[b][l];
          EXPECT_EQ(f.store.softening[b][l], 0.5 * tag);
          PointRecord expected = f.records[of_tag.at(tag)];
          const PointRecord r = f.store.record(static_cast<int>(kLanes * b) + l);
          expected.moving = r.moving;
          for (int d = 0; d < 3; ++d) expected.X0[d] = r.X0[d];
          EXPECT_EQ(packed(r), packed(expected));
        }
    }
    EXPECT_GT(std::count_if(f.store.meta.begin(), f.store.meta.end(), [](const BlockMeta& m) { return m.layer > 0; }), 30);
  }
}

TEST(PointStore, UnstrainedUntilAPointOfItIsNot) {
  Filled f(90, 20);
  for (PointBlock& p : f.store.blocks) {
    p.F = Mat3<vd>{};
    for (int i = 0; i < 3; ++i) p.F.a[i][i] = splat(1.0);
    p.strain = Sym3<vd>{};
  }
  EXPECT_TRUE(f.store.unstrained());
  int last = kLanes - 1;
  while (!(f.store.meta.back().occupied >> last & 1)) --last;
  f.store.blocks.back().F.a[0][1][last] = 1e-300;
  EXPECT_FALSE(f.store.unstrained());
  f.store.blocks.back().F.a[0][1][last] = 0.0;
  f.store.blocks.back().strain.xy[last] = -1e-300;
  EXPECT_FALSE(f.store.unstrained());
}

TEST(PointStore, Clear) {
  Filled f(88, 20);
  f.store.clear();
  EXPECT_TRUE(f.store.blocks.empty() && f.store.states().empty() && f.store.meta.empty() && f.store.tags.empty() && f.store.links.empty());
  EXPECT_FALSE(f.store.changed());
  EXPECT_EQ(f.store.size(), 0);
  test::Random random(89);
  EXPECT_EQ(f.store.add(random_record(random), 1), 0);
}

}  // namespace
}  // namespace mpdem
