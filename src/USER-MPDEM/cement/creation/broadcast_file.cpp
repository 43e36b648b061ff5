// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "broadcast_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "../../parallel/agree.h"
#include "../../parallel/ranks.h"

namespace mpdem {

std::string broadcast_file(MPI_Comm comm, const std::string& name, std::string& trouble) {
  const int me = rank_in(comm);
  std::string text;
  long long size = -1;
  int code = 0;
  if (me == 0) {
    std::FILE* f = std::fopen(name.c_str(), "rb");
    if (f) {
      char buffer[65536];
      for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, f)) > 0;) text.append(buffer, n);
      if (!std::ferror(f)) size = static_cast<long long>(text.size());
      else code = errno;
      std::fclose(f);
    } else {
      code = errno;
    }
  }
  MPI_Bcast(&code, 1, MPI_INT, 0, comm);
  MPI_Bcast(&size, 1, MPI_LONG_LONG, 0, comm);
  if (size < 0) {
    trouble = text_of("file '", name, "' cannot be read: ", std::strerror(code), "; check name and folder");
    return text;
  }
  text.resize(size);
  constexpr long long kMost = 1 << 30;  // MPI counts in int
  for (long long at = 0; at < size; at += kMost) MPI_Bcast(&text[at], static_cast<int>(std::min(kMost, size - at)), MPI_CHAR, 0, comm);
  return text;
}

}  // namespace mpdem
