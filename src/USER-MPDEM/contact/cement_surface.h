// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The outer surface of the cement of a bond, for its contact with other bodies (piece_contact.h). The cement is divided
// into two pieces. Each moves with one grain as a rigid body: in a bond that still holds, the points nearer to that
// grain; in a separated bond, the points that are attached to it. The surface consists of those points that lack a
// neighbour in the lattice in a direction in which there is no grain of the piece. A surface point is a small sphere
// with the volume share of its point: its radius is half of the cube root of the volume, its area the square of this
// root. A column of a film (coupling/film.h) is a surface point only where the bond is separated. Its sphere reaches to
// both grains.
//
// Failed points belong to the surface: crushed cement fills a crack.
//
// A fragment that is attached to no grain is a piece by itself. It moves with its nodes (cement/bond/fragment_bodies.h),
// and touches both grains of its bond. Its axes are those of its bond at creation, which it carries along.
#ifndef MPDEM_CONTACT_CEMENT_SURFACE_H
#define MPDEM_CONTACT_CEMENT_SURFACE_H

#include <vector>

#include "../mpm/bond_record.h"
#include "../parallel/key.h"
#include "../parallel/record.h"

namespace mpdem {

// A point of the cement at its creation, from the origin of the bond and in its axes.
struct PointOfCement {
  double X[3] = {0, 0, 0}, volume = 0.0;
  int side = 0;            // grain (0 or 1) of the piece; 2 and more: a fragment
  double thickness = 0.0;  // of a column of a film: its length from grain to grain; 0: a point of the lattice
  int tag = 0;
};

// X and normal are in axes fixed in the grain, X from its centre. The normal points out of the cement.
struct SurfacePoint {
  double X[3] = {0, 0, 0}, normal[3] = {0, 0, 0};
  double radius = 0.0, area = 0.0;

  template <class Self, class Visitor>
  static constexpr void describe(Self& p, Visitor& visit) {
    visit("the position of a surface point", p.X, kFinite);
    visit("the normal of a surface point", p.normal, kFinite);
    visit("the radius of a surface point", p.radius, kFinite);
    visit("the area of a surface point", p.area, kNotNegative);
  }
};

// Fragments have tags of bodies as grains do, from the largest number downwards.
constexpr int kMostFragments = 1 << 20;
inline int tag_of_fragment(int n) { return static_cast<int>(kLargestInt) - n; }
inline bool is_fragment(int tag) { return tag > tag_of_fragment(kMostFragments); }

struct CementPiece {
  int row = 0, side = 0;     // side: grain (0 or 1) of the bond; 2 and more: a fragment
  int grain = 0, other = 0;  // tags: of the body that it moves with, and of the other grain of the bond
  int second = 0;            // a fragment has both grains of its bond in `other` and here; else 0
  bool apart = false;        // the bond is separated, so the piece touches the other grain and the other piece of its bond
  int size = 0, held = 0;    // number of its points and of its nodes
  double spacing = 0.0;      // of the lattice
  // Centre and orientation of the other grain when the cement was made, from the centre and in the axes of its own grain.
  double other_at[3] = {0, 0, 0}, other_turned[4] = {1, 0, 0, 0};
  std::vector<SurfacePoint> points;
  std::vector<Key> nodes;  // of a fragment, ascending
  // A sphere that contains the surface, from the centre of the grain, in axes fixed in it. Not in a record.
  double middle[3] = {0, 0, 0}, reach = 0.0;
  bool fresh = true;  // made since the last search for contacts

  bool is_loose() const { return side > 1; }
  bool is_bonded_to(int tag) const { return tag == other || tag == second; }
  void find_bounds();
  // Without the points and the nodes.
  template <class Self, class Visitor>
  static constexpr void describe(Self& p, Visitor& visit) {
    visit("the bond of a piece", p.row, kCount);
    visit("the side of a piece", p.side, kCount);
    visit("the grain of a piece", p.grain, kCount);
    visit("the other grain of a piece", p.other, kCount);
    visit("the second grain of a fragment", p.second, kCount);
    visit("'is apart' of a piece", p.apart);
    visit("the number of points of a piece", p.size, kCount);
    visit("the number of nodes of a piece", p.held, kCount);
    visit("the spacing of a piece", p.spacing, kPositive);
    visit("the place of the other grain of a piece", p.other_at, kFinite);
    visit.rotation("the orientation of the other grain of a piece", p.other_turned);
  }
};

// Returns the pieces of a bond that have surface points. points: all points of the bond, in ascending order of their tags.
// fragments: the nodes of each fragment, in the order of their sides.
std::vector<CementPiece> pieces_of(const BondRecord& record, int row, const std::vector<PointOfCement>& points, bool apart,
                                   const std::vector<std::vector<Key>>& fragments = {});

}  // namespace mpdem

#endif
