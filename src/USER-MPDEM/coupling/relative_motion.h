// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Relative motion of two grains in the axes half-way between them. T is `double`, or the eight-lane `vd` with one bond
// a lane. See condensed_bond.h for the symbols.
#ifndef MPDEM_COUPLING_RELATIVE_MOTION_H
#define MPDEM_COUPLING_RELATIVE_MOTION_H

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "../numerics/simd.h"
#include "../numerics/tensor3.h"

namespace mpdem {

// Functions of the square of an angle. They use a series for squares below kSmall, and exact formulas above.
namespace turns {

constexpr double kSmall = 0.04;

template <class T, std::size_t N>
inline T polynomial(const double (&c)[N], T x) {
  T sum = T{} + c[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = sum * x + c[i];
  return sum;
}
template <std::size_t N, class Exact>
inline double value(const double (&c)[N], double x, Exact exact) {
  return x < kSmall ? polynomial(c, x) : exact(std::sqrt(x));
}
template <std::size_t N, class Exact>
inline vd value(const double (&c)[N], vd x, Exact exact) {
  if (!any(x >= kSmall)) return polynomial(c, x);
  return map_lanes(x, [&](double a) { return value(c, a, exact); });
}

// sine(): sin a/a. cosine(): (1 - cos a)/a^2. rest_of_sine(): (a - sin a)/a^3. cotangent(): (1 - a/2 cot(a/2))/a^2.
template <class T>
inline T sine(T a2) {
  constexpr double c[] = {1.0, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800};
  return value(c, a2, [](double a) { return std::sin(a) / a; });
}
template <class T>
inline T cosine(T a2) {
  constexpr double c[] = {1.0 / 2, -1.0 / 24, 1.0 / 720, -1.0 / 40320, 1.0 / 3628800, -1.0 / 479001600};
  return value(c, a2, [](double a) { return (1.0 - std::cos(a)) / (a * a); });
}
template <class T>
inline T rest_of_sine(T a2) {
  constexpr double c[] = {1.0 / 6, -1.0 / 120, 1.0 / 5040, -1.0 / 362880, 1.0 / 39916800};
  return value(c, a2, [](double a) { return (a - std::sin(a)) / (a * a * a); });
}
template <class T>
inline T cotangent(T a2) {
  constexpr double c[] = {1.0 / 12, 1.0 / 720, 1.0 / 30240, 1.0 / 1209600, 1.0 / 47900160, 691.0 / 1307674368000.0};
  return value(c, a2, [](double a) { return (1.0 - 0.5 * a / std::tan(0.5 * a)) / (a * a); });
}
// Returns a/sin a for an angle a below pi. The argument is the square of the sine, since the cosine of a small angle
// has lost its digits.
inline double over_sine(double sine2, double cosine) {
  constexpr double c[] = {1.0,           1.0 / 6,       3.0 / 40,        5.0 / 112,         35.0 / 1152,      63.0 / 2816,
                          231.0 / 13312, 143.0 / 10240, 6435.0 / 557056, 12155.0 / 1245184, 46189.0 / 5505024};
  if (sine2 < kSmall && cosine > 0.0) return polynomial(c, sine2);
  const double s = std::sqrt(sine2);
  return s > 1e-12 ? std::atan2(s, cosine) / s : 1.0;
}
inline vd over_sine(vd sine2, vd cosine) {
  constexpr double c[] = {1.0,           1.0 / 6,       3.0 / 40,        5.0 / 112,         35.0 / 1152,      63.0 / 2816,
                          231.0 / 13312, 143.0 / 10240, 6435.0 / 557056, 12155.0 / 1245184, 46189.0 / 5505024};
  if (!any((sine2 >= kSmall) | (cosine <= 0.0))) return polynomial(c, sine2);
  vd r;
  for (int l = 0; l < kLanes; ++l) r[l] = over_sine(sine2[l], cosine[l]);
  return r;
}

}  // namespace turns

template <class T>
struct Three {
  T a[3];
};
template <class T>
inline Three<T> operator+(const Three<T>& x, const Three<T>& y) {
  return {{x.a[0] + y.a[0], x.a[1] + y.a[1], x.a[2] + y.a[2]}};
}
template <class T>
inline Three<T> operator-(const Three<T>& x, const Three<T>& y) {
  return {{x.a[0] - y.a[0], x.a[1] - y.a[1], x.a[2] - y.a[2]}};
}
template <class T>
inline Three<T> operator*(const T& s, const Three<T>& x) {
  return {{s * x.a[0], s * x.a[1], s * x.a[2]}};
}
template <class T>
inline T dot(const Three<T>& x, const Three<T>& y) {
  return x.a[0] * y.a[0] + x.a[1] * y.a[1] + x.a[2] * y.a[2];
}
template <class T>
inline Three<T> cross(const Three<T>& x, const Three<T>& y) {
  return {{x.a[1] * y.a[2] - x.a[2] * y.a[1], x.a[2] * y.a[0] - x.a[0] * y.a[2], x.a[0] * y.a[1] - x.a[1] * y.a[0]}};
}
template <class T>
inline Three<T> turned(const Mat3<T>& q, const Three<T>& x) {
  Three<T> y;
  for (int i = 0; i < 3; ++i) y.a[i] = q.a[i][0] * x.a[0] + q.a[i][1] * x.a[1] + q.a[i][2] * x.a[2];
  return y;
}
template <class T>
inline Three<T> turned_back(const Mat3<T>& q, const Three<T>& x) {
  Three<T> y;
  for (int i = 0; i < 3; ++i) y.a[i] = q.a[0][i] * x.a[0] + q.a[1][i] * x.a[1] + q.a[2][i] * x.a[2];
  return y;
}

template <class T>
struct RelativeMotion {
  Mat3<T> Q0, Q;                // rotation of grain 0, and axes half-way to grain 1
  Three<T> r[2], delta, theta;  // r: from the centres to the p_s
  Three<T> apart;               // from centre to centre

  RelativeMotion() = default;
  // turn: rotations of both grains since the creation. arm: from their centres to the middle of the contact at the
  // creation.
  RelativeMotion(const Mat3<T>* turn, const Three<T>* arm, const Three<T>& from_centre_to_centre)
      : Q0(turn[0]), apart(from_centre_to_centre) {
    for (int s = 0; s < 2; ++s) r[s] = turned(turn[s], arm[s]);
    const Mat3<T> E = product(transpose(turn[0]), turn[1]);
    const T half = T{} + 0.5;
    // E rotates by the angle |theta| about the axis theta. The vector sine has this axis, and the sine as its length.
    const Three<T> sine{{half * (E.a[2][1] - E.a[1][2]), half * (E.a[0][2] - E.a[2][0]), half * (E.a[1][0] - E.a[0][1])}};
    theta = turns::over_sine(dot(sine, sine), half * (E.a[0][0] + E.a[1][1] + E.a[2][2] - 1.0)) * sine;
    // Q = Q0 exp(theta/2)
    const Three<T> h = half * theta;
    const T h2 = dot(h, h), s = turns::sine(h2), c = turns::cosine(h2);
    Mat3<T> exponential;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) exponential.a[i][j] = c * h.a[i] * h.a[j];
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      exponential.a[i][i] += 1.0 - c * h2;
      exponential.a[j][k] -= s * h.a[i];
      exponential.a[k][j] += s * h.a[i];
    }
    Q = product(turn[0], exponential);
    delta = turned_back(Q, apart + r[1] - r[0]);
  }

  // Finds force and moment on grain 1, about its centre, from the derivatives of the energy by delta and theta. Grain 0
  // has the opposite force, and the moment -M - apart x F.
  void load(const Three<T>& of_delta, const Three<T>& of_theta, Three<T>& F, Three<T>& M) const {
    const T half = T{} + 0.5;
    const Three<T> h = half * theta, turn = cross(of_delta, delta), once = cross(h, turn);
    const T h2 = dot(h, h);
    // y: the derivative by theta with the p_s at rest. delta is in axes that rotate by half of theta, so of_delta adds a
    // part by the Jacobian of exp(theta/2).
    const Three<T> y = of_theta + half * (turn + turns::cosine(h2) * once + turns::rest_of_sine(h2) * cross(h, once));
    const Three<T> first = cross(theta, y);  // z: moment that works on small rotations of grain 1 (inverse Jacobian of exp)
    const Three<T> z = y + half * first + turns::cotangent(dot(theta, theta)) * cross(theta, first);
    F = turned(Q, Three<T>{} - of_delta);
    M = cross(r[1], F) - turned(Q0, z);
  }
};

}  // namespace mpdem

#endif
