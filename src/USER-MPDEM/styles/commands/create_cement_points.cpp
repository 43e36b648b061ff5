// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The part of create_cement.h that makes the points.
#include <algorithm>
#include <cmath>

#include "../../geometry/frame_along.h"
#include "create_cement.h"
#include "atom.h"
#include "../atoms/atom_vec_mpdem.h"

namespace LAMMPS_NS {

using mpdem::BondRecord;
using mpdem::FillPoint;
using mpdem::NewBond;
using mpdem::Vector3;

namespace {

// Sets a frame whose third axis is the axis of the elasticity, and the damage in its components.
void set_frame(const FillPoint& p, mpdem::PointRecord& r) {
  const Eigen::Quaterniond q = mpdem::frame_along(p.axis);
  const double w[4] = {q.w(), q.x(), q.y(), q.z()};
  std::copy(w, w + 4, r.q);
  r.has_frame = true;
  const double* D = p.damage;
  Eigen::Matrix3d m;
  m << D[0], D[5], D[4], D[5], D[1], D[3], D[4], D[3], D[2];
  const Eigen::Matrix3d R = q.toRotationMatrix(), t = R.transpose() * m * R;
  const double turned[6] = {t(0, 0), t(1, 1), t(2, 2), t(1, 2), t(0, 2), t(0, 1)};
  std::copy(turned, turned + 6, r.damage);
}

}  // namespace

std::vector<mpdem::FullPoint> CreateCement::full_points(int rows) {
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  const std::vector<BondRecord>& table = avec->bonds.table;
  std::vector<double> full;  // least volume of an uncut cell, by row
  for (const BondRecord& b : table) full.push_back(0.95 * std::pow(b.spacing, 3));
  std::vector<mpdem::FullPoint> found;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!avec->is_point(i)) continue;
    const int row = avec->bond[i];
    if (row >= rows) continue;
    const double width = mpdem::width_filled(avec->record_of(i), table[row].spacing, full[row]);
    if (width > 0.0) found.push_back({Vector3(atom->x[i][0], atom->x[i][1], atom->x[i][2]), row, width});
  }
  for (int row : avec->bonds.rows_without_points()) {
    if (row >= rows) break;
    const BondRecord& record = table[row];
    const mpdem::Mat3<double> axes = mpdem::axes_of(record);
    for (const mpdem::TemplatePoint& p : avec->bonds.template_of(row).points) {
      const double width = mpdem::width_filled(p, record.spacing, full[row]);
      const Vector3 x(mpdem::position_in_box(record, axes, p.X).data());
      if (width > 0.0 && box_.owns(x)) found.push_back({x, row, width});
    }
  }
  return found;
}

// Returns whether a point of a bond belongs to this rank. Sets its position in the box and its image.
bool CreateCement::place(const BondRecord& record, const mpdem::Mat3<double>& axes, const FillPoint& p, double* x, int* image) const {
  const std::array<double, 3> in_box = mpdem::position_in_box(record, axes, p.X.data());
  std::copy(in_box.begin(), in_box.end(), x);
  std::fill(image, image + 3, 0);
  return box_.wrap(x, image);
}

std::size_t CreateCement::create_points(const std::vector<NewBond>& bonds, bool more) {
  double x[3], at_most = 0.0;
  int image[3];
  for (const NewBond& b : bonds) {
    const mpdem::Mat3<double> axes = mpdem::axes_of(b.record);
    if (box_.own().contains(mpdem::box_around(b.record, b.box))) at_most += b.points.size();
    else
      for (const FillPoint& p : b.points) at_most += place(b.record, axes, p, x, image);
  }
  atoms_->reserve(at_most, more);
  const int before = atom->nlocal;
  for (const NewBond& b : bonds) {
    const mpdem::Mat3<double> axes = mpdem::axes_of(b.record);
    for (std::size_t n = 0; n < b.points.size(); ++n)
      if (place(b.record, axes, b.points[n], x, image)) {
        const int i = add_point(b.points[n], b, b.first_tag + static_cast<int>(n), x, image);
        const std::array<double, 3> v = velocity_of(b, axes, b.points[n]);
        std::copy(v.begin(), v.end(), atom->v[i]);
      }
  }
  return atom->nlocal - before;
}

std::array<double, 3> CreateCement::velocity_of(const NewBond& b, const mpdem::Mat3<double>& axes, const FillPoint& p) {
  std::array<double, 3> arm[2];
  for (int s = 0; s < 2; ++s) {
    const Vector3 from = p.X - Vector3(b.record.centre[s]);
    arm[s] = turned(axes, from.data());
  }
  return mpdem::velocity_between(b.grain, arm);
}

int CreateCement::add_point(const FillPoint& p, const NewBond& bond, int tag, double* x, const int* image) {
  mpdem::PointRecord r;
  r.row = bond.row;
  for (int c = 0; c < 3; ++c) r.X[c] = p.X[c];
  r.volume = p.volume;
  r.film = p.film;
  r.material = p.material;
  r.links = p.link_count;
  for (int k = 0; k < p.link_count; ++k) {
    r.link[k].grain = bond.record.grain[p.link[k].side];
    for (int c = 0; c < 3; ++c) r.link[k].foot[c] = p.link[k].foot[c];
    r.link[k].area = p.link[k].area;
    r.link[k].attached = p.link[k].attached;
    r.link[k].state[0] = p.link[k].damage;
  }
  r.failed = p.failed;
  std::copy(p.damage, p.damage + 6, r.damage);
  if (p.axis.squaredNorm() > 0.0) set_frame(p, r);
  return atoms_->add(r, head(), tag, x, image);
}

}  // namespace LAMMPS_NS
