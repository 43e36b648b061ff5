// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Points are chosen by reference positions alone, so the choice does not depend on the number of ranks.
#include "contact_remapping.h"

#include <array>
#include <map>

#include "../../coupling/debonded_contact.h"
#include "../../parallel/gather_ranks.h"

namespace mpdem {

namespace {

// The nearest intact points of one rank for an orphaned contact point: their number, and their common distance `far`.
struct Offer {
  int orphan, points;
  double far;
};

// Number of the nearest points over all ranks, and their distance.
struct Nearest {
  int points = 0;
  double far = 0.0;
};

}  // namespace

void open_contacts_of_files(Scene& scene) {
  if (!scene.touches()) return;
  for (Bond& b : scene.bonds().resolved())
    if (DebondedContact* contact = b.row >= scene.rows_started ? b.mechanism<DebondedContact>() : nullptr)
      contact->add_debonded_at_creation(b.points, scene.bonds().record(b), b.grid, scene.grains.ends_of(b));
}

std::vector<int> remap_contacts(Scene& scene) {
  if (!scene.contacts_move()) return {};
  struct OfBond {
    std::vector<DebondedContact::Arrival> arrivals;
    std::vector<std::array<int, 2>> gone;
  };
  std::map<int, OfBond> moves;
  std::vector<DebondedContact::OrphanedContact> abroad;  // contact points of bonds with points on other ranks
  for (Bond& b : scene.bonds().resolved()) {
    DebondedContact* contact = b.mechanism<DebondedContact>();
    if (!contact || !contact->take_topology_change()) continue;
    const bool whole = b.size() == scene.bonds().record(b).points;
    for (const DebondedContact::OrphanedContact& m : contact->orphans(b.points, scene.bonds().record(b))) {
      if (!whole) {
        abroad.push_back(m);
        continue;
      }
      const DebondedContact::Found f = DebondedContact::nearest(b.points, m);
      if (f.slots.empty()) continue;
      for (int slot : f.slots) moves[b.row].arrivals.push_back({m, slot, 1.0 / static_cast<double>(f.slots.size())});
      moves[b.row].gone.push_back({m.tag, m.grain});
    }
  }
  const std::vector<DebondedContact::OrphanedContact> all = gather_all(scene.comm, abroad);
  if (!all.empty()) {
    std::vector<Offer> mine;
    std::vector<DebondedContact::Found> found(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Bond* b = scene.bonds().find(all[i].row);
      if (b) found[i] = DebondedContact::nearest(b->points, all[i]);
      if (!found[i].slots.empty()) mine.push_back({static_cast<int>(i), static_cast<int>(found[i].slots.size()), found[i].far});
    }
    std::vector<Nearest> best(all.size());
    for (const Offer& o : gather_all(scene.comm, mine)) {
      Nearest& n = best[o.orphan];
      if (n.points == 0 || o.far < n.far) n = {o.points, o.far};
      else if (o.far == n.far) n.points += o.points;
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (best[i].points == 0 || !scene.bonds().find(all[i].row)) continue;
      OfBond& of_bond = moves[all[i].row];
      if (found[i].far == best[i].far)
        for (int slot : found[i].slots) of_bond.arrivals.push_back({all[i], slot, 1.0 / best[i].points});
      of_bond.gone.push_back({all[i].tag, all[i].grain});
    }
  }
  std::vector<int> moved;
  for (const auto& m : moves) {
    Bond& b = *scene.bonds().find(m.first);
    scene.energy.release(-b.mechanism<DebondedContact>()->move(b.points, scene.bonds().record(b), b.grid, scene.grains.ends_of(b),
                                                               m.second.arrivals, m.second.gone));
    moved.push_back(m.first);
  }
  return moved;
}

}  // namespace mpdem
