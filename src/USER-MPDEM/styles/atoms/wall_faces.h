// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The walls of a scene, each fix wall/gran, as faces that cement can touch: triangles of its meshes, or its plane or
// cylinder. Forces of the cement on a mesh are added to those that LIGGGHTS finds by grains, so that fix mesh/surface
// with stress or servo has them.
#ifndef MPDEM_STYLES_ATOMS_WALL_FACES_H
#define MPDEM_STYLES_ATOMS_WALL_FACES_H

#include <vector>

#include "../../contact/contact_bodies.h"
#include "lammps.h"

namespace LAMMPS_NS {
class FixMeshSurface;
class PrimitiveWall;
}  // namespace LAMMPS_NS

namespace mpdem {

class LiggghtsWalls : public WallFaces {
 public:
  explicit LiggghtsWalls(LAMMPS_NS::LAMMPS* lmp) : lmp_(lmp) {}
  // Finds the walls of the script, and the velocities of their meshes. Call it at the start of a run, and when LIGGGHTS
  // has exchanged atoms and triangles.
  void find();

  int walls() const override { return static_cast<int>(walls_.size()); }
  bool acts_on(int wall, int grain) const override;
  void faces_near(int wall, const double* x, double far, std::vector<int>& faces) const override;
  Nearest nearest(int wall, int face, const double* x) const override;
  void add_force(int wall, int face, int grain, const double* force, const double* at) override;
  double largest_speed() const override;
  bool any_mesh() const;

 private:
  struct Wall {
    LAMMPS_NS::FixMeshSurface* mesh;  // null: a primitive wall
    LAMMPS_NS::PrimitiveWall* primitive;
    int group;           // bit of its group
    double shear[3];     // velocity of a primitive wall, along itself
    double*** velocity;  // velocity by triangle and corner; null for a mesh at rest
  };
  // Corners of a triangle, and their velocities, null for a mesh at rest.
  struct Triangle {
    double corner[3][3];
    double** velocity;
  };
  Triangle triangle(const Wall& w, int face) const;
  int any_atom() const;

  LAMMPS_NS::LAMMPS* lmp_;
  std::vector<Wall> walls_;
};

}  // namespace mpdem

#endif
