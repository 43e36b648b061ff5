// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "leaving_atoms.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "../../numerics/length.h"
#include "../../numerics/sort_unique.h"
#include "../words/arguments.h"
#include "atom.h"
#include "domain.h"
#include "local_atom.h"
#include "update.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {
constexpr int kFixedBoundary = 1;  // value in Domain::boundary
constexpr double kFastest = 0.5;   // cells per step of the cement; faster motion is unstable
}  // namespace

bool left_the_box(const Domain& box, int d, double x) {
  return (box.boundary[d][0] == kFixedBoundary && x < box.boxlo[d]) || (box.boundary[d][1] == kFixedBoundary && x >= box.boxhi[d]);
}

// x: position of the point of atom i in `slot`.
void LeavingAtoms::show(int i, int row, int slot, double* x) {
  // The old image flags cannot be used, since x is unwrapped here.
  atom->image[i] = ((tagint)IMGMAX << IMG2BITS) | ((tagint)IMGMAX << IMGBITS) | IMGMAX;
  domain->remap(x, atom->image[i]);
  bool noted = false;
  for (int d = 0; d < 3; ++d) {
    if (!left_the_box(*domain, d, x[d])) continue;
    if (!noted) outside_.push_back({i, row, slot, d, x[d]});
    noted = true;
    x[d] = x[d] < domain->boxlo[d] ? domain->boxlo[d] : std::nextafter(domain->boxhi[d], domain->boxlo[d]);
  }
}

void LeavingAtoms::show_points(const AtomVecMpdem& avec, Report& report) {
  outside_.clear();
  int lost = -1;
  std::vector<Report::PointMotionNow> motion;
  const auto show_store = [&](const Bond& bond, const PointStore& points, int first_slot) {
    const BondRecord& record = avec.bonds.record(bond);
    const Mat3<double> axes = axes_of(record);
    for (std::size_t b = 0; b < motion.size(); ++b)
      for (int l = 0; l < kLanes; ++l) {
        const int i = points.meta[b].occupied >> l & 1 ? local_atom(*atom, points.tags[b][l]) : -1;
        if (i < 0) continue;
        double position[3], velocity[3];
        for (int d = 0; d < 3; ++d) {
          position[d] = points.blocks[b].X[d][l] + motion[b].u[d][l];
          velocity[d] = motion[b].v[d][l];
        }
        const std::array<double, 3> x = position_in_box(record, axes, position), v = turned(axes, velocity);
        std::copy(x.begin(), x.end(), atom->x[i]);
        std::copy(v.begin(), v.end(), atom->v[i]);
        if (std::isfinite(x[0] + x[1] + x[2])) show(i, bond.row, first_slot + kLanes * static_cast<int>(b) + l, atom->x[i]);
        else lost = i;
      }
  };
  for (const Bond& bond : avec.bonds) {
    report.motion_of_points(bond, motion);
    show_store(bond, bond.points, 0);
    report.motion_of_film(bond, motion);
    show_store(bond, bond.film.points, Bond::kFilm);
  }
  stop_if_any(lmp, lost < 0 ? ""
                            : text_of(who_, "the position of material point ", atom->tag[lost], " is not finite at step ",
                                      update->ntimestep, "; check the motion of the grains, the time step and the contact model"));
}

bool LeavingAtoms::some_are_outside() const {
  int mine = !outside_.empty(), any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  return any != 0;
}

bool LeavingAtoms::may_be_outside(const AtomVecMpdem& avec) const {
  int mine = 0, any;
  for (const Bond& b : avec.bonds.resolved()) {
    if (mine || !b.points.any_failed()) continue;
    const BondRecord& record = avec.bonds.record(b);
    const Mat3<double> axes = axes_of(record);
    for (int i = 0; i < b.grid.size() && !mine; ++i) {
      double position[3];
      for (int d = 0; d < 3; ++d) position[d] = b.grid.keys[i].at(d) * b.grid.h + b.grid.displacement[3 * i + d];
      std::array<double, 3> x = position_in_box(record, axes, position);
      for (int d = 0; d < 3; ++d) mine |= left_the_box(*domain, d, x[d]);
    }
  }
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  return any != 0;
}

Departing LeavingAtoms::outside() const {
  Departing found;
  for (const Outside& o : outside_) found.outside[o.row].push_back(o.slot);
  for (auto& of_row : found.outside) sort_unique(of_row.second);
  return found;
}

std::optional<Departing> LeavingAtoms::find(const AtomVecMpdem& avec, bool points_too) {
  std::vector<int> bonded;
  for (const BondRecord& b : avec.bonds.table)
    for (int s = 0; s < 2; ++s)
      if (b.has_grain(s)) bonded.push_back(b.grain[s]);
  sort_unique(bonded);
  std::vector<char> stays(bonded.size(), 0);
  enum { kGrains, kDeleted, kOutside, kSums };  // grains inside the box; points without an atom; points beyond a face
  bigint mine[kSums] = {0, 0, points_too ? static_cast<bigint>(outside_.size()) : 0}, all[kSums];
  std::string trouble;
  for (const Bond& b : avec.bonds) mine[kDeleted] += b.size();
  for (int i = 0; i < atom->nlocal; ++i) {
    if (avec.is_point(i)) {
      --mine[kDeleted];
      continue;
    }
    const auto at = std::lower_bound(bonded.begin(), bonded.end(), atom->tag[i]);
    if (at == bonded.end() || *at != atom->tag[i]) continue;
    bool inside = true;
    for (int d = 0; d < 3; ++d) {
      inside = inside && !left_the_box(*domain, d, atom->x[i][d]);
      if (!std::isfinite(atom->x[i][d]) && trouble.empty())
        trouble = text_of(who_, "bonded grain ", atom->tag[i], " is lost at step ", update->ntimestep,
                          ": its position is not finite; check the motion of the grains, the contact "
                          "model, 'kn' of fix mpm/couple and the densities of grains and cement, and use a smaller time step");
    }
    stays[at - bonded.begin()] = inside;
    mine[kGrains] += inside;
  }
  stop_if_any(lmp, trouble);
  MPI_Allreduce(mine, all, kSums, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all[kGrains] == static_cast<bigint>(bonded.size()) && all[kDeleted] == 0 && all[kOutside] == 0) return std::nullopt;
  Departing found;
  if (points_too) found = outside();
  if (all[kGrains] < static_cast<bigint>(bonded.size())) {
    MPI_Allreduce(MPI_IN_PLACE, stays.data(), static_cast<int>(stays.size()), MPI_SIGNED_CHAR, MPI_MAX, world);
    for (std::size_t n = 0; n < bonded.size(); ++n)
      if (!stays[n]) found.grains.push_back(bonded[n]);
  }
  if (all[kDeleted] == 0) return found;
  for (const Bond& b : avec.bonds)
    b.for_each_slot([&](int slot) {
      if (local_atom(*atom, b.store_of(slot).tag(Bond::slot_in_store(slot))) < 0) found.deleted[b.row].push_back(slot);
    });
  return found;
}

std::string LeavingAtoms::place(int d, double x) const {
  return text_of(" (", "xyz"[d], " = ", x, ", box ", domain->boxlo[d], " to ", domain->boxhi[d], "); ");
}

std::string LeavingAtoms::flight(int i, double cell, double dt) const {
  const double cells = dt / cell * length(atom->v[i]);
  if (cells < kFastest) return "use a larger box or a periodic one";
  return text_of("it moves ", cells,
                 " cells a step, so the motion is unstable; check the motion of the grains, the contact model, 'kn' of fix "
                 "mpm/couple and the densities of grains and cement, and use a smaller time step");
}

void LeavingAtoms::stop_if_wrong(const Leaving& leaving, bigint of_all, double cell, double dt) const {
  const auto is_unstable = [&](int i) { return dt * length(atom->v[i]) >= kFastest * cell; };
  std::string trouble;
  for (int tag : leaving.grains) {
    const int i = local_atom(*atom, tag);
    if (i < 0 || (tag != leaving.joined_grain && !is_unstable(i))) continue;
    for (int d = 0; d < 3 && trouble.empty(); ++d)
      if (left_the_box(*domain, d, atom->x[i][d]))
        trouble = text_of(who_, "bonded grain ", tag, " is lost at step ", update->ntimestep, ": it left the simulation box",
                          place(d, atom->x[i][d]), flight(i, cell, dt));
  }
  stop_if_any(lmp, trouble);
  if (leaving.joined_grain > 0)
    stop_all(lmp, text_of(who_, "grain ", leaving.joined_grain, " has cement but was deleted or lost at step ", update->ntimestep,
                          ", and a bond that is not separated joins it to another; keep bonded grains, or use a larger box"));
  for (const Outside& o : outside_) {
    const bool attached =
        std::find(leaving.attached_outside.begin(), leaving.attached_outside.end(), atom->tag[o.atom]) != leaving.attached_outside.end();
    if (trouble.empty() && (attached || is_unstable(o.atom)))
      trouble = text_of(who_, "material point ", atom->tag[o.atom], " left the simulation box at step ", update->ntimestep,
                        place(o.direction, o.x), flight(o.atom, cell, dt));
  }
  stop_if_any(lmp, trouble);
  bigint mine = static_cast<bigint>(leaving.attached_deleted.size()), all;
  MPI_Allreduce(&mine, &all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all > 0)
    stop_all(
        lmp,
        text_of(who_, all, " of ", of_all,
                " material points were deleted that are connected to grains which stay; cement cannot be deleted by points, but the cement "
                "of a "
                "separated "
                "bond as a whole, and fragments that are connected to no grain; delete a grain whose bonds are separated, and its cement "
                "goes with it"));
}

void LeavingAtoms::remove(const std::vector<int>& tags, double dropped) {
  enum { kPoints, kAtoms, kDropped, kSums };  // points, how many of them still have an atom, and how many are dropped
  bigint mine[kSums] = {static_cast<bigint>(tags.size()), 0, static_cast<bigint>(dropped)}, all[kSums];
  for (int tag : tags) {
    const int i = local_atom(*atom, tag);
    if (i < 0) continue;
    const int last = --atom->nlocal;
    atom->avec->copy(last, i, 1);
    if (last != i) atom->map_one(atom->tag[i], i);
    atom->map_one(tag, -1);
    ++mine[kAtoms];
  }
  MPI_Allreduce(mine, all, kSums, MPI_LMP_BIGINT, MPI_SUM, world);
  atom->natoms -= all[kAtoms];
  if (all[kAtoms] > 0 && atom->map_style) {
    atom->nghost = 0;
    atom->map_init();
    atom->map_set();
  }
  outside_.clear();
  if (all[kDropped] > 0 && !dropped_reported_) {
    dropped_reported_ = true;
    tell(lmp, text_of(who_, all[kDropped], " points of cement were dropped at step ", update->ntimestep,
                      "; later ones are counted, and told when the run ends\n"));
  }
  if (all[kPoints] > all[kDropped] && !reported_flag_) {
    reported_flag_ = true;
    tell(lmp, text_of(who_, all[kPoints] - all[kDropped], " points of cement left the scene at step ", update->ntimestep,
                      "; later ones are counted, and told when the run ends\n"));
  }
}

}  // namespace mpdem
