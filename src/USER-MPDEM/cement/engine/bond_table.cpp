// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "bond_table.h"

#include "../../mpm/point_scatter.h"

namespace mpdem {

namespace {

template <int side, int d>
double force(const BondState& b) {
  return b.force[side][d];
}

template <int side, int d>
double moment(const BondState& b) {
  return b.torque[side][d];
}

template <int side>
double share_of_fracture_surface(const BondState& b) {
  return b.share[side];
}

template <bool attached>
double links(const BondShare& b) {
  double n = 0.0;
  for (const PointStore* store : {&b.bond.points, &b.bond.film.points})
    for (const Link& k : store->links) n += k.attached == attached;
  return n;
}

double points(const BondShare& b) { return b.points.points; }

// Part of this rank in: area of the links or contact points of `list` for which `counts` is true, over the attached area
// of that grain at creation.
template <class List, class Counts>
double share_of_area(const BondShare& b, int side, List PointStore::*list, Counts counts) {
  double area = 0.0;
  for (const PointStore* store : {&b.bond.points, &b.bond.film.points})
    for (const auto& a : store->*list)
      if (counts(a) && a.grain == b.record.grain[side]) area += a.area;
  return area > 0.0 ? area / b.record.attached_area[side] : 0.0;
}

template <int side>
double attached_share(const BondShare& b) {
  return share_of_area(b, side, &PointStore::links, [](const Link& k) { return k.attached; });
}

template <int side>
double touching_share(const BondShare& b) {
  return share_of_area(b, side, &PointStore::contacts, [](const ContactPoint& p) { return p.closed; });
}

// Part of this rank in the mean of `factor` over the volume of the bond.
template <class F>
double mean_over_volume(const BondShare& b, F factor) {
  double sum = 0.0;
  for (const PointStore* store : {&b.bond.points, &b.bond.film.points})
    for (std::size_t n = 0; n < store->blocks.size(); ++n) sum += sum_lanes(store->blocks[n].volume * factor(*store, static_cast<int>(n)));
  return b.record.volume > 0.0 ? sum / b.record.volume : 0.0;
}
double mean_material(const BondShare& b) {
  return mean_over_volume(b, [](const PointStore& points, int n) { return splat(points.meta[static_cast<std::size_t>(n)].material); });
}
double mean_strength(const BondShare& b) {
  return mean_over_volume(b, [](const PointStore& points, int n) { return drawn_strength(points, n); });
}
double mean_moduli(const BondShare& b) {
  return mean_over_volume(b, [](const PointStore& points, int n) { return points.stiffness_factor(n); });
}

// Scripts use the numbers of columns, so append new ones.
std::vector<BondColumn> columns() {
  return {
      {"fx1", "force of the bond on its first grain (lower ID), along x", force<0, 0>},
      {"fy1", "the same along y", force<0, 1>},
      {"fz1", "the same along z", force<0, 2>},
      {"mx1", "moment on the first grain about its centre, along x", moment<0, 0>},
      {"my1", "the same along y", moment<0, 1>},
      {"mz1", "the same along z", moment<0, 2>},
      {"fx2", "force on the second grain, along x", force<1, 0>},
      {"fy2", "the same along y", force<1, 1>},
      {"fz2", "the same along z", force<1, 2>},
      {"mx2", "moment on the second grain about its centre, along x", moment<1, 0>},
      {"my2", "the same along y", moment<1, 1>},
      {"mz2", "the same along z", moment<1, 2>},
      {"gap", "gap between the grains", &BondState::gap},
      {"tension", "force along the line of centres, mean of both ends; positive in tension", &BondState::tension},
      {"points", "points", points},
      {"attached", "links attached", links<true>},
      {"debonded", "links that debonded", links<false>},
      {"failed", "failed points", &BondState::failed},
      {"largest_damage", "largest eigenvalue of D", &BondState::largest_damage},
      {"mean_damage", "its mean over the volume", &BondState::mean_damage},
      {"peak_tension", "largest tension of all steps so far", &BondState::peak},
      {"separated", "1 once separated, else 0", &BondState::separated},
      {"share_grain1", "share of the fracture surface at the first grain", share_of_fracture_surface<0>},
      {"share_grain2", "share of it at the second grain", share_of_fracture_surface<1>},
      {"elastic_energy", "elastic energy of all bonds", &CementTotals::elastic},
      {"kinetic_energy", "kinetic energy of all bonds", &CementTotals::kinetic},
      {"coupling_energy", "energy of the coupling of all bonds", &CementTotals::coupling},
      {"dissipated_energy", "dissipated energy of all bonds", &CementTotals::dissipated},
      {"released_energy", "released energy of all bonds", &CementTotals::released},
      {"damped_energy", "damped energy of all bonds", &CementTotals::damped},
      {"external_work", "work of the grains on all bonds", &CementTotals::external_work},
      {"energy_imbalance", "imbalance of the energy of all bonds", &CementTotals::imbalance},
      {"attached_grain1", "share of the area of the cement at the first grain that is still attached", attached_share<0>},
      {"attached_grain2", "the same at the second grain", attached_share<1>},
      {"friction_energy", "energy that friction took of all bonds", &CementTotals::frictional},
      {"touching_grain1", "share of that area that debonded and touches the first grain again", touching_share<0>},
      {"touching_grain2", "the same at the second grain", touching_share<1>},
      {"broken", "1 once separated or below 1 % of the peak load, else 0", &BondState::broken},
      {"kinetic_share", "kinetic share of the energy of free grains and all cement", &CementTotals::kinetic_share},
      {"unbalanced_force", "unbalanced force of all free grains over the mean force of bonds and contacts",
       &CementTotals::unbalanced_force},
      {"material", "mean over its volume of the number of the material, 0 for that of fix mpm", mean_material},
      {"strength_factor", "mean over its volume of the factor that was drawn for the strength; 1 without scatter", mean_strength},
      {"moduli_factor", "the same of the moduli", mean_moduli},
  };
}

using PartOfSum = double (*)(const BondShare&);

}  // namespace

// Columns that are sums over ranks get their index in BondState::sums here.
const std::vector<BondColumn>& bond_columns() {
  static const std::vector<BondColumn> all = [] {
    std::vector<BondColumn> list = columns();
    int sums = 0;
    for (BondColumn& c : list)
      if (std::holds_alternative<PartOfSum>(c.found)) c.sum = sums++;
    return list;
  }();
  return all;
}

int summed_columns() {
  int sums = 0;
  for (const BondColumn& c : bond_columns()) sums += c.sum >= 0;
  return sums;
}

// Sums need a loop over points or links. So do these three fields, which Report finds by PointSums; loads of the bonds are
// known without such a loop.
bool BondColumn::needs_points() const {
  const auto* field = std::get_if<double BondState::*>(&found);
  return sum >= 0 || (field && (*field == &BondState::failed || *field == &BondState::largest_damage || *field == &BondState::mean_damage));
}

double BondColumn::value(const BondState& bond) const {
  if (sum >= 0) return bond.sums[static_cast<std::size_t>(sum)];
  if (const auto* field = std::get_if<double BondState::*>(&found)) return bond.**field;
  return std::get<double (*)(const BondState&)>(found)(bond);
}

void add_to_sums(const BondShare& share, double* sums) {
  for (const BondColumn& c : bond_columns())
    if (c.sum >= 0) sums[c.sum] += std::get<PartOfSum>(c.found)(share);
}

}  // namespace mpdem
