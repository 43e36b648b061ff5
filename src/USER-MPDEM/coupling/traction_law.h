// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A traction law of the links between cement and grains: the force per area as a function of the separation of material
// point and foot point. A law is one class in one file, derived from TractionLawOf<itself>, and one line in
// traction_laws.h. It does not depend on nodes, grains and added mass. These only use its stiffness.
//
// The virtual functions of TractionLaw are called once a run. The members below are called in the loop over blocks of
// links. They belong to the class itself, and with_traction() of traction_laws.h compiles them into the loop. They work
// on eight links at a time, in the frame of the normal n of the grain's surface:
//
//   kName                  its keyword after `interface`
//   kFields                number of state variables of a link, at most kMostLinkFields of mpm/point_record.h. They
//                          rise from 0, in a link that was never loaded, to 1. The first is the damage of the link.
//   kLeavesResidue         see TractionLaw::leaves_residue()
//   State                  these variables for eight links: kFields times a vd
//   words()                the options after its name, see LawOption; the constructor gets the stiffness and their values
//   secant(delta, state)   stiffness kn and kt, at most stiffness(), of the traction kn delta_n n + kt delta_t
//   energy(delta, state)   per area, stored
//
// Laws with a state also have
//
//   update(delta, state)   updates the state for the separation, see TractionUpdate. Repetition changes nothing.
//   onset_share(delta)     traction of a link without damage over that at which its damage begins. A norm of the
//                          separation, but that compression counts as zero.
#ifndef MPDEM_COUPLING_TRACTION_LAW_H
#define MPDEM_COUPLING_TRACTION_LAW_H

#include <memory>
#include <string>
#include <vector>

#include "../material/law_list.h"
#include "../material/scatter.h"
#include "../material/vti_elasticity.h"
#include "../numerics/simd.h"

namespace mpdem {

// Stiffness of the links at the start, pressure per length. It is an upper bound of the tangent of every law.
struct TractionStiffness {
  double kn = 0, kt = 0;
};

// Separation of eight links.
struct LinkSeparation {
  vd n;       // delta_n, positive where the cement moved away from the grain
  vd square;  // square of the length of the whole separation
  vd tangential_square() const { return max(square - n * n, vd{}); }
};

inline LinkSeparation separation_of(const vd* delta, const vd* n) {
  return {delta[0] * n[0] + delta[1] * n[1] + delta[2] * n[2], delta[0] * delta[0] + delta[1] * delta[1] + delta[2] * delta[2]};
}

struct TractionSecant {
  vd kn, kt;
  // Energy per area of springs with this stiffness.
  vd energy(const LinkSeparation& s) const { return 0.5 * (kt * s.square + (kn - kt) * s.n * s.n); }
};

struct TractionUpdate {
  vd dissipated;        // energy per area that damage dissipates in this update
  vmask grown, debond;  // the state changed; the link carries no load from now on
};

// Length of the softening zone at a crack tip in a material of these elastic constants.
struct SofteningLength {
  double length;
  const char *formula, *cure;
};

class TractionLaw {
 public:
  explicit TractionLaw(TractionStiffness stiffness) : stiffness_(stiffness) {}
  virtual ~TractionLaw() = default;

  const TractionStiffness& stiffness() const { return stiffness_; }
  virtual const char* name() const = 0;
  virtual int fields() const = 0;
  // True if a link stays attached when its point fails. The failed point is then residue on the grain without force,
  // and the crack is inside the cement.
  virtual bool leaves_residue() const = 0;
  // Values of its options, in their order, at most LinkSettings::kMostParameters. Later runs must have the same values.
  virtual std::vector<double> parameters() const { return {}; }
  // Lengths that cells must resolve. Empty if there are none.
  virtual std::vector<SofteningLength> softening_lengths(const VtiConstants&) const { return {}; }
  // What is wrong with the combination of the options, or an empty string.
  virtual std::string trouble() const { return ""; }

  // Laws of the other materials of the scene, and scatter, as in Law (material/law.h). All laws are of one class.
  const TractionLaw& of_material(int n) const { return n == 0 || others_.empty() ? *this : *others_[static_cast<std::size_t>(n) - 1]; }
  int materials() const { return 1 + static_cast<int>(others_.size()); }
  void set_materials(std::vector<std::shared_ptr<const TractionLaw>> others) { others_ = std::move(others); }
  const Scatter& scatter() const { return scatter_; }
  void set_scatter(const Scatter& s) { scatter_ = s; }

 protected:
  // Laws are copied only as objects of their own class.
  TractionLaw(const TractionLaw&) = default;
  TractionLaw& operator=(const TractionLaw&) = default;

 private:
  TractionStiffness stiffness_;
  std::vector<std::shared_ptr<const TractionLaw>> others_;
  Scatter scatter_;
};

template <class L>
class TractionLawOf : public TractionLaw {
 public:
  using TractionLaw::TractionLaw;
  const char* name() const final { return L::kName; }
  int fields() const final { return L::kFields; }
  bool leaves_residue() const final { return L::kLeavesResidue; }
  // of_material() as an object of this class.
  const L& same_kind(int n) const { return static_cast<const L&>(of_material(n)); }
};

}  // namespace mpdem

#endif
