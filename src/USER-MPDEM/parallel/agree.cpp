// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "agree.h"

#include <algorithm>

#include "../numerics/sort_unique.h"
#include "gather_ranks.h"

namespace mpdem {

std::string first_text(MPI_Comm comm, const std::string& text) {
  const int size = ranks_of(comm), mine = text.empty() ? size : rank_in(comm);
  int first;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, comm);
  if (first == size) return "";
  int length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, first, comm);
  std::string shown = text;
  shown.resize(static_cast<std::size_t>(length));
  MPI_Bcast(&shown[0], length, MPI_CHAR, first, comm);
  return shown;
}

void throw_if_any(MPI_Comm comm, const std::string& text) {
  const std::string shown = first_text(comm, text);
  if (!shown.empty()) throw BadState(shown);
}

std::vector<int> union_of_ranks(MPI_Comm comm, const std::vector<int>& mine) {
  const int some = !mine.empty();
  int any;
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, comm);  // in most calls no rank has any
  if (!any) return {};
  std::vector<int> numbers = gather_all(comm, mine);
  sort_unique(numbers);
  return numbers;
}

}  // namespace mpdem
