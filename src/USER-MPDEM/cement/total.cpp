// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// `total` kinematics. If asked for, velocities are transferred every N steps, or a new reference is taken when the
// cement has distorted.
#include <algorithm>
#include <cmath>

#include "../mpm/advance_updated.h"
#include "../mpm/reproject.h"
#include "kinematics.h"
#include "nonlocal.h"

namespace mpdem {

class Total : public Kinematics {
 public:
  explicit Total(const MovingParts& parts) : Kinematics(parts) {}

  void advance() override {
    const CementOptions& o = scene_.options;
    const double dt = scene_.now.dt, kick = scene_.kick();
    const bool transfer = o.reproject_every > 0 && scene_.ends_step() && scene_.now.number % o.reproject_every == 0;
    const bool may_be_distorted = o.reproject_distortion > 0.0 && scene_.ends_step() && scene_.now.number % o.check_every == 0;
    average_drives(scene_, shared_.any_bond_is_cut());
    scene_.grains.sides.clear_forces();
    if (added_.any()) scene_.grains.expect_sudden_forces();
    scene_.bonds().for_each_awake([&](Bond& b, const Bond* next) {
      if (next) next->prefetch_step();
      scene_.timer.start(StepTimer::kNodes);
      b.jump.clear();
      if (transfer) reproject(b);
      if (added_.any()) scene_.grains.follow_jumps(b, dt, scene_.dt_last, scene_.weight_of(b), scene_.books);
      b.grid.drift(kick, dt);
      b.grid.begin_forces();
      b.unmoved = b.unmoved && b.grid.stands_still();
      if (!b.unmoved) {
        scene_.timer.start(StepTimer::kPoints);
        advance_points(b.points, 0, static_cast<int>(b.points.blocks.size()), b.grid, *scene_.law, dt, o.advance, forces_.pass());
      }
      scene_.timer.start(StepTimer::kCoupling);
      forces_.take_failed(b);
      forces_.let_go(b);
      if (transfer) b.added.add_reaction(b.grid, b.jump, 1.0 / dt, scene_.grains.side_of(b));
      if (!may_be_distorted) forces_.add_forces(b);
    });
    scene_.dt_last = dt;
    if (!may_be_distorted) return;
    if (distorted()) {
      scene_.grains.react_to_jumps(dt, scene_.books);
      scene_.grains.clear_sudden_forces();  // the grains know them
      take_new_reference();
      scene_.grains.sides.clear_forces();
    }
    for (Bond& b : scene_.bonds().awake()) forces_.add_forces(b);
  }

  void find_internal_force() override {
    for (Bond& b : scene_.bonds().awake()) {
      b.grid.clear_force();
      add_internal_force(b.points, b.grid, *scene_.law);
    }
  }

 private:
  // The kinetic energy that a projection leaves out counts as damped. It is the energy at the step, where the velocity
  // is half a kick ahead of what is stored.
  void reproject(Bond& b) {
    const double half = 0.5 * scene_.dt_last, kick = scene_.kick();
    const GrainSide* side = scene_.grains.side_of(b);
    scene_.books.damp_by(
        [&] { return work_.kinetic_energy(b, half) + (b.body < scene_.bodies_started ? b.added.energy_ahead(b.grid, side, kick) : 0.0); },
        [&] { reproject_velocity(b.points, b.grid, b.added.of_nodes(), scene_.inertia, scene_.options.transfer, kick, b.jump); });
    // the energy of added mass is that at the step, too; the reaction goes to the grains
    scene_.books.damp(half * b.added.power(b.grid, side, b.jump) - b.added.work_of_reaction(b.grid, side, b.jump));
    scene_.books.do_work(half * work_.gravity_power(b, b.jump));
  }

  // Has any point that holds distorted by more than is asked for? Collective.
  bool distorted() const {
    vd most{};
    for (const Bond& bond : scene_.bonds())
      for (std::size_t b = 0; b < bond.points.blocks.size(); ++b) {
        const Mat3<vd>& F = bond.points.blocks[b].F;
        const BlockMeta& m = bond.points.meta[b];
        const vmask taken = lanes(static_cast<std::uint8_t>(m.occupied & ~m.failed));
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) most = max(most, select(taken, abs(F.a[i][j] - (i == j ? 1.0 : 0.0)), vd{}));
      }
    double mine = 0.0, all;
    for (int l = 0; l < kLanes; ++l) mine = std::max(mine, most[l]);
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_MAX, scene_.comm);
    return all > scene_.options.reproject_distortion;
  }

  // Makes the present the reference of points and links. Velocities go over by transfer.
  void take_new_reference() {
    const auto energy = [this] {
      double sum = 0.0;
      for (const Bond& b : scene_.bonds()) sum += work_.kinetic_energy(b, 0.0) + b.added.energy(b.grid, scene_.grains.side_of(b));
      return sum;
    };
    scene_.books.damp_by(energy, [&] {
      for (Bond& b : scene_.bonds()) {
        UpdatedPass::start(b.points, b.grid, 0);
        move_to_present(b.points, b.grid);
        b.links.move_to_present(b.points, b.grid);
        std::fill(b.grid.displacement.begin(), b.grid.displacement.end(), 0.0);
      }
      arrangement_.lay_out_again(scene_.all_rows(), {}, {});
      added_.follow(scene_.all_rows(), "the present was taken for the reference");
      for (Bond& b : scene_.bonds()) {
        UpdatedPass::project(b.points, b.grid, *scene_.law, scene_.inertia, scene_.options.transfer);
        b.grid.halo.sum(b.grid.mass.own().data(), 1);
        b.grid.halo.sum(b.grid.momentum.data(), 3);
        take_momentum(b.grid);
      }
    });
  }
};

std::unique_ptr<Kinematics> make_total(const MovingParts& parts) { return std::make_unique<Total>(parts); }

}  // namespace mpdem
