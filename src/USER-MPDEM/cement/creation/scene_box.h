// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The simulation box, along the axes, and the subdomain of this rank. Positions are rounded as the host rounds them, so
// that it assigns a point to the same rank.
#ifndef MPDEM_CEMENT_CREATION_SCENE_BOX_H
#define MPDEM_CEMENT_CREATION_SCENE_BOX_H

#include <algorithm>
#include <cmath>
#include <vector>

#include "../../geometry/box_search.h"

namespace mpdem {

struct SceneBox {
  double low[3] = {0, 0, 0}, high[3] = {0, 0, 0}, period[3] = {0, 0, 0};  // period: width, also where not periodic
  bool periodic[3] = {false, false, false};
  double own_low[3] = {0, 0, 0}, own_high[3] = {0, 0, 0};  // subdomain of this rank

  // any_vector: vector from a position in the box to any periodic image of another. Returns the vector to the nearest image.
  Vector3 shortest(const Vector3& any_vector) const {
    Vector3 d = any_vector;
    for (int c = 0; c < 3; ++c)
      if (periodic[c] && std::fabs(d[c]) > 0.5 * period[c]) d[c] += d[c] < 0.0 ? period[c] : -period[c];
    return d;
  }
  // Vectors to the periodic images of a position, itself first.
  std::vector<Vector3> images() const {
    const int n[3] = {periodic[0], periodic[1], periodic[2]};
    std::vector<Vector3> all = {Vector3::Zero()};
    for (int i = -n[0]; i <= n[0]; ++i)
      for (int j = -n[1]; j <= n[1]; ++j)
        for (int k = -n[2]; k <= n[2]; ++k)
          if (i != 0 || j != 0 || k != 0) all.emplace_back(i * period[0], j * period[1], k * period[2]);
    return all;
  }
  // Wraps x into the box by whole periods, and adds their number to `image`. Returns whether x belongs to this rank.
  bool wrap(double* x, int* image) const {
    bool own = true;
    for (int c = 0; c < 3; ++c) {
      if (periodic[c]) {
        for (; x[c] < low[c]; --image[c]) x[c] += period[c];
        for (; x[c] >= high[c]; ++image[c]) x[c] -= period[c];
        x[c] = std::max(x[c], low[c]);
      }
      own = own && x[c] >= own_low[c] && x[c] < own_high[c];
    }
    return own;
  }
  bool owns(const Vector3& at) const {
    double x[3] = {at[0], at[1], at[2]};
    int image[3] = {0, 0, 0};
    return wrap(x, image);
  }
  Box own() const { return Box(Vector3(own_low[0], own_low[1], own_low[2]), Vector3(own_high[0], own_high[1], own_high[2])); }
};

// A grain in the search for neighbours.
struct Sphere {
  int tag;
  Vector3 x;
  double radius;
};

}  // namespace mpdem

#endif
