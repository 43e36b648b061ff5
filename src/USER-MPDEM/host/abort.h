// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_HOST_ABORT_H
#define MPDEM_HOST_ABORT_H

#include "lammps.h"

namespace mpdem {

// Sends the name of the log file of the first rank to all ranks, so that any of them can write an error there.
// Collective. Call it whenever the log may have changed.
void learn_log_name(LAMMPS_NS::LAMMPS* lmp);

}  // namespace mpdem

#endif
