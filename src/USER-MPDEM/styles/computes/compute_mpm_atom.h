// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// compute mpm/atom: one quantity of each material point, for dumps and reductions; zero for other atoms. The ID of the
// compute is the name of the dump column. See doc/compute_mpm_atom.md.
#ifdef COMPUTE_CLASS

ComputeStyle(mpm / atom, ComputeMpmAtom)

#else

#ifndef MPDEM_STYLES_COMPUTES_COMPUTE_MPM_ATOM_H
#define MPDEM_STYLES_COMPUTES_COMPUTE_MPM_ATOM_H

#include <string>
#include <vector>

#include "compute.h"
#include "../fixes/fix_mpm.h"

namespace LAMMPS_NS {

class ComputeMpmAtom : public Compute {
 public:
  ComputeMpmAtom(LAMMPS* lmp, int& iarg, int narg, char** arg);
  ~ComputeMpmAtom() override;
  void init() override;
  void compute_peratom() override;
  double memory_usage() override;

 private:
  FixMpm* find_cement() const;
  void find_values(const mpdem::Bond& bond, const mpdem::PointStore& points);

  template <class L>
  mpdem::vd value_of(const mpdem::PointStore& points, int block, const L& law) const;

  std::string cement_id_, name_;
  FixMpm* cement_ = nullptr;
  int quantity_ = 0;
  int size_ = 0;
  struct Row {
    mpdem::vd v;
  };
  std::vector<Row> value_;       // values of each block of a bond
  mpdem::Mat3<mpdem::vd> axes_;  // axes of the bond
};

}  // namespace LAMMPS_NS

#endif
#endif
