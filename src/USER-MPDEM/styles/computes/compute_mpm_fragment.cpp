// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "compute_mpm_fragment.h"

#include <algorithm>
#include <vector>

#include "../../parallel/gather_ranks.h"
#include "../fixes/fix_mpm.h"
#include "../words/arguments.h"
#include "atom.h"
#include "../atoms/atom_vec_mpdem.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

namespace {

// Values of the vector, which scripts use by their numbers.
enum Value { kGroups, kJoined, kLargest, kShareLargest, kSingle, kValues };

// Smallest ID of the grains that are joined to this one, with shorter ways for later calls.
int first_of(std::map<int, int>& parent, int tag) {
  int first = tag;
  while (parent[first] != first) first = parent[first];
  while (parent[tag] != first) tag = std::exchange(parent[tag], first);
  return first;
}

}  // namespace

ComputeMpmFragment::ComputeMpmFragment(LAMMPS* lmp, int& iarg, int narg, char** arg) : Compute(lmp, iarg, narg, arg) {
  mpdem::Arguments args(lmp, mpdem::text_of("compute mpm/fragment (id ", id, ")"), narg, arg, iarg);
  if (!AtomVecMpdem::of(lmp)) args.complain(mpdem::text_of("atom style '", atom->atom_style, "' has no cement; use 'atom_style mpdem'"));
  if (!args.empty()) args.complain("'" + args.word("") + "' is one word too many; the form is 'compute ID group-ID mpm/fragment'");
  peratom_flag = vector_flag = 1;
  size_peratom_cols = 0;
  size_vector = kValues;
  extvector = 0;
  vector_atom = nullptr;
  invoked_flag = 0;
  vector = new double[kValues];
}

ComputeMpmFragment::~ComputeMpmFragment() {
  memory->destroy(vector_atom);
  delete[] vector;
}

// By the ID of each grain that has cement: the smallest ID of the grains that bonds with cement join to it, the same on all
// ranks. A bond joins its grains until it is separated.
std::map<int, int> ComputeMpmFragment::joined_grains() const {
  const FixMpm* cement = FixMpm::of(*modify);
  const std::vector<mpdem::BondRecord>& table = AtomVecMpdem::of(lmp)->bonds.table;
  std::map<int, int> parent;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const mpdem::BondRecord& b = table[row];
    if (!b.has_grain(0) || !b.has_grain(1) || (cement && cement->engine().cracks().separated(row))) continue;
    for (int tag : b.grain) parent.emplace(tag, tag);
    const int roots[] = {first_of(parent, b.grain[0]), first_of(parent, b.grain[1])};
    parent[std::max(roots[0], roots[1])] = std::min(roots[0], roots[1]);
  }
  for (auto& of_tag : parent) of_tag.second = first_of(parent, of_tag.first);
  return parent;
}

void ComputeMpmFragment::compute_peratom() {
  invoked_peratom = update->ntimestep;
  if (atom->nmax > size_) {
    memory->destroy(vector_atom);
    size_ = atom->nmax;
    memory->create(vector_atom, size_, "mpm/fragment:values");
  }
  const std::map<int, int> joined = joined_grains();
  const AtomVecMpdem& avec = *AtomVecMpdem::of(lmp);
  for (int i = 0; i < atom->nlocal; ++i) {
    vector_atom[i] = 0.0;
    if (!(atom->mask[i] & groupbit) || avec.is_point(i)) continue;
    const auto at = joined.find(atom->tag[i]);
    vector_atom[i] = at == joined.end() ? atom->tag[i] : at->second;
  }
}

void ComputeMpmFragment::compute_vector() {
  invoked_vector = update->ntimestep;
  struct Part {
    int first;
    double grains, mass;
  };
  std::map<int, Part> mine;
  const std::map<int, int> joined = joined_grains();
  const AtomVecMpdem& avec = *AtomVecMpdem::of(lmp);
  Part single{0, 0.0, 0.0}, all{0, 0.0, 0.0};
  double heaviest_single = 0.0;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!(atom->mask[i] & groupbit) || avec.is_point(i)) continue;
    const auto at = joined.find(atom->tag[i]);
    if (at == joined.end()) heaviest_single = std::max(heaviest_single, atom->rmass[i]);
    Part& part = at == joined.end() ? single : mine.emplace(at->second, Part{at->second, 0.0, 0.0}).first->second;
    part.grains += 1.0;
    part.mass += atom->rmass[i];
  }
  std::vector<Part> parts;
  for (const auto& p : mine) parts.push_back(p.second);
  std::map<int, Part> of_all;
  for (const Part& p : mpdem::gather_all(world, parts)) {
    Part& sum = of_all.emplace(p.first, Part{p.first, 0.0, 0.0}).first->second;
    sum.grains += p.grains;
    sum.mass += p.mass;
  }
  double singles[2] = {single.grains, single.mass};
  MPI_Allreduce(MPI_IN_PLACE, singles, 2, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, &heaviest_single, 1, MPI_DOUBLE, MPI_MAX, world);
  all.mass = singles[1];
  Part largest{0, singles[0] > 0.0 ? 1.0 : 0.0, heaviest_single};
  for (const auto& p : of_all) {
    all.grains += p.second.grains;
    all.mass += p.second.mass;
    if (p.second.mass > largest.mass) largest = p.second;
  }
  vector[kGroups] = static_cast<double>(of_all.size()) + singles[0];
  vector[kJoined] = static_cast<double>(of_all.size());
  vector[kLargest] = largest.grains;
  vector[kShareLargest] = all.mass > 0.0 ? largest.mass / all.mass : 0.0;
  vector[kSingle] = singles[0];
}

double ComputeMpmFragment::memory_usage() { return static_cast<double>(size_) * sizeof(double); }

}  // namespace LAMMPS_NS
