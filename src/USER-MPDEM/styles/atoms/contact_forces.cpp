// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "contact_forces.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "../../numerics/sort_unique.h"
#include "atom.h"
#include "comm.h"
#include "compute_pair_gran_local.h"
#include "fix_property_atom.h"
#include "fix_wall_gran.h"
#include "force.h"
#include "modify.h"
#include "pair_gran.h"
#include "primitive_wall.h"
#include "update.h"

namespace mpdem {

using namespace LAMMPS_NS;

// Members of LIGGGHTS' FixWallGran by their symbols.
void evaluate_wall(FixWallGran*) __asm__("_ZN9LAMMPS_NS11FixWallGran14post_force_pglEv");
void register_compute(FixWallGran*, ComputePairGranLocal*,
                      int&) __asm__("_ZN9LAMMPS_NS11FixWallGran27register_compute_wall_localEPNS_20ComputePairGranLocalERi");
void unregister_compute(FixWallGran*, ComputePairGranLocal*) __asm__(
    "_ZN9LAMMPS_NS11FixWallGran29unregister_compute_wall_localEPNS_20ComputePairGranLocalE");

// A contact of two atoms of this rank, or of one with a ghost: the force on the first one.
struct HeardPair {
  int i, j;
  double force[3];
};
// A contact with a wall. normal: unit vector from the grain to the wall, distance: of its centre from the wall.
struct HeardWall {
  int i;
  double force[3], distance;
  const double* normal;
};

// Vectors of the atoms of this rank, to be put back.
class Copy {
 public:
  Copy(double** vectors, int count) : vectors_(vectors) {
    for (int i = 0; vectors && i < count; ++i) values_.insert(values_.end(), vectors[i], vectors[i] + 3);
  }
  void put_back() const {
    for (std::size_t n = 0; n < values_.size(); ++n) vectors_[n / 3][n % 3] = values_[n];
  }

 private:
  double** vectors_;
  std::vector<double> values_;
};

class ContactForces::Listener : public ComputePairGranLocal {
 public:
  Listener(LAMMPS* lmp, int next, int words, char** word) : ComputePairGranLocal(lmp, next, words, word) {}

  void add_pair(int i, int j, double fx, double fy, double fz, double, double, double, double*, const double*) override {
    if (fx * fx + fy * fy + fz * fz > 0.0) on_pair({i, j, {fx, fy, fz}});
  }
  void add_wall_1(int, int, int, double*, double*) override {}
  void add_wall_2(int i, double fx, double fy, double fz, double, double, double, double*, double square, double* normal) override {
    on_wall({i, {fx, fy, fz}, std::sqrt(square), normal});
  }
  void pair_finalize() override {}
  // Without `newton on` both ranks of a contact find it. LIGGGHTS' own tables count it on this one.
  bool is_of_other_rank(const HeardPair& p) const { return !force->newton_pair && p.j >= atom->nlocal && atom->tag[p.i] <= atom->tag[p.j]; }

  // The wall to which a compute of the script listens, or null.
  static FixWallGran* wall_of(const ComputePairGranLocal& other) { return other.*(&Listener::fixwall); }

  std::function<void(const HeardPair&)> on_pair;
  std::function<void(const HeardWall&)> on_wall;
};

// LIGGGHTS refuses such a compute after the first step, since histories might lack values that it requests. This one
// requests none, so the step is set to 0 meanwhile.
ContactForces::ContactForces(LAMMPS* lmp) : lmp_(lmp) {
  char name[] = "mpm_contacts", all[] = "all", style[] = "pair/gran/local", what[] = "force";
  char* words[] = {name, all, style, what};
  int next = 3;
  const bigint now = std::exchange(lmp->update->ntimestep, 0);
  listener_ = std::make_unique<Listener>(lmp, next, 4, words);
  lmp->update->ntimestep = now;
}

ContactForces::~ContactForces() = default;

void ContactForces::listen_to_pairs() {
  Force& force = *lmp_->force;
  PairGran* const contacts = force.pair ? static_cast<PairGran*>(force.pair_match("gran", 0)) : nullptr;
  if (!contacts || !contacts->cplenable()) return;
  lmp_->comm->forward_comm();  // ghosts have velocities half a step old, so dashpots would depend on the number of ranks
  ComputePairGranLocal* const of_script = contacts->cpl();
  int unused;
  if (of_script) contacts->unregister_compute_pair_local(of_script);
  contacts->register_compute_pair_local(listener_.get(), unused);
  contacts->compute_pgl(0, 0);
  contacts->unregister_compute_pair_local(listener_.get());
  if (of_script) contacts->register_compute_pair_local(of_script, unused);
}

void ContactForces::listen_to_walls() {
  Modify& modify = *lmp_->modify;
  for (int n = 0; n < modify.nfix; ++n) {
    FixWallGran* const wall = dynamic_cast<FixWallGran*>(modify.fix[n]);
    if (!wall) continue;
    // LIGGGHTS overwrites what `store_force` keeps of a wall, so it is put back.
    const int stored = modify.find_fix((std::string("force_") + wall->id).c_str());
    const FixPropertyAtom* const store = stored < 0 ? nullptr : dynamic_cast<FixPropertyAtom*>(modify.fix[stored]);
    const Copy kept(store ? store->array_atom : nullptr, lmp_->atom->nlocal);
    if (wall->is_mesh_wall()) listen_to_meshes(*wall);
    else listen_to_primitive(*wall);
    kept.put_back();
  }
}

void ContactForces::listen_to_meshes(FixWallGran& wall) {
  ComputePairGranLocal* of_script = nullptr;
  for (int c = 0; c < lmp_->modify->ncompute; ++c) {
    ComputePairGranLocal* const compute = dynamic_cast<ComputePairGranLocal*>(lmp_->modify->compute[c]);
    if (compute && Listener::wall_of(*compute) == &wall) of_script = compute;
  }
  int unused;
  if (of_script) unregister_compute(&wall, of_script);
  register_compute(&wall, listener_.get(), unused);
  evaluate_wall(&wall);
  unregister_compute(&wall, listener_.get());
  if (of_script) register_compute(&wall, of_script, unused);
}

// LIGGGHTS reports contacts with meshes alone, so the wall adds its forces to those of the grains, which are put back. At set-up
// histories of contacts stay as they are.
void ContactForces::listen_to_primitive(FixWallGran& wall) {
  Atom& atom = *lmp_->atom;
  const Copy forces(atom.f, atom.nlocal), torques(atom.torque, atom.nlocal);
  for (int i = 0; i < atom.nlocal; ++i) std::fill_n(atom.f[i], 3, 0.0);
  const int in_setup = std::exchange(lmp_->update->setupflag, 1);
  wall.post_force(0);
  lmp_->update->setupflag = in_setup;
  for (int i = 0; i < atom.nlocal; ++i) {
    const double* const f = atom.f[i];
    if (f[0] == 0.0 && f[1] == 0.0 && f[2] == 0.0) continue;
    double arm[3];
    wall.primitiveWall()->resolveContact(atom.x[i], 0.0, arm);
    const double distance = std::hypot(arm[0], arm[1], arm[2]);
    for (double& a : arm) a /= distance;
    listener_->on_wall({i, {f[0], f[1], f[2]}, distance, arm});
  }
  forces.put_back();
  torques.put_back();
}

Report::Magnitudes ContactForces::of_bonded(const std::vector<BondRecord>& table) {
  std::vector<int> tags;
  for (const BondRecord& b : table)
    for (int s = 0; s < 2; ++s)
      if (b.has_grain(s)) tags.push_back(b.grain[s]);
  sort_unique(tags);
  const auto has_cement = [&](int i) { return std::binary_search(tags.begin(), tags.end(), lmp_->atom->tag[i]); };
  Report::Magnitudes heard = {};
  listener_->on_pair = [&](const HeardPair& p) {
    if (listener_->is_of_other_rank(p) || !(has_cement(p.i) || has_cement(p.j))) return;
    heard.sum += std::sqrt(p.force[0] * p.force[0] + p.force[1] * p.force[1] + p.force[2] * p.force[2]);
    heard.number += 1.0;
  };
  listen_to_pairs();
  return heard;
}

void ContactForces::add_virials(GrainVirial& virial) {
  Atom& atom = *lmp_->atom;
  const bool both_ranks = !lmp_->force->newton_pair;  // do both ranks of a contact find it?
  listener_->on_pair = [&](const HeardPair& p) {
    const int atoms[] = {p.i, p.j};
    for (int s = 0; s < 2; ++s) {
      if (both_ranks && atoms[s] >= atom.nlocal) continue;
      const int here = atoms[s], other = atoms[1 - s];
      const double share = atom.radius[here] / (atom.radius[here] + atom.radius[other]);
      double force[3], arm[3];
      for (int d = 0; d < 3; ++d) {
        force[d] = s == 0 ? p.force[d] : -p.force[d];
        arm[d] = share * (atom.x[other][d] - atom.x[here][d]);
      }
      virial.add(atom.tag[here], force, arm);
    }
  };
  listener_->on_wall = [&](const HeardWall& w) {
    double arm[3];
    for (int d = 0; d < 3; ++d) arm[d] = w.distance * w.normal[d];
    virial.add(atom.tag[w.i], w.force, arm);
  };
  listen_to_pairs();
  listen_to_walls();
}

}  // namespace mpdem
