// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Sends list out[r] of plain values to each rank r and returns the received values, ordered by source. Collective.
#ifndef MPDEM_PARALLEL_ALL_TO_ALL_H
#define MPDEM_PARALLEL_ALL_TO_ALL_H

#include <mpi.h>

#include <vector>

#include "gather_ranks.h"

namespace mpdem {

template <class T>
struct Received {
  std::vector<T> data;
  std::vector<int> count;  // number of values from each source rank
};

template <class T>
Received<T> all_to_all(MPI_Comm comm, const std::vector<std::vector<T>>& out) {
  const int ranks = static_cast<int>(out.size());
  std::vector<int> send(ranks), recv(ranks);
  for (int r = 0; r < ranks; ++r) send[r] = static_cast<int>(out[r].size());
  MPI_Alltoall(send.data(), 1, MPI_INT, recv.data(), 1, MPI_INT, comm);
  const std::vector<int> send_at = starts_of(send), recv_at = starts_of(recv);
  std::vector<T> flat;
  for (const auto& v : out) flat.insert(flat.end(), v.begin(), v.end());
  Received<T> in;
  in.count = recv;
  in.data.resize(recv_at.back() + recv.back());
  const TypeOf<T> type;
  MPI_Alltoallv(flat.data(), send.data(), send_at.data(), type, in.data.data(), recv.data(), recv_at.data(), type, comm);
  return in;
}

}  // namespace mpdem

#endif
