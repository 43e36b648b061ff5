// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_HOST_SIGNALS_H
#define MPDEM_HOST_SIGNALS_H

namespace mpdem {

// Installs the signal handlers. SIGINT and SIGTERM write a restart file and end the run; a second one ends the program
// at once. SIGUSR1 writes a restart file, and the run continues. All ranks act at the same step.
void install_signal_handlers();

}  // namespace mpdem

#endif
