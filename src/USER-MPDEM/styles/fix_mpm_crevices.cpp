// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Bodies with a crevice get two sheets (fracture/crevice.h). What lies near the middle of a body goes to
// one rank, which looks at it as a whole and keeps the nodes where the sheets are joined.
#include <algorithm>
#include <cmath>

#include "../fracture/crevice.h"
#include "../parallel/all_to_all.h"
#include "comm.h"
#include "fix_mpm.h"

namespace LAMMPS_NS {

using mpdem::kLanes;

namespace {

struct Sent {
  int body;
  mpdem::SheetPoint point;
};

}  // namespace

// But for its sheet.
mpdem::SheetPoint FixMpm::sheet_point(int block, int lane) const {
  const mpdem::PointStore& points = avec_->points;
  const mpdem::Body& body = avec_->bodies[points.meta[block].body];
  mpdem::SheetPoint p;
  for (int d = 0; d < 3; ++d) {
    p.X[d] = points.created_at(block)[d][lane];
    p.cell[d] = mpdem::lattice_cell(body, d, p.X[d]);
  }
  p.share = points.blocks[block].volume[lane] / (body.spacing * body.spacing * body.spacing);
  p.sheet = 0;
  return p;
}

// Collective. Parts of the points of bodies from the first on; new_part_ has those that change.
void FixMpm::divide_bodies(int first) {
  const mpdem::PointStore& points = avec_->points;
  const int bodies = static_cast<int>(avec_->bodies.size());
  if (first >= bodies) return;
  const double reach = mpdem::sheet_reach(basis_, cell_);
  std::vector<signed char> sheet(kLanes * points.blocks.size(), 0);
  std::vector<std::vector<Sent>> out(comm->nprocs);
  for (std::size_t b = 0; b < points.blocks.size() && tied_; ++b) {
    const mpdem::BlockMeta& m = points.meta[b];
    if (m.body < first) continue;
    const mpdem::Body& body = avec_->bodies[m.body];
    for (int l = 0; l < kLanes; ++l) {
      if (!(m.occupied >> l & 1)) continue;
      Sent s;
      s.body = m.body;
      s.point = sheet_point(static_cast<int>(b), l);
      const double nearer = mpdem::nearer_to_first(body, s.point.X);
      s.point.sheet = mpdem::nearer_side(body, nearer);
      s.point.middle = mpdem::in_the_middle(body, nearer);
      sheet[kLanes * b + l] = static_cast<signed char>(s.point.sheet);
      if (std::fabs(nearer) <= reach) out[m.body % comm->nprocs].push_back(s);
    }
  }
  std::vector<std::vector<mpdem::SheetPoint>> whole(bodies);
  for (const Sent& s : mpdem::all_to_all(world, out).data) whole[s.body].push_back(s.point);
  has_sheets_.resize(bodies);
  joined_.erase(std::lower_bound(joined_.begin(), joined_.end(), mpdem::Key{first, -(1 << 30), 0, 0}), joined_.end());
  for (int b = first; b < bodies; ++b) {
    const mpdem::Crevice c = mpdem::find_crevice(whole[b], avec_->bodies[b], basis_, cell_);
    std::vector<mpdem::SheetPoint>().swap(whole[b]);
    has_sheets_[b] = c.found;
    if (!c.found) continue;
    for (const auto& node : c.joined) joined_.push_back({b, node[0], node[1], node[2]});
  }
  MPI_Allreduce(MPI_IN_PLACE, has_sheets_.data() + first, bodies - first, MPI_SIGNED_CHAR, MPI_MAX, world);
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const mpdem::BlockMeta& m = points.meta[b];
    if (m.body < first) continue;
    for (int l = 0; l < kLanes; ++l) {
      if (!(m.occupied >> l & 1)) continue;
      const int slot = kLanes * static_cast<int>(b) + l;
      const int part = mpdem::part_of(mpdem::piece_of(m.part), has_sheets_[m.body] ? sheet[slot] : 0);
      if (part != m.part) new_part_[slot] = part;
    }
  }
}

// Of a body that this rank looks at as a whole.
mpdem::JoinedNodes FixMpm::joined_nodes(int body) const {
  const auto from = std::lower_bound(joined_.begin(), joined_.end(), mpdem::Key{body, -(1 << 30), 0, 0});
  mpdem::JoinedNodes nodes;
  for (auto k = from; k != joined_.end() && (*k)[0] == body; ++k) nodes.push_back({(*k)[1], (*k)[2], (*k)[3]});
  return nodes;
}

int FixMpm::part_of_slot(int slot) const {
  const auto moved = new_part_.find(slot);
  return moved != new_part_.end() ? moved->second : avec_->points.meta[slot / kLanes].part;
}

// For each of the nodes, what find_edge_ties() asks. Collective.
std::vector<char> FixMpm::sheets_at(const std::vector<mpdem::Key>& keys) {
  const auto place = [](mpdem::Key k) {
    k[0] = mpdem::body_of(k[0]);
    return k;
  };
  std::vector<mpdem::Key> wanted;
  for (const mpdem::Key& k : keys)
    if (has_sheets_[mpdem::body_of(k[0])]) wanted.push_back(place(k));
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  std::vector<char> found;
  mpdem::fetch_values(world, 1, joined_, std::vector<double>(joined_.size(), 0.0), wanted, found);
  std::vector<char> sheets(keys.size(), mpdem::kNoSheets);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (!has_sheets_[mpdem::body_of(keys[i][0])]) continue;
    const std::size_t at = std::lower_bound(wanted.begin(), wanted.end(), place(keys[i])) - wanted.begin();
    sheets[i] = found[at] ? mpdem::kJoined : mpdem::kApart;
  }
  return sheets;
}

}  // namespace LAMMPS_NS
