// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "auto_step.h"

#include <algorithm>
#include <climits>
#include <cmath>

#include "../words/arguments.h"
#include "../words/fix_mpm_words.h"
#include "comm.h"
#include "force.h"
#include "modify.h"
#include "pair.h"
#include "update.h"

namespace mpdem {

int AutoStep::substeps(const CementOptions& o) const {
  if (o.subcycle > 0 || longest_substep_ == 0.0) return std::max(1, o.subcycle);
  constexpr double kRounding = 1e-9;
  return static_cast<int>(std::min<double>(INT_MAX, std::max(1.0, std::ceil(update->dt / longest_substep_ - kRounding))));
}

void AutoStep::set(Cement& c, const LAMMPS_NS::Fix* running, const LAMMPS_NS::Fix* own) {
  const CementOptions& o = c.options();
  if (share_ == 0.0 && o.subcycle > 0) return;
  c.stable_step().find_film();
  const EigenvalueEstimate e = c.eigenvalue_of_new_layout();
  const double limit = longest_step(c, c.stable_step().step_for(e.most, o.relative_damping));
  if (share_ > 0.0) {
    warn_of_splitting(o);
    set_step(limit, e, running, own);
  }
  report_substeps(o);
}

// Returns the longest step of LIGGGHTS for this stable step of the cement. With `subcycle auto` the cement limits a
// sub-step, and coupled grains limit the step.
double AutoStep::longest_step(Cement& c, double cement_step) {
  constexpr double kShareOfSubsteps = 0.9;  // of the stable step of the cement, as with `timestep auto`
  if (c.options().subcycle > 0) return c.options().subcycle * cement_step;
  longest_substep_ = std::min(longest_substep_ > 0.0 ? longest_substep_ : HUGE_VAL, kShareOfSubsteps * cement_step);
  return share_ > 0.0 && c.penalty() ? std::max(cement_step, c.grains_step()) : cement_step;
}

void AutoStep::report_substeps(const CementOptions& o) {
  if (o.subcycle > 0 || substeps(o) == substeps_reported_) return;
  substeps_reported_ = substeps(o);
  if (substeps_reported_ > kMostSubsteps)
    stop_all(lmp,
             who_ + text_of("'subcycle auto' takes ", substeps_reported_, " sub-steps of the cement in a time step of ", update->dt,
                            ", at most ", kMostSubsteps, " are allowed; use 'timestep ", kMostSubsteps * longest_substep_, "' or less"));
  tell(lmp, text_of(who_, "subcycle auto: ", substeps_reported_, " sub-steps of ", update->dt / substeps_reported_, " in a time step of ",
                    update->dt, "\n"));
}

// Nodes at the edge of a new crack are not constrained, so cracks shorten the stable step.
void AutoStep::warn_of_splitting(const CementOptions& o) {
  const double most = !o.split ? 1.0 : o.unilateral ? 0.6 : 0.7;
  if (share_ <= most || splitting_reported_) return;
  splitting_reported_ = true;
  mpdem::warn(lmp, text_of(who_, "'timestep auto ", share_,
                           "' with 'cracks split': nodes that split shorten the stable step, so the run may stop "
                           "where the cement breaks; use 'timestep auto ",
                           most, "' or less for cement that breaks"));
}

// Keeps the step that was found before, unless it is longer than the limit, or than a smaller share of it that the script
// asks for after read_restart. So the step never becomes longer.
void AutoStep::set_step(double limit, const EigenvalueEstimate& e, const LAMMPS_NS::Fix* running, const LAMMPS_NS::Fix* own) {
  double dt = share_ * limit;
  std::string share = text_of(share_, " of the limit,");
  if (last_step_ > 0.0 && last_step_ <= (share_ < last_share_ ? dt : limit)) {
    share = text_of("as before, the limit is now ", limit, ",");
    dt = last_step_;
  } else if (!std::isfinite(dt)) {
    share = "as it was, nothing limits it,";
    dt = update->dt;
  }
  last_step_ = dt;
  last_share_ = share_;
  tell(lmp, text_of(who_, "timestep auto: ", dt, ", ", share, " from the largest eigenvalue ", e.value, " found in ", e.products,
                    " products\n"));
  if (dt == update->dt) return;
  update->dt = dt;
  if (force->pair) force->pair->reset_dt();
  // Fixes before this one read the old step in their init. reset_dt() cannot be used, since fix move refuses it even
  // before a run.
  for (int i = 0; i < modify->nfix && modify->fix[i] != running; ++i)
    if (modify->fix[i] != own) modify->fix[i]->init();
}

void AutoStep::save(CementHead& head) const {
  head.auto_step = last_step_;
  head.auto_share = last_share_;
  head.longest_substep = std::isfinite(longest_substep_) ? longest_substep_ : 0.0;
}

void AutoStep::restore(const CementHead& head) {
  last_step_ = head.auto_step;
  last_share_ = head.auto_share;
  longest_substep_ = head.longest_substep;
}

}  // namespace mpdem
