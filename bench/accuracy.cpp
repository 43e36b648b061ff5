// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Error against wall time on problems with exact solutions (problems.h): one line of CSV a run,
//   problem,kinematics,basis,transfer,h,points,steps,error,seconds
// error = sqrt(sum V |u - u_exact|^2 / sum V |u_exact|^2) over the points, at the end.
//
//   accuracy [problem...] [levels N]     problems: bar cube swirl vortex; N refinements, 4 by default
#include <mpi.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "mpm/advance_updated.h"
#include "mpm/gather.h"
#include "mpm/scatter.h"
#include "problems.h"

namespace {

using namespace mpdem;

struct Method {
  bool updated;
  Basis basis;
  Transfer::Method transfer;
  double parameter;  // share of flip, order of xpic
};

const char* name_of(Basis b) { return b == Basis::linear ? "linear" : b == Basis::quadratic ? "quadratic" : "cubic"; }
std::string name_of(const Method& m) {
  if (!m.updated) return "none";
  switch (m.transfer) {
    case Transfer::pic: return "pic";
    case Transfer::apic: return "apic";
    case Transfer::xpic: return "xpic";
    default: return "flip";
  }
}

class Run {
 public:
  Run(Problem& problem, double h, const Method& method)
      : problem_(problem), method_(method), h_(h), law_(VtiElasticity(problem.constants), DamageParameters()) {
    transfer_.method = method.transfer;
    transfer_.flip_share = method.parameter;
    grid_.basis = method.basis;
    std::vector<int> slots, tags, place;
    for (int i = 0; i < 2 * problem.cells[0]; ++i)
      for (int j = 0; j < 2 * problem.cells[1]; ++j)
        for (int k = 0; k < 2 * problem.cells[2]; ++k) {
          const int n[3] = {i, j, k};
          PointRecord r;
          r.has_frame = true;
          r.volume = h * h * h / 8.0;
          for (int d = 0; d < 3; ++d) r.X[d] = h * (0.5 * (n[d] + 0.5) - problem.low[d]);
          if (!problem.inside(r.X)) continue;
          tags.push_back(static_cast<int>(tags.size()) + 1);
          slots.push_back(points_.add(r, tags.back()));
        }
    points_.arrange(slots, tags, h, place, {}, method.basis);
    if (method.updated) points_.let_move();
    lay_out();
    // the velocity whose spline is the exact one to the third order
    const double k = method.basis == Basis::linear ? 0.0 : method.basis == Basis::quadratic ? 0.125 : 1.0 / 6.0;
    for (int i = 0; i < grid_.size(); ++i) {
      double x[3], u[3], v[3], w[3], sum[3];
      for (int d = 0; d < 3; ++d) x[d] = grid_.keys[i][1 + d] * h;
      problem.motion(x, 0.0, u, v);
      for (int d = 0; d < 3; ++d) sum[d] = (1.0 + 6.0 * k) * v[d];
      for (int d = 0; d < 3; ++d)
        for (int s : {-1, 1}) {
          double y[3] = {x[0], x[1], x[2]};
          y[d] += s * h;
          problem.motion(y, 0.0, u, w);
          for (int c = 0; c < 3; ++c) sum[c] -= k * w[c];
        }
      for (int d = 0; d < 3; ++d) grid_.velocity[3 * i + d] = sum[d];
    }
    planes_.repeat(grid_.velocity);
    if (method.updated) UpdatedPass::start(points_, grid_, 0);
    grid_.clear_force();
    add_internal_force(points_, grid_, law_);
    finish(0.0);
  }

  int points() const {
    int n = 0;
    for (const BlockMeta& m : points_.meta) n += __builtin_popcount(m.occupied);
    return n;
  }

  // From rest of the leap-frog to `end` in `steps`.
  void go(int steps) {
    const double dt = problem_.end / steps;
    grid_.drift(-0.5 * dt, 0.0);
    for (int n = 1; n <= steps; ++n) {
      AdvanceResult result;
      if (method_.updated) {
        if (pass_.layout_is_stale()) lay_out();
        grid_.drift(dt, 0.0);
        pass_.advance(points_, grid_, law_, problem_.density, dt, dt, transfer_, AdvanceOptions(), result);
        if (pass_.lost()) {
          lost_ = true;
          return;
        }
        planes_.fold_scalar(grid_.mass);
        planes_.fold_vector(grid_.momentum);
        for (int i = 0; i < grid_.size(); ++i)
          for (int d = 0; d < 3; ++d)
            grid_.velocity[3 * i + d] = grid_.mass[i] > 0.0 ? grid_.momentum[3 * i + d] / grid_.mass[i] : 0.0;
      } else {
        grid_.drift(dt, dt);
        grid_.clear_force();
        advance_points(points_, grid_, law_, dt, result);
      }
      finish(n * dt);
    }
  }

  double error(double t) const {
    double off = 0.0, size = 0.0;
    if (lost_) return NAN;
    with_basis(method_.basis, [&](auto type) {
      for (std::size_t b = 0; b < points_.blocks.size(); ++b) {
        const PointBlock& p = points_.blocks[b];
        vd u[3];
        gather_value(grid_.displacement.data(), points_.meta[b].column,
                     Weights<decltype(type)>(p.X, points_.meta[b].base, 1.0 / h_), u);
        const vd* X0 = points_.created_at(static_cast<int>(b));
        for (int l = 0; l < kLanes; ++l) {
          if (!(points_.meta[b].occupied >> l & 1)) continue;
          double X[3], exact[3], v[3];
          for (int d = 0; d < 3; ++d) X[d] = X0[d][l];
          problem_.motion(X, t, exact, v);
          for (int d = 0; d < 3; ++d) {
            const double e = (method_.updated ? p.X[d][l] - X[d] : u[d][l]) - exact[d];
            off += e * e;
            size += exact[d] * exact[d];
          }
        }
      }
    });
    return std::sqrt(off / size);
  }

 private:
  void lay_out() {
    std::vector<Grid::Cell> cells;
    for (BlockMeta& m : points_.meta) cells.push_back({field_of(m.body, m.part), m.base, m.column});
    std::vector<char> fresh;
    grid_.build(MPI_COMM_SELF, h_, cells, NodeKinematics(), fresh, {}, method_.updated ? UpdatedPass::kMargin : 0);
    grid_.lump_mass(points_, problem_.density);
    planes_ = problem_.planes;
    planes_.bind(grid_);
    planes_.fold_scalar(grid_.mass);
    if (method_.updated) pass_.bind(points_, grid_);
  }

  // Body force and accelerations at time t.
  void finish(double t) {
    if (problem_.has_body_force())
      with_basis(method_.basis, [&](auto type) {
        for (std::size_t b = 0; b < points_.blocks.size(); ++b) {
          const PointBlock& p = points_.blocks[b];
          const BlockMeta& m = points_.meta[b];
          const vd* X0 = points_.created_at(static_cast<int>(b));
          vd f[3]{};
          for (int l = 0; l < kLanes; ++l) {
            if (!(m.occupied >> l & 1)) continue;
            const double X[3] = {X0[0][l], X0[1][l], X0[2][l]};
            double force[3];
            problem_.body_force(X, t, force);
            for (int d = 0; d < 3; ++d) f[d][l] = problem_.density * p.volume[l] * force[d];
          }
          scatter_value(grid_.force.data(), m.column, Weights<decltype(type)>(p.X, m.base, 1.0 / h_), f);
        }
      });
    planes_.fold_vector(grid_.force);
    grid_.update_acceleration();
  }

  Problem& problem_;
  Method method_;
  double h_;
  TensorDamage law_;
  Transfer transfer_;
  PointStore points_;
  Grid grid_;
  UpdatedPass pass_;
  MirrorPlanes planes_;
  bool lost_ = false;
};

std::unique_ptr<Problem> make(const std::string& name, int n) {
  if (name == "bar") return std::make_unique<Bar>(n);
  if (name == "cube") return std::make_unique<Cube>(n);
  return std::make_unique<Vortex>(name.c_str(), n, name == "swirl" ? 0.1 : 1.0);
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  std::vector<std::string> problems;
  int levels = 4;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "levels" && i + 1 < argc && (levels = std::atoi(argv[i + 1])) >= 1 && levels <= 6) {
      ++i;
    } else if (word == "bar" || word == "cube" || word == "swirl" || word == "vortex") {
      problems.push_back(word);
    } else {
      std::fprintf(stderr, "accuracy: '%s' is no problem of this program; it knows bar, cube, swirl and vortex, and 'levels' with a "
                           "number from 1 to 6\n", word.c_str());
      MPI_Finalize();
      return 1;
    }
  }
  if (problems.empty()) problems = {"bar", "cube", "swirl", "vortex"};
  const Method methods[] = {{false, Basis::linear, Transfer::apic, 0},    {false, Basis::quadratic, Transfer::apic, 0},
                            {false, Basis::cubic, Transfer::apic, 0},     {true, Basis::linear, Transfer::flip, 1.0},
                            {true, Basis::quadratic, Transfer::pic, 0},   {true, Basis::quadratic, Transfer::flip, 1.0},
                            {true, Basis::quadratic, Transfer::apic, 0},  {true, Basis::cubic, Transfer::apic, 0}};
  std::printf("problem,kinematics,basis,transfer,h,points,steps,error,seconds\n");
  for (const std::string& name : problems) {
    int n = name == "cube" ? 6 : 8;
    for (int level = 0; level < levels; ++level, n *= 2) {
      if (name == "cube" && level == 3) n = 36;  // 48 would not say more
      for (const Method& method : methods) {
        const std::unique_ptr<Problem> problem = make(name, n);
        const double h = 1.0 / n;
        const int steps = static_cast<int>(std::ceil(problem->end * problem->speed / (0.2 * h)));
        const auto start = std::chrono::steady_clock::now();
        Run run(*problem, h, method);
        run.go(steps);
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        std::printf("%s,%s,%s,%s,%.6g,%d,%d,%.6g,%.4g\n", name.c_str(), method.updated ? "updated" : "total", name_of(method.basis),
                    name_of(method).c_str(), h, run.points(), steps, run.error(problem->end), seconds);
        std::fflush(stdout);
      }
    }
  }
  MPI_Finalize();
  return 0;
}
