// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A body is the cement between two grains as it was created: origin and axes of its coordinates, its grains at that
// time, and its lattice of points. The table of bodies is the same on every rank.
//
// Coordinates of a body have their own axes. So lattice and grid lie along the line of centres, whatever its direction
// in the box, and bonds of one shape have the same answer and the same cost. Everything stored of a body, its points,
// nodes and links is in these axes, unless its comment says otherwise. Values are turned into the axes of the box where
// cement meets grains (BondEnds), for gravity, and for output.
#ifndef MPDEM_MPM_BOND_RECORD_H
#define MPDEM_MPM_BOND_RECORD_H

#include <array>
#include <cmath>

#include "../numerics/rotation.h"
#include "../parallel/key.h"
#include "../parallel/record.h"

namespace mpdem {

// The rule by which fix mpm gave the points of a body their frames.
enum class AxisRule { none, radial, bond, global };

struct BondRecord {
  int grain[2] = {0, 0};                                    // tags, ascending
  double origin[3] = {0, 0, 0};                             // origin of its coordinates, in the box
  double turn[4] = {1, 0, 0, 0};                            // rotation from its axes to those of the box
  double radius[2] = {0, 0};                                // of the grains
  double centre[2][3] = {{0, 0, 0}, {0, 0, 0}};             // centres of the grains, from the origin
  double orientation[2][4] = {{1, 0, 0, 0}, {1, 0, 0, 0}};  // orientation of the grains at creation, to the axes of the body
  double shift[2][3] = {{0, 0, 0}, {0, 0, 0}};              // from unwrapped coordinates of LIGGGHTS to coordinates of the body
  double attached_area[2] = {0, 0};
  double box[3] = {0, 0, 0};            // period of the box, 0 where there is none; shifts are multiples of it
  AxisRule axis_rule = AxisRule::none;  // none: no frames yet
  double axis[3] = {0, 0, 0};           // direction of its axis, in the axes of the box
  bool in_motion = false;               // a step was taken, and displacements are those of nodes
  bool condensed = false;               // displacements follow those of the grains, see coupling/condensed_bond.h
  double calm = 0.0;                    // time for which its pieces were found at rest, see cement/step/condensing.h
  double volume = 0;
  double spacing = 0;             // spacing of the lattice of points
  double lattice[3] = {0, 0, 0};  // a corner of the lattice, reference coordinates
  bool regular = true;            // points of full cells lie in the middle of their cells
  double thickness = 0;           // largest thickness of the cement between the grains; 0: all of it is film
  int points = 0;
  int pattern = 0;                // number of its pattern, from 1, while its points are not made yet (point_template.h); else 0
  bool wants_points = false;      // its points must be made before the next step
  int home = 0;                   // rank that has its points, counted from 1; 0: points go by their places, see cement/bond/work_shares.h
  bool left[2] = {false, false};  // the grain left the scene, see cement/step/departures.h

  // Is the grain still there, and may it have cement of this body? A body without points asks for no grain. Its IDs may be those
  // of later atoms.
  bool has_grain(int side) const { return points > 0 && !left[side]; }

  // See parallel/record.h.
  template <class Self, class Visitor>
  static constexpr void describe(Self& b, Visitor& visit) {
    visit("the ID of its first grain", b.grain[0], from(1.0, kLargestInt));
    visit("the ID of its second grain, the larger one,", b.grain[1],
          from(b.grain[0] < kLargestInt ? b.grain[0] + 1.0 : kLargestInt, kLargestInt));
    visit("its origin", b.origin, kFinite);
    visit.rotation("its axes", b.turn);
    visit("the radius of a grain", b.radius, kPositive);
    visit("the centre of a grain", b.centre, kFinite);
    for (auto& q : b.orientation) visit.rotation("the orientation of a grain", q);
    visit("the shift of a grain", b.shift, kFinite);
    // Patches of point files are flat, so their areas may add up to a little more than that of the sphere.
    for (int s = 0; s < 2; ++s) visit("an attached area", b.attached_area[s], from(0.0, 1.1 * 4.0 * M_PI * b.radius[s] * b.radius[s]));
    visit("the period of the box", b.box, kNotNegative);
    visit("the rule of its axis", b.axis_rule, from(0, static_cast<int>(AxisRule::global)));
    visit("the direction of its axis", b.axis, kFinite);
    visit("'is in motion'", b.in_motion);
    visit("'is condensed'", b.condensed);
    visit("the time its pieces were at rest", b.calm, kNotNegative);
    visit("its volume", b.volume, kNotNegative);
    // Across the grains there are at most as many cells as an int can count.
    const double widest = 2.0 * (b.radius[0] + b.radius[1]);
    visit("its spacing", b.spacing, from(1e-8 * widest, widest));
    visit("the corner of its lattice", b.lattice, from(-1e3 * widest, 1e3 * widest));
    visit("'is regular'", b.regular);
    visit("its thickness", b.thickness, from(0.0, widest));
    visit("its number of points", b.points, kCount);
    visit("its pattern", b.pattern, kCount);
    visit("'wants points'", b.wants_points);
    visit("the rank that has its points", b.home, kCount);
    for (auto& l : b.left) visit("'has left' of a grain", l);
  }
};

// Share of the way from the first centre to the second at which the middle of the gap lies. distance: of the centres.
inline double share_to_middle(const BondRecord& record, double distance) {
  return 0.5 + 0.5 * (record.radius[0] - record.radius[1]) / distance;
}
inline Mat3<double> axes_of(const BondRecord& record) { return rotation_of(record.turn); }
// Converts coordinates of a body to those of the box. axes: axes_of(body).
inline std::array<double, 3> position_in_box(const BondRecord& record, const Mat3<double>& axes, const double* X) {
  std::array<double, 3> x = turned(axes, X);
  for (int d = 0; d < 3; ++d) x[d] = record.origin[d] + x[d];
  return x;
}

inline int lattice_cell(const BondRecord& record, int d, double X) {
  return static_cast<int>(std::floor((X - record.lattice[d]) / record.spacing));
}

// Distance of X from the surface of a grain, negative inside it.
inline double above_grain(const BondRecord& record, int side, const double* X) {
  double r2 = 0.0;
  for (int d = 0; d < 3; ++d) r2 += (X[d] - record.centre[side][d]) * (X[d] - record.centre[side][d]);
  return std::sqrt(r2) - record.radius[side];
}

// How much nearer X is to the surface of the first grain than to that of the second.
inline double nearer_to_first(const BondRecord& record, const double* X) { return above_grain(record, 1, X) - above_grain(record, 0, X); }

inline double rounding_of_positions(const BondRecord& record) { return 1e-6 * record.spacing; }
// True if both surfaces are equally near, up to rounding.
inline bool in_the_middle(const BondRecord& record, double nearer_to_first) {
  return std::fabs(nearer_to_first) <= rounding_of_positions(record);
}

// The grain (0 or 1) that is behind along the axis nearest to the line of centres, in the axes of the body. Of axes equally
// near it is the first (geometry/bond_axes.h). So the result does not depend on the order of the grains.
inline int side_behind(const BondRecord& record) {
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

// The grain (0 or 1) whose surface is nearer. In the middle it is the one behind.
inline int nearer_side(const BondRecord& record, double nearer_to_first) {
  return in_the_middle(record, nearer_to_first) ? side_behind(record) : nearer_to_first < 0.0;
}

// A body has parts. Each part has its own nodes, which are a field of the grid. Parts say which copies of nodes their
// points have (fracture/phantom_nodes.h). Where nodes have no copies (cement/failure/node_splitting.h), they are the pieces of a body that
// came apart: part 0 stays with the first grain, part 1 with the second, and others are loose.
// There may be as many bonds as an int counts. A part with 27 nodes takes some 10 kB. So memory ends before a bond runs out of parts.
constexpr int kMaxLayers = 1 << kLayerBits;
inline Field field_of(int row, int layer) { return row | static_cast<Field>(layer) << kRowBits; }
inline int layer_of_field(Field field) { return static_cast<int>(field >> kRowBits); }
inline int row_of(Field field) { return static_cast<int>(field & ((Field{1} << kRowBits) - 1)); }

}  // namespace mpdem

#endif
