// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Cement at all contacts of a group of grains: the command for a pair, once for each of them.
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
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

// Words after `contacts`; those after the gap go to each pair as they are.
void CreateCement::cement_contacts(char** arg, int narg, int words, Arguments& args) {
  const std::string name = args.word("a group of grains for 'contacts'");
  const int igroup = group->find(name.c_str());
  if (igroup < 0) args.complain(text_of("'contacts ", name, "': there is no such group; define it by 'group' before"));
  args.choice("gap", {"gap"});
  const double gap = args.not_negative("gap");
  std::set<std::pair<int, int>> cemented;
  for (const mpdem::Body& b : AtomVecMpdem::of(lmp)->bodies) cemented.insert({b.grain[0], b.grain[1]});
  const std::vector<std::pair<int, int>> found = contacts(group->bitmask[igroup], gap);
  if (found.empty())
    args.complain(text_of("no two grains of group '", name, "' are closer than 'gap ", gap, "'; use a wider gap, or bring them together before"));
  int made = 0;
  for (const std::pair<int, int>& p : found) {
    if (cemented.count(p)) continue;
    std::string tags[2] = {std::to_string(p.first), std::to_string(p.second)}, pair = "pair";
    std::vector<char*> list = {arg[0], &pair[0], &tags[0][0], &tags[1][0]};
    list.insert(list.end(), arg + words, arg + narg);
    CreateCement(lmp).command(static_cast<int>(list.size()), list.data());
    ++made;
  }
  if (comm->me != 0) return;
  for (FILE* f : {screen, logfile})
    if (f)
      std::fprintf(f, "%s", text_of("Cement at ", made, " contacts of group '", name, "' of a gap of at most ", gap, "; ",
                                    found.size() - made, " had cement before\n").c_str());
}

}  // namespace LAMMPS_NS
