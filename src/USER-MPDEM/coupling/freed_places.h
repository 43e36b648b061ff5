// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Places of the grains' surfaces that let go of the cement, and still touch it: unilateral contact with Coulomb friction. The grain is a
// sphere, so its surface is the same wherever the cement slides to, and slides may be of any length. With q the vector from the centre
// of the grain to the place in the cement, n = q/|q|, r the distance at which they touch, A the area, R the rotation of the grain:
//
//   gap      g = |q| - r                          p = kn <-g>, the pressure
//   stick    e = d - (d.n) n, d = q - R s         s: where the place would be without friction's force, in the frame of the grain
//   slip     |kt e| <= mu p; else s moves along e until it is so, which takes the energy A mu p |slip|,
//            all along e in the step in which the gap opens
//   force    f = A (p n - kt e) on the cement, -f and -q x f on the grain
//
// A place is opened where its link lets go, with s = R^T q when it closes. As long as the point of the link holds, it follows the foot of the
// link. A point that failed carries no stress, so its place bears nothing. It goes on to the nearest point that holds (FreedPlace),
// half a spacing before it towards the grain. What failed between them keeps its thickness there: r is the distance of that place in the
// reference, or the present one if that is less, so nothing is pushed at once. A point follows one place of either grain, with the area
// of all that came to it. One that is closed keeps its force.
//
// The stiffness is that of the links, and asks for added mass as they do (added_mass.h), but twice: a node of mass m that comes back from a
// spring k which acts on one side alone is as fast as it came if k dt^2 <= 2 m. With 4 m, at which a spring of both sides is stable yet, it
// may come back with three times its energy.
#ifndef MPDEM_FREED_PLACES_H
#define MPDEM_FREED_PLACES_H

#include <array>
#include <vector>

#include "../mpm/grid.h"
#include "../mpm/point_store.h"
#include "grain_sides.h"
#include "penalty_links.h"

namespace mpdem {

// `side` is always the first of the two sides of the bond, the second is behind it. Energies are those of this rank.
class FreedPlaces {
 public:
  FreedPlaces() = default;
  // Lays out the places of the store on a grid that has the nodes of all points.
  FreedPlaces(const PointStore& points, const Body& body, const PenaltyParameters& parameters, const Grid& grid);

  // The points of these slots failed, so their places bear nothing any more. Answers the energy that is released, by the rule of
  // PenaltyLinks::let_go().
  double end(PointStore& points, const Grid& grid, const GrainSide* side, const std::vector<int>& failed, double dt);
  // Opens the places of links that let go: those of slots that failed, and others of the store. Answers the energy that they store.
  double open(PointStore& points, const Body& body, const Grid& grid, const GrainSide* side, const std::vector<int>& failed,
              const std::vector<int>& links);
  // Of links that had let go when the cement was made.
  void open_all(PointStore& points, const Body& body, const Grid& grid, const GrainSide* side);

  // What the present positions do to the places. Answers the energy that friction took. Positions that stay change nothing.
  double follow(PointStore& points, const Grid& grid, const GrainSide* side);
  // Force of the present positions on nodes and grains.
  void add_force(Grid& grid, GrainSide* side) const;
  // Adds what the contact stores.
  void add_energy(const Grid& grid, const GrainSide* side, double& energy) const;
  // Gives added mass to all places from here on. Those that open or go on have none of their own until then: the links that let go still have theirs.
  void give_inertia(PointStore& points);
  // As PenaltyLinks::add_stiffness().
  void add_stiffness(const Grid& grid, const GrainSide* side, double* penalty) const;
  // How far any place is inside its grain, at the last follow().
  double deepest() const { return deepest_; }

  // A place that looks for a point that holds, and what it brings there.
  struct Mover {
    int body, grain, tag;  // of the point that failed
    double area, X[3], n[3];  // n: normal of the grain's surface in the reference
    double spacing;           // of the points
  };
  // Places whose points failed; they stay until they are dropped.
  std::vector<Mover> movers(const PointStore& points, const Body& body) const;
  // The point of the store that holds and is nearest: distances across the normal count three times. -1: none holds.
  struct Found {
    double distance = 0;  // square, in whole parts of kTie: points of a lattice that are equally far shall not go by rounding, which goes with the units
    int tag = -1, slot = -1;
    static constexpr double kTie = 1.0471e-6;  // of the square of the spacing; no distance of a lattice is a whole number of these
    bool nearer_than(const Found& o) const { return tag >= 0 && (o.tag < 0 || distance < o.distance || (distance == o.distance && tag < o.tag)); }
  };
  static Found nearest(const PointStore& points, const Mover& m);
  // Places come to these slots, and those whose points failed and that are named by `gone` go. Answers what is stored more than before.
  struct Arrival {
    Mover mover;
    int slot;
  };
  double move(PointStore& points, const Body& body, const Grid& grid, const GrainSide* side, const std::vector<Arrival>& arrivals,
              const std::vector<std::array<int, 2>>& gone);  // tag and grain

  bool empty() const { return blocks_.empty(); }
  std::size_t memory_usage() const;

 private:
  struct Block {
    vd X[3], area, inert_area, radius, stick[3], rubs;
    vint base[3];
    int place[kLanes];  // of the store; -1: empty
    int side;
    std::uint8_t taken, holds, closed;  // a bit a lane; holds: the point has not failed
  };
  // Of eight places.
  struct Touch {
    vd q[3], n[3], e[3], gap;
  };
  const int* columns(const Block& b) const { return &columns_[kLanes * (&b - blocks_.data()) * columns_of_cell_]; }
  void touch(const Block& b, const Grid& grid, const GrainSide& s, Touch& t) const;
  vd energy(const Block& b, const Touch& t) const;
  void lay_out(const PointStore& points, const Body& body, const Grid& grid);
  double take(PointStore& points, const Body& body, const Grid& grid, const GrainSide* side, std::vector<FreedPlace> opened, bool just_now);

  PenaltyParameters p_;
  int columns_of_cell_ = 0;
  double inverse_h_ = 0, deepest_ = 0;
  std::vector<Block> blocks_;
  std::vector<int> columns_;  // of the lanes of the blocks, see Grid
};

}  // namespace mpdem

#endif
