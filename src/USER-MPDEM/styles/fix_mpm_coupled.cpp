// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// How the cement of fix mpm is coupled, now and in the steps before. Links hold the places that grains and cement had
// towards each other: after steps without them, or with other springs, they would load the bonds at a blow.
#include <algorithm>
#include <cmath>
#include <string>

#include "arguments.h"
#include "comm.h"
#include "fix_mpm.h"
#include "modify.h"

namespace LAMMPS_NS {

using mpdem::text_of;

bool FixMpm::in_motion() const {
  return std::any_of(avec_->bodies.begin(), avec_->bodies.end(), [](const mpdem::Body& b) { return b.in_motion != 0.0; });
}

void FixMpm::set_coupling(const Fix* coupling, const mpdem::PenaltyParameters& p) {
  const std::string who = text_of("fix mpm/couple (id ", coupling->id, "): ");
  if (coupled_ && coupling->id != coupling_id_)
    mpdem::stop_all(lmp, who + text_of("cement '", id, "' is coupled by fix '", coupling_id_, "' already; unfix one of them"));
  if (ran_.kind == mpdem::LinksSoFar::kNone)
    mpdem::stop_all(lmp, who + text_of("cement '", id, "' made steps without a fix mpm/couple, in which the grains went elsewhere, and its links "
                                       "would tear; keep one fix mpm/couple from the first step on, or create the cement anew in a new scene "
                                       "(write_cement, create_cement ... file)"));
  if (ran_.kind == mpdem::LinksSoFar::kLinks) {
    constexpr double kAsPrinted = 1e-5;
    const auto differ = [](double a, double b) { return std::fabs(a - b) > kAsPrinted * b; };
    if (p.at_surface != ran_.at_surface)
      mpdem::stop_all(lmp, who + text_of("'at ", p.at_surface ? "surface" : "points", "', but the steps before were made with 'at ",
                                         ran_.at_surface ? "surface" : "points", "', and the load of the bonds would jump; use that"));
    if (differ(p.kn, ran_.kn) || differ(p.kt, ran_.kt))
      mpdem::stop_all(lmp, who + text_of("'kn' and 'kt' over 'length' are ", p.kn, " and ", p.kt, ", but were ", ran_.kn, " and ", ran_.kt,
                                         " in the steps before, and the load of the bonds would jump; use 'kn ", ran_.kn * cell_, " kt ",
                                         ran_.kt * cell_, "' with 'length cell', as in these"));
  }
  coupled_ = true;
  coupling_id_ = coupling->id;
  penalty_ = p;
  set_time_step(coupling);
}

// In the first step of a run.
void FixMpm::remember_coupling() {
  ran_.kind = coupled_ ? mpdem::LinksSoFar::kLinks : mpdem::LinksSoFar::kNone;
  if (!coupled_) return;
  ran_.kn = penalty_.kn;
  ran_.kt = penalty_.kt;
  ran_.at_surface = penalty_.at_surface;
}

// Is there a fix mpm/couple? It speaks up in its own init, after this one's.
bool FixMpm::coupling_follows() {
  for (int i = 0; i < modify->nfix; ++i)
    if (std::string(modify->fix[i]->style) == "mpm/couple") return true;
  if (relax_ > 0.0)
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): 'quasistatic ", mass_scale_, " ", relax_, "' damps relative to the grains, "
                                 "which needs a fix mpm/couple; define one, or use damping 0"));
  if (!warned_of_no_coupling_ && comm->me == 0)
    error->warning("fix mpm", 0,
                   text_of("fix mpm (id ", id, "): there is no fix mpm/couple, so that the cement bonds nothing",
                           ran_.kind == mpdem::LinksSoFar::kLinks ? " any more, and cannot be bonded again once it has made a step so" : "",
                           "; define one before the run", continued() ? ", after read_restart too" : "")
                       .c_str());
  warned_of_no_coupling_ = true;
  return false;
}

}  // namespace LAMMPS_NS
