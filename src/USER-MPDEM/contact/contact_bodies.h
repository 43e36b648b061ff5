// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The bodies that cement may touch: grains and fragments (ContactBody), and walls (WallFaces). BodyMotions has the motions
// of the bodies of this rank and of those of other ranks that their cement may touch, and sums the forces on them over the
// ranks.
#ifndef MPDEM_CONTACT_CONTACT_BODIES_H
#define MPDEM_CONTACT_CONTACT_BODIES_H

#include <mpi.h>

#include <Eigen/Dense>
#include <vector>

#include "../parallel/halo_sum.h"
#include "cement_surface.h"

namespace mpdem {

// A grain that this rank owns, with or without cement. x: unwrapped. q: orientation, the identity where it is not known,
// which only grains with cement need. Or a fragment: x is the place of the origin of its axes (cement_surface.h), v the
// velocity there, torque about x; its radius is 0.
struct ContactBody {
  int tag = 0;
  double radius = 0.0;
  double x[3] = {0, 0, 0}, v[3] = {0, 0, 0}, omega[3] = {0, 0, 0}, q[4] = {1, 0, 0, 0};
  double to_box[3] = {0, 0, 0};                        // from x to the position in the box, where walls are
  double force[3] = {0, 0, 0}, torque[3] = {0, 0, 0};  // result
};

// A plane face of a wall, or a part of a curved one, near this rank.
class WallFaces {
 public:
  virtual ~WallFaces() = default;
  struct Nearest {
    double foot[3];      // nearest point of the face
    double velocity[3];  // of the wall there
    double distance;     // from the face
  };
  virtual int walls() const = 0;
  // Does the wall act on the cement of that grain? Each acts on fragments, whose tag may stand in place of that of a grain.
  virtual bool acts_on(int wall, int grain) const = 0;
  // Numbers of the faces of a wall that may be nearer to x than `far`. Ascending.
  virtual void faces_near(int wall, const double* x, double far, std::vector<int>& faces) const = 0;
  virtual Nearest nearest(int wall, int face, const double* x) const = 0;
  // A force on the wall by the cement of a grain, at a position in the box.
  virtual void add_force(int wall, int face, int grain, const double* force, const double* at) = 0;
  virtual double largest_speed() const = 0;
};

struct BodyMotion {
  Eigen::Vector3d x, v, omega, force, torque;
  Eigen::Matrix3d R;
  double radius;
  double reach = 0.0, path = 0.0;  // of its pieces from its centre; longest path of one of their points since the search
};

class BodyMotions {
 public:
  // Collective. bodies: the grains of this rank. others: tags of those that their cement may touch, in any order. pieces:
  // of all ranks.
  void set(MPI_Comm comm, const std::vector<ContactBody>& bodies, const std::vector<int>& others, const std::vector<CementPiece>& pieces);
  // Collective. Takes the motions of the same bodies, and sets all forces to 0.
  void take(const std::vector<ContactBody>& bodies);
  // Collective. Gives the bodies their forces.
  void give_forces(std::vector<ContactBody>& bodies);

  int index_of(int tag) const;
  int tag_of(int index) const { return tags_[static_cast<std::size_t>(index)]; }
  BodyMotion& operator[](int index) { return motions_[static_cast<std::size_t>(index)]; }
  const BodyMotion& operator[](int index) const { return motions_[static_cast<std::size_t>(index)]; }
  const BodyMotion& of_body(std::size_t body) const { return motions_[static_cast<std::size_t>(of_body_[body])]; }  // body: of this rank
  std::vector<BodyMotion>& all() { return motions_; }
  std::size_t memory_usage() const { return motions_.capacity() * sizeof(BodyMotion) + buffer_.capacity() * sizeof(double); }

 private:
  std::vector<int> tags_;  // ascending
  std::vector<BodyMotion> motions_;
  std::vector<int> of_body_;  // index in motions_ of each body of this rank
  std::vector<double> buffer_;
  HaloSum halo_;
};

// Shorthands.
inline Eigen::Vector3d vector3(const double* v) { return {v[0], v[1], v[2]}; }
Eigen::Matrix3d matrix_of(const double* q);  // rotation of a quaternion

}  // namespace mpdem

#endif
