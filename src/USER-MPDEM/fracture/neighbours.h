// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds which points of a bond hold together if they are intact: those whose lattice cells share a face. Points of
// different sheets (crevice.h), none of them in the middle, need more: their material must touch there. Separation
// (separation.h) and ligament (ligament.h) of a bond use these neighbours.
#ifndef MPDEM_FRACTURE_NEIGHBOURS_H
#define MPDEM_FRACTURE_NEIGHBOURS_H

#include <array>
#include <utility>
#include <vector>

namespace mpdem {

struct CrackPoint {
  int tag;
  int cell[3];     // cell of the lattice
  int layer;       // present piece, where parts are pieces (bond_record.h), else 0
  float space[6];  // space_ahead() towards -x, +x, -y, +y, -z, +z
  float damage;    // largest eigenvalue
  bool failed;
  bool attached[2];      // holds to this grain; if the point failed, it is a skin on the grain
  double link_area[2];   // projected area of its links, let go or not
  float link_damage[2];  // damage of its link to this grain, if the traction law knows damage
  int nearer;            // its sheet: the grain, by nearer_side() of bond_record.h
  bool middle;           // belongs to both sheets, in_the_middle() of bond_record.h
  float above[2];        // distance from the surface of each grain
  int connected = 3;     // PointRecord::holds
};

// Most points that a cell may have in one direction, and so the largest value of `across`.
constexpr int kMostAcross = 16;

class Neighbours {
 public:
  // across: least width of a bridge in points, in both directions, up to kMostAcross. A face between points that hold
  // belongs to a bridge if there is a square of so many faces around it without a failed point beside it. At a rim the
  // square must be one of those that hold most faces. A grid whose cells are as wide does not resolve a narrower
  // bridge: the bridge has fewer strains than its nodes have ways to move, and carries next to nothing.
  explicit Neighbours(const std::vector<CrackPoint>& points, int across = 1);
  // Points across the faces -x, +x, -y, +y, -z, +z, whether they failed or not. -1 if there is none, or if the two
  // points are of different sheets that are not connected there.
  const std::array<int, 6>& of(int i) const { return face_[i]; }
  // True if there is a point across that face, both points hold, and the face belongs to a bridge.
  bool bridged(int i, int face) const { return square(i, face, nullptr); }
  // Points beside the square of faces that makes the face part of a bridge, including i and the point across the face.
  std::vector<int> bridge(int i, int face) const;
  // Points in the order of their cells. Results found in this order do not depend on the order in which the points are given.
  const std::vector<int>& order() const { return order_; }

 private:
  int at(const std::array<int, 3>& cell) const;
  bool square(int i, int face, std::vector<int>* beside) const;
  std::vector<int> order_;
  std::vector<std::array<int, 6>> face_;
  const std::vector<CrackPoint>& points_;
  int across_;
  std::vector<std::pair<std::array<int, 3>, int>> cells_;  // ascending
  std::vector<int> first_;  // first_[x - least_x_]: first of cells_ with this x; the last entry is their number
  int least_x_ = 0;
};

}  // namespace mpdem

#endif
