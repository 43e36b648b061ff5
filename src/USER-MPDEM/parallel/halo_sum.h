// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Sums nodal values over the ranks that share a node. Every rank adds the same contributions in the same order
// (ascending rank). So the copies of a node stay bitwise identical and never have to be sent again. Buffers are
// allocated once.
#ifndef MPDEM_PARALLEL_HALO_SUM_H
#define MPDEM_PARALLEL_HALO_SUM_H

#include <mpi.h>

#include <vector>

#include "rendezvous.h"

namespace mpdem {

class HaloSum;

// Sums over ranks for several bonds at once, with one message to each rank for all of them, and the buffers of the messages. A
// sum allocates no memory after build(). An item is a key that two ranks share.
class HaloMessages {
 public:
  // parts: one HaloSum for each of n bonds.
  void build(const HaloSum* const* parts, std::size_t n);
  // Sums the values of these bonds. values[p]: array of parts[p], `width` doubles for each of its keys.
  void sum(const HaloSum* const* parts, double* const* values, std::size_t n, int width);

 private:
  std::size_t index_of(int rank) const;

  std::vector<int> ranks_;          // all ranks with which this rank shares a bond, ascending
  std::vector<std::size_t> items_;  // number of items shared with each of these ranks
  std::vector<std::vector<double>> send_, recv_;
  std::vector<std::size_t> read_;  // how many numbers of each message are added already
  std::vector<MPI_Request> requests_;
};

// Sums one array of nodal values over the ranks that share the nodes.
class HaloSum {
 public:
  // Collective. keys: of the nodes of this rank, ascending, each once.
  void build(MPI_Comm comm, const std::vector<Key>& keys);
  // Builds the sums of `size` keys whose sharing is known already. Not collective.
  void build(MPI_Comm comm, Sharing shared, std::size_t size);

  // Sets the number of keys in the place of build(), if no key is shared.
  void resize(std::size_t size) { counts_here_.resize(size, 1); }

  // Collective among sharing ranks. values: width doubles for each key, summed in place.
  void sum(double* values, int width);

  // counts_here()[i] is true on exactly one of the ranks that share key i, the lowest. Sums over all nodes of all ranks take
  // the node from that rank alone.
  const std::vector<char>& counts_here() const { return counts_here_; }

  std::size_t shared_items() const;
  bool shares_any() const { return !shared_.ranks.empty(); }

 private:
  friend class HaloMessages;
  // take_own() sets shared values to zero and keeps them. add_own() adds them when it is the turn of this rank.
  void take_own(double* values, int width) const;
  void add_own(double* values, int width) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  int me_ = 0;
  Sharing shared_;
  std::vector<char> counts_here_;
  std::vector<int> shared_items_;    // indices of all keys that some other rank shares, ascending
  mutable std::vector<double> own_;  // values of this rank, within a sum
  HaloMessages messages_;
};

// Sums over many arrays at once, each with its own HaloSum, with one message to each rank. The order of additions is as in HaloSum::sum().
class HaloSums {
 public:
  // parts: sums of different bonds, ascending. They are stored by address, so they must outlive this object.
  void build(const std::vector<const HaloSum*>& parts);
  // Sums the values. values[n]: array of parts[n]. Throws std::logic_error if their numbers differ.
  void sum(const std::vector<double*>& values, int width);

 private:
  std::vector<const HaloSum*> parts_;
  HaloMessages messages_;
};

}  // namespace mpdem

#endif
