// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "stiffness_of_bonds.h"

#include <algorithm>
#include <limits>
#include <map>
#include <unordered_map>

#include "../../mpm/field_drive.h"
#include "../../numerics/cross_matrix.h"
#include "../../parallel/agree.h"
#include "../../parallel/ranks.h"
#include "bond_description.h"
#include "template_layouts.h"

namespace mpdem {

namespace {

// Results are in bond coordinates until into_box().
void write(const StaticBond& found, StiffnessOfBond& to) {
  for (int d = 0; d < 3; ++d) {
    to.middle[d] = found.frame.middle[d];
    to.axis[d] = found.frame.axis[d];
  }
  std::copy(found.stiffness.data(), found.stiffness.data() + 36, to.K);
  to.products = found.products;
}

void turn(const Eigen::Matrix3d& axes, StiffnessOfBond& s) {
  Matrix6 both = Matrix6::Zero();
  both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = axes;
  Eigen::Map<Matrix6> K(s.K);
  Eigen::Map<Eigen::Vector3d> axis(s.axis);
  K = (both * K * both.transpose()).eval();
  axis = (axes * axis).eval();
}

class StiffnessFinder {
 public:
  StiffnessFinder(const std::vector<BondRecord>& table, std::vector<BondLayout>& layouts, const BondedGrains::EndsOfAll& grains,
                  const Law& law)
      : table_(table), layouts_(layouts), grains_(grains), law_(law), found_(table.size(), StiffnessOfBond{}) {
    for (const BondLayout& l : layouts_) reported_.push_back(l.row);
  }

  // Solves the bonds that are whole on this rank.
  void solve_whole() {
    std::unordered_multimap<std::size_t, int> solved;  // layouts by the hash of their description
    for (std::size_t n = 0; n < layouts_.size(); ++n) {
      if (is_cut(layouts_[n])) continue;
      const BondDescription mine = description(n);
      const std::size_t hash = mine.hash();
      const auto range = solved.equal_range(hash);
      const auto equal = std::find_if(range.first, range.second, [&](const auto& s) { return description(s.second) == mine; });
      StiffnessOfBond& to = found_[layouts_[n].row];
      if (equal == range.second) {
        solve_one(MPI_COMM_SELF, layouts_[n].row, static_cast<int>(n));
        solved.emplace(hash, static_cast<int>(n));
        continue;
      }
      to = found_[layouts_[equal->second].row];
      to.products = 0.0;
    }
  }

  // Collective. Solves the bonds that several ranks share.
  void solve_shared(MPI_Comm comm) {
    std::vector<char> cut(table_.size(), 0);
    std::vector<int> at(table_.size(), -1);
    for (std::size_t n = 0; n < layouts_.size(); ++n) {
      at[layouts_[n].row] = static_cast<int>(n);
      cut[layouts_[n].row] = is_cut(layouts_[n]);
    }
    MPI_Allreduce(MPI_IN_PLACE, cut.data(), static_cast<int>(cut.size()), MPI_SIGNED_CHAR, MPI_MAX, comm);
    for (std::size_t row = 0; row < cut.size(); ++row)
      if (cut[row]) solve_one(comm, static_cast<int>(row), at[row]);
  }

  // Solves bonds whose points are made later: one solution for all bonds of a template. The rank that owns the first
  // grain of a bond reports it.
  void solve_templates(std::vector<CondensedBonds::TemplateBond> laid_out) {
    std::map<int, StiffnessOfBond> solved;
    for (CondensedBonds::TemplateBond& o : laid_out) {
      const EndsAtCreation at(o.record);
      write(solve_static({o.bond.points, o.bond.grid, o.bond.links, at.ends, o.record, law_, o.bond.film}), solved[o.point_template]);
    }
    for (const BondedGrains::OwnedEnd& o : grains_.owned) {
      const int point_template = table_[o.row].point_template;
      if (point_template == 0 || o.side != 0) continue;
      StiffnessOfBond& of_template = solved.at(point_template);
      found_[o.row] = of_template;
      of_template.products = 0.0;
      reported_.push_back(o.row);
    }
  }

  // Condensed bonds are solved in the configuration at creation. Rotates their results to the present one.
  void turn_condensed() {
    for (int row : reported_) {
      if (!table_[row].condensed) continue;
      StiffnessOfBond& s = found_[row];
      Eigen::Map<Eigen::Vector3d> middle(s.middle);
      CondensedModel model;
      model.middle = middle;
      const CondensedMotion now(model, table_[row], &grains_.ends.ends[grains_.ends.find(row, 0)]);
      turn(now.axes(), s);
      middle = now.middle();
    }
  }

  void into_box() {
    for (int row : reported_) {
      const BondRecord& record = table_[row];
      StiffnessOfBond& s = found_[row];
      const std::array<double, 3> middle = position_in_box(record, axes_of(record), s.middle);
      std::copy(middle.begin(), middle.end(), s.middle);
      turn(matrix_of(axes_of(record)), s);
    }
  }

  // Collective. The first rank that reports a bond sends its result to the others.
  std::vector<StiffnessOfBond> of_all(MPI_Comm comm) {
    const int me = rank_in(comm);
    std::vector<int> owner(table_.size(), std::numeric_limits<int>::max());
    for (int row : reported_) owner[row] = me;
    MPI_Allreduce(MPI_IN_PLACE, owner.data(), static_cast<int>(owner.size()), MPI_INT, MPI_MIN, comm);
    for (std::size_t row = 0; row < owner.size(); ++row)
      if (owner[row] != me) found_[row] = StiffnessOfBond{};
    static_assert(sizeof(StiffnessOfBond) % sizeof(double) == 0, "numbers alone");
    constexpr int kNumbers = sizeof(StiffnessOfBond) / sizeof(double);
    MPI_Allreduce(MPI_IN_PLACE, found_.data(), kNumbers * static_cast<int>(found_.size()), MPI_DOUBLE, MPI_SUM, comm);
    return std::move(found_);
  }

 private:
  // A bond with a film may be shared without shared nodes, since a film has none.
  bool is_cut(const BondLayout& l) const {
    return l.grid.halo.shares_any() || (!l.film.empty() && l.points.size() + l.film.points.size() != table_[l.row].points);
  }
  const BondEnd* ends_of(int bond_row) const {
    if (table_[bond_row].condensed) return creation_.emplace(bond_row, EndsAtCreation(table_[bond_row])).first->second.ends;
    return &grains_.ends.ends[grains_.ends.find(bond_row, 0)];
  }
  BondDescription description(int layout) const {
    const BondLayout& l = layouts_[layout];
    return BondDescription(l.points, l.film.points, l.grid, table_[l.row], ends_of(l.row));
  }
  // layout: index of the layout of the bond; -1: this rank has no share of the bond.
  void solve_one(MPI_Comm comm, int row, int layout) {
    if (layout < 0) {
      solve_static(comm, nullptr);
      return;
    }
    BondLayout& l = layouts_[layout];
    const StaticSystem system{l.points, l.grid, l.links, ends_of(row), table_[row], law_, l.film};
    write(solve_static(comm, &system), found_[row]);
  }

  const std::vector<BondRecord>& table_;
  std::vector<BondLayout>& layouts_;
  const BondedGrains::EndsOfAll& grains_;
  const Law& law_;
  std::vector<StiffnessOfBond> found_;
  std::vector<int> reported_;                       // rows that this rank reports
  mutable std::map<int, EndsAtCreation> creation_;  // of condensed bonds
};

}  // namespace

std::vector<StiffnessOfBond> stiffness_of_bonds(const Scene& scene, std::vector<BondLayout> layouts) {
  const BondedGrains::EndsOfAll grains = scene.grains.ends_of_all(scene.comm, scene.bonds());
  const int orphan = grains.ends.orphan();
  throw_if_any(scene.comm, orphan < 0 ? ""
                                      : text_of("grain ", grains.ends.ends[orphan].tag,
                                                " has cement but was deleted or lost; use 'run 0' before, which takes the cement of "
                                                "separated bonds out of the scene, or keep bonded grains"));
  // Cement whose grain left has no stiffness.
  const auto is_alone = [&](const BondLayout& l) {
    return !scene.bonds().table[l.row].has_grain(0) || !scene.bonds().table[l.row].has_grain(1);
  };
  layouts.erase(std::remove_if(layouts.begin(), layouts.end(), is_alone), layouts.end());
  StiffnessFinder finder(scene.bonds().table, layouts, grains, *scene.law);
  std::string trouble;
  std::vector<CondensedBonds::TemplateBond> template_bonds = layouts_of_templates(scene, templates_of_owned_grains(scene), &*scene.penalty);
  try {
    finder.solve_whole();
    finder.solve_templates(std::move(template_bonds));
  } catch (const BadState& e) {
    trouble = e.what();
  }
  throw_if_any(scene.comm, trouble);
  finder.solve_shared(scene.comm);
  finder.turn_condensed();
  finder.into_box();
  return finder.of_all(scene.comm);
}

namespace {

StiffnessOfBond stiffness_of_film(Film film, const BondRecord& record, const Scene& scene) {
  lay_out_film(film, record, scene.options, scene.law);
  revert_field(film.points);
  for (BlockMeta& m : film.points.meta) {
    m.failed = 0;
    m.damaged = false;
  }
  const EndsAtCreation at(record);
  StaticBond found;
  found.frame = frame_of(record, at.ends);
  found.stiffness = film.stiffness(film.strains(at.ends, found.frame.middle), *scene.law);
  StiffnessOfBond s{};
  write(found, s);
  turn(matrix_of(axes_of(record)), s);
  return s;
}

}  // namespace

std::vector<StiffnessOfBond> stiffness_of_films(const Scene& scene) {
  const Bonds& bonds = scene.bonds();
  std::map<int, StiffnessOfBond> mine;  // by row
  const auto add = [&](int row, const Film& film) {
    if (!film.empty()) mine[row] = stiffness_of_film(film, bonds.table[row], scene);
  };
  for (const Bond& b : bonds) add(b.row, b.film);
  std::map<int, int> first_of_template;
  for (int row : bonds.rows_without_points()) {
    if (!scene.grains.find(bonds.table[row].grain[0])) continue;
    const auto [first, fresh] = first_of_template.try_emplace(bonds.table[row].point_template, row);
    if (const auto known = mine.find(first->second); known != mine.end()) mine[row] = known->second;
    if (!fresh) continue;
    Film film;
    const PointTemplate& p = bonds.template_of(row);
    for (std::size_t n = 0; n < p.points.size(); ++n)
      if (p.points[n].film) film.points.add(p.record(n, row, bonds.table[row]), static_cast<int>(n) + 1);
    add(row, film);
  }
  int some = !mine.empty(), any;
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, scene.comm);
  if (!any) return {};
  std::vector<StiffnessOfBond> found(bonds.table.size(), StiffnessOfBond{});
  for (const auto& s : mine) found[s.first] = s.second;
  constexpr int kNumbers = sizeof(StiffnessOfBond) / sizeof(double);
  std::vector<double> axes;  // ranks that share a bond add up its stiffness, but have the same axis
  for (StiffnessOfBond& s : found) {
    axes.insert(axes.end(), s.axis, s.axis + 3);
    std::fill(s.axis, s.axis + 3, 0.0);
  }
  std::vector<double> most(axes), least(axes);
  MPI_Allreduce(MPI_IN_PLACE, most.data(), static_cast<int>(axes.size()), MPI_DOUBLE, MPI_MAX, scene.comm);
  MPI_Allreduce(MPI_IN_PLACE, least.data(), static_cast<int>(axes.size()), MPI_DOUBLE, MPI_MIN, scene.comm);
  MPI_Allreduce(MPI_IN_PLACE, found.data(), kNumbers * static_cast<int>(found.size()), MPI_DOUBLE, MPI_SUM, scene.comm);
  for (std::size_t k = 0; k < axes.size(); ++k) found[k / 3].axis[k % 3] = most[k] > -least[k] ? most[k] : least[k];
  return found;
}

}  // namespace mpdem
