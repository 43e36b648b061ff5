// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "wall_faces.h"

#include <algorithm>
#include <cmath>

#include "../../numerics/length.h"
#include "../../numerics/triangle.h"
#include "../words/arguments.h"
#include "atom.h"
#include "fix_mesh_surface.h"
#include "fix_wall_gran.h"
#include "modify.h"
#include "primitive_wall.h"
#include "tri_mesh.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {

// `shear` of a primitive wall, for which LIGGGHTS has no accessor.
struct Shear : FixWallGran {
  static int is_on(const FixWallGran& w) { return w.*(&Shear::shear_); }
  static int direction(const FixWallGran& w) { return w.*(&Shear::shearDim_); }
  static int axis(const FixWallGran& w) { return w.*(&Shear::shearAxis_); }
  static double speed(const FixWallGran& w) { return w.*(&Shear::vshear_); }
};

}  // namespace

void LiggghtsWalls::find() {
  walls_.clear();
  const Modify& modify = *lmp_->modify;
  for (int n = 0; n < modify.nfix; ++n) {
    FixWallGran* wall = dynamic_cast<FixWallGran*>(modify.fix[n]);
    if (!wall) continue;
    if (!wall->is_mesh_wall()) {
      Wall w{nullptr, wall->primitiveWall(), wall->groupbit, {0.0, 0.0, 0.0}, nullptr};
      if (Shear::is_on(*wall)) {
        if (w.primitive->axis() >= 0 && Shear::axis(*wall) >= 0)
          stop_all(lmp_, text_of("fix wall/gran (id ", wall->id,
                                 "): 'shear' of a cylinder does not go with 'friction' of fix mpm/couple; "
                                 "use a mesh with 'fix move/mesh rotate'"));
        w.shear[Shear::direction(*wall)] = Shear::speed(*wall);
      }
      walls_.push_back(w);
    }
    for (int m = 0; wall->is_mesh_wall() && m < wall->n_meshes(); ++m) {
      FixMeshSurface* mesh = wall->mesh_list()[m];
      auto* velocity = mesh->triMesh()->prop().getElementProperty<MultiVectorContainer<double, 3, 3>>("v");
      walls_.push_back({mesh, nullptr, wall->groupbit, {0.0, 0.0, 0.0}, velocity ? velocity->begin() : nullptr});
    }
  }
}

bool LiggghtsWalls::acts_on(int wall, int grain) const {
  if (is_fragment(grain)) return true;
  const int i = lmp_->atom->map(grain);
  return i >= 0 && (lmp_->atom->mask[i] & walls_[static_cast<std::size_t>(wall)].group);
}

bool LiggghtsWalls::any_mesh() const {
  return std::any_of(walls_.begin(), walls_.end(), [](const Wall& w) { return w.mesh != nullptr; });
}

LiggghtsWalls::Triangle LiggghtsWalls::triangle(const Wall& w, int face) const {
  TriMesh& mesh = *w.mesh->triMesh();
  Triangle t;
  for (int k = 0; k < 3; ++k) mesh.node(face, k, t.corner[k]);
  t.velocity = w.velocity ? w.velocity[face] : nullptr;
  return t;
}

void LiggghtsWalls::faces_near(int wall, const double* x, double far, std::vector<int>& faces) const {
  const Wall& w = walls_[wall];
  faces.clear();
  if (w.primitive) {
    if (nearest(wall, 0, x).distance < far) faces.push_back(0);
    return;
  }
  const int all = w.mesh->triMesh()->sizeLocal() + w.mesh->triMesh()->sizeGhost();
  for (int f = 0; f < all; ++f) {
    const Triangle t = triangle(w, f);
    bool apart = false;
    for (int d = 0; d < 3 && !apart; ++d) {
      const double low = std::min({t.corner[0][d], t.corner[1][d], t.corner[2][d]}),
                   high = std::max({t.corner[0][d], t.corner[1][d], t.corner[2][d]});
      apart = x[d] < low - far || x[d] > high + far;
    }
    if (!apart && nearest(wall, f, x).distance < far) faces.push_back(f);
  }
}

WallFaces::Nearest LiggghtsWalls::nearest(int wall, int face, const double* x) const {
  const Wall& w = walls_[wall];
  Nearest n{};
  if (w.primitive) {
    double of_point[3] = {x[0], x[1], x[2]}, delta[3] = {0, 0, 0};
    n.distance = w.primitive->resolveContact(of_point, 0.0, delta);
    for (int d = 0; d < 3; ++d) n.foot[d] = x[d] + delta[d], n.velocity[d] = w.shear[d];
    return n;
  }
  const Triangle t = triangle(w, face);
  const std::array<double, 3> share = nearest_in_triangle(t.corner[0], t.corner[1], t.corner[2], x);
  double square = 0.0;
  for (int d = 0; d < 3; ++d) {
    for (int k = 0; k < 3; ++k) {
      n.foot[d] += share[k] * t.corner[k][d];
      if (t.velocity) n.velocity[d] += share[k] * t.velocity[k][d];
    }
    square += (x[d] - n.foot[d]) * (x[d] - n.foot[d]);
  }
  n.distance = std::sqrt(square);
  return n;
}

// The mesh takes the place of a force from an atom and its distance from this.
int LiggghtsWalls::any_atom() const { return lmp_->atom->nlocal > 0 ? 0 : -1; }

void LiggghtsWalls::add_force(int wall, int face, int grain, const double* force, const double* at) {
  const Wall& w = walls_[wall];
  const Atom& atom = *lmp_->atom;
  const int i = is_fragment(grain) ? any_atom() : lmp_->atom->map(grain);
  if (!w.mesh || i < 0 || !w.mesh->trackStress()) return;
  double on_grain[3], delta[3];
  for (int d = 0; d < 3; ++d) {
    on_grain[d] = -force[d];
    delta[d] = at[d] - atom.x[i][d];
  }
  Nearest n = nearest(wall, face, at);
  w.mesh->add_particle_contribution(i, on_grain, delta, face, n.velocity);
}

double LiggghtsWalls::largest_speed() const {
  double most = 0.0;
  for (const Wall& w : walls_) {
    most = std::max(most, length(w.shear));
    const int all = w.velocity ? w.mesh->triMesh()->sizeLocal() + w.mesh->triMesh()->sizeGhost() : 0;
    for (int f = 0; f < all; ++f)
      for (int k = 0; k < 3; ++k) most = std::max(most, length(w.velocity[f][k]));
  }
  return most;
}

}  // namespace mpdem
