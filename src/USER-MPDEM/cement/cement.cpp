// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A run of the cement: start, steps, their ends. Layout is in arrangement.cpp, what is told in report.cpp, restart in state.cpp.
#include "cement.h"

#include <algorithm>
#include <cmath>

#include "../mpm/point_state.h"
#include "../parallel/agree.h"
#include "kinematics.h"

namespace mpdem {

Cement::Cement(MPI_Comm comm, Bonds& bonds, const CementOptions& options, std::shared_ptr<const Law> law, CementHost& host)
    : comm_(comm), bonds_(bonds), options_(options), law_(std::move(law)), host_(host) {
  kinematics_ = options_.updated ? make_updated(*this) : make_total(*this);
}

// Clears the marks of parts, so that another fix starts from whole bonds.
Cement::~Cement() {
  if (!options_.split) return;
  for (Bond& b : bonds_)
    for (BlockMeta& m : b.points.meta) {
      m.part = m.looked_at = 0;
      m.holds[0] = m.holds[1] = 0xff;
    }
}

void Cement::set_density(double density) { inertia_ = options_.mass_scale * density; }

void Cement::couple(const PenaltyParameters* penalty) {
  penalty_.reset();
  if (penalty) penalty_ = *penalty;
}

void Cement::take_up_states() {
  std::string trouble;
  for (Bond& b : bonds_)
    if (trouble.empty()) trouble = mpdem::take_up_states(b.points, law_);
  throw_if_any(comm_, trouble);
}

void Cement::take_up_commands() {
  if (!(layout_.any_added_mass || condensed_.any()) || !grains_.find_commands(comm_, condensed_.pack())) return;
  books_.do_work(condensed_.work_of_commands(bonds_, dt_last_));
  if (layout_.any_added_mass) grains_.take_up_commands(comm_, bonds_, now_.dt, dt_last_, books_);
}

void Cement::step() {
  substep_ = now_.substeps;
  advance();
}

void Cement::advance() {
  grains_.find_rates(now_.dt, dt_last_, books_);
  if (now_.substeps > 1 && ends_step()) grains_.spread_loads(now_.substeps);
  timer_.start(StepTimer::kCoupling);
  const std::vector<int> moved = move_places();
  grains_.distribute(bonds_);
  condensed_.follow(grains_, weight_of_cement().data());
  refresh_for_places(moved);
  look_for_cracks();
  advance_.dissipated = advance_.released = 0.0;
  kinematics_->advance();
  books_.dissipate(advance_.dissipated);
  books_.release(advance_.released);
  if (condensed_.any()) condensed_.pack()->find_jump_loads(now_.dt);
  complete_forces();
  books_.end_step_of_dampers(step_work(damping_power(0)), step_work(rubbing_power()));
  kinematics_->account_for_accelerations();
  timer_.start(StepTimer::kCoupling);
  react();
  if (ends_step()) grains_.watch_late_loads(false);
  wake_bonds();
  condense_again();
  timer_.stop();
}

// Of its points, nodes and links, as central differences keep it.
double Cement::energy_of(const Bond& b) const {
  PointSums points;
  points.add(b.points, *law_, true);
  double energy = points.elastic + b.added.energy(b.grid, grains_.side_of(b), 0.0, dt_last_);
  b.links.add_spring_energy(b.grid, grains_.side_of(b), energy);
  for (int i = 0; i < b.grid.size(); ++i) {
    if (!b.grid.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) {
      const double v = b.grid.velocity[3 * i + d];
      energy += 0.5 * b.grid.mass[i] * v * (v + dt_last_ * b.grid.acceleration[3 * i + d]);
    }
  }
  return energy;
}

// After a check; not in it, where the forces of the step are still to be shown, and which may
// be the step of a restart file.
void Cement::look_for_cracks() {
  if (!can_break() || !begins_step()) return;
  const bool after_check = (now_.number - 1) % options_.check_every == 0;
  if (!after_check && (now_.number - 1) % kWatchEvery != 0) return;
  if (options_.split) {
    timer_.start(StepTimer::kLayout);
    split_nodes();
  }
  if (after_check) cracks_.give_way(comm_, bonds_, sheets_, options_, load_watch_.look(comm_, bonds_.table, shear_speed()), keeps_skins(), now_.number - 1);
  if (!after_check && !cracks_.some_path_is_cut(comm_)) return;
  timer_.start(StepTimer::kLayout);
  if (after_check) drop_inert_added_mass();
  Cracks::Found found = look_at_bonds(after_check);
  const std::vector<int> held = found.held;
  if (options_.split) part_bonds(found.lay_out, std::move(found.parts));
  else lay_out_parts(std::move(found));
  for (int row : held)
    if (Bond* b = bonds_.find(row)) find_relaxation(*b);
}

// Bonds that hold by bridges alone that are narrower than a cell come apart there.
Cracks::Found Cement::look_at_bonds(bool debris) {
  Cracks::Found found = cracks_.look(comm_, bonds_, sheets_, options_, debris);
  if (!options_.split) return found;
  Splits::Found split = splits_.come_apart(comm_, bonds_, options_, found.pieces);
  found.parts = std::move(split.parts);
  found.lay_out.insert(found.lay_out.end(), split.lay_out.begin(), split.lay_out.end());
  std::sort(found.lay_out.begin(), found.lay_out.end());
  found.lay_out.erase(std::unique(found.lay_out.begin(), found.lay_out.end()), found.lay_out.end());
  return found;
}

void Cement::take_failed(Bond& b) {
  b.failed.clear();
  b.failed.swap(advance_.failed);
  if (!b.resting.asleep()) b.near_threshold = advance_.near_threshold;
  advance_.near_threshold = false;
}

void Cement::let_go(Bond& b) {
  if (b.failed.empty()) return;
  b.mass.forget();
  b.impulse.forget();
  sort_links(b);
  b.links.let_go(b.points, b.failed, b.grid, grains_.side_of(b), advance_.released);
  if (touches()) open_places(b, b.failed, {});
  if (options_.unilateral) {
    const double before = b.closing.energy(b.points, b.grid);
    b.closing.add(b.points, law_->elasticity(), b.failed);
    advance_.released -= b.closing.energy(b.points, b.grid) - before;
  }
  host_.points_failed(b);
  if (penalty_) cracks_.watch(b);
}

// Traction laws may dissipate and let go of points that hold.
void Cement::follow_links(Bond& b) {
  b.links.follow(b.points, b.grid, grains_.side_of(b), b.link_step);
  books_.dissipate(b.link_step.dissipated);
  books_.release(b.link_step.released);
  if (b.link_step.let_go.empty()) return;
  if (touches()) open_places(b, {}, b.link_step.let_go);
  host_.links_let_go(b);
  cracks_.watch_links(b);
}

// Everything but the internal force, which is on the nodes already.
void Cement::add_link_forces(Bond& b) {
  timer_.start(StepTimer::kCoupling);
  follow_links(b);
  if (!b.places.empty()) books_.rub(b.places.follow(b.points, b.grid, grains_.side_of(b)));
  if (options_.updated) b.links.add_force(b.grid, grains_.side_of(b));
  else b.resting.add_force(b.links, b.grid, grains_.side_of(b));
  b.places.add_force(b.grid, grains_.side_of(b));
  b.closing.add_force(b.points, b.grid);
  b.grid.ties.pull_back(b.grid.force.data());
}

void Cement::sum_shared(double* (*values)(Grid&), int width) {
  std::vector<double*> of_bonds;
  for (Bond& b : bonds_.awake())
    if (b.cut_by_ranks()) of_bonds.push_back(values(b.grid));
  layout_.shared_nodes.sum(of_bonds, width);
}

// Adds damping, weight, and forces of the host and of crack faces to nodes that have those of points and links already.
void Cement::complete_forces(Bond& b, double kick) {
  if (penalty_ && options_.relax > 0.0) b.relaxation.add_force(b.grid, grains_.side_of(b));
  const double* g = now_.gravity;
  if (g[0] != 0.0 || g[1] != 0.0 || g[2] != 0.0) {
    const std::array<double, 3> along = gravity_of(b);
    for (int i = 0; i < b.grid.size(); ++i)
      for (int d = 0; d < 3; ++d) b.grid.force[3 * i + d] += b.grid.mass[i] / options_.mass_scale * along[d];
  }
  host_.add_node_forces(b);
  if (faces_touch()) b.faces.add_force(b.points, b.grid, b.added.of_nodes(), kick, now_.dt);
}

// Bonds that ranks do not cut need not wait for others. Many small bonds do not fit into the cache, so each pass over them takes time to
// bring them there.
void Cement::begin_completing() {
  layout_.completes_early = true;
  if ((layout_.any_added_mass || condensed_.any()) && grains_.any_free() && options_.mass_order == 1) grains_.begin_sums();
}

// Completes a bond that ranks do not cut right after the forces of its links.
void Cement::complete_early(Bond& b) {
  if (!layout_.completes_early || b.cut_by_ranks()) return;
  complete_forces(b, now_.dt);
  grains_.sum_up(b);
}

// Forces of nodes from those of points and links, and the accelerations.
void Cement::complete_forces() {
  timer_.start(StepTimer::kHalo);
  sum_shared([](Grid& g) { return g.force.data(); }, 3);
  timer_.start(StepTimer::kNodes);
  for (Bond& b : bonds_.awake())
    if (!layout_.completes_early || b.cut_by_ranks()) complete_forces(b, 0.5 * (dt_last_ + now_.dt));
  layout_.completes_early = false;
  if (options_.mass_order > 1) add_inertial_forces();
  find_grain_accelerations();
  if (now_.substeps > 1 && ends_step()) share_impulses();
  if (condensed_.any()) condensed_.pack()->find_inertial_loads();
  // Backwards, since the last bonds are those that are still in cache, and the next step begins with the first.
  bonds_.for_each_awake_backwards([this](Bond& b, const Bond* next) {
    if (next) next->prefetch_nodes();
    b.added.accelerate(b.grid, grains_.side_of(b));
  });
}

void Cement::find_grain_accelerations() {
  if (!(layout_.any_added_mass || condensed_.any()) || !grains_.any_free()) return;
  timer_.start(StepTimer::kCoupling);
  using Loads = BondedGrains::Loads;
  grains_.find_accelerations(comm_, bonds_, now_.substeps == 1 ? Loads::all : Loads::spread, condensed_.pack());
  timer_.start(StepTimer::kNodes);
}

// With N the inertia of nodes, added mass and grains, of which the nodes have the lumped mass, and a = N^-1 f, the accelerations are
// N^-1 (f + (M_L - M) a). See mpm/consistent_mass.h.
void Cement::add_inertial_forces() {
  find_grain_accelerations();
  for (Bond& b : bonds_.awake()) {
    Grid& grid = b.grid;
    grid.inertial_force = grid.force;
    b.added.take_along(grid, grains_.side_of(b));
    grid.update_acceleration(b.added.of_nodes());
    grid.force.swap(grid.inertial_force);
    timer_.start(StepTimer::kPoints);
    b.mass.find_inertial_force(b.points, grid, inertia_);
    timer_.start(StepTimer::kNodes);
  }
  timer_.start(StepTimer::kHalo);
  sum_shared([](Grid& g) { return g.inertial_force.data(); }, 3);
  timer_.start(StepTimer::kNodes);
  for (Bond& b : bonds_.awake())
    for (std::size_t n = 0; n < b.grid.force.size(); ++n) b.grid.force[n] += b.grid.inertial_force[n];
}

double Cement::kinetic_energy(const Bond& b, double kick) const {
  const Grid& grid = b.grid;
  double twice[3] = {};  // of each component: their sums do not wait for each other
  for (int i = 0; i < grid.size(); ++i) {
    if (!grid.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) {
      const double v = grid.velocity[3 * i + d] + kick * grid.acceleration[3 * i + d];
      twice[d] += grid.mass[i] * v * v;
    }
  }
  return 0.5 * (twice[0] + twice[1] + twice[2]);
}

EnergyBooks::StepWork Cement::step_work(const Power& power) const {
  return {dt_last_ * power.after(0.5 * dt_last_), dt_last_ * power.stored};
}

// What dampers take of the cement of bodies from first_body on.
Power Cement::damping_power(int first_body) const {
  Power power;
  if (!penalty_ || (penalty_->damping == 0.0 && options_.relax == 0.0)) return power;
  for (const Bond& b : bonds_.awake()) {
    if (b.body < first_body) continue;
    power.add(b.links.damper_power(b.grid, grains_.side_of(b)));
    if (options_.relax > 0.0) power.add(b.relaxation.power(b.grid, grains_.side_of(b)));
  }
  return power;
}

// What friction of crack faces takes.
Power Cement::rubbing_power() const {
  Power power;
  if (!faces_touch()) return power;
  for (const Bond& b : bonds_.awake()) power.add(b.faces.power(b.grid));
  return power;
}

std::array<double, 3> Cement::gravity_of(const Bond& b) const { return turned_back(axes_of(bonds_.body(b)), now_.gravity); }

// Of the weight of this rank's nodes on a velocity.
double Cement::gravity_power(const Bond& b, const std::vector<double>& velocity) const {
  const std::array<double, 3> g = gravity_of(b);
  if ((g[0] == 0.0 && g[1] == 0.0 && g[2] == 0.0) || velocity.empty()) return 0.0;
  double power = 0.0;
  for (int i = 0; i < b.grid.size(); ++i) {
    if (!b.grid.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) power += b.grid.mass[i] / options_.mass_scale * g[d] * velocity[3 * i + d];
  }
  return power;
}

// What a change of velocity takes of the energy that central differences keep, beyond that of the stored velocity: it meets
// the acceleration, too.
double Cement::half_kick(const Bond& b, const std::vector<double>& jump) const {
  if (jump.empty()) return 0.0;
  double power[3] = {};  // of each component: their sums do not wait for each other
  for (int i = 0; i < b.grid.size(); ++i) {
    if (!b.grid.halo.counts_here()[i]) continue;
    for (int d = 0; d < 3; ++d) power[d] += b.grid.mass[i] * b.grid.acceleration[3 * i + d] * jump[3 * i + d];
  }
  return -0.5 * dt_last_ * (power[0] + power[1] + power[2] + b.added.power(b.grid, grains_.side_of(b), jump));
}

// Work of the inertial forces on the cement of bodies from first_body on.
EnergyBooks::StepWork Cement::inertial_work_of_step(int first_body) const {
  EnergyBooks::StepWork work;
  for (const Bond& b : bonds_.awake()) {
    if (b.body < first_body || options_.mass_order == 1) continue;
    const Grid& grid = b.grid;
    double before = 0.0, later = 0.0;
    for (int i = 0; i < grid.size(); ++i) {
      if (!grid.halo.counts_here()[i]) continue;
      for (int n = 3 * i; n < 3 * i + 3; ++n) {
        before += grid.inertial_force[n] * grid.velocity[n];
        later += grid.inertial_force[n] * grid.acceleration[n];
      }
    }
    work.before += dt_last_ * before;
    work.now += dt_last_ * before + 0.5 * dt_last_ * dt_last_ * later;
  }
  return work;
}

// Work of grains, gravity and impulses of the host on the cement of bodies from first_body on.
EnergyBooks::StepWork Cement::work_of_step(int first_body) {
  const bool pushed = now_.substeps > 1 && ends_step();
  EnergyBooks::StepWork work = penalty_ ? grains_.work(dt_last_, first_body) : EnergyBooks::StepWork();
  for (const Bond& b : bonds_.awake()) {
    if (b.body < first_body) continue;
    double before = dt_last_ * gravity_power(b, b.grid.velocity), later = gravity_power(b, b.grid.acceleration);
    if (pushed) {
      before += dt_last_ * b.impulse.power(b.grid, b.grid.velocity);
      later += b.impulse.power(b.grid, b.grid.acceleration);
    }
    work.now += before + 0.5 * dt_last_ * dt_last_ * later;
    work.before += before;
  }
  const EnergyBooks::StepWork of_condensed = condensed_.work(grains_, bonds_, weight_of_cement().data(), dt_last_, first_body);
  work.now += of_condensed.now;
  work.before += of_condensed.before;
  return work;
}

void Cement::end_step() {
  if (ends_step()) grains_.watch_late_loads(true);
  grains_.keep_velocities(dt_last_);
  if (can_break()) load_watch_.add(grains_, bonds_.table, dt_last_);
  books_.end_step(work_of_step(0), inertial_work_of_step(0));
  for (auto b = bonds_.table.rbegin(); b != bonds_.table.rend() && !b->in_motion; ++b) b->in_motion = true;
}

void Cement::check_state() {
  constexpr double kDeepest = 0.01;
  std::string trouble;
  for (const Bond& b : bonds_.awake())
    if (b.places.deepest() > kDeepest * options_.cell && trouble.empty())
      trouble = text_of("cement is pressed ", b.places.deepest(), " deep into a grain at step ", now_.number, ", the most is ", kDeepest,
                        " of a cell, ", kDeepest * options_.cell, "; use a larger 'kn' of fix mpm/couple or slower grains");
    else if (b.faces.too_far() > 0.0 && trouble.empty())
      trouble = text_of("faces of a crack in the cement touch after they slid ", b.faces.too_far(), " at step ", now_.number, ", with 'friction' the most is a cell, ",
                        options_.cell, "; end the run before, or use 'kinematics updated' without 'friction'");
    else if (!b.grid.finite() && trouble.empty())
      trouble = text_of("a node of the grid is not finite at step ", now_.number,
                        "; check the motion of the grains, the time step and the contact model");
  const int orphan = grains_.sides.orphan() >= 0 ? grains_.sides.sides[grains_.sides.orphan()].tag : condensed_.any() ? condensed_.pack()->orphan() : 0;
  if (penalty_ && orphan != 0)
    trouble = text_of("grain ", orphan, " has cement but was deleted or lost at step ", now_.number,
                      "; keep bonded grains, or use a larger box");
  throw_if_any(comm_, trouble);
}

void Cement::start_run() {
  substep_ = now_.substeps;
  grains_.start_spreading(now_.substeps);
  // added mass with the eigenvalue as it is known now
  if (!options_.updated && penalty_)
    books_.release_by([&] { return added_energy_ahead(all_rows(), 0.0); }, [&] { refresh_added_mass(); });
  if (penalty_ && bodies_started_ < static_cast<int>(bonds_.table.size()))
    grains_.start_added_mass(comm_, bonds_, bodies_started_, layout_.any_added_mass, books_);
  condensed_.follow(grains_, weight_of_cement().data());
  kinematics_->find_internal_force();
  grains_.sides.clear_forces();
  grains_.clear_sudden_forces();
  for (Bond& b : bonds_.awake()) {
    b.jump.clear();
    b.links.add_force(b.grid, grains_.side_of(b));
    b.places.add_force(b.grid, grains_.side_of(b));
    b.closing.add_force(b.points, b.grid);
    b.grid.ties.pull_back(b.grid.force.data());
  }
  complete_forces();
  if (penalty_) react();
  start_bodies();
}

// Velocities of bodies that were not in motion yet go back half a step. What they have of energy counts
// from here, and the work of the first half step, which is ahead.
void Cement::start_bodies() {
  const int rows = static_cast<int>(bonds_.table.size());
  if (bodies_started_ == rows) return;
  const double damped_ahead = 0.5 * dt_last_ * damping_power(bodies_started_).after(0.5 * dt_last_);  // by the velocities of this time
  if (penalty_) grains_.go_back_half_a_step(bonds_, dt_last_);
  double mine = 0.0, energy;
  for (Bond& b : bonds_.awake()) {
    if (b.body < bodies_started_) continue;
    Grid& grid = b.grid;
    for (int i = 0; i < grid.size(); ++i)
      for (int d = 0; d < 3; ++d) {
        double& v = grid.velocity[3 * i + d];
        const double kick = 0.5 * dt_last_ * grid.acceleration[3 * i + d];
        if (grid.halo.counts_here()[i]) mine += 0.5 * grid.mass[i] * (v - kick) * (v + kick);
        v -= kick;
      }
    b.links.add_spring_energy(grid, grains_.side_of(b), mine);
    b.places.add_energy(grid, grains_.side_of(b), mine);
    mine += b.added.energy(grid, grains_.side_of(b), 0.0, dt_last_);
    kinematics_->start_points(b);
  }
  condensed_.resume(grains_, weight_of_cement().data());
  for (int row = bodies_started_; row < rows; ++row) {
    const CondensedBonds::Energies e = condensed_.energies_of(row, bonds_, 0.5 * dt_last_);
    mine += e.elastic + e.kept;
  }
  MPI_Allreduce(&mine, &energy, 1, MPI_DOUBLE, MPI_SUM, comm_);
  books_.start(energy, work_of_step(bodies_started_), inertial_work_of_step(bodies_started_), damped_ahead);
  bodies_started_ = rows;
}

}  // namespace mpdem
