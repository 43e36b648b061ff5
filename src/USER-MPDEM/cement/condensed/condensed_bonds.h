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
// Bonds whose points are not made yet (mpm/point_template.h) share one bond, laid out, on each rank that has grains of
// them. This bond is looked at in the place of each of them. A bond that has to wake asks for its points first. Its
// loads are told by the rank that has its first grain.
#ifndef MPDEM_CEMENT_CONDENSED_CONDENSED_BONDS_H
#define MPDEM_CEMENT_CONDENSED_CONDENSED_BONDS_H

#include <mpi.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "../../coupling/condensed_bond.h"
#include "../../coupling/condensed_pack.h"
#include "../bond/bond.h"
#include "../bond/bonded_grains.h"
#include "../failure/load_history.h"
#include "../bond/options.h"
#include "../bond/point_sums.h"
#include "static_bond.h"

namespace mpdem {

class CondensedBonds {
 public:
  // Collective. Solves those of the rows that the table marks as condensed. They were laid out at rest. Rows that are
  // solved already and did not change are left out. Solved bonds have no loads before bind(). links, inertia: what the
  // solutions depend on besides the bonds. Fields of a bond that holds by next to nothing
  // may not be found. If no step has moved it yet, it is no longer condensed. Returns the rows of such bonds, the same
  // on all ranks. Throws BadState if the fields of other bonds are not found.
  std::vector<int> solve(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows, const Law& law, const PenaltyParameters& links,
                         double inertia);
  // Tells whether a condensed row came apart, and is condensed as pieces. The same on all ranks. Call before solve().
  void set_in_pieces(int row, bool yes) {
    if (yes) in_pieces_.insert(row);
    else in_pieces_.erase(row);
  }
  bool is_in_pieces(int row) const { return in_pieces_.count(row) > 0; }
  int solved_last() const { return solved_last_; }  // number of solutions that this rank found last, patterns included
  const std::vector<int>& without_field_last() const {
    return without_field_last_;
  }  // rows for which the last solve() found no fields, of all ranks
  // A laid-out bond that stands for the bonds of a pattern, and the body of one of them.
  struct OfPattern {
    int pattern;
    Bond bond;
    BondRecord record;
    bool counts = true;  // true on the first of the ranks that have the pattern
  };
  // Collective. Takes laid-out bonds of patterns, in the place of those that are here (all_anew) or together with them.
  // Solves those that are new or changed. Call before solve().
  void take_patterns(MPI_Comm comm, std::vector<OfPattern> laid_out, int patterns, bool all_anew, const Law& law,
                     const PenaltyParameters& links, double inertia);
  bool has_pattern(int pattern) const { return patterns_.count(pattern) > 0; }
  // Calls f for each pattern that this rank counts.
  template <class F>
  void each_pattern(F f) const {
    for (const auto& p : patterns_)
      if (p.second.of.counts) f(p.second.of.bond);
  }
  // Collective. Binds condensed bonds to grains. Call after bonds or grains went to other ranks.
  void bind(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains);
  bool has(int bond_row) const { return find(bond_row) != nullptr; }
  bool any() const { return pack_.any(); }  // true if any rank has condensed bonds

  // Collective. Takes the motion of the grains in a step, and finds loads that do not depend on their accelerations.
  void follow(const BondedGrains& grains, const double* gravity);
  // Collective. Does the same, then takes the accelerations that the grains have, and finds the loads by these.
  void resume(const BondedGrains& grains, const double* gravity);
  CondensedPack& pack() { return pack_; }

  struct Energies {
    double elastic = 0, kinetic = 0, discrete_kinetic = 0;            // discrete_kinetic: the energy that central differences keep
    double momentum[3] = {0, 0, 0}, angular_momentum[3] = {0, 0, 0};  // angular momentum is about the origin of the box
    void add(const Energies& e);
  };
  // Energies of the bonds that this rank tells, or of one of them. half: half a step.
  Energies energies(const Bonds& bonds, double half) const;
  Energies energies_of(int bond_row, const Bonds& bonds, double half) const;
  // The same of the piece of a bond on one of its grains. sides: its sides, or those of ends_of_piece() before it changed.
  using Ends = std::array<BondEnd, 2>;
  Energies energies_of_piece(int bond_row, int piece, const Bonds& bonds, double half, const Ends& ends) const;
  // Returns false if this rank has nothing of the piece.
  bool ends_of_piece(int bond_row, int piece, const Bonds& bonds, Ends& ends) const;
  // The grains of a bond as its sides.
  Ends ends_of(int bond_row, const Bonds& bonds) const;
  // tells(): does this rank tell the loads of the bond? loaded_ends(): all its loads on its grains.
  // energy_of_points(): elastic energy of its points. The rest of its energy is in the links.
  bool owns(int bond_row) const { return find(bond_row) && find(bond_row)->owns; }
  std::array<BondEnd, 2> loaded_ends(int bond_row, const Bonds& bonds, const double* gravity) const;
  double energy_of_points(int bond_row) const;
  // Raises the largest tension of the bonds that this rank tells, but for those in pieces, to that of the step. peaks: by row.
  void note_peaks(std::vector<double>& peaks) const;
  const PointSums& sums_of_points(int bond_row) const { return find(bond_row)->solution->sums; }
  std::vector<int> owned_rows() const;                             // rows that this rank tells
  std::vector<int> rows_without_points(const Bonds& bonds) const;  // rows among these that have no points yet
  const OfPattern& of_pattern(const BondRecord& record) const { return patterns_.at(record.pattern).of; }
  // Work in a step of the loads on the grains of this rank, and of the weight, for bodies from first_row on.
  EnergyBalance::StepWork work(const BondedGrains& grains, const Bonds& bonds, const double* gravity, double dt_last, int first_row) const;
  // Work of commands that changed the velocities of grains between two runs, by the jumps of the sides. The cement
  // follows them.
  double work_of_commands(const Bonds& bonds, double dt_last) const;

  // Returns rows of this rank that have to wake. Looks at the points of a bond, or of its pattern, only where a bound
  // does not tell. One rank cannot find an average over points of several ranks. Such bonds go to `together`: all ranks
  // have to look, and to call note_check().
  std::vector<int> due(Bonds& bonds, const CementOptions& options, const Law& law, std::vector<int>& together);
  // Notes the largest root of the drive that the points of a condensed bond have now, on any rank. Returns whether the
  // bond has to wake.
  bool note_check(int bond_row, double root, const CementOptions& options, const Law& law);
  bool any_cut() const { return !cut_.empty(); }  // true if ranks cut a condensed bond; the same on all ranks
  // Motion of the nodes of a bond, three numbers each. The velocity is that by the grains, with velocities ahead by
  // `later` times their acceleration.
  struct NodeMotion {
    std::vector<double> displacement, velocity, acceleration;
  };
  NodeMotion nodes_of(const Bond& bond, const BondRecord& record, double later) const;
  // Write the strain by the present motion to the points of a condensed bond, or of all, for code that looks at points.
  void show_strain(Bond& bond) const;
  void show_strains(Bonds& bonds) const;
  // Collective. Points and nodes of a bond take up the present motion, in equilibrium with the accelerations of the
  // grains. bond: null if this rank has nothing of it. dt_last: length of the last step; velocities lie half of it
  // behind.
  void activate(MPI_Comm comm, int bond_row, Bond* bond, const Bonds& bonds, const double* gravity, double dt_last, const Law& law) const;
  // Would a bond that is awake and whole on this rank be the same if it were condensed again? Force and energy may
  // change by kChange of what they are at its threshold. side: first side of the bond, with the loads of the step.
  // energy: energy of its nodes, points and links. root: root of its largest drive.
  bool matches_static_solution(const Bond& resolved, const BondRecord& record, const BondEnd* ends, double energy, double root,
                               const double* gravity, double dt_last, const Law& law);
  // Asks the same of a bond that came apart: does what holds move with its grains? The limits are kChange of the
  // largest load that the bond had, and of the energy with that load.
  bool pieces_rest(Bond& resolved, const BondRecord& record, const BondEnd* ends, double energy, const LoadHistory::Largest& largest,
                   const double* gravity, double dt_last, const Law& law);
  // Momentum of both sides of a bond that fits, half a step behind, as loads. momentum_of_nodes() is the momentum that
  // its nodes have. momentum_as_condensed() is the momentum of the condensed bond with the motion of these sides. Call
  // it once the bond is solved. half: half a step.
  GrainLoads momentum_of_nodes(const Bond& resolved, const BondRecord& record, const BondEnd* ends) const;
  GrainLoads momentum_as_condensed(int row, const BondRecord& record, const BondEnd* ends, double half) const;
  void forget_candidate(int bond_row) { candidates_.erase(bond_row); }
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
    std::vector<signed char> grain_of_node;  // grain of each node of a bond in pieces, on ranks that have nodes of it
    double bound[6] = {};                    // bound of the root of the drive by each motion, see find_strain_bounds() of mpm/field_drive.h
    PointSums sums;
    Matrix6 energy = Matrix6::Zero();  // elastic energy of the points: d.energy d/2
  };
  struct Member {  // members are in the order of the pack
    int row;
    bool owns;
    std::shared_ptr<const Solution> solution;  // without fields if this rank has no points of it
    int piece = -1;                            // the grain that this piece goes with; -1: a whole bond
    double looked_at[6] = {};                  // the relative motion when its points were looked at last
    double margin = 0.0;                       // how much the bound may change until the next look
  };
  const CondensedModel& model_of(std::size_t member) const {
    return members_[member].solution->models[std::max(members_[member].piece, 0)];
  }
  // Returns the body of a part of the pack: the row of the table, or `piece`, which becomes the body of a piece.
  const BondRecord& record_of(std::size_t member, const Bonds& bonds, BondRecord& piece) const;
  const Member* find(int bond_row) const;
  static std::shared_ptr<const Solution> of_pieces(MPI_Comm comm, Bond* b, const BondRecord& record, const Law& law);
  static std::shared_ptr<const Solution> solved(MPI_Comm comm, Bond* b, const BondRecord& record, const Law& law,
                                                int most = kMostStaticSteps);
  bool solve_cut(MPI_Comm comm, Bonds& bonds, int row, const Law& law);  // collective; false: no field was found
  double largest_root(Bond& b, const BondRecord& record, int member, const CementOptions& options, const Law& law) const;
  bool note_check(std::size_t member, double root, const CementOptions& options, const Law& law);
  void show_strain(Bond& bond, int member) const;

  void equilibrate(MPI_Comm comm, Bond* bond, const BondRecord& record, const double* gravity, const Law& law) const;
  void pack_up(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains);
  int member_of_row(int bond_row) const;  // the first part of the bond, which may have two pieces; -1: none
  int member_of(int bond_row) const;      // throws std::logic_error if there is none
  template <class F>
  void each_member_of(int bond_row, F f) const {
    const int first = member_of_row(bond_row);
    for (std::size_t member = static_cast<std::size_t>(first); first >= 0 && member < members_.size() && members_[member].row == bond_row;
         ++member)
      f(member);
  }
  Energies energies_of_member(std::size_t member, const Bonds& bonds, double half, const Ends* ends = nullptr) const;
  int member_of_piece(int bond_row, int piece) const;  // -1: none
  std::array<BondEnd, 2> loaded_ends_of_member(std::size_t member, const Bonds& bonds, const double* gravity) const;
  NodeMotion nodes_of_pieces(const Bond& bond, const BondRecord& record, double later) const;

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
  std::set<int> cut_;  // bodies that ranks cut, the same on all ranks
  struct Candidate {
    int layout = 0;                            // layout of the bond when it was solved
    double damage = 0.0, failed = 0.0;         // values at that time
    std::shared_ptr<const Solution> solution;  // none: the solution was not found
  };
  std::map<int, Candidate> candidates_;  // bonds that are awake, solved to see whether they fit
  std::vector<Member> members_;          // ascending in body
  CondensedPack pack_;
};

}  // namespace mpdem

#endif
