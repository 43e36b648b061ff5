// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Faces of cracks in the cement of one bond touch, with Coulomb friction. Where nodes split (fracture/node_copies.h), the copies of a node are
// the two faces, and the jump over the crack is that of their displacements, w = u_b - u_a. It was zero when the node split. With the
// normal n from a to b, by the gradient of the volume that holds of either copy in the present state (S. G. Bardenhagen, J. U. Brackbill,
// D. Sulsky, Comput. Methods Appl. Mech. Engrg. 187, 2000, 529-541),
//
//   G_a = sum V F^-T grad N_a     n = (G_a - G_b)/|G_a - G_b|
//
// two nodes exchange just the force that leaves w.n >= 0 at the end of the next step (forward increments of N. J. Carpenter, R. L. Taylor,
// M. G. Katona, Int. J. Numer. Methods Engrg. 32, 1991, 103-128): with the lumped masses N that is one equation a pair. An overlap, which
// a normal that turns may make, is undone by a bounce no faster than the faces close. So the force never gives energy. Along the face the force
// is that which stops their slip, or mu times the normal one if that is less. It needs no stiffness and leaves the stable step as it is.
// What the pair loses of its kinetic energy, by impact and slip, is the work of these forces.
// Copies whose G is below 1e-5 of the face of a cell meet nothing.
// Valid for slips of up to a cell: pairs that are further off touch no more, and slid_too_far() tells of those whose sides both hold to a grain.
// A piece that holds to none flies where it likes. It meets the plane of a face from which it broke off anywhere but opposite to it.
#ifndef MPDEM_CRACK_FACES_H
#define MPDEM_CRACK_FACES_H

#include <vector>

#include "../mpm/grid.h"
#include "../mpm/point_store.h"
#include "../mpm/power.h"

namespace mpdem {

class Splits;

class CrackFaces {
 public:
  CrackFaces() = default;
  // Pairs of copies of nodes that were one at the start and are free.
  CrackFaces(const PointStore& points, const Grid& grid, const Splits& splits, double friction);

  // Collective among the ranks that share the nodes, of which all know of all copies. Adds the forces of the pairs to those of the nodes, which
  // are complete; added: mass of the nodes, or none. The next step changes velocities by kick times the acceleration and lasts dt.
  void add_force(const PointStore& points, Grid& grid, const SharedList<double>& added, double kick, double dt);
  // Power that they take, at the velocity that is so long of the acceleration later than the stored one. Of the nodes that count here.
  Power power(const Grid& grid) const;
  // Collective as add_force(). Largest slip above a cell of pairs that would touch in the last step, of material that holds to a grain; 0: none.
  double slid_too_far(const PointStore& points, Grid& grid) const;
  // Deepest overlap of a pair in the last step.
  double deepest() const { return deepest_; }
  int pairs() const { return static_cast<int>(pairs_.size()); }
  int touching() const { return touching_; }

 private:
  struct Pair {
    int node[2];
    double force[3];  // on the second
    double too_far;   // its slip, where it would touch but for that; else 0
  };
  void find_normals(const PointStore& points, Grid& grid);
  void meet(Pair& p, Grid& grid, const double* mass, double kick, double dt);

  double friction_ = 0, deepest_ = 0;
  int touching_ = 0;
  std::vector<Pair> pairs_;      // by place
  std::vector<int> blocks_;      // with nodes of pairs
  std::vector<double> normal_;   // G, three numbers a node
};

}  // namespace mpdem

#endif
