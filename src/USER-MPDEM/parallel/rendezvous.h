// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds which ranks share a key. Every key has a home rank, given by its hash. Ranks report their keys there, and the
// home answers with the other ranks that have them. The cost is proportional to the keys of a rank, for any number of
// ranks and any shape of their subdomains. All functions are collective.
#ifndef MPDEM_PARALLEL_RENDEZVOUS_H
#define MPDEM_PARALLEL_RENDEZVOUS_H

#include <mpi.h>

#include <vector>

#include "key.h"

namespace mpdem {

// items[n] are the indices of the caller's keys that ranks[n] has too, in key order, so both ranks enumerate the shared
// keys in the same order. Ranks ascend.
struct Sharing {
  std::vector<int> ranks;
  std::vector<std::vector<int>> items;
};

// keys: ascending, each once.
Sharing find_sharing(MPI_Comm comm, const std::vector<Key>& keys);

// Returns `width` doubles for each wanted key: the values of any rank that has the key, or zeros. found[w] becomes 1 if some rank
// has wanted[w], else 0. values: `width` doubles for each of `keys`. keys and wanted: ascending, each once.
std::vector<double> fetch_values(MPI_Comm comm, int width, const std::vector<Key>& keys, const std::vector<double>& values,
                                 const std::vector<Key>& wanted, std::vector<char>& found);

}  // namespace mpdem

#endif
