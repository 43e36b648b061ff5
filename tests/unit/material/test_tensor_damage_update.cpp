// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include <algorithm>
#include <vector>

#include "damage_reference.h"
#include "material/tensor_damage.h"
#include "mpm/point_store.h"

namespace mpdem {
namespace {

using test::DamageReference;
using test::kB0;
using test::law_of;
using test::Matrix;
using test::strain_at;
using test::tensor;

struct Block {
  Sym3<vd> start{}, strain{}, damage{};
};

// Random loads from below the surface to far above it.
Block random_block(const TensorDamage& law, test::Random& random) {
  Block b;
  for (int l = 0; l < kLanes; ++l) {
    const Matrix D = random.index(3) ? random.damage(0.6) : Matrix(Matrix::Zero());
    const Matrix e = strain_at(law, random.uniform(0.5, 2.0), random.sym(), D);
    test::set_tensor(b.damage, l, D);
    test::set_tensor(b.strain, l, e);
    test::set_tensor(b.start, l, 0.95 * e);
  }
  return b;
}

// A lane's result is bitwise identical whatever the others hold.
TEST(TensorDamageUpdate, InactiveLanesKeepTheirDamageAndStayOutOfIt) {
  for (bool monotone : {true, false}) {
    const TensorDamage law = law_of(monotone);
    test::Random random(65);
    for (int n = 0; n < 300; ++n) {
      const Block all = random_block(law, random);
      Sym3<vd> together = all.damage;
      const TensorDamage::Update u = law.update(all.start, all.strain, together, splat_mask(true));
      // These lanes stay the same, the others hold rubbish: strains by the thousand, D at the cut-off.
      const std::uint8_t mask = static_cast<std::uint8_t>(1 + random.index(254));
      Block mixed = all;
      for (int l = 0; l < kLanes; ++l)
        if (!(mask >> l & 1)) {
          test::set_tensor(mixed.strain, l, 1e3 * random.sym());
          test::set_tensor(mixed.damage, l, random.with_values({0.9, random.uniform(0, 0.9), 0.0}));
        }
      Sym3<vd> apart = mixed.damage;
      const TensorDamage::Update v = law.update(mixed.start, mixed.strain, apart, lanes(mask));
      for (int l = 0; l < kLanes; ++l) {
        if (mask >> l & 1) {
          EXPECT_EQ(tensor(apart, l), tensor(together, l));
          EXPECT_EQ(tensor(v.stress, l), tensor(u.stress, l));
          EXPECT_EQ(double(v.dissipated[l]), double(u.dissipated[l]));
          EXPECT_EQ(bool(v.failed[l]), bool(u.failed[l]));
          EXPECT_EQ(bool(v.grown[l]), bool(u.grown[l]));
        } else {
          EXPECT_EQ(tensor(apart, l), tensor(mixed.damage, l));
          EXPECT_EQ(tensor(v.stress, l), Matrix(Matrix::Zero()));
          EXPECT_FALSE(v.failed[l] || v.grown[l]);
          EXPECT_EQ(double(v.dissipated[l]), 0.0);
          EXPECT_EQ(double(v.released[l]), 0.0);
        }
      }
    }
  }
}

TEST(TensorDamageUpdate, FailedLanesGiveNoStress) {
  const TensorDamage law = law_of();
  test::Random random(66);
  int failed = 0;
  test::Worst cutoff, energy;
  for (int n = 0; n < 200; ++n) {
    Block b = random_block(law, random);
    for (int l = 0; l < kLanes; l += 2) test::set_tensor(b.strain, l, 4.0 * tensor(b.strain, l));
    const Sym3<vd> before = law.stress(b.strain, b.damage);
    const TensorDamage::Update u = law.update(b.start, b.strain, b.damage, splat_mask(true));
    vmask alive = splat_mask(true);
    for (int l = 0; l < kLanes; ++l) {
      const double largest = Eigen::SelfAdjointEigenSolver<Matrix>(tensor(b.damage, l)).eigenvalues()[2];
      EXPECT_EQ(bool(u.failed[l]), largest >= 0.9 * (1 - 1e-11)) << largest;
      EXPECT_LE(largest, 0.9 * (1 + 1e-14));
      if (!u.failed[l]) continue;
      ++failed;
      alive[l] = 0;
      EXPECT_EQ(tensor(u.stress, l), Matrix(Matrix::Zero()));
      cutoff.add(std::fabs(largest / 0.9 - 1.0));
      const double spent = 0.5 * test::contract(tensor(before, l), tensor(b.start, l));
      energy.add(std::fabs((u.dissipated[l] + u.released[l]) / spent - 1.0));
    }
    // from now on such a lane is inactive
    const Sym3<vd> kept = b.damage;
    const TensorDamage::Update again = law.update(b.strain, b.strain, b.damage, alive);
    for (int l = 0; l < kLanes; ++l)
      if (u.failed[l]) {
        EXPECT_EQ(tensor(again.stress, l), Matrix(Matrix::Zero()));
        EXPECT_EQ(tensor(b.damage, l), tensor(kept, l));
      }
  }
  EXPECT_GT(failed, 500);
  expect_within(cutoff, 1e-12, "largest D over the cut-off");
  expect_within(energy, 1e-12, "dissipated + released");
}

// On random walks of the strain the state is never above the surface, nothing heals, and nothing is gained.
TEST(TensorDamageUpdate, AdmissibleOnRandomWalks) {
  for (double exponent : {0.0, 0.7}) {
    DamageParameters p;
    p.B0 = kB0;
    p.exponent = exponent;
    const TensorDamage law(VtiElasticity(test::calcite()), p);
    const DamageReference reference(test::calcite());
    test::Random random(67);
    test::Worst above, healing, gain;
    int grown = 0;
    for (int walk = 0; walk < 20; ++walk) {
      Sym3<vd> strain{}, start{}, damage{};
      vmask alive = splat_mask(true);
      for (int k = 0; k < 100; ++k) {
        start = strain;
        const Sym3<vd> before = damage;
        for (int l = 0; l < kLanes; ++l) test::set_tensor(strain, l, tensor(strain, l) + 2e-3 * random.sym());
        const TensorDamage::Update u = law.update(start, strain, damage, alive);
        const TensorDamage::Drive drive = law.drive(strain, damage);
        for (int l = 0; l < kLanes; ++l) {
          if (!alive[l]) continue;
          const Matrix growth = tensor(damage, l) - tensor(before, l), e = tensor(strain, l);
          healing.add(-Eigen::SelfAdjointEigenSolver<Matrix>(growth).eigenvalues()[0]);
          gain.add((reference.psi(e, tensor(damage, l)) - reference.psi(e, tensor(before, l))) / kB0);
          if (u.grown[l]) ++grown;
          if (u.failed[l]) alive[l] = 0;
          else above.add(drive.Yeq[l] / drive.B[l] - 1.0);
        }
      }
    }
    EXPECT_GT(grown, 500);
    const std::string m = ", exponent " + std::to_string(exponent);
    expect_within(above, test::kRootTolerance, "Yeq/B - 1" + m);
    expect_within(healing, 1e-14, "least eigenvalue of the growth" + m);
    expect_within(gain, 1e-13, "energy gained over B0" + m);
  }
}

// Strains that rotate as they grow, in n steps from the onset of damage to `reach` times it; D at the end.
std::vector<Matrix> turned(double exponent, int n) {
  DamageParameters p;
  p.B0 = kB0;
  p.exponent = exponent;
  const TensorDamage law(VtiElasticity(test::calcite()), p);
  test::Random random(71);
  std::vector<Matrix> all;
  for (int path = 0; path < 8; ++path) {
    Matrix first[kLanes], second[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      first[l] = strain_at(law, 1.0, random.sym(), Matrix::Zero());
      second[l] = strain_at(law, 1.0, first[l] / first[l].norm() + 0.7 * random.sym(), Matrix::Zero());
    }
    Sym3<vd> strain{}, damage{};
    for (int k = 0; k <= n; ++k) {
      const Sym3<vd> before = strain;
      const double t = static_cast<double>(k) / n;
      for (int l = 0; l < kLanes; ++l) test::set_tensor(strain, l, (1.0 + 0.5 * t) * ((1.0 - t) * first[l] + t * second[l]));
      law.update(before, strain, damage, splat_mask(true));
    }
    for (int l = 0; l < kLanes; ++l) all.push_back(tensor(damage, l));
  }
  return all;
}

TEST(TensorDamageUpdate, SecondOrderInTheStepWhereTheStrainTurns) {
  for (double exponent : {0.0, 0.7}) {
    const std::vector<Matrix> coarse = turned(exponent, 50), middle = turned(exponent, 100), fine = turned(exponent, 200);
    std::vector<double> orders;
    for (std::size_t i = 0; i < fine.size(); ++i)
      orders.push_back(std::log2((coarse[i] - middle[i]).norm() / (middle[i] - fine[i]).norm()));
    std::sort(orders.begin(), orders.end());
    test::expect_within(std::fabs(orders[orders.size() / 2] - 2.0), 0.1, "order minus 2, exponent " + std::to_string(exponent));
    EXPECT_GT(orders[orders.size() / 10], 1.7);
  }
}

// A small step takes five evaluations: value and slope at its start, its middle, and two values on the way to the root.
TEST(TensorDamageUpdate, EvaluationsOfASmallStep) {
  for (double exponent : {0.0, 0.7}) {
    DamageParameters p;
    p.B0 = kB0;
    p.exponent = exponent;
    const TensorDamage law(VtiElasticity(test::calcite()), p);
    test::Random random(72);
    int most = 0, sum = 0;
    for (int n = 0; n < 200; ++n) {
      Sym3<vd> before{}, strain{}, damage{};
      for (int l = 0; l < kLanes; ++l) {
        const Matrix D = random.damage(0.6),
                     e = strain_at(law, std::pow(1.0 - Eigen::SelfAdjointEigenSolver<Matrix>(D).eigenvalues()[2], -exponent), random.sym(),
                                   D);
        test::set_tensor(damage, l, D);
        test::set_tensor(before, l, e);
        test::set_tensor(strain, l, 1.0005 * e);
      }
      const int taken = law.update(before, strain, damage, splat_mask(true)).evaluations;
      most = std::max(most, taken);
      sum += taken;
    }
    EXPECT_LE(most, 7) << "exponent " << exponent;
    EXPECT_LE(sum, 200 * 5.5) << "exponent " << exponent;
  }
}

// A factor on B0 of a lane is another B0.
TEST(TensorDamageUpdate, StrengthOfALane) {
  test::Random random(69);
  test::Worst worst;
  vd strength;
  for (int l = 0; l < kLanes; ++l) strength[l] = random.uniform(0.3, 3.0);
  for (int n = 0; n < 50; ++n) {
    const Block b = random_block(law_of(), random);
    Sym3<vd> D = b.damage;
    const TensorDamage::Update u = law_of().update(b.start, b.strain, D, splat_mask(true), strength);
    for (int l = 0; l < kLanes; ++l) {
      DamageParameters p;
      p.B0 = strength[l] * kB0;
      Sym3<vd> other = b.damage;
      const TensorDamage::Update v = TensorDamage(VtiElasticity(test::calcite()), p).update(b.start, b.strain, other, splat_mask(true));
      worst.add(tensor(D, l) - tensor(other, l), 1.0);
      EXPECT_EQ(bool(u.failed[l]), bool(v.failed[l]));
      EXPECT_EQ(bool(u.grown[l]), bool(v.grown[l]));
    }
  }
  expect_within(worst, 1e-12, "D");
}

// A share g of the growth gives D = D_n + g (D_inf - D_n). Stress and energies are those of D.
TEST(TensorDamageUpdate, ShareOfTheGrowth) {
  const TensorDamage law = law_of();
  test::Random random(70);
  test::Worst growth, stress, energy;
  for (double g : {0.01, 0.5, 1.0})
    for (int n = 0; n < 50; ++n) {
      const Block b = random_block(law, random);
      Sym3<vd> whole = b.damage, part = b.damage;
      law.update(b.start, b.strain, whole, splat_mask(true));
      const TensorDamage::Update u = law.update(b.start, b.strain, part, splat_mask(true), splat(1.0), g);
      const Sym3<vd> s = law.stress(b.strain, part), trial = law.stress(b.strain, b.damage);
      for (int l = 0; l < kLanes; ++l) {
        const Matrix D = tensor(b.damage, l);
        growth.add(tensor(part, l) - D - g * (tensor(whole, l) - D), 1.0);
        if (g < 1.0) {
          EXPECT_FALSE(u.failed[l]);
        }
        if (!u.failed[l]) stress.add(tensor(u.stress, l) - tensor(s, l), tensor(trial, l).norm());
        const double spent = 0.5 * test::contract(tensor(trial, l) - tensor(s, l), tensor(b.start, l));
        energy.add(std::fabs(u.dissipated[l] - spent) / kB0);
      }
    }
  expect_within(growth, 1e-15, "growth");
  expect_within(stress, 1e-14, "stress");
  expect_within(energy, 1e-13, "dissipated over B0");
}

// A strain held far above failure: D goes to the cut-off as 1 - (1-g)^n, the point fails when it has come
// to 0.99 of it, and all the energy it had is dissipated or released by then.
TEST(TensorDamageUpdate, ViscousLanesFailInFiniteTime) {
  const TensorDamage law = law_of();
  const DamageReference reference(test::calcite());
  for (double g : {0.002, 0.05, 0.4}) {
    Sym3<vd> strain{}, damage{};
    for (int l = 0; l < kLanes; ++l)
      test::set_tensor(strain, l, strain_at(law, 40.0 + 10.0 * l, Matrix(Eigen::Vector3d(0, 0, 1).asDiagonal()), Matrix::Zero()));
    vmask alive = splat_mask(true);
    vd energy{};
    const int expected = static_cast<int>(std::ceil(std::log(0.01) / std::log1p(-g)));
    for (int n = 1; n <= expected; ++n) {
      const TensorDamage::Update u = law.update(strain, strain, damage, alive, splat(1.0), g);
      energy += u.dissipated + u.released;
      for (int l = 0; l < kLanes; ++l) {
        EXPECT_EQ(bool(u.failed[l]), n == expected) << "step " << n << ", share " << g;
        EXPECT_NEAR(tensor(damage, l)(2, 2), n == expected ? 0.9 : 0.9 * (1.0 - std::pow(1.0 - g, n)), 1e-12);
        if (n == expected) {
          EXPECT_EQ(tensor(u.stress, l), Matrix(Matrix::Zero()));
          EXPECT_NEAR(energy[l] / reference.psi(tensor(strain, l), Matrix::Zero()), 1.0, 1e-12);
        }
      }
    }
  }
}

// If the law without viscosity would stay short of the cut-off, so does D, however long it takes.
TEST(TensorDamageUpdate, ViscousLanesShortOfTheCutoffDoNotFail) {
  const TensorDamage law = law_of();
  Sym3<vd> strain{}, damage{}, target{};
  for (int l = 0; l < kLanes; ++l)
    test::set_tensor(strain, l, strain_at(law, 2.0 + l, Matrix(Eigen::Vector3d(0, 0, 1).asDiagonal()), Matrix::Zero()));
  law.update(strain, strain, target, splat_mask(true));
  for (int n = 0; n < 2000; ++n) EXPECT_FALSE(any(law.update(strain, strain, damage, splat_mask(true), splat(1.0), 0.05).failed));
  for (int l = 0; l < kLanes; ++l) EXPECT_NEAR((tensor(damage, l) - tensor(target, l)).norm(), 0.0, 1e-10);
}

TEST(TensorDamageUpdate, UnloadingIsSecant) {
  const TensorDamage law = law_of();
  test::Random random(68);
  test::Worst worst;
  Block b = random_block(law, random);
  law.update(b.start, b.strain, b.damage, splat_mask(true));
  const Sym3<vd> D = b.damage, stress = law.stress(b.strain, D);
  for (double share : {0.9, 0.5, 0.0, -0.4}) {
    const Sym3<vd> strain = splat(share) * b.strain;
    const TensorDamage::Update u = law.update(b.strain, strain, b.damage, splat_mask(true));
    EXPECT_FALSE(any(u.grown));
    for (int l = 0; l < kLanes; ++l) {
      EXPECT_EQ(tensor(b.damage, l), tensor(D, l));
      worst.add(tensor(u.stress, l) - share * tensor(stress, l), tensor(stress, l).norm());
    }
  }
  expect_within(worst, 1e-13, "stress");
}

}  // namespace
}  // namespace mpdem
