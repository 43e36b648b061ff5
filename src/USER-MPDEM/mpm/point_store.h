// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// State of the material points a rank owns: the only copy, in the layout the kernels
// read. Eight points of one cell make a block (structure of arrays inside, lanes beyond
// the last point are empty with zero volume). LIGGGHTS' atom of a point holds its slot,
// eight times the block plus the lane; slots change whenever the points are arranged.
// Points that arrive from another rank or a restart file wait in blocks of their own at
// the end until the next `arrange`.
//
// Lengths are relative to the origin of the point's body. X is the place in the reference
// configuration: where the body was created, or, if there is a `motion`, where the points were
// when the reference was last taken anew (with `updated` kinematics, in every step); F is
// relative to it.
#ifndef MPDEM_POINT_STORE_H
#define MPDEM_POINT_STORE_H

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "../material/corotational.h"
#include "../material/law.h"
#include "../numerics/tensor3.h"
#include "basis.h"
#include "body.h"

namespace mpdem {

// Numbers that a law of damage may keep for a point.
constexpr int kMostStateFields = Law::kMostFields;

// Bond of a point to a grain. The foot point lies on the surface of the grain as it was when
// the body was created; the cement there has its reference at foot + moved.
struct Link {
  int slot;
  int grain;        // tag
  double foot[3];
  double area;      // of the grain's surface
  int attached;     // 0 once it has let go
  double moved[3] = {0, 0, 0};
  bool inert = false;  // has let go, but its added mass still counts, see coupling/penalty_links.h
};

// One point, for transfer between ranks, restart files and creation.
struct PointRecord {
  static constexpr int kMaxLinks = 2;
  int body = 0, part = 0;
  bool failed = false;
  bool has_frame = false;  // q was given; otherwise the fix sets it from its axis rule
  double X[3] = {0, 0, 0};
  double volume = 0;
  double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  double q[4] = {1, 0, 0, 0};
  double strain[6] = {0, 0, 0, 0, 0, 0};
  double damage[kMostStateFields] = {0, 0, 0, 0, 0, 0};  // state of the law of damage, see material/law.h
  bool moving = false;  // has the next three
  double X0[3] = {0, 0, 0}, v[3] = {0, 0, 0}, C[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
  int links = 0;
  Link link[kMaxLinks];

  // Numbers that pack() gives, moving or not.
  static constexpr int kPacked = 5 + 3 + 1 + 9 + 4 + 6 + 6 + 1 + kMaxLinks * 9;
  static constexpr int kPackedMoving = kPacked + 15;
  int pack(double* buf) const;
  int unpack(const double* buf);
  static bool packed_moving(const double* buf) { return buf[4] != 0.0; }
  // Of a record from a file, as long as `packed_moving` says; what is wrong with it, empty if nothing is.
  std::string unpack_checked(const double* buf, const std::vector<Body>& bodies);

 private:
  template <class Numbers>
  void take(Numbers& in);
};

struct PointBlock {
  vd X[3];
  vd volume;
  Mat3<vd> F;
  Frame q;
  Sym3<vd> strain;
};

// Of points whose reference moves: where they were created, velocity and its affine part.
struct PointMotion {
  vd X0[3], v[3];
  Mat3<vd> C;
};

struct BlockMeta {
  int body = 0, part = 0;
  int base[3] = {0, 0, 0};       // cell, see basis.h
  int column[kMostColumns] = {0};  // first nodes of its columns, set by the grid
  std::uint8_t occupied = 0, failed = 0, framed = 0;  // a bit a lane
  std::uint8_t linked = 0;  // had a link to a grain when it was made
  bool damaged = false;     // some lane has a state of the law that is not 0
};

// Bit mask to lanes.
inline vmask lanes(std::uint8_t bits) {
  const vmask bit{1, 2, 4, 8, 16, 32, 64, 128};
  return (bit & static_cast<std::int64_t>(bits)) != 0;
}
inline std::uint8_t bits(vmask m) {
  unsigned r = 0;
  for (int l = 0; l < kLanes; ++l) r |= (m[l] ? 1u : 0u) << l;
  return static_cast<std::uint8_t>(r);
}

class PointStore {
 public:
  std::vector<PointBlock> blocks;
  std::vector<PointMotion> motion;  // empty while the first reference stands
  std::vector<BlockMeta> meta;
  std::vector<std::array<int, kLanes>> tags;
  std::vector<Link> links;  // ascending in slot

  // Appends a point and returns its slot.
  int add(const PointRecord& r, int tag);
  PointRecord record(int slot) const;

  // Keeps the points in `live` (slots, with their tags) and drops all others, in the order
  // body, part, cell, tag; new_slot[i] is where live[i] went. Order and blocks depend on the
  // points alone, not on how they came here. Link positions follow. new_part[i], if there are
  // any, is the part that live[i] goes to.
  void arrange(const std::vector<int>& live, const std::vector<int>& live_tags, double cell,
               std::vector<int>& new_slot, const std::vector<int>& new_part = {}, Basis basis = Basis::quadratic);

  // State of the law: state_fields() vectors a block. It takes no memory until some point has damage.
  const vd* state(int b) const { return state_.empty() ? kNoState : &state_[state_fields_ * static_cast<std::size_t>(b)]; }
  vd* change_state(int b);
  // Of all blocks, one after the other; empty while they are all 0.
  const std::vector<vd>& states() const { return state_; }
  // As many numbers as the law of the points has. Until it is set, and where a point arrives that has more, there are
  // kMostStateFields of them: the damage tensor that a file gave, see Law::state_from_tensor.
  int state_fields() const { return state_fields_; }
  // That law, nullptr until it is set. It stays when the command that made it is gone: the numbers are of no other.
  const Law* law() const { return law_.get(); }
  // Numbers above the count of the law must be 0.
  void set_law(const std::shared_ptr<const Law>& law);
  // The state of one point.
  void set_state(int slot, const double* numbers);

  // Gives the points a motion, at rest, if they have none.
  void let_move();

  // A block without points in cell `base`; returns its number.
  int add_block(int body, int part, const int* base, double cell, Basis basis);
  // Copies a point of another store, without its links, into a free lane.
  void take(const PointStore& from, int slot, int new_slot);
  void empty_lane(int slot, double cell, Basis basis);
  // Ascending in slot again, after moves; new_place[i] is where link i went.
  std::vector<int> sort_links();

  // Where the points of a block were created.
  const vd* created_at(int b) const { return motion.empty() ? blocks[b].X : motion[b].X0; }

  void clear();
  std::size_t memory_usage() const;

 private:
  static const vd kNoState[kMostStateFields];
  std::vector<vd> state_;
  int state_fields_ = kMostStateFields;
  std::shared_ptr<const Law> law_;
  std::size_t settled_ = 0;  // blocks that cells were found for; the others are the tail
  void set(int slot, const PointRecord& r, int tag);
  void set_state_fields(int fields);
};

}  // namespace mpdem

#endif
