// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Memory a rank may take, so that an input which asks for more is told so before the machine
// begins to swap or ends some process or other.
#ifndef MPDEM_MEMORY_LIMIT_H
#define MPDEM_MEMORY_LIMIT_H

#include <mpi.h>

namespace mpdem {

// Bytes, the same on every rank: the least over all machines of physical memory over the ranks of
// `comm` there, and no more than the limits of the process (RLIMIT_AS, RLIMIT_RSS: ulimit -v, -m;
// batch systems set them). Collective.
double memory_limit(MPI_Comm comm);

}  // namespace mpdem

#endif
