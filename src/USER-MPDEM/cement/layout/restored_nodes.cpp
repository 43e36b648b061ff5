// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "restored_nodes.h"

#include <algorithm>

#include "../../parallel/agree.h"
#include "../../parallel/all_to_all.h"
#include "../../parallel/ranks.h"

namespace mpdem {

namespace {

NodeRow node_row_of(const Grid& grid, int i) {
  NodeRow row;
  row.row = row_of(grid.keys[i].field());
  row.layer = layer_of_field(grid.keys[i].field());
  for (int d = 0; d < 3; ++d) {
    row.index[d] = grid.keys[i].at(d);
    row.velocity[d] = grid.velocity[3 * i + d];
    row.displacement[d] = grid.displacement[3 * i + d];
    row.acceleration[d] = grid.acceleration[3 * i + d];
  }
  return row;
}

Key key_of(const NodeRow& r) { return {field_of(r.row, r.layer), r.index}; }

}  // namespace

std::map<int, std::vector<double>> packed_nodes(const Scene& scene) {
  std::map<int, std::vector<double>> nodes;
  for (const Bond& bond : scene.bonds().resolved()) {
    std::vector<double>& rows = nodes[bond.row];
    for (int i = 0; i < bond.grid.size(); ++i)
      if (bond.grid.halo.counts_here()[i]) append(node_row_of(bond.grid, i), rows);
  }
  return nodes;
}

double nodes_to_pack(const Scene& scene) {
  double nodes = 0.0;
  for (const Bond& bond : scene.bonds().resolved()) {
    const std::vector<char>& counts = bond.grid.halo.counts_here();
    nodes += static_cast<double>(std::count(counts.begin(), counts.end(), 1));
  }
  MPI_Allreduce(MPI_IN_PLACE, &nodes, 1, MPI_DOUBLE, MPI_SUM, scene.comm);
  return nodes;
}

void RestoredNodes::keep(std::vector<NodeRow> rows, double of_all) {
  rows_ = std::move(rows);
  of_all_ = of_all;
}

void RestoredNodes::take(std::vector<NodeRow> rows) {
  std::sort(rows.begin(), rows.end(), [](const NodeRow& a, const NodeRow& b) { return key_of(a) < key_of(b); });
  motion_.assign(scene_.bonds().table.size(), NodeKinematics());
  for (const NodeRow& row : rows) {
    NodeKinematics& k = motion_[row.row];
    k.keys.push_back(key_of(row));
    for (const double* part : {row.velocity, row.displacement, row.acceleration}) k.values.insert(k.values.end(), part, part + 3);
  }
}

// Rows first go to a home rank of their bond, which sends them to all ranks that have points of the bond.
void RestoredNodes::send_to_holders() {
  if (of_all_ < 0.0) return;
  const int ranks = ranks_of(scene_.comm);
  double found = static_cast<double>(rows_.size());
  MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_DOUBLE, MPI_SUM, scene_.comm);
  if (found != of_all_)
    throw BadState(text_of("the points of the restart file have the motion of ", found, " of ", of_all_,
                           " nodes; use another restart file, of the whole scene"));
  of_all_ = -1.0;
  std::vector<std::vector<NodeRow>> to_home(ranks);
  for (const NodeRow& row : rows_) to_home[row.row % ranks].push_back(row);
  std::vector<NodeRow>().swap(rows_);
  std::vector<NodeRow> at_home = all_to_all(scene_.comm, to_home).data;
  const auto by_bond = [](const NodeRow& a, const NodeRow& b) { return a.row < b.row; };
  std::sort(at_home.begin(), at_home.end(), by_bond);
  std::vector<std::vector<int>> ask(ranks);
  for (const Bond& b : scene_.bonds()) ask[b.row % ranks].push_back(b.row);
  const Received<int> asked = all_to_all(scene_.comm, ask);
  std::vector<std::vector<NodeRow>> answer(ranks);
  std::size_t n = 0;
  for (int rank = 0; rank < ranks; ++rank)
    for (int i = 0; i < asked.count[rank]; ++i, ++n) {
      NodeRow of_bond;
      of_bond.row = asked.data[n];
      const auto rows = std::equal_range(at_home.begin(), at_home.end(), of_bond, by_bond);
      answer[rank].insert(answer[rank].end(), rows.first, rows.second);
    }
  take(all_to_all(scene_.comm, answer).data);
}

}  // namespace mpdem
