// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Makes sure that the text of an error is written on every path. LIGGGHTS ends a run that fails on one rank by
// MPI_Abort, which discards the buffers of stdio. With output to a file or a pipe the error itself is in these buffers,
// and it never reaches the log, which only the first rank has open. The definitions below take precedence over those of
// the libraries, see registration.cpp. LIGGGHTS' own definitions also print a joke after one error in five, from memory
// that is freed already.
#include <fcntl.h>
#include <mpi.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "abort.h"
#include "compute.h"
#include "error.h"
#include "fix.h"
#include "output.h"
#include "universe.h"

namespace mpdem {

namespace {
std::string log_name;  // log file of this world, the same on all of its ranks
}

void learn_log_name(LAMMPS_NS::LAMMPS* lmp) {
  char name[4096] = "";
  if (lmp->logfile) {
    std::fflush(lmp->logfile);
    const int fd = fileno(lmp->logfile);
    // Sets append mode: otherwise the buffer of this rank would overwrite what other ranks append.
    fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_APPEND);
    const std::string link = "/proc/self/fd/" + std::to_string(fd);
    const ssize_t n = readlink(link.c_str(), name, sizeof name - 1);
    name[n > 0 ? n : 0] = '\0';
  }
  MPI_Bcast(name, sizeof name, MPI_CHAR, 0, lmp->world);
  log_name = name;
}

}  // namespace mpdem

extern "C" int MPI_Abort(MPI_Comm comm, int code) {
  std::fflush(nullptr);
  return PMPI_Abort(comm, code);
}

namespace LAMMPS_NS {

namespace {
// LIGGGHTS adds the line of its source to a message. Messages of the package have line 0 and end with the cure, which
// may be a line to copy into a script.
std::string place(const char* file, int line) { return line > 0 ? std::string(" (") + file + ":" + std::to_string(line) + ")" : ""; }
}  // namespace

void Error::one(const char* file, int line, const char* text) {
  int me;
  MPI_Comm_rank(world, &me);
  // With `-screen file` only the first rank has a screen, and with `-screen none` no rank has one.
  const std::string message = text + place(file, line);
  std::fprintf(screen ? screen : stderr, "ERROR on proc %d: %s\n", me, message.c_str());
  if (universe->nworlds > 1 && universe->uscreen) std::fprintf(universe->uscreen, "ERROR on proc %d: %s\n", universe->me, message.c_str());
  std::FILE* log = logfile ? logfile : mpdem::log_name.empty() ? nullptr : std::fopen(mpdem::log_name.c_str(), "a");
  if (log) std::fprintf(log, "ERROR on proc %d: %s\n", me, message.c_str());
  MPI_Abort(world, 1);
}

// Collective among the ranks of the world.
void Error::all(const char* file, int line, const char* text) {
  MPI_Barrier(world);
  int me;
  MPI_Comm_rank(world, &me);
  if (me == 0)
    for (std::FILE* f : {screen, logfile})
      if (f) std::fprintf(f, "ERROR: %s%s\n", text, place(file, line).c_str());
  std::fflush(nullptr);
  delete output;
  if (screen && screen != stdout) std::fclose(screen);
  if (logfile) std::fclose(logfile);
  if (universe->nworlds > 1) MPI_Abort(universe->uworld, 1);
  MPI_Finalize();
  std::exit(1);
}

// Errors of the command line, before there are worlds.
void Error::universe_all(const char* file, int line, const char* text) {
  MPI_Barrier(universe->uworld);
  if (universe->me == 0)
    for (std::FILE* f : {universe->uscreen, universe->ulogfile})
      if (f) std::fprintf(f, "ERROR: %s (%s:%d)\n", text, file, line);
  std::fflush(nullptr);
  MPI_Finalize();
  std::exit(1);
}

void Error::universe_one(const char* file, int line, const char* text) {
  if (universe->uscreen) std::fprintf(universe->uscreen, "ERROR on proc %d: %s (%s:%d)\n", universe->me, text, file, line);
  MPI_Abort(universe->uworld, 1);
}

namespace {
std::string of_style(const char* kind, const char* style, const char* id, const char* text) {
  const std::string name = std::string(kind) + " " + style + " (id " + id + ")";
  return std::strlen(text) > 2 ? name + ": " + text : "Illegal " + name + " command";  // LIGGGHTS gives no text for an illegal command
}
}  // namespace

void Error::fix_error(const char* file, int line, Fix* fix, const char* text) { fix_error(file, line, fix, fix->style, text); }
void Error::fix_error(const char* file, int line, Fix* fix, const char* style, const char* text) {
  all(file, line, of_style("Fix", style, fix->id, text).c_str());
}
void Error::compute_error(const char* file, int line, Compute* compute, const char* text) {
  all(file, line, of_style("Compute", compute->style, compute->id, text).c_str());
}

}  // namespace LAMMPS_NS
