// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Records of the cement in a restart file, besides its points and grains, in this order: a version, a head, a row for
// each bond, rows of the split nodes, and of loose points. The motion of the nodes is stored with the points of their bonds
// (AtomVecMpdem::write_with_points), a row for each node. It is most of the data, and LIGGGHTS limits what a fix writes
// to 2 GiB.
#ifndef MPDEM_CEMENT_LAYOUT_CEMENT_RESTART_H
#define MPDEM_CEMENT_LAYOUT_CEMENT_RESTART_H

#include <algorithm>

#include "../../fracture/separation.h"
#include "../../material/law.h"
#include "../../mpm/basis.h"
#include "../../mpm/bond_record.h"
#include "../../parallel/record.h"
#include "../bond/energy_balance.h"
#include "../failure/load_history.h"

namespace mpdem {

// The links of the steps so far. Later steps must use the same.
struct LinkSettings {
  enum Kind { kNoSteps, kLinks, kNone } kind = kNoSteps;
  double kn = 0.0, kt = 0.0;
  bool at_surface = true;
  int law = 0;  // number of the traction law, traction_law_number()
  static constexpr int kMostParameters = 6;
  double parameter[kMostParameters] = {0, 0, 0, 0, 0, 0};  // parameters of the traction law
  double friction = -1.0;                                  // PenaltyParameters::friction

  template <class Self, class Visitor>
  static constexpr void describe(Self& l, Visitor& visit) {
    visit("the kind of coupling", l.kind, from(kNoSteps, kNone));
    visit("kn of the coupling", l.kn, kFinite);
    visit("kt of the coupling", l.kt, kFinite);
    visit("'at surface' of the coupling", l.at_surface);
    visit("the number of the traction law", l.law, kCount);
    visit("a parameter of the traction law", l.parameter, kFinite);
    visit("friction of the coupling", l.friction, from(-1.0, kLargestNumber));
  }
};

// The damage law of the steps so far. Later steps may have another, which is reported to the user.
struct DamageLawSettings {
  int law = 0;  // number of the law, law_number()
  double value[Law::kMostWords] = {}, length = 0.0, energy = 0.0, imperfection = 0.0;

  template <class Self, class Visitor>
  static constexpr void describe(Self& l, Visitor& visit) {
    visit("the number of the law of damage", l.law, kCount);
    visit("a value of the law of damage", l.value, kFinite);
    visit("the length of the regularization", l.length, kNotNegative);
    visit("the energy of a crack", l.energy, kNotNegative);
    visit("the imperfection", l.imperfection, kNotNegative);
  }
};

// The clock of LooseCement (cement/step/loose_cement.h).
struct LooseClock {
  int rows = 0;                    // number of LooseRow that follow
  double time = 0.0, step = -1.0;  // the time that it shows, and the step at which it does

  template <class Self, class Visitor>
  static constexpr void describe(Self& c, Visitor& visit) {
    visit("the number of loose points", c.rows, kCount);
    visit("the clock of loose points", c.time, kNotNegative);
    visit("the step of that clock", c.step, from(-1.0, kLargestNumber));
  }
};

struct CementHead {
  static constexpr int kVersion = 23;
  double cell = 0.0;
  Basis basis = Basis::quadratic;
  bool updated = false, tied = false;
  double step = 0.0;     // time step; stored velocities are those half a step earlier
  int rows_started = 0;  // number of bonds at the head of the table that have moved; later ones are as made
  double start_energy = 0.0;
  EnergyBalance::Sums energy;  // sums over all ranks
  double time = 0.0;
  double eigenvalue = 0.0;       // largest eigenvalue; 0: not known
  double auto_step = 0.0;        // time step that `timestep auto S` found last
  double auto_share = 0.0;       // S of `timestep auto S`; 0: it found no time step
  double longest_substep = 0.0;  // longest sub-step of `subcycle auto`; 0: none was found
  LinkSettings links;
  DamageLawSettings law;
  bool unilateral = false;              // are failed points stiff while their crack is closed
  double elastic[5] = {0, 0, 0, 0, 0};  // constants of the elasticity, VtiConstants
  double mass_scale = 1.0;
  double density = 0.0;      // density of the calcite
  bool split = false;        // do nodes split as points fail, see fracture/phantom_nodes.h
  int rows = 0, copies = 0;  // numbers of BondRow and PhantomNodeRow that follow
  double nodes = 0.0;        // number of NodeRow on all ranks
  LooseClock loose;

  template <class Self, class Visitor>
  static constexpr void describe(Self& h, Visitor& visit) {
    visit("cell", h.cell, kPositive);
    visit("the number of the basis", h.basis, from(0, Bases::kNumber - 1));
    visit("'kinematics updated'", h.updated);
    visit("'edge tied'", h.tied);
    visit("the time step", h.step, kNotNegative);
    visit("the number of bonds that have moved", h.rows_started, kCount);
    visit("the energy at the start", h.start_energy, kFinite);
    visit.part(h.energy);
    visit("the time", h.time, kFinite);
    visit("the largest eigenvalue", h.eigenvalue, kNotNegative);
    visit("the step of 'timestep auto'", h.auto_step, kNotNegative);
    visit.part(h.links);
    visit.part(h.law);
    visit("the number of bonds", h.rows, kCount);
    visit("the number of nodes", h.nodes, kNotNegative);
    visit("'cracks split'", h.split);
    visit("'unilateral'", h.unilateral);
    visit("the elasticity", h.elastic, kFinite);
    visit("the scale of the inertia", h.mass_scale, kPositive);
    visit("the number of copies of nodes", h.copies, kCount);
    visit("the sub-step of 'subcycle auto'", h.longest_substep, kNotNegative);
    visit("the density", h.density, kPositive);
    visit("the share of 'timestep auto'", h.auto_share, from(0, 1));
    visit.part(h.loose);
  }
};

struct BondRow {
  double broken_seen = 0.0;  // number of failed points and debonded links at the last check of the bond
  FractureSurface separation;
  double peak = 0.0;       // largest tension so far
  double broken_at = 0.0;  // the step Cracks::State::broken_at
  bool released = false;   // do its fragments touch other bodies, see FragmentBodies
  LoadHistory::Largest largest;
  double loads[LoadHistory::kSums] = {};  // sums over the present window, of all ranks

  template <class Self, class Visitor>
  static constexpr void describe(Self& b, Visitor& visit) {
    visit("the number of failed points and links of a bond", b.broken_seen, kNotNegative);
    visit.part(b.separation);
    visit("the largest tension of a bond", b.peak, kFinite);
    visit("the step at which a bond was broken", b.broken_at, kNotNegative);
    visit("'has free fragments' of a bond", b.released);
    visit.part(b.largest);
    visit("a sum of loads of a bond", b.loads, kFinite);
  }
};

struct NodeRow {
  int row = 0, layer = 0, index[3] = {0, 0, 0};  // the key of the node
  double velocity[3] = {0, 0, 0}, displacement[3] = {0, 0, 0}, acceleration[3] = {0, 0, 0};

  template <class Self, class Visitor>
  static constexpr void describe(Self& n, Visitor& visit) {
    visit("the bond of a node", n.row, kCount);
    visit("the layer of a node", n.layer, from(0, kMaxLayers - 1));
    visit("a grid index of a node", n.index, from(-Key::kFarthest, Key::kFarthest));
    visit("the velocity of a node", n.velocity, kFinite);
    visit("the displacement of a node", n.displacement, kFinite);
    visit("the acceleration of a node", n.acceleration, kFinite);
  }
};

// The phantom node of one layer of a bond at a split node: an Entry of PhantomNodes (fracture/phantom_nodes.h).
struct PhantomNodeRow {
  int row = 0, index[3] = {0, 0, 0};
  int layer = 0, copy = 0, first = 0;
  double volume = 0.0;

  template <class Self, class Visitor>
  static constexpr void describe(Self& c, Visitor& visit) {
    visit("the bond of a split node", c.row, kCount);
    visit("a grid index of a split node", c.index, from(-Key::kFarthest, Key::kFarthest));
    visit("the layer of a split node", c.layer, from(0, kMaxLayers - 1));
    visit("the copy of a split node", c.copy, kCount);
    visit("the first copy of a split node", c.first, kCount);
    visit("the volume of a split node", c.volume, kNotNegative);
  }
};

// A point that came loose, a LooseCement::Loose (cement/step/loose_cement.h).
struct LooseRow {
  int row = 0, tag = 0;
  double since = 0.0;

  template <class Self, class Visitor>
  static constexpr void describe(Self& l, Visitor& visit) {
    visit("the bond of a loose point", l.row, kCount);
    visit("the ID of a loose point", l.tag, kCount);
    visit("the time at which a point came loose", l.since, kNotNegative);
  }
};

// Number of values that follow a head.
inline std::size_t numbers_after(const CementHead& h) {
  return static_cast<std::size_t>(kMostNumbers<BondRow>) * h.rows + static_cast<std::size_t>(kMostNumbers<PhantomNodeRow>) * h.copies +
         static_cast<std::size_t>(kMostNumbers<LooseRow>) * h.loose.rows;
}

}  // namespace mpdem

#endif
