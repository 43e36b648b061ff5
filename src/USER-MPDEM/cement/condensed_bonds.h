// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The condensed bonds of this rank: those that it has points of, and those of its grains. A condensed bond (coupling/condensed_bond.h) takes the
// place of its resolved one, whose points and nodes wait at the creation, until the drive of the damage at some point comes
// near its threshold. Then it wakes: points, nodes and links take up the static fields with the motion of the grains.
//
// Bonds of equal shape in the same axes share one solution. Loads of a bond are told by one rank, the first that has points of it.
//
// A bond that came apart is condensed as a rigid piece on each grain (rigid_pieces.h), and does not wake.
//
// Bonds whose points are not made yet (mpm/point_pattern.h) share one bond, laid out, on each rank that has grains of them. It is looked at in the place of each
// of them. One that has to wake asks for its points first. Its loads are told by the rank that has its first grain.
#ifndef MPDEM_CONDENSED_BONDS_H
#define MPDEM_CONDENSED_BONDS_H

#include <mpi.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "../coupling/condensed_bond.h"
#include "../coupling/condensed_pack.h"
#include "bond.h"
#include "bonded_grains.h"
#include "load_watch.h"
#include "options.h"
#include "point_sums.h"
#include "static_bond.h"

namespace mpdem {

class CondensedBonds {
 public:
  // Collective. Solves those of the rows whose table says that they are condensed, which were laid out at rest, but for those that are solved already
  // and did not change. They have no loads before bind(). links, inertia: what the solutions hang on beside the bonds.
  // split: CementOptions::split. Of those that no step has moved yet, bonds whose fields are not found, since they hold by next to nothing, are
  // no longer condensed then: answers their rows, the same on all ranks. Throws BadState if those of others are not found.
  std::vector<int> solve(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows, const Law& law, const PenaltyParameters& links, double inertia, bool split);
  // Of a row that is condensed: as pieces, since it came apart? The same on all ranks. Before solve().
  void set_in_pieces(int row, bool yes) {
    if (yes) in_pieces_.insert(row);
    else in_pieces_.erase(row);
  }
  bool is_in_pieces(int row) const { return in_pieces_.count(row) > 0; }
  int solved_last() const { return solved_last_; }  // by this rank
  int without_field_last() const { return without_field_last_; }  // that the last solve() found none for, of all ranks
  // A laid-out bond that stands for those of a pattern, and the body of one of them.
  struct OfPattern {
    int pattern;
    Bond bond;
    Body body;
    bool counts = true;  // on this rank, the first of those that have it
  };
  // Collective. Takes them in the place of those that are here, or with these, and solves those that are new or changed. Before solve().
  void take_patterns(MPI_Comm comm, std::vector<OfPattern> laid_out, int patterns, bool all_anew, const Law& law, const PenaltyParameters& links, double inertia);
  bool has_pattern(int pattern) const { return patterns_.count(pattern) > 0; }
  // Calls f for each pattern that this rank counts.
  template <class F>
  void each_pattern(F f) {
    for (auto& p : patterns_)
      if (p.second.of.counts) f(p.second.of.bond);
  }
  // Collective. After bonds or grains went to other ranks.
  void bind(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains);
  bool has(int body) const { return find(body) != nullptr; }
  bool any() const { return pack_.any(); }  // on any rank

  // Collective. In a step: motion of the grains, loads that do not hang on their accelerations.
  void follow(const BondedGrains& grains, const double* gravity);
  // Collective. The same with the accelerations that the grains have, and the loads by these.
  void resume(const BondedGrains& grains, const double* gravity);
  CondensedPack* pack() { return any() ? &pack_ : nullptr; }

  struct Energies {
    double elastic = 0, kinetic = 0, discrete_kinetic = 0;  // the last: that which central differences keep
    double momentum[3] = {0, 0, 0}, angular_momentum[3] = {0, 0, 0};  // the latter about the origin of the box
    void add(const Energies& e);
  };
  // Of those that this rank tells. half: half a step.
  Energies energies(const Bonds& bonds, double half) const;
  Energies energies_of(int body, const Bonds& bonds, double half) const;
  // All loads on the grains of a bond that this rank reports. The elastic energy of its points; the rest of its energy is in the links.
  bool tells(int body) const { return find(body) && find(body)->tells; }
  std::array<GrainSide, 2> loaded_sides(int body, const Bonds& bonds, const double* gravity) const;
  double energy_of_points(int body) const;
  const PointSums& sums_of_points(int body) const { return find(body)->solution->sums; }
  std::vector<int> rows_told() const;                        // by this rank
  std::vector<int> rows_without_points(const Bonds& bonds) const;  // of these
  const OfPattern& of_pattern(const Body& body) const { return patterns_.at(body.pattern).of; }
  // Work of the loads on the grains of this rank, and of the weight, in a step; of bodies from first_body on.
  EnergyBooks::StepWork work(const BondedGrains& grains, const Bonds& bonds, const double* gravity, double dt_last, int first_body) const;
  // Work of commands that changed the velocities of grains between two runs by the jumps of the sides: the cement follows.
  double work_of_commands(const Bonds& bonds, double dt_last) const;

  // Those of this rank that have to wake. Looks at the points of a bond, or of its pattern, only where a bound does not tell.
  // An average over points of several ranks is not for one rank to find. Such bonds go to `together`: all ranks are to look, and to tell note_look().
  std::vector<int> due(Bonds& bonds, const CementOptions& options, const Law& law, std::vector<int>& together);
  // The largest root of the drive that the points of a condensed bond have now, on any rank. Has the bond to wake?
  bool note_look(int body, double root, const CementOptions& options, const Law& law);
  bool any_cut() const { return !cut_.empty(); }  // by ranks; the same on all of them
  // Of the nodes of a bond, three numbers each; the velocity is that of the grains, `later` of their acceleration later.
  struct NodeMotion {
    std::vector<double> displacement, velocity, acceleration;
  };
  NodeMotion nodes_of(const Bond& bond, const Body& body, double later) const;
  // Writes the strain by the present motion to the points of a bond, for who looks.
  void show_strain(Bond& bond) const;
  // Collective. Points and nodes of a bond take up the present, in equilibrium with the accelerations of the grains. bond: null if this rank has
  // nothing of it. dt_last: velocities lie half of it behind.
  void wake(MPI_Comm comm, int body, Bond* bond, const Bonds& bonds, const double* gravity, double dt_last, const Law& law) const;
  // Would a bond that is awake and whole on this rank be the same if it were condensed again, within kChange of force and energy at its
  // threshold? side: its first, with the loads of the step. energy: that of its nodes, points and links. root: that of its largest drive.
  bool fits(const Bond& awake, const Body& body, const GrainSide* side, double energy, double root, const double* gravity, double dt_last, const Law& law);
  // The same of a bond that came apart: does what holds move with its grains, within kChange of the largest load that the bond had and of the energy with that?
  bool pieces_rest(Bond& awake, const Body& body, const GrainSide* side, double energy, const LoadWatch::Largest& largest, const double* gravity,
                   double dt_last, const Law& law, bool split);
  // Momentum of both sides of one that fits, half a step behind, as its nodes have it, and as the condensed bond has it with the motion of these sides. The
  // latter once it is solved. As loads. half: half a step.
  GrainLoads momentum_of_nodes(const Bond& awake, const Body& body, const GrainSide* side) const;
  GrainLoads momentum_as_condensed(int row, const Body& body, const GrainSide* side, double half) const;
  void forget_candidate(int body) { candidates_.erase(body); }

  // Collective. They are condensed no more.
  void drop(MPI_Comm comm, const std::vector<int>& rows, const Bonds& bonds, const BondedGrains& grains);

  std::size_t memory_usage() const;
  int count() const;  // told by this rank

 private:
  struct Solution {
    StaticBond fields;
    std::vector<CondensedModel> models = std::vector<CondensedModel>(1);  // one of the bond, or one of each piece
    std::vector<signed char> grain_of_node;                               // of the latter, on ranks that have nodes of it
    double bound[6] = {};  // of the root of the drive by each motion, see find_strain_bounds() of mpm/field_drive.h
    PointSums sums;
    Matrix6 energy = Matrix6::Zero();  // of the points: d.energy d/2
  };
  struct Member {  // in the order of the pack
    int body;
    bool tells;
    std::shared_ptr<const Solution> solution;  // without fields if this rank has no points of it
    int piece = -1;                            // the grain that this piece goes with
    double looked_at[6] = {};                  // the relative motion when its points were looked at last
    double margin = 0.0;                       // how much the bound may change until the next time
  };
  const CondensedModel& model_of(std::size_t part) const { return members_[part].solution->models[std::max(members_[part].piece, 0)]; }
  // As the pack has it: the row of the table, or `piece`, which becomes the body of a piece.
  const Body& body_of(std::size_t part, const Bonds& bonds, Body& piece) const;
  const Member* find(int body) const;
  static std::shared_ptr<const Solution> of_pieces(MPI_Comm comm, Bond* b, const Body& body, const Law& law, bool split);
  static std::shared_ptr<const Solution> solved(MPI_Comm comm, Bond* b, const Body& body, const Law& law, int most = kMostStaticSteps);
  bool solve_cut(MPI_Comm comm, Bonds& bonds, int row, const Law& law, bool split);  // collective; false: no field was found
  double largest_root(Bond& b, int part, const CementOptions& options, const Law& law) const;
  bool note_look(std::size_t part, double root, const CementOptions& options, const Law& law);
  void show_strain(Bond& bond, int part) const;

  void settle(MPI_Comm comm, Bond* bond, const Body& body, const double* gravity, const Law& law) const;
  void pack_up(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains);
  int part_of(int body) const;  // the first, of two pieces; -1: none
  template <class F>
  void each_part_of(int body, F f) const {
    const int first = part_of(body);
    for (std::size_t part = static_cast<std::size_t>(first); first >= 0 && part < members_.size() && members_[part].body == body; ++part) f(part);
  }
  Energies energies_of_part(std::size_t part, const Bonds& bonds, double half) const;
  std::array<GrainSide, 2> loaded_sides_of_part(std::size_t part, const Bonds& bonds, const double* gravity) const;
  NodeMotion nodes_of_pieces(const Bond& bond, const Body& body, double later) const;

  struct PatternSolution {
    OfPattern of;
    std::shared_ptr<const Solution> solution;
    std::size_t described = 0;  // hash of what it was solved for
  };
  std::map<int, PatternSolution> patterns_;
  std::map<int, std::shared_ptr<const Solution>> solutions_;  // of bonds with points here
  std::map<int, std::size_t> described_;                      // hash of what they were solved for
  int solved_last_ = 0, without_field_last_ = 0;
  std::set<int> in_pieces_;
  std::set<int> cut_;                                         // bodies that ranks cut, the same on all ranks
  struct Candidate {
    bool tried = false;
    double damage = 0.0, failed = 0.0;         // when it was solved
    std::shared_ptr<const Solution> solution;  // none: the solution was not found
  };
  std::map<int, Candidate> candidates_;  // bonds that are awake, solved to see whether they fit
  std::vector<Member> members_;                               // ascending in body
  CondensedPack pack_;
};

}  // namespace mpdem

#endif
