// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Detects the separation of bonds. One rank examines a bond as a whole after points or links have failed, and the
// pieces of a separated bond get nodes of their own (fracture/separation.h, node_splitting.h). A node shared across a
// crack still transmits force, so a bond must be examined as soon as it may be separated. To know when, a path of
// intact points from grain to grain is stored: the bond is examined when one of these points fails. Separated bonds are
// examined again at the checks. At the end of a run the ligament of each connected bond is found (fracture/ligament.h).
//
// Throws std::logic_error if ranks disagree on the bonds to be examined.
#ifndef MPDEM_CEMENT_FAILURE_CRACKS_H
#define MPDEM_CEMENT_FAILURE_CRACKS_H

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "../../fracture/separation.h"
#include "../bond/bond.h"
#include "../bond/options.h"
#include "node_splitting.h"

namespace mpdem {

class Cracks {
 public:
  // State of each row of the table, the same on all ranks except path_cut.
  struct State {
    FractureSurface separation;
    double broken_seen = 0;      // number of failed points and debonded links at the last examination
    std::vector<int> path;       // tags of the points of the path, ascending, see separation.h; empty: not known
    bool path_cut = false;       // the path is cut on this rank, or not searched yet
    std::int64_t broken_at = 0;  // step at which the bond was found broken by its load (load_history.h) though not separated; 0: not yet
  };
  const State& operator[](std::size_t row) const { return states_[row]; }
  std::size_t size() const { return states_.size(); }
  // Number of failed points and debonded links of a bond on this rank.
  static double count_broken(const Bond& bond);
  // True if nothing failed or debonded since the last examination of a separated bond. broken: count_broken(), summed
  // over the ranks.
  bool has_seen(int row, double broken) const { return broken == states_[static_cast<std::size_t>(row)].broken_seen; }
  bool separated(std::size_t row) const { return row < states_.size() && states_[row].separation.separated; }
  // True if the bond is separated or no longer carries load. In the second case `separation` has the surface of a crack
  // through the ligament, until the bond is separated.
  bool broken(std::size_t row) const { return separated(row) || (row < states_.size() && states_[row].broken_at > 0); }
  void restore(std::vector<State> states) { states_ = std::move(states); }

  // Call when all cement of a bond was removed. The bond is not examined any more, and stays intact unless it was broken.
  void forget_cement(int row);
  // Marks bonds that are new or come from a restart file for examination. Returns true if some are new. Bonds of the
  // file wait for the next step that examines bonds, so that a restarted run equals an uninterrupted one.
  bool add_bonds(std::size_t rows);
  // Records whether points that fail in this step cut the path of their bond.
  void watch(const Bond& bond);
  // Records that the film of a bond failed on this rank.
  void note_film_failure(const Bond& bond);
  // Records as watch() does whether links that debond from intact points in this step cut the path.
  void note_debonded_links(const Bond& bond);
  // Collective. True if a path is cut on any rank, or a bond waits for its first examination.
  bool some_path_is_cut(MPI_Comm comm) const;

  // Collective. Examines bonds in which points failed or links debonded: those whose path is cut and, with `with_separated`,
  // those that are separated already. residue: TractionLaw::leaves_residue(). Residue distinguishes debonding from a
  // crack beside the interface, so the width of the damage band is not used then. Rows before `from` wait.
  struct Found {
    NodeSplitting::SeparatedBonds separated_bonds;
    std::vector<int> connected;  // bonds with points whose PointRecord::connected changed; ascending
  };
  Found detect_separations(MPI_Comm comm, Bonds& bonds, const CementOptions& options, bool residue, bool with_separated, int from = 0);

  // Collective. Finds the ligament of each of these bonds, and the fracture surface that its failure would give. rows:
  // connected bonds, ascending.
  struct LigamentReport {
    double left = 0.0, whole = 0.0;  // number of points of the ligament, now and in the undamaged bond
    Separation surface;
  };
  std::vector<LigamentReport> find_ligaments(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<int>& rows,
                                             bool residue) const;

  // Collective. By row, for each slot of this rank's points: the bits of the grains to which the piece of the point is
  // attached now, see attached_grains() of fracture/separation.h. rows: ascending, the same on all ranks.
  std::map<int, std::vector<char>> attached_grains(MPI_Comm comm, const Bonds& bonds, const CementOptions& options,
                                                   const std::vector<int>& rows) const;
  // Collective. The same for the number of points of the piece of each point, see piece_sizes() of fracture/separation.h.
  std::map<int, std::vector<int>> piece_sizes(MPI_Comm comm, const Bonds& bonds, const CementOptions& options,
                                              const std::vector<int>& rows) const;

  // Collective. rows: bonds that carry no load from this step on, ascending. Records those as broken whose ligament is
  // less than that of the undamaged bond.
  void record_failures(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<int>& rows, bool residue,
                       std::int64_t step);

  // Returns `debonding` or `internal` if that has at least 90 % of the fracture surface, else `mixed`.
  static const char* mode_of(const FractureSurface& s);
  // Returns the mode of a broken bond, or `intact`.
  std::string mode(std::size_t row) const;

 private:
  void note_failure(const Bond& bond, int slot);
  std::vector<int> rows_to_check(MPI_Comm comm, const Bonds& bonds, bool with_separated, int from);
  Separation find_separation(const BondRecord& record, int row, const CementOptions& options, const std::vector<CrackPoint>& points,
                             bool residue) const;

  std::vector<State> states_;
  std::size_t registered_ = 0;  // number of rows registered by add_bonds()
  std::vector<int> cut_;        // rows whose path is cut on this rank, each once
  std::vector<int> new_;        // rows that wait for their first examination, the same on all ranks
};

}  // namespace mpdem

#endif
