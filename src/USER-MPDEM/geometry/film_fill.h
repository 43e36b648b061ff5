// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The film of a bond: the region of a shape that is too thin for cells. Columns along the line of centres reach from
// grain to grain there. A column is a point with a link to either grain, whose foot points are its ends.
//
// Cells of two spacings cannot resolve the strain where the grains are nearer than that, so the film ends where they
// are two spacings apart. If the rest is narrower than a cell, all of the bond is film. It then has the outline of the
// flat bond of the same volume.
//
// The points do not depend on the spacing. They lie in rings, at the points of a Gauss rule in ln t, where t is the
// thickness: then the sums over A, A t and A/t, which are area, volume and stiffness, converge at once. Each ring has
// kSectors of them.
#ifndef MPDEM_GEOMETRY_FILM_FILL_H
#define MPDEM_GEOMETRY_FILM_FILL_H

#include <vector>

#include "lattice_fill.h"

namespace mpdem {

struct FilmFill {
  double from = 0.0, to = 0.0;            // radii; none if they are equal
  double volume = 0.0, area[2] = {0, 0};  // area: on either grain
  bool all = false;                       // no cells outside of the film
  bool empty() const { return !(to > from); }
};

constexpr double kCellOfPoints = 2.0;  // width of a cell of eight points, in spacings

// Throws ShapeError if the shape cannot be film where it is too thin.
FilmFill film_fill(const Shape& shape, double spacing);

// True if the shape is thinner than a cell everywhere, and ends where it no longer reaches from grain to grain. Then fill_seam() can
// fill it for cells.
bool is_seam(const Shape& shape, double spacing);
// A seam: columns at most a spacing apart, as points that cells take. Each column has one point at either grain. They lie in rings between the
// radii of the flat bond of this inner radius and volume.
std::vector<FillPoint> fill_seam(const Shape& shape, double spacing, const std::vector<Neighbour>& neighbours = {});

// Points of the film, ring by ring. Neighbours take their share of each, as in fill_with_points().
std::vector<FillPoint> fill_film(const GrainPair& pair, const FilmFill& film, const std::vector<Neighbour>& neighbours = {});

}  // namespace mpdem

#endif
