// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "elastic_grains.h"

#include <algorithm>
#include <cmath>

#include "../../parallel/agree.h"

namespace mpdem {

namespace {

constexpr double kWidestPatch = 3.0;  // angle from the line of centres

std::string in_words(const GrainElasticity& g) { return g.is_rigid() ? std::string("rigid") : text_of("elastic ", g.E, " ", g.nu); }

}  // namespace

void set_elastic_grains(MPI_Comm comm, Bonds& bonds, const std::vector<ElasticPair>& of_rows) {
  std::string trouble;
  for (std::size_t row = 0; row < of_rows.size(); ++row) {
    BondRecord& record = bonds.table[row];
    for (int s = 0; s < 2; ++s) {
      const GrainElasticity before{record.grain_E[s], record.grain_nu[s]}, &now = of_rows[row][s];
      if (record.in_motion && !(before == now) && trouble.empty())
        trouble = text_of("grain ", record.grain[s], " is ", in_words(now), ", but was ", in_words(before),
                          " in the steps before, and the load of its bonds would jump; use 'grains ", in_words(before), "' for its type");
      record.grain_E[s] = now.E;
      record.grain_nu[s] = now.nu;
    }
  }
  std::vector<double> bound(4 * bonds.table.size(), -10.0);  // minus the least and the largest angle at each grain; below -9: no links
  for (const Bond& b : bonds) {
    const BondRecord& record = bonds.record(b);
    if (record.grain_E[0] + record.grain_E[1] == 0.0) continue;
    double line[3];
    for (int d = 0; d < 3; ++d) line[d] = record.centre[1][d] - record.centre[0][d];
    const double length = std::sqrt(line[0] * line[0] + line[1] * line[1] + line[2] * line[2]);
    for (const Link& k : b.points.links) {
      const int s = k.grain == record.grain[1];
      double from[3], along = 0.0, square = 0.0;
      for (int d = 0; d < 3; ++d) {
        from[d] = k.foot[d] - record.centre[s][d];
        along += (s == 0 ? 1.0 : -1.0) * from[d] * line[d] / length;
        square += from[d] * from[d];
      }
      const double angle = std::acos(std::clamp(along / std::sqrt(square), -1.0, 1.0));
      double* of = &bound[4 * static_cast<std::size_t>(b.row) + 2 * static_cast<std::size_t>(s)];
      of[0] = std::max(of[0], -angle);
      of[1] = std::max(of[1], angle);
    }
  }
  throw_if_any(comm, trouble);
  MPI_Allreduce(MPI_IN_PLACE, bound.data(), static_cast<int>(bound.size()), MPI_DOUBLE, MPI_MAX, comm);
  // Points lie within half of the spacing of the rims. A hole of less than two points is none.
  for (std::size_t row = 0; row < bonds.table.size(); ++row)
    for (std::size_t s = 0; s < 2; ++s) {
      BondRecord& record = bonds.table[row];
      const double *of = &bound[4 * row + 2 * s], half = 0.5 * record.spacing / record.radius[s];
      if (record.grain_E[s] == 0.0 || record.patch[s][1] > 0.0 || of[0] < -9.0) continue;
      record.patch[s][0] = -of[0] > 2.0 * half ? -of[0] - half : 0.0;
      record.patch[s][1] = std::min(of[1] + half, kWidestPatch);
    }
}

}  // namespace mpdem
