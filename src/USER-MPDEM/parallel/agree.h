// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// States that end a run, as exceptions: the engine knows no host that could stop. What all ranks see is thrown on all of
// them with the same text, what one rank sees and the others wait for is thrown there as OnOneRank.
#ifndef MPDEM_AGREE_H
#define MPDEM_AGREE_H

#include <mpi.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "../numerics/text_of.h"

namespace mpdem {

struct BadState : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct OnOneRank : BadState {
  using BadState::BadState;
};

// Collective. The text of the lowest rank that has one, on all ranks; empty if there is none.
std::string first_text(MPI_Comm comm, const std::string& text);

// Collective. Throws BadState on all ranks if any rank has a text.
void throw_if_any(MPI_Comm comm, const std::string& text);

// Collective. The numbers that some rank has, ascending, on all ranks.
std::vector<int> union_of_ranks(MPI_Comm comm, const std::vector<int>& mine);

}  // namespace mpdem

#endif
