// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "shared_nodes.h"

namespace mpdem {

void SharedNodes::bind() {
  std::vector<const HaloSum*> halos;
  cut_bonds_.clear();
  for (Bond& b : scene_.bonds().resolved()) {
    if (!b.cut_by_ranks()) continue;
    cut_bonds_.push_back(&b);
    halos.push_back(&b.grid.halo);
  }
  sums_.build(halos);
  if (!scene_.options.advance.nonlocal) return;
  const int cut = !halos.empty();
  int any;
  MPI_Allreduce(&cut, &any, 1, MPI_INT, MPI_MAX, scene_.comm);
  any_bond_is_cut_ = any != 0;
}

void SharedNodes::sum(double* (*values)(Bond&), int width) {
  std::vector<double*> of_bonds;
  for (Bond* b : cut_bonds_) of_bonds.push_back(values(*b));
  sums_.sum(of_bonds, width);
}

}  // namespace mpdem
