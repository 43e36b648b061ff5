// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "piece_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "../material/coulomb.h"
#include "../parallel/gather_ranks.h"
#include "../parallel/ranks.h"

namespace mpdem {

namespace {

using Vector3 = Eigen::Vector3d;

constexpr double kFullWeight = 1.0;  // sum of the weights above which all of the area is in contact; inside a surface it is about 2.3
constexpr double kSameFace = 0.8;    // normals with a larger product belong to one face of a wall

bool precedes(const CementPiece& a, const CementPiece& b) { return a.row != b.row ? a.row < b.row : a.side < b.side; }

}  // namespace

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
  // The groups refer to the pieces by their places, which change.
  std::vector<KnownSlips> kept = std::move(kept_);
  kept_.clear();
  for (const KnownSlips& k : list_.closed(pieces_)) kept.push_back(k);
  for (const KnownSlips& k : kept) {
    if (!replaced(k.id.row) && !(k.id.kind == kPiece && replaced(k.id.other))) {
      kept_.push_back(k);
      continue;
    }
    for (const CementPiece& p : pieces_)
      if (p.row == k.id.row && p.side == k.id.side)
        for (const ContactSlip& slip : k.slips)
          dissipated_ += 0.5 * p.points[static_cast<std::size_t>(k.id.point)].area * p_.kt * vector3(slip.e).squaredNorm();
  }
  list_.clear();
  loads_of_bonds_.clear();
  contacts_.clear();
  pieces_.erase(std::remove_if(pieces_.begin(), pieces_.end(), [&](const CementPiece& p) { return replaced(p.row); }), pieces_.end());
  for (std::vector<CementPiece>& of_row : pieces)
    for (CementPiece& p : of_row) pieces_.push_back(std::move(p));
  std::sort(pieces_.begin(), pieces_.end(), precedes);
  number_fragments();
}

// Gives fragments the tags of their bodies. A search takes these.
void PieceContact::number_fragments() {
  int n = 0;
  for (CementPiece& p : pieces_)
    if (p.is_loose()) p.grain = tag_of_fragment(n++);
}

SlipsById PieceContact::slips_of_all(MPI_Comm comm) const {
  std::vector<KnownSlips> mine = list_.closed(pieces_);
  mine.insert(mine.end(), kept_.begin(), kept_.end());
  SlipsById slips = restored_;
  for (const KnownSlips& k : gather_all(comm, mine)) std::copy(k.slips, k.slips + kMostNormals, slips[k.id].begin());
  return slips;
}

void PieceContact::search(MPI_Comm comm, const std::vector<ContactBody>& bodies, const WallFaces& walls, const NearestImage& nearest) {
  const SlipsById slips = slips_of_all(comm);
  restored_.clear();
  kept_.clear();
  travel_ = path_of_walls_ = 0.0;
  list_ = find_contacts(comm, pieces_, bodies, walls, nearest, p_.search_margin, motions_);
  list_.take_slips(pieces_, slips);
  loads_of_bonds_.clear();
  for (int row : list_.bonds) loads_of_bonds_.push_back({row, {}});
  clear_overlaps(comm, walls);
}

// The overlap of surfaces that are new is taken from the radius of their points.
void PieceContact::clear_overlaps(MPI_Comm comm, const WallFaces& walls) {
  std::vector<double> changed;  // piece, point, radius
  for (const ContactGroup& g : list_.groups) {
    const bool fresh = pieces_[g.piece].fresh || (g.kind == kPiece && pieces_[g.other].fresh);
    for (int i = g.begin; i < g.end && fresh; ++i) {
      double& radius = pieces_[g.piece].points[list_.candidates[i].point].radius;
      const double overlap = overlap_of(g, list_.candidates[i], walls);
      if (!(overlap > 0.0)) continue;
      radius -= overlap;
      for (double number : {static_cast<double>(g.piece), static_cast<double>(list_.candidates[i].point), radius})
        changed.push_back(number);
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

double PieceContact::overlap_of(const ContactGroup& g, const ContactCandidate& c, const WallFaces& walls) const {
  const BodyMotion& a = motions_[g.body];
  const SurfacePoint& s = pieces_[g.piece].points[c.point];
  if (g.kind == kWall) {
    const Vector3 in_box = a.x + a.R * vector3(s.X) + vector3(g.shift);
    double most = 0.0;
    for (int f = c.near_begin; f < c.near_end; ++f)
      most = std::max(most, s.radius - walls.nearest(g.other, list_.near[f], in_box.data()).distance);
    return most;
  }
  const auto overlap = [&](const BodyMotion& own, const BodyMotion& other) {
    Touch t;
    const Vector3 at = own.x + own.R * vector3(s.X);
    if (g.kind == kGrain) find_sphere(other, s, at, t);
    else find_surface(other, g, c, at, own.R * vector3(s.normal), t);
    return t.found ? -t.gap : 0.0;
  };
  const double now = overlap(a, shifted(g));
  const CementPiece& piece = pieces_[g.piece];
  if (g.load < 0 || piece.is_loose() || (g.kind == kPiece && pieces_[g.other].is_loose())) return now;
  // Within a bond the surfaces also fit where the cement was made.
  BodyMotion own, other;
  own.x = Vector3::Zero();
  own.R = Eigen::Matrix3d::Identity();
  other.x = vector3(piece.other_at);
  other.R = matrix_of(piece.other_turned);
  other.radius = motions_[g.other_body].radius;
  return std::max(now, overlap(own, other));
}

BodyMotion PieceContact::shifted(const ContactGroup& g) const {
  BodyMotion b = motions_[g.other_body];
  b.x += vector3(g.shift);
  return b;
}

// p: position of the point.
double PieceContact::find_sphere(const BodyMotion& b, const SurfacePoint& s, const Vector3& p, Touch& t) const {
  const Vector3 from = p - b.x;
  const double size = from.norm(), gap = size - b.radius - s.radius;
  if (gap >= 0.0) return gap;
  t.set(gap, s.area, from / size, p, s.radius);
  return 0.0;
}

// m: normal of the point.
double PieceContact::find_surface(const BodyMotion& b, const ContactGroup& g, const ContactCandidate& c, const Vector3& p, const Vector3& m,
                                  Touch& t) const {
  const SurfacePoint& s = pieces_[g.piece].points[c.point];
  const CementPiece& other = pieces_[g.other];
  const Vector3 y = b.R.transpose() * (p - b.x), my = b.R.transpose() * m;
  const double support = kSurfaceSupport * other.spacing, inverse = 1.0 / (support * support);
  double weight = 0.0, height = 0.0, far = std::numeric_limits<double>::infinity();
  Vector3 n = Vector3::Zero();
  for (int k = c.near_begin; k < c.near_end; ++k) {
    const SurfacePoint& q = other.points[list_.near[k]];
    const Vector3 nq = vector3(q.normal), d = y - vector3(q.X);
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

double PieceContact::touch(const ContactGroup& g, std::size_t candidate, double dt) {
  const ContactCandidate& c = list_.candidates[candidate];
  const BodyMotion& a = motions_[g.body];
  const SurfacePoint& point = pieces_[g.piece].points[c.point];
  const Vector3 p = a.x + a.R * vector3(point.X);
  Touch t;
  const BodyMotion b = shifted(g);
  const double clear = g.kind == kGrain ? find_sphere(b, point, p, t) : find_surface(b, g, c, p, a.R * vector3(point.normal), t);
  ContactSlip& s = *list_.slips_of(candidate);
  if (t.found) {
    add_force(g, s, t, dt);
  } else if (s.closed) {
    dissipated_ += 0.5 * point.area * p_.kt * vector3(s.e).squaredNorm();
    s = ContactSlip();
  }
  return clear;
}

// Side of the other body of a contact within a bond; 2 and more: a fragment.
int PieceContact::side_of_other(const CementPiece& piece, const ContactGroup& g) const {
  if (g.kind == kPiece) return pieces_[g.other].side;
  return piece.is_loose() ? g.other == piece.second : 1 - piece.side;
}

void PieceContact::add_force(const ContactGroup& g, ContactSlip& s, const Touch& t, double dt) {
  const CementPiece& piece = pieces_[g.piece];
  BodyMotion& a = motions_[g.body];
  BodyMotion* b = g.kind == kWall ? nullptr : &motions_[g.other_body];
  const Vector3 arm = t.at - a.x;
  Vector3 arm_of_other = Vector3::Zero(), v = a.v + a.omega.cross(arm) - t.of_wall;
  if (b) {
    arm_of_other = t.at - b->x - vector3(g.shift);
    v -= b->v + b->omega.cross(arm_of_other);
  }
  Vector3 e = s.closed ? vector3(s.e) : Vector3(Vector3::Zero());
  const double before = p_.kt * e.norm();
  if (s.closed && dt > 0.0) {  // at the start of a run the slip is that of these positions
    e += dt * (v - v.dot(t.n) * t.n);
    e -= e.dot(t.n) * t.n;
  }
  const double most = p_.friction * p_.kn * -t.gap, size = p_.kt * e.norm(), share = sliding_share(most, size);
  dissipated_ += 0.5 * t.area * (before + std::min(most, size)) * share * e.norm();
  e *= 1.0 - share;
  const Vector3 f = t.area * (-p_.kn * t.gap * t.n - p_.kt * e), moment = arm.cross(f), of_other = -arm_of_other.cross(f);
  a.force += f;
  a.torque += moment;
  if (b) {
    b->force -= f;
    b->torque += of_other;
  }
  if (g.load >= 0) {
    double(*load)[6] = loads_of_bonds_[static_cast<std::size_t>(g.load)].load;
    const int other = side_of_other(piece, g);
    for (int d = 0; d < 3 && !piece.is_loose(); ++d) {
      load[piece.side][d] += f[d];
      load[piece.side][3 + d] += moment[d];
    }
    for (int d = 0; d < 3 && other < 2; ++d) {
      load[other][d] -= f[d];
      load[other][3 + d] += of_other[d];
    }
  }
  stored_ += 0.5 * t.area * (p_.kn * t.gap * t.gap + p_.kt * e.squaredNorm());
  deepest_ = std::max(deepest_, -t.gap);
  std::copy(e.data(), e.data() + 3, s.e);
  std::copy(t.n.data(), t.n.data() + 3, s.n);
  s.closed = true;
  const auto grain_of = [](const CementPiece& p) { return p.is_loose() ? p.other : p.grain; };
  const int other = g.kind == kWall ? 0 : g.kind == kPiece ? grain_of(pieces_[g.other]) : motions_.tag_of(g.other_body);
  Contact c{grain_of(piece), other, {}, {}, {}};
  std::copy(f.data(), f.data() + 3, c.force);
  std::copy(arm.data(), arm.data() + 3, c.arm);
  std::copy(arm_of_other.data(), arm_of_other.data() + 3, c.arm_of_other);
  contacts_.push_back(c);
}

double PieceContact::touch_walls(const ContactGroup& g, std::size_t candidate, WallFaces& walls, double dt) {
  const ContactCandidate& c = list_.candidates[candidate];
  const BodyMotion& a = motions_[g.body];
  const SurfacePoint& s = pieces_[g.piece].points[c.point];
  const Vector3 shift = vector3(g.shift), p = a.x + a.R * vector3(s.X) + shift;
  struct Found {
    Touch touch;
    int face;
  };
  std::array<Found, kMostNormals> found;  // the deepest first
  int count = 0;
  double clear = std::numeric_limits<double>::infinity();
  for (int k = c.near_begin; k < c.near_end; ++k) {
    const WallFaces::Nearest at = walls.nearest(g.other, list_.near[k], p.data());
    clear = std::min(clear, std::max(at.distance - s.radius, 0.0));
    if (!(at.distance < s.radius) || at.distance <= 0.0) continue;
    Found here;
    here.face = list_.near[k];
    here.touch.set(at.distance - s.radius, s.area, (p - vector3(at.foot)) / at.distance, p, s.radius);
    here.touch.of_wall = vector3(at.velocity);
    here.touch.at -= shift;
    // Faces that meet in a plane or at an edge that sticks out are touched once, where the overlap is the largest.
    int same = 0;
    while (same < count && found[same].touch.n.dot(here.touch.n) < kSameFace) ++same;
    if (same < count && found[same].touch.gap <= here.touch.gap) continue;
    if (same == kMostNormals) continue;
    count = std::max(count, same + 1);
    found[same] = here;
  }
  ContactSlip* slips = list_.slips_of(candidate);
  std::array<ContactSlip, kMostNormals> before;
  std::copy(slips, slips + kMostNormals, before.begin());
  std::fill(slips, slips + kMostNormals, ContactSlip());
  for (int k = 0; k < count; ++k) {
    const auto known = std::find_if(before.begin(), before.end(),
                                    [&](const ContactSlip& b) { return b.closed && vector3(b.n).dot(found[k].touch.n) > kSameFace; });
    if (known != before.end()) {
      slips[k] = *known;
      known->closed = false;
    }
    const Vector3 force_before = a.force;
    add_force(g, slips[k], found[k].touch, dt);
    const Vector3 on_wall = force_before - a.force;
    walls.add_force(g.other, found[k].face, pieces_[g.piece].grain, on_wall.data(), Vector3(found[k].touch.at + shift).data());
  }
  for (const ContactSlip& b : before)
    if (b.closed) dissipated_ += 0.5 * s.area * p_.kt * vector3(b.e).squaredNorm();
  return clear;
}

namespace {

// Path in a step of what moves with that speed at its end. It may have been faster within the step.
double path_at(double speed, double dt) {
  constexpr double kMargin = 1.5;
  return kMargin * dt * speed;
}

// Longest path of a point of a body in a step.
double path_of(const double* v, const double* omega, double reach, double dt) {
  return path_at(vector3(v).norm() + reach * vector3(omega).norm(), dt);
}

}  // namespace

// Longest path of a body of this rank, or a wall, in a step.
double PieceContact::longest_path(const std::vector<ContactBody>& bodies, const WallFaces& walls, double dt) const {
  double longest = path_at(walls.largest_speed(), dt);
  for (std::size_t n = 0; n < bodies.size(); ++n)
    longest = std::max(longest, path_of(bodies[n].v, bodies[n].omega, motions_.of_body(n).reach, dt));
  return longest;
}

// Finds the forces of the candidates that may touch.
void PieceContact::examine(double dt, WallFaces& walls) {
  for (BodyMotion& m : motions_.all()) m.path += path_of(m.v.data(), m.omega.data(), m.reach, dt);
  for (ContactGroup& g : list_.groups) {
    const double since = motions_[g.body].path + (g.kind == kWall ? path_of_walls_ : motions_[g.other_body].path);
    if (dt > 0.0 && since < g.quiet_until) continue;
    g.quiet_until = std::numeric_limits<double>::infinity();
    for (int i = g.begin; i < g.end; ++i) {
      ContactCandidate& c = list_.candidates[i];
      const std::size_t n = static_cast<std::size_t>(i);
      if (dt == 0.0 || since >= c.quiet_until) c.quiet_until = since + (g.kind == kWall ? touch_walls(g, n, walls, dt) : touch(g, n, dt));
      g.quiet_until = std::min(g.quiet_until, c.quiet_until);
    }
  }
}

bool PieceContact::find_forces(MPI_Comm comm, std::vector<ContactBody>& bodies, WallFaces& walls, double dt) {
  stored_ = deepest_ = 0.0;
  contacts_.clear();
  for (LoadOfBond& l : loads_of_bonds_) l = {l.row, {}};
  path_of_walls_ += path_at(walls.largest_speed(), dt);
  travel_ += longest_path(bodies, walls, dt);
  if (list_.any) {
    motions_.take(bodies);
    examine(dt, walls);
    motions_.give_forces(bodies);
    deepest_so_far_ = std::max(deepest_so_far_, deepest_);
  } else {
    for (ContactBody& b : bodies)
      for (int d = 0; d < 3; ++d) b.force[d] = b.torque[d] = 0.0;
  }
  double farthest = travel_;
  if (ranks_of(comm) > 1) MPI_Allreduce(&travel_, &farthest, 1, MPI_DOUBLE, MPI_MAX, comm);
  travel_ = farthest;
  constexpr double kShare = 0.45;  // of the search margin; two bodies that approach each other travel twice that, and one step more
  return travel_ > kShare * p_.search_margin;
}

namespace {

// A node of a fragment, of the bond of the piece.
struct NodeOfPiece {
  int layer = 0, index[3] = {0, 0, 0};

  template <class Self, class Visitor>
  static constexpr void describe(Self& n, Visitor& visit) {
    visit("the layer of a node of a fragment", n.layer, from(0, kMaxLayers - 1));
    visit("the index of a node of a fragment", n.index, from(-Key::kFarthest, Key::kFarthest));
  }
};

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
    for (const Key& k : p.nodes) append(NodeOfPiece{layer_of_field(k.field()), {k.at(0), k.at(1), k.at(2)}}, numbers);
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
    for (int i = 0; i < p.held && in.trouble().empty(); ++i) {
      NodeOfPiece n;
      in.read(n);
      p.nodes.emplace_back(field_of(p.row, n.layer), n.index);
    }
    if (p.points.empty()) continue;
    p.find_bounds();
    p.fresh = false;
    pieces_.push_back(std::move(p));
  }
  number_fragments();
  for (int n = 0; n < head.slips && in.trouble().empty(); ++n) {
    KnownSlips k;
    in.read(k);
    std::copy(k.slips, k.slips + kMostNormals, restored_[k.id].begin());
  }
}

std::size_t PieceContact::memory_usage() const {
  std::size_t bytes = list_.memory_usage() + motions_.memory_usage() + contacts_.capacity() * sizeof(Contact) +
                      loads_of_bonds_.capacity() * sizeof(LoadOfBond) + (kept_.capacity() + restored_.size()) * sizeof(KnownSlips);
  for (const CementPiece& p : pieces_) bytes += p.points.capacity() * sizeof(SurfacePoint);
  return bytes;
}

}  // namespace mpdem
