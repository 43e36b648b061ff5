// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The condensed bonds of this rank: those that it has points of, and those of its grains. A condensed bond (coupling/condensed_bond.h) takes the
// place of its resolved one, whose points and nodes wait at the creation, until the drive of the damage at some point comes
// near its threshold. Then it wakes: points, nodes and links take up the static fields with the motion of the grains.
//
// Bonds of equal shape in the same axes share one solution. Loads of a bond are told by one rank, the first that has points of it.
#ifndef MPDEM_CONDENSED_BONDS_H
#define MPDEM_CONDENSED_BONDS_H

#include <mpi.h>

#include <map>
#include <memory>
#include <set>
#include <vector>

#include "../coupling/condensed_bond.h"
#include "../coupling/grain_accelerations.h"
#include "bond.h"
#include "options.h"
#include "static_bond.h"

namespace mpdem {

class CondensedBonds {
 public:
  // Collective. Solves those of the rows whose table says that they are condensed, which were laid out at rest. They have no
  // loads before bind().
  void solve(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows, const Law& law);
  // Collective. After the sides were built anew.
  void bind(MPI_Comm comm, const Bonds& bonds, GrainSides& sides);
  bool has(int body) const { return find(body) != nullptr; }
  bool any() const { return any_; }  // on any rank

  // In a step: where the grains are, loads that do not hang on their accelerations.
  void follow(const Bonds& bonds, const GrainSides& sides);
  void add_forces(GrainSides& sides, const double* gravity) const;
  // The change of velocity that accelerations did not foretell, as a force over the step.
  void add_jumps(GrainSides& sides, double dt) const;
  const CondensedMass& mass();
  // Loads by the accelerations of the sides.
  void add_inertia(GrainSides& sides) const;

  struct Energies {
    double elastic = 0, kinetic = 0, kept = 0;  // kept: the kinetic energy of central differences
    double momentum[3] = {0, 0, 0}, angular_momentum[3] = {0, 0, 0};  // the latter about the origin of the box
  };
  // Of those that this rank tells. half: half a step.
  Energies energies(const Bonds& bonds, const GrainSides& sides, double half) const;
  Energies energies_of(int body, const Bonds& bonds, const GrainSides& sides, double half) const;
  // Power of the weight on velocities (rates: on accelerations) of the sides; of bodies from first_body on.
  double gravity_power(const GrainSides& sides, const double* gravity, bool rates, int first_body) const;

  // Work of commands that changed the velocities of grains between two runs by the jumps of the sides: the cement follows.
  double work_of_commands(const GrainSides& sides, double dt_last) const;

  // Those of this rank that have to wake, ascending. Looks at the points of a bond only where a bound does not tell.
  std::vector<int> due(Bonds& bonds, const CementOptions& options, const Law& law);
  // Of the nodes of a bond, three numbers each; the velocity is that of the sides, `later` of their acceleration later.
  struct NodeMotion {
    std::vector<double> displacement, velocity, acceleration;
  };
  NodeMotion nodes_of(const Bond& bond, const GrainSides& sides, double later) const;
  // Writes the strain by the present motion to the points of a bond, for who looks.
  void show_strain(Bond& bond) const;
  // Collective. Points and nodes of a bond take up the present, in equilibrium with the accelerations of the grains. bond: null if this rank has
  // nothing of it. dt_last: velocities lie half of it behind.
  void wake(MPI_Comm comm, int body, Bond* bond, const Bonds& bonds, const GrainSides& sides, const double* gravity, double dt_last,
            const Law& law) const;
  // They have no solution any more; bind() then.
  void drop(const std::vector<int>& rows);

  std::size_t memory_usage() const;
  int count() const;  // told by this rank

 private:
  struct Solution {
    StaticBond fields;
    CondensedModel model;
    double bound[6];  // of the root of the drive by each motion, see find_strain_bounds() of mpm/field_drive.h
  };
  struct Member {
    int body, side;
    bool tells;
    std::shared_ptr<const Solution> solution;  // without fields if this rank has no points of it
    CondensedMotion motion;
    CondensedMotion::Vector6 looked_at;  // the relative motion when its points were looked at last
    double margin;                       // how much the bound may change until the next time
  };
  const Member* find(int body) const;
  static std::shared_ptr<const Solution> solved(MPI_Comm comm, Bond* b, const Body& body, const Law& law);
  double largest_root(Bond& b, const CementOptions& options, const Law& law) const;

  void settle(MPI_Comm comm, Bond* bond, const Body& body, const GrainSides& sides, const double* gravity, const Law& law) const;

  std::map<int, std::shared_ptr<const Solution>> solutions_;  // of bonds with points here
  std::set<int> cut_;                                         // bodies that ranks cut, the same on all ranks
  std::vector<Member> members_;                               // ascending in body
  CondensedMass mass_;
  bool any_ = false;
};

}  // namespace mpdem

#endif
