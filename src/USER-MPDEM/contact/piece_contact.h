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
// and angular momentum are kept. e is the elastic slip: it grows with the relative velocity along the surface and is
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
#include <array>
#include <functional>
#include <map>
#include <tuple>
#include <vector>

#include "../parallel/halo_sum.h"
#include "cement_surface.h"

namespace mpdem {

// A grain that this rank owns, with or without cement. x: unwrapped. q: orientation, the identity where it is not known,
// which only grains with cement need.
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
  // Does the wall act on the cement of that grain?
  virtual bool acts_on(int wall, int grain) const = 0;
  // Numbers of the faces of a wall that may be nearer to x than `far`. Ascending.
  virtual void faces_near(int wall, const double* x, double far, std::vector<int>& faces) const = 0;
  virtual Nearest nearest(int wall, int face, const double* x) const = 0;
  // A force on the wall by the cement of a grain, at a position in the box.
  virtual void add_force(int wall, int face, int grain, const double* force, const double* at) = 0;
  virtual double largest_speed() const = 0;
};

struct ContactOfPieces {
  double kn = 0.0, kt = 0.0;  // pressure per length
  double friction = 0.0;
  double search_margin = 0.0;
};

class PieceContact {
 public:
  using Vector3 = Eigen::Vector3d;
  // Shift that brings one body next to another in a periodic box: changes the difference of two positions.
  using NearestImage = std::function<void(double*)>;

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
  int touching() const { return touching_; }
  // A contact, for the sum of virials: force on the cement of the grain, its position from the centre of the grain, and
  // the same for the other body (tag 0: a wall).
  struct Contact {
    int grain, other;
    double force[3], arm[3], arm_of_other[3];
  };
  const std::vector<Contact>& contacts() const { return contacts_; }
  // Forces and moments of contact within bonds that are apart, on both of their grains about their centres, of this rank.
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
  enum Kind { kGrain, kPiece, kWall };
  static constexpr int kMostNormals = 3;  // faces of a wall that a point touches at once, in a corner
  struct Slip {
    double e[3] = {0, 0, 0}, n[3] = {0, 0, 0};  // n: of the last step, tells the faces of a wall apart
    bool closed = false;

    template <class Self, class Visitor>
    static constexpr void describe(Self& s, Visitor& visit) {
      visit("the elastic slip of a contact", s.e, kFinite);
      visit("the normal of a contact", s.n, kFinite);
      visit("'is closed' of a contact", s.closed);
    }
  };
  // The point of a contact and the other body: a grain by its tag, a piece by its bond and side, or a wall by its number.
  struct Id {
    int row = 0, side = 0, point = 0, kind = 0, other = 0, other_side = 0;
    bool operator<(const Id& b) const {
      return std::tie(row, side, point, kind, other, other_side) < std::tie(b.row, b.side, b.point, b.kind, b.other, b.other_side);
    }

    template <class Self, class Visitor>
    static constexpr void describe(Self& i, Visitor& visit) {
      visit("the bond of a contact", i.row, kCount);
      visit("the side of a contact", i.side, from(0, 1));
      visit("the surface point of a contact", i.point, kCount);
      visit("the kind of a contact", i.kind, from(kGrain, kWall));
      visit("the other body of a contact", i.other, kCount);
      visit("the other side of a contact", i.other_side, from(0, 1));
    }
  };
  struct KnownSlips {
    Id id;
    Slip slips[kMostNormals];

    template <class Self, class Visitor>
    static constexpr void describe(Self& k, Visitor& visit) {
      visit.part(k.id);
      for (auto& s : k.slips) visit.part(s);
    }
  };
  using SlipsById = std::map<Id, std::array<Slip, kMostNormals>>;
  // A point of the piece that may touch the other body.
  struct Candidate {
    int point;
    int near_begin, near_end;  // in near_: points of the other piece, or faces of the wall
    int slip;                  // first of its slips
    double quiet_until;        // path of both bodies since the search at which it may touch
  };
  // Candidates of one piece and one other body.
  struct Group {
    int piece, kind, other;  // other: tag of the grain, index of the piece, or number of the wall
    int body, other_body;    // indices in motions_; other_body is -1 for a wall
    double shift[3];         // added to the position of the other body; for a wall, to that of the piece
    int begin, end;          // candidates
    int load;                // index in loads_of_bonds_ of a contact within a bond, else -1
    double quiet_until = 0;  // the least of its candidates
  };
  struct Motion {
    Vector3 x, v, omega, force, torque;
    Eigen::Matrix3d R;
    double radius;
    double reach = 0.0, path = 0.0;  // of its pieces from its centre; longest path of one of their points since the search
  };
  struct Touch;
  struct KnownBody;
  Id id_of(const Group& g, const Candidate& c) const;
  std::vector<KnownSlips> closed_slips() const;  // of this rank
  SlipsById slips_of_all(MPI_Comm comm) const;
  void take_motions(const std::vector<ContactBody>& bodies);
  bool may_touch(const CementPiece& a, const CementPiece& b) const;
  bool may_touch(const CementPiece& a, int tag) const { return tag != a.grain && (tag != a.other || a.apart); }
  std::vector<Group> groups_near(const std::vector<KnownBody>& known, int me, const WallFaces& walls, const NearestImage& nearest) const;
  int motion_of(int tag) const;  // index in motions_
  void set_motions(MPI_Comm comm, const std::vector<ContactBody>& bodies, const std::vector<Group>& found);
  void add_candidates(Group g, const WallFaces& walls, double margin);
  // Return a distance by which the bodies have to move before they touch; 0 if they do.
  // b: the other body, with the shift of the group.
  double find_sphere(const Motion& b, const SurfacePoint& s, const Vector3& p, Touch& t) const;
  double find_surface(const Motion& b, const Group& g, const Candidate& c, const Vector3& p, const Vector3& m, Touch& t) const;
  Motion shifted(const Group& g) const;
  double touch(const Group& g, const Candidate& c, double dt);
  double overlap_of(const Group& g, const Candidate& c, const WallFaces& walls) const;
  void clear_overlaps(MPI_Comm comm, const WallFaces& walls);
  void add_force(const Group& g, Slip& s, const Touch& t, double dt, Motion& a, Motion* b);
  double touch_walls(const Group& g, const Candidate& c, WallFaces& walls, double dt);

  ContactOfPieces p_;
  std::vector<CementPiece> pieces_;
  SlipsById restored_;
  std::vector<KnownSlips> kept_;  // of this rank, since pieces were replaced
  std::vector<Group> groups_;
  std::vector<Candidate> candidates_;
  std::vector<int> near_;
  std::vector<Slip> slips_;
  std::vector<int> tags_;  // of motions_, ascending
  std::vector<Motion> motions_;
  std::vector<int> motion_of_body_;  // index in motions_ of each body of this rank
  std::vector<double> buffer_;
  HaloSum halo_;
  bool any_ = false;  // some rank has candidates
  double travel_ = 0.0, path_of_walls_ = 0.0, stored_ = 0.0, dissipated_ = 0.0, deepest_ = 0.0;
  int touching_ = 0;
  std::vector<Contact> contacts_;
  std::vector<LoadOfBond> loads_of_bonds_;
};

}  // namespace mpdem

#endif
