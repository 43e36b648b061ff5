// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// compute mpm/stress: stress of grains from the forces of bonds and contacts on them, as mean over a volume and for each
// grain. See doc/compute_mpm_stress.md.
#ifdef COMPUTE_CLASS

ComputeStyle(mpm / stress, ComputeMpmStress)

#else

#ifndef MPDEM_STYLES_COMPUTES_COMPUTE_MPM_STRESS_H
#define MPDEM_STYLES_COMPUTES_COMPUTE_MPM_STRESS_H

#include <memory>
#include <string>

#include "../../cement/bond/grain_virial.h"
#include "../atoms/contact_forces.h"
#include "compute.h"

namespace LAMMPS_NS {

class ComputeMpmStress : public Compute {
 public:
  ComputeMpmStress(LAMMPS* lmp, int& iarg, int narg, char** arg);
  ~ComputeMpmStress() override;
  void init() override;
  void compute_vector() override;
  void compute_peratom() override;
  double memory_usage() override;

 private:
  std::string who() const;
  void find_virials();
  double volume() const;

  std::string variable_;       // equal-style variable with the volume; empty: none
  double given_volume_ = 0.0;  // 0: that of the box
  mpdem::GrainVirial virial_;  // over all ranks, of step found_at_
  bigint found_at_ = -1;
  std::unique_ptr<mpdem::ContactForces> contacts_;  // made when first needed
  int size_ = 0;
};

}  // namespace LAMMPS_NS

#endif
#endif
