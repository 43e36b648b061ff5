// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// When bonds are laid out (layout.h), what is carried over, and what follows from a layout: added mass, the stable step.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "../mpm/scatter.h"
#include "../parallel/agree.h"
#include "bond_motion.h"
#include "cement.h"
#include "kinematics.h"

namespace mpdem {

LayoutRules Cement::rules() {
  return {comm_, bonds_.table, options_, law_, sheets_, cracks_, inertia_, penalty_ ? &*penalty_ : nullptr, options_.split ? &splits_ : nullptr};
}

std::vector<int> Cement::all_rows() const {
  std::vector<int> rows(bonds_.table.size());
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

// Those that some rank names.
std::vector<int> Cement::agreed_rows(const std::vector<int>& mine) const {
  return union_of_ranks(comm_, mine);
}

LayoutRequest Cement::request_of(Bond& b, NewPartsOfBonds& parts) {
  LayoutRequest r;
  r.body = b.body;
  r.points = std::move(b.points);
  r.before = b.grid.kinematics();
  if (!arrivals_.restored_nodes.empty()) r.before = std::move(arrivals_.restored_nodes[b.body]);
  const auto changed = parts.find(b.body);
  if (changed != parts.end()) r.parts = std::move(changed->second);
  return r;
}

// What has nodes of its own before a layout.
NewPartsOfBonds Cement::parts_at_start(Splits& splits, Sheets& sheets) const {
  if (!options_.split) return sheets.divide(comm_, bonds_, options_, arrivals_.fresh_points);
  NewPartsOfBonds parts = splits.start(comm_, bonds_, options_);
  splits.bring(comm_, bonds_);
  return parts;
}

std::vector<BondLayout> Cement::layouts_of_copies(const PenaltyParameters* penalty) {
  bring_restored_nodes();
  Sheets sheets(sheets_);
  Splits splits(splits_);
  NewPartsOfBonds parts = parts_at_start(splits, sheets);
  std::vector<LayoutRequest> requests;
  for (const Bond& b : bonds_) {
    requests.emplace_back();
    LayoutRequest& r = requests.back();
    r.body = b.body;
    r.points = b.points;
    r.points.sort_links();
    r.parts.part_of_slot = parts[b.body].part_of_slot;
    if (penalty) r.before = arrivals_.restored_nodes.empty() ? b.grid.kinematics() : arrivals_.restored_nodes[b.body];
  }
  CementOptions options(options_);
  options.updated = false;  // no margin
  const LayoutRules rules{comm_, bonds_.table, options, law_, sheets, cracks_, inertia_, penalty, options_.split ? &splits : nullptr};
  return make_layout(rules, all_rows(), std::move(requests));
}

// As mass goes back from the heirs of tied nodes to these where a bond came apart, or its nodes split, its momentum and angular momentum are
// kept by a rigid motion.
void Cement::lay_out(const std::vector<int>& rows, NewPartsOfBonds parts, bool arrange, bool splits) {
  bring_restored_nodes();
  const std::vector<int> untied = splits ? rows : options_.split ? std::vector<int>() : cracks_.untie(options_);
  const bool moves = layout_.built && !untied.empty();
  const std::vector<double> motion = moves ? motion_of(untied) : std::vector<double>();
  std::vector<LayoutRequest> requests;
  bool shared = !layout_.built;  // are nodes of other ranks among those that change
  for (int row : rows) {
    Bond* b = bonds_.find(row);
    if (!b) continue;
    shared = shared || b->cut_by_ranks();
    requests.push_back(request_of(*b, parts));
  }
  LayoutRules how = rules();
  how.arrange = arrange;
  std::vector<BondLayout> layouts = make_layout(how, rows, std::move(requests));
  arrivals_.restored_nodes.clear();
  adopt(layouts);
  if (moves) keep_motion(untied, motion);
  start_velocities(layouts);
  shared = bonds_.drop_empty(rows) || shared;
  for (int row : rows) {
    Bond* b = bonds_.find(row);
    if (!b) continue;
    shared = shared || b->cut_by_ranks();
    kinematics_->bind(*b);
  }
  int mine = shared, any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, comm_);
  if (any) bind_shared_nodes();
}

// Collective. Nodes of bonds that are awake.
void Cement::bind_shared_nodes() {
  std::vector<HaloSum*> halos;
  for (Bond& b : bonds_.awake())
    if (b.cut_by_ranks()) halos.push_back(&b.grid.halo);
  layout_.shared_nodes.build(halos);
  if (options_.skip.nonlocal) {
    const int cut = !halos.empty();
    int any;
    MPI_Allreduce(&cut, &any, 1, MPI_INT, MPI_MAX, comm_);
    layout_.any_bond_is_cut = any != 0;
  }
}

// Where bonds and grains are on the ranks where they were.
void Cement::lay_out_again(const std::vector<int>& rows, NewPartsOfBonds parts, bool arrange, bool splits) {
  lay_out(rows, std::move(parts), arrange, splits);
  refresh_added_mass(rows);
}

// After lay_out() of bonds or grains that came from other ranks, or are new.
void Cement::bind_grains() {
  grains_.bind(comm_, bonds_, inertia_);
  grains_.distribute(bonds_);  // who looks before the next step is not to find grains at rest
  layout_.built = true;
  if (dt_last_ == 0.0) dt_last_ = now_.dt;
  condensed_.bind(comm_, bonds_, grains_);
  condensed_.follow(grains_, weight_of_cement().data());
}

void Cement::lay_out_run() {
  NewPartsOfBonds parts = parts_at_start(splits_, sheets_);
  remember_axis();
  choose_condensed();
  // another time step, other added mass
  const bool changes = layout_.built && now_.dt != dt_last_;
  const auto energy = [&] { return changes ? added_energy_ahead(all_rows(), 0.0) : 0.0; };
  books_.release_by(energy, [&] {
    lay_out(all_rows(), std::move(parts));
    bind_grains();
    open_places_of_files();
    refresh_added_mass();
  });
  load_watch_.take_up(bonds_.table.size());
  // New bodies may be cracked.
  arrivals_.fresh_points.clear();
  if (cracks_.take_up(bonds_.table.size()) && can_break()) {
    if (options_.split) {
      Splits::Found split = splits_.look(comm_, bonds_, options_);
      if (!split.lay_out.empty()) lay_out_again(split.lay_out, std::move(split.parts), true, true);
    }
    Cracks::Found found = look_at_bonds(true);
    if (!found.lay_out.empty()) lay_out_again(found.lay_out, std::move(found.parts), true, options_.split);
    for (int row : found.held)
      if (Bond* b = bonds_.find(row)) find_relaxation(*b);
  }
  condense(all_rows(), true);
}

void Cement::lay_out_exchanged() {
  std::vector<int> mine;
  for (const Bond& b : bonds_)
    if (b.points.changed()) mine.push_back(b.body);
  int moved = !mine.empty() || grains_.changed(), any;
  MPI_Allreduce(&moved, &any, 1, MPI_INT, MPI_MAX, comm_);
  // Slots of `updated` points were brought up to date for the exchange.
  const std::vector<int> rows = options_.updated ? all_rows() : agreed_rows(mine);
  if (!any && rows.empty()) return;
  if (options_.split) splits_.bring(comm_, bonds_);
  lay_out(rows, parts_of_fresh_points());
  bind_grains();
  refresh_added_mass(rows);
  condense(rows, false);
}

// Of bonds whose points were made between two steps.
NewPartsOfBonds Cement::parts_of_fresh_points() {
  NewPartsOfBonds parts;
  if (!arrivals_.fresh_points.empty()) parts = sheets_.divide(comm_, bonds_, options_, arrivals_.fresh_points);
  arrivals_.fresh_points.clear();
  return parts;
}

// Where parts came apart. Links have other nodes then, and their added mass another energy.
void Cement::lay_out_parts(Cracks::Found found) {
  if (found.lay_out.empty()) return;
  const auto energy = [&] {
    double sum = 0.0;
    for (int row : found.lay_out)
      if (const Bond* b = bonds_.find(row)) sum += b->added.energy(b->grid, grains_.side_of(*b));
    return sum;
  };
  books_.release_by(energy, [&] {
    lay_out_again(found.lay_out, std::move(found.parts));
    check_step_after(found.lay_out, "parts came apart");
  });
}

// Of bonds that are in motion.
double Cement::added_energy_ahead(const std::vector<int>& rows, double later) {
  double energy = 0.0;
  for (int row : rows) {
    const Bond* b = row < bodies_started_ ? bonds_.find(row) : nullptr;
    if (b) energy += b->added.energy_ahead(b->grid, grains_.side_of(*b), later);
  }
  return energy;
}

// Links that let go give up their added mass in the course of a run.
void Cement::drop_inert_added_mass() {
  books_.release_by([&] { return added_energy_ahead(all_rows(), 0.5 * (dt_last_ + now_.dt)); },
                    [&] {
                      for (Bond& b : bonds_.awake()) drop_inert_links(b);
                      refresh_added_mass();
                    });
}

// A new layout leaves them out, and sums over links go by their blocks, so they go here too: a run in parts is the run as a whole.
void Cement::drop_inert_links(Bond& b) {
  if (!b.links.drop_inertia(b.points) || options_.updated) return;
  b.links = PenaltyLinks(b.points, bonds_.body(b), *penalty_, options_.cell, inertia_, options_.basis);
  b.links.find_columns(b.grid);
}

void Cement::refresh_added_mass() {
  if (layout_.built) refresh_added_mass(all_rows());
}

void Cement::refresh_added_mass(const std::vector<int>& rows) {
  if (!penalty_) return;
  const bool known = layout_.eigenvalue > 0.0;
  // What damping takes of the bound in every step, nodes with added mass cannot have.
  const double bound = options_.stability_bound() * std::max(0.1, 1.0 - 0.5 * relaxation_rate(options_.relax) * now_.dt);
  const AddedMass::Stability s{now_.dt, known ? layout_.eigenvalue : eigenvalue_bound(), !known, bound};
  for (int row : rows)
    if (Bond* b = bonds_.table[row].condensed ? nullptr : bonds_.find(row)) b->added.find(b->links, b->grid, grains_.side_of(*b), s, b->places);
  for (int row : rows)
    if (Bond* b = options_.updated ? nullptr : bonds_.find(row)) b->share(layout_.alike);
  int some = 0, any;
  for (const Bond& b : bonds_) some = some || !b.added.empty();
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, comm_);
  layout_.any_added_mass = any != 0;
  grains_.added_mass_changed();
}

// Of bodies some of whose points have no frame yet.
void Cement::remember_axis() {
  std::vector<Body>& table = bonds_.table;
  if (std::all_of(table.begin(), table.end(), [](const Body& b) { return b.axis_rule != AxisRule::none; })) return;
  std::vector<int> open(table.size(), 0);
  for (const Bond& b : bonds_)
    for (const BlockMeta& m : b.points.meta)
      if (m.framed != m.occupied) open[b.body] = 1;
  for (std::size_t b = 0; b < table.size(); ++b)
    if (table[b].pattern > 0) open[b] = 1;
  MPI_Allreduce(MPI_IN_PLACE, open.data(), static_cast<int>(open.size()), MPI_INT, MPI_MAX, comm_);
  for (std::size_t b = 0; b < table.size(); ++b) {
    if (!open[b] || table[b].axis_rule != AxisRule::none) continue;
    table[b].axis_rule = options_.axis;
    std::copy(options_.axis_direction, options_.axis_direction + 3, table[b].axis);
  }
}

// Links by the slots of their points, which change while points change cells.
void Cement::sort_links(Bond& b) {
  const auto by_slot = [](const Link& x, const Link& y) { return x.slot < y.slot; };
  if (!std::is_sorted(b.points.links.begin(), b.points.links.end(), by_slot)) b.links.renumber(b.points.sort_links());
}

void Cement::sync_slots() {
  if (!options_.updated || !layout_.built) return;
  for (Bond& b : bonds_) {
    sort_links(b);
    host_.slots_changed(b);
  }
}

// Each side of a bond that came apart is slowed against the grain that it holds to.
void Cement::find_relaxation(Bond& b) {
  b.relaxation = Relaxation();
  b.impulse = SharedImpulse();
  if (!penalty_ || (options_.relax == 0.0 && options_.subcycle == 1)) return;
  const std::vector<char> held = cracks_.separated(b.body) ? nodes_held(b.points, b.grid) : std::vector<char>();
  if (options_.relax > 0.0) b.relaxation = Relaxation(b.grid, bonds_.body(b), held, options_.relax, shear_speed());
  if (options_.subcycle != 1) b.impulse = SharedImpulse(b.grid, bonds_.body(b), held);
}

// What hangs on the nodes of a bond.
void Cement::start_anew(Bond& b) {
  b.mass.forget();
  b.places = touches() ? FreedPlaces(b.points, bonds_.body(b), *penalty_, b.grid) : FreedPlaces();
  b.faces = faces_touch() ? CrackFaces(b.points, b.grid, splits_, penalty_->friction) : CrackFaces();
  b.closing = options_.unilateral ? ClosingPoints(b.points, law_->elasticity()) : ClosingPoints();
  b.mass.forget();
  b.added = AddedMass();
  b.resting = Resting();
  find_relaxation(b);
  b.jump.clear();
}

void Cement::adopt(std::vector<BondLayout>& layouts) {
  for (BondLayout& l : layouts) {
    Bond& b = *bonds_.find(l.body);
    b.points = std::move(l.points);
    b.grid = std::move(l.grid);
    b.links = std::move(l.links);
    start_anew(b);
    b.near_threshold = options_.skip.nonlocal && is_near_threshold(b.points, *law_);
    b.failed.clear();
    b.laid_out_blocks = b.points.blocks.size();
    if (l.new_slot.empty()) continue;
    b.blocks_when_arranged = b.points.blocks.size();
    host_.slots_changed(b);
  }
}

// Nodal velocities of bonds that are new from the velocities of their points: the linear field that fits each bond
// best is taken over exactly, so a translation or rotation starts without strain, the rest
// by lumped projection.
void Cement::start_velocities(std::vector<BondLayout>& layouts) {
  const int first = bodies_started_, rows = static_cast<int>(bonds_.table.size()) - first;
  if (rows == 0) return;
  // Normal equations of v = A (1, X/cell), 4 x 4 and 4 x 3 a body.
  constexpr int kNormal = 28;
  std::vector<double> sums(static_cast<std::size_t>(kNormal) * rows, 0.0);
  struct New {
    Bond* bond;
    const std::vector<char>* fresh;
    std::vector<double> velocity;  // of the slots
  };
  std::vector<New> fresh;
  for (BondLayout& l : layouts) {
    if (l.body < first) continue;
    fresh.push_back({bonds_.find(l.body), &l.fresh, {}});
    const PointStore& points = fresh.back().bond->points;
    std::vector<double>& velocity = fresh.back().velocity;
    velocity.assign(3 * kLanes * points.blocks.size(), 0.0);
    double* s = &sums[static_cast<std::size_t>(kNormal) * (l.body - first)];
    const Mat3<double> axes = axes_of(bonds_.table[l.body]);
    for (std::size_t b = 0; b < points.blocks.size(); ++b)
      for (int lane = 0; lane < kLanes; ++lane) {
        if (!(points.meta[b].occupied >> lane & 1)) continue;
        const std::array<double, 3> v = turned_back(axes, host_.initial_velocity(points.tags[b][lane]).data());
        std::copy(v.begin(), v.end(), &velocity[3 * (kLanes * b + lane)]);
        const double V = points.blocks[b].volume[lane];
        double y[4] = {1.0, 0, 0, 0};
        for (int d = 0; d < 3; ++d) y[1 + d] = points.blocks[b].X[d][lane] / options_.cell;
        for (int r = 0; r < 4; ++r) {
          for (int c = 0; c < 4; ++c) s[4 * r + c] += V * y[r] * y[c];
          for (int d = 0; d < 3; ++d) s[16 + 3 * r + d] += V * y[r] * v[d];
        }
      }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, comm_);
  for (New& n : fresh) {
    const double* s = &sums[static_cast<std::size_t>(kNormal) * (n.bond->body - first)];
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> M(s);
    const Eigen::Map<const Eigen::Matrix<double, 4, 3, Eigen::RowMajor>> y(s + 16);
    const Eigen::Matrix<double, 4, 3> A = M.completeOrthogonalDecomposition().solve(y);
    const PointStore& points = n.bond->points;
    Grid& grid = n.bond->grid;
    std::vector<double> momentum(3 * grid.size(), 0.0);
    with_basis(options_.basis, [&](auto type) {
      for (std::size_t b = 0; b < points.blocks.size(); ++b) {
        const PointBlock& p = points.blocks[b];
        vd rest[3];
        for (int d = 0; d < 3; ++d) {
          vd v;
          for (int l = 0; l < kLanes; ++l) v[l] = n.velocity[3 * (kLanes * b + l) + d];
          rest[d] = inertia_ * p.volume * (v - (A(0, d) + (A(1, d) * p.X[0] + A(2, d) * p.X[1] + A(3, d) * p.X[2]) / options_.cell));
        }
        with_weights<decltype(type)>(p, points.meta[b], 1.0 / options_.cell,
                                     [&](const auto& w) { scatter_value(momentum.data(), points.meta[b].column, w, rest); });
      }
    });
    grid.ties.give_to_heirs(momentum.data(), 3);
    grid.halo.sum(momentum.data(), 3);
    const std::vector<char>& is_fresh = *n.fresh;
    for (int i = 0; i < grid.size(); ++i) {
      if (!is_fresh[i]) continue;
      for (int d = 0; d < 3; ++d) {
        double v = A(0, d);
        for (int e = 0; e < 3; ++e) v += A(1 + e, d) * grid.keys[i].at(e);
        if (grid.mass[i] > 0.0) v += momentum[3 * i + d] / grid.mass[i];
        grid.velocity[3 * i + d] = v;
      }
    }
    // not those in motion, to which it would do nothing but round
    std::vector<double> extended(grid.velocity);
    grid.ties.extend(extended.data());
    for (std::size_t i = 0; i < extended.size(); ++i)
      if (is_fresh[i / 3]) grid.velocity[i] = extended[i];
    kinematics_->start_points(*n.bond);
  }
}

// Of each of these bonds, over all ranks, with the kick of the next drift ahead.
std::vector<double> Cement::motion_of(const std::vector<int>& rows) const {
  static_assert(sizeof(BondMotion) % sizeof(double) == 0, "sums of numbers");
  constexpr int kWidth = sizeof(BondMotion) / sizeof(double);
  std::vector<double> sums(kWidth * rows.size(), 0.0);
  const double kick = 0.5 * (dt_last_ + now_.dt);
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (const Bond* b = bonds_.find(rows[n])) reinterpret_cast<BondMotion*>(sums.data())[n] = mpdem::motion_of(b->grid, kick);
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, comm_);
  return sums;
}

void Cement::keep_motion(const std::vector<int>& rows, const std::vector<double>& before) {
  std::vector<double> after = motion_of(rows);
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (Bond* b = bonds_.find(rows[n]))
      give_back_motion(b->grid, reinterpret_cast<const BondMotion*>(before.data())[n], reinterpret_cast<const BondMotion*>(after.data())[n]);
  after = motion_of(rows);
  int me;
  MPI_Comm_rank(comm_, &me);
  for (std::size_t n = 0; n < rows.size() && me == 0; ++n)
    books_.release(reinterpret_cast<const BondMotion*>(before.data())[n].kinetic - reinterpret_cast<const BondMotion*>(after.data())[n].kinetic);
}

}  // namespace mpdem
