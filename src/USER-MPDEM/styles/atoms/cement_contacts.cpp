// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement_contacts.h"

#include <algorithm>

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "neighbor.h"
#include "../../numerics/length.h"
#include "../words/arguments.h"

namespace mpdem {

using namespace LAMMPS_NS;

void CementContacts::start_run(AtomVecMpdem& avec, Cement& cement) {
  active_ = cement.has_contact();
  if (!active_) return;
  cement.contact().set(cement.contact_parameters());
  take_surfaces(cement);
  search(avec, cement);
  check_reach(cement);
  add_forces(avec, cement, 0.0);
}

void CementContacts::take_changes(AtomVecMpdem& avec, Cement& cement) {
  if (!active_ || cement.changes_of_surfaces() == changes_) return;
  take_surfaces(cement);
  search(avec, cement);
}

// Collective. Replaces the surfaces of bonds that are new, came apart, or lost points since the last call.
void CementContacts::take_surfaces(Cement& cement) {
  changes_ = cement.changes_of_surfaces();
  const std::vector<BondRecord>& table = cement.bonds().table;
  if (taken_.size() < table.size()) {
    taken_.resize(table.size());
    for (const CementPiece& p : cement.contact().pieces()) taken_[p.row] = {p.apart, table[p.row].points};  // from a restart file
  }
  std::vector<int> rows;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const Taken now{cement.is_apart(static_cast<int>(row)), table[row].points};
    if (taken_[row].apart != now.apart || taken_[row].points != now.points) rows.push_back(static_cast<int>(row));
    taken_[row] = now;
  }
  if (!rows.empty()) cement.contact().replace(rows, cement.surfaces(rows));
}

// LIGGGHTS gives a rank the triangles that its grains may touch, up to half of the distance of `neighbor` from their surfaces.
void CementContacts::check_reach(Cement& cement) const {
  if (lmp_->comm->nprocs == 1 || !walls_.any_mesh()) return;
  double farthest = 0.0;
  int grain = 0;
  for (const CementPiece& p : cement.contact().pieces()) {
    const BondRecord& record = cement.bonds().table[p.row];
    const double beyond = length(p.middle) + p.reach - record.radius[p.side];
    if (beyond > farthest) farthest = beyond, grain = p.grain;
  }
  if (farthest > 0.5 * lmp_->neighbor->skin)
    stop_all(lmp_, text_of("fix mpm: with 'friction' and mesh walls on several ranks, cement may reach half of the 'neighbor' distance, ",
                           lmp_->neighbor->skin, ", beyond its grain; that of grain ", grain, " reaches ", farthest,
                           " beyond it; use a 'neighbor' of at least ", 2.1 * farthest, ", one rank, or primitive walls"));
}

void CementContacts::read_grains(AtomVecMpdem& avec) {
  const Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n) {
    const int i = atoms_[n];
    ContactBody& b = bodies_[n];
    lmp_->domain->unmap(atom.x[i], atom.image[i], b.x);
    std::copy(atom.v[i], atom.v[i] + 3, b.v);
    std::copy(atom.omega[i], atom.omega[i] + 3, b.omega);
    if (const double* q = avec.orientation(i)) std::copy(q, q + 4, b.q);
  }
}

void CementContacts::search(AtomVecMpdem& avec, Cement& cement) {
  walls_.find();
  Atom& atom = *lmp_->atom;
  atoms_.clear();
  bodies_.clear();
  for (int i = 0; i < atom.nlocal; ++i) {
    if (avec.is_point(i)) continue;
    atoms_.push_back(i);
    bodies_.emplace_back();
    bodies_.back().tag = atom.tag[i];
    bodies_.back().radius = avec.coats.bare_radius(atom.tag[i], atom.radius[i]);
    double unwrapped[3];
    lmp_->domain->unmap(atom.x[i], atom.image[i], unwrapped);
    for (int d = 0; d < 3; ++d) bodies_.back().to_box[d] = atom.x[i][d] - unwrapped[d];
  }
  read_grains(avec);
  const Domain& domain = *lmp_->domain;
  NearestImage nearest;
  if (domain.xperiodic || domain.yperiodic || domain.zperiodic)
    nearest = [this](double* d) {
      const Domain& box = *lmp_->domain;
      const int periodic[3] = {box.xperiodic, box.yperiodic, box.zperiodic};
      for (int k = 0; k < 3; ++k)
        if (periodic[k]) d[k] -= box.prd[k] * std::nearbyint(d[k] / box.prd[k]);
    };
  cement.contact().search(lmp_->world, bodies_, walls_, nearest);
  search_is_due_ = false;
}

void CementContacts::add_forces(AtomVecMpdem& avec, Cement& cement, double dt) {
  if (!active_) return;
  take_changes(avec, cement);  // cement may have left since the last step
  if (search_is_due_) search(avec, cement);
  else read_grains(avec);
  search_is_due_ = cement.contact().find_forces(lmp_->world, bodies_, walls_, dt);
  Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n)
    for (int d = 0; d < 3; ++d) {
      atom.f[atoms_[n]][d] += bodies_[n].force[d];
      atom.torque[atoms_[n]][d] += bodies_[n].torque[d];
    }
}

}  // namespace mpdem
