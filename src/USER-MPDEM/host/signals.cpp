// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// LIGGGHTS acts on a signal rank by rank, each at its present step, after which ranks wait for each other forever. Here
// all ranks agree every few steps on the step at which they act. This also works with `neigh_modify once yes`, with
// which LIGGGHTS does not check for signals.
#include "signals.h"

#include <mpi.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>

#include "../styles/atoms/private_access.h"
#include "neighbor.h"
#include "original.h"
#include "output.h"
#include "signal_handling.h"
#include "update.h"

namespace {

constexpr int kAgreeEvery = 10;  // steps between two agreements
volatile sig_atomic_t quit_seen = 0, restart_seen = 0;

// Writes a text with async-signal-safe functions.
void say(const char* text) {
  const ssize_t written = write(STDERR_FILENO, text, std::strlen(text));
  static_cast<void>(written);
}

extern "C" void on_quit(int) {
  if (quit_seen) {
    say("\nSecond SIGINT or SIGTERM: ending at once, without a restart file.\n");
    _Exit(EXIT_FAILURE);
  }
  quit_seen = 1;
}

extern "C" void on_restart(int) { restart_seen = 1; }

// Without a `restart` command LIGGGHTS sets the next restart to a past step after it wrote a requested file. Thermo
// output and dumps would wait for that step forever.
void keep_output_going(LAMMPS_NS::Output* output, LAMMPS_NS::bigint last_step) {
  const mpdem::RestartSchedule restarts = mpdem::restart_schedule(output);  // has references to members of `output`
  if (!restarts.any) restarts.next_single = restarts.next_double = last_step + 1;
}

}  // namespace

namespace mpdem {

void install_signal_handlers() {
  struct sigaction quit, restart;
  std::memset(&quit, 0, sizeof quit);
  std::memset(&restart, 0, sizeof restart);
  quit.sa_handler = on_quit;
  restart.sa_handler = on_restart;
  quit.sa_flags = restart.sa_flags = SA_RESTART;
  sigaction(SIGINT, &quit, nullptr);
  sigaction(SIGTERM, &quit, nullptr);  // mpirun passes an interrupt on as SIGTERM
  sigaction(SIGUSR1, &restart, nullptr);
}

}  // namespace mpdem

namespace LAMMPS_NS {

// Replaces the function of LIGGGHTS that all ranks call once a step. Returning 1 makes this a step at which a restart file can
// be written. The flags of SignalHandler tell LIGGGHTS to write one in this step, then to quit if that was asked for.
int Neighbor::decide() {
  static const auto decide_of_liggghts = mpdem::original<int (*)(Neighbor*)>("_ZN9LAMMPS_NS8Neighbor6decideEv");
  if (update->ntimestep % kAgreeEvery == 0) {
    int seen[2] = {quit_seen, restart_seen};
    MPI_Allreduce(MPI_IN_PLACE, seen, 2, MPI_INT, MPI_MAX, world);
    if (seen[0] || seen[1]) {
      restart_seen = 0;
      SignalHandler::request_quit = seen[0];
      SignalHandler::request_write_restart = SignalHandler::enable_restart_writing;
      keep_output_going(output, update->laststep);
      output->restart_requested(update->ntimestep);
      return 1;
    }
  }
  return decide_of_liggghts(this);
}

}  // namespace LAMMPS_NS
