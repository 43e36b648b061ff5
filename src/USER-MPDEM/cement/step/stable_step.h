// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Computes the stable time step from the largest eigenvalue of the cement, the damping of `quasistatic`, and the
// grains. Keeps the largest eigenvalue found so far, on which the added mass of links depends.
//
// Steps are times, eigenvalues are squares of angular frequencies. All functions are collective, except those about the
// known eigenvalue.
#ifndef MPDEM_CEMENT_STEP_STABLE_STEP_H
#define MPDEM_CEMENT_STEP_STABLE_STEP_H

#include <map>
#include <string>
#include <vector>

#include "../../mpm/largest_eigenvalue.h"
#include "../condensed/condensed_bonds.h"
#include "../bond/scene.h"
#include "../condensed/stiffness_of_bonds.h"

namespace mpdem {

class StableStep {
 public:
  StableStep(const Scene& scene, const CondensedBonds& condensed) : scene_(scene), condensed_(condensed) {}

  // Largest stable step of the present state, from the largest eigenvalue of the cement and the damping of the options.
  double find();
  EigenvalueEstimate eigenvalue() const;
  // True with `updated` kinematics: points move within the cells, so only the bound is valid for later steps. eigenvalue()
  // and limiting_eigenvalue() return the bound then.
  bool bound_alone() const;
  // Largest stable step of the present state within some per cent, for messages. The known eigenvalue stays.
  double estimate() const;
  // Largest stable step for a known eigenvalue, with the share `relative_damping` of critical damping. The stiffness of films
  // between the grains is included. Throws BadState if no step is stable.
  double step_for(double eigenvalue, double relative_damping) const;
  // Returns the message that the step exceeds this limit.
  std::string exceeds(double limit) const;
  // Collective. Call before the others when bonds, grains or their free directions changed.
  void find_film();
  // Largest stable step of grains on massless bonds of this static stiffness.
  double of_grains(const std::vector<StiffnessOfBond>& found) const;
  // Effect of the damping of `quasistatic` on the step. step: with damping. undamped: without it. admitted: damping
  // that shortens the step by a tenth at most.
  struct DampedStep {
    static constexpr double kKept = 0.9;  // a step below this share of the undamped one is short
    double step, undamped, admitted;
    bool is_short() const { return step < kKept * undamped; }
  };
  DampedStep damped_step(double eigenvalue) const;
  // Largest rate of relative damping (`quasistatic`) of any node, with the share `share` of critical damping. The
  // motion of free grains is included.
  double relative_damping_rate(double share) const;
  double largest_mass_ratio() const;  // cement over grain, see BondedGrains::mass_ratio()

  // Returns the bound of the eigenvalue if dt is stable with it, else the eigenvalue, which costs some passes.
  double limiting_eigenvalue(double dt) { return limiting_eigenvalue(dt, scene_.all_rows(), nullptr, Precision::at_start); }
  // The largest eigenvalue found so far, 0: none was needed.
  double known_eigenvalue() const { return known_; }
  bool eigenvalue_is_known() const { return known_ > 0.0; }
  void restore(double eigenvalue) { known_ = eigenvalue; }

  // Blocks of points of a bond, by row of the table.
  using Patches = std::map<int, std::vector<int>>;
  // Call when the layout of these bonds changed during a run. event: cause of the change, for the message. patches:
  // blocks that alone need a check, or null. Returns whether the known eigenvalue changed. Throws BadState if the step
  // is too long.
  bool check_after(const std::vector<int>& rows, const char* event, const Patches* patches = nullptr);

 private:
  std::vector<EigenvalueSystem> systems_of(const std::vector<int>& rows, const Patches* patches, bool with_templates) const;
  // Precision of an eigenvalue: at_start and after_change are coarse where that is enough. after_change leaves out templates.
  enum class Precision { precise, at_start, after_change };
  EigenvalueEstimate eigenvalue_of(const std::vector<int>& rows, const Patches* patches, Precision precision) const;
  double limiting_eigenvalue(double dt, const std::vector<int>& rows, const Patches* patches, Precision precision);

  const Scene& scene_;
  const CondensedBonds& condensed_;
  double known_ = 0.0;
  double eigenvalue_of_films_ = 0.0;  // bound of the largest eigenvalue of the grains on their films
};

}  // namespace mpdem

#endif
