// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Scalar damage with linear softening, eight points at a time. Under uniaxial stress the stress falls on a straight line
// from the strength at the strain e0 to nothing at the strain R e0. R is the ductility:
//
//   stress       sigma = (1 - d) C : eps
//   drive        Yeq = sqrt(sum <e_i>_+^2) of the principal strains e_i, the equivalent strain
//   surface      F = Yeq - B,  B = s k,  k = max(kappa, e0),  s the strength of the point
//   state        kappa = the largest Yeq/s so far, 0 while it has not passed e0
//   damage       d = R/(R - 1) (1 - e0/k)
//   failure      d reaches the cut-off: stress zero from then on
//
// The stiffness does not come back in compression. A weaker point (s below 1) has the same curve with all strains
// multiplied by s.
#ifndef MPDEM_MATERIAL_LINEAR_DAMAGE_H
#define MPDEM_MATERIAL_LINEAR_DAMAGE_H

#include <algorithm>
#include <cmath>

#include "../numerics/eigen3.h"
#include "../numerics/text_of.h"
#include "law.h"

namespace mpdem {

class LinearDamage final : public LawOf<LinearDamage> {
 public:
  static constexpr const char* kName = "linear";
  static constexpr int kFields = 1, kDegree = 1;
  struct State {
    vd kappa;
  };

  static std::vector<LawOption> words() {
    return {{"e0", is_positive, "must be greater than 0", "the equivalent strain at which damage starts", {}},
            {"ductility", [](double v) { return v > 1.0; }, "must be greater than 1", "the strain without stress over 'e0'", {}},
            {"cutoff", is_inside_0_1, "must lie between 0 and 1, both excluded", "", {}},
            {"interface", is_positive, "must be greater than 0", "", {}}};
  }

  LinearDamage(const VtiElasticity& elasticity, const LawValues& values)
      : LawOf(elasticity),
        e0_(values.get("e0", 0.0)),
        ductility_(values.get("ductility", 2.0)),
        cutoff_(values.get("cutoff", 0.9)),
        interface_(values.get("interface", 1.0)),
        kappa_at_cutoff_(kappa_of(cutoff_)) {}

  std::vector<double> values() const override { return {e0_, ductility_, cutoff_, interface_}; }
  double threshold() const { return e0_; }
  double softening() const { return 0.0; }  // one curve for all points
  double lowest_threshold() const { return e0_; }
  double interface() const { return interface_; }
  double growth(double) const { return 1.0; }
  double cutoff() const override { return cutoff_; }

  // For uniaxial stress along a direction of modulus E. Yeq is the strain if the strains across it are not positive.
  ImpliedStrength implied_strength(double E) const override {
    const double ef = ductility_ * e0_, to = kappa_at_cutoff_, passed = to - e0_;
    const double work = 0.5 * e0_ * e0_ + e0_ * passed * (ef - 0.5 * (to + e0_)) / (ef - e0_);
    return {E * e0_, e0_, to, E * work};
  }
  std::string advice_on_strain() const override {
    return text_of("with e0 ", e0_, ", ductility ", ductility_, " and cut-off ", cutoff_,
                   ": check e0, a strain, and the ductility, a ratio of strains");
  }
  std::string report(double cell) const override {
    return text_of("  damage    linear, e0 ", e0_, ", ductility ", ductility_, ", cut-off ", cutoff_, ", interface ", interface_, "\n",
                   report_of_strength(), length() > 0.0 ? report_of_band(cell) : "");
  }

  std::vector<std::string> columns() const override { return {"kappa"}; }
  vd column(int, const Sym3<vd>&, State s) const { return s.kappa; }
  void state_from_tensor(const double* D, double* state) const override {
    double off = 0.0;
    for (int i = 0; i < 6; ++i) off = std::max(off, std::fabs(D[i] - (i < 3 ? D[0] : 0.0)));
    if (off > 1e-9) throw std::domain_error("and the damage tensor is not the same in all directions, as that of 'damage linear' is");
    if (!(D[0] >= 0.0 && D[0] < 1.0)) throw std::domain_error("outside the range of 'damage linear', 0 to below 1");
    state[0] = D[0] > 0.0 ? kappa_of(D[0]) : 0.0;
  }

  static vd square_bound(const Sym3<vd>&, const Sym3<vd>& strain) { return contract(strain, strain); }
  static vd rough_bound(const Sym3<vd>& stress, const Sym3<vd>& strain) { return square_bound(stress, strain); }

  static vd undamaged_drive(const Sym3<vd>& strain) {
    const Sym3<vd> p = positive_part(strain);
    return sqrt(contract(p, p));
  }
  LawDrive drive(const Sym3<vd>& strain, State s, vd = vd{}) const { return {undamaged_drive(strain), max(s.kappa, splat(e0_))}; }
  Sym3<vd> stress(const Sym3<vd>& strain, State s) const { return (1.0 - largest_damage(s)) * elasticity().stress(strain); }
  vd largest_damage(State s) const { return ductility_ / (ductility_ - 1.0) * (1.0 - e0_ / max(s.kappa, splat(e0_))); }
  Sym3<vd> damage(State s) const {
    const vd d = largest_damage(s);
    return {d, d, d, vd{}, vd{}, vd{}};
  }
  Sym3<vd> opening(const Sym3<vd>& strain, State) const { return strain; }

  LawTrial trial(const Sym3<vd>& strain, State s, vd = vd{}) const {
    return {stress(strain, s), contract(strain, strain), max(s.kappa, splat(e0_))};
  }

  // Step of the damage, in closed form. The sum of the energies balances to second order of the step.
  LawUpdate update(const Sym3<vd>& strain_start, const Sym3<vd>& strain, State& s, vmask active, vd strength, double, vd = vd{}) const {
    LawUpdate u;
    const vd kappa = undamaged_drive(strain) / strength;
    u.grown = active & (kappa > max(s.kappa, splat(e0_)));
    const Sym3<vd> before = stress(strain, s);
    u.failed = u.grown & (kappa >= kappa_at_cutoff_);
    s.kappa = select(u.grown, min(kappa, splat(kappa_at_cutoff_)), s.kappa);
    const Sym3<vd> after = stress(strain, s);
    const vd kept = 0.5 * contract(after, strain_start);
    u.dissipated = select(u.grown, 0.5 * contract(before, strain_start) - kept, vd{});
    u.released = select(u.failed, kept, vd{});
    u.stress = blend(active & ~u.failed, after, Sym3<vd>{});
    u.evaluations = 2;
    return u;
  }

 private:
  double kappa_of(double d) const { return e0_ * ductility_ / (ductility_ - d * (ductility_ - 1.0)); }

  double e0_, ductility_, cutoff_, interface_;
  double kappa_at_cutoff_;
};

}  // namespace mpdem

#endif
