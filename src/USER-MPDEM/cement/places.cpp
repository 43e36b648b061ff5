// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Places go on to points that are chosen by places of the reference alone. So all ranks together choose as one rank
// does.
#include "places.h"

#include <array>
#include <map>

#include "../parallel/gather_ranks.h"
#include "../parallel/ranks.h"

namespace mpdem {

namespace {

struct Offer {
  int mover, rank, tag;
  double distance;
};

}  // namespace

void open_places(Scene& scene, Bond& b, const std::vector<int>& links) {
  if (b.places.empty()) b.places = FreedPlaces(b.points, scene.bonds.body(b), *scene.penalty, b.grid);
  scene.books.release(-b.places.open(b.points, scene.bonds.body(b), b.grid, scene.grains.side_of(b), links));
  b.places_may_move = true;
}

void open_places_of_files(Scene& scene) {
  if (!scene.touches()) return;
  for (Bond& b : scene.bonds.awake()) {
    b.places_may_move = true;
    if (b.body < scene.bodies_started) continue;
    if (b.places.empty()) b.places = FreedPlaces(b.points, scene.bonds.body(b), *scene.penalty, b.grid);
    b.places.open_all(b.points, scene.bonds.body(b), b.grid, scene.grains.side_of(b));
  }
}

std::vector<int> move_places(Scene& scene) {
  if (!scene.touches() || !scene.watches()) return {};
  struct OfBond {
    std::vector<FreedPlaces::Arrival> arrivals;
    std::vector<std::array<int, 2>> gone;
  };
  std::map<int, OfBond> moves;
  std::vector<FreedPlaces::Mover> abroad;  // places of bonds that have points on other ranks
  for (Bond& b : scene.bonds.awake()) {
    if (!b.places_may_move) continue;
    b.places_may_move = false;
    const bool whole = b.points.size() == scene.bonds.body(b).points;
    for (const FreedPlaces::Mover& m : b.places.movers(b.points, scene.bonds.body(b))) {
      if (!whole) {
        abroad.push_back(m);
        continue;
      }
      const FreedPlaces::Found f = FreedPlaces::nearest(b.points, m);
      if (f.tag < 0) continue;
      moves[b.body].arrivals.push_back({m, f.slot});
      moves[b.body].gone.push_back({m.tag, m.grain});
    }
  }
  const int me = rank_in(scene.comm);
  const std::vector<FreedPlaces::Mover> all = gather_all(scene.comm, abroad);
  if (!all.empty()) {
    std::vector<Offer> mine;
    std::vector<int> slot(all.size(), -1);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Bond* b = scene.bonds.find(all[i].body);
      const FreedPlaces::Found f = b ? FreedPlaces::nearest(b->points, all[i]) : FreedPlaces::Found();
      if (f.tag < 0) continue;
      mine.push_back({static_cast<int>(i), me, f.tag, f.distance});
      slot[i] = f.slot;
    }
    std::vector<Offer> best(all.size(), Offer{0, -1, -1, 0.0});
    for (const Offer& o : gather_all(scene.comm, mine))
      if (FreedPlaces::Found{o.distance, o.tag, 0}.nearer_than({best[o.mover].distance, best[o.mover].tag, 0})) best[o.mover] = o;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (best[i].tag < 0 || !scene.bonds.find(all[i].body)) continue;
      OfBond& of_bond = moves[all[i].body];
      if (best[i].rank == me) of_bond.arrivals.push_back({all[i], slot[i]});
      of_bond.gone.push_back({all[i].tag, all[i].grain});
    }
  }
  std::vector<int> moved;
  for (const auto& m : moves) {
    Bond& b = *scene.bonds.find(m.first);
    if (b.places.empty()) b.places = FreedPlaces(b.points, scene.bonds.body(b), *scene.penalty, b.grid);
    scene.books.release(-b.places.move(b.points, scene.bonds.body(b), b.grid, scene.grains.side_of(b), m.second.arrivals, m.second.gone));
    moved.push_back(m.first);
  }
  return moved;
}

}  // namespace mpdem
