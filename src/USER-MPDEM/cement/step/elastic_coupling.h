// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Bonds on one elastic grain act on each other: the load of each moves the patches of the others as rigid bodies
// (grain/far_field.h). With F0 and k of coupling/elastic_end.h, the loads F and motions w of the patches of a grain are
//
//   w = C F,   F = F0 - k w,   so   (1 + k C) F = F0.
//
// C has no blocks on its diagonal. Patches near each other may move each other more than six loads can tell. So that the grain
// has positive energy, C is reduced until no load makes the patches of rigid bodies do more than kMostNegative of their own work.
#ifndef MPDEM_CEMENT_STEP_ELASTIC_COUPLING_H
#define MPDEM_CEMENT_STEP_ELASTIC_COUPLING_H

#include <mpi.h>

#include <Eigen/Dense>
#include <map>
#include <utility>
#include <vector>

#include "../../grain/far_field.h"
#include "../bond/bond.h"

namespace mpdem {

class ElasticCoupling {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  // Finds the bonds that share elastic grains, the same on all ranks. None may be condensed.
  void find(const Bonds& bonds, double cell);
  // Ends, one for each such bond and grain. Index of an end; -1 if its bond is alone on the grain.
  int end_of(int bond_row, int side) const;
  std::size_t ends() const { return loads_.size(); }
  bool is_coupled(int bond_row) const { return end_of(bond_row, 0) >= 0 || end_of(bond_row, 1) >= 0; }

  // Of all ends, the same on all ranks.
  void set_stiffness(const std::vector<Matrix6>& k);
  // Finds the motions of the patches for these F0.
  void find_motions(const std::vector<Vector6>& loads);
  const Vector6& motion(int end) const { return motions_[static_cast<std::size_t>(end)]; }
  // Ends on a grain on which one of these bonds has an end.
  std::vector<char> neighbours(const std::vector<char>& of_ends) const;

 private:
  struct OnGrain {
    std::vector<int> ends;
    Eigen::MatrixXd C;
    Eigen::PartialPivLU<Eigen::MatrixXd> equations;  // 1 + k C
  };
  std::vector<OnGrain> grains_;
  std::map<std::pair<int, int>, int> end_of_;           // by row and side
  std::map<std::pair<int, int>, FarField> far_fields_;  // of these, and of bonds that were resolved before
  std::vector<Vector6> loads_, motions_;
};

}  // namespace mpdem

#endif
