// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "bonded_atoms.h"

#include <algorithm>
#include <cmath>

#include "../../numerics/length.h"
#include "../words/arguments.h"
#include "atom.h"
#include "domain.h"
#include "fix_gravity.h"
#include "local_atom.h"
#include "modify.h"
#include "prescribed_motion.h"
#include "update.h"

namespace mpdem {

using namespace LAMMPS_NS;

void BondedAtoms::find(AtomVecMpdem& avec, BondedGrains& grains) {
  Atom& atom = *lmp_->atom;
  atoms_.clear();
  for (const BondRecord& b : avec.bonds.table)
    for (int s = 0; s < 2; ++s) {
      const int i = b.has_grain(s) ? local_atom(atom, b.grain[s]) : -1;
      if (i < 0) continue;
      avec.track_orientation(i);
      atoms_.push_back(i);
    }
  std::sort(atoms_.begin(), atoms_.end(), [&](int a, int b) { return atom.tag[a] < atom.tag[b]; });
  atoms_.erase(std::unique(atoms_.begin(), atoms_.end()), atoms_.end());
  std::vector<Grain> now(atoms_.size());
  for (std::size_t n = 0; n < now.size(); ++n) {
    const int i = atoms_[n];
    Grain& g = now[n];
    g.tag = atom.tag[i];
    g.mass = atom.rmass[i];
    g.radius = avec.coats.bare_radius(g.tag, atom.radius[i]);
    g.inertia = avec.coats.inertia(g.tag, atom.radius[i], g.mass);
    g.state = avec.grain(i);
    const PrescribedMotion p = prescribed_motion(lmp_, i);
    for (int d = 0; d < 6; ++d) g.free[d] = d < 3 ? !p.translation[d] : !p.rotation;
  }
  grains.replace(std::move(now));
  for (std::size_t n = 0; n < atoms_.size(); ++n) lmp_->domain->unmap(atom.x[atoms_[n]], atom.image[atoms_[n]], grains.grains[n].x);
}

void BondedAtoms::read(BondedGrains& grains) const {
  const Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n) {
    const int i = atoms_[n];
    Grain& g = grains.grains[n];
    for (int d = 0; d < 3; ++d) {
      g.velocity[d] = atom.v[i][d];
      g.velocity[3 + d] = atom.omega[i][d];
      g.force[d] = atom.f[i][d];
      g.force[3 + d] = atom.torque[i][d];
    }
  }
}

void BondedAtoms::write_forces(const BondedGrains& grains) const {
  Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n)
    for (int d = 0; d < 3; ++d) {
      atom.f[atoms_[n]][d] = grains.grains[n].force[d];
      atom.torque[atoms_[n]][d] = grains.grains[n].force[3 + d];
    }
}

void BondedAtoms::read_positions(BondedGrains& grains) const {
  const Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n) lmp_->domain->unmap(atom.x[atoms_[n]], atom.image[atoms_[n]], grains.grains[n].x);
}

void BondedAtoms::write_motion(const BondedGrains& grains) const {
  const Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n) {
    const int i = atoms_[n];
    const Grain& g = grains.grains[n];
    double moved_to[3];
    lmp_->domain->unmap(atom.x[i], atom.image[i], moved_to);
    for (int d = 0; d < 6; ++d) {
      if (!g.free[d]) continue;
      if (d < 3) atom.x[i][d] += g.x[d] - moved_to[d];
      (d < 3 ? atom.v[i][d] : atom.omega[i][d - 3]) = g.velocity[d];
    }
  }
}

void BondedAtoms::write_free_velocities(const BondedGrains& grains) const {
  Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n)
    for (int d = 0; d < 6; ++d)
      if (grains.grains[n].free[d]) (d < 3 ? atom.v[atoms_[n]][d] : atom.omega[atoms_[n]][d - 3]) = grains.grains[n].velocity[d];
}

void BondedAtoms::write_velocities(const BondedGrains& grains) const {
  Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n)
    for (int d = 0; d < 3; ++d) {
      atom.v[atoms_[n]][d] = grains.grains[n].velocity[d];
      atom.omega[atoms_[n]][d] = grains.grains[n].velocity[3 + d];
    }
}

void BondedAtoms::expect_gravity(BondedGrains& grains, const Fix* fix) const {
  Modify& modify = *lmp_->modify;
  bool later = false;
  for (int k = 0; k < modify.nfix; ++k) {
    FixGravity* gravity = dynamic_cast<FixGravity*>(modify.fix[k]);
    later = later || modify.fix[k] == fix;
    if (!gravity || !later) continue;
    double g[3];
    gravity->get_gravity(g);
    for (std::size_t n = 0; n < atoms_.size(); ++n) {
      const int i = atoms_[n];
      if (grains.grains[n].state->velocities_known || !(lmp_->atom->mask[i] & gravity->groupbit)) continue;
      for (int d = 0; d < 3; ++d) grains.grains[n].state->late_load[d] += lmp_->atom->rmass[i] * g[d];
    }
  }
}

void BondedAtoms::report_trouble() { stop_if_any(lmp_, trouble_); }

// Any smooth motion stays well within twice the larger of the velocities of this sub-step and the last one.
void BondedAtoms::follow(BondedGrains& grains, double cell, double dt) {
  const Atom& atom = *lmp_->atom;
  for (std::size_t n = 0; n < atoms_.size(); ++n) {
    const int i = atoms_[n];
    Grain& grain = grains.grains[n];
    GrainState& g = *grain.state;
    double jump[3];
    lmp_->domain->unmap(atom.x[i], atom.image[i], grain.x);
    for (int d = 0; d < 3; ++d) {
      grain.moved[d] = grain.x[d] - g.x[d];
      jump[d] = grain.moved[d] - dt * atom.v[i][d];
      g.x[d] = grain.x[d];
    }
    const double expected = dt * std::max(length(atom.v[i]), length(g.v));
    const bool known = g.position_known;
    g.position_known = true;
    if (known && trouble_.empty() && length(jump) > 2.0 * expected + 1e-5 * cell)
      trouble_ = text_of(who_, "bonded grain ", atom.tag[i], " jumped by ", length(grain.moved), " in step ", lmp_->update->ntimestep,
                         ", its velocity takes it ", expected,
                         " at most; formulas of 'fix move' in step*dt jump "
                         "when 'timestep' or 'reset_timestep' changes, and need the velocity that goes with the position: define "
                         "that fix anew, with formulas that start from 0; 'displace_atoms', 'set', 'change_box' and 'fix deform' "
                         "must not move bonded grains");
  }
}

}  // namespace mpdem
