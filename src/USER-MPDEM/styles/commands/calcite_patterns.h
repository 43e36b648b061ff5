// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Contents over contacts of one command create_cement: chooses them (cement/creation/contact_contents.h), coats grains for
// the pattern `coating`, and reports what was reached.
#ifndef MPDEM_STYLES_COMMANDS_CALCITE_PATTERNS_H
#define MPDEM_STYLES_COMMANDS_CALCITE_PATTERNS_H

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "../../cement/creation/cement_plan.h"
#include "coat_grains.h"

namespace mpdem {

class CalcitePatterns {
 public:
  // groupbit, group: the grains that the contents refer to.
  CalcitePatterns(LAMMPS_NS::LAMMPS* lmp, int groupbit, std::string group, const SceneBox& box)
      : lmp_(lmp), groupbit_(groupbit), group_(std::move(group)), box_(box) {}

  // Collective. Returns the content of each pair of the plan, 0 where there is no cement. Throws BadState.
  std::vector<double> choose(const CementPlan& plan);
  // Collective, after the bonds were made. made: pairs that have cement now. Throws BadState if the calcite of a pattern
  // is off by more than 1 %.
  void finish(const CementPlan& plan, const std::vector<GrainTags>& skipped, const std::vector<GrainTags>& made);
  const std::string& report() const { return report_; }

 private:
  std::vector<double> contents_of(const CementPlan& plan);
  void sum_up(const CementPlan& plan, const std::vector<GrainTags>& skipped);
  void add_coats(const ContentWish& wish, double density);
  std::string text_of_draws(const ContentWish& wish) const;

  LAMMPS_NS::LAMMPS* lmp_;
  int groupbit_;
  std::string group_;
  SceneBox box_;
  std::vector<BareGrain> grains_;
  double grain_mass_ = 0.0;
  std::unique_ptr<ContactContents> contents_;
  std::map<GrainTags, PairToCement> pairs_;
  double mass_[ContentWish::kPatterns] = {0, 0, 0, 0};  // reached
  int bonds_[ContentWish::kPatterns] = {0, 0, 0, 0};
  double thickness_ = 0.0;  // thickness of the coats
  std::string report_;
};

}  // namespace mpdem

#endif
