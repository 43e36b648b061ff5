// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Places go on to points that are chosen by places of the reference alone. So all ranks together choose as one rank
// does.
#include "places.h"

#include <array>
#include <map>

#include "../coupling/freed_places.h"
#include "../parallel/gather_ranks.h"

namespace mpdem {

namespace {

// The nearest points that a rank has for a mover.
struct Offer {
  int mover, points;
  double far;
};

// The nearest points of all ranks.
struct Nearest {
  int points = 0;
  double far = 0.0;
};

}  // namespace

void open_places_of_files(Scene& scene) {
  if (!scene.touches()) return;
  for (Bond& b : scene.bonds().awake())
    if (b.body >= scene.bodies_started) b.part<FreedPlaces>()->open_all(b.points, scene.bonds().body(b), b.grid, scene.grains.side_of(b));
}

std::vector<int> move_places(Scene& scene) {
  if (!scene.places_move()) return {};
  struct OfBond {
    std::vector<FreedPlaces::Arrival> arrivals;
    std::vector<std::array<int, 2>> gone;
  };
  std::map<int, OfBond> moves;
  std::vector<FreedPlaces::Mover> abroad;  // places of bonds that have points on other ranks
  for (Bond& b : scene.bonds().awake()) {
    FreedPlaces& places = *b.part<FreedPlaces>();
    if (!places.take_change()) continue;
    const bool whole = b.size() == scene.bonds().body(b).points;
    for (const FreedPlaces::Mover& m : places.movers(b.points, scene.bonds().body(b))) {
      if (!whole) {
        abroad.push_back(m);
        continue;
      }
      const FreedPlaces::Found f = FreedPlaces::nearest(b.points, m);
      if (f.slots.empty()) continue;
      for (int slot : f.slots) moves[b.body].arrivals.push_back({m, slot, 1.0 / static_cast<double>(f.slots.size())});
      moves[b.body].gone.push_back({m.tag, m.grain});
    }
  }
  const std::vector<FreedPlaces::Mover> all = gather_all(scene.comm, abroad);
  if (!all.empty()) {
    std::vector<Offer> mine;
    std::vector<FreedPlaces::Found> found(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Bond* b = scene.bonds().find(all[i].body);
      if (b) found[i] = FreedPlaces::nearest(b->points, all[i]);
      if (!found[i].slots.empty()) mine.push_back({static_cast<int>(i), static_cast<int>(found[i].slots.size()), found[i].far});
    }
    std::vector<Nearest> best(all.size());
    for (const Offer& o : gather_all(scene.comm, mine)) {
      Nearest& n = best[o.mover];
      if (n.points == 0 || o.far < n.far) n = {o.points, o.far};
      else if (o.far == n.far) n.points += o.points;
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (best[i].points == 0 || !scene.bonds().find(all[i].body)) continue;
      OfBond& of_bond = moves[all[i].body];
      if (found[i].far == best[i].far)
        for (int slot : found[i].slots) of_bond.arrivals.push_back({all[i], slot, 1.0 / best[i].points});
      of_bond.gone.push_back({all[i].tag, all[i].grain});
    }
  }
  std::vector<int> moved;
  for (const auto& m : moves) {
    Bond& b = *scene.bonds().find(m.first);
    scene.books.release(-b.part<FreedPlaces>()->move(b.points, scene.bonds().body(b), b.grid, scene.grains.side_of(b), m.second.arrivals, m.second.gone));
    moved.push_back(m.first);
  }
  return moved;
}

}  // namespace mpdem
