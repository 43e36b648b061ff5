// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Options of a script that define a law: a damage law, see material/laws.h, or a traction law, see
// coupling/traction_laws.h.
#ifndef MPDEM_STYLES_WORDS_LAW_WORDS_H
#define MPDEM_STYLES_WORDS_LAW_WORDS_H

#include <string>
#include <vector>

#include "../../coupling/traction_laws.h"
#include "../../material/laws.h"
#include "arguments.h"

namespace mpdem {

// A law as the script chose it. make() takes what else its constructor needs: elasticity or TractionStiffness.
template <class Entry>
struct Choice {
  const Entry* entry;  // entry of a static list
  LawValues values;
  template <class Given>
  auto make(const Given& given) const {
    return entry->make(given, values);
  }
};
using LawChoice = Choice<LawEntry>;

// Reads the values of the options of a law. law: its name in messages.
LawValues read_law_words(Arguments& args, const std::string& law, const std::vector<LawOption>& words);

// Reads name and options of a law after a keyword.
template <class Entry>
Choice<Entry> read_choice(Arguments& args, const std::string& keyword, const std::vector<Entry>& entries) {
  std::vector<std::string> names;
  for (const Entry& e : entries) names.push_back(e.name);
  const std::string name = args.choice(keyword, names);
  Choice<Entry> c{entries.data(), {}};
  while (c.entry->name != name) ++c.entry;
  c.values = read_law_words(args, keyword + " " + name, c.entry->words);
  return c;
}

// Returns the names of the laws as `a, b or c`.
template <class Entry>
std::string names_listed(const std::vector<Entry>& entries) {
  std::string all;
  for (const Entry& e : entries) all += (&e == &entries.front() ? "" : &e == &entries.back() ? " or " : ", ") + e.name;
  return all;
}

// Returns the option names of all laws for messages, such as "and after 'damage tensor' B0", "cutoff".
template <class Entry>
std::vector<std::string> law_words(const std::string& keyword, const std::vector<Entry>& entries) {
  std::vector<std::string> all;
  for (const Entry& e : entries)
    for (const LawOption& w : e.words)
      all.push_back((&w == &e.words.front() ? "and after '" + keyword + " " + e.name + "' " : "") + w.name);
  return all;
}

// Stops if `word` of the script is an option of a law, but does not stand behind that law. Returns if no law has such an
// option. chosen: the law that the script chose.
void check_misplaced(const Arguments& args, const std::string& word, const LawChoice& chosen);

}  // namespace mpdem

#endif
