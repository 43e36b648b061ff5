// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The step of fix mpm without LIGGGHTS and grains, for benchmarks: one free body on one
// process, kernels and their order as in cement/total.cpp and cement/updated.cpp.
// SI or any other consistent units.
#ifndef MPDEM_BENCH_STEPPER_H
#define MPDEM_BENCH_STEPPER_H

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "material/laws.h"
#include "mpm/advance_updated.h"
#include "mpm/grid.h"
#include "mpm/point_state.h"

namespace mpdem::bench {

using Point = std::array<double, 3>;

struct Method {
  bool updated = false;
  Basis basis = Basis::quadratic;
  bool transfers = false;  // `updated` always
  Transfer transfer;

  // kinematics/basis/transfer, e.g. total/quadratic/none
  std::string name() const;
};

// total with none, pic, flip, apic, xpic2; updated with the last four; each basis.
const std::vector<Method>& all_methods();

class Stepper {
 public:
  PointStore points;
  Grid grid;

  // Points at X, all of one volume, axes of the material those of space.
  Stepper(const Method& method, double h, const std::vector<Point>& X, double volume,
          std::shared_ptr<const Law> law, double density);

  // Velocity of the nodes half a step before the start.
  void start(const std::function<Point(const Point&)>& velocity);
  // Adds force from outside to grid.force, before the first step and in every step.
  std::function<void(Stepper&, double time)> load;
  // Called in every step of `updated`, once the nodes have the velocity of the step.
  std::function<void(Stepper&, double dt)> before_points;
  // Acceleration of the present state; once, after start().
  void accelerate();
  // Throws std::runtime_error if a point is lost.
  void step(double dt);

  double time() const { return time_; }
  double seconds() const { return seconds_; }  // of CPU in step(), load left out
  long crossings() const { return crossings_; }
  int layouts() const { return layouts_; }
  const AdvanceResult& result() const { return result_; }
  const Law& law() const { return *law_; }
  const Method& method() const { return method_; }
  std::size_t memory_usage() const { return points.memory_usage() + grid.memory_usage(); }
  // dt^2 lambda <= 4, with transfers 2, as in fix mpm. lambda: of these points where they stay,
  // the bound for any place where they move, tents, for which there is none, with 20 % on top.
  double stable_step();
  double kinetic_energy(double half_step) const;  // with velocities half_step later
  double strain_energy() const;
  // f(block, lane)
  template <class F>
  void for_points(F f) const {
    for (std::size_t b = 0; b < points.blocks.size(); ++b)
      for (int l = 0; l < kLanes; ++l)
        if (points.meta[b].occupied >> l & 1) f(static_cast<int>(b), l);
  }

 private:
  void arrange();
  void lay_out();
  void step_total(double dt);
  void step_updated(double dt);
  void take_momentum();

  Method method_;
  std::shared_ptr<const Law> law_;
  double density_, time_ = 0.0, seconds_ = 0.0;
  long crossings_ = 0;
  int layouts_ = 0;
  std::size_t blocks_when_arranged_ = 0;
  UpdatedPass pass_;
  AdvanceResult result_;
  std::vector<double> jump_;
};

}  // namespace mpdem::bench

#endif
