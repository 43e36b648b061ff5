// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Rates on one core, see doc/performance.md:
//   step/<kinematics>/<basis>/<transfer>/<elastic|damaging>   the full step of a cube of 110 592, points anywhere in their cells
//   lattice/<elastic|damaging>                                the default step of that cube with its points in a lattice
//   size/<points>                                             the default step by number of points
//   scalar/total/quadratic/none/elastic                       the yardstick of scalar_step.h
//   machine/triad, machine/multiply_add                       what the core can do
// Arguments: names (regular expressions), and those of Google Benchmark.
#include <benchmark/benchmark.h>
#include <mpi.h>

#include <cstdio>
#include <cstring>
#include <iostream>
#include <memory>
#include <random>

#include "machine.h"
#include "scalar_step.h"

namespace {

using namespace mpdem;
using namespace mpdem::bench;

constexpr double kCell = 1e-4, kStep = 3e-9;
// So heavy that the large forces of the random states below move nothing.
constexpr double kDensity = 2710e9;
// A hundredth of the points change cell in a step.
constexpr Point kVelocity = {0.006 * kCell / kStep, 0.003 * kCell / kStep, 0.001 * kCell / kStep};
constexpr double kGrowth = 1e-5;  // of the strain of damaging points in a step

TensorDamage cement() {
  DamageParameters p;
  p.B0 = 9.6e6;
  return TensorDamage(VtiElasticity(VtiConstants{50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9}), p);
}

// One point in each eighth of a cell, anywhere or in its middle.
enum class Places { anywhere, lattice };
std::vector<Point> cube_of_points(int cells, Places places) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto within = [&] { return places == Places::lattice ? 0.5 : uniform(random); };
  std::vector<Point> X;
  const int n = 2 * cells;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        const double x = i + within(), y = j + within(), z = k + within();
        X.push_back({0.5 * kCell * x, 0.5 * kCell * y, 0.5 * kCell * z});
      }
  return X;
}

struct Cube {
  FreeBody s;
  int points;
  bool damaging;

  Cube(const Method& m, int cells, bool damaging, Places places = Places::anywhere)
      : s(m, kCell, cube_of_points(cells, places), kCell * kCell * kCell / 8, std::make_shared<TensorDamage>(cement()), kDensity),
        points(8 * cells * cells * cells),
        damaging(damaging) {
    s.start(kStep, [&](const Point&) { return kVelocity; });
    if (damaging) strain_tenth(0.1 * cells * kCell);
  }

  // Points with X < front get a random strain tensor, scaled to the onset of damage, then 20 % more.
  void strain_tenth(double front) {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    s.for_points([&](int b, int l) {
      PointBlock& p = s.points().blocks[b];
      if (p.X[0][l] >= front) return;
      vd* e = &p.strain.xx;
      for (int c = 0; c < 6; ++c) e[c][l] = normal(random);
      const LawDrive drive = cement().drive(p.strain, Sym3<vd>{});
      const double scale = std::sqrt(cement().threshold() / drive.Yeq[l]);
      for (int c = 0; c < 6; ++c) e[c][l] *= 1.001 * scale;
      s.points().meta[b].damaged = true;
    });
    for (int n = 0; n < 40; ++n) step(0.005);
  }

  void step(double growth = kGrowth) {
    if (damaging)
      for (std::size_t b = 0; b < s.points().blocks.size(); ++b)
        if (s.points().meta[b].damaged) s.points().blocks[b].strain = splat(1.0 + growth) * s.points().blocks[b].strain;
    s.step();
  }

  // Share of the points whose damage grows in one more step.
  double growing() {
    std::vector<double> before(points + 1), after(points + 1);
    const auto note = [&](std::vector<double>& trace_of) {
      s.for_points([&](int b, int l) { trace_of[s.points().tags[b][l]] = trace(state_of<TensorDamage>(s.points(), b))[l]; });
    };
    note(before);
    step();
    note(after);
    int n = 0;
    for (int i = 1; i <= points; ++i) n += after[i] > before[i];
    return static_cast<double>(n) / points;
  }
};

// The last cube is kept: Google Benchmark calls several times to find out how long to run. It has a communicator, so it
// goes before MPI ends.
std::unique_ptr<Cube> last;

Cube& cube(const Method& m, int cells, bool damaging, Places places) {
  static std::string what;
  const std::string wanted = m.name() + (damaging ? "d" : "e") + (places == Places::lattice ? "l" : "a") + std::to_string(cells);
  if (what != wanted) {
    last.reset();
    last = std::make_unique<Cube>(m, cells, damaging, places);
    what = wanted;
  }
  return *last;
}

benchmark::Counter rate(double each, const benchmark::State& state) {
  return benchmark::Counter(each * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

// Flops of a point of the default step, a multiply-add counting two, read off the kernels. Everywhere: 9 for the step of the gradient, strain and
// frame 319 + 9, stress 17, its rough bound 26, Piola stress 193, nodes 2. Anywhere in a cell: weights 54, gather 459, scatter 351 + 71 for the sums
// over lanes. In a lattice (columns.h): weights 36, gather 9 * 9 + 3 * 26 + 2 * 6 + 20 + 24, scatter 4 + 2 * 2 * 12 + 3 * 2 + 6 * 12 + 9 * 10; lanes that
// are not used count as well.
constexpr double kFlopsEverywhere = 9 + 328 + 17 + 26 + 193 + 2;
constexpr double flops(Places places) { return kFlopsEverywhere + (places == Places::lattice ? 36 + 215 + 220 : 54 + 459 + 422); }

// Bytes between memory and core: all of the block read, F, frame and strain written, the
// block's meta data, and 280 bytes a node in the drift, the pass and the acceleration.
double bytes_moved(const Cube& c) { return 8.0 * (23 + 19) + sizeof(BlockMeta) / 8.0 + 280.0 * c.s.grid().size() / c.points; }

void full_step(benchmark::State& state, const Method& m, int cells, bool damaging, Places places = Places::anywhere) {
  Cube& c = cube(m, cells, damaging, places);
  long crossings = 0;
  for (auto _ : state) {
    c.step();
    crossings += c.s.crossings();
  }
  const double steps = static_cast<double>(state.iterations());
  state.counters["points/s"] = rate(c.points, state);
  state.counters["points"] = c.points;
  state.counters["bytes/point"] = static_cast<double>(c.s.memory_usage()) / c.points;
  int used = 0;
  for (const BlockMeta& block : c.s.points().meta) used += block.occupied != 0;
  state.counters["fill"] = c.points / static_cast<double>(kLanes * used);
  state.counters["crossing"] = static_cast<double>(crossings) / steps / c.points;
  if (damaging) state.counters["growing"] = c.growing();
  if (!damaging && m.name() == "total/quadratic/none") {
    state.counters["flop/s"] = rate(flops(places) * c.points, state);
    state.counters["bytes/s"] = rate(bytes_moved(c) * c.points, state);
  }
}

void scalar_step(benchmark::State& state) {
  const TensorDamage law = cement();
  Cube c(Method(), 24, false);
  std::vector<ScalarPoint> p = scalar_points(c.s);
  std::vector<double> velocity(c.s.grid().velocity), force(velocity.size());
  for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] = std::sin(0.1 * static_cast<double>(i));
  c.s.grid().velocity = velocity;
  // That it is the same method.
  c.s.grid().clear_force();
  AdvanceResult result;
  advance_points(c.s.points(), c.s.grid(), c.s.law(), kStep, result);
  scalar_advance(p, velocity.data(), force.data(), kCell, law, kStep);
  double largest = 0, worst = 0;
  for (std::size_t i = 0; i < force.size(); ++i) {
    largest = std::max(largest, std::fabs(force[i]));
    worst = std::max(worst, std::fabs(force[i] - c.s.grid().force[i]));
  }
  if (!(worst < 1e-11 * largest)) state.SkipWithError("the scalar kernel gives another force");
  long over = 0;
  for (auto _ : state) {
    c.s.grid().velocity = velocity;
    c.s.grid().drift(0.0, kStep);
    std::fill(force.begin(), force.end(), 0.0);
    over += scalar_advance(p, velocity.data(), force.data(), kCell, law, kStep);
    c.s.grid().update_acceleration();
    for (double& v : velocity) v = -v;
  }
  benchmark::DoNotOptimize(over);
  state.counters["points/s"] = rate(c.points, state);
}

void triad_rate(benchmark::State& state) {
  const std::size_t n = std::size_t(1) << 25;  // 256 MB each
  std::vector<double> a(n, 0.0), b(n, 1.0), c(n, 2.0);
  for (auto _ : state) {
    triad(a.data(), b.data(), c.data(), 3.0, n);
    benchmark::ClobberMemory();
  }
  state.counters["bytes/s"] = rate(24.0 * static_cast<double>(n), state);
}

void multiply_add_rate(benchmark::State& state) {
  const long n = 1 << 20;
  for (auto _ : state) benchmark::DoNotOptimize(multiply_add(0.5, n));
  state.counters["flop/s"] = rate(2.0 * kWidest * kChains * static_cast<double>(n), state);
}

std::vector<std::string> register_all() {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name, auto f) {
    names.push_back(name);
    benchmark::RegisterBenchmark(name.c_str(), f)->Unit(benchmark::kMillisecond);
  };
  add("machine/triad", triad_rate);
  add("machine/multiply_add", multiply_add_rate);
  add("scalar/total/quadratic/none/elastic", scalar_step);
  for (const Method& m : all_methods())
    for (bool damaging : {false, true})
      add("step/" + m.name() + (damaging ? "/damaging" : "/elastic"), [=](benchmark::State& s) { full_step(s, m, 24, damaging); });
  for (bool damaging : {false, true})
    add(damaging ? "lattice/damaging" : "lattice/elastic",
        [=](benchmark::State& s) { full_step(s, Method(), 24, damaging, Places::lattice); });
  for (int cells : {11, 23, 50, 79})
    add("size/" + std::to_string(8 * cells * cells * cells), [=](benchmark::State& s) { full_step(s, Method(), cells, false); });
  return names;
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  const std::vector<std::string> names = register_all();
  std::string filter;
  std::vector<char*> rest;
  for (int i = 0; i < argc; ++i)
    if (i == 0 || std::strncmp(argv[i], "-", 1) == 0) rest.push_back(argv[i]);
    else filter += (filter.empty() ? "" : "|") + std::string(argv[i]);
  filter = "--benchmark_filter=" + filter;
  if (filter.back() != '=') rest.push_back(&filter[0]);
  int count = static_cast<int>(rest.size());
  benchmark::Initialize(&count, rest.data());
  const bool wrong = benchmark::ReportUnrecognizedArguments(count, rest.data());
  const bool none = !wrong && benchmark::RunSpecifiedBenchmarks() == 0;
  if (none) {
    std::fprintf(stderr, "bench_step: no benchmark matches; names are\n");
    for (const std::string& n : names) std::fprintf(stderr, "  %s\n", n.c_str());
  }
  last.reset();
  MPI_Finalize();
  return wrong || none;
}
