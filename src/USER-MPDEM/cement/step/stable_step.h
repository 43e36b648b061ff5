// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds what time step is stable: by the largest eigenvalue of the cement, by the damping of `quasistatic`, and by the
// grains. It keeps the largest eigenvalue that it found so far, on which the added mass of links depends.
//
// Steps are times, eigenvalues are squares of frequencies. All functions are collective, except those about the known
// eigenvalue.
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

  // Largest stable step in the present state, from the largest eigenvalue of the cement and the damping of the options.
  double find();
  EigenvalueEstimate eigenvalue() const;
  // True with `updated` kinematics: points come to other places in the cells, so only the bound holds for the steps to
  // come. The functions above and below give the bound then.
  bool bound_alone() const;
  // Largest stable step for a known eigenvalue, with the damping `relax` of critical. The stiffness of films between the
  // grains counts, too. Throws BadState if no step is stable.
  double step_for(double eigenvalue, double relax) const;
  // Says that the step is above this limit.
  std::string exceeds(double limit) const;
  // Collective. Call before, when bonds, grains or what is free of them changed.
  void find_film();
  // Largest step with which grains on massless bonds of this static stiffness would be stable.
  double of_grains(const std::vector<StiffnessOfBond>& found) const;
  // Effect of the damping of `quasistatic` on the step. step: with damping. undamped: without it. admitted: damping
  // that takes a tenth of the step at most.
  struct DampedStep {
    static constexpr double kKept = 0.9;
    double step, undamped, admitted;
    bool is_short() const { return step < kKept * undamped; }
  };
  DampedStep damped_step(double eigenvalue) const;
  // Largest rate of any node against its grains by `quasistatic`, with the damping `share` of critical. Free grains are
  // slowed too.
  double relaxation_rate(double share) const;
  double largest_mass_ratio() const;  // largest ratio of grains that follow forces

  // Returns the bound of the eigenvalue if dt is stable with it, else the eigenvalue. The eigenvalue itself costs some
  // passes.
  double limiting_eigenvalue(double dt) { return limiting_eigenvalue(dt, scene_.all_rows(), nullptr, Look::at_start); }
  // The largest eigenvalue that was found so far; 0: none was asked for.
  double known_eigenvalue() const { return known_; }
  bool eigenvalue_is_known() const { return known_ > 0.0; }
  void restore(double eigenvalue) { known_ = eigenvalue; }

  // Blocks of points of a bond, by row of the table.
  using Patches = std::map<int, std::vector<int>>;
  // Call when the layout of these bonds changed in a run. event: reason of the change, for the message. patches: blocks
  // that alone need a look, or null. Returns whether the known eigenvalue is another one now. Throws BadState if the
  // step is too long.
  bool check_after(const std::vector<int>& rows, const char* event, const Patches* patches = nullptr);

 private:
  enum class Look { precise, at_start, after_change };  // the last two may be coarse; after_change: of these bonds alone, in a run
  EigenvalueEstimate eigenvalue_of(const std::vector<int>& rows, const Patches* patches, Look look) const;
  double limiting_eigenvalue(double dt, const std::vector<int>& rows, const Patches* patches, Look look);

  const Scene& scene_;
  const CondensedBonds& condensed_;
  double known_ = 0.0;
  double of_film_ = 0.0;  // bound of the largest eigenvalue of the grains on their films
};

}  // namespace mpdem

#endif
