// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds the neighbours of the points of a bond: points whose lattice cells share a face. Intact neighbours are
// connected. Points on the two sides of an unbonded gap (unbonded_gap.h), none of them in the middle, are neighbours only if
// their material touches. Separation (separation.h) and ligament (ligament.h) of a bond use these neighbours.
#ifndef MPDEM_FRACTURE_NEIGHBOURS_H
#define MPDEM_FRACTURE_NEIGHBOURS_H

#include <array>
#include <utility>
#include <vector>

namespace mpdem {

struct CrackPoint {
  int tag;
  int cell[3];     // cell of the lattice
  int layer;       // layer of the point, where the layers of the bond are pieces (bond_record.h); else 0
  float space[6];  // space_ahead() towards -x, +x, -y, +y, -z, +z
  float damage;    // largest eigenvalue
  bool failed;
  bool attached[2];      // attached to this grain; a failed point is residue on the grain
  double link_area[2];   // projected area of its links, debonded ones too
  float link_damage[2];  // largest damage of its links to this grain, 0 if the traction law has no damage
  int nearer;            // grain of its side of an unbonded gap, by nearer_grain() of bond_record.h
  bool middle;           // it belongs to both sides, by is_equidistant() of bond_record.h
  float above[2];        // distance from the surface of each grain
  int connected = 3;     // bits of grains, as PointRecord::connected
};

// Most points that a cell of the grid may have in one direction, and so the largest value of `across`.
constexpr int kMostAcross = 16;

class Neighbours {
 public:
  // across: least width of a bridge in points, in both directions, up to kMostAcross. A face between intact points
  // belongs to a bridge if it lies in a square of faces of this width without a failed point beside it. At a rim the square must be
  // one of those with most faces. A grid whose cells have this width does not resolve a narrower bridge: the bridge has fewer strains
  // than its nodes have degrees of freedom, and carries very little.
  explicit Neighbours(const std::vector<CrackPoint>& points, int across = 1);
  // Indices of the points across the faces -x, +x, -y, +y, -z, +z, failed or not. -1 if there is none, or if the two
  // points are on different sides of an unbonded gap and do not touch.
  const std::array<int, 6>& of(int i) const { return face_[i]; }
  // True if there is a point across that face, both points are intact, and the face belongs to a bridge.
  bool bridged(int i, int face) const { return find_bridge(i, face, nullptr); }
  // Points beside the square of faces by which the face belongs to a bridge, with i and the point across the face.
  std::vector<int> bridge(int i, int face) const;
  // Points in the order of their cells. Results found in this order do not depend on the order of the given points.
  const std::vector<int>& order() const { return order_; }

 private:
  int at(const std::array<int, 3>& cell) const;
  // Returns bridged(). beside: gets the points of bridge(), unless it is null.
  bool find_bridge(int i, int face, std::vector<int>* beside) const;
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
