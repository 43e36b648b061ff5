// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// `total` kinematics (total Lagrangian): the reference of points is fixed, nodes drift, and points follow.
#ifndef MPDEM_CEMENT_STEP_TOTAL_H
#define MPDEM_CEMENT_STEP_TOTAL_H

#include "kinematics.h"
#include "nonlocal.h"

namespace mpdem {

class Total : public Kinematics {
 public:
  explicit Total(const KinematicsContext& context) : Kinematics(context) {}

  void start_run() override { renew_added_mass(0.0); }
  void change_step() override { renew_added_mass(scene_.kick()); }
  void advance() override;
  void find_internal_force() override;

 protected:
  // Does advance() up to the forces of links. before(bond) is called before its nodes drift, after(bond) when its
  // points have their stress.
  template <class Before, class After>
  void pass(Before before, After after) {
    const double dt = scene_.now.dt, kick = scene_.kick();
    average_drives(scene_, shared_.any_bond_is_cut());
    scene_.grains.ends.clear_forces();
    if (added_.any()) scene_.grains.expect_sudden_forces();
    scene_.bonds().for_each_resolved([&](Bond& b, const Bond* next) {
      if (next) next->prefetch_step();
      scene_.timer.start(StepTimer::kNodes);
      b.transfer_change.clear();
      before(b);
      if (added_.any()) scene_.grains.follow_jumps(b, dt, scene_.dt_last, scene_.weight_of(b), scene_.energy);
      b.grid.drift(kick, dt);
      b.grid.begin_forces();
      b.unmoved = b.unmoved && b.grid.is_at_rest();
      if (!b.unmoved) {
        scene_.timer.start(StepTimer::kPoints);
        advance_points(b.points, 0, static_cast<int>(b.points.blocks.size()), b.grid, *scene_.law, dt, scene_.options.advance,
                       forces_.pass_result());
      }
      scene_.timer.start(StepTimer::kCoupling);
      forces_.take_failed(b);
      forces_.debond(b);
      after(b);
    });
    scene_.dt_last = dt;
  }

 private:
  void renew_added_mass(double later);
};

}  // namespace mpdem

#endif
