// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Memory that a rank may use, so that an input that needs more is rejected before the machine swaps or kills processes.
#ifndef MPDEM_PARALLEL_MEMORY_LIMIT_H
#define MPDEM_PARALLEL_MEMORY_LIMIT_H

#include <mpi.h>

namespace mpdem {

// Limit in bytes, the same on every rank. It is the least value over all machines of the physical memory, divided by
// the ranks of `comm` on the machine. It is not above the limits of the process (RLIMIT_AS, RLIMIT_RSS: ulimit -v, -m;
// batch systems set them). Collective.
double memory_limit(MPI_Comm comm);

}  // namespace mpdem

#endif
