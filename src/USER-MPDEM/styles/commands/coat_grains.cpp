// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "coat_grains.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>

#include "../../cement/creation/contact_contents.h"
#include "../../cement/creation/contacts.h"
#include "../../parallel/gather_ranks.h"
#include "../atoms/atom_vec_mpdem.h"
#include "atom.h"
#include "group.h"
#include "update.h"

namespace mpdem {

using namespace LAMMPS_NS;

std::vector<BareGrain> bare_grains(LAMMPS* lmp, int groupbit) {
  const Atom& atom = *lmp->atom;
  const AtomVecMpdem& cement = *AtomVecMpdem::of(lmp);
  std::vector<BareGrain> mine;
  for (int i = 0; i < atom.nlocal; ++i) {
    if (!(atom.mask[i] & groupbit) || cement.is_point(i)) continue;
    BareGrain g;
    g.tag = atom.tag[i];
    std::copy(atom.x[i], atom.x[i] + 3, g.x);
    g.radius = cement.coats.bare_radius(g.tag, atom.radius[i]);
    g.mass = cement.coats.bare_mass(g.tag, atom.rmass[i]);
    mine.push_back(g);
  }
  std::vector<BareGrain> all = gather_all(lmp->world, mine);
  std::sort(all.begin(), all.end(), [](const BareGrain& a, const BareGrain& b) { return a.tag < b.tag; });
  return all;
}

double density_of_calcite(LAMMPS* lmp, const Arguments& args) {
  const std::string units = lmp->update->unit_style;
  if (units == "si") return 2710.0;
  if (units == "cgs" || units == "micro") return 2.71;
  args.complain(text_of("keyword 'density' is missing: it has no default in units '", units, "'"));
}

namespace {

// Pairs of grains, one of them coated at least, that are nearer to each other than their coats are thick.
GrainCoats::Pairs near_pairs(LAMMPS* lmp, const SceneBox& box) {
  const GrainCoats& coats = AtomVecMpdem::of(lmp)->coats;
  std::vector<Sphere> spheres;
  std::unordered_map<int, const Sphere*> of;
  for (const BareGrain& g : bare_grains(lmp, ~0)) spheres.push_back({g.tag, Vector3(g.x[0], g.x[1], g.x[2]), g.radius});
  for (const Sphere& s : spheres) of.emplace(s.tag, &s);
  double thickest = 0.0;
  for (const Coat& c : coats.all()) thickest = std::max(thickest, c.thickness);
  const auto thickness = [&](int tag) { return coats.find(tag) ? coats.find(tag)->thickness : 0.0; };
  GrainCoats::Pairs near;
  for (const auto& p : contacts(spheres, box, 2.0 * thickest)) {
    const Sphere &a = *of.at(p.first), &b = *of.at(p.second);
    if (box.shortest(b.x - a.x).norm() - a.radius - b.radius < thickness(p.first) + thickness(p.second)) near.push_back(p);
  }
  return near;
}

}  // namespace

int coat(LAMMPS* lmp, const std::vector<BareGrain>& grains, const CoatRequest& request, const SceneBox& box) {
  AtomVecMpdem& cement = *AtomVecMpdem::of(lmp);
  Atom& atom = *lmp->atom;
  std::vector<Coat> coats;
  for (const BareGrain& g : grains) {
    if (cement.coats.find(g.tag)) throw BadState(text_of("create_cement coat: grain ", g.tag, " has a coat already; coat it once"));
    if (!(request.thickness <= kMostCoat * g.radius))
      throw BadState(text_of("create_cement coat: a coat ", request.thickness, " thick is more than ", kMostCoat,
                             " of the radius of grain ", g.tag, ", ", kMostCoat * g.radius, "; use a thinner one"));
    coats.push_back({g.tag, g.radius, g.mass, request.thickness, request.density, request.at_walls});
  }
  cement.coats.add(coats);
  for (int i = 0; i < atom.nlocal; ++i) {
    const Coat* c = cement.is_point(i) ? nullptr : cement.coats.find(atom.tag[i]);
    if (!c) continue;
    atom.radius[i] = c->outer();
    atom.rmass[i] = c->mass_of_both();
    atom.density[i] = c->mean_density();
  }
  const GrainCoats::Pairs near = near_pairs(lmp, box);
  cement.coats.touch_bare(near);
  lmp->update->first_update = 0;  // LIGGGHTS sets up the next run, also with `pre no`
  return static_cast<int>(near.size());
}

void coat_grains(LAMMPS* lmp, Arguments& args, const SceneBox& box) {
  const std::string name = args.word("a group of grains for 'coat'");
  const int igroup = lmp->group->find(name.c_str());
  if (igroup < 0) args.complain(text_of("'coat ", name, "': there is no such group; define it by 'group' before"));
  const std::vector<BareGrain> grains = bare_grains(lmp, lmp->group->bitmask[igroup]);
  if (grains.empty()) args.complain(text_of("group '", name, "' has no grains"));
  double calcite = 0.0;
  CoatRequest request;
  const std::vector<std::string> words = {"thickness", "calcite", "density", "walls"};
  while (!args.empty()) {
    const std::string key = args.word("a keyword");
    args.once(key);
    if (key == "thickness") request.thickness = args.positive(key);
    else if (key == "calcite") calcite = args.between(key, 1e-6, 1.0, "mass of the coats over that of the grains");
    else if (key == "density") request.density = args.positive(key);
    else if (key == "walls") request.at_walls = args.choice(key, {"coat", "bare"}) == "coat";
    else args.unknown(key, words);
  }
  if ((request.thickness > 0.0) == (calcite > 0.0)) args.complain("needs one of 'thickness' and 'calcite'");
  if (request.density == 0.0) request.density = density_of_calcite(lmp, args);
  double mass = 0.0;
  std::vector<double> radii;
  for (const BareGrain& g : grains) {
    radii.push_back(g.radius);
    mass += g.mass;
  }
  if (calcite > 0.0)
    request.thickness = coat_of_mass(radii, request.density, calcite * mass, text_of("create_cement coat: 'calcite ", calcite, "'"));
  const int bare = coat(lmp, grains, request, box);
  const double volume = volume_of_coats(radii, request.thickness);
  tell(lmp, text_of("Coats ", request.thickness, " thick on ", grains.size(), " grains of group '", name, "': volume ", volume, ", mass ",
                    request.density * volume, ", content (mass over that of the grains, ", mass, ") ", request.density * volume / mass,
                    "; nearer than their coats are ", bare, " pairs of grains, which touch each other with their bare surfaces\n"));
}

}  // namespace mpdem
