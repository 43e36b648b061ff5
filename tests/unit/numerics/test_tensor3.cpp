// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "numerics/tensor3.h"

#include "lanes.h"
#include "material/effective_strain.h"

namespace mpdem {
namespace {

using test::Matrix;
using test::sym3;
using test::tensor;

Mat3<double> mat3(const Matrix& m) {
  Mat3<double> r;
  for (int i = 0; i < 9; ++i) r.a[i / 3][i % 3] = m(i / 3, i % 3);
  return r;
}
Matrix matrix(const Mat3<double>& m) {
  Matrix r;
  for (int i = 0; i < 9; ++i) r(i / 3, i % 3) = m.a[i / 3][i % 3];
  return r;
}

TEST(Tensor3, AgreesWithMatrixAlgebra) {
  test::Random random(3);
  test::Worst worst;
  for (int n = 0; n < 200; ++n) {
    const Matrix a = random.sym(), b = random.sym(), q = random.frame(), f = random.general();
    const Matrix g = random.general() + 2.0 * Matrix::Identity();
    worst.add(std::fabs(contract(sym3(a), sym3(b)) - (a * b).trace()), "contract");
    worst.add(std::fabs(trace(sym3(a)) - a.trace()), "trace");
    worst.add(std::fabs(determinant(sym3(a)) - a.determinant()), "determinant of a symmetric tensor");
    worst.add(tensor(sym3(a) + sym3(b)) - (a + b), 1.0, "sum");
    worst.add(tensor(sym3(a) - sym3(b)) - (a - b), 1.0, "difference");
    worst.add(tensor(1.5 * sym3(a)) - 1.5 * a, 1.0, "multiple");
    worst.add(tensor(sym_product(sym3(a), sym3(b))) - test::symmetric(a * b), 1.0, "sym_product");
    worst.add(tensor(rotate(mat3(q), sym3(a))) - q * a * q.transpose(), 1.0, "rotate");
    worst.add(tensor(rotate_back(mat3(q), sym3(a))) - q.transpose() * a * q, 1.0, "rotate_back");
    worst.add(tensor(sym_product_transposed(mat3(g), mat3(f))) - test::symmetric(g * f.transpose()), 10.0, "sym_product_transposed");
    worst.add(matrix(product(sym3(a), mat3(f))) - a * f, 1.0, "product with a symmetric tensor");
    worst.add(tensor(upper(mat3(a))) - a, 1.0, "upper");
    worst.add(matrix(product(mat3(g), mat3(f))) - g * f, 10.0, "product");
    worst.add(std::fabs(determinant(mat3(g)) - g.determinant()), "determinant");
    worst.add(matrix(cofactor(mat3(g))) - g.determinant() * g.inverse().transpose(), 10.0, "cofactor");
    if (std::fabs(g.determinant()) > 0.5) worst.add(matrix(inverse(mat3(g))) - g.inverse(), 10.0, "inverse");
    const Matrix positive = a * a + Matrix::Identity();
    worst.add(tensor(inverse(sym3(positive))) - positive.inverse(), 1.0, "inverse of a symmetric tensor");
  }
  expect_within(worst, 1e-13, "deviation");
}

}  // namespace
}  // namespace mpdem
