// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Fragments that touch other bodies. A fragment is a clump of intact points of a resolved bond that holds to no grain. Its
// points keep their material points and nodes, which move as ever. For contact (contact/piece_contact.h) it is a rigid
// body with the mean motion of its nodes,
//
//   m = sum m_i     x_c = sum m_i x_i/m     v_c = sum m_i v_i/m     r_i = x_i - x_c
//   I = sum m_i (r_i.r_i 1 - r_i r_i)       omega = I^-1 sum m_i r_i x v_i
//   R: the rotation nearest to sum m_i r_i (X_i - X_c)      (W. Kabsch, Acta Cryst. A 32, 1976, 922-923)
//
// The force F of contact and its moment T about x_c go to the nodes as the forces of a rigid body,
//
//   f_i = m_i (F/m + (I^-1 T) x r_i).
//
// So sum f_i = F, sum r_i x f_i = T and sum f_i.v_i = F.v_c + T.omega: momentum, angular momentum and the work of the
// contact are those of the body. Contact does not strain a fragment.
//
// A fragment has no state of its own. Which nodes it has is the same on all ranks, and stays until its surface is found
// again. x and u of nodes are in the axes of the bond. BodyOfNodes and forces of contact are in those of the box.
#ifndef MPDEM_CEMENT_BOND_FRAGMENT_BODIES_H
#define MPDEM_CEMENT_BOND_FRAGMENT_BODIES_H

#include <mpi.h>

#include <Eigen/Dense>
#include <vector>

#include "bond.h"

namespace mpdem {

// Motion of a fragment in the box. x, v: of the origin of the axes of its bond, carried along with the fragment.
struct BodyOfNodes {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), x = centre, v = centre, omega = centre;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // from the axes of the bond at creation to the box
};

class FragmentBodies {
 public:
  struct NodesOf {
    int row;
    std::vector<Key> nodes;  // ascending
  };
  // Time by which nodes have yet to move: v + kick a, then u + dt v. Both are 0 once they have moved.
  struct Drift {
    double kick = 0.0, dt = 0.0;
  };

  // Bonds of which fragments may touch other bodies, ascending, the same on all ranks. They have no other contact.
  const std::vector<int>& rows() const { return rows_; }
  bool has(int row) const;
  void add_rows(const std::vector<int>& rows);
  void remove_rows(const std::vector<int>& rows);
  int changes() const { return changes_; }  // number of calls that changed rows()

  // Replaces all fragments. The same on all ranks.
  void set(const std::vector<NodesOf>& fragments);
  bool any() const { return !fragments_.empty(); }
  int size() const { return static_cast<int>(fragments_.size()); }

  // Collective. Finds the motions of all fragments, the same on all ranks.
  const std::vector<BodyOfNodes>& find_motions(MPI_Comm comm, const Bonds& bonds, const Drift& ahead);
  // Six numbers a fragment, the same on all ranks: force and moment about BodyOfNodes::x of the last motion.
  void set_forces(const std::vector<double>& forces, const Bonds& bonds);
  // Collective. Finds the accelerations that these forces give, times a factor. Call it when nodes have the masses of the
  // step. With sub-steps the last one has all of the impulse of a step of the host, and the others have none.
  void find_accelerations(MPI_Comm comm, const Bonds& bonds, const Drift& ahead, double factor);
  // Adds the forces to those of the nodes of a bond, which are complete.
  void add_forces(Bond& b) const;
  // Power of these forces for such nodal velocities, over the nodes that count on this rank.
  double power(const Bond& b, const std::vector<double>& velocity) const;
  std::size_t memory_usage() const;

 private:
  using Vector3 = Eigen::Vector3d;
  using Matrix3 = Eigen::Matrix3d;
  struct Fragment {
    NodesOf of;
    // Nodes with mass on this rank, in a layout of the bond with that number and so many nodes.
    std::vector<int> here;
    int layout = -1, size = -1;
    // In the axes of the bond. force, moment: of contact, the moment about `about`.
    double mass = 0.0;
    Vector3 X = Vector3::Zero(), x = X, v = X, momentum = X, force = X, moment = X, about = X, a = X, alpha = X;
    Matrix3 inertia = Matrix3::Zero(), spread = inertia;
  };
  void find_nodes(const Bonds& bonds);
  void sum_up(MPI_Comm comm, const Bonds& bonds, const Drift& ahead);
  template <class F>
  void for_each_force(const Bond& b, F f) const;

  std::vector<int> rows_;
  int changes_ = 0;
  std::vector<Fragment> fragments_;  // by row, ascending
  std::vector<BodyOfNodes> motions_;
};

}  // namespace mpdem

#endif
