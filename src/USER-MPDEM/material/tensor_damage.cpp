// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "tensor_damage.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "effective_strain.h"

namespace mpdem {

namespace {

constexpr int kDirectionIterations = 3;
constexpr double kDirectionTolerance = 1e-10;
constexpr int kMarchSteps = 16;
// A trial state this close to the surface has a single root along Y (checked on 1200
// states); further out the march to the first root of the full range is needed.
constexpr double kNearSurface = 1.2;
constexpr double kRootTolerance = 2e-15;  // of B
// With viscosity D only comes near the cut-off; a lane whose growth aims at the cut-off has
// failed when its largest eigenvalue is this share of it. From D = 0 that takes 4.6 relaxation
// times. The rest of the way is gone in that step.
constexpr double kViscousFailure = 0.99;

Sym3<vd> blend(vmask m, const Sym3<vd>& a, const Sym3<vd>& b) {
  return {select(m, a.xx, b.xx), select(m, a.yy, b.yy), select(m, a.zz, b.zz),
          select(m, a.yz, b.yz), select(m, a.xz, b.xz), select(m, a.xy, b.xy)};
}

Sym3<vd> scaled(const Sym3<vd>& h, const Sym3<vd>& x) {
  return {h.xx * x.xx, h.yy * x.yy, h.zz * x.zz, h.yz * x.yz, h.xz * x.xz, h.xy * x.xy};
}

}  // namespace

namespace {

// Energy that a volume has spent on damage D = 1 - keep, over sqrt(2) B0.
double spent_work(double m, double keep) {
  const double log_keep = std::log(keep), x = (1.0 - m) * log_keep;
  // -log_keep (1 - e^x)/(-x) at m = 1 is -log_keep
  return std::fabs(x) < 1e-12 ? -log_keep : -log_keep * std::expm1(x) / x;
}

// Work of a volume pulled to failure, over sqrt(2) B0.
double band_work(double m, double Dcut) {
  return spent_work(m, 1.0 - Dcut) + 0.5 * std::exp((1.0 - m) * std::log(1.0 - Dcut));
}

// m in (-1,3) at which the rising function work(m) is `wanted`; false if there is none.
template <class F>
bool find_exponent(F work, double wanted, double& least, double& most, double& m) {
  double lo = -1.0 + 1e-9, hi = 3.0 - 1e-9;
  least = work(lo);
  most = work(hi);
  if (!(wanted > least && wanted < most)) return false;
  for (int i = 0; i < 200; ++i) {
    const double mid = 0.5 * (lo + hi);
    if (mid == lo || mid == hi) break;
    (work(mid) < wanted ? lo : hi) = mid;
  }
  m = hi;
  return true;
}

}  // namespace

double localisation_cells(const DamageParameters& p) {
  const double m = p.exponent, keep = (1.0 - p.Dcut) * std::pow(3.0, 2.0 / (1.0 + m));
  return 1.0 + (keep < 1.0 ? spent_work(m, keep) / band_work(m, p.Dcut) : 0.0);
}

ImpliedStrength implied_strength(const DamageParameters& p, double E) {
  const double e0 = std::pow(2.0, 0.25) * std::sqrt(p.B0 / E);
  const double m = p.exponent;
  return {E * e0, e0, e0 * std::pow(1.0 - p.Dcut, -0.5 * (1.0 + m)), std::sqrt(2.0) * p.B0 * band_work(m, p.Dcut)};
}

double crack_band_exponent(const DamageParameters& p, double G_f, double band) {
  const double energy = std::sqrt(2.0) * p.B0;
  double least, most, m = 0.0;
  if (!find_exponent([&](double x) { return band_work(x, p.Dcut); }, G_f / (energy * band), least, most, m)) {
    std::ostringstream why;
    why << "G_f " << G_f << " cannot be spent on a band of width " << band << ": with this B0 and cut-off the width must lie between "
        << G_f / (energy * most) << " and " << G_f / (energy * least);
    throw std::domain_error(why.str());
  }
  return m;
}

double crack_cell_exponent(const DamageParameters& p, double G_f, double cell) {
  const double energy = std::sqrt(2.0) * p.B0;
  double least, most, m = 0.0;
  const auto work = [&](double x) {
    DamageParameters q = p;
    q.exponent = x;
    return localisation_cells(q) * band_work(x, p.Dcut);
  };
  if (!find_exponent(work, G_f / (energy * cell), least, most, m)) {
    std::ostringstream why;
    why << "G_f " << G_f << " cannot be spent on a crack in cells of " << cell << ": with this B0 and cut-off it must lie between "
        << energy * cell * least << " and " << energy * cell * most << ", or for this G_f the cell between "
        << G_f / (energy * most) << " and " << G_f / (energy * least);
    throw std::domain_error(why.str());
  }
  return m;
}

TensorDamage::State TensorDamage::evaluate(const Sym3<vd>& strain, const Sym3<vd>& damage) const {
  const EffectiveStrain<vd> effective(damage);
  const Sym3<vd> strain_e = effective(strain);
  State s;
  s.stress_e = elasticity_.stress(strain_e);
  s.stress = effective(s.stress_e);
  s.Y = sandwich(effective.phi(), sym_product(s.stress, strain_e));
  return s;
}

vd TensorDamage::drive_by(Sym3<vd>& Y) const {
  if (p_.monotone) Y = positive_part(Y);
  return sqrt(0.5 * contract(Y, Y));
}

vd TensorDamage::tension_weight(const Sym3<vd>& stress_e) const {
  if (p_.zeta == 1.0) return splat(1.0);
  const Spectral t = eigen(stress_e);
  vd positive{}, total{};
  for (int i = 0; i < 3; ++i) {
    positive += max(t.value[i], vd{});
    total += abs(t.value[i]);
  }
  const vd r = select(total > 0.0, positive / max(total, splat(1e-300)), splat(1.0));
  return r + (1.0 - r) * (p_.zeta * p_.zeta);
}

vd TensorDamage::threshold(const Sym3<vd>& damage) const {
  if (p_.exponent == 0.0) return splat(p_.B0);
  const double m = p_.exponent;
  return p_.B0 * map_lanes(1.0 - largest(eigen(damage)), [m](double a) { return std::pow(a, -m); });
}

Sym3<vd> TensorDamage::stress(const Sym3<vd>& strain, const Sym3<vd>& damage) const {
  // The same call as in update(), so that a state gives the same stress to the bit there
  // and here.
  return evaluate(strain, damage).stress;
}

TensorDamage::Drive TensorDamage::drive(const Sym3<vd>& strain, const Sym3<vd>& damage) const {
  State s = evaluate(strain, damage);
  return {tension_weight(s.stress_e) * drive_by(s.Y), threshold(damage), largest(eigen(damage))};
}

// Largest Delta with max eig(D + Delta N) <= Dcut. With A = Dcut 1 - D positive
// definite, A - Delta N stays so up to Delta = 1 / max eig(A^-1/2 N A^-1/2).
vd TensorDamage::largest_growth(const Sym3<vd>& damage, const Sym3<vd>& direction) const {
  const Spectral d = eigen(damage);
  vd r[3];
  for (int i = 0; i < 3; ++i) r[i] = 1.0 / sqrt(max(p_.Dcut - d.value[i], splat(1e-16)));
  const Sym3<vd> n = rotate_back(d.axes, direction);
  const Spectral m = eigen(scaled(
      {r[0] * r[0], r[1] * r[1], r[2] * r[2], r[1] * r[2], r[0] * r[2], r[0] * r[1]}, n));
  // Only with literal Y can the largest eigenvalue be so small: nothing grows towards
  // the cut-off, ten units of Delta leave every surface behind.
  return 1.0 / max(largest(m), splat(0.1));
}

// Is the largest eigenvalue of D at `share` of the cut-off? (1 - tiny) share Dcut 1 - D loses
// definiteness.
vmask TensorDamage::at_cutoff(const Sym3<vd>& D, double share) const {
  const double c = share * p_.Dcut * (1.0 - 1e-12);
  const vd xx = c - D.xx, yy = c - D.yy;
  const Sym3<vd> m{xx, yy, c - D.zz, -D.yz, -D.xz, -D.xy};
  return ~((xx > 0.0) & (xx * yy - D.xy * D.xy > 0.0) & (determinant(m) > 0.0));
}

// First Delta > 0 at which Yeq(D + Delta N) falls to B, before the cut-off is reached. g0 > 0
// is the value at Delta = 0. `near` lanes march from their guess, the others over the whole
// range in constant factors from a millionth of it.
TensorDamage::Root TensorDamage::first_root(const Sym3<vd>& strain, const Sym3<vd>& damage, const Sym3<vd>& direction,
                                            vd g0, vd B_scale, vd guess, vmask near, vmask lanes) const {
  Root root;
  const auto evaluate_at = [&](vd t, Sym3<vd>& stress, Sym3<vd>& Y) {
    const Sym3<vd> D = damage + t * direction;
    const State s = evaluate(strain, D);
    stress = s.stress;
    Y = s.Y;
    return drive_by(Y) - B_scale * threshold(D);
  };
  const auto keep = [&](vmask m, vd t, const Sym3<vd>& stress, const Sym3<vd>& Y) {
    root.delta = select(m, t, root.delta);
    root.stress = blend(m, stress, root.stress);
    root.Y = blend(m, Y, root.Y);
  };
  const vd tolerance = kRootTolerance * p_.B0 * B_scale;
  Sym3<vd> stress, Y;
  root.missing = splat_mask(false);

  // March outwards by constant factors until g changes sign. The exact end of the range
  // takes two spectral decompositions and is only wanted when a step might pass it.
  const double factor = std::pow(10.0, 6.0 / kMarchSteps);
  vd limit = splat(1e300);
  bool know_limit = false;
  const auto find_limit = [&] {
    limit = largest_growth(damage, direction);
    know_limit = true;
  };
  if (any(lanes & ~near)) find_limit();
  vd a{}, ga = g0, b{}, gb = vd{};
  vd t = select(near, guess, 1e-6 * limit);
  vmask open = lanes;
  root.delta = vd{};
  root.stress = root.Y = Sym3<vd>{a, a, a, a, a, a};
  for (int k = 0; any(open) && k < 60; ++k) {
    if (!know_limit && any(open & at_cutoff(damage + t * direction))) find_limit();
    t = min(t, limit);
    const vd gt = evaluate_at(t, stress, Y);
    keep(open, t, stress, Y);
    const vmask crossed = open & (gt <= 0.0);
    b = select(crossed, t, b);
    gb = select(crossed, gt, gb);
    const vmask above = open & ~crossed;
    a = select(above, t, a);
    ga = select(above, gt, ga);
    const vmask ended = above & (t >= limit);
    root.missing |= ended;
    open = above & ~ended;
    t = factor * t;
  }

  // Illinois steps inside the bracket; g is nearly linear in Delta, so a few suffice.
  // Bisection takes over should they stall.
  open = lanes & ~root.missing & (gb < -tolerance);
  vmask last_high = splat_mask(false), last_low = splat_mask(false);
  for (int k = 0; any(open) && k < 100; ++k) {
    vd c = k < 30 ? b - gb * (b - a) / min(gb - ga, splat(-1e-300)) : 0.5 * (a + b);
    const vmask inside = (c > a) & (c < b);
    c = select(open, select(inside, c, 0.5 * (a + b)), root.delta);
    const vd gc = evaluate_at(c, stress, Y);
    keep(open, c, stress, Y);
    const vmask low = open & (gc > 0.0);
    const vmask high = open & ~low;
    a = select(low, c, a);
    ga = select(low, gc, ga);
    b = select(high, c, b);
    gb = select(high, gc, gb);
    gb = select(low & last_low, 0.5 * gb, gb);
    ga = select(high & last_high, 0.5 * ga, ga);
    last_low = low;
    last_high = high;
    open = open & (abs(gc) > tolerance) & (b - a > 4e-16 * b);
  }
  return root;
}

TensorDamage::Update TensorDamage::update(const Sym3<vd>& strain_start, const Sym3<vd>& strain,
                                          Sym3<vd>& damage, vmask active, vd strength,
                                          double growth) const {
  const vd zero{};
  const Sym3<vd> none{zero, zero, zero, zero, zero, zero};
  State state = evaluate(strain, damage);
  const vd B_scale = strength / max(tension_weight(state.stress_e), splat(1e-300));
  const vd B = B_scale * threshold(damage);

  Update u;
  u.failed = u.grown = splat_mask(false);
  u.dissipated = u.released = zero;
  u.stress = blend(active, state.stress, none);
  // Cutting the negative part of Y only shortens it: no eigenvalues below the surface.
  const vd limit2 = 2.0 * B * B * (1.0 + 2e-14);
  vmask exceeds = active & (contract(state.Y, state.Y) > limit2);
  if (!any(exceeds)) return u;
  const vd Yeq = drive_by(state.Y);
  exceeds = exceeds & (Yeq > B * (1.0 + 1e-14));
  if (!any(exceeds)) return u;
  u.grown = exceeds;

  const vd trial = 0.5 * contract(state.stress, strain_start);
  const vd g0 = Yeq - B;
  const auto unit = [&](const Sym3<vd>& Y) { return (1.0 / max(sqrt(contract(Y, Y)), splat(1e-300))) * Y; };
  Sym3<vd> N = unit(state.Y);
  const vmask near = p_.monotone ? exceeds & (Yeq < kNearSurface * B) : splat_mask(false);

  Sym3<vd> D = damage;
  vmask open = exceeds;
  vd delta = zero;
  for (int it = 0; it < kDirectionIterations && any(open); ++it) {
    // In uniaxial strain Yeq falls linearly with 1 - D: the first guess is its root. Later
    // directions differ little.
    const vd intact = 1.0 - (D.xx * N.xx * N.xx + D.yy * N.yy * N.yy + D.zz * N.zz * N.zz);
    const vd guess = (it == 0 ? intact * (1.0 - B / Yeq) : delta) * 1.0000001;
    const Root root = first_root(strain, damage, N, g0, B_scale, guess, near & (guess > 0.0), open);
    delta = select(open, root.delta, delta);
    D = blend(open, damage + root.delta * N, D);
    u.failed |= root.missing & open;
    state.stress = blend(open, root.stress, state.stress);
    const Sym3<vd> N_end = unit(root.Y);
    const Sym3<vd> change = N_end - N;
    const vmask settled = contract(change, change) < kDirectionTolerance * kDirectionTolerance;
    open = open & ~root.missing & ~settled;
    N = blend(open, N_end, N);
  }
  if (growth < 1.0) {
    const Sym3<vd> part = damage + splat(growth) * (D - damage);
    u.failed = exceeds & (u.failed | at_cutoff(D)) & at_cutoff(part, kViscousFailure);
    D = blend(u.failed, D, part);
    state.stress = evaluate(strain, D).stress;
  }
  u.failed |= exceeds & at_cutoff(D);
  damage = blend(exceeds, D, damage);
  const vd kept = 0.5 * contract(state.stress, strain_start);
  u.dissipated = select(exceeds, trial - kept, zero);
  u.released = select(u.failed, kept, zero);
  u.stress = blend(active & ~u.failed, state.stress, none);
  return u;
}

}  // namespace mpdem
