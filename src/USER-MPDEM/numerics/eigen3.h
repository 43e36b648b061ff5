// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Spectral decomposition of eight symmetric 3x3 tensors at once by cyclic Jacobi rotations (Golub & Van Loan, Matrix
// Computations, sec. 8.5). A lane that has converged is not rotated further, so its result does not depend on the
// others. The method is backward stable, exact for diagonal input, and has no branch on repeated eigenvalues.
#ifndef MPDEM_NUMERICS_EIGEN3_H
#define MPDEM_NUMERICS_EIGEN3_H

#include "simd.h"
#include "tensor3.h"

namespace mpdem {

struct Spectral {
  vd value[3];    // not sorted
  Mat3<vd> axes;  // column i belongs to value[i]
};

// Rotates the tensor in the plane of the axes p and q so that its component apq becomes zero, in the lanes `open`. r is the third
// axis. vp and vq are the columns p and q of the product of all rotations so far.
inline void jacobi_rotation(vmask open, vd& app, vd& aqq, vd& apq, vd& arp, vd& arq, vd* vp, vd* vq) {
  const vd diff = aqq - app;
  const vd twice = select(open, apq + apq, vd{});
  // t is the tangent of the smaller angle. It is found without a division by apq, so that apq = 0 gives the identity.
  const vd root = sqrt(diff * diff + twice * twice);
  const vd denom = abs(diff) + root;
  const vd tiny = splat(1e-300);
  const vd t_abs = twice / max(denom, tiny);
  const vd t = diff < 0.0 ? -t_abs : t_abs;
  const vd c = 1.0 / sqrt(1.0 + t * t);
  const vd s = t * c;
  app -= t * apq;
  aqq += t * apq;
  apq = select(open, vd{}, apq);
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
  const vd tolerance = 1e-32 * scale;  // squared: off-diagonals below 1e-16 of the norm
  for (int sweep = 0; sweep < 12; ++sweep) {
    const vmask open = bc * bc + ac * ac + ab * ab > tolerance;
    if (!any(open)) break;
    jacobi_rotation(open, a, b, ab, ac, bc, v[0], v[1]);
    jacobi_rotation(open, a, c, ac, ab, bc, v[0], v[2]);
    jacobi_rotation(open, b, c, bc, ab, ac, v[1], v[2]);
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

// Sum over i of f_i n_i n_i for the columns n_i of q.
inline Sym3<vd> compose(const Mat3<vd>& q, const vd* f) {
  const auto c = [&](int i, int j) { return q.a[i][0] * f[0] * q.a[j][0] + q.a[i][1] * f[1] * q.a[j][1] + q.a[i][2] * f[2] * q.a[j][2]; };
  return {c(0, 0), c(1, 1), c(2, 2), c(1, 2), c(0, 2), c(0, 1)};
}

// An extreme eigenvalue. gap: from 2 down to 0, where the eigenvalue is double; the value is not accurate for a gap below 1e-5.
// radius: half of the largest distance that an eigenvalue can have from the mean of all three, (J2/3)^(1/2).
struct Extreme {
  vd value, gap, radius;
};

// Returns the largest eigenvalue of m where sign is 1, and the smallest where it is -1, as a root of the characteristic polynomial.
inline Extreme extreme_eigenvalue(const Sym3<vd>& m, vd sign) {
  // The eigenvalues are mean + u sqrt(J2/3) with the roots u of u^3 - 3 u - 2 r = 0. Finds the largest of sign times m.
  const vd mean = (1.0 / 3.0) * trace(m);
  const Sym3<vd> dev{m.xx - mean, m.yy - mean, m.zz - mean, m.yz, m.xz, m.xy};
  const vd radius = sqrt(contract(dev, dev) * (1.0 / 6.0));
  const vd tiny = splat(1e-150);
  const vd inverse = 1.0 / max(radius, tiny);
  vd r = 0.5 * sign * determinant(dev) * inverse * inverse * inverse;
  r = max(min(r, splat(1.0)), splat(-1.0));
  // u = 2 cos(2/3 arccos c) with r = 2 c^2 - 1. The Chebyshev interpolation in c is accurate to 3e-6. Two Newton steps
  // give all digits.
  const vd c = sqrt(0.5 * (1.0 + r));
  vd u = 1.00000274602 + c * (1.15450081002 + c * (-0.21976891968 + c * (0.0952690139231 + c * (-0.0382436570715 + c * 0.00824160659855))));
  for (int it = 0; it < 2; ++it) {
    const vd slope = 3.0 * (u * u - 1.0);
    u -= (u * (u * u - 3.0) - 2.0 * r) / max(slope, tiny);
  }
  return {mean + sign * radius * u, 1.0 + r, radius};
}

// adj(m - value 1), a multiple of the projection on the eigenspace of a simple eigenvalue.
inline Sym3<vd> adjugate(const Sym3<vd>& m, vd value) {
  const vd xx = m.xx - value, yy = m.yy - value, zz = m.zz - value;
  return {yy * zz - m.yz * m.yz,   xx * zz - m.xz * m.xz,   xx * yy - m.xy * m.xy,
          m.xz * m.xy - xx * m.yz, m.xy * m.yz - yy * m.xz, m.xz * m.yz - zz * m.xy};
}

inline Sym3<vd> blend(vmask m, const Sym3<vd>& a, const Sym3<vd>& b) {
  return {select(m, a.xx, b.xx), select(m, a.yy, b.yy), select(m, a.zz, b.zz),
          select(m, a.yz, b.yz), select(m, a.xz, b.xz), select(m, a.xy, b.xy)};
}

struct LargestEigenvalue {
  vd value;
  Sym3<vd> slope;  // derivative by m: projection on an eigenspace, or the mean over equal eigenvalues
};

inline vd largest_eigenvalue(const Sym3<vd>& m) {
  const Extreme e = extreme_eigenvalue(m, splat(1.0));
  const vmask unsafe = (e.gap < 1e-5) & (e.radius > 1e-100);  // if the radius is smaller, all eigenvalues are the mean
  return any(unsafe) ? select(unsafe, largest(eigen(m)), e.value) : e.value;
}

inline LargestEigenvalue largest_eigenvalue_and_slope(const Sym3<vd>& m) {
  const Extreme e = extreme_eigenvalue(m, splat(1.0));
  LargestEigenvalue l{e.value, adjugate(m, e.value)};
  l.slope = (1.0 / max(trace(l.slope), splat(1e-300))) * l.slope;
  const vmask unsafe = (e.gap < 1e-5) | (e.radius < 1e-100);
  if (any(unsafe)) {
    const Spectral s = eigen(m);
    const vd top = largest(s);
    vd f[3], sum{};
    for (int i = 0; i < 3; ++i) {
      f[i] = select(s.value[i] >= top - 1e-9 * abs(top), splat(1.0), vd{});
      sum += f[i];
    }
    for (int i = 0; i < 3; ++i) f[i] /= sum;
    l.value = select(unsafe, top, l.value);
    l.slope = blend(unsafe, compose(s.axes, f), l.slope);
  }
  return l;
}

// Signs of the eigenvalues, by Sylvester's minors. If the signs differ, one eigenvalue has the rarer sign.
struct Signs {
  vmask definite, negative;  // all positive, all negative
  vmask two;                 // in other lanes: two negative values and one positive; if false, one negative
  vmask unsafe;              // the root is nearly double, or the signs are in doubt
  Extreme rarer;
};

// m2, det: the leading minors of m of order 2 and 3. noise: rounding error of det. Call it only if some lane is not definite.
inline Signs signs_of(const Sym3<vd>& m, vmask definite, vd m2, vd det, vd noise) {
  Signs s;
  s.definite = definite;
  s.negative = (m.xx < 0.0) & (m2 > 0.0) & (det < -noise);
  s.two = det >= 0.0;
  s.rarer = extreme_eigenvalue(m, select(s.two, splat(1.0), splat(-1.0)));
  s.unsafe = ~definite & ~s.negative & ((s.rarer.gap < 1e-5) | (abs(det) <= noise) | (s.rarer.radius < 1e-100));
  return s;
}

// Calls all() if all eigenvalues are positive in all lanes, else some(signs). size2: m : m.
template <class All, class Some>
auto by_signs(const Sym3<vd>& m, vd size2, All all, Some some) {
  const vd m2 = m.xx * m.yy - m.xy * m.xy;
  const vd det = determinant(m);
  // Near a rank-one tensor the sign of the determinant is rounding error.
  const vd noise = 1e-13 * size2 * sqrt(size2);
  const vmask definite = (m.xx > 0.0) & (m2 > 0.0) & (det > noise);
  return any(~definite) ? some(signs_of(m, definite, m2, det, noise)) : all();
}

// Positive part <m>_+ by the one eigenvalue of the rarer sign. If that is negative, <m>_+ is m less its part in this eigenspace.
// If it is positive, <m>_+ is its part in this eigenspace alone. Lanes whose root is nearly double, or whose signs are in doubt,
// use the Jacobi rotations.
inline Sym3<vd> positive_part(const Sym3<vd>& m) {
  return by_signs(
      m, contract(m, m), [&] { return m; },
      [&](const Signs& s) {
        const Sym3<vd> adj = adjugate(m, s.rarer.value);
        Sym3<vd> p = (s.rarer.value / max(trace(adj), splat(1e-300))) * adj;
        p = blend(s.two, p, m - p);
        if (any(s.unsafe)) {
          const Spectral of = eigen(m);
          vd f[3];
          for (int i = 0; i < 3; ++i) f[i] = max(of.value[i], vd{});
          p = blend(s.unsafe, compose(of.axes, f), p);
        }
        return blend(s.definite, m, blend(s.negative, Sym3<vd>{}, p));
      });
}

// <m>_+ : <m>_+ by the same eigenvalue, without its axes. If a large negative eigenvalue is subtracted and little is left, the
// difference has no digits. The result of the Jacobi rotations is used then.
inline vd square_of_positive_part(const Sym3<vd>& m) {
  const vd size2 = contract(m, m);
  return by_signs(
      m, size2, [&] { return size2; },
      [&](const Signs& s) {
        const vd rarer2 = s.rarer.value * s.rarer.value;
        vd square = select(s.two, rarer2, size2 - rarer2);
        const vmask unsafe = s.unsafe | (~s.definite & ~s.negative & ~s.two & (square < 1e-4 * size2));
        if (any(unsafe)) {
          const Spectral of = eigen(m);
          vd sum{};
          for (const vd& value : of.value) {
            const vd p = max(vd{}, value);  // NaN stays
            sum += p * p;
          }
          square = select(unsafe, sum, square);
        }
        return select(s.definite, size2, select(s.negative, vd{}, square));
      });
}

}  // namespace mpdem

#endif
