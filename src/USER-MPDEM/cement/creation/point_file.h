// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Material points of a bond from a text file, as measured by X-ray CT or written by write_cement. Lines are comments
// (from # to the end of the line), one line with the names of the columns, and one line a point. Columns, in any order:
//   x y z, volume                      position in the box, reference volume
//   ax ay az                           axis of the elasticity
//   dxx dyy dzz dyz dxz dxy            damage, components in the axes of the box
//   d1 d2 d3 v1x v1y v1z v2x v2y v2z   or principal values and two of their directions
//   failed                             1: carries no stress
//   grain_i grain_j                    IDs of the grains; lines of other pairs are left out
//   area_i area_j                      attached area of the point at the grain of the smaller /
//                                      the larger ID
//   foot_ix foot_iy foot_iz, foot_j.   foot point on the surface (else the nearest one)
//   attached_i attached_j              0: the link to that grain has debonded
//   damage_i damage_j                  damage of that link, for traction laws that know it;
//                                      points that failed may then be attached
// Points lie on a cubic lattice along the axes of the box. They may also lie along those of the bond
// (geometry/bond_axes.h), like points of shapes. Without the area columns, points within `attach` of a surface are
// attached to it with the area V R^2/(r^2 attach), where V is the volume of the point, R the radius of the grain and r
// the distance to its centre. For cement of that thickness this sums up to the area of the sphere.
#ifndef MPDEM_CEMENT_CREATION_POINT_FILE_H
#define MPDEM_CEMENT_CREATION_POINT_FILE_H

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "../../geometry/lattice_fill.h"

namespace mpdem {

struct PointFileOptions {
  int tag[2] = {0, 0};  // tags of the grains, ascending
  double spacing = 0;
  double attach = 0;                // 0: one spacing
  int material = 0, materials = 1;  // number of the material of points where the file has no column of it; how many materials there are
  // Converts a position in the box to coordinates from the middle of the gap, for the nearest periodic image.
  std::function<Vector3(const Vector3&)> to_bond = [](const Vector3& x) { return x; };
};

struct PointCloud {
  std::vector<FillPoint> points;                             // points in the axes of the lattice
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  // rotation from these axes to those of the box
  // Corner of a lattice in which each point has a cell of its own, from the middle of the gap. It is 0 if that is
  // possible, else half a cell beside the points.
  Vector3 corner = Vector3::Zero();
  // Corner of the lattice that has the points of full cells at the centres of its cells, if there is one (`regular`).
  // Otherwise this is `corner`.
  Vector3 lattice = Vector3::Zero();
  bool regular = false;
  double largest_volume = 0;
  double volume = 0, thickness = 0, attached_area[2] = {0, 0};
  // Grains that lines of other pairs name, ascending, with the first such line.
  std::map<int, int> other_grains;
};

// Text with which messages begin: file and line.
std::string line_in_file(const std::string& name, int line);

// Throws ShapeError with the name of the file and the number of the line.
PointCloud read_points(const std::string& text, const std::string& name, const GrainPair& pair, const PointFileOptions& options);

}  // namespace mpdem

#endif
