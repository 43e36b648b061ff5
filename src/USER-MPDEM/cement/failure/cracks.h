// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds bonds that come apart. Bonds in which points failed are looked at as a whole, each by one rank, and their parts
// get nodes of their own (fracture/separation.h, node_splitting.h). What is left of a shared node across a crack still pulls. So a path
// of intact points from grain to grain is remembered. Its bond is looked at as soon as one of these points fails. Bonds
// that have come apart are looked at again at the checks. For bonds that hold, the end of a run tells how much of them
// is left (fracture/ligament.h).
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
    SeparatingSurface separation;
    double broken_seen = 0;  // number of failed points and of links that let go, at the last look
    std::vector<int> path;   // tags of the points of the path, ascending, see separation.h; empty: not known
    bool path_cut = false;   // true: the path is cut on this rank
    std::int64_t broken_at =
        0;  // step at which it was found to carry nothing any more though it is not separated (load_history.h); 0: not yet
  };
  const State& operator[](std::size_t row) const { return states_[row]; }
  std::size_t size() const { return states_.size(); }
  // Has nothing failed or let go since the last look? The bond must be whole on this rank and have come apart.
  bool has_seen(const Bond& bond) const;
  bool separated(std::size_t row) const { return row < states_.size() && states_[row].separation.separated; }
  // Is the bond separated, or does it carry nothing any more? In the second case `separation` has the surface of a
  // crack through what is left, until the bond is separated.
  bool broken(std::size_t row) const { return separated(row) || (row < states_.size() && states_[row].broken_at > 0); }
  void restore(std::vector<State> states) { states_ = std::move(states); }

  // Marks bonds for a look that are new or come from a restart file. Returns true if some are new. Bonds of the file
  // wait for the step of the next look, so that a run in parts is the run as a whole.
  bool add_bonds(std::size_t rows);
  // Notes whether the path of a bond is cut by the points that fail in this step.
  void watch(const Bond& bond);
  // Notes that the film of a bond failed on this rank.
  void watch_film(const Bond& bond);
  // Does the same for links that let go in this step of points that hold.
  void watch_links(const Bond& bond);
  // Collective. Is a path cut on any rank, or does a bond wait for its first look?
  bool some_path_is_cut(MPI_Comm comm) const;

  // Collective. Looks at bonds in which points failed or links let go: those whose path is cut, and those that have
  // come apart already if `debris`. skins: TractionLaw::leaves_residue(). Skins tell what let go from what broke beside
  // it, so the band of a crack does not count there. Rows before `from` wait.
  struct Found {
    NodeSplitting::CameApart came_apart;
    std::vector<int> held;  // bonds whose points hold to other grains now, PointRecord::holds; ascending
  };
  Found detect_separations(MPI_Comm comm, Bonds& bonds, const CementOptions& options, bool residue, bool fragment, int from = 0);

  // Collective. The ligament of each of these rows of bonds that hold, ascending, and the separating surface if the
  // ligament failed.
  struct Ahead {
    double left = 0.0, whole = 0.0;  // points of the ligament that hold; points of the ligament of the unbroken bond
    Separation surface;              // separating surface if the ligament failed
  };
  std::vector<Ahead> ahead(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<int>& rows,
                           bool residue) const;

  // Collective. For each slot of these bonds of which this rank has points, by row: the bits of the grains to which its piece is
  // attached now, see grains_held() of fracture/separation.h. rows: ascending, the same on all ranks.
  std::map<int, std::vector<char>> grains_held(MPI_Comm comm, const Bonds& bonds, const CementOptions& options,
                                               const std::vector<int>& rows) const;

  // Collective. Notes that these bonds, ascending, carry nothing any more since this step. Those of them that are not
  // whole count as broken.
  void record_failures(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<int>& rows, bool residue,
                       std::int64_t step);

  // Returns `debonding`, `internal` or `mixed`.
  static const char* mode_of(const SeparatingSurface& s);
  // Returns the mode of a broken bond, or `intact`.
  std::string mode(std::size_t row) const;

 private:
  void note(const Bond& bond, int slot);
  std::vector<int> rows_to_check(MPI_Comm comm, const Bonds& bonds, bool fragment, int from);
  Separation find_separation(const BondRecord& record, int row, const CementOptions& options, const std::vector<CrackPoint>& points,
                             bool residue) const;

  std::vector<State> states_;
  std::size_t with_path_ = 0;  // number of rows that this object has taken up
  std::vector<int> cut_;       // rows whose path is cut on this rank, each once
  std::vector<int> new_;       // rows that wait for their first look, the same on all ranks
};

}  // namespace mpdem

#endif
