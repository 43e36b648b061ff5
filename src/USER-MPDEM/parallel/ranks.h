// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_PARALLEL_RANKS_H
#define MPDEM_PARALLEL_RANKS_H

#include <mpi.h>

namespace mpdem {

inline int ranks_of(MPI_Comm comm) {
  int ranks;
  MPI_Comm_size(comm, &ranks);
  return ranks;
}

inline int rank_in(MPI_Comm comm) {
  int me;
  MPI_Comm_rank(comm, &me);
  return me;
}

}  // namespace mpdem

#endif
