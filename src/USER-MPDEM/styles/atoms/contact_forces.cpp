// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "contact_forces.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../../numerics/sort_unique.h"
#include "atom.h"
#include "comm.h"
#include "compute_pair_gran_local.h"
#include "force.h"
#include "pair_gran.h"
#include "update.h"

namespace mpdem {

using namespace LAMMPS_NS;

class ContactForces::Listener : public ComputePairGranLocal {
 public:
  Listener(LAMMPS* lmp, int next, int words, char** word) : ComputePairGranLocal(lmp, next, words, word) {}

  void add_pair(int i, int j, double fx, double fy, double fz, double, double, double, double*, const double*) override {
    if (is_of_other_rank(i, j) || !(has_cement(i) || has_cement(j))) return;
    const double square = fx * fx + fy * fy + fz * fz;
    if (square == 0.0) return;
    heard.sum += std::sqrt(square);
    heard.number += 1.0;
  }
  void pair_finalize() override {}

  Report::Magnitudes heard;
  std::vector<int> tags;  // of grains that have cement, ascending

 private:
  // Without `newton on` both ranks of a contact find it. LIGGGHTS' own tables count it on this one.
  bool is_of_other_rank(int i, int j) const { return !force->newton_pair && j >= atom->nlocal && atom->tag[i] <= atom->tag[j]; }
  bool has_cement(int i) const { return std::binary_search(tags.begin(), tags.end(), atom->tag[i]); }
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

Report::Magnitudes ContactForces::of_bonded(const std::vector<BondRecord>& table) {
  Force& force = *lmp_->force;
  PairGran* const contacts = force.pair ? static_cast<PairGran*>(force.pair_match("gran", 0)) : nullptr;
  if (!contacts || !contacts->cplenable()) return {};
  std::vector<int>& tags = listener_->tags;
  tags.clear();
  for (const BondRecord& b : table)
    for (int s = 0; s < 2; ++s)
      if (b.has_grain(s)) tags.push_back(b.grain[s]);
  sort_unique(tags);
  listener_->heard = {};
  lmp_->comm->forward_comm();  // ghosts have velocities half a step old, so dashpots would depend on the number of ranks
  ComputePairGranLocal* const of_script = contacts->cpl();
  int unused;
  if (of_script) contacts->unregister_compute_pair_local(of_script);
  contacts->register_compute_pair_local(listener_.get(), unused);
  contacts->compute_pgl(0, 0);
  contacts->unregister_compute_pair_local(listener_.get());
  if (of_script) contacts->register_compute_pair_local(of_script, unused);
  return listener_->heard;
}

}  // namespace mpdem
