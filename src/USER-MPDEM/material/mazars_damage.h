// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Scalar damage of Mazars with its two parameters for tension, eight points at a time:
//
//   stress       sigma = (1 - d) C : eps
//   drive        Yeq = sqrt(sum <e_i>_+^2) of the principal strains e_i, the equivalent strain
//   surface      F = Yeq - B,  B = s k,  k = max(kappa, kappa0),  s the strength of the point
//   state        kappa = the largest Yeq/s so far, 0 while it has not passed kappa0
//   damage       d = 1 - (1 - At) kappa0/k - At exp(-Bt (k - kappa0))
//   failure      d reaches the cut-off: stress zero from then on
//
// J. Mazars, Eng. Fract. Mech. 25 (1986) 729. His second pair of parameters, for compression, is left out: damage of
// compressed cement comes from the strain across the load. The stiffness does not recover in compression. A weaker
// point (s below 1) has the same curve with all strains multiplied by s.
#ifndef MPDEM_MATERIAL_MAZARS_DAMAGE_H
#define MPDEM_MATERIAL_MAZARS_DAMAGE_H

#include <algorithm>
#include <cmath>

#include "../numerics/eigen3.h"
#include "../numerics/text_of.h"
#include "law.h"

namespace mpdem {

class MazarsDamage final : public LawOf<MazarsDamage> {
 public:
  static constexpr const char* kName = "mazars";
  static constexpr int kFields = 1, kDegree = 1;
  struct State {
    vd kappa;
  };

  static std::vector<LawOption> words() {
    return {{"kappa0", is_positive, "must be greater than 0", "the equivalent strain at which damage starts", {}},
            {"At", is_in_0_1_with_1, "must lie in (0, 1]", "the share of the strength that softens to nothing", {}},
            {"Bt", is_positive, "must be greater than 0", "the rate of softening, one over a strain", {}},
            {"cutoff", is_inside_0_1, "must lie between 0 and 1, both excluded", "", {}},
            {"interface", is_positive, "must be greater than 0", "", {}}};
  }

  MazarsDamage(const VtiElasticity& elasticity, const LawValues& values)
      : LawOf(elasticity),
        kappa0_(values.get("kappa0", 0.0)),
        At_(values.get("At", 1.0)),
        Bt_(values.get("Bt", 0.0)),
        cutoff_(values.get("cutoff", 0.9)),
        interface_(values.get("interface", 1.0)),
        kappa_at_cutoff_(kappa_of(cutoff_)) {}

  std::vector<double> values() const override { return {kappa0_, At_, Bt_, cutoff_, interface_}; }
  double threshold() const { return kappa0_; }
  double softening() const { return 0.0; }  // one curve for all points
  double lowest_threshold() const { return kappa0_; }
  double interface() const { return interface_; }
  double growth(double) const { return 1.0; }
  double cutoff() const override { return cutoff_; }

  // Strength for uniaxial stress along a direction of modulus E. Yeq is the strain if the strains across it are not positive.
  ImpliedStrength implied_strength(double E) const override {
    const double peak = std::clamp(1.0 / Bt_, kappa0_, kappa_at_cutoff_);
    return {E * std::max(kappa0_, (1.0 - damage_at(peak)) * peak), kappa0_, kappa_at_cutoff_, E * work(kappa_at_cutoff_)};
  }
  std::string advice_on_strain() const override {
    return text_of("with kappa0 ", kappa0_, ", At ", At_, ", Bt ", Bt_, " and cut-off ", cutoff_,
                   ": check kappa0, a strain, and Bt, one over a strain");
  }
  std::string report(double cell) const override {
    const std::string parameters = text_of("  damage    mazars: kappa0 ", kappa0_, ", At ", At_, ", Bt ", Bt_, ", cut-off ", cutoff_,
                                           ", interface ", interface_, "\n", report_of_strength());
    if (length() > 0.0) return parameters + report_of_band(cell);
    const double band = localisation_cells();
    return text_of(parameters, "  implies   energy per crack area ",
                   implied_strength(elasticity().constants.Ez).work_per_volume * band * cell, " for a crack ", band,
                   " cells wide: it is proportional to the cell\n");
  }
  // Curve of uniaxial tension: strain over stress is 1/(1 - d), and the threshold of the strain is kappa/kappa0.
  std::optional<SofteningCurve> softening_curve() const override {
    const auto log_kappa = [law = *this](double x) { return std::log(law.kappa_of(-std::expm1(-x)) / law.kappa0_); };
    const double step = 1e-4;
    return SofteningCurve{[](double x) {
                            return SofteningCurve::Value{x, 1.0};
                          },
                          [log_kappa, step](double x) {
                            return SofteningCurve::Value{
                                x > 0.0 ? log_kappa(x) : 0.0,
                                (log_kappa(x + step) - log_kappa(std::max(x - step, 0.0))) / (step + std::min(x, step))};
                          }};
  }

  // Width of the band in cells, as localisation_cells() of tensor_damage.h: when the two layers of points beside a
  // crack fail, the next two have reached a third of the strain.
  double localisation_cells() const {
    const double third = kappa_at_cutoff_ / 3.0, spent = work(third) - 0.5 * (1.0 - damage_at(third)) * third * third;
    return 1.0 + spent / work(kappa_at_cutoff_);
  }

  std::vector<std::string> columns() const override { return {"kappa"}; }
  vd column(int, const Sym3<vd>&, State s) const { return s.kappa; }
  void state_from_tensor(const double* D, double* state) const override {
    double off = 0.0;
    for (int i = 0; i < 6; ++i) off = std::max(off, std::fabs(D[i] - (i < 3 ? D[0] : 0.0)));
    if (off > 1e-9) throw std::domain_error("and the damage tensor is not the same in all directions, as that of 'damage mazars' is");
    if (!(D[0] >= 0.0 && D[0] < 1.0)) throw std::domain_error("outside the range of 'damage mazars', 0 to below 1");
    state[0] = D[0] > 0.0 ? kappa_of(D[0]) : 0.0;
  }

  static vd square_bound(const Sym3<vd>&, const Sym3<vd>& strain) { return contract(strain, strain); }
  static vd rough_bound(const Sym3<vd>& stress, const Sym3<vd>& strain) { return square_bound(stress, strain); }

  static vd undamaged_drive(const Sym3<vd>& strain) { return equivalent(strain); }
  LawDrive drive(const Sym3<vd>& strain, State s, vd = vd{}) const { return {equivalent(strain), max(s.kappa, splat(kappa0_))}; }
  Sym3<vd> stress(const Sym3<vd>& strain, State s) const { return (1.0 - largest_damage(s)) * elasticity().stress(strain); }
  vd largest_damage(State s) const {
    return map_lanes(s.kappa, [this](double k) { return damage_at(k); });
  }
  Sym3<vd> damage(State s) const {
    const vd d = largest_damage(s);
    return {d, d, d, vd{}, vd{}, vd{}};
  }
  Sym3<vd> opening(const Sym3<vd>& strain, State) const { return strain; }

  LawTrial trial(const Sym3<vd>& strain, State s, vd = vd{}) const {
    return {stress(strain, s), contract(strain, strain), max(s.kappa, splat(kappa0_))};
  }

  // Step of the damage, in closed form. The energies are those of TensorDamage::update. Their sum balances to second
  // order of the step.
  LawUpdate update(const Sym3<vd>& strain_start, const Sym3<vd>& strain, State& s, vmask active, vd strength, double, vd = vd{}) const {
    LawUpdate u;
    const vd kappa = equivalent(strain) / strength;
    u.grown = active & (kappa > max(s.kappa, splat(kappa0_)));
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

  // Damage d of an equivalent strain. It is exactly 0 up to kappa0.
  double damage_at(double kappa) const {
    const double k = std::max(kappa, kappa0_), share = kappa0_ / k;
    return 1.0 - share + At_ * (share - std::exp(-Bt_ * (k - kappa0_)));
  }

 private:
  static vd equivalent(const Sym3<vd>& strain) {
    const Sym3<vd> p = positive_part(strain);
    return sqrt(contract(p, p));
  }

  // Inverts damage_at() by bisection, since d rises with kappa.
  double kappa_of(double d) const {
    double low = kappa0_, high = 2.0 * kappa0_;
    while (damage_at(high) < d) high *= 2.0;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (low + high);
      if (middle == low || middle == high) break;
      (damage_at(middle) < d ? low : high) = middle;
    }
    return high;
  }

  // Work of uniaxial stress up to strain e, over E.
  double work(double e) const {
    if (e <= kappa0_) return 0.5 * e * e;
    const double left = std::exp(-Bt_ * (e - kappa0_));
    return 0.5 * kappa0_ * kappa0_ + (1.0 - At_) * kappa0_ * (e - kappa0_) +
           At_ * ((kappa0_ - left * e) / Bt_ + (1.0 - left) / (Bt_ * Bt_));
  }

  double kappa0_, At_, Bt_, cutoff_, interface_;
  double kappa_at_cutoff_;
};

}  // namespace mpdem

#endif
