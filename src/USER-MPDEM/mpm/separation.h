// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Has a bond come apart, and how? The crack is the set of failed points; intact points hold
// together where their lattice cells share a face and, if they are of different sheets (crevice.h), their
// material touches there and a node at which the sheets are joined is in the support of both. A bond is separated when no such piece is
// attached to both grains. Then
// * the cement gets parts that share no nodes: what is attached to the first grain, to the
//   second, and every loose piece of at least kLeastLoose points. Failed points and smaller
//   crumbs go with the nearest of these (in steps from cell to cell) of their part;
// * the separating surface lies where the material that goes with the first grain meets the
//   material that goes with the second: inside the cement, or at a grain where that grain's
//   own links are to material of the other. Where neither grain holds to anything but there is
//   a loose piece, it is the surface of both. Its areas are projected on the plane across the
//   line of centres.
// A bond that holds is described by the same rule: of all paths from grain to grain over intact points, that
// whose most damaged point is the least damaged (minimax path) holds longest. If all points with at least that
// point's damage had failed the bond would be separated; with any more it would hold.
// Serial, on all points of one body; the result does not depend on their order.
#ifndef MPDEM_SEPARATION_H
#define MPDEM_SEPARATION_H

#include <array>
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
  bool attached[2];         // holds to this grain
  double link_area[2];      // projected area of its links, let go or not
};

struct Separation {
  bool separated = false;
  // Of the separating surface, projected: at either grain, and inside.
  double at_grain[2] = {0, 0}, inside = 0;
  // New part of each point, in the order given; without sheets too.
  std::vector<int> part;
  // Tags of the points, ascending, of a path that holds longest: while none of them fails the bond is not
  // separated. And their largest damage.
  std::vector<int> path;
  double path_damage = 0.0;

  double debonded_share() const {
    const double all = at_grain[0] + at_grain[1] + inside;
    return all > 0.0 ? (at_grain[0] + at_grain[1]) / all : 0.0;
  }
};

constexpr int kLeastLoose = 64;

using JoinedNodes = std::vector<std::array<int, 3>>;

// face_area[d]: projected area of a lattice face across direction d. joined: ascending, where there are sheets;
// support: nodes a direction.
Separation separate(const std::vector<CrackPoint>& points, const double* face_area, const JoinedNodes& joined = {}, int support = 0);

// The points as if all with at least this damage had failed, and let go of their grains with that.
std::vector<CrackPoint> failed_from(double damage, std::vector<CrackPoint> points);

}  // namespace mpdem

#endif
