// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Places on the surfaces of grains that let go of the cement and may still touch it: unilateral contact with Coulomb
// friction. The grain is a sphere, so its surface is the same wherever the cement slides to, and slides may have any
// length. With q the vector from the centre of the grain to the place in the cement, n = q/|q|, r the distance at which
// they touch, A the area and R the rotation of the grain:
//
//   gap      g = |q| - r                          p = kn <-g>, the pressure
//   stick    e = d - (d.n) n, d = q - R s         s: where the place would be without friction's force, in the frame of the grain
//   slip     |kt e| <= mu p; else s moves along e until it is so, which takes the energy A mu p |slip|,
//            all along e in the step in which the gap opens
//   force    f = A (p n - kt e) on the cement, -f and -q x f on the grain
//
// A place is opened where its link lets go, with s = R^T q when it closes. As long as the point of the link holds, the
// place follows the foot of the link. A point that failed carries no stress, so its place bears nothing. The place then
// moves to the nearest point that holds (ContactPoint), half a spacing before it towards the grain. Failed material
// between them keeps its thickness: r is the distance of the new place in the reference, or the present distance if
// that is less. So nothing is pushed at once. A point follows one place of each grain, which has the area of all places
// that came to it. Points that are equally near share a place. A closed place keeps its force.
//
// The stiffness is that of the links, or PenaltyParameters::most_contact if that is less. Where a place touches or is
// about to, it asks for added mass as they do (added_mass.h), but twice as much. A node of mass m that comes back from a
// one-sided spring k is as fast as it came if k dt^2 <= 2 m. At 4 m, where a two-sided spring is still stable, it may
// come back with three times its energy.
#ifndef MPDEM_COUPLING_DEBONDED_CONTACT_H
#define MPDEM_COUPLING_DEBONDED_CONTACT_H

#include <array>
#include <utility>
#include <vector>

#include "../mpm/bond_mechanism.h"
#include "../mpm/grid.h"
#include "../mpm/point_store.h"
#include "bond_ends.h"
#include "penalty_links.h"

namespace mpdem {

// `side` always points to the first of the two sides of the bond. The second follows it. Energies are those of this rank.
class DebondedContact : public BondMechanism {
 public:
  DebondedContact() = default;
  void points_failed(const BondAtWork& b, const std::vector<int>& slots, const std::vector<int>& links, Losses& losses) override;
  void links_debonded(const BondAtWork& b, const std::vector<int>& links, Losses& losses) override;
  void add_force(const BondAtWork& b, Losses& losses) override;
  void add_energy(const PointStore& points, const Grid& grid, const BondEnd* ends, double& of_points, double& of_coupling) const override;
  std::string trouble(const PointStore& points, Grid& grid, long step) const override;

  // Lays out the places of the store on a grid that has the nodes of all points.
  DebondedContact(const PointStore& points, const BondRecord& record, const PenaltyParameters& parameters, const Grid& grid);

  // Ends the places of points that failed (slots), which bear nothing any more. Returns the energy that is released, by
  // the rule of PenaltyLinks::debond().
  double end(PointStore& points, const Grid& grid, const BondEnd* ends, const std::vector<int>& failed, double dt);
  // Opens the places of links of the store that let go in the step dt, which ends now. A point may have the place of another one
  // already; areas add up. Returns the energy that the new places have when their force begins. A force that begins within a step
  // acts with its new value over half of the motion of that step. So it is the present energy less what it gained over that half.
  double open(PointStore& points, const BondRecord& record, const Grid& grid, const BondEnd* ends, const std::vector<int>& links,
              double dt);
  // Opens the places of all links that had let go when the cement was made.
  void open_all(PointStore& points, const BondRecord& record, const Grid& grid, const BondEnd* ends);

  // Updates the places for the present positions. Returns the energy that friction took. Unchanged positions change nothing.
  double follow(PointStore& points, const Grid& grid, const BondEnd* ends);
  // Adds the forces of the present positions to nodes and grains.
  void add_force(Grid& grid, BondEnd* ends) const;
  // Does both, place by place.
  double follow_and_add_force(PointStore& points, Grid& grid, BondEnd* ends);
  // Adds the energy that the contact stores.
  void add_energy(const Grid& grid, const BondEnd* ends, double& energy) const;
  // Gives added mass to places that touch, or may touch within the time `soon`, and takes it from the others. Returns
  // true if that of a place changes. Added mass ties the motion of the cement to that of the grain, so places that are
  // apart must have none. Until this call, places that open or move on have none of their own: the links that let go
  // still have theirs. The grains are where they are at the end of the step dt, the nodes where they were before it.
  bool update_added_mass(PointStore& points, const Grid& grid, const BondEnd* ends, double dt, double soon);
  void add_stiffness(const Grid& grid, const BondEnd* ends, double* penalty) const override;
  // Largest depth of a place inside its grain, at the last follow().
  double deepest() const { return deepest_; }

  // A place that looks for a point that holds, and what it brings to that point.
  struct OrphanedContact {
    int row, grain, tag;      // of the point that failed
    double area, X[3], n[3];  // X: place on the surface of the grain in the reference, n: its normal
    double spacing;           // of the points
  };
  // Places whose points failed. They stay in the store until move() drops them. There are none if take_change() is false: no
  // point failed and no place opened since its last call.
  bool take_change() { return std::exchange(changed_, false); }
  std::vector<OrphanedContact> movers(const PointStore& points, const BondRecord& record) const;
  // The points of the store that hold and are nearest to the place on the surface. Distances across the normal count three times.
  // Points that are equally near share the place, since none of them comes first in a bond that is its own mirror image.
  struct Found {
    double far = 0;          // the distance counted so, its square in whole parts of kTie: rounding makes no difference between points
    std::vector<int> slots;  // ascending; empty if no point holds
    static constexpr double kTie = 1.0471e-6;  // share of the square of the spacing; no distance in a lattice is a whole number of these
  };
  static Found nearest(const PointStore& points, const OrphanedContact& m);
  // Moves places to the slots of `arrivals`, and drops the failed ones that `gone` names. Returns the increase of stored energy.
  struct Arrival {
    OrphanedContact mover;
    int slot;
    double share;  // of the area
  };
  double move(PointStore& points, const BondRecord& record, const Grid& grid, const BondEnd* ends, const std::vector<Arrival>& arrivals,
              std::vector<std::array<int, 2>> gone);  // tag and grain

  bool empty() const { return blocks_.empty(); }
  std::size_t memory_usage() const override;

 private:
  struct Block {
    vd X[3], area, inert_area, radius, stick[3], slides;
    vint base[3];
    int contact[kLanes];  // place in the store; -1: empty
    int side;
    std::uint8_t taken, connected, closed;                      // one bit for each lane; holds: the point has not failed
    bool is_dead() const { return (connected | closed) == 0; }  // all its points failed, so it bears nothing any more
  };
  // Contact of eight places.
  struct Touch {
    vd q[3], n[3], e[3], gap;
  };
  const int* columns(const Block& b) const { return &columns_[kLanes * (&b - blocks_.data()) * columns_of_cell_]; }
  void touch(const Block& b, const Grid& grid, const BondEnd& s, Touch& t) const;
  static void find_stretch(const Block& b, const BondEnd& s, Touch& t);     // e of the place where q and n are
  double follow(Block& b, PointStore& points, const BondEnd& s, Touch& t);  // t: of this step; e after the slip
  void add_force(const Block& b, const Touch& t, Grid& grid, BondEnd& s) const;
  // Velocity of the places against the grain.
  void find_velocity(const Block& b, const Grid& grid, const BondEnd& s, const Touch& t, vd* v, vd* of_grain) const;
  vd energy(const Block& b, const Touch& t) const;
  // Energy of closed places whose force ends or begins in the step dt: half of the product of force and stretch at both ends of the step.
  vd energy_across(const Block& b, const Touch& t, const Grid& grid, const BondEnd& s, double dt) const;
  void lay_out(const PointStore& points, const BondRecord& record, const Grid& grid);
  // Takes up new places, and lays out all.
  void take(PointStore& points, const BondRecord& record, const Grid& grid, std::vector<ContactPoint> opened);

  PenaltyParameters p_;
  int columns_of_cell_ = 0;
  double inverse_h_ = 0, deepest_ = 0;
  bool changed_ = true;  // points may have come that failed on another rank
  std::vector<Block> blocks_;
  std::vector<int> columns_;  // columns of the lanes of the blocks, see Grid
};

}  // namespace mpdem

#endif
