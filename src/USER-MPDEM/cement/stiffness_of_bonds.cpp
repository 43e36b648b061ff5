// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The static stiffness of all bonds. Those of one rank are solved there, one by one, equal ones once. Those that ranks cut are solved
// by all ranks together, one after the other.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <unordered_map>

#include "../parallel/agree.h"
#include "cement.h"

namespace mpdem {

namespace {

constexpr double kAlike = 1e-9;  // of a cell, and of what has no unit

// All that the stiffness depends on, rounded so that equal bonds in other places have the same.
class Description {
 public:
  Description(const BondLayout& l, const Body& body, const GrainSide* side) {
    const double h = l.grid.h;
    for (int s = 0; s < 2; ++s) {
      add(&body.radius[s], 1, h);
      add(body.centre[s], 3, h);
      add(body.orientation[s], 4, 1.0);
      add(side[s].x, 3, h);
      add(side[s].R.a[0], 9, 1.0);
    }
    add(l.grid.displacement.data(), l.grid.displacement.size(), h);
    for (std::size_t b = 0; b < l.points.blocks.size(); ++b) {
      const PointBlock& p = l.points.blocks[b];
      add_vectors(p.X, 3, h);
      add_vectors(&p.volume, 1, h * h * h);
      add_vectors(&p.F, 9, 1.0);
      add_vectors(&p.q, 4, 1.0);
      numbers_.push_back(l.points.meta[b].failed);
      numbers_.push_back(l.points.meta[b].part);
    }
    for (const vd& state : l.points.states()) add_vectors(&state, 1, 1.0);
    for (const Link& k : l.points.links) {
      add(k.foot, 3, h);
      add(k.moved, 3, h);
      add(&k.area, 1, h * h);
      add(k.state, kMostLinkFields, 1.0);
      numbers_.push_back(k.slot);
      numbers_.push_back(k.attached + 2 * (k.grain == body.grain[1]));
    }
  }
  bool operator==(const Description& d) const { return numbers_ == d.numbers_; }
  std::size_t hash() const {
    std::size_t h = numbers_.size();
    for (double n : numbers_) h = (h ^ std::hash<double>()(n)) * 0x9e3779b97f4a7c15ull + (h >> 29);
    return h;
  }

 private:
  void add(const double* values, std::size_t count, double unit) {
    for (std::size_t i = 0; i < count; ++i) numbers_.push_back(std::nearbyint(values[i] / (kAlike * unit)) + 0.0);
  }
  void add_vectors(const void* vectors, std::size_t count, double unit) { add(static_cast<const double*>(vectors), kLanes * count, unit); }
  std::vector<double> numbers_;
};

void write(const StaticBond& found, const Body& body, StiffnessOfBond& to) {
  for (int d = 0; d < 3; ++d) {
    to.middle[d] = body.origin[d] + found.frame.middle[d];
    to.axis[d] = found.frame.axis[d];
  }
  std::copy(found.stiffness.data(), found.stiffness.data() + 36, to.K);
  to.products = found.products;
}

class StiffnessFinder {
 public:
  StiffnessFinder(const std::vector<Body>& table, std::vector<BondLayout>& layouts, const BondedGrains& grains, const Law& law)
      : table_(table), layouts_(layouts), grains_(grains), law_(law), found_(table.size(), StiffnessOfBond{}) {}

  // Bonds of this rank alone.
  void solve_whole() {
    std::unordered_multimap<std::size_t, int> solved;  // layouts by the hash of their description
    for (std::size_t n = 0; n < layouts_.size(); ++n) {
      if (layouts_[n].grid.halo.shares_any()) continue;
      const Description mine = description(n);
      const std::size_t hash = mine.hash();
      const auto range = solved.equal_range(hash);
      const auto equal = std::find_if(range.first, range.second, [&](const auto& s) { return description(s.second) == mine; });
      StiffnessOfBond& to = found_[layouts_[n].body];
      if (equal == range.second) {
        solve_one(MPI_COMM_SELF, layouts_[n].body, static_cast<int>(n));
        solved.emplace(hash, static_cast<int>(n));
        continue;
      }
      const int other = layouts_[equal->second].body;
      to = found_[other];
      to.products = 0.0;
      for (int d = 0; d < 3; ++d) to.middle[d] += table_[layouts_[n].body].origin[d] - table_[other].origin[d];
    }
  }

  // Collective.
  void solve_cut(MPI_Comm comm) {
    std::vector<char> cut(table_.size(), 0);
    std::vector<int> at(table_.size(), -1);
    for (std::size_t n = 0; n < layouts_.size(); ++n) {
      at[layouts_[n].body] = static_cast<int>(n);
      cut[layouts_[n].body] = layouts_[n].grid.halo.shares_any();
    }
    MPI_Allreduce(MPI_IN_PLACE, cut.data(), static_cast<int>(cut.size()), MPI_SIGNED_CHAR, MPI_MAX, comm);
    for (std::size_t row = 0; row < cut.size(); ++row)
      if (cut[row]) solve_one(comm, static_cast<int>(row), at[row]);
  }

  // Collective. The first rank that has a bond tells the others.
  std::vector<StiffnessOfBond> of_all(MPI_Comm comm) {
    int me;
    MPI_Comm_rank(comm, &me);
    std::vector<int> teller(table_.size(), std::numeric_limits<int>::max());
    for (const BondLayout& l : layouts_) teller[l.body] = me;
    MPI_Allreduce(MPI_IN_PLACE, teller.data(), static_cast<int>(teller.size()), MPI_INT, MPI_MIN, comm);
    for (std::size_t row = 0; row < teller.size(); ++row)
      if (teller[row] != me) found_[row] = StiffnessOfBond{};
    static_assert(sizeof(StiffnessOfBond) % sizeof(double) == 0, "numbers alone");
    constexpr int kNumbers = sizeof(StiffnessOfBond) / sizeof(double);
    MPI_Allreduce(MPI_IN_PLACE, found_.data(), kNumbers * static_cast<int>(found_.size()), MPI_DOUBLE, MPI_SUM, comm);
    return std::move(found_);
  }

 private:
  const GrainSide* side_of(int body) const { return &grains_.sides.sides[grains_.sides.find(body, 0)]; }
  Description description(int layout) const {
    const BondLayout& l = layouts_[layout];
    return Description(l, table_[l.body], side_of(l.body));
  }
  // layout: -1, this rank has nothing of the bond.
  void solve_one(MPI_Comm comm, int row, int layout) {
    if (layout < 0) {
      solve_static(comm, nullptr);
      return;
    }
    BondLayout& l = layouts_[layout];
    const StaticParts parts{l.points, l.grid, l.links, side_of(row), table_[row], law_};
    write(solve_static(comm, &parts), table_[row], found_[row]);
  }

  const std::vector<Body>& table_;
  std::vector<BondLayout>& layouts_;
  const BondedGrains& grains_;
  const Law& law_;
  std::vector<StiffnessOfBond> found_;
};

}  // namespace

std::vector<StiffnessOfBond> Cement::stiffness_of_bonds() {
  std::vector<BondLayout> layouts = layouts_of_copies(&*penalty_);
  BondedGrains grains(grains_);
  grains.bind(comm_, bonds_, inertia_);
  grains.distribute(bonds_);
  const int orphan = grains.sides.orphan();
  throw_if_any(comm_, orphan < 0 ? "" : text_of("grain ", grains.sides.sides[orphan].tag, " has cement but was deleted or lost; keep bonded grains"));
  StiffnessFinder finder(bonds_.table, layouts, grains, *law_);
  std::string trouble;
  try {
    finder.solve_whole();
  } catch (const BadState& e) {
    trouble = e.what();
  }
  throw_if_any(comm_, trouble);
  finder.solve_cut(comm_);
  return finder.of_all(comm_);
}

}  // namespace mpdem
