// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Bonds that come apart: bodies in which points failed are looked at as a whole, each by one rank, and
// their parts get nodes of their own (fracture/separation.h). What is left of a shared node across a crack
// pulls on: so a path of intact points from grain to grain is remembered, and its bond is looked at as
// soon as one of them fails; what has come apart, at the checks of fix mpm. Of bonds that hold, the end of a run
// tells how much of them is left (fracture/ligament.h).
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "../fracture/ligament.h"
#include "../fracture/separation.h"
#include "../parallel/all_to_all.h"
#include "arguments.h"
#include "atom.h"
#include "comm.h"
#include "fix_mpm.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::kLanes;
using mpdem::text_of;
using mpdem::vd;

namespace {

struct Sent {
  int body, slot;
  mpdem::CrackPoint point;
};
struct Returned {
  int slot, part;
};
struct OfPath {
  int body, tag;
};

void direction_of_centres(const mpdem::Body& body, double* n) {
  double length = 0.0;
  for (int d = 0; d < 3; ++d) {
    n[d] = body.centre[1][d] - body.centre[0][d];
    length += n[d] * n[d];
  }
  for (int d = 0; d < 3; ++d) n[d] /= std::sqrt(length);
}

const char* mode_of(const mpdem::Separation& s) {
  const double share = s.debonded_share();
  return share >= 0.9 ? "debonding" : share <= 0.1 ? "internal" : "mixed";
}

std::string shares_of(const mpdem::Separation& s) {
  const double all = s.at_grain[0] + s.at_grain[1] + s.inside;
  if (all <= 0.0) return "";
  return text_of("; of the separating surface ", 100.0 * s.at_grain[0] / all, " % at the first grain, ",
                 100.0 * s.at_grain[1] / all, " % at the second, ", 100.0 * s.inside / all, " % inside");
}

}  // namespace

// What collect_bodies() brought to this rank.
struct FixMpm::WholeBodies {
  mpdem::Received<Sent> sent;
  std::vector<std::vector<mpdem::CrackPoint>> points;  // of each body, in the order in which they are sent; empty elsewhere
};

// Notes the bonds whose path is cut by the points that fail in this step.
void FixMpm::watch_paths() {
  if (!coupled_) return;
  const int bodies = static_cast<int>(avec_->bodies.size());
  for (int slot : advance_.failed) {
    const int b = avec_->points.meta[slot / kLanes].body;
    if (static_cast<int>(path_cut_.size()) < bodies) path_cut_.resize(bodies, 0);
    if (static_cast<int>(path_.size()) < bodies) path_.resize(bodies);
    if (path_cut_[b] || (b < static_cast<int>(separation_.size()) && separation_[b].separated)) continue;
    const std::vector<int>& path = path_[b];
    path_cut_[b] = path.empty() || std::binary_search(path.begin(), path.end(), avec_->points.tags[slot / kLanes][slot % kLanes]);
    any_path_cut_ = any_path_cut_ || path_cut_[b];
  }
}

// Collective.
bool FixMpm::some_path_is_cut() {
  int mine = any_path_cut_, any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  return any != 0;
}

// Sends each of the bodies asked for to one rank, as a whole. Collective.
FixMpm::WholeBodies FixMpm::collect_bodies(const std::vector<char>& wanted) {
  sort_links();
  const mpdem::PointStore& points = avec_->points;
  std::vector<std::vector<Sent>> out(comm->nprocs);
  std::vector<int> first_link(kLanes * points.blocks.size() + 1, 0);
  for (const mpdem::Link& k : points.links) ++first_link[k.slot + 1];
  for (std::size_t i = 1; i < first_link.size(); ++i) first_link[i] += first_link[i - 1];
  const std::vector<vd> damage = mpdem::largest_damages(points, *law_, wanted);
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const mpdem::BlockMeta& m = points.meta[b];
    if (!wanted[m.body]) continue;
    const mpdem::Body& body = avec_->bodies[m.body];
    double axis[3];
    direction_of_centres(body, axis);
    for (int l = 0; l < kLanes; ++l) {
      if (!(m.occupied >> l & 1)) continue;
      Sent s;
      s.body = m.body;
      s.slot = kLanes * static_cast<int>(b) + l;
      s.point.tag = points.tags[b][l];
      s.point.part = mpdem::piece_of(m.part);
      s.point.sheet = mpdem::sheet_of(m.part);
      s.point.failed = m.failed >> l & 1;
      s.point.damage = static_cast<float>(std::max(damage[b][l], 0.0));
      const mpdem::SheetPoint place = sheet_point(static_cast<int>(b), l);
      for (int d = 0; d < 3; ++d) {
        s.point.cell[d] = place.cell[d];
        s.point.base[d] = m.base[d];
      }
      const double nearer = mpdem::nearer_to_first(body, place.X);
      s.point.nearer = mpdem::nearer_side(body, nearer);
      s.point.middle = mpdem::in_the_middle(body, nearer);
      for (int n = 0; n < 6; ++n) s.point.space[n] = static_cast<float>(mpdem::space_ahead(place, body, n / 2, n % 2 == 0 ? -1 : 1));
      for (int g = 0; g < 2; ++g) {
        s.point.attached[g] = false;
        s.point.link_area[g] = 0.0;
      }
      for (int n = first_link[s.slot]; n < first_link[s.slot + 1]; ++n) {
        const mpdem::Link& k = points.links[n];
        const int g = k.grain == body.grain[0] ? 0 : 1;
        double across = 0.0;
        for (int d = 0; d < 3; ++d) across += (k.foot[d] - body.centre[g][d]) / body.radius[g] * axis[d];
        s.point.attached[g] = s.point.attached[g] || k.attached;
        s.point.link_area[g] += k.area * std::fabs(across);
      }
      out[m.body % comm->nprocs].push_back(s);
    }
  }
  WholeBodies whole;
  whole.sent = mpdem::all_to_all(world, out);
  whole.points.resize(wanted.size());
  for (const Sent& s : whole.sent.data) whole.points[s.body].push_back(s.point);
  return whole;
}

mpdem::Separation FixMpm::look_at(int body, const std::vector<mpdem::CrackPoint>& points) const {
  const mpdem::Body& b = avec_->bodies[body];
  double face[3];
  direction_of_centres(b, face);
  for (double& f : face) f = std::fabs(f) * b.spacing * b.spacing;
  return mpdem::separate(points, face, joined_nodes(body), mpdem::support(basis_), separation_[body].separated);
}

// Looks at bodies in which points failed: those whose path is cut, and what has come apart already,
// if debris. Collective. True if a part changed, or a body came apart that has ties or damping.
bool FixMpm::separate_bodies(bool debris) {
  if (law_->inert() || !coupled_) return false;
  mpdem::PointStore& points = avec_->points;
  const int bodies = static_cast<int>(avec_->bodies.size());
  std::vector<double> failed(bodies, 0.0);
  for (const mpdem::BlockMeta& m : points.meta) failed[m.body] += __builtin_popcount(m.failed);
  MPI_Allreduce(MPI_IN_PLACE, failed.data(), bodies, MPI_DOUBLE, MPI_SUM, world);
  separation_.resize(bodies);
  failed_seen_.resize(bodies, 0.0);
  path_.resize(bodies);
  path_cut_.resize(bodies, 0);
  MPI_Allreduce(MPI_IN_PLACE, path_cut_.data(), bodies, MPI_INT, MPI_MAX, world);
  std::vector<char> look(bodies);
  bool any = false;
  for (int b = 0; b < bodies; ++b) {
    look[b] = failed[b] != failed_seen_[b] && (separation_[b].separated ? debris : path_cut_[b] != 0);
    any = any || look[b];
    if (look[b]) failed_seen_[b] = failed[b];
  }
  path_cut_.assign(bodies, 0);
  any_path_cut_ = false;
  if (!any) return false;

  const WholeBodies whole = collect_bodies(look);

  // Here the bodies of this rank are whole.
  std::vector<std::vector<Returned>> back(comm->nprocs);
  std::vector<double> result(4 * bodies, 0.0);
  std::vector<mpdem::Separation> found(bodies);
  std::vector<std::vector<OfPath>> paths(comm->nprocs);
  for (int b = 0; b < bodies; ++b) {
    if (whole.points[b].empty()) continue;
    found[b] = look_at(b, whole.points[b]);
    for (int tag : found[b].path)
      for (auto& to : paths) to.push_back({b, tag});
    result[4 * b] = found[b].separated;
    result[4 * b + 1] = found[b].at_grain[0];
    result[4 * b + 2] = found[b].at_grain[1];
    result[4 * b + 3] = found[b].inside;
  }
  std::vector<std::size_t> at(bodies, 0);
  std::size_t n = 0;
  for (int r = 0; r < comm->nprocs; ++r)
    for (int i = 0; i < whole.sent.count[r]; ++i, ++n) {
      const Sent& s = whole.sent.data[n];
      const int part = found[s.body].part[at[s.body]++];
      // `updated` fragments may meet again, so they share their nodes
      if (part != s.point.part && !updated_) back[r].push_back({s.slot, part});
    }
  const std::vector<Returned> changed = mpdem::all_to_all(world, back).data;
  for (int b = 0; b < bodies; ++b)
    if (look[b]) path_[b].clear();
  for (const OfPath& p : mpdem::all_to_all(world, paths).data) path_[p.body].push_back(p.tag);
  MPI_Allreduce(MPI_IN_PLACE, result.data(), 4 * bodies, MPI_DOUBLE, MPI_SUM, world);
  bool lay_out = false;
  for (int b = 0; b < bodies; ++b) {
    if (!look[b]) continue;
    // The surface is that of the separation; what breaks later is debris.
    const bool was = separation_[b].separated;
    if (was || result[4 * b] == 0.0) continue;
    separation_[b].separated = true;
    lay_out = tied_ || relax_ > 0.0;
    separation_[b].at_grain[0] = result[4 * b + 1];
    separation_[b].at_grain[1] = result[4 * b + 2];
    separation_[b].inside = result[4 * b + 3];
  }

  parent_field_.clear();
  new_part_.clear();
  for (const Returned& r : changed) {
    const mpdem::BlockMeta& m = points.meta[r.slot / kLanes];
    if (r.part >= mpdem::kMaxPieces)
      mpdem::stop_one(lmp, text_of("fix mpm (id ", id, "): a bond broke into more than ", mpdem::kMaxPieces, " parts"));
    new_part_[r.slot] = mpdem::part_of(r.part, mpdem::sheet_of(m.part));
    // of both sheets: nodes of the other may come to this rank as masters of those of its own
    for (int sheet = 0; sheet < 2; ++sheet)
      parent_field_[mpdem::field_of(m.body, mpdem::part_of(r.part, sheet))] =
          mpdem::field_of(m.body, mpdem::part_of(mpdem::piece_of(m.part), sheet));
  }
  int mine = !changed.empty(), all;
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MAX, world);
  return all != 0 || lay_out;
}

std::string FixMpm::failure_mode(int body) const {
  if (body >= static_cast<int>(separation_.size()) || !separation_[body].separated) return "intact";
  return mode_of(separation_[body]);
}

// The same on all ranks.
void FixMpm::count_modes(Totals& t) const {
  t.separated = t.debonding = t.internal = t.mixed = 0.0;
  for (const mpdem::Separation& s : separation_) {
    if (!s.separated) continue;
    const std::string mode = mode_of(s);
    t.separated += 1.0;
    (mode == "debonding" ? t.debonding : mode == "internal" ? t.internal : t.mixed) += 1.0;
  }
}

// Of bodies that hold, their ligament and the separation that there would be without it. Collective.
std::vector<FixMpm::CrackAhead> FixMpm::cracks_ahead(const std::vector<char>& wanted) {
  const std::size_t bodies = wanted.size();
  const WholeBodies whole = collect_bodies(wanted);
  constexpr int kWords = 5;
  std::vector<double> found(kWords * bodies, 0.0);
  for (std::size_t b = 0; b < bodies; ++b) {
    const std::vector<mpdem::CrackPoint>& points = whole.points[b];
    if (points.empty()) continue;
    const int body = static_cast<int>(b);
    const mpdem::Ligament ligament = mpdem::find_ligament(points, joined_nodes(body), mpdem::support(basis_));
    double row[kWords] = {static_cast<double>(ligament.left()), static_cast<double>(ligament.whole)};
    for (const std::vector<int>& cut : ligament.cuts) {
      const mpdem::Separation s = look_at(body, mpdem::cut_through(cut, points));
      const double area[3] = {s.at_grain[0], s.at_grain[1], s.inside};
      for (int i = 0; i < 3; ++i) row[2 + i] += area[i] / static_cast<double>(ligament.cuts.size());
    }
    std::copy(row, row + kWords, &found[kWords * b]);
  }
  MPI_Allreduce(MPI_IN_PLACE, found.data(), static_cast<int>(found.size()), MPI_DOUBLE, MPI_SUM, world);
  std::vector<CrackAhead> ahead(bodies);
  for (std::size_t b = 0; b < bodies; ++b) {
    const double* row = &found[kWords * b];
    ahead[b].left = row[0];
    ahead[b].whole = row[1];
    for (int g = 0; g < 2; ++g) ahead[b].surface.at_grain[g] = row[2 + g];
    ahead[b].surface.inside = row[4];
  }
  return ahead;
}

// One line a bond, at the end of a run in which points have failed. Collective.
void FixMpm::report_modes() {
  constexpr std::size_t kMostLines = 20;
  const std::vector<BondState>& state = bonds();
  std::vector<char> told(state.size(), 0), holds(state.size(), 0);
  std::size_t lines = 0;
  for (std::size_t b = 0; b < std::min(state.size(), separation_.size()) && lines < kMostLines; ++b) {
    told[b] = state[b].failed != 0.0;
    holds[b] = told[b] && !separation_[b].separated;
    lines += told[b];
  }
  if (lines == 0) return;
  const std::vector<CrackAhead> ahead = cracks_ahead(holds);
  if (comm->me != 0) return;
  for (std::size_t b = 0; b < told.size(); ++b) {
    if (!told[b]) continue;
    std::string text = text_of("fix mpm (id ", id, "): bond ", b + 1, " of grains ", avec_->bodies[b].grain[0], " and ",
                               avec_->bodies[b].grain[1], ": ", failure_mode(static_cast<int>(b)), ", ", state[b].failed,
                               " points failed");
    if (!holds[b]) {
      text += shares_of(separation_[b]);
    } else {
      const CrackAhead& a = ahead[b];
      text += text_of("; ", a.whole > 0.0 ? 100.0 * a.left / a.whole : 0.0, " % of its weakest section is left (", a.left, " of ", a.whole,
                      " points), and a crack through that would be ", mode_of(a.surface), shares_of(a.surface));
    }
    for (FILE* f : {screen, logfile})
      if (f) std::fprintf(f, "%s\n", text.c_str());
  }
  if (lines == kMostLines) report_sum_of_modes(static_cast<int>(lines));
}

// Where not every bond has a line.
void FixMpm::report_sum_of_modes(int lines) {
  std::map<std::string, int> count;
  int damaged = 0;
  for (std::size_t b = 0; b < bonds_.size(); ++b) {
    if (bonds_[b].failed == 0.0) continue;
    ++count[failure_mode(static_cast<int>(b))];
    ++damaged;
  }
  if (damaged == lines) return;
  std::string text = text_of("fix mpm (id ", id, "): of ", bonds_.size(), " bonds points failed in ", damaged, ", the first ", lines,
                             " of which are listed:");
  const char* comma = " ";
  for (const auto& mode : count) {
    text += text_of(comma, mode.second, " ", mode.first);
    comma = ", ";
  }
  for (FILE* f : {screen, logfile})
    if (f) std::fprintf(f, "%s\n", text.c_str());
}

}  // namespace LAMMPS_NS
