// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// To be preloaded: MPI_Wtime() tells CPU time of the process, so that the tables of LIGGGHTS have it, whatever else runs on the machine.
#include <time.h>

extern "C" double MPI_Wtime() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
