// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement_report.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <utility>

#include "../../mpm/point_state.h"
#include "../words/arguments.h"
#include "atom.h"
#include "../guards/cement_checks.h"
#include "cement_warnings.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "modify.h"
#include "update.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {

// The stable step is computed twice on different blocks of points: for 'timestep auto' and for the report.
constexpr double kRoundingOfSteps = 1.0 + 1e-9;

std::string shares_of(const FractureSurface& s) {
  const double all = s.at_grain[0] + s.at_grain[1] + s.inside;
  if (all <= 0.0) return "";
  return text_of("; of the fracture surface ", 100.0 * s.at_grain[0] / all, " % at the first grain, ", 100.0 * s.at_grain[1] / all,
                 " % at the second, ", 100.0 * s.inside / all, " % inside");
}

// Returns the number of debonded links.
double links_debonded(const BondState& bond) {
  static const BondColumn column =
      *std::find_if(bond_columns().begin(), bond_columns().end(), [](const BondColumn& c) { return c.name == std::string("debonded"); });
  return column.value(bond);
}

}  // namespace

const CementTotals& CementReport::totals(Cement& c) {
  if (totals_at_ == lmp_->update->ntimestep) return totals_;
  double reach = 0.0;
  for (int d = 0; d < 3; ++d) reach = std::max({reach, std::fabs(lmp_->domain->boxlo[d]), std::fabs(lmp_->domain->boxhi[d])});
  totals_ = c.report().totals(reach);
  if (c.built()) totals_at_ = lmp_->update->ntimestep;
  return totals_;
}

const CementTotals& CementReport::totals_with_contacts(Cement& c) {
  if (in_run_ && c.built() && unbalanced_at_ != lmp_->update->ntimestep) {
    if (!contacts_) contacts_ = std::make_unique<ContactForces>(lmp_);
    unbalanced_ = c.report().unbalanced_force(loads(c), contacts_->of_bonded(c.bonds().table));
    unbalanced_at_ = lmp_->update->ntimestep;
  }
  totals(c);
  totals_.unbalanced_force = unbalanced_;
  return totals_;
}

const std::vector<BondState>& CementReport::bonds(Cement& c) {
  if (bonds_ && bonds_at_ == lmp_->update->ntimestep) return *bonds_;
  bonds_ = &c.report().bond_states();
  if (c.built()) bonds_at_ = loads_at_ = lmp_->update->ntimestep;
  return *bonds_;
}

const std::vector<BondState>& CementReport::loads(Cement& c) {
  if (bonds_ && loads_at_ == lmp_->update->ntimestep) return *bonds_;
  bonds_ = &c.report().bond_loads();
  if (c.built()) loads_at_ = lmp_->update->ntimestep;
  return *bonds_;
}

namespace {
// Young's modulus and Poisson's ratio of the elastic grains, a few different ones.
std::string constants_of_grains(const std::vector<BondRecord>& table) {
  constexpr std::size_t kShown = 3;
  std::set<std::pair<double, double>> found;
  for (const BondRecord& b : table)
    for (int s = 0; s < 2; ++s)
      if (b.grain_E[s] > 0.0) found.emplace(b.grain_E[s], b.grain_nu[s]);
  std::string text;
  std::size_t n = 0;
  for (const auto& [E, nu] : found)
    if (n++ < kShown) text += text_of(text.empty() ? ", E " : "; ", E, " nu ", nu);
  return found.size() > kShown ? text + "; ..." : text;
}

// Returns the text with mass scaling or relative damping, else nothing.
std::string if_quasistatic(const CementOptions& o, const std::string& text) {
  if (o.mass_scale > 1.0 || o.relative_damping > 0.0) return text;
  return {};
}

// Collective. Returns the number of failed points without a damage that gives the direction of their crack, as a file
// may have them.
bigint failed_without_damage(MPI_Comm world, Cement& c) {
  bigint mine = 0, all;
  for (const Bond& bond : c.bonds())
    for (std::size_t b = 0; b < bond.points.meta.size(); ++b)
      for (int l = 0; l < kLanes; ++l) {
        const BlockMeta& m = bond.points.meta[b];
        const bool waits = (m.occupied & m.failed & ~m.distorted) >> l & 1;  // a failed point whose crack may close
        if (waits && !(crack_of(bond.points, kLanes * static_cast<int>(b) + l).damage[0] > 0.0)) ++mine;
      }
  MPI_Allreduce(&mine, &all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  return all;
}
}  // namespace

void CementReport::parameters(Cement& c, bigint points) {
  const CementOptions& o = c.options();
  const std::vector<BondRecord>& table = c.bonds().table;
  stop_if_not_positive(c);
  const StableStep::DampedStep damped = c.stable_step().damped_step(c.stable_step().limiting_eigenvalue(c.dt()));
  const double limit = damped.step;
  const bool exact = c.stable_step().eigenvalue_is_known(), bound = c.stable_step().bound_alone();
  const double told = reported_ || exact || bound ? limit : c.stable_step().estimate();
  if (lmp_->comm->me == 0 && !reported_) {
    const VtiConstants& e = c.law().elasticity().constants;
    std::string text = text_of(who_, points, " material points, ", table.size(), " bonds, cell ", o.cell, "\n  elastic   Ep ", e.Ep,
                               ", Ez ", e.Ez, ", nu_p ", e.nu_p, ", nu_zp ", e.nu_zp, ", Gzp ", e.Gzp, ", C33 ", c.law().elasticity().C33,
                               "\n  axis      ", axis_name(o.axis, o.axis_direction), "\n");
    text += c.law().report(o.cell);
    if (o.imperfection > 0.0)
      text += text_of("  one side of each bond carries ", o.imperfection, " more strain than the other ('imperfection')\n");
    if (!c.law().inert()) text += text_of("  cracks    ", word_of(o.split, "split", "bonds"), "\n");
    if (c.penalty() && c.penalty()->friction < 0.0 && (!c.law().inert() || c.penalty()->law->fields() > 0))
      text += text_of("  contact   cement that debonded goes through its grain",
                      word_of(o.unilateral, "", ", and faces of cracks through each other"),
                      "; 'friction' of fix mpm/couple makes them touch\n");
    const auto elastic = std::count_if(table.begin(), table.end(), [](const BondRecord& b) { return b.grain_E[0] + b.grain_E[1] > 0.0; });
    if (elastic > 0)
      text += text_of("  grains    elastic", constants_of_grains(table), ", under ", elastic, " of ", table.size(),
                      " bonds; bonds on one grain ",
                      word_of(c.has_coupled_grains(), "act on each other", "do not act on each other with 'condense yes'"), "\n");
    text += if_quasistatic(
        o, text_of("  quasistatic: inertia ", o.mass_scale, " times that of the calcite, damping ", o.relative_damping, " of critical\n"));
    text +=
        text_of("  time step ", c.dt(), c.substeps() > 1 ? text_of(" of the cement, ", c.substeps(), " in one of ", lmp_->update->dt) : "",
                ", stable up to ", word_of(exact, "", bound ? "at least " : "about "), told, "\n");
    tell(lmp_, text);
  }
  if (!reported_) warn_of_cement(lmp_, who_, c);
  const bigint open = o.unilateral && !reported_ ? failed_without_damage(lmp_->world, c) : 0;
  if (open > 0)
    mpdem::warn(
        lmp_,
        text_of(
            who_, open,
            " points failed and have no damage, so that 'unilateral yes' knows no direction of their cracks, and these never close; give "
            "the point "
            "file the columns 'd1 d2 d3 v1x v1y v1z v2x v2y v2z' or 'dxx dyy dzz dyz dxz dxy' besides 'failed', or use 'unilateral no'"));
  if (o.condense && c.penalty()) {
    int mine = c.report().bonds_solved(), all;
    MPI_Reduce(&mine, &all, 1, MPI_INT, MPI_SUM, 0, lmp_->world);
    const int bonds = static_cast<int>(table.size());
    std::string others;
    const std::vector<int>& without = c.report().bonds_without_field();
    constexpr std::size_t kNamed = 5;
    for (std::size_t n = 0; n < std::min(kNamed, without.size()); ++n)
      others +=
          text_of(n == 0 ? text_of("; ", without.size(), " stay resolved, since pieces of them are connected by almost nothing: of grains ")
                         : std::string(", "),
                  table[without[n]].grain[0], " and ", table[without[n]].grain[1]);
    if (without.size() > kNamed) others += " ...";
    if (lmp_->comm->me == 0)
      tell(lmp_, text_of("  condensed ", bonds - c.report().resolved_bonds(), " of ", bonds, " bonds, with ", all, " solutions found anew",
                         others, "\n"));
  }
  if (damped.is_short()) damping(c);
  stop_if_too_long(c, limit);
}

void CementReport::check_step(Cement& c) {
  stop_if_not_positive(c);
  stop_if_too_long(c, c.stable_step().damped_step(c.stable_step().limiting_eigenvalue(c.dt())).step);
}

void CementReport::stop_if_not_positive(const Cement& c) const {
  if (!(c.dt() > 0.0))
    stop_all(lmp_, text_of(who_, "time step ", lmp_->update->dt, " must be above 0; use 'timestep', or 'timestep auto 0.5' of fix mpm"));
}

void CementReport::stop_if_too_long(Cement& c, double limit) const {
  if (c.dt() > kRoundingOfSteps * limit)
    stop_all(lmp_,
             text_of(who_, c.stable_step().exceeds(limit), " at step ", lmp_->update->ntimestep, "; use 'timestep ",
                     0.9 * c.substeps() * limit, "' or less, ",
                     c.penalty() && c.penalty()->damping > 0.0 ? text_of("a 'damping' of fix mpm/couple below ", c.penalty()->damping, ", ")
                                                               : "",
                     "or a larger cell"));
}

// Collective. Warns or stops where the damping limits the stable step. Uses the eigenvalue itself, since its bound
// would seem to admit more damping.
void CementReport::damping(Cement& c) {
  const CementOptions& o = c.options();
  const EigenvalueEstimate e = c.stable_step().eigenvalue();
  const StableStep::DampedStep damped = c.stable_step().damped_step(e.most);
  const double ratio = c.stable_step().largest_mass_ratio();
  const std::string is_free =
      ratio == 0.0 ? "" : text_of(", since the cement of a free grain has up to ", ratio, " times the inertia of the grain against it");
  const std::string text = text_of("the damping of 'quasistatic ", o.mass_scale, " ", o.relative_damping,
                                   "' shortens the stable step from ", damped.undamped, " to ", damped.step, is_free, "; use 'quasistatic ",
                                   o.mass_scale, " ", damped.admitted, "' or less, which leaves 0.9 of the step");
  if (c.dt() > kRoundingOfSteps * damped.step)
    stop_all(lmp_,
             who_ + text_of(c.stable_step().exceeds(damped.step), ": ", text, ", or 'timestep ", 0.9 * c.substeps() * damped.step, "'"));
  if (!reported_ && damped.step < 0.5 * damped.undamped) mpdem::warn(lmp_, who_ + text);
}

void CementReport::accelerations(Cement& c) {
  if (accelerations_reported_ || !c.grains().accelerations_are_imprecise()) return;
  accelerations_reported_ = true;
  mpdem::warn(lmp_, who_ +
                        "accelerations of grains are not found to their precision, and energy is not kept: grains are far lighter than the "
                        "mass that links add, and "
                        "links of both grains of a bond share nodes; look at the 'density' of the grains, or use a smaller 'timestep', a "
                        "smaller cell, or 'kn auto' and 'kt auto' of fix mpm/couple");
}

void CementReport::added_mass(Cement& c, const AtomVecMpdem& avec) {
  accelerations(c);
  if (reported_) return;
  reported_ = true;
  if (!c.penalty()) return;
  const std::vector<BondRecord>& table = c.bonds().table;
  const std::vector<double> of_ends = c.report().added_mass_of_ends();
  double mass[2] = {0.0, c.report().cement_mass()};  // mass of the grains, and of the cement with mass scaling
  for (int i = 0; i < lmp_->atom->nlocal; ++i)
    if (!avec.is_point(i)) mass[0] += lmp_->atom->rmass[i];
  MPI_Allreduce(MPI_IN_PLACE, mass, 2, MPI_DOUBLE, MPI_SUM, lmp_->world);
  std::map<int, double> of_grain;
  double all = 0.0, share = -1.0, most;
  for (std::size_t n = 0; n < of_ends.size(); ++n) {
    of_grain[table[n / 2].grain[n % 2]] += of_ends[n];
    all += of_ends[n];
  }
  for (const Grain& g : c.grains().grains)
    if (g.any_free()) share = std::max(share, of_grain[g.tag] / g.mass);
  MPI_Allreduce(&share, &most, 1, MPI_DOUBLE, MPI_MAX, lmp_->world);
  if (lmp_->comm->me != 0) return;
  std::string text = text_of("  links     added mass ", all, ", ", all / mass[1], " of the mass of the cement");
  if (most >= 0.0) text += text_of("; up to ", most, " of the mass of a free grain");
  tell(lmp_, text + "\n");
  const double scene = mass[0] + mass[1];
  if (all > scene)
    mpdem::warn(
        lmp_,
        text_of(who_, "links need ", all, " of added mass, more than the mass of all grains and cement, ", scene,
                ", and the bonds follow late; use a smaller 'timestep', or 'kn auto', 'kt auto' and 'length cell' of fix mpm/couple, ",
                "or less ('auto' is 200 C33)",
                c.penalty()->friction > 1.0 ? text_of(", or a 'friction' below ", c.penalty()->friction) : "",
                "; look at the 'density' of the grains, too"));
}

namespace {
// Collective. Returns text on a bonded grain whose integrator limits its displacement in a step, or an empty text.
std::string limited_grain(LAMMPS* lmp, Cement& c) {
  std::string found;
  for (int k = 0; k < lmp->modify->nfix; ++k) {
    const Fix& fix = *lmp->modify->fix[k];
    if (std::string(fix.style) != "nve/limit") continue;
    for (const Grain& g : c.grains().grains)
      if (found.empty() && (lmp->atom->mask[lmp->atom->map(g.tag)] & fix.groupbit))
        found = text_of("; bonded grain ", g.tag, " is moved by fix '", fix.id,
                        "' (nve/limit), which makes and takes energy where it limits the displacement: use 'fix nve/sphere'");
  }
  return first_text(lmp->world, found);
}
}  // namespace

void CementReport::times(Cement& c, bigint points) {
  accelerations(c);
  const bigint steps = steps_timed_ += lmp_->update->ntimestep - lmp_->update->firststep;
  if (steps <= 0) return;
  const CementOptions& o = c.options();
  const auto& mine = c.timer().seconds();
  const PassTicks t = c.forces().ticks();
  const double ticks = std::max(1.0, static_cast<double>(t.gather + t.material + t.scatter));
  std::vector<double> s = {mine[StepTimer::kPoints] * t.scatter / ticks,
                           mine[StepTimer::kNodes],
                           mine[StepTimer::kHalo],
                           mine[StepTimer::kPoints] * t.gather / ticks,
                           mine[StepTimer::kPoints] * t.material / ticks,
                           mine[StepTimer::kCoupling],
                           mine[StepTimer::kCondensing],
                           mine[StepTimer::kLayout],
                           mine[StepTimer::kOutput]};
  double bytes = static_cast<double>(c.report().memory_usage()), unmoved[2] = {0.0, 1.0 * c.bonds().size()};
  for (const Bond& b : c.bonds()) unmoved[0] += b.unmoved;
  s.push_back(c.timer().cpu_seconds());
  s.push_back(c.timer().wall_seconds());
  MPI_Allreduce(MPI_IN_PLACE, s.data(), static_cast<int>(s.size()), MPI_DOUBLE, MPI_MAX, lmp_->world);
  MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPI_DOUBLE, MPI_SUM, lmp_->world);
  MPI_Allreduce(MPI_IN_PLACE, unmoved, 2, MPI_DOUBLE, MPI_SUM, lmp_->world);
  double deepest = c.contact().deepest_so_far();
  MPI_Allreduce(MPI_IN_PLACE, &deepest, 1, MPI_DOUBLE, MPI_MAX, lmp_->world);
  const CementTotals& now = totals_with_contacts(c);
  const std::string limited = limited_grain(lmp_, c);
  if (lmp_->comm->me != 0) return;
  const char* names[] = {"scatter",  "node update", "halo",   "gather", "material",
                         "coupling", "condensing",  "layout", "output"};  // in the order of s
  const double all = s.back(), cpu = s.end()[-2], point_steps = static_cast<double>(points) * static_cast<double>(steps);
  std::string text = text_of(who_, all, " s in ", steps, " steps, ", point_steps / std::max(all, 1e-9), " point steps per second, ",
                             point_steps / std::max(cpu, 1e-9), " by CPU time, ");
  text += points > 0 ? text_of(bytes / static_cast<double>(points), " bytes a point\n ")
                     : text_of(bytes / std::max(1.0, static_cast<double>(c.bonds().table.size())), " bytes a bond\n ");
  for (std::size_t i = 0; i + 2 < s.size(); ++i)
    text += text_of(i ? ", " : " ", names[i], " ", std::round(1000.0 * s[i] / std::max(cpu, 1e-9)) / 10.0, " %");
  if (unmoved[0] > 0.0) text += text_of("; ", unmoved[0], " of ", unmoved[1], " bonds at rest");
  text += if_quasistatic(
      o, text_of("\n  quasistatic: kinetic share of the energy ", now.kinetic_share, ", unbalanced force ", now.unbalanced_force));
  if (deepest > 0.0)
    text += text_of("\n  contact: deepest overlap of rigid surfaces ", deepest, ", ", 100.0 * deepest / o.cell, " % of a cell");
  tell(lmp_, text + "\n");
  if (now.left.points > 0.0)
    tell(lmp_, text_of(who_, now.left.points, " points of cement with a mass of ", now.left.mass, " have left the scene so far, ",
                       now.left.dropped, " of them with a mass of ", now.left.dropped_mass, " were dropped\n"));
  constexpr double kMostImbalance = 0.02;
  if (c.penalty() && std::fabs(now.imbalance) > kMostImbalance)
    mpdem::warn(
        lmp_,
        text_of(who_, "energy of the cement was ", now.imbalance < 0.0 ? "made" : "lost", ", ", 100.0 * std::fabs(now.imbalance),
                " % of the largest work or energy at step ", lmp_->update->ntimestep,
                "; use one 'timestep', or a smaller one, and look for fixes and commands that move bonded grains besides their integrator",
                limited));
}

void CementReport::modes(Cement& c) {
  constexpr std::size_t kMostLines = 20;
  const std::vector<BondState>& state = bonds(c);
  const std::vector<BondRecord>& table = c.bonds().table;
  const Cracks& cracks = c.cracks();
  std::vector<char> told(state.size(), 0);
  std::vector<int> not_separated;
  std::size_t lines = 0;
  for (std::size_t b = 0; b < std::min(state.size(), cracks.size()) && lines < kMostLines; ++b) {
    told[b] = is_listed(state[b]);
    if (told[b] && !cracks.separated(b)) not_separated.push_back(static_cast<int>(b));
    lines += told[b];
  }
  if (lines == 0) return;
  const std::vector<Cracks::LigamentReport> ahead = c.ligaments(not_separated);
  if (lmp_->comm->me != 0) return;
  auto of_next = ahead.begin();
  bool shares_nodes = false;  // has a bond lost more than half of a section whose crack has no phantom nodes?
  for (std::size_t b = 0; b < told.size(); ++b) {
    if (!told[b]) continue;
    std::string text = text_of(who_, "bond ", b + 1, " of grains ", table[b].grain[0], " and ", table[b].grain[1], ": ", cracks.mode(b),
                               ", ", state[b].failed, " points failed");
    if (c.leaves_residue()) text += text_of(", ", links_debonded(state[b]), " links debonded");
    if (cracks.separated(b)) {
      text += shares_of(cracks[b].separation);
      tell(lmp_, text + "\n");
      continue;
    }
    const Cracks::LigamentReport& a = *of_next++;
    if (cracks.broken(b)) {
      text +=
          text_of(", and less than ", 100.0 * LoadHistory::kBrokenLoadRatio, " % of its peak load is left since step ", cracks[b].broken_at,
                  " though ", a.left, " of ", a.whole, " points of its weakest section are intact", shares_of(cracks[b].separation));
    } else {
      text += text_of("; ", a.whole > 0.0 ? 100.0 * a.left / a.whole : 0.0, " % of its weakest section is intact (", a.left, " of ",
                      a.whole, " points), and a crack through this ligament would be ", Cracks::mode_of(a.surface), shares_of(a.surface));
      shares_nodes = shares_nodes || 2.0 * a.left < a.whole;
    }
    tell(lmp_, text + "\n");
  }
  const CementOptions& o = c.options();
  if (shares_nodes && !split_reported_ && !o.split && !o.reprojects()) {
    split_reported_ = true;
    tell(lmp_,
         text_of(who_,
                 "with 'cracks bonds' the faces of a crack share nodes and carry load until the bond is separated; with 'cracks split' "
                 "of fix mpm they do not\n"));
  }
  if (lines == kMostLines) sum_of_modes(c, static_cast<int>(lines));
}

// Does the report at the end of a run have a line for this bond?
bool CementReport::is_listed(const BondState& bond) { return bond.failed != 0.0 || bond.separated != 0.0 || links_debonded(bond) != 0.0; }

// Prints the number of bonds of each failure mode, where not every bond has a line.
void CementReport::sum_of_modes(const Cement& c, int lines) const {
  std::map<std::string, int> count;
  int damaged = 0;
  for (std::size_t b = 0; b < bonds_->size(); ++b) {
    if (!is_listed((*bonds_)[b])) continue;
    ++count[c.cracks().mode(b)];
    ++damaged;
  }
  if (damaged == lines) return;
  std::string text =
      text_of(who_, damaged, " of ", bonds_->size(), " bonds have points that failed", c.leaves_residue() ? " or links that debonded" : "",
              ", ", lines, " are listed; failure modes of all ", damaged, ":");
  const char* comma = " ";
  for (const auto& mode : count) {
    text += text_of(comma, mode.second, " ", mode.first);
    comma = ", ";
  }
  tell(lmp_, text + "\n");
}

// Returns the smallest jump of velocity that is reported. The wave that it sends through the cement has a stress of 1 %
// of the strength, or without damage a strain of 1e-6. start_watch() also ignores jumps that are a small share of the
// velocity.
double CementReport::limit_of_jumps(const Cement& c) const {
  const Law& law = c.law();
  const VtiConstants& e = law.elasticity().constants;
  const double speed = law.elasticity().fastest_wave(c.scaled_density());
  if (law.inert()) return 1e-6 * speed;
  return 0.01 / (c.scaled_density() * speed) *
         std::min(law.implied_strength(e.Ez).tensile_strength, law.implied_strength(e.Ep).tensile_strength);
}

void CementReport::start(Cement& c) {
  if (!c.penalty()) return;
  const BondedGrains::Start& s = c.grains().fastest_start();
  const double wave = c.scaled_density() * c.law().elasticity().fastest_wave(c.scaled_density());
  std::string text;
  if (s.speed > limit_of_jumps(c)) {
    const BondRecord& b = c.bonds().table[s.row];
    text = text_of("the cement of grains ", b.grain[0], " and ", b.grain[1], " starts at a speed of ", s.speed,
                   " against one of them, which sends a wave of stress ", wave * s.speed,
                   " through it; set velocities of grains before create_cement, or those of grains and points alike, and let grains that "
                   "part do so from rest");
  }
  const std::string first = first_text(lmp_->world, text);
  if (!first.empty()) mpdem::warn(lmp_, first);
}

void CementReport::jump(Cement& c) {
  if (jump_reported_ || !c.penalty()) return;
  const BondedGrains::Jump& j = c.grains().worst_jump();
  const double speed = c.law().elasticity().fastest_wave(c.scaled_density());
  const std::string text = j.tag == 0 ? ""
                                      : text_of("the prescribed velocity of bonded grain ", j.tag, " jumps by ", j.size, " in step ",
                                                j.step, ", which sends a wave of stress ", c.scaled_density() * speed * j.size,
                                                " through its cement; let it begin, change and "
                                                "end smoothly, over many steps, as by 'fix move ... variable' with formulas");
  const std::string first = first_text(lmp_->world, text);
  if (first.empty()) return;
  jump_reported_ = true;
  mpdem::warn(lmp_, first);
}

void CementReport::start_run(Cement& c) {
  in_run_ = true;
  jump_reported_ = false;
  c.grains().start_watch(limit_of_jumps(c));
  forget();
}

void CementReport::end_run(Cement& c) {
  totals_with_contacts(c);
  in_run_ = false;
}

// Times the steps only. The set-up may take as long as hundreds of steps.
void CementReport::start_timing(Cement& c) {
  steps_timed_ = 0;
  c.timer().clear();
  c.forces().clear_ticks();
}

}  // namespace mpdem
