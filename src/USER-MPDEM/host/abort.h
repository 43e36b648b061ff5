// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_HOST_ABORT_H
#define MPDEM_HOST_ABORT_H

#include "lammps.h"

namespace mpdem {

// Tells every rank the name of the log that the first rank has open, so that an error on any of them can be written
// there. Collective. Must be called whenever the log may have changed.
void learn_log_name(LAMMPS_NS::LAMMPS* lmp);

}  // namespace mpdem

#endif
