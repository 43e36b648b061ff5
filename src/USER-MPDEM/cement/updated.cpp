// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// `updated` kinematics: the reference is the present, see mpm/advance_updated.h.
#include <algorithm>
#include <iterator>

#include "../mpm/reproject.h"
#include "../parallel/agree.h"
#include "cement.h"
#include "kinematics.h"

namespace mpdem {

void take_momentum(Grid& grid) {
  for (int i = 0; i < grid.size(); ++i)
    if (grid.mass[i] > 0.0)
      for (int d = 0; d < 3; ++d) grid.velocity[3 * i + d] = grid.momentum[3 * i + d] / grid.mass[i];
}

class Updated : public Kinematics {
 public:
  explicit Updated(Cement& cement) : Kinematics(cement) {}

  void advance() override {
    Cement& c = cement_;
    const double dt = c.now_.dt;
    c.timer_.start(StepTimer::kLayout);
    follow_points();
    c.average_drives();
    c.grains_.clear_sudden_forces();
    if (c.layout_.any_added_mass) c.grains_.expect_sudden_forces();
    kinetic_.clear();
    inertial_.clear();
    int lost = 0;
    for (Bond& b : c.bonds_) {
      move_nodes_and_points(b);
      if (b.updated.lost()) lost = b.updated.lost();
    }
    throw_if_any(c.comm_, !lost ? std::string()
                                : text_of("material point ", lost, " moved more than two cells in step ", c.now_.number,
                                          " or is not finite; check the motion of the grains and the time step"));
    c.timer_.start(StepTimer::kHalo);
    c.sum_shared([](Grid& g) { return g.mass.own().data(); }, 1);
    c.sum_shared([](Grid& g) { return g.momentum.data(); }, 3);
    c.grains_.sides.clear_forces();
    std::size_t n = 0;
    for (Bond& b : c.bonds_) {
      b.laid_out_blocks = b.points.blocks.size();
      take_velocities(b, kinetic_[n++]);
      move_links(b);
    }
    c.refresh_added_mass();
    n = 0;
    for (Bond& b : c.bonds_) {
      c.books_.damp(inertial_[n++] - b.added.energy(b.grid, c.grains_.side_of(b)));
      for (std::size_t i = 0; i < b.filtered.size(); ++i) b.jump[i] -= b.filtered[i];
      b.filtered.clear();
    }
    c.dt_last_ = dt;
    for (Bond& b : c.bonds_) c.add_link_forces(b);
  }

  void account_for_accelerations() override {
    Cement& c = cement_;
    for (const Bond& b : c.bonds_) {
      c.books_.damp(c.half_kick(b, b.jump));
      c.books_.do_work(-0.5 * c.dt_last_ * c.gravity_power(b, b.jump));  // nodes came here without that
    }
  }

  void find_internal_force() override {
    Cement& c = cement_;
    for (Bond& b : c.bonds_) UpdatedPass::project(b.points, b.grid, *c.law_, c.inertia_, c.options_.transfer);
    c.sum_shared([](Grid& g) { return g.mass.own().data(); }, 1);
  }

  void start_points(Bond& b) override { UpdatedPass::start(b.points, b.grid, 0); }
  void bind(Bond& b) override { b.updated.bind(b.points, b.grid); }

 private:
  // Lays out bonds whose points come near the end of their grid. Blocks fill badly when points went through many cells.
  void follow_points() {
    Cement& c = cement_;
    std::vector<int> mine, sparse;
    for (const Bond& b : c.bonds_)
      if (b.updated.layout_is_stale()) mine.push_back(b.body);
    const std::vector<int> stale = c.agreed_rows(mine);
    if (stale.empty()) return;
    for (int row : stale) {
      const Bond* b = c.bonds_.find(row);
      if (b && b->points.blocks.size() > b->blocks_when_arranged + b->blocks_when_arranged / 3) sparse.push_back(row);
    }
    sparse = c.agreed_rows(sparse);
    std::vector<int> dense;
    std::set_difference(stale.begin(), stale.end(), sparse.begin(), sparse.end(), std::back_inserter(dense));
    const double kick = 0.5 * (c.dt_last_ + c.now_.dt);
    c.books_.damp_by([&] { return c.added_energy_ahead(stale, kick); },
                     [&] {
                       if (!dense.empty()) c.lay_out_again(dense, {}, false);
                       c.sync_slots();
                       if (!sparse.empty()) c.lay_out_again(sparse);
                     });
  }

  void move_nodes_and_points(Bond& b) {
    Cement& c = cement_;
    const CementOptions& o = c.options_;
    const double dt = c.now_.dt, kick = 0.5 * (c.dt_last_ + dt);
    c.timer_.start(StepTimer::kNodes);
    if (c.layout_.any_added_mass) c.grains_.follow_jumps(b, dt, c.dt_last_);
    b.grid.drift(kick, 0.0);
    kinetic_.push_back(c.kinetic_energy(b, 0.0));
    inertial_.push_back(b.added.energy(b.grid, c.grains_.side_of(b)));
    b.jump.assign(b.grid.velocity.size(), 0.0);
    if (o.transfer.method == Transfer::xpic && o.transfer.order > 1) filter(b, kick);
    c.timer_.start(StepTimer::kCoupling);
    b.links.find_moves(b.grid, dt);
    c.timer_.start(StepTimer::kPoints);
    b.updated.advance(b.points, b.grid, *c.law_, c.inertia_, dt, kick, o.transfer, o.skip, c.advance_);
    c.take_failed(b);
  }

  void filter(Bond& b, double kick) {
    std::vector<double>& v = b.grid.velocity;
    const std::vector<double> kicked(v);
    for (std::size_t i = 0; i < v.size(); ++i) v[i] -= kick * b.grid.acceleration[i];
    filter_velocity(b.points, b.grid, b.added.of_nodes(), cement_.inertia_, cement_.options_.transfer.order);
    for (std::size_t i = 0; i < v.size(); ++i) {
      v[i] += kick * b.grid.acceleration[i];
      b.jump[i] = v[i] - kicked[i];
    }
    // before the nodes move, unlike the transfer
    cement_.books_.damp(-cement_.half_kick(b, b.jump));
    cement_.books_.do_work(0.5 * cement_.dt_last_ * cement_.gravity_power(b, b.jump));
    b.filtered = b.jump;
  }

  // Share of the inertia of added mass that takes part in the transfer: the velocity that points take from nodes is theirs and the
  // added mass' together; what flip keeps in the points is theirs alone.
  double shared() const {
    const Transfer& t = cement_.options_.transfer;
    return t.method == Transfer::flip ? 1.0 - t.flip_share : 1.0;
  }

  // A node with neither mass keeps what it has.
  void take_velocities(Bond& b, double kinetic_before) {
    Cement& c = cement_;
    c.timer_.start(StepTimer::kNodes);
    Grid& grid = b.grid;
    const SharedList<double>& added = b.added.of_nodes();
    for (int i = 0; i < grid.size(); ++i) {
      const double a = added.empty() ? 0.0 : shared() * added[i], m = grid.mass[i] + a;
      for (int d = 0; d < 3; ++d) {
        double& v = grid.velocity[3 * i + d];
        const double w = m > 0.0 ? (grid.momentum[3 * i + d] + a * v) / m : v;
        b.jump[3 * i + d] += w - v;
        v = w;
      }
    }
    c.books_.damp(kinetic_before - c.kinetic_energy(b, 0.0));
    GrainSide* side = c.grains_.side_of(b);
    b.added.add_reaction(grid, b.jump, shared() * shared() / c.now_.dt, side);
    c.books_.damp(-shared() * shared() * b.added.work_of_reaction(grid, side, b.jump));  // which goes to the grains
  }

  // Links whose place left its cell go into other blocks; where the grid ends, it is laid out anew
  // in the next step, and until then the margin has the nodes.
  void move_links(Bond& b) {
    Cement& c = cement_;
    c.timer_.start(StepTimer::kCoupling);
    const bool moved = b.links.move_places(b.points);
    if (c.keeps_skins()) c.let_go(b);  // new blocks would leave skins out before their energy is booked
    if (moved && !b.links.follow_points(b.points, c.bonds_.body(b), b.grid))
      throw OnOneRank(text_of("a link moved out of the grid at step ", c.now_.number, "; check the motion of the grains and the time step"));
    if (!c.keeps_skins()) c.let_go(b);
    b.links.drop_inertia(b.points);
  }

  std::vector<double> kinetic_, inertial_;  // of each bond, before points and nodes exchange velocity
};

std::unique_ptr<Kinematics> make_updated(Cement& cement) { return std::make_unique<Updated>(cement); }

}  // namespace mpdem
