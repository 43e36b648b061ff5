// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Holds what keeps nodes of a bond apart: nodes that are split, and what is known of its cracks. Layouts follow it
// (layout.h), and Parting changes it.
#ifndef MPDEM_CEMENT_FAILURE_DISCONTINUITIES_H
#define MPDEM_CEMENT_FAILURE_DISCONTINUITIES_H

#include <memory>

#include "cracks.h"
#include "node_splitting.h"

namespace mpdem {

struct Discontinuities {
  std::unique_ptr<NodeSplitting> splits;
  Cracks cracks;
};

}  // namespace mpdem

#endif
