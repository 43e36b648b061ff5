// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Error and time of the step on problems with a known solution, see doc/performance.md.
//   accuracy [--quick] [--list] [--periods N] [--section N] [name ...]
// Names (regular expressions) are problem/kinematics/basis/transfer. CSV on standard output:
// seconds are CPU seconds of the steps, loads left out; error is the rms over the points of
// the difference in displacement over a typical displacement, nan if the run broke down; drift
// the largest change of energy over the initial energy in ten periods, where there is no load.
#include <mpi.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <regex>
#include <stdexcept>

#include "mpm/gather.h"
#include "mpm/scatter.h"
#include "mpm/reproject.h"
#include "problems.h"

namespace {

using namespace mpdem;
using namespace mpdem::bench;

constexpr int kEnergyCells = 12;

std::vector<Point> lattice(const Problem& p, double h) {
  Point low, high;
  p.box(h, low, high);
  std::vector<Point> X;
  int n[3];
  double s[3];
  for (int d = 0; d < 3; ++d) {
    const int per_cell = d < 2 ? p.in_plane : 2;
    n[d] = static_cast<int>(std::lround(per_cell * (high[d] - low[d]) / h));
    s[d] = h / per_cell;
  }
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k) {
        const Point x = {low[0] + s[0] * (i + 0.5), low[1] + s[1] * (j + 0.5), low[2] + s[2] * (k + 0.5)};
        if (p.inside(x, h)) X.push_back(x);
      }
  return X;
}

Point created_at(const FreeBody& s, int b, int l) {
  const vd* X = s.points().created_at(b);
  return {X[0][l], X[1][l], X[2][l]};
}

// Consistent nodal forces of body force and traction. With `updated` the surface is where the
// solution says.
struct Load {
  const Problem& problem;
  std::vector<Problem::Facet> facets;

  // -V tau F^-T, tau = lambda ln J 1 + mu (F F^T - 1); with `updated` the gradients are those of the present.
  Mat3<vd> neo_hookean(const FreeBody& s, const PointBlock& p, vmask here) const {
    const Problem::NeoHookean& k = *problem.neo_hookean();
    const Mat3<vd> F = p.F, cof = cofactor(F);
    const vd J = F.a[0][0] * cof.a[0][0] + F.a[0][1] * cof.a[0][1] + F.a[0][2] * cof.a[0][2];
    vd pressure{};
    for (int l = 0; l < kLanes; ++l) pressure[l] = k.lambda * std::log(J[l]);
    Mat3<vd> tau, T;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        tau.a[i][j] = k.mu * (F.a[i][0] * F.a[j][0] + F.a[i][1] * F.a[j][1] + F.a[i][2] * F.a[j][2]);
        if (i == j) tau.a[i][j] += pressure - k.mu;
      }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        T.a[i][j] =
            s.method().updated ? tau.a[i][j] : (tau.a[i][0] * cof.a[0][j] + tau.a[i][1] * cof.a[1][j] + tau.a[i][2] * cof.a[2][j]) / J;
        T.a[i][j] = select(here, -p.volume * T.a[i][j], vd{});
      }
    return T;
  }

  template <class Type>
  void add(FreeBody& s, double t, std::vector<double>& force) const {
    const Grid& grid = s.grid();
    const double h = grid.h;
    const std::vector<PointBlock>& blocks = s.points().blocks;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const BlockMeta& m = s.points().meta[b];
      vd f[3] = {};
      for (int l = 0; l < kLanes; ++l)
        if (m.occupied >> l & 1) {
          const Point a = problem.body_force(created_at(s, static_cast<int>(b), l), t);
          for (int d = 0; d < 3; ++d) f[d][l] = problem.density * blocks[b].volume[l] * a[d];
        }
      with_weights<Type>(blocks[b], m, 1.0 / h, [&](const auto& w) {
        scatter_value(force.data(), m.column, w, f);
        if (problem.neo_hookean()) scatter_gradient(force.data(), m.column, w, neo_hookean(s, blocks[b], lanes(m.occupied)));
      });
    }
    for (const Problem::Facet& facet : facets) {
      Point x = facet.X;
      if (s.method().updated) {
        const Point u = problem.displacement(facet.X, t);
        for (int d = 0; d < 3; ++d) x[d] += u[d];
      }
      vd X[3], f[3] = {};
      int base[3], column[kMostColumns];
      for (int d = 0; d < 3; ++d) {
        // a hair inside, for the cell that has points
        const double inside = d == facet.normal ? x[d] - 1e-9 * h * facet.sense : x[d];
        base[d] = support_base(inside, 1.0 / h, Type::kShift);
        X[d] = splat(inside);
      }
      if (!grid.find_columns(field_of(0, 0), base, column)) throw std::runtime_error("surface outside of the grid");
      f[facet.normal][0] = facet.sense * facet.area * problem.traction(facet, t);
      scatter_value(force.data(), column, Weights<Type>(X, base, 1.0 / h), f);
    }
  }
  void operator()(FreeBody& s, double t, std::vector<double>& force) const {
    with_basis(s.grid().basis, [&](auto type) { add<decltype(type)>(s, t, force); });
  }
};

// `updated` has no use for F; here it is kept for the neo-Hookean stress: by the velocity that the points will meet in the step.
void advance_deformation_gradient(FreeBody& s) {
  const Grid& grid = s.grid();
  const double dt = s.dt();
  std::vector<double> velocity(grid.velocity);
  const Transfer& t = s.method().transfer;
  if (t.method == Transfer::xpic && t.order > 1) {
    s.grid().velocity.swap(velocity);
    filter_velocity(s.points(), s.grid(), {}, s.density(), t.order);
    s.grid().velocity.swap(velocity);
  }
  for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] += dt * grid.acceleration[i];
  with_basis(grid.basis, [&](auto type) {
    for (std::size_t b = 0; b < s.points().blocks.size(); ++b) {
      PointBlock& p = s.points().blocks[b];
      const BlockMeta& m = s.points().meta[b];
      const vmask here = lanes(m.occupied);
      vd v[3];
      const Mat3<vd> L = gather_value_and_gradient(velocity.data(), m.column, Weights<decltype(type)>(p.X, m.base, 1.0 / grid.h), v);
      Mat3<vd> F;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const vd grown = p.F.a[i][j] + dt * (L.a[i][0] * p.F.a[0][j] + L.a[i][1] * p.F.a[1][j] + L.a[i][2] * p.F.a[2][j]);
          F.a[i][j] = select(here, grown, splat(i == j ? 1.0 : 0.0));
        }
      p.F = F;
    }
  });
}

double error(const Problem& p, const FreeBody& s) {
  double sum = 0.0;
  long n = 0;
  with_basis(s.grid().basis, [&](auto type) {
    for (std::size_t b = 0; b < s.points().blocks.size(); ++b) {
      const PointBlock& q = s.points().blocks[b];
      const BlockMeta& m = s.points().meta[b];
      vd u[3];
      if (s.method().updated) {
        for (int d = 0; d < 3; ++d) u[d] = q.X[d] - s.points().created_at(static_cast<int>(b))[d];
      } else {
        with_weights<decltype(type)>(q, m, 1.0 / s.grid().h,
                                     [&](const auto& w) { gather_value(s.grid().displacement.data(), m.column, w, u); });
      }
      for (int l = 0; l < kLanes; ++l)
        if (m.occupied >> l & 1) {
          const Point exact = p.displacement(created_at(s, static_cast<int>(b), l), s.time());
          for (int d = 0; d < 3; ++d) sum += std::pow(u[d][l] - exact[d], 2);
          ++n;
        }
    }
  });
  return std::sqrt(sum / static_cast<double>(n)) / p.scale;
}

void measure(const Problem& p, const Method& m, int cells) {
  const double h = 1.0 / cells;
  const std::vector<Point> X = lattice(p, h);
  const double volume = h * h * h / (2 * p.in_plane * p.in_plane);
  FreeBody s(m, h, X, volume, std::make_shared<NoDamage>(p.law()), p.density);
  double stable = s.stable_step();
  if (const Problem::NeoHookean* k = p.neo_hookean()) {
    const double E = k->mu * (3 * k->lambda + 2 * k->mu) / (k->lambda + k->mu), nu = k->lambda / (2 * (k->lambda + k->mu));
    stable = FreeBody(m, h, X, volume, std::make_shared<NoDamage>(VtiElasticity(VtiConstants::isotropic(E, nu))), p.density).stable_step();
    if (m.updated) s.before_step = advance_deformation_gradient;
  }
  const int steps = static_cast<int>(std::ceil(p.looks[0] / (p.of_stable * stable)));
  const double dt = p.looks[0] / steps;
  double worst = 0.0, drift = NAN, seconds = NAN;
  int taken = 0;
  try {
    if (p.loaded()) {
      s.load = Load{p, p.facets(h)};
      s.held = [&](const Point& x) { return p.held(x); };
    }
    s.start(dt, [&](const Point& x) { return p.velocity(x, -0.5 * dt); });
    for (double look : p.looks) {
      for (; s.time() < look - 0.5 * dt; ++taken) s.step();
      const double e = error(p, s);
      worst = std::isfinite(e) ? std::max(worst, e) : NAN;
      if (std::isnan(worst)) break;
    }
    seconds = s.seconds();
    if (p.energy_until > 0.0 && cells == kEnergyCells) {
      double start = 0.0;
      drift = 0.0;
      for (double t = s.time(); t < p.energy_until; t += dt) {
        s.step();
        const double energy = s.energy();
        if (start == 0.0) start = energy;
        drift = std::max(drift, std::fabs(energy / start - 1.0));
      }
    }
  } catch (const std::runtime_error&) {
    worst = NAN;
  }
  std::printf("%s,%s,%d,%zu,%d,%.6g,%.6g,%.6g\n", p.name.c_str(), m.name().c_str(), cells, X.size(), taken, seconds, worst, drift);
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  bool quick = false, list = false;
  BarOptions bar;
  std::string wanted;
  for (int i = 1; i < argc; ++i) {
    if (!std::strcmp(argv[i], "--quick")) quick = true;
    else if (!std::strcmp(argv[i], "--list")) list = true;
    else if (!std::strcmp(argv[i], "--periods") && i + 1 < argc) bar.periods = std::atoi(argv[++i]);
    else if (!std::strcmp(argv[i], "--section") && i + 1 < argc) bar.section = std::atoi(argv[++i]);
    else wanted += (wanted.empty() ? "" : "|") + std::string(argv[i]);
  }
  struct Run {
    const Problem* problem;
    const Method* method;
    std::string name;
  };
  if (bar.periods < 1 || bar.section < 1) {
    std::fprintf(stderr, "accuracy: '--periods' and '--section' must be 1 or more\n");
    return 1;
  }
  const auto problems = all_problems(bar);
  std::vector<Run> all, chosen;
  for (const auto& p : problems)
    for (const Method& m : all_methods()) all.push_back({p.get(), &m, p->name + "/" + m.name()});
  const std::regex point_template(wanted);
  for (const Run& r : all)
    if (std::regex_search(r.name, point_template)) chosen.push_back(r);
  if (chosen.empty()) {
    std::fprintf(stderr, "accuracy: no benchmark matches '%s'; names are\n", wanted.c_str());
    for (const Run& r : all) std::fprintf(stderr, "  %s\n", r.name.c_str());
    return 1;
  }
  if (!list) std::printf("problem,method,cells,points,steps,seconds,error,drift\n");
  for (const Run& r : chosen) {
    const std::vector<int>& cells = r.problem->cells;
    if (list) std::printf("%s\n", r.name.c_str());
    for (int i = 0; !list && i < (quick ? r.problem->quick : static_cast<int>(cells.size())); ++i) measure(*r.problem, *r.method, cells[i]);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  const int status = run(argc, argv);
  MPI_Finalize();
  return status;
}
