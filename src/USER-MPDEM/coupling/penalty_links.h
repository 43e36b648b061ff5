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
// Semi-implicit in the node: where the row sum of the penalty stiffness k is too stiff for
// the time step, the node's mass is raised just enough (Grid::set_added_mass). A damper g,
// which acts on the velocity of half a step ago, counts as a spring 2 g/dt: a step is stable
// if k dt^2 + 2 g dt <= 4 m. Added mass c is that of the motion u - R of the node against the grain (as if fixed to
// it there); the force -c (u - R)'' acts on the grain with the opposite sign at the node's place, so momentum and
// angular momentum stay exact. Where the node's own mass does part of the work of c but the grain R is free, since
// (u - R)^2 <= (1 + t) u^2 + (1 + 1/t) R^2 for any t, links count (1 + t)-fold, with t the mass of the cement over
// what the grain has of inertia against it (`mass_ratio`): the grain's own kinetic energy then covers the rest.
// Accelerations of free grains: grain_accelerations.h.
#ifndef MPDEM_PENALTY_LINKS_H
#define MPDEM_PENALTY_LINKS_H

#include <array>
#include <vector>

#include "../mpm/grid.h"
#include "../mpm/point_store.h"
#include "grain_sides.h"

namespace mpdem {

struct PenaltyParameters {
  double kn = 0, kt = 0;  // pressure per length
  double damping = 0;     // share of critical, of the spring with the mass of its point
  bool at_surface = true;
};

class PenaltyLinks {
 public:
  // Lays out the links of the store in blocks of one cell and one side.
  // Call add_cells() before the grid is built, bind() after the sides.
  void build(const PointStore& points, const std::vector<Body>& bodies, const PenaltyParameters& parameters,
             double cell, double density, Basis basis = Basis::quadratic);
  void add_cells(std::vector<Grid::Cell>& cells);
  void bind(const GrainSides& sides);
  // After the grid is built: nodes and weights of links that read tied nodes, with their masters.
  void find_masters(const Grid& grid);
  // Instead of add_cells() where the grid stands already; false if it has not all the nodes.
  bool find_columns(const Grid& grid);

  // How far the cement carries the places of the links in dt, with the nodes as they are.
  void find_moves(const Grid& grid, double dt);
  // Moves them, and the cement's ends in the store, so far; true if the point of one left its
  // cell: follow_points() then.
  bool move_places(PointStore& points);
  // The blocks that build(), add_cells() and bind() would make, of which only those change whose points did; false
  // if the grid has not all the nodes. Without ties.
  bool follow_points(const PointStore& points, const std::vector<Body>& bodies, const Grid& grid, const GrainSides& sides);
  // The present becomes the reference of the cement's ends in the store; build() again then.
  void move_to_present(PointStore& points, const Grid& grid) const;
  // After PointStore::sort_links().
  void renumber(const std::vector<int>& new_place);

  // Row-summed stiffness of this rank's links, and of their dampers at this time step, into
  // grid.penalty. Links that let go count, and react, until drop_inertia() is called.
  void add_stiffness(Grid& grid, const GrainSides& sides, double dt);
  void drop_inertia(PointStore& points);
  // After Grid::set_added_mass(): whose the added mass of each node is, for what follows.
  void share_added_mass(const Grid& grid, const GrainSides& sides);
  // Of the nodes of this rank, whoever has the links.
  struct AddedMass {
    int node, at[2];  // places of the sides
    double mass[2];   // of the links to either
    double X[3];      // of the node, reference
    // From the centre of a grain.
    void lever_arm(const Grid& grid, const GrainSide& s, double* r) const {
      for (int d = 0; d < 3; ++d) r[d] = X[d] + grid.displacement[3 * node + d] - s.x[d];
    }
  };
  const std::vector<AddedMass>& added_masses() const { return shares_; }

  // Penalty force of the present positions on nodes and grains.
  void add_force(Grid& grid, GrainSides& sides, bool skip_detached = true) const;
  // The same for the links of one body. They follow each other; places are those in bodies().
  struct BodyLinks {
    int body, first, last;
  };
  void add_force(const BodyLinks& links, Grid& grid, GrainSides& sides, bool skip_detached) const;
  std::vector<BodyLinks> bodies() const;
  // Power that the dampers take: their force is that of the stored velocity, the velocity is so long
  // of the acceleration later. Bodies from first_body on.
  double damper_power(const Grid& grid, const GrainSides& sides, double later, int first_body = 0) const;
  // Added mass moves with its grain: force on nodes, after their sum over ranks, that takes it along, and its reaction on
  // the grains, before theirs, with the acceleration that nodes will have by Grid::update_acceleration().
  void carry_added_mass(Grid& grid, GrainSides& sides) const;
  // Added mass follows the jumps of its grains, as it follows their accelerations: c of a node of mass m takes it along with
  // c / (m + c) of them, rate times which is added to the accelerations. grain_rate times the reaction is added to the
  // forces of jumps on the grains.
  void follow_jumps(Grid& grid, GrainSides& sides, double rate, double grain_rate) const;
  // The same as forces on nodes and grains, of bodies from first_body on; `at_start`: of added mass that moves with the
  // nodes so far, whose jump is the velocity of the grains less that of the nodes.
  void add_jumps(Grid& grid, GrainSides& sides, int first_body, bool at_start) const;
  // Reaction of the added mass to a transfer that changes the velocity of nodes, by the acceleration scale * field.
  void add_reaction(const Grid& grid, const std::vector<double>& field, double scale, GrainSides& sides) const;
  // Work of that reaction on the grains for a change `field` of the velocity of the nodes, over its scale.
  double work_of_reaction(const Grid& grid, const GrainSides& sides, const std::vector<double>& field) const;
  // Power of the acceleration of the added mass relative to the grains on the velocity `field` of the nodes.
  double inertial_power(const Grid& grid, const GrainSides& sides, const std::vector<double>& field) const;

  // Frees the links of points that failed (slots, ascending); returns how many, and adds
  // the spring energy they gave up to `released`.
  int let_go(PointStore& points, const std::vector<int>& failed, const Grid& grid, const GrainSides& sides,
             double& released);

  // Energy of the springs of bodies from first_body on.
  double spring_energy(const Grid& grid, const GrainSides& sides, int first_body = 0) const;
  // Kinetic energy of the added mass relative to the grains, m/2 v.w with v and w the stored
  // velocity after the times `early` and `late` of the acceleration.
  double inertial_energy(const Grid& grid, const GrainSides& sides, double early = 0.0, double late = 0.0,
                         int first_body = 0) const;
  // Kinetic energy of the added mass relative to the grains before their jumps, with nodes after the time `later` of their
  // acceleration: what it is at the end of a drift whose grains have moved already. Of bodies before end_body.
  double inertial_energy_ahead(const Grid& grid, const GrainSides& sides, double later, int end_body) const;
  // That mass by side, of the nodes that count on this rank.
  std::vector<double> added_mass(const Grid& grid, const GrainSides& sides) const;

  const PenaltyParameters& parameters() const { return p_; }

 private:
  struct LinkBlock {
    vd X[3];    // where the link acts, reference; maybe outside the cell, which is the point's
    vd q0[3];   // in the grain's frame
    vd area;    // zero in empty lanes and once let go
    vd damper;  // damping coefficient over sqrt(k)
    vd inert_area, inert_damper;  // the same, with links that let go and still have added mass
    vd move[3]; // of X in this step, `updated` only
    int body, part, side, at;  // at: index into GrainSides
    int reduced;               // index into reduced_; -1: reads no tied node
    int base[3], column[kMostColumns];
    int link[kLanes];
    std::uint8_t attached, inert;  // a bit a lane: link holds, link has added mass
  };

  // Of a block: body, part, first node, side; blocks ascend in it.
  using Place = std::array<int, 6>;
  struct Item {
    Place place;
    int tag, link;
  };

  // Free nodes that a block reads through ties, and how.
  struct Reduced {
    std::vector<int> node;
    std::vector<vd> weight;
    vd row_sum;
  };

  // Calls f(node, weight) for the free nodes of a block.
  template <class Type, class F>
  void for_each_free_node(const LinkBlock& b, const Weights<Type>& w, F f) const;
  double created(const PointStore& points, const Link& k, int d) const;
  double acts_at(const PointStore& points, const Link& k, int d) const;
  static Place place_of(const LinkBlock& b);
  Item item_of(const PointStore& points, const std::vector<Body>& bodies, int link) const;
  // Appends the blocks of these links, which it sorts.
  void fill_blocks(const PointStore& points, const std::vector<Body>& bodies, std::vector<Item>& items,
                   std::vector<LinkBlock>& blocks) const;
  vd energy(const LinkBlock& b, const Grid& grid, const GrainSide& s) const;
  // Calls f(column, offset, weight) for the nodes of a block.
  template <class Type, class F>
  static void for_each_node(const Weights<Type>& w, F f);
  template <class Type>
  vd row_sum(const LinkBlock& b, const Weights<Type>& w) const;
  template <class Type>
  void place(const LinkBlock& b, const Grid& grid, const GrainSide& s, vd* q, vd* delta, vd* n) const;
  // Velocity of the place against the grain's, and the force of the dampers by it.
  template <class Type>
  void damper(const LinkBlock& b, const Grid& grid, const GrainSide& s, const Weights<Type>& w, const vd* q, const vd* n, vd* v,
              vd* f) const;

  PenaltyParameters p_;
  Basis basis_ = Basis::quadratic;
  double inverse_h_ = 0, density_ = 0;
  std::vector<LinkBlock> blocks_;
  std::vector<Reduced> reduced_;
  std::vector<Place> concerned_;  // by the last move_places()
  std::vector<AddedMass> shares_;
};

}  // namespace mpdem

#endif
