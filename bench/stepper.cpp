// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "stepper.h"

#include <time.h>

#include <algorithm>
#include <stdexcept>

#include "mpm/largest_eigenvalue.h"
#include "mpm/point_stress.h"
#include "mpm/reproject.h"

namespace mpdem::bench {

namespace {

// CPU time: the same as wall time on a quiet machine, and little else on a busy one.
struct Stopwatch {
  explicit Stopwatch(double& seconds) : seconds_(seconds), from_(now()) {}
  ~Stopwatch() { seconds_ += now() - from_; }
  static double now() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  double& seconds_;
  double from_;
};

}  // namespace

std::string Method::name() const {
  const char* bases[] = {"linear", "quadratic", "cubic"};
  const char* transfer_names[] = {"pic", "flip", "apic", "xpic2"};
  return std::string(updated ? "updated/" : "total/") + bases[static_cast<int>(basis)] + "/" +
         (transfers ? transfer_names[transfer.method] : "none");
}

const std::vector<Method>& all_methods() {
  static const std::vector<Method> methods = [] {
    std::vector<Method> all;
    for (bool updated : {false, true})
      for (Basis basis : {Basis::linear, Basis::quadratic, Basis::cubic}) {
        if (!updated) all.push_back({false, basis, false, {}});
        for (auto m : {Transfer::pic, Transfer::flip, Transfer::apic, Transfer::xpic}) {
          Transfer t;
          t.method = m;
          all.push_back({updated, basis, true, t});
        }
      }
    return all;
  }();
  return methods;
}

Stepper::Stepper(const Method& method, double h, const std::vector<Point>& X, double volume,
                 std::shared_ptr<const Law> law, double density)
    : method_(method), law_(std::move(law)), density_(density) {
  grid.h = h;
  grid.basis = method.basis;
  int tag = 0;
  for (const Point& x : X) {
    PointRecord r;
    r.has_frame = true;
    std::copy(x.begin(), x.end(), r.X);
    r.volume = volume;
    points.add(r, ++tag);
  }
  points.arrange(h, method.basis);
  if (method.updated) points.let_move();
  blocks_when_arranged_ = points.blocks.size();
  lay_out();
}

void Stepper::lay_out() {
  std::vector<Grid::Cell> cells;
  for (BlockMeta& m : points.meta) cells.push_back({field_of(m.body, m.part), m.base, m.column});
  std::vector<char> fresh;
  grid.build(MPI_COMM_SELF, grid.h, cells, NodeKinematics(), fresh, {}, method_.updated ? UpdatedPass::kMargin : 0);
  grid.lump_mass(points, density_);
  if (method_.updated) pass_.bind(points, grid);
  ++layouts_;
}

void Stepper::arrange() {
  points.arrange(grid.h, method_.basis);
  blocks_when_arranged_ = points.blocks.size();
}

void Stepper::start(const std::function<Point(const Point&)>& velocity) {
  for (int i = 0; i < grid.size(); ++i) {
    const Point v = velocity({grid.h * grid.keys[i][1], grid.h * grid.keys[i][2], grid.h * grid.keys[i][3]});
    std::copy(v.begin(), v.end(), &grid.velocity[3 * i]);
  }
  if (method_.updated) {
    UpdatedPass::start(points, grid, 0);
    UpdatedPass::project(points, grid, *law_, density_, method_.transfer);
    take_momentum();
  }
}

void Stepper::accelerate() {
  grid.clear_force();
  if (load) load(*this, time_);
  if (method_.updated) {
    const std::vector<double> outside(grid.force);
    UpdatedPass::project(points, grid, *law_, density_, method_.transfer);
    for (std::size_t i = 0; i < outside.size(); ++i) grid.force[i] += outside[i];
  } else {
    add_internal_force(points, grid, *law_);
  }
  grid.update_acceleration();
}

void Stepper::take_momentum() {
  for (int i = 0; i < grid.size(); ++i)
    if (grid.mass[i] > 0.0)
      for (int d = 0; d < 3; ++d) grid.velocity[3 * i + d] = grid.momentum[3 * i + d] / grid.mass[i];
}

void Stepper::step(double dt) {
  result_.dissipated = result_.released = 0.0;
  result_.failed.clear();
  {
    Stopwatch watch(seconds_);
    method_.updated ? step_updated(dt) : step_total(dt);
  }
  time_ += dt;
  if (load) load(*this, time_);
  Stopwatch watch(seconds_);
  grid.sum_force();
  grid.update_acceleration();
}

void Stepper::step_total(double dt) {
  if (method_.transfers) reproject_velocity(points, grid, {}, density_, method_.transfer, dt, jump_);
  grid.drift(dt, dt);
  grid.clear_force();
  advance_points(points, grid, *law_, dt, result_);
}

void Stepper::step_updated(double dt) {
  if (pass_.layout_is_stale()) {
    if (points.blocks.size() > blocks_when_arranged_ + blocks_when_arranged_ / 3) arrange();
    lay_out();
  }
  grid.drift(dt, 0.0);
  if (method_.transfer.method == Transfer::xpic && method_.transfer.order > 1) {
    for (std::size_t i = 0; i < grid.velocity.size(); ++i) grid.velocity[i] -= dt * grid.acceleration[i];
    filter_velocity(points, grid, {}, density_, method_.transfer.order);
    for (std::size_t i = 0; i < grid.velocity.size(); ++i) grid.velocity[i] += dt * grid.acceleration[i];
  }
  if (before_points) before_points(*this, dt);
  pass_.advance(points, grid, *law_, density_, dt, dt, method_.transfer, AdvanceOptions(), result_);
  if (pass_.lost()) throw std::runtime_error("point " + std::to_string(pass_.lost()) + " is lost");
  crossings_ += pass_.crossings();
  grid.halo.sum(grid.mass.data(), 1);
  grid.halo.sum(grid.momentum.data(), 3);
  take_momentum();
}

double Stepper::stable_step() {
  double lambda = 0.0;
  if (method_.updated) lambda = eigenvalue_bound(method_.basis, law_->elasticity().largest_stiffness(), density_, grid.h);
  if (lambda == 0.0) lambda = (method_.updated ? 1.2 : 1.0) * largest_eigenvalue(MPI_COMM_SELF, points, grid, *law_).value;
  return std::sqrt((method_.transfers ? 2.0 : 4.0) / lambda);
}

double Stepper::kinetic_energy(double half_step) const {
  double energy = 0.0;
  for (int i = 0; i < grid.size(); ++i)
    for (int d = 0; d < 3; ++d) {
      const double v = grid.velocity[3 * i + d] + half_step * grid.acceleration[3 * i + d];
      energy += 0.5 * grid.mass[i] * v * v;
    }
  return energy;
}

double Stepper::strain_energy() const {
  double energy = 0.0;
  with_law(*law_, [&](const auto& law) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b)
      energy += 0.5 * sum_lanes(points.blocks[b].volume *
                                contract(stress_of(points, static_cast<int>(b), law), points.blocks[b].strain));
  });
  return energy;
}

}  // namespace mpdem::bench
