// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Stress of grains times their volume, from the forces on their surfaces:
//
//   V sigma = sum of (x f^T + f x^T)/2,
//
// with the force f on the grain and the arm x from its centre to the point of the force. Tension is positive. Whatever
// presses on grains adds its forces here: bonds (Report::add_virials), contacts of LIGGGHTS between grains and with walls
// (styles/computes/compute_mpm_stress.cpp), and any other contact. Each force on each grain counts once, on any rank.
#ifndef MPDEM_CEMENT_BOND_GRAIN_VIRIAL_H
#define MPDEM_CEMENT_BOND_GRAIN_VIRIAL_H

#include <mpi.h>

#include <array>
#include <map>

#include "../../parallel/gather_ranks.h"

namespace mpdem {

class GrainVirial {
 public:
  using Sum = std::array<double, 6>;  // xx, yy, zz, xy, xz, yz, in units of energy

  void clear() { of_grain_.clear(); }
  // tag: ID of the grain. force, arm: in the axes of the box.
  void add(int tag, const double* force, const double* arm) {
    static constexpr int kFirst[] = {0, 1, 2, 0, 0, 1}, kSecond[] = {0, 1, 2, 1, 2, 2};
    Sum& sum = of_grain_.emplace(tag, Sum{}).first->second;
    for (int k = 0; k < 6; ++k) sum[k] += 0.5 * (arm[kFirst[k]] * force[kSecond[k]] + arm[kSecond[k]] * force[kFirst[k]]);
  }
  // Collective. Gives all ranks the sums over all ranks.
  void sum_over(MPI_Comm comm) {
    struct OfGrain {
      int tag;
      Sum sum;
    };
    std::vector<OfGrain> mine;
    for (const auto& g : of_grain_) mine.push_back({g.first, g.second});
    of_grain_.clear();
    for (const OfGrain& g : gather_all(comm, mine)) {
      Sum& sum = of_grain_.emplace(g.tag, Sum{}).first->second;
      for (int k = 0; k < 6; ++k) sum[k] += g.sum[k];
    }
  }
  Sum of(int tag) const {
    const auto at = of_grain_.find(tag);
    return at == of_grain_.end() ? Sum{} : at->second;
  }

 private:
  std::map<int, Sum> of_grain_;
};

}  // namespace mpdem

#endif
