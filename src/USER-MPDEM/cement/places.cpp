// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Places that let go of the grains (coupling/freed_places.h): when they open, and when they go on to other points, which may be on
// other ranks. It is chosen by places of the reference alone, so all ranks together choose as one does.
#include "../parallel/gather_all.h"
#include "cement.h"

namespace mpdem {

namespace {

struct Offer {
  int mover, rank, tag;
  double distance;
};

int rank_in(MPI_Comm comm) {
  int me;
  MPI_Comm_rank(comm, &me);
  return me;
}

}  // namespace

void Cement::open_places(Bond& b, const std::vector<int>& failed, const std::vector<int>& links) {
  if (b.places.empty()) b.places = FreedPlaces(b.points, bonds_.body(b), *penalty_, b.grid);
  books_.release(-b.places.open(b.points, bonds_.body(b), b.grid, grains_.side_of(b), failed, links));
  b.places_may_move = true;
}

// Of bonds that are new.
void Cement::open_places_of_files() {
  if (!touches()) return;
  for (Bond& b : bonds_.awake()) {
    b.places_may_move = true;
    if (b.body < bodies_started_) continue;
    if (b.places.empty()) b.places = FreedPlaces(b.points, bonds_.body(b), *penalty_, b.grid);
    b.places.open_all(b.points, bonds_.body(b), b.grid, grains_.side_of(b));
  }
}

// Collective. Places whose points failed go on to the nearest that hold. Nodes and grains are where they were at the end of the last step.
// Answers the bonds where some did, the same on all ranks.
std::vector<int> Cement::move_places() {
  if (!touches() || !begins_step() || (now_.number - 1) % kWatchEvery != 0) return {};
  struct OfBond {
    std::vector<FreedPlaces::Arrival> arrivals;
    std::vector<std::array<int, 2>> gone;
  };
  std::map<int, OfBond> moves;
  std::vector<FreedPlaces::Mover> abroad;  // of bonds that have points on other ranks
  for (Bond& b : bonds_.awake()) {
    if (!b.places_may_move) continue;
    b.places_may_move = false;
    const bool whole = b.points.size() == bonds_.body(b).points;
    for (const FreedPlaces::Mover& m : b.places.movers(b.points, bonds_.body(b), b.grid, grains_.side_of(b))) {
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
  const int me = rank_in(comm_);
  const std::vector<FreedPlaces::Mover> all = gather_all(comm_, abroad);
  if (!all.empty()) {
    std::vector<Offer> mine;
    std::vector<int> slot(all.size(), -1);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Bond* b = bonds_.find(all[i].body);
      const FreedPlaces::Found f = b ? FreedPlaces::nearest(b->points, all[i]) : FreedPlaces::Found();
      if (f.tag < 0) continue;
      mine.push_back({static_cast<int>(i), me, f.tag, f.distance});
      slot[i] = f.slot;
    }
    std::vector<Offer> best(all.size(), Offer{0, -1, -1, 0.0});
    for (const Offer& o : gather_all(comm_, mine))
      if (FreedPlaces::Found{o.distance, o.tag, 0}.nearer_than({best[o.mover].distance, best[o.mover].tag, 0})) best[o.mover] = o;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (best[i].tag < 0 || !bonds_.find(all[i].body)) continue;
      OfBond& of_bond = moves[all[i].body];
      if (best[i].rank == me) of_bond.arrivals.push_back({all[i], slot[i]});
      of_bond.gone.push_back({all[i].tag, all[i].grain});
    }
  }
  std::vector<int> moved;
  for (const auto& m : moves) {
    Bond& b = *bonds_.find(m.first);
    if (b.places.empty()) b.places = FreedPlaces(b.points, bonds_.body(b), *penalty_, b.grid);
    books_.release(-b.places.move(b.points, bonds_.body(b), b.grid, grains_.side_of(b), m.second.arrivals, m.second.gone));
    moved.push_back(m.first);
  }
  return agreed_rows(moved);
}

// Where places are elsewhere, so is their stiffness.
void Cement::refresh_for_places(const std::vector<int>& moved) {
  if (moved.empty()) return;
  books_.release_by([&] { return added_energy_ahead(moved, 0.5 * (dt_last_ + now_.dt)); }, [&] { refresh_added_mass(moved); });
}

}  // namespace mpdem
