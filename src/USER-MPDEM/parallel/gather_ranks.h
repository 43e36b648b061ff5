// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Gathers plain values of all ranks, in the order of the ranks: on all ranks, or on the first. Collective.
#ifndef MPDEM_PARALLEL_GATHER_RANKS_H
#define MPDEM_PARALLEL_GATHER_RANKS_H

#include <mpi.h>

#include <numeric>
#include <vector>

#include "ranks.h"

namespace mpdem {

// Indices at which the values of each rank begin.
inline std::vector<int> starts_of(const std::vector<int>& counts) {
  std::vector<int> starts(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  return starts;
}

// MPI type for T. It exists as long as the object.
template <class T>
class TypeOf {
 public:
  TypeOf() {
    MPI_Type_contiguous(sizeof(T), MPI_BYTE, &type_);
    MPI_Type_commit(&type_);
  }
  ~TypeOf() { MPI_Type_free(&type_); }
  TypeOf(const TypeOf&) = delete;
  TypeOf& operator=(const TypeOf&) = delete;
  operator MPI_Datatype() const { return type_; }

 private:
  MPI_Datatype type_;
};

template <class T>
std::vector<T> gather_all(MPI_Comm comm, const std::vector<T>& mine) {
  const int count = static_cast<int>(mine.size());
  std::vector<int> counts(ranks_of(comm));
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  const std::vector<int> at = starts_of(counts);
  std::vector<T> all(at.back() + counts.back());
  if (all.empty()) return all;
  const TypeOf<T> type;
  MPI_Allgatherv(mine.data(), count, type, all.data(), counts.data(), at.data(), type, comm);
  return all;
}

// Gathers the values on the first rank. Returns an empty list on the other ranks.
template <class T>
std::vector<T> gather_on_first(MPI_Comm comm, const std::vector<T>& mine) {
  const int count = static_cast<int>(mine.size());
  std::vector<int> counts(ranks_of(comm));
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  const std::vector<int> at = starts_of(counts);
  std::vector<T> all(rank_in(comm) == 0 ? at.back() + counts.back() : 0);
  const TypeOf<T> type;
  MPI_Gatherv(mine.data(), count, type, all.data(), counts.data(), at.data(), type, 0, comm);
  return all;
}

}  // namespace mpdem

#endif
