// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Which grains are elastic, and the patches of their surfaces to which cement is attached, in the table of bonds.
#ifndef MPDEM_CEMENT_LAYOUT_ELASTIC_GRAINS_H
#define MPDEM_CEMENT_LAYOUT_ELASTIC_GRAINS_H

#include <mpi.h>

#include <array>
#include <vector>

#include "../../grain/elastic_sphere.h"
#include "../bond/bond.h"

namespace mpdem {

// Elasticity of both grains of a row of the table.
using ElasticPair = std::array<GrainElasticity, 2>;

// Collective. Sets the elasticity of the grains of all bonds, the same on all ranks. A patch is found when its grain becomes elastic,
// and stays. Throws BadState on all ranks if a bond that has moved had others.
void set_elastic_grains(MPI_Comm comm, Bonds& bonds, const std::vector<ElasticPair>& of_rows);

}  // namespace mpdem

#endif
