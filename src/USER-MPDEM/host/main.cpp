// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// liggghts-mpdem: LIGGGHTS' own driver, linked with the package.
#include <mpi.h>

#include "input.h"
#include "lammps.h"
#include "signals.h"

int main(int argc, char** argv) {
  mpdem::install_signal_handlers();
  MPI_Init(&argc, &argv);
  auto* liggghts = new LAMMPS_NS::LAMMPS(argc, argv, MPI_COMM_WORLD);
  liggghts->input->file();
  delete liggghts;
  MPI_Finalize();
  return 0;
}
