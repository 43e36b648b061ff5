// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "material_words.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "keywords.h"

namespace mpdem {

namespace {

using MaterialKeyword = Keyword<MaterialWords>;

constexpr double kLeastModulus = 1.0, kMostModulus = 100.0, kMostVariation = 2.0;

const std::vector<MaterialKeyword>& material_keywords() {
  static const std::vector<MaterialKeyword> all = {
      {"elastic", "vti Ep Ez nu_p nu_zp Gzp or isotropic E nu", "",
       [](Arguments& args, const MaterialKeyword&, MaterialWords& w) { w.elastic = read_elastic(args); }},
      {"damage", names_listed(law_entries()), "",
       [](Arguments& args, const MaterialKeyword& k, MaterialWords& w) { w.damage = read_choice(args, k.name, law_entries()); }},
      {"energy", "G", "", [](Arguments& args, const MaterialKeyword& k, MaterialWords& w) { w.energy = args.positive(k.name); }},
      {"interface", names_listed(traction_entries()), "",
       [](Arguments& args, const MaterialKeyword& k, MaterialWords& w) { w.interface = read_choice(args, k.name, traction_entries()); }},
      {"density", "rho", "", [](Arguments& args, const MaterialKeyword& k, MaterialWords& w) { w.density = args.positive(k.name); }},
      {"scatter", kScatterValues, "", [](Arguments& args, const MaterialKeyword&, MaterialWords& w) { read_scatter(args, w.scatter); },
       true},
  };
  return all;
}

// Sets internal length and fracture energy of the law.
void soften(const Arguments& args, const CementOptions& o, const CementLawWords& w, Law& law) {
  std::string word = "'regularization crackband'";
  try {
    if (w.crack_band > 0.0) law.set_crack_energy(w.crack_band, o.cell);
    if (!o.advance.nonlocal) return;
    const double L = o.length;
    // A length that is smaller by rounding alone is allowed: scripts compute it.
    if (L < 0.999999 * o.cell)
      args.complain(text_of("'regularization nonlocal ", L, "': the length must be at least the cell, which is ", o.cell, "; take 'cell ",
                            L, "' or less"));
    constexpr double kMostCells = 100.0;  // an average over more takes thousands of passes a step
    if (L > kMostCells * o.cell)
      args.complain(text_of("'regularization nonlocal ", L, "': the length must be at most ", kMostCells, " cells, which are ",
                            kMostCells * o.cell, ", in the units of the box; take a length of one to four cells"));
    word = "'regularization nonlocal ... energy'";
    law.set_nonlocal(L, w.nonlocal_energy);
  } catch (const std::domain_error& e) {
    const VtiConstants& c = law.elasticity().constants;
    args.complain(text_of(word, ": ", e.what(), "; these options of the law are a tensile strength of ",
                          law.implied_strength(std::min(c.Ep, c.Ez)).tensile_strength));
  }
}

// Stops at a law whose strength, strain at failure or energy is not finite. Thresholds that no cement reaches are
// allowed.
void check_strength(const Arguments& args, const Law& law, const std::string& name) {
  if (law.inert()) return;
  const VtiConstants& e = law.elasticity().constants;
  const ImpliedStrength s = law.implied_strength(std::max(e.Ep, e.Ez));
  if (std::isfinite(s.failure_strain) && std::isfinite(s.tensile_strength) && std::isfinite(s.work_per_volume)) return;
  args.complain(text_of("'damage ", name, "': cement would fail at a strain of ", s.failure_strain, " with a strength of ",
                        s.tensile_strength, "; both must be finite, ", law.advice_on_strain()));
}

}  // namespace

VtiConstants read_elastic(Arguments& args) {
  VtiConstants constants;
  if (args.choice("elastic", {"vti", "isotropic"}) == "isotropic") {
    const std::vector<double> v =
        args.numbers("elastic isotropic", {{"E", "Young's modulus, above 0"}, {"nu", "Poisson's ratio, between -1 and 0.5"}}, "4e10 0.3");
    const double E = v[0], nu = v[1];
    constants = VtiConstants::isotropic(E, nu);
    if (!(nu > -1.0 && nu < 0.5)) args.complain(text_of("'elastic isotropic' nu = ", nu, " must lie between -1 and 0.5"));
  } else {
    const std::vector<double> v = args.numbers("elastic vti",
                                               {{"Ep", "Young's modulus in the plane of isotropy, above 0"},
                                                {"Ez", "Young's modulus along the axis, above 0"},
                                                {"nu_p", "Poisson's ratio in the plane of isotropy, between -1 and 1"},
                                                {"nu_zp", "Poisson's ratio under stress along the axis"},
                                                {"Gzp", "shear modulus of planes that have the axis, above 0"}},
                                               "4e10 3e10 0.3 0.25 1.2e10");
    constants.Ep = v[0], constants.Ez = v[1], constants.nu_p = v[2], constants.nu_zp = v[3], constants.Gzp = v[4];
  }
  const std::string why = constants.violated_condition();
  if (!why.empty()) args.complain("'elastic' is not positive definite: " + why);
  return constants;
}

void read_scatter(Arguments& args, Scatter& scatter) {
  ScatterRule rule;
  const std::vector<std::string> names = {"strength", "energy", "moduli", "interface"};
  const int what = args.index_of_choice("scatter", names);
  rule.what = static_cast<Scattered>(what);
  const std::string word = "scatter " + names[static_cast<std::size_t>(what)];
  if (args.choice(word, {"weibull", "lognormal"}) == "weibull") {
    rule.distribution = ScatterRule::weibull;
    rule.parameter = args.between(word + " weibull", kLeastModulus, kMostModulus, "modulus of Weibull");
  } else {
    rule.distribution = ScatterRule::lognormal;
    rule.parameter = args.positive(word + " lognormal");
    if (rule.parameter > kMostVariation)
      args.complain(text_of("'", word, " lognormal ", rule.parameter, "': coefficient of variation, must be at most ", kMostVariation));
  }
  if (args.accept("length")) rule.length = args.positive(word + " length");
  if (args.accept("seed")) rule.seed = args.integer(word + " seed", 1);
  const bool twice = std::any_of(scatter.rules.begin(), scatter.rules.end(),
                                 [&](const ScatterRule& r) { return r.what == rule.what && (r.length > 0.0) == (rule.length > 0.0); });
  if (twice)
    args.complain(text_of("'", word, "' is given twice ", rule.length > 0.0 ? "with" : "without",
                          " 'length'; give one for the values of bonds, and one with 'length' for a field"));
  scatter.rules.push_back(rule);
}

std::shared_ptr<Law> make_law(const Arguments& args, const CementOptions& o, const CementLawWords& w) {
  std::shared_ptr<Law> law = w.damage.make(VtiElasticity(w.elastic));
  soften(args, o, w, *law);
  check_strength(args, *law, w.damage.entry->name);
  law->set_scatter(w.scatter);
  const double least = w.scatter.least_length();
  if (w.scatter.has_field() && least < 0.999999 * o.cell)
    args.complain(text_of("'scatter ... length ", least, "': the correlation length must be at least the cell, which is ", o.cell,
                          "; take 'cell ", least, "' or less, or a greater length"));
  return law;
}

MaterialWords read_material(Arguments& args, const std::string& name) {
  MaterialWords w;
  w.name = name;
  const std::vector<std::string> said = parse_keywords(args, material_keywords(), w, [&](const std::string& key) {
    std::vector<std::string> known = names_of(material_keywords());
    for (const std::string& word : law_words("damage", law_entries())) known.push_back(word);
    for (const std::string& word : law_words("interface", traction_entries())) known.push_back(word);
    args.unknown(key, known);
  });
  for (const std::string& words : said) {
    w.said.push_back({words, w.who()});
    if (words.rfind("elastic", 0) == 0) w.said.back().words = "material " + words;  // not to be taken for that of fix mpm
    if (words.rfind("damage", 0) == 0) w.said.back().words = "material " + words;
  }
  return w;
}

MaterialWords read_material(LAMMPS_NS::LAMMPS* lmp, const Bonds::NamedMaterial& material) {
  std::vector<std::string> words;
  std::istringstream in(material.words);
  for (std::string w; in >> w;) words.push_back(w);
  std::vector<char*> arg;
  for (std::string& w : words) arg.push_back(&w[0]);
  Arguments args(lmp, "cement_material " + material.name, static_cast<int>(arg.size()), arg.data(), 0);
  return read_material(args, material.name);
}

std::shared_ptr<Law> make_law(LAMMPS_NS::LAMMPS* lmp, const CementOptions& o, const CementLawWords& of_fix, const MaterialWords& m) {
  const Arguments args(lmp, m.who(), 0, nullptr, 0);
  CementLawWords w = of_fix;
  w.scatter = m.scatter;
  if (m.elastic) w.elastic = *m.elastic;
  if (m.damage) {
    if (m.damage->entry != of_fix.damage.entry)
      args.complain(text_of("'damage ", m.damage->entry->name, "', but fix mpm has 'damage ", of_fix.damage.entry->name,
                            "': all cements of a scene have one law of damage, with numbers of their own; use 'damage ",
                            of_fix.damage.entry->name, "' here, where a high threshold is cement that does not fail"));
    w.damage = *m.damage;
  }
  if (m.energy > 0.0) {
    double* const of_fix_mpm = w.crack_band > 0.0 ? &w.crack_band : &w.nonlocal_energy;
    if (*of_fix_mpm == 0.0)
      args.complain(
          text_of("'energy ", m.energy, "' needs a fix mpm with an energy: 'regularization crackband G' or 'nonlocal L energy G'"));
    *of_fix_mpm = m.energy;
  }
  std::shared_ptr<Law> law = make_law(args, o, w);
  law->set_density(m.density);
  return law;
}

std::string listed_material_words() { return listed("cement_material", material_keywords()); }

namespace {

int number_of_material(const Arguments& args, const std::vector<Bonds::NamedMaterial>& materials, const std::string& name) {
  if (name == kDefaultMaterial) return 0;
  for (std::size_t n = 0; n < materials.size(); ++n)
    if (materials[n].name == name) return static_cast<int>(n) + 1;
  std::string known = kDefaultMaterial;
  for (const Bonds::NamedMaterial& m : materials) known += ", " + m.name;
  args.complain(text_of("there is no 'material ", name, "'; known are ", known, "; define it before by 'cement_material ", name, " ...'"));
}

}  // namespace

void take_material(Arguments& args, const std::vector<Bonds::NamedMaterial>& materials, CementRequest& wish) {
  const int number = number_of_material(args, materials, args.word("the name of a material for 'material'"));
  if (wish.shapes.empty()) {
    wish.material = number;
    return;
  }
  wish.material_of_shape.resize(wish.shapes.size(), -1);
  wish.material_of_shape.back() = number;
}

}  // namespace mpdem
