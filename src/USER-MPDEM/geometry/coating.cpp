// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "coating.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "shape_styles.h"

namespace mpdem {

namespace {

// Largest polar angle, about the centre of grain `side`, of the points of its shell inside the other shell.
double overlap_angle(const GrainPair& p, int side, double t) {
  const double d = p.distance(), R = p.radius(side), S = p.radius(1 - side) + t;
  const auto cosine = [&](double r) { return (r * r + d * d - S * S) / (2.0 * r * d); };
  double least = std::min(cosine(R), cosine(R + t));
  const double turning = d * d - S * S;  // square of the r at which the cosine is least
  if (turning > R * R && turning < (R + t) * (R + t)) least = std::min(least, cosine(std::sqrt(turning)));
  return std::acos(std::min(std::max(least, -1.0), 1.0));
}

}  // namespace

Coating::Coating(const GrainPair& pair, double thickness, double cap, double inner) : Shape(pair, inner), t_(thickness), cap_(cap) {
  std::ostringstream why;
  if (!(thickness > 0.0 && thickness <= std::min(pair.R1, pair.R2))) {
    why << "coating thickness " << thickness << " must lie in (0, " << std::min(pair.R1, pair.R2) << "], the smaller grain's radius";
  } else if (!((cap > 0.0 && cap <= 0.5 * M_PI * (1.0 + 1e-15)) || cap == M_PI)) {
    why << "cap " << cap / kDegree << " degrees must lie in (0, 90], or be 180 for the whole grain";
  } else if (!(pair.gap < 2.0 * thickness)) {
    why << "coatings of thickness " << thickness << " do not meet across a gap of " << pair.gap << "; use more than " << 0.5 * pair.gap;
  } else {
    const double need = std::max(overlap_angle(pair, 0, thickness), overlap_angle(pair, 1, thickness));
    if (cap < need) why << "cap " << cap / kDegree << " degrees cuts into the bond; use more than " << need / kDegree;
  }
  const double smaller = std::min(pair.R1, pair.R2);
  if (why.str().empty() && !(this->inner() < std::min(ring(), smaller)))
    why << "inner radius " << this->inner() << " must lie in [0, " << std::min(ring(), smaller) << "), inside "
        << (ring() < smaller
                ? "the ring in which the coatings meet; use a thicker coating or a smaller 'inner', with 'inner auto' a smaller spacing"
                : "the smaller grain; use a smaller 'inner'");
  if (!why.str().empty()) throw ShapeError(why.str());
}

double Coating::thickness_for_volume(const GrainPair& pair, double volume, double cap, double inner) {
  const auto volume_of = [&](double t) {
    try {
      return Coating(pair, t, cap, inner).volume();
    } catch (const ShapeError&) {
      return 0.0;
    }
  };
  const double largest = std::min(pair.R1, pair.R2);
  // With a cap, the thickest coating is the one whose overlap just fits into the cap.
  double most = largest;
  if (cap < M_PI)
    most = bisect_rising([&](double t) { return std::max(overlap_angle(pair, 0, t), overlap_angle(pair, 1, t)) - cap; }, 0.0, largest) *
           (1.0 - 1e-12);
  if (volume_of(most) == 0.0) Coating(pair, most, cap, inner);  // throws with a message about what is wrong besides the volume
  const double least = least_of_rising(volume_of, most);
  if (!(volume > 0.0 && volume >= least && volume <= volume_of(most))) {
    std::ostringstream why;
    why << "a coating of volume " << volume << " does not fit: on these grains and outside the inner radius " << inner
        << " it holds at least " << least << " and at most " << volume_of(most) << "; more fits with a wider cap, less with a narrower one";
    throw VolumeError(why.str(), least, volume_of(most));
  }
  return bisect_rising([&](double t) { return volume_of(t) - volume; }, 0.0, most);
}

double Coating::ring() const {
  const double d = pair().distance(), S1 = pair().R1 + t_, S2 = pair().R2 + t_;
  const double z = (d * d + S1 * S1 - S2 * S2) / (2.0 * d);
  return std::sqrt(std::max(S1 * S1 - z * z, 0.0));
}

double Coating::volume() const {
  const double d = pair().distance(), s = std::sin(0.5 * cap_);
  double V = 0.0;
  for (int i = 0; i < 2; ++i) {
    const double R = pair().radius(i);
    V += 4.0 * M_PI / 3.0 * s * s * t_ * (3.0 * R * R + 3.0 * R * t_ + t_ * t_);
  }
  V -= lens_volume(pair().R1 + t_, pair().R2 + t_, d) - lens_volume(pair().R1, pair().R2, d);
  return V - volume_within_inner();
}

double Coating::top(double z) const {
  double r = 0.0;
  for (int s = 0; s < 2; ++s) {
    const double S = pair().radius(s) + t_, h = z - pair().height(s);
    if (std::fabs(h) >= S) continue;
    double out = std::sqrt(S * S - h * h);
    if (cap_ < M_PI) {
      const double ahead = s == 0 ? h : -h;  // towards the contact
      if (ahead <= 0.0) continue;
      if (cap_ < 0.5 * M_PI) out = std::min(out, ahead * std::tan(cap_));
    }
    r = std::max(r, out);
  }
  return r;
}

double Coating::top_clearance(double r, double z) const {
  double c = 1e300;
  for (int s = 0; s < 2; ++s) {
    const double h = z - pair().height(s);
    const double from = std::hypot(r, h);
    c = std::min(c, std::fabs(from - (pair().radius(s) + t_)));
    if (cap_ < M_PI) {
      const double angle = std::fabs(std::atan2(r, s == 0 ? h : -h) - cap_);
      c = std::min(c, angle < 0.5 * M_PI ? from * std::sin(angle) : from);
    }
  }
  return c;
}

double Coating::lowest() const {
  if (cap_ == M_PI) return pair().height(0) - (pair().R1 + t_);
  return std::min(pair().height(0) + pair().R1 * std::cos(cap_), pair().height(1) - (pair().R2 + t_));
}
double Coating::highest() const {
  if (cap_ == M_PI) return pair().height(1) + (pair().R2 + t_);
  return std::max(pair().height(1) - pair().R2 * std::cos(cap_), pair().height(0) + (pair().R1 + t_));
}
double Coating::widest() const { return (std::max(pair().R1, pair().R2) + t_) * (cap_ < 0.5 * M_PI ? std::sin(cap_) : 1.0); }

void Coating::add_breaks(std::vector<double>& at) const {
  Shape::add_breaks(at);
  const double d = pair().distance(), S1 = pair().R1 + t_, S2 = pair().R2 + t_;
  std::vector<double> z = {pair().height(0) + (d * d + S1 * S1 - S2 * S2) / (2.0 * d)};
  for (int s = 0; s < 2; ++s) {
    const double S = pair().radius(s) + t_, towards_contact = s == 0 ? 1.0 : -1.0, h = pair().height(s);  // 1: the contact is above
    const double rim = std::sqrt(std::max(S * S - inner() * inner(), 0.0));
    for (double offset : {S, -S, rim, -rim, S * std::cos(cap_), pair().radius(s) * std::cos(cap_)})
      z.push_back(h + towards_contact * offset);
  }
  for (double v : z)
    if (v > lowest() && v < highest()) at.push_back(v);
}

std::string Coating::describe() const {
  std::ostringstream s;
  s << "coating, thickness " << t_;
  if (cap_ < M_PI) s << " up to " << cap_ / kDegree << " degrees from the contact";
  s << ", ring radius " << ring() << ", inner radius " << inner() << ", gap " << pair().gap;
  return s.str();
}

ShapeStyle coating_style() {
  return {"coating", {{"thickness"}, {"cap", ShapeOption::detail, 180.0}}, [](const ShapeRequest& r) -> std::unique_ptr<Shape> {
            const double cap = r["cap"] == 180.0 ? M_PI : r["cap"] * kDegree;
            const double thickness = r.has("thickness") ? r["thickness"] : Coating::thickness_for_volume(r.pair, r.volume, cap, r.inner);
            return std::make_unique<Coating>(r.pair, thickness, cap, r.inner);
          }};
}

}  // namespace mpdem
