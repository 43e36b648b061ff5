// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Words of a script that describe a cement: those of fix mpm, and of the command cement_material, see doc/cement_material.md.
#ifndef MPDEM_STYLES_WORDS_MATERIAL_WORDS_H
#define MPDEM_STYLES_WORDS_MATERIAL_WORDS_H

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "../../cement/bond/bond.h"
#include "../../cement/bond/options.h"
#include "../../cement/creation/cement_plan.h"
#include "law_words.h"
#include "word_rules.h"

namespace mpdem {

// What a script says of the law of a cement.
struct CementLawWords {
  VtiConstants elastic;
  LawChoice damage{&law_entries().front(), {}};
  double crack_band = 0.0, nonlocal_energy = 0.0;  // fracture energies per area; 0: none
  Scatter scatter;
};

VtiConstants read_elastic(Arguments& args);
constexpr char kScatterValues[] = "strength, energy, moduli or interface, then weibull M or lognormal V [length L] [seed N]";
// Adds a rule.
void read_scatter(Arguments& args, Scatter& scatter);
// Makes the law, with its internal length and fracture energy. Stops if there is none.
std::shared_ptr<Law> make_law(const Arguments& args, const CementOptions& o, const CementLawWords& w);

// A material of cement_material. What it leaves out is as in fix mpm and fix mpm/couple.
struct MaterialWords {
  std::string name;
  std::optional<VtiConstants> elastic;
  std::optional<LawChoice> damage;
  std::optional<Choice<TractionEntry>> interface;
  double energy = 0.0;   // fracture energy per area; 0: that of fix mpm
  double density = 0.0;  // 0: that of create_cement
  Scatter scatter;
  std::vector<SceneOption> said;  // keywords with values, for word_rules.h

  // Name of the command and of the material, for messages.
  std::string who() const { return "cement_material " + name; }
};

constexpr char kDefaultMaterial[] = "default";  // name of that of fix mpm

// Reads the words after the name.
MaterialWords read_material(Arguments& args, const std::string& name);
MaterialWords read_material(LAMMPS_NS::LAMMPS* lmp, const Bonds::NamedMaterial& material);
// The law of a material of a scene with this fix mpm.
std::shared_ptr<Law> make_law(LAMMPS_NS::LAMMPS* lmp, const CementOptions& o, const CementLawWords& of_fix, const MaterialWords& material);
// Returns the keywords, one per line, see keywords.h.
std::string listed_material_words();
// Reads the name after `material` of create_cement, which may be kDefaultMaterial. It is that of the last shape, or of the command.
void take_material(Arguments& args, const std::vector<Bonds::NamedMaterial>& materials, CementRequest& wish);

}  // namespace mpdem

#endif
