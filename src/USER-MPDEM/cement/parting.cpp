// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nodes that split (splits.h) change a bond in place. Points that go to other parts get blocks of their own. New nodes
// come into the grid. Ties of nodes that are touched are found anew, and the masses of all nodes of the bond. All else
// stays where it is. The result is that of a layout of the same state, to the bit. A bond that ranks cut is laid out as a
// whole.
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
  const bool split = scene_.options.split;
  if (split) {
    Splits::Found found = divisions_.splits.look(scene_.comm, scene_.bonds(), scene_.options, from);
    if (!found.lay_out.empty()) arrangement_.lay_out_again(found.lay_out, std::move(found.parts), {true, true});
  }
  Cracks::Found found = look_at_bonds(true, from);
  if (!found.lay_out.empty()) arrangement_.lay_out_again(found.lay_out, std::move(found.parts), {true, split});
  find_relaxation(found.held);
}

void Parting::look() {
  if (!scene_.can_break()) return;
  const bool after_check = scene_.follows_check();
  if (!after_check && !scene_.watches()) return;
  sort_links();
  Cracks& cracks = divisions_.cracks;
  if (scene_.options.split) split_nodes();
  if (after_check)
    cracks.give_way(scene_.comm, scene_.bonds(), divisions_.sheets, scene_.options, load_watch_.look(scene_.comm, scene_.bonds().table, scene_.shear_speed()),
                    scene_.keeps_skins(), scene_.now.number - 1);
  if (!after_check && !cracks.some_path_is_cut(scene_.comm)) return;
  scene_.timer.start(StepTimer::kLayout);
  if (after_check) added_.drop_inert();
  Cracks::Found found = look_at_bonds(after_check);
  if (scene_.options.split) part_bonds(found.lay_out, std::move(found.parts));
  else lay_out_parts(found.lay_out, std::move(found.parts));
  find_relaxation(found.held);
}

// Points that change cells change their slots. Others stay as the layout sorted them.
void Parting::sort_links() {
  if (!scene_.options.updated) return;
  for (Bond& b : scene_.bonds()) b.sort_links();
}

std::vector<Cracks::Ahead> Parting::ahead(const std::vector<int>& rows) {
  sort_links();
  return divisions_.cracks.ahead(scene_.comm, scene_.bonds(), divisions_.sheets, scene_.options, rows, scene_.keeps_skins());
}

// Bonds that hold only by bridges narrower than a cell come apart there.
Cracks::Found Parting::look_at_bonds(bool debris, int from) {
  Cracks::Found found = divisions_.cracks.look(scene_.comm, scene_.bonds(), divisions_.sheets, scene_.options, scene_.keeps_skins(), debris, from);
  if (!scene_.options.split) return found;
  Splits::Found split = divisions_.splits.come_apart(scene_.comm, scene_.bonds(), scene_.options, found.pieces);
  found.parts = std::move(split.parts);
  found.lay_out.insert(found.lay_out.end(), split.lay_out.begin(), split.lay_out.end());
  sort_unique(found.lay_out);
  return found;
}

// Finds the damping of bonds whose points hold to other grains now.
void Parting::find_relaxation(const std::vector<int>& rows) {
  for (int row : rows)
    if (Bond* b = scene_.bonds().find(row)) arrangement_.follow_grains(*b);
}

// Lays out bonds where parts came apart. Links have other nodes then, and their added mass has another energy.
void Parting::lay_out_parts(const std::vector<int>& rows, NewPartsOfBonds parts) {
  if (rows.empty()) return;
  scene_.books.release_by([&] { return added_.energy_ahead(rows, scene_.kick()); },
                          [&] {
                            arrangement_.lay_out_again(rows, std::move(parts), {});
                            added_.follow(rows, "parts came apart");
                          });
}

void Parting::split_nodes() {
  scene_.timer.start(StepTimer::kLayout);
  Splits::Found split = divisions_.splits.look(scene_.comm, scene_.bonds(), scene_.options);
  part_bonds(split.lay_out, std::move(split.parts));
}

// Mass stays with its copy, and copies move as the node did. So momentum and energy are what they were. Edges that are
// tied no longer give mass back, see give_back_motion(). Returns the nodes whose ties and masses are new.
std::vector<int> Parting::part_nodes(Bond& b, const NewParts& parts) {
  const double kick = scene_.kick();
  const BondMotion before = sums_of_motion(b.grid, kick);
  const PointStore::PartMove moved = b.points.move_to_parts(parts.part_of_slot, scene_.options.cell, scene_.options.basis);
  const BorrowedNodes borrowed(scene_.options, scene_.penalty ? &*scene_.penalty : nullptr);
  std::vector<Key> more = divisions_.splits.standing_at(b.body, parts.split);
  const auto add = [&more](const std::vector<Key>& nodes) { more.insert(more.end(), nodes.begin(), nodes.end()); };
  for (int n : moved.blocks) {
    BlockMeta& m = b.points.meta[n];
    m.borrowed = BlockMeta::kOwn;  // borrowed nodes are found anew below
    add(divisions_.splits.standing_for(m, support(scene_.options.basis)));
    if (!borrowed.may_borrow(m)) add(Splits::nodes_of(m, support(scene_.options.basis)));
  }
  sort_unique(more);
  more.erase(std::remove_if(more.begin(), more.end(), [&](const Key& k) { return b.grid.node_at(k) >= 0; }), more.end());
  const std::vector<int> place = b.grid.add_nodes(more);
  b.grid.take_over_motion(parts.source);
  borrowed.take_motion_of_standing(b.grid, divisions_.splits, more, parts.source);
  if (!more.empty())
    for (BlockMeta& m : b.points.meta)
      if (m.borrowed == BlockMeta::kOwn && !borrowed.may_borrow(m))
        for (int& c : m.column) c = place[c];
  for (int n : moved.blocks)
    if (!borrowed.may_borrow(b.points.meta[n])) b.grid.find_columns(b.points.meta[n]);
  b.links.renumber(moved.link_place);
  b.links.follow_parts(b.points, b.grid, place);

  std::vector<int> nodes = divisions_.splits.nodes_touched(b.grid, b.body, parts.split);
  for (const Key& k : more) nodes.push_back(b.grid.node_at(k));
  sort_unique(nodes);
  std::vector<Key> keys;
  for (int i : nodes) keys.push_back(b.grid.keys[i]);
  borrowed.find_anew(b.points, b.grid, divisions_.splits, nodes);
  const std::vector<double> volumes = divisions_.splits.volumes(keys);
  for (std::size_t n = 0; n < nodes.size() && scene_.options.shares_failed_mass(); ++n) b.grid.given_volume[nodes[n]] = volumes[n];
  const bool freed = b.grid.tie_anew(nodes, divisions_.splits.ties(keys));
  b.grid.lump_mass(b.points, scene_.inertia);
  if (freed) {
    give_back_motion(b.grid, before, sums_of_motion(b.grid, kick));
    scene_.books.release(before.kinetic - sums_of_motion(b.grid, kick).kinetic);
  }
  return nodes;
}

// Links have other nodes then, and their added mass has another energy. Links that let go give theirs up.
void Parting::part_bonds(const std::vector<int>& rows, NewPartsOfBonds parts) {
  if (rows.empty()) return;
  std::vector<int> mine;
  for (int row : rows) {
    const Bond* b = scene_.bonds().find(row);
    if (b && b->cut_by_ranks()) mine.push_back(row);
  }
  const std::vector<int> cut = scene_.agreed_rows(mine);
  StableStep::Patches patches;
  scene_.books.release_by([&] { return added_.energy_ahead(rows, scene_.kick()); }, [&] {
    for (int row : rows) {
      Bond* b = scene_.bonds().find(row);
      if (!b) continue;
      added_.drop_inert(*b);
      if (std::binary_search(cut.begin(), cut.end(), row)) continue;
      const std::vector<int> nodes = part_nodes(*b, parts[row]);
      if (added_.hangs_on_eigenvalue()) patches[row] = blocks_about(b->points, b->grid, nodes);
      arrangement_.start_anew(*b);
      b->laid_out_blocks = b->points.blocks.size();
      scene_.host().slots_changed(*b);
    }
    if (!cut.empty()) arrangement_.lay_out(cut, std::move(parts), {true, true});
    added_.refresh(rows);
    added_.follow(rows, "nodes split", &patches);
  });
}

}  // namespace mpdem
