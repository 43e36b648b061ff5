// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Settings, commands and fixes of LIGGGHTS that would spoil cement without a word, and what comes of them: points and grains
// that are gone, and values that are no numbers. LIGGGHTS lets these pass, since `thermo_modify lost` ignores and a run full
// of NaN ends like any other. They are the table in host_guards.cpp: a row names the thing, when it is looked for, why it is
// refused, the cure, and the function that finds it. doc/refused_settings.md has the same rows.
#ifndef MPDEM_STYLES_GUARDS_HOST_GUARDS_H
#define MPDEM_STYLES_GUARDS_HOST_GUARDS_H

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "../atoms/atom_vec_mpdem.h"
#include "fix.h"

namespace LAMMPS_NS {
class FixGravity;
}  // namespace LAMMPS_NS

namespace mpdem {

class Cement;

// When a row is looked at.
enum When : unsigned {
  kCreation = 1,      // create_cement begins
  kPoints = 2,        // points are about to be made
  kInit = 4,          // init of fix mpm
  kCoupling = 8,      // init of fix mpm/couple
  kSteps = 16,        // the same, of a run that takes steps
  kStart = 32,        // set-up of a run, or its first step without a set-up
  kShown = 64,        // points were shown anew in that
  kUnprepared = 128,  // first step of a run without a set-up
  kNoFix = 256,       // the same, where fix mpm may be gone
  kExchanged = 512,   // atoms went to other ranks
  kCheck = 1024       // every `check` steps, and before a restart file
};

// What the functions of the table look at.
struct HostView {
  LAMMPS_NS::LAMMPS* lmp;
  std::string who;  // begins each message: "fix mpm (id cem): "
  const LAMMPS_NS::AtomVecMpdem* cement = nullptr;
  const LAMMPS_NS::Fix* mpm = nullptr;  // fix mpm, its engine, and whether it was asked for all points
  const Cement* engine = nullptr;
  bool wants_points = false;
  const LAMMPS_NS::Fix* couple = nullptr;      // kCoupling, kSteps
  int new_type = 0;                            // kPoints: type of the points
  bool may_leave = false;                      // deleted points are looked at later (leaving_atoms.h)
  bool forces_known = true;                    // kCheck
  const std::vector<double>* shown = nullptr;  // kShown: motion_shown() before

  // Collective at its first call. Bits of the groups that have some cement, and all, with points that are made later.
  struct Groups {
    int some, all;
  };
  const Groups& groups() const;
  // Radius that the cement of grain `tag` was made for; 0 if the grain has none.
  double made_for(int tag) const;

  // What these two found.
  mutable std::optional<Groups> groups_ = std::nullopt;
  mutable std::unordered_map<int, double> radius_ = {};
};

// Collective. Looks at the rows of this time, and stops at the first that is found, or warns.
void check_host(unsigned when, const HostView& view);

// Number of the points in the table of bonds, without those that are made later.
LAMMPS_NS::bigint points_made(const LAMMPS_NS::AtomVecMpdem& cement);
// Collective. Lowest and highest density of points; the lowest is above the highest if there are none.
struct Densities {
  double low, high;
};
Densities densities(const HostView& view);
// Collective. Fixes of the gravity that acts on the cement as on the grains. Their sum is its gravity.
std::vector<LAMMPS_NS::FixGravity*> gravities(const HostView& view);
// Positions and velocities of the atoms of this rank.
std::vector<double> motion_shown(const LAMMPS_NS::Atom& atom);

}  // namespace mpdem

#endif
