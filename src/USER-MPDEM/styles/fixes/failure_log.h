// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Event log of fix mpm: one line for each point that fails, and one for each link that debonds from an intact point.
// Events are stored on their rank and gathered at the checks, sorted by step and ID, so the file is the same on any
// number of ranks.
#ifndef MPDEM_STYLES_FIXES_FAILURE_LOG_H
#define MPDEM_STYLES_FIXES_FAILURE_LOG_H

#include <string>
#include <vector>

#include "../../cement/bond/bond.h"
#include "fix.h"
#include "table_file.h"

namespace mpdem {

enum class Failed { points, film, links };

class FailureLog {
 public:
  // An empty name means no log.
  void name(const std::string& file) { name_ = file; }
  const std::string& file() const { return name_; }
  bool is_open() const { return open_; }

  // Records points that fail, with the links that debond with them; columns of a film that fail inside or debond; or
  // links that debond from intact points.
  void add(const Bond& bond, const BondRecord& record, Failed what, long step, double time);
  // Collective. Writes the stored events, and opens the file first if necessary. Stops in the name of `who` if that
  // fails. goes_on: rows up to the present time are kept.
  void write(const LAMMPS_NS::Fix* fix, LAMMPS_NS::LAMMPS* lmp, const std::string& who, bool goes_on);

 private:
  struct Event {
    long step;
    double time;
    int point, bond, grain;  // grain 0: no link debonded
    double r, theta, z, damage[3], direction[3];
  };
  // Event of the point in this slot, without step, time and grain.
  static Event event_at(const PointStore& points, int row, const BondRecord& record, int slot);
  std::vector<Event> events_;
  std::string name_;
  TableFile file_;
  bool open_ = false;
};

}  // namespace mpdem

#endif
