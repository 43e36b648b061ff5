// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <limits>

#include "ranks.h"

namespace mpdem {

double memory_limit(MPI_Comm comm) {
  MPI_Comm machine;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  const int ranks = ranks_of(machine);
  MPI_Comm_free(&machine);
  const double pages = static_cast<double>(sysconf(_SC_PHYS_PAGES)), page = static_cast<double>(sysconf(_SC_PAGESIZE));
  double mine = pages > 0.0 && page > 0.0 ? pages * page / ranks : std::numeric_limits<double>::max(), least;
  for (auto resource : {RLIMIT_AS, RLIMIT_RSS}) {
    rlimit r;
    if (getrlimit(resource, &r) == 0 && r.rlim_cur != RLIM_INFINITY) mine = std::min(mine, static_cast<double>(r.rlim_cur));
  }
  MPI_Allreduce(&mine, &least, 1, MPI_DOUBLE, MPI_MIN, comm);
  return least;
}

}  // namespace mpdem
