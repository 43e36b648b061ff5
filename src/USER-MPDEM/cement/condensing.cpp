// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "condensing.h"

#include <algorithm>

#include "../mpm/field_drive.h"
#include "../mpm/point_state.h"
#include "../parallel/agree.h"
#include "pattern_layouts.h"

namespace mpdem {

// Bonds that no step has moved yet, since their points and nodes are at the creation.
void Condensing::choose() {
  for (std::size_t row = 0; row < scene_.bonds.table.size(); ++row) {
    Body& b = scene_.bonds.table[row];
    if (!b.in_motion) b.condensed = scene_.options.condense && scene_.penalty;
    if (b.condensed && !scene_.options.condense)
      throw BadState(text_of("bonds were condensed in the steps before, that of grains ", b.grain[0], " and ", b.grain[1], " still is; use 'condense yes'"));
  }
  scene_.bonds.awake_changed();
}

void Condensing::bind() {
  scene_.grains.bind(scene_.comm, scene_.bonds, scene_.inertia);
  scene_.grains.distribute(scene_.bonds);  // who looks before the next step is not to find grains at rest
  scene_.laid_out = true;
  if (scene_.dt_last == 0.0) scene_.dt_last = scene_.now.dt;
  condensed_.bind(scene_.comm, scene_.bonds, scene_.grains);
  condensed_.follow(scene_.grains, scene_.weight().data());
}

void Condensing::condense(const std::vector<int>& rows, bool at_start) {
  if (!scene_.options.condense || !scene_.penalty) return;
  std::vector<int> apart;
  for (int row : rows)
    if (scene_.bonds.table[row].condensed && cracks_.size() > static_cast<std::size_t>(row) && cracks_.separated(row)) apart.push_back(row);
  for (int row : apart) scene_.bonds.table[row].condensed = false;
  scene_.bonds.awake_changed();
  take_patterns(at_start);
  condensed_.solve(scene_.comm, scene_.bonds, rows, *scene_.law, *scene_.penalty, scene_.inertia);
  if (!apart.empty()) {
    bind();
    shared_.bind();
    added_.refresh(apart);
    return;
  }
  condensed_.bind(scene_.comm, scene_.bonds, scene_.grains);
  condensed_.follow(scene_.grains, scene_.weight().data());
}

// Bonds that stand for those of the patterns that this rank has grains of. Grains may have come from other ranks.
void Condensing::take_patterns(bool at_start) {
  std::vector<int> patterns = patterns_of_owned_grains(scene_);
  if (!at_start) patterns.erase(std::remove_if(patterns.begin(), patterns.end(), [&](int p) { return condensed_.has_pattern(p); }), patterns.end());
  condensed_.take_patterns(scene_.comm, layouts_of_patterns(scene_, patterns, &*scene_.penalty), static_cast<int>(scene_.bonds.patterns.size()), at_start,
                           *scene_.law, *scene_.penalty, scene_.inertia);
}

// Bonds that are to wake and have no points get them before the next step, and wake in it. Answers the others.
std::vector<int> Condensing::ask_for_points(const std::vector<int>& rows) {
  rows_that_want_points_.clear();
  std::vector<int> others;
  for (int row : rows) {
    Body& b = scene_.bonds.table[row];
    if (b.pattern > 0) b.wants_points = true;
    (b.pattern > 0 ? rows_that_want_points_ : others).push_back(row);
  }
  return others;
}

void Condensing::wake() {
  if (!condensed_.any()) return;
  const std::vector<int> rows = ask_for_points(scene_.agreed_rows(condensed_.due(scene_.bonds, scene_.options, *scene_.law)));
  if (rows.empty()) return;
  const std::array<double, 3> weight = scene_.weight();
  double given_up = 0.0;
  std::vector<GrainSide> sides;
  for (int row : rows) {
    const CondensedBonds::Energies e = condensed_.energies_of(row, scene_.bonds, 0.5 * scene_.dt_last);
    given_up += e.elastic + e.discrete_kinetic;
    condensed_.wake(scene_.comm, row, scene_.bonds.find(row), scene_.bonds, weight.data(), scene_.dt_last, *scene_.law);
    if (!condensed_.has(row)) continue;
    const std::array<GrainSide, 2> of_row = condensed_.loaded_sides(row, scene_.bonds, weight.data());
    sides.insert(sides.end(), of_row.begin(), of_row.end());
  }
  for (int row : rows) scene_.bonds.table[row].condensed = false;
  scene_.bonds.awake_changed();
  condensed_.drop(scene_.comm, rows, scene_.bonds, scene_.grains);
  condensed_.resume(scene_.grains, weight.data());
  scene_.grains.wake(scene_.comm, scene_.bonds, scene_.inertia, sides);
  shared_.bind();
  for (int row : rows) {
    Bond* b = scene_.bonds.find(row);
    if (!b) continue;
    b->resting = Resting();
    b->near_threshold = scene_.options.skip.nonlocal && is_near_threshold(b->points, *scene_.law);
  }
  added_.refresh(rows);
  for (int row : rows)
    if (const Bond* b = scene_.bonds.find(row)) given_up -= work_.energy_of(*b);
  scene_.books.release(given_up);
}

// Collective. Bonds that may be condensed again.
std::vector<int> Condensing::rows_that_rest() {
  constexpr double kBelow = 0.95;  // so that it does not wake at once
  const double wakes = root_of_share(*scene_.law, scene_.options.wake);
  std::vector<int> mine;
  for (Bond& b : scene_.bonds.awake()) {
    const Body& body = scene_.bonds.body(b);
    if (cracks_.separated(b.body) || b.cut_by_ranks() || b.points.size() != body.points) continue;
    const double root = largest_root_of_drive(b.points, *scene_.law, false);
    if (root >= kBelow * wakes) continue;
    if (condensed_.fits(b, body, scene_.grains.side_of(b), work_.energy_of(b), root, scene_.weight().data(), scene_.dt_last, *scene_.law)) mine.push_back(b.body);
  }
  return scene_.agreed_rows(mine);
}

void Condensing::condense_again() {
  if (!scene_.options.condense || !scene_.penalty || scene_.now.number % scene_.options.check_every != 0) return;
  const std::vector<int> rows = rows_that_rest();
  if (rows.empty()) return;
  double given_up = 0.0;
  std::vector<double> rest(6 * scene_.grains.sides.sides.size(), 0.0);  // of the momentum, which the grains take up in this step
  for (int row : rows) {
    scene_.bonds.table[row].condensed = true;
    Bond* b = scene_.bonds.find(row);
    if (!b) continue;
    given_up += work_.energy_of(*b);
    const GrainSide* side = scene_.grains.side_of(*b);
    const GrainLoads loads = condensed_.rest_of_momentum(*b, scene_.bonds.table[row], side, scene_.now.dt);
    for (int s = 0; s < 2; ++s) {
      const std::array<double, 6> of_side = in_box(side[s], loads.of[s], loads.of[s] + 3);
      std::copy(of_side.begin(), of_side.end(), &rest[6 * (b->side + s)]);
    }
    condensed_.forget_candidate(row);
    go_back_to_creation(b->points);
    for (std::vector<double>* values : {&b->grid.displacement, &b->grid.velocity, &b->grid.acceleration}) std::fill(values->begin(), values->end(), 0.0);
    b->near_threshold = false;
  }
  scene_.grains.sides.sum(rest.data(), 6);
  for (const BondedGrains::OwnedSide& o : scene_.grains.owned())
    for (int d = 0; d < 6; ++d) scene_.grains.grains[o.grain].force[d] += rest[6 * o.at + d];
  scene_.bonds.awake_changed();
  arrangement_.lay_out(rows, {}, {});
  scene_.grains.wake(scene_.comm, scene_.bonds, scene_.inertia, {});
  added_.refresh(rows);
  condensed_.solve(scene_.comm, scene_.bonds, rows, *scene_.law, *scene_.penalty, scene_.inertia);
  condensed_.bind(scene_.comm, scene_.bonds, scene_.grains);
  condensed_.resume(scene_.grains, scene_.weight().data());
  for (int row : rows) {
    const CondensedBonds::Energies e = condensed_.energies_of(row, scene_.bonds, 0.5 * scene_.dt_last);
    given_up -= e.elastic + e.discrete_kinetic;
  }
  scene_.books.damp(given_up);
}

}  // namespace mpdem
