// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A bond is the cement between two grains. Its record has origin and axes of its coordinates, its grains and its lattice of points, all
// as at its creation, and its state. A row of the table of bonds is a record. The table is the same on every rank.
//
// A bond has its own axes. So lattice and grid lie along the line of centres, whatever its direction in the box, and
// bonds of one shape have the same response and the same cost. Points, nodes and links of a bond are stored in these
// axes unless a comment says otherwise. Values are rotated into the axes of the box where cement meets grains
// (BondEnds), for gravity, and for output. Lengths, areas and volumes are in the units of the script.
#ifndef MPDEM_MPM_BOND_RECORD_H
#define MPDEM_MPM_BOND_RECORD_H

#include <array>
#include <cmath>

#include "../material/cement_density.h"
#include "../numerics/rotation.h"
#include "../parallel/key.h"
#include "../parallel/record.h"

namespace mpdem {

// How fix mpm set the material frames of the points of a bond.
enum class AxisRule { none, radial, bond, global };

// Materials of a scene, with that of fix mpm.
constexpr int kMostMaterials = 256, kSeveralMaterials = -1;

struct BondRecord {
  int grain[2] = {0, 0};                                    // tags, ascending
  double origin[3] = {0, 0, 0};                             // origin of the coordinates of the bond, in the box
  double axes[4] = {1, 0, 0, 0};                            // quaternion, rotates from the axes of the bond to those of the box
  double radius[2] = {0, 0};                                // radii of the grains
  double centre[2][3] = {{0, 0, 0}, {0, 0, 0}};             // centres of the grains, from the origin
  double orientation[2][4] = {{1, 0, 0, 0}, {1, 0, 0, 0}};  // orientations of the grains at creation, to the axes of the bond
  double shift[2][3] = {{0, 0, 0}, {0, 0, 0}};              // shift from unwrapped coordinates of LIGGGHTS to those of the bond
  double attached_area[2] = {0, 0};
  double grain_E[2] = {0, 0}, grain_nu[2] = {0, 0};  // elasticity of the grains; E = 0: rigid
  double patch[2][2] = {{0, 0}, {0, 0}};  // least and largest angle of the attached surface from the line of centres; 0: not known
  double box[3] = {0, 0, 0};              // period of the box, 0 where there is none; shifts are multiples of it
  AxisRule axis_rule = AxisRule::none;    // none: no material frames yet
  double axis[3] = {0, 0, 0};             // direction of its axis, in the box
  bool in_motion = false;                 // a step was taken; displacements are those of the nodes
  bool condensed = false;                 // displacements follow from those of the grains, see coupling/condensed_bond.h
  double rest_time = 0.0;                 // time for which its pieces have been at rest, see cement/step/condensing.h
  double volume = 0;
  double own_volume = 0, own_mass = 0;  // of its points whose material has a density of its own: volume and mass
  double spacing = 0;                   // spacing of the lattice of points
  double lattice[3] = {0, 0, 0};        // a corner of the lattice, in reference coordinates
  bool regular = true;                  // points of full cells lie in the middle of their cells
  double thickness = 0;                 // largest thickness of the cement between the grains; 0: film alone
  int points = 0;
  int material = 0;               // number of the material of all its points, see Law::of_material(); kSeveralMaterials: of several
  int point_template = 0;         // number of its point template, from 1, until its points are made (point_template.h); else 0
  bool wants_points = false;      // points must be made before the next step
  int home = 0;                   // 1 + rank that has its points; 0: each point is on the rank of its position (cement/bond/work_shares.h)
  bool left[2] = {false, false};  // the grain left the scene, see cement/step/departures.h

  // True if the grain is in the scene and may have cement of this bond. A bond without points needs no grain: the ID of
  // its grain may belong to a later atom.
  bool has_grain(int side) const { return points > 0 && !left[side]; }
  // True if cells do not resolve the cement between the grains, which is a seam (geometry/film_fill.h).
  bool is_thinner_than(double cell) const { return thickness > 0.0 && thickness < cell; }

  double mass(const CementDensity& density) const { return CementVolume{volume, own_volume, own_mass}.mass(density); }

  // See parallel/record.h.
  template <class Self, class Visitor>
  static constexpr void describe(Self& b, Visitor& visit) {
    visit("the ID of its first grain", b.grain[0], from(1.0, kLargestInt));
    visit("the ID of its second grain, the larger one,", b.grain[1],
          from(b.grain[0] < kLargestInt ? b.grain[0] + 1.0 : kLargestInt, kLargestInt));
    visit("its origin", b.origin, kFinite);
    visit.rotation("its axes", b.axes);
    visit("the radius of a grain", b.radius, kPositive);
    visit("the centre of a grain", b.centre, kFinite);
    for (auto& q : b.orientation) visit.rotation("the orientation of a grain", q);
    visit("the shift of a grain", b.shift, kFinite);
    // Patches of point files are flat, so their areas may sum to slightly more than that of the sphere.
    for (int s = 0; s < 2; ++s) visit("an attached area", b.attached_area[s], from(0.0, 1.1 * 4.0 * M_PI * b.radius[s] * b.radius[s]));
    visit("Young's modulus of a grain", b.grain_E, kNotNegative);
    visit("Poisson's ratio of a grain", b.grain_nu, from(-1.0, 0.5));
    for (auto& angles : b.patch) visit("an angle of an attached surface", angles, from(0.0, 3.15));
    visit("the period of the box", b.box, kNotNegative);
    visit("the rule of its axis", b.axis_rule, from(0, static_cast<int>(AxisRule::global)));
    visit("the direction of its axis", b.axis, kFinite);
    visit("'is in motion'", b.in_motion);
    visit("'is condensed'", b.condensed);
    visit("the time its pieces were at rest", b.rest_time, kNotNegative);
    visit("its volume", b.volume, kNotNegative);
    visit("its volume of cement with a density of its own", b.own_volume, kNotNegative);
    visit("the mass of its cement with a density of its own", b.own_mass, kNotNegative);
    // Across the grains there are at most as many cells as an int can count.
    const double widest = 2.0 * (b.radius[0] + b.radius[1]);
    visit("its spacing", b.spacing, from(1e-8 * widest, widest));
    visit("the corner of its lattice", b.lattice, from(-1e3 * widest, 1e3 * widest));
    visit("'is regular'", b.regular);
    visit("its thickness", b.thickness, from(0.0, widest));
    visit("its number of points", b.points, kCount);
    visit("its template", b.point_template, kCount);
    visit("the number of its material", b.material, from(kSeveralMaterials, kMostMaterials - 1));
    visit("'wants points'", b.wants_points);
    visit("the rank that has its points", b.home, kCount);
    for (auto& l : b.left) visit("'has left' of a grain", l);
  }
};

// Position of the middle of the gap on the line of centres: distance from the first centre over the distance of the centres.
inline double share_to_middle(const BondRecord& record, double distance) {
  return 0.5 + 0.5 * (record.radius[0] - record.radius[1]) / distance;
}
inline Mat3<double> axes_of(const BondRecord& record) { return rotation_of(record.axes); }
// Converts coordinates of a bond to those of the box. axes: axes_of(record).
inline std::array<double, 3> position_in_box(const BondRecord& record, const Mat3<double>& axes, const double* X) {
  std::array<double, 3> x = turned(axes, X);
  for (int d = 0; d < 3; ++d) x[d] = record.origin[d] + x[d];
  return x;
}

inline int lattice_cell(const BondRecord& record, int d, double X) {
  return static_cast<int>(std::floor((X - record.lattice[d]) / record.spacing));
}

// Distance of X from the surface of grain 0 or 1 of the bond, negative inside the grain.
inline double above_grain(const BondRecord& record, int side, const double* X) {
  double r2 = 0.0;
  for (int d = 0; d < 3; ++d) r2 += (X[d] - record.centre[side][d]) * (X[d] - record.centre[side][d]);
  return std::sqrt(r2) - record.radius[side];
}

// Distance of X from the surface of grain 1, less that from grain 0.
inline double nearer_to_first(const BondRecord& record, const double* X) { return above_grain(record, 1, X) - above_grain(record, 0, X); }

inline double rounding_of_positions(const BondRecord& record) { return 1e-6 * record.spacing; }
// True if both surfaces are equally near up to rounding.
inline bool is_equidistant(const BondRecord& record, double nearer_to_first) {
  return std::fabs(nearer_to_first) <= rounding_of_positions(record);
}

// The grain (0 or 1) with the smaller coordinate along that axis of the bond that is nearest to the line of centres,
// the first of equally near ones (geometry/bond_axes.h). So the result does not depend on the order of the grains.
inline int grain_behind(const BondRecord& record) {
  constexpr double kAlike = 1e-3;
  double ahead[3], square = 0.0;
  for (int d = 0; d < 3; ++d) {
    ahead[d] = record.centre[1][d] - record.centre[0][d];
    square += ahead[d] * ahead[d];
  }
  int nearest = 0;
  for (int d = 1; d < 3; ++d)
    if (std::fabs(ahead[d]) > std::fabs(ahead[nearest]) + kAlike * std::sqrt(square)) nearest = d;
  return ahead[nearest] < 0.0;
}

// The grain (0 or 1) whose surface is nearer; grain_behind() in the middle.
inline int nearer_grain(const BondRecord& record, double nearer_to_first) {
  return is_equidistant(record, nearer_to_first) ? grain_behind(record) : nearer_to_first < 0.0;
}

// The points of a bond are in layers. Each layer has nodes of its own, which are a field of the grid. The layer of a
// point decides which phantom nodes it uses (fracture/phantom_nodes.h). Where nodes are not split
// (cement/failure/node_splitting.h), layers are the pieces of a separated bond: layer 0 stays with grain 0, layer 1
// with grain 1, and others are loose. A field has room for as many bonds as an int counts. A layer with 27 nodes takes
// some 10 kB, so memory runs out before the layers do.
constexpr int kMaxLayers = 1 << kLayerBits;
inline Field field_of(int row, int layer) { return row | static_cast<Field>(layer) << kRowBits; }
inline int layer_of_field(Field field) { return static_cast<int>(field >> kRowBits); }
inline int row_of(Field field) { return static_cast<int>(field & ((Field{1} << kRowBits) - 1)); }

}  // namespace mpdem

#endif
