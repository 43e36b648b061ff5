// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement_values.h"

namespace mpdem {

namespace {

template <double CementTotals::*member>
double field(const CementTotals& t) {
  return t.*member;
}
template <int d>
double momentum(const CementTotals& t) {
  return t.momentum[d];
}
template <int d>
double angular_momentum(const CementTotals& t) {
  return t.angular_momentum[d];
}
template <int d>
double momentum_left(const CementTotals& t) {
  return t.left.momentum[d];
}

}  // namespace

// Name, description for doc/fix_mpm.md, how the value is found, and whether it needs contact forces of LIGGGHTS.
const std::vector<CementValue>& cement_values() {
  static const std::vector<CementValue> all = {
      {"points", "points", field<&CementTotals::points>},
      {"failed", "failed points", field<&CementTotals::failed>},
      {"largest_damage", "largest eigenvalue of D of any point", field<&CementTotals::largest_damage>},
      {"mean_damage", "its mean over the volume", field<&CementTotals::mean_damage>},
      {"kinetic_energy", "kinetic energy", field<&CementTotals::kinetic>},
      {"elastic_energy", "elastic energy", field<&CementTotals::elastic>},
      {"coupling_energy", "energy of the coupling", field<&CementTotals::coupling>},
      {"dissipated_energy", "energy dissipated by damage", field<&CementTotals::dissipated>},
      {"released_energy", "energy released at failure", field<&CementTotals::released>},
      {"damped_energy", "energy taken by dampers and re-projection", field<&CementTotals::damped>},
      {"external_work", "work of grains and gravity on the cement", field<&CementTotals::external_work>},
      {"energy_imbalance", "imbalance of the energy, relative; 0 at rest", field<&CementTotals::imbalance>},
      {"momentum_x",
       "momentum of the cement and of impulses that grains get in the next step; with `transfer flip A` it deviates by some 1e-6 of the "
       "relative motion in a step with a transfer, and no longer in the next",
       momentum<0>},
      {"momentum_y", "the same along y", momentum<1>},
      {"momentum_z", "the same along z", momentum<2>},
      {"angular_momentum_x", "angular momentum about the origin", angular_momentum<0>},
      {"angular_momentum_y", "the same about y", angular_momentum<1>},
      {"angular_momentum_z", "the same about z", angular_momentum<2>},
      {"separated", "bonds that are separated", field<&CementTotals::separated>},
      {"debonding", "of these by debonding", field<&CementTotals::debonding>},
      {"internal", "of these internal", field<&CementTotals::internal>},
      {"mixed", "of these mixed", field<&CementTotals::mixed>},
      {"friction_energy", "energy that friction took", field<&CementTotals::frictional>},
      {"awake", "bonds that are resolved, all without `condense`", field<&CementTotals::resolved>},
      {"substeps", "sub-steps of the cement in a step", nullptr},  // fix mpm has it
      {"broken", "bonds that are broken, separated or not", field<&CementTotals::broken>},
      {"points_left", "points that [left the scene](#what-may-leave)", [](const CementTotals& t) { return t.left.points; }},
      {"mass_left", "their mass as calcite, without mass scaling", [](const CementTotals& t) { return t.left.mass; }},
      {"momentum_left_x", "momentum that left", momentum_left<0>},
      {"momentum_left_y", "the same along y", momentum_left<1>},
      {"momentum_left_z", "the same along z", momentum_left<2>},
      {"energy_left", "energy that left", [](const CementTotals& t) { return t.left.energy; }},
      {"kinetic_share", "kinetic share of the energy ([quasi-static loads](#quasi-static-loads))", field<&CementTotals::kinetic_share>},
      {"unbalanced_force", "unbalanced force over the mean force of bonds and contacts", field<&CementTotals::unbalanced_force>, true},
      {"points_dropped", "points that left since they were [dropped](#what-may-leave)",
       [](const CementTotals& t) { return t.left.dropped; }},
      {"mass_dropped", "their mass", [](const CementTotals& t) { return t.left.dropped_mass; }},
      {"contact_energy", "energy stored in contacts of rigid pieces, and of cement with other bodies", field<&CementTotals::contact>},
      {"contact_friction", "energy that friction of these contacts took", field<&CementTotals::contact_friction>},
  };
  return all;
}

}  // namespace mpdem
