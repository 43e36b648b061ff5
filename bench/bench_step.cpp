// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Rate of the full step (scatter, nodes, gather, material) on one core: a cube of n^3 cells
// of eight points, elastic or damaging. Damaging: the cube is stretched so that every point
// of the chosen share grows damage in every step.
#include <benchmark/benchmark.h>
#include <mpi.h>

#include <cmath>

#include "mpm/advance_points.h"

namespace {

using namespace mpdem;

constexpr double kCell = 1e-4;
constexpr double kDensity = 2710.0;

struct Cube {
  PointStore points;
  Grid grid;

  explicit Cube(int cells) {
    std::vector<int> live, tags, slots;
    const int n = 2 * cells;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
          PointRecord r;
          r.X[0] = (i + 0.5 - cells) * 0.5 * kCell;
          r.X[1] = (j + 0.5 - cells) * 0.5 * kCell;
          r.X[2] = (k + 0.5 - cells) * 0.5 * kCell;
          r.volume = 0.125 * kCell * kCell * kCell;
          tags.push_back(static_cast<int>(tags.size()) + 1);
          live.push_back(points.add(r, tags.back()));
        }
    points.arrange(live, tags, kCell, slots);
    std::vector<Grid::Cell> wanted;
    for (BlockMeta& m : points.meta) wanted.push_back({field_of(m.body, m.part), m.base, m.column});
    std::vector<char> fresh;
    grid.build(MPI_COMM_SELF, kCell, wanted, {}, fresh);
    grid.lump_mass(points, kDensity);
  }
};

// range(0): cells a side; range(1): per cent of the points that damage in every step.
void full_step(benchmark::State& state) {
  Cube cube(static_cast<int>(state.range(0)));
  const double share = 0.01 * static_cast<double>(state.range(1));
  DamageParameters p;
  p.B0 = 9.6e6;
  const TensorDamage law(VtiElasticity(VtiConstants{50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9}), p);
  const double dt = 3e-9;
  const double half = 0.5 * kCell * static_cast<double>(state.range(0));
  // Stretch along x of the slab x > (1 - 2 share) half, whose strain starts at the surface.
  const double onset = std::pow(2.0, 0.25) * std::sqrt(p.B0 / law.elasticity().C11), rate = 1e-5 * onset / dt;
  const double from = half * (1.0 - 2.0 * share);
  for (std::size_t b = 0; share > 0.0 && b < cube.points.blocks.size(); ++b)
    cube.points.blocks[b].strain.xx = select(cube.points.blocks[b].X[0] > from, splat(onset), vd{});
  AdvanceResult result;
  for (auto _ : state) {
    for (int i = 0; i < cube.grid.size(); ++i) {
      const double x = cube.grid.keys[i][1] * kCell;
      cube.grid.velocity[3 * i] = share > 0.0 ? rate * std::max(x - from, 0.0) : std::sin(100.0 * x);
    }
    cube.grid.clear_force();
    advance_points(cube.points, cube.grid, law, dt, result);
    cube.grid.sum_force();
    cube.grid.update_acceleration();
    cube.grid.drift(dt, dt);
  }
  const double points = 8.0 * std::pow(static_cast<double>(state.range(0)), 3);
  state.counters["points/s"] = benchmark::Counter(points * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
  state.counters["bytes/point"] = static_cast<double>(cube.points.memory_usage()) / points;
  state.counters["failed"] = static_cast<double>(result.failed.size());
}
BENCHMARK(full_step)->ArgsProduct({{12, 24, 48}, {0}})->Args({24, 10})->Unit(benchmark::kMillisecond);

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  MPI_Finalize();
  return 0;
}
