// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Strain paths against data/damage_paths.csv, computed by data/generate_damage_paths.py:
// proportional and rotating, isotropic and not, with every switch of the law, to failure.
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "damage_reference.h"
#include "material/tensor_damage.h"

namespace mpdem {
namespace {

using test::Matrix;
using test::tensor;

struct Row {
  double strain[6], damage[6], stress[6], Yeq_over_B0, dissipation;
  bool failed, sensitive;
};
struct RecordedPath {
  int number;
  std::vector<Row> rows;
};
// Paths of one material, which a block can hold side by side.
struct Group {
  VtiConstants elastic;
  DamageParameters damage;
  std::vector<RecordedPath> paths;
};

std::vector<Group> read_paths() {
  std::ifstream file(MPDEM_TEST_DATA "/damage_paths.csv");
  std::vector<Group> groups;
  std::map<std::string, std::size_t> group_of;
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line,
            "path,step,Ep,Ez,nup,nuzp,Gzp,B0,Dcut,m,zeta,evolution,exx,eyy,ezz,eyz,exz,exy,Dxx,Dyy,Dzz,Dyz,Dxz,Dxy,"
            "sxx,syy,szz,syz,sxz,sxy,Yeq_over_B0,failed,dissipation,sensitive");
  while (std::getline(file, line)) {
    std::vector<std::string> field;
    std::stringstream text(line);
    for (std::string f; std::getline(text, f, ',');) field.push_back(f);
    if (field.size() != 34) {
      ADD_FAILURE() << "damage_paths.csv: " << field.size() << " fields in: " << line;
      return {};
    }
    const auto number = [&](int i) { return std::stod(field[i]); };
    std::string material;
    for (int i = 2; i < 12; ++i) material += field[i] + ",";
    if (!group_of.count(material)) {
      Group g;
      g.elastic = {number(2), number(3), number(4), number(5), number(6)};
      g.damage.B0 = number(7);
      g.damage.Dcut = number(8);
      g.damage.exponent = number(9);
      g.damage.zeta = number(10);
      g.damage.monotone = field[11] == "monotone";
      group_of[material] = groups.size();
      groups.push_back(g);
    }
    Group& g = groups[group_of[material]];
    const int path = std::stoi(field[0]), step = std::stoi(field[1]);
    if (step == 1) g.paths.push_back({path, {}});
    Row r;
    for (int i = 0; i < 6; ++i) {
      r.strain[i] = number(12 + i);
      r.damage[i] = number(18 + i);
      r.stress[i] = number(24 + i);
    }
    r.Yeq_over_B0 = number(30);
    r.failed = number(31) != 0.0;
    r.dissipation = number(32);
    r.sensitive = number(33) != 0.0;
    EXPECT_EQ(g.paths.back().number, path);
    EXPECT_EQ(static_cast<int>(g.paths.back().rows.size()) + 1, step);
    g.paths.back().rows.push_back(r);
  }
  return groups;
}

struct Deviations {
  test::Worst damage, stress, drive, dissipation, bookkeeping;

  void expect() const {
    expect_within(damage, test::kRootTolerance, "D");
    expect_within(stress, test::kRootTolerance, "stress over C0:eps");
    expect_within(drive, test::kRootTolerance, "Yeq");
    expect_within(dissipation, test::kRootTolerance, "dissipation over undamaged energy");
    expect_within(bookkeeping, 1e-12, "energy of the step over undamaged energy");
  }
};

class Comparison {
 public:
  Comparison(const Group& g, Deviations& d) : g_(g), law_(VtiElasticity(g.elastic), g.damage), reference_(g.elastic), d_(d) {}

  const TensorDamage& law() const { return law_; }

  void step(const RecordedPath& path, int k, int l, const Sym3<vd>& before, const Sym3<vd>& damage, const Sym3<vd>& start,
            const Sym3<vd>& strain, const TensorDamage::Update& u) {
    const Row& r = path.rows[k];
    if (r.sensitive) return;
    const std::string where = "path " + std::to_string(path.number) + ", step " + std::to_string(k + 1);
    const Matrix e = tensor(r.strain), D = tensor(damage, l), undamaged = reference_.elastic_stress(e);
    EXPECT_EQ(bool(u.failed[l]), r.failed) << where;
    d_.damage.add(D - tensor(r.damage), 1.0, where);
    d_.stress.add(tensor(u.stress, l) - tensor(r.stress), undamaged.norm(), where);

    // drive() weighs Yeq for zeta < 1 by the present state; the table has it without.
    const TensorDamage::Drive drive = law_.drive(strain, damage);
    const double weight = weight_of(e, D);
    d_.drive.add(std::fabs(drive.Yeq[l] / weight / g_.damage.B0 / r.Yeq_over_B0 - 1.0), where);

    // Energies: of the strain at the end of the step, against the table; as the law counts
    // them, eps_n : (C(D_n) - C(D_n+1)) : eps_n+1 / 2, against its own stress.
    const Matrix trial = tensor(law_.stress(strain, before), l), kept = tensor(law_.stress(strain, damage), l);
    const double psi = reference_.psi(e, Matrix::Zero());
    d_.dissipation.add(std::fabs(0.5 * test::contract(trial - kept, e) - r.dissipation) / psi, where);
    d_.bookkeeping.add(std::fabs(0.5 * test::contract(trial - kept, tensor(start, l)) - u.dissipated[l]) / psi, where);
  }

 private:
  double weight_of(const Matrix& e, const Matrix& D) const {
    if (g_.damage.zeta == 1.0) return 1.0;
    const test::Vector s =
        Eigen::SelfAdjointEigenSolver<Matrix>(reference_.elastic_stress(test::DamageReference::effective(e, D))).eigenvalues();
    const double r = s.cwiseMax(0.0).sum() / s.cwiseAbs().sum();
    return r + (1.0 - r) * g_.damage.zeta * g_.damage.zeta;
  }

  const Group& g_;
  TensorDamage law_;
  test::DamageReference reference_;
  Deviations& d_;
};

class DamagePaths : public ::testing::Test {
 protected:
  // Every path of a group in a lane of its own, lanes left over run them again with a delay:
  // lanes start, fail and end at different times.
  static void drive(const Group& g, Comparison& c) {
    const int n = static_cast<int>(g.paths.size());
    ASSERT_LE(n, kLanes);
    Sym3<vd> strain{}, start{}, damage{};
    vmask alive = splat_mask(true);
    int compared[kLanes] = {0};
    for (int tick = 0; any(alive) && tick < 1000; ++tick) {
      vmask active{};
      const Sym3<vd> before = damage;
      start = strain;
      for (int l = 0; l < kLanes; ++l) {
        const int k = tick - 3 * (l / n);
        if (!alive[l] || k < 0) continue;
        active[l] = -1;
        test::set_tensor(strain, l, tensor(g.paths[l % n].rows[k].strain));
      }
      const TensorDamage::Update u = c.law().update(start, strain, damage, active);
      for (int l = 0; l < kLanes; ++l) {
        if (!active[l]) {
          EXPECT_EQ(tensor(damage, l), tensor(before, l));
          continue;
        }
        const RecordedPath& path = g.paths[l % n];
        const int k = tick - 3 * (l / n);
        c.step(path, k, l, before, damage, start, strain, u);
        ++compared[l];
        if (u.failed[l] || k + 1 == static_cast<int>(path.rows.size())) alive[l] = 0;
      }
    }
    for (int l = 0; l < kLanes; ++l) EXPECT_EQ(compared[l], static_cast<int>(g.paths[l % n].rows.size()));
  }
};

TEST_F(DamagePaths, WholePathsSideBySide) {
  const std::vector<Group> groups = read_paths();
  ASSERT_EQ(groups.size(), 23u);
  Deviations deviations;
  for (const Group& g : groups) {
    std::ostringstream trace;
    trace << "B0 " << g.damage.B0 << ", m " << g.damage.exponent << ", zeta " << g.damage.zeta << ", Ep " << g.elastic.Ep
          << (g.damage.monotone ? ", monotone" : ", full");
    SCOPED_TRACE(trace.str());
    Comparison c(g, deviations);
    drive(g, c);
  }
  EXPECT_GT(deviations.damage.count(), 2000);
  deviations.expect();
}

// Each row starts from the tabled state before it, so that nothing adds up along a path.
TEST_F(DamagePaths, SingleSteps) {
  Deviations deviations;
  for (const Group& g : read_paths()) {
    Comparison c(g, deviations);
    for (const RecordedPath& path : g.paths) {
      const int n = static_cast<int>(path.rows.size());
      for (int first = 0; first < n; first += kLanes) {
        Sym3<vd> start{}, strain{}, before{};
        vmask active{};
        for (int l = 0; l < kLanes && first + l < n; ++l) {
          const int k = first + l;
          active[l] = -1;
          test::set_tensor(strain, l, tensor(path.rows[k].strain));
          if (k == 0) continue;
          test::set_tensor(start, l, tensor(path.rows[k - 1].strain));
          test::set_tensor(before, l, tensor(path.rows[k - 1].damage));
        }
        Sym3<vd> damage = before;
        const TensorDamage::Update u = c.law().update(start, strain, damage, active);
        for (int l = 0; l < kLanes && first + l < n; ++l) c.step(path, first + l, l, before, damage, start, strain, u);
      }
    }
  }
  EXPECT_GT(deviations.damage.count(), 2000);
  deviations.expect();
}

}  // namespace
}  // namespace mpdem
