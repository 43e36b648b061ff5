// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// `total` kinematics, with transfers of velocity every N steps or a new reference when the cement has distorted, if asked for.
#include <algorithm>
#include <cmath>

#include "../mpm/advance_updated.h"
#include "../mpm/reproject.h"
#include "cement.h"
#include "kinematics.h"

namespace mpdem {

class Total : public Kinematics {
 public:
  explicit Total(Cement& cement) : Kinematics(cement) {}

  void advance() override {
    Cement& c = cement_;
    const CementOptions& o = c.options_;
    const double dt = c.now_.dt, kick = 0.5 * (c.dt_last_ + dt);
    const bool transfer = o.reproject_every > 0 && c.ends_step() && c.now_.number % o.reproject_every == 0;
    const bool may_be_distorted = o.reproject_distortion > 0.0 && c.ends_step() && c.now_.number % o.check_every == 0;
    c.average_drives();
    c.grains_.clear_sudden_forces();
    c.grains_.sides.clear_forces();
    if (c.layout_.any_added_mass) c.grains_.expect_sudden_forces();
    if (!may_be_distorted) c.begin_completing();
    const auto range = c.bonds_.awake();
    for (auto at = range.begin(); at != range.end();) {
      Bond& b = *at;
      ++at;
      if (at != range.end()) (*at).prefetch_step();
      c.timer_.start(StepTimer::kNodes);
      b.jump.clear();
      if (transfer) reproject(b);
      if (c.layout_.any_added_mass) c.grains_.follow_jumps(b, dt, c.dt_last_);
      b.grid.drift(kick, dt);
      c.timer_.start(StepTimer::kPoints);
      if (may_be_distorted) b.grid.clear_force();
      else b.grid.begin_forces();
      b.resting.advance(b.points, b.grid, *c.law_, dt, o.skip, c.advance_);
      c.timer_.start(StepTimer::kCoupling);
      c.take_failed(b);
      c.let_go(b);
      if (transfer) b.added.add_reaction(b.grid, b.jump, 1.0 / dt, c.grains_.side_of(b));
      if (may_be_distorted) continue;
      c.add_link_forces(b);
      c.complete_early(b);
    }
    c.dt_last_ = dt;
    if (!may_be_distorted) return;
    if (distorted()) {
      c.grains_.react_to_jumps(dt, c.books_);
      take_new_reference();
      c.grains_.sides.clear_forces();
    }
    for (Bond& b : c.bonds_.awake()) c.add_link_forces(b);
  }

  void find_internal_force() override {
    for (Bond& b : cement_.bonds_.awake()) {
      b.grid.clear_force();
      add_internal_force(b.points, b.grid, *cement_.law_);
    }
  }

 private:
  // The kinetic energy that a projection leaves out counts as damped: that at the step, where
  // velocity is half a kick ahead of what is stored.
  void reproject(Bond& b) {
    Cement& c = cement_;
    const double dt = c.now_.dt, half = 0.5 * c.dt_last_, kick = 0.5 * (c.dt_last_ + dt);
    const GrainSide* side = c.grains_.side_of(b);
    c.books_.damp_by(
        [&] { return c.kinetic_energy(b, half) + (b.body < c.bodies_started_ ? b.added.energy_ahead(b.grid, side, kick) : 0.0); },
        [&] { reproject_velocity(b.points, b.grid, b.added.of_nodes(), c.inertia_, c.options_.transfer, kick, b.jump); });
    // the energy of added mass, too, is that at the step; the reaction goes to the grains
    c.books_.damp(half * b.added.power(b.grid, side, b.jump) - b.added.work_of_reaction(b.grid, side, b.jump));
    c.books_.do_work(half * c.gravity_power(b, b.jump));
  }

  // Has any point distorted by more than is asked for? Collective.
  bool distorted() const {
    vd most{};
    for (const Bond& bond : cement_.bonds_)
      for (const PointBlock& p : bond.points.blocks)
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) most = max(most, abs(p.F.a[i][j] - (i == j ? 1.0 : 0.0)));
    double mine = 0.0, all;
    for (int l = 0; l < kLanes; ++l) mine = std::max(mine, most[l]);
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_MAX, cement_.comm_);
    return all > cement_.options_.reproject_distortion;
  }

  // The present becomes the reference of points and links; velocities go over by transfer.
  void take_new_reference() {
    Cement& c = cement_;
    const auto energy = [&c] {
      double sum = 0.0;
      for (const Bond& b : c.bonds_) sum += c.kinetic_energy(b, 0.0) + b.added.energy(b.grid, c.grains_.side_of(b));
      return sum;
    };
    c.books_.damp_by(energy, [&] {
      for (Bond& b : c.bonds_) {
        UpdatedPass::start(b.points, b.grid, 0);
        move_to_present(b.points, b.grid);
        b.links.move_to_present(b.points, b.grid);
        std::fill(b.grid.displacement.begin(), b.grid.displacement.end(), 0.0);
      }
      c.lay_out_again(c.all_rows());
      c.check_step_after(c.all_rows(), "the present was taken for the reference");
      for (Bond& b : c.bonds_) {
        UpdatedPass::project(b.points, b.grid, *c.law_, c.inertia_, c.options_.transfer);
        b.grid.halo.sum(b.grid.mass.own().data(), 1);
        b.grid.halo.sum(b.grid.momentum.data(), 3);
        take_momentum(b.grid);
      }
    });
  }
};

std::unique_ptr<Kinematics> make_total(Cement& cement) { return std::make_unique<Total>(cement); }

}  // namespace mpdem
