// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Sums nodal values over the ranks that share a node. Every holder adds the same
// contributions in the same order (ascending rank), so the copies of a node stay equal
// to the bit and never have to be sent again. Buffers are sized once.
#ifndef MPDEM_HALO_SUM_H
#define MPDEM_HALO_SUM_H

#include <mpi.h>

#include <vector>

#include "rendezvous.h"

namespace mpdem {

class HaloSum {
 public:
  // Collective. keys: ascending, each once.
  void build(MPI_Comm comm, const std::vector<Key>& keys);

  // Collective among sharing ranks. values: width doubles a key, summed in place.
  void sum(double* values, int width);

  // Of the ranks that hold key i, is this the one that counts it in global sums?
  const std::vector<char>& counts_here() const { return counts_here_; }

  std::size_t shared_items() const;

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  int me_ = 0;
  Sharing shared_;
  std::vector<char> counts_here_;
  std::vector<int> union_;  // shared keys, ascending
  std::vector<double> own_, send_, recv_;
  std::vector<MPI_Request> requests_;
};

}  // namespace mpdem

#endif
