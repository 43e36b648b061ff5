// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "fix_mpm.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "../../cement/engine/cement_values.h"
#include "../../parallel/huge_pages.h"
#include "../../parallel/memory_limit.h"
#include "../words/arguments.h"
#include "atom.h"
#include "../guards/cement_checks.h"
#include "../words/fix_mpm_words.h"
#include "comm.h"
#include "files_in_use.h"
#include "fix_gravity.h"
#include "../guards/host_guards.h"
#include "../atoms/coated_contacts.h"
#include "../atoms/local_atom.h"
#include "modify.h"
#include "output.h"
#include "../atoms/point_atoms.h"
#include "../atoms/private_access.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::kLanes;
using mpdem::text_of;
using namespace FixConst;

namespace {
constexpr int kReportEvery = 5;  // steps between checks for grains that are lost or jump
}  // namespace

FixMpm::FixMpm(LAMMPS* lmp, int narg, char** arg)
    : Fix(lmp, narg, arg),
      avec_(AtomVecMpdem::of(lmp)),
      atoms_(lmp, who()),
      contacts_(lmp),
      hidden_(lmp),
      ranks_(lmp),
      leaving_(lmp, who()) {
  time_integrate = 1;
  restart_global = 1;
  force_reneighbor = 1;  // LIGGGHTS exchanges atoms at the step next_reneighbor
  next_reneighbor = -1;
  scalar_flag = vector_flag = 1;
  size_vector = static_cast<int>(mpdem::cement_values().size());
  global_freq = 1;
  extscalar = extvector = 0;  // intensive, since `thermo_modify norm yes` would divide by the number of grains and points
  mpdem::Arguments args(lmp, text_of("fix mpm (id ", id, ")"), narg, arg, 3);
  if (!avec_) args.complain(text_of("atom style '", atom->atom_style, "' cannot hold material points; use 'atom_style mpdem'"));
  const mpdem::ParsedOptions words = mpdem::parse_cement_words(args);
  for (const std::string& note : words.notes) mpdem::tell(lmp, who() + note + "\n");
  step_ = std::make_unique<mpdem::AutoStep>(lmp, who(), words.step_fraction);
  words_ = words.said;
  law_words_ = words.law_words;
  law_ = words.law;
  coupling_.need(words.needs_coupling);
  failures_.name(words.events);
  cement_ = std::make_unique<mpdem::Cement>(world, avec_->bonds, words.options, words.law, static_cast<mpdem::CementHost&>(*this));
  report_ = std::make_unique<mpdem::CementReport>(lmp, who());
  watch_ = std::make_unique<mpdem::QuasistaticWatch>(lmp, who(), words.kinetic_share);
}

// A restart file that is written after this has no nodes of the cement.
FixMpm::~FixMpm() {
  if (avec_) avec_->forget_nodes();
}

// Makes LIGGGHTS set up the next run, also with `pre no`, so that the atom style finds that its cement has no fix.
void FixMpm::pre_delete(bool by_script) {
  if (by_script) update->first_update = 0;
}

std::string FixMpm::who() const { return text_of("fix mpm (id ", id, "): "); }

mpdem::StepInput FixMpm::step_input() const {
  mpdem::StepInput now;
  now.number = update->ntimestep;
  now.substeps = substeps();
  now.dt = update->dt / now.substeps;
  for (FixGravity* fix : gravities_) {
    double g[3];
    fix->get_gravity(g);
    for (int d = 0; d < 3; ++d) now.gravity[d] += g[d];
  }
  return now;
}

int FixMpm::setmask() {
  return PRE_INITIAL_INTEGRATE | INITIAL_INTEGRATE | POST_INTEGRATE | PRE_EXCHANGE | PRE_NEIGHBOR | POST_FORCE | PRE_FINAL_INTEGRATE |
         FINAL_INTEGRATE | END_OF_STEP | POST_RUN;
}

// Commands between runs call this too, and it loses the state of the grains at the last step. So LIGGGHTS has to set up
// the next run, also with `pre no`, until setup() sets the flag again. It does not set up the intervals of a run with
// `every`, see check_unprepared().
void FixMpm::init() {
  update->first_update = 0;
  const mpdem::CementOptions& o = cement_->options();
  const std::vector<mpdem::BondRecord>& table = avec_->bonds.table;
  take_materials();
  make_points_of_run();
  mpdem::HostView view = host();
  view.may_leave = cement_->built();
  mpdem::check_host(mpdem::kInit, view);
  take_density(view);
  mpdem::check_axis(lmp, who(), table, o);
  guarded([this] { cement_->read_point_states(); });  // cement from a file may have damage
  mpdem::check_cell(lmp, who(), table, o.cell);
  avec_->points_excluded = true;
  std::string trouble = ranks_.set_balance(o.balance);
  if (trouble.empty() && !avec_->coats.empty()) trouble = mpdem::touch_coats(lmp);
  if (!trouble.empty()) mpdem::stop_all(lmp, who() + trouble);
  gravities_ = mpdem::gravities(view);
  if (memory_limit_ == 0.0) memory_limit_ = mpdem::memory_limit(world);
  cement_->set_most_bytes(0.5 * memory_limit_);  // the other half is for points and LIGGGHTS
  refuse(who(), words_of_materials());
  cement_->couple(nullptr);  // fix mpm/couple registers in its own init
  coupling_.forget();
  atoms_.find(*avec_, cement_->grains());
  mpdem::check_only_writer(lmp, who(), "events", events_name(), this);
  if (!coupling_follows()) set_time_step(this);
}

int FixMpm::modify_param(int narg, char** arg) {
  mpdem::Arguments args(lmp, text_of("fix_modify (fix mpm, id ", id, ")"), narg, arg, 0);
  if (!args.accept("points")) return 0;
  all_points_ = args.choice("points", {"all", "later"}) == "all";
  return 2;
}

// Makes the points of bonds that have none yet and request them, or need them in this run.
void FixMpm::make_points_of_run() {
  bool coupled = false;
  for (int i = 0; i < modify->nfix; ++i) coupled = coupled || std::string(modify->fix[i]->style) == "mpm/couple";
  std::vector<int> rows;
  std::vector<mpdem::SceneOption> later = words_of_materials();
  const std::size_t of_materials = later.size();
  const std::vector<mpdem::BondRecord>& table = avec_->bonds.table;
  for (int row : avec_->bonds.rows_without_points()) {
    if (!all_points_ && later.size() == of_materials)
      later.push_back({"points later", text_of("the cement of grains ", table[row].grain[0], " and ", table[row].grain[1])});
    if (all_points_ || !coupled || table[row].wants_points) rows.push_back(row);
  }
  refuse(who(), later);
  if (rows.empty()) return;
  mpdem::keep_contact_history(lmp);
  make_points(rows);
}

void FixMpm::make_points(const std::vector<int>& rows) {
  guarded([&] { mpdem::make_points(lmp, rows); });
  cement_->points_were_made(rows);
}

// Is there a fix mpm/couple? It registers in its own init, after this one's.
bool FixMpm::coupling_follows() const {
  for (int i = 0; i < modify->nfix; ++i)
    if (std::string(modify->fix[i]->style) == "mpm/couple") return true;
  return false;
}

void FixMpm::check_coupling() const {
  const std::string trouble = cement_->penalty() ? "" : coupling_.trouble_without(cement_->restored());
  if (!trouble.empty()) mpdem::stop_all(lmp, who() + trouble);
}

bool FixMpm::in_motion() const {
  const std::vector<mpdem::BondRecord>& table = avec_->bonds.table;
  return std::any_of(table.begin(), table.end(), [](const mpdem::BondRecord& b) { return b.in_motion; });
}

bool FixMpm::points_are_wanted() const { return all_points_ && !avec_->bonds.rows_without_points().empty(); }

void FixMpm::set_coupling(const Fix* coupling, const mpdem::PenaltyParameters& p, const std::vector<std::string>& said) {
  const std::string trouble = coupling_.take(coupling->id, id, cell(), p);
  if (!trouble.empty()) mpdem::stop_all(lmp, text_of("fix mpm/couple (id ", coupling->id, "): ", trouble));
  std::vector<mpdem::SceneOption> words;
  for (const std::string& one : said) words.push_back({one});
  int film = std::any_of(avec_->bonds.begin(), avec_->bonds.end(), [](const mpdem::Bond& b) { return !b.film.empty(); });
  MPI_Allreduce(MPI_IN_PLACE, &film, 1, MPI_INT, MPI_MAX, world);
  if (film) words.push_back({"film joined", "create_cement"});
  if (!avec_->bonds.rows_without_points().empty()) words.push_back({"points later", "create_cement"});
  refuse(text_of("fix mpm/couple (id ", coupling->id, "): "), std::move(words), false);
  cement_->couple(&p);
  set_time_step(coupling);
}

void FixMpm::set_grains(const Fix* coupling, const std::vector<mpdem::ElasticPair>& of_rows) {
  try {
    cement_->set_elastic_grains(of_rows);
  } catch (const mpdem::BadState& e) {
    mpdem::stop_all(lmp, text_of("fix mpm/couple (id ", coupling->id, "): ", e.what()));
  }
}

// Stops if options of this fix and others exclude each other. from_here: does this fix report it?
void FixMpm::refuse(const std::string& who, std::vector<mpdem::SceneOption> others, bool from_here) {
  for (const mpdem::SceneOption& w : words_) others.push_back({w.words, from_here ? "" : text_of("fix mpm (id ", id, ")")});
  const std::string trouble = mpdem::exclusion_in(others);
  if (!trouble.empty()) mpdem::stop_all(lmp, who + trouble);
}

void FixMpm::set_time_step(const Fix* running) {
  guarded([&] { step_->set(*cement_, running, this); });
}

void FixMpm::setup_pre_exchange() {
  check_positions();
  remove_leaving(false);
  show_homes(update->setupflag != 0);
}

// Commands must not move grains that have cement, nor its points.
void FixMpm::check_positions() {
  mpdem::HostView view = host();
  mpdem::check_host(mpdem::kStart, view);
  if (!cement_->built()) return;
  const std::vector<double> shown = mpdem::motion_shown(*atom);
  write_point_atoms();
  view.shown = &shown;
  mpdem::check_host(mpdem::kShown, view);
}

// With `run ... pre no` LIGGGHTS continues from the end of the last run. Nothing may have changed since.
void FixMpm::check_unprepared() {
  mpdem::HostView view = host();
  view.who = "run ... pre no: ";
  mpdem::check_host(mpdem::kUnprepared, view);
  take_density(view);
  check_positions();
}

void FixMpm::take_density(const mpdem::HostView& view) {
  const mpdem::Densities density = mpdem::densities(view);
  if (density.low <= density.high) guarded([&] { cement_->set_density(density.low); });
  else if (density.own > 0.0 && cement_->density() > 0.0) return;  // no cement has this density
  else if (density.own > 0.0) guarded([&] { cement_->set_density(density.own); });
  else if (!avec_->coats.empty()) guarded([&] { cement_->set_density(avec_->coats.all()[0].density); });  // no cement but coats
}

// Call it before LIGGGHTS exchanges atoms, while true positions are shown. for_run: the exchange is for a run, and not
// for write_restart.
void FixMpm::show_homes(bool for_run) {
  if (ranks_.show_homes(*avec_, for_run)) next_reneighbor = update->ntimestep + 1;
}

void FixMpm::setup_pre_neighbor() {
  mpdem::check_host(mpdem::kExchanged, host());
  atoms_.find(*avec_, cement_->grains());
  guarded([this] { cement_->lay_out_run(); });
  avec_->coats.find_atoms(*atom);
  prepared_ = true;
}

void FixMpm::setup(int) {
  update->first_update = 1;
  check_coupling();
  avec_->last_run.begin(*modify, avec_->bonds.table.size());
  hidden_.start(this);
  if (!avec_->coats.empty()) mpdem::act_last(modify, this);  // LIGGGHTS integrates with scaled torques
  mpdem::exchange_last(modify, this);                        // earlier fixes may delete or insert grains
  ranks_.start_run(this);
  report_->start_run(*cement_);
  guarded([this] { report_->parameters(*cement_, mpdem::points_made(*avec_)); });
  tell_materials();
  write_events();
  check_state();
  contacts_.start_run(*avec_, *cement_);
  atoms_.read(cement_->grains());
  if (cement_->penalty()) atoms_.expect_gravity(cement_->grains(), this);
  guarded([this] { cement_->start_run(); });
  report_->start(*cement_);
  atoms_.write_velocities(cement_->grains());
  atoms_.write_forces(cement_->grains());
  report_->added_mass(*cement_, *avec_);
  report_->forget();
  write_point_atoms();
  watch_outside();
  watch_loose();
  mpdem::gather_into_huge_pages();
  watch_->start_run(*cement_, totals().failed > 0.0);
  report_->start_timing(*cement_);
}

// Commands may have changed velocities since the end of the last step.
void FixMpm::pre_initial_integrate() {
  const bool first = update->ntimestep == update->firststep + 1;
  if (first && !prepared_) check_unprepared();
  if (first) prepared_ = false;
  if (first) report_->enter_steps();
  if (first) mpdem::warn_of_coats_at_walls(lmp, who());
  if (first || substeps() > 1) atoms_.read(cement_->grains());
  guarded([&] { cement_->start_step(first); });
  if (first) atoms_.write_velocities(cement_->grains());
  hidden_.hide();
  avec_->coats.scale_torques(*atom);
}

void FixMpm::initial_integrate(int) {
  hidden_.show();
  avec_->coats.restore_torques(*atom);
}

void FixMpm::pre_final_integrate() {
  hidden_.hide();
  avec_->coats.scale_torques(*atom);
}

void FixMpm::final_integrate() {
  hidden_.show();
  avec_->coats.restore_torques(*atom);
}

// Updates the orientation of bonded grains, since LIGGGHTS' integrators for spheres keep omega only.
void FixMpm::post_integrate() {
  atoms_.read(cement_->grains());
  const auto moved = [this] { guarded([this] { cement_->grains_moved(); }); };
  if (substeps() == 1) return moved();
  atoms_.read_positions(cement_->grains());
  moved();
  atoms_.write_motion(cement_->grains());
}

void FixMpm::pre_exchange() {
  if (!cement_->built()) return;
  cement_->timer().start(mpdem::StepTimer::kLayout);
  atoms_.report_trouble();
  write_point_atoms();
  remove_leaving((update->ntimestep - 1) % cement_->options().check_every == 0);  // true in the step after a check
  // New points take indices that ghosts had. That is safe here: LIGGGHTS has already called the fix that saves the history
  // of contacts, which refers to these indices.
  const std::vector<int> rows = cement_->rows_that_want_points();
  if (!rows.empty()) make_points(rows);
  show_homes(true);
  cement_->timer().stop();
}

void FixMpm::pre_neighbor() {
  cement_->timer().start(mpdem::StepTimer::kLayout);
  avec_->coats.find_atoms(*atom);
  avec_->clear_loads_of_points();  // points have other indices in LIGGGHTS' lists now
  contacts_.atoms_moved();
  mpdem::check_host(mpdem::kExchanged, host());
  atoms_.find(*avec_, cement_->grains());
  atoms_.read(cement_->grains());
  guarded([this] { cement_->lay_out_exchanged(); });
  if (ranks_.shows_homes()) write_point_atoms();
  cement_->timer().stop();
}

void FixMpm::post_force(int) {
  report_->forget();  // values requested earlier in this step are those of the last step
  atoms_.follow(cement_->grains(), cell(), step_input().dt);
  contacts_.add_forces(*avec_, *cement_, update->dt);
  atoms_.read(cement_->grains());
  guarded([this] { cement_->step(); });
  if (!cement_->rows_that_want_points().empty()) next_reneighbor = update->ntimestep + 1;
  atoms_.write_forces(cement_->grains());
  atoms_.write_free_velocities(cement_->grains());
}

void FixMpm::end_of_step() {
  cement_->timer().start(mpdem::StepTimer::kOutput);
  const bool output_due = update->ntimestep == output->next, first = update->ntimestep == update->firststep + 1;
  const bool check_due = update->ntimestep % cement_->options().check_every == 0;
  if (output_due || first || update->ntimestep % kReportEvery == 0) atoms_.report_trouble();
  atoms_.read(cement_->grains());
  guarded([this] { cement_->end_step(); });
  contacts_.take_changes(*avec_, *cement_);
  atoms_.write_forces(cement_->grains());
  if (output_due || check_due || first) report_->jump(*cement_);
  report_->forget();  // values requested earlier lack the work of this step
  if (check_due) write_events();
  if (check_due) watch_->check(*cement_);
  if (check_due || output_due || first) check_state();
  const bool shown = output_due || (check_due && leaving_.may_be_outside(*avec_));
  if (shown) {
    write_point_atoms();
    watch_outside();
  }
  if (check_due) watch_loose();
  if (check_due && ranks_.is_uneven(*avec_)) {
    if (!shown) write_point_atoms();
    if (ranks_.find_homes(*avec_)) next_reneighbor = update->ntimestep + 1;
  }
  if (first) coupling_.remember(cement_->penalty() ? &*cement_->penalty() : nullptr);
  cement_->timer().stop();
}

void FixMpm::post_run() {
  prepared_ = false;
  mpdem::warn_of_coats_at_walls(lmp, who());
  avec_->last_run.atoms = atom->natoms;
  avec_->last_run.dt = update->dt;
  report_->jump(*cement_);
  write_point_atoms();
  watch_outside();
  write_events();
  watch_->check(*cement_);
  report_->modes(*cement_);
  report_->times(*cement_, mpdem::points_made(*avec_));
  report_->end_run(*cement_);
  ranks_.tell(who(), *avec_);
}

// Velocities are half an old step behind. The next step uses the new one.
void FixMpm::reset_dt() {
  guarded([this] {
    if (!cement_->built()) return;
    step_->report_substeps(options());
    report_->check_step(*cement_);
    cement_->change_step();
  });
}

double FixMpm::stable_step(bool of_grains) {
  double step = 0.0;
  guarded([&] {
    step = !of_grains                       ? substeps() * cement_->stable_step().find()
           : is_coupled() && substeps() > 1 ? cement_->grains_step_if_known()
                                            : INFINITY;
  });
  return step;
}

std::vector<mpdem::StiffnessOfBond> FixMpm::stiffness_of_bonds() {
  mpdem::check_host(mpdem::kStart, host());
  std::vector<mpdem::StiffnessOfBond> found;
  guarded([&] { found = cement_->stiffness_of_bonds(); });
  return found;
}

void FixMpm::check_state(bool forces_known) {
  guarded([this] { cement_->check_state(); });
  mpdem::HostView view = host();
  view.forces_known = forces_known;
  mpdem::check_host(mpdem::kCheck, view);
}

std::array<double, 3> FixMpm::initial_velocity(int tag) {
  const double* v = atom->v[atom->map(tag)];
  return {v[0], v[1], v[2]};
}

void FixMpm::failed(const mpdem::Bond& bond, mpdem::Failed what) {
  watch_->note_failure();
  failures_.add(bond, avec_->bonds.record(bond), what, static_cast<long>(update->ntimestep), update->get_cur_time());
}

void FixMpm::slots_changed(const mpdem::Bond& bond) {
  bond.for_each_slot([&](int slot) {
    const int i = mpdem::local_atom(*atom, bond.store_of(slot).tag(mpdem::Bond::slot_in_store(slot)));
    if (i >= 0) avec_->slot[i] = slot;
  });
}

void FixMpm::write_events() { failures_.write(this, lmp, who(), cement_->restored()); }

void FixMpm::show_points() { cement_->show_points(); }

void FixMpm::write_point_atoms() {
  cement_->sync_slots();
  avec_->clear_loads_of_points();
  leaving_.show_points(*avec_, cement_->report());
  ranks_.true_positions_shown();
}

FixMpm* FixMpm::of(const Modify& modify) {
  for (int i = 0; i < modify.nfix; ++i)
    if (FixMpm* fix = dynamic_cast<FixMpm*>(modify.fix[i])) return fix;
  return nullptr;
}

double FixMpm::compute_scalar() {
  const mpdem::CementTotals& t = totals();
  return t.elastic + t.coupling;
}

double FixMpm::compute_vector(int n) {
  const mpdem::CementValue& value = mpdem::cement_values()[n];
  return value.of ? value.of(value.of_contacts ? totals_with_contacts() : totals()) : substeps();
}

// Stiffness of condensed bonds. The atom style counts the memory of the bonds themselves.
double FixMpm::memory_usage() { return static_cast<double>(cement_->report().memory_of_condensed()); }

}  // namespace LAMMPS_NS
