// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Which surface points of the cement of this rank may touch which bodies (find_contacts()), and the elastic slips of
// contacts, which outlive a search and a restart.
#ifndef MPDEM_CONTACT_CONTACT_LIST_H
#define MPDEM_CONTACT_CONTACT_LIST_H

#include <array>
#include <functional>
#include <map>
#include <tuple>
#include <vector>

#include "contact_bodies.h"

namespace mpdem {

enum ContactKind { kGrain, kPiece, kWall };
constexpr int kMostNormals = 3;  // faces of a wall that a point touches at once, in a corner

struct ContactSlip {
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
struct ContactId {
  int row = 0, side = 0, point = 0, kind = 0, other = 0, other_side = 0;
  bool operator<(const ContactId& b) const {
    return std::tie(row, side, point, kind, other, other_side) < std::tie(b.row, b.side, b.point, b.kind, b.other, b.other_side);
  }

  template <class Self, class Visitor>
  static constexpr void describe(Self& i, Visitor& visit) {
    visit("the bond of a contact", i.row, kCount);
    visit("the side of a contact", i.side, kCount);
    visit("the surface point of a contact", i.point, kCount);
    visit("the kind of a contact", i.kind, from(kGrain, kWall));
    visit("the other body of a contact", i.other, kCount);
    visit("the other side of a contact", i.other_side, kCount);
  }
};
struct KnownSlips {
  ContactId id;
  ContactSlip slips[kMostNormals];

  template <class Self, class Visitor>
  static constexpr void describe(Self& k, Visitor& visit) {
    visit.part(k.id);
    for (auto& s : k.slips) visit.part(s);
  }
};
using SlipsById = std::map<ContactId, std::array<ContactSlip, kMostNormals>>;

// A point of the piece that may touch the other body.
struct ContactCandidate {
  int point;
  int near_begin, near_end;  // in ContactList::near: points of the other piece, or faces of the wall
  double quiet_until;        // path of both bodies since the search at which it may touch
};

// Candidates of one piece and one other body.
struct ContactGroup {
  int piece, kind, other;  // other: tag of the grain, index of the piece, or number of the wall
  int body, other_body;    // indices in the motions; other_body is -1 for a wall
  double shift[3];         // added to the position of the other body; for a wall, to that of the piece
  int begin, end;          // candidates
  int load;                // number of the pair of pieces of a bond, or of piece and grain, in ContactList::bonds; else -1
  double quiet_until = 0;  // the least of its candidates
};

struct ContactList {
  std::vector<ContactGroup> groups;
  std::vector<ContactCandidate> candidates;
  std::vector<int> near;
  std::vector<ContactSlip> slips;  // kMostNormals of each candidate
  std::vector<int> bonds;          // rows of groups within a bond that is separated
  bool any = false;                // some rank has candidates

  void clear() { *this = ContactList(); }
  ContactSlip* slips_of(std::size_t candidate) { return &slips[kMostNormals * candidate]; }
  // Slips of contacts that are closed.
  std::vector<KnownSlips> closed(const std::vector<CementPiece>& pieces) const;
  // Takes the slips of contacts that it has.
  void take_slips(const std::vector<CementPiece>& pieces, const SlipsById& known);
  std::size_t memory_usage() const;
};

// Shift that brings one body next to another in a periodic box: changes the difference of two positions.
using NearestImage = std::function<void(double*)>;

// Collective. Finds the contacts of the pieces on the grains of this rank that may close before bodies have moved half of
// the margin. Sets the motions. pieces: the same on all ranks. Slips are 0.
ContactList find_contacts(MPI_Comm comm, const std::vector<CementPiece>& pieces, const std::vector<ContactBody>& bodies,
                          const WallFaces& walls, const NearestImage& nearest, double margin, BodyMotions& motions);

// Distance along a surface, over the spacing, at which its points have no weight, see piece_contact.h.
constexpr double kSurfaceSupport = 1.5;

}  // namespace mpdem

#endif
