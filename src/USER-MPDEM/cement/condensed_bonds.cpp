// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "condensed_bonds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "../parallel/agree.h"
#include "../mpm/advance_points.h"
#include "../mpm/field_drive.h"
#include "bond_description.h"

namespace mpdem {

namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

Vector3 place_of(const Grid& grid, int i) { return grid.h * Vector3(grid.keys[i][1], grid.keys[i][2], grid.keys[i][3]); }

Eigen::Matrix<double, 3, 6> fields_at(const StaticBond& fields, int i) {
  Eigen::Matrix<double, 3, 6> u;
  for (int j = 0; j < 6; ++j)
    for (int d = 0; d < 3; ++d) u(d, j) = fields.displacement[j][3 * i + d];
  return u;
}

}  // namespace

std::shared_ptr<const CondensedBonds::Solution> CondensedBonds::solved(MPI_Comm comm, Bond* b, const Body& body, const Law& law) {
  auto s = std::make_shared<Solution>();
  const SidesAtCreation at(body);
  if (b) {
    const StaticParts parts{b->points, b->grid, b->links, at.side, body, law};
    s->fields = solve_static(comm, &parts);
  } else {
    s->fields = solve_static(comm, nullptr);
  }
  s->model.K = s->fields.stiffness;
  s->model.middle = frame_of(body, at.side).middle;
  if (b)
    for (int i = 0; i < b->grid.size(); ++i)
      if (b->grid.mass[i] > 0.0 && b->grid.halo.counts_here()[i]) s->model.add_node(b->grid.mass[i], place_of(b->grid, i), fields_at(s->fields, i));
  if (comm != MPI_COMM_SELF) {
    MPI_Allreduce(MPI_IN_PLACE, s->model.M.data(), 144, MPI_DOUBLE, MPI_SUM, comm);
    MPI_Allreduce(MPI_IN_PLACE, s->model.N.data(), 108, MPI_DOUBLE, MPI_SUM, comm);
  }
  std::fill(s->bound, s->bound + 6, 0.0);
  if (b) find_strain_bounds(b->points, s->fields.strain, law, s->bound);
  return s;
}

void CondensedBonds::solve(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows, const Law& law) {
  std::unordered_multimap<std::size_t, int> known;
  std::vector<char> cut(rows.size(), 0);
  std::string trouble;
  const auto description = [&](int row) {
    const Bond& b = *bonds.find(row);
    return BondDescription(b.points, b.grid, bonds.table[row], SidesAtCreation(bonds.table[row]).side);
  };
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const int row = rows[n];
    solutions_.erase(row);
    Bond* b = bonds.find(row);
    if (!b || !bonds.table[row].condensed) continue;
    cut[n] = b->cut_by_ranks();
    if (cut[n]) continue;
    const BondDescription mine = description(row);
    const auto range = known.equal_range(mine.hash());
    const auto equal = std::find_if(range.first, range.second, [&](const auto& k) { return description(k.second) == mine; });
    if (equal != range.second) {
      solutions_[row] = solutions_[equal->second];
      continue;
    }
    try {
      solutions_[row] = solved(MPI_COMM_SELF, b, bonds.table[row], law);
      known.emplace(mine.hash(), row);
    } catch (const BadState& e) {
      if (trouble.empty()) trouble = e.what();
    }
  }
  throw_if_any(comm, trouble);
  MPI_Allreduce(MPI_IN_PLACE, cut.data(), static_cast<int>(cut.size()), MPI_SIGNED_CHAR, MPI_MAX, comm);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    if (cut[n]) cut_.insert(rows[n]);
    else cut_.erase(rows[n]);
  }
  for (std::size_t n = 0; n < rows.size(); ++n) {
    if (!cut[n]) continue;
    Bond* b = bonds.find(rows[n]);
    auto s = solved(comm, b, bonds.table[rows[n]], law);
    if (b) solutions_[rows[n]] = std::move(s);
  }
}

// The model of a bond goes to all ranks that have a side of it.
void CondensedBonds::bind(MPI_Comm comm, const Bonds& bonds, GrainSides& sides) {
  int me;
  MPI_Comm_rank(comm, &me);
  constexpr int kWidth = CondensedModel::kNumbers;
  std::vector<int> teller(bonds.table.size(), std::numeric_limits<int>::max());
  for (const auto& s : solutions_) teller[s.first] = me;
  MPI_Allreduce(MPI_IN_PLACE, teller.data(), static_cast<int>(teller.size()), MPI_INT, MPI_MIN, comm);
  any_ = std::any_of(teller.begin(), teller.end(), [](int t) { return t != std::numeric_limits<int>::max(); });
  members_.clear();
  mass_ = CondensedMass();
  if (!any_) return;
  std::vector<double> numbers(kWidth * sides.sides.size(), 0.0);
  for (const auto& s : solutions_)
    if (teller[s.first] == me) s.second->model.pack(&numbers[kWidth * static_cast<std::size_t>(sides.find(s.first, 0))]);
  sides.sum(numbers.data(), kWidth);
  mass_.of_side.assign(sides.sides.size(), -1);
  for (std::size_t at = 0; at < sides.sides.size(); at += 2) {
    const int body = sides.sides[at].body;
    if (teller[body] == std::numeric_limits<int>::max()) continue;
    Member m{body, static_cast<int>(at), teller[body] == me, nullptr, {}, CondensedMotion::Vector6::Zero(), 0.0};
    const auto own = solutions_.find(body);
    if (own != solutions_.end()) {
      m.solution = own->second;
    } else {
      auto s = std::make_shared<Solution>();
      s->model.unpack(&numbers[kWidth * at]);
      m.solution = std::move(s);
    }
    for (int s = 0; s < 2; ++s) mass_.of_side[at + s] = 2 * static_cast<int>(members_.size()) + s;
    members_.push_back(std::move(m));
  }
}

void CondensedBonds::drop(const std::vector<int>& rows) {
  for (int row : rows) solutions_.erase(row);
}

const CondensedBonds::Member* CondensedBonds::find(int body) const {
  const auto m = std::lower_bound(members_.begin(), members_.end(), body, [](const Member& a, int b) { return a.body < b; });
  return m != members_.end() && m->body == body ? &*m : nullptr;
}

void CondensedBonds::follow(const Bonds& bonds, const GrainSides& sides) {
  for (Member& m : members_) m.motion = CondensedMotion(m.solution->model, bonds.table[m.body], &sides.sides[m.side]);
}

void CondensedBonds::add_forces(GrainSides& sides, const double* gravity) const {
  for (const Member& m : members_) {
    if (!m.tells) continue;
    GrainSide* side = &sides.sides[m.side];
    const CondensedModel& model = m.solution->model;
    m.motion.elastic(model).add_to(side);
    // what of the inertia does not hang on the accelerations, and the weight
    GrainSide still[2] = {side[0], side[1]};
    for (GrainSide& s : still) std::fill(s.a, s.a + 3, 0.0), std::fill(s.alpha, s.alpha + 3, 0.0);
    const CondensedMotion::Vector12 inertia = model.M * (m.motion.rate(still) - m.motion.uniform(turned_back(side->axes, gravity).data())) + m.motion.centripetal(model, side);
    m.motion.loads(-inertia).add_to(side);
  }
}

void CondensedBonds::add_jumps(GrainSides& sides, double dt) const {
  for (const Member& m : members_) {
    if (!m.tells) continue;
    GrainSide* side = &sides.sides[m.side];
    const bool jumps = std::any_of(side[0].jump, side[0].jump + 6, [](double j) { return j != 0.0; }) ||
                       std::any_of(side[1].jump, side[1].jump + 6, [](double j) { return j != 0.0; });
    if (!jumps) continue;
    const GrainLoads l = m.motion.loads(-1.0 / dt * (m.solution->model.M * m.motion.of_sides(side[0].jump, side[1].jump)));
    for (int s = 0; s < 2; ++s)
      for (int d = 0; d < 6; ++d) side[s].jump_force[d] += l.of[s][d];
  }
}

const CondensedMass& CondensedBonds::mass() {
  mass_.own.resize(2 * members_.size());
  mass_.other.resize(2 * members_.size());
  for (std::size_t n = 0; n < members_.size(); ++n)
    for (int s = 0; s < 2; ++s) {
      mass_.own[2 * n + s] = members_[n].motion.mass(members_[n].solution->model, s, s);
      mass_.other[2 * n + s] = members_[n].motion.mass(members_[n].solution->model, s, 1 - s);
    }
  return mass_;
}

void CondensedBonds::add_inertia(GrainSides& sides) const {
  for (const Member& m : members_) {
    if (!m.tells) continue;
    GrainSide* side = &sides.sides[m.side];
    double a[2][6];
    for (int s = 0; s < 2; ++s)
      for (int d = 0; d < 3; ++d) {
        a[s][d] = side[s].a[d];
        a[s][3 + d] = side[s].alpha[d];
      }
    m.motion.loads(-(m.solution->model.M * m.motion.of_sides(a[0], a[1]))).add_to(side);
  }
}

CondensedBonds::Energies CondensedBonds::energies_of(int body, const Bonds& bonds, const GrainSides& sides, double half) const {
  Energies e;
  const Member* m = find(body);
  if (!m || !m->tells) return e;
  const GrainSide* side = &sides.sides[m->side];
  const CondensedModel& model = m->solution->model;
  const CondensedMotion::Vector12 before = m->motion.velocity(side, 0.0), now = m->motion.velocity(side, half), after = m->motion.velocity(side, 2.0 * half);
  e.elastic = m->motion.energy(model);
  e.kinetic = 0.5 * now.dot(model.M * now);
  e.kept = 0.5 * before.dot(model.M * after);
  const CondensedMotion::Vector12 p = model.M * now;
  const Body& b = bonds.table[body];
  const auto in_box = [side](const Vector3& v) { return CondensedMotion::vector(turned(side->axes, v.data()).data()); };
  const Vector3 P = in_box(m->motion.axes() * (p.segment<3>(0) + p.segment<3>(6)));
  const Vector3 L = in_box(m->motion.axes() * (p.segment<3>(3) + p.segment<3>(9))) + (CondensedMotion::vector(b.origin) + in_box(m->motion.middle())).cross(P);
  std::copy(P.data(), P.data() + 3, e.momentum);
  std::copy(L.data(), L.data() + 3, e.angular_momentum);
  return e;
}

CondensedBonds::Energies CondensedBonds::energies(const Bonds& bonds, const GrainSides& sides, double half) const {
  Energies sum;
  for (const Member& m : members_) {
    const Energies e = energies_of(m.body, bonds, sides, half);
    sum.elastic += e.elastic;
    sum.kinetic += e.kinetic;
    sum.kept += e.kept;
    for (int d = 0; d < 3; ++d) {
      sum.momentum[d] += e.momentum[d];
      sum.angular_momentum[d] += e.angular_momentum[d];
    }
  }
  return sum;
}

double CondensedBonds::gravity_power(const GrainSides& sides, const double* gravity, bool rates, int first_body) const {
  double power = 0.0;
  for (const Member& m : members_) {
    if (!m.tells || m.body < first_body) continue;
    const GrainSide* side = &sides.sides[m.side];
    CondensedMotion::Vector12 q = m.motion.velocity(side, 0.0);
    if (rates) q = m.motion.velocity(side, 1.0) - q;
    power += q.dot(m.solution->model.M * m.motion.uniform(turned_back(side->axes, gravity).data()));
  }
  return power;
}

double CondensedBonds::work_of_commands(const GrainSides& sides, double dt_last) const {
  double work = 0.0;
  for (const Member& m : members_) {
    if (!m.tells) continue;
    const GrainSide* side = &sides.sides[m.side];
    const CondensedMotion::Vector12 change = m.motion.of_sides(side[0].jump, side[1].jump);
    work += 0.5 * (m.motion.velocity(side, dt_last) + change).dot(m.solution->model.M * change);
  }
  return work;
}

CondensedBonds::NodeMotion CondensedBonds::nodes_of(const Bond& bond, const GrainSides& sides, double later) const {
  const Member& m = *find(bond.body);
  const GrainSide* side = &sides.sides[m.side];
  const Vector3& middle = m.solution->model.middle;
  const CondensedMotion::Vector12 v = m.motion.velocity(side, later), a = m.motion.rate(side);
  const CondensedMotion::Vector6 d = m.motion.relative(), half = 0.5 * d;
  const Matrix3& Q = m.motion.axes();
  const Vector3 c = m.motion.middle(), w = m.motion.turning(side);
  const auto rigid = [](const CondensedMotion::Vector6& g, const Vector3& Y) { return Vector3(g.head<3>() + Vector3(g.tail<3>()).cross(Y)); };
  NodeMotion n;
  for (auto* values : {&n.displacement, &n.velocity, &n.acceleration}) values->resize(3 * static_cast<std::size_t>(bond.grid.size()));
  for (int i = 0; i < bond.grid.size(); ++i) {
    const Vector3 X = place_of(bond.grid, i), Y = X - middle;
    const Eigen::Matrix<double, 3, 6> u = fields_at(m.solution->fields, i);
    const Vector3 y = Y + u * d - rigid(half, Y);  // the axes go with half of the relative motion
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

void CondensedBonds::show_strain(Bond& bond) const {
  const Member& m = *find(bond.body);
  const CondensedMotion::Vector6 d = m.motion.relative();
  for (std::size_t b = 0; b < bond.points.blocks.size(); ++b) {
    Sym3<vd> e{};
    for (int j = 0; j < 6; ++j) e = e + splat(d[j]) * m.solution->fields.strain[j][b];
    bond.points.blocks[b].strain = e;
  }
}

void CondensedBonds::wake(MPI_Comm comm, int body, Bond* bond, const Bonds& bonds, const GrainSides& sides, const double* gravity, double dt_last,
                          const Law& law) const {
  if (bond) {
    Grid& grid = bond->grid;
    show_strain(*bond);
    NodeMotion n = nodes_of(*bond, sides, 0.5 * dt_last);
    for (std::size_t i = 0; i < n.velocity.size(); ++i) n.velocity[i] -= 0.5 * dt_last * n.acceleration[i];
    grid.displacement.swap(n.displacement);
    grid.velocity.swap(n.velocity);
    grid.acceleration.swap(n.acceleration);
    const Matrix3& Q = find(body)->motion.axes();
    double turn[3][3];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) turn[i][j] = Q(i, j);
    take_up_field(bond->points, grid, turn);
  }
  const bool cut = cut_.count(body) > 0;
  const std::array<double, 3> along = turned_back(axes_of(bonds.table[body]), gravity);
  if (bond || cut) settle(cut ? comm : MPI_COMM_SELF, bond, bonds.table[body], sides, along.data(), law);
}

// The fields are linear. What is left of forces is of the order of the strain, but links are stiff: a step of Newton's method takes it away.
void CondensedBonds::settle(MPI_Comm comm, Bond* bond, const Body& body, const GrainSides& sides, const double* gravity, const Law& law) const {
  constexpr int kIterations = 2;
  for (int k = 0; k < kIterations; ++k) {
    if (!bond) {
      solve_static(comm, nullptr, {});
      continue;
    }
    Grid& grid = bond->grid;
    GrainSide side[2] = {sides.sides[bond->side], sides.sides[bond->side + 1]};
    for (GrainSide& s : side)  // no dampers
      for (int d = 0; d < 3; ++d) s.v[d] = s.omega[d] = 0.0;
    std::vector<double> velocity(grid.velocity.size(), 0.0);
    velocity.swap(grid.velocity);
    grid.clear_force();
    add_internal_force(bond->points, grid, law);
    bond->links.add_force(grid, side);
    grid.sum_force();
    for (int i = 0; i < grid.size(); ++i)
      for (int d = 0; d < 3; ++d)
        if (grid.ties.row(i) < 0) grid.force[3 * i + d] += grid.mass[i] * (gravity[d] - grid.acceleration[3 * i + d]);
    const StaticParts parts{bond->points, grid, bond->links, side, body, law};
    grid.velocity = solve_static(comm, &parts, grid.force);
    AdvanceOptions options;
    options.nonlocal = true;  // without averages no damage grows
    bond->points.average.clear();
    AdvanceResult result;
    grid.clear_force();
    advance_points(bond->points, 0, static_cast<int>(bond->points.blocks.size()), grid, law, 1.0, options, result);
    for (std::size_t i = 0; i < velocity.size(); ++i) grid.displacement[i] += grid.velocity[i];
    velocity.swap(grid.velocity);
  }
}

double CondensedBonds::largest_root(Bond& b, const CementOptions& options, const Law& law) const {
  show_strain(b);
  // averages of points that other ranks have would need sums over these: without them a bond wakes earlier
  const bool averaged = options.skip.nonlocal && !b.cut_by_ranks();
  if (averaged) {
    const AverageSweeps sweeps = sweeps_for(options.length, options.cell, options.basis);
    b.average.start(b.points, b.grid, law);
    for (int k = 0; k < sweeps.count; ++k)
      b.average.sweep(b.points, b.grid, k == sweeps.count - 1 ? sweeps.last_weight : 1.0, k == sweeps.count - 1);
  }
  return largest_root_of_drive(b.points, law, averaged);
}

// The bound is by norms and some times the root itself. So the points are looked at when it says that they might be due, and again when a change
// of the motion might have made them due. So when a bond wakes does not hang on when it was looked at.
std::vector<int> CondensedBonds::due(Bonds& bonds, const CementOptions& options, const Law& law) {
  const double wakes = root_of_share(law, options.wake);
  std::vector<int> rows;
  for (Member& m : members_) {
    const CondensedMotion::Vector6& d = m.motion.relative();
    double bound = 0.0, changed = 0.0;
    for (int j = 0; j < 6; ++j) {
      bound += std::fabs(d[j]) * m.solution->bound[j];
      changed += std::fabs(d[j] - m.looked_at[j]) * m.solution->bound[j];
    }
    if (bound < wakes || changed < m.margin) continue;
    Bond* b = bonds.find(m.body);
    if (!b) continue;
    const double root = largest_root(*b, options, law);
    m.looked_at = d;
    m.margin = margin_of_root(law, bound, root, wakes);
    if (root >= wakes) rows.push_back(m.body);
  }
  return rows;
}

std::size_t CondensedBonds::memory_usage() const {
  std::size_t bytes = members_.capacity() * sizeof(Member);
  for (const auto& s : solutions_) bytes += s.second.use_count() > 0 ? s.second->fields.memory_usage() / s.second.use_count() : 0;
  return bytes;
}

int CondensedBonds::count() const {
  return static_cast<int>(std::count_if(members_.begin(), members_.end(), [](const Member& m) { return m.tells; }));
}

}  // namespace mpdem
