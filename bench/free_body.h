// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A host of the cement for benchmarks: one free body on one process, without grains and links. Every step is that of
// `Cement`, called in the order that fix mpm does, with the options that fix mpm takes by default. SI or any other consistent units.
#ifndef MPDEM_BENCH_FREE_BODY_H
#define MPDEM_BENCH_FREE_BODY_H

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cement/engine/cement.h"
#include "material/laws.h"
#include "mpm/point_state.h"

namespace mpdem::bench {

using Point = std::array<double, 3>;

struct Method {
  bool updated = false;
  Basis basis = Basis::quadratic;
  bool transfers = false;  // in every step; `updated` always
  Transfer transfer;
  int mass_order = 1;

  // kinematics/basis/transfer, e.g. total/quadratic/none; order2 in place of none with that of the mass
  std::string name() const;
};

// total with none, order2, pic, flip, apic, xpic2; updated with the last four; each basis.
const std::vector<Method>& all_methods();

class FreeBody : public CementHost {
 public:
  // Points at X, all of one volume, axes of the material those of space.
  FreeBody(const Method& method, double h, const std::vector<Point>& X, double volume, std::shared_ptr<const Law> law, double density);

  // Called in every step, before it.
  std::function<void(FreeBody&)> before_step;
  // Adds forces from outside to `force`, three numbers a node.
  std::function<void(FreeBody&, double time, std::vector<double>& force)> load;
  // Is a node at rest? By its position.
  std::function<bool(const Point&)> held;

  // Starts a run with steps of dt. The points have these velocities half a step before, where central differences have them.
  void start(double dt, const std::function<Point(const Point&)>& velocity);
  // Throws std::runtime_error if a point is lost.
  void step();

  PointStore& points() { return bonds_.begin()->points; }
  const PointStore& points() const { return bonds_.begin()->points; }
  Grid& grid() { return bonds_.begin()->grid; }
  const Grid& grid() const { return bonds_.begin()->grid; }
  double time() const { return static_cast<double>(now_.number) * now_.dt; }
  double dt() const { return now_.dt; }
  double seconds() const { return seconds_; }                            // of CPU in step(), loads left out
  int crossings() const { return bonds_.begin()->updated.crossings(); }  // in the last step
  const Law& law() const { return cement_->law(); }
  double density() const { return density_; }
  const Method& method() const { return method_; }
  std::size_t memory_usage() const { return cement_->report().memory_usage(); }
  // As fix mpm: lambda of these points where they stay, the bound for any place where they move; for linear hat functions, which
  // have none, that of these points with 20 % on top.
  double stable_step();
  double energy() {
    const CementTotals t = cement_->report().totals(0.0);
    return t.kinetic + t.elastic;
  }
  // f(block, lane)
  template <class F>
  void for_points(F f) const {
    for (std::size_t b = 0; b < points().blocks.size(); ++b)
      for (int l = 0; l < kLanes; ++l)
        if (points().meta[b].occupied >> l & 1) f(static_cast<int>(b), l);
  }

 private:
  std::array<double, 3> initial_velocity(int) override { return {0, 0, 0}; }
  void points_failed(const Bond&) override {}
  void links_debonded(const Bond&) override {}
  void slots_changed(const Bond&) override {}
  void add_node_forces(Bond& bond) override;
  void set_velocity(const std::function<Point(const Point&)>& velocity);
  Point place_of_node(int i) const;

  Method method_;
  double density_, seconds_ = 0.0, load_seconds_ = 0.0;  // of the loads of this step
  StepInput now_;
  Bonds bonds_;
  std::unique_ptr<Cement> cement_;
};

}  // namespace mpdem::bench

#endif
