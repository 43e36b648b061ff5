// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "coated_contacts.h"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "atom.h"
#include "atom_vec_mpdem.h"
#include "fix_wall_gran.h"
#include "force.h"
#include "granular_pair_style.h"
#include "granular_wall.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair_gran_proxy.h"
#include "private_access.h"
#include "../words/arguments.h"

namespace mpdem {

using namespace LAMMPS_NS;
using LIGGGHTS::ContactModels::SurfacesIntersectData;
using LIGGGHTS::PairStyles::IGranularPairStyle;
using LIGGGHTS::Walls::IGranularWall;

namespace {

// Coats of the present scene, or null if there are none. read_restart makes another atom style.
GrainCoats* coats_of(LAMMPS* lmp) {
  AtomVecMpdem* const cement = AtomVecMpdem::of(lmp);
  return cement && !cement->coats.empty() ? &cement->coats : nullptr;
}

// LIGGGHTS' lists of neighbours and of the history of their contacts; those of the object's birth come back at its end.
class Lists {
 public:
  explicit Lists(PairGran& pair)
      : list_(*pair.list),
        history_(pair.listgranhistory),
        number_(list_.inum),
        rows_(list_.ilist),
        numbers_(list_.numneigh),
        first_(list_.firstneigh) {
    if (!history_) return;
    flags_ = history_->firstneigh;
    values_ = history_->firstdouble;
  }
  ~Lists() {
    list_.inum = number_;
    list_.ilist = rows_;
    list_.numneigh = numbers_;
    list_.firstneigh = first_;
    if (!history_) return;
    history_->firstneigh = flags_;
    history_->firstdouble = values_;
  }
  Lists(const Lists&) = delete;
  Lists& operator=(const Lists&) = delete;

 private:
  NeighList& list_;
  NeighList* const history_;
  const int number_;
  int* const rows_;
  int* const numbers_;
  int** const first_;
  int** flags_ = nullptr;
  double** values_ = nullptr;
};

// What a pair style sums up for output, which it sets to zero at each call.
struct Tallies {
  double energy[2], virial[6];
  std::vector<double> of_atoms;

  Tallies(const PairGran& pair, int atoms) : energy{pair.eng_vdwl, pair.eng_coul} {
    std::copy(pair.virial, pair.virial + 6, virial);
    if (!pair.evflag) return;  // the flags below are of an earlier step
    if (pair.eflag_atom) of_atoms.insert(of_atoms.end(), pair.eatom, pair.eatom + atoms);
    for (int i = 0; i < atoms && pair.vflag_atom; ++i) of_atoms.insert(of_atoms.end(), pair.vatom[i], pair.vatom[i] + 6);
  }
  void add_to(PairGran& pair, int atoms) const {
    pair.eng_vdwl += energy[0];
    pair.eng_coul += energy[1];
    for (int d = 0; d < 6; ++d) pair.virial[d] += virial[d];
    auto from = of_atoms.begin();
    for (int i = 0; i < atoms && pair.eflag_atom; ++i) pair.eatom[i] += *from++;
    for (int i = 0; i < atoms && pair.vflag_atom; ++i)
      for (int d = 0; d < 6; ++d) pair.vatom[i][d] += *from++;
  }
};

class CoatedPairs : public IGranularPairStyle {
 public:
  CoatedPairs(LAMMPS* lmp, IGranularPairStyle* model) : lmp_(lmp), model_(model) {}
  void settings(int n, char** words, LIGGGHTS::IContactHistorySetup* setup) override { model_->settings(n, words, setup); }
  void init_granular() override { model_->init_granular(); }
  void write_restart_settings(FILE* fp) override { model_->write_restart_settings(fp); }
  void read_restart_settings(FILE* fp, int64_t code) override { model_->read_restart_settings(fp, code); }
  int get_history_offset(const std::string name) override { return model_->get_history_offset(name); }
  double stressStrainExponent() override { return model_->stressStrainExponent(); }
  int64_t hashcode() override { return model_->hashcode(); }
  bool contact_match(const std::string type, const std::string name) override { return model_->contact_match(type, name); }
  void compute_force(PairGran* pair, int energies, int virials, int adds) override;

 private:
  void part(const PairGran& pair, const GrainCoats& coats);

  LAMMPS* const lmp_;
  const std::unique_ptr<IGranularPairStyle> model_;
  // By atom: numbers of neighbours that touch with coats and bare; where the bare ones begin, which follow the others.
  std::vector<int> coated_, bare_;
  std::vector<int*> first_, flags_;
  std::vector<double*> values_;
  std::vector<int> rows_;  // atoms with bare neighbours
};

// Reorders the neighbours of each atom, so that bare ones are last. The order within both kinds stays.
void CoatedPairs::part(const PairGran& pair, const GrainCoats& coats) {
  const Atom& atom = *lmp_->atom;
  const NeighList& list = *pair.list;
  const NeighList* const history = pair.listgranhistory;
  const std::size_t per_pair = history ? history->dnum : 0;
  // LIGGGHTS' arrays end with the last atom of the first group
  const std::size_t atoms = list.inum == 0 ? 0 : 1 + static_cast<std::size_t>(*std::max_element(list.ilist, list.ilist + list.inum));
  coated_.assign(atoms, 0);
  bare_.assign(atoms, 0);
  first_.assign(atoms, nullptr);
  flags_.assign(atoms, nullptr);
  values_.assign(atoms, nullptr);
  rows_.clear();
  std::vector<int> neighbours, flags;
  std::vector<double> values;
  for (int k = 0; k < list.inum; ++k) {
    const int i = list.ilist[k], n = list.numneigh[i];
    int* const row = list.firstneigh[i];
    const auto touches_bare = [&](int at) { return coats.touches_bare(atom.tag[i], atom.tag[row[at] & NEIGHMASK]); };
    std::vector<int> order;
    for (int at = 0; at < n; ++at)
      if (!touches_bare(at)) order.push_back(at);
    coated_[i] = static_cast<int>(order.size());
    if (coated_[i] == n) continue;
    for (int at = 0; at < n; ++at)
      if (touches_bare(at)) order.push_back(at);
    rows_.push_back(i);
    bare_[i] = n - coated_[i];
    neighbours.assign(row, row + n);
    for (int at = 0; at < n; ++at) row[at] = neighbours[order[at]];
    first_[i] = row + coated_[i];
    if (!history) continue;
    int* const flag = history->firstneigh[i];
    double* const value = history->firstdouble[i];
    flags.assign(flag, flag + n);
    values.assign(value, value + per_pair * n);
    for (int at = 0; at < n; ++at) {
      flag[at] = flags[order[at]];
      std::copy_n(&values[per_pair * order[at]], per_pair, value + per_pair * at);
    }
    flags_[i] = flag + coated_[i];
    values_[i] = value + per_pair * coated_[i];
  }
}

void CoatedPairs::compute_force(PairGran* pair, int energies, int virials, int adds) {
  GrainCoats* const coats = coats_of(lmp_);
  if (!coats) return model_->compute_force(pair, energies, virials, adds);
  Atom& atom = *lmp_->atom;
  if (lmp_->neighbor->ago == 0) {
    coats->find_atoms(atom);
    part(*pair, *coats);
  }
  const Lists restored(*pair);
  pair->list->numneigh = coated_.data();
  model_->compute_force(pair, energies, virials, adds);
  if (rows_.empty()) return;
  const int atoms = atom.nlocal + atom.nghost;
  const Tallies before(*pair, atoms);
  NeighList& list = *pair->list;
  list.inum = static_cast<int>(rows_.size());
  list.ilist = rows_.data();
  list.numneigh = bare_.data();
  list.firstneigh = first_.data();
  if (pair->listgranhistory) {
    pair->listgranhistory->firstneigh = flags_.data();
    pair->listgranhistory->firstdouble = values_.data();
  }
  const BareRadii bare(*coats, atom);
  model_->compute_force(pair, energies, virials, adds);
  if (pair->evflag) before.add_to(*pair, atoms);
}

class CoatedWall : public IGranularWall {
 public:
  CoatedWall(LAMMPS* lmp, IGranularWall* model) : lmp_(lmp), model_(model) {}
  void settings(int n, char** words, LIGGGHTS::IContactHistorySetup* setup) override { model_->settings(n, words, setup); }
  void init_granular() override { model_->init_granular(); }
  bool checkSurfaceIntersect(SurfacesIntersectData& contact) override { return model_->checkSurfaceIntersect(contact); }
  int get_history_offset(std::string name) override { return model_->get_history_offset(name); }
  bool contact_match(const std::string type, const std::string name) override { return model_->contact_match(type, name); }
  // deltan is the overlap with the wall. Where it is only that of the coat, the model ends the contact.
  void compute_force(FixWallGran* wall, SurfacesIntersectData& contact, bool touches, double* velocity, FixMeshSurface* fix, int mesh_index,
                     TriMesh* mesh, int triangle) override {
    GrainCoats* const coats = coats_of(lmp_);
    const Coat* const coat = coats ? coats->find(lmp_->atom->tag[contact.i]) : nullptr;
    if (coat && coat->at_walls && touches) coats->note_at_wall(*coat, contact.deltan);
    if (coat && !coat->at_walls) {
      const double distance = contact.radi - contact.deltan;
      contact.radi = coat->radius;
      contact.deltan = coat->radius - distance;
      touches = touches && contact.deltan >= 0.0;
    }
    model_->compute_force(wall, contact, touches, velocity, fix, mesh_index, mesh, triangle);
  }

 private:
  LAMMPS* const lmp_;
  const std::unique_ptr<IGranularWall> model_;
};

// `impl` of a wall, for which LIGGGHTS has no accessor.
struct WallModel : FixWallGran {
  static IGranularWall*& of(FixWallGran& wall) { return wall.*(&WallModel::impl); }
};

}  // namespace

std::string touch_coats(LAMMPS* lmp) {
  if (Pair* const pair = lmp->force->pair) {
    PairGranProxy* const contacts = dynamic_cast<PairGranProxy*>(pair);
    if (!contacts) return text_of("pair style '", lmp->force->pair_style, "' does not know coats of grains; use pair style 'gran'");
    if (contacts->contact_match("surface", "multicontact"))
      return "surface model 'multicontact' does not know coats of grains; use 'surface default'";
    IGranularPairStyle*& model = model_of(contacts);
    if (model && !dynamic_cast<CoatedPairs*>(model)) model = new CoatedPairs(lmp, model);
  }
  for (int n = 0; n < lmp->modify->nfix; ++n) {
    FixWallGran* const wall = dynamic_cast<FixWallGran*>(lmp->modify->fix[n]);
    if (!wall) continue;
    IGranularWall*& model = WallModel::of(*wall);
    if (model && !dynamic_cast<CoatedWall*>(model)) model = new CoatedWall(lmp, model);
  }
  return "";
}

void warn_of_coats_at_walls(LAMMPS* lmp, const std::string& who) {
  GrainCoats* const coats = coats_of(lmp);
  if (!coats || !coats->are_new()) return;
  bool walls = false;
  for (int n = 0; n < lmp->modify->nfix; ++n) walls = walls || dynamic_cast<FixWallGran*>(lmp->modify->fix[n]);
  if (!walls) return;
  const GrainCoats::AtWalls found = coats->take_at_walls(lmp->world);
  if (found.grains == 0) return;
  warn(lmp,
       text_of(who, found.grains, " coated grains press walls before the first step, the deepest by ", found.deepest,
               " of the thickness of its coat: walls at the place of the bare grains load the coats; use 'walls bare' of create_cement, or "
               "walls that stand off by the thickness"));
}

}  // namespace mpdem
