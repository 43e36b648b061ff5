// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// What time step is stable.
#include <algorithm>
#include <cmath>
#include <map>

#include "../numerics/cross_matrix.h"
#include "../parallel/agree.h"
#include "cement.h"

namespace mpdem {

// Bound of the largest eigenvalue of cement without ties; 0: none.
double Cement::eigenvalue_bound() const {
  return mpdem::eigenvalue_bound(options_.basis, law_->elasticity().largest_stiffness(), inertia_, options_.cell);
}

double Cement::shear_speed() const { return std::sqrt(law_->elasticity().softest_shear() / inertia_); }

double Cement::largest_mass_ratio() {
  std::map<int, double> cement;
  for (const Body& b : bonds_.table)
    for (int tag : b.grain) cement[tag] += inertia_ * b.volume;
  double mine = 0.0, most;
  for (const Grain& g : grains_.grains) mine = std::max(mine, BondedGrains::mass_ratio(g, cement[g.tag]));
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, comm_);
  return most;
}

// Of `quasistatic` with the damping `share` of critical, the largest of any node against its grains, which when free are
// slowed too.
double Cement::relaxation_rate(double share) {
  if (share == 0.0) return 0.0;
  double rate = 0.0;
  for (const Body& b : bonds_.table) rate = std::max(rate, Relaxation::rate(b, share, shear_speed()));
  return rate * (1.0 + largest_mass_ratio());
}

double Cement::step_for(double eigenvalue, double relax) {
  // Damping acts on the velocity of half a step ago: w^2 dt^2 + 2 p dt <= B.
  const double damping = penalty_ ? penalty_->damping : 0.0, B = options_.stability_bound();
  const double p = damping * std::sqrt(B * eigenvalue) + 0.25 * B * relaxation_rate(relax);
  const double step = B / (p + std::sqrt(p * p + B * eigenvalue));
  if (!(step > 0.0))  // as if nothing limited the step, were it compared with
    throw BadState(text_of("no time step is stable, the square of the highest frequency is ", eigenvalue, " with density ", density(),
                           " of the cement and stiffness ", law_->elasticity().largest_stiffness(),
                           "; use densities, moduli and penalties that go together in these units"));
  return step;
}

// With the stiffness K_ss of its bonds against each grain alone, 2 |R_0.K R_1| <= R_0.K R_0 + R_1.K R_1 has twice the largest eigenvalue of M^-1 sum K_ss as
// a bound for all grains together. Of a free pair of equal grains it is exact.
double Cement::grains_step() {
  const std::vector<StiffnessOfBond> found = stiffness_of_bonds();
  std::map<int, Matrix6> stiffness;
  for (std::size_t row = 0; row < found.size(); ++row) {
    const Body& body = bonds_.table[row];
    const Eigen::Map<const Eigen::Vector3d> axis(found[row].axis), first(body.centre[0]), second(body.centre[1]);
    const double half_gap = 0.5 * ((second - first).norm() - body.radius[0] - body.radius[1]);
    for (int s = 0; s < 2; ++s) {
      Matrix6 to_middle = Matrix6::Identity();
      to_middle.topRightCorner<3, 3>() = -cross((s == 0 ? 1.0 : -1.0) * (body.radius[s] + half_gap) * axis);
      const auto at = stiffness.emplace(body.grain[s], Matrix6::Zero()).first;
      at->second += to_middle.transpose() * Eigen::Map<const Matrix6>(found[row].K) * to_middle;
    }
  }
  double mine = 0.0, largest;
  for (const Grain& g : grains_.grains) {
    const auto at = stiffness.find(g.tag);
    if (at == stiffness.end()) continue;
    Matrix6 K = at->second;
    for (int d = 0; d < 6; ++d) {
      const double scale = g.free[d] ? 1.0 / std::sqrt(d < 3 ? g.mass : g.inertia) : 0.0;
      K.row(d) *= scale;
      K.col(d) *= scale;
    }
    mine = std::max(mine, 2.0 * Eigen::SelfAdjointEigenSolver<Matrix6>(K, Eigen::EigenvaluesOnly).eigenvalues()[5]);
  }
  MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  return 2.0 / std::sqrt(largest);
}

// The damping that is admitted takes a tenth: with that step, p of step_for() is (B - w^2 dt^2)/(2 dt), and grows by a rate
// that is proportional to the damping.
Cement::DampedStep Cement::damped_step(double eigenvalue) {
  constexpr double kKept = 0.9;
  DampedStep d{step_for(eigenvalue, options_.relax), step_for(eigenvalue, 0.0), options_.relax};
  if (d.step >= kKept * d.undamped) return d;
  const double B = options_.stability_bound(), dt = kKept * d.undamped, damping = penalty_ ? penalty_->damping : 0.0;
  const double p = (B - eigenvalue * dt * dt) / (2.0 * dt) - damping * std::sqrt(B * eigenvalue);
  d.admitted = 4.0 * p / (B * relaxation_rate(1.0));
  return d;
}

EigenvalueEstimate Cement::eigenvalue() { return eigenvalue_of(all_rows()); }

// Of patches, which are looked at as nodes split, coarsely where that is enough: the estimate is value and residual, so it is on the safe side.
EigenvalueEstimate Cement::eigenvalue_of(const std::vector<int>& rows, const Patches* patches) {
  std::vector<EigenvaluePart> parts;
  for (int row : rows)
    if (Bond* b = bonds_.find(row)) {
      parts.push_back({&b->points, &b->grid, options_.unilateral});
      const auto patch = patches ? patches->find(row) : Patches::const_iterator();
      if (patches && patch != patches->end()) parts.back().blocks = &patch->second;
    }
  if (patches) {
    constexpr double kCoarse = 0.05;
    const EigenvalueEstimate coarse = largest_eigenvalue(comm_, parts, *law_, kCoarse);
    if (now_.dt <= step_for(coarse.value + coarse.residual, options_.relax)) return coarse;
  } else {
    condensed_.each_pattern([&](Bond& b) { parts.push_back({&b.points, &b.grid, options_.unilateral}); });
  }
  return largest_eigenvalue(comm_, parts, *law_);
}

double Cement::stable_step() {
  const EigenvalueEstimate e = eigenvalue();
  return step_for(e.value + e.residual, options_.relax);
}

// Of copies, since the layout of the run comes later, when other fixes have taken up the step.
EigenvalueEstimate Cement::eigenvalue_of_new_layout() {
  std::vector<BondLayout> layouts = layouts_of_copies(nullptr);
  std::vector<EigenvaluePart> of_layouts;
  for (BondLayout& l : layouts) of_layouts.push_back({&l.points, &l.grid, options_.unilateral});
  int me, ranks;
  MPI_Comm_rank(comm_, &me);
  MPI_Comm_size(comm_, &ranks);
  std::vector<int> patterns;
  for (const Body& b : bonds_.table)
    if (b.pattern > 0 && b.pattern % ranks == me) patterns.push_back(b.pattern);
  std::sort(patterns.begin(), patterns.end());
  patterns.erase(std::unique(patterns.begin(), patterns.end()), patterns.end());
  std::vector<CondensedBonds::OfPattern> of_patterns = layouts_of_patterns(patterns, nullptr);
  for (CondensedBonds::OfPattern& p : of_patterns) of_layouts.push_back({&p.bond.points, &p.bond.grid, options_.unilateral});
  return largest_eigenvalue(comm_, of_layouts, *law_);
}

double Cement::limiting_eigenvalue(double dt) { return limiting_eigenvalue(dt, all_rows()); }

// What was found before is kept unless it is well below: the added mass, which has a margin for that, hangs
// on it, and has to be the same in runs that are divided or restarted otherwise.
double Cement::limiting_eigenvalue(double dt, const std::vector<int>& rows, const Patches* patches) {
  double mine = 1.0, ties;
  for (const Bond& b : bonds_) mine = std::max(mine, b.grid.largest_tie_factor());
  condensed_.each_pattern([&](const Bond& b) { mine = std::max(mine, b.grid.largest_tie_factor()); });
  MPI_Allreduce(&mine, &ties, 1, MPI_DOUBLE, MPI_MAX, comm_);
  const double bound = ties * eigenvalue_bound();
  if (bound > 0.0 && dt <= step_for(bound, options_.relax)) return bound;
  const EigenvalueEstimate e = eigenvalue_of(rows, patches);
  if (e.value > 1.02 * layout_.eigenvalue) layout_.eigenvalue = e.value + e.residual;
  return e.value + e.residual;
}

// Other nodes and weights, other eigenvalue: that of the bonds in question, since those of the others stay. One that was never asked for is
// no matter: then the step is below the bound, which holds for points anywhere. The layout has the added mass for what was known before.
// Where nodes split, patches are blocks about them, one support further than those that changed: the modes that are new are as short as a cell.
void Cement::check_step_after(const std::vector<int>& rows, const char* event, const Patches* patches) {
  if (layout_.eigenvalue == 0.0 || options_.updated) return;
  const int n = now_.substeps;
  const double known = layout_.eigenvalue, limit = step_for(limiting_eigenvalue(now_.dt, rows, patches), options_.relax);
  if (now_.dt > limit)
    throw BadState(text_of("time step ", n * now_.dt, " exceeds the stable step ", n * limit, n > 1 ? text_of(" of ", n, " sub-steps") : "", " after ", event, " at step ",
                           now_.number, "; use 'timestep ", 0.9 * n * limit, "' or less"));
  if (layout_.eigenvalue != known) refresh_added_mass();
}

}  // namespace mpdem
