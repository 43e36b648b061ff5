// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "condensed_bonds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "../../mpm/field_drive.h"
#include "../../numerics/index_in.h"
#include "../../parallel/agree.h"
#include "../../parallel/ranks.h"
#include "bond_description.h"
#include "condensed_fields.h"
#include "rigid_pieces.h"

namespace mpdem {

namespace {

using Vector3 = Eigen::Vector3d;

// Factor on the bound, which is that of undamaged material, for damaged material. The bound only decides when points
// are examined.
constexpr double kDriveOfDamaged = 10.0;

BondDescription described(const Bond& b, const BondRecord& record) {
  return BondDescription(b.points, b.film.points, b.grid, record, EndsAtCreation(record).ends);
}

// Nodes at the edge with almost no stiffness may have large errors in the static fields. Stiffness and strain do not
// depend on them, but with their masses the bond gets too large an inertia. If all of a bond moves about as its grains,
// each grain has a third of its mass. A larger inertia is harmless while it is small against the grains: it may be
// kHeaviest times the mass of the bond, or the share kOfGrain of the mass of a grain with the density of the cement.
constexpr double kHeaviest = 2.0, kOfGrain = 0.05;
bool is_too_heavy(const CondensedModel& model, const BondRecord& record) {
  const auto trace = [&](int i, int j) { return model.M.block<3, 3>(i, j).trace(); };
  const double mass = trace(0, 0) + trace(6, 6) + 2.0 * trace(0, 6);  // mass of the bond: both grains move alike
  const double grain =
      4.0 / 3.0 * M_PI * std::pow(std::min(record.radius[0], record.radius[1]), 3) / record.volume;  // volume of grain over bond
  return !(std::max(trace(0, 0), trace(6, 6)) <= std::max(kHeaviest, kOfGrain * grain) * mass);
}

// Hash of the parameters on which all solutions depend.
std::size_t hash_of_run(const PenaltyParameters& links, double scaled_density) {
  std::size_t hash = 0;
  const auto add = [&hash](double number) { hash = (hash ^ std::hash<double>()(number)) * 0x9e3779b97f4a7c15ull; };
  for (double number : {links.law->stiffness().kn, links.law->stiffness().kt, static_cast<double>(links.at_surface), scaled_density})
    add(number);
  for (int n = 1; n < links.law->materials(); ++n) {
    const TractionStiffness& of_material = links.law->of_material(n).stiffness();
    add(of_material.kn);
    add(of_material.kt);
  }
  return hash;
}

// Nodes may have almost no stiffness beside failed points and at edges without constrained nodes. Such a bond has to
// converge soon, or it stays resolved. A bond that was condensed before has the full number of steps.
struct LooseNodes {
  int failed = 0, constraints = 0;
  explicit LooseNodes(const Bond* b)
      : failed(b && b->points.any_failed()), constraints(b ? static_cast<int>(b->grid.constraints.size()) : 0) {}
  int most_steps(const BondRecord& record) const {
    return !record.in_motion && (failed || constraints == 0) ? kMostStepsOfCandidate : kMostStaticSteps;
  }
};

// Sums over the ranks that have nodes of the bond.
void complete(MPI_Comm comm, CondensedModel& model) {
  if (comm != MPI_COMM_SELF) {
    MPI_Allreduce(MPI_IN_PLACE, model.M.data(), 144, MPI_DOUBLE, MPI_SUM, comm);
    MPI_Allreduce(MPI_IN_PLACE, model.N.data(), 108, MPI_DOUBLE, MPI_SUM, comm);
  }
  model.find_inertial_coupling();
}

}  // namespace

std::shared_ptr<const CondensedBonds::Solution> CondensedBonds::solved(MPI_Comm comm, Bond* b, const BondRecord& record, const Law& law,
                                                                       int most) {
  auto s = std::make_shared<Solution>();
  const EndsAtCreation at(record);
  if (b) {
    const StaticSystem system{b->points, b->grid, b->links, at.ends, record, law, b->film};
    s->fields = solve_static(comm, &system, most);
  } else {
    s->fields = solve_static(comm, nullptr, most);
  }
  CondensedModel& model = s->models.front();
  model.K = s->fields.stiffness;
  model.middle = frame_of(record, at.ends).middle;
  if (b)
    for (int i = 0; i < b->grid.size(); ++i)
      if (b->grid.mass[i] > 0.0 && b->grid.halo.counts_here()[i])
        model.add_node(b->grid.mass[i], position_of(b->grid, i), fields_at(s->fields, i));
  complete(comm, model);
  if (is_too_heavy(model, record))
    throw BadState(text_of("the static fields of the bond of grains ", record.grain[0], " and ", record.grain[1],
                           " are far off at nodes that are connected by almost nothing; ", kCureOfLooseNodes));
  if (!b) return s;
  const Film::Strains* const strains[] = {&s->fields.strain, &s->fields.strain_of_film};
  for (int n : {Bond::kOnGrid, Bond::kColumns}) {
    double bound[6];
    find_strain_bounds(*b->stores()[n], *strains[n], law, bound);
    for (int j = 0; j < 6; ++j) s->bound[j] = std::max(s->bound[j], bound[j]);
    s->sums.add(*b->stores()[n], law, false);
  }
  const std::shared_ptr<const TractionLaw>& interface = b->links.parameters().law;
  if (interface && interface->fields() > 0) {
    s->interface = interface;
    double of_links[6], of_faces[6];
    b->links.largest_onset_shares(s->fields.separations, of_links);
    b->film.largest_onset_shares(s->fields.faces, *interface, of_faces);
    for (int j = 0; j < 6; ++j) s->bound[j] = std::max(s->bound[j], root_of_share(law, 1.0) * std::max(of_links[j], of_faces[j]));
  }
  if (s->sums.largest_damage > 0.0)
    for (double& of_motion : s->bound) of_motion *= kDriveOfDamaged;
  b->points.forget_roots_of_norm();
  const auto energy_by = [&](int i, int j) {  // energy of the points by field i, or by the sum of two fields
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
  s->energy += s->fields.stiffness_of_film;
  return s;
}

// Pieces have no stiffness and no strain.
std::shared_ptr<const CondensedBonds::Solution> CondensedBonds::of_pieces(MPI_Comm comm, Bond* b, const BondRecord& record,
                                                                          const Law& law) {
  auto s = std::make_shared<Solution>();
  const Eigen::Vector3d middle = frame_of(record, EndsAtCreation(record).ends).middle;
  if (b) {
    s->grain_of_node = grains_of_nodes(*b, record);
    s->models = models_of_pieces(*b, s->grain_of_node, middle);
    for (const PointStore* store : b->stores()) s->sums.add(*store, law, false);
  } else {
    s->models.assign(2, CondensedModel());
    for (CondensedModel& m : s->models) m.middle = middle;
  }
  for (CondensedModel& m : s->models) complete(comm, m);
  return s;
}

bool CondensedBonds::solve_shared(MPI_Comm comm, Bonds& bonds, int row, const Law& law) {
  const BondRecord& record = bonds.table[row];
  Bond* b = bonds.find(row);
  std::shared_ptr<const Solution> s;
  if (is_in_pieces(row)) {
    s = of_pieces(comm, b, record, law);
  } else {
    LooseNodes loose(b);
    for (int* of_any : {&loose.failed, &loose.constraints}) MPI_Allreduce(MPI_IN_PLACE, of_any, 1, MPI_INT, MPI_MAX, comm);
    try {
      s = solved(comm, b, record, law, loose.most_steps(record));
    } catch (const BadState&) {
      if (record.in_motion) throw;
      return false;
    }
    if (rank_in(comm) == 0) ++solved_last_;  // all ranks solve it together
  }
  if (b) solutions_[row] = std::move(s);
  return true;
}

std::vector<int> CondensedBonds::solve(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows, const Law& law,
                                       const PenaltyParameters& links, double scaled_density) {
  struct Known {
    const Bond* bond;
    const BondRecord* record;
    std::shared_ptr<const Solution> solution;
  };
  std::unordered_multimap<std::size_t, Known> known;
  for (const auto& p : templates_) known.emplace(p.second.described, Known{&p.second.of.bond, &p.second.of.record, p.second.solution});
  std::vector<char> cut(rows.size(), 0), solved_already(rows.size(), 1);
  std::vector<int> without;  // rows that did not converge
  std::string trouble;
  const std::size_t hash_of_all = hash_of_run(links, scaled_density);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const int row = rows[n];
    Bond* b = bonds.find(row);
    if (!b || !bonds.table[row].condensed) {
      solutions_.erase(row);
      described_.erase(row);
      continue;
    }
    // Shared nodes do not show whether ranks cut the bond: pieces of a separated bond share none, and may be on two ranks.
    cut[n] = !bonds.is_whole(*b);
    const BondDescription mine = described(*b, bonds.table[row]);
    const std::size_t hash = mine.hash() ^ hash_of_all;
    const auto before = described_.find(row);
    solved_already[n] = before != described_.end() && before->second == hash && solutions_.count(row) > 0;
    described_[row] = hash;
    if (cut[n] || solved_already[n]) continue;
    if (is_in_pieces(row)) {
      solutions_[row] = of_pieces(MPI_COMM_SELF, b, bonds.table[row], law);
      continue;
    }
    const auto range = known.equal_range(hash);
    const auto equal =
        std::find_if(range.first, range.second, [&](const auto& k) { return described(*k.second.bond, *k.second.record) == mine; });
    if (equal != range.second) {
      solutions_[row] = equal->second.solution;
      continue;
    }
    const BondRecord& record = bonds.table[row];
    try {
      solutions_[row] = solved(MPI_COMM_SELF, b, record, law, LooseNodes(b).most_steps(record));
      known.emplace(hash, Known{b, &record, solutions_[row]});
      ++solved_last_;
    } catch (const BadState& e) {
      if (!record.in_motion) without.push_back(row);
      else if (trouble.empty()) trouble = e.what();
    }
  }
  throw_if_any(comm, trouble);
  MPI_Allreduce(MPI_IN_PLACE, cut.data(), static_cast<int>(cut.size()), MPI_SIGNED_CHAR, MPI_MAX, comm);
  MPI_Allreduce(MPI_IN_PLACE, solved_already.data(), static_cast<int>(cut.size()), MPI_SIGNED_CHAR, MPI_MIN, comm);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    if (cut[n]) cut_.insert(rows[n]);
    else cut_.erase(rows[n]);
    if (cut[n] && !solved_already[n] && !solve_shared(comm, bonds, rows[n], law)) without.push_back(rows[n]);
  }
  without = union_of_ranks(comm, without);
  without_field_last_ = without;
  for (int row : without) {
    bonds.table[row].condensed = false;
    solutions_.erase(row);
    described_.erase(row);
    cut_.erase(row);
  }
  return without;
}

void CondensedBonds::install_templates(MPI_Comm comm, std::vector<TemplateBond> laid_out, int templates, bool all_anew, const Law& law,
                                       const PenaltyParameters& links, double scaled_density) {
  solved_last_ = 0;
  std::map<int, TemplateSolution> before;
  if (all_anew) before.swap(templates_);
  const std::size_t hash_of_all = hash_of_run(links, scaled_density);
  std::string trouble;
  for (TemplateBond& o : laid_out) {
    TemplateSolution& p = templates_[o.point_template];
    p.of = std::move(o);
    p.described = described(p.of.bond, p.of.record).hash() ^ hash_of_all;
    const TemplateSolution was = std::move(before[p.of.point_template]);
    if (was.solution && was.described == p.described) {
      p.solution = was.solution;
      continue;
    }
    try {
      p.solution = solved(MPI_COMM_SELF, &p.of.bond, p.of.record, law);
      ++solved_last_;
    } catch (const BadState& e) {
      if (trouble.empty()) trouble = e.what();
    }
  }
  throw_if_any(comm, trouble);
  if (templates == 0) return;
  const int me = rank_in(comm);
  std::vector<int> first(templates, std::numeric_limits<int>::max());
  for (const auto& p : templates_) first[p.first - 1] = me;
  MPI_Allreduce(MPI_IN_PLACE, first.data(), templates, MPI_INT, MPI_MIN, comm);
  for (auto& p : templates_) p.second.of.counts = first[p.first - 1] == me;
}

// Sends the model of each bond to all ranks that have a grain of it.
void CondensedBonds::bind(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains) {
  const int me = rank_in(comm);
  std::vector<int> owner(bonds.table.size(), std::numeric_limits<int>::max());
  for (const auto& s : solutions_) owner[s.first] = me;
  MPI_Allreduce(MPI_IN_PLACE, owner.data(), static_cast<int>(owner.size()), MPI_INT, MPI_MIN, comm);
  std::vector<Key> keys, wanted;
  std::vector<double> numbers;
  members_.clear();
  for (int row = 0; row < static_cast<int>(owner.size()); ++row) {
    const BondRecord& record = bonds.table[row];
    if (record.point_template > 0 && record.condensed) {
      const bool first = grains.find(record.grain[0]), here = first || grains.find(record.grain[1]);
      const auto p = here ? templates_.find(record.point_template) : templates_.end();
      if (p != templates_.end()) members_.push_back({row, first, p->second.solution, -1});
      continue;
    }
    if (owner[row] == std::numeric_limits<int>::max()) continue;
    const auto own = solutions_.find(row);
    const int pieces = is_in_pieces(row) ? 2 : 1;
    for (int n = 0; n < pieces; ++n) {
      const int piece = pieces == 2 ? n : -1;
      if (piece >= 0 && !record.has_grain(piece)) continue;
      if (own != solutions_.end()) {
        members_.push_back({row, owner[row] == me, own->second, piece});
        keys.push_back({row, n, 0, 0});
        numbers.resize(numbers.size() + CondensedModel::kNumbers);
        own->second->models[n].pack(&numbers[numbers.size() - CondensedModel::kNumbers]);
      } else if (grains.find(record.grain[0]) || grains.find(record.grain[1])) {
        members_.push_back({row, false, nullptr, piece});
        wanted.push_back({row, n, 0, 0});
      }
    }
  }
  std::vector<char> found;
  const std::vector<double> fetched = fetch_values(comm, CondensedModel::kNumbers, keys, numbers, wanted, found);
  const double* from = fetched.data();
  for (Member& m : members_) {
    if (m.solution) continue;
    auto s = std::make_shared<Solution>();
    s->models.resize(1 + std::max(m.piece, 0));
    s->models.back().unpack(from);
    from += CondensedModel::kNumbers;
    m.solution = std::move(s);
  }
  pack_up(comm, bonds, grains);
}

void CondensedBonds::pack_up(MPI_Comm comm, const Bonds& bonds, const BondedGrains& grains) {
  std::vector<CondensedPack::Entry> entries;
  std::vector<BondRecord> pieces(members_.size());
  for (std::size_t n = 0; n < members_.size(); ++n)
    entries.push_back({&model_of(n), &record_of(n, bonds, pieces[n]), members_[n].solution->bound});
  pack_.build(comm, entries, grains.grains);
}

void CondensedBonds::drop(MPI_Comm comm, const std::vector<int>& rows, const Bonds& bonds, const BondedGrains& grains) {
  for (int row : rows) {
    solutions_.erase(row);
    described_.erase(row);
    cut_.erase(row);
  }
  const auto gone = [&](const Member& m) { return std::binary_search(rows.begin(), rows.end(), m.row); };
  members_.erase(std::remove_if(members_.begin(), members_.end(), gone), members_.end());
  pack_up(comm, bonds, grains);
}

const BondRecord& CondensedBonds::record_of(std::size_t member, const Bonds& bonds, BondRecord& piece) const {
  const Member& m = members_[member];
  if (m.piece < 0) return bonds.table[m.row];
  return piece = record_of_piece(bonds.table[m.row], m.piece);
}

const CondensedBonds::Member* CondensedBonds::find(int bond_row) const {
  const int member = member_of_row(bond_row);
  return member < 0 ? nullptr : &members_[member];
}

int CondensedBonds::member_of_row(int bond_row) const {
  const auto m = std::lower_bound(members_.begin(), members_.end(), bond_row, [](const Member& a, int b) { return a.row < b; });
  return m != members_.end() && m->row == bond_row ? static_cast<int>(m - members_.begin()) : -1;
}

int CondensedBonds::member_of(int bond_row) const {
  return static_cast<int>(index_in(
      members_, bond_row, [](const Member& m) { return m.row; }, "condensed bond"));
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

void CondensedBonds::Energies::add(const Energies& e) {
  elastic += e.elastic;
  kinetic += e.kinetic;
  discrete_kinetic += e.discrete_kinetic;
  for (int d = 0; d < 3; ++d) {
    momentum[d] += e.momentum[d];
    angular_momentum[d] += e.angular_momentum[d];
  }
}

CondensedBonds::Energies CondensedBonds::energies_of_member(std::size_t member, const Bonds& bonds, double half, const Ends* given) const {
  Energies e;
  if (!members_[member].owns) return e;
  const CondensedModel& model = model_of(member);
  BondRecord piece;
  const BondRecord& b = record_of(member, bonds, piece);
  const Ends ends = given ? *given : pack_.ends(static_cast<int>(member), b);
  const CondensedMotion motion(model, b, ends.data());
  const CondensedMotion::Vector12 before = motion.velocity(ends.data(), 0.0), now = motion.velocity(ends.data(), half),
                                  after = motion.velocity(ends.data(), 2.0 * half);
  e.elastic = motion.energy(model);
  e.kinetic = 0.5 * now.dot(model.M * now);
  e.discrete_kinetic = 0.5 * before.dot(model.M * after);
  const CondensedMotion::Vector12 p = model.M * now;
  const auto in_box = [&ends](const Vector3& v) { return CondensedMotion::vector(turned(ends[0].axes, v.data()).data()); };
  const Vector3 P = in_box(motion.axes() * (p.segment<3>(0) + p.segment<3>(6)));
  const Vector3 L =
      in_box(motion.axes() * (p.segment<3>(3) + p.segment<3>(9))) + (CondensedMotion::vector(b.origin) + in_box(motion.middle())).cross(P);
  std::copy(P.data(), P.data() + 3, e.momentum);
  std::copy(L.data(), L.data() + 3, e.angular_momentum);
  return e;
}

CondensedBonds::Energies CondensedBonds::energies_of(int bond_row, const Bonds& bonds, double half) const {
  Energies sum;
  each_member_of(bond_row, [&](std::size_t member) { sum.add(energies_of_member(member, bonds, half)); });
  return sum;
}

int CondensedBonds::member_of_piece(int bond_row, int piece) const {
  int found = -1;
  each_member_of(bond_row, [&](std::size_t member) {
    if (members_[member].piece == piece) found = static_cast<int>(member);
  });
  return found;
}

CondensedBonds::Energies CondensedBonds::energies_of_piece(int bond_row, int piece, const Bonds& bonds, double half,
                                                           const Ends& ends) const {
  const int member = member_of_piece(bond_row, piece);
  return member < 0 ? Energies() : energies_of_member(static_cast<std::size_t>(member), bonds, half, &ends);
}

CondensedBonds::Ends CondensedBonds::ends_of(int row, const Bonds& bonds) const {
  Ends both{};
  each_member_of(row, [&](std::size_t member) {
    BondRecord of_piece;
    const Ends ends = pack_.ends(static_cast<int>(member), record_of(member, bonds, of_piece));
    const int piece = members_[member].piece;
    if (piece < 0) both = ends;
    else both[piece] = ends[0];
  });
  return both;
}

bool CondensedBonds::ends_of_piece(int row, int piece, const Bonds& bonds, Ends& ends) const {
  const int member = member_of_piece(row, piece);
  if (member < 0) return false;
  BondRecord of_piece;
  ends = pack_.ends(member, record_of(static_cast<std::size_t>(member), bonds, of_piece));
  return true;
}

CondensedBonds::Energies CondensedBonds::energies(const Bonds& bonds, double half) const {
  Energies sum;
  for (std::size_t member = 0; member < members_.size(); ++member) sum.add(energies_of_member(member, bonds, half));
  return sum;
}

double CondensedBonds::energy_of_points(int row) const {
  const int member = member_of(row);
  CondensedMotion::Vector6 d;
  for (int j = 0; j < 6; ++j) d[j] = pack_.relative(member, j);
  return 0.5 * d.dot(members_[member].solution->energy * d);
}

std::array<BondEnd, 2> CondensedBonds::loaded_ends_of_member(std::size_t member, const Bonds& bonds, const double* gravity) const {
  BondRecord piece;
  const BondRecord& record = record_of(member, bonds, piece);
  auto ends = pack_.ends(static_cast<int>(member), record);
  const CondensedModel& model = model_of(member);
  const GrainLoads loads =
      CondensedMotion(model, record, ends.data()).all_loads(model, ends.data(), turned_back(ends[0].axes, gravity).data());
  for (BondEnd& s : ends) s.row = members_[member].row;
  loads.add_to(ends.data());
  return ends;
}

// A piece has its loads on the first of its ends.
std::array<BondEnd, 2> CondensedBonds::loaded_ends(int bond_row, const Bonds& bonds, const double* gravity) const {
  std::array<BondEnd, 2> ends{};  // the end of a piece whose grain left has no load
  each_member_of(bond_row, [&](std::size_t member) {
    const auto of_member = loaded_ends_of_member(member, bonds, gravity);
    const int piece = members_[member].piece;
    if (piece < 0) {
      ends = of_member;
      return;
    }
    ends[piece] = of_member[0];
    ends[piece].side = piece;
  });
  return ends;
}

// For all bonds together the pack has the loads already, summed by grain.
EnergyBalance::StepWork CondensedBonds::work(const BondedGrains& grains, const Bonds& bonds, const double* gravity, double dt_last,
                                             int first_row, int end_row) const {
  if (!any()) return {};
  if (first_row == 0 && end_row == std::numeric_limits<int>::max()) return grains.work_of(pack_, dt_last);
  EnergyBalance::StepWork work;
  for (std::size_t member = 0; member < members_.size(); ++member) {
    const Member& m = members_[member];
    if (m.row < first_row || m.row >= end_row) continue;
    const auto ends = loaded_ends_of_member(member, bonds, gravity);
    for (const BondEnd& s : ends) {
      const Grain* g = grains.find(s.tag);
      if (!g) continue;
      const std::array<double, 6> f = in_box(s, s.force, s.torque);
      for (int d = 0; d < 6; ++d) {
        work.now -= dt_last * f[d] * g->state->v_end[d];
        work.with_velocity_before -= dt_last * f[d] * g->state->v[d];
      }
    }
    if (!m.owns) continue;
    const CondensedModel& model = model_of(member);
    BondRecord piece;
    const CondensedMotion motion(model, record_of(member, bonds, piece), ends.data());
    const CondensedMotion::Vector12 weight = model.M * motion.uniform(turned_back(ends[0].axes, gravity).data()),
                                    q = motion.velocity(ends.data(), 0.0);
    const double before = dt_last * q.dot(weight);
    work.with_velocity_before += before;
    work.now += before + 0.5 * dt_last * dt_last * (motion.velocity(ends.data(), 1.0) - q).dot(weight);
  }
  return work;
}

double CondensedBonds::work_of_commands(const Bonds& bonds, double dt_last) const {
  double work = 0.0;
  for (std::size_t member = 0; member < members_.size(); ++member) {
    const Member& m = members_[member];
    if (!m.owns) continue;
    BondRecord piece;
    const BondRecord& record = record_of(member, bonds, piece);
    const auto ends = pack_.ends(static_cast<int>(member), record);
    const CondensedModel& model = model_of(member);
    const CondensedMotion motion(model, record, ends.data());
    const CondensedMotion::Vector12 change = motion.to_q(ends[0].jump, ends[1].jump);
    work += (motion.velocity(ends.data(), dt_last) + 0.5 * change).dot(model.M * change);
  }
  return work;
}

void CondensedBonds::note_peaks(std::vector<double>& peaks) const {
  pack_.each_tension([&](std::size_t member, double tension) {
    const Member& m = members_[member];
    if (m.owns && m.piece < 0) peaks[m.row] = std::max(peaks[m.row], tension);
  });
}

std::vector<int> CondensedBonds::owned_rows() const {
  std::vector<int> rows;
  for (const Member& m : members_)
    if (m.owns && (rows.empty() || rows.back() != m.row)) rows.push_back(m.row);  // a bond may have one or two pieces
  return rows;
}

std::vector<int> CondensedBonds::rows_without_points(const Bonds& bonds) const {
  std::vector<int> rows;
  for (int row : bonds.rows_without_points())
    if (owns(row)) rows.push_back(row);
  return rows;
}

double CondensedBonds::root_of_interface(const Solution& s, const Bond& b, const double* d, const Law& law) {
  if (!s.interface) return 0.0;
  return root_of_share(law, 1.0) *
         std::max(b.links.largest_onset_share(s.fields.separations, d), b.film.largest_onset_share(s.fields.faces, *s.interface, d));
}

double CondensedBonds::root_of_interface(const Bond& bond, const Law& law) const {
  const int member = member_of(bond.row);
  double d[6];
  for (int j = 0; j < 6; ++j) d[j] = pack_.relative(member, j);
  return root_of_interface(*members_[static_cast<std::size_t>(member)].solution, bond, d, law);
}

double CondensedBonds::largest_root(Bond& b, const BondRecord& record, int member, const CementOptions& options, const Law& law) const {
  show_strain(b, member);
  double d[6];
  for (int j = 0; j < 6; ++j) d[j] = pack_.relative(member, j);
  const double of_film = std::max(largest_root_of_drive(b.film.points, law, nullptr),
                                  root_of_interface(*members_[static_cast<std::size_t>(member)].solution, b, d, law));
  if (!options.advance.nonlocal) return std::max(of_film, largest_root_of_drive(b.points, law, nullptr));
  DriveAverage average;  // temporary: a condensed bond keeps no lists for it
  average.find(b.points, b.grid, law, smoothing_passes_for(options.length, options.cell, options.basis), {&record, options.imperfection});
  const double root = largest_root_of_drive(b.points, law, &b.grid);
  b.grid.drive_average.clear();
  return std::max(of_film, root);
}

// The bound uses norms of the strain, and may be several times the root itself. Points are examined when the bound
// reaches the level of activation, and again when the motion has changed by the margin of the last examination. So the
// step of activation does not depend on when points were examined.
std::vector<int> CondensedBonds::rows_due(Bonds& bonds, const CementOptions& options, const Law& law, std::vector<int>& together) {
  const double times = options.advance.nonlocal ? bound_of_averages(law) : 1.0,
               activation_root = root_of_share(law, options.activation_share) / times;
  std::vector<int> rows;
  if (!pack_.any_level_reaches(activation_root)) return rows;
  for (std::size_t member = 0; member < members_.size(); ++member) {
    const Member& m = members_[member];
    if (pack_.level(static_cast<int>(member)) < activation_root) continue;
    double changed = 0.0;
    for (int j = 0; j < 6; ++j) changed += std::fabs(pack_.relative(static_cast<int>(member), j) - m.examined_at[j]) * m.solution->bound[j];
    if (times * changed < m.margin) continue;
    const int point_template = bonds.table[m.row].point_template;
    Bond* b = point_template == 0 ? bonds.find(m.row) : m.owns ? &templates_.at(point_template).of.bond : nullptr;
    if (!b) continue;
    if (options.advance.nonlocal && cut_.count(m.row) > 0) together.push_back(m.row);
    else if (note_check(member, largest_root(*b, bonds.table[m.row], static_cast<int>(member), options, law), options, law))
      rows.push_back(m.row);
  }
  return rows;
}

bool CondensedBonds::note_check(std::size_t member, double root, const CementOptions& options, const Law& law) {
  Member& m = members_[member];
  for (int j = 0; j < 6; ++j) m.examined_at[j] = pack_.relative(static_cast<int>(member), j);
  const double activation_root = root_of_share(law, options.activation_share), bound = pack_.level(static_cast<int>(member));
  m.margin = options.advance.nonlocal ? margin_of_average(law, bound_of_averages(law) * bound, root, activation_root)
                                      : margin_of_root(law, bound, root, activation_root);
  return root >= activation_root;
}

bool CondensedBonds::note_check(int bond_row, double root, const CementOptions& options, const Law& law) {
  const int member = member_of_row(bond_row);
  return member >= 0 ? note_check(static_cast<std::size_t>(member), root, options, law) : false;
}

void CondensedBonds::forget_candidates_but(const Bonds& bonds) {
  for (auto c = candidates_.begin(); c != candidates_.end();) {
    const Bond* b = bonds.find(c->first);
    c = b && bonds.is_resolved(*b) ? std::next(c) : candidates_.erase(c);
  }
}

std::size_t CondensedBonds::memory_usage() const {
  std::size_t bytes = members_.capacity() * sizeof(Member) + pack_.memory_usage();
  std::set<const Solution*> solutions;  // shared by bonds
  for (const auto& p : templates_) {
    bytes += p.second.of.bond.memory_usage();
    solutions.insert(p.second.solution.get());
  }
  for (const auto& s : solutions_) solutions.insert(s.second.get());
  for (const auto& c : candidates_) solutions.insert(c.second.solution.get());
  for (const Member& m : members_) solutions.insert(m.solution.get());
  for (const Solution* s : solutions)
    if (s)
      bytes += sizeof(Solution) + s->fields.memory_usage() + s->models.capacity() * sizeof(CondensedModel) + s->grain_of_node.capacity();
  return bytes;
}

int CondensedBonds::count() const { return static_cast<int>(owned_rows().size()); }

}  // namespace mpdem
