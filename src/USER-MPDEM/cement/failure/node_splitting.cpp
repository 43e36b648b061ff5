// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "node_splitting.h"

#include <algorithm>
#include <cmath>

#include "../../numerics/length.h"
#include "../../numerics/index_in.h"
#include "../../numerics/sort_unique.h"
#include "../../parallel/agree.h"
#include "../../parallel/all_to_all.h"
#include "../../parallel/ranks.h"
#include "node_index.h"

namespace mpdem {

namespace {

struct SentPoint {
  int row;
  SplitterPoint point;
};
struct SentGapPoint {
  int row;
  GapPoint point;
};
constexpr char kHasLattice = 1, kToCollect = 2;  // bonds to examine: the lattice is there; the points must be collected first
constexpr int kBetween = -1;  // piece of points between the grains; a number of its own keeps the order of the grains without effect

struct SentTag {
  int row, tag;
};
struct SentLayer {
  int row, tag, layer;
};
struct SentSource {
  int row, layer, from;
  GridIndex node;
};
struct SentEntry {
  int row;
  GridIndex node;
  PhantomNodes::Entry entry;
};
struct SentContinuation {
  int row;
  GridIndex node;
  PhantomNodes::Continuation continuation;
};

// The volume is that of cement of the density of the scene with the same mass.
SentPoint sent_point(const PointStore& points, int row, const BondRecord& record, const CementOptions& options,
                     const CementDensity& density, int b, int l) {
  SentPoint s{row, {}};
  SplitterPoint& p = s.point;
  const GapPoint position = gap_point(points, record, b, l);
  p.tag = points.tags[b][l];
  for (int d = 0; d < 3; ++d) {
    p.cell[d] = position.cell[d];
    // The block of a point that was received has no cell yet.
    p.base[d] = support_base(points.blocks[b].X[d][l], 1.0 / options.cell, cell_shift(options.basis));
    p.at[d] = points.blocks[b].X[d][l] / options.cell - p.base[d];
  }
  p.volume = density.of(points.meta[b].material) / density.of_scene * points.blocks[b].volume[l];
  p.layer = points.meta[b].layer;
  p.failed = points.meta[b].split_checked >> l & 1;
  p.nearer = position.nearer_grain;
  p.middle = position.middle;
  for (int n = 0; n < 6; ++n) p.space[n] = static_cast<float>(space_ahead(position, record, n / 2, n % 2 == 0 ? -1 : 1));
  return s;
}

NodeSplitter::Line line_of(const BondRecord& record, double cell) {
  NodeSplitter::Line line;
  double apart[3], widest = 0.0;
  for (int d = 0; d < 3; ++d) {
    apart[d] = record.centre[1][d] - record.centre[0][d];
    if (std::fabs(apart[d]) > widest) {
      widest = std::fabs(apart[d]);
      line.axis = d;
    }
  }
  const double to_middle = share_to_middle(record, length(apart));
  for (int d = 0; d < 3; ++d) line.middle[d] = (record.centre[0][d] + to_middle * apart[d]) / cell;
  return line;
}

template <class F>
void for_each_point(const PointStore& points, F f) {
  for (int b = 0; b < static_cast<int>(points.blocks.size()); ++b)
    for (int l = 0; l < kLanes; ++l)
      if (points.meta[b].occupied >> l & 1) f(b, l);
}

// Collective. Sends the points of the wanted bonds to the ranks that examine these bonds.
std::vector<std::vector<SplitterPoint>> collect(MPI_Comm comm, const Bonds& bonds, const CementOptions& options,
                                                const CementDensity& density, const std::vector<char>& wanted) {
  const int ranks = ranks_of(comm);
  std::vector<std::vector<SentPoint>> out(ranks);
  for (const Bond& bond : bonds)
    if (wanted[bond.row])
      for_each_point(bond.points, [&](int b, int l) {
        out[bond.row % ranks].push_back(sent_point(bond.points, bond.row, bonds.record(bond), options, density, b, l));
      });
  std::vector<std::vector<SplitterPoint>> whole(wanted.size());
  for (const SentPoint& s : all_to_all(comm, out).data) whole[s.row].push_back(s.point);
  return whole;
}

// Collective. Finds the unbonded gaps of the wanted bonds, on the ranks that examine them.
std::map<int, UnbondedGap> find_unbonded_gaps(MPI_Comm comm, const Bonds& bonds, const CementOptions& options,
                                              const std::vector<char>& wanted) {
  const int ranks = ranks_of(comm);
  const double reach = gap_reach(options.basis, options.cell);
  std::vector<std::vector<SentGapPoint>> out(ranks);
  for (const Bond& bond : bonds)
    if (wanted[bond.row])
      for_each_point(bond.points, [&](int b, int l) {
        const GapPoint p = gap_point(bond.points, bonds.record(bond), b, l);
        if (std::fabs(nearer_to_first(bonds.record(bond), p.X)) <= reach) out[bond.row % ranks].push_back({bond.row, p});
      });
  std::vector<std::vector<GapPoint>> near(wanted.size());
  for (const SentGapPoint& s : all_to_all(comm, out).data) near[s.row].push_back(s.point);
  std::map<int, UnbondedGap> found;
  for (std::size_t r = 0; r < near.size(); ++r) {
    if (near[r].empty()) continue;
    UnbondedGap c = find_unbonded_gap(near[r], bonds.table[r], options.basis, options.cell);
    if (c.found) found.emplace_hint(found.end(), static_cast<int>(r), std::move(c));
    std::vector<GapPoint>().swap(near[r]);
  }
  return found;
}

// Moves points with a layer from an earlier fix to layer 0, except those that have a new layer.
void leave_former_layers(const Bond& bond, NewLayersOfBonds& found) {
  for_each_point(bond.points, [&](int b, int l) {
    if (bond.points.meta[b].layer != 0) found[bond.row].layer_of_slot.emplace(kLanes * b + l, 0);
  });
}

}  // namespace

const NodeSplitting::Row NodeSplitting::kWhole{};

// Sends changes from the ranks that examine the bonds to those that have points of them.
NewLayersOfBonds NodeSplitting::apply(MPI_Comm comm, const Bonds& bonds, const std::vector<int>& rows,
                                      const std::vector<NodeChange>& changes) {
  const int ranks = ranks_of(comm);
  std::vector<std::vector<int>> here(ranks);
  for (int r : rows)
    if (bonds.find(r)) here[r % ranks].push_back(r);
  const Received<int> holders = all_to_all(comm, here);
  std::vector<std::vector<SentLayer>> sent_layers(ranks);
  std::vector<std::vector<SentSource>> sources(ranks);
  std::vector<std::vector<SentEntry>> entries(ranks);
  std::size_t n = 0;
  for (int rank = 0; rank < ranks; ++rank)
    for (int i = 0; i < holders.count[rank]; ++i, ++n) {
      const int r = holders.data[n];
      const NodeChange& c = changes[index_in(rows, r, "bond")];
      for (const NodeChange::Moved& m : c.moved) sent_layers[rank].push_back({r, m.tag, m.layer});
      for (const NodeChange::Source& s : c.sources) sources[rank].push_back({r, s.layer, s.from, s.node});
      for (const GridIndex& p : c.rows)
        for (const PhantomNodes::Entry& e : *copies(r).row(p)) entries[rank].push_back({r, p, e});
    }
  NewLayersOfBonds found;
  std::vector<SentLayer> moved = all_to_all(comm, sent_layers).data;
  std::sort(moved.begin(), moved.end(),
            [](const SentLayer& a, const SentLayer& b) { return a.row != b.row ? a.row < b.row : a.tag < b.tag; });
  for (int r : rows) {
    const Bond* bond = bonds.find(r);
    if (!bond) continue;
    const auto of_bond = std::equal_range(moved.begin(), moved.end(), SentLayer{r, 0, 0},
                                          [](const SentLayer& a, const SentLayer& b) { return a.row < b.row; });
    if (of_bond.first == of_bond.second) continue;
    std::map<int, int>& layer_of_slot = found[r].layer_of_slot;
    constexpr int kMarks = 1 << 12;  // a filter by tag: most points do not move
    std::vector<char> marks(kMarks, 0);
    for (auto m = of_bond.first; m != of_bond.second; ++m) marks[m->tag % kMarks] = 1;
    for_each_point(bond->points, [&](int b, int l) {
      const int tag = bond->points.tags[b][l];
      if (!marks[tag % kMarks]) return;
      const auto m = std::lower_bound(of_bond.first, of_bond.second, tag, [](const SentLayer& a, int t) { return a.tag < t; });
      if (m == of_bond.second || m->tag != tag) return;
      if (m->layer >= kMaxLayers) throw OnOneRank(text_of("a bond broke into more than ", kMaxLayers, " layers"));
      layer_of_slot[kLanes * b + l] = m->layer;
    });
  }
  for (const SentSource& s : all_to_all(comm, sources).data)
    found[s.row].source[key_at(s.row, s.layer, s.node)] = key_at(s.row, s.from, s.node);
  const int me = rank_in(comm);
  std::map<Key, PhantomNodes::Row> changed;
  for (const SentEntry& e : all_to_all(comm, entries).data) {
    const Key k = key_at(e.row, 0, e.node);
    std::vector<Key>& split = found[e.row].split;
    if (split.empty() || split.back() != k) split.push_back(k);
    if (e.row % ranks != me) changed[k].push_back(e.entry);
  }
  for (auto& c : changed) rows_[row_of(c.first.field())].copies.set(grid_index_of(c.first), std::move(c.second));
  return found;
}

NewLayersOfBonds NodeSplitting::start(MPI_Comm comm, Bonds& bonds, const CementOptions& options, const std::vector<int>& with_new_points) {
  const int to = static_cast<int>(bonds.table.size()), ranks = ranks_of(comm), me = rank_in(comm);
  std::vector<char> is_new(to, 0);
  std::fill(is_new.begin() + first_new(), is_new.end(), 1);
  for (int r : with_new_points) is_new[r] = 1;
  std::vector<char> wanted(is_restored_ ? std::vector<char>(to, 1) : is_new);  // restart files have no continuations
  if (std::find(wanted.begin(), wanted.end(), 1) == wanted.end()) return {};
  known_.resize(to);
  for (int r = 0; r < to; ++r)
    if (wanted[r]) known_[r].copies = r % ranks == me;
  for (Bond& b : bonds)
    for (BlockMeta& m : b.points.meta)
      if (is_new[b.row]) m.split_checked = 0;
  std::map<int, UnbondedGap> unbonded_gaps;
  if (options.tied || options.split) unbonded_gaps = find_unbonded_gaps(comm, bonds, options, wanted);
  if (!options.split) {
    std::fill(wanted.begin(), wanted.end(), 0);
    for (const auto& c : unbonded_gaps) wanted[c.first] = 1;
    MPI_Allreduce(MPI_IN_PLACE, wanted.data(), to, MPI_SIGNED_CHAR, MPI_MAX, comm);
  }
  std::vector<std::vector<SplitterPoint>> whole = collect(comm, bonds, options, density_, wanted);
  std::vector<int> rows;
  std::vector<NodeChange> changes;
  for (int r = 0; r < to; ++r) {
    if (!wanted[r]) continue;
    rows.push_back(r);
    changes.emplace_back();
    if (r % ranks != me) continue;
    for (SplitterPoint& p : whole[r]) {
      p.layer = 0;
      p.failed = false;
    }
    NodeSplitter lattice(std::move(whole[r]), options.basis, line_of(bonds.table[r], options.cell));
    Row& row = rows_[r];
    changes.back() = lattice.start(row.copies, unbonded_gaps[r]);
    if (is_new[r]) continue;
    // A bond of a restart file has its copies from the file. It needs the continuations of start() alone.
    changes.back() = NodeChange();
    row.copies.forget_rows();
  }
  for (auto& e : restored_)
    if (row_of(e.first.field()) % ranks == me) rows_[row_of(e.first.field())].copies.set(grid_index_of(e.first), std::move(e.second));
  restored_.clear();
  is_restored_ = false;
  NewLayersOfBonds found = apply(comm, bonds, rows, changes);
  for (const Bond& bond : bonds)
    if (is_new[bond.row]) leave_former_layers(bond, found);
  return found;
}

std::map<Key, PhantomNodes::Row> NodeSplitting::rows_to_keep(MPI_Comm comm) const {
  const int ranks = ranks_of(comm), me = rank_in(comm);
  std::map<Key, PhantomNodes::Row> kept;
  for (const auto& r : rows_)
    for (const auto& row : r.second.copies.rows())
      if (r.first % ranks == me) kept[key_at(r.first, 0, row.first)] = row.second;
  return kept;
}

void NodeSplitting::find_lattices(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<char>& wanted) {
  std::vector<char> to_come(wanted.size(), 0);
  for (std::size_t r = 0; r < wanted.size(); ++r) to_come[r] = wanted[r] == kToCollect;
  if (std::find(to_come.begin(), to_come.end(), 1) == to_come.end()) return;
  std::vector<std::vector<SplitterPoint>> whole = collect(comm, bonds, options, density_, to_come);
  const int ranks = ranks_of(comm);
  for (int r = rank_in(comm); r < static_cast<int>(wanted.size()); r += ranks)
    if (to_come[r])
      rows_[r].lattice = std::make_shared<NodeSplitter>(std::move(whole[r]), options.basis, line_of(bonds.table[r], options.cell));
}

NodeSplitting::Found NodeSplitting::find_splits(MPI_Comm comm, Bonds& bonds, const CementOptions& options, int from) {
  Found found;
  const int ranks = ranks_of(comm), me = rank_in(comm), n = static_cast<int>(bonds.table.size());
  std::vector<std::vector<SentTag>> out(ranks);
  // A bond with such points is not condensed, see Condensing::rests().
  const auto is_due = [&](const Bond& b) { return from == kResolved ? bonds.is_resolved(b) : b.row >= from; };
  for (const Bond& bond : bonds)
    for (std::size_t b = 0, end = is_due(bond) ? bond.points.meta.size() : 0; b < end; ++b) {
      const BlockMeta& m = bond.points.meta[b];
      const int fresh = m.failed & ~m.split_checked;
      for (int l = 0; l < kLanes && fresh; ++l)
        if (fresh >> l & 1) out[bond.row % ranks].push_back({bond.row, bond.points.tags[b][l]});
    }
  bool mine = false;
  for (const auto& to : out) mine = mine || !to.empty();
  int some = mine, any;
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, comm);
  if (!any) return found;
  std::map<int, std::vector<int>> failed;
  for (const SentTag& s : all_to_all(comm, out).data) failed[s.row].push_back(s.tag);
  std::vector<char> wanted(n, 0);
  for (const auto& f : failed) wanted[f.first] = row(f.first).lattice ? kHasLattice : kToCollect;
  MPI_Allreduce(MPI_IN_PLACE, wanted.data(), n, MPI_SIGNED_CHAR, MPI_MAX, comm);
  find_lattices(comm, bonds, options, wanted);
  for (Bond& bond : bonds)
    if (wanted[bond.row])
      for (BlockMeta& m : bond.points.meta) m.split_checked = m.failed;
  std::vector<int> rows;
  std::vector<NodeChange> changes;
  std::vector<char> changed(n, 0);
  for (int r = 0; r < n; ++r) {
    if (!wanted[r]) continue;
    rows.push_back(r);
    changes.emplace_back();
    if (r % ranks != me) continue;
    changes.back() = rows_[r].lattice->fail(failed[r], rows_[r].copies);
    changed[r] = !changes.back().rows.empty();
  }
  found.layers = apply(comm, bonds, rows, changes);
  MPI_Allreduce(MPI_IN_PLACE, changed.data(), n, MPI_SIGNED_CHAR, MPI_MAX, comm);
  for (int r : rows)
    if (changed[r]) found.lay_out.push_back(r);
  return found;
}

NodeChange NodeSplitting::separate(int row, const std::vector<PointOfPiece>& pieces, const CementOptions& options) {
  std::vector<NodeSplitter::OfPiece> of_pieces;
  of_pieces.reserve(pieces.size());
  for (const PointOfPiece& p : pieces) of_pieces.push_back({p.tag, p.between ? kBetween : p.piece});
  NodeChange change = rows_[row].lattice->split_pieces(of_pieces, rows_[row].copies);
  if (!options.split) rows_[row].lattice.reset();
  return change;
}

NodeSplitting::Found NodeSplitting::split_pieces(MPI_Comm comm, Bonds& bonds, const CementOptions& options,
                                                 SeparatedBonds newly_separated) {
  Found found;
  found.lay_out = std::move(newly_separated.rows);
  const int n = static_cast<int>(bonds.table.size());
  std::vector<char> wanted(n, 0), changed(n, 0);
  for (const auto& p : newly_separated.pieces) wanted[p.first] = row(p.first).lattice ? kHasLattice : kToCollect;
  MPI_Allreduce(MPI_IN_PLACE, wanted.data(), n, MPI_SIGNED_CHAR, MPI_MAX, comm);
  for (Bond& bond : bonds)
    if (wanted[bond.row])
      for (BlockMeta& m : bond.points.meta) m.split_checked = m.failed;
  find_lattices(comm, bonds, options, wanted);
  std::vector<int> rows;
  std::vector<NodeChange> changes;
  for (int r = 0; r < n; ++r) {
    if (!wanted[r]) continue;
    rows.push_back(r);
    changes.emplace_back();
    const auto p = newly_separated.pieces.find(r);
    if (p == newly_separated.pieces.end()) continue;
    changes.back() = separate(r, p->second, options);
    changed[r] = !changes.back().moved.empty() || !changes.back().rows.empty();
  }
  if (rows.empty()) return found;
  found.layers = apply(comm, bonds, rows, changes);
  MPI_Allreduce(MPI_IN_PLACE, changed.data(), n, MPI_SIGNED_CHAR, MPI_MAX, comm);
  for (int r : rows)
    if (changed[r]) found.lay_out.push_back(r);
  sort_unique(found.lay_out);
  return found;
}

void NodeSplitting::remove_volume(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<int>& rows) {
  std::vector<char> wanted(known_.size(), 0);
  for (int r : rows) wanted[r] = kToCollect;
  find_lattices(comm, bonds, options, wanted);
  std::vector<NodeChange> changes(rows.size());
  for (std::size_t n = 0; n < rows.size(); ++n) {
    if (rows[n] % ranks_of(comm) != rank_in(comm)) continue;
    changes[n].rows = rows_[rows[n]].lattice->leave(rows_[rows[n]].copies);
    rows_[rows[n]].lattice.reset();
  }
  apply(comm, bonds, rows, changes);
}

void NodeSplitting::fetch_copies(MPI_Comm comm, const Bonds& bonds) {
  const int ranks = ranks_of(comm), me = rank_in(comm);
  std::vector<char> moved(known_.size(), 0);
  for (const Bond& b : bonds)
    if (b.points.changed() && b.row < first_new()) moved[b.row] = 1;
  MPI_Allreduce(MPI_IN_PLACE, moved.data(), first_new(), MPI_SIGNED_CHAR, MPI_MAX, comm);
  for (int r = 0; r < first_new(); ++r)
    if (moved[r]) known_[r].edges = false;
  std::vector<std::vector<int>> ask(ranks);
  for (int r = 0; r < first_new(); ++r) {
    if (r % ranks == me) continue;
    const Bond* bond = bonds.find(r);
    if (!bond || !bond->has_points()) {  // copies here would not be updated; known_.edges stays, the same on all ranks
      rows_.erase(r);
      known_[r].copies = false;
    } else if (!known_[r].copies) {
      ask[r % ranks].push_back(r);
    }
  }
  const Received<int> asked = all_to_all(comm, ask);
  std::vector<std::vector<SentEntry>> entries(ranks);
  std::vector<std::vector<SentContinuation>> continuations(ranks);
  std::size_t n = 0;
  for (int rank = 0; rank < ranks; ++rank)
    for (int i = 0; i < asked.count[rank]; ++i, ++n) {
      const int r = asked.data[n];
      for (const auto& row : copies(r).rows())
        for (const PhantomNodes::Entry& e : row.second) entries[rank].push_back({r, row.first, e});
      for (const auto& t : copies(r).continuations())
        for (const PhantomNodes::Continuation& to : t.second) continuations[rank].push_back({r, t.first, to});
    }
  std::map<Key, PhantomNodes::Row> rows;
  for (const SentEntry& e : all_to_all(comm, entries).data) rows[key_at(e.row, 0, e.node)].push_back(e.entry);
  for (const auto& to : ask)
    for (int r : to) {
      if (const auto row = rows_.find(r); row != rows_.end()) row->second.copies.clear();
      known_[r].copies = true;
    }
  for (auto& r : rows) rows_[row_of(r.first.field())].copies.set(grid_index_of(r.first), std::move(r.second));
  for (const SentContinuation& t : all_to_all(comm, continuations).data)
    rows_[t.row].copies.continuations()[t.node].push_back(t.continuation);
}

}  // namespace mpdem
