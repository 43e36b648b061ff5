// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Reads the keywords of fix mpm in the script, see doc/fix_mpm.md.
#ifndef MPDEM_STYLES_WORDS_FIX_MPM_WORDS_H
#define MPDEM_STYLES_WORDS_FIX_MPM_WORDS_H

#include <memory>
#include <string>
#include <vector>

#include "../../cement/bond/options.h"
#include "../../material/law.h"
#include "material_words.h"
#include "word_rules.h"

namespace mpdem {

class Arguments;

constexpr double kUsualKineticShare = 3e-3;
constexpr double kMostDamping = 100.0;  // largest damping that a script may set, over the critical one

struct ParsedOptions {
  CementOptions options;
  CementLawWords law_words;
  std::shared_ptr<Law> law;                   // law of material 0, made of law_words
  double step_fraction = 0.0;                 // share of the stable step; 0: the script sets the step
  std::string events;                         // name of the file of events, or empty
  double kinetic_share = kUsualKineticShare;  // fix mpm warns above this kinetic share; 0: never
  bool needs_coupling = true;                 // stop if there is no fix mpm/couple?
  std::vector<std::string> notes;             // messages on keywords that have no effect any more
  std::vector<SceneOption> said;              // all keywords with values, for word_rules.h
};

// Stops at keywords that are unknown, missing, out of range or exclude each other.
ParsedOptions parse_cement_words(Arguments& args);
// Returns the keywords, one per line, see keywords.h.
std::string listed_cement_words();

}  // namespace mpdem

#endif
