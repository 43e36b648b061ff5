// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Layouts, start and steps of a run. Restart is in state.cpp.
#include "cement.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "../../mpm/point_state.h"
#include "../../numerics/flush_denormals.h"
#include "../../numerics/sort_unique.h"
#include "../../parallel/agree.h"
#include "../../parallel/ranks.h"
#include "../condensed/template_layouts.h"
#include "../step/contact_remapping.h"
#include "../step/formulations.h"

namespace mpdem {

Cement::Cement(MPI_Comm comm, Bonds& bonds, const CementOptions& options, std::shared_ptr<const Law> law, CementHost& host)
    : scene_(comm, bonds, host, options, formulation_of(options), std::move(law)) {
  const KinematicsContext context{scene_, shared_, added_, layout_manager_, forces_, work_};
  discontinuities_.splits = scene_.formulation->splits();
  kinematics_ = scene_.formulation->kinematics(context);
}

// Resets layers and connectivity of the points, so that another fix starts from bonds without cracks.
Cement::~Cement() {
  for (Bond& b : scene_.bonds())
    for (BlockMeta& m : b.points.meta) {
      m.layer = m.split_checked = 0;
      m.connected[0] = m.connected[1] = 0xff;
    }
}

void Cement::couple(const PenaltyParameters* penalty) {
  scene_.penalty.reset();
  if (penalty) scene_.penalty = *penalty;
}

void Cement::set_elastic_grains(const std::vector<ElasticPair>& of_rows) {
  mpdem::set_elastic_grains(scene_.comm, scene_.bonds(), of_rows);
  const auto is_elastic = [](const BondRecord& r) { return r.grain_E[0] + r.grain_E[1] > 0.0; };
  for (const BondRecord& r : scene_.bonds().table)
    if (r.is_thinner_than(scene_.options.cell) && !is_elastic(r))
      throw BadState(text_of("'cell ", scene_.options.cell, "' is larger than the cement between grains ", r.grain[0], " and ", r.grain[1],
                             " is thick (", r.thickness, "), and cells do not resolve that between rigid grains; use 'film joined' of ",
                             "create_cement, a smaller cell and spacing, or 'grains elastic'"));
  const bool any = std::any_of(scene_.bonds().table.begin(), scene_.bonds().table.end(), is_elastic);
  // Condensed bonds do not know the loads of others, and the load of a bond must not jump where it is resolved.
  scene_.elastic_grains = !any ? ElasticGrains::none : scene_.options.condense ? ElasticGrains::apart : ElasticGrains::coupled;
}

void Cement::read_point_states() {
  std::string trouble;
  for (Bond& b : scene_.bonds())
    for (PointStore* store : b.stores())
      if (trouble.empty()) trouble = mpdem::read_point_states(*store, scene_.law);
  throw_if_any(scene_.comm, trouble);
}

void Cement::points_were_made(const std::vector<int>& rows) {
  layout_manager_.points_were_made(rows);
  condensing_.points_were_made();
}

void Cement::go_on(const char* call, Stage from, Stage to) {
  static constexpr const char* kLast[] = {
      "nothing", "lay_out_run", "start_run or end_step", "start_step", "grains_moved or lay_out_exchanged", "step"};
  if (stage_ != from) throw std::logic_error(text_of("Cement: ", call, " was called after ", kLast[static_cast<int>(stage_)]));
  stage_ = to;
}

void Cement::lay_out_run() {
  stage_ = Stage::laid_out;
  NewLayersOfBonds layers = layout_manager_.layers_at_start();
  layout_manager_.remember_axis();
  condensing_.choose();
  layout_manager_.lay_out(scene_.all_rows(), std::move(layers), {});
  condensing_.bind();
  open_contacts_of_files(scene_);
  // The added mass depends on the time step. It is found for the last step first, which the energy balance has counted, and
  // then for the step of this run. The difference of energy counts as released.
  const double dt = std::exchange(scene_.now.dt, scene_.dt_last);
  added_.refresh();
  scene_.now.dt = dt;
  if (dt != scene_.dt_last)
    scene_.energy.release_by([&] { return added_.energy_ahead(scene_.all_rows(), 0.0); }, [&] { added_.refresh(); });
  topology_.add_bonds();
  stable_step_.find_film();
  condensing_.condense(scene_.all_rows(), true);
}

void Cement::lay_out_exchanged() {
  go_on("lay_out_exchanged", Stage::grains_moved, Stage::grains_moved);
  std::vector<int> mine;
  for (const Bond& b : scene_.bonds())
    if (scene_.formulation->needs_layout(b)) mine.push_back(b.row);
  int moved = !mine.empty() || scene_.grains.changed(), any;
  MPI_Allreduce(&moved, &any, 1, MPI_INT, MPI_MAX, scene_.comm);
  const std::vector<int> rows = scene_.agreed_rows(mine);
  if (!any && rows.empty()) return;
  layout_manager_.lay_out(rows, layout_manager_.layers_at_start(), {});
  condensing_.bind();
  scene_.grains.distribute_as_before(scene_.bonds(), scene_.now.dt);  // contacts are remapped before the cement follows its grains
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

std::vector<PenaltyLinks::LinkTraction> Cement::link_tractions(const Bond& b) const {
  if (condensed_.has(b.row)) return condensed_.link_tractions(b, scene_.bonds().record(b));
  if (b.links.empty()) return std::vector<PenaltyLinks::LinkTraction>(b.points.links.size());
  return b.links.tractions(b.points, b.grid, scene_.grains.ends_of(b));
}

// Uses layouts of copies, since other fixes need the time step before the layout of the run is made.
EigenvalueEstimate Cement::eigenvalue_of_new_layout() const {
  if (stable_step_.bound_alone()) return stable_step_.eigenvalue();
  const std::vector<BondLayout> layouts = layouts_of_copies(nullptr);
  std::vector<EigenvalueSystem> of_layouts;
  for (const BondLayout& l : layouts) of_layouts.push_back({&l.points, &l.grid, scene_.options.unilateral});
  const int ranks = ranks_of(scene_.comm), me = rank_in(scene_.comm);
  std::vector<int> templates;
  for (int row : scene_.bonds().rows_without_points())
    if (scene_.bonds().table[row].point_template % ranks == me) templates.push_back(scene_.bonds().table[row].point_template);
  sort_unique(templates);
  const std::vector<CondensedBonds::TemplateBond> template_bonds = layouts_of_templates(scene_, templates, nullptr);
  for (const CondensedBonds::TemplateBond& p : template_bonds)
    of_layouts.push_back({&p.bond.points, &p.bond.grid, scene_.options.unilateral});
  return largest_eigenvalue(scene_.comm, of_layouts, *scene_.law, kPreciseEigenvalue);
}

std::vector<StiffnessOfBond> Cement::stiffness_of_bonds() const {
  return mpdem::stiffness_of_bonds(scene_, layouts_of_copies(&*scene_.penalty));
}

void Cement::set_density(double density) {
  constexpr double kRounding = 1e-12;
  const std::vector<BondRecord>& table = scene_.bonds().table;
  const bool in_use = scene_.options.split || std::any_of(table.begin(), table.begin() + scene_.rows_started, [](const BondRecord& b) {
                        return b.volume - b.own_volume > kRounding * b.volume;
                      });
  if (scene_.rows_started > 0 && in_use && std::fabs(density - scene_.density()) > kRounding * density)
    throw BadState(text_of("the density of the points is ", density, ", and was ", scene_.density(),
                           " in the steps before; change it before the first run"));
  scene_.scaled_density = scene_.options.mass_scale * density;
  discontinuities_.splits->set_density(scene_.inertia());
}

void Cement::read_commanded_velocities() {
  BondedGrains& grains = scene_.grains;
  if (!scene_.penalty || !grains.find_commands(scene_.comm, condensed_.pack())) return;
  scene_.energy.do_work(condensed_.work_of_commands(scene_.bonds(), scene_.dt_last));
  if (added_.any()) {
    // A command changes accelerations through the added mass, so forces on the nodes do another work in the second half of
    // the last step. work() is the part of this work that depends on the accelerations: on the velocity kick() times the
    // acceleration.
    const auto work = [&](auto of_bond) {
      double sum = 0.0;
      for (const Bond& b : scene_.bonds().resolved()) sum += of_bond(b, b.grid.acceleration);
      return 0.25 * scene_.dt_last * (scene_.dt_last + scene_.now.dt) * sum;
    };
    const auto of_loads = [&](const Bond& b, const std::vector<double>& v) { return work_.load_power(b, v); };
    const auto inertial = [&](const Bond& b, const std::vector<double>& v) { return work_.inertial_power(b, v); };
    const double loads_before = work(of_loads), inertial_before = work(inertial);
    grains.read_commanded_velocities(scene_.comm, scene_.bonds(), scene_.now.dt, scene_.dt_last, scene_.energy);
    scene_.energy.do_work(work(of_loads) - loads_before);
    scene_.energy.do_inertial_work(work(inertial) - inertial_before);
  }
  grains.count_commands(scene_.dt_last, scene_.energy);
}

void Cement::start_run() {
  go_on("start_run", Stage::laid_out, Stage::between_steps);
  BondedGrains& grains = scene_.grains;
  scene_.substep = scene_.now.substeps;
  grains.start_spreading(scene_.now.substeps);
  kinematics_->start_run();  // finds the added mass with the present estimate of the eigenvalue
  if (scene_.penalty && scene_.rows_started < static_cast<int>(scene_.bonds().table.size()))
    grains.start_added_mass(scene_.comm, scene_.bonds(), scene_.rows_started, added_.any(), scene_.energy);
  condensed_.follow(grains, scene_.weight().data());
  std::vector<std::vector<double>> before;  // accelerations of the last run
  const bool new_step = scene_.rows_started > 0 && scene_.now.dt != scene_.dt_last;
  if (new_step)
    for (const Bond& b : scene_.bonds().resolved()) before.push_back(b.grid.acceleration);
  grains.resume_sudden_loads(scene_.now.dt);
  kinematics_->find_internal_force();
  forces_.find_at_start();
  if (new_step) correct_half_kicks(before);
  if (scene_.penalty) forces_.react();
  start_bonds();
  grains.set_reported_loads(scene_.now.substeps);
}

// A new time step changes the added mass, and so the accelerations. The grains made the second half kick of the last
// step with the former accelerations. Nodes make both half kicks at once with the new ones, so their velocities get the
// difference here.
void Cement::correct_half_kicks(const std::vector<std::vector<double>>& accelerations) {
  auto before = accelerations.begin();
  for (Bond& b : scene_.bonds().resolved()) {
    std::vector<double>& v = b.grid.velocity;
    const std::vector<double>& was = *before++;
    for (std::size_t i = 0; i < v.size() && b.row < scene_.rows_started; ++i)
      v[i] += 0.5 * scene_.dt_last * (was[i] - b.grid.acceleration[i]);
  }
}

// Shifts the velocities of new bonds back by half a step, as central differences store them. The energy of new bonds is
// counted from here, with the work of the first half step, which is counted in advance. The kinetic energy is the one
// that central differences conserve: the product of the velocities half a step before and after.
void Cement::start_bonds() {
  const int rows = static_cast<int>(scene_.bonds().table.size());
  if (scene_.rows_started == rows) return;
  const double damped_ahead =
      0.5 * scene_.dt_last * work_.of_dampers(scene_.rows_started).after(0.5 * scene_.dt_last);  // before the velocities are shifted
  if (scene_.penalty) scene_.grains.stagger_velocities(scene_.bonds(), scene_.dt_last);
  double mine = 0.0, energy;
  for (Bond& b : scene_.bonds().resolved()) {
    if (b.row < scene_.rows_started) continue;
    Grid& grid = b.grid;
    for (int i = 0; i < grid.size(); ++i)
      for (int d = 0; d < 3; ++d) {
        double& v = grid.velocity[3 * i + d];
        const double kick = 0.5 * scene_.dt_last * grid.acceleration[3 * i + d];
        if (grid.halo.counts_here()[i]) mine += 0.5 * grid.mass[i] * (v - kick) * (v + kick);
        v -= kick;
      }
    b.links.add_spring_energy(grid, scene_.grains.ends_of(b), mine);
    for (const auto& p : b.mechanisms) p->add_energy(b.points, grid, scene_.grains.ends_of(b), mine, mine);
    mine += b.added.energy(grid, scene_.grains.ends_of(b), 0.0, scene_.dt_last);
    scene_.formulation->start(b);
  }
  condensed_.resume(scene_.grains, scene_.weight().data());
  for (int row = scene_.rows_started; row < rows; ++row) {
    const CondensedBonds::Energies e = condensed_.energies_of(row, scene_.bonds(), 0.5 * scene_.dt_last);
    mine += e.elastic + e.discrete_kinetic;
  }
  MPI_Allreduce(&mine, &energy, 1, MPI_DOUBLE, MPI_SUM, scene_.comm);
  scene_.energy.start(energy, work_.of_loads(scene_.rows_started), work_.of_inertial_forces(scene_.rows_started), damped_ahead);
  scene_.rows_started = rows;
}

void Cement::start_step(bool commands) {
  go_on("start_step", Stage::between_steps, Stage::step_started);
  if (commands) read_commanded_velocities();
  substeps_.begin();
}

void Cement::grains_moved() {
  go_on("grains_moved", Stage::step_started, Stage::grains_moved);
  if (scene_.now.substeps > 1) take_substeps();
  else scene_.grains.rotate(scene_.now.dt);
}

void Cement::step() {
  go_on("step", Stage::grains_moved, Stage::step_taken);
  const FlushDenormals flush;
  scene_.substep = scene_.now.substeps;
  scene_.grains.spread_loads(scene_.now.substeps);
  advance();
  scene_.grains.record_late_loads(false);
}

void Cement::take_substeps() {
  substeps_.find_paths();
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
  // Grains: motion to their present positions, and contact points of failed points.
  grains.update_kinematics(scene_.now.dt, scene_.dt_last, static_cast<long>(scene_.now.number), scene_.energy);
  scene_.timer.start(StepTimer::kCoupling);
  const std::vector<int> moved = remap_contacts(scene_);
  grains.distribute(scene_.bonds());
  condensed_.follow(grains, scene_.weight().data());
  grains.clear_sudden_forces();
  added_.follow_contacts(moved);
  // Separation of bonds and node splitting.
  topology_.update();
  // Motion of nodes, then stress of points, then internal forces and forces of links.
  forces_.begin(scene_.now.dt);
  kinematics_->advance();
  forces_.end_pass();
  // Accelerations of free grains, then of nodes.
  condensed_.pack().find_jump_loads(scene_.now.dt);
  forces_.find_accelerations();
  scene_.energy.end_step_of_dampers(work_.over_step(work_.of_dampers(0)), work_.over_step(work_.of_friction()));
  kinematics_->account_for_accelerations();
  // Loads on the grains.
  scene_.timer.start(StepTimer::kCoupling);
  grains.save_loads();
  forces_.react();
  // Bonds near their threshold are activated, and resting bonds condensed again.
  scene_.timer.hold(StepTimer::kCondensing);
  if (condensing_.change()) find_forces_anew();
  scene_.timer.stop();
}

// Finds the forces in the way of the start of a run, so that a run divided at this step gives the same result.
void Cement::find_forces_anew() {
  scene_.grains.restore_loads();
  scene_.grains.distribute(scene_.bonds());
  condensed_.follow(scene_.grains, scene_.weight().data());
  condensed_.pack().find_jump_loads(scene_.now.dt);
  kinematics_->find_internal_force();
  forces_.find_at_start();
  forces_.react();
  scene_.grains.correct_work_of_withdrawn_loads(scene_.dt_last, scene_.energy);
  condensing_.count_changes();
}

void Cement::end_step() {
  go_on("end_step", Stage::step_taken, Stage::between_steps);
  scene_.grains.record_late_loads(true);
  end_substep();
  report_.note_peaks();
  scene_.grains.set_reported_loads(scene_.now.substeps);
}

void Cement::end_substep() {
  scene_.grains.keep_velocities(scene_.dt_last);
  topology_.watch_loads();
  scene_.energy.end_step(work_.of_loads(0), work_.of_inertial_forces(0));
  std::vector<BondRecord>& table = scene_.bonds().table;
  for (auto b = table.rbegin(); b != table.rend() && !b->in_motion; ++b) b->in_motion = true;
}

void Cement::check_state() {
  std::string trouble;
  for (Bond& b : scene_.bonds().resolved()) {
    for (const auto& p : b.mechanisms) {
      const std::string of_member = p->trouble(b.points, b.grid, static_cast<long>(scene_.now.number));
      if (trouble.empty()) trouble = of_member;
    }
    if (!b.grid.finite() && trouble.empty())
      trouble = text_of("a node of the grid is not finite at step ", scene_.now.number,
                        "; check the motion of the grains, the time step and the contact model");
  }
  const int orphan =
      scene_.grains.ends.orphan() >= 0 ? scene_.grains.ends.ends[scene_.grains.ends.orphan()].tag : condensed_.pack().orphan();
  if (scene_.penalty && orphan != 0)
    trouble = text_of("grain ", orphan, " has cement but was deleted or lost at step ", scene_.now.number,
                      "; keep bonded grains, or use a larger box");
  throw_if_any(scene_.comm, trouble);
}

}  // namespace mpdem
