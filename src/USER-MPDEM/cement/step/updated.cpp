// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// `updated` kinematics (updated Lagrangian): the present is the reference, see mpm/advance_updated.h.
#include <algorithm>
#include <iterator>

#include "../../mpm/reproject.h"
#include "../../parallel/agree.h"
#include "kinematics.h"
#include "nonlocal.h"

namespace mpdem {

void velocities_from_momentum(Grid& grid) {
  for (int i = 0; i < grid.size(); ++i)
    if (grid.mass[i] > 0.0)
      for (int d = 0; d < 3; ++d) grid.velocity[3 * i + d] = grid.momentum[3 * i + d] / grid.mass[i];
}

class Updated : public Kinematics {
 public:
  explicit Updated(const KinematicsContext& context) : Kinematics(context) {}

  // Each step finds the added mass, and counts the energy that it releases.
  void start_run() override {}
  void change_step() override { added_.refresh(); }

  void advance() override {
    const double dt = scene_.now.dt;
    scene_.timer.start(StepTimer::kLayout);
    follow_points();
    average_drives(scene_, shared_.any_bond_is_cut());
    if (added_.any()) scene_.grains.expect_sudden_forces();
    kinetic_.clear();
    inertial_.clear();
    int lost = 0;
    for (Bond& b : scene_.bonds()) {
      move_nodes_and_points(b);
      if (b.updated.lost()) lost = b.updated.lost();
    }
    throw_if_any(scene_.comm, !lost ? std::string()
                                    : text_of("material point ", lost, " moved more than two cells in step ", scene_.now.number,
                                              " or is not finite; check the motion of the grains and the time step"));
    scene_.timer.start(StepTimer::kHalo);
    shared_.sum([](Bond& b) { return b.grid.mass.own().data(); }, 1);
    shared_.sum([](Bond& b) { return b.grid.momentum.data(); }, 3);
    scene_.grains.ends.clear_forces();
    std::size_t n = 0;
    for (Bond& b : scene_.bonds()) {
      b.laid_out_blocks = b.points.blocks.size();
      update_velocities(b, kinetic_[n++]);
      update_links(b);
    }
    added_.refresh();
    n = 0;
    for (Bond& b : scene_.bonds()) {
      scene_.energy.damp(inertial_[n++] - b.added.energy(b.grid, scene_.grains.ends_of(b)));
      for (std::size_t i = 0; i < b.filtered.size(); ++i) b.transfer_change[i] -= b.filtered[i];
      b.filtered.clear();
    }
    scene_.dt_last = dt;
    for (Bond& b : scene_.bonds()) forces_.add_forces(b);
  }

  void account_for_accelerations() override {
    for (const Bond& b : scene_.bonds()) {
      scene_.energy.damp(work_.half_kick(b, b.transfer_change));
      // Nodes moved here without the change of velocity by the transfer.
      scene_.energy.do_work(-0.5 * scene_.dt_last * work_.gravity_power(b, b.transfer_change));
    }
  }

  void find_internal_force() override {
    for (Bond& b : scene_.bonds()) UpdatedPass::project(b.points, b.grid, *scene_.law, scene_.inertia(), scene_.options.transfer);
    shared_.sum([](Bond& b) { return b.grid.mass.own().data(); }, 1);
  }

 private:
  // Lays out bonds whose points come near the end of their grid. Blocks of points that crossed many cells become
  // sparse, so these points are sorted again.
  void follow_points() {
    std::vector<int> mine, sparse;
    for (const Bond& b : scene_.bonds())
      if (b.updated.layout_is_stale()) mine.push_back(b.row);
    const std::vector<int> stale = scene_.agreed_rows(mine);
    if (stale.empty()) return;
    for (int row : stale) {
      const Bond* b = scene_.bonds().find(row);
      if (b && b->points.blocks.size() > b->updated.blocks_of_layout + b->updated.blocks_of_layout / 3) sparse.push_back(row);
    }
    sparse = scene_.agreed_rows(sparse);
    std::vector<int> dense;
    std::set_difference(stale.begin(), stale.end(), sparse.begin(), sparse.end(), std::back_inserter(dense));
    const double kick = scene_.kick();
    LayoutManager::How as_they_are;
    as_they_are.arrange = false;
    scene_.energy.damp_by([&] { return added_.energy_ahead(stale, kick); },
                          [&] {
                            if (!dense.empty()) layout_manager_.lay_out_again(dense, {}, as_they_are);
                            layout_manager_.sync_slots();
                            if (!sparse.empty()) layout_manager_.lay_out_again(sparse, {}, {});
                          });
  }

  void move_nodes_and_points(Bond& b) {
    const CementOptions& o = scene_.options;
    const double dt = scene_.now.dt, kick = scene_.kick();
    b.unmoved = false;
    scene_.timer.start(StepTimer::kNodes);
    if (added_.any()) scene_.grains.follow_jumps(b, dt, scene_.dt_last, scene_.weight_of(b), scene_.energy);
    b.grid.drift(kick, 0.0);  // changes velocities alone
    kinetic_.push_back(work_.kinetic_energy(b, 0.0));
    inertial_.push_back(b.added.energy(b.grid, scene_.grains.ends_of(b)));
    b.transfer_change.assign(b.grid.velocity.size(), 0.0);
    if (o.transfer.method == Transfer::xpic && o.transfer.order > 1) filter(b, kick);
    scene_.timer.start(StepTimer::kCoupling);
    b.links.find_moves(b.grid, dt);
    scene_.timer.start(StepTimer::kPoints);
    b.updated.advance(b.points, b.grid, *scene_.law, scene_.inertia(), dt, kick, o.transfer, o.advance, forces_.pass_result());
    forces_.take_failed(b);
  }

  void filter(Bond& b, double kick) {
    std::vector<double>& v = b.grid.velocity;
    const std::vector<double> kicked(v);
    for (std::size_t i = 0; i < v.size(); ++i) v[i] -= kick * b.grid.acceleration[i];
    filter_velocity(b.points, b.grid, b.added.of_nodes(), scene_.inertia(), scene_.options.transfer.order);
    for (std::size_t i = 0; i < v.size(); ++i) {
      v[i] += kick * b.grid.acceleration[i];
      b.transfer_change[i] = v[i] - kicked[i];
    }
    // Nodes move with this change, unlike with that of the transfer, so it is counted with the accelerations before.
    scene_.energy.damp(-work_.half_kick(b, b.transfer_change));
    scene_.energy.do_work(0.5 * scene_.dt_last * work_.gravity_power(b, b.transfer_change));
    b.filtered = b.transfer_change;
  }

  // Share of the added mass that takes part in the transfer. The velocity that points take from nodes is that of nodes
  // and added mass together. The velocity that flip keeps in the points is theirs alone.
  double transferred_share() const {
    const Transfer& t = scene_.options.transfer;
    return t.method == Transfer::flip ? 1.0 - t.flip_share : 1.0;
  }

  // A node with neither mass nor added mass keeps its velocity.
  void update_velocities(Bond& b, double kinetic_before) {
    scene_.timer.start(StepTimer::kNodes);
    Grid& grid = b.grid;
    const SharedList<double>& added = b.added.of_nodes();
    for (int i = 0; i < grid.size(); ++i) {
      const double a = added.empty() ? 0.0 : transferred_share() * added[i], m = grid.mass[i] + a;
      for (int d = 0; d < 3; ++d) {
        double& v = grid.velocity[3 * i + d];
        const double w = m > 0.0 ? (grid.momentum[3 * i + d] + a * v) / m : v;
        b.transfer_change[3 * i + d] += w - v;
        v = w;
      }
    }
    scene_.energy.damp(kinetic_before - work_.kinetic_energy(b, 0.0));
    BondEnd* ends = scene_.grains.ends_of(b);
    b.added.add_reaction(grid, b.transfer_change, transferred_share() * transferred_share() / scene_.now.dt, ends);
    // The work of the reaction goes to the grains.
    scene_.energy.damp(-transferred_share() * transferred_share() * b.added.work_of_reaction(grid, ends, b.transfer_change));
  }

  // Links whose end on the cement left its cell move to other blocks. A grid whose end they reach is laid out again in
  // the next step. Until then its margin has the nodes.
  void update_links(Bond& b) {
    scene_.timer.start(StepTimer::kCoupling);
    const bool moved = b.links.move_links(b.points);
    if (scene_.leaves_residue()) forces_.debond(b);  // new blocks would drop residue before its energy is counted
    if (moved && !b.links.follow_points(b.points, scene_.bonds().record(b), b.grid))
      throw OnOneRank(
          text_of("a link moved out of the grid at step ", scene_.now.number, "; check the motion of the grains and the time step"));
    if (!scene_.leaves_residue()) forces_.debond(b);
    b.links.drop_added_mass(b.points);
  }

  std::vector<double> kinetic_, inertial_;  // energies of each bond before points and nodes exchange velocity
};

std::unique_ptr<Kinematics> make_updated(const KinematicsContext& context) { return std::make_unique<Updated>(context); }

}  // namespace mpdem
