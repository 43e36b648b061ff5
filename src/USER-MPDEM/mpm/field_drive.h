// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Points whose strain is given by a field and not by steps: the drive of the damage that they have, and how they take the field up.
// The root of a drive is (Yeq/B)^(1/n) with the degree n of the law, so that it grows as the strain does. B is the threshold as the step
// compares it, with the factor of points that touch a grain.
#ifndef MPDEM_FIELD_DRIVE_H
#define MPDEM_FIELD_DRIVE_H

#include <array>
#include <vector>

#include "../material/law.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

// Root of a drive that is this share of its threshold.
double root_of_share(const Law& law, double share);

// Of strains d_j strain_j no point has a larger root than sum |d_j| bound[j]. By the norm of the strain, 0 without damage.
void find_strain_bounds(const PointStore& points, const std::array<std::vector<Sym3<vd>>, 6>& strain, const Law& law, double* bound);

// So much may sum |change of d_j| bound[j] become before a root may reach `most`: of degree 2 the square of a root changes by 2 b c + c^2 at most,
// where b bounds the root, of degree 1 the root by c.
double margin_of_root(const Law& law, double b, double root, double most);
// The same of averages (drive_average.h), which are means of roots of norms: where the norm of a point is 0 its root grows most.
double margin_of_average(const Law& law, double b, double root, double most);
// An average goes from points to one whose threshold may be lower, by the factor of those that touch a grain: so many times the bound of points bounds it.
double bound_of_averages(const Law& law);

// The largest root of the points with the strain that they have. averages: a grid that has those of the drive over a length, if they count.
double largest_root_of_drive(const PointStore& points, const Law& law, const Grid* averages);

// Deformation and frames by the displacement of the nodes, which is that of a turn Q and small beyond it. The strain is given already.
// Before, the points are as they were made.
void take_up_field(PointStore& points, const Grid& grid, const double Q[3][3]);

// The other way: no deformation and no strain, frames without the turn of the deformation. The damage stays.
void go_back_to_creation(PointStore& points);

}  // namespace mpdem

#endif
