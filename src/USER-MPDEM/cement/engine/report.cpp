// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "report.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <unordered_map>

#include "../../mpm/block_nodes.h"
#include "../../mpm/gather.h"

namespace mpdem {

namespace {

void global_sum(std::vector<double>& v, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, v.data(), static_cast<int>(v.size()), MPI_DOUBLE, MPI_SUM, comm);
}
void global_max(std::vector<double>& v, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, v.data(), static_cast<int>(v.size()), MPI_DOUBLE, MPI_MAX, comm);
}

// Sums over nodes that count on this rank: kinetic energy, the kinetic energy that central differences conserve,
// momentum, and angular momentum about the origin of the box.
struct NodeSums {
  double kinetic = 0, discrete_kinetic = 0, momentum[3] = {0, 0, 0}, angular_momentum[3] = {0, 0, 0};

  // Starts with the impulses that grains are yet to get. The nodes have the opposite momentum already.
  explicit NodeSums(const std::vector<Grain>& grains) {
    for (const Grain& grain : grains) {
      const double* p = grain.state->pending_impulse;
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        momentum[d] += p[d];
        angular_momentum[d] += p[3 + d] + grain.x[e] * p[g] - grain.x[g] * p[e];
      }
    }
  }
  void add(const CondensedBonds::Energies& of_condensed) {
    kinetic += of_condensed.kinetic;
    discrete_kinetic += of_condensed.discrete_kinetic;
    for (int d = 0; d < 3; ++d) {
      momentum[d] += of_condensed.momentum[d];
      angular_momentum[d] += of_condensed.angular_momentum[d];
    }
  }
  // half: half a step.
  void add(const Grid& grid, const BondRecord& record, double half) {
    const Mat3<double> axes = axes_of(record);
    for (int i = 0; i < grid.size(); ++i) {
      if (!grid.halo.counts_here()[i]) continue;
      double now[3], kick[3], position[3];
      for (int d = 0; d < 3; ++d) {
        kick[d] = half * grid.acceleration[3 * i + d];
        now[d] = grid.velocity[3 * i + d] + kick[d];
        position[d] = grid.keys[i].at(d) * grid.h + grid.displacement[3 * i + d];
      }
      const std::array<double, 3> v = turned(axes, now), x = position_in_box(record, axes, position);
      const double mass = grid.mass[i];
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        kinetic += 0.5 * mass * now[d] * now[d];
        discrete_kinetic += 0.5 * mass * (now[d] - kick[d]) * (now[d] + kick[d]);
        momentum[d] += mass * v[d];
        angular_momentum[d] += mass * (x[e] * v[g] - x[g] * v[e]);
      }
    }
  }
};

// Writes force, moment, and position of the grain from the origin of the bond coordinates, in the axes of the box.
// of_other_substeps: share of the impulse of a step that acts in its other sub-steps.
void write_end(const BondEnd& s, double of_other_substeps, double* row) {
  const std::array<double, 6> load = in_box(s, s.force, s.torque), impulse = in_box(s, s.impulse, s.impulse + 3);
  const std::array<double, 3> x = turned(s.axes, s.x);
  for (int d = 0; d < 6; ++d) row[d] = load[d] - of_other_substeps * impulse[d];
  std::copy(x.begin(), x.end(), row + 6);
}

// Energy due to rounding errors of positions, which scale with the coordinates in the box. Links and cement have
// energies of this order even at rest, and more where errors accumulate over many steps. reach: largest coordinate, in
// cells.
double rounded_energy(double stiffness, double reach) {
  const double strain = std::numeric_limits<double>::epsilon() * reach;
  return 100.0 * stiffness * strain * strain;
}

// Kinetic energy of the free degrees of freedom of a grain.
double kinetic_energy(const Grain& g) {
  double sum = 0.0;
  for (int d = 0; d < 6; ++d) sum += g.free[d] ? 0.5 * (d < 3 ? g.mass : g.inertia) * g.velocity[d] * g.velocity[d] : 0.0;
  return sum;
}

// See Report::EnergyShares. of_cement, of_grains: kinetic energy of the cement and of the grains. put_in: energy put
// into the cement. Rounding, and work that the energy balance does not count, may make it smaller than of_cement.
double kinetic_share_of(double of_cement, double of_grains, double put_in) {
  const double all = of_grains + std::max(put_in, of_cement);
  return all > 0.0 ? (of_grains + of_cement) / all : 0.0;
}

void count_bonds(const Cracks& cracks, int resolved, CementTotals& t) {
  t.resolved = resolved;
  for (std::size_t r = 0; r < cracks.size(); ++r) {
    t.broken += cracks.broken(r);
    if (!cracks.separated(r)) continue;
    const std::string mode = cracks.mode(r);
    t.separated += 1.0;
    (mode == "debonding" ? t.debonding : mode == "internal" ? t.internal : t.mixed) += 1.0;
  }
}

// Sums over points; links; nodes: kinetic energy, that of central differences, momentum, angular momentum; then the energy
// balance, with the kinetic energy of grains before the cement that left.
enum TotalIndex {
  kSumPoints,
  kSumFailed,
  kSumVolume,
  kSumDamaged,
  kSumElastic,
  kSumCoupling,
  kSumKinetic,
  kSumDiscreteKinetic,
  kSumMomentum,
  kSumAngularMomentum = kSumMomentum + 3,
  kSumDissipated = kSumAngularMomentum + 3,
  kSumReleased,
  kSumDamped,
  kSumFrictional,
  kSumWork,
  kSumGrains,
  kSumContact,
  kSumContactFriction,
  kSumLeft,
  kNumberOfSums = kSumLeft + kMostNumbers<EnergyBalance::Left>
};

}  // namespace

CementTotals Report::totals(double reach_of_box) const {
  CementTotals t{};
  count_bonds(cracks_, resolved_bonds(), t);
  if (!scene_.laid_out) return t;
  std::vector<double> sum(kNumberOfSums, 0.0), most(1, 0.0);
  PointSums of_points;
  NodeSums of_nodes(scene_.grains.grains);
  const CondensedBonds::Energies condensed = condensed_.energies(scene_.bonds(), 0.5 * scene_.dt_last);
  const auto add_condensed = [&](int row) {
    of_points.add(condensed_.sums_of_points(row));
    const double energy = condensed_.energy_of_points(row);
    sum[kSumElastic] += energy, sum[kSumCoupling] -= energy;  // condensed.elastic includes it; the rest is in the links
  };
  for (const Bond& bond : scene_.bonds()) {
    if (!scene_.bonds().is_resolved(bond)) {
      add_condensed(bond.row);
      continue;
    }
    for (const PointStore* store : bond.stores()) of_points.add(*store, *scene_.law, true);
    of_nodes.add(bond.grid, scene_.bonds().record(bond), 0.5 * scene_.dt_last);
    const BondEnd* ends = scene_.grains.ends_of(bond);
    const double inertial = bond.added.energy(bond.grid, ends, 0.5 * scene_.dt_last, 0.5 * scene_.dt_last);
    bond.links.add_spring_energy(bond.grid, ends, sum[kSumCoupling]);
    for (const auto& p : bond.mechanisms) p->add_energy(bond.points, bond.grid, ends, sum[kSumElastic], sum[kSumCoupling]);
    sum[kSumCoupling] += inertial + bond.film.energy_of_faces(scene_.penalty ? scene_.penalty->law.get() : nullptr);
    sum[kSumDiscreteKinetic] += bond.added.energy(bond.grid, ends, 0.0, scene_.dt_last) - inertial;
  }
  for (int row : condensed_.rows_without_points(scene_.bonds())) add_condensed(row);
  sum[kSumCoupling] += condensed.elastic;
  of_nodes.add(condensed);
  sum[kSumKinetic] = of_nodes.kinetic;
  sum[kSumDiscreteKinetic] += of_nodes.discrete_kinetic;
  std::copy(of_nodes.momentum, of_nodes.momentum + 3, &sum[kSumMomentum]);
  std::copy(of_nodes.angular_momentum, of_nodes.angular_momentum + 3, &sum[kSumAngularMomentum]);
  const double of_stores[] = {of_points.points, of_points.failed, of_points.volume, of_points.damaged_volume};
  std::copy(std::begin(of_stores), std::end(of_stores), &sum[kSumPoints]);
  sum[kSumElastic] += of_points.elastic;
  most[0] = of_points.largest_damage;
  const EnergyBalance::Sums& balance = scene_.energy.sums();
  const double of_balance[] = {balance.dissipated, balance.released, balance.damped - balance.damped_ahead,
                               balance.frictional - balance.frictional_ahead, balance.work - balance.work_ahead};
  std::copy(std::begin(of_balance), std::end(of_balance), &sum[kSumDissipated]);
  for (const Grain& g : scene_.grains.grains) sum[kSumGrains] += scene_.options.mass_scale * kinetic_energy(g);
  sum[kSumContact] = contact_.stored();
  sum[kSumContactFriction] = contact_.dissipated();
  pack(balance.left, &sum[kSumLeft]);
  for (int k : {kSumKinetic, kSumDiscreteKinetic}) sum[k] -= balance.inertial_work - balance.inertial_work_ahead;
  global_sum(sum, scene_.comm);
  global_max(most, scene_.comm);
  t.largest_damage = most[0];
  set_totals(sum, reach_of_box, t);
  return t;
}

// Finds the values of the whole scene from the sums over all ranks.
void Report::set_totals(const std::vector<double>& sum, double reach_of_box, CementTotals& t) const {
  t.points = sum[kSumPoints];
  t.failed = sum[kSumFailed];
  t.mean_damage = sum[kSumVolume] > 0.0 ? sum[kSumDamaged] / sum[kSumVolume] : 0.0;
  t.kinetic = sum[kSumKinetic];
  t.elastic = sum[kSumElastic];
  t.coupling = sum[kSumCoupling];
  t.dissipated = sum[kSumDissipated];
  t.released = sum[kSumReleased];
  t.damped = sum[kSumDamped];
  t.frictional = sum[kSumFrictional];
  t.external_work = sum[kSumWork];
  unpack(&sum[kSumLeft], t.left);
  t.contact = sum[kSumContact];
  t.contact_friction = sum[kSumContactFriction];
  const double spent = t.kinetic + t.elastic + t.coupling + t.dissipated + t.released + t.damped + t.frictional + t.left.energy;
  const double scale = std::max(std::fabs(t.external_work), spent);
  // Central differences conserve m/2 v-.v+, with the velocities half a step before and after, instead of m/2 v.v.
  const double kept = spent - t.kinetic + sum[kSumDiscreteKinetic];
  const double stiffest =
      std::max(scene_.law->elasticity().C33, scene_.penalty ? scene_.penalty->law->stiffness().kn * scene_.options.cell : 0.0);
  const double rounding = rounded_energy(stiffest * sum[kSumVolume], reach_of_box / scene_.options.cell);
  const double put_in = t.external_work + scene_.energy.start_energy();
  t.imbalance = scale > rounding ? (put_in - kept) / scale : 0.0;
  t.kinetic_share = scale > rounding ? kinetic_share_of(t.kinetic, sum[kSumGrains], put_in) : 0.0;
  std::copy(&sum[kSumMomentum], &sum[kSumMomentum] + 3, t.momentum);
  std::copy(&sum[kSumAngularMomentum], &sum[kSumAngularMomentum] + 3, t.angular_momentum);
}

Report::EnergyShares Report::energy_shares() const {
  if (!scene_.laid_out) return {};
  enum { kCement, kSumGrains, kSumWork, kSumDissipated, kNumberOfSums };
  NodeSums of_nodes(std::vector<Grain>{});
  of_nodes.add(condensed_.energies(scene_.bonds(), 0.5 * scene_.dt_last));
  for (const Bond& bond : scene_.bonds().resolved()) of_nodes.add(bond.grid, scene_.bonds().record(bond), 0.5 * scene_.dt_last);
  const EnergyBalance::Sums& energy = scene_.energy.sums();
  std::vector<double> sum(kNumberOfSums, 0.0);
  sum[kCement] = of_nodes.kinetic - (energy.inertial_work - energy.inertial_work_ahead);
  sum[kSumWork] = energy.work - energy.work_ahead;
  for (const Grain& g : scene_.grains.grains) sum[kSumGrains] += scene_.options.mass_scale * kinetic_energy(g);
  sum[kSumDissipated] = energy.dissipated;
  global_sum(sum, scene_.comm);
  const double put_in = sum[kSumWork] + scene_.energy.start_energy();
  return {kinetic_share_of(sum[kCement], sum[kSumGrains], put_in),
          sum[kSumDissipated] > 0.0 ? sum[kSumDissipated] / std::max(put_in, sum[kSumDissipated]) : 0.0, put_in};
}

double Report::unbalanced_force(const std::vector<BondState>& loads, const Magnitudes& of_contacts) const {
  if (!scene_.laid_out) return 0.0;
  const std::vector<BondRecord>& table = scene_.bonds().table;
  std::unordered_map<int, std::array<double, 3>> cement_load;  // by tag: force that accelerates the cement of a grain
  for (const Grain& g : scene_.grains.grains) cement_load[g.tag] = {};
  Magnitudes of_bonds;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const BondState& b = loads[i];
    double square = 0.0;
    for (int d = 0; d < 3; ++d) square += 0.25 * (b.force[0][d] - b.force[1][d]) * (b.force[0][d] - b.force[1][d]);
    if (b.broken == 0.0) of_bonds.sum += std::sqrt(square), of_bonds.number += 1.0;
    for (int s = 0; s < 2; ++s) {
      const auto at = table[i].has_grain(s) ? cement_load.find(table[i].grain[s]) : cement_load.end();
      if (at == cement_load.end()) continue;
      for (int d = 0; d < 3; ++d) {
        const double on_grain = b.separated == 0.0 ? 0.5 * (b.force[0][d] + b.force[1][d]) : b.force[s][d] - b.contact[s][d];
        at->second[d] += 0.5 * table[i].mass(scene_.true_density()) * scene_.now.gravity[d] - on_grain;
      }
    }
  }
  enum { kSquares, kSumGrains, kContacts, kSum, kNumberOfSums };
  std::vector<double> sum(kNumberOfSums, 0.0);
  for (const Grain& g : scene_.grains.grains) {
    if (!(g.free[0] || g.free[1] || g.free[2])) continue;
    sum[kSumGrains] += 1.0;
    for (int d = 0; d < 3; ++d)
      sum[kSquares] += g.free[d] ? (g.force[d] + cement_load[g.tag][d]) * (g.force[d] + cement_load[g.tag][d]) : 0.0;
  }
  sum[kContacts] = of_contacts.number;
  sum[kSum] = of_contacts.sum;
  global_sum(sum, scene_.comm);
  if (sum[kSquares] == 0.0) return 0.0;
  constexpr double kMost = 1e9;
  const double resultant = std::sqrt(sum[kSquares] / sum[kSumGrains]);
  const double mean = (of_bonds.sum + sum[kSum]) / std::max(1.0, of_bonds.number + sum[kContacts]);
  return resultant < kMost * mean ? resultant / mean : kMost;
}

void Report::add_virials(const std::vector<BondState>& loads, GrainVirial& virial) const {
  for (const PieceContact::Contact& c : contact_.contacts()) {
    const double opposite[3] = {-c.force[0], -c.force[1], -c.force[2]};
    virial.add(c.grain, c.force, c.arm);
    if (c.other > 0) virial.add(c.other, opposite, c.arm_of_other);
  }
  if (rank_in(scene_.comm) != 0) return;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const BondState& b = loads[i];
    const BondRecord& record = scene_.bonds().table[i];
    for (int s = 0; s < 2; ++s) {
      double arm[3], of_bond[3];  // without contact, which is counted above
      for (int d = 0; d < 3; ++d) of_bond[d] = b.force[s][d] - b.contact[s][d];
      for (int d = 0; d < 3; ++d) arm[d] = (s == 0 ? 1.0 : -1.0) * (record.radius[s] + 0.5 * b.gap) * b.normal[d];
      if (record.has_grain(0) && record.has_grain(1)) virial.add(record.grain[s], of_bond, arm);
    }
  }
}

const std::vector<BondState>& Report::bond_loads() {
  const std::size_t n = scene_.bonds().table.size();
  states_.assign(n, BondState{});
  const std::vector<double> peak = peaks();
  for (std::size_t i = 0; i < n; ++i) states_[i].peak = peak[i];
  if (!scene_.laid_out) return states_;
  const double of_other_substeps = 1.0 - 1.0 / scene_.now.substeps;
  constexpr std::size_t kSide = 12, width = 2 * kSide;  // see write_end(), then the force of contact
  std::vector<double> sum(width * n, 0.0);
  for (const BondedGrains::OwnedEnd& o : scene_.grains.owned()) {
    if (!scene_.penalty) break;
    const BondEnd& s = scene_.grains.ends.ends[o.at];
    write_end(s, of_other_substeps, &sum[width * o.row + kSide * o.side]);
  }
  for (int bond_row : condensed_.owned_rows()) {
    const std::array<BondEnd, 2> ends = condensed_.loaded_ends(bond_row, scene_.bonds(), scene_.weight().data());
    for (int s = 0; s < 2; ++s) write_end(ends[s], of_other_substeps, &sum[width * bond_row + kSide * s]);
  }
  for (const PieceContact::LoadOfBond& c : contact_.loads_of_bonds())
    for (int s = 0; s < 2; ++s)
      for (int d = 0; d < 6; ++d) {
        double* row = &sum[width * static_cast<std::size_t>(c.row) + kSide * static_cast<std::size_t>(s)];
        row[d] += c.load[s][d];
        if (d < 3) row[9 + d] += c.load[s][d];
      }
  global_sum(sum, scene_.comm);
  for (std::size_t i = 0; i < n; ++i) {
    const double* row = &sum[width * i];
    BondState& b = states_[i];
    double axis[3], length = 0.0;
    for (int d = 0; d < 3; ++d) {
      axis[d] = row[kSide + 6 + d] - row[6 + d];
      length += axis[d] * axis[d];
    }
    const BondRecord& record = scene_.bonds().table[i];
    const bool both = record.has_grain(0) && record.has_grain(1);
    length = both ? std::sqrt(length) : 0.0;
    for (int s = 0; s < 2; ++s)
      for (int d = 0; d < 3; ++d) {
        b.force[s][d] = row[kSide * s + d];
        b.torque[s][d] = row[kSide * s + 3 + d];
        b.contact[s][d] = row[kSide * s + 9 + d];
        b.tension += (s == 0 ? 0.5 : -0.5) * b.force[s][d] * (length > 0.0 ? axis[d] / length : 0.0);
      }
    for (int d = 0; d < 3; ++d) b.normal[d] = length > 0.0 ? axis[d] / length : 0.0;
    b.gap = both ? length - record.radius[0] - record.radius[1] : 0.0;
    b.broken = cracks_.broken(i);
    if (!cracks_.broken(i)) continue;
    const FractureSurface& s = cracks_[i].separation;
    const double all = s.at_grain[0] + s.at_grain[1] + s.inside;
    b.separated = cracks_.separated(i);
    for (int g = 0; g < 2; ++g) b.share[g] = all > 0.0 ? s.at_grain[g] / all : 0.0;
  }
  return states_;
}

const std::vector<BondState>& Report::bond_states() {
  bond_loads();
  if (!scene_.laid_out) return states_;
  const std::size_t n = scene_.bonds().table.size();
  enum { kSumFailed, kSumVolume, kSumDamaged, kColumns };
  const std::size_t width = kColumns + static_cast<std::size_t>(summed_columns());
  std::vector<double> sum(width * n, 0.0), most(n, 0.0);
  const auto add = [&](int row_of_table, const Bond& b, const BondRecord& record, const PointSums& of_bond) {
    double* row = &sum[width * row_of_table];
    row[kSumFailed] = of_bond.failed;
    row[kSumVolume] = of_bond.volume;
    row[kSumDamaged] = of_bond.damaged_volume;
    most[row_of_table] = of_bond.largest_damage;
    add_to_sums({b, record, of_bond}, row + kColumns);
  };
  for (const Bond& b : scene_.bonds()) {
    PointSums of_bond;
    if (scene_.bonds().is_resolved(b)) {
      of_bond.add(b.points, *scene_.law, false);
      of_bond.add(b.film.points, *scene_.law, false);
    } else {
      of_bond = condensed_.sums_of_points(b.row);
    }
    add(b.row, b, scene_.bonds().record(b), of_bond);
  }
  for (int row : condensed_.rows_without_points(scene_.bonds())) {
    const CondensedBonds::TemplateBond& p = condensed_.template_bond_of(scene_.bonds().table[row]);
    add(row, p.bond, p.record, condensed_.sums_of_points(row));
  }
  global_sum(sum, scene_.comm);
  global_max(most, scene_.comm);
  for (std::size_t i = 0; i < n; ++i) {
    const double* row = &sum[width * i];
    BondState& b = states_[i];
    b.failed = row[kSumFailed];
    b.mean_damage = row[kSumVolume] > 0.0 ? row[kSumDamaged] / row[kSumVolume] : 0.0;
    b.largest_damage = most[i];
    b.sums.assign(row + kColumns, row + width);
  }
  return states_;
}

std::vector<double> Report::added_mass_of_ends() const {
  std::vector<double> sum(2 * scene_.bonds().table.size(), 0.0);
  for (const Bond& b : scene_.bonds()) b.added.add_to_ends(b.grid, &sum[2 * static_cast<std::size_t>(b.row)]);
  global_sum(sum, scene_.comm);
  return sum;
}

double Report::cement_mass() const {
  const CementDensity density = scene_.inertia();
  double sum = 0.0;
  for (const Bond& bond : scene_.bonds())
    for (const PointStore* store : bond.stores())
      for (std::size_t b = 0; b < store->blocks.size(); ++b)
        sum += density.of(store->meta[b].material) * sum_lanes(store->blocks[b].volume);
  for (int row : condensed_.rows_without_points(scene_.bonds())) sum += scene_.bonds().table[row].mass(density);
  return sum;
}

int Report::resolved_bonds() const {
  const std::vector<int> rows = scene_.bonds().resolved_rows();
  return static_cast<int>(std::count_if(rows.begin(), rows.end(), [this](int row) { return scene_.bonds().table[row].points > 0; }));
}

// Velocities are v_n = v_n-1/2 + dt a_n / 2. Points made since the last layout have no nodes yet, and get no motion.
void Report::motion_of_points(const Bond& bond, std::vector<PointMotionNow>& motion) const {
  std::vector<double> velocity(bond.grid.velocity), displacement(bond.grid.displacement);
  for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] += 0.5 * scene_.dt_last * bond.grid.acceleration[i];
  if (condensed_.has(bond.row)) {
    CondensedBonds::NodeMotion n = condensed_.nodes_of(bond, scene_.bonds().record(bond), 0.5 * scene_.dt_last);
    velocity.swap(n.velocity);
    displacement.swap(n.displacement);
  }
  motion.resize(bond.laid_out_blocks);
  with_basis(scene_.options.basis, [&](auto type) {
    for (std::size_t b = 0; b < bond.laid_out_blocks; ++b) {
      const BlockMeta& m = bond.points.meta[b];
      with_weights<decltype(type)>(bond.points.blocks[b], m, 1.0 / scene_.options.cell, [&](const auto& w) {
        with_values<3>(bond.grid, m, displacement.data(),
                       [&](const double* u, const int* column) { gather_value(u, column, w, motion[b].u); });
        with_values<3>(bond.grid, m, velocity.data(), [&](const double* v, const int* column) { gather_value(v, column, w, motion[b].v); });
      });
    }
  });
}

// Points made since the last layout get no motion.
void Report::motion_of_film(const Bond& bond, std::vector<PointMotionNow>& motion) const {
  motion.resize(bond.film.laid_out_blocks());
  const double half = 0.5 * scene_.dt_last;
  if (motion.empty()) return;
  CondensedBonds::Ends ends;
  if (condensed_.has(bond.row)) ends = condensed_.ends_of(bond.row, scene_.bonds());
  else std::copy(scene_.grains.ends_of(bond), scene_.grains.ends_of(bond) + 2, ends.begin());
  for (std::size_t b = 0; b < motion.size(); ++b) {
    bond.film.motion(static_cast<int>(b), ends.data(), half, motion[b].u, motion[b].v);
    for (int d = 0; d < 3; ++d) motion[b].u[d] -= bond.film.points.blocks[b].X[d];
  }
}

void Report::note_peaks() {
  if (!scene_.penalty) return;
  peaks_.resize(scene_.bonds().table.size());
  const double of_other_substeps = 1.0 - 1.0 / scene_.now.substeps;
  for (const BondedGrains::OwnedEnd& o : scene_.grains.owned()) {
    const BondRecord& record = scene_.bonds().table[o.row];
    if (o.side != 0 || !record.has_grain(1)) continue;
    const BondEnd *first = &scene_.grains.ends.ends[o.at], *second = first + 1;
    double square = 0.0, sum = 0.0;
    for (int d = 0; d < 3; ++d) {
      const double axis = second->x[d] - first->x[d];
      square += axis * axis;
      sum += axis * (first->force[d] - second->force[d] - of_other_substeps * (first->impulse[d] - second->impulse[d]));
    }
    if (square > 0.0) peaks_[o.row] = std::max(peaks_[o.row], 0.5 * sum / std::sqrt(square));
  }
  condensed_.note_peaks(peaks_);
}

std::vector<double> Report::peaks() const {
  std::vector<double> peaks(peaks_);
  peaks.resize(scene_.bonds().table.size());
  global_max(peaks, scene_.comm);
  return peaks;
}

}  // namespace mpdem
