// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// How the cement is computed: the options of a script, except those of its damage law. Units are those of `units`.
#ifndef MPDEM_CEMENT_BOND_OPTIONS_H
#define MPDEM_CEMENT_BOND_OPTIONS_H

#include <limits>

#include "../../mpm/advance_points.h"
#include "../../mpm/basis.h"
#include "../../mpm/bond_record.h"
#include "../../mpm/transfer.h"

namespace mpdem {

constexpr int kMostSubsteps = 1000;
constexpr double kUsualImperfection = 2e-3, kMostImperfection = 0.1;

// What is dropped: by age and size, see cement/step/loose_cement.h, where all conditions must be met; and what a grain that
// leaves the box takes along.
struct FragmentRule {
  bool drop = false;         // false: fragments stay in the scene
  bool bonds = false;        // the rule is for all cement of separated bonds, not for their fragments only
  double age = 0.0;          // least time since it came loose
  int below_points = 0;      // it has fewer points; 0: any number
  double below_share = 0.0;  // it has a smaller share of the points of the bond; 0: any share
  bool outside = false;      // joined cement outside of the box leaves with all cement of its bond, instead of stopping the run
};

struct CementOptions {
  double cell = 0.0;
  Basis basis = Basis::quadratic;
  AxisRule axis = AxisRule::radial;      // axis of new points
  double axis_direction[3] = {0, 0, 1};  // unit vector, for `global`
  bool updated = false;                  // `kinematics updated`
  bool tied = true;                      // are nodes at the edge of the cement constrained, see mpm/extension_constraints.h
  Transfer transfer;
  int reproject_every = 0;            // steps between two re-projections; 0: none
  double reproject_distortion = 0.0;  // distortion at which the present configuration becomes the reference; 0: never
  AdvanceOptions advance;
  double mass_scale = 1.0, relative_damping = 0.0;  // quasistatic: factor of the inertia, share of critical damping
  double length = 0.0;                              // internal length of the nonlocal average of the driving force; 0: none
  double imperfection = 0.0;  // nonlocal damage only: share of extra strain that cement at one grain carries, mpm/imperfection.h
  double half_band = 0.0;     // half width of the crack band for this length, Law::crack_band(); 0: none, or not known
  int mass_order = 1;         // 1 or 2 terms of the inverse of the consistent mass, see mpm/consistent_mass.h
  bool split = false;         // do nodes split as points fail, not only when the bond separates, see cement/failure/node_splitting.h
  bool unilateral = false;    // are failed points stiff while their crack is closed, see mpm/closing_points.h
  bool condense = false;      // are bonds condensed while their damage is far from its threshold, see cement/condensed/condensed_bonds.h
  double activation_share = 0.8;  // share of the threshold at which a condensed bond is activated
  int subcycle = 1;               // sub-steps in a step of the host; 0: as many as the cement needs
  bool balance = false;           // are bonds moved to ranks that have less work, see cement/bond/work_shares.h
  int check_every = 100;          // steps between two checks
  FragmentRule fragments;
  double most_bytes = std::numeric_limits<double>::infinity();  // limit for the grids of a rank

  // Least width of intact cement that counts as a connection of the grains; 0: any width. Where nodes split as points
  // fail, a bridge narrower than a cell of the grid carries almost nothing.
  double narrowest_bridge() const { return split ? cell : 0.0; }
  // Do the nodes beside a crack share the mass of failed points, see fracture/phantom_nodes.h? Failed points that may
  // be stiff again keep their mass at their own nodes, since the bound of the time step needs it there.
  bool shares_failed_mass() const { return !unilateral; }
  // Do points give their velocity to the nodes: in every step, every so many steps, or when they get a new reference?
  bool reprojects() const { return updated || reproject_every > 0 || reproject_distortion > 0.0; }
};

}  // namespace mpdem

#endif
