// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "layout_manager.h"

#include <algorithm>

#include "../../coupling/relative_damping.h"
#include "../../parallel/ranks.h"
#include "../bond/bond_motion.h"
#include "../layout/mechanisms.h"
#include "formulations.h"
#include "nonlocal.h"
#include "../layout/starting_motion.h"

namespace mpdem {

namespace {

// Motion of each of these bonds, summed over all ranks. Velocities are ahead by the kick of the next drift.
std::vector<BondMotion> sums_of_motion(const Scene& scene, const std::vector<int>& rows) {
  static_assert(sizeof(BondMotion) % sizeof(double) == 0, "sums of numbers");
  constexpr int kWidth = sizeof(BondMotion) / sizeof(double);
  std::vector<BondMotion> sums(rows.size(), BondMotion{});
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (const Bond* b = scene.bonds().find(rows[n])) sums[n] = mpdem::sums_of_motion(b->grid, scene.kick());
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), kWidth * static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, scene.comm);
  return sums;
}

// Restores momentum and angular momentum. The energy that is missing counts as released.
void keep_motion(Scene& scene, const std::vector<int>& rows, const std::vector<BondMotion>& before) {
  std::vector<BondMotion> after = sums_of_motion(scene, rows);
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (Bond* b = scene.bonds().find(rows[n])) restore_rigid_motion(b->grid, before[n], after[n]);
  after = sums_of_motion(scene, rows);
  const int me = rank_in(scene.comm);
  for (std::size_t n = 0; n < rows.size() && me == 0; ++n) scene.energy.release(before[n].kinetic - after[n].kinetic);
}

NewLayersOfBonds layers_before_layout(const Scene& scene, Bonds& bonds, const std::vector<int>& fresh, NodeSplitting& splits) {
  NewLayersOfBonds layers = splits.start(scene.comm, bonds, scene.options, fresh);
  splits.fetch_copies(scene.comm, bonds);
  return layers;
}

}  // namespace

std::vector<BondLayout> layouts_of_copies(const Scene& scene, const Discontinuities& divisions, const RestoredNodes& of_file,
                                          const std::vector<int>& fresh, const PenaltyParameters* penalty) {
  Bonds copies;
  copies.table = scene.bonds().table;
  for (const Bond& b : scene.bonds()) copies.make(b.row).points = b.points;
  RestoredNodes restored(of_file);
  restored.send_to_holders();
  const std::unique_ptr<NodeSplitting> splits = divisions.splits->copy();
  NewLayersOfBonds layers = layers_before_layout(scene, copies, fresh, *splits);
  std::vector<LayoutRequest> requests;
  for (Bond& b : copies) {
    requests.emplace_back();
    LayoutRequest& r = requests.back();
    r.row = b.row;
    r.points = std::move(b.points);
    r.points.sort_links();
    r.layers.layer_of_slot = layers[b.row].layer_of_slot;
    if (penalty) r.before = restored.any() ? restored.of(b.row) : scene.bonds().find(b.row)->grid.kinematics();
  }
  // Points of a copy do not move, so its grid needs no margin.
  const std::unique_ptr<const Formulation> at_rest = formulation_of(CementOptions());
  const LayoutRules rules{scene.comm, copies.table, scene.options, scene.law, scene.inertia(), penalty, *splits, *at_rest};
  std::vector<BondLayout> layouts = make_layout(rules, scene.all_rows(), std::move(requests));
  for (BondLayout& l : layouts) {
    l.film = scene.bonds().find(l.row)->film;
    lay_out_film(l.film, copies.table[l.row], scene.options, scene.law);
  }
  return layouts;
}

LayoutRequest LayoutManager::request_of(Bond& b, NewLayersOfBonds& layers) {
  LayoutRequest r;
  r.row = b.row;
  r.points = std::move(b.points);
  r.before = b.grid.kinematics();
  if (restored_.any()) r.before = std::move(restored_.of(b.row));
  const auto changed = layers.find(b.row);
  if (changed != layers.end()) r.layers = std::move(changed->second);
  return r;
}

// Where nodes split, constraints end, and mass returns from mass receivers to nodes of another velocity. keep_motion()
// restores momentum and angular momentum.
void LayoutManager::lay_out(const std::vector<int>& rows, NewLayersOfBonds layers, const How& how) {
  restored_.send_to_holders();
  const bool moves = scene_.laid_out && how.splits;
  const std::vector<BondMotion> motion = moves ? sums_of_motion(scene_, rows) : std::vector<BondMotion>();
  std::vector<LayoutRequest> requests;
  for (int row : rows)
    if (Bond* b = scene_.bonds().find(row)) requests.push_back(request_of(*b, layers));
  const PenaltyParameters* penalty = scene_.penalty ? &*scene_.penalty : nullptr;
  const LayoutRules rules{scene_.comm, scene_.bonds().table,     scene_.options,      scene_.law, scene_.inertia(),
                          penalty,     *discontinuities_.splits, *scene_.formulation, how.arrange};
  std::vector<BondLayout> layouts = make_layout(rules, rows, std::move(requests));
  restored_.clear();
  install(layouts);
  if (moves) keep_motion(scene_, rows, motion);
  start_velocities(scene_, layouts);
  scene_.bonds().drop_empty(rows);
  for (int row : rows)
    if (Bond* b = scene_.bonds().find(row)) scene_.formulation->follow_layout(*b);
  shared_.bind();
}

void LayoutManager::lay_out_again(const std::vector<int>& rows, NewLayersOfBonds layers, const How& how) {
  lay_out(rows, std::move(layers), how);
  added_.refresh(rows);
}

NewLayersOfBonds LayoutManager::layers_at_start() {
  NewLayersOfBonds layers = layers_before_layout(scene_, scene_.bonds(), fresh_points_, *discontinuities_.splits);
  fresh_points_.clear();
  return layers;
}

void LayoutManager::move_phantom_nodes() { discontinuities_.splits->fetch_copies(scene_.comm, scene_.bonds()); }

void LayoutManager::remember_axis() {
  std::vector<BondRecord>& table = scene_.bonds().table;
  if (std::all_of(table.begin(), table.end(), [](const BondRecord& b) { return b.axis_rule != AxisRule::none; })) return;
  std::vector<int> open(table.size(), 0);
  for (const Bond& b : scene_.bonds())
    for (const PointStore* store : b.stores())
      for (const BlockMeta& m : store->meta)
        if (m.framed != m.occupied) open[b.row] = 1;
  for (int row : scene_.bonds().rows_without_points()) open[row] = 1;
  MPI_Allreduce(MPI_IN_PLACE, open.data(), static_cast<int>(open.size()), MPI_INT, MPI_MAX, scene_.comm);
  for (std::size_t b = 0; b < table.size(); ++b) {
    if (!open[b] || table[b].axis_rule != AxisRule::none) continue;
    table[b].axis_rule = scene_.options.axis;
    std::copy(scene_.options.axis_direction, scene_.options.axis_direction + 3, table[b].axis);
  }
}

void LayoutManager::sync_slots() {
  if (!scene_.laid_out) return;
  for (Bond& b : scene_.bonds())
    if (scene_.formulation->sort_links(b)) scene_.host().slots_changed(b);
}

// In a separated bond, each node follows the grain to which it is connected.
void LayoutManager::follow_grains(Bond& b) const {
  if (b.mechanisms.empty()) return;
  const std::vector<char> connected =
      discontinuities_.cracks.separated(b.row) ? connected_grains_of_nodes(b.points, b.grid) : std::vector<char>();
  for (const auto& p : b.mechanisms) p->follow_grains(b.grid, scene_.bonds().record(b), connected);
}

void LayoutManager::start_anew(Bond& b) {
  b.layout = ++layouts_;
  b.mechanisms = mechanisms_of(scene_, b, *discontinuities_.splits);
  b.added = AddedMass();
  b.unmoved = scene_.options.advance.skip_resting && b.points.unstrained();
  follow_grains(b);
  b.transfer_change.clear();
}

void LayoutManager::install(std::vector<BondLayout>& layouts) {
  for (BondLayout& l : layouts) {
    Bond& b = *scene_.bonds().find(l.row);
    b.points = std::move(l.points);
    b.grid = std::move(l.grid);
    if (l.links.is_elastic()) l.links.continue_from(b.links);
    b.links = std::move(l.links);
    lay_out_film(b.film, scene_.bonds().record(b), scene_.options, scene_.law);
    start_anew(b);
    find_near_threshold(scene_, b);
    b.failed.clear();
    b.laid_out_blocks = b.points.blocks.size();
    if (!l.new_slot.empty()) b.updated.blocks_of_layout = b.points.blocks.size();
    if (!l.new_slot.empty() || !b.film.empty()) scene_.host().slots_changed(b);
  }
}

}  // namespace mpdem
