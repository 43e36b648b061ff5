// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Contact points on debonded cement, which may still touch its grains: unilateral contact with Coulomb friction. The
// grain is a sphere, so its surface is the same wherever the cement slides, and slips may have any length. With q the
// vector from the centre of the grain to the contact point in the cement, n = q/|q|, r the distance at which they
// touch, A the area and R the rotation of the grain:
//
//   gap      g = |q| - r                          p = kn <-g>, the pressure
//   stick    e = d - (d.n) n, d = q - R s         s: position without frictional force, in the frame of the grain
//   slip     |kt e| <= mu p; else s moves along e until this is met, which dissipates the energy A mu p |slip|;
//            it moves by all of e in the step in which the gap opens
//   force    f = A (p n - kt e) on the cement, -f and -q x f on the grain
//
// A contact point is created where a link debonds. s = R^T q when it closes. While the material point of the link is
// intact, the contact point follows the foot point of the link. A failed point carries no stress, so its contact point
// has no load. The contact point is then remapped to the nearest intact point. It lies half a spacing from this towards
// the grain. Failed material between it and the grain keeps its thickness: r is the distance of the new contact point in
// the reference, or the present distance if that is less. So no force appears at once. A material point has one contact
// point for each grain, with the area of all contact points that moved to it. Points that are equally near share the
// area. A closed contact point keeps its force.
//
// The stiffness is that of the links, or PenaltyParameters::max_contact_stiffness if that is less. A contact point that touches
// or is about to touch needs added mass as links do (added_mass.h), but twice as much. A node of mass m rebounds from a
// one-sided spring k at its speed of approach if k dt^2 <= 2 m. At 4 m, where a two-sided spring is still stable, it
// may rebound with three times its energy.
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

// `ends` points to end 0 of the bond. End 1 follows it. Energies are those of this rank.
class DebondedContact : public BondMechanism {
 public:
  DebondedContact() = default;
  void points_failed(const BondContext& b, const std::vector<int>& slots, const std::vector<int>& links, Losses& losses) override;
  void links_debonded(const BondContext& b, const std::vector<int>& links, Losses& losses) override;
  void add_force(const BondContext& b, Losses& losses) override;
  void add_energy(const PointStore& points, const Grid& grid, const BondEnd* ends, double& of_points, double& of_coupling) const override;
  std::string trouble(const PointStore& points, Grid& grid, long step) const override;

  // Lays out the contact points of the store on a grid that has the nodes of all points. Throws std::logic_error if the
  // grid does not have the nodes of one of them.
  DebondedContact(const PointStore& points, const BondRecord& record, const PenaltyParameters& parameters, const Grid& grid);

  // Ends the contact of points that failed (slots). Returns the energy that is released, by the rule of
  // PenaltyLinks::debond().
  double end(PointStore& points, const Grid& grid, const BondEnd* ends, const std::vector<int>& failed, double dt);
  // Creates the contact points of links of the store that debond in the step dt, which ends now. If a point has a
  // contact point with this grain already, the areas add up. Returns the energy that the new contact points have when
  // their force begins. A force that begins within a step acts with its new value over half of the motion of that step.
  // So this is the present energy less what it gained over that half.
  double open(PointStore& points, const BondRecord& record, const Grid& grid, const BondEnd* ends, const std::vector<int>& links,
              double dt);
  // Creates the contact points of all links that were debonded when the cement was made.
  void add_debonded_at_creation(PointStore& points, const BondRecord& record, const Grid& grid, const BondEnd* ends);

  // Updates the contact points for the present positions. Returns the frictional dissipation. Unchanged positions
  // change nothing.
  double follow(PointStore& points, const Grid& grid, const BondEnd* ends);
  // Adds the forces of the present positions to nodes and grains.
  void add_force(Grid& grid, BondEnd* ends) const;
  // Does both, one contact point after the other.
  double update_and_add_force(PointStore& points, Grid& grid, BondEnd* ends);
  // Adds the energy that the contact stores.
  void add_energy(const Grid& grid, const BondEnd* ends, double& energy) const;
  // Adds the area with added mass of contact points that touch, or may touch within the time `soon`, and removes that of the
  // others. Returns true if any changes. Added mass couples the motion of the cement to that of the grain, so open
  // contact points must have none. Until this call, new or moved contact points have none of their own: the debonded
  // links still have theirs. The grains are at the end of the step dt, the nodes where they were before it.
  bool update_added_mass(PointStore& points, const Grid& grid, const BondEnd* ends, double dt, double soon);
  void add_stiffness(const Grid& grid, const BondEnd* ends, double* penalty) const override;
  // Largest penetration of a contact point into its grain, at the last follow().
  double largest_penetration() const { return largest_penetration_; }

  // A contact point whose material point failed, and what it transfers to an intact point.
  struct OrphanedContact {
    int row, grain, tag;      // row of the bond; tags of the grain and of the point that failed
    double area, X[3], n[3];  // X: position on the surface of the grain in the reference, n: its normal
    double spacing;           // spacing of the points of the bond
  };
  // orphans(): contact points whose material points failed. They stay in the store until move() removes them. There are
  // none if take_topology_change() is false: no point failed and no link debonded since its last call.
  bool take_topology_change() { return std::exchange(changed_, false); }
  std::vector<OrphanedContact> orphans(const PointStore& points, const BondRecord& record) const;
  // The intact points of the store that are nearest to the position on the surface. Distances across the normal count
  // three times. Points that are equally near share the contact point, since none of them comes first in a bond that is
  // its own mirror image.
  struct Found {
    double far = 0;          // square of this distance, in whole multiples of kTie, so that rounding makes no difference between points
    std::vector<int> slots;  // ascending; empty if no point is intact
    static constexpr double kTie = 1.0471e-6;  // share of the square of the spacing; no distance in a lattice is a whole number of these
  };
  static Found nearest(const PointStore& points, const OrphanedContact& m);
  // Moves contact points to the slots of `arrivals`, and removes those of failed points that `gone` names. Returns the
  // increase of stored energy.
  struct Arrival {
    OrphanedContact orphan;
    int slot;
    double share;  // share of the area of the contact point that goes to this slot
  };
  double move(PointStore& points, const BondRecord& record, const Grid& grid, const BondEnd* ends, const std::vector<Arrival>& arrivals,
              std::vector<std::array<int, 2>> gone);  // tag and grain

  bool empty() const { return blocks_.empty(); }
  std::size_t memory_usage() const override;

 private:
  struct Block {
    vd X[3], area, added_mass_area, radius, stick_point[3], friction_traction;  // radius: r; stick_point: s; friction_traction: |kt e|
    vint base[3];
    int contact[kLanes];  // index in the store; -1: empty
    int side;
    std::uint8_t taken, intact, closed;                                     // one bit for each lane; intact: the point has not failed
    bool has_failed_points_only() const { return (intact | closed) == 0; }  // all its points failed, so it carries no load
  };
  // Kinematics of eight contact points, see the symbols above.
  struct Touch {
    vd q[3], n[3], e[3], gap;
  };
  const int* columns(const Block& b) const { return &columns_[kLanes * (&b - blocks_.data()) * columns_of_cell_]; }
  void touch(const Block& b, const Grid& grid, const BondEnd& s, Touch& t) const;
  static void find_stretch(const Block& b, const BondEnd& s, Touch& t);     // finds e from q and n
  double follow(Block& b, PointStore& points, const BondEnd& s, Touch& t);  // t: of this step; e after the slip
  void add_force(const Block& b, const Touch& t, Grid& grid, BondEnd& s) const;
  // Velocity v of the contact points relative to the grain, and velocity of the grain there.
  void find_velocity(const Block& b, const Grid& grid, const BondEnd& s, const Touch& t, vd* v, vd* of_grain) const;
  vd energy(const Block& b, const Touch& t) const;
  // Energy of closed contact points whose force ends or begins in the step dt: half of the product of force and stretch
  // at both ends of the step.
  vd energy_across(const Block& b, const Touch& t, const Grid& grid, const BondEnd& s, double dt) const;
  void lay_out(const PointStore& points, const BondRecord& record, const Grid& grid);
  // Adds new contact points to the store, and lays out all.
  void add(PointStore& points, const BondRecord& record, const Grid& grid, std::vector<ContactPoint> opened);

  PenaltyParameters p_;
  int columns_of_cell_ = 0;
  double inverse_h_ = 0, largest_penetration_ = 0;
  bool changed_ = true;  // points that failed on another rank may have arrived
  std::vector<Block> blocks_;
  std::vector<int> columns_;  // columns of the lanes of the blocks, see Grid
};

}  // namespace mpdem

#endif
