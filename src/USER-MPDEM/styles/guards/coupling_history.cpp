// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "coupling_history.h"

#include <algorithm>
#include <cmath>

#include "../../coupling/traction_laws.h"
#include "../../parallel/agree.h"

namespace mpdem {

namespace {

// mu: negative for none.
std::string with_friction(double mu, const char* none) { return mu < 0.0 ? none : text_of("'friction ", mu, "'"); }

}  // namespace

std::string CouplingHistory::take(const std::string& id, const std::string& cement, double cell, const PenaltyParameters& p) {
  if (!needed_) return text_of("fix mpm (id ", cement, ") has 'coupling none'; use it without that, or this fix not at all");
  if (!id_.empty() && id != id_) return text_of("cement '", cement, "' is coupled by fix '", id_, "' already; unfix one of them");
  if (ran_.kind == LinkSettings::kNone)
    return text_of("cement '", cement,
                   "' made steps without a fix mpm/couple, in which the grains went elsewhere, and its links "
                   "would tear; keep one fix mpm/couple from the first step on, or create the cement anew in a new scene "
                   "(write_cement, create_cement ... file)");
  if (ran_.kind == LinkSettings::kLinks) {
    constexpr double kAsPrinted = 1e-5;  // relative difference of a number that was copied from a message
    const auto differ = [](double a, double b) { return std::fabs(a - b) > kAsPrinted * b; };
    if (p.at_surface != ran_.at_surface)
      return text_of("'at ", p.at_surface ? "surface" : "points", "', but the steps before were made with 'at ",
                     ran_.at_surface ? "surface" : "points", "', and the load of the bonds would jump; use that");
    const TractionStiffness k = p.law->stiffness();
    if (differ(k.kn, ran_.kn) || differ(k.kt, ran_.kt))
      return text_of("'kn' and 'kt' over 'length' are ", k.kn, " and ", k.kt, ", but were ", ran_.kn, " and ", ran_.kt,
                     " in the steps before, and the load of the bonds would jump; use 'kn ", ran_.kn * cell, " kt ", ran_.kt * cell,
                     "' with 'length cell', as in these");
    const std::vector<double> values = p.law->parameters();
    bool same = traction_law_number(*p.law) == ran_.law;
    for (std::size_t i = 0; i < values.size(); ++i) same = same && !differ(values[i], ran_.parameter[i]);
    if (p.friction != ran_.friction && differ(p.friction, ran_.friction))
      return text_of(with_friction(p.friction, "no 'friction'"), ", but the steps before were made with ",
                     with_friction(ran_.friction, "none"), ", and the load of the bonds would jump; use that");
    if (!same)
      return text_of("'interface ", p.law->name(), "' with these words is not that of the steps before: '", words_so_far(), "'; use that");
  }
  id_ = id;
  return "";
}

std::string CouplingHistory::trouble_without(bool restored) const {
  if (!needed_) return "";
  return text_of("there is no fix mpm/couple, so that the cement bonds nothing", ran_.kind == LinkSettings::kLinks ? " any more" : "",
                 "; define one after this fix", restored ? ", after read_restart too" : "",
                 ", or use 'coupling none' for cement that no grain holds");
}

// Returns the options of the traction law of the earlier steps, as in a script.
std::string CouplingHistory::words_so_far() const {
  const std::vector<TractionEntry>& entries = traction_entries();
  if (ran_.law < 1 || ran_.law > static_cast<int>(entries.size())) return text_of("number ", ran_.law, " of another program");
  const TractionEntry& law = entries[ran_.law - 1];
  std::string words = "interface " + law.name;
  for (std::size_t i = 0; i < law.words.size(); ++i) words += text_of(" ", law.words[i].name, " ", ran_.parameter[i]);
  return words;
}

void CouplingHistory::remember(const PenaltyParameters* p) {
  ran_.kind = p ? LinkSettings::kLinks : LinkSettings::kNone;
  if (!p) return;
  ran_.kn = p->law->stiffness().kn;
  ran_.kt = p->law->stiffness().kt;
  ran_.at_surface = p->at_surface;
  ran_.friction = p->friction;
  ran_.law = traction_law_number(*p->law);
  const std::vector<double> values = p->law->parameters();
  std::copy(values.begin(), values.end(), ran_.parameter);
}

}  // namespace mpdem
