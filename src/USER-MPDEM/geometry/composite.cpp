// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "composite.h"

#include <algorithm>

namespace mpdem {

namespace {

template <class F>
double largest_of(const std::vector<std::unique_ptr<Shape>>& parts, F f) {
  double v = f(*parts.front());
  for (const auto& p : parts) v = std::max(v, f(*p));
  return v;
}

}  // namespace

Composite::Composite(std::vector<std::unique_ptr<Shape>> parts)
    : Shape(parts.front()->pair(), parts.front()->inner()), parts_(std::move(parts)) {
  volume_ = volume_by_quadrature(*this);
}

double Composite::top(double z) const {
  return largest_of(parts_, [z](const Shape& s) { return s.top(z); });
}
double Composite::top_clearance(double r, double z) const {
  return -largest_of(parts_, [r, z](const Shape& s) { return -s.top_clearance(r, z); });
}
double Composite::lowest() const {
  return -largest_of(parts_, [](const Shape& s) { return -s.lowest(); });
}
double Composite::highest() const {
  return largest_of(parts_, [](const Shape& s) { return s.highest(); });
}
double Composite::widest() const {
  return largest_of(parts_, [](const Shape& s) { return s.widest(); });
}
double Composite::covered_angle(int side) const {
  return largest_of(parts_, [side](const Shape& s) { return s.covered_angle(side); });
}
double Composite::largest_thickness() const {
  return largest_of(parts_, [](const Shape& s) { return s.largest_thickness(); });
}

void Composite::add_breaks(std::vector<double>& at) const {
  for (const auto& p : parts_) p->add_breaks(at);
}

int Composite::part_at(const Vector3& x) const {
  const auto part = std::find_if(parts_.begin(), parts_.end(), [&](const auto& p) { return p->inside(x); });
  return part == parts_.end() ? 0 : static_cast<int>(part - parts_.begin());
}

// All shapes reach from grain to grain there, so each of them has an outline with any smaller inner radius.
double Composite::spans() const {
  return -largest_of(parts_, [](const Shape& s) { return -s.spans(); });
}
bool Composite::ends_where_it_spans() const {
  return std::all_of(parts_.begin(), parts_.end(), [](const auto& p) { return p->ends_where_it_spans(); });
}
std::unique_ptr<Shape> Composite::with_inner(double inner) const {
  std::vector<std::unique_ptr<Shape>> parts;
  for (const auto& p : parts_) parts.push_back(p->with_inner(inner));
  return std::make_unique<Composite>(std::move(parts));
}

std::string Composite::describe() const {
  std::string text;
  for (const auto& p : parts_) text += (text.empty() ? "" : " and ") + p->describe();
  return text;
}

}  // namespace mpdem
