// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cracks.h"

#include <algorithm>
#include <cmath>

#include "../../fracture/ligament.h"
#include "../../mpm/point_state.h"
#include "../../numerics/index_in.h"
#include "../../parallel/agree.h"
#include "../../parallel/all_to_all.h"
#include "../../parallel/ranks.h"

namespace mpdem {

namespace {

struct Sent {
  int row, slot;
  CrackPoint point;
};
struct Connected {
  int row, slot, connected;
};
struct OfSlot {
  int row, slot, value;
};
struct OfPath {
  int row, tag;
};

void direction_of_centres(const BondRecord& record, double* n) {
  double length = 0.0;
  for (int d = 0; d < 3; ++d) {
    n[d] = record.centre[1][d] - record.centre[0][d];
    length += n[d] * n[d];
  }
  for (int d = 0; d < 3; ++d) n[d] /= std::sqrt(length);
}

// Returns point l of block b. first_link: for each slot, its first link in the store.
CrackPoint crack_point(const PointStore& points, const BondRecord& record, int b, int l, double damage, const std::vector<int>& first_link,
                       const double* axis, bool layers_are_pieces) {
  const BlockMeta& m = points.meta[b];
  const int slot = kLanes * b + l;
  CrackPoint p;
  p.tag = points.tags[b][l];
  p.layer = layers_are_pieces ? m.layer : 0;
  p.failed = m.failed >> l & 1;
  p.connected = points.connected(slot);
  p.damage = static_cast<float>(std::max(damage, 0.0));
  const GapPoint position = gap_point(points, record, b, l);
  std::copy(position.cell, position.cell + 3, p.cell);
  p.nearer = position.nearer_grain;
  p.middle = position.middle;
  for (int n = 0; n < 6; ++n) p.space[n] = static_cast<float>(space_ahead(position, record, n / 2, n % 2 == 0 ? -1 : 1));
  for (int g = 0; g < 2; ++g) {
    p.attached[g] = false;
    p.above[g] = static_cast<float>(above_grain(record, g, position.X));
    p.link_damage[g] = 0.0f;
    p.link_area[g] = 0.0;
  }
  for (int n = first_link[slot]; n < first_link[slot + 1]; ++n) {
    const Link& k = points.links[n];
    const int g = k.grain == record.grain[0] ? 0 : 1;
    double across = 0.0;
    for (int d = 0; d < 3; ++d) across += (k.foot[d] - record.centre[g][d]) / record.radius[g] * axis[d];
    p.attached[g] = p.attached[g] || k.attached;
    p.link_damage[g] = std::max(p.link_damage[g], static_cast<float>(k.state[0]));
    p.link_area[g] += k.area * std::fabs(across);
  }
  return p;
}

// Counts failed points and debonded links, each by itself, so every failure changes the sum.
double count_broken(const PointStore& points) {
  int count = 0;
  for (const BlockMeta& m : points.meta) count += __builtin_popcount(m.failed);
  for (const Link& k : points.links) count += !k.attached;
  return count;
}

// Least width of a bridge in spacings, see Neighbours.
int cells_across(const BondRecord& record, const CementOptions& options) {
  return std::max(1, static_cast<int>(std::lround(options.narrowest_bridge() / record.spacing)));
}

// Bonds collected as a whole, each on one rank.
struct WholeBonds {
  struct Source {
    int rank, slot;
  };
  // Points of each of the wanted rows, and the rank and slot that has them. Both are empty on other ranks.
  std::vector<std::vector<CrackPoint>> points;
  std::vector<std::vector<Source>> sources;
};

// Calls f(slot, point) for the points of a bond on this rank.
template <class F>
void for_each_crack_point(const Bond& bond, const BondRecord& record, bool layers_are_pieces, F f) {
  const PointStore& points = bond.points;
  double axis[3];
  direction_of_centres(record, axis);
  std::vector<int> first_link(kLanes * points.blocks.size() + 1, 0);
  for (const Link& k : points.links) ++first_link[k.slot + 1];
  for (std::size_t i = 1; i < first_link.size(); ++i) first_link[i] += first_link[i - 1];
  const std::vector<vd> damage = largest_damages(points);
  for (int b = 0; b < static_cast<int>(points.blocks.size()); ++b)
    for (int l = 0; l < kLanes; ++l)
      if (points.meta[b].occupied >> l & 1)
        f(kLanes * b + l, crack_point(points, record, b, l, damage[b][l], first_link, axis, layers_are_pieces));
}

// Collective. Collects the points of each of these bonds (ascending) on one rank. Those of a bond that is there as a
// whole are not sent: in large simulations copies are not in the cache, and cost as much as examining the bond.
WholeBonds collect(MPI_Comm comm, const Bonds& bonds, const std::vector<int>& rows, const CementOptions& options) {
  const int ranks = ranks_of(comm), me = rank_in(comm);
  const bool layers_are_pieces = options.reprojects();
  std::vector<std::vector<Sent>> out(ranks);
  WholeBonds whole;
  whole.points.resize(rows.size());
  whole.sources.resize(rows.size());
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const Bond* bond = bonds.find(rows[n]);
    if (!bond) continue;
    const int to = bond->row % ranks;
    if (to == me && bonds.is_whole(*bond)) {
      whole.points[n].reserve(kLanes * bond->points.blocks.size());
      whole.sources[n].reserve(kLanes * bond->points.blocks.size());
      for_each_crack_point(*bond, bonds.record(*bond), layers_are_pieces, [&](int slot, const CrackPoint& p) {
        whole.points[n].push_back(p);
        whole.sources[n].push_back({me, slot});
      });
    } else {
      for_each_crack_point(*bond, bonds.record(*bond), layers_are_pieces, [&](int slot, const CrackPoint& p) {
        out[to].push_back({bond->row, slot, p});
      });
    }
  }
  const Received<Sent> sent = all_to_all(comm, out);
  std::size_t n = 0;
  for (int rank = 0; rank < ranks; ++rank)
    for (int i = 0; i < sent.count[rank]; ++i, ++n) {
      const Sent& s = sent.data[n];
      const std::size_t place = index_in(rows, s.row, "bond");
      whole.points[place].push_back(s.point);
      whole.sources[place].push_back({rank, s.slot});
    }
  return whole;
}

// Collective. Finds a number of each point on the rank that collects its bond, and returns it to the rank of the point.
// find(points, across) returns a number for each point. Returns by row the numbers of all slots, 0 where there is no point.
template <class T, class Find>
std::map<int, std::vector<T>> found_in_whole_bonds(MPI_Comm comm, const Bonds& bonds, const CementOptions& options,
                                                   const std::vector<int>& rows, Find find) {
  const WholeBonds whole = collect(comm, bonds, rows, options);
  std::vector<std::vector<OfSlot>> back(ranks_of(comm));
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const std::vector<CrackPoint>& points = whole.points[n];
    if (points.empty()) continue;
    const std::vector<T> numbers = find(points, cells_across(bonds.table[rows[n]], options));
    for (std::size_t k = 0; k < points.size(); ++k)
      back[whole.sources[n][k].rank].push_back({rows[n], whole.sources[n][k].slot, numbers[k]});
  }
  std::map<int, std::vector<T>> found;
  for (int row : rows)
    if (const Bond* b = bonds.find(row)) found[row].assign(kLanes * b->points.blocks.size(), 0);
  for (const OfSlot& p : all_to_all(comm, back).data) found[p.row][p.slot] = static_cast<T>(p.value);
  return found;
}

}  // namespace

bool Cracks::add_bonds(std::size_t rows) {
  const bool some_are_new = states_.size() < rows;
  states_.resize(rows);
  for (; registered_ < rows; ++registered_) {
    states_[registered_].path_cut = true;
    new_.push_back(static_cast<int>(registered_));
  }
  return some_are_new;
}

void Cracks::forget_cement(int row) {
  if (static_cast<std::size_t>(row) >= states_.size()) return;
  states_[row].broken_seen = 0.0;  // without points there is nothing to be seen
  states_[row].path.clear();
}

void Cracks::watch(const Bond& bond) {
  for (int slot : bond.failed) note_failure(bond, slot);
}

void Cracks::note_debonded_links(const Bond& bond) {
  for (int link : bond.link_step.debond) note_failure(bond, bond.points.links[link].slot);
}

// Intact film bridges the grains, wherever the rest is cracked.
void Cracks::note_film_failure(const Bond& bond) {
  State& s = states_[bond.row];
  if (bond.film.carries_load() || s.path_cut || s.separation.separated) return;
  s.path_cut = true;
  cut_.push_back(bond.row);
}

// Records that no path leads over the point of this slot any more, or from it to a grain.
void Cracks::note_failure(const Bond& bond, int slot) {
  State& s = states_[bond.row];
  if (s.path_cut || s.separation.separated) return;
  s.path_cut = s.path.empty() || std::binary_search(s.path.begin(), s.path.end(), bond.points.tag(slot));
  if (s.path_cut) cut_.push_back(bond.row);
}

bool Cracks::some_path_is_cut(MPI_Comm comm) const {
  int mine = !cut_.empty() || !new_.empty(), any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, comm);
  return any != 0;
}

Separation Cracks::find_separation(const BondRecord& record, int row, const CementOptions& options, const std::vector<CrackPoint>& points,
                                   bool residue) const {
  double face[3];  // areas of the faces of a lattice cell, projected on a plane across the line of centres
  direction_of_centres(record, face);
  for (double& f : face) f = std::fabs(f) * record.spacing * record.spacing;
  const double reach = residue ? 0.0 : options.half_band;
  return separate(points, face, states_[row].separation.separated, cells_across(record, options), reach);
}

std::string Cracks::mode(std::size_t row) const { return broken(row) ? mode_of(states_[row].separation) : "intact"; }

double Cracks::count_broken(const Bond& bond) { return mpdem::count_broken(bond.points) + mpdem::count_broken(bond.film.points); }

// Returns rows whose path is cut and where something failed since the last examination. Any separated bond may have new
// fragments, so with `with_separated` all resolved ones are candidates.
std::vector<int> Cracks::rows_to_check(MPI_Comm comm, const Bonds& bonds, bool with_separated, int from) {
  const auto take = [from](std::vector<int>& rows) {  // those before `from` stay
    const auto first = std::stable_partition(rows.begin(), rows.end(), [from](int row) { return row < from; });
    const std::vector<int> taken(first, rows.end());
    rows.erase(first, rows.end());
    return taken;
  };
  std::vector<int> rows = union_of_ranks(comm, take(cut_));
  const std::vector<int> fresh = take(new_);
  rows.insert(rows.end(), fresh.begin(), fresh.end());  // none is in `rows` yet: note_failure() skips rows whose path is cut
  for (int row : rows) states_[row].path_cut = false;
  rows.erase(std::remove_if(rows.begin(), rows.end(), [&](int row) { return states_[row].separation.separated; }), rows.end());
  if (with_separated) {
    for (int row : bonds.resolved_rows())
      if (row >= from && states_[row].separation.separated) rows.push_back(row);
  }
  std::sort(rows.begin(), rows.end());
  std::vector<double> now(2 * rows.size(), 0.0);  // count_broken(); number of ranks with intact film
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const Bond* b = bonds.find(rows[n]);
    if (!b) continue;
    now[2 * n] = count_broken(*b);
    now[2 * n + 1] = b->film.carries_load();
  }
  MPI_Allreduce(MPI_IN_PLACE, now.data(), static_cast<int>(now.size()), MPI_DOUBLE, MPI_SUM, comm);
  std::vector<int> examined;
  for (std::size_t n = 0; n < rows.size(); ++n) {
    State& s = states_[rows[n]];
    // Film that carries load joins the grains. Once it has failed, note_film_failure() marks the bond.
    if (now[2 * n + 1] > 0.0 || now[2 * n] == s.broken_seen) continue;
    s.broken_seen = now[2 * n];
    examined.push_back(rows[n]);
  }
  return examined;
}

Cracks::Found Cracks::detect_separations(MPI_Comm comm, Bonds& bonds, const CementOptions& options, bool residue, bool with_separated,
                                         int from) {
  Found found;
  const std::vector<int> examined = rows_to_check(comm, bonds, with_separated, from);
  if (examined.empty()) return found;
  const int ranks = ranks_of(comm);

  // Entries of bonds that another rank examines are empty.
  const WholeBonds whole = collect(comm, bonds, examined, options);
  std::vector<std::vector<Connected>> of_points(ranks);
  std::vector<std::vector<OfPath>> paths(ranks);
  constexpr int kRow = 9;  // separated, three areas, `connected` changed, has points, three areas of the film
  std::vector<double> result(kRow * examined.size(), 0.0);
  std::vector<Separation> separations(examined.size());
  for (std::size_t n = 0; n < examined.size(); ++n) {
    const int r = examined[n];
    if (const Bond* b = bonds.find(r)) {
      const Film::Areas film = b->film.areas();
      const double areas[3] = {film.at_grain[0], film.at_grain[1], film.inside};
      std::copy(areas, areas + 3, &result[kRow * n + 6]);
    }
    if (whole.points[n].empty()) continue;
    result[kRow * n + 5] = 1.0;
    Separation& s = separations[n] = find_separation(bonds.table[r], r, options, whole.points[n], residue);
    for (int tag : s.path)
      for (auto& to : paths) to.push_back({r, tag});
    const double row[4] = {1.0 * s.separated, s.at_grain[0], s.at_grain[1], s.inside};
    std::copy(row, row + 4, &result[kRow * n]);
  }
  for (std::size_t n = 0; n < examined.size(); ++n) {
    const std::vector<CrackPoint>& points = whole.points[n];
    if (points.empty() || !separations[n].separated) continue;
    if (options.split && separated(examined[n])) continue;  // nodes of fragments split as points fail
    std::vector<NodeSplitting::PointOfPiece>& pieces = found.separated_bonds.pieces[examined[n]];
    pieces.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      pieces.push_back({points[i].tag, separations[n].piece[i], points[i].layer, separations[n].between[i] != 0});
  }
  for (std::size_t n = 0; n < examined.size(); ++n)
    for (std::size_t k = 0; k < whole.points[n].size(); ++k) {
      const CrackPoint& point = whole.points[n][k];
      const WholeBonds::Source& at = whole.sources[n][k];
      const int connected = separations[n].separated ? separations[n].attached_grains[k] : point.connected;
      if (connected == point.connected) continue;
      of_points[at.rank].push_back({examined[n], at.slot, connected});
      result[kRow * n + 4] = 1.0;
    }
  for (const Connected& p : all_to_all(comm, of_points).data) bonds.find(p.row)->points.set_connected(p.slot, p.connected);
  for (int r : examined) states_[r].path.clear();
  for (const OfPath& p : all_to_all(comm, paths).data) states_[p.row].path.push_back(p.tag);
  MPI_Allreduce(MPI_IN_PLACE, result.data(), static_cast<int>(result.size()), MPI_DOUBLE, MPI_SUM, comm);
  for (std::size_t k = 0; k < examined.size(); ++k) {
    const double* row = &result[kRow * k];
    State& s = states_[examined[k]];
    // The fracture surface is that of the first separation: what fails later only makes fragments. A bond without
    // points is all film, and is examined only when that has failed.
    if (!s.separation.separated && (row[0] != 0.0 || row[5] == 0.0)) {
      s.separation.separated = true;
      for (int g = 0; g < 2; ++g) s.separation.at_grain[g] = row[1 + g] + row[6 + g];
      s.separation.inside = row[3] + row[8];
      if (row[5] != 0.0) found.separated_bonds.rows.push_back(examined[k]);
    }
    if (row[4] != 0.0) found.connected.push_back(examined[k]);
  }
  return found;
}

std::vector<Cracks::LigamentReport> Cracks::find_ligaments(MPI_Comm comm, const Bonds& bonds, const CementOptions& options,
                                                           const std::vector<int>& rows, bool residue) const {
  const WholeBonds whole = collect(comm, bonds, rows, options);
  constexpr int kWords = 5;  // ligament left and whole; areas at either grain and inside
  std::vector<double> found(kWords * rows.size(), 0.0);
  for (std::size_t b = 0; b < rows.size(); ++b) {
    const std::vector<CrackPoint>& points = whole.points[b];
    const int row = rows[b];
    if (const Bond* bond = bonds.find(row)) {
      const Film::Areas film = bond->film.areas();
      const double face = bonds.table[row].spacing * bonds.table[row].spacing;
      found[kWords * b] += film.intact / face;  // the number of lattice points that would fill this area
      found[kWords * b + 1] += film.all() / face;
      for (int g = 0; g < 2; ++g) found[kWords * b + 2 + g] += film.at_grain[g];
      found[kWords * b + 4] += film.inside + film.intact;
    }
    if (points.empty()) continue;
    const Ligament ligament = find_ligament(points);
    double* of_bond = &found[kWords * b];
    of_bond[0] += ligament.left();
    of_bond[1] += ligament.whole;
    for (const std::vector<int>& cut : ligament.cuts) {
      const Separation s = find_separation(bonds.table[row], row, options, cut_through(cut, points, residue), residue);
      const double area[3] = {s.at_grain[0], s.at_grain[1], s.inside};
      for (int i = 0; i < 3; ++i) of_bond[2 + i] += area[i] / static_cast<double>(ligament.cuts.size());
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, found.data(), static_cast<int>(found.size()), MPI_DOUBLE, MPI_SUM, comm);
  std::vector<LigamentReport> all(rows.size());
  for (std::size_t b = 0; b < all.size(); ++b) {
    const double* of_bond = &found[kWords * b];
    all[b].left = of_bond[0];
    all[b].whole = of_bond[1];
    std::copy(of_bond + 2, of_bond + 4, all[b].surface.at_grain);
    all[b].surface.inside = of_bond[4];
  }
  return all;
}

std::map<int, std::vector<char>> Cracks::attached_grains(MPI_Comm comm, const Bonds& bonds, const CementOptions& options,
                                                         const std::vector<int>& rows) const {
  return found_in_whole_bonds<char>(comm, bonds, options, rows, mpdem::attached_grains);
}

std::map<int, std::vector<int>> Cracks::piece_sizes(MPI_Comm comm, const Bonds& bonds, const CementOptions& options,
                                                    const std::vector<int>& rows) const {
  return found_in_whole_bonds<int>(comm, bonds, options, rows, mpdem::piece_sizes);
}

void Cracks::record_failures(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<int>& rows, bool residue,
                             std::int64_t step) {
  std::vector<int> unbroken;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(unbroken), [&](int row) { return !broken(row); });
  if (unbroken.empty()) return;
  const std::vector<LigamentReport> found = find_ligaments(comm, bonds, options, unbroken, residue);
  for (std::size_t n = 0; n < unbroken.size(); ++n) {
    if (found[n].left >= found[n].whole) continue;
    State& state = states_[unbroken[n]];
    state.broken_at = step;
    const bool separated = state.separation.separated;
    state.separation = found[n].surface;
    state.separation.separated = separated;
  }
}

const char* Cracks::mode_of(const FractureSurface& s) {
  const double share = s.debonded_share();
  return share >= 0.9 ? "debonding" : share <= 0.1 ? "internal" : "mixed";
}

}  // namespace mpdem
