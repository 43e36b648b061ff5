// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "piece_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "../material/coulomb.h"
#include "../numerics/rotation.h"
#include "../parallel/gather_ranks.h"
#include "../parallel/ranks.h"

namespace mpdem {

namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

constexpr double kSupport = 1.5;     // H over the spacing
constexpr double kFullWeight = 1.0;  // sum of the weights above which all of the area is in contact; inside a surface it is about 2.3
constexpr double kSameFace = 0.8;    // normals with a larger product belong to one face of a wall

Vector3 vector(const double* v) { return {v[0], v[1], v[2]}; }

Matrix3 matrix_of(const double* q) {
  const Mat3<double> R = rotation_of(q);
  Matrix3 M;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) M(i, j) = R.a[i][j];
  return M;
}

// Cells of a regular grid with the spheres whose centres are in them.
class SphereGrid {
 public:
  explicit SphereGrid(double cell) : inverse_(1.0 / cell) {}
  void add(const Vector3& x, int index) { cells_[key(cell_of(x))].push_back(index); }
  // Calls f(index) for the spheres in the cell of x and the 26 around it.
  template <class F>
  void each_near(const Vector3& x, F f) const {
    const std::array<long, 3> c = cell_of(x);
    for (long i = -1; i <= 1; ++i)
      for (long j = -1; j <= 1; ++j)
        for (long k = -1; k <= 1; ++k) {
          const auto found = cells_.find(key({c[0] + i, c[1] + j, c[2] + k}));
          if (found == cells_.end()) continue;
          for (int index : found->second) f(index);
        }
  }

 private:
  std::array<long, 3> cell_of(const Vector3& x) const {
    return {std::lround(x[0] * inverse_), std::lround(x[1] * inverse_), std::lround(x[2] * inverse_)};
  }
  static std::uint64_t key(const std::array<long, 3>& c) {
    constexpr std::uint64_t kMask = (1u << 21) - 1;
    return (static_cast<std::uint64_t>(c[0]) & kMask) << 42 | (static_cast<std::uint64_t>(c[1]) & kMask) << 21 |
           (static_cast<std::uint64_t>(c[2]) & kMask);
  }
  double inverse_;
  std::unordered_map<std::uint64_t, std::vector<int>> cells_;
};

bool precedes(const CementPiece& a, const CementPiece& b) { return a.row != b.row ? a.row < b.row : a.side < b.side; }

}  // namespace

// A grain, the same on all ranks.
struct PieceContact::KnownBody {
  int tag, rank;
  double radius, x[3], q[4], to_box[3];
};

// Where a surface point touches: gap, normal out of the other body, area.
struct PieceContact::Touch {
  double gap = 0.0, area = 0.0;
  Vector3 n, at;                      // at: position of the contact
  Vector3 of_wall = Vector3::Zero();  // velocity of a wall there
  bool found = false;
  void set(double of_gap, double of_area, const Vector3& normal, const Vector3& p, double radius) {
    gap = of_gap, area = of_area, n = normal, at = p - normal * (radius + 0.5 * of_gap), found = true;
  }
};

void PieceContact::replace(const std::vector<int>& rows, std::vector<std::vector<CementPiece>> pieces) {
  const auto replaced = [&](int row) { return std::binary_search(rows.begin(), rows.end(), row); };
  // the groups refer to the pieces by their places, which change
  std::vector<KnownSlips> kept = std::move(kept_);
  kept_.clear();
  for (const KnownSlips& k : closed_slips()) kept.push_back(k);
  for (const KnownSlips& k : kept) {
    if (!replaced(k.id.row) && !(k.id.kind == kPiece && replaced(k.id.other))) {
      kept_.push_back(k);
      continue;
    }
    for (const CementPiece& p : pieces_)
      if (p.row == k.id.row && p.side == k.id.side)
        for (const Slip& slip : k.slips)
          dissipated_ += 0.5 * p.points[static_cast<std::size_t>(k.id.point)].area * p_.kt * vector(slip.e).squaredNorm();
  }
  groups_.clear();
  candidates_.clear();
  slips_.clear();
  loads_of_bonds_.clear();
  contacts_.clear();
  pieces_.erase(std::remove_if(pieces_.begin(), pieces_.end(), [&](const CementPiece& p) { return replaced(p.row); }), pieces_.end());
  for (std::vector<CementPiece>& of_row : pieces)
    for (CementPiece& p : of_row) pieces_.push_back(std::move(p));
  std::sort(pieces_.begin(), pieces_.end(), precedes);
}

bool PieceContact::may_touch(const CementPiece& a, const CementPiece& b) const {
  if (a.grain == b.grain) return false;
  return a.row != b.row || a.apart;
}

PieceContact::Id PieceContact::id_of(const Group& g, const Candidate& c) const {
  const CementPiece& a = pieces_[g.piece];
  if (g.kind == kPiece) return {a.row, a.side, c.point, g.kind, pieces_[g.other].row, pieces_[g.other].side};
  return {a.row, a.side, c.point, g.kind, g.other, 0};
}

std::vector<PieceContact::KnownSlips> PieceContact::closed_slips() const {
  std::vector<KnownSlips> closed;
  for (const Group& g : groups_)
    for (int i = g.begin; i < g.end; ++i) {
      KnownSlips k;
      std::copy(&slips_[candidates_[i].slip], &slips_[candidates_[i].slip] + kMostNormals, k.slips);
      if (std::none_of(k.slips, k.slips + kMostNormals, [](const Slip& s) { return s.closed; })) continue;
      k.id = id_of(g, candidates_[i]);
      closed.push_back(k);
    }
  return closed;
}

PieceContact::SlipsById PieceContact::slips_of_all(MPI_Comm comm) const {
  std::vector<KnownSlips> mine = closed_slips();
  mine.insert(mine.end(), kept_.begin(), kept_.end());
  SlipsById slips = restored_;
  for (const KnownSlips& k : gather_all(comm, mine)) std::copy(k.slips, k.slips + kMostNormals, slips[k.id].begin());
  return slips;
}

void PieceContact::take_motions(const std::vector<ContactBody>& bodies) {
  constexpr int kOfMotion = 14;
  buffer_.assign(kOfMotion * tags_.size(), 0.0);
  for (std::size_t n = 0; n < bodies.size(); ++n) {
    const ContactBody& b = bodies[n];
    double* to = &buffer_[static_cast<std::size_t>(kOfMotion) * motion_of_body_[n]];
    std::copy(b.x, b.x + 3, to);
    std::copy(b.v, b.v + 3, to + 3);
    std::copy(b.omega, b.omega + 3, to + 6);
    std::copy(b.q, b.q + 4, to + 9);
    to[13] = b.radius;
  }
  halo_.sum(buffer_.data(), kOfMotion);
  const double* from = buffer_.data();
  for (Motion& m : motions_) {
    m.x = vector(from);
    m.v = vector(from + 3);
    m.omega = vector(from + 6);
    m.R = matrix_of(from + 9);
    m.radius = from[13];
    m.force = m.torque = Vector3::Zero();
    from += kOfMotion;
  }
}

void PieceContact::search(MPI_Comm comm, const std::vector<ContactBody>& bodies, const WallFaces& walls, const NearestImage& nearest) {
  const SlipsById slips = slips_of_all(comm);
  restored_.clear();
  kept_.clear();
  groups_.clear();
  candidates_.clear();
  near_.clear();
  slips_.clear();
  loads_of_bonds_.clear();
  travel_ = path_of_walls_ = 0.0;
  const int me = rank_in(comm);
  std::vector<KnownBody> known;
  for (const ContactBody& b : bodies)
    known.push_back(
        {b.tag, me, b.radius, {b.x[0], b.x[1], b.x[2]}, {b.q[0], b.q[1], b.q[2], b.q[3]}, {b.to_box[0], b.to_box[1], b.to_box[2]}});
  known = gather_all(comm, known);
  std::sort(known.begin(), known.end(), [](const KnownBody& a, const KnownBody& b) { return a.tag < b.tag; });
  std::vector<Group> found = groups_near(known, me, walls, nearest);
  set_motions(comm, bodies, found);
  for (Group& g : found) {
    g.body = motion_of(g.body);
    if (g.other_body >= 0) g.other_body = motion_of(g.other_body);
    add_candidates(g, walls, p_.search_margin);
  }
  slips_.resize(kMostNormals * candidates_.size());
  for (const Group& g : groups_)
    for (int i = g.begin; i < g.end; ++i) {
      candidates_[i].slip = kMostNormals * i;
      const auto before = slips.find(id_of(g, candidates_[i]));
      if (before != slips.end()) std::copy(before->second.begin(), before->second.end(), &slips_[candidates_[i].slip]);
    }
  clear_overlaps(comm, walls);
  int mine = !groups_.empty(), any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, comm);
  any_ = any;
}

// Returns the pieces of this rank with all bodies near them. The groups have tags in place of indices of motions. known:
// ascending in tags.
std::vector<PieceContact::Group> PieceContact::groups_near(const std::vector<KnownBody>& known, int me, const WallFaces& walls,
                                                           const NearestImage& nearest) const {
  const auto body_of = [&](int tag) {
    const auto k = std::lower_bound(known.begin(), known.end(), tag, [](const KnownBody& b, int t) { return b.tag < t; });
    return k != known.end() && k->tag == tag ? static_cast<int>(k - known.begin()) : -1;
  };
  double largest = 0.0;
  for (const KnownBody& k : known) largest = std::max(largest, k.radius);
  std::vector<int> carrier;
  std::vector<Vector3> middles;
  for (const CementPiece& p : pieces_) {
    carrier.push_back(body_of(p.grain));
    largest = std::max(largest, p.reach);
    const int k = carrier.back();
    middles.push_back(k < 0 ? Vector3(Vector3::Zero()) : Vector3(vector(known[k].x) + matrix_of(known[k].q) * vector(p.middle)));
  }
  const double cell = 2.0 * largest + p_.search_margin;
  SphereGrid grains(cell), others(cell);
  for (std::size_t k = 0; k < known.size() && !nearest; ++k) grains.add(vector(known[k].x), static_cast<int>(k));
  for (std::size_t n = 0; n < pieces_.size() && !nearest; ++n)
    if (carrier[n] >= 0) others.add(middles[n], static_cast<int>(n));
  // In a periodic box, all pairs are compared.
  const auto each_near = [&](const SphereGrid& grid, std::size_t size, const Vector3& x, auto f) {
    if (!nearest) return grid.each_near(x, f);
    for (std::size_t i = 0; i < size; ++i) f(static_cast<int>(i));
  };
  const auto shift_to = [&](const Vector3& from, const Vector3& to) {
    Vector3 d = to - from;
    if (nearest) nearest(d.data());
    return Vector3(d - (to - from));
  };
  std::vector<Group> found;
  for (std::size_t n = 0; n < pieces_.size(); ++n) {
    const int k = carrier[n];
    if (k < 0 || known[k].rank != me) continue;
    const CementPiece& piece = pieces_[n];
    const auto add = [&](int kind, int other, int tag, const Vector3& x, double radius) {
      const Vector3 shift = shift_to(middles[n], x);
      if ((x + shift - middles[n]).norm() > radius + piece.reach + p_.search_margin) return;
      found.push_back({static_cast<int>(n), kind, other, piece.grain, tag, {shift[0], shift[1], shift[2]}, 0, 0, -1});
    };
    each_near(grains, known.size(), middles[n], [&](int i) {
      if (may_touch(piece, known[i].tag)) add(kGrain, known[i].tag, known[i].tag, vector(known[i].x), known[i].radius);
    });
    each_near(others, pieces_.size(), middles[n], [&](int i) {
      if (i > static_cast<int>(n) && carrier[i] >= 0 && may_touch(piece, pieces_[i]))
        add(kPiece, i, pieces_[i].grain, middles[i], pieces_[i].reach);
    });
    for (int w = 0; w < walls.walls(); ++w) {
      if (!walls.acts_on(w, piece.grain)) continue;
      const double* to = known[k].to_box;
      found.push_back({static_cast<int>(n), kWall, w, piece.grain, -1, {to[0], to[1], to[2]}, 0, 0, -1});
    }
  }
  std::sort(found.begin(), found.end(), [](const Group& a, const Group& b) {
    return std::array<int, 3>{a.piece, a.kind, a.other} < std::array<int, 3>{b.piece, b.kind, b.other};
  });
  return found;
}

int PieceContact::motion_of(int tag) const { return static_cast<int>(std::lower_bound(tags_.begin(), tags_.end(), tag) - tags_.begin()); }

// Collective. Finds the motions of the grains of this rank and of those in the groups.
void PieceContact::set_motions(MPI_Comm comm, const std::vector<ContactBody>& bodies, const std::vector<Group>& found) {
  tags_.clear();
  for (const ContactBody& b : bodies) tags_.push_back(b.tag);
  for (const Group& g : found)
    if (g.other_body >= 0) tags_.push_back(g.other_body);
  std::sort(tags_.begin(), tags_.end());
  tags_.erase(std::unique(tags_.begin(), tags_.end()), tags_.end());
  std::vector<Key> keys;
  for (int tag : tags_) keys.push_back({tag, 0, 0, 0});
  halo_.build(comm, keys);
  motions_.assign(tags_.size(), Motion());
  for (const CementPiece& p : pieces_) {
    const std::size_t m = static_cast<std::size_t>(motion_of(p.grain));
    if (m < tags_.size() && tags_[m] == p.grain) motions_[m].reach = std::max(motions_[m].reach, vector(p.middle).norm() + p.reach);
  }
  motion_of_body_.clear();
  for (const ContactBody& b : bodies) motion_of_body_.push_back(motion_of(b.tag));
  take_motions(bodies);
}

void PieceContact::add_candidates(Group g, const WallFaces& walls, double margin) {
  const CementPiece& piece = pieces_[g.piece];
  const Motion& a = motions_[g.body];
  g.begin = static_cast<int>(candidates_.size());
  std::vector<int> faces;
  if (g.kind == kWall) {
    const Vector3 middle = a.x + a.R * vector(piece.middle) + vector(g.shift);
    walls.faces_near(g.other, middle.data(), piece.reach + margin, faces);
    if (faces.empty()) return;
  }
  for (int i = 0; i < piece.size; ++i) {
    const SurfacePoint& s = piece.points[i];
    const Vector3 p = a.x + a.R * vector(s.X), m = a.R * vector(s.normal);
    Candidate c{i, static_cast<int>(near_.size()), 0, 0, 0.0};
    bool is_near = false;
    if (g.kind == kGrain) {
      const Motion& b = motions_[g.other_body];
      is_near = (p - b.x - vector(g.shift)).norm() < b.radius + s.radius + margin;
    } else if (g.kind == kPiece) {
      const Motion& b = motions_[g.other_body];
      const CementPiece& other = pieces_[g.other];
      const Vector3 y = b.R.transpose() * (p - b.x - vector(g.shift)), my = b.R.transpose() * m;
      const double far = (kSupport + 1.0) * other.spacing + std::max(s.radius, 0.0) + margin;
      constexpr double kFacing = 0.2;  // surfaces may turn between two searches
      for (int j = 0; j < other.size; ++j)
        if ((y - vector(other.points[j].X)).squaredNorm() < far * far && my.dot(vector(other.points[j].normal)) < kFacing)
          near_.push_back(j);
      is_near = static_cast<int>(near_.size()) > c.near_begin;
    } else {
      const Vector3 in_box = p + vector(g.shift);
      for (int f : faces)
        if (walls.nearest(g.other, f, in_box.data()).distance < s.radius + margin) near_.push_back(f);
      is_near = static_cast<int>(near_.size()) > c.near_begin;
    }
    if (!is_near) continue;
    c.near_end = static_cast<int>(near_.size());
    candidates_.push_back(c);
  }
  g.end = static_cast<int>(candidates_.size());
  if (g.end == g.begin) return;
  const bool within = g.kind == kPiece ? pieces_[g.other].row == piece.row : g.kind == kGrain && g.other == piece.other;
  if (within) {
    g.load = static_cast<int>(loads_of_bonds_.size());
    loads_of_bonds_.push_back({piece.row, {}});
  }
  groups_.push_back(g);
}

// The overlap of surfaces that are new is taken from the radius of their points.
void PieceContact::clear_overlaps(MPI_Comm comm, const WallFaces& walls) {
  std::vector<double> changed;  // piece, point, radius
  for (const Group& g : groups_) {
    const bool fresh = pieces_[g.piece].fresh || (g.kind == kPiece && pieces_[g.other].fresh);
    for (int i = g.begin; i < g.end && fresh; ++i) {
      double& radius = pieces_[g.piece].points[candidates_[i].point].radius;
      const double overlap = overlap_of(g, candidates_[i], walls);
      if (!(overlap > 0.0)) continue;
      radius -= overlap;
      for (double number : {static_cast<double>(g.piece), static_cast<double>(candidates_[i].point), radius}) changed.push_back(number);
    }
  }
  bool any_fresh = false;
  for (CementPiece& p : pieces_) {
    any_fresh = any_fresh || p.fresh;
    p.fresh = false;
  }
  if (!any_fresh) return;
  changed = gather_all(comm, changed);
  for (std::size_t n = 0; n < changed.size(); n += 3)
    pieces_[static_cast<std::size_t>(changed[n])].points[static_cast<std::size_t>(changed[n + 1])].radius = changed[n + 2];
}

double PieceContact::overlap_of(const Group& g, const Candidate& c, const WallFaces& walls) const {
  const Motion& a = motions_[g.body];
  const SurfacePoint& s = pieces_[g.piece].points[c.point];
  if (g.kind == kWall) {
    const Vector3 in_box = a.x + a.R * vector(s.X) + vector(g.shift);
    double most = 0.0;
    for (int f = c.near_begin; f < c.near_end; ++f)
      most = std::max(most, s.radius - walls.nearest(g.other, near_[f], in_box.data()).distance);
    return most;
  }
  const auto overlap = [&](const Motion& own, const Motion& other) {
    Touch t;
    const Vector3 at = own.x + own.R * vector(s.X);
    if (g.kind == kGrain) find_sphere(other, s, at, t);
    else find_surface(other, g, c, at, own.R * vector(s.normal), t);
    return t.found ? -t.gap : 0.0;
  };
  const double now = overlap(a, shifted(g));
  if (g.load < 0) return now;
  // Within a bond the surfaces also fit where the cement was made.
  const CementPiece& piece = pieces_[g.piece];
  Motion own, other;
  own.x = Vector3::Zero();
  own.R = Matrix3::Identity();
  other.x = vector(piece.other_at);
  other.R = matrix_of(piece.other_turned);
  other.radius = motions_[g.other_body].radius;
  return std::max(now, overlap(own, other));
}

PieceContact::Motion PieceContact::shifted(const Group& g) const {
  Motion b = motions_[g.other_body];
  b.x += vector(g.shift);
  return b;
}

// p: position of the point.
double PieceContact::find_sphere(const Motion& b, const SurfacePoint& s, const Vector3& p, Touch& t) const {
  const Vector3 from = p - b.x;
  const double size = from.norm(), gap = size - b.radius - s.radius;
  if (gap >= 0.0) return gap;
  t.set(gap, s.area, from / size, p, s.radius);
  return 0.0;
}

// m: normal of the point.
double PieceContact::find_surface(const Motion& b, const Group& g, const Candidate& c, const Vector3& p, const Vector3& m, Touch& t) const {
  const SurfacePoint& s = pieces_[g.piece].points[c.point];
  const CementPiece& other = pieces_[g.other];
  const Vector3 y = b.R.transpose() * (p - b.x), my = b.R.transpose() * m;
  const double support = kSupport * other.spacing, inverse = 1.0 / (support * support);
  double weight = 0.0, height = 0.0, far = std::numeric_limits<double>::infinity();
  Vector3 n = Vector3::Zero();
  for (int k = c.near_begin; k < c.near_end; ++k) {
    const SurfacePoint& q = other.points[near_[k]];
    const Vector3 nq = vector(q.normal), d = y - vector(q.X);
    const double square = d.squaredNorm(), facing = -my.dot(nq), h = d.dot(nq), left = 1.0 - (square - h * h) * inverse;
    far = std::min(far, square - (s.radius + q.radius) * std::fabs(s.radius + q.radius));
    if (facing <= 0.0 || left <= 0.0 || std::fabs(h) > 2.0 * other.spacing) continue;
    const double w = left * left * facing;
    weight += w;
    height += w * (h - q.radius);
    n += w * nq;
  }
  // Where the surfaces touch, a point is nearer than this by the support and by both radii.
  if (weight <= 0.0) return far > support * support ? std::sqrt(far) - support : 0.0;
  const double gap = height / weight - s.radius, size = n.norm();
  if (gap >= 0.0 || size <= 0.0) return far > support * support ? std::sqrt(far) - support : 0.0;
  t.set(gap, s.area * std::min(1.0, weight / kFullWeight), b.R * (n / size), p, s.radius);
  return 0.0;
}

double PieceContact::touch(const Group& g, const Candidate& c, double dt) {
  Motion& a = motions_[g.body];
  const SurfacePoint& point = pieces_[g.piece].points[c.point];
  const Vector3 p = a.x + a.R * vector(point.X);
  Touch t;
  const Motion b = shifted(g);
  const double clear = g.kind == kGrain ? find_sphere(b, point, p, t) : find_surface(b, g, c, p, a.R * vector(point.normal), t);
  Slip& s = slips_[c.slip];
  if (t.found) {
    add_force(g, s, t, dt, a, &motions_[g.other_body]);
  } else if (s.closed) {
    dissipated_ += 0.5 * point.area * p_.kt * vector(s.e).squaredNorm();
    s = Slip();
  }
  return clear;
}

void PieceContact::add_force(const Group& g, Slip& s, const Touch& t, double dt, Motion& a, Motion* b) {
  const CementPiece& piece = pieces_[g.piece];
  const Vector3 arm = t.at - a.x;
  Vector3 arm_of_other = Vector3::Zero(), v = a.v + a.omega.cross(arm) - t.of_wall;
  if (b) {
    arm_of_other = t.at - b->x - vector(g.shift);
    v -= b->v + b->omega.cross(arm_of_other);
  }
  Vector3 e = s.closed ? vector(s.e) : Vector3(Vector3::Zero());
  const double before = p_.kt * e.norm();
  if (s.closed) e += dt * (v - v.dot(t.n) * t.n);
  e -= e.dot(t.n) * t.n;
  const double most = p_.friction * p_.kn * -t.gap, size = p_.kt * e.norm(), share = sliding_share(most, size);
  dissipated_ += 0.5 * t.area * (before + std::min(most, size)) * share * e.norm();
  e *= 1.0 - share;
  const Vector3 f = t.area * (-p_.kn * t.gap * t.n - p_.kt * e);
  a.force += f;
  a.torque += arm.cross(f);
  if (b) {
    b->force -= f;
    b->torque -= arm_of_other.cross(f);
  }
  if (g.load >= 0) {
    double(*load)[6] = loads_of_bonds_[static_cast<std::size_t>(g.load)].load;
    const Vector3 moment = arm.cross(f), of_other = -arm_of_other.cross(f);
    for (int d = 0; d < 3; ++d) {
      load[piece.side][d] += f[d];
      load[piece.side][3 + d] += moment[d];
      load[1 - piece.side][d] -= f[d];
      load[1 - piece.side][3 + d] += of_other[d];
    }
  }
  stored_ += 0.5 * t.area * (p_.kn * t.gap * t.gap + p_.kt * e.squaredNorm());
  deepest_ = std::max(deepest_, -t.gap);
  ++touching_;
  std::copy(e.data(), e.data() + 3, s.e);
  std::copy(t.n.data(), t.n.data() + 3, s.n);
  s.closed = true;
  Contact c{piece.grain, b ? tags_[static_cast<std::size_t>(b - motions_.data())] : 0, {}, {}, {}};
  std::copy(f.data(), f.data() + 3, c.force);
  std::copy(arm.data(), arm.data() + 3, c.arm);
  std::copy(arm_of_other.data(), arm_of_other.data() + 3, c.arm_of_other);
  contacts_.push_back(c);
}

double PieceContact::touch_walls(const Group& g, const Candidate& c, WallFaces& walls, double dt) {
  Motion& a = motions_[g.body];
  const SurfacePoint& s = pieces_[g.piece].points[c.point];
  const Vector3 shift = vector(g.shift), p = a.x + a.R * vector(s.X) + shift;
  struct Found {
    Touch touch;
    int face;
  };
  std::array<Found, kMostNormals> found;  // the deepest first
  int count = 0;
  double clear = std::numeric_limits<double>::infinity();
  for (int k = c.near_begin; k < c.near_end; ++k) {
    const WallFaces::Nearest at = walls.nearest(g.other, near_[k], p.data());
    clear = std::min(clear, std::max(at.distance - s.radius, 0.0));
    if (!(at.distance < s.radius) || at.distance <= 0.0) continue;
    Found here;
    here.face = near_[k];
    here.touch.set(at.distance - s.radius, s.area, (p - vector(at.foot)) / at.distance, p, s.radius);
    here.touch.of_wall = vector(at.velocity);
    here.touch.at -= shift;
    // Faces that meet in a plane or at an edge that sticks out are touched once, where the overlap is the largest.
    int same = 0;
    while (same < count && found[same].touch.n.dot(here.touch.n) < kSameFace) ++same;
    if (same < count && found[same].touch.gap <= here.touch.gap) continue;
    if (same == kMostNormals) continue;
    count = std::max(count, same + 1);
    found[same] = here;
  }
  Slip* slips = &slips_[c.slip];
  std::array<Slip, kMostNormals> before;
  std::copy(slips, slips + kMostNormals, before.begin());
  std::fill(slips, slips + kMostNormals, Slip());
  for (int k = 0; k < count; ++k) {
    const auto known = std::find_if(before.begin(), before.end(),
                                    [&](const Slip& b) { return b.closed && vector(b.n).dot(found[k].touch.n) > kSameFace; });
    if (known != before.end()) {
      slips[k] = *known;
      known->closed = false;
    }
    const Vector3 force_before = a.force;
    add_force(g, slips[k], found[k].touch, dt, a, nullptr);
    const Vector3 on_wall = force_before - a.force;
    walls.add_force(g.other, found[k].face, pieces_[g.piece].grain, on_wall.data(), Vector3(found[k].touch.at + shift).data());
  }
  for (const Slip& b : before)
    if (b.closed) dissipated_ += 0.5 * s.area * p_.kt * vector(b.e).squaredNorm();
  return clear;
}

bool PieceContact::find_forces(MPI_Comm comm, std::vector<ContactBody>& bodies, WallFaces& walls, double dt) {
  stored_ = deepest_ = 0.0;
  touching_ = 0;
  contacts_.clear();
  for (LoadOfBond& l : loads_of_bonds_) l = {l.row, {}};
  constexpr double kMargin = 1.5;  // bodies may have been faster within the step
  const auto path = [&](const double* v, const double* omega, double reach) {
    return kMargin * dt * (vector(v).norm() + reach * vector(omega).norm());
  };
  double longest = kMargin * dt * walls.largest_speed();
  path_of_walls_ += longest;
  for (std::size_t n = 0; n < bodies.size(); ++n)
    longest = std::max(longest, path(bodies[n].v, bodies[n].omega, motions_[static_cast<std::size_t>(motion_of_body_[n])].reach));
  travel_ += longest;
  if (any_) {
    take_motions(bodies);
    for (Motion& m : motions_) m.path += path(m.v.data(), m.omega.data(), m.reach);
    for (Group& g : groups_) {
      const double since = motions_[g.body].path + (g.kind == kWall ? path_of_walls_ : motions_[g.other_body].path);
      if (dt > 0.0 && since < g.quiet_until) continue;
      g.quiet_until = std::numeric_limits<double>::infinity();
      for (int i = g.begin; i < g.end; ++i) {
        Candidate& c = candidates_[i];
        if (dt == 0.0 || since >= c.quiet_until) c.quiet_until = since + (g.kind == kWall ? touch_walls(g, c, walls, dt) : touch(g, c, dt));
        g.quiet_until = std::min(g.quiet_until, c.quiet_until);
      }
    }
    buffer_.resize(6 * motions_.size());
    for (std::size_t n = 0; n < motions_.size(); ++n)
      for (int d = 0; d < 3; ++d) {
        buffer_[6 * n + d] = motions_[n].force[d];
        buffer_[6 * n + 3 + d] = motions_[n].torque[d];
      }
    halo_.sum(buffer_.data(), 6);
  }
  for (std::size_t n = 0; n < bodies.size(); ++n)
    for (int d = 0; d < 3; ++d) {
      bodies[n].force[d] = any_ ? buffer_[6 * static_cast<std::size_t>(motion_of_body_[n]) + d] : 0.0;
      bodies[n].torque[d] = any_ ? buffer_[6 * static_cast<std::size_t>(motion_of_body_[n]) + 3 + d] : 0.0;
    }
  double farthest = travel_;
  if (ranks_of(comm) > 1) MPI_Allreduce(&travel_, &farthest, 1, MPI_DOUBLE, MPI_MAX, comm);
  travel_ = farthest;
  constexpr double kShare = 0.45;  // of the search margin; two bodies that approach each other travel twice that, and one step more
  return travel_ > kShare * p_.search_margin;
}

namespace {

struct ContactHead {
  double dissipated = 0.0;
  int pieces = 0, slips = 0;

  template <class Self, class Visitor>
  static constexpr void describe(Self& h, Visitor& visit) {
    visit("what contact of pieces dissipated", h.dissipated, kFinite);
    visit("the number of pieces", h.pieces, kCount);
    visit("the number of contacts of pieces", h.slips, kCount);
  }
};

}  // namespace

std::vector<double> PieceContact::packed(MPI_Comm comm) const {
  const SlipsById slips = slips_of_all(comm);
  ContactHead head;
  MPI_Allreduce(&dissipated_, &head.dissipated, 1, MPI_DOUBLE, MPI_SUM, comm);
  head.pieces = static_cast<int>(pieces_.size());
  head.slips = static_cast<int>(slips.size());
  std::vector<double> numbers;
  append(head, numbers);
  for (const CementPiece& p : pieces_) {
    append(p, numbers);
    for (const SurfacePoint& s : p.points) append(s, numbers);
  }
  for (const auto& s : slips) {
    KnownSlips k;
    k.id = s.first;
    std::copy(s.second.begin(), s.second.end(), k.slips);
    append(k, numbers);
  }
  return numbers;
}

void PieceContact::restore(RecordReader& in, bool first_rank) {
  ContactHead head;
  in.read(head);
  dissipated_ = first_rank ? head.dissipated : 0.0;
  for (int n = 0; n < head.pieces && in.trouble().empty(); ++n) {
    CementPiece p;
    in.read(p);
    for (int i = 0; i < p.size && in.trouble().empty(); ++i) {
      p.points.emplace_back();
      in.read(p.points.back());
    }
    if (p.points.empty()) continue;
    p.find_bounds();
    p.fresh = false;
    pieces_.push_back(std::move(p));
  }
  for (int n = 0; n < head.slips && in.trouble().empty(); ++n) {
    KnownSlips k;
    in.read(k);
    std::copy(k.slips, k.slips + kMostNormals, restored_[k.id].begin());
  }
}

std::size_t PieceContact::memory_usage() const {
  std::size_t bytes = groups_.capacity() * sizeof(Group) + candidates_.capacity() * sizeof(Candidate) + near_.capacity() * sizeof(int) +
                      slips_.capacity() * sizeof(Slip) + motions_.capacity() * sizeof(Motion) + buffer_.capacity() * sizeof(double);
  for (const CementPiece& p : pieces_) bytes += p.points.capacity() * sizeof(SurfacePoint);
  return bytes;
}

}  // namespace mpdem
