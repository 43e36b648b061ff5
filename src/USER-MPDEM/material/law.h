// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A damage law: elasticity, and how it loses stiffness until a point fails. A law is one class in one file, derived
// from LawOf<itself>, and one line in laws.h.
//
// Virtual functions of Law are called once a run or once a report. The members below are called in loops over points.
// They belong to the class itself, and with_law() of laws.h compiles them into the loops. They work on eight points at
// a time, in the material frame:
//
//   kName, kFields        its name after `damage`; numbers that a point keeps, at most kMostFields.
//                         All of them are 0 in a point without damage.
//   State                 these numbers for eight points: kFields times a vd
//   words()               the options after its name, see LawOption; the constructor takes their values
//   square_bound(stress, strain)       upper bound of Yeq^2 of undamaged points, without eigenvalues
//   rough_bound(stress, strain)        upper bound of that, in few operations: most points go no further
//   threshold()           B of undamaged points that touch no grain
//   interface()           factor on B of points that touch a grain
//   growth(dt)            share of the growth that a step allows, 1 without viscosity
//   softening()           parameter of the curve by which a point softens, if its position does not matter; else softening_at()
//   drive(strain, state, softening)    driving force Yeq and its threshold B: damage grows where Yeq is above B
//   stress(strain, state)
//   undamaged_drive(strain)            Yeq of the material without damage in that strain
//   kDegree               Yeq of a strain c times as large is c^kDegree times as large, 1 or 2
//   lowest_threshold()    the least B that a point can have
//   trial(strain, state, softening)    stress, and bounds of Yeq and B, see LawTrial
//   update(strain_start, strain, state, active, strength, growth, softening)    the step, see LawUpdate
//   largest_damage(state), damage(state)      from 0 to 1; as a tensor, for output
//   opening(strain, state)    tensor whose first principal axis is the normal of the crack, for output
//   column(k, strain, state)  column k of columns()
//
// `strength` is the factor on B of each lane, `softening` its softening(). A law without fields does no damage. It
// needs only words() and the members that output uses.
#ifndef MPDEM_MATERIAL_LAW_H
#define MPDEM_MATERIAL_LAW_H

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "../numerics/simd.h"
#include "law_list.h"
#include "localisation.h"
#include "scatter.h"
#include "vti_elasticity.h"

namespace mpdem {

// Result of a step of damage, with its energies.
struct LawUpdate {
  Sym3<vd> stress;
  vd dissipated;  // energy per volume spent in this step by growth of damage
  vd released;    // energy per volume given up by lanes that fail now
  vmask grown, failed;
  int evaluations;  // evaluations of the law or of its derivative, for eight points each
};

// Stress, and bounds without eigenvalues. Damage may grow only if square_bound is above the square of least_threshold.
struct LawTrial {
  Sym3<vd> stress;
  vd square_bound;     // upper bound of Yeq^2
  vd least_threshold;  // lower bound of B
};

struct LawDrive {
  vd Yeq, B;
};

// Strength that the parameters imply for uniaxial stress along a direction of modulus E.
struct ImpliedStrength {
  double tensile_strength, onset_strain, failure_strain, work_per_volume;
};

class Law {
 public:
  static constexpr int kMostFields = 6, kMostWords = 8;

  explicit Law(const VtiElasticity& elasticity) : elasticity_(elasticity) {}
  virtual ~Law() = default;

  const VtiElasticity& elasticity() const { return elasticity_; }
  virtual const char* name() const = 0;
  virtual int fields() const = 0;
  // True if the law does no damage. Points then have no state, and none fails.
  bool inert() const { return fields() == 0; }
  // Degree of the law, see kDegree.
  virtual int degree() const = 0;

  // Values of the options of the law, in the order of words(). The value of an option with choices is the index of the chosen one.
  virtual std::vector<double> values() const = 0;
  // Largest damage of a point that has not failed.
  virtual double cutoff() const { return 0.0; }
  virtual ImpliedStrength implied_strength(double E) const = 0;
  // The rest of the message "cement fails at a strain of 3, ...": the numbers that cause this and what to check.
  virtual std::string advice_on_strain() const { return ""; }
  // Lines of the report of fix mpm.
  virtual std::string report(double cell) const = 0;
  // Lines with implied_strength() along the axis and in the plane.
  std::string report_of_strength() const;

  // True if the softening of the law can be chosen so that a crack takes the energy G_f per area.
  virtual bool has_crack_energy() const { return false; }
  // The energy per area for which the softening was chosen; 0: none.
  virtual double crack_energy() const { return 0.0; }
  // Chooses the softening so for cells of this width. Throws std::domain_error with the allowed range if there is no such softening.
  virtual void set_crack_energy(double /* G_f */, double /* cell */) {}

  // Length over which strain is averaged, see mpm/drive_average.h; 0: none.
  double length() const { return length_; }
  // Sets this length. G_f: energy per area for which the softening is chosen, for laws with has_crack_energy(); 0: the
  // softening stays. Throws as set_crack_energy() does.
  virtual void set_nonlocal(double length, double /* G_f */) { length_ = length; }
  // Softening of a point at these distances from the surfaces of its grains, a number that only the law interprets.
  // Called where softens_by_position().
  virtual double softening_at(double /* d0 */, double /* d1 */) const { return 0.0; }
  virtual bool softens_by_position() const { return false; }
  // Softening of a layer of this thickness between two grains that is strained evenly.
  virtual double softening_of_layer(double /* thickness */) const { return 0.0; }
  // Curve of the law in uniaxial tension, from which the band of a crack follows. Empty if the law has no curve.
  virtual std::optional<SofteningCurve> softening_curve() const { return std::nullopt; }
  // Band in which the material breaks, for a law with a length. Empty if it is not known.
  std::optional<Localisation> crack_band() const;

  // Softening of points whose crack takes this many times the energy for which it was chosen. Called where a material has
  // scatter of its energy, which only laws with can_scatter_energy() may have.
  virtual double softening_for(double /* times */) const { return 0.0; }
  virtual bool can_scatter_energy() const { return false; }

  // Other materials of the scene. This law is that of material 0 and has the others, of the same class.
  const Law& of_material(int n) const { return n == 0 ? *this : *others_[static_cast<std::size_t>(n) - 1]; }
  int materials() const { return 1 + static_cast<int>(others_.size()); }
  void set_materials(std::vector<std::shared_ptr<const Law>> others) { others_ = std::move(others); }
  // Scatter of this material.
  const Scatter& scatter() const { return scatter_; }
  void set_scatter(const Scatter& s) { scatter_ = s; }
  // Density of this material, mass per volume; 0: that of the scene (cement_density.h).
  double density() const { return density_; }
  void set_density(double density) { density_ = density; }
  // Does one of the materials have scatter of this kind, or any scatter?
  bool any_scatter(Scattered what) const;
  bool any_scatter() const;

  // Names of the columns of compute mpm/atom that this law adds.
  virtual std::vector<std::string> columns() const { return {}; }
  // True if the state is a damage tensor (xx yy zz yz xz xy) in the material frame.
  virtual bool state_is_tensor() const { return false; }
  // Finds the numbers of the state from a damage tensor (xx yy zz yz xz xy) that a file gave. Throws std::domain_error
  // if no state has that damage.
  virtual void state_from_tensor(const double* D, double* state) const = 0;

 protected:
  // Laws are copied as objects of their own class alone.
  Law(const Law&) = default;
  Law& operator=(const Law&) = default;
  // Line of the report of fix mpm with band and energy of a crack that the length implies.
  std::string report_of_band(double cell) const;

 private:
  VtiElasticity elasticity_;
  double length_ = 0.0, density_ = 0.0;
  std::vector<std::shared_ptr<const Law>> others_;
  Scatter scatter_;
};

template <class L>
class LawOf : public Law {
 public:
  using Law::Law;
  const char* name() const final { return L::kName; }
  int fields() const final { return L::kFields; }
  int degree() const final {
    if constexpr (L::kFields > 0) return L::kDegree;
    return 2;
  }
};

}  // namespace mpdem

#endif
