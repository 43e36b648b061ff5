// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// State of the material points of a rank. It is the only copy, in the memory layout of the kernels. Eight points of one
// cell make a block: a structure of arrays, whose lanes beyond the last point are empty and have zero volume. The atom
// of a point in LIGGGHTS holds its slot, which is eight times the block plus the lane. Slots change whenever the points
// are arranged. Points that arrive from another rank or a restart file are kept in blocks of their own at the end, the
// tail, until the next arrange().
//
// Lengths are relative to the origin of the point's bond. X is the position in the reference configuration, in which
// the bond was created. If there is a `motion`, X is the position of the point when the reference was last renewed
// (with `updated` kinematics, in every step). F is relative to the reference.
#ifndef MPDEM_MPM_POINT_STORE_H
#define MPDEM_MPM_POINT_STORE_H

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "../material/corotational.h"
#include "../material/law.h"
#include "../numerics/tensor3.h"
#include "basis.h"
#include "columns.h"
#include "point_record.h"

namespace mpdem {

// Eight points. The fields are those of a PointRecord, with the same order of components.
struct PointBlock {
  vd X[3];
  vd volume;
  Mat3<vd> F;
  Frame q;
  Sym3<vd> strain;
};

// Motion of points whose reference moves: position of creation, velocity and its affine field, as in a PointRecord.
struct PointMotion {
  vd X0[3], v[3];
  Mat3<vd> C;
};

// Slip of the cracks of failed points, as in a PointRecord.
struct PointSlip {
  vd at[3];
};

struct BlockMeta {
  int row = 0, layer = 0;
  int base[3] = {0, 0, 0};         // cell, see basis.h
  int joined = kOneCell;           // code of its cells in a row, see basis.h and arrange()
  int column[kMostColumns] = {0};  // first nodes of its columns, set by the grid; without a meaning if it has aliases
  static constexpr int kOwn = -1;
  int aliases = kOwn;                                 // index of the first of its nodes in Grid::aliases; kOwn: it has columns
  std::uint8_t occupied = 0, failed = 0, framed = 0;  // one bit for each lane
  std::uint8_t split_checked = 0;                     // lanes that failed, and for which nodes were split, see fracture/phantom_nodes.h
  std::uint8_t distorted = 0;          // lanes that failed and are too distorted for a crack that closes, see closing_points.h
  std::uint8_t connected[2] = {0, 0};  // lanes that intact cement joined to grain 0 or 1 at the last check; all until separation
  std::uint8_t linked = 0;             // lanes whose point had a link to a grain when it was made
  std::uint8_t second = 0, third = 0;  // lanes in the second and the third cell of the row
  Lattice lattice = Lattice::none;     // arrangement of its points, with empty lanes at matching positions
  bool damaged = false;                // some lane failed, or has a state of the law that is not 0
  std::uint8_t material = 0;           // number of the material of its points, see Law::of_material()
};

// Drawn factors of eight points (material/scatter.h). stiffness: on the stress. strength: on the threshold of damage. The
// driving force that is compared with it is found with the moduli without scatter. For a law of degree 2, whose driving
// force grows with the moduli, `strength` is therefore divided by the factor of the moduli.
struct PointScatter {
  vd stiffness = splat(1.0), strength = splat(1.0);
};

// Prefetches memory for writing. Always inlined: GCC takes a function with no other effect for one without any effect.
__attribute__((always_inline)) inline void prefetch_bytes(const void* first, std::size_t bytes) {
  constexpr std::size_t kLine = 64;
  const char* p = static_cast<const char*>(first);
  for (std::size_t at = 0; at < bytes; at += kLine) __builtin_prefetch(p + at, 1);
}

// Converts a bit mask to a mask of lanes.
inline vmask lanes(std::uint8_t bits) {
  const vmask bit{1, 2, 4, 8, 16, 32, 64, 128};
  return (bit & static_cast<std::int64_t>(bits)) != 0;
}
// The value in these lanes, and zero in the others.
inline vd masked(std::uint8_t bits, vd value) { return select(lanes(bits), value, vd{}); }

// Number of nodes of a block along d, if the basis has `support` nodes in one cell.
inline int nodes_along(const BlockMeta& m, int d, int support) { return support + reach_along(m.joined, d); }
// Cell of a lane, in direction d.
inline int cell_of(const BlockMeta& m, int lane, int d) {
  return m.base[d] + (reach_along(m.joined, d) == 0 ? 0 : (m.second >> lane & 1) + 2 * (m.third >> lane & 1));
}

// Calls f with the weights of a block. f is compiled for one cell, and for rows of two and three cells along each axis.
template <class Type, class F>
decltype(auto) with_weights(const PointBlock& p, const BlockMeta& m, double inverse_h, F&& f) {
  if constexpr (Type::kMayJoinCells) {
    const auto of_row = [&](auto joined) {
      return f(Weights<Type, decltype(joined)::value>(p.X, m.base, lanes(m.second), lanes(m.third), inverse_h));
    };
    if (m.joined == 0) return of_row(std::integral_constant<int, 0>());
    if (m.joined == 1) return of_row(std::integral_constant<int, 1>());
    if (m.joined == 2) return of_row(std::integral_constant<int, 2>());
    if (m.joined == 3) return of_row(std::integral_constant<int, 3>());
    if (m.joined == 4) return of_row(std::integral_constant<int, 4>());
    if (m.joined == 5) return of_row(std::integral_constant<int, 5>());
  }
  return f(Weights<Type>(p.X, m.base, inverse_h));
}

// Calls f with weights that serve gather_gradient and scatter_gradient alone. Points of a lattice have ColumnWeights, which are
// fewer.
template <class Type, class F>
decltype(auto) with_gradient_weights(const PointBlock& p, const BlockMeta& m, double inverse_h, F&& f) {
  if constexpr (Type::kSupport == 3) {
    if (m.lattice == Lattice::box) return f(ColumnWeights<Type, Lattice::box>(p.X, m.base, inverse_h));
    if (m.lattice == Lattice::columns) return f(ColumnWeights<Type, Lattice::columns>(p.X, m.base, inverse_h));
  }
  return with_weights<Type>(p, m, inverse_h, std::forward<F>(f));
}

// Range of the entries of a slot in a list of links or contact points that ascends in slot.
template <class List>
auto of_slot(List& list, int slot) {
  const auto begin = std::lower_bound(list.begin(), list.end(), slot, [](const auto& a, int s) { return a.slot < s; });
  auto end = begin;
  while (end != list.end() && end->slot == slot) ++end;
  return std::make_pair(begin, end);
}

class PointStore {
 public:
  std::vector<PointBlock> blocks;
  std::vector<PointMotion> motion;  // empty while the first reference is in use
  std::vector<PointSlip> slip;      // empty while no crack closed under friction, see closing_points.h
  // Root of the norm of the present strain of the points (strain_norm.h), in blocks with damage whose last pass found it,
  // and kUnknown in others. The list is empty without nonlocal damage. Records do not have it, since it follows from
  // the strain.
  std::vector<vd> root_of_norm;
  static constexpr double kUnknown = -1.0;
  // Softening of the points (material/law.h) by positions of creation, set with the layout. Empty if all have the same.
  std::vector<vd> softening;
  std::vector<PointScatter> scatter;  // set with the layout; empty without scatter
  std::vector<BlockMeta> meta;
  std::vector<std::array<int, kLanes>> tags;
  std::vector<Link> links;             // ascending in slot
  std::vector<ContactPoint> contacts;  // ascending in slot and grain

  int tag(int slot) const { return tags[slot / kLanes][slot % kLanes]; }
  bool has_failed(int slot) const { return meta[slot / kLanes].failed >> slot % kLanes & 1; }

  // Appends a point and returns its slot.
  int add(const PointRecord& r, int tag);
  PointRecord record(int slot) const;

  // Sorts all points into blocks of one cell and one material, in the order bond, layer, material, cell, tag. Returns the new
  // slot of each old slot, -1 for an empty one. Order and blocks depend on the points alone, not on the order of their
  // arrival. Links and contact points are moved with them.
  // new_layer: the new layer of some slots, by slot.
  // stay: points will not change cells (`kinematics total`). This has three effects.
  // 1. Points of one cell that are in columns of a lattice get the lanes of columns.h.
  // 2. Blocks that are not full are merged with those of one or two next cells in a row, if their points fit into one block. Such a
  //    block has a third or two thirds more nodes with the quadratic basis, but it replaces two or three blocks.
  // 3. A point that gets another layer keeps its lane. A block whose points are in several layers is divided into a family of
  //    blocks, one per layer: the home, which has the points of the first layer, and a copy for each other layer. The lane
  //    of a point is used in the block of its layer and empty in the others. Blocks of a family span only the cells in
  //    which their points are. Copies come after all homes, in the order home, layer.
  std::vector<int> arrange(double cell, Basis basis = Basis::quadratic, const std::map<int, int>& new_layer = {}, bool stay = false);

  // Moves points to other layers after arrange() with `stay`. Blocks are bitwise identical to those of arrange().
  struct LayerMove {
    std::vector<int> blocks;          // blocks that have other points than before
    std::vector<int> new_link_index;  // new index of each link
  };
  LayerMove move_to_layers(const std::map<int, int>& layer_of_slot, double cell, Basis basis);

  // Removes a point that left for another rank. Its links stay until the next arrange().
  void release(int slot);
  // True if points came or left since arrange().
  bool changed() const { return changed_; }
  int size() const;         // points
  bool unstrained() const;  // true if all deformation gradients are the identity, and all strains zero
  bool any_failed() const;
  // Bits of the grains to which a point is connected, as in a PointRecord.
  int connected(int slot) const {
    const BlockMeta& m = meta[slot / kLanes];
    return (m.connected[0] >> slot % kLanes & 1) + 2 * (m.connected[1] >> slot % kLanes & 1);
  }
  void set_connected(int slot, int grains) {
    const std::uint8_t bit = static_cast<std::uint8_t>(1u << slot % kLanes);
    for (int g = 0; g < 2; ++g) {
      std::uint8_t& m = meta[slot / kLanes].connected[g];
      m = static_cast<std::uint8_t>((grains >> g & 1) ? m | bit : m & ~bit);
    }
  }

  // Prefetches a block that a pass will soon need. Otherwise the pass stalls: the hardware prefetcher stops at the end
  // of a page of memory, which has about three blocks.
  __attribute__((always_inline)) void prefetch(int b) const {
    prefetch_bytes(&blocks[b], sizeof(PointBlock));
    prefetch_bytes(&meta[b], sizeof(BlockMeta));
    if (!state_.empty()) prefetch_bytes(state(b), state_fields_ * sizeof(vd));
  }

  // State of the law of damage of block b, state_fields() vectors. It takes no memory until some point has damage.
  const vd* state(int b) const { return state_.empty() ? kNoState : &state_[state_fields_ * static_cast<std::size_t>(b)]; }
  vd* change_state(int b);
  // States of all blocks in sequence. Empty while they are all 0.
  const std::vector<vd>& states() const { return state_; }
  // Number of vectors in a state of the law. kMostStateFields until the law is set, as in a record.
  int state_fields() const { return state_fields_; }
  // Law of the points. Null until it is set, if the points came from a file or another rank. It outlives the command
  // that made it, since the states belong to this law.
  const Law* law() const { return law_.get(); }
  // Number of the law that is set or with which the points arrived, as in PointRecord::law.
  int law_number() const { return law_number_; }
  // Sets the law. Numbers of a state beyond the fields of the law must be 0.
  void set_law(const std::shared_ptr<const Law>& law);
  // Sets the state of one point. numbers: kMostStateFields of them.
  void set_state(int slot, const double* numbers);

  // Gives the points a PointMotion with zero velocity, unless they have one.
  void start_motion();
  // Gives the points a slip of zero, unless they have a slip.
  void start_slip();
  void keep_root_of_norm(int b, const vd& root) {
    if (root_of_norm.empty()) root_of_norm.assign(blocks.size(), splat(kUnknown));
    root_of_norm[b] = root;
  }
  // Must be called after every change of strain outside the pass over the points.
  void forget_roots_of_norm() { root_of_norm.clear(); }
  bool knows_root_of_norm(int b) const { return meta[b].damaged && !root_of_norm.empty() && root_of_norm[b][0] != kUnknown; }

  // Appends a block without points in cell `base` and returns its number.
  int add_block(int row, int layer, const int* base, double cell, Basis basis);
  // Copies a point of another store into a free lane, without its links.
  void take(const PointStore& from, int slot, int new_slot);
  // Removes the point of a lane, without its links. The empty lane gets a position in the middle of the cell and no volume.
  void empty_lane(int slot, double cell, Basis basis);
  // Sorts the links by slot after moves. new_index[i] is the new index of link i.
  std::vector<int> sort_links();

  // Drawn factors of the points of a block, 1 without scatter.
  vd stiffness_factor(int b) const { return scatter.empty() ? splat(1.0) : scatter[b].stiffness; }
  vd strength_factor(int b) const { return scatter.empty() ? splat(1.0) : scatter[b].strength; }

  // Positions at which the points of a block were created.
  const vd* created_at(int b) const { return motion.empty() ? blocks[b].X : motion[b].X0; }

  void clear();
  std::size_t memory_usage() const;

 private:
  void forget_root_of_norm(int b) {
    if (!root_of_norm.empty()) root_of_norm[b] = splat(kUnknown);
  }
  template <class Self, class F>
  static void each_array(Self& s, F f) {
    f(s.blocks);
    f(s.state_);
    f(s.motion);
    f(s.slip);
    f(s.root_of_norm);
    f(s.softening);
    f(s.scatter);
    f(s.meta);
    f(s.tags);
    f(s.links);
    f(s.contacts);
  }
  // Calls f(array, entries in a block) for the arrays with a fixed number of entries in each block.
  template <class Self, class F>
  static void each_array_of_blocks(Self& s, F f) {
    f(s.blocks, 1);
    if (!s.state_.empty()) f(s.state_, s.state_fields_);
    if (!s.motion.empty()) f(s.motion, 1);
    if (!s.slip.empty()) f(s.slip, 1);
    if (!s.root_of_norm.empty()) f(s.root_of_norm, 1);
    if (!s.softening.empty()) f(s.softening, 1);
    if (!s.scatter.empty()) f(s.scatter, 1);
    f(s.meta, 1);
    f(s.tags, 1);
  }
  std::size_t arranged_blocks_ = 0;  // number of blocks with a cell; the blocks after them are the tail
  int tail_lanes_ = 0;               // lanes used in the last block of the tail
  bool changed_ = false;
  static const vd kNoState[kMostStateFields];
  std::vector<vd> state_;
  int state_fields_ = kMostStateFields, law_number_ = 0;
  std::shared_ptr<const Law> law_;
  int homes_ = 0;  // number of blocks before the first copy
  struct Copy {
    int home, layer;
  };
  std::vector<Copy> copies_;
  // How a family is to be divided, by lane: the layer of the point, the block in which it is now, and its cell. Layer and block
  // are -1 if the lane is empty in all blocks of the family.
  struct Family {
    std::array<int, kLanes> layer, from;
    std::array<std::array<int, 3>, kLanes> cell;
    Family() { layer.fill(-1), from.fill(-1); }
    int first() const;                // the lowest layer
    std::vector<int> others() const;  // the other layers, ascending
    // Sets the row of cells of the block of a layer: base, joined, second and third.
    void shape(int layer, BlockMeta& m) const;
  };
  int add_block(int row, int layer, const Family& family, double cell, Basis basis);
  std::vector<int> blocks_of_family(int home) const;
  // Returns the families that have one of these slots, by their home, with the new layers of the slots.
  std::map<int, Family> families_that_divide(const std::map<int, int>& layer_of_slot) const;
  PointStore copy_of_blocks(const std::vector<int>& which) const;
  void append_copy(const PointStore& from, int b);
  void fill_lanes(int b, const Family& family, const PointStore& from, const std::map<int, int>& new_index, std::vector<int>& new_slot,
                  double cell, Basis basis);
  void find_damaged(int b);
  // Finds BlockMeta::lattice, and moves empty lanes to positions that fit it.
  void find_lattice(int b);
  void reserve_like(const PointStore& other, std::size_t blocks);
  void add_record(int slot, const PointRecord& r, int tag);
  void set(int slot, const PointRecord& r, int tag);
  void set_state_fields(int fields);
  void append_block();
};

}  // namespace mpdem

#endif
