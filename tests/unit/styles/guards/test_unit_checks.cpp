// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Calcite is like a solid in each system of units. Its numbers of one system are not in another one.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "material/tensor_damage.h"
#include "styles/guards/unit_checks.h"

using namespace mpdem;

namespace {

struct System {
  const char* name;
  double pressure, density;  // a Pa and a kg/m3 in these units
};
constexpr System kSystems[] = {{"si", 1.0, 1.0}, {"cgs", 10.0, 1e-3}, {"micro", 1e-3, 1e-3}};
constexpr double kCalcite = 2710.0;

std::vector<std::string> warnings(const System& written_in, const char* units, double E = 60e9, double B0 = 9.6e3) {
  DamageParameters p;
  p.B0 = B0 * written_in.pressure;
  p.Dcut = 0.9;
  const TensorDamage law(VtiElasticity(VtiConstants::isotropic(E * written_in.pressure, 0.25)), p);
  return unlike_solids(law, kCalcite * written_in.density, units);
}

bool tells_of(const std::vector<std::string>& found, const char* what) {
  for (const std::string& text : found)
    if (text.find(what) != std::string::npos) return true;
  return false;
}

}  // namespace

TEST(UnitChecks, CalciteIsLikeASolidInItsOwnUnits) {
  for (const System& s : kSystems) EXPECT_TRUE(warnings(s, s.name).empty()) << s.name << ": " << warnings(s, s.name).front();
  EXPECT_TRUE(warnings(kSystems[0], "real").empty()) << "units that no check knows";
}

TEST(UnitChecks, NumbersOfOtherUnitsAreFound) {
  for (const System& s : kSystems)
    for (const System& other : kSystems)
      if (s.density != other.density) {
        EXPECT_TRUE(tells_of(warnings(s, other.name), "density")) << s.name << " in " << other.name;
      }
}

TEST(UnitChecks, EachNumberIsJudgedByItself) {
  for (const System& s : kSystems) {
    const auto strong = warnings(s, s.name, 60e9, 20e6), soft = warnings(s, s.name, 60.0, 9.6e-6);
    EXPECT_TRUE(strong.size() == 1 && tells_of(strong, "tensile strength")) << s.name;
    EXPECT_TRUE(soft.size() == 2 && tells_of(soft, "compressional waves") && tells_of(soft, "tensile strength")) << s.name;
  }
}
