// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Elastic cement, `damage none`: no state, no damage, no failure.
#ifndef MPDEM_MATERIAL_NO_DAMAGE_H
#define MPDEM_MATERIAL_NO_DAMAGE_H

#include <limits>

#include "law.h"

namespace mpdem {

class NoDamage final : public LawOf<NoDamage> {
 public:
  static constexpr const char* kName = "none";
  static constexpr int kFields = 0;
  struct State {};

  explicit NoDamage(const VtiElasticity& elasticity, const LawValues& = {}) : LawOf(elasticity) {}
  static std::vector<LawOption> words() { return {}; }

  std::vector<double> values() const override { return {}; }
  ImpliedStrength implied_strength(double) const override {
    const double infinite = std::numeric_limits<double>::infinity();
    return {infinite, infinite, infinite, infinite};
  }
  std::string report(double) const override { return "  damage    none\n"; }
  void state_from_tensor(const double* D, double*) const override {
    for (int i = 0; i < kMostFields; ++i)
      if (D[i] != 0.0) throw std::domain_error("which needs a law of damage, 'damage tensor' for instance");
  }

  Sym3<vd> stress(const Sym3<vd>& strain, State) const { return elasticity().stress(strain); }
  LawDrive drive(const Sym3<vd>&, State, vd = vd{}) const { return {vd{}, splat(1.0)}; }
  double interface() const { return 1.0; }
  double softening() const { return 0.0; }
  vd largest_damage(State) const { return vd{}; }
  Sym3<vd> damage(State) const { return Sym3<vd>{}; }
  Sym3<vd> opening(const Sym3<vd>& strain, State) const { return strain; }
  vd column(int, const Sym3<vd>&, State) const { return vd{}; }
};

}  // namespace mpdem

#endif
