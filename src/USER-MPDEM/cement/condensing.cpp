// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// When bonds are condensed, wake, and are condensed again. See condensed_bonds.h.
#include <algorithm>

#include "../mpm/field_drive.h"
#include "../mpm/point_state.h"
#include "../parallel/agree.h"
#include "cement.h"

namespace mpdem {

// Bonds that no step has moved yet, since their points and nodes are at the creation.
void Cement::choose_condensed() {
  for (std::size_t row = 0; row < bonds_.table.size(); ++row) {
    Body& b = bonds_.table[row];
    if (!b.in_motion) b.condensed = options_.condense && penalty_;
    if (b.condensed && !options_.condense)
      throw BadState(text_of("bonds were condensed in the steps before, that of grains ", b.grain[0], " and ", b.grain[1], " still is; use 'condense yes'"));
  }
  bonds_.awake_changed();
}

// Collective. After their layout, with the links of the run.
void Cement::condense(const std::vector<int>& rows, bool at_start) {
  if (!options_.condense || !penalty_) return;
  std::vector<int> apart;
  for (int row : rows)
    if (bonds_.table[row].condensed && cracks_.size() > static_cast<std::size_t>(row) && cracks_.separated(row)) apart.push_back(row);
  for (int row : apart) bonds_.table[row].condensed = false;
  bonds_.awake_changed();
  take_patterns(at_start);
  condensed_.solve(comm_, bonds_, rows, *law_, *penalty_, inertia_);
  if (!apart.empty()) {
    bind_grains();
    bind_shared_nodes();
    refresh_added_mass(apart);
    return;
  }
  condensed_.bind(comm_, bonds_, grains_);
  condensed_.follow(grains_, weight_of_cement().data());
}

// Bonds that stand for those of the patterns that this rank has grains of. Grains may have come from other ranks.
void Cement::take_patterns(bool at_start) {
  std::vector<int> patterns = patterns_of_owned_grains();
  if (!at_start) patterns.erase(std::remove_if(patterns.begin(), patterns.end(), [&](int p) { return condensed_.has_pattern(p); }), patterns.end());
  condensed_.take_patterns(comm_, layouts_of_patterns(patterns, &*penalty_), static_cast<int>(bonds_.patterns.size()), at_start, *law_, *penalty_, inertia_);
}

// Ascending.
std::vector<int> Cement::patterns_of_owned_grains() const {
  const auto owned = [&](int tag) {
    const auto at = std::lower_bound(grains_.grains.begin(), grains_.grains.end(), tag, [](const Grain& g, int t) { return g.tag < t; });
    return at != grains_.grains.end() && at->tag == tag;
  };
  std::vector<char> needed(bonds_.patterns.size() + 1, 0);
  for (const Body& b : bonds_.table)
    if (b.pattern > 0 && !needed[b.pattern]) needed[b.pattern] = owned(b.grain[0]) || owned(b.grain[1]);
  std::vector<int> patterns;
  for (std::size_t p = 1; p < needed.size(); ++p)
    if (needed[p]) patterns.push_back(static_cast<int>(p));
  return patterns;
}

// Collective. Of this rank alone, at the creation: the first bond of a pattern stands for all.
std::vector<CondensedBonds::OfPattern> Cement::layouts_of_patterns(const std::vector<int>& patterns, const PenaltyParameters* penalty) const {
  Bonds alone;  // a row a pattern, so that keys of nodes are the same on all ranks
  alone.table.resize(bonds_.patterns.size());
  std::vector<char> known(bonds_.patterns.size() + 1, 1);
  for (int p : patterns) known[p] = 0;
  for (const Body& body : bonds_.table) {
    if (body.pattern == 0 || known[body.pattern]) continue;
    known[body.pattern] = 1;
    const int row = body.pattern - 1;
    const PointPattern& pattern = bonds_.patterns[row];
    alone.table[row] = body;
    for (std::size_t n = 0; n < pattern.points.size(); ++n) alone.add(pattern.record(n, row, body), static_cast<int>(n) + 1);
  }
  std::vector<CondensedBonds::OfPattern> found;
  std::string trouble;
  try {
    if (!patterns.empty()) found = layouts_at_creation(alone, penalty);
  } catch (const BadState& e) {
    trouble = e.what();
  }
  throw_if_any(comm_, trouble);
  return found;
}

// Of bonds that this rank has as a whole.
std::vector<CondensedBonds::OfPattern> Cement::layouts_at_creation(Bonds& alone, const PenaltyParameters* penalty) const {
  CementOptions options(options_);
  options.split = false;
  Sheets sheets;
  const Cracks intact;
  NewPartsOfBonds parts = sheets.divide(MPI_COMM_SELF, alone, options);
  std::vector<LayoutRequest> requests;
  std::vector<int> rows;
  for (Bond& b : alone) {
    const std::string trouble = mpdem::take_up_states(b.points, law_);
    if (!trouble.empty()) throw BadState(trouble);
    requests.emplace_back();
    requests.back().body = b.body;
    requests.back().points = std::move(b.points);
    requests.back().parts = std::move(parts[b.body]);
    rows.push_back(b.body);
  }
  const LayoutRules rules{MPI_COMM_SELF, alone.table, options, law_, sheets, intact, inertia_, penalty, nullptr};
  std::vector<CondensedBonds::OfPattern> found;
  for (BondLayout& l : make_layout(rules, rows, std::move(requests))) {
    found.push_back({l.body + 1, Bond(), alone.table[l.body], true});
    Bond& b = found.back().bond;
    b.points = std::move(l.points);
    b.grid = std::move(l.grid);
    b.links = std::move(l.links);
    b.laid_out_blocks = b.points.blocks.size();
  }
  return found;
}

// Bonds that are to wake and have no points get them before the next step, and wake in it. Answers the others.
std::vector<int> Cement::ask_for_points(const std::vector<int>& rows) {
  arrivals_.rows_that_want_points.clear();
  std::vector<int> others;
  for (int row : rows) {
    Body& b = bonds_.table[row];
    if (b.pattern > 0) b.wants_points = true;
    (b.pattern > 0 ? arrivals_.rows_that_want_points : others).push_back(row);
  }
  return others;
}

// Of condensed bonds near their threshold, at the end of the forces of a step: they are resolved from the next drift on.
void Cement::wake_bonds() {
  if (!condensed_.any()) return;
  const std::vector<int> rows = ask_for_points(agreed_rows(condensed_.due(bonds_, options_, *law_)));
  if (rows.empty()) return;
  const std::array<double, 3> weight = weight_of_cement();
  double given_up = 0.0;
  std::vector<GrainSide> sides;
  for (int row : rows) {
    const CondensedBonds::Energies e = condensed_.energies_of(row, bonds_, 0.5 * dt_last_);
    given_up += e.elastic + e.kept;
    condensed_.wake(comm_, row, bonds_.find(row), bonds_, weight.data(), dt_last_, *law_);
    if (!condensed_.has(row)) continue;
    const std::array<GrainSide, 2> of_row = condensed_.loaded_sides(row, bonds_, weight.data());
    sides.insert(sides.end(), of_row.begin(), of_row.end());
  }
  for (int row : rows) bonds_.table[row].condensed = false;
  bonds_.awake_changed();
  condensed_.drop(comm_, rows, bonds_, grains_);
  condensed_.resume(grains_, weight.data());
  grains_.wake(comm_, bonds_, inertia_, sides);
  bind_shared_nodes();
  for (int row : rows) {
    Bond* b = bonds_.find(row);
    if (!b) continue;
    b->resting = Resting();
    b->near_threshold = options_.skip.nonlocal && is_near_threshold(b->points, *law_);
  }
  refresh_added_mass(rows);
  for (int row : rows)
    if (const Bond* b = bonds_.find(row)) given_up -= energy_of(*b);
  books_.release(given_up);
}

// The acceleration by gravity that acts on the inertia of the cement.
std::array<double, 3> Cement::weight_of_cement() const {
  const double* g = now_.gravity;
  return {g[0] / options_.mass_scale, g[1] / options_.mass_scale, g[2] / options_.mass_scale};
}

// Collective. Bonds that are awake, whole on a rank, and far from their threshold again, where force and energy hardly change by it: their waves have
// gone. They keep their damage, and have the stiffness of the present.
void Cement::condense_again() {
  if (!options_.condense || !penalty_ || now_.number % options_.check_every != 0) return;
  constexpr double kBelow = 0.95;  // so that it does not wake at once
  const double wakes = root_of_share(*law_, options_.wake);
  const std::array<double, 3> weight = weight_of_cement();
  std::vector<int> mine;
  for (Bond& b : bonds_.awake()) {
    const Body& body = bonds_.body(b);
    if (cracks_.separated(b.body) || b.cut_by_ranks() || b.points.size() != body.points) continue;
    const double root = largest_root_of_drive(b.points, *law_, false);
    if (root >= kBelow * wakes) continue;
    if (condensed_.fits(b, body, grains_.side_of(b), energy_of(b), root, weight.data(), dt_last_, *law_)) mine.push_back(b.body);
  }
  const std::vector<int> rows = agreed_rows(mine);
  if (rows.empty()) return;
  double given_up = 0.0;
  std::vector<double> rest(6 * grains_.sides.sides.size(), 0.0);  // of the momentum, which the grains take up in this step
  for (int row : rows) {
    bonds_.table[row].condensed = true;
    Bond* b = bonds_.find(row);
    if (!b) continue;
    given_up += energy_of(*b);
    const GrainSide* side = grains_.side_of(*b);
    const GrainLoads loads = condensed_.rest_of_momentum(*b, bonds_.table[row], side, now_.dt);
    for (int s = 0; s < 2; ++s) {
      const std::array<double, 6> of_side = in_box(side[s], loads.of[s], loads.of[s] + 3);
      std::copy(of_side.begin(), of_side.end(), &rest[6 * (b->side + s)]);
    }
    condensed_.forget_candidate(row);
    go_back_to_creation(b->points);
    for (std::vector<double>* values : {&b->grid.displacement, &b->grid.velocity, &b->grid.acceleration}) std::fill(values->begin(), values->end(), 0.0);
    b->near_threshold = false;
  }
  grains_.sides.sum(rest.data(), 6);
  for (const BondedGrains::OwnedSide& o : grains_.owned())
    for (int d = 0; d < 6; ++d) grains_.grains[o.grain].force[d] += rest[6 * o.at + d];
  bonds_.awake_changed();
  lay_out(rows, {});
  grains_.wake(comm_, bonds_, inertia_, {});
  refresh_added_mass(rows);
  condensed_.solve(comm_, bonds_, rows, *law_, *penalty_, inertia_);
  condensed_.bind(comm_, bonds_, grains_);
  condensed_.resume(grains_, weight.data());
  for (int row : rows) {
    const CondensedBonds::Energies e = condensed_.energies_of(row, bonds_, 0.5 * dt_last_);
    given_up -= e.elastic + e.kept;
  }
  books_.damp(given_up);
}

}  // namespace mpdem
