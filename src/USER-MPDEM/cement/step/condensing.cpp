// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "condensing.h"

#include <algorithm>
#include <limits>

#include "../../mpm/field_drive.h"
#include "../../mpm/point_state.h"
#include "../../numerics/sort_unique.h"
#include "../../parallel/agree.h"
#include "../../parallel/ranks.h"
#include "nonlocal.h"
#include "../condensed/template_layouts.h"
#include "../condensed/rigid_pieces.h"

namespace mpdem {

// Marks only bonds that no step has moved yet, since their points and nodes are where they were created.
void Condensing::choose() {
  for (std::size_t row = 0; row < scene_.bonds().table.size(); ++row) {
    BondRecord& b = scene_.bonds().table[row];
    if (!b.in_motion) b.condensed = scene_.options.condense && scene_.penalty;
    if (b.condensed && !scene_.options.condense && !cracks_.separated(row))
      throw BadState(text_of("bonds were condensed in the steps before, that of grains ", b.grain[0], " and ", b.grain[1],
                             " still is; use 'condense yes'"));
    if (b.condensed && !scene_.penalty)
      throw BadState(text_of("the bond of grains ", b.grain[0], " and ", b.grain[1],
                             " is condensed, but nothing holds it to its grains; use 'fix mpm/couple' as in the steps before"));
  }
  std::vector<int> nonlinear;
  for (const Bond& b : scene_.bonds())
    if (!scene_.bonds().record(b).in_motion && !scene_.stays_linear(b)) nonlinear.push_back(b.row);
  for (int row : scene_.agreed_rows(nonlinear)) scene_.bonds().table[row].condensed = false;
  scene_.bonds().resolved_changed();
}

void Condensing::bind() {
  scene_.grains.bind(scene_.comm, scene_.bonds(), scene_.inertia());
  scene_.grains.distribute(scene_.bonds());  // code that runs before the next step must not find grains at rest
  scene_.laid_out = true;
  if (scene_.dt_last == 0.0) scene_.dt_last = scene_.now.dt;
  condensed_.forget_candidates_but(scene_.bonds());
  condensed_.bind(scene_.comm, scene_.bonds(), scene_.grains);
  condensed_.follow(scene_.grains, scene_.weight().data());
}

void Condensing::condense(const std::vector<int>& rows, bool at_start) {
  if (!scene_.may_condense()) return;
  mark_pieces(rows);
  std::vector<int> resolved = rows_with_loose_pieces(rows);
  for (int row : resolved) scene_.bonds().table[row].condensed = false;
  scene_.bonds().resolved_changed();
  install_templates(at_start);
  const std::vector<int> without = condensed_.solve(scene_.comm, scene_.bonds(), rows, *scene_.law, *scene_.penalty, scene_.scaled_density);
  resolved.insert(resolved.end(), without.begin(), without.end());
  if (!resolved.empty()) {
    scene_.bonds().resolved_changed();
    bind();
    shared_.bind();
    added_.refresh(resolved);
    return;
  }
  condensed_.bind(scene_.comm, scene_.bonds(), scene_.grains);
  condensed_.follow(scene_.grains, scene_.weight().data());
}

void Condensing::mark_pieces(const std::vector<int>& rows) {
  for (int row : rows) condensed_.set_in_pieces(row, scene_.bonds().table[row].condensed && cracks_.separated(row));
}

// Collective. Returns separated bonds that stay resolved because of their fragments.
std::vector<int> Condensing::rows_with_loose_pieces(const std::vector<int>& rows) const {
  std::vector<int> in_pieces, loose;
  for (int row : rows)
    if (condensed_.is_in_pieces(row)) in_pieces.push_back(row);
  std::vector<int> points(in_pieces.size(), 0);
  for (std::size_t n = 0; n < points.size(); ++n)
    if (const Bond* b = scene_.bonds().find(in_pieces[n])) points[n] = points_in_fragments(b->points);
  if (!points.empty()) MPI_Allreduce(MPI_IN_PLACE, points.data(), static_cast<int>(points.size()), MPI_INT, MPI_SUM, scene_.comm);
  for (std::size_t n = 0; n < points.size(); ++n)
    if (points[n] >= kLeastLoose) loose.push_back(in_pieces[n]);
  return loose;
}

// Takes the representative bonds of the templates that grains of this rank need. Grains may have come from other ranks.
void Condensing::install_templates(bool at_start) {
  std::vector<int> templates = templates_of_owned_grains(scene_);
  if (!at_start)
    templates.erase(std::remove_if(templates.begin(), templates.end(), [&](int p) { return condensed_.has_template(p); }), templates.end());
  condensed_.install_templates(scene_.comm, layouts_of_templates(scene_, templates, &*scene_.penalty),
                               static_cast<int>(scene_.bonds().templates.size()), at_start, *scene_.law, *scene_.penalty,
                               scene_.scaled_density);
}

// Bonds to activate that lack points get them before the next step, and are activated in it. Returns the others.
std::vector<int> Condensing::ask_for_points(const std::vector<int>& rows) {
  std::vector<int> others;
  for (int row : rows) {
    BondRecord& b = scene_.bonds().table[row];
    if (b.point_template == 0) {
      others.push_back(row);
      continue;
    }
    if (!b.wants_points) rows_that_want_points_.push_back(row);
    b.wants_points = true;
  }
  return others;
}

bool Condensing::change() {
  activated_ = recondensed_ = released_ = Change();
  if (!scene_.may_condense()) return false;
  activate();
  condense_again();
  return !activated_.rows.empty() || !recondensed_.rows.empty() || !released_.rows.empty();
}

void Condensing::count_changes() {
  for (int row : activated_.rows)
    if (const Bond* b = scene_.bonds().find(row)) activated_.energy -= work_.energy_of(*b);
  scene_.energy.release(activated_.energy);
  for (int row : released_.rows)
    if (const Bond* b = scene_.bonds().find(row)) released_.energy -= work_.energy_of(*b);
  scene_.energy.damp(released_.energy);
  for (int row : recondensed_.rows) {
    const CondensedBonds::Energies e = condensed_.energies_of(row, scene_.bonds(), 0.5 * scene_.dt_last);
    recondensed_.energy -= e.elastic + e.discrete_kinetic;
  }
  // The momentum that grains gain is counted as work, so that damped energy does not depend on rigid translation.
  scene_.energy.do_work(-recondensed_.to_grains);
  scene_.energy.damp(recondensed_.energy - recondensed_.to_grains);
}

std::vector<int> Condensing::rows_to_activate() {
  std::vector<int> together;
  std::vector<int> mine = condensed_.rows_due(scene_.bonds(), scene_.options, *scene_.law, together);
  if (!scene_.options.advance.nonlocal || !condensed_.any_shared()) return scene_.agreed_rows(mine);
  together = scene_.agreed_rows(together);
  if (!together.empty()) {
    for (int row : together)
      if (Bond* b = scene_.bonds().find(row)) condensed_.show_strain(*b);
    average_cut_drives(scene_, together);
    std::vector<double> roots(together.size(), 0.0);
    for (std::size_t n = 0; n < roots.size(); ++n)
      if (const Bond* b = scene_.bonds().find(together[n]))
        roots[n] = std::max({largest_root_of_drive(b->points, *scene_.law, &b->grid),
                             largest_root_of_drive(b->film.points, *scene_.law, nullptr), condensed_.root_of_interface(*b, *scene_.law)});
    MPI_Allreduce(MPI_IN_PLACE, roots.data(), static_cast<int>(roots.size()), MPI_DOUBLE, MPI_MAX, scene_.comm);
    for (std::size_t n = 0; n < roots.size(); ++n)
      if (condensed_.note_check(together[n], roots[n], scene_.options, *scene_.law)) mine.push_back(together[n]);
  }
  return scene_.agreed_rows(mine);
}

void Condensing::activate() {
  if (!condensed_.any()) return;
  const std::vector<int> rows = ask_for_points(rows_to_activate());
  if (rows.empty()) return;
  const std::array<double, 3> weight = scene_.weight();
  activated_.rows = rows;
  std::vector<BondEnd> ends;
  for (int row : rows) {
    const CondensedBonds::Energies e = condensed_.energies_of(row, scene_.bonds(), 0.5 * scene_.dt_last);
    activated_.energy += e.elastic + e.discrete_kinetic;
    condensed_.activate(scene_.comm, row, scene_.bonds().find(row), scene_.bonds(), weight.data(), scene_.dt_last, *scene_.law);
    if (!condensed_.has(row)) continue;
    const std::array<BondEnd, 2> of_row = condensed_.loaded_ends(row, scene_.bonds(), weight.data());
    ends.insert(ends.end(), of_row.begin(), of_row.end());
  }
  for (int row : rows) scene_.bonds().table[row].condensed = false;
  scene_.bonds().resolved_changed();
  condensed_.drop(scene_.comm, rows, scene_.bonds(), scene_.grains);
  condensed_.resume(scene_.grains, weight.data());
  scene_.grains.rebind_ends(scene_.comm, scene_.bonds(), scene_.inertia(), ends);
  shared_.bind();
  for (int row : rows) {
    Bond* b = scene_.bonds().find(row);
    if (!b) continue;
    b->unmoved = false;
    find_near_threshold(scene_, *b);
  }
  added_.refresh(rows);
}

bool Condensing::rests(Bond& b) {
  constexpr double kBelow = 0.95;  // margin against activation in the next step
  const BondRecord& record = scene_.bonds().record(b);
  if (!scene_.bonds().is_whole(b)) return false;
  if (!record.has_grain(0) || !record.has_grain(1)) return false;  // fragments may be far from the grain that is left
  // A condensed bond is not examined, so node splitting and the check must have seen all failed points before.
  const auto is_to_split = [](const BlockMeta& m) { return (m.failed & ~m.split_checked) != 0; };
  if (scene_.options.split && std::any_of(b.points.meta.begin(), b.points.meta.end(), is_to_split)) return false;
  if (cracks_.separated(b.row) && (scene_.touches() || !cracks_.has_seen(b.row, Cracks::count_broken(b)))) return false;
  const BondEnd* ends = scene_.grains.ends_of(b);
  if (cracks_.separated(b.row))
    return condensed_.matches_rigid_pieces(b, record, ends, work_.energy_of(b), load_history_.largest(b.row), scene_.weight().data(),
                                           scene_.dt_last, *scene_.law);
  if (!scene_.options.condense || !scene_.stays_linear(b)) return false;
  const double root =
      std::max(largest_root_of_drive(b.points, *scene_.law, nullptr), largest_root_of_drive(b.film.points, *scene_.law, nullptr));
  const double largest = kBelow * root_of_share(*scene_.law, scene_.options.activation_share);
  if (root >= largest) return false;
  return condensed_.matches_static_solution(b, record, ends, work_.energy_of(b), root, largest, scene_.weight().data(), scene_.dt_last,
                                            *scene_.law);
}

// Collective. With `condense no`, only bonds in which faces of a crack slid too far. Rigid pieces keep no strain, and no
// large fragment that is attached to no grain.
Condensing::Parting Condensing::rows_to_part() {
  Parting parted;
  std::vector<int> rows;
  const std::vector<BondRecord>& table = scene_.bonds().table;
  for (std::size_t row = 0; row < table.size() && scene_.touches(); ++row)
    if (!table[row].condensed && table[row].has_grain(0) && table[row].has_grain(1) && cracks_.separated(row))
      rows.push_back(static_cast<int>(row));
  if (rows.empty()) return parted;
  std::vector<double> sums(3 * rows.size(), 0.0);  // points in fragments, broken points and links, ranks on which a mechanism has ended
  for (std::size_t n = 0; n < rows.size(); ++n) {
    Bond* b = scene_.bonds().find(rows[n]);
    if (!b) continue;
    sums[3 * n] = points_in_fragments(b->points);
    sums[3 * n + 1] = Cracks::count_broken(*b);
    sums[3 * n + 2] += !b->film.empty();  // its columns have no other contact
    for (const auto& p : b->mechanisms) sums[3 * n + 2] += !scene_.options.condense && p->has_ended(b->points, b->grid);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, scene_.comm);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    // Small fragments stay with the grains that they are at, but those that were free may be anywhere.
    const bool free = scene_.fragments.has(rows[n]);
    const bool due = free ? sums[3 * n] == 0.0 : scene_.options.condense || sums[3 * n + 2] > 0.0;
    if (!due || !cracks_.has_seen(rows[n], sums[3 * n + 1])) continue;
    (sums[3 * n] < kLeastLoose ? parted.in_pieces : parted.with_fragments).push_back(rows[n]);
  }
  return parted;
}

// Collective. From here on surfaces touch, so contact points and crack faces of these bonds end, with their energy.
void Condensing::release_fragments(const std::vector<int>& rows) {
  released_.rows = rows;
  if (rows.empty()) return;
  scene_.fragments.add_rows(rows);
  for (int row : rows) {
    Bond* b = scene_.bonds().find(row);
    if (!b) continue;
    released_.energy += work_.energy_of(*b);
    b->points.contacts.clear();
  }
  layout_manager_.lay_out_again(rows, {}, {});
}

// Collective. Returns bonds that may be condensed again. The force of one step passes zero while pieces ring, so
// separated bonds must be at rest for a whole window of the load history.
std::vector<int> Condensing::rows_that_rest() {
  std::vector<int> mine;
  for (Bond& b : scene_.bonds().resolved())
    if (rests(b)) mine.push_back(b.row);
  std::vector<int> rows;
  std::vector<BondRecord>& table = scene_.bonds().table;
  std::vector<double> rest_time(table.size(), 0.0);
  for (int row : scene_.agreed_rows(mine)) {
    const double time = table[row].rest_time + scene_.options.check_every * scene_.dt_last;
    if (cracks_.separated(row) && time * scene_.shear_speed() < LoadHistory::window_path(table[row])) rest_time[row] = time;
    else rows.push_back(row);
  }
  for (std::size_t row = 0; row < table.size(); ++row) table[row].rest_time = rest_time[row];
  return rows;
}

void Condensing::condense_again() {
  if (!scene_.ends_step() || scene_.now.number % scene_.options.check_every != 0) return;
  BondedGrains& grains = scene_.grains;
  const Parting separated = rows_to_part();
  release_fragments(separated.with_fragments);
  const std::vector<int>& parted = separated.in_pieces;
  scene_.fragments.remove_rows(parted);
  std::vector<int> rows = rows_that_rest();
  rows.insert(rows.end(), parted.begin(), parted.end());
  sort_unique(rows);
  recondensed_.rows = rows;
  if (rows.empty()) return;
  condensed_.prepare_pieces(scene_.comm, scene_.bonds(), parted, *scene_.law);
  std::vector<int> first(rows.size(), std::numeric_limits<int>::max());  // rank that counts the momentum of the condensed bond
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (scene_.bonds().find(rows[n])) first[n] = rank_in(scene_.comm);
  MPI_Allreduce(MPI_IN_PLACE, first.data(), static_cast<int>(first.size()), MPI_INT, MPI_MIN, scene_.comm);
  const double half = 0.5 * scene_.dt_last;
  std::vector<double> lost_momentum(6 * grains.ends.ends.size(), 0.0);  // of each end: momentum that the bond loses, given to the grain
  struct OfRow {
    int row, at;
    bool counts;
    BondEnd ends[2];
  };
  std::vector<OfRow> here;
  const auto add_to_lost = [&](const OfRow& o, const GrainLoads& momentum, double sign) {
    for (int s = 0; s < 2; ++s) {
      const std::array<double, 6> of_end = in_box(o.ends[s], momentum.of[s], momentum.of[s] + 3);
      for (int d = 0; d < 6; ++d) lost_momentum[6 * (o.at + s) + d] += sign * of_end[d];
    }
  };
  for (int row : rows) scene_.bonds().table[row].condensed = true;
  mark_pieces(rows);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const int row = rows[n];
    Bond* b = scene_.bonds().find(row);
    if (!b) continue;
    recondensed_.energy += work_.energy_of(*b);
    const BondEnd* ends = grains.ends_of(*b);
    here.push_back({row, b->first_end_index, first[n] == rank_in(scene_.comm), {ends[0], ends[1]}});
    add_to_lost(here.back(), condensed_.momentum_of_nodes(*b, scene_.bonds().table[row], ends), 1.0);
    condensed_.forget_candidate(row);
    revert_field(b->points);
    revert_field(b->film.points);
    b->film.close_faces();
    for (std::vector<double>* values : {&b->grid.displacement, &b->grid.velocity, &b->grid.acceleration})
      std::fill(values->begin(), values->end(), 0.0);
    b->near_threshold = false;
    b->average = DriveAverage();  // it would keep its lists as long as the bond is condensed
  }
  const std::vector<BondedGrains::OwnedEnd> owned = grains.owned();
  BondEnds ends = grains.ends;  // copy with the order of `lost_momentum`; rebind_ends() drops the ends of condensed bonds
  scene_.bonds().resolved_changed();
  layout_manager_.lay_out(rows, {}, {});
  grains.rebind_ends(scene_.comm, scene_.bonds(), scene_.inertia(), {});
  added_.refresh(rows);
  condensed_.solve(scene_.comm, scene_.bonds(), rows, *scene_.law, *scene_.penalty, scene_.scaled_density);
  for (const OfRow& o : here)
    if (o.counts) add_to_lost(o, condensed_.momentum_as_condensed(o.row, scene_.bonds().table[o.row], o.ends, half), -1.0);
  ends.sum(lost_momentum.data(), 6);
  std::vector<BondedGrains::Six> momentum(grains.grains.size(), BondedGrains::Six{});
  for (const BondedGrains::OwnedEnd& o : owned)
    for (int d = 0; d < 6; ++d) momentum[o.grain][d] += lost_momentum[6 * o.at + d];
  condensed_.bind(scene_.comm, scene_.bonds(), grains);
  condensed_.follow(grains, scene_.weight().data());
  recondensed_.to_grains = grains.apply_impulse(scene_.comm, momentum, condensed_.pack());
}

}  // namespace mpdem
