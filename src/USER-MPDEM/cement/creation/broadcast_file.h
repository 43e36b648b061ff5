// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_CEMENT_CREATION_BROADCAST_FILE_H
#define MPDEM_CEMENT_CREATION_BROADCAST_FILE_H

#include <mpi.h>

#include <string>

namespace mpdem {

// Collective. Returns the text of a file that only the first rank reads. trouble: why it cannot be read.
std::string broadcast_file(MPI_Comm comm, const std::string& name, std::string& trouble);

}  // namespace mpdem

#endif
