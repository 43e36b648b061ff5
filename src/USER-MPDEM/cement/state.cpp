// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// State of the cement that points and grains do not hold, for restart files. cement_restart.h has its records.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>

#include "../material/laws.h"
#include "../parallel/agree.h"
#include "../parallel/gather_ranks.h"
#include "cement.h"

namespace mpdem {

namespace {

std::array<double, 5> numbers_of(const VtiConstants& e) { return {e.Ep, e.Ez, e.nu_p, e.nu_zp, e.Gzp}; }

std::string words_of(const double* e) { return text_of("elastic vti ", e[0], " ", e[1], " ", e[2], " ", e[3], " ", e[4]); }

void check_restored(const CementHead& head, const CementOptions& o, const VtiConstants& elastic) {
  const auto edge = [](bool t) { return t ? "tied" : "free"; };
  const auto name = [](bool u) { return u ? "updated" : "total"; };
  if (head.cell != o.cell)
    throw BadState(text_of("'cell ", o.cell, "' but the restart file was written with cell ", head.cell, "; use that"));
  if (head.basis != o.basis || head.updated != o.updated)
    throw BadState(text_of("'basis ", name_of(o.basis), "' and 'kinematics ", name(o.updated),
                           "' but the motion of the nodes in the restart file is that of basis ", name_of(head.basis),
                           " and kinematics ", name(head.updated), "; use these"));
  const auto differ = [](double a, double b) { return std::fabs(a - b) > 1e-5 * std::fabs(b); };  // beyond the rounding of printed numbers
  const std::array<double, 5> now = numbers_of(elastic);
  if (!std::equal(now.begin(), now.end(), head.elastic, std::not_fn(differ)))
    throw BadState(text_of("'", words_of(now.data()), "' but the cement of the steps before has '", words_of(head.elastic), "', and the load of the bonds would jump; use that"));
  if (differ(o.mass_scale, head.mass_scale))
    throw BadState(text_of("inertia ", o.mass_scale, " times that of the calcite but it was ", head.mass_scale, " times in the steps before, and energy would come of nothing; use 'quasistatic ",
                           head.mass_scale, "' and its damping", head.mass_scale == 1.0 ? ", or no 'quasistatic'" : ""));
  const auto cracks = [](bool split) { return split ? "split" : "bonds"; };
  if (head.split != o.split)
    throw BadState(text_of("'cracks ", cracks(o.split), "' but the restart file was written with 'cracks ", cracks(head.split), "'; use that"));
  const auto yes = [](bool u) { return u ? "yes" : "no"; };
  if (head.unilateral != o.unilateral)
    throw BadState(text_of("'unilateral ", yes(o.unilateral), "' but the restart file was written with 'unilateral ", yes(head.unilateral), "'; use that"));
  if (head.tied != o.tied)
    throw BadState(text_of("nodes at the edge are ", edge(o.tied), " but were ", edge(head.tied), " when the restart file was written; use 'edge ",
                           edge(head.tied), "' and the kinematics and re-projection of that run"));
}

LawSoFar law_of(const Law& law, const CementOptions& o) {
  LawSoFar now;
  now.law = law_number(law);
  const std::vector<double> values = law.values();
  std::copy(values.begin(), values.end(), now.value);
  now.length = law.length();
  now.energy = law.crack_energy();
  now.imperfection = o.imperfection;
  return now;
}

}  // namespace

std::string Cement::other_words_than(const CementHead& head) const {
  const LawSoFar now = law_of(*scene_.law, scene_.options), &was = head.law;
  const int known = static_cast<int>(law_entries().size());
  const NamedLaw& law = law_entries()[now.law - 1];
  if (was.law != now.law)
    return text_of("'damage ", law.name, "', was '", was.law >= 1 && was.law <= known ? "damage " + law_entries()[was.law - 1].name : text_of("law ", was.law), "'");
  std::string all;
  const auto compare = [&](const std::string& word, double a, double b) {
    if (std::fabs(a - b) > 1e-5 * std::max(std::fabs(a), std::fabs(b))) all += text_of(all.empty() ? "'" : ", '", word, "' ", a, ", was ", b);
  };
  for (std::size_t n = 0; n < law.words.size(); ++n) compare(law.words[n].name, now.value[n], was.value[n]);
  compare("regularization nonlocal", now.length, was.length);
  compare("energy", now.energy, was.energy);
  compare("imperfection", now.imperfection, was.imperfection);
  return all;
}

std::vector<double> Cement::packed_state(CementHead head) {
  head.cell = scene_.options.cell;
  head.basis = scene_.options.basis;
  head.updated = scene_.options.updated;
  head.tied = scene_.options.tied;
  head.step = scene_.dt_last;
  head.bodies_started = scene_.bodies_started;
  head.start_energy = scene_.books.start_energy();
  head.books = scene_.books.gather_on_first(scene_.comm);
  head.eigenvalue = stable_step_.known_eigenvalue();
  std::vector<double> mine_of_copies;
  for (const auto& row : divisions_.splits.rows_to_keep(scene_.comm))
    for (const NodeCopies::Entry& e : row.second)
      append(CopyRow{body_of(row.first.field()), {row.first.at(0), row.first.at(1), row.first.at(2)}, e.part, e.copy, e.first, e.volume}, mine_of_copies);
  const std::vector<double> copies = gather_on_first(scene_.comm, mine_of_copies);
  head.split = scene_.options.split;
  head.unilateral = scene_.options.unilateral;
  const std::array<double, 5> elastic = numbers_of(scene_.law->elasticity().constants);
  std::copy(elastic.begin(), elastic.end(), head.elastic);
  head.law = law_of(*scene_.law, scene_.options);
  head.mass_scale = scene_.options.mass_scale;
  head.density = scene_.density();
  head.copies = static_cast<int>(copies.size() / kMostNumbers<CopyRow>);
  head.bodies = static_cast<int>(scene_.bonds().table.size());
  head.nodes = nodes_to_pack(scene_);
  std::vector<double> all = {CementHead::kVersion};
  append(head, all);
  const std::vector<double> peaks = report_.peaks();
  LoadWatch& watch = parting_.load_watch();
  watch.take_up(peaks.size());
  const std::vector<LoadWatch::Sums> loads = watch.gather_on_first(scene_.comm);
  for (std::size_t r = 0; r < peaks.size(); ++r) {
    const Cracks::State s = r < cracks().size() ? cracks()[r] : Cracks::State();
    BondRow row{s.broken_seen, s.separation, peaks[r], static_cast<double>(s.broken_at), watch.largest(r)};
    std::copy(loads[r].begin(), loads[r].end(), row.loads);
    append(row, all);
  }
  all.insert(all.end(), copies.begin(), copies.end());
  return all;
}

// Reads the rows of bonds that follow the head. Bonds that made no step yet are new to the looks for cracks, and to the nodes that split.
void Cement::restore_bonds(int bodies, RecordReader& in) {
  const int me = rank_in(scene_.comm);
  std::vector<Cracks::State> cracks(bodies);
  std::vector<LoadWatch::Largest> largest(bodies);
  std::vector<LoadWatch::Sums> loads(bodies, LoadWatch::Sums{});
  std::vector<double> peaks(bodies);
  for (int r = 0; r < bodies; ++r) {
    BondRow row;
    in.read(row);
    cracks[r].broken_seen = row.broken_seen;
    cracks[r].separation = row.separation;
    peaks[r] = row.peak;
    cracks[r].broken_at = static_cast<std::int64_t>(row.broken_at);
    largest[r] = row.largest;
    if (me == 0) std::copy(row.loads, row.loads + LoadWatch::kSums, loads[r].begin());
  }
  report_.restore(peaks);
  parting_.load_watch().restore(std::move(largest), std::move(loads));
  cracks.resize(scene_.bodies_started);  // the first look at the others is still to come
  divisions_.cracks.restore(std::move(cracks));
}

// Cement may have been made since the file was written.
void Cement::restore(const CementHead& head, RecordReader& in, const std::vector<double>& nodes) {
  check_restored(head, scene_.options, scene_.law->elasticity().constants);
  const std::size_t table = scene_.bonds().table.size();
  scene_.dt_last = head.step;
  scene_.bodies_started = head.bodies_started;
  scene_.inertia = scene_.options.mass_scale * head.density;
  stable_step_.restore(head.eigenvalue);
  restored_ = true;
  const int me = rank_in(scene_.comm);
  scene_.books.restore(me == 0 ? head.books : EnergyBooks::Sums(), head.start_energy);
  restore_bonds(head.bodies, in);
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
  divisions_.splits.restore(head.bodies_started, std::move(copies));
  restored_nodes_.keep(std::move(rows), head.nodes);
}

}  // namespace mpdem
