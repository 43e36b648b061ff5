// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Event log of fix mpm: one line for each point that fails, and for each link that lets go of a point that holds.
// Events wait on their rank. They are gathered at the checks and ordered by step and ID. So the file is the same on any
// number of ranks.
#ifndef MPDEM_FAILURE_LOG_H
#define MPDEM_FAILURE_LOG_H

#include <mpi.h>

#include <string>
#include <vector>

#include "../cement/bond.h"
#include "table_file.h"

namespace mpdem {

class FailureLog {
 public:
  // An empty name means no log.
  void name(const std::string& file) { name_ = file; }
  const std::string& file() const { return name_; }
  bool is_open() const { return open_; }

  // Note points that fail, with the links that let go with them, columns of a film that fail, and links that let go of
  // points that hold. A column that fails breaks inside.
  void add(const Bond& bond, const Body& body, long step, double time);
  void add_film(const Bond& bond, const Body& body, long step, double time);
  void add_links(const Bond& bond, const Body& body, long step, double time);
  // Collective. Opens the file as TableFile::open() does. Returns what went wrong, or an empty text.
  std::string open(MPI_Comm comm, double last_kept);
  // Collective. Writes the events that wait. Returns what went wrong, or an empty text.
  std::string write(MPI_Comm comm);

 private:
  struct Event {
    long step;
    double time;
    int point, bond, grain;  // grain 0: no link let go
    double r, theta, z, damage[3], direction[3];
  };
  // Event of the point at this slot, without step, time and grain.
  static Event event_at(const PointStore& points, int row, const Body& body, int slot);
  std::vector<Event> events_;
  std::string name_;
  TableFile file_;
  bool open_ = false;
};

}  // namespace mpdem

#endif
