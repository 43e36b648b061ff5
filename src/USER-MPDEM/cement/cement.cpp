// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The recipes: layouts of a run, its start, steps, and their ends. Restart is in state.cpp.
#include "cement.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "../mpm/point_state.h"
#include "../numerics/flush_denormals.h"
#include "../numerics/sort_unique.h"
#include "../parallel/agree.h"
#include "../parallel/ranks.h"
#include "pattern_layouts.h"
#include "places.h"

namespace mpdem {

Cement::Cement(MPI_Comm comm, Bonds& bonds, const CementOptions& options, std::shared_ptr<const Law> law, CementHost& host)
    : scene_(comm, bonds, host, options, std::move(law)) {
  const MovingParts parts{scene_, shared_, added_, arrangement_, forces_, work_};
  divisions_.splits = scene_.formulation->splits();
  kinematics_ = scene_.formulation->kinematics(parts);
}

// Clears the marks of parts, so that another fix starts from whole bonds.
Cement::~Cement() {
  for (Bond& b : scene_.bonds())
    for (BlockMeta& m : b.points.meta) {
      m.part = m.looked_at = 0;
      m.holds[0] = m.holds[1] = 0xff;
    }
}

void Cement::couple(const PenaltyParameters* penalty) {
  scene_.penalty.reset();
  if (penalty) scene_.penalty = *penalty;
}

void Cement::take_up_states() {
  std::string trouble;
  for (Bond& b : scene_.bonds())
    for (PointStore* store : b.stores())
      if (trouble.empty()) trouble = mpdem::take_up_states(*store, scene_.law);
  throw_if_any(scene_.comm, trouble);
}

void Cement::points_were_made(const std::vector<int>& rows) {
  arrangement_.points_were_made(rows);
  condensing_.points_were_made();
}

void Cement::go_on(const char* call, Stage from, Stage to) {
  static constexpr const char* kLast[] = {"nothing", "lay_out_run", "start_run or end_step", "start_step", "grains_moved or lay_out_exchanged", "step"};
  if (stage_ != from) throw std::logic_error(text_of("Cement: ", call, " was called after ", kLast[static_cast<int>(stage_)]));
  stage_ = to;
}

void Cement::lay_out_run() {
  stage_ = Stage::laid_out;
  NewPartsOfBonds parts = arrangement_.parts_at_start();
  arrangement_.remember_axis();
  condensing_.choose();
  arrangement_.lay_out(scene_.all_rows(), std::move(parts), {});
  condensing_.bind();
  open_places_of_files(scene_);
  // Another time step needs other added mass than the last one, from a restart file too.
  const double dt = std::exchange(scene_.now.dt, scene_.dt_last);
  added_.refresh();
  scene_.now.dt = dt;
  if (dt != scene_.dt_last) scene_.books.release_by([&] { return added_.energy_ahead(scene_.all_rows(), 0.0); }, [&] { added_.refresh(); });
  parting_.take_up();
  stable_step_.find_film();
  condensing_.condense(scene_.all_rows(), true);
}

void Cement::lay_out_exchanged() {
  go_on("lay_out_exchanged", Stage::grains_moved, Stage::grains_moved);
  std::vector<int> mine;
  for (const Bond& b : scene_.bonds())
    if (scene_.formulation->needs_layout(b)) mine.push_back(b.body);
  int moved = !mine.empty() || scene_.grains.changed(), any;
  MPI_Allreduce(&moved, &any, 1, MPI_INT, MPI_MAX, scene_.comm);
  const std::vector<int> rows = scene_.agreed_rows(mine);
  if (!any && rows.empty()) return;
  arrangement_.lay_out(rows, arrangement_.parts_at_start(), {});
  condensing_.bind();
  scene_.grains.distribute_as_before(scene_.bonds(), scene_.now.dt);  // places go on before the cement follows its grains
  added_.refresh(rows);
  condensing_.condense(rows, false);
}

void Cement::change_step() {
  scene_.grains.start_spreading(scene_.now.substeps);
  kinematics_->change_step();
}

void Cement::show_points() {
  sync_slots();
  condensed_.show_strains(scene_.bonds());
}

// Uses layouts of copies. The layout of the run comes later, when other fixes have taken up the step.
EigenvalueEstimate Cement::eigenvalue_of_new_layout() const {
  if (stable_step_.bound_alone()) return stable_step_.eigenvalue();
  const std::vector<BondLayout> layouts = layouts_of_copies(nullptr);
  std::vector<EigenvaluePart> of_layouts;
  for (const BondLayout& l : layouts) of_layouts.push_back({&l.points, &l.grid, scene_.options.unilateral});
  const int ranks = ranks_of(scene_.comm), me = rank_in(scene_.comm);
  std::vector<int> patterns;
  for (int row : scene_.bonds().rows_without_points())
    if (scene_.bonds().table[row].pattern % ranks == me) patterns.push_back(scene_.bonds().table[row].pattern);
  sort_unique(patterns);
  const std::vector<CondensedBonds::OfPattern> of_patterns = layouts_of_patterns(scene_, patterns, nullptr);
  for (const CondensedBonds::OfPattern& p : of_patterns) of_layouts.push_back({&p.bond.points, &p.bond.grid, scene_.options.unilateral});
  return largest_eigenvalue(scene_.comm, of_layouts, *scene_.law, kPreciseEigenvalue);
}

std::vector<StiffnessOfBond> Cement::stiffness_of_bonds() const { return mpdem::stiffness_of_bonds(scene_, layouts_of_copies(&*scene_.penalty)); }

void Cement::set_density(double density) {
  if (scene_.bodies_started > 0 && std::fabs(density - scene_.density()) > 1e-12 * density)
    throw BadState(text_of("the density of the points is ", density, ", and was ", scene_.density(), " in the steps before; change it before the first run"));
  scene_.inertia = scene_.options.mass_scale * density;
}

void Cement::take_up_commands() {
  BondedGrains& grains = scene_.grains;
  if (!scene_.penalty || !grains.find_commands(scene_.comm, condensed_.pack())) return;
  scene_.books.do_work(condensed_.work_of_commands(scene_.bonds(), scene_.dt_last));
  if (added_.any()) {
    const auto power = [&](auto of_bond) {  // of the forces on nodes in the second half of the last step
      double sum = 0.0;
      for (const Bond& b : scene_.bonds().awake()) sum += of_bond(b, b.grid.acceleration);
      return 0.25 * scene_.dt_last * (scene_.dt_last + scene_.now.dt) * sum;
    };
    const auto of_loads = [&](const Bond& b, const std::vector<double>& v) { return work_.load_power(b, v); };
    const auto inertial = [&](const Bond& b, const std::vector<double>& v) { return work_.inertial_power(b, v); };
    const double loads_before = power(of_loads), inertial_before = power(inertial);
    grains.take_up_commands(scene_.comm, scene_.bonds(), scene_.now.dt, scene_.dt_last, scene_.books);
    scene_.books.do_work(power(of_loads) - loads_before);
    scene_.books.do_inertial_work(power(inertial) - inertial_before);
  }
  grains.book_commands(scene_.dt_last, scene_.books);
}

void Cement::start_run() {
  go_on("start_run", Stage::laid_out, Stage::between_steps);
  BondedGrains& grains = scene_.grains;
  scene_.substep = scene_.now.substeps;
  grains.start_spreading(scene_.now.substeps);
  kinematics_->start_run();  // added mass with the eigenvalue as it is known now
  if (scene_.penalty && scene_.bodies_started < static_cast<int>(scene_.bonds().table.size()))
    grains.start_added_mass(scene_.comm, scene_.bonds(), scene_.bodies_started, added_.any(), scene_.books);
  condensed_.follow(grains, scene_.weight().data());
  std::vector<std::vector<double>> before;
  const bool new_step = scene_.bodies_started > 0 && scene_.now.dt != scene_.dt_last;
  if (new_step)
    for (const Bond& b : scene_.bonds().awake()) before.push_back(b.grid.acceleration);
  grains.resume_sudden_loads(scene_.now.dt);
  kinematics_->find_internal_force();
  forces_.find_at_start();
  if (new_step) keep_half_kicks(before);
  if (scene_.penalty) forces_.react();
  start_bodies();
  grains.show_loads(scene_.now.substeps);
}

// A new time step comes with other added mass, so accelerations are not those that the last step found. The grains made
// the half kick of the last step with these. So do the nodes, by what the whole kick that is to come lacks of it.
void Cement::keep_half_kicks(const std::vector<std::vector<double>>& accelerations) {
  auto before = accelerations.begin();
  for (Bond& b : scene_.bonds().awake()) {
    std::vector<double>& v = b.grid.velocity;
    const std::vector<double>& was = *before++;
    for (std::size_t i = 0; i < v.size() && b.body < scene_.bodies_started; ++i) v[i] += 0.5 * scene_.dt_last * (was[i] - b.grid.acceleration[i]);
  }
}

// Velocities of bodies that were not in motion yet go back half a step. Their energy counts from here. So does the work
// of the first half step, which is ahead.
void Cement::start_bodies() {
  const int rows = static_cast<int>(scene_.bonds().table.size());
  if (scene_.bodies_started == rows) return;
  const double damped_ahead = 0.5 * scene_.dt_last * work_.of_dampers(scene_.bodies_started).after(0.5 * scene_.dt_last);  // uses the velocities of this time
  if (scene_.penalty) scene_.grains.go_back_half_a_step(scene_.bonds(), scene_.dt_last);
  double mine = 0.0, energy;
  for (Bond& b : scene_.bonds().awake()) {
    if (b.body < scene_.bodies_started) continue;
    Grid& grid = b.grid;
    for (int i = 0; i < grid.size(); ++i)
      for (int d = 0; d < 3; ++d) {
        double& v = grid.velocity[3 * i + d];
        const double kick = 0.5 * scene_.dt_last * grid.acceleration[3 * i + d];
        if (grid.halo.counts_here()[i]) mine += 0.5 * grid.mass[i] * (v - kick) * (v + kick);
        v -= kick;
      }
    b.links.add_spring_energy(grid, scene_.grains.side_of(b), mine);
    for (const auto& p : b.parts) p->add_energy(b.points, grid, scene_.grains.side_of(b), mine, mine);
    mine += b.added.energy(grid, scene_.grains.side_of(b), 0.0, scene_.dt_last);
    scene_.formulation->start(b);
  }
  condensed_.resume(scene_.grains, scene_.weight().data());
  for (int row = scene_.bodies_started; row < rows; ++row) {
    const CondensedBonds::Energies e = condensed_.energies_of(row, scene_.bonds(), 0.5 * scene_.dt_last);
    mine += e.elastic + e.discrete_kinetic;
  }
  MPI_Allreduce(&mine, &energy, 1, MPI_DOUBLE, MPI_SUM, scene_.comm);
  scene_.books.start(energy, work_.of_loads(scene_.bodies_started), work_.of_inertial_forces(scene_.bodies_started), damped_ahead);
  scene_.bodies_started = rows;
}

void Cement::start_step(bool commands) {
  go_on("start_step", Stage::between_steps, Stage::step_started);
  if (commands) take_up_commands();
  substeps_.begin();
}

void Cement::grains_moved() {
  go_on("grains_moved", Stage::step_started, Stage::grains_moved);
  if (scene_.now.substeps > 1) take_substeps();
  else scene_.grains.turn(scene_.now.dt);
}

void Cement::step() {
  go_on("step", Stage::grains_moved, Stage::step_taken);
  const FlushDenormals flush;
  scene_.substep = scene_.now.substeps;
  scene_.grains.spread_loads(scene_.now.substeps);
  advance();
  scene_.grains.watch_late_loads(false);
}

void Cement::take_substeps() {
  substeps_.find_ways();
  for (scene_.substep = 1; scene_.substep < scene_.now.substeps; ++scene_.substep) {
    substeps_.move_grains();
    advance();
    substeps_.kick_grains();
    end_substep();
  }
  substeps_.move_grains();
}

void Cement::advance() {
  const FlushDenormals flush;
  BondedGrains& grains = scene_.grains;
  // grains: the way in which they came here
  grains.find_rates(scene_.now.dt, scene_.dt_last, static_cast<long>(scene_.now.number), scene_.books);
  scene_.timer.start(StepTimer::kCoupling);
  const std::vector<int> moved = move_places(scene_);
  grains.distribute(scene_.bonds());
  condensed_.follow(grains, scene_.weight().data());
  grains.clear_sudden_forces();
  added_.follow_places(moved);
  // bonds that come apart
  parting_.look();
  // nodes, points, links
  forces_.begin(scene_.now.dt);
  kinematics_->advance();
  forces_.end_pass();
  // accelerations of nodes and grains
  condensed_.pack().find_jump_loads(scene_.now.dt);
  forces_.find_accelerations();
  scene_.books.end_step_of_dampers(work_.over_step(work_.of_dampers(0)), work_.over_step(work_.of_rubbing()));
  kinematics_->account_for_accelerations();
  // loads on the grains
  scene_.timer.start(StepTimer::kCoupling);
  grains.keep_loads();
  forces_.react();
  // bonds that wake, and those that are condensed again
  if (condensing_.change()) find_forces_anew();
  scene_.timer.stop();
}

// Finds the forces of the step anew, in the way in which they are found at the start of a run.
void Cement::find_forces_anew() {
  scene_.grains.take_back_loads();
  scene_.grains.distribute(scene_.bonds());
  condensed_.follow(scene_.grains, scene_.weight().data());
  condensed_.pack().find_jump_loads(scene_.now.dt);
  kinematics_->find_internal_force();
  forces_.find_at_start();
  forces_.react();
  scene_.grains.book_loads_taken_back(scene_.dt_last, scene_.books);
  condensing_.book_changes();
}

void Cement::end_step() {
  go_on("end_step", Stage::step_taken, Stage::between_steps);
  scene_.grains.watch_late_loads(true);
  end_substep();
  report_.note_peaks();
  scene_.grains.show_loads(scene_.now.substeps);
}

void Cement::end_substep() {
  scene_.grains.keep_velocities(scene_.dt_last);
  parting_.watch_loads();
  scene_.books.end_step(work_.of_loads(0), work_.of_inertial_forces(0));
  std::vector<Body>& table = scene_.bonds().table;
  for (auto b = table.rbegin(); b != table.rend() && !b->in_motion; ++b) b->in_motion = true;
}

void Cement::check_state() {
  std::string trouble;
  for (Bond& b : scene_.bonds().awake()) {
    for (const auto& p : b.parts) {
      const std::string of_part = p->trouble(b.points, b.grid, static_cast<long>(scene_.now.number));
      if (trouble.empty()) trouble = of_part;
    }
    if (!b.grid.finite() && trouble.empty())
      trouble = text_of("a node of the grid is not finite at step ", scene_.now.number,
                        "; check the motion of the grains, the time step and the contact model");
  }
  const int orphan = scene_.grains.sides.orphan() >= 0 ? scene_.grains.sides.sides[scene_.grains.sides.orphan()].tag : condensed_.pack().orphan();
  if (scene_.penalty && orphan != 0)
    trouble = text_of("grain ", orphan, " has cement but was deleted or lost at step ", scene_.now.number,
                      "; keep bonded grains, or use a larger box");
  throw_if_any(scene_.comm, trouble);
}

}  // namespace mpdem
