// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Plain values of all ranks on all of them, in the order of the ranks. Collective.
#ifndef MPDEM_GATHER_ALL_H
#define MPDEM_GATHER_ALL_H

#include <mpi.h>

#include <vector>

namespace mpdem {

template <class T>
std::vector<T> gather_all(MPI_Comm comm, const std::vector<T>& mine) {
  int ranks;
  MPI_Comm_size(comm, &ranks);
  const int count = static_cast<int>(mine.size());
  std::vector<int> counts(ranks), at(ranks, 0);
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  for (int r = 1; r < ranks; ++r) at[r] = at[r - 1] + counts[r - 1];
  std::vector<T> all(at.back() + counts.back());
  MPI_Datatype type;
  MPI_Type_contiguous(sizeof(T), MPI_BYTE, &type);
  MPI_Type_commit(&type);
  MPI_Allgatherv(mine.data(), count, type, all.data(), counts.data(), at.data(), type, comm);
  MPI_Type_free(&type);
  return all;
}

}  // namespace mpdem

#endif
