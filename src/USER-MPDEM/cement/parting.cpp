// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nodes that split (splits.h): what changes in a bond, in place. Points that go to other parts get blocks of their own, new nodes come
// into the grid, and the ties and masses of those that are touched are found anew; all else stays where it is. What comes of it is what a layout of
// the same state gives, to the bit. A bond that ranks cut is laid out as a whole.
#include <algorithm>

#include "../mpm/block_nodes.h"
#include "bond_motion.h"
#include "cement.h"
#include "kinematics.h"

namespace mpdem {

namespace {

// Blocks that have one of these nodes, and those that share a node with them.
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

void Cement::split_nodes() {
  timer_.start(StepTimer::kLayout);
  Splits::Found split = splits_.look(comm_, bonds_, options_);
  part_bonds(split.lay_out, std::move(split.parts));
}

// Mass stays with its copy and copies move as the node did, so momentum and energy are what they were; edges that are tied no longer
// give mass back, see give_back_motion(). Answers the nodes whose ties and masses are new.
std::vector<int> Cement::part_nodes(Bond& b, const NewParts& parts) {
  const double kick = 0.5 * (dt_last_ + now_.dt);
  const BondMotion before = mpdem::motion_of(b.grid, kick);
  const PointStore::PartMove moved = b.points.move_to_parts(parts.part_of_slot, options_.cell, options_.basis);
  std::vector<Key> more = splits_.nodes_of(b.points, moved.blocks, b.body, support(options_.basis));
  more.erase(std::remove_if(more.begin(), more.end(), [&](const Key& k) { return b.grid.node_at(k) >= 0; }), more.end());
  const std::vector<int> place = b.grid.add_nodes(more);
  b.grid.take_over_motion(parts.source);
  if (!more.empty())
    for (BlockMeta& m : b.points.meta)
      for (int& c : m.column) c = place[c];
  for (int n : moved.blocks) b.grid.find_columns(b.points.meta[n]);
  b.links.renumber(moved.link_place);
  b.links.follow_parts(b.points, b.grid, place);

  std::vector<int> nodes = splits_.nodes_touched(b.grid, b.body, parts.split);
  for (const Key& k : more) nodes.push_back(b.grid.node_at(k));
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  std::vector<Key> keys;
  for (int i : nodes) keys.push_back(b.grid.keys[i]);
  const std::vector<double> volumes = splits_.volumes(keys);
  for (std::size_t n = 0; n < nodes.size() && options_.shares_failed_mass(); ++n) b.grid.given_volume[nodes[n]] = volumes[n];
  const bool freed = b.grid.tie_anew(nodes, splits_.ties(keys));
  b.grid.lump_mass(b.points, inertia_);
  if (freed) {
    give_back_motion(b.grid, before, mpdem::motion_of(b.grid, kick));
    books_.release(before.kinetic - mpdem::motion_of(b.grid, kick).kinetic);
  }
  return nodes;
}

// Links have other nodes then, and their added mass another energy. Those that let go give theirs up.
void Cement::part_bonds(const std::vector<int>& rows, NewPartsOfBonds parts) {
  if (rows.empty()) return;
  std::vector<int> mine;
  for (int row : rows) {
    const Bond* b = bonds_.find(row);
    if (b && b->cut_by_ranks()) mine.push_back(row);
  }
  const std::vector<int> cut = agreed_rows(mine);
  const auto energy = [&] {
    double sum = 0.0;
    for (int row : rows)
      if (const Bond* b = bonds_.find(row)) sum += b->added.energy(b->grid, grains_.side_of(*b));
    return sum;
  };
  Patches patches;
  books_.release_by(energy, [&] {
    for (int row : rows) {
      Bond* b = bonds_.find(row);
      if (!b) continue;
      drop_inert_links(*b);
      if (std::binary_search(cut.begin(), cut.end(), row)) continue;
      const std::vector<int> nodes = part_nodes(*b, parts[row]);
      if (layout_.eigenvalue > 0.0) patches[row] = blocks_about(b->points, b->grid, nodes);
      start_anew(*b);
      b->laid_out_blocks = b->points.blocks.size();
      host_.slots_changed(*b);
      kinematics_->bind(*b);
    }
    if (!cut.empty()) lay_out(cut, std::move(parts), true, true);
    refresh_added_mass(rows);
    check_step_after(rows, "nodes split", &patches);
  });
}

}  // namespace mpdem
