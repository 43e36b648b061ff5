// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Options of a scene that exclude each other. Each pair is a row of a table: what excludes what, why, and what to use
// instead.
#ifndef MPDEM_STYLES_WORDS_WORD_RULES_H
#define MPDEM_STYLES_WORDS_WORD_RULES_H

#include <string>
#include <vector>

namespace mpdem {

// A keyword with its value, given or default: `reproject 10`.
struct SceneOption {
  std::string words;
  std::string of = {};  // owner: `fix mpm (id cem)`; empty: the command that reads them
};

// Returns what excludes what, why, and a cure, or an empty text.
std::string exclusion_in(const std::vector<SceneOption>& scene);
// Returns one line per pair: `excludes`, either option as in the documentation, and why, separated by tabs.
std::string listed_exclusions();

}  // namespace mpdem

#endif
