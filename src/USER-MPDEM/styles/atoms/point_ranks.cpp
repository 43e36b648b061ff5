// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_ranks.h"

#include <mpi.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "../../numerics/sort_unique.h"
#include "../../parallel/gather_ranks.h"
#include "../words/arguments.h"
#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "modify.h"
#include "private_access.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {

// Work of a condensed bond, in points.
constexpr double kWorkOfCondensed = 4.0;

// Returns the next of n subdomains on the shorter path, which may lead across a periodic boundary.
int step_towards(int from, int to, int n, bool periodic) {
  int way = to - from;
  if (periodic && 2 * std::abs(way) > n) way = -way;
  return (from + std::clamp(way, -1, 1) + n) % n;
}

}  // namespace

PointRanks::PointRanks(LAMMPS* lmp) : Pointers(lmp) {}

std::string PointRanks::set_balance(bool balance) {
  balance_ = balance;
  if (!balance) return "";
  if (domain->triclinic) return "'balance yes' is for boxes with right angles; use 'balance no'";
  constexpr int kShrinks = 2;
  for (int d = 0; d < 3; ++d)
    if (domain->boundary[d][0] >= kShrinks || domain->boundary[d][1] >= kShrinks)
      return text_of("'balance yes' is for a box whose sides stay, but that along ", "xyz"[d],
                     " follows the atoms; use 'boundary' with f or p, or 'balance no'");
  return "";
}

void PointRanks::find_subdomains() {
  Subdomain mine;
  for (int d = 0; d < 3; ++d) {
    mine.subdomain[d] = comm->myloc[d];
    mine.low[d] = domain->sublo[d];
    mine.high[d] = domain->subhi[d];
    edges_[d].assign(comm->procgrid[d] + 1, 0.0);
  }
  subdomains_.clear();
  for (const Subdomain& b : gather_all(world, std::vector<Subdomain>{mine})) {
    subdomains_.push_back(b.subdomain);
    for (int d = 0; d < 3; ++d) {
      edges_[d][b.subdomain[d]] = b.low[d];
      edges_[d][b.subdomain[d] + 1] = b.high[d];
    }
  }
}

int PointRanks::subdomain_along(int d, double x) const {
  const std::vector<double>& edges = edges_[d];
  const int at = static_cast<int>(std::upper_bound(edges.begin(), edges.end(), x) - edges.begin()) - 1;
  return std::clamp(at, 0, static_cast<int>(edges.size()) - 2);
}

double PointRanks::middle(int d, int subdomain) const { return 0.5 * (edges_[d][subdomain] + edges_[d][subdomain + 1]); }

bool PointRanks::any_homes(const AtomVecMpdem& avec) const {
  return std::any_of(avec.bonds.table.begin(), avec.bonds.table.end(), [](const BondRecord& b) { return b.home > 0; });
}

void PointRanks::start_run(const Fix* fix) {
  last_ = worst_ = 1.0;
  if (balance_) exchange_last(modify, fix);
}

bool PointRanks::show_homes(AtomVecMpdem& avec, bool for_run) {
  std::vector<BondRecord>& table = avec.bonds.table;
  if (!any_homes(avec) && !in_transit_) return false;
  find_subdomains();
  const auto subdomain_of = [&](int i) {
    SubdomainIndex p;
    for (int d = 0; d < 3; ++d) p[d] = subdomain_along(d, atom->x[i][d]);
    return p;
  };
  if (for_run) {
    std::vector<int> strayed;
    for (int i = 0; i < atom->nlocal; ++i) {
      if (!avec.is_point(i) || table[avec.bond[i]].home == 0) continue;
      const int home = table[avec.bond[i]].home - 1;
      const SubdomainIndex p = subdomain_of(i);
      if (home >= comm->nprocs || !is_adjacent(subdomains_[home], p, p)) strayed.push_back(avec.bond[i]);
    }
    sort_unique(strayed);
    for (int row : gather_all(world, strayed)) table[row].home = 0;
    if (!balance_)
      for (BondRecord& b : table) b.home = 0;
  }
  enum { kShown, kInTransit, kFlags };
  int mine[kFlags] = {}, any[kFlags];
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!avec.is_point(i)) continue;
    const BondRecord& record = table[avec.bond[i]];
    SubdomainIndex here, next;  // next: on the path to `to`
    for (int d = 0; d < 3; ++d) here[d] = next[d] = comm->myloc[d];
    SubdomainIndex to = here;
    if (for_run) {
      to = record.home > 0 ? subdomains_[record.home - 1] : subdomain_of(i);
      for (int d = 0; d < 3; ++d) next[d] = step_towards(here[d], to[d], comm->procgrid[d], domain->periodicity[d] != 0);
    } else if (!avec.bonds.find(avec.bond[i])->is_laid_out(avec.slot[i])) {
      continue;  // a point without a layout stays: its true position could not be restored afterwards
    }
    mine[kInTransit] |= next != to;
    if (record.home == 0 && next == to) continue;  // LIGGGHTS sends it there by its true position
    mine[kShown] = 1;
    for (int d = 0; d < 3; ++d) atom->x[i][d] = middle(d, next[d]);
  }
  MPI_Allreduce(mine, any, kFlags, MPI_INT, MPI_MAX, world);
  shows_homes_ = any[kShown] != 0;
  if (for_run) in_transit_ = any[kInTransit] != 0;
  return any[kInTransit] != 0;
}

// Returns resolved bonds that are wholly on this rank, with the range of subdomains in which they lie.
std::vector<MovableBond> PointRanks::movable_bonds(const AtomVecMpdem& avec) const {
  std::map<int, MovableBond> found;
  for (const Bond& b : avec.bonds.resolved())
    if (avec.bonds.is_whole(b)) found[b.row] = {b.row, comm->me, static_cast<double>(avec.bonds.record(b).points), {}, {-1, -1, -1}};
  for (int i = 0; i < atom->nlocal; ++i) {
    const auto at = avec.is_point(i) ? found.find(avec.bond[i]) : found.end();
    if (at == found.end()) continue;
    MovableBond& b = at->second;
    const bool first = b.high[0] < 0;
    for (int d = 0; d < 3; ++d) {
      const int subdomain = subdomain_along(d, atom->x[i][d]);
      b.low[d] = first ? subdomain : std::min(b.low[d], subdomain);
      b.high[d] = first ? subdomain : std::max(b.high[d], subdomain);
    }
  }
  std::vector<MovableBond> bonds;
  for (const auto& b : found)
    if (b.second.high[0] >= 0) bonds.push_back(b.second);
  return bonds;
}

bool PointRanks::is_uneven(const AtomVecMpdem& avec) {
  if (!balance_) return false;
  double mine = 0.0;
  for (const Bond& b : avec.bonds) {
    if (!avec.bonds.is_resolved(b)) mine += kWorkOfCondensed;
    else
      for (const BlockMeta& m : b.points.meta) mine += __builtin_popcount(m.occupied);
  }
  work_ = gather_all(world, std::vector<double>{mine});
  last_ = mpdem::load_imbalance(work_);
  worst_ = std::max(worst_, last_);
  return last_ > kAllowedImbalance;
}

bool PointRanks::find_homes(AtomVecMpdem& avec) {
  find_subdomains();
  const std::vector<BondMove> moves = rebalance(subdomains_, gather_all(world, movable_bonds(avec)), work_);
  for (const BondMove& m : moves) avec.bonds.table[m.row].home = m.rank + 1;
  return !moves.empty();
}

void PointRanks::tell(const std::string& who, const AtomVecMpdem& avec) {
  if (!balance_ || comm->nprocs == 1) return;
  is_uneven(avec);
  const std::vector<BondRecord>& table = avec.bonds.table;
  const auto given = std::count_if(table.begin(), table.end(), [](const BondRecord& b) { return b.home > 0; });
  mpdem::tell(lmp, text_of(who, "balance: the rank with most work has ", last_, " of the mean, ", worst_,
                           " at most in this run; ranks were given ", given, " bonds\n"));
}

}  // namespace mpdem
