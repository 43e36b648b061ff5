// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "arrangement.h"

#include <algorithm>

#include "../coupling/relaxation.h"
#include "../parallel/ranks.h"
#include "bond_motion.h"
#include "mechanisms.h"
#include "nonlocal.h"
#include "starting_motion.h"

namespace mpdem {

namespace {

// Motion of each of these bonds, over all ranks. Velocities are ahead by the kick of the next drift.
std::vector<BondMotion> sums_of_motion(const Scene& scene, const std::vector<int>& rows) {
  static_assert(sizeof(BondMotion) % sizeof(double) == 0, "sums of numbers");
  constexpr int kWidth = sizeof(BondMotion) / sizeof(double);
  std::vector<BondMotion> sums(rows.size(), BondMotion{});
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (const Bond* b = scene.bonds().find(rows[n])) sums[n] = mpdem::sums_of_motion(b->grid, scene.kick());
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), kWidth * static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, scene.comm);
  return sums;
}

// Gives momentum and angular momentum back, so that they are what they were. The energy that is missing counts as
// released.
void keep_motion(Scene& scene, const std::vector<int>& rows, const std::vector<BondMotion>& before) {
  std::vector<BondMotion> after = sums_of_motion(scene, rows);
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (Bond* b = scene.bonds().find(rows[n])) give_back_motion(b->grid, before[n], after[n]);
  after = sums_of_motion(scene, rows);
  const int me = rank_in(scene.comm);
  for (std::size_t n = 0; n < rows.size() && me == 0; ++n) scene.books.release(before[n].kinetic - after[n].kinetic);
}

NewPartsOfBonds parts_before_layout(const Scene& scene, Bonds& bonds, const std::vector<int>& fresh, Splits& splits) {
  NewPartsOfBonds parts = splits.start(scene.comm, bonds, scene.options, fresh);
  splits.bring(scene.comm, bonds);
  return parts;
}

}  // namespace

std::vector<BondLayout> layouts_of_copies(const Scene& scene, const Divisions& divisions, const RestoredNodes& of_file, const std::vector<int>& fresh,
                                          const PenaltyParameters* penalty) {
  Bonds copies;
  copies.table = scene.bonds().table;
  for (const Bond& b : scene.bonds()) copies.make(b.body).points = b.points;
  RestoredNodes restored(of_file);
  restored.bring();
  const std::unique_ptr<Splits> splits = divisions.splits->copy();
  NewPartsOfBonds parts = parts_before_layout(scene, copies, fresh, *splits);
  std::vector<LayoutRequest> requests;
  for (Bond& b : copies) {
    requests.emplace_back();
    LayoutRequest& r = requests.back();
    r.body = b.body;
    r.points = std::move(b.points);
    r.points.sort_links();
    r.parts.part_of_slot = parts[b.body].part_of_slot;
    if (penalty) r.before = restored.any() ? restored.of(b.body) : scene.bonds().find(b.body)->grid.kinematics();
  }
  const Formulation of_look{};  // points do not move, and need no margin
  const LayoutRules rules{scene.comm, copies.table, scene.options, scene.law, scene.inertia, penalty, *splits, of_look};
  std::vector<BondLayout> layouts = make_layout(rules, scene.all_rows(), std::move(requests));
  for (BondLayout& l : layouts) {
    l.film = scene.bonds().find(l.body)->film;
    lay_out_film(l.film, copies.table[l.body], scene.options, scene.law);
  }
  return layouts;
}

LayoutRequest Arrangement::request_of(Bond& b, NewPartsOfBonds& parts) {
  LayoutRequest r;
  r.body = b.body;
  r.points = std::move(b.points);
  r.before = b.grid.kinematics();
  if (restored_.any()) r.before = std::move(restored_.of(b.body));
  const auto changed = parts.find(b.body);
  if (changed != parts.end()) r.parts = std::move(changed->second);
  return r;
}

// Mass goes back from the heirs of tied nodes to these nodes where nodes split. Its
// momentum and angular momentum are kept by a rigid motion.
void Arrangement::lay_out(const std::vector<int>& rows, NewPartsOfBonds parts, const How& how) {
  restored_.bring();
  const bool moves = scene_.laid_out && how.splits;
  const std::vector<BondMotion> motion = moves ? sums_of_motion(scene_, rows) : std::vector<BondMotion>();
  std::vector<LayoutRequest> requests;
  for (int row : rows)
    if (Bond* b = scene_.bonds().find(row)) requests.push_back(request_of(*b, parts));
  const PenaltyParameters* penalty = scene_.penalty ? &*scene_.penalty : nullptr;
  const LayoutRules rules{scene_.comm, scene_.bonds().table, scene_.options, scene_.law, scene_.inertia, penalty,
                          *divisions_.splits, *scene_.formulation, how.arrange};
  std::vector<BondLayout> layouts = make_layout(rules, rows, std::move(requests));
  restored_.clear();
  adopt(layouts);
  if (moves) keep_motion(scene_, rows, motion);
  start_velocities(scene_, layouts);
  scene_.bonds().drop_empty(rows);
  for (int row : rows)
    if (Bond* b = scene_.bonds().find(row)) scene_.formulation->follow_layout(*b);
  shared_.bind();
}

void Arrangement::lay_out_again(const std::vector<int>& rows, NewPartsOfBonds parts, const How& how) {
  lay_out(rows, std::move(parts), how);
  added_.refresh(rows);
}

NewPartsOfBonds Arrangement::parts_at_start() {
  NewPartsOfBonds parts = parts_before_layout(scene_, scene_.bonds(), fresh_points_, *divisions_.splits);
  fresh_points_.clear();
  return parts;
}

void Arrangement::bring_copies() {
  divisions_.splits->bring(scene_.comm, scene_.bonds());
}

void Arrangement::remember_axis() {
  std::vector<Body>& table = scene_.bonds().table;
  if (std::all_of(table.begin(), table.end(), [](const Body& b) { return b.axis_rule != AxisRule::none; })) return;
  std::vector<int> open(table.size(), 0);
  for (const Bond& b : scene_.bonds())
    for (const PointStore* store : b.stores())
      for (const BlockMeta& m : store->meta)
        if (m.framed != m.occupied) open[b.body] = 1;
  for (int row : scene_.bonds().rows_without_points()) open[row] = 1;
  MPI_Allreduce(MPI_IN_PLACE, open.data(), static_cast<int>(open.size()), MPI_INT, MPI_MAX, scene_.comm);
  for (std::size_t b = 0; b < table.size(); ++b) {
    if (!open[b] || table[b].axis_rule != AxisRule::none) continue;
    table[b].axis_rule = scene_.options.axis;
    std::copy(scene_.options.axis_direction, scene_.options.axis_direction + 3, table[b].axis);
  }
}

void Arrangement::sync_slots() {
  if (!scene_.laid_out) return;
  for (Bond& b : scene_.bonds())
    if (scene_.formulation->sort_links(b)) scene_.host().slots_changed(b);
}

// Each side of a bond that came apart follows the grain that it holds to.
void Arrangement::follow_grains(Bond& b) const {
  if (b.parts.empty()) return;
  const std::vector<char> held = divisions_.cracks.separated(b.body) ? nodes_held(b.points, b.grid) : std::vector<char>();
  for (const auto& p : b.parts) p->follow_grains(b.grid, scene_.bonds().body(b), held);
}

void Arrangement::start_anew(Bond& b) {
  b.layout = ++layouts_;
  b.parts = parts_of(scene_, b, *divisions_.splits);
  b.added = AddedMass();
  b.unmoved = scene_.options.advance.skip_resting && b.points.unstrained();
  follow_grains(b);
  b.jump.clear();
}

void Arrangement::adopt(std::vector<BondLayout>& layouts) {
  for (BondLayout& l : layouts) {
    Bond& b = *scene_.bonds().find(l.body);
    b.points = std::move(l.points);
    b.grid = std::move(l.grid);
    b.links = std::move(l.links);
    lay_out_film(b.film, scene_.bonds().body(b), scene_.options, scene_.law);
    start_anew(b);
    find_near_threshold(scene_, b);
    b.failed.clear();
    b.laid_out_blocks = b.points.blocks.size();
    if (!l.new_slot.empty()) b.updated.blocks_when_arranged = b.points.blocks.size();
    if (!l.new_slot.empty() || !b.film.empty()) scene_.host().slots_changed(b);
  }
}

}  // namespace mpdem
