// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The coats of all grains (coupling/coat.h), the same table on every rank. LIGGGHTS' radius, mass and density of a coated
// grain are those with its coat, so that its neighbour lists, gravity, output and restart files have the coat. Three
// things differ from a sphere of that radius and mass: the moment of inertia, contacts of bare pairs, and those of
// walls if a coat is not `at_walls`. CoatedTorques and BareRadii are for these (styles/atoms/coated_contacts.h).
#ifndef MPDEM_STYLES_ATOMS_GRAIN_COATS_H
#define MPDEM_STYLES_ATOMS_GRAIN_COATS_H

#include <mpi.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "../../coupling/coat.h"

namespace LAMMPS_NS {
class Atom;
}

namespace mpdem {

class GrainCoats {
 public:
  using Pairs = std::vector<std::pair<int, int>>;  // IDs of grains, each pair ascending

  bool empty() const { return coats_.empty(); }
  const std::vector<Coat>& all() const { return coats_; }
  const Coat* find(int tag) const {
    const auto found = row_.find(tag);
    return found == row_.end() ? nullptr : &coats_[found->second];
  }
  // Adds coats of grains that have none. Every rank passes the same.
  void add(const std::vector<Coat>& coats);
  // Adds pairs that touch with their bare surfaces. Pairs of grains without coats are left out.
  void touch_bare(const Pairs& pairs);
  bool touches_bare(int a, int b) const { return bare_.count(key(a, b)) != 0; }

  // Radius and mass without the coat, of a grain of this ID, radius and mass.
  double bare_radius(int tag, double radius) const {
    const Coat* c = empty() ? nullptr : find(tag);
    return c ? c->radius : radius;
  }
  // Radius with its coat, or the other value if it has none.
  double outer_radius(int tag, double otherwise) const {
    const Coat* c = empty() ? nullptr : find(tag);
    return c ? c->outer() : otherwise;
  }
  double bare_mass(int tag, double mass) const {
    const Coat* c = empty() ? nullptr : find(tag);
    return c ? c->mass : mass;
  }
  double inertia(int tag, double radius, double mass) const {
    const Coat* c = empty() ? nullptr : find(tag);
    return c ? c->inertia() : 0.4 * mass * radius * radius;
  }

  // Grains whose coat overlaps walls before the first step with these coats and with walls.
  void note_at_wall(const Coat& coat, double overlap);
  struct AtWalls {
    int grains = 0;
    double deepest = 0.0;  // largest overlap over the thickness of the coat
  };
  bool are_new() const { return new_; }  // were coats added since take_at_walls()? The same on all ranks
  // Collective. Returns these grains and forgets them.
  AtWalls take_at_walls(MPI_Comm comm);

  void write(std::FILE* fp) const;
  // Replaces the table by that of a file. most: numbers that the file has at most. Returns what is wrong, or an empty text.
  std::string read_file(std::FILE* fp, long long most);
  void share(MPI_Comm comm);  // collective: replaces the table by that of the first rank

  // Finds the atoms of coated grains, ghosts too. Call it after atoms were reordered or exchanged.
  void find_atoms(const LAMMPS_NS::Atom& atom);
  struct CoatedAtom {
    int i;
    double bare, outer;    // radii
    double torque_factor;  // 2/5 m r^2 of LIGGGHTS over the moment of inertia
  };
  const std::vector<CoatedAtom>& atoms() const { return atoms_; }

  // Between these LIGGGHTS integrates. It divides torques by 2/5 m r^2; scaled, they give the exact angular acceleration.
  void scale_torques(LAMMPS_NS::Atom& atom);
  void restore_torques(LAMMPS_NS::Atom& atom);

 private:
  std::vector<double> packed() const;
  void read(RecordReader& in);
  static std::uint64_t key(int a, int b) {
    if (a > b) std::swap(a, b);
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
  }

  std::vector<Coat> coats_;  // ascending in ID
  std::unordered_map<int, int> row_;
  std::vector<BarePair> pairs_;
  std::unordered_set<std::uint64_t> bare_;  // keys of these pairs
  std::vector<CoatedAtom> atoms_;           // local ones first
  std::vector<double> torques_;             // while they are scaled
  bool new_ = false;                        // coats were added since take_at_walls()
  std::unordered_set<int> at_walls_;        // IDs
  double deepest_ = 0.0;
};

// LIGGGHTS' radii of coated grains are the bare ones while it exists.
class BareRadii {
 public:
  BareRadii(const GrainCoats& coats, LAMMPS_NS::Atom& atom);
  ~BareRadii();
  BareRadii(const BareRadii&) = delete;
  BareRadii& operator=(const BareRadii&) = delete;

 private:
  const GrainCoats& coats_;
  LAMMPS_NS::Atom& atom_;
};

}  // namespace mpdem

#endif
