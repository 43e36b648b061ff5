// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "departures.h"

#include <algorithm>

#include "../../mpm/block_nodes.h"
#include "../../numerics/sort_unique.h"
#include "../../parallel/agree.h"
#include "../../parallel/ranks.h"
#include "../condensed/rigid_pieces.h"

namespace mpdem {

namespace {

bool has(const std::vector<int>& ascending, int value) { return std::binary_search(ascending.begin(), ascending.end(), value); }

bool has(const std::map<int, std::vector<int>>& slots, int row, int slot) {
  const auto at = slots.find(row);
  return at != slots.end() && has(at->second, slot);
}

// Bits of the grains of a bond that are in a list of IDs.
int ends_in(const BondRecord& record, const std::vector<int>& grains) {
  int bits = 0;
  for (int s = 0; s < 2; ++s)
    if (record.has_grain(s) && has(grains, record.grain[s])) bits |= 1 << s;
  return bits;
}

// Adds the cement of a point.
void add_point(const Scene& scene, const Bond& b, int slot, CementVolume& cement) {
  const int in_store = Bond::slot_in_store(slot), block = in_store / kLanes;
  const PointStore& store = b.store_of(slot);
  cement.add(store.blocks[block].volume[in_store % kLanes], scene.inertia().own(store.meta[block].material));
}

// Drops the links or contact points of a grain.
template <class List>
void drop_of_grain(List& list, int grain) {
  list.erase(std::remove_if(list.begin(), list.end(), [grain](const auto& a) { return a.grain == grain; }), list.end());
}

}  // namespace

Leaving Departures::choose(const Departing& departing) {
  const std::vector<BondRecord>& table = scene_.bonds().table;
  std::vector<int> mine;
  for (const auto* slots : {&departing.outside, &departing.deleted, &departing.dropped.slots})
    for (const auto& of_row : *slots) mine.push_back(of_row.first);
  if (!departing.grains.empty())
    for (std::size_t row = 0; row < table.size(); ++row)
      if (ends_in(table[row], departing.grains) != 0) mine.push_back(static_cast<int>(row));
  mine.insert(mine.end(), departing.dropped.bonds.begin(), departing.dropped.bonds.end());
  sort_unique(mine);
  Leaving leaving;
  leaving.grains = departing.grains;
  const std::vector<int> rows = scene_.agreed_rows(mine);
  std::vector<int> deleted(rows.size(), 0);
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (const auto at = departing.deleted.find(rows[n]); at != departing.deleted.end()) deleted[n] = static_cast<int>(at->second.size());
  MPI_Allreduce(MPI_IN_PLACE, deleted.data(), static_cast<int>(deleted.size()), MPI_INT, MPI_SUM, scene_.comm);
  std::vector<char> as_a_whole(rows.size());
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const BondRecord& record = table[rows[n]];
    const int gone = ends_in(record, departing.grains);
    const bool separated = discontinuities_.cracks.separated(rows[n]);
    as_a_whole[n] =
        ((deleted[n] == record.points || record.point_template > 0) && (separated || gone == 3)) || has(departing.dropped.bonds, rows[n]);
    if (gone != 0 && !separated && scene_.options.fragments.outside) as_a_whole[n] = 1;
    if (gone != 0 && !separated && !as_a_whole[n]) {
      leaving.joined_grain = record.grain[(gone & 1) != 0 ? 0 : 1];
      return leaving;
    }
  }
  std::map<int, std::vector<char>> held = discontinuities_.cracks.attached_grains(scene_.comm, scene_.bonds(), scene_.options, rows);
  const auto choose_points_of = [&](std::size_t n) {
    if (Bond* b = scene_.bonds().find(rows[n])) choose_points(*b, held[rows[n]], departing, as_a_whole[n], leaving);
  };
  for (std::size_t n = 0; n < rows.size(); ++n) choose_points_of(n);
  std::vector<int> whole;
  if (scene_.options.fragments.outside) whole = scene_.agreed_rows(leaving.rows_attached_outside);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    if (!has(whole, rows[n])) continue;
    as_a_whole[n] = 1;
    leaving.slots.erase(rows[n]);
    choose_points_of(n);
  }
  if (scene_.options.fragments.outside) leaving.attached_outside.clear();
  for (const auto& of_row : leaving.slots) leaving.rows.push_back(of_row.first);
  for (int row : rows)
    if (ends_in(table[row], departing.grains) != 0) leaving.rows.push_back(row);
  leaving.rows.insert(leaving.rows.end(), departing.dropped.bonds.begin(), departing.dropped.bonds.end());
  count_dropped(departing.dropped, leaving);
  sort_unique(leaving.rows);
  leaving.rows = scene_.agreed_rows(leaving.rows);
  return leaving;
}

// held: of each slot, bits of the grains to which the point is attached; 0 for a fragment. An attached point leaves if all
// its grains do. A fragment of a resolved bond leaves if it is outside or deleted, or lies on nodes of cement that leaves.
// A fragment of a condensed bond belongs to a piece, and leaves only with the grain of that piece.
void Departures::choose_points(Bond& b, const std::vector<char>& held, const Departing& departing, bool as_a_whole,
                               Leaving& leaving) const {
  const BondRecord& record = scene_.bonds().record(b);
  const int gone = ends_in(record, departing.grains);
  const bool separated = discontinuities_.cracks.separated(b.row), resolved = scene_.bonds().is_resolved(b);
  std::vector<signed char> grain_of_node;  // empty: no piece leaves
  if (separated) {
    for (std::size_t slot = 0; slot < held.size(); ++slot)
      if (b.points.meta[slot / kLanes].occupied >> slot % kLanes & 1)
        b.points.set_connected(static_cast<int>(slot), b.points.has_failed(static_cast<int>(slot)) ? 0 : held[slot]);
    if (gone != 0 && resolved) grain_of_node = attached_grains_of_nodes(b);
  }
  const auto goes_with_grain = [&](int slot) {
    const BlockMeta& m = b.points.meta[slot / kLanes];
    if (!resolved) {  // as in grains_of_nodes()
      const int lane = slot % kLanes;
      double X[3];
      for (int d = 0; d < 3; ++d) X[d] = b.points.blocks[slot / kLanes].X[d][lane];
      return (gone >> nearer_grain(record, nearer_to_first(record, X)) & 1) != 0;
    }
    bool goes = false;
    if (!grain_of_node.empty())
      for_each_node_of_lane(b.grid, m, slot % kLanes,
                            [&](int i) { goes = goes || (grain_of_node[i] >= 0 && (gone >> grain_of_node[i] & 1)); });
    return goes;
  };
  for (int slot = 0; slot < static_cast<int>(held.size()); ++slot) {
    if (!(b.points.meta[slot / kLanes].occupied >> slot % kLanes & 1)) continue;
    const bool outside = has(departing.outside, b.row, slot), deleted = has(departing.deleted, b.row, slot);
    const bool dropped = has(departing.dropped.slots, b.row, slot);
    const bool fragments = held[slot] == 0, stays = fragments ? !resolved && !goes_with_grain(slot) : (held[slot] & ~gone) != 0;
    if (as_a_whole || (!stays && (!fragments || outside || deleted || dropped || goes_with_grain(slot))))
      leaving.slots[b.row].push_back(slot);
    else if (deleted) leaving.attached_deleted.push_back(b.points.tag(slot));
    else if (outside && !fragments) leaving.add_attached_outside(b.row, b.points.tag(slot));
  }
  // A film belongs to both grains. In a separated bond it is a fragment, and leaves with the first grain that does.
  b.for_each_slot_of(Bond::kColumns, [&](int slot) {
    const int tag = b.film.points.tag(Bond::slot_in_store(slot));
    if (as_a_whole || (separated && (gone != 0 || has(departing.outside, b.row, slot) || has(departing.deleted, b.row, slot))))
      leaving.slots[b.row].push_back(slot);
    else if (has(departing.deleted, b.row, slot)) leaving.attached_deleted.push_back(tag);
    else if (has(departing.outside, b.row, slot)) leaving.add_attached_outside(b.row, tag);
  });
}

// Points of a template count on the first rank.
void Departures::count_dropped(const LooseCement::Due& dropped, Leaving& leaving) const {
  for (const auto& [row, slots] : leaving.slots) {
    const auto of_row = dropped.slots.find(row);
    const bool whole = has(dropped.bonds, row);
    if (!whole && of_row == dropped.slots.end()) continue;
    const Bond& b = *scene_.bonds().find(row);
    for (int slot : slots) {
      if (!whole && !has(of_row->second, slot)) continue;
      leaving.dropped_points += 1.0;
      add_point(scene_, b, slot, leaving.dropped);
    }
  }
  for (int row : dropped.bonds) {
    const BondRecord& record = scene_.bonds().table[row];
    if (record.point_template == 0 || rank_in(scene_.comm) != 0) continue;
    leaving.dropped_points += record.points;
    leaving.dropped.volume += record.volume;
    leaving.dropped.own_volume += record.own_volume;
    leaving.dropped.own_mass += record.own_mass;
  }
}

std::vector<Departures::Share> Departures::shares(const Leaving& leaving) const {
  enum { kPoints, kVolume, kOwnVolume, kOwnMass, kNumbers };
  std::vector<double> sum(kNumbers * leaving.rows.size(), 0.0);
  for (std::size_t n = 0; n < leaving.rows.size(); ++n) {
    const BondRecord& record = scene_.bonds().table[leaving.rows[n]];
    const auto slots = leaving.slots.find(leaving.rows[n]);
    double* of_row = &sum[kNumbers * n];
    if (record.point_template > 0 && rank_in(scene_.comm) == 0) {
      of_row[kPoints] = record.points;
      of_row[kVolume] = record.volume;
      of_row[kOwnVolume] = record.own_volume;
      of_row[kOwnMass] = record.own_mass;
    } else if (slots != leaving.slots.end()) {
      const Bond& b = *scene_.bonds().find(slots->first);
      CementVolume cement;
      for (int slot : slots->second) add_point(scene_, b, slot, cement);
      of_row[kPoints] = static_cast<double>(slots->second.size());
      of_row[kVolume] = cement.volume;
      of_row[kOwnVolume] = cement.own_volume;
      of_row[kOwnMass] = cement.own_mass;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), static_cast<int>(sum.size()), MPI_DOUBLE, MPI_SUM, scene_.comm);
  std::vector<Share> all(leaving.rows.size());
  for (std::size_t n = 0; n < all.size(); ++n) {
    const double* of_row = &sum[kNumbers * n];
    all[n] = {leaving.rows[n],
              of_row[kPoints],
              {of_row[kVolume], of_row[kOwnVolume], of_row[kOwnMass]},
              of_row[kPoints] == scene_.bonds().table[leaving.rows[n]].points};
  }
  return all;
}

// Adds the share of this rank in a resolved bond: sign 1 before cement leaves, -1 after it. ahead: work that the energy
// balance has counted in advance for the second half of the step.
void Departures::add_resolved(const Bond& b, double sign, EnergyBalance::Left& left, double& ahead) const {
  left.energy += sign * work_.energy_of(b);
  ahead += sign * work_.ahead_of(b);
  double sum[3] = {0, 0, 0};
  for (int i = 0; i < b.grid.size(); ++i)
    for (int d = 0; d < 3 && b.grid.halo.counts_here()[i]; ++d)
      sum[d] += sign * b.grid.mass[i] * (b.grid.velocity[3 * i + d] + 0.5 * scene_.dt_last * b.grid.acceleration[3 * i + d]);
  const std::array<double, 3> momentum = turned(axes_of(scene_.bonds().record(b)), sum);
  for (int d = 0; d < 3; ++d) left.momentum[d] += momentum[d];
}

// Adds the share of this rank in the pieces of a condensed bond, as add_resolved() does. The work counted in advance is what
// brings a piece to its velocity at the end of the step.
void Departures::add_pieces(const Pieces& pieces, double sign, EnergyBalance::Left& left, double& ahead) const {
  const double dt = scene_.dt_last;
  for (int n = 0; n < 2; ++n) {
    if (!pieces.here[n]) continue;
    const auto energies = [&](double half) {
      return condensed_.energies_of_piece(pieces.row, pieces.whole ? -1 : n, scene_.bonds(), half, pieces.ends[n]);
    };
    const CondensedBonds::Energies now = energies(0.5 * dt);
    left.energy += sign * (now.elastic + now.discrete_kinetic);
    if (!pieces.whole) ahead += sign * (energies(dt).kinetic - now.discrete_kinetic);
    for (int d = 0; d < 3; ++d) left.momentum[d] += sign * now.momentum[d];
  }
}

Departures::Pieces Departures::pieces_of(int row) const {
  Pieces pieces;
  pieces.row = row;
  pieces.whole = !condensed_.is_in_pieces(row);
  for (int n = 0; n < (pieces.whole ? 1 : 2); ++n)
    pieces.here[n] = condensed_.ends_of_piece(row, pieces.whole ? -1 : n, scene_.bonds(), pieces.ends[n]);
  return pieces;
}

// Work of grains on leaving cement in the second half of the last step, which the energy balance counts in advance.
double Departures::ahead_of_grains(const std::vector<Share>& of_rows, const std::vector<int>& grains) const {
  double power = 0.0;
  for (const BondedGrains::OwnedEnd& o : scene_.grains.owned()) {
    const auto of_row = std::lower_bound(of_rows.begin(), of_rows.end(), o.row, [](const Share& s, int row) { return s.row < row; });
    if (of_row == of_rows.end() || of_row->row != o.row) continue;
    if (!of_row->all && !(ends_in(scene_.bonds().table[o.row], grains) >> o.side & 1)) continue;
    const BondEnd& s = scene_.grains.ends.ends[o.at];
    for (int d = 0; d < 6; ++d) {
      const double force = (d < 3 ? s.force[d] : s.torque[d - 3]) - s.jump_force[d] - s.transfer_force[d] - s.impulse[d];
      const double velocity = d < 3 ? s.v[d] + scene_.dt_last * s.a[d] : s.omega[d - 3] + scene_.dt_last * s.alpha[d - 3];
      power -= force * velocity;
    }
  }
  return 0.5 * scene_.dt_last * power;
}

// Work that the energy balance counts in advance for a condensed bond in one piece, with the work of its weight.
double Departures::ahead_of_condensed(int row) const {
  const EnergyBalance::StepWork work = condensed_.work(scene_.grains, scene_.bonds(), scene_.weight().data(), scene_.dt_last, row, row + 1);
  return work.now - 0.5 * work.with_velocity_before;
}

// Removes points, links and contact points from the bonds, and grains and points from the table.
std::vector<int> Departures::take_out(const std::vector<Share>& of_rows, const Leaving& leaving) {
  std::vector<int> tags;
  for (const Share& share : of_rows) {
    BondRecord& record = scene_.bonds().table[share.row];
    const int gone = ends_in(record, leaving.grains);
    if (Bond* b = scene_.bonds().find(share.row)) {
      const auto slots = leaving.slots.find(share.row);
      for (int slot : slots == leaving.slots.end() ? std::vector<int>() : slots->second) {
        tags.push_back(b->store_of(slot).tag(Bond::slot_in_store(slot)));
        b->release(slot);
      }
      for (int s = 0; s < 2; ++s) {
        if (!(gone >> s & 1)) continue;
        drop_of_grain(b->points.links, record.grain[s]);
        drop_of_grain(b->points.contacts, record.grain[s]);
      }
    }
    for (int s = 0; s < 2; ++s) record.left[s] = record.left[s] || (gone >> s & 1) != 0;
    record.points -= static_cast<int>(share.points);
    const auto rest = [&](double whole, double leaves) { return share.all ? 0.0 : std::max(0.0, whole - leaves); };
    record.volume = rest(record.volume, share.cement.volume);
    record.own_volume = std::min(record.volume, rest(record.own_volume, share.cement.own_volume));
    record.own_mass = rest(record.own_mass, share.cement.own_mass);
    if (!share.all) continue;
    record.condensed = record.wants_points = false;
    record.point_template = record.home = 0;
  }
  scene_.bonds().resolved_changed();
  return tags;
}

std::vector<int> Departures::carry_out(const Leaving& leaving) {
  const bool moved = std::any_of(scene_.bonds().begin(), scene_.bonds().end(), [](const Bond& b) { return b.changed(); });
  throw_if_any(scene_.comm, moved ? "cement leaves of which points went to other ranks since the last run; use 'run 0' after "
                                    "write_restart, before grains or points are deleted"
                                  : "");
  const std::vector<Share> of_rows = shares(leaving);
  EnergyBalance::Left left;
  std::vector<int> emptied;
  std::vector<Pieces> pieces;
  double ahead = ahead_of_grains(of_rows, leaving.grains);
  for (const Share& share : of_rows) {
    const BondRecord& record = scene_.bonds().table[share.row];
    if (record.condensed) pieces.push_back(pieces_of(share.row));
    else if (const Bond* b = scene_.bonds().find(share.row)) add_resolved(*b, 1.0, left, ahead);
    if (share.all) emptied.push_back(share.row);
    if (rank_in(scene_.comm) != 0) continue;
    left.points += share.points;
    left.mass += share.cement.mass(scene_.true_density());
  }
  for (const Pieces& p : pieces) {
    add_pieces(p, 1.0, left, ahead);
    if (p.whole) ahead += ahead_of_condensed(p.row);
  }
  const std::vector<int> tags = take_out(of_rows, leaving);
  condensed_.note_departure();
  discontinuities_.splits->remove_volume(scene_.comm, scene_.bonds(), scene_.options, leaving.rows);
  layout_manager_.move_phantom_nodes();
  layout_manager_.lay_out_again(leaving.rows, {}, {});
  for (const Bond& b : scene_.bonds().resolved())
    if (has(leaving.rows, b.row)) add_resolved(b, -1.0, left, ahead);
  condensed_.drop(scene_.comm, emptied, scene_.bonds(), scene_.grains);
  condensing_.condense(leaving.rows, false);
  for (const Pieces& p : pieces) add_pieces(p, -1.0, left, ahead);
  left.dropped = leaving.dropped_points;
  left.dropped_mass = leaving.dropped.mass(scene_.true_density());
  for (int row : emptied) discontinuities_.cracks.forget_cement(row);
  scene_.energy.leave(left);
  loose_cement_.forget(leaving.rows);
  scene_.energy.start(0.0, {-ahead, 0.0}, {}, 0.0);  // cement leaves before the half step whose work was counted in advance
  return tags;
}

}  // namespace mpdem
