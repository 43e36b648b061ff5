// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Material points of a shape: one for each cell of a cubic lattice along the axes of its coordinates, symmetric about the
// origin, that the shape fills or cuts. A cut cell gives its point the volume and the
// centroid of the part inside (sub-sampled), then all volumes are scaled to the exact
// volume of the shape. The attached surface of each grain is cut by the same lattice:
// every patch goes to the point of its cell with its area and its centroid on the sphere
// (the foot point), scaled to the exact area. Deterministic: every rank that calls this
// gets the same points in the same order.
//
// Where the shape overlaps those of other bodies, its neighbours, material goes to the one whose middle (the
// origin of its coordinates, the middle of the gap) is nearest: cells are cut there too. What is at the same
// distance is shared evenly. So the bodies together fill the union of their shapes, once.
#ifndef MPDEM_LATTICE_FILL_H
#define MPDEM_LATTICE_FILL_H

#include <Eigen/Geometry>
#include <vector>

#include "shape.h"

namespace mpdem {

struct FillPoint {
  Vector3 X = Vector3::Zero();
  double volume = 0;
  int links = 0;
  struct Attachment {
    int side = 0;
    Vector3 foot = Vector3::Zero();
    double area = 0;
    bool attached = true;
    double damage = 0;  // of the link, see coupling/traction_law.h; only points from a file have some
  } link[2];
  // Only points from a file have these.
  Vector3 axis = Vector3::Zero();            // of the elasticity; zero: by the rule of fix mpm
  double damage[6] = {0, 0, 0, 0, 0, 0};     // xx yy zz yz xz xy in the axes of the box
  bool failed = false;
};

struct Neighbour {
  const Shape* shape;
  Vector3 middle;           // where its coordinates start
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  // to its axes
  Vector3 own(const Vector3& x) const { return turn * (x - middle); }
};

// Throws ShapeError if no cell of the lattice is inside, or if there would be more than `most` points.
std::vector<FillPoint> fill_with_points(const Shape& shape, double spacing, double most = 1e8,
                                        const std::vector<Neighbour>& neighbours = {});

}  // namespace mpdem

#endif
