// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Penalty coupling of cement to rigid grains. A link holds the vector q0 from the grain's
// centre to its place on the bond, fixed in the grain, and compares it with the current
// vector q_t of the same place in the cement:
//
//   delta = q_t - R q0,  n = R q0/|q0|,
//   f = -A (k_n (delta.n) n + k_t (delta - (delta.n) n)) - damping,   on the cement
//   -f and -q_t x f on the grain.
//
// f and the moment derive from U = delta_b.K0.delta_b/2 in the frame of the grain; the
// lever arm has to be q_t or angular momentum is lost when k_n != k_t. The place is the
// foot point on the grain's surface (`at surface`) or the material point itself (`at
// points`).
//
// At the foot point the field is the polynomial of the cell of the *material point*, continued to
// there; mostly both lie in one cell. Where they do not, a node whose support reaches over the
// foot point but over no material point has no stiffness and would give way until the penalty
// force on it vanishes (stiffness of a bond up to 14 % low if the grid lies badly). Continuation
// is the remedy of extended B-splines (Hoellig, Reif & Wipper, SIAM J. Numer. Anal. 39 (2001)
// 442). The weights sum to one and reproduce linear fields, so momentum and angular momentum
// stay exact; some are negative.
//
// That is the elastic law. The force per area by delta is a traction law, see traction_law.h.
//
// The links of one bond on one rank. Stiff links ask for added mass at the nodes: added_mass.h.
#ifndef MPDEM_PENALTY_LINKS_H
#define MPDEM_PENALTY_LINKS_H

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "../mpm/grid.h"
#include "../mpm/point_store.h"
#include "../mpm/power.h"
#include "../numerics/short_list.h"
#include "grain_sides.h"
#include "traction_law.h"

namespace mpdem {

struct PenaltyParameters {
  std::shared_ptr<const TractionLaw> law;
  double damping = 0;  // share of critical, of the spring with the mass of its point
  bool at_surface = true;
  double friction = -1;  // of places that let go, see freed_places.h; below 0: they touch nothing
  // Largest stiffness of a place. Friction that slides goes by the force along the normal.
  double stiffest() const {
    const TractionStiffness& k = law->stiffness();
    return std::max(friction > 0.0 ? k.kn * std::sqrt(1.0 + friction * friction) : k.kn, k.kt);
  }
};

// What links of a law with a state did in a step.
struct LinkStep {
  double dissipated = 0, released = 0;  // energies: spent by the law, and what springs give up besides as they soften, let go, open or close
  std::vector<int> let_go;              // links of the store that let go although their points hold
};

// `side` is always the first of the two sides of the bond, the second is behind it.
class PenaltyLinks {
 public:
  PenaltyLinks() = default;
  // Lays out the links of the store in blocks of one side. Call add_cells() before the grid is built.
  PenaltyLinks(const PointStore& points, const Body& body, const PenaltyParameters& parameters, double cell, double density,
               Basis basis = Basis::quadratic);
  void add_cells(std::vector<Grid::Cell>& cells);
  // Instead of add_cells() where the grid stands already; false if it has not all the nodes.
  bool find_columns(const Grid& grid);

  // How far the cement carries the places of the links in dt, with the nodes as they are.
  void find_moves(const Grid& grid, double dt);
  // Moves them, and the cement's ends in the store, so far; true if the point of one left its
  // cell, or if links are gone: follow_points() then.
  bool move_places(PointStore& points);
  // The blocks that a new layout would have; false if the grid has not all the nodes. Without ties.
  bool follow_points(const PointStore& points, const Body& body, const Grid& grid);
  // The present becomes the reference of the cement's ends in the store; lay out anew then.
  void move_to_present(PointStore& points, const Grid& grid) const;
  // After PointStore::sort_links().
  void renumber(const std::vector<int>& new_place);
  // Points went to other parts, and nodes to other places, see Grid::add_nodes(). Throws std::logic_error if the nodes of a link are
  // not there.
  void follow_parts(const PointStore& points, const Grid& grid, const std::vector<int>& place);

  // What the present positions, dt after those of before, do to the state of the traction law, in the links of the store too. Positions that
  // stay change nothing. No work for a law without a state.
  void follow(PointStore& points, const Grid& grid, const GrainSide* side, double dt, LinkStep& step);
  // Force of the present positions and states on nodes and grains.
  void add_force(Grid& grid, GrainSide* side) const;
  // Power that the dampers take: their force is that of the stored velocity, the velocity is so long
  // of the acceleration later.
  Power damper_power(const Grid& grid, const GrainSide* side) const;
  // Adds the energy that the traction law stores.
  void add_spring_energy(const Grid& grid, const GrainSide* side, double& energy) const;

  // Frees the links of points that failed (slots, ascending; links of the store ascend in slot), and adds the energy they gave up to `released`. With a law that keeps
  // skins they stay attached without a force: a failed point has no stress, and shares its nodes with the cement that came off it. Answers those of the store
  // that let go, ascending.
  // Links that let go count for the added mass until drop_inertia() is called.
  std::vector<int> let_go(PointStore& points, const std::vector<int>& failed, const Grid& grid, const GrainSide* side, double dt, double& released);
  bool drop_inertia(PointStore& points);  // true if some were inert
  // The blocks that a new layout would have, where points and nodes stay as they are.
  void leave_out_dropped(const PointStore& points, const Body& body);
  // Row-summed stiffness of this rank's links, and of their dampers at this time step, added to two numbers a node,
  // those of either side. Links that read tied nodes burden the masters.
  void add_stiffness(const Grid& grid, const GrainSide* side, double dt, double* penalty) const;

  // Secant stiffness of the links of a block in the present state, times their area; zero where they let go. arm: from the centre of the
  // grain to the place in the cement, so that a turn of both together strains nothing.
  struct Secant {
    vd n[3], arm[3], kn, kt;
  };
  std::vector<Secant> secants(const Grid& grid, const GrainSide* side) const;
  // Adds forces by small displacements x of the nodes, and by small motions of the two grains: translation of the centre, then turn. `load` is on
  // the grains, force and moment about the centre. Linear and symmetric: what the forces themselves do by a turn is left out.
  void add_small_force(const std::vector<Secant>& secants, const double* x, const double (*motion)[6], double* force, double (*load)[6]) const;

  const PenaltyParameters& parameters() const { return p_; }
  bool empty() const { return blocks_.empty(); }
  // Holds with others what these have alike.
  void share(AlikeLists& alike);
  std::size_t memory_usage() const;

 private:
  struct LinkBlock {
    vd X[3];    // where the link acts, reference; maybe outside the cell, which is the point's
    vd area;    // zero in empty lanes
    vint base[3];  // cells of the points
    int link[kLanes];              // of the store; -1: empty
    std::uint8_t side;
    // Lanes with a link, attached or not.
    std::uint8_t taken() const {
      unsigned bits = 0;
      for (int l = 0; l < kLanes; ++l) bits |= (link[l] >= 0 ? 1u : 0u) << l;
      return static_cast<std::uint8_t>(bits);
    }
  };

  // A bit a lane: link holds, link has added mass.
  struct Holding {
    std::uint8_t attached = 0, inert = 0;
  };

  struct Places {
    vd X[3];
  };

  // Links lie in the order of their sides, of the cells of their feet, which stay, and of the IDs of their points. Those of a cell are
  // few, and blocks of one cell would be half empty, so a block has those of several.
  struct Item {
    std::array<int, 5> key;  // side, cell, ID
    int link;
  };

  // Is it attached, and no skin?
  bool holds(const PointStore& points, const Link& k) const {
    return k.attached && !(p_.law->keeps_skins() && (points.meta[k.slot / kLanes].failed >> k.slot % kLanes & 1));
  }
  double created(const PointStore& points, const Link& k, int d) const;
  double acts_at(const PointStore& points, const Link& k, int d) const;
  void base_of(const PointStore& points, const Link& k, int* base) const;
  void set_lane(std::size_t block, int lane, const PointStore& points, int link);
  // Of a lane of a block, kSupport^2 of them.
  int* columns(std::size_t block, int lane) { return &columns_.own()[(kLanes * block + lane) * columns_of_cell_]; }
  std::size_t number_of(const LinkBlock& b) const { return static_cast<std::size_t>(&b - blocks_.data()); }
  const int* columns(const LinkBlock& b) const { return columns_.data() + kLanes * number_of(b) * columns_of_cell_; }
  const vd* created_at(const LinkBlock& b) const { return created_.empty() ? b.X : created_[number_of(b)].X; }
  void keep_created();
  // Value of a nodal field at the places of a block.
  template <class Type>
  void gather(const std::vector<double>& nodal, const LinkBlock& b, const Weights<Type>& w, vd* out) const;
  // Stored, lane by lane.
  template <class L>
  vd energy(const L& law, std::size_t block, const Grid& grid, const GrainSide& s) const;
  template <class L>
  static vd taken_in_step(const L& law, const typename L::State& before, const typename L::State& after, const vd* delta, const vd* n, const vd* v, double dt);
  template <class L>
  vd energy_of_ending(const L& law, std::size_t block, const Grid& grid, const GrainSide& s, double dt) const;
  // Of a block, for its traction law.
  template <class L>
  typename L::State state(const L&, std::size_t block) const;
  void release(std::size_t block, std::uint8_t freed, vd energy, bool is_skin, PointStore& points, double& released);
  void take_states(const PointStore& points);
  template <class Type>
  void place(const LinkBlock& b, const Grid& grid, const GrainSide& s, const Weights<Type>& w, vd* q, vd* delta, vd* n) const;
  // Velocity of the place against the grain's.
  template <class Type>
  void find_velocity(const LinkBlock& b, const Grid& grid, const GrainSide& s, const Weights<Type>& w, const vd* q, vd* v) const;
  // The same, and the force of the dampers by it.
  template <class Type>
  void damper(const LinkBlock& b, const Grid& grid, const GrainSide& s, const Weights<Type>& w, const TractionSecant& k, const vd* q,
              const vd* n, vd* v, vd* f) const;

  PenaltyParameters p_;
  Basis basis_ = Basis::quadratic;
  double cell_ = 0, inverse_h_ = 0, density_ = 0;
  int body_ = 0, columns_of_cell_ = 0;
  bool gone_ = false;               // some links have neither force nor added mass, by the last move_places()
  // What bonds of one shape have alike: blocks, and of their lanes nodes (see Grid) and parts.
  SharedList<LinkBlock> blocks_;
  SharedList<int> columns_;
  SharedList<int> parts_;
  std::vector<Holding> holding_;  // of each block
  std::vector<vd> states_;   // of the traction law, its fields of each block; those of the store are the same
  std::vector<Places> moves_;    // of the places of each block in this step, `updated` only
  std::vector<Places> created_;  // where the links of each block were then; empty: where they act
  std::vector<vd> dampers_;      // coefficient over sqrt(k), of each block; empty without damping
  // Of the body: centres of its grains then, and their orientation to its axes.
  double centre_[2][3] = {};
  Mat3<double> orientation_[2];
};

}  // namespace mpdem

#endif
