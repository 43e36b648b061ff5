// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The step of the damage: D = D_n + Delta N, where Delta is the first root of Yeq - B at the end of the step.
//
// Near the surface N is the direction of the drive at the middle of the step. This is at half the strain and half the
// growth that the tangent at (strain at the end, D_n) gives along the drive there. D is then of second order in the
// step. With N at D_n, or solved for at the end of the step, it is of first order at the same cost, see bench/law.cpp.
// With any N it ends on the surface. A jump far beyond the surface has no such middle. N is then the direction at D_n,
// and after that twice the direction at the D that it led to. The same is done with `evolution full`, where the root may be one
// of several even near the surface.
//
// The arithmetic of a lane does not depend on its neighbours: lanes stop and branch by masks.
#include <cmath>

#include "tensor_damage.h"

namespace mpdem {

namespace {

// The root is found when the next change of D would be smaller than this.
constexpr double kTolerance = 2e-11;
constexpr int kMostSteps = 8;
// Two values nearer than this do not give a slope.
constexpr double kLeastSecant = 1e-10;
constexpr int kMarchSteps = 16;
// If the threshold falls, Yeq - B may dip below zero for only a short while. So the march takes small steps.
constexpr double kNearMarch = 1.1;
// A trial state with Yeq below this factor times B has a single root along Y (checked on 1200 states). Further out the
// march to the first root of the full range is needed.
constexpr double kNearSurface = 1.2;
// Cosine of the largest angle between the drives at the middle and at the trial state. If a step rotates the drive
// more, the middle does not represent the step, and the trial state is used.
constexpr double kLargestTurn = 0.5;
constexpr int kMostDirections = 3;
constexpr double kSameDirection = 1e-10;
// With viscosity D only comes near the cut-off. A lane whose growth aims at the cut-off has failed when its largest
// eigenvalue is this share of it. From D = 0 that takes 4.6 relaxation times. The rest is added in that step.
constexpr double kViscousFailure = 0.99;

Sym3<vd> scaled(const Sym3<vd>& h, const Sym3<vd>& x) {
  return {h.xx * x.xx, h.yy * x.yy, h.zz * x.zz, h.yz * x.yz, h.xz * x.xz, h.xy * x.xy};
}

Sym3<vd> unit(const Sym3<vd>& Y) { return (1.0 / max(sqrt(contract(Y, Y)), splat(1e-300))) * Y; }

}  // namespace

// What the search for the new D starts from.
struct TensorDamage::Search {
  Sym3<vd> strain, damage;  // strain at the end of the step, damage at its start
  vd B_scale, softening;    // B_scale: factor on B, strength over tension weight, since the surface is s Yeq - B
  int evaluations = 0;
};

// A state D at the strain at the end of the step.
struct TensorDamage::TrialState {
  Evaluation state;
  Sym3<vd> D, drive;
  vd Yeq, excess;  // excess: Yeq - B, with B times Search::B_scale

  TrialState(const TensorDamage& law, const Sym3<vd>& strain, const Sym3<vd>& damage)
      : state(law.evaluate(strain, damage)), D(damage), drive(state.Y), Yeq(law.drive_by(drive)) {}
};

// The result of the search: the new D with its stress and drive.
struct TensorDamage::Found {
  Sym3<vd> D, stress, drive;
  void take(vmask lanes, const TrialState& x) {
    D = blend(lanes, x.D, D);
    stress = blend(lanes, x.state.stress, stress);
    drive = blend(lanes, x.drive, drive);
  }
};

TensorDamage::TrialState TensorDamage::evaluate(Search& s, const Sym3<vd>& D) const {
  ++s.evaluations;
  TrialState x(*this, s.strain, D);
  x.excess = x.Yeq - s.B_scale * threshold(D, s.softening);
  return x;
}

// Derivative of the excess by D. The derivative of Y is symmetric, as a second derivative of the energy. That of
// <Y>_+:<Y>_+/2 is <Y>_+. So one derivative of Y, along the drive, gives the derivative of Yeq in all directions.
Sym3<vd> TensorDamage::gradient_of_excess(Search& s, const TrialState& x) const {
  ++s.evaluations;
  const Sym3<vd> G = splat(std::sqrt(0.5)) * derivative_of_Y(x.state, unit(x.drive));
  if (!any(s.softening != 0.0)) return G;
  const LargestEigenvalue top = largest_eigenvalue_and_slope(x.D);
  return G - ((x.Yeq - x.excess) * s.softening / (1.0 - top.value)) * top.slope;
}

// Largest Delta with max eig(D + Delta N) <= Dcut. With A = Dcut 1 - D positive definite, A - Delta N stays positive
// definite up to Delta = 1 / max eig(A^-1/2 N A^-1/2).
vd TensorDamage::largest_growth(const Sym3<vd>& damage, const Sym3<vd>& direction) const {
  const Spectral d = eigen(damage);
  vd r[3];
  for (int i = 0; i < 3; ++i) r[i] = 1.0 / sqrt(max(p_.Dcut - d.value[i], splat(1e-16)));
  const Sym3<vd> n = rotate_back(d.axes, direction);
  const Spectral m = eigen(scaled({r[0] * r[0], r[1] * r[1], r[2] * r[2], r[1] * r[2], r[0] * r[2], r[0] * r[1]}, n));
  // The largest eigenvalue can be so small only with `evolution full`. Then nothing grows towards the cut-off, and ten units of
  // Delta leave every surface behind.
  return 1.0 / max(largest(m), splat(0.1));
}

// True if the largest eigenvalue of D is at `share` of the cut-off: (1 - tiny) share Dcut 1 - D is then not positive
// definite.
vmask TensorDamage::at_cutoff(const Sym3<vd>& D, double share) const {
  const double c = share * p_.Dcut * (1.0 - 1e-12);
  const vd xx = c - D.xx, yy = c - D.yy;
  const Sym3<vd> m{xx, yy, c - D.zz, -D.yz, -D.xz, -D.xy};
  return ~((xx > 0.0) & (xx * yy - D.xy * D.xy > 0.0) & (determinant(m) > 0.0));
}

// Direction N, from the trial state x and the derivative G of its excess. `beyond` are lanes whose tangent has no root below the cut-off.
Sym3<vd> TensorDamage::direction(Search& s, const Sym3<vd>& strain_start, const TrialState& x, const Sym3<vd>& G, vmask lanes) const {
  const Sym3<vd> N = unit(x.drive);
  const vd along = contract(G, N);
  vd delta = -x.excess / along;
  const vmask beyond = lanes & (~(along < 0.0) | at_cutoff(s.damage + delta * N));
  if (any(beyond)) {
    const vd limit = largest_growth(s.damage, N);
    delta = select(beyond, select(along < 0.0, min(delta, limit), limit), delta);
  }
  ++s.evaluations;
  Sym3<vd> drive = evaluate(splat(0.5) * (strain_start + s.strain), s.damage + (0.5 * delta) * N).Y;
  drive_by(drive);
  const Sym3<vd> middle = unit(drive);
  return blend(contract(middle, N) > kLargestTurn, middle, N);
}

// Finds the root along N. The first step is Newton's, from the trial state. The second is on the parabola through value
// and slope there and the value that the first step led to. Then secants follow: their slopes are as good as the
// derivative and save an evaluation each. A lane ends when the next step would be below the tolerance. Returns the
// lanes that are not sure of their root.
vmask TensorDamage::root_by_secants(Search& s, vd excess, vd slope, const Sym3<vd>& N, vmask lanes, Found& found) const {
  vd delta = -excess / slope, step = delta;
  vmask open = lanes & (slope < 0.0) & ~at_cutoff(s.damage + delta * N), done = splat_mask(false);
  for (int k = 0; any(open) && k < kMostSteps; ++k) {
    const TrialState x = evaluate(s, s.damage + delta * N);
    const vd secant = (x.excess - excess) / step;
    const vd slope_here = k == 0 ? 2.0 * secant - slope : select(abs(step) > kLeastSecant, secant, slope);
    const vd next = -x.excess / slope_here;
    const vmask converged = open & (abs(next) <= kTolerance);
    found.take(converged, x);
    done |= converged;
    open &=
        ~converged & (abs(next) <= 0.5 * abs(step)) & (slope_here < 0.0) & (delta + next > 0.0) & ~at_cutoff(s.damage + (delta + next) * N);
    excess = x.excess;
    slope = slope_here;
    step = next;
    delta = select(open, delta + next, delta);
  }
  return lanes & ~done;
}

// Finds the first Delta > 0 at which Yeq(D_n + Delta N) falls to B, before the cut-off is reached at `limit`. The march
// starts at a millionth of the range and has a constant factor. If `start` is given, it begins there and has a small
// factor. Then Newton's method follows within the bracket, with bisection if it leaves that. Returns the lanes that
// stay above the surface. They get the end of the range.
vmask TensorDamage::first_root(Search& s, const Sym3<vd>& N, vd start, vd limit, vmask lanes, Found& found) const {
  const vd factor = select(start > 0.0, splat(kNearMarch), splat(std::pow(10.0, 6.0 / kMarchSteps)));
  vd low{}, high = limit, delta = limit;
  vmask open = lanes, missing = splat_mask(false);
  for (vd t = max(start, 1e-6 * limit); any(open); t *= factor) {
    t = min(t, limit);
    const TrialState x = evaluate(s, s.damage + t * N);
    const vmask below = open & (x.excess <= 0.0), ended = open & ~below & (t >= limit);
    low = select(open & ~below, t, low);
    high = select(below, t, high);
    delta = select(below, t, delta);
    missing |= ended;
    open &= ~below & ~ended;
  }
  for (int k = 0; k < 100; ++k) {
    const TrialState x = evaluate(s, s.damage + delta * N);
    const vmask above = x.excess > 0.0;
    low = select(above, delta, low);
    high = select(above, high, delta);
    const vd slope = contract(gradient_of_excess(s, x), N), newton = delta - x.excess / slope;
    const vmask good = (slope < 0.0) & (newton >= low) & (newton <= high) & splat_mask(k < 20);
    const vd next = select(good, newton, 0.5 * (low + high));
    const vmask converged = lanes & (missing | (abs(next - delta) <= kTolerance));
    found.take(converged, x);
    lanes &= ~converged;
    if (!any(lanes)) break;
    delta = select(lanes, next, delta);
  }
  return missing;
}

// Both searches return the lanes that fail: small_step() near the surface, jump() far beyond it.
vmask TensorDamage::small_step(Search& s, const Sym3<vd>& strain_start, const TrialState& x, vmask lanes, Found& found) const {
  const Sym3<vd> G = gradient_of_excess(s, x), N = direction(s, strain_start, x, G, lanes);
  const vd along = contract(G, N);
  vmask open = root_by_secants(s, x.excess, along, N, lanes, found);
  if (!any(open)) return splat_mask(false);
  const vd limit = largest_growth(s.damage, N);
  vmask failed = splat_mask(false);
  if (p_.exponent >= 0.0) {
    // Next to the surface there is one root at most (kNearSurface) if the threshold does not fall with damage. So one evaluation
    // at the end of the range tells whether the root lies before it.
    const TrialState end = evaluate(s, s.damage + limit * N);
    failed = open & (along < 0.0) & (end.excess > 0.0);
    found.take(failed, end);
    open &= ~failed;
  }
  if (!any(open)) return failed;
  return failed | first_root(s, N, select(along < 0.0, -0.5 * x.excess / along, vd{}), limit, open, found);
}

vmask TensorDamage::jump(Search& s, vmask lanes, Found& found) const {
  vmask failed = splat_mask(false);
  Sym3<vd> N = unit(found.drive);
  for (int k = 0; k < kMostDirections && any(lanes); ++k) {
    failed |= first_root(s, N, vd{}, largest_growth(s.damage, N), lanes, found);
    const Sym3<vd> there = unit(found.drive), change = there - N;
    lanes &= ~failed & (contract(change, change) > kSameDirection * kSameDirection);
    N = there;
  }
  return failed;
}

TensorDamage::Update TensorDamage::update(const Sym3<vd>& strain_start, const Sym3<vd>& strain, Sym3<vd>& damage, vmask active, vd strength,
                                          double growth, vd softening) const {
  TrialState x(*this, strain, damage);
  Search s{strain, damage, strength / max(tension_weight(x.state.stress_e), splat(1e-300)), softening, 1};
  const vd B = s.B_scale * threshold(damage, softening);
  x.excess = x.Yeq - B;

  Update u;
  u.failed = splat_mask(false);
  u.dissipated = u.released = vd{};
  u.stress = blend(active, x.state.stress, Sym3<vd>{});
  u.grown = active & (x.Yeq > B * (1.0 + 1e-14));
  u.evaluations = s.evaluations;
  if (!any(u.grown)) return u;

  Found found{damage, x.state.stress, x.drive};
  const vmask near = p_.monotone ? u.grown & (x.Yeq < kNearSurface * B) : splat_mask(false), far = u.grown & ~near;
  if (any(near)) u.failed = small_step(s, strain_start, x, near, found);
  if (any(far)) u.failed |= jump(s, far, found);
  if (growth < 1.0) {
    const Sym3<vd> part = damage + splat(growth) * (found.D - damage);
    u.failed = u.grown & (u.failed | at_cutoff(found.D)) & at_cutoff(part, kViscousFailure);
    found.D = blend(u.failed, found.D, part);
    ++s.evaluations;
    found.stress = evaluate(strain, found.D).stress;
  }
  u.failed |= u.grown & at_cutoff(found.D);
  u.evaluations = s.evaluations;
  damage = blend(u.grown, found.D, damage);
  const vd kept = 0.5 * contract(found.stress, strain_start);
  u.dissipated = select(u.grown, 0.5 * contract(x.state.stress, strain_start) - kept, vd{});
  u.released = select(u.failed, kept, vd{});
  u.stress = blend(active & ~u.failed, found.stress, Sym3<vd>{});
  return u;
}

}  // namespace mpdem
