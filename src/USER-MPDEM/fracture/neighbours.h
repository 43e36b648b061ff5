// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Which points of a bond hold together if they are intact: those whose lattice cells share a face and, if they are
// of different sheets (crevice.h) and none of them in the middle, whose material touches there and in whose supports there is a
// node at which the sheets are joined. What the separation (separation.h) and the ligament (ligament.h) of a bond go by.
#ifndef MPDEM_NEIGHBOURS_H
#define MPDEM_NEIGHBOURS_H

#include <array>
#include <utility>
#include <vector>

namespace mpdem {

struct CrackPoint {
  int tag;
  int cell[3];              // of the lattice
  int part;                 // so far; piece_of(), see body.h
  int sheet;
  int base[3];              // first node of its support
  float space[6];           // space_ahead() towards -x, +x, -y, +y, -z, +z
  float damage;             // largest eigenvalue
  bool failed;
  bool attached[2];         // holds to this grain; if it failed, it is a skin on it
  double link_area[2];      // projected area of its links, let go or not
  float link_damage[2];     // of its link to this grain, as far as the traction law knows damage
  int nearer;               // grain, by nearer_side() of body.h
  bool middle;              // of both sheets, in_the_middle() of body.h
  float above[2];           // distance from the surface of either grain
  int holds = 3;            // PointRecord::holds
};

// Ascending.
using JoinedNodes = std::vector<std::array<int, 3>>;

// Points that a bridge may have to be wide at most: those of a cell in one direction.
constexpr int kMostAcross = 16;

class Neighbours {
 public:
  // joined: where there are sheets; support: nodes a direction.
  // across: points that a bridge is wide at least, in both directions, up to kMostAcross. A face between points that hold belongs to a bridge if a square of
  // so many faces around it has no failed point beside it; at a rim, one of the squares that hold most faces. A narrower bridge is not
  // resolved by a grid whose cells are as wide: it has fewer strains than its nodes have ways to move, and carries next to nothing.
  explicit Neighbours(const std::vector<CrackPoint>& points, const JoinedNodes& joined = {}, int support = 0, int across = 1);
  // Points across the faces -x, +x, -y, +y, -z, +z; -1 where there is none, or none that holds.
  const std::array<int, 6>& of(int i) const { return face_[i]; }
  // Is there a point across that face, do both hold, and is the face one of a bridge?
  bool bridged(int i, int face) const { return square(i, face, nullptr); }
  // Points beside the square of faces that makes it one, i and that across the face among them.
  std::vector<int> bridge(int i, int face) const;
  // Points in the order of their cells: what goes by it does not depend on the order in which they are given.
  const std::vector<int>& order() const { return order_; }

 private:
  int at(const std::array<int, 3>& cell) const;
  bool square(int i, int face, std::vector<int>* beside) const;
  std::vector<int> order_;
  std::vector<std::array<int, 6>> face_;
  const std::vector<CrackPoint>& points_;
  int across_;
  std::vector<std::pair<std::array<int, 3>, int>> cells_;  // ascending
  std::vector<int> first_;                                  // of cells_, behind those of an x
  int least_x_ = 0;
};

}  // namespace mpdem

#endif
