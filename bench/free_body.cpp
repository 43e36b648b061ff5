// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "free_body.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cement/step/kinematics.h"
#include "mpm/consistent_mass.h"
#include "mpm/gather.h"
#include "mpm/scatter.h"
#include "mpm/largest_eigenvalue.h"
#include "parallel/agree.h"

namespace mpdem::bench {

namespace {

// CPU time: the same as wall time on a quiet machine, and little else on a busy one.
double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

CementOptions options_of(const Method& method, double h) {
  CementOptions o;
  o.cell = h;
  o.basis = method.basis;
  o.axis = AxisRule::global;
  o.updated = method.updated;
  o.transfer = method.transfer;
  o.reproject_every = method.transfers && !method.updated ? 1 : 0;
  o.tied = !o.reprojects();
  o.mass_order = method.mass_order;
  return o;
}

}  // namespace

std::string Method::name() const {
  const char* bases[] = {"linear", "quadratic", "cubic"};
  const std::string transfer_name = transfer.method == Transfer::flip   ? "flip"
                                    : transfer.method == Transfer::apic ? "apic"
                                    : transfer.order == 1               ? "pic"
                                                                        : "xpic2";
  return std::string(updated ? "updated/" : "total/") + bases[static_cast<int>(basis)] + "/" +
         (transfers         ? transfer_name
          : mass_order == 2 ? "order2"
                            : "none");
}

const std::vector<Method>& all_methods() {
  static const std::vector<Method> methods = [] {
    std::vector<Method> all;
    for (bool updated : {false, true})
      for (Basis basis : {Basis::linear, Basis::quadratic, Basis::cubic}) {
        if (!updated)
          for (int order : {1, 2}) all.push_back({false, basis, false, {}, order});
        for (const Transfer& t :
             {Transfer{Transfer::xpic, 1.0, 1}, Transfer{Transfer::flip}, Transfer{Transfer::apic}, Transfer{Transfer::xpic, 1.0, 2}})
          all.push_back({updated, basis, true, t, 1});
      }
    return all;
  }();
  return methods;
}

FreeBody::FreeBody(const Method& method, double h, const std::vector<Point>& X, double volume, std::shared_ptr<const Law> law,
                   double density)
    : method_(method),
      density_(density),
      cement_(std::make_unique<Cement>(MPI_COMM_SELF, bonds_, options_of(method, h), std::move(law), *this)) {
  BondRecord record;
  record.grain[0] = 1;
  record.grain[1] = 2;
  record.points = static_cast<int>(X.size());
  record.volume = volume * static_cast<double>(X.size());
  record.spacing = std::cbrt(volume);
  bonds_.table.push_back(record);
  int tag = 0;
  for (const Point& x : X) {
    PointRecord r;
    r.has_frame = true;
    std::copy(x.begin(), x.end(), r.X);
    r.volume = volume;
    bonds_.add(r, ++tag);
  }
  cement_->set_density(density);
  cement_->read_point_states();
}

void FreeBody::start(double dt, const std::function<Point(const Point&)>& velocity) {
  now_.dt = dt;
  cement_->set_step(now_);
  cement_->lay_out_run();
  cement_->start_run();
  Grid& g = grid();
  set_velocity(velocity);
  if (method_.updated) {  // as at the end of a step
    UpdatedPass::start(points(), g, 0);
    UpdatedPass::project(points(), g, law(), density_, method_.transfer);
    velocities_from_momentum(g);
  }
  cement_->check_state();
}

// Nodal values that give the points their velocities, M v = sum_p m_p N_I v_p. They are not the values of the spline at the nodes,
// which would be those of a field that is smoother by (kh)^2/8. The part of an error that the lumped mass sees is left in each round.
void FreeBody::set_velocity(const std::function<Point(const Point&)>& velocity) {
  constexpr int kRounds = 30;
  Grid& g = grid();
  std::vector<double> given(g.velocity.size(), 0.0);
  with_basis(g.basis, [&](auto type) {
    for (std::size_t b = 0; b < points().blocks.size(); ++b) {
      const PointBlock& p = points().blocks[b];
      const BlockMeta& m = points().meta[b];
      vd momentum[3] = {};
      for (int l = 0; l < kLanes; ++l)
        if (m.occupied >> l & 1) {
          const Point v = velocity({p.X[0][l], p.X[1][l], p.X[2][l]});
          for (int d = 0; d < 3; ++d) momentum[d][l] = density_ * p.volume[l] * v[d];
        }
      with_weights<decltype(type)>(p, m, 1.0 / g.h, [&](const auto& w) { scatter_value(given.data(), m.column, w, momentum); });
    }
  });
  g.constraints.add_to_mass_receivers(given.data(), 3);
  for (int i = 0; i < g.size(); ++i) {
    const Point v = velocity(place_of_node(i));
    std::copy(v.begin(), v.end(), &g.velocity[3 * i]);
  }
  g.constraints.extend(g.velocity.data());
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> left(given);
    add_consistent_mass(points(), g, density_, MassOf::all_points, -1.0, g.velocity, left);
    for (int i = 0; i < g.size(); ++i)
      for (int d = 0; d < 3 && g.mass[i] > 0.0; ++d) g.velocity[3 * i + d] += left[3 * i + d] / g.mass[i];
    g.constraints.extend(g.velocity.data());
  }
}

void FreeBody::step() {
  if (before_step) before_step(*this);
  ++now_.number;
  load_seconds_ = 0.0;
  const double from = cpu_seconds();
  cement_->set_step(now_);
  cement_->start_step(false);
  cement_->grains_moved();
  cement_->step();
  cement_->end_step();
  seconds_ += cpu_seconds() - from - load_seconds_;
}

Point FreeBody::place_of_node(int i) const {
  const Grid& g = grid();
  return {g.h * g.keys[i].at(0), g.h * g.keys[i].at(1), g.h * g.keys[i].at(2)};
}

void FreeBody::add_node_forces(Bond& bond) {
  if (!load && !held) return;
  const double from = cpu_seconds();
  Grid& g = bond.grid;
  if (load) {
    std::vector<double> force(g.force.size(), 0.0);
    load(*this, time(), force);
    g.constraints.gather_to_masters(force.data());
    for (std::size_t i = 0; i < force.size(); ++i) g.force[i] += force[i];
  }
  for (int i = 0; i < g.size() && held; ++i)
    if (held(place_of_node(i)))
      for (int d = 0; d < 3; ++d) g.force[3 * i + d] = g.velocity[3 * i + d] = 0.0;
  load_seconds_ += cpu_seconds() - from;
}

double FreeBody::stable_step() {
  double lambda = 0.0;
  if (method_.updated) lambda = eigenvalue_bound(method_.basis, law().elasticity().largest_stiffness(), density_, cement_->options().cell);
  if (lambda == 0.0) lambda = (method_.updated ? 1.2 : 1.0) * cement_->eigenvalue_of_new_layout().value;
  return cement_->stable_step().step_for(lambda, 0.0);
}

}  // namespace mpdem::bench
