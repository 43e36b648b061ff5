// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Damage drive of points whose strain comes from a superposition of fields and not from steps, and how the points are
// set to such a field. Field j, one of six, is strain[j] times its amplitude d_j. The root of a drive is (Yeq/B)^(1/n) with the degree n
// of the law, so it grows linearly with the strain. B is the threshold that the step uses, with the factor of points at a grain.
#ifndef MPDEM_MPM_FIELD_DRIVE_H
#define MPDEM_MPM_FIELD_DRIVE_H

#include <array>
#include <vector>

#include "../material/law.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

// Root of a drive that is `share` times its threshold.
double root_of_share(const Law& law, double share);

// Finds bound[6]: with the strain sum_j d_j strain[j], no point has a root above sum_j |d_j| bound[j]. The bounds use
// the norm of the strain. They are zero if the law has no damage.
void find_strain_bounds(const PointStore& points, const std::array<std::vector<Sym3<vd>>, 6>& strain, const Law& law, double* bound);

// Margin of a root: while c = sum_j |change of d_j| bound[j] is below it, no root exceeds `most`. `root` is the largest present root,
// and b is a bound of all. For degree 2 the square of a root changes by at most 2 b c + c^2, for degree 1 the root by at most c.
double margin_of_root(const Law& law, double b, double root, double most);
// Margin of averages (drive_average.h). It assumes that each point has the norm 0, where the root grows most.
double margin_of_average(const Law& law, double b, double root, double most);
// Factor from the bound of roots to the bound of averages. An average spreads from points to a point whose threshold
// may be lower by the factor of points that touch a grain.
double bound_of_averages(const Law& law);

// Largest root of the points with their present strain. averages: the grid with the averages of a nonlocal drive, or
// null.
double largest_root_of_drive(const PointStore& points, const Law& law, const Grid* averages);

// Sets deformation and frames from the displacement of the nodes, which is a rotation Q plus a small displacement. The
// strain must be set before the call. Deformation and frames must be those of creation.
void set_field(PointStore& points, const Grid& grid, const double Q[3][3]);

// Reverts set_field(): no deformation, no strain, and frames without the rotation of the deformation. Keeps the damage.
void revert_field(PointStore& points);

}  // namespace mpdem

#endif
