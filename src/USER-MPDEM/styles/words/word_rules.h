// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Words of a scene that do not go together. Each pair is a row of one list: what excludes what, why, and what to use instead.
#ifndef MPDEM_STYLES_WORDS_WORD_RULES_H
#define MPDEM_STYLES_WORDS_WORD_RULES_H

#include <string>
#include <vector>

namespace mpdem {

// A keyword with its value, given or by default: `reproject 10`.
struct SceneWords {
  std::string words;
  std::string of = {};  // what has them: `fix mpm (id cem)`; empty: the command that reads them
};

// Returns what does not go together, why, and a cure, or an empty text.
std::string words_that_exclude(const std::vector<SceneWords>& scene);
// Returns a line a pair: `excludes`, words of either as pages have them, and why, divided by tabulators.
std::string listed_exclusions();

}  // namespace mpdem

#endif
