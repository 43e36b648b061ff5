// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Settings, commands and fixes of LIGGGHTS that would silently corrupt the state of the cement, and their effects:
// missing points and grains, and values that are not finite. LIGGGHTS lets these pass, since `thermo_modify lost`
// ignores and a run full of NaN ends like any other. host_guards.cpp has a table of them. A row names the setting, when
// it is checked, why it is refused, the cure, and the function that detects it. doc/refused_settings.md has the same
// rows.
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

// When a row is checked.
enum When : unsigned {
  kCreation = 1,      // create_cement begins
  kPoints = 2,        // points are about to be made
  kInit = 4,          // init of fix mpm
  kCoupling = 8,      // init of fix mpm/couple
  kSteps = 16,        // the same, of a run that takes steps
  kStart = 32,        // set-up of a run, or its first step without a set-up
  kShown = 64,        // the same, after the atoms of points were updated
  kUnprepared = 128,  // first step of a run without a set-up
  kNoFix = 256,       // the same, where fix mpm may be gone
  kExchanged = 512,   // atoms went to other ranks
  kCheck = 1024       // every `check` steps, and before a restart file
};

// What the functions of the table read.
struct HostView {
  LAMMPS_NS::LAMMPS* lmp;
  std::string who;  // begins each message: "fix mpm (id cem): "
  const LAMMPS_NS::AtomVecMpdem* cement = nullptr;
  const LAMMPS_NS::Fix* mpm = nullptr;  // fix mpm, its engine, and whether it was asked for all points
  const Cement* engine = nullptr;
  bool wants_points = false;
  const LAMMPS_NS::Fix* couple = nullptr;      // kCoupling, kSteps
  int new_type = 0;                            // kPoints: type of the points
  bool may_leave = false;                      // deleted points are checked later (leaving_atoms.h)
  bool forces_known = true;                    // kCheck
  const std::vector<double>* shown = nullptr;  // kShown: earlier motion_shown()

  // Collective at its first call. Bits of the groups that have some cement, and all of it, with points made later.
  struct Groups {
    int some, all;
  };
  const Groups& groups() const;
  // Radius for which the cement of grain `tag` was made; 0 if the grain has none.
  double radius_at_creation(int tag) const;

  // Caches of these two.
  mutable std::optional<Groups> groups_ = std::nullopt;
  mutable std::unordered_map<int, double> radius_ = {};
};

// Collective. Checks the rows of this time. Stops at the first that applies, or warns.
void check_host(unsigned when, const HostView& view);

// Number of points of all bonds, without those made later.
LAMMPS_NS::bigint points_made(const LAMMPS_NS::AtomVecMpdem& cement);
// Collective. Lowest and highest density of points whose material has none of its own. Without points the lowest is above the highest.
// own: lowest density that materials of points have as their own; 0: none. changed: a point of such a material has another density.
struct Densities {
  double low, high, own;
  bool changed;
};
Densities densities(const HostView& view);
// Collective. Fixes whose gravity acts on the cement. Their sum is its gravity.
std::vector<LAMMPS_NS::FixGravity*> gravities(const HostView& view);
// Positions and velocities of the atoms of this rank, 6 numbers each.
std::vector<double> motion_shown(const LAMMPS_NS::Atom& atom);

}  // namespace mpdem

#endif
