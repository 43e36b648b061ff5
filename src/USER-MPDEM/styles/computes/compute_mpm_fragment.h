// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// compute mpm/fragment: for each grain the smallest ID of the grains to which bonds join it, and how many groups of
// joined grains there are. See doc/compute_mpm_fragment.md.
#ifdef COMPUTE_CLASS

ComputeStyle(mpm / fragment, ComputeMpmFragment)

#else

#ifndef MPDEM_STYLES_COMPUTES_COMPUTE_MPM_FRAGMENT_H
#define MPDEM_STYLES_COMPUTES_COMPUTE_MPM_FRAGMENT_H

#include <map>

#include "compute.h"

namespace LAMMPS_NS {

class ComputeMpmFragment : public Compute {
 public:
  ComputeMpmFragment(LAMMPS* lmp, int& iarg, int narg, char** arg);
  ~ComputeMpmFragment() override;
  void init() override {}
  void compute_peratom() override;
  void compute_vector() override;
  double memory_usage() override;

 private:
  std::map<int, int> joined_grains() const;

  int size_ = 0;
};

}  // namespace LAMMPS_NS

#endif
#endif
