// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "scene.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "../../mpm/largest_eigenvalue.h"
#include "../../parallel/agree.h"

namespace mpdem {

std::array<double, 3> Scene::weight() const {
  const double* g = now.gravity;
  return {g[0] / options.mass_scale, g[1] / options.mass_scale, g[2] / options.mass_scale};
}

std::array<double, 3> Scene::weight_of(const Bond& b) const {
  const std::array<double, 3> w = weight();
  return w == std::array<double, 3>{} ? w : turned_back(axes_of(bonds().record(b)), w.data());
}

double Scene::shear_speed() const { return std::sqrt(law->elasticity().softest_shear() / scaled_density); }

// Failed points may close again and carry pressure, and debonded links become contacts. Either changes the stiffness
// without a further failure.
bool Scene::stays_linear(const Bond& b) const {
  if ((touches() || options.unilateral) && b.points.any_failed()) return false;
  const auto softened = [](const Link& k) { return k.attached && k.state[0] > 0.0; };  // state[0]: damage of a cohesive link
  for (const PointStore* store : b.stores())
    if (std::any_of(store->links.begin(), store->links.end(), softened)) return false;
  const auto debonded = [](const Link& k) { return !k.attached; };
  return !touches() || (b.points.contacts.empty() && std::none_of(b.points.links.begin(), b.points.links.end(), debonded));
}

double Scene::eigenvalue_bound() const {
  // The distribution from which moduli are drawn has no largest value.
  if (law->any_scatter(Scattered::moduli)) return 0.0;
  double largest = 0.0;
  for (int n = 0; n < law->materials(); ++n)
    largest = std::max(largest, mpdem::eigenvalue_bound(options.basis, law->of_material(n).elasticity().largest_stiffness(),
                                                        inertia().of(n), options.cell));
  return largest;
}

std::vector<int> Scene::all_rows() const {
  std::vector<int> rows(bonds().table.size());
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

std::vector<int> Scene::agreed_rows(const std::vector<int>& mine) const { return union_of_ranks(comm, mine); }

}  // namespace mpdem
