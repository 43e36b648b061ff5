// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Second-order tensor damage by energy equivalence, eight points at a time. All tensors are in the co-rotated material
// frame.
//
//   effective strain  eps_e = M^-1 : eps, effective stress sigma_e = C0 : eps_e,
//   stress            sigma = M^-1 : sigma_e,   M : s = sym(phi s),  phi = (1 - D)^-1
//   conjugate force   Y = -d(rho psi)/dD = phi sym(sigma eps_e) phi
//   surface           F = s Yeq - B(D),  Yeq = sqrt(Y:Y/2),  B = B0 (1 - max eig D)^-m
//   growth            dD along Y (its positive part <Y>_+ with evolution `monotone`)
//   failure           max eig D reaches the cut-off Dcut (with viscosity: it aims at Dcut and
//                     has reached 0.99 Dcut; the rest is added then): stress zero from then on
//
// The effective stress is of Cordebois & Sidoroff type; Chow & Wang, Int. J. Fracture 33 (1987) 3. The tension weight
// is s = r + (1 - r) zeta^2, with r = sum<s_i>/sum|s_i| of the principal effective stresses (Lee & Fenves, J. Eng.
// Mech. 124 (1998) 892). It is frozen during the step and gives f_c = f_t/zeta. zeta = 1 is the symmetric law.
#ifndef MPDEM_MATERIAL_TENSOR_DAMAGE_H
#define MPDEM_MATERIAL_TENSOR_DAMAGE_H

#include <cmath>

#include "../numerics/eigen3.h"
#include "../numerics/simd.h"
#include "../numerics/tensor3.h"
#include "effective_strain.h"
#include "law.h"
#include "surface_band.h"
#include "vti_elasticity.h"

namespace mpdem {

struct DamageParameters {
  double B0 = 0.0;         // energy per volume, above 0
  double Dcut = 0.9;       // critical damage (`cutoff`), in (0, 1)
  double exponent = 0.0;   // m of the crack band, in (-1,3)
  double zeta = 1.0;       // f_t/f_c in (0,1]
  bool monotone = true;    // true: <Y>_+ drives the damage; false: Y itself
  double interface = 1.0;  // factor on B0 of points attached to a grain
  double viscosity = 0.0;  // relaxation time of damage growth (Duvaut-Lions), 0: none
};

// Exponent m that spends G_f on a crack of width `band`:
//   sqrt(2) B0 band W(m) = G_f,  W(m) = [1-(1-Dcut)^(1-m)]/(1-m) + (1-Dcut)^(1-m)/2,
// after Bazant & Oh, Mater. Struct. 16 (1983) 155. Throws std::domain_error, with the range of bands that G_f allows,
// if there is no exponent in (-1,3).
double crack_band_exponent(const DamageParameters& p, double G_f, double band);

// Width of the band, in cells, in which a solid breaks across a grid axis. It holds for quadratic B-splines with two
// points in a cell in each direction. The narrowest strain that the splines have is a hat of two cells, on a face
// between the halves of two cells: 3/4 of its top in the two nearest layers of points, and 1/4 in the next two. The
// nearest layers fail together. The next two get the damage of a third of the strain at failure. A layer is half a cell
// wide. So with 1 - D = (e/e0)^(-2/(1+m)) the width is 1 + w/W, where w is the energy that a volume spends on D at
// e_f/3. Measured by tests/verification/softening_bar.py.
double localisation_cells(const DamageParameters& p);
// Exponent m that spends G_f on a crack of this width. Throws as crack_band_exponent() does.
double crack_cell_exponent(const DamageParameters& p, double G_f, double cell);

// Curve of uniaxial tension: strain over stress is (1 - D)^-2, and the threshold of the strain is (1 - D)^(-(1+m)/2).
SofteningCurve softening_curve(const DamageParameters& p);
// Half of the band of a crack along a grain lies in the grain. So the material there spends this many times the energy.
constexpr double kBandsOfSurface = 2.0;
// Exponent m, in [-1/2, 2], that spends G_f on a crack if strain is averaged over a length. Throws as
// crack_band_exponent() does, also if there is none for most_times times that energy.
double nonlocal_exponent(const DamageParameters& p, double G_f, double length, double most_times = 1.0);

// Strength by theory, for example s = E e0^4/e^3 past the onset for exponent 0.
ImpliedStrength implied_strength(const DamageParameters& p, double E);

class TensorDamage final : public LawOf<TensorDamage> {
 public:
  static constexpr const char* kName = "tensor";
  static constexpr int kFields = 6, kDegree = 2;
  using State = Sym3<vd>;  // D

  TensorDamage(const VtiElasticity& elasticity, const DamageParameters& parameters)
      : LawOf(elasticity), p_(parameters), surface_band_(parameters.exponent) {}
  TensorDamage(const VtiElasticity& elasticity, const LawValues& values);
  static std::vector<LawOption> words();

  const DamageParameters& parameters() const { return p_; }
  // Exponent of points whose position does not matter, and of points at these distances from the surfaces of their
  // grains.
  double softening() const { return p_.exponent; }
  double softening_at(double d0, double d1) const override { return surface_band_.exponent(d0, d1); }
  bool softens_by_position() const override { return surface_band_.depends_on_position(); }
  double softening_of_layer(double thickness) const override {
    const double energy = crack_energy_ > 0.0 ? crack_energy_ : surface_band_.energy();
    return energy > 0.0 ? exponent_of_layer(p_, energy, thickness) : p_.exponent;
  }
  double softening_for(double times) const override;
  bool can_scatter_energy() const override { return crack_energy_ > 0.0 && length() == 0.0; }
  double threshold() const { return p_.B0; }
  double lowest_threshold() const { return p_.exponent < 0.0 ? p_.B0 * std::pow(1.0 - p_.Dcut, -p_.exponent) : p_.B0; }
  double interface() const { return p_.interface; }
  double growth(double dt) const { return dt / (p_.viscosity + dt); }

  std::vector<double> values() const override { return {p_.B0, p_.Dcut, p_.monotone ? 0.0 : 1.0, p_.zeta, p_.interface, p_.viscosity}; }
  double cutoff() const override { return p_.Dcut; }
  ImpliedStrength implied_strength(double E) const override { return mpdem::implied_strength(p_, E); }
  std::string advice_on_strain() const override;
  std::string report(double cell) const override;
  bool has_crack_energy() const override { return true; }
  double crack_energy() const override { return crack_energy_; }
  void set_crack_energy(double G_f, double cell) override;
  std::optional<SofteningCurve> softening_curve() const override { return mpdem::softening_curve(p_); }
  void set_nonlocal(double length, double G_f) override;
  bool state_is_tensor() const override { return true; }
  void state_from_tensor(const double* D, double* state) const override;

  vd largest_damage(const Sym3<vd>& D) const { return largest(eigen(D)); }
  const Sym3<vd>& damage(const Sym3<vd>& D) const { return D; }
  const Sym3<vd>& opening(const Sym3<vd>&, const Sym3<vd>& D) const { return D; }
  vd column(int, const Sym3<vd>&, const Sym3<vd>&) const { return vd{}; }

  // Needs no eigenvalue, since dropping the negative part of Y only shortens it, and s <= 1.
  static vd square_bound(const Sym3<vd>& stress, const Sym3<vd>& strain) {
    const Sym3<vd> Y = sym_product(stress, strain);
    return 0.5 * contract(Y, Y);
  }
  // Uses |sym(a b)| <= |a| |b|, with a margin for rounding.
  static vd rough_bound(const Sym3<vd>& stress, const Sym3<vd>& strain) {
    constexpr double kHalf = 0.5 * (1.0 + 1e-12);
    return kHalf * contract(stress, stress) * contract(strain, strain);
  }

  vd undamaged_drive(const Sym3<vd>& strain) const;

  // Stress for given strain and damage. In lanes whose result is not used, D may be any tensor with eigenvalues below
  // one.
  Sym3<vd> stress(const Sym3<vd>& strain, const Sym3<vd>& damage) const;

  // Finds the stress, and bounds of Yeq and B. Points keep their damage if the bound of Yeq is below that of B.
  using Trial = LawTrial;
  Trial trial(const Sym3<vd>& strain, const Sym3<vd>& damage, vd softening) const;

  using Update = LawUpdate;

  // Does a step of `damage` from strain_start to strain. It ends on the surface, and grows along the drive at the
  // middle of the step, see return_map.cpp. Lanes outside `active` (failed, or empty) keep their damage and return zero
  // stress. The result of a lane is bitwise independent of the others. The energies are the trapezoidal work of the
  // step less the change of stored energy, eps_n : (C(D_n) - C(D_n+1)) : eps_n+1 / 2. So a sum over the steps balances
  // to second order of the step. strength: factor on B0 of each lane. growth: share of the growth that the step allows,
  // dt/(viscosity + dt), 1 without viscosity. softening: exponent of each lane, softening() where it is not given.
  Update update(const Sym3<vd>& strain_start, const Sym3<vd>& strain, Sym3<vd>& damage, vmask active, vd strength, double growth,
                vd softening) const;
  Update update(const Sym3<vd>& strain_start, const Sym3<vd>& strain, Sym3<vd>& damage, vmask active, vd strength = splat(1.0),
                double growth = 1.0) const {
    return update(strain_start, strain, damage, active, strength, growth, splat(p_.exponent));
  }

  // Driving force s Yeq at the given state, and B(D). For output and tests.
  using Drive = LawDrive;
  Drive drive(const Sym3<vd>& strain, const Sym3<vd>& damage, vd softening) const;
  Drive drive(const Sym3<vd>& strain, const Sym3<vd>& damage) const { return drive(strain, damage, splat(p_.exponent)); }

 private:
  struct Evaluation {
    EffectiveStrain<vd> effective;
    Mat3<vd> phi_strain, phi_stress;  // phi eps_e and phi sigma, with phi = A^-1
    Sym3<vd> stress_e, stress, Y;     // sigma_e, sigma, and Y with its negative part, see drive_by()
  };
  __attribute__((noinline)) Evaluation evaluate(const Sym3<vd>& strain, const Sym3<vd>& damage) const;
  // Derivative of Y along N.
  Sym3<vd> derivative_of_Y(const Evaluation& s, const Sym3<vd>& N) const;
  // Replaces Y by the part that drives (its positive part if monotone) and returns its Yeq.
  vd drive_by(Sym3<vd>& Y) const;
  vd tension_weight(const Sym3<vd>& stress_e) const;
  vd threshold(const Sym3<vd>& damage, vd softening) const;
  vd least_threshold(const Sym3<vd>& damage, vd softening) const;
  vmask at_cutoff(const Sym3<vd>& damage, double share = 1.0) const;
  vd largest_growth(const Sym3<vd>& damage, const Sym3<vd>& direction) const;

  struct Search;
  struct TrialState;
  struct Found;
  TrialState evaluate(Search& s, const Sym3<vd>& D) const;
  Sym3<vd> gradient_of_excess(Search& s, const TrialState& x) const;
  Sym3<vd> direction(Search& s, const Sym3<vd>& strain_start, const TrialState& x, const Sym3<vd>& G, vmask lanes) const;
  vmask small_step(Search& s, const Sym3<vd>& strain_start, const TrialState& x, vmask lanes, Found& found) const;
  vmask jump(Search& s, vmask lanes, Found& found) const;
  vmask root_by_secants(Search& s, vd excess, vd slope, const Sym3<vd>& N, vmask lanes, Found& found) const;
  vmask first_root(Search& s, const Sym3<vd>& N, vd start, vd limit, vmask lanes, Found& found) const;

  DamageParameters p_;
  double crack_energy_ = 0.0;
  SurfaceBand surface_band_;  // without a length it has p_.exponent for all points
};

}  // namespace mpdem

#endif
