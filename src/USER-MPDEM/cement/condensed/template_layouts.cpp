// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "template_layouts.h"

#include <algorithm>

#include "../../mpm/point_state.h"
#include "../../parallel/agree.h"
#include "../layout/layout.h"

namespace mpdem {

namespace {

// Lays out bonds that are whole on this rank, in their configuration at creation.
std::vector<CondensedBonds::TemplateBond> layouts_at_creation(const Scene& scene, Bonds& alone, const PenaltyParameters* penalty) {
  const CementOptions& options = scene.options;
  NodeSplitting splits;
  splits.set_density(scene.inertia());
  NewLayersOfBonds layers = splits.start(MPI_COMM_SELF, alone, options);
  std::vector<LayoutRequest> requests;
  std::vector<int> rows;
  for (Bond& b : alone) {
    for (PointStore* store : b.stores()) {
      const std::string trouble = mpdem::read_point_states(*store, scene.law);
      if (!trouble.empty()) throw BadState(trouble);
    }
    requests.emplace_back();
    requests.back().row = b.row;
    requests.back().points = std::move(b.points);
    requests.back().layers = std::move(layers[b.row]);
    rows.push_back(b.row);
  }
  const LayoutRules rules{MPI_COMM_SELF, alone.table, options, scene.law, scene.inertia(), penalty, splits, *scene.formulation};
  std::vector<CondensedBonds::TemplateBond> found;
  for (BondLayout& l : make_layout(rules, rows, std::move(requests))) {
    found.push_back({l.row + 1, Bond(), alone.table[l.row], true});
    Bond& b = found.back().bond;
    b.points = std::move(l.points);
    b.grid = std::move(l.grid);
    b.links = std::move(l.links);
    b.film = std::move(alone.find(l.row)->film);
    lay_out_film(b.film, found.back().record, options, scene.law);
  }
  return found;
}

}  // namespace

std::vector<int> templates_of_owned_grains(const Scene& scene) {
  const auto owned = [&](int tag) { return scene.grains.find(tag) != nullptr; };
  std::vector<char> needed(scene.bonds().templates.size() + 1, 0);
  for (const BondRecord& b : scene.bonds().table)
    if (b.point_template > 0 && !needed[b.point_template]) needed[b.point_template] = owned(b.grain[0]) || owned(b.grain[1]);
  std::vector<int> templates;
  for (std::size_t p = 1; p < needed.size(); ++p)
    if (needed[p]) templates.push_back(static_cast<int>(p));
  return templates;
}

std::vector<CondensedBonds::TemplateBond> layouts_of_templates(const Scene& scene, const std::vector<int>& templates,
                                                               const PenaltyParameters* penalty) {
  Bonds alone;  // one row for each template, so that keys of nodes are equal on all ranks
  alone.table.resize(scene.bonds().templates.size());
  std::vector<char> known(scene.bonds().templates.size() + 1, 1);
  for (int p : templates) known[p] = 0;
  for (const BondRecord& record : scene.bonds().table) {
    if (record.point_template == 0 || known[record.point_template]) continue;
    known[record.point_template] = 1;
    const int row = record.point_template - 1;
    const PointTemplate& point_template = scene.bonds().templates[row];
    alone.table[row] = record;
    for (std::size_t n = 0; n < point_template.points.size(); ++n)
      alone.add(point_template.record(n, row, record), static_cast<int>(n) + 1);
  }
  std::vector<CondensedBonds::TemplateBond> found;
  std::string trouble;
  try {
    if (!templates.empty()) found = layouts_at_creation(scene, alone, penalty);
  } catch (const BadState& e) {
    trouble = e.what();
  }
  throw_if_any(scene.comm, trouble);
  return found;
}

}  // namespace mpdem
