// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "problems.h"

#include <cmath>

namespace mpdem::bench {

namespace {

const double kPi = std::acos(-1.0);

// First mode of a free bar -1 < x < 1 without lateral contraction, antisymmetric, which is that
// of a bar of length 1 held at x = 0: u = v0/w sin(w t) sin(pi x/2), w = pi/2 c. So slow that it
// is linear. After a quarter of the period the error of the amplitude shows and that of the phase does not; after whole
// periods it is the other way round.
struct Bar : Problem {
  static constexpr double v0 = 1e-7;
  static constexpr double kPeriod = 4.0;
  const double w = 2.0 * kPi / kPeriod;
  const bool in_space;  // refined across, too; otherwise the section always has as many cells
  const int section;
  Bar(bool in_space, const BarOptions& o) : in_space(in_space), section(o.section) {
    name = in_space ? "thick-bar" : "bar";
    if (in_space) cells = {8, 16, 24};
    else cells = {4, 6, 12, 24, 48};
    quick = in_space ? 2 : 4;
    end = o.periods * kPeriod;
    looks = {0.25 * kPeriod, end};
    if (!in_space) energy_until = end + 10.0 * kPeriod;
    scale = v0 / w / std::sqrt(2.0);
  }
  NoDamage law() const override { return NoDamage(VtiElasticity(VtiConstants::isotropic(1.0, 0.0))); }
  bool inside(const Point&, double) const override { return true; }
  void box(double h, Point& low, Point& high) const override {
    const double width = in_space ? 0.375 : section * h;
    low = {-1, 0, 0};
    high = {1, width, width};
  }
  bool loaded() const override { return false; }
  Point displacement(const Point& X, double t) const override { return {v0 / w * std::sin(w * t) * std::sin(0.5 * kPi * X[0]), 0, 0}; }
  Point velocity(const Point& X, double t) const override { return {v0 * std::cos(w * t) * std::sin(0.5 * kPi * X[0]), 0, 0}; }
};

// Axis-aligned manufactured solution (Wallstedt & Guilkey, J. Comput. Phys. 227 (2008) 9628) in
// three dimensions, transversely isotropic: u_i = A_i sin(pi X_i) sin(c_i pi t) in the unit cube.
// For the law of the package, tau_i = sum_k C_ik ln F_kk per reference volume, P_i = tau_i/F_ii:
//   rho b_i = rho u_i,tt - (C_ii - tau_i) F_ii,i / F_ii^2
// The faces carry the traction P_i.
struct Cube : Problem {
  const Point A = {0.05, 0.04, 0.03}, c = {1.0, 1.2, 0.8};
  double C[3][3];
  Cube() {
    name = "cube";
    cells = {6, 8, 12, 16, 24};
    quick = 4;
    end = 0.5;
    looks = {end};
    const VtiElasticity e = law().elasticity();
    const double c3[3][3] = {{e.C11, e.C12, e.C13}, {e.C12, e.C11, e.C13}, {e.C13, e.C13, e.C33}};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) C[i][j] = c3[i][j];
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += std::pow(A[i] * std::sin(c[i] * kPi * end), 2) / 2;
    scale = std::sqrt(sum);
  }
  NoDamage law() const override { return NoDamage(VtiElasticity(VtiConstants{1.0, 0.6, 0.25, 0.2, 0.3})); }
  bool inside(const Point&, double) const override { return true; }
  void box(double, Point& low, Point& high) const override {
    low = {0, 0, 0};
    high = {1, 1, 1};
  }
  Point displacement(const Point& X, double t) const override {
    Point u;
    for (int i = 0; i < 3; ++i) u[i] = A[i] * std::sin(kPi * X[i]) * std::sin(c[i] * kPi * t);
    return u;
  }
  Point velocity(const Point& X, double t) const override {
    Point v;
    for (int i = 0; i < 3; ++i) v[i] = A[i] * c[i] * kPi * std::sin(kPi * X[i]) * std::cos(c[i] * kPi * t);
    return v;
  }
  double stretch(const Point& X, int i, double t) const { return 1.0 + A[i] * kPi * std::cos(kPi * X[i]) * std::sin(c[i] * kPi * t); }
  double kirchhoff(const Point& X, int i, double t) const {
    double tau = 0.0;
    for (int k = 0; k < 3; ++k) tau += C[i][k] * std::log(stretch(X, k, t));
    return tau;
  }
  Point body_force(const Point& X, double t) const override {
    Point b;
    for (int i = 0; i < 3; ++i) {
      const double wave = A[i] * std::sin(kPi * X[i]) * std::sin(c[i] * kPi * t), F = stretch(X, i, t);
      b[i] = -std::pow(c[i] * kPi, 2) * wave + (C[i][i] - kirchhoff(X, i, t)) * kPi * kPi * wave / (F * F) / density;
    }
    return b;
  }
  std::vector<Facet> facets(double h) const override {
    std::vector<Facet> all;
    const int n = static_cast<int>(std::lround(2.0 / h));
    for (int d = 0; d < 3; ++d)
      for (int side = 0; side < 2; ++side)
        for (int i = 0; i < n; ++i)
          for (int j = 0; j < n; ++j) {
            Point X;
            X[d] = side;
            X[(d + 1) % 3] = 0.5 * h * (i + 0.5);
            X[(d + 2) % 3] = 0.5 * h * (j + 0.5);
            all.push_back({X, 0.25 * h * h, d, 2 * side - 1});
          }
    return all;
  }
  double traction(const Facet& f, double t) const override { return kirchhoff(f.X, f.normal, t) / stretch(f.X, f.normal, t); }
};

// Generalized vortex (Kamojjala, Brannon, Sadeghirad & Guilkey, Eng. Comput. 31 (2015) 193): circles
// of radius R rotate by alpha = G sin(pi t/T) H(R), H = 1 - 32 (R-1)^2 + 256 (R-1)^4 for
// 0.75 < R < 1.25 and 0 elsewhere; E = 1000, nu = 0.3, rho = 1000, T = 1 as there. With Jaumann's
// rate, g = R alpha,R gives tau_rt = mu sin g and -tau_rr = tau_tt = mu (1 - cos g), no change of
// volume, and
//   b_r = -R alpha_t^2 - (tau_rr,R + (tau_rr - tau_tt)/R)/rho
//   b_t =  R alpha_tt - (tau_rt,R + 2 tau_rt/R)/rho.
// This law loses strong ellipticity, and the problem its well-posedness, where the principal
// stresses differ by 2 mu, 4 mu sin(g/2) = 2 mu or g = pi/3. G = 0.14 keeps |g| < 0.99; with
// G = 1, as for hyperelastic materials, |g| comes to 7.
// With a neo-Hookean body, tau_rt = mu g, tau_tt = mu g^2 and tau_rr = 0, G = 1 as there is well-posed: the
// steps are the package's, the stress is the benchmark's.
// Out of the ring the material is at rest.
struct Vortex : Problem {
  const double G;
  const NeoHookean constants{1000.0 * 0.3 / (1.3 * 0.4), 1000.0 / 2.6};
  const bool hyperelastic;
  explicit Vortex(bool neo) : G(neo ? 1.0 : 0.14), hyperelastic(neo) {
    name = neo ? "published-vortex" : "vortex";
    cells = {8, 12, 16, 24};
    if (!neo) cells.push_back(32);
    quick = neo ? 2 : 3;
    density = 1000.0;
    looks = {0.5, 1.0};
    if (neo) of_stable = 0.1;  // mu (1 + g^2) is the stiffness along the circles in the end
    if (neo) in_plane = 4;     // points drift apart by a factor of seven along the circles
    scale = 1.0;               // set below
    double sum = 0, all = 0;
    for (int i = 0; i < 1000; ++i) {
      const double R = 0.75 + 0.5 * (i + 0.5) / 1000;
      sum += R * std::pow(2 * R * std::sin(0.5 * G * profile(R)), 2);
      all += R;
    }
    scale = std::sqrt(sum / all);
  }
  NoDamage law() const override { return NoDamage(VtiElasticity(VtiConstants::isotropic(hyperelastic ? 1e-6 : 1000.0, 0.3))); }
  const NeoHookean* neo_hookean() const override { return hyperelastic ? &constants : nullptr; }
  static bool turns(double R) { return std::fabs(R - 1.0) < 0.25; }
  // Nodes a sixteenth and more off the ring are held. Left free, the ring would rotate as a rigid body:
  // the jumps of b at both its ends, sampled by the points, leave a torque.
  bool held(const Point& x) const override { return std::fabs(std::hypot(x[0], x[1]) - 1.0) > 0.25 + 1.0 / 16; }
  static double profile(double R) {
    const double x = (R - 1) * (R - 1);
    return turns(R) ? 1 - 32 * x + 256 * x * x : 0.0;
  }
  bool inside(const Point& X, double) const override {
    const double R = std::hypot(X[0], X[1]);
    return R > 0.5 && R < 1.5;
  }
  void box(double h, Point& low, Point& high) const override {
    low = {-1.5, -1.5, 0};
    high = {1.5, 1.5, h};
  }
  Point displacement(const Point& X, double t) const override {
    const double a = G * std::sin(kPi * t) * profile(std::hypot(X[0], X[1]));
    return {std::cos(a) * X[0] - std::sin(a) * X[1] - X[0], std::sin(a) * X[0] + std::cos(a) * X[1] - X[1], 0};
  }
  Point velocity(const Point& X, double t) const override {
    const double w = G * kPi * std::cos(kPi * t) * profile(std::hypot(X[0], X[1]));
    return {-w * X[1], w * X[0], 0};
  }
  Point body_force(const Point& X, double t) const override {
    const double R = std::hypot(X[0], X[1]), r = R - 1, mu = 1000.0 / 2.6;
    if (!turns(R)) return {0, 0, 0};
    const double s = G * std::sin(kPi * t), H = profile(R), H1 = -64 * r + 1024 * r * r * r, H2 = -64 + 3072 * r * r;
    const double a = s * H, at = G * kPi * std::cos(kPi * t) * H, att = -kPi * kPi * a;
    const double g = R * s * H1, g1 = s * (H1 + R * H2);
    double rr = -mu * (1 - std::cos(g)), rr1 = -mu * std::sin(g) * g1, tt = -rr, rt = mu * std::sin(g), rt1 = mu * std::cos(g) * g1;
    if (hyperelastic) rr = rr1 = 0.0, tt = mu * g * g, rt = mu * g, rt1 = mu * g1;
    const double br = -R * at * at - (rr1 + (rr - tt) / R) / density, bt = R * att - (rt1 + 2 * rt / R) / density;
    const double x = (std::cos(a) * X[0] - std::sin(a) * X[1]) / R, y = (std::sin(a) * X[0] + std::cos(a) * X[1]) / R;
    return {br * x - bt * y, br * y + bt * x, 0};
  }
};

}  // namespace

std::vector<std::unique_ptr<Problem>> all_problems(const BarOptions& bar) {
  std::vector<std::unique_ptr<Problem>> all;
  all.push_back(std::make_unique<Bar>(false, bar));
  all.push_back(std::make_unique<Bar>(true, bar));
  all.push_back(std::make_unique<Cube>());
  all.push_back(std::make_unique<Vortex>(false));
  all.push_back(std::make_unique<Vortex>(true));
  return all;
}

}  // namespace mpdem::bench
