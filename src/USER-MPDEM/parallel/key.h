// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Identifies a node on all ranks by its field, which is a layer of a bond (mpm/bond_record.h), and its index on the
// grid of the bond. Keys of other objects, as of a piece of a bond, use fewer of these integers. The order of keys is field, i, j, k.
//
// A key takes 16 bytes: 31 bits for the bond, as many as an int can count, 22 for the layer, 25 for each component of
// the grid index. Memory is full before a bond can have so many layers, as each layer has its own nodes. The constructor throws
// OnOneRank for an index farther than kFarthest cells from the origin of the bond.
#ifndef MPDEM_PARALLEL_KEY_H
#define MPDEM_PARALLEL_KEY_H

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "agree.h"

namespace mpdem {

using Field = std::int64_t;
constexpr int kRowBits = 31, kLayerBits = 22;

class Key {
 public:
  static constexpr int kIndexBits = 25, kFarthest = (1 << (kIndexBits - 1)) - 1;
  // Makes a key that no node has, and that precedes all others.
  constexpr Key() = default;
  Key(Field field, int i, int j, int k)
      : bits_(static_cast<Bits>(field) << 3 * kIndexBits | shifted(i, 2) | shifted(j, 1) | shifted(k, 0)) {}
  Key(Field field, const int* index) : Key(field, index[0], index[1], index[2]) {}
  // Makes a key that no node has, and that precedes all keys of the field.
  static Key before(Field field) {
    Key k;
    k.bits_ = static_cast<Bits>(field) << 3 * kIndexBits;
    return k;
  }

  Field field() const { return static_cast<Field>(bits_ >> 3 * kIndexBits); }
  int at(int d) const { return static_cast<int>(bits_ >> (2 - d) * kIndexBits & kMask) - kFarthest - 1; }
  std::array<int, 3> index() const { return {at(0), at(1), at(2)}; }
  Key with_field(Field field) const {
    Key k = before(field);
    k.bits_ |= bits_ & ((Bits{1} << 3 * kIndexBits) - 1);
    return k;
  }
  Key moved(int d, int by) const {
    std::array<int, 3> p = index();
    p[d] += by;
    return Key(field(), p.data());
  }
  // Low and high 64 bits of the whole key.
  std::uint64_t low() const { return static_cast<std::uint64_t>(bits_); }
  std::uint64_t high() const { return static_cast<std::uint64_t>(bits_ >> 64); }

  friend bool operator<(const Key& a, const Key& b) { return a.bits_ < b.bits_; }
  friend bool operator==(const Key& a, const Key& b) { return a.bits_ == b.bits_; }
  friend bool operator!=(const Key& a, const Key& b) { return a.bits_ != b.bits_; }

 private:
  __extension__ using Bits = unsigned __int128;
  static constexpr Bits kMask = (Bits{1} << kIndexBits) - 1;
  static Bits shifted(int place, int n) {
    if (place > kFarthest || place < -kFarthest)
      throw OnOneRank(text_of("a node lies ", place, " cells from the middle of its bond, allowed are ", kFarthest,
                              "; use a larger 'cell', and check the motion of the points"));
    return static_cast<Bits>(place + kFarthest + 1) << n * kIndexBits;
  }
  Bits bits_ = 0;
};

constexpr Key kNoNode;

// Index of a key in an ascending list, -1 if it is not there.
inline int index_of(const std::vector<Key>& ascending, const Key& k) {
  const auto at = std::lower_bound(ascending.begin(), ascending.end(), k);
  return at != ascending.end() && *at == k ? static_cast<int>(at - ascending.begin()) : -1;
}

}  // namespace mpdem

#endif
