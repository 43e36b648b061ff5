// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// create_cement: all that it reads of the store of the points and puts into it.
#include <cmath>

#include "atom.h"
#include "atom_vec_mpdem.h"
#include "create_cement.h"
#include "domain.h"

namespace LAMMPS_NS {

using mpdem::Body;
using mpdem::FillPoint;

std::vector<CreateCement::FullPoint> CreateCement::full_points(int bodies) const {
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  std::vector<double> full;
  for (const Body& b : avec->bonds.table) full.push_back(0.95 * std::pow(b.spacing, 3));
  std::vector<FullPoint> found;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!avec->is_point(i)) continue;
    const int b = avec->slot[i] / mpdem::kLanes, l = avec->slot[i] % mpdem::kLanes;
    const int body = avec->bond[i];
    if (body >= bodies || avec->points_of(i).blocks[b].volume[l] < full[body]) continue;
    found.push_back({mpdem::Vector3(atom->x[i][0], atom->x[i][1], atom->x[i][2]), body});
  }
  return found;
}

// Whether a point of a body lies in the sub-domain of this rank, and where.
bool CreateCement::place(const Body& body, const FillPoint& p, double* x, tagint& image) const {
  for (int c = 0; c < 3; ++c) x[c] = body.origin[c] + p.X[c];
  image = ((tagint)IMGMAX << IMG2BITS) | ((tagint)IMGMAX << IMGBITS) | IMGMAX;
  domain->remap(x, image);
  bool mine = true;
  for (int c = 0; c < 3; ++c) mine = mine && x[c] >= domain->sublo[c] && x[c] < domain->subhi[c];
  return mine;
}

void CreateCement::add_point(const FillPoint& p, const Body& body, int body_index, int tag, const double* x, tagint image) {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  double at[3] = {x[0], x[1], x[2]};
  avec->create_atom(type_, at);
  const int i = atom->nlocal - 1;
  atom->tag[i] = tag;
  atom->image[i] = image;
  atom->mask[i] = 1 | groupbit_;
  atom->radius[i] = std::cbrt(0.75 * p.volume / M_PI);
  atom->density[i] = density_;
  atom->rmass[i] = density_ * p.volume;

  mpdem::PointRecord r;
  r.body = body_index;
  for (int c = 0; c < 3; ++c) r.X[c] = p.X[c];
  r.volume = p.volume;
  r.links = p.links;
  for (int k = 0; k < p.links; ++k) {
    r.link[k].grain = body.grain[p.link[k].side];
    for (int c = 0; c < 3; ++c) r.link[k].foot[c] = p.link[k].foot[c];
    r.link[k].area = p.link[k].area;
    r.link[k].attached = p.link[k].attached;
  }
  r.failed = p.failed;
  std::copy(p.damage, p.damage + 6, r.damage);
  if (p.axis.squaredNorm() > 0.0) set_frame(p, r);
  avec->add_point(i, r, tag);
}

}  // namespace LAMMPS_NS
