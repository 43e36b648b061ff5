// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Discontinuities of the displacement in all bonds: split nodes, and the state of cracks. Layouts read it (layout.h),
// and TopologyUpdate changes it.
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
