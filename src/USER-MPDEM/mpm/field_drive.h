// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Points whose strain comes from a field and not from steps: the drive of their damage, and how they take up the field.
// The root of a drive is (Yeq/B)^(1/n) with the degree n of the law. So it grows linearly with the strain. B is the
// threshold that the step uses, including the factor of points that touch a grain.
#ifndef MPDEM_MPM_FIELD_DRIVE_H
#define MPDEM_MPM_FIELD_DRIVE_H

#include <array>
#include <vector>

#include "../material/law.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

// Root of a drive that has this share of its threshold.
double root_of_share(const Law& law, double share);

// Finds bound[6]: with a strain sum_j d_j strain[j], no point has a root above sum_j |d_j| bound[j]. The bounds use the
// norm of the strain. They are zero if the law has no damage.
void find_strain_bounds(const PointStore& points, const std::array<std::vector<Sym3<vd>>, 6>& strain, const Law& law, double* bound);

// Margin of a root: while sum_j |change of d_j| bound[j] is below it, no root exceeds `most`. `root` is the largest
// root now, and b bounds the roots. With a change c of this sum, the square of a root changes by at most 2 b c + c^2
// for degree 2, and the root by at most c for degree 1.
double margin_of_root(const Law& law, double b, double root, double most);
// Margin of averages (drive_average.h), which are means of roots of norms. The bound is that of a point with norm 0, where the root grows most.
double margin_of_average(const Law& law, double b, double root, double most);
// Factor from the bound of roots to the bound of averages. An average goes from points to a point whose threshold may
// be lower by the factor of points that touch a grain.
double bound_of_averages(const Law& law);

// Largest root of the points with their present strain. averages: the grid with the averages of a nonlocal drive, or null.
double largest_root_of_drive(const PointStore& points, const Law& law, const Grid* averages);

// Sets deformation and frames from the displacement of the nodes, which is a rotation Q and small beyond it. The strain
// must be set already. Before the call, deformation and frames are those of creation.
void set_field(PointStore& points, const Grid& grid, const double Q[3][3]);

// Reverts set_field(): no deformation, no strain, and frames without the rotation of the deformation. Keeps the damage.
void go_back_to_creation(PointStore& points);

}  // namespace mpdem

#endif
