// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "unit_checks.h"

#include <algorithm>
#include <set>

#include "../../parallel/agree.h"

namespace mpdem {

namespace {

struct Units {
  const char *name, *pressure, *density, *speed;
  double Pa, kg_per_m3, m_per_s;  // the units of the script in SI
};
constexpr Units kUnits[] = {
    {"si", "Pa", "kg/m3", "m/s", 1.0, 1.0, 1.0},
    {"cgs", "dyn/cm2", "g/cm3", "cm/s", 0.1, 1e3, 0.01},
    {"micro", "pg/(um us2)", "pg/um3", "um/us", 1e3, 1e3, 1.0},
};

// Compressional waves run at some 900 m/s in polymers and at 7 000 m/s in calcite. Calcite has a density of 2 710 kg/m3.
// Crystals of calcite and cemented rocks fail at tensile stresses of 0.1 to 50 MPa. The limits leave room on both sides.
constexpr double kSlowest = 500.0, kFastest = 10e3;
constexpr double kLightest = 1e3, kHeaviest = 4e3;
constexpr double kWeakest = 1e3, kStrongest = 80e6;
constexpr double kSoftestGrain = 1e6;  // rubber

}  // namespace

// With other units than those of kUnits only the strain at failure is judged.
std::vector<std::string> unlike_solids(const Law& law, double density, const std::string& units) {
  std::vector<std::string> found;
  const VtiConstants& e = law.elasticity().constants;
  for (const Units& u : kUnits) {
    if (units != u.name) continue;
    const auto judge = [&](const char* what, double value, double unit, const char* name, double least, double most,
                           const std::string& check) {
      if (value * unit >= least && value * unit <= most) return;
      found.push_back(text_of(what, " is ", value, " ", name, "; solids like cement have ", least / unit, " to ", most / unit,
                              ": check the units of ", check, ", which are those of 'units ", u.name, "'"));
    };
    judge("the density of the cement", density, u.kg_per_m3, u.density, kLightest, kHeaviest,
          "'density' of create_cement and cement_material");
    judge("the speed of compressional waves in the cement", law.elasticity().fastest_wave(density), u.m_per_s, u.speed, kSlowest, kFastest,
          text_of("'elastic' (", u.pressure, ") and of the density (", u.density, ")"));
    if (law.inert()) continue;
    const double strength = std::min(law.implied_strength(e.Ez).tensile_strength, law.implied_strength(e.Ep).tensile_strength);
    judge("the tensile strength of the cement", strength, u.Pa, u.pressure, kWeakest, kStrongest,
          text_of("the options of 'damage ", law.name(), "' (", u.pressure, "; a threshold is an energy per volume, not a strength)"));
  }
  if (law.inert()) return found;
  const double strain = law.implied_strength(std::min(e.Ez, e.Ep)).failure_strain;
  if (strain > 1.0) found.push_back(text_of("cement fails at a strain of ", strain, ", ", law.advice_on_strain()));
  return found;
}

std::vector<std::string> unlike_grains(const std::vector<BondRecord>& table, const std::string& units) {
  std::vector<std::string> found;
  std::set<double> moduli;
  for (const BondRecord& b : table) moduli.insert(b.grain_E, b.grain_E + 2);
  for (const Units& u : kUnits)
    for (double E : moduli)
      if (units == u.name && E > 0.0 && E * u.Pa < kSoftestGrain)
        found.push_back(text_of("Young's modulus of elastic grains is ", E, " ", u.pressure, "; solids have ", kSoftestGrain / u.Pa,
                                " and more: check the units of 'grains elastic', which are those of 'units ", u.name, "'"));
  return found;
}

}  // namespace mpdem
