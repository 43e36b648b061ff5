// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A material point with its links, in the form in which it is sent to other ranks, written to restart files, and added
// to a store. PointStore (point_store.h) keeps the same values in blocks. Lengths are in the axes of the bond, from its
// origin.
#ifndef MPDEM_MPM_POINT_RECORD_H
#define MPDEM_MPM_POINT_RECORD_H

#include <string>
#include <vector>

#include "../material/law.h"
#include "../parallel/record.h"
#include "bond_record.h"

namespace mpdem {

// Numbers that a law of damage may keep for a point.
constexpr int kMostStateFields = Law::kMostFields;

// Numbers that a traction law may keep for a link, see coupling/traction_law.h.
constexpr int kMostLinkFields = 1;

// Link of a point to a grain. The foot point lies on the surface of the grain as it was when the bond was created. The
// reference position of the cement there is foot + moved.
struct Link {
  int slot = -1;  // slot of its point in a store
  int grain = 0;  // tag
  double foot[3] = {0, 0, 0};
  double area = 0;                // of the grain's surface
  bool attached = false;          // the link has not failed
  bool keeps_added_mass = false;  // the link has failed, but its added mass still counts, see coupling/penalty_links.h
  double moved[3] = {0, 0, 0};
  double state[kMostLinkFields] = {0};  // state of its traction law

  template <class Self, class Visitor>
  static constexpr void describe(Self& k, Visitor& visit) {
    visit.left_out(k.slot);
    visit("the grain of a link", k.grain, kCount);
    visit("the foot of a link", k.foot, kFinite);
    visit("the area of a link", k.area, kNotNegative);
    visit("'is attached' of a link", k.attached);
    visit("the displacement of a link", k.moved, kFinite);
    visit("'has added mass' of a link", k.keeps_added_mass);
    visit("the state of a link", k.state, from(0.0, 1.0));
  }
};

// A point of the debonded surface of a grain, together with the material that it may touch. A material point has at
// most one contact point for each grain, see coupling/debonded_contact.h.
struct ContactPoint {
  int slot = -1;                      // slot of its material point in a store
  int grain = 0;                      // tag
  double area = 0;                    // of the grain's surface
  double X[3] = {0, 0, 0};            // where the material is touched, reference coordinates
  double radius = 0;                  // distance from the centre of the grain at which it touches
  double stick_point[3] = {0, 0, 0};  // position at which friction has no force, in the frame of the grain
  double friction_traction = 0;       // traction of friction in the last step
  double added_mass_area = 0;         // area whose stiffness has added mass
  bool closed = false;                // touched in the last step

  template <class Self, class Visitor>
  static constexpr void describe(Self& p, Visitor& visit) {
    visit.left_out(p.slot);
    visit("the grain of a contact point", p.grain, kCount);
    visit("the area of a contact point", p.area, kNotNegative);
    visit("where a contact point is", p.X, kFinite);
    visit("the radius of a contact point", p.radius, kNotNegative);
    visit("where a contact point sticks", p.stick_point, kFinite);
    visit("friction of a contact point", p.friction_traction, kNotNegative);
    visit("area with added mass of a contact point", p.added_mass_area, kNotNegative);
    visit("'is closed' of a contact point", p.closed);
  }
};

// Bits of the grains to which a point is connected: bit 0 for the first grain of its bond, bit 1 for the second.
constexpr int kConnectedToBoth = 3;

struct PointRecord {
  static constexpr int kMaxLinks = 2;
  int row = 0, layer = 0;
  bool failed = false;
  bool split_checked = false;        // the nodes were split for it, see fracture/phantom_nodes.h
  int connected = kConnectedToBoth;  // bits of the grains to which it is connected, see BlockMeta
  int material = 0;                  // number of its material, see Law::of_material()
  bool film = false;                 // one point across the gap, with a link to each grain, see coupling/film.h
  bool has_frame = false;            // q was given; otherwise the fix sets it from its axis rule
  double X[3] = {0, 0, 0};
  double volume = 0;
  double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  double q[4] = {1, 0, 0, 0};
  double strain[6] = {0, 0, 0, 0, 0, 0};
  // State of a law of damage (material/law.h), and the number of that law (law_number() of material/laws.h). Number 0:
  // no law has read the state yet, which is then the damage tensor that a file gave.
  double damage[kMostStateFields] = {0, 0, 0, 0, 0, 0};
  int law = 0;
  bool moving = false;  // X0, v and C are set
  double X0[3] = {0, 0, 0}, v[3] = {0, 0, 0}, C[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
  int links = 0;
  Link link[kMaxLinks];
  int contacts = 0;
  ContactPoint contact[kMaxLinks];
  bool distorted = false;      // failed, and too distorted to have a crack that closes, see mpm/closing_points.h
  bool has_slip = false;       // slip is set
  double slip[3] = {0, 0, 0};  // slip of its closed crack, over the width of the crack, see mpm/closing_points.h

  // See parallel/record.h.
  template <class Self, class Visitor>
  static constexpr void describe(Self& p, Visitor& visit) {
    visit("its bond", p.row, kCount);
    visit("its layer", p.layer, from(0, kMaxLayers - 1));
    visit("'failed'", p.failed);
    visit("'was checked for splits'", p.split_checked);
    visit("'is connected to'", p.connected, from(0, kConnectedToBoth));
    visit("'is film'", p.film);
    visit("'has a frame'", p.has_frame);
    visit("its position", p.X, kFinite);
    visit("its volume", p.volume, kPositive);
    visit("its deformation", p.F, kFinite);
    visit.rotation("its frame", p.q);
    visit("its strain", p.strain, kFinite);
    visit("its damage", p.damage, kFinite);
    visit("the number of its law of damage", p.law, kCount);
    visit("'is moving'", p.moving);
    if (visit.present(p.moving)) {
      visit("its first position", p.X0, kFinite);
      visit("its velocity", p.v, kFinite);
      visit("its velocity gradient", p.C, kFinite);
    }
    const int n = visit.length("its number of links", p.links, kMaxLinks);
    for (int k = 0; k < n; ++k) visit.part(p.link[k]);
    const int freed = visit.length("its number of contact points", p.contacts, kMaxLinks);
    for (int k = 0; k < freed; ++k) visit.part(p.contact[k]);
    visit("'is distorted'", p.distorted);
    visit("the number of its material", p.material, from(0, kMostMaterials - 1));
    visit("'has slid'", p.has_slip);
    if (visit.present(p.has_slip)) visit("the slip of its crack", p.slip, kFinite);
  }
};

// Text of what is wrong with a point from a file that belongs to one of these bonds, or an empty string. The numbers of
// the point must be in their ranges.
std::string trouble_of(const PointRecord& point, const std::vector<BondRecord>& records);

}  // namespace mpdem

#endif
