// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// State of the cement that points and grains do not hold, for restart files: numbers of all, a row a bond, a row a node.
#include <algorithm>
#include <limits>
#include <utility>

#include "../mpm/checked_numbers.h"
#include "../parallel/agree.h"
#include "cement.h"

namespace mpdem {

namespace {
constexpr std::size_t kBondRow = 6;
constexpr int kNodeRow = 4 + NodeKinematics::kWidth;
}  // namespace

std::vector<double> Cement::packed_state(double time, const std::vector<double>& of_host) {
  const EnergyBooks::Sums& b = books_.sums();
  double sums[5] = {b.dissipated, b.released, b.damped, b.work, b.work_ahead};
  MPI_Allreduce(MPI_IN_PLACE, sums, 5, MPI_DOUBLE, MPI_SUM, comm_);
  std::vector<double> mine;
  for (const Bond& bond : bonds_) {
    const NodeKinematics k = bond.grid.kinematics();
    for (std::size_t i = 0; i < k.keys.size(); ++i) {
      if (!bond.grid.halo.counts_here()[i]) continue;
      mine.insert(mine.end(), k.keys[i].begin(), k.keys[i].end());
      const double* v = &k.values[NodeKinematics::kWidth * i];
      mine.insert(mine.end(), v, v + NodeKinematics::kWidth);
    }
  }
  int ranks, me, n = static_cast<int>(mine.size());
  MPI_Comm_size(comm_, &ranks);
  MPI_Comm_rank(comm_, &me);
  std::vector<int> counts(ranks), at(ranks, 0);
  MPI_Gather(&n, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm_);
  std::vector<double> nodes;
  if (me == 0) {
    for (int r = 1; r < ranks; ++r) at[r] = at[r - 1] + counts[r - 1];
    nodes.resize(at.back() + counts.back());
  }
  MPI_Gatherv(mine.data(), n, MPI_DOUBLE, nodes.data(), counts.data(), at.data(), MPI_DOUBLE, 0, comm_);
  std::vector<double> all;
  if (me != 0) return all;
  all = {options_.cell, static_cast<double>(options_.basis), 1.0 * options_.updated + 2.0 * options_.tied, dt_last_,
         static_cast<double>(bodies_started_), books_.start_energy()};
  all.insert(all.end(), sums, sums + 5);
  all.push_back(time);
  all.push_back(eigenvalue_);
  all.insert(all.end(), of_host.begin(), of_host.end());
  const std::size_t rows = bonds_.table.size();
  all.push_back(static_cast<double>(rows));
  all.push_back(static_cast<double>(nodes.size() / kNodeRow));
  states_.resize(rows, BondState{});
  for (std::size_t r = 0; r < rows; ++r) {
    const Cracks::State s = r < cracks_.size() ? cracks_[r] : Cracks::State();
    all.insert(all.end(), {s.failed_seen, 1.0 * s.separation.separated, s.separation.at_grain[0], s.separation.at_grain[1],
                           s.separation.inside, states_[r].peak});
  }
  all.insert(all.end(), nodes.begin(), nodes.end());
  return all;
}

double Cement::restore_head(CheckedNumbers& in) {
  const double cell = in.positive("cell");
  const Basis basis = static_cast<Basis>(in.integer("the number of the basis", 0, static_cast<int>(Basis::cubic)));
  const int kinematics = in.integer("the number of the kinematics", 0, 3);
  const bool updated = kinematics & 1, tied = kinematics & 2;
  dt_last_ = in.not_negative("the time step");
  bodies_started_ = in.integer("the number of bonds that have moved", 0, static_cast<double>(bonds_.table.size()));
  const double start_energy = in.finite("an energy");
  double sums[5];
  in.finite("an energy", sums);
  int me;
  MPI_Comm_rank(comm_, &me);
  books_.restore(me == 0 ? EnergyBooks::Sums{sums[0], sums[1], sums[2], sums[3], sums[4]} : EnergyBooks::Sums(), start_energy);
  const double time = in.finite("the time");
  eigenvalue_ = in.not_negative("the largest eigenvalue");
  restored_ = true;
  if (!in.trouble().empty()) return time;
  const auto edge = [](bool t) { return t ? "tied" : "free"; };
  const auto name = [](bool u) { return u ? "updated" : "total"; };
  const char* const bases[] = {"linear", "quadratic", "cubic"};
  if (cell != options_.cell)
    throw BadState(text_of("'cell ", options_.cell, "' but the restart file was written with cell ", cell, "; use that"));
  if (basis != options_.basis || updated != options_.updated)
    throw BadState(text_of("'basis ", bases[static_cast<int>(options_.basis)], "' and 'kinematics ", name(options_.updated),
                           "' but the motion of the nodes in the restart file is that of basis ", bases[static_cast<int>(basis)],
                           " and kinematics ", name(updated), "; use these"));
  if (tied != options_.tied)
    throw BadState(text_of("nodes at the edge are ", edge(options_.tied), " but were ", edge(tied), " when the restart file was written; use 'edge ",
                           edge(tied), "' and the kinematics and re-projection of that run"));
  return time;
}

// Rows of nodes in any order. Cement may have been made since.
std::string Cement::restore_rows(CheckedNumbers& in, std::size_t numbers_left) {
  const std::size_t table = bonds_.table.size();
  const std::size_t rows = in.integer("the number of bonds", bodies_started_, static_cast<double>(table));
  const std::size_t n = in.integer("the number of nodes", 0, std::numeric_limits<int>::max());
  if (!in.trouble().empty()) return in.trouble();
  const std::size_t expected = 2 + kBondRow * rows + kNodeRow * n;
  if (expected > numbers_left)
    return text_of(rows, " bonds and ", n, " nodes take ", expected, " numbers, it has ", numbers_left, " at most");
  std::vector<Cracks::State> cracks(rows);
  states_.assign(rows, BondState{});
  for (std::size_t r = 0; r < rows; ++r) {
    cracks[r].failed_seen = in.not_negative("the number of failed points of a bond");
    Separation& s = cracks[r].separation;
    s.separated = in.flag("'is separated' of a bond");
    s.at_grain[0] = in.not_negative("the area of separation at a grain");
    s.at_grain[1] = in.not_negative("the area of separation at a grain");
    s.inside = in.not_negative("the area of separation inside");
    states_[r].peak = in.finite("the largest tension of a bond");
  }
  cracks_.restore(std::move(cracks));
  const double most = 1 << 30;
  const double* first = in.next();
  std::vector<std::pair<Key, const double*>> nodes;
  for (std::size_t i = 0; i < n; ++i) {
    const int field = in.integer("the bond of a node", 0, most);
    in.check("the bond of a node", body_of(field), 0, static_cast<double>(table) - 1);
    Key key{field, 0, 0, 0};
    for (int d = 1; d < 4; ++d) key[d] = in.integer("the place of a node", -most, most);
    for (int d = 0; d < NodeKinematics::kWidth; ++d) in.finite("the motion of a node");
    nodes.emplace_back(key, first + kNodeRow * i + 4);
  }
  if (!in.trouble().empty()) return in.trouble();
  std::sort(nodes.begin(), nodes.end());
  restored_nodes_.assign(table, NodeKinematics());
  for (const auto& [key, values] : nodes) {
    NodeKinematics& k = restored_nodes_[body_of(key[0])];
    k.keys.push_back(key);
    k.values.insert(k.values.end(), values, values + NodeKinematics::kWidth);
  }
  return "";
}

}  // namespace mpdem
