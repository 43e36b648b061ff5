// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Contact of cement with what is not bonded to it: other grains, walls, the cement of other bonds, and, once a bond is
// separated, its own two grains and pieces. The cement moves with its grains as rigid pieces (cement_surface.h). A
// surface point p of area A touches
//
//   a grain     a sphere: gap g = |p - c| - R - r, normal n = (p - c)/|p - c|, r the radius of the point
//   a wall      a plane, cylinder or triangle, with its nearest point in place of p - n (g + r)
//   a piece     the surface through the points q_j of the piece, interpolated by moving least squares (after R. Kolluri,
//               ACM Trans. Algorithms 4, 2008, no. 18): g = sum w_j ((p - q_j).n_j - r_j)/sum w_j - r, n along
//               sum w_j n_j, w_j = (1 - (l/H)^2)^2 max(0, -m.n_j) with l the distance across n_j, H = 1.5 spacings, m
//               the normal of p; A falls to zero with sum w_j where the surface ends
//
// and gets the force A (kn <-g> n - kt e). The body touched gets the opposite force at the same position, so momentum
// and angular momentum are kept. A fragment is a body of its own in place of the grain. e is the elastic slip: it grows with the relative velocity along the surface and is
// limited by Coulomb friction (material/coulomb.h). Stored energy is A (kn g^2 + kt e^2)/2.
//
// A surface that is made in contact has no force at first: the radii of its points are reduced by the overlap.
//
// Pieces are the same on all ranks. The rank that owns the grain of a piece finds its contacts. Candidates are searched
// again when bodies may have moved half of the search margin. A candidate with a gap is not examined before both bodies
// may have moved that far. Forces do not depend on when either is.
#ifndef MPDEM_CONTACT_PIECE_CONTACT_H
#define MPDEM_CONTACT_PIECE_CONTACT_H

#include <mpi.h>

#include <Eigen/Dense>
#include <vector>

#include "contact_list.h"

namespace mpdem {

struct ContactOfPieces {
  double kn = 0.0, kt = 0.0;  // pressure per length
  double friction = 0.0;
  double search_margin = 0.0;
};

class PieceContact {
 public:
  using Vector3 = Eigen::Vector3d;

  void set(const ContactOfPieces& parameters) { p_ = parameters; }
  // Replaces the pieces of these bonds (ascending). The same on all ranks. Their contacts end. Call search() before the
  // next step.
  void replace(const std::vector<int>& rows, std::vector<std::vector<CementPiece>> pieces);
  const std::vector<CementPiece>& pieces() const { return pieces_; }  // ascending in row and side

  // Collective. Finds the candidates for contact. bodies: the grains of this rank, in any order, the same as in later
  // calls until the next search.
  void search(MPI_Comm comm, const std::vector<ContactBody>& bodies, const WallFaces& walls, const NearestImage& nearest);
  // Collective. Finds the forces on the bodies. dt: length of the step that led to their positions, 0 at the start of a
  // run, when no slip is added. Returns true if search() is due before the next call.
  bool find_forces(MPI_Comm comm, std::vector<ContactBody>& bodies, WallFaces& walls, double dt);

  // Of this rank, at the last find_forces(). dissipated: by friction since the start, of this rank.
  double stored() const { return stored_; }
  double dissipated() const { return dissipated_; }
  double deepest() const { return deepest_; }
  int touching() const { return static_cast<int>(contacts_.size()); }
  double deepest_so_far() const { return deepest_so_far_; }  // of this rank, since the program started
  // A contact, for the sum of virials: force on the cement of the grain, its position from the centre of the grain, and
  // the same for the other body (tag 0: a wall). A fragment counts to a grain of its bond.
  struct Contact {
    int grain, other;
    double force[3], arm[3], arm_of_other[3];
  };
  const std::vector<Contact>& contacts() const { return contacts_; }
  // Forces and moments of contact within bonds that are apart, on both of their grains about their centres, of this rank.
  // Those on fragments are left out.
  struct LoadOfBond {
    int row;
    double load[2][6];
  };
  const std::vector<LoadOfBond>& loads_of_bonds() const { return loads_of_bonds_; }

  // Collective. State for a restart file, complete on all ranks. Restore it on all ranks, before search(). first_rank:
  // is this the rank that counts the sums of all?
  std::vector<double> packed(MPI_Comm comm) const;
  void restore(RecordReader& in, bool first_rank);
  std::size_t memory_usage() const;

 private:
  struct Touch;
  void number_fragments();
  SlipsById slips_of_all(MPI_Comm comm) const;
  // Return a distance by which the bodies have to move before they touch; 0 if they do.
  // b: the other body, with the shift of the group.
  double find_sphere(const BodyMotion& b, const SurfacePoint& s, const Vector3& p, Touch& t) const;
  double find_surface(const BodyMotion& b, const ContactGroup& g, const ContactCandidate& c, const Vector3& p, const Vector3& m,
                      Touch& t) const;
  BodyMotion shifted(const ContactGroup& g) const;
  double touch(const ContactGroup& g, std::size_t candidate, double dt);
  double touch_walls(const ContactGroup& g, std::size_t candidate, WallFaces& walls, double dt);
  double overlap_of(const ContactGroup& g, const ContactCandidate& c, const WallFaces& walls) const;
  void clear_overlaps(MPI_Comm comm, const WallFaces& walls);
  int side_of_other(const CementPiece& piece, const ContactGroup& g) const;
  void add_force(const ContactGroup& g, ContactSlip& s, const Touch& t, double dt);
  void examine(double dt, WallFaces& walls);
  double longest_path(const std::vector<ContactBody>& bodies, const WallFaces& walls, double dt) const;

  ContactOfPieces p_;
  std::vector<CementPiece> pieces_;
  SlipsById restored_;
  std::vector<KnownSlips> kept_;  // of this rank, since pieces were replaced
  ContactList list_;
  BodyMotions motions_;
  double travel_ = 0.0, path_of_walls_ = 0.0, stored_ = 0.0, dissipated_ = 0.0, deepest_ = 0.0, deepest_so_far_ = 0.0;
  std::vector<Contact> contacts_;
  std::vector<LoadOfBond> loads_of_bonds_;  // of list_.bonds
};

}  // namespace mpdem

#endif
