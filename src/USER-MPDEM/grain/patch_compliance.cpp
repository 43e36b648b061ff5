// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "patch_compliance.h"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "polar_rule.h"

namespace mpdem {

namespace {

// A vector mode is a sum of terms: the radial function, times a function of the polar angle, times cos or sin of an order of
// the angle about the pole, along n, along the meridian or across it.
struct Term {
  enum Along { radial, meridian, across } along;
  enum Of { one, cosine, sine } of;
  int order;
  bool is_sine;
  double factor;
};

// Adds g times cos(phi), or sin(phi), times the harmonic.
void add_product(std::vector<Term>& terms, Term::Along along, Term::Of of, SurfaceModes::Harmonic h, bool by_sine, double factor) {
  const int m = h.order;
  const auto add = [&](int order, bool is_sine, double f) {
    if (order < 0) order = -order, f = is_sine ? -f : f;
    if (!(is_sine && order == 0)) terms.push_back({along, of, order, is_sine, f});
  };
  const double half = 0.5 * factor;
  if (!by_sine) {
    add(m - 1, h.sine, half);
    add(m + 1, h.sine, half);
  } else if (!h.sine) {
    add(m + 1, true, half);
    add(m - 1, true, -half);
  } else {
    add(m - 1, false, half);
    add(m + 1, false, -half);
  }
}

std::vector<Term> terms_of(SurfaceModes::Harmonic h, int direction) {
  const double norm = h.order == 0 ? 1.0 / std::sqrt(2.0 * M_PI) : 1.0 / std::sqrt(M_PI);
  std::vector<Term> terms;
  if (direction == 2) {
    terms.push_back({Term::radial, Term::cosine, h.order, h.sine, norm});
    terms.push_back({Term::meridian, Term::sine, h.order, h.sine, -norm});
    return terms;
  }
  const bool y = direction == 1;
  add_product(terms, Term::radial, Term::sine, h, y, norm);
  add_product(terms, Term::meridian, Term::cosine, h, y, norm);
  add_product(terms, Term::across, Term::one, h, !y, y ? norm : -norm);
  return terms;
}

// Integrals of radial functions, times `one`, `cosine` or `sine`, times P, its slope, and order P/sin, over the patch.
struct Integrals {
  std::array<std::array<Eigen::VectorXd, 3>, 3> of;  // [Term::Of][P, slope, P over sine]
};

class Compliance {
 public:
  Compliance(const SurfaceModes& modes, double nu) : modes_(modes), nu_(nu) {
    // A harmonic of degree pi/width has half a wave over the width of the patch.
    const double width = modes.outer() - modes.inner();
    constexpr double kDegrees = 24.0;  // the sum over degrees ends at this over the width
    highest_ = static_cast<int>(std::ceil(kDegrees / width));
    rule_ = polar_rule(modes.inner(), modes.outer(), 4 * modes.radials() + static_cast<int>(kDegrees) + 16);
    radial_.resize(modes.radials(), static_cast<Eigen::Index>(rule_.angle.size()));
    for (std::size_t i = 0; i < rule_.angle.size(); ++i)
      modes.find_radials(std::cos(rule_.angle[i]), radial_.col(static_cast<Eigen::Index>(i)).data());
    for (const SurfaceModes::Scalar& s : modes.modes())
      for (int d = 0; d < 3; ++d) terms_.push_back(terms_of(modes.harmonics()[s.harmonic], d));
  }

  Eigen::MatrixXd find() {
    const Eigen::Index n = modes_.size();
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(n, n);
    for (int order = 0; order <= modes_.orders() + 1; ++order)
      for (LegendreFunctions P(order, rule_.angle); P.degree() <= highest_; P.next()) add_degree(P, order, B);
    return 0.5 * (B + B.transpose());
  }

 private:
  void add_degree(const LegendreFunctions& P, int order, Eigen::MatrixXd& B) {
    const Eigen::Index points = radial_.cols();
    Integrals integrals;
    Eigen::VectorXd values(points);
    for (int of = 0; of < 3; ++of)
      for (int k = 0; k < 3; ++k) {
        for (Eigen::Index i = 0; i < points; ++i) {
          const double c = std::cos(rule_.angle[i]), s = std::sin(rule_.angle[i]);
          const double p = k == 0 ? P.value()[i] : k == 1 ? P.slope()[i] : order * P.value()[i] / s;
          values[i] = rule_.weight[i] * p * (of == Term::one ? 1.0 : of == Term::cosine ? c : s);
        }
        integrals.of[of][k] = (order == 0 ? 2.0 * M_PI : M_PI) * (radial_ * values);
      }
    const SphereResponse a = sphere_response(P.degree(), nu_);
    const double l = P.degree(), twice = l * (l + 1.0);
    for (bool sine : {false, true}) {
      if (sine && order == 0) continue;
      Eigen::MatrixXd t = Eigen::MatrixXd::Zero(modes_.size(), 3);  // t_r, t_s, t_t of each vector mode
      for (Eigen::Index j = 0; j < t.rows(); ++j)
        for (const Term& term : terms_[j]) add(term, order, sine, integrals, modes_.modes()[j / 3].radial, t, j);
      if (twice > 0.0) t.rightCols<2>() /= twice;
      Eigen::MatrixXd u(t.rows(), 3);
      u.col(0) = a.rr * t.col(0) + a.rs * t.col(1);
      u.col(1) = twice * (a.sr * t.col(0) + a.ss * t.col(1));
      u.col(2) = twice * a.tt * t.col(2);
      B.noalias() += t * u.transpose();
    }
  }

  // Projections of a term on the harmonic: P n, grad and n x grad.
  static void add(const Term& term, int order, bool sine, const Integrals& integrals, int radial, Eigen::MatrixXd& t, Eigen::Index j) {
    if (term.order != order) return;
    const auto of = [&](int k) { return term.factor * integrals.of[term.of][k][radial]; };
    const bool same = term.is_sine == sine;
    const double sign = sine ? 1.0 : -1.0;
    if (term.along == Term::radial && same) t(j, 0) += of(0);
    if (term.along == Term::meridian && same) t(j, 1) += of(1);
    if (term.along == Term::across && !same) t(j, 1) += sign * of(2);
    if (term.along == Term::across && same) t(j, 2) += of(1);
    if (term.along == Term::meridian && !same) t(j, 2) -= sign * of(2);
  }

  const SurfaceModes& modes_;
  double nu_;
  int highest_;
  PolarRule rule_;
  Eigen::MatrixXd radial_;  // radial functions by points
  std::vector<std::vector<Term>> terms_;
};

}  // namespace

Eigen::MatrixXd compliance_of_modes(const SurfaceModes& modes, double nu) { return Compliance(modes, nu).find(); }

PatchCompliance::PatchCompliance(const SurfaceModes& modes, const GrainElasticity& grain, double radius) : modes_(modes), radius_(radius) {
  Eigen::MatrixXd B = radius / grain.shear_modulus() * compliance_of_modes(modes, grain.nu);
  tail_ = 0.5 * Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(B, Eigen::EigenvaluesOnly).eigenvalues()[0];
  B.diagonal().array() -= tail_;
  factor_ = B.llt().matrixL();
  find_rigid();
}

// Modes are linear combinations of the harmonics of order 0 and 1 where they move the patch as a rigid body.
void PatchCompliance::find_rigid() {
  constexpr int kAround = 12;
  const PolarRule rule = polar_rule(modes_.inner(), modes_.outer(), 2 * modes_.radials() + 8);
  rigid_.setZero(modes_.size(), 6);
  std::vector<double> radial(modes_.radials()), harmonic(modes_.harmonics().size());
  for (std::size_t i = 0; i < rule.angle.size(); ++i) {
    const double c = std::cos(rule.angle[i]), s = std::sin(rule.angle[i]);
    modes_.find_radials(c, radial.data());
    for (int k = 0; k < kAround; ++k) {
      const double phi = 2.0 * M_PI * k / kAround;
      modes_.find_harmonics(std::cos(phi), std::sin(phi), harmonic.data());
      Eigen::Matrix<double, 3, 6> G;
      G.leftCols<3>().setIdentity();
      const Eigen::Vector3d r = radius_ * Eigen::Vector3d(s * std::cos(phi), s * std::sin(phi), c);
      for (int d = 0; d < 3; ++d) G.col(3 + d) = Eigen::Vector3d::Unit(d).cross(r);
      G *= radius_ * rule.weight[i] * 2.0 * M_PI / kAround;  // values of the modes over the radius, areas times its square
      for (int j = 0; j < modes_.scalars(); ++j)
        rigid_.middleRows<3>(3 * j) += radial[modes_.modes()[j].radial] * harmonic[modes_.modes()[j].harmonic] * G;
    }
  }
}

Eigen::Matrix<double, 6, 6> PatchCompliance::of_rigid_patch() const {
  const Eigen::MatrixXd y = factor_.triangularView<Eigen::Lower>().solve(rigid_);
  return (y.transpose() * y).inverse();
}

std::shared_ptr<const PatchCompliance> PatchCompliance::of(double inner, double outer, int degree, int orders, const GrainElasticity& grain,
                                                           double radius) {
  static std::map<std::array<double, 7>, std::weak_ptr<const PatchCompliance>> known;
  std::weak_ptr<const PatchCompliance>& found = known[{inner, outer, double(degree), double(orders), grain.E, grain.nu, radius}];
  std::shared_ptr<const PatchCompliance> patch = found.lock();
  if (!patch) {
    patch = std::make_shared<PatchCompliance>(SurfaceModes(inner, outer, degree, orders), grain, radius);
    found = patch;
  }
  return patch;
}

}  // namespace mpdem
