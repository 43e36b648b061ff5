// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "compute_mpm_stress.h"

#include <mpi.h>

#include "../fixes/fix_mpm.h"
#include "../words/arguments.h"
#include "atom.h"
#include "../atoms/atom_vec_mpdem.h"
#include "domain.h"
#include "input.h"
#include "memory.h"
#include "modify.h"
#include "update.h"
#include "variable.h"

namespace LAMMPS_NS {

using mpdem::text_of;

namespace {
constexpr int kComponents = 6;
}

ComputeMpmStress::ComputeMpmStress(LAMMPS* lmp, int& iarg, int narg, char** arg) : Compute(lmp, iarg, narg, arg) {
  mpdem::Arguments args(lmp, text_of("compute mpm/stress (id ", id, ")"), narg, arg, iarg);
  if (!AtomVecMpdem::of(lmp)) args.complain(text_of("atom style '", atom->atom_style, "' has no cement; use 'atom_style mpdem'"));
  if (args.accept("volume")) {
    const std::string given = narg > args.place() ? arg[args.place()] : "";
    if (given.rfind("v_", 0) == 0) variable_ = args.word("volume").substr(2);
    else given_volume_ = args.positive("volume", " or an equal-style variable v_NAME");
  }
  if (!args.empty()) args.complain("'" + args.word("") + "' is one word too many; the form is 'compute ID group-ID mpm/stress [volume V]'");
  vector_flag = peratom_flag = 1;
  size_vector = size_peratom_cols = kComponents;
  extvector = 0;
  array_atom = nullptr;
  invoked_flag = 0;
  vector = new double[kComponents];
}

ComputeMpmStress::~ComputeMpmStress() {
  memory->destroy(array_atom);
  delete[] vector;
}

std::string ComputeMpmStress::who() const { return text_of("compute mpm/stress (id ", id, "): "); }

void ComputeMpmStress::init() {
  found_at_ = -1;
  if (variable_.empty()) return;
  const int n = input->variable->find(const_cast<char*>(variable_.c_str()));
  if (n < 0 || !input->variable->equalstyle(n))
    mpdem::stop_all(lmp, who() + "'volume v_" + variable_ + "': there is no equal-style variable '" + variable_ +
                             "'; define it with 'variable " + variable_ + " equal ...', or give a number");
}

double ComputeMpmStress::volume() const {
  if (variable_.empty()) return given_volume_ > 0.0 ? given_volume_ : domain->xprd * domain->yprd * domain->zprd;
  const double volume = input->variable->compute_equal(input->variable->find(const_cast<char*>(variable_.c_str())));
  if (!(volume > 0.0))
    mpdem::stop_all(lmp, text_of(who(), "'volume v_", variable_, "' is ", volume, " at step ", update->ntimestep, "; it must be above 0"));
  return volume;
}

// LIGGGHTS knows its contacts within a run only.
void ComputeMpmStress::find_virials() {
  if (found_at_ == update->ntimestep) return;
  if (update->whichflag == 0)
    mpdem::stop_all(lmp, who() + "contacts are known within a run only; use it in thermo_style, a fix or a dump, or use 'run 0' before");
  found_at_ = update->ntimestep;
  virial_.clear();
  if (FixMpm* cement = FixMpm::of(*modify)) cement->add_virials(virial_);
  if (!contacts_) contacts_ = std::make_unique<mpdem::ContactForces>(lmp);
  contacts_->add_virials(virial_);
  virial_.sum_over(world);
}

void ComputeMpmStress::compute_vector() {
  invoked_vector = update->ntimestep;
  find_virials();
  double mine[kComponents] = {}, all[kComponents];
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!(atom->mask[i] & groupbit)) continue;
    const mpdem::GrainVirial::Sum sum = virial_.of(atom->tag[i]);
    for (int k = 0; k < kComponents; ++k) mine[k] += sum[k];
  }
  MPI_Allreduce(mine, all, kComponents, MPI_DOUBLE, MPI_SUM, world);
  const double inverse = 1.0 / volume();
  for (int k = 0; k < kComponents; ++k) vector[k] = all[k] * inverse;
}

void ComputeMpmStress::compute_peratom() {
  invoked_peratom = update->ntimestep;
  if (atom->nmax > size_) {
    memory->destroy(array_atom);
    size_ = atom->nmax;
    memory->create(array_atom, size_, kComponents, "mpm/stress:values");
  }
  find_virials();
  for (int i = 0; i < atom->nlocal; ++i) {
    const mpdem::GrainVirial::Sum sum = atom->mask[i] & groupbit ? virial_.of(atom->tag[i]) : mpdem::GrainVirial::Sum{};
    std::copy(sum.begin(), sum.end(), array_atom[i]);
  }
}

double ComputeMpmStress::memory_usage() { return static_cast<double>(size_) * kComponents * sizeof(double); }

}  // namespace LAMMPS_NS
