// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// State of the cement that points and grains do not hold, for restart files: cement_restart.h.
#include <algorithm>
#include <map>

#include "../parallel/agree.h"
#include "../parallel/all_to_all.h"
#include "cement.h"

namespace mpdem {

namespace {

// Numbers of all ranks on rank 0.
std::vector<double> gather(MPI_Comm comm, const std::vector<double>& mine) {
  int ranks, me, n = static_cast<int>(mine.size());
  MPI_Comm_size(comm, &ranks);
  MPI_Comm_rank(comm, &me);
  std::vector<int> counts(ranks), at(ranks, 0);
  MPI_Gather(&n, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  std::vector<double> all;
  if (me == 0) {
    for (int r = 1; r < ranks; ++r) at[r] = at[r - 1] + counts[r - 1];
    all.resize(at.back() + counts.back());
  }
  MPI_Gatherv(mine.data(), n, MPI_DOUBLE, all.data(), counts.data(), at.data(), MPI_DOUBLE, 0, comm);
  return all;
}

NodeRow row_of(const Grid& grid, int i) {
  NodeRow row;
  row.body = body_of(grid.keys[i].field());
  row.part = part_of_field(grid.keys[i].field());
  for (int d = 0; d < 3; ++d) {
    row.place[d] = grid.keys[i].at(d);
    row.velocity[d] = grid.velocity[3 * i + d];
    row.displacement[d] = grid.displacement[3 * i + d];
    row.acceleration[d] = grid.acceleration[3 * i + d];
  }
  return row;
}

Key key_of(const NodeRow& r) { return {field_of(r.body, r.part), r.place}; }

}  // namespace

std::vector<double> Cement::packed_state(CementHead head) {
  double nodes = 0.0;
  for (const Bond& bond : bonds_.awake()) {
    const std::vector<char>& counts = bond.grid.halo.counts_here();
    nodes += static_cast<double>(std::count(counts.begin(), counts.end(), 1));
  }
  MPI_Allreduce(MPI_IN_PLACE, &nodes, 1, MPI_DOUBLE, MPI_SUM, comm_);
  head.cell = options_.cell;
  head.basis = options_.basis;
  head.updated = options_.updated;
  head.tied = options_.tied;
  head.step = dt_last_;
  head.bodies_started = bodies_started_;
  head.start_energy = books_.start_energy();
  head.books = books_.sums_of_all(comm_);
  head.eigenvalue = layout_.eigenvalue;
  std::vector<double> mine_of_copies;
  for (const auto& row : splits_.rows_to_keep(comm_))
    for (const NodeCopies::Entry& e : row.second)
      append(CopyRow{body_of(row.first.field()), {row.first.at(0), row.first.at(1), row.first.at(2)}, e.part, e.copy, e.first, e.volume}, mine_of_copies);
  const std::vector<double> copies = gather(comm_, mine_of_copies);
  head.split = options_.split;
  head.unilateral = options_.unilateral;
  head.copies = static_cast<int>(copies.size() / kMostNumbers<CopyRow>);
  head.bodies = static_cast<int>(bonds_.table.size());
  head.nodes = nodes;
  std::vector<double> all = {CementHead::kVersion};
  append(head, all);
  states_.resize(bonds_.table.size(), BondState{});
  load_watch_.take_up(states_.size());
  const std::vector<LoadWatch::Sums> loads = load_watch_.sums_of_all(comm_);
  for (std::size_t r = 0; r < states_.size(); ++r) {
    const Cracks::State s = r < cracks_.size() ? cracks_[r] : Cracks::State();
    BondRow row{s.failed_seen, s.separation, states_[r].peak, static_cast<double>(s.broken_at), load_watch_.largest(r)};
    std::copy(loads[r].begin(), loads[r].end(), row.loads);
    append(row, all);
  }
  all.insert(all.end(), copies.begin(), copies.end());
  return all;
}

std::map<int, std::vector<double>> Cement::packed_nodes() const {
  std::map<int, std::vector<double>> nodes;
  for (const Bond& bond : bonds_.awake()) {
    std::vector<double>& rows = nodes[bond.body];
    for (int i = 0; i < bond.grid.size(); ++i)
      if (bond.grid.halo.counts_here()[i]) append(row_of(bond.grid, i), rows);
  }
  return nodes;
}

void Cement::check_restored(const CementHead& head) const {
  const auto edge = [](bool t) { return t ? "tied" : "free"; };
  const auto name = [](bool u) { return u ? "updated" : "total"; };
  if (head.cell != options_.cell)
    throw BadState(text_of("'cell ", options_.cell, "' but the restart file was written with cell ", head.cell, "; use that"));
  if (head.basis != options_.basis || head.updated != options_.updated)
    throw BadState(text_of("'basis ", name_of(options_.basis), "' and 'kinematics ", name(options_.updated),
                           "' but the motion of the nodes in the restart file is that of basis ", name_of(head.basis),
                           " and kinematics ", name(head.updated), "; use these"));
  const auto cracks = [](bool split) { return split ? "split" : "bonds"; };
  if (head.split != options_.split)
    throw BadState(text_of("'cracks ", cracks(options_.split), "' but the restart file was written with 'cracks ", cracks(head.split), "'; use that"));
  const auto yes = [](bool u) { return u ? "yes" : "no"; };
  if (head.unilateral != options_.unilateral)
    throw BadState(text_of("'unilateral ", yes(options_.unilateral), "' but the restart file was written with 'unilateral ", yes(head.unilateral), "'; use that"));
  if (head.tied != options_.tied)
    throw BadState(text_of("nodes at the edge are ", edge(options_.tied), " but were ", edge(head.tied), " when the restart file was written; use 'edge ",
                           edge(head.tied), "' and the kinematics and re-projection of that run"));
}

// Cement may have been made since.
void Cement::restore(const CementHead& head, RecordReader& in, const std::vector<double>& nodes) {
  check_restored(head);
  const std::size_t table = bonds_.table.size();
  dt_last_ = head.step;
  bodies_started_ = head.bodies_started;
  layout_.eigenvalue = head.eigenvalue;
  arrivals_.restored = true;
  int me;
  MPI_Comm_rank(comm_, &me);
  books_.restore(me == 0 ? head.books : EnergyBooks::Sums(), head.start_energy);
  std::vector<Cracks::State> cracks(head.bodies);
  std::vector<LoadWatch::Largest> largest(head.bodies);
  std::vector<LoadWatch::Sums> loads(head.bodies, LoadWatch::Sums{});
  states_.assign(head.bodies, BondState{});
  for (int r = 0; r < head.bodies; ++r) {
    BondRow row;
    in.read(row);
    cracks[r].failed_seen = row.failed_seen;
    cracks[r].separation = row.separation;
    states_[r].peak = row.peak;
    cracks[r].broken_at = static_cast<std::int64_t>(row.broken_at);
    largest[r] = row.largest;
    if (me == 0) std::copy(row.loads, row.loads + LoadWatch::kSums, loads[r].begin());
  }
  load_watch_.restore(std::move(largest), std::move(loads));
  cracks_.restore(std::move(cracks));
  std::vector<NodeRow> rows(nodes.size() / kMostNumbers<NodeRow>);
  RecordReader of_points(nodes.data(), nodes.data() + nodes.size());
  for (NodeRow& row : rows) {
    of_points.read(row);
    in.check_whole("the bond of a node", row.body, from(0, static_cast<double>(table) - 1.0));
  }
  in.tell(of_points.trouble());
  std::map<Key, NodeCopies::Row> copies;
  for (int n = 0; n < head.copies; ++n) {
    CopyRow row;
    in.read(row);
    in.check_whole("the bond of a split node", row.body, from(0, static_cast<double>(table) - 1.0));
    copies[{field_of(row.body, 0), row.place}].push_back({row.part, row.copy, row.first, row.volume});
  }
  if (!in.trouble().empty()) return;
  if (options_.split) splits_.restore(head.bodies, std::move(copies));
  arrivals_.rows_of_nodes = std::move(rows);
  arrivals_.nodes = head.nodes;
}

void Cement::take_restored_nodes(std::vector<NodeRow> rows) {
  std::sort(rows.begin(), rows.end(), [](const NodeRow& a, const NodeRow& b) { return key_of(a) < key_of(b); });
  arrivals_.restored_nodes.assign(bonds_.table.size(), NodeKinematics());
  for (const NodeRow& row : rows) {
    NodeKinematics& k = arrivals_.restored_nodes[row.body];
    k.keys.push_back(key_of(row));
    for (const double* part : {row.velocity, row.displacement, row.acceleration}) k.values.insert(k.values.end(), part, part + 3);
  }
}

// Collective, before the first layout. Points may have gone to other ranks since they were read: rows go to all that have some of their bond, by way of
// a home of the bond.
void Cement::bring_restored_nodes() {
  if (arrivals_.nodes < 0.0) return;
  int ranks;
  MPI_Comm_size(comm_, &ranks);
  double found = static_cast<double>(arrivals_.rows_of_nodes.size());
  MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_DOUBLE, MPI_SUM, comm_);
  if (found != arrivals_.nodes)
    throw BadState(text_of("the points of the restart file have the motion of ", found, " of ", arrivals_.nodes, " nodes; use another restart file, of the whole scene"));
  arrivals_.nodes = -1.0;
  std::vector<std::vector<NodeRow>> to_home(ranks);
  for (const NodeRow& row : arrivals_.rows_of_nodes) to_home[row.body % ranks].push_back(row);
  std::vector<NodeRow>().swap(arrivals_.rows_of_nodes);
  std::vector<NodeRow> at_home = all_to_all(comm_, to_home).data;
  const auto by_bond = [](const NodeRow& a, const NodeRow& b) { return a.body < b.body; };
  std::sort(at_home.begin(), at_home.end(), by_bond);
  std::vector<std::vector<int>> ask(ranks);
  for (const Bond& b : bonds_) ask[b.body % ranks].push_back(b.body);
  const Received<int> asked = all_to_all(comm_, ask);
  std::vector<std::vector<NodeRow>> answer(ranks);
  std::size_t n = 0;
  for (int rank = 0; rank < ranks; ++rank)
    for (int i = 0; i < asked.count[rank]; ++i, ++n) {
      NodeRow of_bond;
      of_bond.body = asked.data[n];
      const auto rows = std::equal_range(at_home.begin(), at_home.end(), of_bond, by_bond);
      answer[rank].insert(answer[rank].end(), rows.first, rows.second);
    }
  take_restored_nodes(all_to_all(comm_, answer).data);
}

}  // namespace mpdem
