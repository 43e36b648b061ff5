// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// create_cement: cement at all contacts of a group of grains, as the command for a pair makes it at each of them.
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <set>
#include <utility>

#include "atom.h"
#include "atom_vec_mpdem.h"
#include "comm.h"
#include "create_cement.h"
#include "domain.h"
#include "group.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::text_of;

// Pairs of IDs of grains of the group, of all ranks, that are no farther apart. Ascending, the same on every rank.
std::vector<std::pair<int, int>> CreateCement::contacts(int groupbit, double gap) const {
  constexpr int kWidth = 5;  // tag, x, radius
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  std::vector<double> mine;
  for (int i = 0; i < atom->nlocal; ++i)
    if ((atom->mask[i] & groupbit) && !avec->is_point(i))
      mine.insert(mine.end(), {static_cast<double>(atom->tag[i]), atom->x[i][0], atom->x[i][1], atom->x[i][2], atom->radius[i]});
  int count = static_cast<int>(mine.size());
  std::vector<int> counts(comm->nprocs), at(comm->nprocs, 0);
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, world);
  for (int r = 1; r < comm->nprocs; ++r) at[r] = at[r - 1] + counts[r - 1];
  std::vector<double> all(at.back() + counts.back());
  MPI_Allgatherv(mine.data(), count, MPI_DOUBLE, all.data(), counts.data(), at.data(), MPI_DOUBLE, world);

  struct Place {
    double x;
    const double* grain;
  };
  std::vector<Place> sorted;
  double widest = 0.0;
  for (std::size_t g = 0; g < all.size(); g += kWidth) widest = std::max(widest, all[g + 4]);
  const double reach = 2.0 * widest + gap;
  for (std::size_t g = 0; g < all.size(); g += kWidth) {
    sorted.push_back({all[g + 1], &all[g]});
    // its image beyond the upper face, for those near that face
    if (domain->periodicity[0] && all[g + 1] - domain->boxlo[0] <= reach) sorted.push_back({all[g + 1] + domain->prd[0], &all[g]});
  }
  std::sort(sorted.begin(), sorted.end(), [](const Place& a, const Place& b) { return a.x != b.x ? a.x < b.x : a.grain[0] < b.grain[0]; });
  std::set<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < sorted.size(); ++i)
    for (std::size_t j = i + 1; j < sorted.size() && sorted[j].x - sorted[i].x <= reach; ++j) {
      const double *a = sorted[i].grain, *b = sorted[j].grain;
      double d[3] = {b[1] - a[1], b[2] - a[2], b[3] - a[3]};
      domain->minimum_image(d[0], d[1], d[2]);
      const double distance = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      if (a == b || distance - a[4] - b[4] > gap) continue;
      pairs.insert(std::minmax(static_cast<int>(a[0]), static_cast<int>(b[0])));
    }
  return {pairs.begin(), pairs.end()};
}

// For each bond the others, and periodic images, whose boxes meet its own.
std::vector<std::vector<CreateCement::Near>> CreateCement::neighbours() {
  const std::vector<Bond>& bonds = bonds_;
  using mpdem::Vector3;
  struct Place {
    Vector3 middle;
    std::size_t bond;
    bool image;
  };
  double widest = 0.0;
  for (const Bond& b : bonds) widest = std::max(widest, shape_of(b.kind).half_extent().maxCoeff());
  const Vector3 low(domain->boxlo[0], domain->boxlo[1], domain->boxlo[2]), high(domain->boxhi[0], domain->boxhi[1], domain->boxhi[2]);
  const int images[3] = {domain->periodicity[0], domain->periodicity[1], domain->periodicity[2]};
  std::vector<Place> places;
  for (std::size_t n = 0; n < bonds.size(); ++n)
    for (int i = -images[0]; i <= images[0]; ++i)
      for (int j = -images[1]; j <= images[1]; ++j)
        for (int k = -images[2]; k <= images[2]; ++k) {
          const Vector3 x = bonds[n].middle() + Vector3(i * domain->prd[0], j * domain->prd[1], k * domain->prd[2]);
          const bool image = i != 0 || j != 0 || k != 0;
          // Middles lie up to a radius outside of the box, beside the first grain.
          const double reach = 2.0 * widest + bonds[n].pair.R1;
          if (image && ((x - low).minCoeff() < -reach || (high - x).minCoeff() < -reach)) continue;
          places.push_back({x, n, image});
        }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.middle[0] != b.middle[0] ? a.middle[0] < b.middle[0] : a.bond < b.bond; });
  std::vector<std::vector<Near>> near(bonds.size());
  for (std::size_t n = 0; n < places.size(); ++n)
    for (std::size_t m = n + 1; m < places.size() && places[m].middle[0] - places[n].middle[0] <= 2.0 * widest; ++m) {
      const Place &a = places[n], &b = places[m];
      const Vector3 apart = b.middle - a.middle;
      const mpdem::Shape &of_a = shape_of(bonds[a.bond].kind), &of_b = shape_of(bonds[b.bond].kind);
      if ((apart.cwiseAbs().array() > (of_a.half_extent() + of_b.half_extent()).array()).any()) continue;
      if (!a.image) near[a.bond].push_back({b.bond, apart});
      if (!b.image) near[b.bond].push_back({a.bond, -apart});
    }
  return near;
}

void CreateCement::report_skipped(const std::vector<std::pair<int, int>>& skipped) const {
  if (comm->me != 0 || skipped.empty()) return;
  constexpr std::size_t kMost = 20;
  std::string pairs;
  for (std::size_t n = 0; n < std::min(skipped.size(), kMost); ++n) pairs += text_of(" ", skipped[n].first, "-", skipped[n].second);
  if (skipped.size() > kMost) pairs += " ...";
  const std::string text = text_of(skipped.size(), " bonds left out whose cement would overlap that of others, between grains", pairs, "\n");
  for (FILE* f : {screen, logfile})
    if (f) std::fprintf(f, "%s", text.c_str());
}

// Collective.
void CreateCement::report_sums(const Sums& sums, int groupbit, const std::string& name) const {
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  double mine[2] = {0.0, 0.0}, grains[2];
  for (int i = 0; i < atom->nlocal; ++i)
    if ((atom->mask[i] & groupbit) && !avec->is_point(i)) {
      mine[0] += 1.0;
      mine[1] += atom->rmass[i];
    }
  MPI_Allreduce(mine, grains, 2, MPI_DOUBLE, MPI_SUM, world);
  if (comm->me != 0) return;
  const std::string text = text_of("  in all ", std::llround(sums.points), " points, volume ", sums.volume, ", mass ", sums.mass, ", content (mass over that of the ", grains[0],
                                   " grains of group '", name, "', ", grains[1], ") ", sums.mass / grains[1], "\n");
  for (FILE* f : {screen, logfile})
    if (f) std::fprintf(f, "%s", text.c_str());
}

// Words after `contacts`.
void CreateCement::cement_contacts(Arguments& args) {
  const std::string name = args.word("a group of grains for 'contacts'");
  const int igroup = group->find(name.c_str());
  if (igroup < 0) args.complain(text_of("'contacts ", name, "': there is no such group; define it by 'group' before"));
  args.choice("gap", {"gap"});
  const double gap = args.not_negative("gap");
  const std::vector<Pair> found = contacts(group->bitmask[igroup], gap), before = cemented();
  if (found.empty())
    args.complain(text_of("no two grains of group '", name, "' are closer than 'gap ", gap, "'; use a wider gap, or bring them together before"));
  std::vector<Pair> pairs, skipped;
  std::set_difference(found.begin(), found.end(), before.begin(), before.end(), std::back_inserter(pairs));
  Sums sums;
  if (!pairs.empty()) {
    plan(pairs, args);
    if (overlap_ == "trim") {
      if (!file_.empty()) args.complain("'overlap trim' belongs to shapes; points of a file stay as they are, use 'overlap skip'");
      near_ = neighbours();
    }
    sums = make(args, skipped);
  }
  if (comm->me == 0)
    for (FILE* f : {screen, logfile})
      if (f)
        std::fprintf(f, "%s", text_of("Cement at ", pairs.size() - skipped.size(), " contacts of group '", name, "' of a gap of at most ", gap, "; ",
                                      found.size() - pairs.size(), " had cement before\n").c_str());
  report_sums(sums, group->bitmask[igroup], name);
  report_skipped(skipped);
}

}  // namespace LAMMPS_NS
