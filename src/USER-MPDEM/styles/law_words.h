// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The words of a script from which a law of damage is made, see material/laws.h.
#ifndef MPDEM_LAW_WORDS_H
#define MPDEM_LAW_WORDS_H

#include <string>
#include <vector>

#include "../material/laws.h"
#include "arguments.h"

namespace mpdem {

struct LawChoice {
  const LawEntry* entry = &law_entries().front();
  LawValues values;
  std::unique_ptr<Law> make(const VtiElasticity& elasticity) const { return entry->make(elasticity, values); }
};

// The words after `damage`.
LawChoice read_law(Arguments& args);

// "and after 'damage tensor' B0, cutoff ..." of each law that has words.
std::vector<std::string> law_words();

// Complains of a word of a law that stands elsewhere; returns if it is none.
void check_misplaced(const Arguments& args, const std::string& word, const LawChoice& chosen);

}  // namespace mpdem

#endif
