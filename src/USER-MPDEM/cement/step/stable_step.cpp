// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "stable_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "../../coupling/relative_damping.h"
#include "../../numerics/cross_matrix.h"
#include "../../parallel/agree.h"

namespace mpdem {

namespace {
constexpr double kGrowth = 1.02;  // growth up to which the known eigenvalue is kept
}

double StableStep::largest_mass_ratio() const {
  std::unordered_map<int, double> cement;
  for (const Grain& g : scene_.grains.grains) cement.emplace(g.tag, 0.0);
  for (const BondRecord& b : scene_.bonds().table)
    for (int s = 0; s < 2; ++s)
      if (const auto at = cement.find(b.grain[s]); b.has_grain(s) && at != cement.end()) at->second += b.mass(scene_.inertia());
  double mine = 0.0, most;
  for (const Grain& g : scene_.grains.grains) mine = std::max(mine, BondedGrains::mass_ratio(g, cement[g.tag]));
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, scene_.comm);
  return most;
}

double StableStep::relative_damping_rate(double share) const {
  if (share == 0.0) return 0.0;
  double thinnest = std::numeric_limits<double>::infinity();
  for (const BondRecord& b : scene_.bonds().table)
    if (b.thickness > 0.0) thinnest = std::min(thinnest, b.thickness);  // a bond of film alone has no nodes
  return RelativeDamping::rate(thinnest, share, scene_.shear_speed()) * (1.0 + largest_mass_ratio());
}

void StableStep::find_film() {
  const std::vector<StiffnessOfBond> found = stiffness_of_films(scene_);
  const double step = found.empty() ? std::numeric_limits<double>::infinity() : of_grains(found);
  eigenvalue_of_films_ = 4.0 / (step * step);
}

// The largest eigenvalue of a sum is at most the sum of the largest eigenvalues.
double StableStep::step_for(double eigenvalue, double relative_damping) const {
  eigenvalue += eigenvalue_of_films_;
  // Damping acts on the velocity half a step before, so stability requires w^2 dt^2 + 2 p dt <= B.
  const double damping = scene_.penalty ? scene_.penalty->damping : 0.0, B = scene_.stability_limit();
  const double p = damping * std::sqrt(B * eigenvalue) + 0.25 * B * relative_damping_rate(relative_damping);
  const double step = B / (p + std::sqrt(p * p + B * eigenvalue));
  if (!(step > 0.0))  // a step of zero would pass comparisons as if nothing limited it
    throw BadState(text_of("no time step is stable, the square of the highest frequency is ", eigenvalue, " with density ",
                           scene_.density(), " of the cement and stiffness ", scene_.law->elasticity().largest_stiffness(),
                           "; use densities, moduli and penalties that go together in these units"));
  return step;
}

// The admitted damping shortens the step by a tenth. At that step, p of step_for() is (B - w^2 dt^2)/(2 dt). The rate
// of damping in p is proportional to the damping.
StableStep::DampedStep StableStep::damped_step(double eigenvalue) const {
  DampedStep d{step_for(eigenvalue, scene_.options.relative_damping), step_for(eigenvalue, 0.0), scene_.options.relative_damping};
  if (!d.is_short()) return d;
  const double B = scene_.stability_limit(), dt = DampedStep::kKept * d.undamped, damping = scene_.penalty ? scene_.penalty->damping : 0.0;
  const double p = (B - eigenvalue * dt * dt) / (2.0 * dt) - damping * std::sqrt(B * eigenvalue);
  d.admitted = 4.0 * p / (B * relative_damping_rate(1.0));
  return d;
}

std::string StableStep::exceeds(double limit) const {
  const int n = scene_.now.substeps;
  std::string text = text_of("time step ", n * scene_.now.dt, " exceeds the stable step ", n * limit);
  if (n > 1) text += text_of(" of ", n, " sub-steps");
  return text;
}

// Uses the stiffness K_ss of the bonds of each grain with all other grains fixed. Since 2 |R_0.K R_1| <= R_0.K R_0 +
// R_1.K R_1, twice the largest eigenvalue of M^-1 sum K_ss is a bound for all grains together. It is exact for a free
// pair of equal grains.
double StableStep::of_grains(const std::vector<StiffnessOfBond>& found) const {
  std::map<int, Matrix6> stiffness;
  for (std::size_t row = 0; row < found.size(); ++row) {
    const BondRecord& record = scene_.bonds().table[row];
    const Eigen::Map<const Eigen::Vector3d> axis(found[row].axis), first(record.centre[0]), second(record.centre[1]);
    const double half_gap = 0.5 * ((second - first).norm() - record.radius[0] - record.radius[1]);
    for (int s = 0; s < 2 && record.has_grain(0) && record.has_grain(1); ++s) {
      Matrix6 to_middle = Matrix6::Identity();
      to_middle.topRightCorner<3, 3>() = -cross_matrix((s == 0 ? 1.0 : -1.0) * (record.radius[s] + half_gap) * axis);
      const auto at = stiffness.emplace(record.grain[s], Matrix6::Zero()).first;
      at->second += to_middle.transpose() * Eigen::Map<const Matrix6>(found[row].K) * to_middle;
    }
  }
  double mine = 0.0, largest;
  for (const Grain& g : scene_.grains.grains) {
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
  MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, scene_.comm);
  return 2.0 / std::sqrt(largest);
}

EigenvalueEstimate StableStep::eigenvalue() const {
  const double bound = scene_.eigenvalue_bound();
  return bound_alone() ? EigenvalueEstimate{bound, 0.0, 0, bound} : eigenvalue_of(scene_.all_rows(), nullptr, Precision::precise);
}

bool StableStep::bound_alone() const { return scene_.formulation->lasting_eigenvalue(scene_.eigenvalue_bound()) > 0.0; }

// A known eigenvalue is checked only as precisely as needed. The estimate plus its residual is on the safe side. Ranks
// have patches of their own bonds alone, so an eigenvalue that is to be kept is found from whole bonds, and does not
// depend on the number of ranks.
EigenvalueEstimate StableStep::eigenvalue_of(const std::vector<int>& rows, const Patches* patches, Precision precision) const {
  std::vector<EigenvalueSystem> systems = systems_of(rows, patches, precision != Precision::after_change);
  for (double tolerance : {0.05, 0.01, kEigenvalueTolerance}) {
    if (precision == Precision::precise || known_ == 0.0) break;
    if (tolerance == kEigenvalueTolerance)
      for (EigenvalueSystem& p : systems) p.blocks = nullptr;
    EigenvalueEstimate e = largest_eigenvalue(scene_.comm, systems, *scene_.law, tolerance);
    e.most = e.value + e.residual;
    if (e.most <= kGrowth * known_ && scene_.now.dt <= step_for(e.most, scene_.options.relative_damping)) return e;
  }
  return largest_eigenvalue(scene_.comm, systems, *scene_.law, kPreciseEigenvalue);
}

std::vector<EigenvalueSystem> StableStep::systems_of(const std::vector<int>& rows, const Patches* patches, bool with_templates) const {
  std::vector<EigenvalueSystem> systems;
  for (int row : rows)
    if (const Bond* b = scene_.bonds().find(row)) {
      systems.push_back({&b->points, &b->grid, scene_.options.unilateral});
      const auto patch = patches ? patches->find(row) : Patches::const_iterator();
      if (patches && patch != patches->end()) systems.back().blocks = &patch->second;
    }
  if (with_templates)
    condensed_.for_each_template([&](const Bond& b) { systems.push_back({&b.points, &b.grid, scene_.options.unilateral}); });
  return systems;
}

double StableStep::estimate() const {
  constexpr double kTolerance = 0.02;
  const EigenvalueEstimate e = largest_eigenvalue(scene_.comm, systems_of(scene_.all_rows(), nullptr, true), *scene_.law, kTolerance);
  return step_for(e.value + e.residual, scene_.options.relative_damping);
}

double StableStep::find() {
  const EigenvalueEstimate e = eigenvalue();
  return step_for(e.most, scene_.options.relative_damping);
}

// The known eigenvalue is kept unless the new one is clearly larger. The added mass depends on it, and has a margin for
// that. It must not depend on where a run is divided or restarted. It is found precisely, so that bonds along other axes
// of the box, whose nodes have another order, have the same added mass.
double StableStep::limiting_eigenvalue(double dt, const std::vector<int>& rows, const Patches* patches, Precision precision) {
  double mine = 1.0, constraint_factor;
  for (int row : rows)
    if (const Bond* b = scene_.bonds().find(row)) mine = std::max(mine, b->grid.largest_constraint_factor());
  if (precision != Precision::after_change)
    condensed_.for_each_template([&](const Bond& b) { mine = std::max(mine, b.grid.largest_constraint_factor()); });
  MPI_Allreduce(&mine, &constraint_factor, 1, MPI_DOUBLE, MPI_MAX, scene_.comm);
  const double bound = constraint_factor * scene_.eigenvalue_bound();
  if (bound_alone()) return bound;
  const bool known_is_enough = precision != Precision::after_change || bound <= kGrowth * known_;
  if (bound > 0.0 && known_is_enough && dt <= step_for(bound, scene_.options.relative_damping)) return bound;
  const EigenvalueEstimate e = eigenvalue_of(rows, patches, precision);
  if (e.value > kGrowth * known_) known_ = e.most;
  return e.most;
}

// A change of nodes and weights changes the eigenvalue of these bonds alone. It need not be found if their bound is no
// larger than the known eigenvalue. If no eigenvalue was ever needed, the step is below the bound, which is valid for
// points anywhere. The layout has the added mass of the eigenvalue known before. Where nodes split, patches are the
// blocks around them, one support wider than those that changed, since the new modes are as short as a cell.
bool StableStep::check_after(const std::vector<int>& rows, const char* event, const Patches* patches) {
  if (known_ == 0.0) return false;
  const double known = known_, limit = step_for(limiting_eigenvalue(scene_.now.dt, rows, patches, Precision::after_change),
                                                scene_.options.relative_damping);
  if (scene_.now.dt > limit)
    throw BadState(text_of(exceeds(limit), " after ", event, " at step ", scene_.now.number, "; use 'timestep ",
                           0.9 * scene_.now.substeps * limit, "' or less, or a smaller share in 'timestep auto'"));
  return known_ != known;
}

}  // namespace mpdem
