// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "tensor_damage.h"

#include <cmath>

namespace mpdem {

namespace {

constexpr int kDirectionIterations = 3;
constexpr double kDirectionTolerance = 1e-10;
constexpr int kMarchSteps = 16;
// A trial state this close to the surface has a single root along Y (checked on 1200
// states); further out the march to the first root of the full range is needed.
constexpr double kNearSurface = 1.2;
constexpr double kRootTolerance = 2e-15;  // of B

Sym3<vd> blend(vmask m, const Sym3<vd>& a, const Sym3<vd>& b) {
  return {select(m, a.xx, b.xx), select(m, a.yy, b.yy), select(m, a.zz, b.zz),
          select(m, a.yz, b.yz), select(m, a.xz, b.xz), select(m, a.xy, b.xy)};
}

Sym3<vd> scaled(const Sym3<vd>& h, const Sym3<vd>& x) {
  return {h.xx * x.xx, h.yy * x.yy, h.zz * x.zz, h.yz * x.yz, h.xz * x.xz, h.xy * x.xy};
}

}  // namespace

ImpliedStrength implied_strength(const DamageParameters& p, double E) {
  const double e0 = std::pow(2.0, 0.25) * std::sqrt(p.B0 / E);
  const double m = p.exponent;
  const double keep = 1.0 - p.Dcut;
  const double spent = m == 1.0 ? -std::log(keep) : (1.0 - std::pow(keep, 1.0 - m)) / (1.0 - m);
  const double W = spent + 0.5 * std::pow(keep, 1.0 - m);
  return {E * e0, e0, e0 * std::pow(keep, -0.5 * (1.0 + m)), std::sqrt(2.0) * p.B0 * W};
}

TensorDamage::State TensorDamage::evaluate(const Sym3<vd>& strain, const Sym3<vd>& damage,
                                           bool want_weight) const {
  const Spectral d = eigen(damage);
  vd a[3];
  // The floor only keeps lanes outside the active set finite.
  for (int i = 0; i < 3; ++i) a[i] = max(1.0 - d.value[i], splat(1e-6));
  const auto harmonic = [&](int i, int j) { return 2.0 * a[i] * a[j] / (a[i] + a[j]); };
  const Sym3<vd> h{a[0], a[1], a[2], harmonic(1, 2), harmonic(0, 2), harmonic(0, 1)};

  const Sym3<vd> eps_e_local = scaled(h, rotate_back(d.axes, strain));
  const Sym3<vd> sigma_e = elasticity_.stress(rotate(d.axes, eps_e_local));
  const Sym3<vd> sigma_local = scaled(h, rotate_back(d.axes, sigma_e));

  Sym3<vd> Y = sym_product(sigma_local, eps_e_local);
  vd phi[3];
  for (int i = 0; i < 3; ++i) phi[i] = 1.0 / a[i];
  Y = scaled({phi[0] * phi[0], phi[1] * phi[1], phi[2] * phi[2], phi[1] * phi[2], phi[0] * phi[2],
              phi[0] * phi[1]},
             Y);
  if (p_.monotone) Y = positive_part(Y);

  State s;
  s.Yeq = sqrt(0.5 * contract(Y, Y));
  s.Y = rotate(d.axes, Y);
  s.stress = rotate(d.axes, sigma_local);
  s.largest_damage = largest(d);
  s.tension_weight = splat(1.0);
  if (want_weight && p_.zeta != 1.0) {
    const Spectral t = eigen(sigma_e);
    vd positive{}, total{};
    for (int i = 0; i < 3; ++i) {
      positive += max(t.value[i], vd{});
      total += abs(t.value[i]);
    }
    const vd r = select(total > 0.0, positive / max(total, splat(1e-300)), splat(1.0));
    s.tension_weight = r + (1.0 - r) * (p_.zeta * p_.zeta);
  }
  return s;
}

vd TensorDamage::threshold(vd largest_damage) const {
  if (p_.exponent == 0.0) return splat(p_.B0);
  const double m = p_.exponent;
  return p_.B0 * map_lanes(1.0 - largest_damage, [m](double a) { return std::pow(a, -m); });
}

Sym3<vd> TensorDamage::stress(const Sym3<vd>& strain, const Sym3<vd>& damage) const {
  return evaluate(strain, damage, false).stress;
}

TensorDamage::Drive TensorDamage::drive(const Sym3<vd>& strain, const Sym3<vd>& damage) const {
  const State s = evaluate(strain, damage, true);
  return {s.tension_weight * s.Yeq, threshold(s.largest_damage), s.largest_damage};
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

// First Delta in (0, limit] at which Yeq(D + Delta N) falls to B; lanes that stay above
// up to the limit are returned in no_root. g0 > 0 is the value at Delta = 0.
vd TensorDamage::first_root(const Sym3<vd>& strain, const Sym3<vd>& damage, const Sym3<vd>& direction, vd g0,
                            vd B_scale, vd guess, vd limit, vmask lanes, vmask& no_root) const {
  const auto g = [&](vd t) {
    const State s = evaluate(strain, damage + t * direction, false);
    return s.Yeq - B_scale * threshold(s.largest_damage);
  };
  const vd tolerance = kRootTolerance * p_.B0 * B_scale;

  // March outwards by constant factors until g changes sign.
  const double factor = std::pow(10.0, 6.0 / kMarchSteps);
  vd a{}, ga = g0, b = limit, gb = vd{};
  vd t = min(guess, limit);
  vmask open = lanes;
  no_root = splat_mask(false);
  for (int k = 0; any(open) && k < 60; ++k) {
    const vd gt = g(t);
    const vmask crossed = open & (gt <= 0.0);
    b = select(crossed, t, b);
    gb = select(crossed, gt, gb);
    const vmask above = open & ~crossed;
    a = select(above, t, a);
    ga = select(above, gt, ga);
    const vmask ended = above & (t >= limit);
    no_root |= ended;
    open = above & ~ended;
    t = min(factor * t, limit);
  }

  // Illinois steps inside the bracket; g is nearly linear in Delta, so a few suffice.
  // Bisection takes over should they stall.
  vd root = select(no_root, limit, b);
  open = lanes & ~no_root & (gb < -tolerance);
  vmask last_high = splat_mask(false), last_low = splat_mask(false);
  for (int k = 0; any(open) && k < 100; ++k) {
    vd c = k < 30 ? b - gb * (b - a) / min(gb - ga, splat(-1e-300)) : 0.5 * (a + b);
    const vmask inside = (c > a) & (c < b);
    c = select(inside, c, 0.5 * (a + b));
    const vd gc = g(c);
    root = select(open, c, root);
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
                                          Sym3<vd>& damage, vmask active) const {
  const vd zero{};
  const Sym3<vd> none{zero, zero, zero, zero, zero, zero};
  State state = evaluate(strain, damage, true);
  const vd B_scale = 1.0 / max(state.tension_weight, splat(1e-300));
  const vd B = B_scale * threshold(state.largest_damage);
  const vmask exceeds = active & (state.Yeq > B * (1.0 + 1e-14));

  Update u;
  u.grown = exceeds;
  u.failed = splat_mask(false);
  u.dissipated = u.released = zero;
  u.stress = blend(active, state.stress, none);
  if (!any(exceeds)) return u;

  const vd trial = 0.5 * contract(state.stress, strain_start);
  const vd g0 = state.Yeq - B;
  const auto unit = [&](const Sym3<vd>& Y) { return (1.0 / max(sqrt(contract(Y, Y)), splat(1e-300))) * Y; };
  Sym3<vd> N = unit(state.Y);
  const vmask near = p_.monotone ? exceeds & (state.Yeq < kNearSurface * B) : splat_mask(false);

  Sym3<vd> D = damage;
  vmask open = exceeds;
  vd delta = zero;
  for (int it = 0; it < kDirectionIterations && any(open); ++it) {
    const vd limit = largest_growth(damage, N);
    // In uniaxial strain Yeq falls linearly with 1 - D: the first guess is its root.
    const vd intact = 1.0 - (D.xx * N.xx * N.xx + D.yy * N.yy * N.yy + D.zz * N.zz * N.zz);
    vd guess = it == 0 ? intact * (1.0 - B / state.Yeq) * 1.0000001 : delta * 1.0000001;
    guess = select(near & (guess > 0.0), guess, 1e-6 * limit);
    vmask no_root;
    const vd found = first_root(strain, damage, N, g0, B_scale, guess, limit, open, no_root);
    delta = select(open, found, delta);
    D = blend(open, damage + found * N, D);
    u.failed |= no_root & open;
    state = evaluate(strain, D, false);
    const Sym3<vd> N_end = unit(state.Y);
    const Sym3<vd> change = N_end - N;
    const vmask settled = contract(change, change) < kDirectionTolerance * kDirectionTolerance;
    open = open & ~no_root & ~settled;
    N = blend(open, N_end, N);
  }
  u.failed |= exceeds & (state.largest_damage >= p_.Dcut * (1.0 - 1e-12));
  damage = blend(exceeds, D, damage);
  const vd kept = 0.5 * contract(state.stress, strain_start);
  u.dissipated = select(exceeds, trial - kept, zero);
  u.released = select(u.failed, kept, zero);
  u.stress = blend(active & ~u.failed, state.stress, none);
  return u;
}

}  // namespace mpdem
