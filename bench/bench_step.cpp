// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Rate of the full step on one core: a cube of n^3 cells of eight points.
//
//   step/KINEMATICS/BASIS/TRANSFER/STATE/n   elastic: the law is on, no point reaches its surface;
//                                  damaging: a tenth of the points, all over the cube, damage in every
//                                  step under strains of random direction
//   machine/triad, machine/fma     bandwidth of memory and peak of arithmetic of the same core
//   scalar/total/quadratic         the elastic step point by point, nodes in a triple loop
//
// `updated` cubes fly so fast that one point in a hundred changes its cell in a step; moving them
// from block to block and laying out the grid anew is part of the step.
#include <benchmark/benchmark.h>
#include <mpi.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>

#include "mpm/advance_updated.h"
#include "mpm/reproject.h"
#include "mpm/resting.h"

namespace {

using namespace mpdem;

constexpr double kCell = 1e-4, kDensity = 2710.0, kStep = 3e-9;

TensorDamage law_of_calcite() {
  DamageParameters p;
  p.B0 = 9.6e6;
  return TensorDamage(VtiElasticity(VtiConstants{50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9}), p);
}

struct Cube {
  PointStore points;
  Grid grid;
  UpdatedPass pass;
  bool updated;

  Cube(int cells, Basis basis, bool moving) : updated(moving) {
    std::vector<int> live, tags, slots;
    const int n = 2 * cells;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
          PointRecord r;
          r.has_frame = true;
          const int at[3] = {i, j, k};
          for (int d = 0; d < 3; ++d) r.X[d] = (at[d] + 0.5 - cells) * 0.5 * kCell;
          r.volume = 0.125 * kCell * kCell * kCell;
          tags.push_back(static_cast<int>(tags.size()) + 1);
          live.push_back(points.add(r, tags.back()));
        }
    points.arrange(live, tags, kCell, slots, {}, basis);
    grid.basis = basis;
    if (updated) points.let_move();
    lay_out();
  }
  void lay_out() {
    std::vector<Grid::Cell> wanted;
    for (BlockMeta& m : points.meta) wanted.push_back({field_of(m.body, m.part), m.base, m.column});
    std::vector<char> fresh;
    grid.build(MPI_COMM_SELF, kCell, wanted, {}, fresh, {}, updated ? UpdatedPass::kMargin : 0);
    grid.lump_mass(points, kDensity);
    if (updated) pass.bind(points, grid);
  }
  void arrange() {
    std::vector<int> live, tags, slots;
    for (std::size_t b = 0; b < points.meta.size(); ++b)
      for (int l = 0; l < kLanes; ++l)
        if (points.meta[b].occupied >> l & 1) {
          live.push_back(kLanes * static_cast<int>(b) + l);
          tags.push_back(points.tags[b][l]);
        }
    points.arrange(live, tags, kCell, slots, {}, grid.basis);
  }
};

// Strain of a block at the surface of the law in a direction of its own, and the rate that
// carries it on: what damages grows in every step, slowly enough to go on for the whole run.
void load(Cube& cube, const TensorDamage& law) {
  std::mt19937_64 engine(7);
  const auto uniform = [&] { return 0x1p-52 * static_cast<double>(engine() >> 11) - 1.0; };
  for (std::size_t b = 0; b < cube.points.blocks.size(); ++b) {
    if (b % 10 != 3) continue;
    Sym3<vd>& e = cube.points.blocks[b].strain;
    for (vd* x : {&e.xx, &e.yy, &e.zz, &e.yz, &e.xz, &e.xy}) *x = splat(uniform());
    const double Yeq = law.drive(e, Sym3<vd>{}).Yeq[0];
    const vd scale = splat(1.001 * std::sqrt(law.parameters().B0 / Yeq));
    for (vd* x : {&e.xx, &e.yy, &e.zz, &e.yz, &e.xz, &e.xy}) *x *= scale;
  }
}

struct Setting {
  bool updated;
  Basis basis;
  bool transfers;
  Transfer transfer;
  bool damaging;
  int cells;
};

void full_step(benchmark::State& state, Setting s) {
  Cube cube(s.cells, s.basis, s.updated);
  const TensorDamage law = law_of_calcite();
  if (s.damaging) load(cube, law);
  Resting resting;
  resting.bind(cube.points, cube.grid);
  // a motion that strains everywhere, and a flight: a point in a hundred crosses a face a step
  const double flight = s.updated ? 0.01 * kCell / kStep : 0.0;
  for (int i = 0; i < cube.grid.size(); ++i) {
    cube.grid.velocity[3 * i] = flight;
    for (int d = 0; d < 3 && !s.damaging; ++d) cube.grid.velocity[3 * i + d] += 1e-3 * std::sin(0.1 * cube.grid.keys[i][1 + d]);
  }
  if (s.updated) UpdatedPass::start(cube.points, cube.grid, 0);
  std::vector<double> jump;
  std::size_t full = cube.points.blocks.size();
  double crossed = 0.0, damaged = 0.0, failed = 0.0;
  for (auto _ : state) {
    AdvanceResult result;
    if (s.damaging)  // the blocks that damage go on
      for (std::size_t b = 3; b < cube.points.blocks.size(); b += 10) {
        Sym3<vd>& e = cube.points.blocks[b].strain;
        for (vd* x : {&e.xx, &e.yy, &e.zz, &e.yz, &e.xz, &e.xy}) *x *= 1.00005;
      }
    if (s.updated) {
      if (cube.pass.layout_is_stale()) {
        if (cube.points.blocks.size() > full + full / 3) {
          cube.arrange();
          full = cube.points.blocks.size();
        }
        cube.lay_out();
      }
      if (s.transfer.method == Transfer::xpic) filter_velocity(cube.points, cube.grid, kDensity, s.transfer.order);
      cube.grid.drift(kStep, 0.0);
      cube.pass.advance(cube.points, cube.grid, law, kDensity, kStep, kStep, s.transfer, AdvanceOptions(), result);
      crossed += static_cast<double>(cube.pass.moves().size());
      for (int i = 0; i < cube.grid.size(); ++i)
        for (int d = 0; d < 3; ++d)
          if (cube.grid.mass[i] > 0.0) cube.grid.velocity[3 * i + d] = cube.grid.momentum[3 * i + d] / cube.grid.mass[i];
    } else {
      if (s.transfers) reproject_velocity(cube.points, cube.grid, kDensity, s.transfer, kStep, jump);
      cube.grid.drift(kStep, kStep);
      cube.grid.clear_force();
      resting.advance(cube.points, cube.grid, law, kStep, AdvanceOptions(), result);
    }
    cube.grid.sum_force();
    cube.grid.update_acceleration();
    // Held nodes, or the stress of what damages would unload it.
    if (s.damaging) std::fill(cube.grid.acceleration.begin(), cube.grid.acceleration.end(), 0.0);
    damaged += result.dissipated > 0.0;
    failed += static_cast<double>(result.failed.size());
  }
  const double points = 8.0 * std::pow(static_cast<double>(s.cells), 3), n = static_cast<double>(state.iterations());
  state.counters["points"] = points;
  state.counters["points/s"] = benchmark::Counter(points * n, benchmark::Counter::kIsRate);
  state.counters["bytes/point"] = static_cast<double>(cube.points.memory_usage() + cube.grid.memory_usage()) / points;
  if (s.updated) state.counters["crossing"] = crossed / n / points;
  if (s.damaging) {
    double D = 0.0;
    for (const BlockMeta& m : cube.points.meta) D += m.damaged;
    state.counters["share_damaged"] = D / static_cast<double>(cube.points.meta.size());
    state.counters["steps_damaging"] = damaged / n;
    state.counters["failed"] = failed;
  }
}

// Sum of two arrays into a third, each far larger than the caches.
void triad(benchmark::State& state) {
  const std::size_t n = 1u << 24;
  std::vector<double> a(n, 1.0), b(n, 2.0), c(n, 3.0);
  for (auto _ : state) {
    for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 0.5 * c[i];
    benchmark::DoNotOptimize(a.data());
    benchmark::ClobberMemory();
  }
  state.counters["bytes/s"] = benchmark::Counter(24.0 * n * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

// Twelve independent chains of multiply and add on whole vectors.
void fma(benchmark::State& state) {
  vd x[12];
  for (int i = 0; i < 12; ++i) x[i] = splat(1.0 + i);
  const vd a = splat(0.999999), b = splat(1e-6);
  constexpr int kRounds = 1000;
  for (auto _ : state) {
    for (int r = 0; r < kRounds; ++r)
      for (vd& y : x) y = y * a + b;
    for (vd& y : x) benchmark::DoNotOptimize(y);
  }
  state.counters["flop/s"] =
      benchmark::Counter(2.0 * kLanes * 12 * kRounds * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

// What the blocks are measured against: the same elastic step, one point at a time.
void scalar_step(benchmark::State& state) {
  constexpr int kCells = 24;
  Cube cube(kCells, Basis::quadratic, false);
  const VtiElasticity C = law_of_calcite().elasticity();
  struct Point {
    double X[3], volume, F[9], strain[6];
    int column[9], base[3];
  };
  std::vector<Point> points;
  for (std::size_t b = 0; b < cube.points.blocks.size(); ++b)
    for (int l = 0; l < kLanes; ++l) {
      if (!(cube.points.meta[b].occupied >> l & 1)) continue;
      Point p{};
      for (int d = 0; d < 3; ++d) p.X[d] = cube.points.blocks[b].X[d][l], p.base[d] = cube.points.meta[b].base[d];
      for (int c = 0; c < 9; ++c) p.column[c] = cube.points.meta[b].column[c];
      p.volume = cube.points.blocks[b].volume[l];
      for (int d = 0; d < 3; ++d) p.F[4 * d] = 1.0;
      points.push_back(p);
    }
  Grid& g = cube.grid;
  for (int i = 0; i < 3 * g.size(); ++i) g.velocity[i] = 1e-3 * std::sin(0.1 * g.keys[i / 3][1 + i % 3]);
  for (auto _ : state) {
    g.drift(kStep, kStep);
    g.clear_force();
    for (Point& p : points) {
      double w[3][3], dw[3][3], L[9] = {0};
      for (int d = 0; d < 3; ++d) {
        const double t = p.X[d] / kCell - (p.base[d] + 1.0);
        w[d][0] = 0.5 * (0.5 - t) * (0.5 - t), w[d][1] = 0.75 - t * t, w[d][2] = 0.5 * (0.5 + t) * (0.5 + t);
        dw[d][0] = -(0.5 - t) / kCell, dw[d][1] = -2.0 * t / kCell, dw[d][2] = (0.5 + t) / kCell;
      }
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          for (int k = 0; k < 3; ++k) {
            const double* v = &g.velocity[3 * (p.column[3 * i + j] + k)];
            const double N[3] = {dw[0][i] * w[1][j] * w[2][k], w[0][i] * dw[1][j] * w[2][k], w[0][i] * w[1][j] * dw[2][k]};
            for (int c = 0; c < 3; ++c)
              for (int d = 0; d < 3; ++d) L[3 * c + d] += v[c] * N[d];
          }
      for (int c = 0; c < 9; ++c) p.F[c] += kStep * L[c];
      const double e[6] = {L[0], L[4], L[8], 0.5 * (L[5] + L[7]), 0.5 * (L[2] + L[6]), 0.5 * (L[1] + L[3])};
      for (int c = 0; c < 6; ++c) p.strain[c] += kStep * e[c];
      const Sym3<double> s = C.stress(Sym3<double>{p.strain[0], p.strain[1], p.strain[2], p.strain[3], p.strain[4], p.strain[5]});
      const double T[9] = {s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz};
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          for (int k = 0; k < 3; ++k) {
            double* f = &g.force[3 * (p.column[3 * i + j] + k)];
            const double N[3] = {dw[0][i] * w[1][j] * w[2][k], w[0][i] * dw[1][j] * w[2][k], w[0][i] * w[1][j] * dw[2][k]};
            for (int c = 0; c < 3; ++c)
              f[c] -= p.volume * (T[3 * c] * N[0] + T[3 * c + 1] * N[1] + T[3 * c + 2] * N[2]);
          }
    }
    g.update_acceleration();
  }
  state.counters["points/s"] = benchmark::Counter(static_cast<double>(points.size()) * static_cast<double>(state.iterations()),
                                                  benchmark::Counter::kIsRate);
}

void register_all() {
  const auto add = [](const std::string& name, Setting s) {
    benchmark::RegisterBenchmark((name + "/" + std::to_string(s.cells)).c_str(), full_step, s)->Unit(benchmark::kMillisecond);
  };
  const std::pair<const char*, Basis> bases[] = {{"linear", Basis::linear}, {"quadratic", Basis::quadratic}, {"cubic", Basis::cubic}};
  const std::pair<const char*, Transfer> transfers[] = {
      {"pic", {Transfer::pic, 0, 1}}, {"flip", {Transfer::flip, 1, 1}}, {"apic", {Transfer::apic, 0, 1}}, {"xpic2", {Transfer::xpic, 0, 2}}};
  for (bool damaging : {false, true})
    for (const auto& b : bases) {
      const std::string state = damaging ? "damaging" : "elastic";
      add(std::string("step/total/") + b.first + "/none/" + state, {false, b.second, false, {}, damaging, 24});
      for (const auto& t : transfers) {
        add(std::string("step/total/") + b.first + "/" + t.first + "/" + state, {false, b.second, true, t.second, damaging, 24});
        add(std::string("step/updated/") + b.first + "/" + t.first + "/" + state, {true, b.second, true, t.second, damaging, 24});
      }
    }
  for (int cells : {11, 23, 50, 79}) add("size/total/quadratic/none/elastic", {false, Basis::quadratic, false, {}, false, cells});
  benchmark::RegisterBenchmark("machine/triad", triad);
  benchmark::RegisterBenchmark("machine/fma", fma);
  benchmark::RegisterBenchmark("scalar/total/quadratic/none/elastic", scalar_step)->Unit(benchmark::kMillisecond);
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  const std::size_t run = benchmark::RunSpecifiedBenchmarks();
  MPI_Finalize();
  return run > 0 ? 0 : 1;
}
