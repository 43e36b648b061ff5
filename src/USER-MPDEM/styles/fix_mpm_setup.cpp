// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// What fix mpm does when points or grains change rank, and before the first step: blocks of
// points, grid, links and sides are laid out anew, all motion is carried over.
#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "../geometry/frame_along.h"
#include "../geometry/radial_axis.h"
#include "../mpm/scatter.h"
#include "arguments.h"
#include "atom.h"
#include "domain.h"
#include "fix_mpm.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::kLanes;
using mpdem::text_of;
using mpdem::vd;

// Before their first run points are where create_cement put them, and their grid with them.
void FixMpm::check_created_positions() {
  std::string trouble;
  for (int i = 0; i < atom->nlocal && trouble.empty(); ++i) {
    if (!avec_->is_point(i)) continue;
    const int b = avec_->slot[i] / kLanes, l = avec_->slot[i] % kLanes;
    const int index = avec_->points.meta[b].body;
    if (index < bodies_started_) continue;
    const mpdem::Body& body = avec_->bodies[index];
    if (body.in_motion != 0.0)
      trouble = text_of("fix mpm (id ", id, "): the cement of grains ", body.grain[0], " and ", body.grain[1], " has been in motion, which "
                        "the nodes of another fix mpm had: it was deleted by 'unfix', or was not defined with the ID it has in the restart "
                        "file before the first run; keep that fix, or after read_restart define it with that ID at once. For other "
                        "parameters create the cement in a new scene (write_cement, create_cement ... file)");
    if (!trouble.empty()) continue;
    double x[3], most = 0.0;
    for (int d = 0; d < 3; ++d) x[d] = body.origin[d] + avec_->points.blocks[b].X[d][l];
    domain->remap(x);
    for (int d = 0; d < 3; ++d) most = std::max(most, std::fabs(x[d] - atom->x[i][d]));
    if (most > 1e-9 * cell_)
      trouble = text_of("fix mpm (id ", id, "): a command changed the position of material point ", atom->tag[i], " by ", most,
                        "; move grains before their cement is made by create_cement");
  }
  mpdem::stop_if_any(lmp, trouble);
}

void FixMpm::setup_pre_exchange() {
  check_grains_stayed();
  check_created_positions();
  if (!built_) return;
  // The state is in the points; atoms only show it, and a command that moved them in
  // between would be without effect.
  std::vector<double> shown;
  for (int i = 0; i < atom->nlocal; ++i)
    if (avec_->is_point(i))
      for (int d = 0; d < 3; ++d) {
        shown.push_back(atom->x[i][d]);
        shown.push_back(atom->v[i][d]);
      }
  fill_atoms();
  std::string trouble;
  std::size_t at = 0;
  const double speed = law_->elasticity().fastest_wave(density_);
  for (int i = 0; i < atom->nlocal; ++i)
    if (avec_->is_point(i))
      for (int d = 0; d < 3; ++d) {
        const bool moved = std::fabs(shown[at] - atom->x[i][d]) > 1e-9 * cell_ ||
                           std::fabs(shown[at + 1] - atom->v[i][d]) > 1e-9 * speed;
        at += 2;
        if (moved && trouble.empty())
          trouble = text_of("fix mpm (id ", id, "): a command changed position or velocity of material point ", atom->tag[i],
                            " after the cement was set in motion; do so before the first run");
      }
  mpdem::stop_if_any(lmp, trouble);
}

void FixMpm::pre_exchange() {
  if (!built_) return;
  watch_for_grains_that_leave();
  fill_atoms();
}

void FixMpm::setup_pre_neighbor() {
  count_points();
  divide_bodies(static_cast<int>(has_sheets_.size()));
  remember_axis();
  // another time step, other added mass
  const bool changes = built_ && coupled_ && update->dt != dt_last_;
  const auto energy = [&] { return changes ? links_.inertial_energy_ahead(grid_, sides_, 0.0, bodies_started_) : 0.0; };
  const double before = energy();
  rebuild();
  released_ += before - energy();
  // New bodies may be cracked. Others, which after read_restart may have come apart since they were
  // looked at, wait for the step of the next look, so that a run in parts is the run as a whole.
  const std::size_t bodies = avec_->bodies.size();
  const bool some_are_new = separation_.size() < bodies;
  if (path_.size() < bodies) {
    path_cut_.resize(bodies);
    std::fill(path_cut_.begin() + static_cast<std::ptrdiff_t>(path_.size()), path_cut_.end(), 1);
    any_path_cut_ = true;
  }
  if (some_are_new && separate_bodies(true)) rebuild();
}

void FixMpm::pre_neighbor() {
  count_points();
  int changed = updated_;  // slots were brought up to date for the exchange
  std::size_t live = 0;
  for (int i = 0; i < atom->nlocal; ++i) live += avec_->is_point(i);
  std::size_t arranged = 0;
  for (const mpdem::BlockMeta& m : avec_->points.meta) arranged += static_cast<std::size_t>(__builtin_popcount(m.occupied));
  if (live != arranged) changed = 1;
  // Arrivals sit in tail blocks that no grid knows.
  for (int i = 0; i < atom->nlocal && !changed; ++i)
    if (avec_->is_point(i) && avec_->slot[i] / kLanes >= static_cast<int>(laid_out_blocks_)) changed = 1;
  for (const OwnedSide& o : owned_) {
    const int i = atom->map(avec_->bodies[o.body].grain[o.side]);
    if (i < 0 || i >= atom->nlocal) changed = 1;
  }
  int any;
  MPI_Allreduce(&changed, &any, 1, MPI_INT, MPI_MAX, world);
  if (any) rebuild();
  else find_owned_grains();
}

void FixMpm::find_owned_grains() {
  owned_.clear();
  grains_here_.clear();
  for (std::size_t b = 0; b < avec_->bodies.size(); ++b)
    for (int s = 0; s < 2; ++s) {
      const int i = atom->map(avec_->bodies[b].grain[s]);
      if (i < 0 || i >= atom->nlocal) continue;
      owned_.push_back({i, sides_.find(static_cast<int>(b), s), static_cast<int>(b), s, 0.0});
      avec_->track_orientation(i);
      grains_here_.push_back(i);
    }
  std::sort(grains_here_.begin(), grains_here_.end());
  grains_here_.erase(std::unique(grains_here_.begin(), grains_here_.end()), grains_here_.end());
  prescribed_.clear();
  for (int i : grains_here_) prescribed_.push_back(mpdem::prescribed_motion(lmp, i));
  const std::map<int, double> inertia = inertia_of_cement();
  for (OwnedSide& o : owned_) {
    const std::size_t n = std::lower_bound(grains_here_.begin(), grains_here_.end(), o.atom) - grains_here_.begin();
    o.mass_ratio = mass_ratio(o.atom, prescribed_[n], inertia.at(atom->tag[o.atom]));
  }
  find_bonded_grains();
}

void FixMpm::rebuild(const std::vector<char>& changed) {
  mpdem::PointStore& points = avec_->points;
  std::vector<int> live, tags, parts, place;
  for (int i = 0; i < atom->nlocal; ++i)
    if (avec_->is_point(i)) {
      const int slot = avec_->slot[i];
      live.push_back(slot);
      tags.push_back(atom->tag[i]);
      parts.push_back(part_of_slot(slot));
    }
  points.arrange(live, tags, cell_, place, parts, basis_);
  std::size_t at = 0;
  for (int i = 0; i < atom->nlocal; ++i)
    if (avec_->is_point(i)) avec_->slot[i] = place[at++];
  set_frames(points);
  blocks_when_arranged_ = points.blocks.size();
  lay_out_grid(changed);
}

// Grid, links and sides for the blocks as they are.
void FixMpm::lay_out_grid(const std::vector<char>& changed) {
  mpdem::PointStore& points = avec_->points;
  laid_out_blocks_ = points.blocks.size();
  std::vector<mpdem::Grid::Cell> cells;
  for (mpdem::BlockMeta& m : points.meta) cells.push_back({mpdem::field_of(m.body, m.part), m.base, m.column});
  if (coupled_) {
    links_.build(points, avec_->bodies, penalty_, cell_, inertia_, basis_);
    links_.add_cells(cells);
  }
  const std::vector<int> to_untie = bodies_to_untie();
  const std::vector<double> motion = to_untie.empty() ? std::vector<double>() : motion_of_bodies();
  std::vector<char> fresh;
  grid_.basis = basis_;
  build_grid(grid_, points, cells, restored_, fresh, updated_ ? mpdem::UpdatedPass::kMargin : 0, changed);
  if (!to_untie.empty()) keep_motion_of_bodies(to_untie, motion);
  new_part_.clear();
  parent_field_.clear();
  restored_ = mpdem::NodeKinematics();
  if (bodies_started_ < static_cast<int>(avec_->bodies.size())) {
    start_velocities(fresh);
    if (updated_) mpdem::UpdatedPass::start(points, grid_, bodies_started_);
  }
  if (relax_ > 0.0) {
    std::vector<char> apart(avec_->bodies.size(), 0);
    for (std::size_t b = 0; b < std::min(apart.size(), separation_.size()); ++b) apart[b] = separation_[b].separated;
    relaxation_.build(grid_, avec_->bodies, apart, relax_, shear_speed());
  }
  if (coupled_) {
    std::vector<mpdem::Key> owned;
    for (std::size_t b = 0; b < avec_->bodies.size(); ++b)
      for (int s = 0; s < 2; ++s) {
        const int i = atom->map(avec_->bodies[b].grain[s]);
        if (i >= 0 && i < atom->nlocal) owned.push_back({static_cast<int>(b), s, 0, 0});
      }
    sides_.build(world, avec_->bodies, grid_.keys, owned);
    links_.bind(sides_);
    links_.find_masters(grid_);
    if (relax_ > 0.0) relaxation_.bind(sides_);
  }
  resting_.bind(points, grid_);
  if (coupled_ && !updated_) resting_links_.bind(links_, resting_, sides_);
  if (updated_) updated_pass_.bind(points, grid_);
  find_owned_grains();
  distribute_grains();  // who looks before the next step is not to find grains at rest
  built_ = true;
  if (dt_last_ == 0.0) dt_last_ = update->dt;
  refresh_added_mass();
}

void FixMpm::refresh_added_mass() {
  if (!coupled_) return;
  std::fill(grid_.penalty.begin(), grid_.penalty.end(), 0.0);
  // What damping takes of the bound in every step, nodes with added mass cannot have.
  const double bound = stability_bound() * std::max(0.1, 1.0 - 0.5 * relaxation_rate(relax_) * update->dt);
  links_.add_stiffness(grid_, sides_, update->dt);
  const bool known = eigenvalue_ > 0.0;
  grid_.set_added_mass(update->dt, known ? eigenvalue_ : eigenvalue_bound(), !known, bound);
  links_.share_added_mass(grid_, sides_);
  int some = !links_.added_masses().empty(), any;
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, world);
  any_added_mass_ = any != 0;
  fresh_added_mass_ = true;
}

// The same in the course of a run, where links that let go give up their added mass.
void FixMpm::drop_added_mass() {
  if (coupled_ && !law_->inert()) take_up_added_mass(true);
}

// With the eigenvalue as it is known now. Bodies that were not in motion yet start with what they have then.
void FixMpm::take_up_added_mass(bool drop_inert) {
  if (!coupled_) return;
  const double later = drop_inert ? 0.5 * (dt_last_ + update->dt) : 0.0;
  const auto energy = [this, later] {
    return bodies_started_ > 0 ? links_.inertial_energy_ahead(grid_, sides_, later, bodies_started_) : 0.0;
  };
  const double before = energy();
  if (drop_inert) links_.drop_inertia(avec_->points);
  refresh_added_mass();
  released_ += before - energy();
}

std::string FixMpm::axis_name(int rule, const double* direction) const {
  if (rule == kGlobal) return text_of("global ", direction[0], " ", direction[1], " ", direction[2]);
  return rule == kBond ? "bond" : "radial";
}

// Frames stay those of the first run, whatever a fix that is defined again says.
void FixMpm::check_axis() const {
  for (const mpdem::Body& b : avec_->bodies) {
    double along = 0.0;
    for (int d = 0; d < 3; ++d) along += b.axis[1 + d] * axis_direction_[d];
    const int rule = static_cast<int>(b.axis[0]);
    if (rule == 0 || (rule == axis_ && (rule != kGlobal || std::fabs(along) > 1.0 - 1e-12))) continue;
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): 'axis ", axis_name(axis_, axis_direction_), "' but the axes of the cement of grains ",
                                 b.grain[0], " and ", b.grain[1], " were set in its first run, by 'axis ", axis_name(rule, b.axis + 1),
                                 "'; use that, or create the cement anew"));
  }
}

// Of bodies some of whose points have no frame yet. Collective.
void FixMpm::remember_axis() {
  std::vector<mpdem::Body>& bodies = avec_->bodies;
  if (std::all_of(bodies.begin(), bodies.end(), [](const mpdem::Body& b) { return b.axis[0] != 0.0; })) return;
  std::vector<int> open(bodies.size(), 0);
  for (const mpdem::BlockMeta& m : avec_->points.meta)
    if (m.framed != m.occupied) open[m.body] = 1;
  MPI_Allreduce(MPI_IN_PLACE, open.data(), static_cast<int>(open.size()), MPI_INT, MPI_MAX, world);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!open[b] || bodies[b].axis[0] != 0.0) continue;
    bodies[b].axis[0] = axis_;
    std::copy(axis_direction_, axis_direction_ + 3, bodies[b].axis + 1);
  }
}

// Frame of each new point: third axis along the axis of the elasticity.
void FixMpm::set_frames(mpdem::PointStore& points) const {
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    mpdem::BlockMeta& m = points.meta[b];
    if (m.framed == m.occupied) continue;
    const mpdem::Body& body = avec_->bodies[m.body];
    for (int l = 0; l < kLanes; ++l) {
      if (!(m.occupied >> l & 1) || (m.framed >> l & 1)) continue;
      mpdem::Vector3 a;
      if (axis_ == kGlobal) {
        a = mpdem::Vector3(axis_direction_[0], axis_direction_[1], axis_direction_[2]);
      } else if (axis_ == kBond) {
        for (int d = 0; d < 3; ++d) a[d] = body.centre[1][d] - body.centre[0][d];
      } else {
        mpdem::Vector3 X, centre[2];
        for (int d = 0; d < 3; ++d) {
          X[d] = points.blocks[b].X[d][l];
          for (int s = 0; s < 2; ++s) centre[s][d] = body.centre[s][d];
        }
        a = mpdem::radial_axis(X, centre, body.radius, body.spacing);
      }
      const Eigen::Quaterniond q = mpdem::frame_along(a.normalized());
      mpdem::Frame& f = points.blocks[b].q;
      f.w[l] = q.w();
      f.x[l] = q.x();
      f.y[l] = q.y();
      f.z[l] = q.z();
      if (m.damaged && law_->state_is_tensor()) {  // given in the axes of the box
        const mpdem::Sym3<vd> D = mpdem::rotate_back(mpdem::rotation_matrix(f), mpdem::state_of<mpdem::TensorDamage>(points, static_cast<int>(b)));
        const double numbers[6] = {D.xx[l], D.yy[l], D.zz[l], D.yz[l], D.xz[l], D.xy[l]};
        points.set_state(kLanes * static_cast<int>(b) + l, numbers);
      }
      m.framed |= static_cast<std::uint8_t>(1u << l);
    }
  }
}

// Nodal velocities from the velocities of the points: the linear field that fits each body
// best is taken over exactly, so a translation or rotation starts without strain, the rest
// by lumped projection.
void FixMpm::start_velocities(const std::vector<char>& fresh) {
  mpdem::PointStore& points = avec_->points;
  const int bodies = static_cast<int>(avec_->bodies.size());
  std::vector<double> velocity(3 * kLanes * points.blocks.size(), 0.0);
  for (int i = 0; i < atom->nlocal; ++i)
    if (avec_->is_point(i))
      for (int d = 0; d < 3; ++d) velocity[3 * avec_->slot[i] + d] = atom->v[i][d];

  // Normal equations of v = A (1, X/cell), 4 x 4 and 4 x 3 a body.
  constexpr int kNormal = 28;
  std::vector<double> sums(kNormal * bodies, 0.0);
  for (std::size_t b = 0; b < points.blocks.size(); ++b)
    for (int l = 0; l < kLanes; ++l) {
      const double V = points.blocks[b].volume[l];
      if (V == 0.0) continue;
      double* s = &sums[kNormal * points.meta[b].body];
      double y[4] = {1.0, 0, 0, 0};
      for (int d = 0; d < 3; ++d) y[1 + d] = points.blocks[b].X[d][l] / cell_;
      for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) s[4 * r + c] += V * y[r] * y[c];
        for (int d = 0; d < 3; ++d) s[16 + 3 * r + d] += V * y[r] * velocity[3 * (kLanes * b + l) + d];
      }
    }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, world);
  std::vector<Eigen::Matrix<double, 4, 3>> fit(bodies);
  for (int n = 0; n < bodies; ++n) {
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> A(&sums[kNormal * n]);
    const Eigen::Map<const Eigen::Matrix<double, 4, 3, Eigen::RowMajor>> y(&sums[kNormal * n + 16]);
    fit[n] = A.completeOrthogonalDecomposition().solve(y);
  }

  std::vector<double> momentum(3 * grid_.size(), 0.0);
  mpdem::with_basis(basis_, [&](auto type) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const mpdem::PointBlock& p = points.blocks[b];
      const auto& A = fit[points.meta[b].body];
      vd rest[3];
      for (int d = 0; d < 3; ++d) {
        vd v;
        for (int l = 0; l < kLanes; ++l) v[l] = velocity[3 * (kLanes * b + l) + d];
        rest[d] = inertia_ * p.volume *
                  (v - (A(0, d) + (A(1, d) * p.X[0] + A(2, d) * p.X[1] + A(3, d) * p.X[2]) / cell_));
      }
      mpdem::scatter_value(momentum.data(), points.meta[b].column,
                           mpdem::Weights<decltype(type)>(p.X, points.meta[b].base, 1.0 / cell_), rest);
    }
  });
  grid_.ties.bequeath(momentum.data(), 3);
  grid_.halo.sum(momentum.data(), 3);
  for (int i = 0; i < grid_.size(); ++i) {
    if (!fresh[i]) continue;
    const auto& A = fit[mpdem::body_of(grid_.keys[i][0])];
    for (int d = 0; d < 3; ++d) {
      double v = A(0, d);
      for (int e = 0; e < 3; ++e) v += A(1 + e, d) * grid_.keys[i][1 + e];
      if (grid_.mass[i] > 0.0) v += momentum[3 * i + d] / grid_.mass[i];
      grid_.velocity[3 * i + d] = v;
    }
  }
  // not those in motion, to which it would do nothing but round
  std::vector<double> extended(grid_.velocity);
  grid_.ties.extend(extended.data());
  for (std::size_t i = 0; i < extended.size(); ++i)
    if (fresh[i / 3]) grid_.velocity[i] = extended[i];
}

}  // namespace LAMMPS_NS
