// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Problems with exact solutions, in units of their own: where the points are, motion, body force
// per mass, material, planes of symmetry.
//
// bar     Axial vibration, nu = 0, fixed at x = 0 and free at x = L (a plane of symmetry holds it).
// cube    Manufactured: u_i = A sin(pi X_i) sin(c pi t + p_i) in the unit cube between planes of
//         symmetry, transversely isotropic. With the Kirchhoff stress tau_ii = sum_k C_ik ln F_kk and
//         P_ii = tau_ii/F_ii the body force is b_i = u_i,tt - F_ii,i/F_ii^2 (C_ii - tau_ii)/rho.
// vortex  Generalized vortex (Kamojjala, Brannon, Sadeghirad & Guilkey, Eng. Comput. 31 (2015)
//         213): a ring turns by alpha(R, t) and back, isochoric, so Kirchhoff and Cauchy stress are
//         the same; stress by the Jaumann rate in a shear g = R alpha'. Amplitude 1 shears by up to 6.
// swirl   The vortex with a tenth of its amplitude.
#ifndef MPDEM_PROBLEMS_H
#define MPDEM_PROBLEMS_H

#include <cmath>
#include <string>

#include "material/vti_elasticity.h"
#include "mirror_planes.h"

namespace mpdem {

struct Problem {
  virtual ~Problem() = default;
  std::string name;
  double density = 1000.0, end = 1.0, speed = 1.0;  // of the fastest wave with the motion
  VtiConstants constants;
  int cells[3] = {1, 1, 1};  // box, from node -low on
  int low[3] = {0, 0, 0};
  MirrorPlanes planes;

  virtual bool inside(const double*) const { return true; }
  virtual void motion(const double* X, double t, double* u, double* v) const = 0;
  // Per mass, at the point that was at X.
  virtual void body_force(const double* X, double t, double* b) const = 0;
  virtual bool has_body_force() const { return true; }
};

struct Bar : Problem {
  double L = 1.0, v0, omega;
  explicit Bar(int n) {
    name = "bar";
    constants = VtiConstants::isotropic(1000.0, 0.0);
    speed = 1.0;
    v0 = 1e-7 * speed;  // the exact solution is for small strain
    omega = 0.5 * M_PI / L * speed;
    end = 0.5 * M_PI / omega;
    cells[0] = n;
    planes.pair[0] = {true, false, 0, 0};
    planes.pair[1] = planes.pair[2] = {true, true, 0, 1};
  }
  void motion(const double* X, double t, double* u, double* v) const override {
    const double shape = std::sin(0.5 * M_PI * X[0] / L);
    u[0] = v0 / omega * std::sin(omega * t) * shape;
    v[0] = v0 * std::cos(omega * t) * shape;
    u[1] = u[2] = v[1] = v[2] = 0.0;
  }
  void body_force(const double*, double, double* b) const override { b[0] = b[1] = b[2] = 0.0; }
  bool has_body_force() const override { return false; }
};

struct Cube : Problem {
  double A = 0.02, phase[3] = {0.0, M_PI, 0.0}, c;  // at rest in place at t = 0
  VtiElasticity law;
  explicit Cube(int n) : law(VtiConstants{1500.0, 1000.0, 0.25, 0.2, 450.0}) {
    name = "cube";
    constants = VtiConstants{1500.0, 1000.0, 0.25, 0.2, 450.0};
    c = std::sqrt(law.C11 / density);
    speed = c;
    end = 0.5 / c;  // a quarter of a period
    for (int d = 0; d < 3; ++d) {
      cells[d] = n;
      planes.pair[d] = {true, true, 0, n};
    }
  }
  void motion(const double* X, double t, double* u, double* v) const override {
    for (int d = 0; d < 3; ++d) {
      u[d] = A * std::sin(M_PI * X[d]) * std::sin(c * M_PI * t + phase[d]);
      v[d] = A * std::sin(M_PI * X[d]) * std::cos(c * M_PI * t + phase[d]) * c * M_PI;
    }
  }
  void body_force(const double* X, double t, double* b) const override {
    double F[3], e[3], slope[3];
    for (int d = 0; d < 3; ++d) {
      const double s = A * M_PI * std::sin(c * M_PI * t + phase[d]);
      F[d] = 1.0 + s * std::cos(M_PI * X[d]);
      slope[d] = -s * M_PI * std::sin(M_PI * X[d]);
      e[d] = std::log(F[d]);
    }
    const Sym3<double> tau = law.stress(Sym3<double>{e[0], e[1], e[2], 0, 0, 0});
    const double t_ii[3] = {tau.xx, tau.yy, tau.zz}, C_ii[3] = {law.C11, law.C11, law.C33};
    for (int d = 0; d < 3; ++d)
      b[d] = -c * c * M_PI * M_PI * A * std::sin(M_PI * X[d]) * std::sin(c * M_PI * t + phase[d]) -
             slope[d] / (F[d] * F[d]) * (C_ii[d] - t_ii[d]) / density;
  }
};

struct Vortex : Problem {
  double G, mu;
  Vortex(const char* title, int n, double amplitude) : G(amplitude) {  // n cells a unit of length
    name = title;
    end = 0.5;  // furthest from its start, where it is back at t = 1
    const double E = 1000.0, nu = 0.3;
    constants = VtiConstants::isotropic(E, nu);
    mu = 0.5 * E / (1.0 + nu);
    speed = std::sqrt(E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)) / density) + M_PI * G;
    cells[0] = cells[1] = 2 * (low[0] = low[1] = n + (n + 2) / 3);
    planes.pair[2] = {true, true, 0, 1};
  }
  static double hump(double R) { return 1.0 - 32.0 * std::pow(R - 1.0, 2) + 256.0 * std::pow(R - 1.0, 4); }
  static double hump1(double R) { return -64.0 * (R - 1.0) + 1024.0 * std::pow(R - 1.0, 3); }
  static double hump2(double R) { return -64.0 + 3072.0 * std::pow(R - 1.0, 2); }
  bool inside(const double* X) const override {
    const double R = std::hypot(X[0], X[1]);
    return R > 0.75 && R < 1.25;
  }
  void motion(const double* X, double t, double* u, double* v) const override {
    const double R = std::hypot(X[0], X[1]), h = inside(X) ? hump(R) : 0.0;
    const double a = G * std::sin(M_PI * t) * h, rate = G * M_PI * std::cos(M_PI * t) * h;
    const double x = std::cos(a) * X[0] - std::sin(a) * X[1], y = std::sin(a) * X[0] + std::cos(a) * X[1];
    u[0] = x - X[0];
    u[1] = y - X[1];
    v[0] = -rate * y;
    v[1] = rate * x;
    u[2] = v[2] = 0.0;
  }
  void body_force(const double* X, double t, double* b) const override {
    const double R = std::hypot(X[0], X[1]), s = G * std::sin(M_PI * t);
    const double a = s * hump(R), a_t = G * M_PI * std::cos(M_PI * t) * hump(R), a_tt = -M_PI * M_PI * a;
    const double g = R * s * hump1(R), g1 = s * (hump1(R) + R * hump2(R));
    const double s_tt = mu * (1.0 - std::cos(g)), s_rt = mu * std::sin(g);
    const double s_rr1 = -mu * std::sin(g) * g1, s_rt1 = mu * std::cos(g) * g1;
    const double b_r = -R * a_t * a_t - (s_rr1 - 2.0 * s_tt / R) / density;
    const double b_t = R * a_tt - (s_rt1 + 2.0 * s_rt / R) / density;
    const double angle = std::atan2(X[1], X[0]) + a;
    b[0] = b_r * std::cos(angle) - b_t * std::sin(angle);
    b[1] = b_r * std::sin(angle) + b_t * std::cos(angle);
    b[2] = 0.0;
  }
};

}  // namespace mpdem

#endif
