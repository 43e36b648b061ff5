// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Contact of crack faces in the cement of one bond, with Coulomb friction. Where nodes split
// (fracture/phantom_nodes.h), the copies of a node are the two faces. The jump over the crack is that of their
// displacements, w = u_b - u_a. It was zero when the node split. The normal n points from a to b. It follows from the
// intact volume of either copy in the present state and from its gradient (after S. G. Bardenhagen, J. U. Brackbill, D.
// Sulsky, Comput. Methods Appl. Mech. Engrg. 187, 2000, 529-541, who take the difference of the gradients):
//
//   V_a = sum V N_a     G_a = sum V F^-T grad N_a     n = g/|g|, g = G_a/V_a - G_b/V_b
//
// The division by V matters at nodes beside which the cement ends. There each G has a part along the crack, in
// proportion to V. This part drops out of the difference of G/V. It remains in the plain difference of the gradients if
// one copy has more material, and tilts the normal.
//
// Two nodes exchange just the force that leaves w.n >= 0 at the end of the next step (forward increments of N. J.
// Carpenter, R. L. Taylor, M. G. Katona, Int. J. Numer. Methods Engrg. 32, 1991, 103-128). With lumped masses this is
// one equation a pair. A rotating normal may cause an overlap. It is undone by a bounce no faster than the faces close,
// so the force never supplies energy. Along the face, the force is that which stops their slip, or mu times the normal
// force if that is less. The contact needs no stiffness and does not reduce the stable step. The kinetic energy that a
// pair loses by impact and slip is the work of these forces. Copies whose G is below 1e-5 of the face of a cell have no
// contact.
//
// Slips of up to a cell are valid. Pairs with larger slips have no contact. slid_too_far() finds those with both copies
// connected to a grain. The bond then goes on as rigid pieces (contact/piece_contact.h). A piece that is connected to no
// grain flies freely and does not count: it reaches the plane of the face from which it broke off elsewhere, where there
// is no contact.
#ifndef MPDEM_COUPLING_CRACK_FACES_H
#define MPDEM_COUPLING_CRACK_FACES_H

#include <functional>
#include <vector>

#include "../mpm/bond_mechanism.h"
#include "../mpm/grid.h"
#include "../mpm/point_store.h"
#include "../mpm/power.h"

namespace mpdem {

class CrackFaces : public BondMechanism {
 public:
  using KeyOf = std::function<Key(const Key&)>;

  CrackFaces() = default;
  // Finds pairs of free (not constrained) copies of nodes that were one node at the start. at_start: the original node
  // of a copy.
  CrackFaces(const PointStore& points, const Grid& grid, const KeyOf& at_start, double friction);

  void add_contact(const BondContext& b) override { add_contact_force(b.points, b.grid, b.added_mass, b.kick, b.dt); }
  void add_friction_power(const Grid& grid, Power& sum) const override { sum.add(power(grid)); }
  bool has_ended(const PointStore& points, Grid& grid) const override { return slid_too_far(points, grid) > 0.0; }

  // Collective among the ranks that share the nodes, all of which have all copies. Adds the forces of the pairs to
  // those of the nodes, which are complete. added: added mass of the nodes, or an empty list. The next step changes
  // velocities by kick times the acceleration and lasts dt.
  void add_contact_force(const PointStore& points, Grid& grid, const SharedList<double>& added, double kick, double dt);
  // Power that the forces of the pairs dissipate, at the nodes that this rank counts. Power::after() gives it for
  // velocities ahead of the stored ones.
  Power power(const Grid& grid) const;
  // Collective as add_contact_force(). Largest slip above a cell of pairs that would touch in the last step, and whose material
  // is connected to a grain; 0: none.
  double slid_too_far(const PointStore& points, Grid& grid) const;
  double largest_penetration() const { return largest_penetration_; }  // deepest overlap of a pair in the last step
  int pairs() const { return static_cast<int>(pairs_.size()); }
  int touching() const { return touching_; }
  std::size_t memory_usage() const override {
    return pairs_.capacity() * sizeof(Pair) + blocks_.capacity() * sizeof(int) +
           (gradient_.capacity() + volume_.capacity()) * sizeof(double);
  }

 private:
  struct Pair {
    int node[2];
    double force[3];  // force on the second node
    double too_far;   // slip of a pair that would touch if it had not slid too far; else 0
  };
  // tie: row of each node in the constraints, or -1 if it is free.
  void find_pairs(const Grid& grid, const KeyOf& at_start, const std::vector<int>& tie);
  void find_normals(const PointStore& points, Grid& grid);
  void add_pair_force(Pair& p, Grid& grid, const double* mass, double kick, double dt);

  double friction_ = 0, largest_penetration_ = 0;
  int touching_ = 0;
  std::vector<Pair> pairs_;                // sorted by grid index
  std::vector<int> blocks_;                // blocks that have nodes of pairs
  std::vector<double> gradient_, volume_;  // G and V of the formula, three numbers and one number per node
};

}  // namespace mpdem

#endif
