// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The materials of cement_material for fix mpm.
#include <algorithm>

#include "../words/arguments.h"
#include "comm.h"
#include "fix_mpm.h"

namespace LAMMPS_NS {

using mpdem::text_of;

// Makes the laws of all materials. A material of an earlier run has the same words now, so its law is the same.
void FixMpm::take_materials() {
  std::vector<std::shared_ptr<const mpdem::Law>> laws;
  materials_.clear();
  for (const mpdem::Bonds::NamedMaterial& m : avec_->bonds.materials) {
    materials_.push_back(mpdem::read_material(lmp, m));
    laws.push_back(mpdem::make_law(lmp, cement_->options(), law_words_, materials_.back()));
  }
  law_->set_materials(std::move(laws));
  int most = 0;
  for (const mpdem::Bond& bond : avec_->bonds)
    for (const mpdem::PointStore* store : bond.stores())
      for (const mpdem::BlockMeta& m : store->meta) most = std::max(most, static_cast<int>(m.material));
  for (const mpdem::PointTemplate& t : avec_->bonds.templates)
    for (const mpdem::TemplatePoint& p : t.points) most = std::max(most, p.material);
  mpdem::stop_if_any(lmp, most < law_->materials() ? std::string()
                                                   : text_of(who(), "points are of material ", most, ", and the scene has ",
                                                             law_->materials(), "; use another restart file"));
}

// Words of the materials, for the rules of words that exclude each other (words/word_rules.h).
std::vector<mpdem::SceneOption> FixMpm::words_of_materials() const {
  const std::vector<mpdem::BondRecord>& table = avec_->bonds.table;
  std::vector<mpdem::SceneOption> words;
  const auto several =
      std::find_if(table.begin(), table.end(), [](const mpdem::BondRecord& b) { return b.material == mpdem::kSeveralMaterials; });
  if (several != table.end())
    words.push_back({"several materials in a bond", text_of("that of grains ", several->grain[0], " and ", several->grain[1])});
  for (const mpdem::MaterialWords& m : materials_) words.insert(words.end(), m.said.begin(), m.said.end());
  return words;
}

// Prints the parameters of the materials once.
void FixMpm::tell_materials() {
  if (materials_told_ || comm->me != 0) return;
  materials_told_ = true;
  const std::vector<mpdem::BondRecord>& table = avec_->bonds.table;
  const int several = static_cast<int>(
      std::count_if(table.begin(), table.end(), [](const mpdem::BondRecord& b) { return b.material == mpdem::kSeveralMaterials; }));
  for (std::size_t n = 0; n < materials_.size(); ++n) {
    const int number = static_cast<int>(n) + 1;
    const mpdem::Law& law = law_->of_material(number);
    const mpdem::VtiConstants& e = law.elasticity().constants;
    const auto own = std::count_if(table.begin(), table.end(), [&](const mpdem::BondRecord& b) { return b.material == number; });
    mpdem::tell(
        lmp, text_of("  material  ", number, " '", materials_[n].name, "', of ", own, " bonds, and in some of ", several,
                     " of several materials\n  elastic   Ep ", e.Ep, ", Ez ", e.Ez, ", nu_p ", e.nu_p, ", nu_zp ", e.nu_zp, ", Gzp ", e.Gzp,
                     "\n", law.density() > 0.0 ? text_of("  density   ", law.density(), "\n") : "", law.report(cement_->options().cell)));
  }
}

}  // namespace LAMMPS_NS
