// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_SIGNALS_H
#define MPDEM_SIGNALS_H

namespace mpdem {

// SIGINT, SIGTERM: write a restart file and end the run; a second one ends the program at once.
// SIGUSR1: write a restart file and go on. All ranks do so at the same step.
void install_signal_handlers();

}  // namespace mpdem

#endif
