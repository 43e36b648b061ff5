// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Event log of fix mpm: one line for each point that fails. Events wait on their rank and are
// gathered at the checks, ordered by step and ID, so that the file is the same on any number
// of ranks.
#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "arguments.h"
#include "comm.h"
#include "files_in_use.h"
#include "fix_mpm.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::kLanes;
using mpdem::text_of;

namespace {
const char* const kHeader =
    "step,time,point,bond,grain,r,theta,z,damage1,damage2,damage3,direction_x,direction_y,direction_z,mode";
}

void FixMpm::record_events() {
  if (events_name_.empty() || advance_.failed.empty()) return;
  sort_links();
  const mpdem::PointStore& points = avec_->points;
  for (int slot : advance_.failed) {
    const int b = slot / kLanes, l = slot % kLanes;
    const mpdem::Body& body = avec_->bodies[points.meta[b].body];
    FailureEvent e{};
    e.step = static_cast<double>(update->ntimestep);
    e.time = update->get_cur_time();
    e.point = points.tags[b][l];
    e.bond = points.meta[b].body + 1;
    // of two links that of the nearer grain
    const double place[3] = {points.created_at(b)[0][l], points.created_at(b)[1][l], points.created_at(b)[2][l]};
    const int nearer = body.grain[mpdem::nearer_side(body, mpdem::nearer_to_first(body, place))];
    for (auto k = std::lower_bound(points.links.begin(), points.links.end(), slot, [](const mpdem::Link& k, int s) { return k.slot < s; });
         k != points.links.end() && k->slot == slot; ++k)
      if (e.grain == 0.0 || k->grain == nearer) e.grain = k->grain;

    // Polar coordinates about the line of centres, from the coordinate axis most across it.
    mpdem::Vector3 axis, X;
    for (int d = 0; d < 3; ++d) {
      axis[d] = body.centre[1][d] - body.centre[0][d];
      X[d] = place[d];
    }
    axis.normalize();
    int least = 0;
    for (int d = 1; d < 3; ++d)
      if (std::fabs(axis[d]) < std::fabs(axis[least]) - 1e-12) least = d;
    const mpdem::Vector3 e1 = (mpdem::Vector3::Unit(least) - axis[least] * axis).normalized(), e2 = axis.cross(e1);
    e.z = X.dot(axis);
    e.r = (X - e.z * axis).norm();
    e.theta = std::atan2(X.dot(e2), X.dot(e1));

    const mpdem::CrackOfPoint crack = mpdem::crack_of(points, slot, *law_);
    std::copy(crack.damage, crack.damage + 3, e.damage);
    std::copy(crack.normal, crack.normal + 3, e.direction);
    events_.push_back(e);
  }
}

// Collective.
void FixMpm::write_events() {
  if (events_name_.empty()) return;
  const auto check = [this](const std::string& why) {
    mpdem::stop_if_any(lmp, why.empty() ? why : text_of("fix mpm (id ", id, "): cannot write 'events' file ", why, "; name another, or use a "
                                                        "disk with free space"));
  };
  if (!events_open_) {
    std::string trouble;
    mpdem::check_only_writer(lmp, text_of("fix mpm (id ", id, "): "), "events", events_name_, this);
    if (comm->me == 0) trouble = events_file_.open(events_name_, kHeader, continued() ? static_cast<long>(events_from_) : mpdem::TableFile::kAnew);
    check(trouble);
    events_open_ = true;
  }
  constexpr int kWidth = sizeof(FailureEvent) / sizeof(double);
  int mine = kWidth * static_cast<int>(events_.size());
  std::vector<int> counts(comm->nprocs), at(comm->nprocs, 0);
  MPI_Gather(&mine, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, world);
  std::vector<FailureEvent> all;
  if (comm->me == 0) {
    for (int r = 1; r < comm->nprocs; ++r) at[r] = at[r - 1] + counts[r - 1];
    all.resize((at.back() + counts.back()) / kWidth);
  }
  MPI_Gatherv(events_.data(), mine, MPI_DOUBLE, all.data(), counts.data(), at.data(), MPI_DOUBLE, 0, world);
  events_.clear();
  std::sort(all.begin(), all.end(), [](const FailureEvent& a, const FailureEvent& b) {
    return a.step != b.step ? a.step < b.step : a.point < b.point;
  });
  std::string rows;
  for (const FailureEvent& e : all)
    mpdem::append(rows, "%.0f,%.10g,%.0f,%.0f,%.0f,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.6f,%.6f,%.6f,%s\n", e.step, e.time, e.point, e.bond,
                  e.grain, e.r, e.theta, e.z, e.damage[0], e.damage[1], e.damage[2], e.direction[0], e.direction[1], e.direction[2],
                  e.grain > 0 ? "debonding" : "internal");
  check(rows.empty() ? "" : events_file_.write(rows));
}

}  // namespace LAMMPS_NS
