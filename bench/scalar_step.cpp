// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "scalar_step.h"

namespace mpdem::bench {

namespace {

using M = double[3][3];

void rotation(const double* q, M R) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                          {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                          {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R[i][j] = r[i][j];
}

void spin(const double* q, double vx, double vy, double vz, double* out) {
  const double x = 0.5 * vx, y = 0.5 * vy, z = 0.5 * vz;
  const double p[4] = {q[0] - x * q[1] - y * q[2] - z * q[3], q[1] + x * q[0] + y * q[3] - z * q[2], q[2] + y * q[0] + z * q[1] - x * q[3],
                       q[3] + z * q[0] + x * q[2] - y * q[1]};
  const double n = 1.0 / std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
  for (int i = 0; i < 4; ++i) out[i] = n * p[i];
}

void invert(const M a, M out) {
  M c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      c[i][j] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
    }
  const double r = 1.0 / (a[0][0] * c[0][0] + a[0][1] * c[0][1] + a[0][2] * c[0][2]);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[i][j] = r * c[j][i];
}

void spline(double t, double inverse_h, double* w, double* dw) {
  w[0] = 0.5 * (1.5 - t) * (1.5 - t);
  w[1] = 0.75 - (t - 1) * (t - 1);
  w[2] = 0.5 * (t - 0.5) * (t - 0.5);
  dw[0] = (t - 1.5) * inverse_h;
  dw[1] = -2 * (t - 1) * inverse_h;
  dw[2] = (t - 0.5) * inverse_h;
}

}  // namespace

std::vector<ScalarPoint> scalar_points(const FreeBody& s) {
  std::vector<ScalarPoint> all;
  s.for_points([&](int b, int l) {
    const PointBlock& p = s.points().blocks[b];
    const BlockMeta& m = s.points().meta[b];
    ScalarPoint r;
    for (int i = 0; i < 3; ++i) {
      r.X[i] = p.X[i][l];
      r.base[i] = cell_of(m, l, i);
      for (int j = 0; j < 3; ++j) r.F[i][j] = p.F.a[i][j][l];
    }
    r.volume = p.volume[l];
    const vd* q = &p.q.w;
    for (int i = 0; i < 4; ++i) r.q[i] = q[i][l];
    const vd* e = &p.strain.xx;
    for (int i = 0; i < 6; ++i) r.strain[i] = e[i][l];
    if (!s.grid().find_columns(field_of(m.row, m.layer), r.base, r.column)) throw std::logic_error("a point has no nodes");
    all.push_back(r);
  });
  return all;
}

long scalar_advance(std::vector<ScalarPoint>& points, const double* velocity, double* force, double h, const TensorDamage& law, double dt) {
  const double inverse_h = 1.0 / h, B2 = law.parameters().B0 * law.parameters().B0;
  long over = 0;
  for (ScalarPoint& p : points) {
    double w[3][3], dw[3][3];
    for (int d = 0; d < 3; ++d) spline(p.X[d] * inverse_h - p.base[d], inverse_h, w[d], dw[d]);
    M dF = {};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
          const double* v = velocity + 3 * (p.column[3 * i + j] + k);
          const double g[3] = {dw[0][i] * w[1][j] * w[2][k], w[0][i] * dw[1][j] * w[2][k], w[0][i] * w[1][j] * dw[2][k]};
          for (int c = 0; c < 3; ++c)
            for (int d = 0; d < 3; ++d) dF[c][d] += v[c] * g[d];
        }
    M mid, inverse, G = {}, R;
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d) {
        dF[c][d] *= dt;
        mid[c][d] = p.F[c][d] + 0.5 * dF[c][d];
      }
    invert(mid, inverse);
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d)
        for (int e = 0; e < 3; ++e) G[c][d] += dF[c][e] * inverse[e][d];
    const double wx = 0.5 * (G[2][1] - G[1][2]), wy = 0.5 * (G[0][2] - G[2][0]), wz = 0.5 * (G[1][0] - G[0][1]);
    double q[4];
    spin(p.q, 0.5 * wx, 0.5 * wy, 0.5 * wz, q);
    rotation(q, R);
    double e[3][3] = {};
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (int c = 0; c < 3; ++c)
          for (int d = 0; d < 3; ++d) e[a][b] += R[c][a] * 0.5 * (G[c][d] + G[d][c]) * R[d][b];
    p.strain[0] += e[0][0];
    p.strain[1] += e[1][1];
    p.strain[2] += e[2][2];
    p.strain[3] += e[1][2];
    p.strain[4] += e[0][2];
    p.strain[5] += e[0][1];
    spin(p.q, wx, wy, wz, q);
    std::copy(q, q + 4, p.q);
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d) p.F[c][d] += dF[c][d];

    const Sym3<double> strain{p.strain[0], p.strain[1], p.strain[2], p.strain[3], p.strain[4], p.strain[5]};
    const Sym3<double> stress = law.elasticity().stress(strain), Y = sym_product(stress, strain);
    if (0.5 * contract(Y, Y) > B2) ++over;
    const double s[3][3] = {{stress.xx, stress.xy, stress.xz}, {stress.xy, stress.yy, stress.yz}, {stress.xz, stress.yz, stress.zz}};
    rotation(p.q, R);
    invert(p.F, inverse);
    double tau[3][3] = {}, P[3][3] = {};
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (int c = 0; c < 3; ++c)
          for (int d = 0; d < 3; ++d) tau[a][b] += R[a][c] * s[c][d] * R[b][d];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (int c = 0; c < 3; ++c) P[a][b] -= p.volume * tau[a][c] * inverse[b][c];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
          double* f = force + 3 * (p.column[3 * i + j] + k);
          const double g[3] = {dw[0][i] * w[1][j] * w[2][k], w[0][i] * dw[1][j] * w[2][k], w[0][i] * w[1][j] * dw[2][k]};
          for (int c = 0; c < 3; ++c) f[c] += P[c][0] * g[0] + P[c][1] * g[1] + P[c][2] * g[2];
        }
  }
  return over;
}

}  // namespace mpdem::bench
