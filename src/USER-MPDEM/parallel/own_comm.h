// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_PARALLEL_OWN_COMM_H
#define MPDEM_PARALLEL_OWN_COMM_H

#include <mpi.h>

namespace mpdem {

// A communicator of the same ranks as another one, so that messages of the cement are not mistaken for those of its
// host, whatever tags both use. Construction and destruction are collective.
class OwnComm {
 public:
  explicit OwnComm(MPI_Comm of_host) { MPI_Comm_dup(of_host, &comm_); }
  ~OwnComm() { MPI_Comm_free(&comm_); }
  OwnComm(const OwnComm&) = delete;
  OwnComm& operator=(const OwnComm&) = delete;
  operator MPI_Comm() const { return comm_; }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
};

}  // namespace mpdem

#endif
