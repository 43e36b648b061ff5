// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Node splitting (node_splitting.h) changes a bond in place. Points that move to other layers get blocks of their own.
// New nodes are added to the grid. The constraints of nodes that are affected and the masses of all nodes of the bond
// are found again. All else stays where it is. The result is bitwise identical to a layout of the same state. A bond
// that ranks cut is laid out as a whole, and so is any bond with `cracks bonds`, whose edges are not kept.
#include "topology_update.h"

#include <algorithm>

#include "../../mpm/block_nodes.h"
#include "../../numerics/sort_unique.h"
#include "../bond/bond_motion.h"
#include "../failure/node_aliases.h"

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

void TopologyUpdate::add_bonds() {
  load_history_.add_bonds(scene_.bonds().table.size());
  const int from = static_cast<int>(discontinuities_.cracks.size());
  if (!discontinuities_.cracks.add_bonds(scene_.bonds().table.size()) || !scene_.penalty) return;
  if (scene_.options.split) {
    NodeSplitting::Found found = discontinuities_.splits->find_splits(scene_.comm, scene_.bonds(), scene_.options, from);
    if (!found.lay_out.empty()) layout_manager_.lay_out_again(found.lay_out, std::move(found.layers), {true, true});
  }
  Found found = find_separations(true, from);
  if (!found.lay_out.empty()) layout_manager_.lay_out_again(found.lay_out, std::move(found.layers), {true, true});
  find_relative_damping(found.connected);
}

void TopologyUpdate::update() {
  if (!scene_.can_break()) return;
  if (scene_.begins_step() && (scene_.now.number - 1) % scene_.options.check_every == 0) update_after_check();
  else if (scene_.is_topology_step()) update_cut_paths();
}

// Examines the whole state.
void TopologyUpdate::update_after_check() {
  split_at_failed_points();
  discontinuities_.cracks.record_failures(scene_.comm, scene_.bonds(), scene_.options,
                                          load_history_.find_failed(scene_.comm, scene_.bonds().table, scene_.shear_speed()),
                                          scene_.leaves_residue(), scene_.now.number - 1);
  scene_.timer.start(StepTimer::kLayout);
  added_.drop_debonded();
  separate_pieces(true);
}

// Examines bonds in which a path of intact points was cut.
void TopologyUpdate::update_cut_paths() {
  split_at_failed_points();
  if (!discontinuities_.cracks.some_path_is_cut(scene_.comm)) return;
  scene_.timer.start(StepTimer::kLayout);
  separate_pieces(false);
}

void TopologyUpdate::split_at_failed_points() {
  sort_links();
  if (scene_.options.split) split_nodes();
}

void TopologyUpdate::separate_pieces(bool with_separated) {
  Found found = find_separations(with_separated);
  change_bonds(found.lay_out, std::move(found.layers), "pieces separated");
  find_relative_damping(found.connected);
}

// Points that change cells change their slots. Others stay as the layout sorted them.
void TopologyUpdate::sort_links() {
  for (Bond& b : scene_.bonds()) scene_.formulation->sort_links(b);
}

std::vector<Cracks::LigamentReport> TopologyUpdate::find_ligaments(const std::vector<int>& rows) {
  sort_links();
  return discontinuities_.cracks.find_ligaments(scene_.comm, scene_.bonds(), scene_.options, rows, scene_.leaves_residue());
}

TopologyUpdate::Found TopologyUpdate::find_separations(bool with_separated, int from) {
  Cracks::Found cracked = discontinuities_.cracks.detect_separations(scene_.comm, scene_.bonds(), scene_.options, scene_.leaves_residue(),
                                                                     with_separated, from);
  return {discontinuities_.splits->split_pieces(scene_.comm, scene_.bonds(), scene_.options, std::move(cracked.separated_bonds)),
          std::move(cracked.connected)};
}

// Finds the relative damping of bonds whose points are now connected to other grains.
void TopologyUpdate::find_relative_damping(const std::vector<int>& rows) {
  for (int row : rows)
    if (Bond* b = scene_.bonds().find(row)) layout_manager_.follow_grains(*b);
}

void TopologyUpdate::split_nodes() {
  scene_.timer.start(StepTimer::kLayout);
  NodeSplitting::Found split = discontinuities_.splits->find_splits(scene_.comm, scene_.bonds(), scene_.options);
  change_bonds(split.lay_out, std::move(split.layers), "nodes split");
}

// Mass stays with its phantom node, and phantom nodes move as the node did, so momentum and energy are conserved. Nodes
// whose constraint ends get their mass back from mass receivers, see restore_rigid_motion(). Returns the nodes whose
// constraints and masses are new.
std::vector<int> TopologyUpdate::split_in_place(Bond& b, const NewLayers& layers) {
  const double kick = scene_.kick();
  const BondMotion before = sums_of_motion(b.grid, kick);
  const PointStore::LayerMove moved = b.points.move_to_layers(layers.layer_of_slot, scene_.options.cell, scene_.options.basis);
  const NodeAliases aliases(scene_.options, scene_.penalty ? &*scene_.penalty : nullptr);
  std::vector<Key> more = discontinuities_.splits->representatives_at(b.row, layers.split);
  const auto add = [&more](const std::vector<Key>& nodes) { more.insert(more.end(), nodes.begin(), nodes.end()); };
  for (int n : moved.blocks) {
    BlockMeta& m = b.points.meta[n];
    m.aliases = BlockMeta::kOwn;  // aliases are found again below
    add(discontinuities_.splits->representatives_of(m, support(scene_.options.basis)));
    if (!aliases.may_alias(m)) add(NodeSplitting::nodes_of(m, support(scene_.options.basis)));
  }
  sort_unique(more);
  more.erase(std::remove_if(more.begin(), more.end(), [&](const Key& k) { return b.grid.node_at(k) >= 0; }), more.end());
  // New nodes change the indices of others. Blocks that stay are renumbered, those that moved are searched for anew.
  const std::vector<int> new_index = b.grid.add_nodes(more);
  b.grid.copy_motion(layers.source);
  aliases.copy_motion_of_representatives(b.grid, *discontinuities_.splits, more, layers.source);
  if (!more.empty())
    for (BlockMeta& m : b.points.meta)
      if (m.aliases == BlockMeta::kOwn && !aliases.may_alias(m))
        for (int& c : m.column) c = new_index[c];
  for (int n : moved.blocks)
    if (!aliases.may_alias(b.points.meta[n])) b.grid.find_columns(b.points.meta[n]);
  b.links.renumber(moved.new_link_index);
  b.links.follow_layers(b.points, b.grid, new_index);

  std::vector<int> nodes = discontinuities_.splits->nodes_touched(b.grid, b.row, layers.split);
  for (const Key& k : more) nodes.push_back(b.grid.node_at(k));
  sort_unique(nodes);
  std::vector<Key> keys;
  for (int i : nodes) keys.push_back(b.grid.keys[i]);
  aliases.find_anew(b.points, b.grid, *discontinuities_.splits, nodes);
  const std::vector<double> volumes = discontinuities_.splits->volumes(keys, scene_.options);
  if (!volumes.empty()) {
    b.grid.given_volume.resize(b.grid.size(), -1.0);
    for (std::size_t n = 0; n < volumes.size(); ++n) b.grid.given_volume[nodes[n]] = volumes[n];
  }
  const bool freed = b.grid.replace_constraints(nodes, discontinuities_.splits->constraints(keys));
  b.grid.lump_mass(b.points, scene_.inertia());
  if (freed) {
    restore_rigid_motion(b.grid, before, sums_of_motion(b.grid, kick));
    scene_.energy.release(before.kinetic - sums_of_motion(b.grid, kick).kinetic);
  }
  return nodes;
}

// Links then have other nodes, and their added mass has another energy. With node splitting at failed points, debonded
// links release that energy here, else at the checks.
void TopologyUpdate::change_bonds(const std::vector<int>& rows, NewLayersOfBonds layers, const char* event) {
  if (rows.empty()) return;
  std::vector<int> mine;
  for (int row : rows) {
    const Bond* b = scene_.bonds().find(row);
    if (b && (b->cut_by_ranks() || !scene_.options.split)) mine.push_back(row);
  }
  const std::vector<int> whole = scene_.agreed_rows(mine);
  StableStep::Patches patches;
  scene_.energy.release_by([&] { return added_.energy_ahead(rows, scene_.kick()); },
                           [&] {
                             for (int row : rows) {
                               Bond* b = scene_.bonds().find(row);
                               if (!b) continue;
                               if (scene_.options.split) added_.drop_debonded(*b);
                               if (std::binary_search(whole.begin(), whole.end(), row)) continue;
                               const std::vector<int> nodes = split_in_place(*b, layers[row]);
                               if (added_.depends_on_eigenvalue()) patches[row] = blocks_about(b->points, b->grid, nodes);
                               layout_manager_.start_anew(*b);
                               b->laid_out_blocks = b->points.blocks.size();
                               scene_.host().slots_changed(*b);
                             }
                             if (!whole.empty()) layout_manager_.lay_out(whole, std::move(layers), {true, true});
                             added_.refresh(rows);
                             added_.follow(rows, event, &patches);
                           });
}

}  // namespace mpdem
