// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Exceptions for states that end a run. The engine throws, and the host stops: the engine calls no function of its host for that. If all
// ranks see the state, all of them throw BadState with the same text. If only one rank sees it while the others wait for it, that rank
// throws OnOneRank.
#ifndef MPDEM_PARALLEL_AGREE_H
#define MPDEM_PARALLEL_AGREE_H

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

// Collective. Returns on all ranks the text of the lowest rank that has one; empty if there is none.
std::string first_text(MPI_Comm comm, const std::string& text);

// Collective. Throws BadState on all ranks if any rank has a text.
void throw_if_any(MPI_Comm comm, const std::string& text);

// Collective. Returns on all ranks the numbers that some rank has, ascending.
std::vector<int> union_of_ranks(MPI_Comm comm, const std::vector<int>& mine);

}  // namespace mpdem

#endif
