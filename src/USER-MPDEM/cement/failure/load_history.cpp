// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "load_history.h"

#include <algorithm>
#include <cmath>

#include "../../coupling/relative_motion.h"
#include "../../parallel/ranks.h"

namespace mpdem {

namespace {

Three<double> three(const double* x) { return {{x[0], x[1], x[2]}}; }

// ends: the first of the two ends of the bond.
RelativeMotion<double> relative_motion(const BondRecord& record, const BondEnd* ends) {
  Mat3<double> turn[2];
  Three<double> arm[2];
  const Three<double> apart = three(record.centre[1]) - three(record.centre[0]);
  const double length = std::sqrt(dot(apart, apart)), to_middle = share_to_middle(record, length);
  for (int s = 0; s < 2; ++s) {
    turn[s] = product(ends[s].R, transpose(rotation_of(record.orientation[s])));
    arm[s] = (s == 0 ? to_middle : to_middle - 1.0) * apart;
  }
  return {turn, arm, three(ends[1].x) - three(ends[0].x)};
}

// Norm of force and moment, or of displacement and rotation, with the second three numbers multiplied by `unit`.
double size_of(const double* six, double unit) {
  double square = 0.0;
  for (int d = 0; d < 6; ++d) square += six[d] * six[d] * (d < 3 ? 1.0 : unit * unit);
  return std::sqrt(square);
}

}  // namespace

// Radius of a disc with the mean attached area of both grains.
double LoadHistory::radius_of(const BondRecord& record) {
  return std::sqrt(0.5 * (record.attached_area[0] + record.attached_area[1]) / M_PI);
}

void LoadHistory::add(const BondedGrains& grains, const std::vector<BondRecord>& table, double dt) {
  int at = -1;  // index of the first end of the bond that has `motion`
  RelativeMotion<double> motion;
  for (const BondedGrains::OwnedEnd& o : grains.owned()) {
    if (static_cast<std::size_t>(o.row) >= sums_.size()) continue;
    const BondEnd* ends = &grains.ends.ends[o.at - o.side];
    if (o.at - o.side != at) motion = relative_motion(table[o.row], ends);
    at = o.at - o.side;
    const BondEnd& s = ends[o.side];
    const double share = o.side == 0 ? -0.5 * dt : 0.5 * dt;
    const Three<double> force = three(s.force), F = turned_back(motion.Q, force),
                        M = turned_back(motion.Q, three(s.torque) - cross(motion.r[o.side], force));
    Sums& sum = sums_[o.row];
    sum[0] += 0.5 * dt;
    for (int d = 0; d < 3; ++d) {
      sum[1 + d] += share * F.a[d];
      sum[4 + d] += share * M.a[d];
      sum[7 + d] += 0.5 * dt * motion.delta.a[d];
      sum[10 + d] += 0.5 * dt * motion.theta.a[d];
    }
  }
}

std::vector<LoadHistory::Sums> LoadHistory::sums_of_all(MPI_Comm comm) const {
  std::vector<Sums> all(sums_);
  if (!all.empty()) MPI_Allreduce(MPI_IN_PLACE, all.front().data(), static_cast<int>(kSums * all.size()), MPI_DOUBLE, MPI_SUM, comm);
  return all;
}

std::vector<LoadHistory::Sums> LoadHistory::gather_on_first(MPI_Comm comm) {
  const std::vector<Sums> all = sums_of_all(comm);
  sums_ = rank_in(comm) == 0 ? all : std::vector<Sums>(all.size(), Sums{});
  return all;
}

// Most checks end no window. So ranks sum the times first, and then loads and motions only of rows whose window ends.
std::vector<int> LoadHistory::find_failed(MPI_Comm comm, const std::vector<BondRecord>& table, double shear_speed) {
  std::vector<double> time;
  for (std::size_t r = 0; r < sums_.size(); ++r) {
    if (table[r].condensed) sums_[r] = Sums{};  // a window does not continue after the bond was condensed
    time.push_back(sums_[r][0]);
  }
  if (!time.empty()) MPI_Allreduce(MPI_IN_PLACE, time.data(), static_cast<int>(time.size()), MPI_DOUBLE, MPI_SUM, comm);
  std::vector<int> rows;
  std::vector<Sums> found;
  for (std::size_t r = 0; r < time.size(); ++r) {
    if (radius_of(table[r]) == 0.0 || time[r] * shear_speed < window_path(table[r])) continue;
    rows.push_back(static_cast<int>(r));
    found.push_back(sums_[r]);
    sums_[r] = Sums{};
  }
  std::vector<int> gone;
  if (rows.empty()) return gone;
  MPI_Allreduce(MPI_IN_PLACE, found.front().data(), static_cast<int>(kSums * found.size()), MPI_DOUBLE, MPI_SUM, comm);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const Sums& sum = found[n];
    Largest& largest = largest_[rows[n]];
    const double radius = radius_of(table[rows[n]]);
    const double load = size_of(&sum[1], 1.0 / radius) / sum[0], motion = size_of(&sum[7], radius) / sum[0];
    if (load < kBrokenLoadRatio * largest.load && motion > largest.motion) gone.push_back(rows[n]);
    if (load > largest.load) largest = {load, motion};
  }
  return gone;
}

}  // namespace mpdem
