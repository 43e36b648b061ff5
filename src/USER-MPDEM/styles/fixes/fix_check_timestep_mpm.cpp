// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "fix_check_timestep_mpm.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "../words/arguments.h"
#include "../atoms/atom_vec_mpdem.h"
#include "fix_mpm.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::text_of;

FixCheckTimestepMpm::FixCheckTimestepMpm(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg) {
  mpdem::Arguments args(lmp, text_of("fix check/timestep/mpm (id ", id, ")"), narg, arg, 3);
  nevery = args.integer("the number of steps between checks", 1);
  cement_id_ = args.word("the ID of a fix mpm");
  fraction_ = args.positive("the share of the stable step");
  if (fraction_ > 1.0) args.complain(text_of("the share of the stable step is ", fraction_, ", must lie in (0, 1]; 0.9 for instance"));
  stop_ = args.empty() ? false : args.choice("what to do", {"warn", "stop"}) == "stop";
  if (!args.empty()) args.complain("'" + args.word("") + "' is one word too many; the form is N ID FRACTION [warn|stop]");
  vector_flag = 1;
  size_vector = 2;
  extvector = 0;
  global_freq = nevery;
}

namespace {

// Collective. Returns a checksum that changes if grains become free or prescribed, or their inertia changes. It is a
// sum of integers, since rounding would depend on the ranks of the grains.
double mark_of_free_grains(const std::vector<mpdem::Grain>& grains, MPI_Comm world) {
  std::uint64_t mine = 0, sum;
  for (const mpdem::Grain& g : grains)
    for (int d = 0; d < 6; ++d) {
      const double inertia = g.free[d] ? (d < 3 ? g.mass : g.inertia) : 0.0;
      std::uint64_t bits;
      std::memcpy(&bits, &inertia, sizeof bits);
      mine += (bits ^ (bits >> 29)) * (2 * (6 * static_cast<std::uint64_t>(g.tag) + d) + 1) * 0x9e3779b97f4a7c15u >> 12;
    }
  MPI_Allreduce(&mine, &sum, 1, MPI_UINT64_T, MPI_SUM, world);
  return static_cast<double>(sum >> 11);  // 53 bits
}

}  // namespace

int FixCheckTimestepMpm::setmask() { return FixConst::END_OF_STEP; }

void FixCheckTimestepMpm::init() {
  const int i = modify->find_fix(cement_id_.c_str());
  cement_ = i < 0 ? nullptr : dynamic_cast<FixMpm*>(modify->fix[i]);
  if (!cement_)
    mpdem::stop_all(lmp, text_of("fix check/timestep/mpm (id ", id, "): '", cement_id_,
                                 "' is not a fix mpm; define that fix "
                                 "before and name its ID here"));
}

// Damage softens bonds, so the limit by grains remains valid until there are other bonds, sub-steps or free grains.
void FixCheckTimestepMpm::setup(int) {
  const std::array<double, 3> scene = {static_cast<double>(cement_->cement()->bonds.table.size()), static_cast<double>(cement_->substeps()),
                                       mark_of_free_grains(cement_->engine().grains().grains, world)};
  if (scene != scene_) of_grains_ = cement_->stable_step(true);
  scene_ = scene;
  check();
}
void FixCheckTimestepMpm::end_of_step() { check(); }

void FixCheckTimestepMpm::check() {
  const double cement_step = cement_->stable_step();
  limit_ = std::min(cement_step, of_grains_);
  share_ = limit_ > 0.0 ? update->dt / limit_ : 0.0;
  if (!(share_ > fraction_)) return;
  const std::string text = text_of("fix check/timestep/mpm (id ", id, "): time step ", update->dt, " is ", share_, " of the stable step ",
                                   limit_, limit_ < cement_step ? " of grains on their bonds at step " : " at step ", update->ntimestep,
                                   ", more than ", fraction_, "; use 'timestep ", fraction_ * limit_, "' or less");
  if (stop_) mpdem::stop_all(lmp, text);
  mpdem::warn(lmp, text, "fix check/timestep/mpm");
}

double FixCheckTimestepMpm::compute_vector(int n) { return n == 0 ? share_ : limit_; }

}  // namespace LAMMPS_NS
