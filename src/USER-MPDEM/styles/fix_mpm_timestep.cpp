// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Time step of fix mpm: what is stable, `timestep auto`, and what is said about it.
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>

#include "../mpm/largest_eigenvalue.h"
#include "arguments.h"
#include "atom.h"
#include "comm.h"
#include "fix_mpm.h"
#include "force.h"
#include "modify.h"
#include "pair.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::text_of;

// Bound of the largest eigenvalue of cement without ties; 0: none.
double FixMpm::eigenvalue_bound() const {
  return mpdem::eigenvalue_bound(basis_, law_->elasticity().largest_stiffness(), inertia_, cell_);
}


// Largest dt^2 lambda. A mode that re-projection removes altogether takes half of what the
// central difference takes.
double FixMpm::stability_bound() const { return reproject_every_ > 0 || updated_ ? 2.0 : 4.0; }

// Of all bonds of a grain, by its tag.
std::map<int, double> FixMpm::inertia_of_cement() const {
  std::map<int, double> inertia;
  for (const mpdem::Body& b : avec_->bodies)
    for (int tag : b.grain) inertia[tag] += inertia_ * b.volume;
  return inertia;
}

// That over what the grain has of inertia against it where its motion is not prescribed: a mass m at places up to the
// radius r that moves with the grain has no more kinetic energy than a sphere of 7/2 m, since with t = 5/2
//   m (V + Omega r)^2 <= (1 + t) m V^2 + (1 + 1/t) m r^2 Omega^2   and its moment of inertia is 2/5 m r^2.
double FixMpm::mass_ratio(int i, const mpdem::PrescribedMotion& p, double inertia) const {
  return ((p.any_translation_free() ? 1.0 : 0.0) + (p.rotation ? 0.0 : 2.5)) * inertia / atom->rmass[i];
}

double FixMpm::shear_speed() const { return std::sqrt(law_->elasticity().softest_shear() / inertia_); }

// The largest of grains that follow forces. Collective.
double FixMpm::largest_mass_ratio() const {
  const std::map<int, double> inertia = inertia_of_cement();
  double mine = 0.0, most;
  for (int i = 0; i < atom->nlocal; ++i) {
    const auto it = avec_->is_point(i) ? inertia.end() : inertia.find(atom->tag[i]);
    if (it != inertia.end()) mine = std::max(mine, mass_ratio(i, mpdem::prescribed_motion(lmp, i), it->second));
  }
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, world);
  return most;
}

// Of `quasistatic` with the damping `share` of critical, the largest of any node against its grains, which when free are
// slowed too. Collective.
double FixMpm::relaxation_rate(double share) const {
  if (share == 0.0) return 0.0;
  double rate = 0.0;
  for (const mpdem::Body& b : avec_->bodies) rate = std::max(rate, mpdem::Relaxation::rate(b, share, shear_speed()));
  return rate * (1.0 + largest_mass_ratio());
}

double FixMpm::step_for(double eigenvalue, double relax) const {
  // Damping acts on the velocity of half a step ago: w^2 dt^2 + 2 p dt <= B.
  const double B = stability_bound(), p = penalty_.damping * std::sqrt(B * eigenvalue) + 0.25 * B * relaxation_rate(relax);
  const double step = B / (p + std::sqrt(p * p + B * eigenvalue));
  if (!(step > 0.0))  // as if nothing limited the step, were it compared with
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): no time step is stable, the square of the highest frequency is ", eigenvalue,
                                 " with density ", density_, " of the cement and stiffness ", law_->elasticity().largest_stiffness(),
                                 "; use densities, moduli and penalties that go together in these units"));
  return step;
}

// What the damping of `quasistatic` takes of the step, and the damping that takes a tenth at most: with that step, p of
// step_for() is (B - w^2 dt^2)/(2 dt), and grows by a rate that is proportional to the damping. Collective.
FixMpm::DampedStep FixMpm::damped_step(double eigenvalue) const {
  constexpr double kKept = 0.9;
  DampedStep d{step_for(eigenvalue, relax_), step_for(eigenvalue, 0.0), relax_};
  if (d.step >= kKept * d.undamped) return d;
  const double B = stability_bound(), dt = kKept * d.undamped;
  const double p = (B - eigenvalue * dt * dt) / (2.0 * dt) - penalty_.damping * std::sqrt(B * eigenvalue);
  d.admitted = 4.0 * p / (B * relaxation_rate(1.0));
  return d;
}

double FixMpm::stable_step() {
  const mpdem::EigenvalueEstimate e = mpdem::largest_eigenvalue(world, avec_->points, grid_, *law_);
  return step_for(e.value + e.residual, relax_);
}

// The bound will do for steps below it; the eigenvalue itself costs some passes.
// What was found before is kept unless it is well below: the added mass, which has a margin for that, hangs
// on it, and has to be the same in runs that are divided or restarted otherwise.
double FixMpm::limiting_eigenvalue(double dt) {
  double mine = grid_.largest_tie_factor(), ties;
  MPI_Allreduce(&mine, &ties, 1, MPI_DOUBLE, MPI_MAX, world);
  const double bound = ties * eigenvalue_bound();
  if (bound > 0.0 && dt <= step_for(bound, relax_)) return bound;
  const mpdem::EigenvalueEstimate e = mpdem::largest_eigenvalue(world, avec_->points, grid_, *law_);
  if (e.value > 1.02 * eigenvalue_) eigenvalue_ = e.value + e.residual;
  return e.value + e.residual;
}

// Other nodes and weights, other eigenvalue. One that was never asked for is no matter: then the step is
// below the bound, which holds for points anywhere. The layout has the added mass for what was known before.
void FixMpm::check_step_after(const char* event) {
  if (eigenvalue_ == 0.0 || updated_) return;
  const double known = eigenvalue_, limit = step_for(limiting_eigenvalue(update->dt), relax_);
  if (update->dt > limit)
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): time step ", update->dt, " exceeds the stable step ", limit, " after ", event,
                                 " at step ", update->ntimestep, "; use 'timestep ", 0.9 * limit, "' or less"));
  if (eigenvalue_ != known) refresh_added_mass();
}

// `timestep auto`: before other fixes take up the step, so from a layout of its own. In the init of fix `running`.
void FixMpm::set_time_step(const Fix* running) {
  if (step_fraction_ == 0.0) return;
  mpdem::PointStore points = avec_->points;
  const int divided = static_cast<int>(has_sheets_.size());
  divide_bodies(divided);
  std::vector<int> live, tags, parts, slots;
  for (std::size_t b = 0; b < points.meta.size(); ++b)
    for (int l = 0; l < mpdem::kLanes; ++l)
      if (points.meta[b].occupied >> l & 1) {
        live.push_back(mpdem::kLanes * static_cast<int>(b) + l);
        tags.push_back(points.tags[b][l]);
        parts.push_back(part_of_slot(live.back()));
      }
  points.sort_links();
  points.arrange(live, tags, cell_, slots, parts, basis_);
  set_frames(points);
  std::vector<mpdem::Grid::Cell> cells;
  for (mpdem::BlockMeta& m : points.meta) cells.push_back({mpdem::field_of(m.body, m.part), m.base, m.column});
  mpdem::Grid grid;
  grid.basis = basis_;
  std::vector<char> fresh;
  build_grid(grid, points, cells, mpdem::NodeKinematics(), fresh, 0);
  // slots may change before the layout of the run, which divides them anew
  new_part_.clear();
  has_sheets_.resize(divided);
  const mpdem::EigenvalueEstimate e = mpdem::largest_eigenvalue(world, points, grid, *law_);
  // Never longer than before: what goes by step*dt would jump, and cement that fails leaves longer steps behind.
  double dt = step_fraction_ * step_for(e.value + e.residual, relax_);
  std::string share = text_of(step_fraction_, " of the limit,");
  if (auto_step_ > 0.0 && auto_step_ <= dt) {
    share = text_of("as before, the limit is now ", dt / step_fraction_, ",");
    dt = auto_step_;
  } else if (!std::isfinite(dt)) {
    share = "as it was, nothing limits it,";
    dt = update->dt;
  }
  auto_step_ = dt;
  if (comm->me == 0)
    for (FILE* f : {screen, logfile})
      if (f)
        std::fprintf(f, "%s\n", text_of("fix mpm (id ", id, "): timestep auto: ", dt, ", ", share, " from the largest eigenvalue ", e.value,
                                        " found in ", e.products, " products").c_str());
  if (dt == update->dt) return;
  update->dt = dt;
  if (force->pair) force->pair->reset_dt();
  // Those before it took up the old step in their init. Not reset_dt(), which fix move refuses even before a run.
  for (int i = 0; i < modify->nfix && modify->fix[i] != running; ++i)
    if (modify->fix[i] != this) modify->fix[i]->init();
}

void FixMpm::report_parameters() {
  const DampedStep damped = damped_step(limiting_eigenvalue(update->dt));
  const double limit = damped.step;
  if (comm->me == 0 && !reported_) {
    std::string text = text_of(
        "fix mpm (id ", id, "): ", points_expected_, " material points, ", avec_->bodies.size(), " bodies, cell ", cell_,
        "\n  elastic   Ep ", constants_.Ep, ", Ez ", constants_.Ez, ", nu_p ", constants_.nu_p, ", nu_zp ", constants_.nu_zp,
        ", Gzp ", constants_.Gzp, ", C33 ", law_->elasticity().C33, "\n  axis      ", axis_name(axis_, axis_direction_), "\n");
    text += law_->report(cell_);
    if (mass_scale_ > 1.0 || relax_ > 0.0)
      text += text_of("  quasistatic: inertia ", mass_scale_, " times that of the calcite, damping ", relax_, " of critical\n");
    text += text_of("  time step ", update->dt, ", stable up to ", limit, eigenvalue_ > 0.0 ? "" : " at least", "\n");
    for (FILE* f : {screen, logfile})
      if (f) std::fprintf(f, "%s", text.c_str());
    warn_of_parameters();
  }
  if (damped.admitted < relax_) tell_of_damping();
  if (update->dt > limit)
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): time step ", update->dt, " exceeds the stable step ", limit,
                                 "; use 'timestep ", 0.9 * limit, "' or less, or a larger cell"));
}

// Where the step goes by it, not by the cell. From the eigenvalue itself: below the bound more damping would seem to do. Collective.
void FixMpm::tell_of_damping() {
  const mpdem::EigenvalueEstimate e = mpdem::largest_eigenvalue(world, avec_->points, grid_, *law_);
  const DampedStep damped = damped_step(e.value + e.residual);
  const double ratio = largest_mass_ratio();
  const std::string who = text_of("fix mpm (id ", id, "): "), is_free = ratio == 0.0 ? "" :
      text_of(", since the cement of a free grain has up to ", ratio, " times the inertia of the grain against it");
  const std::string text = text_of("the damping of 'quasistatic ", mass_scale_, " ", relax_, "' shortens the stable step from ", damped.undamped,
                                   " to ", damped.step, is_free, "; use 'quasistatic ", mass_scale_, " ", damped.admitted,
                                   "' or less, which leaves 0.9 of the step");
  if (update->dt > damped.step)
    mpdem::stop_all(lmp, who + text_of("time step ", update->dt, " exceeds the stable step: ", text, ", or 'timestep ", 0.9 * damped.step, "'"));
  if (!reported_ && comm->me == 0 && damped.step < 0.5 * damped.undamped) error->warning("fix mpm", 0, (who + text).c_str());
}

// Of numbers that do not go together, as moduli in GPa and strengths in Pa do not.
void FixMpm::warn_of_parameters() const {
  if (law_->inert()) return;
  const double strain = law_->implied_strength(std::min(constants_.Ez, constants_.Ep)).failure_strain;
  if (strain > 1.0)
    error->warning("fix mpm", 0,
                   text_of("fix mpm (id ", id, "): cement fails at a strain of ", strain, ", ", law_->advice_on_strain()).c_str());
}

// The last line of the report: it takes the eigenvalue, which is found for the others.
void FixMpm::report_added_mass() {
  if (reported_) return;
  reported_ = true;
  if (!coupled_) return;
  std::vector<double> sum(2 * avec_->bodies.size() + 2, 0.0);  // of each side, then mass of the grains and inertia of the cement
  const std::vector<double> mine = links_.added_mass(grid_, sides_);
  for (std::size_t i = 0; i < mine.size(); ++i) sum[2 * sides_.sides[i].body + sides_.sides[i].side] += mine[i];
  for (int i = 0; i < atom->nlocal; ++i)
    if (!avec_->is_point(i)) sum[sum.size() - 2] += atom->rmass[i];
  for (const mpdem::PointBlock& b : avec_->points.blocks) sum.back() += inertia_ * mpdem::sum_lanes(b.volume);
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), static_cast<int>(sum.size()), MPI_DOUBLE, MPI_SUM, world);
  std::map<int, double> of_grain;
  double all = 0.0, share = -1.0, most;
  for (std::size_t n = 0; n + 2 < sum.size(); ++n) {
    of_grain[avec_->bodies[n / 2].grain[n % 2]] += sum[n];
    all += sum[n];
  }
  for (std::size_t n = 0; n < grains_here_.size(); ++n)
    if (!prescribed_[n].all()) share = std::max(share, of_grain[atom->tag[grains_here_[n]]] / atom->rmass[grains_here_[n]]);
  MPI_Allreduce(&share, &most, 1, MPI_DOUBLE, MPI_MAX, world);
  if (comm->me != 0) return;
  std::string text = text_of("  links     add to the nodes ", all, " of mass, ", all / sum.back(), " of the cement's");
  if (most >= 0.0) text += text_of("; those of one free grain up to ", most, " of its mass");
  for (FILE* f : {screen, logfile})
    if (f) std::fprintf(f, "%s\n", text.c_str());
  const double scene = sum[sum.size() - 2] + sum.back();
  if (all > scene)
    error->warning("fix mpm", 0,
                   text_of("fix mpm (id ", id, "): links need ", all, " of added mass, more than the mass of all grains and cement, ", scene,
                           ", and the bonds follow late; use a smaller 'timestep', or a smaller 'kn' and 'kt' of fix mpm/couple ('auto' is ",
                           "200 C33)")
                       .c_str());
}

// Where the time of the run went, the slowest rank for each phase.
void FixMpm::report_times() {
  const bigint steps = update->ntimestep - timed_from_;
  if (steps <= 0) return;
  using mpdem::StepTimer;
  const auto& mine = timer_.seconds();
  const mpdem::PassTicks& t = advance_.ticks;
  const double ticks = std::max(1.0, static_cast<double>(t.gather + t.material + t.scatter));
  std::vector<double> s = {mine[StepTimer::kPoints] * t.scatter / ticks, mine[StepTimer::kNodes], mine[StepTimer::kHalo],
                           mine[StepTimer::kPoints] * t.gather / ticks, mine[StepTimer::kPoints] * t.material / ticks,
                           mine[StepTimer::kCoupling], mine[StepTimer::kLayout], mine[StepTimer::kOutput]};
  double total = 0.0, bytes = memory_usage(), asleep[2] = {1.0 * resting_.asleep(), 1.0 * resting_.fields()};
  for (double x : mine) total += x;
  s.push_back(total);
  MPI_Allreduce(MPI_IN_PLACE, s.data(), static_cast<int>(s.size()), MPI_DOUBLE, MPI_MAX, world);
  MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, asleep, 2, MPI_DOUBLE, MPI_SUM, world);
  const Totals& now = totals();
  if (comm->me != 0) return;
  const char* names[] = {"scatter", "node update", "halo", "gather", "material", "coupling", "layout", "output"};
  const double all = s.back();
  std::string text = text_of("fix mpm (id ", id, "): ", all, " s in ", steps, " steps, ",
                             static_cast<double>(points_expected_) * static_cast<double>(steps) / std::max(all, 1e-9),
                             " point steps per second, ", bytes / static_cast<double>(points_expected_), " bytes a point\n ");
  for (std::size_t i = 0; i + 1 < s.size(); ++i)
    text += text_of(i ? ", " : " ", names[i], " ", std::round(1000.0 * s[i] / std::max(all, 1e-9)) / 10.0, " %");
  if (asleep[0] > 0.0) text += text_of("; ", asleep[0], " of ", asleep[1], " parts of bodies at rest");
  if (mass_scale_ > 1.0 || relax_ > 0.0) {
    const double energy = now.kinetic + now.elastic + now.coupling;
    text += text_of("\n  quasistatic: kinetic share of the energy ", energy > 0.0 ? now.kinetic / energy : 0.0);
  }
  for (FILE* f : {screen, logfile})
    if (f) std::fprintf(f, "%s\n", text.c_str());
}

}  // namespace LAMMPS_NS
