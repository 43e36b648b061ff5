// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement_material.h"

#include <algorithm>
#include <string>
#include <vector>

#include "../atoms/atom_vec_mpdem.h"
#include "../words/material_words.h"
#include "atom.h"

namespace LAMMPS_NS {

using mpdem::text_of;

// Keeps the words of a material. Fix mpm makes its law when a run starts.
void CementMaterial::command(int narg, char** arg) {
  mpdem::Arguments args(lmp, "cement_material", narg, arg, 0);
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  if (!avec) args.complain(text_of("atom style '", atom->atom_style, "' cannot hold material points; use 'atom_style mpdem'"));
  const std::string name = args.word("a name for the material");
  args.name_object(name);
  if (name == mpdem::kDefaultMaterial)
    args.complain(text_of("'", name, "' is the material of fix mpm, whose words are there; use another name"));
  const int first = args.place();
  const double density = mpdem::read_material(args, name).density;
  const std::string words = args.place() == first ? std::string() : args.words_from(first);
  std::vector<mpdem::Bonds::NamedMaterial>& materials = avec->bonds.materials;
  const auto known = std::find_if(materials.begin(), materials.end(), [&](const auto& m) { return m.name == name; });
  if (known == materials.end()) {
    if (materials.size() + 1 == static_cast<std::size_t>(mpdem::kMostMaterials))
      args.complain(text_of("there are ", materials.size(), " materials already, the most that a scene may have"));
    materials.push_back({name, words, density});
    return;
  }
  if (known->words != words) args.complain(text_of("this material exists with the words '", known->words, "'; use these, or another name"));
}

}  // namespace LAMMPS_NS
