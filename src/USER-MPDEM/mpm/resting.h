// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Bonds at rest sleep: while all nodes of a field (a body, or a part of it) on this rank have
// velocity zero, a pass over its points changes nothing, and its internal force is that of the
// step before. It is kept and handed out until a node moves. Exact: a field sleeps only once a
// pass has left every bit of its points as it was (a viscous law may go on at rest).
// `total` kinematics only.
#ifndef MPDEM_RESTING_H
#define MPDEM_RESTING_H

#include <vector>

#include "advance_points.h"

namespace mpdem {

class Resting {
 public:
  // After points or grid were laid out anew: everything is awake.
  void bind(const PointStore& points, const Grid& grid);

  // advance_points() for all points, sleepers left out.
  void advance(PointStore& points, Grid& grid, const Law& law, double dt, const AdvanceOptions& options,
               AdvanceResult& result);

  struct Field {
    int field, first_block, last_block, first_node, last_node;
    bool asleep;  // in the last step
  };
  const std::vector<Field>& all() const { return fields_; }
  int fields() const { return static_cast<int>(fields_.size()); }
  int asleep() const { return asleep_; }  // in the last step

 private:
  bool moves(const Field& f, const Grid& grid) const;
  // Passes over the field and tells whether nothing changed.
  bool settle(const Field& f, PointStore& points, Grid& grid, const Law& law, double dt,
              const AdvanceOptions& options, AdvanceResult& result);

  std::vector<Field> fields_;
  std::vector<double> force_;  // of the sleepers
  std::vector<PointBlock> blocks_before_;
  std::vector<vd> state_before_;
  int asleep_ = 0;
};

}  // namespace mpdem

#endif
