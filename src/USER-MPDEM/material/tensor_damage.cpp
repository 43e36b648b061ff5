// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "tensor_damage.h"

#include <cmath>
#include <stdexcept>

#include "../numerics/text_of.h"

namespace mpdem {

namespace {

// Energy that a volume has spent on the damage D = 1 - keep, over sqrt(2) B0.
double spent_work(double m, double keep) {
  const double log_keep = std::log(keep), x = (1.0 - m) * log_keep;
  // -log_keep (e^x - 1)/x tends to -log_keep at m = 1.
  return std::fabs(x) < 1e-12 ? -log_keep : -log_keep * std::expm1(x) / x;
}

// Work on a volume that is pulled to failure, over sqrt(2) B0.
double band_work(double m, double Dcut) { return spent_work(m, 1.0 - Dcut) + 0.5 * std::exp((1.0 - m) * std::log(1.0 - Dcut)); }

// Finds m in (-1,3) at which the rising function work(m) is `wanted`. Returns false if there is none. least, most: range of work(m).
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

// a^y for a > 0 with a relative error of 1e-4, for bounds. The logarithm is a series about sqrt(2), and 2^f has its own
// series.
vd rough_power(vd a, vd y) {
  const vmask bits = reinterpret_cast<vmask>(a), one = splat_mask(false) + 0x3ff0000000000000;
  const vd mantissa = reinterpret_cast<vd>((bits & 0x000fffffffffffff) | one);
  const vd whole = __builtin_convertvector((bits >> 52) - 1023, vd);
  const vd s = (mantissa - M_SQRT2) / (mantissa + M_SQRT2), s2 = s * s;
  const vd z = y * (whole + 0.5 + (2.0 / M_LN2) * s * (1.0 + s2 * (1.0 / 3.0 + 0.2 * s2)));
  const double shifter = 0x1.8p52;  // its sum with z has the nearest whole number in its last bits
  const vd shifted = z + shifter, f = M_LN2 * (z - (shifted - shifter));
  const vd power = 1.0 + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0)))));
  return reinterpret_cast<vd>(reinterpret_cast<vmask>(power) + (reinterpret_cast<vmask>(shifted) << 52));
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
    throw std::domain_error(text_of("the fracture energy ", G_f, " cannot be spent on a band of width ", band,
                                    ": with this B0 and cut-off the width must lie between ", G_f / (energy * most), " and ",
                                    G_f / (energy * least)));
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
    throw std::domain_error(text_of("the fracture energy ", G_f, " cannot be spent on a crack in cells of ", cell,
                                    ": with this B0 and cut-off it must lie between ", energy * cell * least, " and ", energy * cell * most,
                                    ", or for this energy the cell between ", G_f / (energy * most), " and ", G_f / (energy * least)));
  }
  return m;
}

SofteningCurve softening_curve(const DamageParameters& p) {
  const double rate = 0.5 * (1.0 + p.exponent);
  return {[](double x) { return SofteningCurve::Value{2.0 * x, 2.0}; }, [rate](double x) { return SofteningCurve::Value{rate * x, rate}; }};
}

double nonlocal_exponent(const DamageParameters& p, double G_f, double length, double most_times) {
  // Outside this range the band is not resolved by cells of the length, or is as wide as nine lengths.
  constexpr double kLeast = -0.5, kMost = 2.0;
  const double unit = std::sqrt(2.0) * p.B0 * length;
  const auto log_energy = [&p](double m) {
    DamageParameters q = p;
    q.exponent = m;
    const std::optional<Localisation> band = localise(softening_curve(q), q.Dcut);
    if (!band)
      throw std::domain_error(
          text_of("with the cut-off ", p.Dcut,
                  " the band of a crack has no width: strains in it would be too far above those beside it; use 'cutoff 0.999' or less"));
    return std::log(band->energy);
  };
  const double wanted = std::log(G_f / unit);
  double lo = kLeast, hi = kMost, at_lo = log_energy(lo), at_hi = log_energy(hi);
  if (!(wanted >= at_lo && wanted + std::log(most_times) <= at_hi)) {
    throw std::domain_error(text_of("the fracture energy ", G_f, " cannot be spent on a crack with the length ", length,
                                    ": with this B0 and cut-off it must lie between ", unit * std::exp(at_lo), " and ",
                                    unit * std::exp(at_hi) / most_times, ", or for this energy the length between ",
                                    length * most_times * std::exp(wanted - at_hi), " and ", length * std::exp(wanted - at_lo)));
  }
  // The logarithm is nearly a straight line, so this uses secants, with a bisection every third time.
  double m = lo;
  for (int k = 0; k < 40 && hi - lo > 1e-7; ++k) {
    const double secant = at_hi > at_lo ? lo + (hi - lo) * (wanted - at_lo) / (at_hi - at_lo) : lo;
    m = k % 3 == 2 ? 0.5 * (lo + hi) : secant;
    const double here = log_energy(m);
    if (std::fabs(here - wanted) < 1e-7) break;
    (here < wanted ? lo : hi) = m;
    (here < wanted ? at_lo : at_hi) = here;
  }
  return m;
}

// The energy of a crack in cells goes with localisation_cells() band_work(). An exponent of 0 or more stays so, since the search for
// the new damage is that of thresholds that do not fall (return_map.cpp).
double TensorDamage::softening_for(double times) const {
  const auto work = [&](double x) {
    DamageParameters q = p_;
    q.exponent = x;
    return localisation_cells(q) * band_work(x, p_.Dcut);
  };
  double least, most, m = 0.0;
  const double floor = p_.exponent >= 0.0 ? 0.0 : -1.0 + 1e-9, ceiling = 3.0 - 1e-9;
  if (find_exponent(work, times * work(p_.exponent), least, most, m)) return std::max(m, floor);
  return times < 1.0 ? floor : ceiling;
}

std::vector<LawOption> TensorDamage::words() {
  return {{"B0", is_positive, "must be greater than 0", "the energy per volume at which damage starts", {}},
          {"cutoff", is_inside_0_1, "must lie between 0 and 1, both excluded", "", {}},
          {"evolution", nullptr, "", "", {"monotone", "full"}},
          {"zeta", is_in_0_1_with_1, "tensile over compressive strength, must lie in (0, 1]", "", {}},
          {"interface", is_positive, "must be greater than 0", "", {}},
          {"viscosity", is_not_negative, "must be at least 0, which is none", "", {}}};
}

TensorDamage::TensorDamage(const VtiElasticity& elasticity, const LawValues& values) : LawOf(elasticity) {
  p_.B0 = values.get("B0", p_.B0);
  p_.Dcut = values.get("cutoff", p_.Dcut);
  p_.monotone = values.get("evolution", 0) == 0.0;
  p_.zeta = values.get("zeta", p_.zeta);
  p_.interface = values.get("interface", p_.interface);
  p_.viscosity = values.get("viscosity", p_.viscosity);
  surface_band_ = SurfaceBand(p_.exponent);
}

std::string TensorDamage::advice_on_strain() const {
  const VtiConstants& c = elasticity().constants;
  return text_of("with B0 ", p_.B0, " and moduli ", c.Ez, " and ", c.Ep,
                 ": check the units, which are those of pressure for all of them (Pa, not GPa, with 'units si')");
}

std::string TensorDamage::report(double cell) const {
  std::string text = text_of("  damage    B0 ", p_.B0, ", cut-off ", p_.Dcut, p_.monotone ? ", evolution monotone" : ", evolution full",
                             ", zeta ", p_.zeta, ", interface ", p_.interface, ", viscosity ", p_.viscosity, ", crack band exponent ",
                             p_.exponent, "\n", report_of_strength());
  if (length() > 0.0) return text + report_of_band(cell);
  const double band = localisation_cells(p_);
  return text + text_of("  implies   energy per crack area ", implied_strength(elasticity().constants.Ez).work_per_volume * band * cell,
                        " for a crack ", band,
                        crack_energy_ > 0.0 ? " cells wide\n" : " cells wide: without regularization it is proportional to the cell\n");
}

void TensorDamage::set_nonlocal(double length, double G_f) {
  Law::set_nonlocal(length, G_f);
  if (G_f > 0.0) p_.exponent = nonlocal_exponent(p_, G_f, length, kBandsOfSurface);
  crack_energy_ = G_f;
  // Without a given energy there is none to keep at surfaces, so all points have the same exponent.
  surface_band_ = length > 0.0 && G_f > 0.0 ? SurfaceBand(p_, length) : SurfaceBand(p_.exponent);
}

void TensorDamage::set_crack_energy(double G_f, double cell) {
  p_.exponent = crack_cell_exponent(p_, G_f, cell);
  crack_energy_ = G_f;
  surface_band_ = SurfaceBand(p_.exponent);
}

void TensorDamage::state_from_tensor(const double* D, double* state) const {
  for (int i = 0; i < kFields; ++i) state[i] = D[i];
}

TensorDamage::Evaluation TensorDamage::evaluate(const Sym3<vd>& strain, const Sym3<vd>& damage) const {
  const EffectiveStrain<vd> effective(damage);
  const Mat3<vd> phi_strain = effective.amplified(strain);
  const Sym3<vd> stress_e = elasticity().stress(effective.reduced(phi_strain));
  const Mat3<vd> phi_stress = effective.amplified(stress_e);
  return {effective, phi_strain, phi_stress, stress_e, effective.reduced(phi_stress), sym_product_transposed(phi_stress, phi_strain)};
}

Sym3<vd> TensorDamage::derivative_of_Y(const Evaluation& s, const Sym3<vd>& N) const {
  const Sym3<vd>& K = s.effective.K();
  // Derivatives along N, with dA = -N. That of phi eps_e is W. It is skew, since the symmetric part of phi eps_e is the strain. W makes
  // the derivative A W - N phi eps_e of eps_e symmetric. Q is the derivative of phi sigma, by the same condition on that of sigma.
  const Mat3<vd> NP = product(N, s.phi_strain), NQ = product(N, s.phi_stress);
  const Mat3<vd> W = plus(Sym3<vd>{}, K * twice_axial(NP));
  const Sym3<vd> stress_e = elasticity().stress(symmetric_product(s.effective.A(), W) - upper(NP));
  const Mat3<vd> Q = plus(stress_e, K * (commutator(stress_e, s.effective.A()) + twice_axial(NQ)));
  return sym_product_transposed(Q, s.phi_strain) + sym_product_transposed(s.phi_stress, W);
}

vd TensorDamage::drive_by(Sym3<vd>& Y) const {
  if (p_.monotone) Y = positive_part(Y);
  return sqrt(0.5 * contract(Y, Y));
}

vd TensorDamage::tension_weight(const Sym3<vd>& stress_e) const {
  if (p_.zeta == 1.0) return splat(1.0);
  const vd positive = trace(positive_part(stress_e)), total = 2.0 * positive - trace(stress_e);
  const vd r = select(total > 0.0, positive / max(total, splat(1e-300)), splat(1.0));
  return r + (1.0 - r) * (p_.zeta * p_.zeta);
}

vd TensorDamage::threshold(const Sym3<vd>& damage, vd m) const {
  if (!any(m != 0.0)) return splat(p_.B0);
  const vd keep = 1.0 - largest_eigenvalue(damage);
  vd power;
  for (int l = 0; l < kLanes; ++l) power[l] = std::pow(keep[l], -m[l]);
  return p_.B0 * power;
}

Sym3<vd> TensorDamage::stress(const Sym3<vd>& strain, const Sym3<vd>& damage) const {
  // The call is the same as in update(), so a state gives bitwise the same stress there and here.
  return evaluate(strain, damage).stress;
}

TensorDamage::Trial TensorDamage::trial(const Sym3<vd>& strain, const Sym3<vd>& damage, vd softening) const {
  const Evaluation s = evaluate(strain, damage);
  // Without its negative part Y is only shorter, and the tension weight is at most one. So the bounds need no eigenvalues.
  return {s.stress, 0.5 * contract(s.Y, s.Y), least_threshold(damage, softening)};
}

// Lower bound of B without eigenvalues. It is exact to a thousandth if D has one principal value.
vd TensorDamage::least_threshold(const Sym3<vd>& D, vd m) const {
  if (!any(m != 0.0)) return splat(p_.B0);
  const vd square = contract(D, D), sum = max(trace(D), splat(1e-300));
  // sum d_i^2 / sum d_i is at most the largest d_i >= 0, and that is at most the norm.
  const vd some = p_.monotone ? square / sum : max(max(D.xx, D.yy), D.zz);
  const vd keep = 1.0 - select(m > 0.0, max(some, vd{}), sqrt(square));
  return (0.999 * p_.B0) * rough_power(max(keep, splat(1e-6)), -m);
}

vd TensorDamage::undamaged_drive(const Sym3<vd>& strain) const {
  const Sym3<vd> stress = elasticity().stress(strain);
  const Sym3<vd> Y = sym_product(stress, strain);
  return tension_weight(stress) * sqrt(0.5 * (p_.monotone ? square_of_positive_part(Y) : contract(Y, Y)));
}

TensorDamage::Drive TensorDamage::drive(const Sym3<vd>& strain, const Sym3<vd>& damage, vd softening) const {
  Evaluation s = evaluate(strain, damage);
  return {tension_weight(s.stress_e) * drive_by(s.Y), threshold(damage, softening)};
}

}  // namespace mpdem
