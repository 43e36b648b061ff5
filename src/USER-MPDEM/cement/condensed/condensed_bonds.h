// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The condensed bonds of this rank: those of which it has points, and those of its grains. A condensed bond follows its
// grains by its static stiffness (coupling/condensed_bond.h). Its points and nodes stay in the configuration at
// creation until the driving force of the damage at some point comes near its threshold. Then the bond is activated:
// points, nodes and links get the static fields for the motion of the grains.
//
// Bonds with equal descriptions (bond_description.h) share one solution. One rank owns the loads of a bond: the first
// that has points of it.
//
// A separated bond is condensed as one rigid piece on each grain (rigid_pieces.h), and is not activated.
//
// Bonds of a template (mpm/point_template.h), whose points are made later, share one laid-out bond on each rank that
// has grains of them. Its points are checked for each of these bonds. A bond that is to be activated asks for its
// points first. The rank of its first grain owns its loads.
//
// bond_row, row: row of the table of bonds. half: half a step. ends: both ends of a bond.
#ifndef MPDEM_CEMENT_CONDENSED_CONDENSED_BONDS_H
#define MPDEM_CEMENT_CONDENSED_CONDENSED_BONDS_H

#include <mpi.h>

#include <algorithm>
#include <limits>
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
  // Collective. Solves those of the rows that the table marks as condensed, and that are new or changed. They must be
  // laid out in the configuration at creation. Solved bonds have no loads before bind(). links, scaled_density: what the
  // solutions depend on besides the bonds. The fields of a bond that carries almost nothing may not converge. Such a bond
  // becomes resolved if no step has moved it yet. Returns the rows of these bonds, the same on all ranks. Throws BadState
  // if the fields of other bonds do not converge.
  std::vector<int> solve(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows, const Law& law, const PenaltyParameters& links,
                         double scaled_density);
  // Sets whether a row is condensed as rigid pieces. The same on all ranks. Call before solve().
  void set_in_pieces(int row, bool yes) {
    if (yes) changes_of_surfaces_ += in_pieces_.insert(row).second;
    else in_pieces_.erase(row);
  }
  // Grows with each row that becomes condensed as pieces, and by note_departure(): a bond lost points.
  int changes_of_surfaces() const { return changes_of_surfaces_; }
  void note_departure() { ++changes_of_surfaces_; }
  bool is_in_pieces(int row) const { return in_pieces_.count(row) > 0; }
  int solved_last() const { return solved_last_; }  // number of solutions that this rank found last, templates included
  const std::vector<int>& without_field_last() const { return without_field_last_; }  // result of the last solve()
  // A laid-out bond that represents all bonds of a template, and the record of one of them.
  struct TemplateBond {
    int point_template;
    Bond bond;
    BondRecord record;
    bool counts = true;  // true on the first of the ranks that have the template
  };
  // Collective. Adds the laid-out bonds of templates to those that are here, or replaces these (all_anew). Solves those
  // that are new or changed. templates: number of templates. Call before solve().
  void install_templates(MPI_Comm comm, std::vector<TemplateBond> laid_out, int templates, bool all_anew, const Law& law,
                         const PenaltyParameters& links, double scaled_density);
  bool has_template(int point_template) const { return templates_.count(point_template) > 0; }
  // Calls f(bond) for each template that this rank counts, so that each template counts on one rank.
  template <class F>
  void for_each_template(F f) const {
    for (const auto& p : templates_)
      if (p.second.of.counts) f(p.second.of.bond);
  }
  // Collective. Finds the grains of the condensed bonds. Call after bonds or grains moved to other ranks.
  void bind(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains);
  bool has(int bond_row) const { return find(bond_row) != nullptr; }
  bool any() const { return pack_.any(); }  // true if any rank has condensed bonds

  // Collective. Reads the motion of the grains, and finds the loads that do not depend on their accelerations.
  void follow(const BondedGrains& grains, const double* gravity);
  // Collective. Calls follow(), then reads the accelerations of the grains, and finds the loads due to these.
  void resume(const BondedGrains& grains, const double* gravity);
  CondensedPack& pack() { return pack_; }

  struct Energies {
    double elastic = 0, kinetic = 0, discrete_kinetic = 0;            // discrete_kinetic: conserved by central differences
    double momentum[3] = {0, 0, 0}, angular_momentum[3] = {0, 0, 0};  // about the origin of the box
    void add(const Energies& e);
  };
  // Energies of the bonds that this rank owns, or of one of them.
  Energies energies(const Bonds& bonds, double half) const;
  Energies energies_of(int bond_row, const Bonds& bonds, double half) const;
  // Energies of the rigid piece on grain `piece` of a bond, with its present ends or earlier ones of ends_of_piece().
  using Ends = std::array<BondEnd, 2>;
  Energies energies_of_piece(int bond_row, int piece, const Bonds& bonds, double half, const Ends& ends) const;
  // Returns false if this rank does not have the piece.
  bool ends_of_piece(int bond_row, int piece, const Bonds& bonds, Ends& ends) const;
  // The motion of both ends of a bond.
  Ends ends_of(int bond_row, const Bonds& bonds) const;
  // owns(): does this rank own the loads of the bond? loaded_ends(): the ends with all loads of the bond on its grains.
  // energy_of_points(): elastic energy of its points. The rest of its elastic energy is in the links.
  bool owns(int bond_row) const { return find(bond_row) && find(bond_row)->owns; }
  std::array<BondEnd, 2> loaded_ends(int bond_row, const Bonds& bonds, const double* gravity) const;
  double energy_of_points(int bond_row) const;
  // Updates the peak tensions, by row, with the tension of the bonds that this rank owns, except those in pieces.
  void note_peaks(std::vector<double>& peaks) const;
  const PointSums& sums_of_points(int bond_row) const { return find(bond_row)->solution->sums; }
  std::vector<int> owned_rows() const;
  std::vector<int> rows_without_points(const Bonds& bonds) const;  // owned rows whose points are made later
  const TemplateBond& template_bond_of(const BondRecord& record) const { return templates_.at(record.point_template).of; }
  // Work in a step of the loads on the grains of this rank, and of the weight, for bonds from first_row on.
  EnergyBalance::StepWork work(const BondedGrains& grains, const Bonds& bonds, const double* gravity, double dt_last, int first_row,
                               int end_row = std::numeric_limits<int>::max()) const;
  // Work on the cement when commands changed velocities of grains between two runs, by the velocity jumps of the ends.
  double work_of_commands(const Bonds& bonds, double dt_last) const;

  // Returns the rows of this rank that are to be activated. Examines the points of a bond, or of its template, only
  // where an upper bound of the driving force does not exclude it. A nonlocal average over points of several ranks
  // needs all of them: such rows are added to `together`, and all ranks have to examine them and call note_check().
  std::vector<int> rows_due(Bonds& bonds, const CementOptions& options, const Law& law, std::vector<int>& together);
  // Records the largest root of the driving force (mpm/field_drive.h) of the points of a condensed bond on all ranks.
  // Returns whether the bond is to be activated.
  bool note_check(int bond_row, double root, const CementOptions& options, const Law& law);
  // Root of the driving force that stands for the interface of a condensed bond on this rank.
  double root_of_interface(const Bond& bond, const Law& law) const;
  bool any_shared() const { return !cut_.empty(); }  // true if ranks share a condensed bond; the same on all ranks
  // Motion of the nodes of a bond by the static fields, three numbers per node. Velocities are those for grain velocities
  // plus `later` times the grain accelerations.
  struct NodeMotion {
    std::vector<double> displacement, velocity, acceleration;
  };
  NodeMotion nodes_of(const Bond& bond, const BondRecord& record, double later) const;
  // Write the strain due to the present motion to the points of one or all condensed bonds, for code that reads points.
  void show_strain(Bond& bond) const;
  void show_strains(Bonds& bonds) const;
  // Tractions of the links of a condensed bond, as PenaltyLinks::tractions().
  std::vector<PenaltyLinks::LinkTraction> link_tractions(const Bond& bond, const BondRecord& record) const;
  // Collective. Gives points and nodes of a bond the present motion, in equilibrium with the accelerations of the
  // grains. bond: null if this rank has no share of it. dt_last: length of the last step; velocities are half of it
  // earlier.
  void activate(MPI_Comm comm, int bond_row, Bond* bond, const Bonds& bonds, const double* gravity, double dt_last, const Law& law) const;
  // May a resolved bond that is whole on this rank be condensed again? Force and energy may change by kChange of their
  // values at the damage threshold. ends: with the loads of the step. energy: energy of its nodes, points and links.
  // root: root of its largest driving force; with that of the interface it must be below `largest`.
  bool matches_static_solution(const Bond& resolved, const BondRecord& record, const BondEnd* ends, double energy, double root,
                               double largest, const double* gravity, double dt_last, const Law& law);
  // May a separated bond be condensed again: does the attached cement move with its grains as rigid pieces? Force and
  // energy may change by kChange of the largest load that the bond had, and of the energy with that load.
  bool matches_rigid_pieces(Bond& resolved, const BondRecord& record, const BondEnd* ends, double energy,
                            const LoadHistory::Largest& largest, const double* gravity, double dt_last, const Law& law);
  // Collective. Finds the models of the pieces of these separated bonds, which need not rest.
  void prepare_pieces(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows, const Law& law);
  // Momentum of a bond that is condensed again, half a step before the present time. It is distributed to both grains as
  // a load of the bond is. momentum_of_nodes(): of its nodes. momentum_as_condensed(): of the condensed bond with the
  // motion of these ends; call it after solve().
  GrainLoads momentum_of_nodes(const Bond& resolved, const BondRecord& record, const BondEnd* ends) const;
  GrainLoads momentum_as_condensed(int row, const BondRecord& record, const BondEnd* ends, double half) const;
  void forget_candidate(int bond_row) { candidates_.erase(bond_row); }
  // Forgets all candidates but resolved bonds of this rank.
  void forget_candidates_but(const Bonds& bonds);

  // Collective. Removes rows that are resolved now, ascending.
  void drop(MPI_Comm comm, const std::vector<int>& rows, const Bonds& bonds, const BondedGrains& grains);

  std::size_t memory_usage() const;
  int count() const;  // number of bonds that this rank owns

 private:
  struct Solution {
    StaticBond fields;
    std::vector<CondensedModel> models = std::vector<CondensedModel>(1);  // of the bond, or of each piece
    std::vector<signed char> grain_of_node;                               // grain of each node of a bond in pieces
    double bound[6] = {};  // bounds of the root, see find_strain_bounds() of mpm/field_drive.h
    PointSums sums;
    std::shared_ptr<const TractionLaw> interface;  // of the links, if it has a state
    Matrix6 energy = Matrix6::Zero();              // the points have the elastic energy d.energy d/2 for the relative motion d
  };
  struct Member {  // an entry of the pack: a bond or a piece
    int row;
    bool owns;
    std::shared_ptr<const Solution> solution;  // without fields if this rank has no points
    int piece = -1;                            // grain of the bond that has this piece; -1: a whole bond
    double examined_at[6] = {};                // relative motion when its points were examined last
    double margin = 0.0;                       // change of the bound that requires the next examination
  };
  const CondensedModel& model_of(std::size_t member) const {
    return members_[member].solution->models[std::max(members_[member].piece, 0)];
  }
  // Returns the record of a member: that of the table, or the one of its piece, which is written to `piece`.
  const BondRecord& record_of(std::size_t member, const Bonds& bonds, BondRecord& piece) const;
  const Member* find(int bond_row) const;
  static std::shared_ptr<const Solution> of_pieces(MPI_Comm comm, Bond* b, const BondRecord& record, const Law& law);
  static std::shared_ptr<const Solution> solved(MPI_Comm comm, Bond* b, const BondRecord& record, const Law& law,
                                                int most = kMostStaticSteps);
  bool solve_shared(MPI_Comm comm, Bonds& bonds, int row, const Law& law);  // collective; false: no convergence
  // Root of the driving force that stands for the interface: that of the onset of damage times the share of the strength
  // that the motion d of the bond takes.
  static double root_of_interface(const Solution& s, const Bond& b, const double* d, const Law& law);
  double largest_root(Bond& b, const BondRecord& record, int member, const CementOptions& options, const Law& law) const;
  bool note_check(std::size_t member, double root, const CementOptions& options, const Law& law);
  void show_strain(Bond& bond, int member) const;

  void equilibrate(MPI_Comm comm, Bond* bond, const BondRecord& record, const double* gravity, const Law& law) const;
  void pack_up(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains);
  int member_of_row(int bond_row) const;  // first member of the bond, which may have two; -1: none
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

  struct TemplateSolution {
    TemplateBond of;
    std::shared_ptr<const Solution> solution;
    std::size_t described = 0;  // hash of the description that was solved
  };
  std::map<int, TemplateSolution> templates_;
  std::map<int, std::shared_ptr<const Solution>> solutions_;  // by row, of bonds with points on this rank
  std::map<int, std::size_t> described_;                      // hashes of the descriptions that were solved
  int solved_last_ = 0;
  std::vector<int> without_field_last_;
  std::set<int> in_pieces_;
  int changes_of_surfaces_ = 0;
  std::set<int> cut_;  // rows that several ranks share, the same on all ranks
  struct Candidate {
    int layout = 0;                            // Bond::layout when it was solved
    double damage = 0.0, failed = 0.0;         // damaged volume and failed points at that time
    std::shared_ptr<const Solution> solution;  // null: no convergence
  };
  std::map<int, Candidate> candidates_;  // resolved bonds, solved to check whether they may be condensed
  std::vector<Member> members_;          // in the order of the pack, ascending in row
  CondensedPack pack_;
};

}  // namespace mpdem

#endif
