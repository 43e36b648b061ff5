// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "failure_log.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "../../geometry/shape.h"
#include "../../mpm/point_state.h"
#include "../../parallel/gather_ranks.h"
#include "../words/arguments.h"
#include "comm.h"
#include "files_in_use.h"
#include "update.h"

namespace mpdem {

namespace {
const char* const kHeader = "step,time,point,bond,grain,r,theta,z,damage1,damage2,damage3,direction_x,direction_y,direction_z,mode";
}

FailureLog::Event FailureLog::event_at(const PointStore& points, int row, const BondRecord& record, int slot) {
  Event e{};
  e.point = points.tag(slot);
  e.bond = row + 1;

  // Coordinates are polar about the line of centres, from the middle of the gap. The angle is measured from the axis of
  // the box that is closest to perpendicular to that line.
  const Mat3<double> axes = axes_of(record);
  double between[3], distance = 0.0, position[3];
  for (int d = 0; d < 3; ++d) {
    between[d] = record.centre[1][d] - record.centre[0][d];
    distance += between[d] * between[d];
  }
  const double share = share_to_middle(record, std::sqrt(distance));
  for (int d = 0; d < 3; ++d) position[d] = points.created_at(slot / kLanes)[d][slot % kLanes] - (record.centre[0][d] + share * between[d]);
  const Vector3 axis = Vector3(turned(axes, between).data()).normalized(), X(turned(axes, position).data());
  int least = 0;
  for (int d = 1; d < 3; ++d)
    if (std::fabs(axis[d]) < std::fabs(axis[least]) - 1e-12) least = d;
  const Vector3 e1 = (Vector3::Unit(least) - axis[least] * axis).normalized(), e2 = axis.cross(e1);
  e.z = X.dot(axis);
  e.r = (X - e.z * axis).norm();
  e.theta = std::atan2(X.dot(e2), X.dot(e1));

  const CrackOfPoint crack = crack_of(points, slot);
  std::copy(crack.damage, crack.damage + 3, e.damage);
  const std::array<double, 3> normal = without_sign(turned(axes, crack.normal));
  std::copy(normal.begin(), normal.end(), e.direction);
  return e;
}

void FailureLog::add(const Bond& bond, const BondRecord& record, Failed what, long step, double time) {
  if (name_.empty()) return;
  const PointStore& points = what == Failed::film ? bond.film.points : bond.points;
  const auto note = [&](int slot, int grain) {
    Event e = event_at(points, bond.row, record, slot);
    e.step = step;
    e.time = time;
    e.grain = grain;
    events_.push_back(e);
  };
  const std::vector<int>& gone = bond.debonded_with_points;  // links, ascending in the slot of their point
  for (int slot : what == Failed::points ? bond.failed : std::vector<int>()) {
    // A point may have links to both grains. The row names the nearer grain.
    double position[3];
    int grain = 0;
    for (int d = 0; d < 3; ++d) position[d] = points.created_at(slot / kLanes)[d][slot % kLanes];
    const int nearer = record.grain[nearer_grain(record, nearer_to_first(record, position))];
    for (auto k = std::lower_bound(gone.begin(), gone.end(), slot, [&](int link, int s) { return points.links[link].slot < s; });
         k != gone.end() && points.links[*k].slot == slot; ++k)
      if (grain == 0 || points.links[*k].grain == nearer) grain = points.links[*k].grain;
    note(slot, grain);
  }
  for (int slot : what == Failed::film ? bond.film.failed : std::vector<int>()) note(slot, 0);
  for (int link : what == Failed::film ? bond.film.debonded : what == Failed::links ? bond.link_step.debond : std::vector<int>())
    note(points.links[link].slot, points.links[link].grain);
}

void FailureLog::write(const LAMMPS_NS::Fix* fix, LAMMPS_NS::LAMMPS* lmp, const std::string& who, bool goes_on) {
  if (name_.empty()) return;
  const bool first = lmp->comm->me == 0;
  const auto check = [&](const std::string& why) {
    stop_if_any(lmp, why.empty() ? why : text_of(who, "cannot write 'events' file ", why, "; name another, or use a disk with free space"));
  };
  if (!open_) {
    check_only_writer(lmp, who, "events", name_, fix);
    open_ = true;
    check(first ? file_.open(name_, kHeader, goes_on ? lmp->update->get_cur_time() + 0.5 * lmp->update->dt : TableFile::kAnew) : "");
  }
  std::vector<Event> all = gather_on_first(lmp->world, events_);
  events_.clear();
  std::sort(all.begin(), all.end(),
            [](const Event& a, const Event& b) { return std::tie(a.step, a.point, a.grain) < std::tie(b.step, b.point, b.grain); });
  std::string rows;
  for (const Event& e : all)
    append(rows, "%ld,%.10g,%d,%d,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.6f,%.6f,%.6f,%s\n", e.step, e.time, e.point, e.bond, e.grain, e.r,
           e.theta, e.z, e.damage[0], e.damage[1], e.damage[2], e.direction[0], e.direction[1], e.direction[2],
           e.grain > 0 ? "debonding" : "internal");
  check(rows.empty() ? "" : file_.write(rows));
}

}  // namespace mpdem
