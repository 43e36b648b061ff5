// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Spectral decomposition of eight symmetric 3x3 tensors at once by cyclic Jacobi
// rotations (Golub & Van Loan, Matrix Computations, sec. 8.5): every lane does the
// same work, the loop ends when all lanes have converged. Backward stable, exact for
// diagonal input, no branch on repeated eigenvalues.
#ifndef MPDEM_EIGEN3_H
#define MPDEM_EIGEN3_H

#include "../mpm/simd.h"
#include "tensor3.h"

namespace mpdem {

struct Spectral {
  vd value[3];    // not sorted
  Mat3<vd> axes;  // column i belongs to value[i]
};

// One rotation in the plane (p,q) with the third axis r.
inline void jacobi_rotation(vd& app, vd& aqq, vd& apq, vd& arp, vd& arq, vd* vp, vd* vq) {
  const vd diff = aqq - app;
  const vd twice = apq + apq;
  // t = tan of the smaller angle; written without a division by apq so that a zero
  // off-diagonal gives the identity.
  const vd root = sqrt(diff * diff + twice * twice);
  const vd denom = abs(diff) + root;
  const vd tiny = splat(1e-300);
  const vd t_abs = twice / max(denom, tiny);
  const vd t = diff < 0.0 ? -t_abs : t_abs;
  const vd c = 1.0 / sqrt(1.0 + t * t);
  const vd s = t * c;
  app -= t * apq;
  aqq += t * apq;
  apq = vd{};
  const vd rp = arp;
  arp = c * rp - s * arq;
  arq = s * rp + c * arq;
  for (int i = 0; i < 3; ++i) {
    const vd p = vp[i];
    vp[i] = c * p - s * vq[i];
    vq[i] = s * p + c * vq[i];
  }
}

inline Spectral eigen(const Sym3<vd>& m) {
  vd a = m.xx, b = m.yy, c = m.zz, bc = m.yz, ac = m.xz, ab = m.xy;
  vd v[3][3] = {};  // v[j] is column j
  for (int j = 0; j < 3; ++j) v[j][j] = splat(1.0);
  const vd scale = a * a + b * b + c * c + 2.0 * (bc * bc + ac * ac + ab * ab);
  const vd tolerance = 1e-32 * scale;
  for (int sweep = 0; sweep < 12; ++sweep) {
    if (!any(bc * bc + ac * ac + ab * ab > tolerance)) break;
    jacobi_rotation(a, b, ab, ac, bc, v[0], v[1]);
    jacobi_rotation(a, c, ac, ab, bc, v[0], v[2]);
    jacobi_rotation(b, c, bc, ab, ac, v[1], v[2]);
  }
  Spectral s;
  s.value[0] = a;
  s.value[1] = b;
  s.value[2] = c;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) s.axes.a[i][j] = v[j][i];
  return s;
}

inline vd largest(const Spectral& s) { return max(s.value[0], max(s.value[1], s.value[2])); }

// Sum over i of f_i n_i n_i for the axes n_i of s.
inline Sym3<vd> compose(const Mat3<vd>& q, const vd* f) {
  const auto c = [&](int i, int j) {
    return q.a[i][0] * f[0] * q.a[j][0] + q.a[i][1] * f[1] * q.a[j][1] + q.a[i][2] * f[2] * q.a[j][2];
  };
  return {c(0, 0), c(1, 1), c(2, 2), c(1, 2), c(0, 2), c(0, 1)};
}

// Positive part <m>_+ by its one eigenvalue of the rarer sign: with one negative value,
// m less that eigenspace; with two, the positive eigenspace alone. The value is a simple
// root of the characteristic polynomial, its eigenspace adj(m - l 1)/tr adj(m - l 1). Lanes
// whose root is nearly double or whose signs are in doubt go through the Jacobi rotations.
inline Sym3<vd> positive_part(const Sym3<vd>& m) {
  // Sylvester: all leading minors positive means there is nothing to cut.
  const vd m2 = m.xx * m.yy - m.xy * m.xy;
  const vd det = determinant(m);
  // Next to a rank-one tensor the sign of the determinant is rounding.
  const vd size2 = contract(m, m);
  const vd noise = 1e-13 * size2 * sqrt(size2);
  const vmask definite = (m.xx > 0.0) & (m2 > 0.0) & (det > noise);
  if (!any(~definite)) return m;
  const vmask negative = (m.xx < 0.0) & (m2 > 0.0) & (det < -noise);
  const vmask two = det >= 0.0;  // where neither definite nor negative definite

  // Roots of u^3 - 3 u - 2 r = 0, l = mean + u sqrt(J2/3); the largest of +-m.
  const vd sign = select(two, splat(1.0), splat(-1.0));
  const vd mean = (1.0 / 3.0) * trace(m);
  const Sym3<vd> dev{m.xx - mean, m.yy - mean, m.zz - mean, m.yz, m.xz, m.xy};
  const vd radius = sqrt(contract(dev, dev) * (1.0 / 6.0));
  const vd tiny = splat(1e-150);
  const vd inverse = 1.0 / max(radius, tiny);
  vd r = 0.5 * sign * determinant(dev) * inverse * inverse * inverse;
  r = max(min(r, splat(1.0)), splat(-1.0));
  // Just above the root for all r, and with its slope at the double root.
  vd u = 1.0 + 1.16 * sqrt(0.5 * (1.0 + r));
  for (int it = 0; it < 5; ++it) {
    const vd slope = 3.0 * (u * u - 1.0);
    u -= (u * (u * u - 3.0) - 2.0 * r) / max(slope, tiny);
  }
  const vd value = mean + sign * radius * u;
  const vmask open = ~definite & ~negative;
  const vmask unsafe = open & ((r < -1.0 + 1e-5) | (abs(det) <= noise) | (radius < 1e-100));

  const vd xx = m.xx - value, yy = m.yy - value, zz = m.zz - value;
  Sym3<vd> adj{yy * zz - m.yz * m.yz, xx * zz - m.xz * m.xz, xx * yy - m.xy * m.xy,
               m.xz * m.xy - xx * m.yz, m.xy * m.yz - yy * m.xz, m.xz * m.yz - zz * m.xy};
  const vd weight = value / max(trace(adj), splat(1e-300));
  Sym3<vd> p = weight * adj;
  p = {select(two, p.xx, m.xx - p.xx), select(two, p.yy, m.yy - p.yy), select(two, p.zz, m.zz - p.zz),
       select(two, p.yz, m.yz - p.yz), select(two, p.xz, m.xz - p.xz), select(two, p.xy, m.xy - p.xy)};
  if (any(unsafe)) {
    const Spectral s = eigen(m);
    vd f[3];
    for (int i = 0; i < 3; ++i) f[i] = max(s.value[i], vd{});
    const Sym3<vd> c = compose(s.axes, f);
    p = {select(unsafe, c.xx, p.xx), select(unsafe, c.yy, p.yy), select(unsafe, c.zz, p.zz),
         select(unsafe, c.yz, p.yz), select(unsafe, c.xz, p.xz), select(unsafe, c.xy, p.xy)};
  }
  const vd zero{};
  p = {select(negative, zero, p.xx), select(negative, zero, p.yy), select(negative, zero, p.zz),
       select(negative, zero, p.yz), select(negative, zero, p.xz), select(negative, zero, p.xy)};
  return {select(definite, m.xx, p.xx), select(definite, m.yy, p.yy), select(definite, m.zz, p.zz),
          select(definite, m.yz, p.yz), select(definite, m.xz, p.xz), select(definite, m.xy, p.xy)};
}

}  // namespace mpdem

#endif
