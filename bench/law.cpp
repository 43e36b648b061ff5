// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Work and precision of the law of damage, one point at a time, see doc/performance.md.
//   law [--quick] [--list] [name ...]
// straight: random strains, each grown from 0.9 to 3 times the onset of damage; turning: while it grows, each
// rotates into another one. Steps are in onset strains. CSV on standard output: evaluations of the
// law (and of its derivative) and CPU time of a step of eight points; errors of D, of the stress over
// f_t and of the energy given off over B0, at six places on each path: median and the tenth largest
// in a hundred. The reference is what the two finest steps extrapolate to by the order of the law.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include "material/tensor_damage.h"

namespace {

using namespace mpdem;

constexpr double kFrom = 0.9, kTo = 3.0, kSharesKept[] = {1.1, 1.3, 1.5, 2.0, 2.5, 3.0};
constexpr double kFinest = 1e-4;
const std::vector<double> kSteps = {2.5e-4, 1e-3, 2.5e-3, 1e-2, 2.5e-2, 5e-2, 1e-1};

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Numbers {
  std::vector<double> D, stress;  // six a point and place
  std::vector<double> energy;
  long steps = 0, evaluations = 0;
  double seconds = 0.0;
};

// At the onset of damage, eight of them.
Sym3<vd> random_strain(const TensorDamage& law, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Sym3<vd> e;
  vd* c = &e.xx;
  for (int i = 0; i < 6; ++i)
    for (int l = 0; l < kLanes; ++l) c[i][l] = normal(random);
  return sqrt(law.parameters().B0 / law.drive(e, Sym3<vd>{}).Yeq) * e;
}

void look(const TensorDamage& law, const Sym3<vd>& strain, const Sym3<vd>& D, vmask alive, vd energy, Numbers& n) {
  const Sym3<vd> s = blend(alive, law.stress(strain, D), Sym3<vd>{});
  const vd *d = &D.xx, *t = &s.xx;
  for (int l = 0; l < kLanes; ++l) {
    for (int i = 0; i < 6; ++i) {
      n.D.push_back(d[i][l]);
      n.stress.push_back(t[i][l]);
    }
    n.energy.push_back(energy[l]);
  }
}

Numbers run(const TensorDamage& law, int paths, bool turning, double step) {
  Numbers n;
  const long steps = std::lround((kTo - kFrom) / step);
  for (int path = 0; path < paths; path += kLanes) {
    std::mt19937_64 random(100 + path);
    const Sym3<vd> first = random_strain(law, random), other = random_strain(law, random);
    // Rotations by less than a right angle.
    const Sym3<vd> second = select(contract(first, other) > 0.0, splat(1.0), splat(-1.0)) * other;
    Sym3<vd> D{}, strain = splat(kFrom) * first;
    vmask alive = splat_mask(true);
    vd energy{};
    int next_look = 0;
    const double start = cpu_seconds();
    for (long k = 1; k <= steps; ++k) {
      const double size = kFrom + (kTo - kFrom) * static_cast<double>(k) / static_cast<double>(steps);
      const double share = turning ? (size - kFrom) / (kTo - kFrom) : 0.0;
      const Sym3<vd> before = strain;
      strain = splat(size) * (splat(1.0 - share) * first + splat(share) * second);
      const TensorDamage::Update u = law.update(before, strain, D, alive);
      energy += u.dissipated + u.released;
      alive &= ~u.failed;
      n.evaluations += u.evaluations;
      ++n.steps;
      while (next_look < 6 && size > kSharesKept[next_look] - 1e-9) {
        look(law, strain, D, alive, energy, n);
        ++next_look;
      }
    }
    n.seconds += cpu_seconds() - start;
  }
  return n;
}

// Largest of `each` numbers, of each place on each path.
std::vector<double> errors(const std::vector<double>& a, const std::vector<double>& exact, std::size_t each, double scale) {
  std::vector<double> e(a.size() / each, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) e[i / each] = std::max(e[i / each], std::fabs(a[i] - exact[i]) / scale);
  std::sort(e.begin(), e.end());
  return e;
}

std::vector<double> extrapolated(const std::vector<double>& fine, const std::vector<double>& coarse) {
  std::vector<double> x(fine);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += (fine[i] - coarse[i]) / 3.0;
  return x;
}

void measure(const std::string& name, double exponent, bool quick) {
  DamageParameters p;
  p.B0 = 9.6e3;
  p.exponent = exponent;
  const VtiConstants calcite{50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9};
  const TensorDamage law(VtiElasticity(calcite), p);
  const bool turning = name.find("turning") != std::string::npos;
  const double finest = quick ? 20 * kFinest : kFinest, f_t = implied_strength(p, calcite.Ez).tensile_strength;
  const int paths = quick ? 8 : 64;
  const Numbers fine = run(law, paths, turning, finest), coarse = run(law, paths, turning, 2 * finest);
  const std::vector<double> D = extrapolated(fine.D, coarse.D), stress = extrapolated(fine.stress, coarse.stress),
                            energy = extrapolated(fine.energy, coarse.energy);
  for (double step : kSteps) {
    if (step < 2.5 * finest) continue;
    const Numbers n = run(law, paths, turning, step);
    const auto eD = errors(n.D, D, 6, 1.0), es = errors(n.stress, stress, 6, f_t), eW = errors(n.energy, energy, 1, p.B0);
    const auto at = [](const std::vector<double>& e, double share) {
      return e[static_cast<std::size_t>(share * static_cast<double>(e.size() - 1))];
    };
    std::printf("%s,%g,%.3g,%.4g,%.3g,%.3g,%.3g,%.3g,%.3g,%.3g\n", name.c_str(), step,
                static_cast<double>(n.evaluations) / static_cast<double>(n.steps), 1e9 * n.seconds / static_cast<double>(n.steps),
                at(eD, 0.5), at(eD, 0.9), at(es, 0.5), at(es, 0.9), at(eW, 0.5), at(eW, 0.9));
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::pair<const char*, double> all[] = {
      {"law/straight", 0.0}, {"law/turning", 0.0}, {"law/straight/crackband", 0.7}, {"law/turning/crackband", 0.7}};
  bool quick = false, list = false, found = false;
  std::string wanted;
  for (int i = 1; i < argc; ++i) {
    if (!std::strcmp(argv[i], "--quick")) quick = true;
    else if (!std::strcmp(argv[i], "--list")) list = true;
    else wanted += (wanted.empty() ? "" : "|") + std::string(argv[i]);
  }
  const std::regex point_template(wanted);
  if (!list) std::printf("law,step,evaluations,ns,D,D_90,stress,stress_90,energy,energy_90\n");
  for (const auto& [name, exponent] : all) {
    if (list) std::printf("%s\n", name);
    if (!std::regex_search(name, point_template)) continue;
    found = true;
    if (!list) measure(name, exponent, quick);
  }
  if (!found) std::fprintf(stderr, "law: no benchmark matches '%s'; see --list\n", wanted.c_str());
  return !found;
}
