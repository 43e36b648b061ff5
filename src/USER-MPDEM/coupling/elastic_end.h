// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// An elastic grain at one end of a bond. Its surface follows the links by few modes Phi (grain/surface_modes.h) and by soft
// springs in series with the links (grain/patch_compliance.h). With d_i the separation of link i in the frame of the grain,
// A_i its area, K'_i the stiffness of link and soft spring, and L L' the compliance of the modes, the energy is
//
//   U = min over q of  sum A_i (d_i - Phi_i q).K'_i (d_i - Phi_i q)/2 + q.(L L')^-1 q/2,
//
// so the load on the cement is -A_i K'_i (d_i - Phi_i q), with
//
//   q = M s,   s = sum A_i Phi_i' K'_i d_i,   M = ((L L')^-1 + S)^-1 = L (1 + L' S L)^-1 L',   S = sum A_i Phi_i' K'_i Phi_i.
//
// Where a grain has several bonds each moves the patches of the others as rigid bodies (grain/far_field.h), by w = sum of c F
// over the other bonds. With g = Phi'G, F the load of a patch, and w that of the others,
//
//   q = M s + H w,   F = g'(s - S q) = H's - k w,   H = (1 - M S) g,   k = g'S H.
//
// Links of a traction law with a state have its secant stiffness. A step finds q with the secants of the step before, updates the states
// for the separations of the links, which are d - Phi q less those of the soft springs, and finds q anew where secants changed. Links are
// closed where the cement lies below the undeformed surface, so that secants follow from states and positions alone.
//
// The surface is in equilibrium with the links at each time: it has neither inertia nor state. The energy is at most that of
// links K' to a rigid grain, so the added mass of these makes a step stable. S is a sum over chunks of links, in their order. Where
// links debond only their chunks are computed anew, so S is a function of the links that are attached, and not of their history.
//
// Vectors of modes have three numbers a scalar mode. They are in the axes of the patch, which rotate with the grain. Links
// are in blocks of eight, one per lane.
#ifndef MPDEM_COUPLING_ELASTIC_END_H
#define MPDEM_COUPLING_ELASTIC_END_H

#include <Eigen/Dense>
#include <array>
#include <memory>
#include <vector>

#include "../grain/patch_compliance.h"
#include "../mpm/bond_record.h"
#include "../numerics/simd.h"
#include "../numerics/tensor3.h"
#include "traction_law.h"

namespace mpdem {

class ElasticEnd {
 public:
  static constexpr int kMostModes = 64;  // scalar modes

  ElasticEnd() = default;  // a rigid grain
  // axes: those of the patch by columns, in the axes of the bond at creation; z points from the centre to the pole.
  ElasticEnd(std::shared_ptr<const PatchCompliance> patch, const Mat3<double>& axes);

  bool is_rigid() const { return !patch_; }
  const Mat3<double>& axes() const { return axes_; }
  int modes() const { return static_cast<int>(patch_ ? patch_->modes().scalars() : 0); }
  int size() const { return 3 * modes(); }
  // Stiffness of a link and the soft spring in series, and the share of their separation that the link takes.
  TractionSecant softened(const TractionSecant& k) const {
    const double c = tail();
    return {k.kn / (1.0 + c * k.kn), k.kt / (1.0 + c * k.kt)};
  }
  TractionSecant share_of_link(const TractionSecant& softened) const { return {1.0 - tail() * softened.kn, 1.0 - tail() * softened.kt}; }

  double softened(double k) const { return k / (1.0 + tail() * k); }

  // Blocks of links of this end. direction: of each link from the centre, unit vectors in the axes of the patch.
  void add_block(const vd* direction);
  // Adds forces of a block, area times traction, to the loads of the modes: modes() times 3 sums.
  void add_loads(std::size_t block, const vd* force, vd* sums) const;
  // Displacement of the surface at the links of a block; q: amplitudes, in the axes of the result.
  void displacement(std::size_t block, const double* q, vd* u) const;

  // Share of the blocks from `first` in S, as numbers to be summed: six components for each pair of modes. K: stiffness of the
  // links of each block times their area, zero if they are debonded.
  std::vector<double> stiffness(std::size_t first, const std::vector<TractionSecant>& K) const;
  // M, H and k of these sums.
  struct Response {
    Eigen::MatrixXd M;
    Eigen::Matrix<double, Eigen::Dynamic, 6> H;
    Eigen::Matrix<double, 6, 6> k;
  };
  Response response(const std::vector<double>& sums) const;
  std::size_t memory_usage() const { return values_.capacity() * sizeof(vd); }

 private:
  double tail() const { return patch_ ? patch_->tail() : 0.0; }
  struct Group {
    int harmonic, first, end;  // radial functions of a harmonic
  };
  std::shared_ptr<const PatchCompliance> patch_;
  Mat3<double> axes_;
  std::vector<Group> groups_;
  int radials_ = 0, stride_ = 0;
  std::vector<vd> values_;  // of each block: radial functions, harmonics, and the direction
};

// Both ends of a bond, at least one of them elastic, in a step.
struct ElasticEnds {
  static constexpr std::size_t kChunk = 32;  // blocks
  struct Side {
    ElasticEnd end;
    std::size_t first_block = 0;                      // of its links
    mutable std::vector<std::vector<double>> chunks;  // shares of kChunk blocks in S, empty: not known
    ElasticEnd::Response response;
    Eigen::VectorXd loads, of_all, amplitudes;  // s, share of this rank and of all; q
    Eigen::VectorXd debonded_loads, before;  // what s lost as links debonded or softened in this step; the new s for the positions before
    Eigen::VectorXd softened_from;           // s before links softened, until it is found anew
  };
  std::array<Side, 2> side;
  std::vector<TractionSecant> secants;        // of links and soft springs, for each block; empty: constant, or not known
  std::vector<std::array<int, kLanes>> tags;  // IDs of the points of these links, for a traction law with a state
  bool stiffness_changed = true;              // links debonded since M was found, or it is not known
  bool some_debonded = false;  // links debonded or softened in this step, of the bond on any rank, or of another bond on one of its grains
  bool coupled = false;        // one of the grains has other bonds
  double released = 0.0;       // energy, in this step
  std::size_t memory_usage() const;
};

// The patch of an elastic grain of a bond with the modes that cells of this size resolve, and its axes in those of the bond at creation.
std::shared_ptr<const PatchCompliance> patch_of(const BondRecord& record, int side, double cell);
Mat3<double> axes_of_patch(const BondRecord& record, int side);

// Rotates a vector of modes by R.
inline Eigen::VectorXd turned_modes(const Mat3<double>& R, const Eigen::VectorXd& modes) {
  const Eigen::Matrix3d turn = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&R.a[0][0]);
  Eigen::VectorXd out(modes.size());
  Eigen::Map<Eigen::Matrix3Xd>(out.data(), 3, modes.size() / 3) =
      turn * Eigen::Map<const Eigen::Matrix3Xd>(modes.data(), 3, modes.size() / 3);
  return out;
}

}  // namespace mpdem

#endif
