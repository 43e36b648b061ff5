// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nodes that split (splits.h) change a bond in place. Points that go to other parts get blocks of their own. New nodes
// come into the grid. Ties of nodes that are touched are found anew, and the masses of all nodes of the bond. All else
// stays where it is. The result is that of a layout of the same state, to the bit. A bond that ranks cut is laid out as a
// whole. So is any bond with `cracks bonds`, whose edges are not kept.
#include "parting.h"

#include <algorithm>

#include "../mpm/block_nodes.h"
#include "../numerics/sort_unique.h"
#include "bond_motion.h"
#include "borrowed_nodes.h"

namespace mpdem {

namespace {

// Returns the blocks that have one of these nodes, and the blocks that share a node with them.
std::vector<int> blocks_about(const PointStore& points, const Grid& grid, const std::vector<int>& nodes) {
  std::vector<char> near(grid.size(), 0);
  for (int i : nodes) near[i] = 1;
  std::vector<int> blocks;
  for (int round = 0; round < 2; ++round) {
    blocks.clear();
    for (std::size_t b = 0; b < points.meta.size(); ++b) {
      bool meets = false;
      for_each_node(grid, points.meta[b], [&](int i) { meets = meets || near[i]; });
      if (meets) blocks.push_back(static_cast<int>(b));
    }
    for (int b : blocks) for_each_node(grid, points.meta[b], [&](int i) { near[i] = 1; });
  }
  return blocks;
}

}  // namespace

void Parting::take_up() {
  load_watch_.take_up(scene_.bonds().table.size());
  const int from = static_cast<int>(divisions_.cracks.size());
  if (!divisions_.cracks.take_up(scene_.bonds().table.size()) || !scene_.penalty) return;
  if (scene_.options.split) {
    Splits::Found found = divisions_.splits->look(scene_.comm, scene_.bonds(), scene_.options, from);
    if (!found.lay_out.empty()) arrangement_.lay_out_again(found.lay_out, std::move(found.parts), {true, true});
  }
  Found found = look_at_bonds(true, from);
  if (!found.lay_out.empty()) arrangement_.lay_out_again(found.lay_out, std::move(found.parts), {true, true});
  find_relaxation(found.held);
}

void Parting::look() {
  if (!scene_.can_break()) return;
  if (scene_.begins_step() && (scene_.now.number - 1) % scene_.options.check_every == 0) look_after_check();
  else if (scene_.watches()) look_at_paths();
}

// Looks at the whole state.
void Parting::look_after_check() {
  look_at_points();
  divisions_.cracks.give_way(scene_.comm, scene_.bonds(), scene_.options, load_watch_.look(scene_.comm, scene_.bonds().table, scene_.shear_speed()),
                             scene_.keeps_skins(), scene_.now.number - 1);
  scene_.timer.start(StepTimer::kLayout);
  added_.drop_inert();
  part_pieces(true);
}

// Looks at bonds in which a path of intact points was cut.
void Parting::look_at_paths() {
  look_at_points();
  if (!divisions_.cracks.some_path_is_cut(scene_.comm)) return;
  scene_.timer.start(StepTimer::kLayout);
  part_pieces(false);
}

void Parting::look_at_points() {
  sort_links();
  if (scene_.options.split) split_nodes();
}

void Parting::part_pieces(bool debris) {
  Found found = look_at_bonds(debris);
  part_bonds(found.lay_out, std::move(found.parts), "parts came apart");
  find_relaxation(found.held);
}

// Points that change cells change their slots. Others stay as the layout sorted them.
void Parting::sort_links() {
  for (Bond& b : scene_.bonds()) scene_.formulation->sort_links(b);
}

std::vector<Cracks::Ahead> Parting::ahead(const std::vector<int>& rows) {
  sort_links();
  return divisions_.cracks.ahead(scene_.comm, scene_.bonds(), scene_.options, rows, scene_.keeps_skins());
}

Parting::Found Parting::look_at_bonds(bool debris, int from) {
  Cracks::Found cracked = divisions_.cracks.look(scene_.comm, scene_.bonds(), scene_.options, scene_.keeps_skins(), debris, from);
  return {divisions_.splits->come_apart(scene_.comm, scene_.bonds(), scene_.options, std::move(cracked.came_apart)), std::move(cracked.held)};
}

// Finds the damping of bonds whose points hold to other grains now.
void Parting::find_relaxation(const std::vector<int>& rows) {
  for (int row : rows)
    if (Bond* b = scene_.bonds().find(row)) arrangement_.follow_grains(*b);
}

void Parting::split_nodes() {
  scene_.timer.start(StepTimer::kLayout);
  Splits::Found split = divisions_.splits->look(scene_.comm, scene_.bonds(), scene_.options);
  part_bonds(split.lay_out, std::move(split.parts), "nodes split");
}

// Mass stays with its copy, and copies move as the node did. So momentum and energy are what they were. Edges that are
// tied no longer give mass back, see give_back_motion(). Returns the nodes whose ties and masses are new.
std::vector<int> Parting::part_nodes(Bond& b, const NewParts& parts) {
  const double kick = scene_.kick();
  const BondMotion before = sums_of_motion(b.grid, kick);
  const PointStore::PartMove moved = b.points.move_to_parts(parts.part_of_slot, scene_.options.cell, scene_.options.basis);
  const BorrowedNodes borrowed(scene_.options, scene_.penalty ? &*scene_.penalty : nullptr);
  std::vector<Key> more = divisions_.splits->standing_at(b.body, parts.split);
  const auto add = [&more](const std::vector<Key>& nodes) { more.insert(more.end(), nodes.begin(), nodes.end()); };
  for (int n : moved.blocks) {
    BlockMeta& m = b.points.meta[n];
    m.borrowed = BlockMeta::kOwn;  // borrowed nodes are found anew below
    add(divisions_.splits->standing_for(m, support(scene_.options.basis)));
    if (!borrowed.may_borrow(m)) add(Splits::nodes_of(m, support(scene_.options.basis)));
  }
  sort_unique(more);
  more.erase(std::remove_if(more.begin(), more.end(), [&](const Key& k) { return b.grid.node_at(k) >= 0; }), more.end());
  const std::vector<int> place = b.grid.add_nodes(more);
  b.grid.take_over_motion(parts.source);
  borrowed.take_motion_of_standing(b.grid, *divisions_.splits, more, parts.source);
  if (!more.empty())
    for (BlockMeta& m : b.points.meta)
      if (m.borrowed == BlockMeta::kOwn && !borrowed.may_borrow(m))
        for (int& c : m.column) c = place[c];
  for (int n : moved.blocks)
    if (!borrowed.may_borrow(b.points.meta[n])) b.grid.find_columns(b.points.meta[n]);
  b.links.renumber(moved.link_place);
  b.links.follow_parts(b.points, b.grid, place);

  std::vector<int> nodes = divisions_.splits->nodes_touched(b.grid, b.body, parts.split);
  for (const Key& k : more) nodes.push_back(b.grid.node_at(k));
  sort_unique(nodes);
  std::vector<Key> keys;
  for (int i : nodes) keys.push_back(b.grid.keys[i]);
  borrowed.find_anew(b.points, b.grid, *divisions_.splits, nodes);
  const std::vector<double> volumes = divisions_.splits->volumes(keys, scene_.options);
  if (!volumes.empty()) {
    b.grid.given_volume.resize(b.grid.size(), -1.0);
    for (std::size_t n = 0; n < volumes.size(); ++n) b.grid.given_volume[nodes[n]] = volumes[n];
  }
  const bool freed = b.grid.tie_anew(nodes, divisions_.splits->ties(keys));
  b.grid.lump_mass(b.points, scene_.inertia);
  if (freed) {
    give_back_motion(b.grid, before, sums_of_motion(b.grid, kick));
    scene_.books.release(before.kinetic - sums_of_motion(b.grid, kick).kinetic);
  }
  return nodes;
}

// Links have other nodes then, and their added mass has another energy. Where nodes split as points fail, links that let
// go give theirs up. Else they do so at the checks.
void Parting::part_bonds(const std::vector<int>& rows, NewPartsOfBonds parts, const char* event) {
  if (rows.empty()) return;
  std::vector<int> mine;
  for (int row : rows) {
    const Bond* b = scene_.bonds().find(row);
    if (b && (b->cut_by_ranks() || !scene_.options.split)) mine.push_back(row);
  }
  const std::vector<int> whole = scene_.agreed_rows(mine);
  StableStep::Patches patches;
  scene_.books.release_by([&] { return added_.energy_ahead(rows, scene_.kick()); }, [&] {
    for (int row : rows) {
      Bond* b = scene_.bonds().find(row);
      if (!b) continue;
      if (scene_.options.split) added_.drop_inert(*b);
      if (std::binary_search(whole.begin(), whole.end(), row)) continue;
      const std::vector<int> nodes = part_nodes(*b, parts[row]);
      if (added_.hangs_on_eigenvalue()) patches[row] = blocks_about(b->points, b->grid, nodes);
      arrangement_.start_anew(*b);
      b->laid_out_blocks = b->points.blocks.size();
      scene_.host().slots_changed(*b);
    }
    if (!whole.empty()) arrangement_.lay_out(whole, std::move(parts), {true, true});
    added_.refresh(rows);
    added_.follow(rows, event, &patches);
  });
}

}  // namespace mpdem
