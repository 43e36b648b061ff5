// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "compute_mpm_atom.h"

#include <algorithm>
#include <array>
#include <vector>

#include "../../material/laws.h"
#include "../../mpm/material_runs.h"
#include "../../mpm/point_scatter.h"
#include "../../mpm/point_state.h"
#include "../words/arguments.h"
#include "atom.h"
#include "memory.h"
#include "../atoms/local_atom.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::kLanes;
using mpdem::Sym3;
using mpdem::vd;

namespace {

// In the order of kNames. Quantities of the law follow, see names_of(). value_of() relies on this order.
enum Quantity {
  kDamage,
  kDamageXX,
  kDamageYY,
  kDamageZZ,
  kDamageYZ,
  kDamageXZ,
  kDamageXY,
  kDrive,
  kStressXX,
  kStressYY,
  kStressZZ,
  kStressYZ,
  kStressXZ,
  kStressXY,
  kStressMax,
  kPressure,
  kStrainXX,
  kStrainYY,
  kStrainZZ,
  kStrainYZ,
  kStrainXZ,
  kStrainXY,
  kAttached,
  kGrain,
  kFailed,
  kVolume,
  kAxisX,
  kAxisY,
  kAxisZ,
  kBond,
  kMaterial,
  kModuliFactor,
  kStrengthFactor,
  kLinkArea,
  kTractionN,
  kTractionT,
};

const std::vector<std::string> kNames = {
    "damage",    "damage_xx", "damage_yy", "damage_zz", "damage_yz",     "damage_xz",       "damage_xy",     "drive",      "stress_xx",
    "stress_yy", "stress_zz", "stress_yz", "stress_xz", "stress_xy",     "stress_max",      "pressure",      "strain_xx",  "strain_yy",
    "strain_zz", "strain_yz", "strain_xz", "strain_xy", "attached",      "grain",           "failed",        "volume",     "axis_x",
    "axis_y",    "axis_z",    "bond",      "material",  "moduli_factor", "strength_factor", "attached_area", "traction_n", "traction_t",
};

vd component(const Sym3<vd>& s, int i) {
  const vd v[] = {s.xx, s.yy, s.zz, s.yz, s.xz, s.xy};
  return v[i];
}

// Names of all quantities, including those of the law.
std::vector<std::string> names_of(const mpdem::Law& law) {
  std::vector<std::string> all = kNames;
  for (const std::string& name : law.columns()) all.push_back(name);
  return all;
}

}  // namespace

ComputeMpmAtom::ComputeMpmAtom(LAMMPS* lmp, int& iarg, int narg, char** arg) : Compute(lmp, iarg, narg, arg) {
  mpdem::Arguments args(lmp, mpdem::text_of("compute mpm/atom (id ", id, ")"), narg, arg, iarg);
  peratom_flag = 1;
  size_peratom_cols = 0;
  // Compute does not initialise these. `write_dump` before a run reads the flag, which could then differ between ranks.
  vector_atom = nullptr;
  invoked_flag = 0;
  cement_id_ = args.word("the ID of a fix mpm");
  if (!find_cement()) args.complain("'" + cement_id_ + "' is not a fix mpm; define that fix before and name its ID here");
  const std::vector<std::string> names = names_of(find_cement()->law());
  name_ = args.choice("quantity", names);
  if (!args.empty()) args.complain("'" + args.word("") + "' is one word too many; define a compute for each quantity");
}

ComputeMpmAtom::~ComputeMpmAtom() { memory->destroy(vector_atom); }

FixMpm* ComputeMpmAtom::find_cement() const {
  const int i = modify->find_fix(cement_id_.c_str());
  return i < 0 ? nullptr : dynamic_cast<FixMpm*>(modify->fix[i]);
}

void ComputeMpmAtom::init() {
  cement_ = find_cement();
  if (!cement_) mpdem::stop_all(lmp, mpdem::text_of("compute mpm/atom (id ", id, "): fix mpm '", cement_id_, "' is gone"));
  const std::vector<std::string> names = names_of(cement_->law());
  quantity_ = static_cast<int>(std::find(names.begin(), names.end(), name_) - names.begin());
  if (quantity_ == static_cast<int>(names.size()))
    mpdem::stop_all(lmp, mpdem::text_of("compute mpm/atom (id ", id, "): fix mpm '", cement_id_, "' has 'damage ", cement_->law().name(),
                                        "', whose points have no '", name_, "'; define the compute anew after the fix"));
}

// Values of the points of a block, except those that depend on links.
template <class L>
vd ComputeMpmAtom::value_of(const mpdem::PointStore& points, int b, const L& law) const {
  const mpdem::PointBlock& p = points.blocks[b];
  const mpdem::BlockMeta& m = points.meta[b];
  const auto state = mpdem::state_of<L>(points, b);
  const mpdem::Mat3<vd> R = mpdem::product(axes_, mpdem::rotation_matrix(p.q));  // rotation from the material frame to the axes of the box
  if (quantity_ == kDamage) return law.largest_damage(state);
  if (quantity_ < kDrive) return component(mpdem::rotate(R, law.damage(state)), quantity_ - kDamageXX);
  if (quantity_ == kDrive) {
    const mpdem::LawDrive d = law.drive(p.strain, state, mpdem::softening_of(points, b, law));
    const vd strength = points.strength_factor(b) * mpdem::select(mpdem::lanes(m.linked), mpdem::splat(law.interface()), mpdem::splat(1.0));
    return mpdem::select(mpdem::lanes(m.failed), vd{}, d.Yeq / (strength * d.B));
  }
  if (quantity_ <= kPressure) {
    const Sym3<vd> s = mpdem::rotate(R, mpdem::stress_of(points, b, law));
    const vd v = quantity_ == kStressMax  ? mpdem::largest(mpdem::eigen(s))
                 : quantity_ == kPressure ? mpdem::trace(s) / -3.0
                                          : component(s, quantity_ - kStressXX);
    return mpdem::select(mpdem::lanes(m.failed), vd{}, v);
  }
  if (quantity_ <= kStrainXY) return component(mpdem::rotate(R, p.strain), quantity_ - kStrainXX);
  if (quantity_ == kFailed) return mpdem::select(mpdem::lanes(m.failed), mpdem::splat(1.0), vd{});
  if (quantity_ == kVolume) return p.volume;
  if (quantity_ >= kAxisX && quantity_ <= kAxisZ) return R.a[quantity_ - kAxisX][2];
  if (quantity_ == kBond) return mpdem::splat(m.row + 1.0);
  if (quantity_ == kMaterial) return mpdem::splat(m.material);
  if (quantity_ == kModuliFactor) return points.stiffness_factor(b);
  if (quantity_ == kStrengthFactor) return mpdem::drawn_strength(points, b);
  if (quantity_ > kTractionT) return law.column(quantity_ - kTractionT - 1, p.strain, state);
  return vd{};
}

void ComputeMpmAtom::compute_peratom() {
  invoked_peratom = update->ntimestep;
  init();  // `write_dump` evaluates computes without a run, possibly after `unfix`
  cement_->show_points();
  if (atom->nlocal > size_) {
    memory->destroy(vector_atom);
    size_ = atom->nmax;
    memory->create(vector_atom, size_, "mpm/atom:vector_atom");
  }
  const AtomVecMpdem* avec = cement_->cement();
  for (int i = 0; i < atom->nlocal; ++i) vector_atom[i] = 0.0;
  for (const mpdem::Bond& bond : avec->bonds) {
    for (const mpdem::PointStore* points : bond.stores()) {
      find_values(bond, *points);
      for (std::size_t b = 0; b < points->blocks.size(); ++b)
        for (int l = 0; l < kLanes; ++l) {
          if (!(points->meta[b].occupied >> l & 1)) continue;
          const int i = mpdem::local_atom(*atom, points->tags[b][l]);
          if (i >= 0 && (atom->mask[i] & groupbit)) vector_atom[i] = value_[b].v[l];
        }
    }
  }
}

// Finds the values of the points of a store, by blocks.
void ComputeMpmAtom::find_values(const mpdem::Bond& bond, const mpdem::PointStore& points) {
  const mpdem::BondRecord& record = cement_->cement()->bonds.record(bond);
  value_.resize(points.blocks.size());
  const mpdem::Mat3<double> axes = mpdem::axes_of(record);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) axes_.a[i][j] = mpdem::splat(axes.a[i][j]);
  mpdem::for_each_material(points, cement_->law(), [&](const auto& law, int first, int last) {
    for (int b = first; b < last; ++b) value_[static_cast<std::size_t>(b)].v = value_of(points, b, law);
  });
  // `attached` is 1 while the point is attached to a grain, 2 once the link has debonded. `grain` is the ID of that
  // grain. Tractions are those of this link. Of two links, that of the nearer grain counts.
  if (quantity_ != kAttached && quantity_ != kGrain && (quantity_ < kLinkArea || quantity_ > kTractionT)) return;
  std::vector<mpdem::PenaltyLinks::LinkTraction> tractions(points.links.size());
  if (quantity_ >= kTractionN && &points == &bond.points) tractions = cement_->link_tractions(bond);
  std::vector<std::array<int, mpdem::kLanes>> chosen(value_.size());  // grain whose link gave the value, 0: none
  for (auto& of_block : chosen) of_block.fill(0);
  for (std::size_t n = 0; n < points.links.size(); ++n) {
    const mpdem::Link& k = points.links[n];
    const int b = k.slot / kLanes, l = k.slot % kLanes;
    double X[3];
    for (int d = 0; d < 3; ++d) X[d] = points.created_at(b)[d][l];
    const int nearer = mpdem::nearer_grain(record, mpdem::nearer_to_first(record, X));
    if (chosen[b][l] != 0 && k.grain != record.grain[nearer]) continue;
    chosen[b][l] = k.grain;
    value_[b].v[l] = quantity_ == kGrain       ? k.grain
                     : quantity_ == kAttached  ? (k.attached ? 1.0 : 2.0)
                     : quantity_ == kLinkArea  ? (k.attached ? k.area : 0.0)
                     : quantity_ == kTractionN ? tractions[n].normal
                                               : tractions[n].tangential;
  }
}

double ComputeMpmAtom::memory_usage() { return static_cast<double>(size_) * sizeof(double); }

}  // namespace LAMMPS_NS
