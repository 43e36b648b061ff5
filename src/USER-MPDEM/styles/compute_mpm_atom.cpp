// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "compute_mpm_atom.h"

#include <algorithm>

#include "arguments.h"
#include "atom.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::kLanes;
using mpdem::Sym3;
using mpdem::vd;

namespace {

enum Quantity {
  kDamage, kDamageXX, kDamageYY, kDamageZZ, kDamageYZ, kDamageXZ, kDamageXY,
  kDrive,
  kStressXX, kStressYY, kStressZZ, kStressYZ, kStressXZ, kStressXY, kStressMax, kPressure,
  kStrainXX, kStrainYY, kStrainZZ, kStrainYZ, kStrainXZ, kStrainXY,
  kAttached, kGrain, kFailed, kVolume, kAxisX, kAxisY, kAxisZ, kBond,
};

const std::vector<std::string> kNames = {
    "damage", "damage_xx", "damage_yy", "damage_zz", "damage_yz", "damage_xz", "damage_xy",
    "drive",
    "stress_xx", "stress_yy", "stress_zz", "stress_yz", "stress_xz", "stress_xy", "stress_max", "pressure",
    "strain_xx", "strain_yy", "strain_zz", "strain_yz", "strain_xz", "strain_xy",
    "attached", "grain", "failed", "volume", "axis_x", "axis_y", "axis_z", "bond",
};

vd component(const Sym3<vd>& s, int i) {
  const vd v[] = {s.xx, s.yy, s.zz, s.yz, s.xz, s.xy};
  return v[i];
}

}  // namespace

ComputeMpmAtom::ComputeMpmAtom(LAMMPS* lmp, int& iarg, int narg, char** arg) : Compute(lmp, iarg, narg, arg) {
  mpdem::Arguments args(lmp, mpdem::text_of("compute mpm/atom (id ", id, ")"), narg, arg, iarg);
  peratom_flag = 1;
  size_peratom_cols = 0;
  vector_atom = nullptr;  // Compute does not set it
  cement_id_ = args.word("the ID of a fix mpm");
  if (!find_cement()) args.complain("'" + cement_id_ + "' is not a fix mpm; define that fix before and name its ID here");
  const std::string name = args.choice("quantity", kNames);
  quantity_ = static_cast<int>(std::find(kNames.begin(), kNames.end(), name) - kNames.begin());
  if (!args.empty()) args.unknown(args.word(""), {"nothing; one quantity a compute"});
}

ComputeMpmAtom::~ComputeMpmAtom() { memory->destroy(vector_atom); }

FixMpm* ComputeMpmAtom::find_cement() const {
  const int i = modify->find_fix(cement_id_.c_str());
  return i < 0 ? nullptr : dynamic_cast<FixMpm*>(modify->fix[i]);
}

void ComputeMpmAtom::init() {
  cement_ = find_cement();
  if (!cement_)
    mpdem::stop_all(lmp, mpdem::text_of("compute mpm/atom (id ", id, "): fix mpm '", cement_id_, "' is gone"));
}

void ComputeMpmAtom::compute_peratom() {
  invoked_peratom = update->ntimestep;
  cement_->sync_slots();
  if (atom->nlocal > size_) {
    memory->destroy(vector_atom);
    size_ = atom->nmax;
    memory->create(vector_atom, size_, "mpm/atom:vector_atom");
  }
  const AtomVecMpdem* avec = cement_->cement();
  for (int i = 0; i < atom->nlocal; ++i) vector_atom[i] = 0.0;
  for (const mpdem::Bond& bond : avec->bonds) {
    find_values(bond, avec->bonds.body(bond));
    for (std::size_t b = 0; b < bond.points.blocks.size(); ++b)
      for (int l = 0; l < kLanes; ++l) {
        if (!(bond.points.meta[b].occupied >> l & 1)) continue;
        const int i = atom->map(bond.points.tags[b][l]);
        if (i >= 0 && i < atom->nlocal && (atom->mask[i] & groupbit)) vector_atom[i] = value_[b].v[l];
      }
  }
}

// Of the points of a bond, by blocks.
void ComputeMpmAtom::find_values(const mpdem::Bond& bond, const mpdem::Body& body) {
  const mpdem::PointStore& points = bond.points;
  const mpdem::TensorDamage& law = cement_->law();
  value_.resize(points.blocks.size());
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const mpdem::PointBlock& p = points.blocks[b];
    const mpdem::BlockMeta& m = points.meta[b];
    const Sym3<vd>& D = points.damage[b].D;
    const mpdem::Mat3<vd> R = mpdem::rotation_matrix(p.q);
    vd& v = value_[b].v;
    if (quantity_ == kDamage) {
      v = mpdem::largest(mpdem::eigen(D));
    } else if (quantity_ < kDrive) {
      v = component(mpdem::rotate(R, D), quantity_ - kDamageXX);
    } else if (quantity_ == kDrive) {
      const mpdem::TensorDamage::Drive d = law.drive(p.strain, D);
      const vd strength = mpdem::select(mpdem::lanes(m.linked), mpdem::splat(law.parameters().interface), mpdem::splat(1.0));
      v = law.parameters().B0 > 0.0 ? mpdem::select(mpdem::lanes(m.failed), vd{}, d.Yeq / (strength * d.B)) : vd{};
    } else if (quantity_ <= kPressure) {
      Sym3<vd> s = mpdem::rotate(R, m.damaged ? law.stress(p.strain, D) : law.elasticity().stress(p.strain));
      if (quantity_ == kStressMax) v = mpdem::largest(mpdem::eigen(s));
      else if (quantity_ == kPressure) v = mpdem::trace(s) / -3.0;
      else v = component(s, quantity_ - kStressXX);
      v = mpdem::select(mpdem::lanes(m.failed), vd{}, v);
    } else if (quantity_ <= kStrainXY) {
      v = component(mpdem::rotate(R, p.strain), quantity_ - kStrainXX);
    } else if (quantity_ == kFailed) {
      v = mpdem::select(mpdem::lanes(m.failed), mpdem::splat(1.0), vd{});
    } else if (quantity_ == kVolume) {
      v = p.volume;
    } else if (quantity_ >= kAxisX && quantity_ <= kAxisZ) {
      v = R.a[quantity_ - kAxisX][2];
    } else if (quantity_ == kBond) {
      v = mpdem::splat(m.body + 1.0);
    } else {
      v = vd{};
    }
  }
  // 1 while attached to a grain, 2 once it has let go; the tag of that grain. Of two links those of the nearer grain.
  if (quantity_ == kAttached || quantity_ == kGrain)
    for (const mpdem::Link& k : points.links) {
      const int b = k.slot / kLanes, l = k.slot % kLanes;
      double X[3];
      for (int d = 0; d < 3; ++d) X[d] = points.created_at(b)[d][l];
      const int nearer = mpdem::nearer_side(body, mpdem::nearer_to_first(body, X));
      if (value_[b].v[l] == 0.0 || k.grain == body.grain[nearer]) value_[b].v[l] = quantity_ == kGrain ? k.grain : k.attached ? 1.0 : 2.0;
    }
}

double ComputeMpmAtom::memory_usage() { return static_cast<double>(size_) * sizeof(double); }

}  // namespace LAMMPS_NS
