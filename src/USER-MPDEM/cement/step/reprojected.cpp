// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// `total` kinematics with re-projection: velocities go from nodes to points and back every N steps, or when the cement
// has distorted so much that the present becomes the reference. There are no sub-steps.
#include <algorithm>
#include <cmath>

#include "../../mpm/advance_updated.h"
#include "../../mpm/reproject.h"
#include "total.h"

namespace mpdem {

namespace {

class Reprojected : public Total {
 public:
  explicit Reprojected(const KinematicsContext& context) : Total(context) {}

  void advance() override {
    if (scene_.now.number % scene_.options.reproject_every != 0) return Total::advance();
    pass([this](Bond& b) { reproject(b); },
         [this](Bond& b) {
           b.added.add_reaction(b.grid, b.transfer_change, 1.0 / scene_.now.dt, scene_.grains.ends_of(b));
           forces_.add_forces(b);
         });
  }

 private:
  // The kinetic energy that a projection loses counts as damped. It is the energy at the full step, where the velocity
  // is half a kick ahead of the stored one.
  void reproject(Bond& b) {
    const double half = 0.5 * scene_.dt_last, kick = scene_.kick();
    const BondEnd* ends = scene_.grains.ends_of(b);
    scene_.energy.damp_by(
        [&] { return work_.kinetic_energy(b, half) + (b.row < scene_.rows_started ? b.added.energy_ahead(b.grid, ends, kick) : 0.0); },
        [&] {
          reproject_velocity(b.points, b.grid, b.added.of_nodes(), scene_.inertia(), scene_.options.transfer, kick, b.transfer_change);
        });
    // Take back half a kick, so that the energy of added mass, too, is that at the full step. Its reaction does work on the grains.
    scene_.energy.damp(half * b.added.power(b.grid, ends, b.transfer_change) - b.added.work_of_reaction(b.grid, ends, b.transfer_change));
    scene_.energy.do_work(half * work_.gravity_power(b, b.transfer_change));
  }
};

class RenewedReference : public Total {
 public:
  explicit RenewedReference(const KinematicsContext& context) : Total(context) {}

  void advance() override {
    if (scene_.now.number % scene_.options.check_every != 0) return Total::advance();
    pass([](Bond&) {}, [](Bond&) {});
    if (largest_distortion() > scene_.options.reproject_distortion) {
      scene_.grains.react_to_jumps(scene_.now.dt, scene_.energy);
      scene_.grains.clear_sudden_forces();  // already applied to the grains
      take_new_reference();
      scene_.grains.ends.clear_forces();
    }
    for (Bond& b : scene_.bonds().resolved()) forces_.add_forces(b);
  }

 private:
  // Collective. Largest component of F - I of any intact point.
  double largest_distortion() const {
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
    return all;
  }

  // Makes the present the reference of points and links. Velocities are transferred to the new nodes.
  void take_new_reference() {
    const auto energy = [this] {
      double sum = 0.0;
      for (const Bond& b : scene_.bonds()) sum += work_.kinetic_energy(b, 0.0) + b.added.energy(b.grid, scene_.grains.ends_of(b));
      return sum;
    };
    scene_.energy.damp_by(energy, [&] {
      for (Bond& b : scene_.bonds()) {
        UpdatedPass::start(b.points, b.grid, 0);
        move_to_present(b.points, b.grid);
        b.links.move_to_present(b.points, b.grid);
        std::fill(b.grid.displacement.begin(), b.grid.displacement.end(), 0.0);
      }
      layout_manager_.lay_out_again(scene_.all_rows(), {}, {});
      added_.follow(scene_.all_rows(), "the present was taken for the reference");
      for (Bond& b : scene_.bonds()) {
        UpdatedPass::project(b.points, b.grid, *scene_.law, scene_.inertia(), scene_.options.transfer);
        b.grid.halo.sum(b.grid.mass.own().data(), 1);
        b.grid.halo.sum(b.grid.momentum.data(), 3);
        velocities_from_momentum(b.grid);
      }
    });
  }
};

}  // namespace

std::unique_ptr<Kinematics> make_reprojected(const KinematicsContext& context) { return std::make_unique<Reprojected>(context); }
std::unique_ptr<Kinematics> make_renewed_reference(const KinematicsContext& context) { return std::make_unique<RenewedReference>(context); }

}  // namespace mpdem
