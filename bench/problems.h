// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Problems with a known solution for the accuracy of the step; lengths, densities and moduli of
// order one.
#ifndef MPDEM_BENCH_PROBLEMS_H
#define MPDEM_BENCH_PROBLEMS_H

#include <memory>
#include <string>
#include <vector>

#include "free_body.h"

namespace mpdem::bench {

class Problem {
 public:
  std::string name;
  std::vector<int> cells;  // a unit length
  int quick;               // the first so many of them in a short run
  double density = 1.0, end = 1.0;
  double of_stable = 0.55;    // share of the step that is stable at the start
  int in_plane = 2;           // points a cell along x and along y; two along z
  std::vector<double> looks;  // times of comparison, ascending; the last is `end`
  double energy_until = 0.0;  // free motion goes on so long for the drift of energy, 0: has a load

  virtual ~Problem() = default;
  virtual NoDamage law() const = 0;
  virtual bool inside(const Point& X, double h) const = 0;
  virtual void box(double h, Point& low, Point& high) const = 0;
  virtual Point displacement(const Point& X, double t) const = 0;
  virtual Point velocity(const Point& X, double t) const = 0;  // also of nodes around the body
  virtual bool held(const Point&) const { return false; }      // is a node there at rest?
  virtual bool loaded() const { return true; }
  virtual Point body_force(const Point&, double) const { return {0, 0, 0}; }  // per mass
  // Lame's constants if the stress is that of a neo-Hookean body, which the package has no law for, and
  // law() almost nothing.
  struct NeoHookean {
    double lambda, mu;
  };
  virtual const NeoHookean* neo_hookean() const { return nullptr; }
  // A piece of surface: reference place, area, direction and sense of the normal.
  struct Facet {
    Point X;
    double area;
    int normal, sense;
  };
  virtual std::vector<Facet> facets(double) const { return {}; }
  // Force per reference area, along the normal, on the side of sense +1.
  virtual double traction(const Facet&, double) const { return 0.0; }
  double scale = 1.0;  // rms displacement that errors are divided by
};

// Of the vibrating bars: periods, and cells across the section of `bar`.
struct BarOptions {
  int periods = 1, section = 6;
};
std::vector<std::unique_ptr<Problem>> all_problems(const BarOptions& bar);

}  // namespace mpdem::bench

#endif
