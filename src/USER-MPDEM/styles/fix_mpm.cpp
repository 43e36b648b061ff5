// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "fix_mpm.h"

#include <mpi.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <optional>

#include "../parallel/huge_pages.h"
#include "../parallel/memory_limit.h"
#include "arguments.h"
#include "atom.h"
#include "cement_checks.h"
#include "cement_words.h"
#include "comm.h"
#include "domain.h"
#include "files_in_use.h"
#include "fix_gravity.h"
#include "force.h"
#include "host_recipe.h"
#include "local_atom.h"
#include "modify.h"
#include "output.h"
#include "point_atoms.h"
#include "pair.h"
#include "private_access.h"
#include "scene_checks.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::kLanes;
using mpdem::text_of;
using namespace FixConst;

namespace {
constexpr int kVectorSize = 34;
constexpr double kShareOfSubsteps = 0.9;  // share of the stable step of the cement, for `subcycle auto`
constexpr int kReportEvery = 5;  // steps between reports of grains that are lost or jump
}  // namespace

FixMpm::FixMpm(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg), avec_(AtomVecMpdem::of(lmp)), atoms_(lmp, who()), hidden_(lmp), ranks_(lmp), leaving_(lmp, who()) {
  time_integrate = 1;
  restart_global = 1;
  force_reneighbor = 1;  // LIGGGHTS exchanges atoms at the step next_reneighbor
  next_reneighbor = -1;
  scalar_flag = vector_flag = 1;
  size_vector = kVectorSize;
  global_freq = 1;
  extscalar = extvector = 0;  // atoms are grains and points, and their number has no meaning for cement; `thermo_modify norm yes` divides by it
  mpdem::Arguments args(lmp, text_of("fix mpm (id ", id, ")"), narg, arg, 3);
  if (!avec_) args.complain(text_of("atom style '", atom->atom_style, "' cannot hold material points; use 'atom_style mpdem'"));
  const mpdem::CementWords words = mpdem::take_cement_words(args);
  if (comm->me == 0) {
    for (const std::string& note : words.notes)
      for (FILE* f : {screen, logfile})
        if (f) std::fprintf(f, "%s%s\n", who().c_str(), note.c_str());
  }
  words_ = words.said;
  step_fraction_ = words.step_fraction;
  failures_.name(words.events);
  cement_ = std::make_unique<mpdem::Cement>(world, avec_->bonds, words.options, words.law, static_cast<mpdem::CementHost&>(*this));
  report_ = std::make_unique<mpdem::CementReport>(lmp, who());
  watch_ = std::make_unique<mpdem::QuasistaticWatch>(lmp, who(), words.kinetic_share);
}

// A restart file that is written after this has no nodes of the cement.
FixMpm::~FixMpm() {
  if (avec_) avec_->forget_nodes();
}

// LIGGGHTS prepares the next run then, also with `pre no`, and so the atom style finds that its cement has no fix.
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
  return PRE_INITIAL_INTEGRATE | INITIAL_INTEGRATE | POST_INTEGRATE | PRE_EXCHANGE | PRE_NEIGHBOR | POST_FORCE | PRE_FINAL_INTEGRATE | FINAL_INTEGRATE |
         END_OF_STEP | POST_RUN;
}

// Commands between runs call this too, and what grains have of the last step is gone then. So LIGGGHTS has to prepare the next run,
// also with `pre no`: setup() says that this is done. It does not prepare the parts of a run with `every`, see check_unprepared().
void FixMpm::init() {
  update->first_update = 0;
  const mpdem::CementOptions& o = cement_->options();
  const std::vector<mpdem::Body>& table = avec_->bonds.table;
  make_points_of_run();
  const mpdem::CementPoints points = mpdem::check_scene(lmp, who(), this, *avec_, cement_->built());
  points_expected_ = points.expected;
  if (points.density > 0.0) guarded([&] { cement_->set_density(points.density); });
  mpdem::check_box(lmp, who(), table);
  mpdem::check_axis(lmp, who(), table, o);
  guarded([this] { cement_->take_up_states(); });  // cement from a file may come damaged
  mpdem::check_cell(lmp, who(), table, o.cell);
  check_host_recipe(lmp, who(), *avec_);
  avec_->apart = true;
  const std::string trouble = ranks_.take(o.balance);
  if (!trouble.empty()) mpdem::stop_all(lmp, who() + trouble);
  gravities_ = mpdem::gravities(lmp, who(), this, *avec_);
  if (memory_limit_ == 0.0) memory_limit_ = mpdem::memory_limit(world);
  cement_->set_most_bytes(0.5 * memory_limit_);  // points, and what LIGGGHTS has, come on top
  std::vector<mpdem::SceneWords> made;
  add_film(made);
  refuse(who(), made);
  cement_->couple(nullptr);                      // fix mpm/couple speaks up in its own init
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

// Makes points of bonds that have none yet and ask for them, or cannot do without in this run.
void FixMpm::make_points_of_run() {
  bool coupled = false;
  for (int i = 0; i < modify->nfix; ++i) coupled = coupled || std::string(modify->fix[i]->style) == "mpm/couple";
  std::vector<int> rows;
  std::vector<mpdem::SceneWords> later;
  const std::vector<mpdem::Body>& table = avec_->bonds.table;
  for (std::size_t row = 0; row < table.size(); ++row) {
    if (table[row].pattern == 0) continue;
    if (!all_points_ && later.empty()) later.push_back({"points later", text_of("the cement of grains ", table[row].grain[0], " and ", table[row].grain[1])});
    if (all_points_ || !coupled || table[row].wants_points) rows.push_back(static_cast<int>(row));
  }
  refuse(who(), later);
  if (rows.empty()) return;
  mpdem::keep_contact_history(lmp);
  make_points(rows);
}

void FixMpm::make_points(const std::vector<int>& rows) {
  guarded([&] { points_expected_ += static_cast<bigint>(mpdem::make_points(lmp, rows)); });
  cement_->points_were_made(rows);
}

// Is there a fix mpm/couple? It speaks up in its own init, after this one's.
bool FixMpm::coupling_follows() {
  bool comes_later = false;
  for (int i = 0; i < modify->nfix; ++i) {
    comes_later = comes_later || modify->fix[i] == this;
    if (std::string(modify->fix[i]->style) != "mpm/couple") continue;
    if (!comes_later)
      mpdem::stop_all(lmp, text_of(who(), "fix mpm/couple (id ", modify->fix[i]->id, ") was defined before this fix and has to come after it; unfix it and define it again"));
    return true;
  }
  refuse(who(), {{"no fix mpm/couple"}});
  if (coupling_.warn_of_none() && comm->me == 0)
    error->warning("fix mpm", 0,
                   text_of(who(), "there is no fix mpm/couple, so that the cement bonds nothing",
                           coupling_.so_far().kind == mpdem::LinksSoFar::kLinks ? " any more, and cannot be bonded again once it has made a step so" : "",
                           "; define one before the run", cement_->restored() ? ", after read_restart too" : "")
                       .c_str());
  return false;
}

bool FixMpm::in_motion() const {
  const std::vector<mpdem::Body>& table = avec_->bonds.table;
  return std::any_of(table.begin(), table.end(), [](const mpdem::Body& b) { return b.in_motion; });
}

void FixMpm::set_coupling(const Fix* coupling, const mpdem::PenaltyParameters& p, const std::vector<std::string>& said) {
  const std::string trouble = coupling_.take(coupling->id, id, cell(), p);
  if (!trouble.empty()) mpdem::stop_all(lmp, text_of("fix mpm/couple (id ", coupling->id, "): ", trouble));
  std::vector<mpdem::SceneWords> words;
  for (const std::string& one : said) words.push_back({one});
  add_film(words);
  refuse(text_of("fix mpm/couple (id ", coupling->id, "): "), std::move(words), false);
  cement_->couple(&p);
  set_time_step(coupling);
}

// Stops if words of this fix and others exclude each other. from_here: is it this fix that complains?
void FixMpm::refuse(const std::string& who, std::vector<mpdem::SceneWords> others, bool from_here) {
  for (const mpdem::SceneWords& w : words_) others.push_back({w.words, from_here ? "" : text_of("fix mpm (id ", id, ")")});
  const std::string trouble = mpdem::words_that_exclude(others);
  if (!trouble.empty()) mpdem::stop_all(lmp, who + trouble);
}

// Collective. Adds the word of the first bond with a film, if there is one.
void FixMpm::add_film(std::vector<mpdem::SceneWords>& words) {
  const std::vector<mpdem::Body>& table = avec_->bonds.table;
  int mine = INT_MAX, first;
  for (const mpdem::Bond& b : avec_->bonds)
    if (!b.film.empty()) mine = std::min(mine, b.body);
  for (std::size_t row = 0; row < table.size(); ++row)
    if (table[row].pattern > 0 && avec_->bonds.patterns[table[row].pattern - 1].points.back().film) mine = std::min(mine, static_cast<int>(row));
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, world);
  if (first < INT_MAX) words.push_back({"film joined", text_of("the cement of grains ", table[first].grain[0], " and ", table[first].grain[1])});
}

int FixMpm::substeps() const {
  const int given = cement_->options().subcycle;
  if (given > 0 || longest_substep_ == 0.0) return std::max(1, given);
  constexpr double kRounding = 1e-9;
  return static_cast<int>(std::min<double>(INT_MAX, std::max(1.0, std::ceil(update->dt / longest_substep_ - kRounding))));
}

// Sets the step of `timestep auto` and the sub-steps of `subcycle auto`, before other fixes take up the step. Called in
// the init of fix `running`.
void FixMpm::set_time_step(const Fix* running) {
  const int subcycle = cement_->options().subcycle;
  if (step_fraction_ == 0.0 && subcycle > 0) return;
  mpdem::EigenvalueEstimate e{};
  double limit = 0.0;
  guarded([&] {
    cement_->stable_step().find_film();
    e = cement_->eigenvalue_of_new_layout();
    limit = cement_->stable_step().step_for(e.most, cement_->options().relax);
    if (subcycle > 0) limit *= subcycle;
    else longest_substep_ = std::min(longest_substep_ > 0.0 ? longest_substep_ : HUGE_VAL, kShareOfSubsteps * limit);  // as with `timestep auto`
    if (subcycle == 0 && step_fraction_ > 0.0 && is_coupled()) limit = std::max(limit, cement_->grains_step());
  });
  if (step_fraction_ > 0.0) set_time_step(running, limit, e);
  if (subcycle == 0) tell_substeps();
}

void FixMpm::tell_substeps() {
  const int n = substeps();
  if (n > mpdem::kMostSubsteps)
    mpdem::stop_all(lmp, who() + text_of("'subcycle auto' takes ", n, " sub-steps of the cement in a time step of ", update->dt, ", at most ", mpdem::kMostSubsteps,
                                         " are allowed; use 'timestep ", mpdem::kMostSubsteps * longest_substep_, "' or less"));
  if (comm->me == 0 && n != substeps_told_)
    for (FILE* f : {screen, logfile})
      if (f) std::fprintf(f, "%s\n", text_of(who(), "subcycle auto: ", n, " sub-steps of ", update->dt / n, " in a time step of ", update->dt).c_str());
  substeps_told_ = n;
}

// Edges that get nodes of their own are not tied any more, so the stable step is shorter where the cement has cracks.
void FixMpm::warn_of_splits() {
  const mpdem::CementOptions& o = cement_->options();
  const double share = !o.split ? 1.0 : o.unilateral ? 0.6 : o.mass_order > 1 ? 0.75 : 0.8;
  if (step_fraction_ <= share || splits_told_) return;
  splits_told_ = true;
  if (comm->me == 0)
    error->warning("fix mpm", 0, text_of(who(), "'timestep auto ", step_fraction_, "' with 'cracks split': nodes that split shorten the stable step, so the run may stop "
                                         "where the cement breaks; use 'timestep auto ", share, "' or less for cement that breaks").c_str());
}

void FixMpm::set_time_step(const Fix* running, double limit, const mpdem::EigenvalueEstimate& e) {
  // The step of the runs before is kept as long as it is stable, since formulas in step*dt would jump with it. Cement
  // that fails leaves other limits behind, longer ones and shorter ones. A run from a restart file may ask for a smaller
  // share. It never gets a longer step.
  double dt = step_fraction_ * limit;
  std::string share = text_of(step_fraction_, " of the limit,");
  if (auto_step_ > 0.0 && auto_step_ <= (step_fraction_ < auto_share_ ? dt : limit)) {
    share = text_of("as before, the limit is now ", limit, ",");
    dt = auto_step_;
  } else if (!std::isfinite(dt)) {
    share = "as it was, nothing limits it,";
    dt = update->dt;
  }
  auto_step_ = dt;
  auto_share_ = step_fraction_;
  warn_of_splits();
  if (comm->me == 0)
    for (FILE* f : {screen, logfile})
      if (f)
        std::fprintf(f, "%s\n", text_of(who(), "timestep auto: ", dt, ", ", share, " from the largest eigenvalue ", e.value, " found in ",
                                        e.products, " products").c_str());
  if (dt == update->dt) return;
  update->dt = dt;
  if (force->pair) force->pair->reset_dt();
  // Fixes before this one took up the old step in their init. reset_dt() cannot be used, since fix move refuses it even
  // before a run.
  for (int i = 0; i < modify->nfix && modify->fix[i] != running; ++i)
    if (modify->fix[i] != this) modify->fix[i]->init();
}

void FixMpm::setup_pre_exchange() {
  check_positions();
  let_leave(false);
  show_homes(update->setupflag != 0);
}

// Commands must not move grains that have cement, nor its points.
void FixMpm::check_positions() {
  atoms_.check_stayed(*avec_, cell());
  mpdem::check_created_positions(lmp, who(), *avec_, cell(), cement_->bodies_started());
  if (!cement_->built()) return;
  const std::vector<double> shown = mpdem::motion_shown(lmp, *avec_);
  fill_atoms();
  mpdem::check_points_left_alone(lmp, who(), *avec_, shown, 1e-9 * cell(), 1e-9 * law().elasticity().fastest_wave(cement_->density()));
}

// With `run ... pre no` LIGGGHTS goes on as the last run ended. Nothing may have changed since.
void FixMpm::check_unprepared() {
  if (update->first_update == 0)
    mpdem::stop_all(lmp, "run ... pre no every: a command within the run initialised LIGGGHTS, as 'write_restart' does, and what grains and contacts have of the last "
                         "step is lost; leave 'pre no' out");
  avec_->prepared_fixes.check_same(lmp);  // for a LIGGGHTS with the package compiled in
  const std::size_t bonds = avec_->bonds.table.size();
  if (bonds != prepared_bonds_)
    mpdem::stop_all(lmp, text_of("run ... pre no: there are ", bonds, " bonds of cement and were ", prepared_bonds_, " in the last run; leave 'pre no' out after create_cement"));
  if (update->dt != dt_at_end_)
    mpdem::stop_all(lmp, text_of("run ... pre no: the time step is ", update->dt, " and was ", dt_at_end_, " in the last run; leave 'pre no' out after timestep"));
  const std::vector<mpdem::Body>& table = avec_->bonds.table;
  if (all_points_ && std::any_of(table.begin(), table.end(), [](const mpdem::Body& b) { return b.pattern > 0; }))
    mpdem::stop_all(lmp, "run ... pre no: fix_modify 'points all' asks for points that are yet to be made; leave 'pre no' out");
  const mpdem::CementPoints points = mpdem::check_scene(lmp, "run ... pre no: ", this, *avec_, false);
  if (points.density > 0.0) guarded([&] { cement_->set_density(points.density); });
  if (atom->natoms != atoms_at_end_)
    mpdem::stop_all(lmp, text_of("run ... pre no: there are ", atom->natoms, " atoms and were ", atoms_at_end_, " at the end of the last run; leave 'pre no' out after commands that make or delete atoms"));
  check_positions();
}

// Call before LIGGGHTS exchanges atoms, when it has their true places. for_run: the exchange is for a run, and not for
// write_restart.
void FixMpm::show_homes(bool for_run) {
  if (ranks_.show_homes(*avec_, for_run)) next_reneighbor = update->ntimestep + 1;
}

void FixMpm::setup_pre_neighbor() {
  mpdem::count_points(lmp, who(), *avec_, points_expected_);
  atoms_.find(*avec_, cement_->grains());
  guarded([this] { cement_->lay_out_run(); });
  prepared_ = true;
  prepared_bonds_ = avec_->bonds.table.size();
}

void FixMpm::setup(int) {
  update->first_update = 1;
  avec_->prepared_fixes.note(lmp);
  hidden_.start(this);
  mpdem::exchange_last(modify, this);  // fixes before it may delete grains, or insert some
  ranks_.start_run(this);
  report_->start_run(*cement_);
  guarded([this] { report_->parameters(*cement_, points_expected_); });
  write_events();
  check_state();
  atoms_.read(cement_->grains());
  if (cement_->penalty()) atoms_.expect_gravity(cement_->grains(), this);
  guarded([this] { cement_->start_run(); });
  report_->start(*cement_);
  cement_->grains().show_loads(substeps());
  atoms_.write_velocities(cement_->grains());
  atoms_.write_forces(cement_->grains());
  report_->added_mass(*cement_, *avec_);
  report_->forget();
  fill_atoms();
  watch_outside();
  mpdem::gather_into_huge_pages();
  watch_->start_run(*cement_, totals().failed > 0.0);
  report_->start_timing(*cement_);
}

// Commands may have changed velocities since the end of the last step.
void FixMpm::pre_initial_integrate() {
  const bool first = update->ntimestep == update->firststep + 1, divided = substeps() > 1;
  if (first && !prepared_) check_unprepared();
  if (first) prepared_ = false;
  if (first) report_->enter_steps();
  if (first || divided) {
    atoms_.read(cement_->grains());
    guarded([&] {
      if (first) cement_->take_up_commands();
      if (divided) cement_->begin_substeps();
    });
    if (first) atoms_.write_velocities(cement_->grains());
  }
  hidden_.hide();
}

void FixMpm::initial_integrate(int) { hidden_.show(); }
void FixMpm::pre_final_integrate() { hidden_.hide(); }
void FixMpm::final_integrate() { hidden_.show(); }

// Finds the orientation of bonded grains, since LIGGGHTS' integrators for spheres keep omega only.
void FixMpm::post_integrate() {
  atoms_.read(cement_->grains());
  if (substeps() == 1) {
    cement_->grains().turn(update->dt);
    return;
  }
  atoms_.read_places(cement_->grains());
  guarded([this] { cement_->take_substeps(); });
  atoms_.write_motion(cement_->grains());
}

void FixMpm::pre_exchange() {
  if (!cement_->built()) return;
  cement_->timer().start(mpdem::StepTimer::kLayout);
  atoms_.report_trouble();
  fill_atoms();
  let_leave((update->ntimestep - 1) % cement_->options().check_every == 0);
  // new points take the places of ghosts; LIGGGHTS has called the fix that keeps the history of contacts by these
  // places before all other fixes
  const std::vector<int> rows = cement_->rows_that_want_points();
  if (!rows.empty()) make_points(rows);
  show_homes(true);
  cement_->timer().stop();
}

void FixMpm::pre_neighbor() {
  cement_->timer().start(mpdem::StepTimer::kLayout);
  avec_->clear_loads_of_points();  // points are at other places of LIGGGHTS' lists now
  mpdem::count_points(lmp, who(), *avec_, points_expected_);
  atoms_.find(*avec_, cement_->grains());
  atoms_.read(cement_->grains());
  guarded([this] { cement_->lay_out_exchanged(); });
  if (ranks_.shows_homes()) fill_atoms();
  cement_->timer().stop();
}

void FixMpm::post_force(int) {
  report_->forget();  // reports that were asked for earlier in this step are those of the last step
  atoms_.follow(cement_->grains(), *avec_, cell(), step_input().dt);
  atoms_.read(cement_->grains());
  guarded([this] { cement_->step(); });
  if (!cement_->rows_that_want_points().empty()) next_reneighbor = update->ntimestep + 1;
  atoms_.write_forces(cement_->grains());
  atoms_.write_pushes(cement_->grains());
}

void FixMpm::end_of_step() {
  cement_->timer().start(mpdem::StepTimer::kOutput);
  const bool output_due = update->ntimestep == output->next, first = update->ntimestep == update->firststep + 1;
  const bool check_due = update->ntimestep % cement_->options().check_every == 0;
  if (output_due || first || update->ntimestep % kReportEvery == 0) atoms_.report_trouble();
  atoms_.read(cement_->grains());
  guarded([this] { cement_->end_step(); });
  cement_->grains().show_loads(substeps());
  if (substeps() > 1) atoms_.write_forces(cement_->grains());
  if (output_due || check_due || first) report_->jump(*cement_);
  report_->forget();  // reports asked for earlier do not have the work of this step
  if (check_due) write_events();
  if (check_due) watch_->look(*cement_);
  if (check_due || output_due) check_state();
  const bool shown = output_due || (check_due && leaving_.may_be_outside(*avec_));
  if (shown) {
    fill_atoms();
    watch_outside();
  }
  if (check_due && ranks_.is_uneven(*avec_)) {
    if (!shown) fill_atoms();
    if (ranks_.find_homes(*avec_)) next_reneighbor = update->ntimestep + 1;
  }
  if (first) coupling_.remember(cement_->penalty() ? &*cement_->penalty() : nullptr);
  cement_->timer().stop();
}

void FixMpm::post_run() {
  prepared_ = false;
  atoms_at_end_ = atom->natoms;
  dt_at_end_ = update->dt;
  report_->jump(*cement_);
  fill_atoms();
  watch_outside();
  write_events();
  watch_->look(*cement_);
  report_->modes(*cement_);
  report_->times(*cement_, points_expected_);
  report_->end_run(*cement_);
  ranks_.tell(who(), *avec_);
}

// Velocities lie half an old step behind. The next step takes up the new one.
void FixMpm::reset_dt() {
  guarded([this] {
    if (!cement_->built()) return;
    if (cement_->options().subcycle == 0) tell_substeps();
    report_->check_step(*cement_);
    cement_->change_step();
  });
}

double FixMpm::stable_step(bool of_grains) {
  double step = 0.0;
  guarded([&] { step = !of_grains ? substeps() * cement_->stable_step().find() : is_coupled() && substeps() > 1 ? cement_->grains_step_if_known() : INFINITY; });
  return step;
}

// Rounding differs with the ranks that grains are on, so the sum is of whole numbers.
double FixMpm::mark_of_free_grains() {
  std::uint64_t mine = 0, sum;
  for (const mpdem::Grain& g : cement_->grains().grains)
    for (int d = 0; d < 6; ++d) {
      const double inertia = g.free[d] ? (d < 3 ? g.mass : g.inertia) : 0.0;
      std::uint64_t bits;
      std::memcpy(&bits, &inertia, sizeof bits);
      mine += (bits ^ (bits >> 29)) * (2 * (6 * static_cast<std::uint64_t>(g.tag) + d) + 1) * 0x9e3779b97f4a7c15u >> 12;
    }
  MPI_Allreduce(&mine, &sum, 1, MPI_UINT64_T, MPI_SUM, world);
  return static_cast<double>(sum >> 11);  // 53 bits
}

std::vector<mpdem::StiffnessOfBond> FixMpm::stiffness_of_bonds() {
  atoms_.check_stayed(*avec_, cell());
  mpdem::check_created_positions(lmp, who(), *avec_, cell(), cement_->bodies_started());
  std::vector<mpdem::StiffnessOfBond> found;
  guarded([&] { found = cement_->stiffness_of_bonds(); });
  return found;
}

void FixMpm::check_state(bool forces_known) {
  guarded([this] { cement_->check_state(); });
  std::string trouble = mpdem::grain_that_is_not_finite(lmp, who(), *avec_, forces_known);
  if (trouble.empty()) trouble = grain_outside_of_group(lmp, who(), *avec_);
  mpdem::stop_if_any(lmp, trouble);
  const std::string of_types = mpdem::trouble_with_types(lmp, *avec_, 0);  // grains may be inserted
  if (!of_types.empty()) mpdem::stop_all(lmp, who() + of_types);
}

std::array<double, 3> FixMpm::initial_velocity(int tag) {
  const double* v = atom->v[atom->map(tag)];
  return {v[0], v[1], v[2]};
}

void FixMpm::points_failed(const mpdem::Bond& bond) {
  watch_->note_failure();
  failures_.add(bond, avec_->bonds.body(bond), static_cast<long>(update->ntimestep), update->get_cur_time());
}

void FixMpm::film_failed(const mpdem::Bond& bond) {
  watch_->note_failure();
  failures_.add_film(bond, avec_->bonds.body(bond), static_cast<long>(update->ntimestep), update->get_cur_time());
}

void FixMpm::links_let_go(const mpdem::Bond& bond) {
  watch_->note_failure();
  failures_.add_links(bond, avec_->bonds.body(bond), static_cast<long>(update->ntimestep), update->get_cur_time());
}

void FixMpm::slots_changed(const mpdem::Bond& bond) {
  bond.for_each_slot([&](int slot) {
    const int i = mpdem::local_atom(*atom, bond.store_of(slot).tag(mpdem::Bond::slot_in_store(slot)));
    if (i >= 0) avec_->slot[i] = slot;
  });
}

// Collective. Writes the events that wait, and opens the file first if need be.
void FixMpm::write_events() {
  if (events_name().empty()) return;
  const auto check = [this](const std::string& why) {
    mpdem::stop_if_any(lmp, why.empty() ? why : text_of(who(), "cannot write 'events' file ", why, "; name another, or use a disk with free space"));
  };
  if (!failures_.is_open()) {
    mpdem::check_only_writer(lmp, who(), "events", events_name(), this);
    check(failures_.open(world, cement_->restored() ? update->get_cur_time() + 0.5 * update->dt : mpdem::TableFile::kAnew));
  }
  check(failures_.write(world));
}

void FixMpm::show_points() { cement_->show_points(); }

// Brings LIGGGHTS' positions, velocities and slots of the points up to date. Code that reads strain shows it itself.
void FixMpm::fill_atoms() {
  cement_->sync_slots();
  avec_->clear_loads_of_points();
  leaving_.begin();
  std::string trouble;
  std::vector<mpdem::Report::PointMotionNow> motion;
  const auto fill = [&](const mpdem::Bond& bond, const mpdem::PointStore& points, int first_slot) {
    const mpdem::Body& body = avec_->bonds.body(bond);
    const mpdem::Mat3<double> axes = mpdem::axes_of(body);
    for (std::size_t b = 0; b < motion.size(); ++b)
      for (int l = 0; l < kLanes; ++l) {
        const int i = points.meta[b].occupied >> l & 1 ? mpdem::local_atom(*atom, points.tags[b][l]) : -1;
        if (i < 0) continue;
        double* x = atom->x[i];
        double place[3], velocity[3];
        for (int d = 0; d < 3; ++d) {
          place[d] = points.blocks[b].X[d][l] + motion[b].u[d][l];
          velocity[d] = motion[b].v[d][l];
        }
        const std::array<double, 3> in_box = mpdem::place_in_box(body, axes, place), v = mpdem::turned(axes, velocity);
        std::copy(in_box.begin(), in_box.end(), x);
        std::copy(v.begin(), v.end(), atom->v[i]);
        // `remap` of the old flags cannot be used, since x is unwrapped here.
        atom->image[i] = ((tagint)IMGMAX << IMG2BITS) | ((tagint)IMGMAX << IMGBITS) | IMGMAX;
        domain->remap(x, atom->image[i]);
        for (int d = 0; d < 3; ++d)
          if (!std::isfinite(x[d]) && trouble.empty())
            trouble = text_of(who(), "the position of material point ", atom->tag[i], " is not finite at step ", update->ntimestep,
                              "; check the motion of the grains, the time step and the contact model");
        leaving_.show(i, bond.body, first_slot + kLanes * static_cast<int>(b) + l, x);
      }
  };
  for (const mpdem::Bond& bond : avec_->bonds) {
    cement_->report().motion_of_points(bond, motion);
    fill(bond, bond.points, 0);
    cement_->report().motion_of_film(bond, motion);
    fill(bond, bond.film.points, mpdem::Bond::kFilm);
  }
  ranks_.true_places_shown();
  mpdem::stop_if_any(lmp, trouble);
}

// Cement that is attached must not be beyond a side of the box. What is loose leaves in the step after a check, so that it does not
// matter where a run is divided.
void FixMpm::watch_outside() {
  if (!leaving_.some_are_outside()) return;
  if (update->ntimestep % cement_->options().check_every == 0) next_reneighbor = update->ntimestep + 1;
  guarded([this] { leaving_.stop_if_wrong(cement_->departures().choose(leaving_.outside()), points_expected_, cell(), cement_->dt()); });
}

// Call before LIGGGHTS exchanges atoms, when points are shown.
void FixMpm::let_leave(bool points_too) {
  if (!cement_->built()) return;
  const std::optional<mpdem::Departing> departing = leaving_.find(*avec_, points_too);
  if (!departing) return;
  guarded([&] {
    const mpdem::Leaving leaving = cement_->departures().choose(*departing);
    leaving_.stop_if_wrong(leaving, points_expected_, cell(), cement_->dt());
    if (leaving.rows.empty()) return;
    points_expected_ -= leaving_.remove(cement_->departures().carry_out(leaving));
    report_->forget();
  });
}

double FixMpm::compute_scalar() {
  const mpdem::CementTotals& t = totals();
  return t.elastic + t.coupling;
}

double FixMpm::compute_vector(int n) {
  constexpr int kUnbalanced = 33;
  const mpdem::CementTotals& t = n == kUnbalanced ? totals_with_contacts() : totals();
  const double v[] = {t.points,     t.failed,      t.largest_damage, t.mean_damage, t.kinetic,         t.elastic,
                      t.coupling,   t.dissipated,  t.released,       t.damped,      t.external_work,   t.imbalance,
                      t.momentum[0], t.momentum[1], t.momentum[2],
                      t.angular_momentum[0], t.angular_momentum[1], t.angular_momentum[2],
                      t.separated, t.debonding, t.internal, t.mixed, t.rubbed,
                      t.awake, static_cast<double>(substeps()), t.broken,
                      t.left.points, t.left.mass, t.left.momentum[0], t.left.momentum[1], t.left.momentum[2], t.left.energy, t.kinetic_share, t.unbalanced_force};
  return v[n];
}

// The atom style holds the bonds that wait, and tells the memory that they take.
double FixMpm::memory_usage() { return static_cast<double>(cement_->report().memory_of_condensed()); }

}  // namespace LAMMPS_NS
