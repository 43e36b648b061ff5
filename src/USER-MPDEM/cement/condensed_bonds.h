// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The condensed bonds of this rank: bonds of which it has points, and bonds of its grains. A condensed bond
// (coupling/condensed_bond.h) takes the place of its resolved one. Points and nodes of the resolved bond wait at the
// creation, until the drive of the damage at some point comes near its threshold. Then the bond wakes: points, nodes
// and links take up the static fields with the motion of the grains.
//
// Bonds of equal shape in the same axes share one solution. One rank tells the loads of a bond: the first that has
// points of it.
//
// A bond that came apart is condensed as a rigid piece on each grain (rigid_pieces.h), and does not wake.
//
// Bonds whose points are not made yet (mpm/point_pattern.h) share one bond, laid out, on each rank that has grains of
// them. This bond is looked at in the place of each of them. A bond that has to wake asks for its points first. Its
// loads are told by the rank that has its first grain.
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
  // Collective. Solves those of the rows that the table marks as condensed. They were laid out at rest. Rows that are
  // solved already and did not change are left out. Solved bonds have no loads before bind(). links, inertia: what the
  // solutions depend on besides the bonds. Fields of a bond that holds by next to nothing
  // may not be found. If no step has moved it yet, it is no longer condensed. Returns the rows of such bonds, the same
  // on all ranks. Throws BadState if the fields of other bonds are not found.
  std::vector<int> solve(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows, const Law& law, const PenaltyParameters& links, double inertia);
  // Tells whether a condensed row came apart, and is condensed as pieces. The same on all ranks. Call before solve().
  void set_in_pieces(int row, bool yes) {
    if (yes) in_pieces_.insert(row);
    else in_pieces_.erase(row);
  }
  bool is_in_pieces(int row) const { return in_pieces_.count(row) > 0; }
  int solved_last() const { return solved_last_; }  // number of solutions that this rank found last, patterns included
  const std::vector<int>& without_field_last() const { return without_field_last_; }  // rows for which the last solve() found no fields, of all ranks
  // A laid-out bond that stands for the bonds of a pattern, and the body of one of them.
  struct OfPattern {
    int pattern;
    Bond bond;
    Body body;
    bool counts = true;  // true on the first of the ranks that have the pattern
  };
  // Collective. Takes laid-out bonds of patterns, in the place of those that are here (all_anew) or together with them.
  // Solves those that are new or changed. Call before solve().
  void take_patterns(MPI_Comm comm, std::vector<OfPattern> laid_out, int patterns, bool all_anew, const Law& law, const PenaltyParameters& links, double inertia);
  bool has_pattern(int pattern) const { return patterns_.count(pattern) > 0; }
  // Calls f for each pattern that this rank counts.
  template <class F>
  void each_pattern(F f) const {
    for (const auto& p : patterns_)
      if (p.second.of.counts) f(p.second.of.bond);
  }
  // Collective. Binds condensed bonds to grains. Call after bonds or grains went to other ranks.
  void bind(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains);
  bool has(int body) const { return find(body) != nullptr; }
  bool any() const { return pack_.any(); }  // true if any rank has condensed bonds

  // Collective. Takes the motion of the grains in a step, and finds loads that do not depend on their accelerations.
  void follow(const BondedGrains& grains, const double* gravity);
  // Collective. Does the same, then takes the accelerations that the grains have, and finds the loads by these.
  void resume(const BondedGrains& grains, const double* gravity);
  CondensedPack& pack() { return pack_; }

  struct Energies {
    double elastic = 0, kinetic = 0, discrete_kinetic = 0;  // discrete_kinetic: the energy that central differences keep
    double momentum[3] = {0, 0, 0}, angular_momentum[3] = {0, 0, 0};  // angular momentum is about the origin of the box
    void add(const Energies& e);
  };
  // Energies of the bonds that this rank tells, or of one of them. half: half a step.
  Energies energies(const Bonds& bonds, double half) const;
  Energies energies_of(int body, const Bonds& bonds, double half) const;
  // The same of the piece of a bond on one of its grains. sides: its sides, or those of piece_sides() before it changed.
  using Sides = std::array<GrainSide, 2>;
  Energies energies_of_piece(int body, int piece, const Bonds& bonds, double half, const Sides& sides) const;
  // Returns false if this rank has nothing of the piece.
  bool piece_sides(int body, int piece, const Bonds& bonds, Sides& sides) const;
  // The grains of a bond as its sides.
  Sides sides_of(int body, const Bonds& bonds) const;
  // tells(): does this rank tell the loads of the bond? loaded_sides(): all its loads on its grains.
  // energy_of_points(): elastic energy of its points. The rest of its energy is in the links.
  bool tells(int body) const { return find(body) && find(body)->tells; }
  std::array<GrainSide, 2> loaded_sides(int body, const Bonds& bonds, const double* gravity) const;
  double energy_of_points(int body) const;
  // Raises the largest tension of the bonds that this rank tells, but for those in pieces, to that of the step. peaks: by row.
  void note_peaks(std::vector<double>& peaks) const;
  const PointSums& sums_of_points(int body) const { return find(body)->solution->sums; }
  std::vector<int> rows_told() const;                        // rows that this rank tells
  std::vector<int> rows_without_points(const Bonds& bonds) const;  // rows among these that have no points yet
  const OfPattern& of_pattern(const Body& body) const { return patterns_.at(body.pattern).of; }
  // Work in a step of the loads on the grains of this rank, and of the weight, for bodies from first_body on.
  EnergyBooks::StepWork work(const BondedGrains& grains, const Bonds& bonds, const double* gravity, double dt_last, int first_body) const;
  // Work of commands that changed the velocities of grains between two runs, by the jumps of the sides. The cement
  // follows them.
  double work_of_commands(const Bonds& bonds, double dt_last) const;

  // Returns rows of this rank that have to wake. Looks at the points of a bond, or of its pattern, only where a bound
  // does not tell. One rank cannot find an average over points of several ranks. Such bonds go to `together`: all ranks
  // have to look, and to call note_look().
  std::vector<int> due(Bonds& bonds, const CementOptions& options, const Law& law, std::vector<int>& together);
  // Notes the largest root of the drive that the points of a condensed bond have now, on any rank. Returns whether the
  // bond has to wake.
  bool note_look(int body, double root, const CementOptions& options, const Law& law);
  bool any_cut() const { return !cut_.empty(); }  // true if ranks cut a condensed bond; the same on all ranks
  // Motion of the nodes of a bond, three numbers each. The velocity is that by the grains, with velocities ahead by
  // `later` times their acceleration.
  struct NodeMotion {
    std::vector<double> displacement, velocity, acceleration;
  };
  NodeMotion nodes_of(const Bond& bond, const Body& body, double later) const;
  // Write the strain by the present motion to the points of a condensed bond, or of all, for code that looks at points.
  void show_strain(Bond& bond) const;
  void show_strains(Bonds& bonds) const;
  // Collective. Points and nodes of a bond take up the present motion, in equilibrium with the accelerations of the
  // grains. bond: null if this rank has nothing of it. dt_last: length of the last step; velocities lie half of it
  // behind.
  void wake(MPI_Comm comm, int body, Bond* bond, const Bonds& bonds, const double* gravity, double dt_last, const Law& law) const;
  // Would a bond that is awake and whole on this rank be the same if it were condensed again? Force and energy may
  // change by kChange of what they are at its threshold. side: first side of the bond, with the loads of the step.
  // energy: energy of its nodes, points and links. root: root of its largest drive.
  bool fits(const Bond& awake, const Body& body, const GrainSide* side, double energy, double root, const double* gravity, double dt_last, const Law& law);
  // Asks the same of a bond that came apart: does what holds move with its grains? The limits are kChange of the
  // largest load that the bond had, and of the energy with that load.
  bool pieces_rest(Bond& awake, const Body& body, const GrainSide* side, double energy, const LoadWatch::Largest& largest, const double* gravity,
                   double dt_last, const Law& law);
  // Momentum of both sides of a bond that fits, half a step behind, as loads. momentum_of_nodes() is the momentum that
  // its nodes have. momentum_as_condensed() is the momentum of the condensed bond with the motion of these sides. Call
  // it once the bond is solved. half: half a step.
  GrainLoads momentum_of_nodes(const Bond& awake, const Body& body, const GrainSide* side) const;
  GrainLoads momentum_as_condensed(int row, const Body& body, const GrainSide* side, double half) const;
  void forget_candidate(int body) { candidates_.erase(body); }
  // Forgets all of these but those of awake bonds of this rank.
  void forget_candidates_but(const Bonds& bonds);

  // Collective. Drops rows that are condensed no more.
  void drop(MPI_Comm comm, const std::vector<int>& rows, const Bonds& bonds, const BondedGrains& grains);

  std::size_t memory_usage() const;
  int count() const;  // number of bonds that this rank tells

 private:
  struct Solution {
    StaticBond fields;
    std::vector<CondensedModel> models = std::vector<CondensedModel>(1);  // one model of the bond, or one of each piece
    std::vector<signed char> grain_of_node;                               // grain of each node of a bond in pieces, on ranks that have nodes of it
    double bound[6] = {};  // bound of the root of the drive by each motion, see find_strain_bounds() of mpm/field_drive.h
    PointSums sums;
    Matrix6 energy = Matrix6::Zero();  // elastic energy of the points: d.energy d/2
  };
  struct Member {  // members are in the order of the pack
    int body;
    bool tells;
    std::shared_ptr<const Solution> solution;  // without fields if this rank has no points of it
    int piece = -1;                            // the grain that this piece goes with; -1: a whole bond
    double looked_at[6] = {};                  // the relative motion when its points were looked at last
    double margin = 0.0;                       // how much the bound may change until the next look
  };
  const CondensedModel& model_of(std::size_t part) const { return members_[part].solution->models[std::max(members_[part].piece, 0)]; }
  // Returns the body of a part of the pack: the row of the table, or `piece`, which becomes the body of a piece.
  const Body& body_of(std::size_t part, const Bonds& bonds, Body& piece) const;
  const Member* find(int body) const;
  static std::shared_ptr<const Solution> of_pieces(MPI_Comm comm, Bond* b, const Body& body, const Law& law);
  static std::shared_ptr<const Solution> solved(MPI_Comm comm, Bond* b, const Body& body, const Law& law, int most = kMostStaticSteps);
  bool solve_cut(MPI_Comm comm, Bonds& bonds, int row, const Law& law);  // collective; false: no field was found
  double largest_root(Bond& b, const Body& body, int part, const CementOptions& options, const Law& law) const;
  bool note_look(std::size_t part, double root, const CementOptions& options, const Law& law);
  void show_strain(Bond& bond, int part) const;

  void settle(MPI_Comm comm, Bond* bond, const Body& body, const double* gravity, const Law& law) const;
  void pack_up(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains);
  int part_of(int body) const;  // the first part of the bond, which may have two pieces; -1: none
  int part_that_is(int body) const;  // throws std::logic_error if there is none
  template <class F>
  void each_part_of(int body, F f) const {
    const int first = part_of(body);
    for (std::size_t part = static_cast<std::size_t>(first); first >= 0 && part < members_.size() && members_[part].body == body; ++part) f(part);
  }
  Energies energies_of_part(std::size_t part, const Bonds& bonds, double half, const Sides* sides = nullptr) const;
  int part_of_piece(int body, int piece) const;  // -1: none
  std::array<GrainSide, 2> loaded_sides_of_part(std::size_t part, const Bonds& bonds, const double* gravity) const;
  NodeMotion nodes_of_pieces(const Bond& bond, const Body& body, double later) const;

  struct PatternSolution {
    OfPattern of;
    std::shared_ptr<const Solution> solution;
    std::size_t described = 0;  // hash of what it was solved for
  };
  std::map<int, PatternSolution> patterns_;
  std::map<int, std::shared_ptr<const Solution>> solutions_;  // solutions of bonds with points here
  std::map<int, std::size_t> described_;                      // hash of what these were solved for
  int solved_last_ = 0;
  std::vector<int> without_field_last_;
  std::set<int> in_pieces_;
  std::set<int> cut_;                                         // bodies that ranks cut, the same on all ranks
  struct Candidate {
    int layout = 0;                            // layout of the bond when it was solved
    double damage = 0.0, failed = 0.0;         // values at that time
    std::shared_ptr<const Solution> solution;  // none: the solution was not found
  };
  std::map<int, Candidate> candidates_;  // bonds that are awake, solved to see whether they fit
  std::vector<Member> members_;                               // ascending in body
  CondensedPack pack_;
};

}  // namespace mpdem

#endif
