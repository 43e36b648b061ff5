// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// liggghts-mpdem: LIGGGHTS' own driver, linked with the package.
#include <mpi.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <string>

#include "../styles/words/fix_mpm_words.h"
#include "../styles/fixes/fix_mpm_couple.h"
#include "../styles/words/word_rules.h"
#include "error.h"
#include "input.h"
#include "lammps.h"
#include "signals.h"

int main(int argc, char** argv) {
  mpdem::install_signal_handlers();
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // so that a run whose output goes to a file can be followed
  if (argc == 2 && std::strcmp(argv[1], "-options") == 0) {
    std::fputs((mpdem::listed_cement_words() + LAMMPS_NS::FixMpmCouple::listed_words() + mpdem::listed_material_words() +
                mpdem::listed_exclusions())
                   .c_str(),
               stdout);
    return 0;
  }
  MPI_Init(&argc, &argv);
  auto* liggghts = new LAMMPS_NS::LAMMPS(argc, argv, MPI_COMM_WORLD);
  try {
    liggghts->input->file();
  } catch (const std::bad_alloc&) {
    liggghts->error->one("USER-MPDEM", 0,
                         "out of memory; use fewer points (a larger 'spacing' of create_cement, "
                         "a larger 'cell' of fix mpm) or more ranks on more machines");
  } catch (const std::exception& e) {
    liggghts->error->one("USER-MPDEM", 0, (std::string("unexpected, please report: ") + e.what()).c_str());
  }
  delete liggghts;
  MPI_Finalize();
  return 0;
}
