// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// State of the cement that points and grains do not hold, for restart files: cement_restart.h.
#include <algorithm>
#include <map>

#include "../parallel/agree.h"
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
  row.field = grid.keys[i][0];
  for (int d = 0; d < 3; ++d) {
    row.place[d] = grid.keys[i][1 + d];
    row.velocity[d] = grid.velocity[3 * i + d];
    row.displacement[d] = grid.displacement[3 * i + d];
    row.acceleration[d] = grid.acceleration[3 * i + d];
  }
  return row;
}

Key key_of(const NodeRow& r) { return {r.field, r.place[0], r.place[1], r.place[2]}; }

}  // namespace

std::vector<double> Cement::packed_state(CementHead head) {
  std::vector<double> mine;
  for (const Bond& bond : bonds_.awake())
    for (int i = 0; i < bond.grid.size(); ++i)
      if (bond.grid.halo.counts_here()[i]) append(row_of(bond.grid, i), mine);
  const std::vector<double> nodes = gather(comm_, mine);
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
      append(CopyRow{body_of(row.first[0]), {row.first[1], row.first[2], row.first[3]}, e.part, e.copy, e.first, e.volume}, mine_of_copies);
  const std::vector<double> copies = gather(comm_, mine_of_copies);
  head.split = options_.split;
  head.unilateral = options_.unilateral;
  head.copies = static_cast<int>(copies.size() / kMostNumbers<CopyRow>);
  head.bodies = static_cast<int>(bonds_.table.size());
  head.nodes = static_cast<int>(nodes.size() / kMostNumbers<NodeRow>);
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
  all.insert(all.end(), nodes.begin(), nodes.end());
  all.insert(all.end(), copies.begin(), copies.end());
  return all;
}

void Cement::check_restored(const CementHead& head) const {
  const auto edge = [](bool t) { return t ? "tied" : "free"; };
  const auto name = [](bool u) { return u ? "updated" : "total"; };
  const char* const bases[] = {"linear", "quadratic", "cubic"};
  if (head.cell != options_.cell)
    throw BadState(text_of("'cell ", options_.cell, "' but the restart file was written with cell ", head.cell, "; use that"));
  if (head.basis != options_.basis || head.updated != options_.updated)
    throw BadState(text_of("'basis ", bases[static_cast<int>(options_.basis)], "' and 'kinematics ", name(options_.updated),
                           "' but the motion of the nodes in the restart file is that of basis ", bases[static_cast<int>(head.basis)],
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
void Cement::restore(const CementHead& head, RecordReader& in) {
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
  std::vector<NodeRow> rows(head.nodes);
  for (NodeRow& row : rows) {
    in.read(row);
    in.check_whole("the bond of a node", body_of(row.field), from(0, static_cast<double>(table) - 1.0));
  }
  std::map<Key, NodeCopies::Row> copies;
  for (int n = 0; n < head.copies; ++n) {
    CopyRow row;
    in.read(row);
    in.check_whole("the bond of a split node", row.body, from(0, static_cast<double>(table) - 1.0));
    copies[{row.body, row.place[0], row.place[1], row.place[2]}].push_back({row.part, row.copy, row.first, row.volume});
  }
  if (!in.trouble().empty()) return;
  if (options_.split) splits_.restore(head.bodies, std::move(copies));
  std::sort(rows.begin(), rows.end(), [](const NodeRow& a, const NodeRow& b) { return key_of(a) < key_of(b); });
  arrivals_.restored_nodes.assign(table, NodeKinematics());
  for (const NodeRow& row : rows) {
    NodeKinematics& k = arrivals_.restored_nodes[body_of(row.field)];
    k.keys.push_back(key_of(row));
    for (const double* part : {row.velocity, row.displacement, row.acceleration}) k.values.insert(k.values.end(), part, part + 3);
  }
}

}  // namespace mpdem
