// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Material points of a shape. There is one for each cell of a cubic lattice that the shape fills or cuts. The lattice
// is along the axes of the coordinates of the shape and symmetric about the origin. A point of a cut cell has the
// volume and the centroid of the inside (sub-sampled). Then all volumes are scaled to the exact volume of the shape.
// The attached surface of each grain is cut by the same lattice: every patch belongs to the point of its cell, with its
// area and its centroid on the sphere (the foot point), scaled to the exact area. Deterministic: every rank that calls
// this gets the same points in the same order.
//
// The shape may overlap those of other bonds, its neighbours. Then material belongs to the bond whose middle (the
// origin of its coordinates, the middle of the gap) is nearest, and cells are cut there too. Material at equal distance
// is shared evenly. So the bonds together fill the union of their shapes once.
#ifndef MPDEM_GEOMETRY_LATTICE_FILL_H
#define MPDEM_GEOMETRY_LATTICE_FILL_H

#include <Eigen/Geometry>
#include <vector>

#include "shape.h"

namespace mpdem {

struct FillPoint {
  Vector3 X = Vector3::Zero();
  double volume = 0;
  int link_count = 0;  // how many of `link` there are
  bool film = false;   // a column of a film, see film_fill.h
  int material = 0;    // number of its material
  struct Attachment {
    int side = 0;
    Vector3 foot = Vector3::Zero();
    double area = 0;
    bool attached = true;
    double damage = 0;  // damage of the link, see coupling/traction_law.h; only points from a file have some
  } link[2];
  // Only points from a file have the next members.
  Vector3 axis = Vector3::Zero();         // axis of the elasticity; zero: from the rule of fix mpm
  double damage[6] = {0, 0, 0, 0, 0, 0};  // xx yy zz yz xz xy in the axes of the bond
  bool failed = false;
};

struct Neighbour {
  const Shape* shape;
  Vector3 middle;                                                      // origin of its coordinates
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();            // rotation to its axes
  Vector3 own(const Vector3& x) const { return turn * (x - middle); }  // x in its coordinates
};

// Share of a shape in the material at x, which must be inside the shape, in its coordinates.
double share_at(const std::vector<Neighbour>& neighbours, const Vector3& x);

// Throws ShapeError if there would be `most` points or more, if the shape is too wide for the numbers of cells (1e9
// along an axis), if no cell of the lattice is inside, if neighbours take all of the cement at the surface of a grain,
// or if the cells do not reach 95 % of the attached area of a grain.
std::vector<FillPoint> fill_with_points(const Shape& shape, double spacing, double most = 1e8,
                                        const std::vector<Neighbour>& neighbours = {});

}  // namespace mpdem

#endif
