// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "calcite_patterns.h"

#include <algorithm>
#include <cmath>

#include "../../cement/creation/broadcast_file.h"
#include "../atoms/atom_vec_mpdem.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {
constexpr double kMostOff = 0.01;  // of the calcite of a pattern
}

std::vector<double> CalcitePatterns::choose(const CementPlan& plan) {
  try {
    return contents_of(plan);
  } catch (const BadState& e) {
    throw BadState(text_of("create_cement contacts ", group_, ": ", e.what()));
  }
}

std::vector<double> CalcitePatterns::contents_of(const CementPlan& plan) {
  const ContentWish& wish = plan.wish().contents;
  grains_ = bare_grains(lmp_, groupbit_);
  grain_mass_ = 0.0;
  for (const BareGrain& g : grains_) grain_mass_ += g.mass;
  std::vector<PairToCement> pairs;
  std::vector<GrainTags> tags;
  for (const PlannedBond& b : plan.bonds()) {
    tags.emplace_back(b.grain[0].tag, b.grain[1].tag);
    pairs.push_back({tags.back(), b.pair.gap, std::min(b.pair.R1, b.pair.R2), b.grain[0].mass + b.grain[1].mass});
    pairs_.emplace(tags.back(), pairs.back());
  }
  std::map<GrainTags, double> by_pair;
  if (wish.spread == ContentWish::file) {
    std::string trouble;
    const std::string text = broadcast_file(lmp_->world, wish.file_name, trouble);
    if (!trouble.empty()) throw BadState(trouble);
    by_pair = read_contents(text, wish.file_name, tags);
  }
  double content = 1.0;
  for (const ShapeWords& w : plan.wish().shapes)
    if (const auto given = w.given.find("content"); given != w.given.end()) content = given->second;
  contents_ = std::make_unique<ContactContents>(wish, content, grain_mass_, std::move(by_pair));
  return contents_->choose(pairs, [&](std::size_t n) {
    try {
      return plan.content_bounds(plan.bonds()[n]);
    } catch (const ShapeError& e) {
      throw BadState(text_of("grains ", tags[n].first, " and ", tags[n].second, ": ", e.what()));
    }
  });
}

void CalcitePatterns::sum_up(const CementPlan& plan, const std::vector<GrainTags>& skipped) {
  // Several bonds of a pair may be in the table. Those of this command are the last, and replace the others here.
  std::map<GrainTags, const BondRecord*> records;
  for (const BondRecord& b : AtomVecMpdem::of(lmp_)->bonds.table) records[{b.grain[0], b.grain[1]}] = &b;
  for (const PlannedBond& b : plan.bonds()) {
    const GrainTags tags(b.grain[0].tag, b.grain[1].tag);
    if (std::find(skipped.begin(), skipped.end(), tags) != skipped.end()) continue;
    const ContentWish::Pattern p = contents_->pattern_of(pairs_.at(tags));
    mass_[p] += records.at(tags)->mass(plan.wish().density);
    ++bonds_[p];
  }
}

void CalcitePatterns::add_coats(const ContentWish& wish, double density) {
  const double mass = wish.calcite * wish.pattern[ContentWish::coating] * grain_mass_;
  std::vector<double> radii;
  for (const BareGrain& g : grains_) radii.push_back(g.radius);
  thickness_ = coat_of_mass(radii, density, mass,
                            text_of("create_cement contacts ", group_, ": 'calcite ", wish.calcite, "' with 'pattern ... coating ",
                                    wish.pattern[ContentWish::coating], "'"));
  coat(lmp_, grains_, {thickness_, density, wish.coat_at_walls}, box_);
  mass_[ContentWish::coating] = density * volume_of_coats(radii, thickness_);
}

std::string CalcitePatterns::text_of_draws(const ContentWish& wish) const {
  const int chosen = contents_->cemented(ContentWish::contact) + contents_->cemented(ContentWish::bridging),
            all = contents_->candidates(ContentWish::contact) + contents_->candidates(ContentWish::bridging);
  std::string text;
  if (chosen < all)
    text += text_of("  ", chosen, " of ", all,
                    wish.nearest ? " pairs, those of the smallest gap, got cement\n" : " pairs were drawn to get cement\n");
  if (contents_->cut() > 0) text += text_of("  the contents of ", contents_->cut(), " bonds were set to what their shape allows\n");
  return text;
}

void CalcitePatterns::finish(const CementPlan& plan, const std::vector<GrainTags>& skipped, const std::vector<GrainTags>& made) {
  const ContentWish& wish = plan.wish().contents;
  if (!wish.acts()) return;
  report_ = text_of_draws(wish);
  if (wish.calcite == 0.0) return;
  sum_up(plan, skipped);
  if (wish.pattern[ContentWish::coating] > 0.0) {
    add_coats(wish, plan.wish().density_of(plan.wish().material));
    AtomVecMpdem::of(lmp_)->coats.touch_bare(made);
  }
  mass_[ContentWish::filling] = wish.calcite * wish.pattern[ContentWish::filling] * grain_mass_;
  double sum = 0.0;
  for (double m : mass_) sum += m;
  report_ += text_of("  calcite over the mass of the grains: asked ", wish.calcite, ", reached ", sum / grain_mass_, "\n");
  std::string trouble;
  for (int p = 0; p < ContentWish::kPatterns; ++p) {
    if (wish.pattern[p] == 0.0) continue;
    const double reached = mass_[p] / grain_mass_, asked = wish.calcite * wish.pattern[p];
    report_ += text_of("    ", pattern_names()[p], ": asked ", asked, ", reached ", reached, ", share ", mass_[p] / sum);
    if (p == ContentWish::coating) report_ += text_of(", ", thickness_, " thick on ", grains_.size(), " grains\n");
    else if (p == ContentWish::filling) report_ += ", counted alone: it has no mass in the scene\n";
    else report_ += text_of(" at ", bonds_[p], p == ContentWish::contact ? " contacts\n" : " gaps\n");
    if (trouble.empty() && std::fabs(reached - asked) > kMostOff * asked)
      trouble = text_of("create_cement contacts ", group_, ": 'pattern ... ", pattern_names()[p], "' of 'calcite ", wish.calcite,
                        "' asks for ", asked, " of the mass of the grains of group '", group_, "', and its bonds have ", reached,
                        ", since others leave them no room; use a smaller 'calcite' or share");
  }
  if (!trouble.empty()) throw BadState(trouble);
}

}  // namespace mpdem
