// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Transitions between condensed and resolved bonds: the state of nodes and points by the static fields, and the check
// whether a resolved bond follows these fields.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "../../mpm/advance_points.h"
#include "../../mpm/field_drive.h"
#include "../../parallel/agree.h"
#include "bond_description.h"
#include "condensed_bonds.h"
#include "condensed_fields.h"
#include "rigid_pieces.h"

namespace mpdem {

namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
constexpr double kChange = 1e-3;  // allowed change, as a share of the value at the threshold

// Energy with which the nodes of a bond move beside its grains, for a rough check. Between the grains the static motion is near an
// interpolation between their motions; an error of half of their relative motion is allowed for.
double ringing_energy(const Grid& grid, const BondRecord& record, const BondEnd* ends) {
  double energy = 0.0;
  for (int i = 0; i < grid.size(); ++i) {
    if (!(grid.mass[i] > 0.0)) continue;
    const Vector3 at = position_of(grid, i) + Vector3(&grid.displacement[3 * static_cast<std::size_t>(i)]);
    Vector3 v[2];
    double apart[2];
    for (int s = 0; s < 2; ++s) {
      const BondEnd& e = ends[s];
      const Vector3 arm = at - Vector3(e.x[0], e.x[1], e.x[2]);
      v[s] = Vector3(e.v[0], e.v[1], e.v[2]) + Vector3(e.omega[0], e.omega[1], e.omega[2]).cross(arm);
      apart[s] = std::max(0.0, arm.norm() - record.radius[s]);
    }
    const double sum = apart[0] + apart[1], share = sum > 0.0 ? apart[0] / sum : 0.5;
    const Vector3 static_motion = v[0] + share * (v[1] - v[0]), of_node(&grid.velocity[3 * static_cast<std::size_t>(i)]);
    energy += 0.5 * grid.mass[i] * ((of_node - static_motion).squaredNorm() - 0.25 * (v[1] - v[0]).squaredNorm());
  }
  return energy;
}

}  // namespace

CondensedBonds::NodeMotion CondensedBonds::nodes_of(const Bond& bond, const BondRecord& record, double later) const {
  const int member = member_of(bond.row);
  const Member& m = members_[member];
  if (m.piece >= 0) return nodes_of_pieces(bond, record, later);
  const auto both = pack_.ends(member, record);
  const BondEnd* ends = both.data();
  const CondensedMotion motion(model_of(member), record, ends);
  const Vector3& middle = model_of(member).middle;
  const CondensedMotion::Vector12 v = motion.velocity(ends, later), a = motion.acceleration(ends);
  const CondensedMotion::Vector6& d = motion.relative();
  const CondensedMotion::Vector6 half = 0.5 * d;
  const Matrix3& Q = motion.axes();
  const Vector3 c = motion.middle(), w = motion.angular_velocity(ends);
  const auto rigid = [](const CondensedMotion::Vector6& g, const Vector3& Y) {
    return Vector3(g.head<3>() + Vector3(g.tail<3>()).cross(Y));
  };
  NodeMotion n;
  for (auto* values : {&n.displacement, &n.velocity, &n.acceleration}) values->resize(3 * static_cast<std::size_t>(bond.grid.size()));
  for (int i = 0; i < bond.grid.size(); ++i) {
    const Vector3 X = position_of(bond.grid, i), Y = X - middle;
    const Eigen::Matrix<double, 3, 6> u = fields_at(m.solution->fields, i);
    const Vector3 y = Y + u * d - rigid(half, Y);  // position in the axes Q, which follow half of the relative motion
    const auto field = [&](const CondensedMotion::Vector12& q) {
      const CondensedMotion::Vector6 first = q.head<6>(), second = q.tail<6>();
      return Vector3(rigid(first, y) + u * (second - first));
    };
    const Vector3 of_node[3] = {c + Q * y - X, Q * field(v), Q * (field(a) + w.cross(w.cross(y)))};
    for (int d3 = 0; d3 < 3; ++d3) {
      n.displacement[3 * i + d3] = of_node[0][d3];
      n.velocity[3 * i + d3] = of_node[1][d3];
      n.acceleration[3 * i + d3] = of_node[2][d3];
    }
  }
  return n;
}

// A piece whose grain left is no member.
CondensedBonds::NodeMotion CondensedBonds::nodes_of_pieces(const Bond& bond, const BondRecord& record, double later) const {
  const std::size_t first = member_of(bond.row);
  NodeMotion n;
  for (auto* values : {&n.displacement, &n.velocity, &n.acceleration}) values->resize(3 * static_cast<std::size_t>(bond.grid.size()));
  for (int s = 0; s < 2; ++s) {
    const int member = member_of_piece(bond.row, s);
    if (member < 0) continue;
    const BondRecord piece = record_of_piece(record, s);
    const auto ends = pack_.ends(member, piece);
    const CondensedModel& model = model_of(static_cast<std::size_t>(member));
    const CondensedMotion motion(model, piece, ends.data());
    const CondensedMotion::Vector12 v = motion.velocity(ends.data(), later), a = motion.acceleration(ends.data());
    const Matrix3& Q = motion.axes();
    const Vector3 w = motion.angular_velocity(ends.data());
    for (int i = 0; i < bond.grid.size(); ++i) {
      if (members_[first].solution->grain_of_node[i] != s) continue;
      const Vector3 X = position_of(bond.grid, i), Y = X - model.middle;
      const Vector3 of_node[3] = {motion.middle() + Q * Y - X, Q * (v.head<3>() + Vector3(v.segment<3>(3)).cross(Y)),
                                  Q * (a.head<3>() + Vector3(a.segment<3>(3)).cross(Y) + w.cross(w.cross(Y)))};
      for (int d = 0; d < 3; ++d) {
        n.displacement[3 * i + d] = of_node[0][d];
        n.velocity[3 * i + d] = of_node[1][d];
        n.acceleration[3 * i + d] = of_node[2][d];
      }
    }
  }
  return n;
}

void CondensedBonds::show_strain(Bond& bond) const { show_strain(bond, member_of(bond.row)); }

void CondensedBonds::show_strains(Bonds& bonds) const {
  for (Bond& b : bonds)
    if (has(b.row)) show_strain(b);
}

void CondensedBonds::show_strain(Bond& bond, int member) const {
  const Member& m = members_[member];
  bond.points.forget_roots_of_norm();
  double d[6] = {};
  for (int j = 0; j < 6 && m.piece < 0; ++j) d[j] = pack_.relative(member, j);
  if (m.piece < 0) bond.film.set_strain(m.solution->fields.strain_of_film, d);
  for (std::size_t b = 0; b < bond.points.blocks.size(); ++b) {
    Sym3<vd> e{};
    for (int j = 0; j < 6 && m.piece < 0; ++j) e = e + splat(d[j]) * m.solution->fields.strain[j][b];
    bond.points.blocks[b].strain = e;
  }
}

std::vector<PenaltyLinks::LinkTraction> CondensedBonds::link_tractions(const Bond& bond, const BondRecord& record) const {
  const int member = member_of(bond.row);
  const Member& m = members_[static_cast<std::size_t>(member)];
  if (m.piece >= 0) return std::vector<PenaltyLinks::LinkTraction>(bond.points.links.size());
  const EndsAtCreation at(record);
  const StaticBond& fields = m.solution->fields;
  double d[6];
  std::vector<double> x(3 * static_cast<std::size_t>(bond.grid.size()), 0.0);
  std::array<Eigen::VectorXd, 2> amplitudes{Eigen::VectorXd::Zero(fields.amplitudes[0][0].size()),
                                            Eigen::VectorXd::Zero(fields.amplitudes[0][1].size())};
  for (std::size_t j = 0; j < 6; ++j) {
    d[j] = pack_.relative(member, static_cast<int>(j));
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += d[j] * fields.displacement[j][i];
    for (std::size_t side = 0; side < 2; ++side) amplitudes[side] += d[j] * fields.amplitudes[j][side];
  }
  const auto motions = motions_of(fields.frame, at.ends, d);
  const double both[2][6] = {{motions[0][0], motions[0][1], motions[0][2], motions[0][3], motions[0][4], motions[0][5]},
                             {motions[1][0], motions[1][1], motions[1][2], motions[1][3], motions[1][4], motions[1][5]}};
  return bond.links.small_tractions(bond.points, bond.links.secants(bond.grid, at.ends), at.ends, x.data(), both, amplitudes);
}

void CondensedBonds::activate(MPI_Comm comm, int bond_row, Bond* bond, const Bonds& bonds, const double* gravity, double dt_last,
                              const Law& law) const {
  const BondRecord& row = bonds.table[bond_row];
  if (bond) {
    Grid& grid = bond->grid;
    show_strain(*bond);
    NodeMotion n = nodes_of(*bond, row, 0.5 * dt_last);
    for (std::size_t i = 0; i < n.velocity.size(); ++i) n.velocity[i] -= 0.5 * dt_last * n.acceleration[i];
    grid.displacement.swap(n.displacement);
    grid.velocity.swap(n.velocity);
    grid.acceleration.swap(n.acceleration);
    const int member = member_of(bond_row);
    const Matrix3 Q = CondensedMotion(model_of(member), row, pack_.ends(member, row).data()).axes();
    double turn[3][3];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) turn[i][j] = Q(i, j);
    set_field(bond->points, grid, turn);
    double d[6];
    for (int j = 0; j < 6; ++j) d[j] = pack_.relative(member, j);
    bond->film.set_open(members_[static_cast<std::size_t>(member)].solution->fields.faces, d);
    bond->film.start_from(pack_.ends(member, row).data());
  }
  const std::array<double, 3> along = turned_back(axes_of(row), gravity);
  const MPI_Comm of_bond = cut_.count(bond_row) > 0 ? comm : bond ? MPI_COMM_SELF : MPI_COMM_NULL;
  if (of_bond != MPI_COMM_NULL) equilibrate(of_bond, bond, row, along.data(), law);
}

// The static fields are linear. Their errors are of the order of the strain, but links are stiff, so nodal forces
// remain. Newton steps remove them.
void CondensedBonds::equilibrate(MPI_Comm comm, Bond* bond, const BondRecord& record, const double* gravity, const Law& law) const {
  constexpr int kIterations = 2;
  for (int k = 0; k < kIterations; ++k) {
    if (!bond) {
      static_displacement(comm, nullptr, {});
      continue;
    }
    Grid& grid = bond->grid;
    std::array<BondEnd, 2> ends = pack_.ends(member_of(bond->row), record);
    for (BondEnd& s : ends)  // without velocity dampers exert no force
      for (int d = 0; d < 3; ++d) s.v[d] = s.omega[d] = 0.0;
    std::vector<double> velocity(grid.velocity.size(), 0.0);
    velocity.swap(grid.velocity);
    grid.clear_force();
    add_internal_force(bond->points, grid, law);
    bond->links.add_force(grid, ends.data());
    grid.sum_force();
    for (int i = 0; i < grid.size(); ++i)
      for (int d = 0; d < 3; ++d)
        if (grid.constraints.row(i) < 0) grid.force[3 * i + d] += grid.mass[i] * (gravity[d] - grid.acceleration[3 * i + d]);
    const StaticSystem system{bond->points, grid, bond->links, ends.data(), record, law, bond->film};
    grid.velocity = static_displacement(comm, &system, grid.force);  // over a step of time 1, below
    AdvanceOptions options;
    options.nonlocal = true;  // without averages nonlocal damage does not grow
    grid.drive_average.clear();
    AdvanceResult result;
    grid.clear_force();
    advance_points(bond->points, 0, static_cast<int>(bond->points.blocks.size()), grid, law, 1.0, options, result);
    for (std::size_t i = 0; i < velocity.size(); ++i) grid.displacement[i] += grid.velocity[i];
    velocity.swap(grid.velocity);
  }
}

bool CondensedBonds::matches_static_solution(const Bond& resolved, const BondRecord& record, const BondEnd* ends, double energy,
                                             double root, double largest, const double* gravity, double dt_last, const Law& law) {
  // If the bond changed its static fields have to be found anew. That is of no use while it rings. The elastic energy, of which that
  // in static equilibrium is a part, gives the most that is allowed below.
  constexpr double kRoughly = 10.0;
  const double ringing = ringing_energy(resolved.grid, record, ends);
  if (ringing * root * root > kRoughly * kChange * (energy - ringing)) return false;
  PointSums now;
  now.add(resolved.points, law, false);
  now.add(resolved.film.points, law, false);
  Candidate& c = candidates_[resolved.row];
  if (c.layout != resolved.layout || c.damage != now.damaged_volume || c.failed != now.failed) {
    Bond still;
    still.row = resolved.row;
    still.points = resolved.points;
    still.film = resolved.film;
    still.grid = resolved.grid;
    still.links = resolved.links;
    revert_field(still.points);
    revert_field(still.film.points);
    still.film.close_faces();
    std::fill(still.grid.displacement.begin(), still.grid.displacement.end(), 0.0);
    c = {resolved.layout, now.damaged_volume, now.failed, nullptr};
    try {
      c.solution = solved(MPI_COMM_SELF, &still, record, law, kMostStepsOfCandidate);
    } catch (const BadState&) {
      // The bond is almost separated. It is not condensed until its damage changes.
    }
  }
  if (!c.solution) return false;
  const CondensedModel& model = c.solution->models.front();
  const Eigen::LLT<Matrix6> K(model.K);
  if (K.info() != Eigen::Success) return false;
  const CondensedMotion motion(model, record, ends);
  root = std::max(root, root_of_interface(*c.solution, resolved, motion.relative().data(), law));
  if (root == 0.0 || root >= largest) return false;
  const double elastic = motion.energy(model), at_threshold = elastic / (root * root);
  const CondensedMotion::Vector12 before = motion.velocity(ends, 0.0), after = motion.velocity(ends, dt_last);
  if (std::fabs(energy - elastic - 0.5 * before.dot(model.M * after)) > kChange * at_threshold) return false;
  const GrainLoads loads = motion.all_loads(model, ends, turned_back(ends->axes, gravity).data());
  for (int s = 0; s < 2; ++s) {
    double other[2][6] = {};
    for (int d = 0; d < 3; ++d) {
      other[s][d] = ends[s].force[d] - loads.of[s][d];
      other[s][3 + d] = ends[s].torque[d] - loads.of[s][3 + d];
    }
    const CondensedMotion::Vector6 f = motion.generalized(other[0], other[1]).segment<6>(6 * s);
    if (0.5 * f.dot(K.solve(f)) > kChange * kChange * at_threshold) return false;
  }
  return true;
}

bool CondensedBonds::matches_rigid_pieces(Bond& resolved, const BondRecord& record, const BondEnd* ends, double energy,
                                          const LoadHistory::Largest& largest, const double* gravity, double dt_last, const Law& law) {
  if (points_in_fragments(resolved.points) >= kLeastLoose) return false;
  // Fragments carry no load, and may be in free flight.
  const std::vector<signed char> attached_grain = attached_grains_of_nodes(resolved);
  energy -= energy_of_fragments(resolved, attached_grain, law, dt_last);
  const std::vector<CondensedModel> models =
      models_of_pieces(resolved, attached_grain, frame_of(record, EndsAtCreation(record).ends).middle);
  const double radius = LoadHistory::radius_of(record);
  double force = 0.0;
  for (int s = 0; s < 2; ++s) {
    const CondensedModel& model = models[s];
    const BondRecord piece = record_of_piece(record, s);
    const auto both = both_ends_on(ends[s]);
    const CondensedMotion motion(model, piece, both.data());
    const CondensedMotion::Vector12 before = motion.velocity(both.data(), 0.0), after = motion.velocity(both.data(), dt_last);
    energy -= 0.5 * before.dot(model.M * after);
    const GrainLoads loads = motion.all_loads(model, both.data(), turned_back(ends->axes, gravity).data());
    double other[2][6] = {};
    for (int d = 0; d < 3; ++d) {
      other[0][d] = ends[s].force[d] - loads.of[0][d];
      other[0][3 + d] = ends[s].torque[d] - loads.of[0][3 + d];
    }
    const CondensedMotion::Vector6 f = motion.generalized(other[0], other[1]).head<6>();
    force = std::max(force, std::hypot(f.head<3>().norm(), f.tail<3>().norm() / radius));
  }
  if (std::fabs(energy) > kChange * 0.5 * largest.load * largest.motion || force > kChange * largest.load) return false;
  candidates_[resolved.row].solution = of_pieces(MPI_COMM_SELF, &resolved, record, law);
  return true;
}

void CondensedBonds::prepare_pieces(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows, const Law& law) {
  std::vector<char> cut(rows.size(), 0);
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (const Bond* b = bonds.find(rows[n])) cut[n] = !bonds.is_whole(*b);
  if (!rows.empty()) MPI_Allreduce(MPI_IN_PLACE, cut.data(), static_cast<int>(cut.size()), MPI_SIGNED_CHAR, MPI_MAX, comm);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    Bond* b = bonds.find(rows[n]);
    if (!b && !cut[n]) continue;
    const std::shared_ptr<const Solution> s = of_pieces(cut[n] ? comm : MPI_COMM_SELF, b, bonds.table[rows[n]], law);
    if (b) candidates_[rows[n]].solution = s;
  }
}

GrainLoads CondensedBonds::momentum_of_nodes(const Bond& resolved, const BondRecord& record, const BondEnd* ends) const {
  const Solution& s = *candidates_.at(resolved.row).solution;
  if (!s.grain_of_node.empty()) return momentum_of_pieces(resolved, s.grain_of_node, s.models, record, ends);
  const CondensedMotion motion(s.models.front(), record, ends);
  const Grid& grid = resolved.grid;
  CondensedMotion::Vector12 sum = CondensedMotion::Vector12::Zero();
  for (int i = 0; i < grid.size(); ++i) {
    if (!(grid.mass[i] > 0.0)) continue;
    const CondensedMotion::Vector6 of_node = momentum_of_node(grid, i, motion);
    const CondensedMotion::Vector6 of_second = fields_at(s.fields, i).transpose() * of_node.head<3>();
    sum.head<6>() += of_node - of_second;
    sum.tail<6>() += of_second;
  }
  return motion.loads(sum);
}

GrainLoads CondensedBonds::momentum_as_condensed(int row, const BondRecord& record, const BondEnd* ends, double half) const {
  const std::vector<CondensedModel>& models = solutions_.at(row)->models;
  if (models.size() == 2) return momentum_of_rigid_pieces(models, record, ends, half);
  const CondensedMotion motion(models.front(), record, ends);
  return motion.loads(motion.momentum_before(models.front(), ends, half));
}

}  // namespace mpdem
