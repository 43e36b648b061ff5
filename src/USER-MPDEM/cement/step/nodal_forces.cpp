// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "nodal_forces.h"

#include <array>
#include <utility>
#include <vector>

#include "../../coupling/shared_impulse.h"
#include "../../mpm/consistent_mass.h"

namespace mpdem {

BondContext NodalForces::at_work(Bond& b) {
  return {b.points, b.grid, scene_.grains.ends_of(b), scene_.bonds().record(b), b.added.of_nodes(), scene_.now.dt, kick_};
}

void NodalForces::take_failed(Bond& b) {
  b.failed.clear();
  b.failed.swap(pass_result_.failed);
  b.near_threshold = pass_result_.near_threshold;
  pass_result_.near_threshold = false;
}

void NodalForces::debond(Bond& b) {
  if (b.failed.empty()) return;
  b.sort_links();
  std::vector<int> links = b.links.debond(b.points, b.failed, b.grid, scene_.grains.ends_of(b), scene_.now.dt, pass_result_.released);
  Losses losses;
  for (const auto& p : b.mechanisms) p->points_failed(at_work(b), b.failed, links, losses);
  pass_result_.released += losses.released;
  b.debonded_with_points.clear();
  if (!scene_.leaves_residue()) b.debonded_with_points = std::move(links);
  scene_.host().points_failed(b);
  if (scene_.penalty) cracks_.watch(b);
}

// Traction laws may dissipate energy, and may debond intact points.
void NodalForces::follow_links(Bond& b) {
  b.links.update_and_add_force(b.points, b.grid, scene_.grains.ends_of(b), scene_.now.dt, b.link_step);
  note_links(b);
}

void NodalForces::note_links(Bond& b) {
  scene_.energy.dissipate(b.link_step.dissipated);
  scene_.energy.release(b.link_step.released);
  if (b.link_step.debond.empty()) return;
  Losses losses;
  for (const auto& p : b.mechanisms) p->links_debonded(at_work(b), b.link_step.debond, losses);
  scene_.energy.release(losses.released);
  scene_.host().links_debonded(b);
  cracks_.note_debonded_links(b);
}

// Columns of a film follow the grains, which are already at their positions of the end of the step.
void NodalForces::advance_film(Bond& b) {
  AdvanceResult of_film;
  b.film.advance(scene_.grains.ends_of(b), *scene_.law, scene_.penalty ? scene_.penalty->law.get() : nullptr, scene_.now.dt,
                 scene_.options.advance, of_film);
  scene_.energy.dissipate(of_film.dissipated);
  scene_.energy.release(of_film.released);
  if (b.film.failed.empty() && b.film.debonded.empty()) return;
  scene_.host().film_failed(b);
  if (scene_.penalty) cracks_.note_film_failure(b);
}

// Bonds that ranks do not cut are completed at once, while they are in cache. Bonds that elastic grains couple wait until the
// loads of all of them are known: find_accelerations() adds their forces.
void NodalForces::add_forces(Bond& b) {
  scene_.timer.start(StepTimer::kCoupling);
  if (elastic_.waits(b)) return;
  follow_links(b);
  add_other_forces(b);
}

void NodalForces::add_other_forces(Bond& b) {
  Losses losses;
  for (const auto& p : b.mechanisms) p->add_force(at_work(b), losses);
  scene_.energy.release(losses.released);
  scene_.energy.add_friction(losses.frictional);
  advance_film(b);
  end_forces(b);
}

void NodalForces::end_forces(Bond& b) {
  b.grid.constraints.gather_to_masters(b.grid.force.data());
  if (!b.cut_by_ranks()) complete(b);
}

// Adds damping, weight, and forces of the host and of crack faces to the forces of points and links.
void NodalForces::complete(Bond& b) {
  for (const auto& p : b.mechanisms) p->add_damping(at_work(b));
  const std::array<double, 3> weight = scene_.weight_of(b);
  if (weight != std::array<double, 3>{})
    for (int i = 0; i < b.grid.size(); ++i)
      for (int d = 0; d < 3; ++d) b.grid.force[3 * i + d] += b.grid.mass[i] * weight[d];
  if (scene_.fragments.has(b.row)) scene_.fragments.add_forces(b);
  scene_.host().add_node_forces(b);
  for (const auto& p : b.mechanisms) p->add_contact(at_work(b));
  scene_.grains.sum_up(b);
}

void NodalForces::begin(double kick) {
  kick_ = kick;
  scene_.fragments.find_accelerations(scene_.comm, scene_.bonds(), starts_ ? FragmentBodies::Drift() : scene_.drift(),
                                      scene_.ends_step() * scene_.now.substeps);
  elastic_.find_coupling(starts_);
  pass_result_.dissipated = pass_result_.released = 0.0;
  if (grains_need_accelerations() && scene_.options.mass_order == 1) scene_.grains.begin_sums();
}

void NodalForces::find_accelerations() {
  elastic_.find(starts_, [this](Bond& b) {
    if (starts_) {
      scene_.energy.release(b.link_step.released);
      return add_other_forces_at_start(b);
    }
    note_links(b);
    add_other_forces(b);
  });
  scene_.timer.start(StepTimer::kHalo);
  shared_.sum([](Bond& b) { return b.grid.force.data(); }, 3);
  scene_.timer.start(StepTimer::kNodes);
  for (Bond* b : shared_.cut_bonds()) complete(*b);
  if (scene_.options.mass_order > 1) add_inertial_forces();
  find_grain_accelerations();
  if (scene_.now.substeps > 1 && scene_.ends_step()) share_impulses();
  condensed_.pack().find_inertial_loads();
  // Backwards, since the last bonds are still in cache. The next step begins with the first bonds.
  scene_.bonds().for_each_resolved_backwards([this](Bond& b, const Bond* next) {
    if (next) next->prefetch_nodes();
    b.added.accelerate(b.grid, scene_.grains.ends_of(b));
  });
}

void NodalForces::find_grain_accelerations() {
  if (!grains_need_accelerations()) return;
  scene_.timer.start(StepTimer::kCoupling);
  scene_.grains.find_accelerations(scene_.comm, scene_.bonds(), scene_.now.substeps, condensed_.pack());
  scene_.timer.start(StepTimer::kNodes);
}

// Adds the term of `mass_order 2` to the forces. The nodes have lumped mass M_L and consistent mass M. N is the inertia of
// nodes, added mass and grains with M_L. With a = N^-1 f, the accelerations are N^-1 (f + (M_L - M) a). See
// mpm/consistent_mass.h.
void NodalForces::add_inertial_forces() {
  find_grain_accelerations();
  for (Bond& b : scene_.bonds().resolved()) {
    Grid& grid = b.grid;
    // a = N^-1 f takes the forces with those of the added mass, which must not stay in grid.force.
    grid.inertial_force = grid.force;
    b.added.move_added_mass(grid, scene_.grains.ends_of(b));
    grid.update_acceleration(b.added.of_nodes());
    grid.force.swap(grid.inertial_force);
    scene_.timer.start(StepTimer::kPoints);
    b.mechanism<ConsistentMass>()->find_inertial_force(b.points, grid, scene_.inertia());
    scene_.timer.start(StepTimer::kNodes);
  }
  scene_.timer.start(StepTimer::kHalo);
  shared_.sum([](Bond& b) { return b.grid.inertial_force.data(); }, 3);
  scene_.timer.start(StepTimer::kNodes);
  for (Bond& b : scene_.bonds().resolved())
    for (std::size_t n = 0; n < b.grid.force.size(); ++n) b.grid.force[n] += b.grid.inertial_force[n];
}

void NodalForces::share_impulses() {
  scene_.timer.start(StepTimer::kCoupling);
  for (Bond& b : scene_.bonds().resolved())
    if (SharedImpulse* shared = b.mechanism<SharedImpulse>()) shared->find_intact_mass(b.points, b.grid, scene_.inertia());
  if (scene_.penalty) shared_.sum([](Bond& b) { return b.mechanism<SharedImpulse>()->intact_mass().data(); }, 1);
  scene_.grains.share_impulses(scene_.comm, scene_.bonds(), scene_.now.substeps, condensed_.pack());
  scene_.timer.start(StepTimer::kNodes);
}

void NodalForces::react() { scene_.grains.react(scene_.now.dt, scene_.now.substeps, scene_.energy, condensed_.pack()); }

void NodalForces::end_pass() {
  scene_.energy.dissipate(pass_result_.dissipated);
  scene_.energy.release(pass_result_.released);
}

void NodalForces::add_other_forces_at_start(Bond& b) {
  b.film.add_force(scene_.grains.ends_of(b), *scene_.law);
  BondContext as_it_is = at_work(b);
  as_it_is.dt = 0.0;  // no state changes
  Losses none;
  for (const auto& p : b.mechanisms) p->add_force(as_it_is, none);
  end_forces(b);
}

void NodalForces::find_at_start() {
  scene_.grains.ends.clear_forces();
  scene_.grains.clear_sudden_forces();
  starts_ = true;
  begin(scene_.kick());
  for (Bond& b : scene_.bonds().resolved()) {
    b.transfer_change.clear();
    if (elastic_.waits(b)) continue;
    scene_.energy.release(b.links.add_force(b.grid, scene_.grains.ends_of(b)));
    add_other_forces_at_start(b);
  }
  find_accelerations();
  starts_ = false;
}

}  // namespace mpdem
