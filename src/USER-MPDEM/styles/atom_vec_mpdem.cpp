// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "atom_vec_mpdem.h"

#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <limits>

#include "../mpm/checked_numbers.h"
#include "../version.h"
#include "arguments.h"
#include "atom.h"
#include "comm.h"
#include "fix.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

namespace {
constexpr int kGrainNumbers = sizeof(AtomVecMpdem::GrainState) / sizeof(double);
constexpr int kSphereNumbers = 17;  // of an atom of style sphere, before those of fixes
constexpr int kPlainState = 1, kGrainState = 1 + kGrainNumbers;
enum Kind { kNoState = 0, kPoint = 1, kGrain = 2 };
}  // namespace

// Every scene with cement begins here, in whatever program the package is: by `atom_style`, and by `read_restart`
// once more. A log needs to name the version once.
AtomVecMpdem::AtomVecMpdem(LAMMPS* lmp) : AtomVecSphere(lmp) {
  static FILE* told = nullptr;
  if (comm->me != 0 || (told && told == logfile)) return;
  told = logfile;
  for (FILE* f : {screen, logfile})
    if (f) std::fprintf(f, "USER-MPDEM %s\n", mpdem::kVersion);
}

AtomVecMpdem::~AtomVecMpdem() { memory->destroy(slot); }

AtomVecMpdem* AtomVecMpdem::of(LAMMPS* lmp) { return dynamic_cast<AtomVecMpdem*>(lmp->atom->avec); }

void AtomVecMpdem::track_orientation(int i) {
  if (slot[i] != kPlain) return;
  if (grains.size() == grains.capacity()) drop_grains_that_left();
  grains.emplace_back();
  slot[i] = -2 - (static_cast<int>(grains.size()) - 1);
}

// LIGGGHTS does not tell of atoms that go to another rank or are deleted. Half of the room is free then, so
// that this is not done at every arrival.
void AtomVecMpdem::drop_grains_that_left() {
  std::vector<GrainState> here;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (slot[i] > -2) continue;
    here.push_back(*grain(i));
    slot[i] = -2 - (static_cast<int>(here.size()) - 1);
  }
  here.reserve(std::max<std::size_t>(64, 2 * here.size()));
  grains.swap(here);
}

// At the start of a run; other commands that look at all styles call this too.
void AtomVecMpdem::init() {
  AtomVecSphere::init();
  waiting.finish(lmp);
  if (update->whichflag == 0 || update->nsteps == 0 || bodies.empty()) return;
  // fix mpm/couple says itself that its fix mpm is gone, and which it was
  for (int k = 0; k < modify->nfix; ++k)
    if (std::strcmp(modify->fix[k]->style, "mpm") == 0 || std::strcmp(modify->fix[k]->style, "mpm/couple") == 0) return;
  mpdem::stop_all(lmp, mpdem::text_of("atom_style mpdem: grains ", bodies[0].grain[0], " and ", bodies[0].grain[1],
                                      " have cement, but there is no fix mpm, without which it would hang in the air and bond nothing; define "
                                      "fix mpm and fix mpm/couple before the run (after read_restart with the same IDs)"));
}

void AtomVecMpdem::grow(int n) {
  AtomVecSphere::grow(n);
  memory->grow(slot, nmax, "atom:mpdem_slot");
}

void AtomVecMpdem::copy(int i, int j, int delflag) {
  slot[j] = slot[i];
  AtomVecSphere::copy(i, j, delflag);
}

int AtomVecMpdem::pack_state(int i, double* buf) const {
  int m = 0;
  if (slot[i] >= 0) {
    buf[m++] = kPoint;
    m += points.record(slot[i]).pack(&buf[m]);
  } else if (slot[i] <= -2) {
    buf[m++] = kGrain;
    std::memcpy(&buf[m], &grains[-2 - slot[i]], sizeof(GrainState));
    m += kGrainNumbers;
  } else {
    buf[m++] = kNoState;
  }
  return m;
}

int AtomVecMpdem::unpack_state(int i, const double* buf) {
  int m = 0;
  slot[i] = kPlain;
  const int kind = static_cast<int>(buf[m++]);
  if (kind == kPoint) {
    mpdem::PointRecord r;
    m += r.unpack(&buf[m]);
    slot[i] = points.add(r, atom->tag[i]);
  } else if (kind == kGrain) {
    track_orientation(i);
    std::memcpy(static_cast<void*>(&grains.back()), &buf[m], sizeof(GrainState));
    m += kGrainNumbers;
  }
  return m;
}

int AtomVecMpdem::pack_exchange(int i, double* buf) {
  int m = AtomVecSphere::pack_exchange(i, buf);
  m += pack_state(i, &buf[m]);
  buf[0] = m;
  return m;
}

int AtomVecMpdem::unpack_exchange(double* buf) {
  int m = AtomVecSphere::unpack_exchange(buf);
  m += unpack_state(atom->nlocal - 1, &buf[m]);
  return m;
}

// Exact: the file gets as many numbers as are announced here.
int AtomVecMpdem::size_restart() {
  int n = AtomVecSphere::size_restart();
  const int point_state = 1 + (points.motion.empty() ? mpdem::PointRecord::kPacked : mpdem::PointRecord::kPackedMoving);
  for (int i = 0; i < atom->nlocal; ++i)
    n += 1 + (slot[i] >= 0 ? point_state : slot[i] <= -2 ? kGrainState : kPlainState);
  return n;
}

// State and its length follow what the fixes wrote, and are taken off again before the
// base class hands the rest to the fixes.
int AtomVecMpdem::pack_restart(int i, double* buf) {
  int m = AtomVecSphere::pack_restart(i, buf);
  const int n = pack_state(i, &buf[m]);
  m += n;
  buf[m++] = n + 1;
  buf[0] = m;
  return m;
}

// What is wrong with the numbers of an atom in a restart file, of which the last `own` are state and its length.
std::string AtomVecMpdem::trouble_in_atom(const double* buf, int total, int own) const {
  const auto whole = [](double v) { return ubuf(v).i; };
  const int fixes = total - own - kSphereNumbers;
  if (fixes < 0 || !waiting.fits(lmp, buf + kSphereNumbers, fixes)) return "the state of fixes is not as long as the file says";
  mpdem::CheckedNumbers in(nullptr);
  if (whole(buf[4]) < 1 || whole(buf[4]) > std::numeric_limits<int>::max()) in.tell(mpdem::text_of("its ID is ", whole(buf[4])));
  if (whole(buf[5]) < 1 || whole(buf[5]) > atom->ntypes) in.tell(mpdem::text_of("its type is ", whole(buf[5]), ", allowed is 1 to ", atom->ntypes));
  constexpr double kLargest = mpdem::CheckedNumbers::kLargest;
  for (int d = 0; d < 3; ++d) {
    in.check("its velocity", buf[8 + d], -kLargest, kLargest);
    in.check("its angular velocity", buf[14 + d], -kLargest, kLargest);
  }
  in.check("its radius", buf[11], 0.0, kLargest);
  in.check("its mass", buf[12], 0.0, kLargest);
  in.check("its density", buf[13], 0.0, kLargest);
  if (!in.trouble().empty()) return in.trouble();

  const double* state = buf + total - own;
  const int length = own - 1;
  if (state[0] == kNoState && length == kPlainState) return "";
  if (state[0] == kPoint && (length == 1 + mpdem::PointRecord::kPacked || length == 1 + mpdem::PointRecord::kPackedMoving)) {
    mpdem::PointRecord r;
    if (mpdem::PointRecord::packed_moving(state + 1) != (length == 1 + mpdem::PointRecord::kPackedMoving)) return "the state of a point is not as long as the file says";
    return r.unpack_checked(state + 1, bodies);
  }
  if (state[0] == kGrain && length == kGrainState) {
    GrainState g;
    std::memcpy(static_cast<void*>(&g), state + 1, sizeof g);
    in.check_quaternion("its orientation", g.q);
    for (int n = 1; n < kGrainState; ++n) in.check("the state of a bonded grain", state[n], -kLargest, kLargest);
    in.check_integer("'has been seen'", g.seen, 0.0, 1.0);
    in.check_integer("'has a place'", g.placed, 0.0, 1.0);
    return in.trouble();
  }
  return mpdem::text_of("its state is of kind ", state[0], " and ", length, " numbers long, which none is");
}

int AtomVecMpdem::unpack_restart(double* buf) {
  // That the file is as it was written is known from its seal, if it has one, see host/restart_seal.cpp.
  const double most = kSphereNumbers + atom->nextra_store + std::max(kGrainState, 1 + mpdem::PointRecord::kPackedMoving) + 1;
  const int total = buf[0] > kSphereNumbers && buf[0] <= most ? static_cast<int>(buf[0]) : 1;
  const double own_length = buf[total - 1];
  const int own = own_length > 1.0 && own_length < total ? static_cast<int>(own_length) : 0;
  const std::string trouble = own == 0 || own != own_length || total != buf[0] ? "its number of numbers is wrong" : trouble_in_atom(buf, total, own);
  if (!trouble.empty())
    mpdem::stop_one(lmp, mpdem::text_of("read_restart: the file is damaged in the data of an atom (ID ", ubuf(buf[4]).i, "): ", trouble,
                                        "; use another restart file"));
  buf[0] = total - own;
  AtomVecSphere::unpack_restart(buf);
  buf[0] = total;
  unpack_state(atom->nlocal - 1, &buf[total - own]);
  return total;
}

void AtomVecMpdem::write_restart_settings(FILE* fp) {
  fwrite(kRestartMagic, 1, sizeof kRestartMagic, fp);
  const int head[kRestartHead] = {kRestartVersion, static_cast<int>(sizeof(mpdem::Body)), static_cast<int>(bodies.size()),
                                  restart_is_sealed};
  fwrite(head, sizeof(int), kRestartHead, fp);
  if (!bodies.empty()) fwrite(bodies.data(), sizeof(mpdem::Body), bodies.size(), fp);
  fwrite(kRestartMagic, 1, sizeof kRestartMagic, fp);
}

// Called by every rank; only the first has the file.
void AtomVecMpdem::read_restart_settings(FILE* fp) {
  int me;
  MPI_Comm_rank(world, &me);
  std::string trouble;
  int count = 0;
  if (me == 0) {
    char magic[sizeof kRestartMagic];
    int head[kRestartHead] = {0, 0, 0, 0};
    const auto marked = [&] { return fread(magic, 1, sizeof magic, fp) == sizeof magic && std::memcmp(magic, kRestartMagic, sizeof magic) == 0; };
    const std::string cure = "; use another restart file";
    if (!marked()) {
      trouble = "the file has no data of atom_style mpdem";
    } else if (fread(head, sizeof(int), kRestartHead, fp) != kRestartHead) {
      trouble = "the file is truncated in the data of atom_style mpdem";
    } else if (head[0] != kRestartVersion) {
      trouble = mpdem::text_of("data of atom_style mpdem of version ", head[0], ", this program reads version ", kRestartVersion);
    } else if (head[1] != static_cast<int>(sizeof(mpdem::Body)) || head[2] < 0) {
      trouble = mpdem::text_of("the file is damaged: it has ", head[2], " bonds of ", head[1], " bytes, this program writes ", sizeof(mpdem::Body),
                               " bytes a bond", cure);
    } else if (head[2] > mpdem::kMaxBodies) {
      trouble = mpdem::text_of("the file has ", head[2], " bonds, this program takes ", mpdem::kMaxBodies,
                               " at most; use the program that wrote it");
    } else {
      count = head[2];
      bodies.resize(count);
      if (fread(bodies.data(), sizeof(mpdem::Body), bodies.size(), fp) != bodies.size())
        trouble = "the file is truncated in the data of atom_style mpdem";
      else if (!marked())
        trouble = mpdem::text_of("the file is damaged: it says ", count, " bonds, which is not how many it has", cure);
    }
    for (int b = 0; b < count && trouble.empty(); ++b) {
      const std::string wrong = trouble_of(bodies[b]);
      if (!wrong.empty())
        trouble = mpdem::text_of("the file is damaged in the data of the bond of grains ", bodies[b].grain[0], " and ", bodies[b].grain[1], ": ", wrong, cure);
    }
    if (!trouble.empty()) trouble = "read_restart: " + trouble;
  }
  mpdem::stop_if_any(lmp, trouble);
  MPI_Bcast(&count, 1, MPI_INT, 0, world);
  bodies.resize(count);
  MPI_Bcast(bodies.data(), static_cast<int>(sizeof(mpdem::Body) * bodies.size()), MPI_BYTE, 0, world);
}

void AtomVecMpdem::create_atom(int itype, double* coord) {
  AtomVecSphere::create_atom(itype, coord);
  slot[atom->nlocal - 1] = kPlain;
}

void AtomVecMpdem::data_atom(double* coord, tagint image, char** values) {
  AtomVecSphere::data_atom(coord, image, values);
  slot[atom->nlocal - 1] = kPlain;
}

bigint AtomVecMpdem::memory_usage() {
  return AtomVecSphere::memory_usage() + memory->usage(slot, nmax) + points.memory_usage() +
         static_cast<bigint>(grains.capacity() * sizeof(GrainState));
}

}  // namespace LAMMPS_NS
