// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Bilinear cohesive law with damage: springs that soften beyond a strength and debond once they have dissipated an
// energy per area.
//
//   opening      lambda^2 = <delta_n>^2 + (kt/kn) delta_t^2,  <.> the positive part
//   mixed mode   B = (kt/kn) delta_t^2/lambda^2, from 0 for opening to 1 for shear: the share of shear in the energy
//   onset        lambda0 by (kn lambda0)^2 ((1 - B)/tn^2 + B (kt/kn)/tt^2) = 1
//   end          lambdaf = 2 G/(kn lambda0) with 1/G = (1 - B)/Gn + B/Gt
//   damage       d = lambdaf (lambda - lambda0)/(lambda (lambdaf - lambda0)), from 0 to 1; it never falls
//   traction     (1 - d) of the penalty, 1 - d/2 of it under compression; none once d is 1
//                released: kn <-delta_n>^2/4 times the change of d by shear, and kn <-delta_n>^2/4 when d reaches 1
//   dissipated   by a step of damage at one mode, in closed form: G lambda0 d/(lambdaf - d (lambdaf - lambda0))
//
// Stiffness under compression falls to a half, since added mass (added_mass.h) makes a node that only links connect
// just stable. A fragment that bounces between a closed link of full stiffness and an open soft link would get three
// times its energy in each bounce, averaged over the phases of the steps. With half the stiffness the factor is 1.01.
//
// So a link carries at most tn and dissipates Gn under opening, and tt and Gt under shear, however large the steps are.
// The onset is the quadratic criterion of stress, the end the linear criterion of energies. Both are written in the
// opening of Camacho & Ortiz (Int. J. Solids Struct. 33 (1996) 2899), with the damage of Turon, Camanho, Costa & Davila
// (Mech. Mater. 38 (2006) 1072).
#ifndef MPDEM_COUPLING_COHESIVE_TRACTION_H
#define MPDEM_COUPLING_COHESIVE_TRACTION_H

#include <algorithm>

#include "../numerics/text_of.h"
#include "traction_law.h"

namespace mpdem {

class CohesiveTraction final : public TractionLawOf<CohesiveTraction> {
 public:
  static constexpr const char* kName = "cohesive";
  static constexpr int kFields = 1;
  static constexpr bool kLeavesResidue = true;
  struct State {
    vd d;
  };

  static std::vector<LawOption> words() {
    const std::string positive = "must be greater than 0";
    return {{"tn", is_positive, positive, "the strength under opening, a pressure", {}},
            {"tt", is_positive, positive, "the strength under shear, a pressure", {}},
            {"Gn", is_positive, positive, "the energy per area that opening takes", {}},
            {"Gt", is_positive, positive, "the energy per area that shear takes", {}}};
  }

  CohesiveTraction(TractionStiffness stiffness, const LawValues& values)
      : TractionLawOf(stiffness),
        tn_(values.get("tn", 0.0)),
        tt_(values.get("tt", 0.0)),
        Gn_(values.get("Gn", 0.0)),
        Gt_(values.get("Gt", 0.0)) {
    constexpr double kRounding = 1e-9;
    const double least = (1.0 - kRounding) * std::min(tn_, tt_ * std::sqrt(stiffness.kn / stiffness.kt)) / stiffness.kn;
    least_square_ = least * least;
  }

  std::vector<double> parameters() const override { return {tn_, tt_, Gn_, Gt_}; }
  // Uses the softer direction of the material.
  std::vector<SofteningLength> softening_lengths(const VtiConstants& e) const override {
    const double E = std::min(e.Ep, e.Ez), G = std::min(e.Gzp, 0.5 * e.Ep / (1.0 + e.nu_p));
    return {{E * Gn_ / (tn_ * tn_), "E Gn/tn^2", "a larger 'Gn' or a smaller 'tn'"},
            {G * Gt_ / (tt_ * tt_), "G Gt/tt^2", "a larger 'Gt' or a smaller 'tt'"}};
  }
  // The elastic energy at the strength must be below G in each mode. Mixed modes satisfy this if both pure modes do.
  std::string trouble() const override {
    const double of_n = 0.5 * tn_ * tn_ / stiffness().kn, of_t = 0.5 * tt_ * tt_ / stiffness().kt;
    const auto told = [](const char* G, double value, double least, const char* t, const char* k) {
      return text_of("'", G, " ", value, "' must be above ", least, ", the energy that the links store at '", t, "'; use a larger '", G,
                     "', a smaller '", t, "' or a larger '", k, "'");
    };
    if (!(Gn_ > of_n)) return told("Gn", Gn_, of_n, "tn", "kn");
    if (!(Gt_ > of_t)) return told("Gt", Gt_, of_t, "tt", "kt");
    return "";
  }

  TractionSecant secant(const LinkSeparation& delta, State s) const {
    const vd left = 1.0 - s.d;
    const vd closed = select(s.d < 1.0, 1.0 - kSoftClosed * s.d, vd{});
    return {stiffness().kn * select(delta.n < 0.0, closed, left), stiffness().kt * left};
  }
  vd energy(const LinkSeparation& delta, State s) const { return secant(delta, s).energy(delta); }

  vd onset_share(const LinkSeparation& delta) const {
    const vd open = stiffness().kn * max(delta.n, vd{});
    return sqrt(open * open / (tn_ * tn_) + stiffness().kt * stiffness().kt * delta.tangential_square() / (tt_ * tt_));
  }

  TractionUpdate update(const LinkSeparation& delta, State& s) const {
    const double kn = stiffness().kn, ratio = stiffness().kt / kn;
    const vd open = max(delta.n, vd{}), shear = ratio * delta.tangential_square(), square = open * open + shear;
    if (!any(square > least_square_)) return {vd{}, splat_mask(false), splat_mask(false)};
    const vd B = select(square > 0.0, shear / square, vd{});
    const vd onset = 1.0 / (kn * sqrt((1.0 - B) / (tn_ * tn_) + ratio * B / (tt_ * tt_)));
    const vd G = 1.0 / ((1.0 - B) / Gn_ + B / Gt_);
    const vd end = 2.0 * G / (kn * onset), soft = end - onset, lambda = sqrt(square);
    const vd d = select(lambda >= end, splat(1.0), end * (lambda - onset) / (lambda * soft));
    TractionUpdate u;
    u.grown = (lambda > onset) & (d > s.d);
    u.debond = u.grown & (d >= 1.0);
    const auto spent = [&](vd at) { return G * onset * at / (end - at * soft); };
    u.dissipated = select(u.grown, spent(d) - spent(s.d), vd{});
    s.d = select(u.grown, min(d, splat(1.0)), s.d);
    return u;
  }

 private:
  static constexpr double kSoftClosed = 0.5;  // share of the stiffness under compression that damage 1 takes
  double tn_, tt_, Gn_, Gt_;
  double least_square_;  // square of the separation lambda of update() below which no damage grows in any mode
};

}  // namespace mpdem

#endif
