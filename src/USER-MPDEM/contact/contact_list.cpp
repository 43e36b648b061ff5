// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "contact_list.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "../parallel/gather_ranks.h"
#include "../parallel/ranks.h"

namespace mpdem {

namespace {

using Vector3 = Eigen::Vector3d;

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

// A grain, the same on all ranks.
struct KnownBody {
  int tag, rank;
  double radius, x[3], q[4], to_box[3];
};

bool may_touch(const CementPiece& a, const CementPiece& b) { return a.grain != b.grain && (a.row != b.row || a.apart); }
// tag: of a grain. A fragment is touched as a piece.
bool may_touch(const CementPiece& a, int tag) { return tag != a.grain && (tag != a.other || a.apart) && !is_fragment(tag); }

// Returns the pieces of this rank with all bodies near them. The groups have tags in place of indices of motions. known:
// ascending in tags.
std::vector<ContactGroup> groups_near(const std::vector<CementPiece>& pieces, const std::vector<KnownBody>& known, int me,
                                      const WallFaces& walls, const NearestImage& nearest, double margin) {
  const auto body_of = [&](int tag) {
    const auto k = std::lower_bound(known.begin(), known.end(), tag, [](const KnownBody& b, int t) { return b.tag < t; });
    return k != known.end() && k->tag == tag ? static_cast<int>(k - known.begin()) : -1;
  };
  double largest = 0.0;
  for (const KnownBody& k : known) largest = std::max(largest, k.radius);
  std::vector<int> carrier;
  std::vector<Vector3> middles;
  for (const CementPiece& p : pieces) {
    carrier.push_back(body_of(p.grain));
    largest = std::max(largest, p.reach);
    const int k = carrier.back();
    middles.push_back(k < 0 ? Vector3(Vector3::Zero()) : Vector3(vector3(known[k].x) + matrix_of(known[k].q) * vector3(p.middle)));
  }
  const double cell = 2.0 * largest + margin;
  SphereGrid grains(cell), others(cell);
  for (std::size_t k = 0; k < known.size() && !nearest; ++k) grains.add(vector3(known[k].x), static_cast<int>(k));
  for (std::size_t n = 0; n < pieces.size() && !nearest; ++n)
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
  std::vector<ContactGroup> found;
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    const int k = carrier[n];
    if (k < 0 || known[k].rank != me) continue;
    const CementPiece& piece = pieces[n];
    const auto add = [&](int kind, int other, int tag, const Vector3& x, double radius) {
      const Vector3 shift = shift_to(middles[n], x);
      if ((x + shift - middles[n]).norm() > radius + piece.reach + margin) return;
      found.push_back({static_cast<int>(n), kind, other, piece.grain, tag, {shift[0], shift[1], shift[2]}, 0, 0, -1});
    };
    each_near(grains, known.size(), middles[n], [&](int i) {
      if (may_touch(piece, known[i].tag)) add(kGrain, known[i].tag, known[i].tag, vector3(known[i].x), known[i].radius);
    });
    each_near(others, pieces.size(), middles[n], [&](int i) {
      if (i > static_cast<int>(n) && carrier[i] >= 0 && may_touch(piece, pieces[i]))
        add(kPiece, i, pieces[i].grain, middles[i], pieces[i].reach);
    });
    for (int w = 0; w < walls.walls(); ++w) {
      if (!walls.acts_on(w, piece.grain)) continue;
      const double* to = known[k].to_box;
      found.push_back({static_cast<int>(n), kWall, w, piece.grain, -1, {to[0], to[1], to[2]}, 0, 0, -1});
    }
  }
  std::sort(found.begin(), found.end(), [](const ContactGroup& a, const ContactGroup& b) {
    return std::array<int, 3>{a.piece, a.kind, a.other} < std::array<int, 3>{b.piece, b.kind, b.other};
  });
  return found;
}

void add_candidates(ContactGroup g, const std::vector<CementPiece>& pieces, const BodyMotions& motions, const WallFaces& walls,
                    double margin, ContactList& list) {
  const CementPiece& piece = pieces[g.piece];
  const BodyMotion& a = motions[g.body];
  g.begin = static_cast<int>(list.candidates.size());
  std::vector<int> faces;
  if (g.kind == kWall) {
    const Vector3 middle = a.x + a.R * vector3(piece.middle) + vector3(g.shift);
    walls.faces_near(g.other, middle.data(), piece.reach + margin, faces);
    if (faces.empty()) return;
  }
  for (int i = 0; i < piece.size; ++i) {
    const SurfacePoint& s = piece.points[i];
    const Vector3 p = a.x + a.R * vector3(s.X), m = a.R * vector3(s.normal);
    ContactCandidate c{i, static_cast<int>(list.near.size()), 0, 0.0};
    bool is_near = false;
    if (g.kind == kGrain) {
      const BodyMotion& b = motions[g.other_body];
      is_near = (p - b.x - vector3(g.shift)).norm() < b.radius + s.radius + margin;
    } else if (g.kind == kPiece) {
      const BodyMotion& b = motions[g.other_body];
      const CementPiece& other = pieces[g.other];
      const Vector3 y = b.R.transpose() * (p - b.x - vector3(g.shift)), my = b.R.transpose() * m;
      const double far = (kSurfaceSupport + 1.0) * other.spacing + std::max(s.radius, 0.0) + margin;
      constexpr double kFacing = 0.2;  // surfaces may turn between two searches
      for (int j = 0; j < other.size; ++j)
        if ((y - vector3(other.points[j].X)).squaredNorm() < far * far && my.dot(vector3(other.points[j].normal)) < kFacing)
          list.near.push_back(j);
      is_near = static_cast<int>(list.near.size()) > c.near_begin;
    } else {
      const Vector3 in_box = p + vector3(g.shift);
      for (int f : faces)
        if (walls.nearest(g.other, f, in_box.data()).distance < s.radius + margin) list.near.push_back(f);
      is_near = static_cast<int>(list.near.size()) > c.near_begin;
    }
    if (!is_near) continue;
    c.near_end = static_cast<int>(list.near.size());
    list.candidates.push_back(c);
  }
  g.end = static_cast<int>(list.candidates.size());
  if (g.end == g.begin) return;
  const bool within = g.kind == kPiece ? pieces[g.other].row == piece.row : g.kind == kGrain && piece.is_bonded_to(g.other);
  if (within) {
    g.load = static_cast<int>(list.bonds.size());
    list.bonds.push_back(piece.row);
  }
  list.groups.push_back(g);
}

ContactId id_of(const std::vector<CementPiece>& pieces, const ContactGroup& g, const ContactCandidate& c) {
  const CementPiece& a = pieces[g.piece];
  if (g.kind == kPiece) return {a.row, a.side, c.point, g.kind, pieces[g.other].row, pieces[g.other].side};
  return {a.row, a.side, c.point, g.kind, g.other, 0};
}

}  // namespace

ContactList find_contacts(MPI_Comm comm, const std::vector<CementPiece>& pieces, const std::vector<ContactBody>& bodies,
                          const WallFaces& walls, const NearestImage& nearest, double margin, BodyMotions& motions) {
  const int me = rank_in(comm);
  std::vector<KnownBody> known;
  for (const ContactBody& b : bodies)
    known.push_back(
        {b.tag, me, b.radius, {b.x[0], b.x[1], b.x[2]}, {b.q[0], b.q[1], b.q[2], b.q[3]}, {b.to_box[0], b.to_box[1], b.to_box[2]}});
  known = gather_all(comm, known);
  std::sort(known.begin(), known.end(), [](const KnownBody& a, const KnownBody& b) { return a.tag < b.tag; });
  std::vector<ContactGroup> found = groups_near(pieces, known, me, walls, nearest, margin);
  std::vector<int> others;
  for (const ContactGroup& g : found)
    if (g.other_body >= 0) others.push_back(g.other_body);
  motions.set(comm, bodies, others, pieces);
  ContactList list;
  for (ContactGroup& g : found) {
    g.body = motions.index_of(g.body);
    if (g.other_body >= 0) g.other_body = motions.index_of(g.other_body);
    add_candidates(g, pieces, motions, walls, margin, list);
  }
  list.slips.resize(kMostNormals * list.candidates.size());
  int mine = !list.groups.empty(), any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, comm);
  list.any = any != 0;
  return list;
}

std::vector<KnownSlips> ContactList::closed(const std::vector<CementPiece>& pieces) const {
  std::vector<KnownSlips> closed;
  for (const ContactGroup& g : groups)
    for (int i = g.begin; i < g.end; ++i) {
      KnownSlips k;
      const ContactSlip* of_candidate = &slips[static_cast<std::size_t>(kMostNormals) * i];
      std::copy(of_candidate, of_candidate + kMostNormals, k.slips);
      if (std::none_of(k.slips, k.slips + kMostNormals, [](const ContactSlip& s) { return s.closed; })) continue;
      k.id = id_of(pieces, g, candidates[i]);
      closed.push_back(k);
    }
  return closed;
}

void ContactList::take_slips(const std::vector<CementPiece>& pieces, const SlipsById& known) {
  for (const ContactGroup& g : groups)
    for (int i = g.begin; i < g.end; ++i) {
      const auto before = known.find(id_of(pieces, g, candidates[i]));
      if (before != known.end()) std::copy(before->second.begin(), before->second.end(), slips_of(static_cast<std::size_t>(i)));
    }
}

std::size_t ContactList::memory_usage() const {
  return groups.capacity() * sizeof(ContactGroup) + candidates.capacity() * sizeof(ContactCandidate) +
         (near.capacity() + bonds.capacity()) * sizeof(int) + slips.capacity() * sizeof(ContactSlip);
}

}  // namespace mpdem
