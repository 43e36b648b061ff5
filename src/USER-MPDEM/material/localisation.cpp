// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "localisation.h"

#include <Eigen/Dense>
#include <cmath>
#include <vector>

namespace mpdem {

namespace {

constexpr int kPerLength = 8;
constexpr double kHalfBar = 10.0;  // half of the length of the bar, in units of L
constexpr int kPoints = static_cast<int>(kHalfBar * kPerLength);
constexpr int kSteps = 60;  // steps of the damage in the middle
constexpr double kLargestLastChange = 1e-10;
constexpr int kMostIterations = 60;
constexpr double kLongestStep = 0.3;  // longest step of x and of the logarithm of the stress

// Averaging matrix of the points at i + 1/2 of a half bar, with mirror images at both ends.
Eigen::MatrixXd kernel() {
  Eigen::MatrixXd K(kPoints, kPoints);
  const auto gauss = [](double distance) { return std::exp(-0.5 * distance * distance / (kPerLength * kPerLength)); };
  for (int i = 0; i < kPoints; ++i)
    for (int j = 0; j < kPoints; ++j) K(i, j) = gauss(i - j) + gauss(i + j + 1) + gauss(2 * kPoints - 1 - i - j);
  for (int i = 0; i < kPoints; ++i) K.row(i) /= K.row(i).sum();
  return K;
}

// A state of the bar: x = -ln(1 - d) of the points, and the logarithm of sigma/sigma0.
struct State {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(kPoints);
  double log_stress = 0.0;
};

class Bar {
 public:
  explicit Bar(const std::function<SofteningCurve(double)>& curve_at) : K_(kernel()) {
    for (int i = 0; i < kPoints; ++i) curves_.push_back(curve_at((i + 0.5) / kPerLength));
  }

  // Finds the state with x = `middle` in the middle in which damage grows at the first `growing` points alone. Returns false if
  // Newton's method finds none. As x[0] is given, the stress is the first unknown, in column 0 of J. x of the other points follows.
  bool solve(int growing, double middle, const State& before, State& s) const {
    s.x.tail(kPoints - growing) = before.x.tail(kPoints - growing);
    s.x[0] = middle;
    Eigen::VectorXd root(kPoints), slope(kPoints);
    for (int k = 0; k < kMostIterations; ++k) {
      for (int i = 0; i < kPoints; ++i) {
        const SofteningCurve::Value c = curves_[i].compliance(s.x[i]);
        root[i] = std::exp(0.5 * (s.log_stress + c.value));
        slope[i] = 0.5 * root[i] * c.slope;
      }
      Eigen::VectorXd rest = K_.topRows(growing) * root;
      Eigen::MatrixXd J(growing, growing);
      J.col(0) = 0.5 * rest;
      for (int j = 1; j < growing; ++j) J.col(j) = K_.col(j).head(growing) * slope[j];
      for (int i = 0; i < growing; ++i) {
        const SofteningCurve::Value t = curves_[i].threshold(s.x[i]);
        const double limit = std::exp(0.5 * t.value);
        rest[i] -= limit;
        if (i > 0) J(i, i) -= 0.5 * limit * t.slope;
      }
      Eigen::VectorXd change = J.partialPivLu().solve(-rest);
      const double most = change.cwiseAbs().maxCoeff();
      if (!std::isfinite(most)) return false;
      if (most > kLongestStep) change *= kLongestStep / most;
      s.log_stress += change[0];
      s.x.segment(1, growing - 1) += change.tail(growing - 1);
      if (most < kLargestLastChange) return true;
    }
    return false;
  }

  // Energy per area that damage takes between two states, by the trapezoidal rule in 1/c.
  double work(const State& from, const State& to) const {
    double sum = 0.0;
    for (int i = 0; i < kPoints; ++i) {
      const double c0 = curves_[i].compliance(from.x[i]).value, c1 = curves_[i].compliance(to.x[i]).value;
      if (c0 == c1) continue;
      const auto square_strain = [](const State& s, double c) { return std::exp(2.0 * (s.log_stress + c)); };
      sum += 0.25 * (square_strain(from, c0) + square_strain(to, c1)) * (std::exp(-c0) - std::exp(-c1));
    }
    return 2.0 / kPerLength * sum;
  }
  // Energy per area that the band stores beyond the bar around it.
  double stored(const State& s) const {
    double sum = 0.0;
    for (int i = 0; i < kPoints; ++i) sum += 0.5 * std::exp(2.0 * s.log_stress) * std::expm1(curves_[i].compliance(s.x[i]).value);
    return 2.0 / kPerLength * sum;
  }

 private:
  std::vector<SofteningCurve> curves_;
  Eigen::MatrixXd K_;
};

bool falls(const State& s, const State& before, int growing) { return ((s.x - before.x).segment(1, growing - 1).array() < -1e-12).any(); }

}  // namespace

std::optional<Localisation> localise(const SofteningCurve& curve, double cutoff) {
  return localise([&curve](double) { return curve; }, cutoff);
}

std::optional<Localisation> localise(const std::function<SofteningCurve(double)>& curve_at, double cutoff) {
  const Bar bar(curve_at);
  const double end = -std::log(1.0 - cutoff);
  State before;
  int growing = 0, widest = 0;
  double energy = 0.0;
  for (int step = 1; step <= kSteps; ++step) {
    const double middle = end * step / kSteps;
    State found;
    bool any = false;
    if (step == 1) {
      // Searches the longest interval without a point that would heal. A quarter of a cosine wave is the first guess.
      for (int n = 2; n < kPoints; ++n) {
        State s;
        s.log_stress = -0.1 * middle;
        for (int i = 0; i < n; ++i) s.x[i] = middle * std::cos(0.5 * M_PI * (i + 0.5) / n);
        if (!bar.solve(n, middle, before, s) || falls(s, before, n)) break;
        any = true;
        growing = n;
        found = s;
      }
    } else {
      for (int n = std::min(growing + 1, kPoints - 1); n > 0 && !any; --n) {
        State s = before;
        if (!bar.solve(n, middle, before, s) || falls(s, before, n)) continue;
        any = true;
        growing = n;
        found = s;
      }
    }
    if (!any || found.log_stress >= 0.0 || growing > kPoints - kPerLength) return std::nullopt;  // no band, or too wide
    energy += bar.work(before, found);
    widest = std::max(widest, growing);
    before = found;
  }
  return Localisation{2.0 * widest / kPerLength, energy + bar.stored(before), energy};
}

}  // namespace mpdem
