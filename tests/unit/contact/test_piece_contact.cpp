// SPDX-License-Identifier: GPL-2.0-or-later
// Contact of a flat piece of cement with a wall, a grain and another piece, against closed forms.
#include "../../../src/USER-MPDEM/contact/piece_contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "../../../src/USER-MPDEM/parallel/ranks.h"

namespace mpdem {
namespace {

using Vector3 = Eigen::Vector3d;

constexpr double kSpacing = 1e-4, kRadius = 1e-3, kHalf = 0.5 * kSpacing;
constexpr int kAlong = 6;
const ContactOfPieces kLaw{4e13, 3e13, 0.3, kSpacing};

// The plane z = height, which moves along x.
class Plane : public WallFaces {
 public:
  double height = 0.0, speed = 0.0, force[3] = {0, 0, 0};
  bool there = true;
  int walls() const override { return there; }
  bool acts_on(int, int) const override { return true; }
  void faces_near(int, const double* x, double far, std::vector<int>& faces) const override {
    faces.clear();
    if (std::fabs(x[2] - height) < far) faces.push_back(0);
  }
  Nearest nearest(int, int, const double* x) const override { return {{x[0], x[1], height}, {speed, 0.0, 0.0}, std::fabs(x[2] - height)}; }
  void add_force(int, int, int, const double* f, const double*) override {
    for (int d = 0; d < 3; ++d) force[d] += f[d];
  }
  double largest_speed() const override { return std::fabs(speed); }
};

constexpr double kArea = kAlong * kAlong * kSpacing * kSpacing, kTop = kRadius + kSpacing;  // the surface ends at kTop from the centre

// A square of points that faces down (`down` -1) or up from the centre of its grain, a spacing beyond its radius.
CementPiece square(int row, int side, int grain, int other, double down, bool apart = false, int along = kAlong) {
  CementPiece p;
  p.other_at[2] = down * 2.0 * kTop;
  p.row = row, p.side = side, p.grain = grain, p.other = other, p.apart = apart, p.spacing = kSpacing;
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < along; ++j) {
      SurfacePoint s;
      s.X[0] = kSpacing * (i - 0.5 * (along - 1)), s.X[1] = kSpacing * (j - 0.5 * (along - 1)), s.X[2] = down * (kRadius + kHalf);
      s.normal[2] = down;
      s.radius = kHalf, s.area = kSpacing * kSpacing;
      p.points.push_back(s);
    }
  p.find_bounds();
  return p;
}

ContactBody body(int tag, double z) {
  ContactBody b;
  b.tag = tag, b.radius = kRadius, b.x[2] = z;
  return b;
}

// Bodies of this rank: the first on rank 0, the others on the last.
std::vector<ContactBody> mine(const std::vector<ContactBody>& all) {
  std::vector<ContactBody> here;
  const int me = rank_in(MPI_COMM_WORLD), last = ranks_of(MPI_COMM_WORLD) - 1;
  for (std::size_t n = 0; n < all.size(); ++n)
    if ((n == 0 ? 0 : last) == me) here.push_back(all[n]);
  return here;
}

// Forces and torques of all bodies, on all ranks.
std::vector<ContactBody> forces(PieceContact& contact, Plane& wall, const std::vector<ContactBody>& all, double dt) {
  std::vector<ContactBody> here = mine(all);
  contact.find_forces(MPI_COMM_WORLD, here, wall, dt);
  std::vector<ContactBody> found(all);
  for (ContactBody& b : found) {
    double load[6] = {0, 0, 0, 0, 0, 0};
    for (const ContactBody& h : here)
      for (int d = 0; d < 3; ++d)
        if (h.tag == b.tag) load[d] = h.force[d], load[3 + d] = h.torque[d];
    MPI_Allreduce(MPI_IN_PLACE, load, 6, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    std::copy(load, load + 3, b.force);
    std::copy(load + 3, load + 6, b.torque);
  }
  return found;
}

double total(double of_rank) {
  double all;
  MPI_Allreduce(&of_rank, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return all;
}

// A piece above its partner of the same bond or of another, both with squares that face each other.
struct Facing {
  PieceContact contact;
  Plane wall;
  std::vector<ContactBody> bodies{body(1, 0.0), body(2, 2.0 * kTop + 1e-6)};
  explicit Facing(bool one_bond = false) {
    contact.set(kLaw);
    wall.there = false;
    if (one_bond) {
      contact.replace({0}, {{square(0, 0, 1, 2, 1.0, true), square(0, 1, 2, 1, -1.0, true)}});
    } else {
      contact.replace({0}, {{square(0, 0, 1, 7, 1.0)}});
      contact.replace({1}, {{square(1, 0, 2, 8, -1.0)}});
    }
    search();
  }
  void search() { contact.search(MPI_COMM_WORLD, mine(bodies), wall, nullptr); }
  std::vector<ContactBody> at(double overlap, double dt = 0.0) {
    bodies[1].x[2] = 2.0 * kTop - overlap;
    return forces(contact, wall, bodies, dt);
  }
  // The upper piece is pressed and moves along x. Returns the forces after the last step.
  std::vector<ContactBody> slide(int steps) {
    std::vector<ContactBody> f;
    bodies[1].v[0] = 1.0;
    for (int n = 0; n < steps; ++n) {
      bodies[1].x[0] += 1e-8;
      f = at(2e-6, 1e-8);
    }
    return f;
  }
};

TEST(PieceContact, OnAPlane) {
  PieceContact contact;
  Plane wall;
  contact.set(kLaw);
  contact.replace({0}, {{square(0, 0, 1, 7, -1.0)}});
  std::vector<ContactBody> bodies{body(1, kTop + 1e-6)};
  contact.search(MPI_COMM_WORLD, mine(bodies), wall, nullptr);
  EXPECT_EQ(forces(contact, wall, bodies, 0.0)[0].force[2], 0.0);
  bodies[0].x[2] = kTop - 2e-6;
  const std::vector<ContactBody> f = forces(contact, wall, bodies, 0.0);
  EXPECT_NEAR(f[0].force[2], kArea * kLaw.kn * 2e-6, 1e-9 * kArea * kLaw.kn * 2e-6);
  EXPECT_NEAR(total(wall.force[2]), -f[0].force[2], 1e-12);
  EXPECT_NEAR(total(contact.stored()), 0.5 * kArea * kLaw.kn * 4e-12, 1e-15);
}

TEST(PieceContact, OnAGrain) {
  PieceContact contact;
  Plane wall;
  wall.there = false;
  contact.set(kLaw);
  contact.replace({0}, {{square(0, 0, 1, 7, -1.0)}});
  std::vector<ContactBody> bodies{body(1, 0.0), body(2, -kTop - kRadius - 1e-6)};
  bodies[1].radius = kRadius;
  contact.search(MPI_COMM_WORLD, mine(bodies), wall, nullptr);
  bodies[1].x[2] += 6e-6;
  const std::vector<ContactBody> f = forces(contact, wall, bodies, 0.0);
  double expected = 0.0;
  for (const SurfacePoint& s : contact.pieces()[0].points) {
    const Vector3 d = Vector3(s.X[0], s.X[1], s.X[2]) - Vector3(0, 0, bodies[1].x[2]);
    const double overlap = kRadius + s.radius - d.norm();
    if (overlap > 0.0) expected += s.area * kLaw.kn * overlap * d[2] / d.norm();
  }
  EXPECT_GT(expected, 0.0);
  EXPECT_NEAR(f[0].force[2], expected, 1e-9 * expected);
  EXPECT_NEAR(f[1].force[2], -expected, 1e-9 * expected);
}

TEST(PieceContact, OnAnotherPiece) {
  for (bool one_bond : {false, true}) {
    Facing pair(one_bond);
    EXPECT_EQ(pair.at(-1e-7)[0].force[2], 0.0);
    const std::vector<ContactBody> f = pair.at(2e-6);
    EXPECT_NEAR(f[1].force[2], kArea * kLaw.kn * 2e-6, 1e-9 * kArea * kLaw.kn * 2e-6);
    EXPECT_NEAR(f[0].force[2], -f[1].force[2], 1e-12);
  }
}

// A bond that is not apart does not touch its own grains and cement.
TEST(PieceContact, WholeBondHasNoneOfItsOwn) {
  Facing pair;
  pair.contact.replace({0}, {{square(0, 0, 1, 2, 1.0), square(0, 1, 2, 1, -1.0)}});
  pair.contact.replace({1}, {{}});
  pair.search();
  EXPECT_EQ(pair.at(2e-6)[1].force[2], 0.0);
}

// The surface between the points is as high as at the points: a small face on a large one has the same force anywhere.
TEST(PieceContact, SurfaceBetweenPointsIsFlat) {
  Facing pair;
  pair.contact.replace({1}, {{square(1, 0, 2, 8, -1.0, false, 2 * kAlong)}});
  pair.search();
  for (int n = 0; n < 20; ++n) {
    pair.bodies[1].x[0] = 0.07 * n * kSpacing;
    pair.bodies[1].x[1] = 0.03 * n * kSpacing;
    EXPECT_NEAR(pair.at(2e-6)[1].force[2], kArea * kLaw.kn * 2e-6, 1e-9 * kArea * kLaw.kn * 2e-6);
  }
}

// The upper piece is pressed and moved along x: the force grows with the slip until it is mu times the normal force.
TEST(PieceContact, SticksAndSlips) {
  Facing pair;
  const double overlap = 2e-6, speed = 1.0, dt = 1e-8, normal = kArea * kLaw.kn * overlap;
  const double slip_at_limit = 0.3 * kLaw.kn * overlap / kLaw.kt;
  pair.at(overlap);
  pair.bodies[1].v[0] = speed;
  double slid = 0.0;
  for (int n = 1; n <= 200; ++n) {
    pair.bodies[1].x[0] += speed * dt;
    slid += speed * dt;
    const std::vector<ContactBody> f = pair.at(overlap, dt);
    const double expected = slid < slip_at_limit ? kArea * kLaw.kt * slid : 0.3 * normal;
    EXPECT_NEAR(f[1].force[0], -expected, 1e-6 * normal);
    EXPECT_NEAR(f[0].force[0], expected, 1e-6 * normal);
  }
  EXPECT_NEAR(total(pair.contact.dissipated()), 0.3 * normal * (slid - slip_at_limit), 1e-3 * 0.3 * normal * slid);
}

TEST(PieceContact, KeepsMomentumAndAngularMomentum) {
  Facing pair;
  pair.bodies[1].x[0] = 2.3e-5;
  pair.bodies[1].x[1] = -1.1e-4;
  pair.bodies[0].omega[1] = 300.0;
  pair.bodies[1].v[1] = 2.0;
  pair.at(3e-6);
  const std::vector<ContactBody> f = pair.at(3e-6, 1e-8);
  Vector3 force = Vector3::Zero(), moment = Vector3::Zero(), size = Vector3::Zero();
  for (const ContactBody& b : f) {
    const Vector3 x(b.x[0], b.x[1], b.x[2]), F(b.force[0], b.force[1], b.force[2]);
    force += F;
    moment += x.cross(F) + Vector3(b.torque[0], b.torque[1], b.torque[2]);
    size += F.cwiseAbs();
  }
  EXPECT_GT(std::fabs(f[0].force[0]), 1e-4 * size[2]);
  EXPECT_LT(force.norm(), 1e-13 * size.norm());
  EXPECT_LT(moment.norm(), 1e-12 * size.norm() * kTop);
}

// A surface that is made in contact has no force at first, and the usual one when it is pressed further.
TEST(PieceContact, NewSurfacesStartWithoutForce) {
  Facing pair;
  pair.at(4e-6);
  pair.contact.replace({1}, {{square(1, 0, 2, 8, -1.0)}});
  pair.search();
  EXPECT_NEAR(pair.at(4e-6)[1].force[2], 0.0, 1e-9 * kArea * kLaw.kn * 4e-6);
  EXPECT_NEAR(pair.at(5e-6)[1].force[2], kArea * kLaw.kn * 1e-6, 1e-6 * kArea * kLaw.kn * 1e-6);
}

// A search in between, and a restart, change nothing, not even the last bit.
TEST(PieceContact, SearchAndRestartChangeNothing) {
  Facing pair, searched, again;
  pair.slide(150);
  const std::vector<double> state = pair.contact.packed(MPI_COMM_WORLD);
  searched.slide(70);
  searched.search();
  searched.slide(80);
  PieceContact restored;
  restored.set(kLaw);
  RecordReader in(state.data(), state.data() + state.size());
  restored.restore(in, rank_in(MPI_COMM_WORLD) == 0);
  EXPECT_EQ(in.trouble(), "");
  EXPECT_TRUE(in.at_end());
  again.contact = std::move(restored);
  again.bodies = pair.bodies;
  again.search();
  const std::vector<ContactBody> a = pair.slide(50), b = searched.slide(50), c = again.slide(50);
  for (int d = 0; d < 3; ++d) {
    EXPECT_EQ(a[1].force[d], b[1].force[d]);
    EXPECT_EQ(a[1].force[d], c[1].force[d]);
  }
  EXPECT_DOUBLE_EQ(total(pair.contact.dissipated()), total(again.contact.dissipated()));
}

// A fragment below the piece of its bond at a grain: a body of its own, which counts to neither grain of the bond, and whose
// nodes are in a restart file.
TEST(PieceContact, FragmentIsABody) {
  PieceContact contact;
  Plane wall;
  wall.there = false;
  contact.set(kLaw);
  CementPiece fragment = square(0, 2, 0, 1, 1.0, true);
  fragment.second = 2;
  fragment.nodes = {Key(field_of(0, 3), -4, 5, 6), Key(field_of(0, 3), -4, 5, 7)};
  fragment.held = 2;
  contact.replace({0}, {{square(0, 1, 2, 1, -1.0, true), fragment}});
  const int tag = contact.pieces()[1].grain;
  EXPECT_TRUE(is_fragment(tag));
  EXPECT_FALSE(is_fragment(2));
  std::vector<ContactBody> bodies{body(tag, 0.0), body(2, 2.0 * kTop + 1e-6)};
  bodies[0].radius = 0.0;
  contact.search(MPI_COMM_WORLD, mine(bodies), wall, nullptr);
  bodies[1].x[2] = 2.0 * kTop - 2e-6;
  const std::vector<ContactBody> f = forces(contact, wall, bodies, 0.0);
  EXPECT_LT(f[0].force[2], -1.0);
  EXPECT_NEAR(f[0].force[2] + f[1].force[2], 0.0, 1e-12 * f[1].force[2]);
  double of_bond[2] = {0.0, 0.0};
  for (const PieceContact::LoadOfBond& l : contact.loads_of_bonds())
    for (int s = 0; s < 2; ++s) of_bond[s] += l.load[s][2];
  EXPECT_NEAR(total(of_bond[1]), f[1].force[2], 1e-12 * f[1].force[2]);
  EXPECT_EQ(total(of_bond[0]), 0.0);
  for (const PieceContact::Contact& c : contact.contacts()) EXPECT_EQ(c.grain + c.other, 1 + 2);
  const std::vector<double> state = contact.packed(MPI_COMM_WORLD);
  PieceContact restored;
  RecordReader in(state.data(), state.data() + state.size());
  restored.restore(in, true);
  EXPECT_EQ(in.trouble(), "");
  EXPECT_TRUE(in.at_end());
  EXPECT_EQ(restored.pieces()[1].nodes, fragment.nodes);
  EXPECT_EQ(restored.pieces()[1].grain, tag);
}

// Pieces of another bond that come or go change no contact of others, whatever their place in the list.
TEST(PieceContact, OtherPiecesChangeNothing) {
  Facing pair, other;
  for (Facing* p : {&pair, &other}) {
    p->contact.replace({1, 2}, {{}, {square(2, 0, 2, 8, -1.0)}});
    p->search();
  }
  pair.slide(70), other.slide(70);
  other.contact.replace({1}, {{square(1, 0, 5, 6, 1.0), square(1, 1, 6, 5, 1.0)}});
  other.search();
  pair.slide(20), other.slide(20);
  other.contact.replace({1}, {{}});
  other.search();
  const std::vector<ContactBody> a = pair.slide(20), b = other.slide(20);
  EXPECT_LT(a[1].force[0], -1.0);
  for (int d = 0; d < 3; ++d) EXPECT_EQ(a[1].force[d], b[1].force[d]);
}

// Faces of a bond that parted a little away fit where the cement was made: there they have no force.
TEST(PieceContact, PartedFacesFitWhereTheyWere) {
  PieceContact contact;
  Plane wall;
  wall.there = false;
  contact.set(kLaw);
  CementPiece thick = square(0, 0, 1, 2, 1.0, true);
  for (SurfacePoint& p : thick.points) p.radius += 3e-6;  // more than half of the spacing
  contact.replace({0}, {{thick, square(0, 1, 2, 1, -1.0, true)}});
  std::vector<ContactBody> bodies{body(1, 0.0), body(2, 2.0 * kTop + 5e-6)};
  contact.search(MPI_COMM_WORLD, mine(bodies), wall, nullptr);
  bodies[1].x[2] = 2.0 * kTop;
  EXPECT_NEAR(forces(contact, wall, bodies, 0.0)[1].force[2], 0.0, 1e-9);
  bodies[1].x[2] -= 1e-6;
  EXPECT_NEAR(forces(contact, wall, bodies, 0.0)[1].force[2], kArea * kLaw.kn * 1e-6, 1e-6 * kArea * kLaw.kn * 1e-6);
}

// A grain with cement falls on a wall and rebounds with the speed of its fall.
TEST(PieceContact, BounceKeepsEnergy) {
  PieceContact contact;
  Plane wall;
  contact.set(kLaw);
  contact.replace({0}, {{square(0, 0, 1, 7, -1.0)}});
  std::vector<ContactBody> bodies{body(1, kTop + 1e-6)};
  contact.search(MPI_COMM_WORLD, mine(bodies), wall, nullptr);
  const double mass = 1e-5, dt = 2e-9, speed = 0.1;
  bodies[0].v[2] = -speed;
  for (int n = 0; n < 20000 && bodies[0].x[2] < kTop + 2e-6; ++n) {
    bodies[0].x[2] += dt * bodies[0].v[2];
    bodies[0].v[2] += dt * forces(contact, wall, bodies, dt)[0].force[2] / mass;
  }
  EXPECT_NEAR(bodies[0].v[2], speed, 1e-4 * speed);
}

// Cement that is pressed by a wall that moves has a friction of mu times the normal force.
TEST(PieceContact, MovingWallRubs) {
  PieceContact contact;
  Plane wall;
  contact.set(kLaw);
  contact.replace({0}, {{square(0, 0, 1, 7, -1.0)}});
  std::vector<ContactBody> bodies{body(1, kTop + 1e-6)};
  contact.search(MPI_COMM_WORLD, mine(bodies), wall, nullptr);
  bodies[0].x[2] = kTop - 2e-6;
  wall.speed = 2.0;
  for (int n = 0; n < 200; ++n) forces(contact, wall, bodies, 1e-8);
  EXPECT_NEAR(forces(contact, wall, bodies, 1e-8)[0].force[0], 0.3 * kArea * kLaw.kn * 2e-6, 1e-9);
}

// Between two grains, in a periodic box, the nearest image counts.
TEST(PieceContact, NearestImage) {
  PieceContact contact;
  Plane wall;
  wall.there = false;
  contact.set(kLaw);
  contact.replace({0}, {{square(0, 0, 1, 7, 1.0)}});
  const double period = 0.02;
  std::vector<ContactBody> bodies{body(1, 0.0), body(2, kTop + kRadius - 3.0 * period + 1e-6)};
  contact.search(MPI_COMM_WORLD, mine(bodies), wall, [period](double* d) { d[2] -= period * std::nearbyint(d[2] / period); });
  bodies[1].x[2] -= 4e-6;
  EXPECT_LT(forces(contact, wall, bodies, 0.0)[0].force[2], -1e-6);
}

// The flat ring of a bond: points at the rim and, once apart, on the faces to the other grain are on its surface.
TEST(CementSurface, ExposesWhatIsNotCovered) {
  BondRecord record;
  record.grain[0] = 3, record.grain[1] = 5;
  record.radius[0] = record.radius[1] = kRadius;
  record.centre[0][2] = -kRadius - 2.0 * kSpacing, record.centre[1][2] = kRadius + 2.0 * kSpacing;
  record.spacing = kSpacing;
  record.points = 1;
  std::vector<PointOfCement> points;
  for (int i = -3; i < 3; ++i)
    for (int j = -3; j < 3; ++j)
      for (int k = -2; k < 2; ++k) {
        PointOfCement p;
        p.X[0] = (i + 0.5) * kSpacing, p.X[1] = (j + 0.5) * kSpacing, p.X[2] = (k + 0.5) * kSpacing;
        p.volume = std::pow(kSpacing, 3);
        p.side = k >= 0;
        p.tag = static_cast<int>(points.size());
        points.push_back(p);
      }
  const auto count = [&](bool apart) {
    std::size_t n = 0;
    for (const CementPiece& p : pieces_of(record, 0, points, apart)) n += p.points.size();
    return n;
  };
  EXPECT_GT(count(true), count(false));
  for (const CementPiece& p : pieces_of(record, 0, points, true)) {
    EXPECT_EQ(p.grain, p.side == 0 ? 3 : 5);
    // the face to the other piece, in axes fixed in the grain
    const double face = (p.side == 0 ? 1.0 : -1.0) * (kRadius + 1.5 * kSpacing);
    int inner = 0;
    for (const SurfacePoint& s : p.points)
      if (std::fabs(s.X[2] - face) < 1e-9 && std::fabs(s.X[0]) < 2.0 * kSpacing && std::fabs(s.X[1]) < 2.0 * kSpacing) {
        EXPECT_NEAR(s.normal[2], p.side == 0 ? 1.0 : -1.0, 1e-12);
        EXPECT_NEAR(s.radius, kHalf, 1e-12);
        ++inner;
      }
    EXPECT_EQ(inner, 16);
  }
}

}  // namespace
}  // namespace mpdem
