// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "condensed_bonds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "../mpm/field_drive.h"
#include "../parallel/agree.h"
#include "../parallel/ranks.h"
#include "bond_description.h"
#include "condensed_fields.h"

namespace mpdem {

namespace {

using Vector3 = Eigen::Vector3d;

// The bound is that of whole material. It only says when points are looked at.
constexpr double kDriveOfDamaged = 10.0;

BondDescription described(const Bond& b, const Body& body) { return BondDescription(b.points, b.grid, body, SidesAtCreation(body).side); }

// Hash of the parameters on which every solution depends.
std::size_t hash_of_run(const PenaltyParameters& links, double inertia) {
  std::size_t hash = 0;
  for (double number : {links.law->stiffness().kn, links.law->stiffness().kt, static_cast<double>(links.at_surface), inertia})
    hash = (hash ^ std::hash<double>()(number)) * 0x9e3779b97f4a7c15ull;
  return hash;
}

}  // namespace

std::shared_ptr<const CondensedBonds::Solution> CondensedBonds::solved(MPI_Comm comm, Bond* b, const Body& body, const Law& law, int most) {
  auto s = std::make_shared<Solution>();
  const SidesAtCreation at(body);
  if (b) {
    const StaticParts parts{b->points, b->grid, b->links, at.side, body, law};
    s->fields = solve_static(comm, &parts, most);
  } else {
    s->fields = solve_static(comm, nullptr, most);
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
  if (!b) return s;
  find_strain_bounds(b->points, s->fields.strain, law, s->bound);
  s->sums.add(b->points, law, false);
  if (s->sums.largest_damage > 0.0)
    for (double& of_motion : s->bound) of_motion *= kDriveOfDamaged;
  const auto energy_by = [&](int i, int j) {
    for (std::size_t n = 0; n < b->points.blocks.size(); ++n)
      b->points.blocks[n].strain = i == j ? s->fields.strain[i][n] : s->fields.strain[i][n] + s->fields.strain[j][n];
    PointSums sums;
    sums.add(b->points, law, true);
    return sums.elastic;
  };
  for (int i = 0; i < 6; ++i) s->energy(i, i) = 2.0 * energy_by(i, i);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < i; ++j) s->energy(i, j) = s->energy(j, i) = energy_by(i, j) - 0.5 * (s->energy(i, i) + s->energy(j, j));
  for (PointBlock& p : b->points.blocks) p.strain = Sym3<vd>{};
  return s;
}

void CondensedBonds::solve(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows, const Law& law, const PenaltyParameters& links, double inertia) {
  struct Known {
    const Bond* bond;
    const Body* body;
    std::shared_ptr<const Solution> solution;
  };
  std::unordered_multimap<std::size_t, Known> known;
  for (const auto& p : patterns_) known.emplace(p.second.described, Known{&p.second.of.bond, &p.second.of.body, p.second.solution});
  std::vector<char> cut(rows.size(), 0), solved_already(rows.size(), 1);
  std::string trouble;
  const std::size_t of_all = hash_of_run(links, inertia);
  const int me = rank_in(comm);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const int row = rows[n];
    Bond* b = bonds.find(row);
    if (!b || !bonds.table[row].condensed) {
      solutions_.erase(row);
      described_.erase(row);
      continue;
    }
    cut[n] = b->cut_by_ranks();
    const BondDescription mine = described(*b, bonds.table[row]);
    const std::size_t hash = mine.hash() ^ of_all;
    const auto before = described_.find(row);
    solved_already[n] = before != described_.end() && before->second == hash && solutions_.count(row) > 0;
    described_[row] = hash;
    if (cut[n] || solved_already[n]) continue;
    const auto range = known.equal_range(hash);
    const auto equal = std::find_if(range.first, range.second, [&](const auto& k) { return described(*k.second.bond, *k.second.body) == mine; });
    if (equal != range.second) {
      solutions_[row] = equal->second.solution;
      continue;
    }
    try {
      solutions_[row] = solved(MPI_COMM_SELF, b, bonds.table[row], law);
      known.emplace(hash, Known{b, &bonds.table[row], solutions_[row]});
      ++solved_last_;
    } catch (const BadState& e) {
      if (trouble.empty()) trouble = e.what();
    }
  }
  throw_if_any(comm, trouble);
  MPI_Allreduce(MPI_IN_PLACE, cut.data(), static_cast<int>(cut.size()), MPI_SIGNED_CHAR, MPI_MAX, comm);
  MPI_Allreduce(MPI_IN_PLACE, solved_already.data(), static_cast<int>(cut.size()), MPI_SIGNED_CHAR, MPI_MIN, comm);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    if (cut[n]) cut_.insert(rows[n]);
    else cut_.erase(rows[n]);
    if (!cut[n] || solved_already[n]) continue;
    if (me == 0) ++solved_last_;  // all ranks solve it
    Bond* b = bonds.find(rows[n]);
    auto s = solved(comm, b, bonds.table[rows[n]], law);
    if (!b) continue;
    solutions_[rows[n]] = std::move(s);
  }
}

void CondensedBonds::take_patterns(MPI_Comm comm, std::vector<OfPattern> laid_out, int patterns, bool all_anew, const Law& law,
                                   const PenaltyParameters& links, double inertia) {
  solved_last_ = 0;
  std::map<int, PatternSolution> before;
  if (all_anew) before.swap(patterns_);
  const std::size_t of_all = hash_of_run(links, inertia);
  std::string trouble;
  for (OfPattern& o : laid_out) {
    PatternSolution& p = patterns_[o.pattern];
    p.of = std::move(o);
    p.described = described(p.of.bond, p.of.body).hash() ^ of_all;
    const auto was = before.find(p.of.pattern);
    if (was != before.end() && was->second.described == p.described) {
      p.solution = was->second.solution;
      continue;
    }
    try {
      p.solution = solved(MPI_COMM_SELF, &p.of.bond, p.of.body, law);
      ++solved_last_;
    } catch (const BadState& e) {
      if (trouble.empty()) trouble = e.what();
    }
  }
  throw_if_any(comm, trouble);
  if (patterns == 0) return;
  const int me = rank_in(comm);
  std::vector<int> first(patterns, std::numeric_limits<int>::max());
  for (const auto& p : patterns_) first[p.first - 1] = me;
  MPI_Allreduce(MPI_IN_PLACE, first.data(), patterns, MPI_INT, MPI_MIN, comm);
  for (auto& p : patterns_) p.second.of.counts = first[p.first - 1] == me;
}

// The model of a bond goes to all ranks that have a grain of it.
void CondensedBonds::bind(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains) {
  const int me = rank_in(comm);
  std::vector<int> teller(bonds.table.size(), std::numeric_limits<int>::max());
  for (const auto& s : solutions_) teller[s.first] = me;
  MPI_Allreduce(MPI_IN_PLACE, teller.data(), static_cast<int>(teller.size()), MPI_INT, MPI_MIN, comm);
  std::vector<Key> keys, wanted;
  std::vector<double> numbers;
  members_.clear();
  for (int row = 0; row < static_cast<int>(teller.size()); ++row) {
    const Body& body = bonds.table[row];
    if (body.pattern > 0 && body.condensed) {
      const bool first = grains.find(body.grain[0]), here = first || grains.find(body.grain[1]);
      const auto p = here ? patterns_.find(body.pattern) : patterns_.end();
      if (p != patterns_.end()) members_.push_back({row, first, p->second.solution});
      continue;
    }
    if (teller[row] == std::numeric_limits<int>::max()) continue;
    const auto own = solutions_.find(row);
    if (own != solutions_.end()) {
      members_.push_back({row, teller[row] == me, own->second});
      keys.push_back({row, 0, 0, 0});
      numbers.resize(numbers.size() + CondensedModel::kNumbers);
      own->second->model.pack(&numbers[numbers.size() - CondensedModel::kNumbers]);
    } else if (grains.find(body.grain[0]) || grains.find(body.grain[1])) {
      members_.push_back({row, false, nullptr});
      wanted.push_back({row, 0, 0, 0});
    }
  }
  std::vector<char> found;
  const std::vector<double> fetched = fetch_values(comm, CondensedModel::kNumbers, keys, numbers, wanted, found);
  const double* from = fetched.data();
  for (Member& m : members_) {
    if (m.solution) continue;
    auto s = std::make_shared<Solution>();
    s->model.unpack(from);
    from += CondensedModel::kNumbers;
    m.solution = std::move(s);
  }
  pack_up(comm, bonds, grains);
}

void CondensedBonds::pack_up(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains) {
  std::vector<CondensedPack::Part> parts;
  for (const Member& m : members_) parts.push_back({&m.solution->model, &bonds.table[m.body], m.solution->bound});
  pack_.build(comm, parts, grains.grains);
}

void CondensedBonds::drop(MPI_Comm comm, const std::vector<int>& rows, const Bonds& bonds, const BondedGrains& grains) {
  for (int row : rows) {
    solutions_.erase(row);
    described_.erase(row);
  }
  const auto gone = [&](const Member& m) { return std::binary_search(rows.begin(), rows.end(), m.body); };
  members_.erase(std::remove_if(members_.begin(), members_.end(), gone), members_.end());
  pack_up(comm, bonds, grains);
}

const CondensedBonds::Member* CondensedBonds::find(int body) const {
  const int part = part_of(body);
  return part < 0 ? nullptr : &members_[part];
}

int CondensedBonds::part_of(int body) const {
  const auto m = std::lower_bound(members_.begin(), members_.end(), body, [](const Member& a, int b) { return a.body < b; });
  return m != members_.end() && m->body == body ? static_cast<int>(m - members_.begin()) : -1;
}

void CondensedBonds::follow(const BondedGrains& grains, const double* gravity) {
  pack_.distribute(grains.grains);
  pack_.find_loads(gravity);
}

void CondensedBonds::resume(const BondedGrains& grains, const double* gravity) {
  follow(grains, gravity);
  std::vector<double> accelerations;
  for (const Grain& g : grains.grains) accelerations.insert(accelerations.end(), g.acceleration, g.acceleration + 6);
  pack_.set_accelerations(accelerations.data());
  pack_.find_inertial_loads();
}

CondensedBonds::Energies CondensedBonds::energies_of(int body, const Bonds& bonds, double half) const {
  Energies e;
  const int part = part_of(body);
  if (part < 0 || !members_[part].tells) return e;
  const CondensedModel& model = members_[part].solution->model;
  const Body& b = bonds.table[body];
  const auto side = sides_of(part, bonds);
  const CondensedMotion motion(model, b, side.data());
  const CondensedMotion::Vector12 before = motion.velocity(side.data(), 0.0), now = motion.velocity(side.data(), half),
                                  after = motion.velocity(side.data(), 2.0 * half);
  e.elastic = motion.energy(model);
  e.kinetic = 0.5 * now.dot(model.M * now);
  e.discrete_kinetic = 0.5 * before.dot(model.M * after);
  const CondensedMotion::Vector12 p = model.M * now;
  const auto in_box = [&side](const Vector3& v) { return CondensedMotion::vector(turned(side[0].axes, v.data()).data()); };
  const Vector3 P = in_box(motion.axes() * (p.segment<3>(0) + p.segment<3>(6)));
  const Vector3 L = in_box(motion.axes() * (p.segment<3>(3) + p.segment<3>(9))) + (CondensedMotion::vector(b.origin) + in_box(motion.middle())).cross(P);
  std::copy(P.data(), P.data() + 3, e.momentum);
  std::copy(L.data(), L.data() + 3, e.angular_momentum);
  return e;
}

CondensedBonds::Energies CondensedBonds::energies(const Bonds& bonds, double half) const {
  Energies sum;
  for (const Member& m : members_) {
    const Energies e = energies_of(m.body, bonds, half);
    sum.elastic += e.elastic;
    sum.kinetic += e.kinetic;
    sum.discrete_kinetic += e.discrete_kinetic;
    for (int d = 0; d < 3; ++d) {
      sum.momentum[d] += e.momentum[d];
      sum.angular_momentum[d] += e.angular_momentum[d];
    }
  }
  return sum;
}

double CondensedBonds::energy_of_points(int body) const {
  const int part = part_of(body);
  CondensedMotion::Vector6 d;
  for (int j = 0; j < 6; ++j) d[j] = pack_.relative(part, j);
  return 0.5 * d.dot(members_[part].solution->energy * d);
}

std::array<GrainSide, 2> CondensedBonds::loaded_sides(int body, const Bonds& bonds, const double* gravity) const {
  const int part = part_of(body);
  auto side = sides_of(part, bonds);
  const CondensedModel& model = members_[part].solution->model;
  const GrainLoads loads = CondensedMotion(model, bonds.table[body], side.data()).all(model, side.data(), turned_back(side[0].axes, gravity).data());
  for (GrainSide& s : side) s.body = body;
  loads.add_to(side.data());
  return side;
}

// For all bonds together the pack has the loads summed by grain already.
EnergyBooks::StepWork CondensedBonds::work(const BondedGrains& grains, const Bonds& bonds, const double* gravity, double dt_last,
                                           int first_body) const {
  if (!any()) return {};
  if (first_body == 0) return grains.work_of(pack_, dt_last);
  EnergyBooks::StepWork work;
  for (const Member& m : members_) {
    if (m.body < first_body) continue;
    const auto side = loaded_sides(m.body, bonds, gravity);
    for (const GrainSide& s : side) {
      const Grain* g = grains.find(s.tag);
      if (!g) continue;
      const std::array<double, 6> f = in_box(s, s.force, s.torque);
      for (int d = 0; d < 6; ++d) {
        work.now -= dt_last * f[d] * g->state->v_end[d];
        work.before -= dt_last * f[d] * g->state->v[d];
      }
    }
    if (!m.tells) continue;
    const CondensedModel& model = m.solution->model;
    const CondensedMotion motion(model, bonds.table[m.body], side.data());
    const CondensedMotion::Vector12 weight = model.M * motion.uniform(turned_back(side[0].axes, gravity).data()), q = motion.velocity(side.data(), 0.0);
    const double before = dt_last * q.dot(weight);
    work.before += before;
    work.now += before + 0.5 * dt_last * dt_last * (motion.velocity(side.data(), 1.0) - q).dot(weight);
  }
  return work;
}

double CondensedBonds::work_of_commands(const Bonds& bonds, double dt_last) const {
  double work = 0.0;
  for (std::size_t part = 0; part < members_.size(); ++part) {
    const Member& m = members_[part];
    if (!m.tells) continue;
    const auto side = sides_of(static_cast<int>(part), bonds);
    const CondensedModel& model = m.solution->model;
    const CondensedMotion motion(model, bonds.table[m.body], side.data());
    const CondensedMotion::Vector12 change = motion.of_sides(side[0].jump, side[1].jump);
    work += 0.5 * (motion.velocity(side.data(), dt_last) + change).dot(model.M * change);
  }
  return work;
}

std::vector<int> CondensedBonds::rows_told() const {
  std::vector<int> rows;
  for (const Member& m : members_)
    if (m.tells) rows.push_back(m.body);
  return rows;
}

std::vector<int> CondensedBonds::rows_without_points(const Bonds& bonds) const {
  std::vector<int> rows = rows_told();
  rows.erase(std::remove_if(rows.begin(), rows.end(), [&](int row) { return bonds.table[row].pattern == 0; }), rows.end());
  return rows;
}

double CondensedBonds::largest_root(Bond& b, int part, const CementOptions& options, const Law& law) const {
  show_strain(b, part);
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
  if (!pack_.any_level_reaches(wakes)) return rows;
  for (std::size_t part = 0; part < members_.size(); ++part) {
    Member& m = members_[part];
    const double bound = pack_.level(static_cast<int>(part));
    if (bound < wakes) continue;
    double changed = 0.0, d[6];
    for (int j = 0; j < 6; ++j) {
      d[j] = pack_.relative(static_cast<int>(part), j);
      changed += std::fabs(d[j] - m.looked_at[j]) * m.solution->bound[j];
    }
    if (changed < m.margin) continue;
    const int pattern = bonds.table[m.body].pattern;
    Bond* b = pattern == 0 ? bonds.find(m.body) : m.tells ? &patterns_.at(pattern).of.bond : nullptr;
    if (!b) continue;
    const double root = largest_root(*b, static_cast<int>(part), options, law);
    std::copy(d, d + 6, m.looked_at);
    m.margin = margin_of_root(law, bound, root, wakes);
    if (root >= wakes) rows.push_back(m.body);
  }
  return rows;
}

std::size_t CondensedBonds::memory_usage() const {
  std::size_t bytes = members_.capacity() * sizeof(Member) + pack_.memory_usage();
  for (const auto& p : patterns_) bytes += p.second.of.bond.memory_usage();
  for (const auto& s : solutions_) bytes += s.second.use_count() > 0 ? s.second->fields.memory_usage() / s.second.use_count() : 0;
  return bytes;
}

int CondensedBonds::count() const {
  return static_cast<int>(std::count_if(members_.begin(), members_.end(), [](const Member& m) { return m.tells; }));
}

}  // namespace mpdem
