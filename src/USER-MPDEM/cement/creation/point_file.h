// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Material points of a bond from a text file, as measured by X-ray CT or written by write_cement. The first line names
// the columns, and each further line has one point. A comment goes from # to the end of its line. Lengths and volumes are
// in the units of the script, damage is from 0 to 1. Columns, in any order:
//   x y z, volume                      position in the box, reference volume
//   ax ay az                           axis of the elasticity
//   dxx dyy dzz dyz dxz dxy            damage, components in the axes of the box
//   d1 d2 d3 v1x v1y v1z v2x v2y v2z   or principal values and two of their directions
//   failed                             1: carries no stress
//   grain_i grain_j                    IDs of the grains; lines of other pairs are left out
//   area_i area_j                      attached area of the point at the grain of the smaller /
//                                      the larger ID
//   foot_ix foot_iy foot_iz            foot point on the surface of grain i; without these columns, the nearest one
//   foot_jx foot_jy foot_jz            the same on grain j
//   attached_i attached_j              0: the link to that grain has debonded
//   damage_i damage_j                  damage of that link, for traction laws that have it. With these columns a failed
//                                      point may be attached, as residue; without them it is not
// Points lie on a cubic lattice along the axes of the box. They may also lie along those of the bond
// (geometry/bond_axes.h), like points of shapes. Without the area columns, points within the distance `attach` of a
// surface are attached to it with the area V R^2/(r^2 attach), where V is the volume of the point, R the radius of the
// grain and r the distance to its centre. V/attach is the area of the point in a layer of the thickness `attach`, and
// R^2/r^2 projects it onto the sphere. Where the cement is thinner than `attach`, its thickness takes that place.
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
  double attach = 0;  // largest distance of attached points from the surface, without area columns; 0: one spacing
  int material = 0;   // number of the material of all points, if the file has no column `material`
  int materials = 1;  // how many materials the scene has
  // Converts a position in the box to coordinates from the middle of the gap, for the nearest periodic image.
  std::function<Vector3(const Vector3&)> to_bond = [](const Vector3& x) { return x; };
};

struct PointCloud {
  std::vector<FillPoint> points;                             // points in the axes of the lattice
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  // rotation from these axes to those of the box
  // A lattice needs a cell of its own for each point. corner: position of its corner from the middle of the gap. It is 0
  // unless two points would share a cell, or a point would lie on a face.
  Vector3 corner = Vector3::Zero();
  // True if there is a lattice with the points of full cells at the centres of its cells. lattice: its corner, or
  // `corner` if there is none.
  bool regular = false;
  Vector3 lattice = Vector3::Zero();
  double largest_volume = 0;  // largest volume of a point
  double volume = 0;          // sum over all points
  double thickness = 0;       // largest thickness of the cement, see BondRecord::thickness
  double attached_area[2] = {0, 0};
  // Grains of other pairs that the file has, ascending, with the number of the first line that names each.
  std::map<int, int> other_grains;
};

// Text with which messages begin: file and line.
std::string line_in_file(const std::string& name, int line);

// Throws ShapeError with the name of the file and the number of the line.
PointCloud read_points(const std::string& text, const std::string& name, const GrainPair& pair, const PointFileOptions& options);

}  // namespace mpdem

#endif
