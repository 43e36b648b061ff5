// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "sheets.h"

#include <algorithm>
#include <cmath>

#include "../numerics/sort_unique.h"
#include "../parallel/all_to_all.h"
#include "../parallel/ranks.h"
#include "../parallel/rendezvous.h"

namespace mpdem {

namespace {

struct Sent {
  int body;
  SheetPoint point;
};

Key first_of(int body) { return Key::before(field_of(body, 0)); }

}  // namespace

SheetPoint sheet_point(const PointStore& points, const Body& body, int block, int lane) {
  SheetPoint p;
  for (int d = 0; d < 3; ++d) {
    p.X[d] = points.created_at(block)[d][lane];
    p.cell[d] = lattice_cell(body, d, p.X[d]);
  }
  p.share = points.blocks[block].volume[lane] / (body.spacing * body.spacing * body.spacing);
  p.sheet = 0;
  return p;
}

NewPartsOfBonds Sheets::divide(MPI_Comm comm, const Bonds& bonds, const CementOptions& options, const std::vector<int>& others) {
  NewPartsOfBonds changed;
  const int rows = static_cast<int>(bonds.table.size()), from = first();
  std::vector<int> looked_at;  // ascending
  for (int row : others)
    if (row < from) looked_at.push_back(row);
  std::sort(looked_at.begin(), looked_at.end());
  for (int row = from; row < rows; ++row) looked_at.push_back(row);
  if (looked_at.empty()) return changed;
  std::vector<char> wanted(rows, 0);
  for (int row : looked_at) wanted[row] = 1;
  const int ranks = ranks_of(comm);
  const double reach = sheet_reach(options.basis, options.cell);
  std::vector<std::vector<Sent>> out(ranks);
  std::vector<std::vector<signed char>> sheet;  // sheets of the slots of each bond
  for (const Bond& bond : bonds) {
    sheet.emplace_back();
    if (!wanted[bond.body] || !options.tied) continue;
    const PointStore& points = bond.points;
    const Body& body = bonds.body(bond);
    sheet.back().assign(kLanes * points.blocks.size(), 0);
    for (std::size_t b = 0; b < points.blocks.size(); ++b)
      for (int l = 0; l < kLanes; ++l) {
        if (!(points.meta[b].occupied >> l & 1)) continue;
        Sent s{bond.body, sheet_point(points, body, static_cast<int>(b), l)};
        const double nearer = nearer_to_first(body, s.point.X);
        s.point.sheet = nearer_side(body, nearer);
        s.point.middle = in_the_middle(body, nearer);
        sheet.back()[kLanes * b + l] = static_cast<signed char>(s.point.sheet);
        if (std::fabs(nearer) <= reach) out[bond.body % ranks].push_back(s);
      }
  }
  std::vector<std::vector<SheetPoint>> whole(rows);
  for (const Sent& s : all_to_all(comm, out).data) whole[s.body].push_back(s.point);
  has_sheets_.resize(rows);
  std::vector<signed char> found(looked_at.size(), 0);
  for (std::size_t n = 0; n < looked_at.size(); ++n) {
    const int b = looked_at[n];
    const Crevice c = find_crevice(whole[b], bonds.table[b], options.basis, options.cell);
    std::vector<SheetPoint>().swap(whole[b]);
    found[n] = c.found;
    if (!c.found) continue;
    for (const auto& node : c.joined) joined_.push_back({b, node[0], node[1], node[2]});
  }
  std::sort(joined_.begin(), joined_.end());
  MPI_Allreduce(MPI_IN_PLACE, found.data(), static_cast<int>(found.size()), MPI_SIGNED_CHAR, MPI_MAX, comm);
  for (std::size_t n = 0; n < looked_at.size(); ++n) has_sheets_[looked_at[n]] = found[n];
  auto of_slot = sheet.begin();
  for (const Bond& bond : bonds) {
    const std::vector<signed char>& mine = *of_slot++;
    if (!wanted[bond.body]) continue;
    for (int slot = 0; slot < kLanes * static_cast<int>(bond.points.blocks.size()); ++slot) {
      const BlockMeta& m = bond.points.meta[slot / kLanes];
      if (!(m.occupied >> slot % kLanes & 1)) continue;
      const int part = part_of(piece_of(m.part), has_sheets_[bond.body] ? mine[slot] : 0);
      if (part != m.part) changed[bond.body].part_of_slot[slot] = part;
    }
  }
  return changed;
}

JoinedNodes Sheets::joined_nodes(int body) const {
  JoinedNodes nodes;
  for (auto k = std::lower_bound(joined_.begin(), joined_.end(), first_of(body)); k != joined_.end() && k->field() == field_of(body, 0); ++k)
    nodes.push_back(k->place());
  return nodes;
}

std::vector<char> Sheets::at(MPI_Comm comm, const std::vector<int>& rows, const std::vector<Key>& keys) const {
  const auto place = [](const Key& k) { return k.with_field(field_of(body_of(k.field()), 0)); };
  std::vector<Key> wanted;
  for (const Key& k : keys)
    if (has_sheets_[body_of(k.field())]) wanted.push_back(place(k));
  sort_unique(wanted);
  std::vector<char> found;
  std::vector<Key> joined;
  for (int row : rows)
    for (auto k = std::lower_bound(joined_.begin(), joined_.end(), first_of(row)); k != joined_.end() && k->field() == field_of(row, 0); ++k) joined.push_back(*k);
  fetch_values(comm, 1, joined, std::vector<double>(joined.size(), 0.0), wanted, found);
  std::vector<char> sheets(keys.size(), kNoSheets);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (!has_sheets_[body_of(keys[i].field())]) continue;
    const std::size_t at = std::lower_bound(wanted.begin(), wanted.end(), place(keys[i])) - wanted.begin();
    sheets[i] = found[at] ? kJoined : kApart;
  }
  return sheets;
}

}  // namespace mpdem
