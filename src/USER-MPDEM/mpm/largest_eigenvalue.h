// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Largest eigenvalue of M^-1 K of the cement on its grid. K is the secant stiffness in the present state, M the lumped
// mass. The central difference scheme is stable up to dt = 2/sqrt(lambda).
//
// The eigenvalue is found by Lanczos iteration in the inner product of M (Golub & Van Loan, Matrix Computations, ch.
// 10), which converges faster than power iteration because it uses all earlier products. K is never formed: one product
// is one gather and one scatter over the points.
#ifndef MPDEM_MPM_LARGEST_EIGENVALUE_H
#define MPDEM_MPM_LARGEST_EIGENVALUE_H

#include <mpi.h>

#include <vector>

#include "../material/law.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

struct EigenvalueEstimate {
  double value;     // 1/time^2
  double residual;  // there is an eigenvalue within this distance of value
  int products;     // number of products with the operator
  // Upper estimate of the eigenvalue: value plus tolerance, or value plus residual where the iteration did not converge.
  // The converged residual is not used, since it depends on the random start vector. The value depends on that vector
  // only to second order in the residual.
  double most;
};

// Points and grid of one bond.
struct EigenvalueSystem {
  const PointStore* points;
  const Grid* grid;
  bool failed_as_undamaged = false;          // take failed points as undamaged, since cracks may close (closing_points.h)
  const std::vector<int>* blocks = nullptr;  // K has the points of these blocks; null: of all
};

// Relative tolerances: for a check, and for an eigenvalue on which the result of a run depends.
constexpr double kEigenvalueTolerance = 1e-3, kPreciseEigenvalue = 1e-7;

// Finds the largest eigenvalue of all bonds together. Collective. systems: bonds of this rank, in ascending order of
// their rows in the table of bonds. The iteration stops when the residual is below tolerance times the value, or after
// 200 products.
EigenvalueEstimate largest_eigenvalue(MPI_Comm comm, const std::vector<EigenvalueSystem>& systems, const Law& law,
                                      double tolerance = kEigenvalueTolerance);
inline EigenvalueEstimate largest_eigenvalue(MPI_Comm comm, const PointStore& points, const Grid& grid, const Law& law,
                                             double tolerance = kEigenvalueTolerance) {
  return largest_eigenvalue(comm, {{&points, &grid}}, law, tolerance);
}

// Upper bound of the largest eigenvalue for any positions of the points, or 0 if the basis has none. With row-sum
// lumping the largest eigenvalue is at most that of a single point (Fried 1972). The eigenvalue of a single point is at
// most the maximum over t of sum_I (dN_I/dt)^2 / N_I, times the largest stiffness over density h^2. The maximum is
// kSteepest of the basis.
double eigenvalue_bound(Basis basis, double largest_stiffness, double density, double h);

}  // namespace mpdem

#endif
