// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Bonds that come apart: bonds in which points failed are looked at as a whole, each by one rank, and
// their parts get nodes of their own (fracture/separation.h). What is left of a shared node across a crack
// pulls on: so a path of intact points from grain to grain is remembered, and its bond is looked at as
// soon as one of them fails; what has come apart, at the checks. Of bonds that hold, the end of a run
// tells how much of them is left (fracture/ligament.h).
#ifndef MPDEM_CEMENT_CRACKS_H
#define MPDEM_CEMENT_CRACKS_H

#include <cstdint>
#include <string>
#include <vector>

#include "../fracture/node_copies.h"
#include "../fracture/separation.h"
#include "bond.h"
#include "sheets.h"

namespace mpdem {

class Cracks {
 public:
  // Of each row of the table, the same on all ranks but for path_cut.
  struct State {
    SeparatingSurface separation;
    double broken_seen = 0;  // points that failed and links that let go, when it was looked at
    std::vector<int> path;   // tags, ascending, see separation.h; empty: not known
    bool path_cut = false;   // on this rank
    bool untied = false;     // came apart, and has no ties in the present layout
    std::int64_t broken_at = 0;  // step at which it was found to carry nothing any more though it is not separated (load_watch.h); 0: not yet
  };
  const State& operator[](std::size_t row) const { return states_[row]; }
  std::size_t size() const { return states_.size(); }
  // Has nothing failed or let go since the last look at this bond, which is whole on this rank and came apart?
  bool has_seen(const Bond& bond) const;
  bool separated(std::size_t row) const { return row < states_.size() && states_[row].separation.separated; }
  // Separated, or carries nothing any more; then separation has the surface of a crack through what is left, until the bond is separated.
  bool broken(std::size_t row) const { return separated(row) || (row < states_.size() && states_[row].broken_at > 0); }
  void restore(std::vector<State> states) { states_ = std::move(states); }

  // Bonds that are new or come from a restart file are to be looked at; true if some are new. Those of the file wait for the step of the
  // next look, so that a run in parts is the run as a whole.
  bool take_up(std::size_t rows);
  // Notes whether the path of a bond is cut by the points that fail in this step.
  void watch(const Bond& bond);
  // The same of links that let go in this step of points that hold.
  void watch_links(const Bond& bond);
  // Collective.
  bool some_path_is_cut(MPI_Comm comm) const;

  // Collective. Looks at bonds in which points failed or links let go: those whose path is cut, and what has come apart already, if debris.
  // skins: TractionLaw::keeps_skins(). They tell what let go from what broke beside it, so the band of a crack does not count there.
  // The bonds that need a new layout, the same on all ranks, and their new parts on this one.
  struct Found {
    std::vector<int> lay_out;  // ascending
    NewPartsOfBonds parts;
    std::vector<int> held;     // bonds whose points hold to other grains now, PointRecord::holds; ascending
    std::map<int, std::vector<CopyLattice::OfPiece>> pieces;  // with nodes that split: of bonds that came apart, on the ranks that looked
  };
  Found look(MPI_Comm comm, Bonds& bonds, const Sheets& sheets, const CementOptions& options, bool skins, bool debris);
  // Bonds that have ties now and come to a layout without them.
  std::vector<int> untie(const CementOptions& options);

  // Rows of bonds that hold, ascending: the ligament of each, and the separating surface if the ligament failed. Collective.
  struct Ahead {
    double left = 0.0, whole = 0.0;  // points of the ligament, and of that of the unbroken bond
    Separation surface;              // if the ligament failed
  };
  std::vector<Ahead> ahead(MPI_Comm comm, const Bonds& bonds, const Sheets& sheets, const CementOptions& options,
                           const std::vector<int>& rows, bool skins) const;

  // Collective. These bonds, ascending, carry nothing any more since this step: those of them are broken that are not whole.
  void give_way(MPI_Comm comm, const Bonds& bonds, const Sheets& sheets, const CementOptions& options, const std::vector<int>& rows, bool skins,
                std::int64_t step);

  // `debonding`, `internal` or `mixed`.
  static const char* mode_of(const SeparatingSurface& s);
  // The same, or `intact`.
  std::string mode(std::size_t row) const { return broken(row) ? mode_of(states_[row].separation) : "intact"; }

 private:
  void note(const Bond& bond, int slot);
  std::vector<int> rows_to_look_at(MPI_Comm comm, const Bonds& bonds, bool debris);
  Separation look_at(const Body& body, int row, const Sheets& sheets, const CementOptions& options,
                     const std::vector<CrackPoint>& points, bool skins) const;

  std::vector<State> states_;
  std::size_t with_path_ = 0;  // rows that were ever to be looked at by this object
  std::vector<int> cut_;        // rows whose path is cut on this rank, each once
  std::vector<int> new_;        // rows that wait for their first look, the same on all ranks
};

}  // namespace mpdem

#endif
