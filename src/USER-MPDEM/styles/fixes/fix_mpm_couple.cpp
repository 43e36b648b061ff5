// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "fix_mpm_couple.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "../words/arguments.h"
#include "atom.h"
#include "../guards/cement_checks.h"
#include "../words/fix_mpm_words.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "files_in_use.h"
#include "../guards/host_guards.h"
#include "../words/keywords.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::text_of;
using namespace FixConst;

namespace {

// `kn auto` and `kt auto`, over C33 of the cement. Links of this stiffness hardly soften a bond (test_stiffness.py).
constexpr double kAutoOverC33 = 200.0;
// The stiffness of contact points is at most this times C33 over a cell. Links are stiffer, since the stiffness of the
// bond depends on them. Contact should need little added mass, so that impacts dissipate little energy
// (PenaltyParameters::max_contact_stiffness).
constexpr double kContactOverC33 = 5.0;
constexpr double kMostFriction = 100.0;  // with more, rounding of the pressure would be a force

constexpr double kLeastPoisson = -0.99, kMostPoisson = 0.499;

using Words = mpdem::CouplingOptions;  // the options that the words of the command give
using CoupleKeyword = mpdem::Keyword<Words>;

double stiffness(Arguments& args, const CoupleKeyword& k) { return args.accept("auto") ? -1.0 : args.positive(k.name, " or 'auto'"); }

mpdem::GrainElasticity elasticity(Arguments& args, const std::string& keyword) {
  const std::vector<double> v = args.numbers(
      keyword, {{"E", "Young's modulus", 0.0, 0.0, true}, {"nu", "Poisson's ratio", kLeastPoisson, kMostPoisson}}, "7e10 0.25");
  return {v[0], v[1]};
}

std::vector<mpdem::ElasticType> elastic_types(Arguments& args) {
  std::vector<mpdem::ElasticType> types{{0, elasticity(args, "grains elastic")}};
  for (;;) {
    const bool own = args.accept("type");
    if (!own && !args.accept("rigid")) return types;
    const int type = args.integer(own ? "type" : "rigid", 1);
    types.push_back({type, own ? elasticity(args, text_of("type ", type)) : mpdem::GrainElasticity()});
  }
}

const std::vector<CoupleKeyword>& couple_keywords() {
  using mpdem::traction_entries;
  static const std::vector<CoupleKeyword> all = {
      {"kn", "auto or pressure", "auto", [](Arguments& args, const CoupleKeyword& k, Words& w) { w.kn = stiffness(args, k); }},
      {"kt", "auto or pressure", "auto", [](Arguments& args, const CoupleKeyword& k, Words& w) { w.kt = stiffness(args, k); }},
      {"length", "cell or length", "cell",
       [](Arguments& args, const CoupleKeyword& k, Words& w) {
         w.length = args.accept("cell") ? -1.0 : args.positive(k.name, " or 'cell'");
       }},
      {"at", "surface or points", "surface",
       [](Arguments& args, const CoupleKeyword& k, Words& w) { w.at_surface = k.is(args, "surface"); }},
      {"damping", "ratio", "0",
       [](Arguments& args, const CoupleKeyword& k, Words& w) {
         w.damping = args.between(k.name, 0.0, mpdem::kMostDamping, "share of critical damping");
       }},
      {"interface", mpdem::names_listed(traction_entries()), "penalty",
       [](Arguments& args, const CoupleKeyword& k, Words& w) { w.interface = mpdem::read_choice(args, k.name, traction_entries()); }},
      {"friction", "mu", "",
       [](Arguments& args, const CoupleKeyword& k, Words& w) {
         w.friction = args.between(k.name, 0.0, kMostFriction, "coefficient of friction");
       }},
      {"grains", "rigid or elastic E nu [type T E nu] [rigid T]", "rigid",
       [](Arguments& args, const CoupleKeyword& k, Words& w) {
         w.grains = args.choice(k.name, {"rigid", "elastic"}) == "elastic" ? elastic_types(args) : std::vector<mpdem::ElasticType>();
       }},
      {"csv", "N file", "",
       [](Arguments& args, const CoupleKeyword& k, Words& w) {
         w.table_every = args.integer(k.name, 1);
         w.table_name = args.word("a file name for 'csv'");
       }},
  };
  return all;
}

}  // namespace

FixMpmCouple::FixMpmCouple(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg) {
  Arguments args(lmp, text_of("fix mpm/couple (id ", id, ")"), narg, arg, 3);
  scalar_flag = vector_flag = array_flag = 1;
  size_vector = size_array_cols = static_cast<int>(mpdem::bond_columns().size());
  global_freq = 1;
  extscalar = extvector = extarray = 0;  // values of a bond are not divided by the number of atoms
  cement_id_ = args.word("the ID of a fix mpm");
  cement_ = find_cement();
  if (!cement_) args.complain("'" + cement_id_ + "' is not a fix mpm; define that fix before and name its ID here");
  count_bonds();
  said_ = mpdem::parse_keywords(args, couple_keywords(), words_, [&](const std::string& key) {
    std::vector<std::string> known = mpdem::names_of(couple_keywords());
    for (const std::string& word : mpdem::law_words("interface", mpdem::traction_entries())) known.push_back(word);
    args.unknown(key, known);
  });
}

std::string FixMpmCouple::listed_words() { return mpdem::listed("fix mpm/couple", couple_keywords()); }

// Scripts refer to row [1] before there are bonds.
void FixMpmCouple::count_bonds() { size_array_rows = std::max<int>(1, static_cast<int>(AtomVecMpdem::of(lmp)->bonds.table.size())); }

FixMpm* FixMpmCouple::find_cement() const {
  for (int i = 0; i < modify->nfix; ++i) {
    Fix* fix = modify->fix[i];
    if (fix && cement_id_ == fix->id) return dynamic_cast<FixMpm*>(fix);  // null for a fix that is being replaced
  }
  return nullptr;
}

// Finds the fix again, since fixes may come and go between runs.
void FixMpmCouple::take_cement() {
  cement_ = find_cement();
  if (!cement_) mpdem::stop_all(lmp, text_of("fix mpm/couple (id ", id, "): fix mpm '", cement_id_, "' is gone; unfix this one too"));
}

int FixMpmCouple::setmask() { return END_OF_STEP; }

void FixMpmCouple::init() {
  take_cement();
  count_bonds();
  const double per_length = 1.0 / (words_.length < 0.0 ? cement_->cell() : words_.length);
  mpdem::PenaltyParameters p;
  p.law = traction_laws(per_length);
  mpdem::check_links(lmp, text_of("fix mpm/couple (id ", id, "): "), *cement_->cement(), *p.law);
  warn_of_length(*p.law);
  check_rounding("kn", words_.kn, per_length);
  check_rounding("kt", words_.kt, per_length);
  p.damping = words_.damping;
  p.at_surface = words_.at_surface;
  p.friction = words_.friction;
  p.max_contact_stiffness = kContactOverC33 * cement_->law().elasticity().C33 / cement_->cell();
  cement_->set_grains(this, elastic_grains());
  cement_->set_coupling(this, p, said_);

  mpdem::HostView view{
      lmp, text_of("fix mpm/couple (id ", id, "): "), cement_->cement(), cement_, &cement_->engine(), cement_->points_are_wanted()};
  view.couple = this;
  mpdem::check_host(mpdem::kCoupling | (update->nsteps > 0 ? mpdem::kSteps : 0u), view);  // `run 0` moves nothing

  open_table();
}

// Collective. Grains of each bond.
std::vector<mpdem::ElasticPair> FixMpmCouple::elastic_grains() const {
  const std::vector<mpdem::BondRecord>& table = cement_->cement()->bonds.table;
  std::vector<mpdem::ElasticPair> found(table.size());
  if (words_.grains.empty()) return found;
  std::vector<mpdem::GrainElasticity> of_types(static_cast<std::size_t>(atom->ntypes) + 1, words_.grains.front().elasticity);
  for (const mpdem::ElasticType& t : words_.grains) {
    if (t.type > atom->ntypes)
      mpdem::stop_all(lmp, text_of("fix mpm/couple (id ", id, "): 'grains' names atom type ", t.type, ", but the scene has types 1 to ",
                                   atom->ntypes, "; use one of these"));
    of_types[static_cast<std::size_t>(t.type)] = t.elasticity;
  }
  std::vector<int> types(2 * table.size(), 0);
  for (std::size_t n = 0; n < types.size(); ++n) {
    const int i = atom->map(table[n / 2].grain[n % 2]);
    if (i >= 0 && i < atom->nlocal) types[n] = atom->type[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, types.data(), static_cast<int>(types.size()), MPI_INT, MPI_MAX, world);
  for (std::size_t n = 0; n < types.size(); ++n) {
    const mpdem::BondRecord& b = table[n / 2];
    // A grain that left the scene keeps the elasticity in the record of the bond.
    found[n / 2][n % 2] =
        types[n] > 0 ? of_types[static_cast<std::size_t>(types[n])] : mpdem::GrainElasticity{b.grain_E[n % 2], b.grain_nu[n % 2]};
  }
  return found;
}

// Makes the law of the links, and those of other materials.
std::shared_ptr<const mpdem::TractionLaw> FixMpmCouple::traction_laws(double per_length) const {
  const auto made = [&](int material, const mpdem::Choice<mpdem::TractionEntry>& choice, const std::string& who) {
    const mpdem::Law& of_cement = cement_->law().of_material(material);
    const double automatic = kAutoOverC33 * of_cement.elasticity().C33;
    std::shared_ptr<mpdem::TractionLaw> law = choice.make(mpdem::TractionStiffness{(words_.kn < 0.0 ? automatic : words_.kn) * per_length,
                                                                                   (words_.kt < 0.0 ? automatic : words_.kt) * per_length});
    const std::string wrong = law->trouble();
    if (!wrong.empty()) mpdem::stop_all(lmp, text_of(who, ": 'interface ", law->name(), "': ", wrong));
    law->set_scatter(of_cement.scatter());
    return law;
  };
  const std::shared_ptr<mpdem::TractionLaw> law = made(0, words_.interface, text_of("fix mpm/couple (id ", id, ")"));
  std::vector<std::shared_ptr<const mpdem::TractionLaw>> others;
  for (const mpdem::MaterialWords& m : cement_->materials()) {
    if (m.interface && m.interface->entry != words_.interface.entry)
      mpdem::stop_all(lmp,
                      text_of(m.who(), ": 'interface ", m.interface->entry->name, "', but fix mpm/couple (id ", id, ") has 'interface ",
                              words_.interface.entry->name, "': all cements of a scene have one traction law, with numbers of their own"));
    others.push_back(made(static_cast<int>(others.size()) + 1, m.interface ? *m.interface : words_.interface, m.who()));
  }
  law->set_materials(std::move(others));
  return law;
}

// Warns if cells do not resolve the length over which an interface with strength and fracture energy softens.
void FixMpmCouple::warn_of_length(const mpdem::TractionLaw& law) {
  if (length_reported_ || comm->me != 0) return;
  length_reported_ = true;
  constexpr double kLeastCells = 2.0;
  const double cell = cement_->cell();
  for (const mpdem::SofteningLength& s : law.softening_lengths(cement_->law().elasticity().constants))
    if (s.length < kLeastCells * cell)
      mpdem::warn(
          lmp,
          text_of("fix mpm/couple (id ", id, "): 'interface ", law.name(), "' softens over ", s.formula, " = ", s.length, ", less than ",
                  kLeastCells, " cells of ", cell, ", so that peak and energy of a bond go with the cell; use 'cell ",
                  s.length / kLeastCells, "' or less, or ", s.cure),
          "fix mpm/couple");
}

// Stops if the stiffness k turns the rounding of positions into a stress that matters beside those of the cement. `most` is
// the stiffness at which an error of rounding is a stress of kMostStrain C33, but at least that of `auto`.
void FixMpmCouple::check_rounding(const char* keyword, double given, double per_length) const {
  constexpr double kMostStrain = 1e-6;  // largest strain of the cement due to a rounding error
  double far = 0.0;
  for (int d = 0; d < 3; ++d) far = std::max({far, std::fabs(domain->boxlo[d]), std::fabs(domain->boxhi[d])});
  const double C33 = cement_->law().elasticity().C33, cell = cement_->cell(), length = 1.0 / per_length;
  const double k = given < 0.0 ? kAutoOverC33 * C33 : given;
  const double most = std::max(kAutoOverC33 / cell, kMostStrain / (std::numeric_limits<double>::epsilon() * far)) * C33 * length;
  if (k <= most) return;
  const std::string over = words_.length < 0.0 ? "" : text_of(" over 'length ", words_.length, "'");
  const std::string cure = given < 0.0 || length < cell
                               ? text_of("leave 'length' out, which is the cell, ", cell, ", or use at least ", length * k / most)
                               : text_of("use '", keyword, " auto', which is ", kAutoOverC33, " C33, or at most ", most);
  mpdem::stop_all(lmp, text_of("fix mpm/couple (id ", id, "): '", keyword, given < 0.0 ? std::string(" auto'") : text_of(" ", given, "'"),
                               over, " is ", k / C33, " times the stiffness of the cement, C33 ", C33,
                               words_.length < 0.0 ? "" : text_of(", over ", length / cell, " of a cell"),
                               ", so that the rounding of positions would load the bonds; ", cure));
}

// A run that continues keeps the rows of the runs before it, in this process or before the restart. It keeps the row of the
// last step, too: velocities at the set-up of a run are those of the middle of a step, so a row that it writes would differ.
void FixMpmCouple::open_table() {
  if (words_.table_every == 0) return;
  const std::string who = text_of("fix mpm/couple (id ", id, "): ");
  mpdem::check_only_writer(lmp, who, "csv", words_.table_name, this);
  if (table_open_) return;
  std::string header = "step,time,bond,grain1,grain2", trouble;
  for (const mpdem::BondColumn& c : mpdem::bond_columns()) header += text_of(",", c.name);
  if (comm->me == 0)
    trouble = table_.open(words_.table_name, header + ",mode",
                          // half a step, so that rounding of the time does not remove the last row
                          cement_->in_motion() ? update->get_cur_time() + 0.5 * update->dt : mpdem::TableFile::kAnew);
  stop_if_not_written(trouble);
  table_open_ = true;
  int kept = comm->me == 0 && table_.kept_to() == static_cast<long>(update->ntimestep);
  MPI_Bcast(&kept, 1, MPI_INT, 0, world);
  if (kept) table_last_ = update->ntimestep;
}

// Collective. trouble: why the file was not written, or an empty text.
void FixMpmCouple::stop_if_not_written(const std::string& trouble) {
  mpdem::stop_if_any(lmp, trouble.empty() ? trouble
                                          : text_of("fix mpm/couple (id ", id, "): cannot write 'csv' file ", trouble,
                                                    "; name another, or use a disk with free space"));
}

// Writes a row before the first step.
void FixMpmCouple::setup(int) { end_of_step(); }

void FixMpmCouple::end_of_step() {
  if (words_.table_every > 0 && update->ntimestep % words_.table_every == 0) write_table();
}

void FixMpmCouple::write_table() {
  if (table_last_ == update->ntimestep) return;
  table_last_ = update->ntimestep;
  const int bonds = static_cast<int>(cement_->bonds().size());
  cement_->totals_with_contacts();
  std::string trouble;
  if (comm->me == 0) {
    std::string rows;
    for (int b = 0; b < bonds; ++b) {
      const mpdem::BondRecord& record = cement_->cement()->bonds.table[b];
      mpdem::append(rows, BIGINT_FORMAT ",%.10g,%d,%d,%d", update->ntimestep, update->get_cur_time(), b + 1, record.grain[0],
                    record.grain[1]);
      for (int c = 0; c < size_array_cols; ++c) mpdem::append(rows, ",%.10g", value(b, c));
      rows += "," + cement_->failure_mode(b) + "\n";
    }
    trouble = table_.write(rows);
  }
  stop_if_not_written(trouble);
}

// Collective, unless the value was found at this step already.
double FixMpmCouple::value(int bond_row, int column) {
  const mpdem::BondColumn& c = mpdem::bond_columns()[column];
  if (c.of_all()) return c.value(c.needs_contacts() ? cement_->totals_with_contacts() : cement_->totals());
  return c.value((c.needs_points() ? cement_->bonds() : cement_->loads())[bond_row]);
}

// Variables and thermo output may ask between runs, when there is no fix mpm or no cement.
void FixMpmCouple::check_bond(int bond_row) {
  take_cement();
  const std::size_t bonds = cement_->cement()->bonds.table.size();
  if (static_cast<std::size_t>(bond_row) >= bonds)
    mpdem::stop_all(lmp, text_of("fix mpm/couple (id ", id, "): bond ", bond_row + 1, " was asked for, but there are ", bonds,
                                 "; use create_cement first, or a number up to that"));
}

double FixMpmCouple::compute_scalar() {
  check_bond(0);
  return cement_->loads()[0].tension;
}

double FixMpmCouple::compute_vector(int n) {
  check_bond(0);
  return value(0, n);
}

double FixMpmCouple::compute_array(int row, int column) {
  check_bond(row);
  return value(row, column);
}

}  // namespace LAMMPS_NS
