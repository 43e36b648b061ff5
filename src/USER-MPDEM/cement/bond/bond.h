// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Bond has all data of the cement between two grains on this rank. The data are kept together, so a small bond stays in
// cache from one exchange to the next. Each bond is laid out, advanced and sent by itself.
//
// Bonds has the bonds of this rank, and the table of all bonds, which is the same on every rank.
#ifndef MPDEM_CEMENT_BOND_BOND_H
#define MPDEM_CEMENT_BOND_BOND_H

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "../../coupling/added_mass.h"
#include "../../coupling/film.h"
#include "../../coupling/penalty_links.h"
#include "../../mpm/advance_updated.h"
#include "../../mpm/bond_mechanism.h"
#include "../../mpm/drive_average.h"
#include "../../mpm/grid.h"
#include "../../mpm/point_template.h"
#include "../../mpm/point_store.h"

namespace mpdem {

struct Bond {
  int row = 0;        // row of the table
  PointStore points;  // all but the film
  Film film;
  Grid grid;
  PenaltyLinks links;
  AddedMass added;
  using Mechanisms = std::vector<std::unique_ptr<BondMechanism>>;
  Mechanisms mechanisms;            // mechanisms that act in the scene, see cement/layout/mechanisms.h
  UpdatedPass updated;              // used by `updated` kinematics only
  int first_end_index = 0;          // index of the first end of the bond in BondEnds::ends
  int layout = 0;                   // number of its layout on this rank; 0: none yet
  std::size_t laid_out_blocks = 0;  // number of point blocks that the grid has nodes for
  bool unmoved = false;             // resting: no point is strained and no node has moved since the layout; a step changes no point
  bool near_threshold = false;      // some point is near its threshold or damage grew; nonlocal damage only
  DriveAverage average;
  std::vector<int> failed;                // slots that failed in this step, ascending
  std::vector<int> debonded_with_points;  // indices in points.links of links that debonded with failed points, ascending
  LinkStep link_step;                     // result of the traction law in this step
  std::vector<double> transfer_change;    // change of the nodal velocity by transfer in this step, or empty
  std::vector<double> filtered;           // the part of `transfer_change` that nodes get before they move, xpic only

  // The mechanism of type P; null if it does not act in this bond.
  template <class P>
  P* mechanism() const {
    for (const std::unique_ptr<BondMechanism>& p : mechanisms)
      if (P* found = dynamic_cast<P*>(p.get())) return found;
    return nullptr;
  }
  bool cut_by_ranks() const { return grid.halo.shares_any(); }
  // Points are in two stores: points on the grid, and columns of the film. A slot number of the bond is the slot in the
  // store plus kFilm times the number of the store.
  enum { kOnGrid, kColumns };
  static constexpr int kFilm = 1 << 30;
  static int slot_in_store(int slot) { return slot % kFilm; }
  static int store_number(int slot) { return slot / kFilm; }
  std::array<PointStore*, 2> stores() { return {&points, &film.points}; }
  std::array<const PointStore*, 2> stores() const { return {&points, &film.points}; }
  const PointStore& store_of(int slot) const { return *stores()[store_number(slot)]; }
  int add(const PointRecord& r, int tag) {
    const int number = r.film;
    return kFilm * number + stores()[number]->add(r, tag);
  }
  PointRecord record(int slot) const {
    PointRecord r = store_of(slot).record(slot_in_store(slot));
    r.film = store_number(slot);
    return r;
  }
  void release(int slot) { stores()[store_number(slot)]->release(slot_in_store(slot)); }
  // Did the last layout of the bond include this slot?
  bool is_laid_out(int slot) const {
    const std::size_t blocks[] = {laid_out_blocks, film.laid_out_blocks()};
    return static_cast<std::size_t>(slot_in_store(slot)) < kLanes * blocks[store_number(slot)];
  }
  // for_each_slot_of() calls f(slot) for the points of one store, for_each_slot() for those of both.
  template <class F>
  void for_each_slot_of(int number, F f) const {
    const PointStore& store = *stores()[number];
    for (std::size_t b = 0; b < store.meta.size(); ++b)
      for (int l = 0; l < kLanes; ++l)
        if (store.meta[b].occupied >> l & 1) f(kFilm * number + kLanes * static_cast<int>(b) + l);
  }
  template <class F>
  void for_each_slot(F f) const {
    for (int number : {kOnGrid, kColumns}) for_each_slot_of(number, f);
  }
  int size() const { return points.size() + film.points.size(); }
  bool changed() const { return points.changed() || film.points.changed(); }
  // True if this rank has points of the bond. A bond whose last point left remains until the next layout.
  bool has_points() const { return size() > 0; }
  // Prefetch the memory of the next bond. prefetch_nodes() fetches what a pass over its nodes reads out of order, which
  // the hardware prefetcher cannot predict. prefetch_step() fetches the beginnings of what a step reads in order.
  void prefetch_nodes() const {
    for (const std::vector<double>* v : {&grid.force, &grid.displacement}) prefetch_bytes(v->data(), sizeof(double) * v->size());
    prefetch_bytes(added.masses().data(), sizeof(AddedMass::EightMasses) * added.masses().size());
  }
  void prefetch_step() const {
    constexpr std::size_t kBeginning = 256;
    for (const std::vector<double>* v : {&grid.velocity, &grid.displacement, &grid.acceleration, &grid.force})
      prefetch_bytes(v->data(), std::min(kBeginning, sizeof(double) * v->size()));
    for (int b = 0; b < std::min(2, static_cast<int>(points.blocks.size())); ++b) points.prefetch(b);
  }
  // Sorts links by the slots of their points. Slots change as points move between cells.
  void sort_links();
  // Shares the memory of lists with other bonds that have equal lists.
  void share(AlikeLists& alike) {
    grid.share(alike);
    added.share(alike);
    links.share(alike);
  }
  std::size_t memory_usage() const {
    std::size_t of_mechanisms = mechanisms.capacity() * sizeof(Mechanisms::value_type);
    for (const std::unique_ptr<BondMechanism>& p : mechanisms) of_mechanisms += p->memory_usage();
    return points.memory_usage() + film.memory_usage() + grid.memory_usage() + links.memory_usage() + added.memory_usage() +
           average.memory_usage() + updated.memory_usage() + of_mechanisms +
           sizeof(double) * (transfer_change.capacity() + filtered.capacity());
  }
};

class Bonds {
 public:
  std::vector<BondRecord> table;         // bonds of all ranks
  std::vector<PointTemplate> templates;  // templates of bonds whose points are made later, the same on all ranks
  // Materials that the script named, the same on all ranks; the first has number 1. words: its keywords and values, between blanks.
  struct NamedMaterial {
    std::string name, words;
    double density = 0.0;  // of its own; 0: that of create_cement
  };
  // Density of its own of a material; 0: none.
  double own_density(int material) const {
    const std::size_t n = static_cast<std::size_t>(material) - 1;
    return n < materials.size() ? materials[n].density : 0.0;
  }
  std::vector<NamedMaterial> materials;

  // Iterators over the bonds with points or nodes on this rank, in ascending order of their rows. The address of a bond
  // does not change when others are added or dropped.
  using Slot = std::unique_ptr<Bond>;
  template <class B>
  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = Bond;
    using difference_type = std::ptrdiff_t;
    using pointer = B*;
    using reference = B&;
    explicit Iterator(const Slot* at) : at_(at) {}
    B& operator*() const { return **at_; }
    B* operator->() const { return at_->get(); }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return at_ == other.at_; }
    bool operator!=(const Iterator& other) const { return at_ != other.at_; }

   private:
    const Slot* at_;
  };
  Iterator<Bond> begin() { return Iterator<Bond>(here_.data()); }
  Iterator<Bond> end() { return Iterator<Bond>(here_.data() + here_.size()); }
  Iterator<const Bond> begin() const { return Iterator<const Bond>(here_.data()); }
  Iterator<const Bond> end() const { return Iterator<const Bond>(here_.data() + here_.size()); }
  std::size_t size() const { return here_.size(); }

  // Iterator over the resolved bonds. It skips condensed bonds, whose nodes and points take no part in the step.
  template <class B>
  class Resolved {
   public:
    Resolved(const Slot* bonds, const int* at) : bonds_(bonds), at_(at) {}
    B& operator*() const { return *bonds_[*at_]; }
    Resolved& operator++() {
      ++at_;
      return *this;
    }
    bool operator!=(const Resolved& other) const { return at_ != other.at_; }

   private:
    const Slot* bonds_;
    const int* at_;
  };
  template <class B>
  struct ResolvedRange {
    const Slot* bonds;
    const std::vector<int>& indices;
    Resolved<B> begin() const { return {bonds, indices.data()}; }
    Resolved<B> end() const { return {bonds, indices.data() + indices.size()}; }
  };
  // Calls f(bond, next) for all resolved bonds, in ascending order or backwards. next: the bond that follows in this
  // order, or null.
  template <class F>
  void for_each_resolved(F f) {
    const std::vector<int>& indices = resolved_indices();
    for (std::size_t n = 0; n < indices.size(); ++n) f(*here_[indices[n]], n + 1 < indices.size() ? here_[indices[n + 1]].get() : nullptr);
  }
  template <class F>
  void for_each_resolved_backwards(F f) {
    const std::vector<int>& indices = resolved_indices();
    for (std::size_t n = indices.size(); n-- > 0;) f(*here_[indices[n]], n > 0 ? here_[indices[n - 1]].get() : nullptr);
  }
  ResolvedRange<Bond> resolved() { return {here_.data(), resolved_indices()}; }
  ResolvedRange<const Bond> resolved() const { return {here_.data(), resolved_indices()}; }
  // Call after changes of BondRecord::condensed, on all ranks. resolved_changes() counts these calls.
  void resolved_changed() { resolved_is_known_ = false, ++resolved_changes_; }
  int resolved_changes_ = 0;
  int resolved_changes() const { return resolved_changes_; }
  bool is_resolved(const Bond& b) const { return !table[b.row].condensed; }

  const BondRecord& record(const Bond& b) const { return table[b.row]; }
  // Are all points of the bond on this rank?
  bool is_whole(const Bond& b) const { return b.size() == table[b.row].points; }
  // Rows of the bonds that are not condensed, ascending, the same on all ranks.
  std::vector<int> resolved_rows() const;
  // Rows of the bonds whose points are not made yet, ascending, the same on all ranks. template_of(): their template.
  std::vector<int> rows_without_points() const;
  const PointTemplate& template_of(int row) const { return templates[table[row].point_template - 1]; }
  // Returns null if this rank has neither points nor nodes of the bond.
  Bond* find(int bond_row);
  const Bond* find(int bond_row) const;
  Bond& make(int bond_row);  // returns the existing bond if there is one
  // Drops all bonds that have no points on this rank, if one of these rows is such a bond; else nothing.
  void drop_empty(const std::vector<int>& rows);

  // Adds a point to its bond, and returns its slot.
  int add(const PointRecord& r, int tag) { return make(r.row).add(r, tag); }

  std::size_t memory_usage() const;

 private:
  std::vector<Slot>::const_iterator slot_of(int bond_row) const;  // entry of the bond, or where to insert it
  const std::vector<int>& resolved_indices() const;

  std::vector<Slot> here_;
  mutable std::vector<int> resolved_;
  mutable bool resolved_is_known_ = false;
};

}  // namespace mpdem

#endif
