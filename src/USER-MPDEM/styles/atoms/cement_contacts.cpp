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
  nodes_moved_ = true;
  take_surfaces(cement);
  search(avec, cement);
  check_reach(cement);
  add_forces(avec, cement, 0.0);
}

void CementContacts::take_changes(AtomVecMpdem& avec, Cement& cement) {
  nodes_moved_ = true;
  find_changes(avec, cement);
}

void CementContacts::find_changes(AtomVecMpdem& avec, Cement& cement) {
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
    for (const CementPiece& p : cement.contact().pieces())  // from a restart file
      taken_[p.row] = {p.apart, table[p.row].points, cement.seen_of_fragments(p.row)};
  }
  std::vector<int> rows;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const Taken now{cement.is_apart(static_cast<int>(row)), table[row].points, cement.seen_of_fragments(static_cast<int>(row))};
    if (taken_[row] != now) rows.push_back(static_cast<int>(row));
    taken_[row] = now;
  }
  if (!rows.empty()) cement.take_surfaces(rows);
}

// LIGGGHTS gives a rank the triangles that its grains may touch, up to half of the distance of `neighbor` from their surfaces.
void CementContacts::check_reach(Cement& cement) const {
  if (lmp_->comm->nprocs == 1 || !walls_.any_mesh()) return;
  double farthest = 0.0;
  int grain = 0;
  for (const CementPiece& p : cement.contact().pieces()) {
    if (p.is_loose()) continue;
    const BondRecord& record = cement.bonds().table[p.row];
    const double beyond = length(p.middle) + p.reach - record.radius[p.side];
    if (beyond > farthest) farthest = beyond, grain = p.grain;
  }
  if (farthest > 0.5 * lmp_->neighbor->skin)
    stop_all(lmp_, text_of("fix mpm: with 'friction' and mesh walls on several ranks, cement may reach half of the 'neighbor' distance, ",
                           lmp_->neighbor->skin, ", beyond its grain; that of grain ", grain, " reaches ", farthest,
                           " beyond it; use a 'neighbor' of at least ", 2.1 * farthest, ", one rank, or primitive walls"));
}

void CementContacts::read_bodies(AtomVecMpdem& avec, Cement& cement) {
  const Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n) {
    const int i = atoms_[n];
    ContactBody& b = bodies_[n];
    lmp_->domain->unmap(atom.x[i], atom.image[i], b.x);
    std::copy(atom.v[i], atom.v[i] + 3, b.v);
    std::copy(atom.omega[i], atom.omega[i] + 3, b.omega);
    if (const double* q = avec.orientation(i)) std::copy(q, q + 4, b.q);
  }
  if (cement.fragments() == 0) return;
  const std::vector<BodyOfNodes>& motions = cement.motions_of_fragments(nodes_moved_);
  for (std::size_t n = 0; n < fragments_.size(); ++n) {
    const BodyOfNodes& m = motions[fragments_[n]];
    ContactBody& b = bodies_[atoms_.size() + n];
    Eigen::Map<Eigen::Vector3d>(b.x) = m.x;
    Eigen::Map<Eigen::Vector3d>(b.v) = m.v;
    Eigen::Map<Eigen::Vector3d>(b.omega) = m.omega;
    const Eigen::Quaterniond q(m.R);
    b.q[0] = q.w(), b.q[1] = q.x(), b.q[2] = q.y(), b.q[3] = q.z();
  }
}

// Collective. A fragment outside of all parts of the box belongs to the first rank.
void CementContacts::add_fragments(Cement& cement) {
  fragments_.clear();
  if (cement.fragments() == 0) return;
  const std::vector<BodyOfNodes>& motions = cement.motions_of_fragments(nodes_moved_);
  Domain& domain = *lmp_->domain;
  std::vector<int> rank(motions.size(), lmp_->comm->nprocs);
  std::vector<std::array<double, 3>> to_box(motions.size());
  for (std::size_t n = 0; n < motions.size(); ++n) {
    double in_box[3];
    std::copy(motions[n].centre.data(), motions[n].centre.data() + 3, in_box);
    domain.remap(in_box);
    bool here = true;
    for (int d = 0; d < 3; ++d) {
      to_box[n][d] = in_box[d] - motions[n].centre[d];
      here = here && in_box[d] >= domain.sublo[d] && in_box[d] < domain.subhi[d];
    }
    if (here) rank[n] = lmp_->comm->me;
  }
  MPI_Allreduce(MPI_IN_PLACE, rank.data(), static_cast<int>(rank.size()), MPI_INT, MPI_MIN, lmp_->world);
  for (std::size_t n = 0; n < motions.size(); ++n) {
    if (rank[n] % lmp_->comm->nprocs != lmp_->comm->me) continue;
    fragments_.push_back(static_cast<int>(n));
    bodies_.emplace_back();
    bodies_.back().tag = tag_of_fragment(static_cast<int>(n));
    std::copy(to_box[n].begin(), to_box[n].end(), bodies_.back().to_box);
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
  add_fragments(cement);
  read_bodies(avec, cement);
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
  nodes_moved_ = dt == 0.0;
  find_changes(avec, cement);  // cement may have left since the last step
  if (search_is_due_) search(avec, cement);
  else read_bodies(avec, cement);
  search_is_due_ = cement.contact().find_forces(lmp_->world, bodies_, walls_, dt);
  Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n)
    for (int d = 0; d < 3; ++d) {
      atom.f[atoms_[n]][d] += bodies_[n].force[d];
      atom.torque[atoms_[n]][d] += bodies_[n].torque[d];
    }
  if (cement.fragments() == 0) return;
  std::vector<double> forces(6 * static_cast<std::size_t>(cement.fragments()), 0.0);
  for (std::size_t n = 0; n < fragments_.size(); ++n) {
    const ContactBody& b = bodies_[atoms_.size() + n];
    double* to = &forces[6 * static_cast<std::size_t>(fragments_[n])];
    std::copy(b.force, b.force + 3, to);
    std::copy(b.torque, b.torque + 3, to + 3);
  }
  cement.load_fragments(std::move(forces));
}

}  // namespace mpdem
