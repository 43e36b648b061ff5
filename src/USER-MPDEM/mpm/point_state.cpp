// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_state.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "../material/laws.h"
#include "../numerics/eigen3.h"
#include "../numerics/text_of.h"
#include "material_runs.h"

namespace mpdem {

namespace {

// Largest damage of a point from a tensor that no law has read yet.
double largest_of(const double* D) {
  Sym3<vd> tensor;
  double* of = reinterpret_cast<double*>(&tensor);
  for (int i = 0; i < 6; ++i)
    for (int l = 0; l < kLanes; ++l) of[kLanes * i + l] = D[i];
  return largest(eigen(tensor))[0];
}

std::string name_of_law(int number) { return law_entries()[number - 1].name; }

// Converts the damage tensor that a file gave for a point. Returns what is wrong, or an empty string.
std::string convert_file_tensor(PointStore& points, int slot, const Law& law) {
  const bool failed = points.has_failed(slot);
  double D[kMostStateFields] = {}, state[kMostStateFields] = {};
  for (int i = 0; i < points.state_fields(); ++i) D[i] = points.state(slot / kLanes)[i][slot % kLanes];
  const bool damaged = std::any_of(D, D + kMostStateFields, [](double v) { return v != 0.0; });
  if (law.inert() && (failed || damaged))
    return text_of("damage ", largest_of(D), failed ? ", and has failed" : "",
                   ", which needs a law of damage, 'damage tensor' for instance");
  if (!damaged) return "";
  try {
    law.state_from_tensor(D, state);
    points.set_state(slot, state);
    return "";
  } catch (const std::domain_error& e) {
    return text_of("damage ", largest_of(D), ", ", e.what());
  }
}

}  // namespace

std::vector<vd> largest_damages(const PointStore& points) {
  std::vector<vd> all(points.meta.size());
  for_each_material(points, *points.law(), [&](const auto& l, int first, int last) {
    for (int b = first; b < last; ++b)
      if (points.meta[b].damaged) all[b] = largest_damage_of(points, b, l);
  });
  return all;
}

std::array<double, 3> without_sign(std::array<double, 3> normal) {
  int most = 0;
  for (int i = 1; i < 3; ++i)
    if (std::fabs(normal[i]) > std::fabs(normal[most]) + 1e-9) most = i;
  if (normal[most] < 0.0)
    for (double& x : normal) x = -x;
  return normal;
}

CracksOfBlock cracks_of(const PointStore& points, int block) {
  const Mat3<vd> R = rotation_matrix(points.blocks[block].q);
  Sym3<vd> damage, opening;
  with_law(law_of_block(points, *points.law(), block), [&](const auto& l) {
    const auto state = state_of<std::decay_t<decltype(l)>>(points, block);
    damage = l.damage(state);
    opening = l.opening(points.blocks[block].strain, state);
  });
  const Spectral d = eigen(rotate(R, damage)), n = eigen(rotate(R, opening));
  CracksOfBlock c;
  for (int lane = 0; lane < kLanes; ++lane) {
    double values[3];
    for (int i = 0; i < 3; ++i) values[i] = d.value[i][lane];
    std::sort(values, values + 3, [](double x, double y) { return x > y; });
    int first = 0;
    for (int i = 1; i < 3; ++i)
      if (n.value[i][lane] > n.value[first][lane]) first = i;
    const auto& axis = n.axes.a;
    const std::array<double, 3> normal = without_sign({axis[0][first][lane], axis[1][first][lane], axis[2][first][lane]});
    for (int i = 0; i < 3; ++i) {
      c.damage[i][lane] = values[i];
      c.normal[i][lane] = normal[i];
    }
  }
  return c;
}

CrackOfPoint crack_of(const PointStore& points, int slot) {
  const CracksOfBlock all = cracks_of(points, slot / kLanes);
  CrackOfPoint c;
  for (int i = 0; i < 3; ++i) {
    c.damage[i] = all.damage[i][slot % kLanes];
    c.normal[i] = all.normal[i][slot % kLanes];
  }
  return c;
}

std::array<double, 6> damage_tensor_of(const PointStore& points, int slot) {
  const int b = slot / kLanes, l = slot % kLanes;
  std::array<double, 6> numbers{};
  if (!points.law()) {
    if (points.law_number() != 0 && points.law_number() != kLawNumber<TensorDamage> && !points.states().empty())
      throw std::domain_error(text_of("their state is that of 'damage ", name_of_law(points.law_number()),
                                      "'; define fix mpm with that law and use 'run 0' before"));
    for (int i = 0; i < points.state_fields(); ++i) numbers[i] = points.state(b)[i][l];
    return numbers;
  }
  const Sym3<vd> D = with_law(law_of_block(points, *points.law(), b),
                              [&](const auto& law) -> Sym3<vd> { return law.damage(state_of<std::decay_t<decltype(law)>>(points, b)); });
  return {D.xx[l], D.yy[l], D.zz[l], D.yz[l], D.xz[l], D.xy[l]};
}

std::string read_point_states(PointStore& points, const std::shared_ptr<const Law>& shared) {
  const Law& law = *shared;
  const int number = points.law_number();
  const bool other = number != 0 && number != law_number(law);
  std::string trouble;
  for (int b = 0; b < static_cast<int>(points.meta.size()) && trouble.empty(); ++b) {
    const BlockMeta& m = points.meta[b];
    if (!m.damaged) continue;
    for (int l = 0; l < kLanes && trouble.empty(); ++l) {
      if (!(m.occupied >> l & 1)) continue;
      if (other)
        trouble = text_of("a state of 'damage ", name_of_law(number), "', from which 'damage ", law.name(), "' cannot go on; keep the law");
      else if (number == 0) trouble = convert_file_tensor(points, kLanes * b + l, law_of_block(points, law, b));
      if (!trouble.empty()) trouble = text_of("material point ", points.tags[b][l], " has ", trouble);
    }
  }
  if (trouble.empty()) points.set_law(shared);
  const auto find_beyond_cutoff = [&](const auto& l, int first, int last) {
    for (int b = first; b < last && trouble.empty(); ++b) {
      const BlockMeta& m = points.meta[b];
      if (!m.damaged) continue;
      const vd most = largest_damage_of(points, b, l);
      for (int k = 0; k < kLanes; ++k)
        if (m.occupied >> k & 1 && !(m.failed >> k & 1) && most[k] > l.cutoff() * (1.0 + 1e-9) && trouble.empty())
          trouble = text_of("material point ", points.tags[b][k], " has damage ", most[k], ", above the cut-off ", l.cutoff(),
                            "; raise 'cutoff' or mark such points as failed in the file of create_cement");
    }
  };
  if (trouble.empty()) for_each_material(points, law, find_beyond_cutoff);
  return trouble;
}

}  // namespace mpdem
