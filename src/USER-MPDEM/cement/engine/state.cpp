// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Restart of the state that points and grains do not store. cement_restart.h has the records.
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <stdexcept>

#include "../../material/laws.h"
#include "../../parallel/agree.h"
#include "../../parallel/gather_ranks.h"
#include "cement.h"

namespace mpdem {

namespace {

// A number that differs if the rules differ, and 0 without rules. It is exact in text and in a double.
double number_of(const Scatter& scatter) {
  std::size_t hash = 0;
  for (const ScatterRule& r : scatter.rules)
    for (double v : {static_cast<double>(r.what), static_cast<double>(r.distribution), r.parameter, r.length, static_cast<double>(r.seed)})
      hash = (hash ^ std::hash<double>()(v)) * 0x9e3779b97f4a7c15ull + 1;
  return static_cast<double>(hash >> 32);
}

constexpr int kScatterValue = Law::kMostWords - 1;  // where DamageLawSettings has that number, behind the values of the law

DamageLawSettings law_of(const Law& law, const CementOptions& o) {
  DamageLawSettings now;
  now.law = law_number(law);
  const std::vector<double> values = law.values();
  std::copy(values.begin(), values.end(), now.value);
  if (static_cast<int>(values.size()) > kScatterValue) throw std::logic_error("no room for scatter beside the values of a law");
  now.value[kScatterValue] = number_of(law.scatter());
  now.length = law.length();
  now.energy = law.crack_energy();
  now.imperfection = o.imperfection;
  return now;
}

// Copies the options of the script to the head of a restart file.
void copy_options(CementHead& head, const CementOptions& o, const Law& law) {
  head.cell = o.cell;
  head.basis = o.basis;
  head.updated = o.updated;
  head.tied = o.tied;
  head.split = o.split;
  head.unilateral = o.unilateral;
  head.mass_scale = o.mass_scale;
  const VtiConstants& e = law.elasticity().constants;
  const double elastic[] = {e.Ep, e.Ez, e.nu_p, e.nu_zp, e.Gzp};
  std::copy(std::begin(elastic), std::end(elastic), head.elastic);
  head.law = law_of(law, o);
}

// Options that must not change once the cement has moved. rounding: allowed relative difference of the numbers.
struct KeptOption {
  std::string description;
  std::vector<double> numbers = {};
  double rounding = 0.0;
};

constexpr double kPrinted = 1e-5;  // relative rounding of printed numbers

std::vector<KeptOption> kept_options(const CementHead& h) {
  const double* e = h.elastic;
  return {
      {text_of("cell ", h.cell), {h.cell}},
      {text_of("basis ", name_of(h.basis))},
      {text_of("kinematics ", word_of(h.updated, "updated", "total"))},
      {text_of("elastic vti ", e[0], " ", e[1], " ", e[2], " ", e[3], " ", e[4]), {e, e + 5}, kPrinted},
      {text_of("quasistatic ", h.mass_scale, " Z"), {h.mass_scale}, kPrinted},
      {text_of("cracks ", word_of(h.split, "split", "bonds"))},
      {text_of("unilateral ", word_of(h.unilateral, "yes", "no"))},
      {text_of("edge ", word_of(h.tied, "tied", "free"))},
  };
}

bool same(const KeptOption& a, const KeptOption& b) {
  if (a.numbers.empty()) return a.description == b.description;
  return std::equal(a.numbers.begin(), a.numbers.end(), b.numbers.begin(),
                    [&](double x, double y) { return std::fabs(x - y) <= a.rounding * std::fabs(y); });
}

void check_kept(const CementHead& head, const CementOptions& o, const Law& law) {
  CementHead given;
  copy_options(given, o, law);
  const std::vector<KeptOption> now = kept_options(given), before = kept_options(head);
  for (std::size_t n = 0; n < now.size(); ++n)
    if (!same(now[n], before[n]))
      throw BadState(text_of("'", now[n].description, "' but the restart file was written with '", before[n].description,
                             "'; use that, since the load or the energy of the bonds would jump"));
}

}  // namespace

std::string Cement::changed_options_since(const CementHead& head) const {
  const DamageLawSettings now = law_of(*scene_.law, scene_.options), &was = head.law;
  const int known = static_cast<int>(law_entries().size());
  const NamedLaw& law = law_entries()[now.law - 1];
  if (was.law != now.law)
    return text_of("'damage ", law.name, "', was '",
                   was.law >= 1 && was.law <= known ? "damage " + law_entries()[was.law - 1].name : text_of("law ", was.law), "'");
  std::string all;
  const auto compare = [&](const std::string& word, double a, double b) {
    if (std::fabs(a - b) > kPrinted * std::max(std::fabs(a), std::fabs(b)))
      all += text_of(all.empty() ? "'" : ", '", word, "' ", a, ", was ", b);
  };
  for (std::size_t n = 0; n < law.words.size(); ++n) compare(law.words[n].name, now.value[n], was.value[n]);
  if (now.value[kScatterValue] != was.value[kScatterValue]) all += text_of(all.empty() ? "" : ", ", "the words of 'scatter'");
  compare("regularization nonlocal", now.length, was.length);
  compare("energy", now.energy, was.energy);
  compare("imperfection", now.imperfection, was.imperfection);
  return all;
}

std::vector<double> Cement::packed_state(CementHead head) {
  copy_options(head, scene_.options, *scene_.law);
  head.step = scene_.dt_last;
  head.rows_started = scene_.rows_started;
  head.start_energy = scene_.energy.start_energy();
  head.energy = scene_.energy.gather_on_first(scene_.comm);
  head.eigenvalue = stable_step_.known_eigenvalue();
  std::vector<double> mine_of_copies;
  for (const auto& row : discontinuities_.splits->rows_to_keep(scene_.comm))
    for (const PhantomNodes::Entry& e : row.second)
      append(
          PhantomNodeRow{
              row_of(row.first.field()), {row.first.at(0), row.first.at(1), row.first.at(2)}, e.layer, e.copy, e.first, e.volume},
          mine_of_copies);
  const std::vector<double> copies = gather_on_first(scene_.comm, mine_of_copies);
  head.density = scene_.density();
  head.copies = static_cast<int>(copies.size() / kMostNumbers<PhantomNodeRow>);
  head.rows = static_cast<int>(scene_.bonds().table.size());
  head.nodes = nodes_to_pack(scene_);
  const std::vector<LooseCement::Loose> loose = departures_.loose_cement().times();
  head.loose = {static_cast<int>(loose.size()), departures_.loose_cement().clock(), static_cast<double>(departures_.loose_cement().step())};
  std::vector<double> all = {CementHead::kVersion};
  append(head, all);
  const std::vector<double> peaks = report_.peaks();
  LoadHistory& watch = topology_.load_history();
  watch.add_bonds(peaks.size());
  const std::vector<LoadHistory::Sums> loads = watch.gather_on_first(scene_.comm);
  for (std::size_t r = 0; r < peaks.size(); ++r) {
    const Cracks::State s = r < cracks().size() ? cracks()[r] : Cracks::State();
    BondRow row{s.broken_seen,   s.separation, peaks[r], static_cast<double>(s.broken_at), scene_.fragments.has(static_cast<int>(r)),
                watch.largest(r)};
    std::copy(loads[r].begin(), loads[r].end(), row.loads);
    append(row, all);
  }
  all.insert(all.end(), copies.begin(), copies.end());
  for (const LooseCement::Loose& l : loose) append(LooseRow{l.row, l.tag, l.since}, all);
  const std::vector<double> of_contact = contact_.packed(scene_.comm);
  all.insert(all.end(), of_contact.begin(), of_contact.end());
  return all;
}

// Reads the rows of bonds that follow the head.
void Cement::restore_bonds(int bond_rows, RecordReader& in) {
  const int me = rank_in(scene_.comm);
  std::vector<Cracks::State> cracks(bond_rows);
  std::vector<LoadHistory::Largest> largest(bond_rows);
  std::vector<LoadHistory::Sums> loads(bond_rows, LoadHistory::Sums{});
  std::vector<double> peaks(bond_rows);
  for (int r = 0; r < bond_rows; ++r) {
    BondRow row;
    in.read(row);
    cracks[r].broken_seen = row.broken_seen;
    cracks[r].separation = row.separation;
    peaks[r] = row.peak;
    cracks[r].broken_at = static_cast<std::int64_t>(row.broken_at);
    largest[r] = row.largest;
    if (row.released) scene_.fragments.add_rows({r});
    if (me == 0) std::copy(row.loads, row.loads + LoadHistory::kSums, loads[r].begin());
  }
  report_.restore(peaks);
  topology_.load_history().restore(std::move(largest), std::move(loads));
  cracks.resize(scene_.rows_started);  // the others have had no check yet
  discontinuities_.cracks.restore(std::move(cracks));
}

// The table may have more rows than the file, since cement may be new.
void Cement::restore(const CementHead& head, RecordReader& in, const std::vector<double>& nodes) {
  check_kept(head, scene_.options, *scene_.law);
  const std::size_t table = scene_.bonds().table.size();
  scene_.dt_last = head.step;
  scene_.rows_started = head.rows_started;
  scene_.scaled_density = scene_.options.mass_scale * head.density;
  discontinuities_.splits->set_density(scene_.inertia());
  stable_step_.restore(head.eigenvalue);
  restored_ = true;
  const int me = rank_in(scene_.comm);
  scene_.energy.restore(me == 0 ? head.energy : EnergyBalance::Sums(), head.start_energy);
  restore_bonds(head.rows, in);
  std::vector<NodeRow> rows(nodes.size() / kMostNumbers<NodeRow>);
  RecordReader of_points(nodes.data(), nodes.data() + nodes.size());
  for (NodeRow& row : rows) {
    of_points.read(row);
    in.check_whole("the bond of a node", row.row, from(0, static_cast<double>(table) - 1.0));
  }
  in.tell(of_points.trouble());
  std::map<Key, PhantomNodes::Row> copies;
  for (int n = 0; n < head.copies; ++n) {
    PhantomNodeRow row;
    in.read(row);
    in.check_whole("the bond of a split node", row.row, from(0, static_cast<double>(table) - 1.0));
    copies[{field_of(row.row, 0), row.index}].push_back({row.layer, row.copy, row.first, row.volume});
  }
  std::vector<LooseCement::Loose> loose;
  for (int n = 0; n < head.loose.rows; ++n) {
    LooseRow row;
    in.read(row);
    in.check_whole("the bond of a loose point", row.row, from(0, static_cast<double>(table) - 1.0));
    loose.push_back({row.row, row.tag, row.since});
  }
  contact_.restore(in, me == 0);
  name_fragments();
  if (!in.trouble().empty()) return;
  departures_.loose_cement().restore(head.loose.time, static_cast<std::int64_t>(head.loose.step), loose);
  discontinuities_.splits->restore(head.rows_started, std::move(copies));
  restored_nodes_.keep(std::move(rows), head.nodes);
}

}  // namespace mpdem
