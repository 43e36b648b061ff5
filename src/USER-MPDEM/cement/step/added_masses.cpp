// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "added_masses.h"

#include <algorithm>

#include "../../coupling/debonded_contact.h"
#include "../../numerics/sort_unique.h"

namespace mpdem {

void AddedMasses::refresh() {
  std::vector<Bond*> bonds;
  for (Bond& b : scene_.bonds()) bonds.push_back(&b);
  find(bonds);
}

void AddedMasses::refresh(const std::vector<int>& rows) {
  std::vector<Bond*> bonds;
  for (int row : rows)
    if (Bond* b = scene_.bonds().find(row)) bonds.push_back(b);
  find(bonds);
}

// Collective. bonds: those of this rank.
void AddedMasses::find(const std::vector<Bond*>& bonds) {
  if (!scene_.penalty) return;
  const CementOptions& o = scene_.options;
  const bool known = stable_step_.eigenvalue_is_known();
  // Damping lowers the largest stable dt^2 lambda by the factor 1 - rate dt/2. Only the rest is left for nodes with added mass.
  const double bound =
      scene_.stability_limit() * std::max(0.1, 1.0 - 0.5 * stable_step_.relative_damping_rate(o.relative_damping) * scene_.now.dt);
  // Without a known eigenvalue of the cement an upper bound takes its place.
  const AddedMass::Stability s{scene_.now.dt, known ? stable_step_.known_eigenvalue() : scene_.eigenvalue_bound(), !known, bound};
  for (Bond* b : bonds)
    if (scene_.bonds().is_resolved(*b)) b->added.find(b->links, b->grid, scene_.grains.ends_of(*b), s, b->mechanisms);
  for (Bond* b : bonds) scene_.formulation->share(*b, alike_);  // equal lists of bonds are stored once
  int some = 0, any;
  for (const Bond& b : scene_.bonds()) some = some || !b.added.empty();
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, scene_.comm);
  any_ = any != 0;
  scene_.grains.added_mass_changed();
}

// The new layout was made with added mass for the eigenvalue that was known before. If the layout changed the largest
// eigenvalue, all added mass is found again.
void AddedMasses::follow(const std::vector<int>& rows, const char* event, const StableStep::Patches* patches) {
  if (stable_step_.check_after(rows, event, patches)) refresh();
}

void AddedMasses::follow_contacts(const std::vector<int>& moved) {
  if (!scene_.contacts_move()) return;
  std::vector<int> mine(moved);
  for (Bond& b : scene_.bonds().resolved())
    if (update_added_mass(b)) mine.push_back(b.row);
  sort_unique(mine);
  const std::vector<int> rows = scene_.agreed_rows(mine);
  if (rows.empty()) return;
  renew(rows, [] {});
}

// Energies before and after are compared, so that the change of added mass is counted as released energy.
template <class Action>
void AddedMasses::renew(const std::vector<int>& rows, Action action) {
  std::vector<std::vector<AddedMass::OfNode>> before;
  for (int row : rows)
    if (const Bond* b = scene_.bonds().find(row)) before.push_back(b->added.shares());
  double slowed = 0.0;
  scene_.energy.release_by([&] { return energy_ahead(rows, scene_.kick()); },
                           [&] {
                             action();
                             refresh(rows);
                             std::size_t n = 0;
                             for (int row : rows)
                               if (Bond* b = scene_.bonds().find(row))
                                 slowed +=
                                     b->added.slow_nodes(before[n++], b->grid, scene_.grains.ends_of(*b), scene_.kick(), scene_.now.dt);
                           });
  scene_.energy.release(slowed);
  scene_.grains.expect_sudden_forces();
}

bool AddedMasses::update_added_mass(Bond& b) const {
  const double soon = scene_.topology_interval() * scene_.now.substeps * scene_.now.dt;
  DebondedContact* contact = b.mechanism<DebondedContact>();
  return contact && contact->update_added_mass(b.points, b.grid, scene_.grains.ends_of(b), scene_.now.dt, soon);
}

void AddedMasses::drop_debonded() {
  renew(scene_.all_rows(), [&] {
    for (Bond& b : scene_.bonds().resolved()) drop_debonded(b);
  });
}

// Sums over links are made in the order of their blocks. A new layout, as at the start of a run, has no debonded links in the
// blocks. They are removed in the same way here, so that a divided run has the same order, and gives the result of a single run.
void AddedMasses::drop_debonded(Bond& b) const {
  update_added_mass(b);
  if (b.links.drop_added_mass(b.points)) scene_.formulation->remove_dropped(b, scene_.bonds().record(b));
}

double AddedMasses::energy_ahead(const std::vector<int>& rows, double later) const {
  double sum = 0.0;
  for (int row : rows) {
    const Bond* b = row < scene_.rows_started ? scene_.bonds().find(row) : nullptr;
    // A condensed bond has no added mass, and no ends on this rank.
    if (b && !b->added.empty()) sum += b->added.energy_ahead(b->grid, scene_.grains.ends_of(*b), later);
  }
  return sum;
}

}  // namespace mpdem
