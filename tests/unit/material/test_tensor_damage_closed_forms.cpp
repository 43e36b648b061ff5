// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Single points driven along paths whose answer is known in closed form. With c the
// modulus of the path, stress c e up to e0 and from there, for a threshold B0 (1 - D)^-m,
//   1 - D = (e0/e)^(2/(1+m)),  stress = c e (1 - D)^2,  failure at e0 (1 - Dcut)^(-(1+m)/2).
#include <stdexcept>
#include <vector>

#include "damage_reference.h"
#include "material/tensor_damage.h"

namespace mpdem {
namespace {

using test::kB0;
using test::Matrix;
using test::Vector;

struct Path {
  std::string name;
  VtiConstants constants;
  double modulus;                 // stress per e
  double onset;                   // e0 at B0
  Matrix strain, stress, damage;  // shapes: of e, of the stress, of D
  Matrix held;                    // stress that holds the other axes, per e (1 - D)
  double dissipated;              // up to Dcut = 1, over B0, for m = 0
  std::vector<int> free;          // axes whose strain makes their stress vanish
  std::vector<double> poisson;    // of those axes, undamaged
};

Matrix diagonal(double a, double b, double c) { return Vector(a, b, c).asDiagonal(); }

std::vector<Path> all_paths() {
  const VtiConstants vti = test::calcite(), iso = VtiConstants::isotropic(60e9, 0.3);
  const VtiElasticity cv(vti), ci(iso);
  const double q = std::pow(2.0, 0.25), G = ci.C44, K = 60e9 / (3 * (1 - 2 * 0.3));
  const Matrix x = diagonal(1, 0, 0), z = diagonal(0, 0, 1), none = Matrix::Zero();
  Matrix xy = Matrix::Zero(), xz = Matrix::Zero();
  xy(0, 1) = xy(1, 0) = xz(0, 2) = xz(2, 0) = 1.0;
  const double nu_pz = vti.nu_zp * vti.Ep / vti.Ez, s2 = std::sqrt(2.0);
  const auto uniaxial = [&](double c) { return q * std::sqrt(kB0 / c); };
  const Matrix one = Matrix::Identity();
  return {
      {"uniaxial strain, isotropic", iso, ci.C11, uniaxial(ci.C11), x, x, x, diagonal(0, ci.C12, ci.C13), s2, {}, {}},
      {"uniaxial strain along the axis", vti, cv.C33, uniaxial(cv.C33), z, z, z, diagonal(cv.C13, cv.C13, 0), s2, {}, {}},
      {"uniaxial strain in the plane", vti, cv.C11, uniaxial(cv.C11), x, x, x, diagonal(0, cv.C12, cv.C13), s2, {}, {}},
      {"uniaxial stress, isotropic", iso, iso.Ep, uniaxial(iso.Ep), x, x, x, none, s2, {1, 2}, {0.3, 0.3}},
      {"uniaxial stress along the axis", vti, vti.Ez, uniaxial(vti.Ez), z, z, z, none, s2, {0, 1}, {vti.nu_zp, vti.nu_zp}},
      {"uniaxial stress in the plane", vti, vti.Ep, uniaxial(vti.Ep), x, x, x, none, s2, {1, 2}, {vti.nu_p, nu_pz}},
      {"shear, isotropic", iso, 2 * G, std::sqrt(kB0 / (2 * G)), xz, xz, diagonal(1, 0, 1), none, 2.0, {}, {}},
      {"shear in the plane", vti, 2 * cv.C66, std::sqrt(kB0 / (2 * cv.C66)), xy, xy, diagonal(1, 1, 0), none, 2.0, {}, {}},
      {"hydrostatic, isotropic",
       iso,
       3 * K,
       std::pow(2.0 / 3.0, 0.25) * std::sqrt(kB0 / (3 * K)),
       one,
       one,
       one,
       none,
       std::sqrt(6.0),
       {},
       {}},
  };
}

// One step of eight points. The strain of the free axes is found so that no stress is
// left there. Every trial starts from the damage before the step.
TensorDamage::Update step(const Path& path, const TensorDamage& law, double peak, const Sym3<vd>& before, Sym3<vd>& strain,
                          Sym3<vd>& damage, vmask active) {
  const Sym3<vd> damage_before = damage;
  const int n = static_cast<int>(path.free.size());
  TensorDamage::Update u = law.update(before, strain, damage, active);
  if (n == 0) return u;
  const test::DamageReference elastic(path.constants);
  Eigen::Matrix2d K;
  for (int j = 0; j < 2; ++j) {
    Matrix unit = Matrix::Zero();
    unit(path.free[j], path.free[j]) = 1.0;
    const Matrix s = elastic.elastic_stress(unit);
    for (int i = 0; i < 2; ++i) K(i, j) = s(path.free[i], path.free[i]);
  }
  const Eigen::Matrix2d inverse = K.inverse();
  // Linear convergence down to rounding, which shows as no progress.
  double least = 1e300;
  for (int iteration = 0, idle = 0; iteration < 300 && idle < 8; ++iteration) {
    double residual = 0.0;
    const Sym3<vd> stress = law.stress(strain, damage);
    for (int l = 0; l < kLanes; ++l) {
      if (!active[l]) continue;
      const Matrix s = test::tensor(stress, l);
      Matrix e = test::tensor(strain, l);
      const Eigen::Vector2d r(s(path.free[0], path.free[0]), s(path.free[1], path.free[1]));
      const Eigen::Vector2d correction = inverse * r;
      for (int i = 0; i < 2; ++i) e(path.free[i], path.free[i]) -= correction[i];
      test::set_tensor(strain, l, e);
      residual = std::max(residual, r.cwiseAbs().maxCoeff());
    }
    damage = damage_before;
    u = law.update(before, strain, damage, active);
    if (residual < 1e-15 * peak) break;
    idle = residual < 0.9 * least ? 0 : idle + 1;
    least = std::min(least, residual);
  }
  return u;
}

class ClosedForm : public ::testing::TestWithParam<int> {
 protected:
  const Path path_ = all_paths()[GetParam()];
};

std::string path_name(const ::testing::TestParamInfo<int>& info) {
  std::string name = all_paths()[info.param].name;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
}

// Uniform steps to 1.02 times the failure strain, another number of steps in every lane.
// Lanes that are done stay inactive. In uniaxial stress the strain across is not straight over a step: with an
// exponent the middle of the step in which damage begins has a little stress there, and D is of second order in the steps,
// where it is exact otherwise.
void expect_closed_form(const Path& path, double exponent) {
  DamageParameters parameters;
  parameters.B0 = kB0;
  parameters.exponent = exponent;
  const TensorDamage law(VtiElasticity(path.constants), parameters);
  const double e0 = path.onset, ef = e0 * std::pow(1.0 - parameters.Dcut, -0.5 * (1.0 + exponent));
  const double peak = path.modulus * e0;
  const int counts[kLanes] = {12, 23, 37, 61, 97, 151, 233, 379};
  test::Worst stress_error, damage_error, poisson_error;
  const bool exact = exponent == 0.0 || path.free.empty();
  int failures = 0;

  Sym3<vd> strain{}, before{}, damage{};
  vmask active = splat_mask(true);
  for (int k = 1; any(active); ++k) {
    double e[kLanes];
    before = strain;
    for (int l = 0; l < kLanes; ++l) {
      e[l] = 1.02 * ef * k / counts[l];
      const double last = 1.02 * ef * (k - 1) / counts[l];
      if (active[l]) test::set_tensor(strain, l, test::tensor(strain, l) + (e[l] - last) * path.strain);
    }
    const TensorDamage::Update u = step(path, law, peak, before, strain, damage, active);
    for (int l = 0; l < kLanes; ++l) {
      if (!active[l]) continue;
      const std::string where = path.name + ", step " + std::to_string(k) + " of " + std::to_string(counts[l]);
      const bool failed = u.failed[l];
      ASSERT_EQ(failed, e[l] >= ef) << where << ", e/ef = " << e[l] / ef;
      if (failed) {
        ++failures;
        EXPECT_EQ(test::tensor(u.stress, l), Matrix(Matrix::Zero())) << where;
        damage_error.add(std::fabs(Eigen::SelfAdjointEigenSolver<Matrix>(test::tensor(damage, l)).eigenvalues()[2] - parameters.Dcut),
                         where);
        active[l] = 0;
        continue;
      }
      const double intact = e[l] <= e0 ? 1.0 : std::pow(e0 / e[l], 2.0 / (1.0 + exponent));
      const double stress = path.modulus * e[l] * intact * intact;
      // with an exponent the strain runs to a multiple of e0 that sets the rounding
      const double scale = exponent == 0.0 ? peak : std::max(peak, path.modulus * e[l]);
      const Matrix s = test::tensor(u.stress, l), strain_l = test::tensor(strain, l);
      stress_error.add(s - stress * path.stress - intact * e[l] * path.held, scale, where);
      const double unit = exact ? 1.0 : std::pow(1.02 * ef / (e0 * counts[l]), 2);
      damage_error.add(test::tensor(damage, l) - (1.0 - intact) * path.damage, unit, where);
      for (std::size_t i = 0; i < path.free.size(); ++i)
        poisson_error.add(std::fabs(-strain_l(path.free[i], path.free[i]) / e[l] - path.poisson[i] * intact) / unit, where);
    }
  }
  EXPECT_EQ(failures, kLanes);
  expect_within(stress_error, test::kRootTolerance, "stress over peak");
  const double tolerance = exact ? test::kRootTolerance : 0.05;
  const std::string times = exact ? "" : " over the square of the step in onset strains";
  expect_within(damage_error, tolerance, "1 - D" + times);
  if (!path.free.empty()) expect_within(poisson_error, tolerance, "apparent Poisson ratio" + times);
}

TEST_P(ClosedForm, StressDamageAndFailureStrain) { expect_closed_form(path_, 0.0); }

// Constant ratio from e0 to the failure strain: no step is cut, the rule shows its order.
struct Energies {
  double dissipated = 0.0, released = 0.0, work = 0.0;
};
Energies energies(const Path& path, double exponent, int steps) {
  DamageParameters parameters;
  parameters.B0 = kB0;
  parameters.exponent = exponent;
  const TensorDamage law(VtiElasticity(path.constants), parameters);
  const double ef_over_e0 = std::pow(1.0 - parameters.Dcut, -0.5 * (1.0 + exponent));
  Sym3<vd> strain{}, before{}, damage{};
  Matrix stress_before = Matrix::Zero();
  Energies sum;
  vmask active = splat_mask(true);
  double last = 0.0;
  for (int k = 0; k <= steps && active[0]; ++k) {
    const double e = path.onset * std::pow(ef_over_e0, static_cast<double>(k) / steps);
    before = strain;
    for (int l = 0; l < kLanes; ++l) test::set_tensor(strain, l, test::tensor(strain, l) + (e - last) * path.strain);
    last = e;
    const TensorDamage::Update u = step(path, law, path.modulus * path.onset, before, strain, damage, active);
    const Matrix s = test::tensor(u.stress, 0);
    sum.work += 0.5 * test::contract(s + stress_before, test::tensor(strain, 0) - test::tensor(before, 0));
    stress_before = s;
    sum.dissipated += u.dissipated[0];
    sum.released += u.released[0];
    if (u.failed[0]) {
      EXPECT_EQ(k, steps) << path.name << " failed too early";
      active = splat_mask(false);
    }
  }
  EXPECT_FALSE(any(active)) << path.name << " did not fail";
  return sum;
}

// The sum over the steps is the trapezoidal rule: second order. The energy released at
// failure is taken with the strain at the start of the step.
TEST_P(ClosedForm, DissipatedEnergy) {
  const double Dcut = DamageParameters().Dcut, exact = path_.dissipated * kB0 * Dcut;
  const int n = path_.free.empty() ? 2000 : 1000;
  const Energies coarse = energies(path_, 0.0, n), fine = energies(path_, 0.0, 2 * n);
  const double error_coarse = std::fabs(coarse.dissipated / exact - 1.0);
  const double error_fine = std::fabs(fine.dissipated / exact - 1.0);
  test::expect_within(error_fine, 1e-6, "dissipated up to Dcut");
  test::expect_within(std::fabs(std::log2(error_coarse / error_fine) - 2.0), 0.01, "order minus 2");
  const double released = 0.5 * path_.dissipated * kB0 * (1.0 - Dcut);
  const double whole_release = fine.released * std::pow(1.0 - Dcut, -0.5 / (2 * n));
  test::expect_within(std::fabs(whole_release / released - 1.0), 1e-10, "released");
  test::expect_within(std::fabs((fine.dissipated + fine.released) / fine.work - 1.0), 1e-12, "balance with the work");
}

INSTANTIATE_TEST_SUITE_P(TensorDamage, ClosedForm, ::testing::Range(0, static_cast<int>(all_paths().size())), path_name);

// Crack-band exponent: uniaxial paths only, where the largest eigenvalue is the one that grows.
TEST(CrackBand, StressDamageAndFailureStrain) {
  for (double m : {-0.9, -0.4, 0.7, 1.0, 2.5})
    for (int i : {1, 3, 5}) {
      SCOPED_TRACE(m);
      expect_closed_form(all_paths()[i], m);
    }
}

TEST(CrackBand, WorkToFailureAndImpliedStrength) {
  const Path path = all_paths()[4];
  test::Worst work, strength;
  for (double m : {-0.4, 0.0, 0.7, 1.0, 2.0}) {
    DamageParameters p;
    p.B0 = kB0;
    p.exponent = m;
    const ImpliedStrength implied = implied_strength(p, path.constants.Ez);
    strength.add(std::fabs(implied.onset_strain / path.onset - 1.0), "onset strain");
    strength.add(std::fabs(implied.tensile_strength / (path.constants.Ez * path.onset) - 1.0), "strength");
    const double failure_strain = path.onset * std::pow(1 - p.Dcut, -0.5 * (1 + m));
    strength.add(std::fabs(implied.failure_strain / failure_strain - 1.0), "failure strain");
    const int steps = 1000;
    const Energies e = energies(path, m, steps);
    // the released part refers to the start of its step
    const double whole = e.dissipated + e.released * std::pow(1 - p.Dcut, -0.5 * (1 + m) / steps);
    work.add(std::fabs(whole / implied.work_per_volume - 1.0), "m = " + std::to_string(m));
  }
  expect_within(work, 1e-5, "work");
  expect_within(strength, 1e-14, "implied strength");
}

// The exponent for a fracture energy and a width of band is the one that spends it.
TEST(CrackBand, ExponentForAFractureEnergy) {
  DamageParameters p;
  p.B0 = 9.6e3;
  test::Worst worst;
  for (double m : {-0.99, -0.4, 0.0, 0.7, 1.0 - 1e-13, 1.0, 1.0 + 1e-9, 2.0, 2.99}) {
    p.exponent = m;
    // W by quadrature of the uniaxial curve: the elastic triangle up to e0, then
    // s/ft = (e/e0)^(-(3-m)/(1+m)); the integral in closed form in powers of 1 - Dcut.
    const double k = 1.0 - p.Dcut, n = 1.0 - m;
    const double series = -std::log(k) * (1.0 + 0.5 * n * std::log(k));
    const double spent = std::fabs(n) < 1e-6 ? series : (1.0 - std::pow(k, n)) / n;
    const double W = spent + 0.5 * std::pow(k, n), band = 1e-4, G_f = std::sqrt(2.0) * p.B0 * W * band;
    worst.add(std::fabs(crack_band_exponent(p, G_f, band) - m), std::to_string(m));
    worst.add(std::fabs(implied_strength(p, 6e10).work_per_volume * band / G_f - 1.0), std::to_string(m));
  }
  expect_within(worst, 1e-12, "exponent");
  // from half to 99.5 times sqrt(2) B0 h for a cut-off of 0.9
  const double unit = std::sqrt(2.0) * p.B0 * 1e-4;
  EXPECT_NO_THROW(crack_band_exponent(p, 0.51 * unit, 1e-4));
  EXPECT_NO_THROW(crack_band_exponent(p, 99.4 * unit, 1e-4));
  EXPECT_THROW(crack_band_exponent(p, 0.49 * unit, 1e-4), std::domain_error);
  EXPECT_THROW(crack_band_exponent(p, 99.6 * unit, 1e-4), std::domain_error);
  EXPECT_THROW(crack_band_exponent(p, 0.0, 1e-4), std::domain_error);
}

// The hat of strain, layer by layer: each is loaded along s = f_t (e/e0)^-(3-m)/(1+m) to failure or to a third of that strain,
// and gives back what is elastic.
TEST(ClosedForms, CrackInCellsTakesItsEnergy) {
  test::Worst worst;
  const double cell = 1e-4, E = 6e10;
  for (double m : {-0.5, 0.0, 0.8, 1.0, 1.7, 2.5, 2.9}) {
    DamageParameters p;
    p.B0 = test::kB0;
    p.exponent = m;
    const ImpliedStrength s = implied_strength(p, E);
    const auto spent = [&](double e_end) {  // work to e_end less what comes back on unloading
      if (e_end <= s.onset_strain) return 0.0;
      const int n = 20000;
      double sum = 0.5 * s.tensile_strength * s.onset_strain;
      const double f = std::pow(e_end / s.onset_strain, 1.0 / n), q = -(3.0 - m) / (1.0 + m);
      double e = s.onset_strain, last = s.tensile_strength;
      for (int i = 1; i <= n; ++i) {
        const double next = s.onset_strain * std::pow(f, i), stress = s.tensile_strength * std::pow(next / s.onset_strain, q);
        sum += 0.5 * (last + stress) * (next - e);
        e = next;
        last = stress;
      }
      return sum - 0.5 * last * e;
    };
    const double kept = s.tensile_strength * std::pow(s.failure_strain / s.onset_strain, -(3.0 - m) / (1.0 + m));
    const double G = 0.5 * cell * 2.0 * (spent(s.failure_strain) + 0.5 * kept * s.failure_strain + spent(s.failure_strain / 3.0));
    worst.add(std::fabs(localisation_cells(p) * s.work_per_volume * cell / G - 1.0), std::to_string(m));
    DamageParameters q = p;
    q.exponent = 0.0;
    worst.add(std::fabs(crack_cell_exponent(q, localisation_cells(p) * s.work_per_volume * cell, cell) - m), std::to_string(m));
  }
  expect_within(worst, 1e-6, "energy of the crack and exponent");
  DamageParameters p;
  p.B0 = test::kB0;
  EXPECT_THROW(crack_cell_exponent(p, 1e-9, cell), std::domain_error);
  EXPECT_THROW(crack_cell_exponent(p, 1e9, cell), std::domain_error);
}

}  // namespace
}  // namespace mpdem
