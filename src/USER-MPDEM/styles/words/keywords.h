// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Keywords of a command, each declared once: its name, its values and its default as in the documentation, and how it
// is read. The reader of scripts, the keywords that exclude each other (word_rules.h), `liggghts-mpdem -options` and
// the test of the documentation use these rows.
#ifndef MPDEM_STYLES_WORDS_KEYWORDS_H
#define MPDEM_STYLES_WORDS_KEYWORDS_H

#include <string>
#include <vector>

#include "arguments.h"

namespace mpdem {

// Words: type that receives the values.
template <class Words>
struct Keyword {
  const char* name;
  std::string values;   // `a, b or c` if the keyword takes one of these
  const char* initial;  // default; with a comma or semicolon it depends on other keywords; empty: none
  void (*take)(Arguments&, const Keyword&, Words&);
  bool repeats = false;  // may a script have it several times?

  // Reads one of the choices in `values`.
  std::string choice(Arguments& args) const { return args.choice(name, words_in(values)); }
  bool is(Arguments& args, const char* value) const { return choice(args) == value; }
};

// Reads all arguments. Returns each keyword with its value, also those not given whose default depends on no other.
// unknown: is called with an unknown keyword, and does not return.
template <class Words, class Unknown>
std::vector<std::string> parse_keywords(Arguments& args, const std::vector<Keyword<Words>>& keywords, Words& w, Unknown unknown) {
  std::vector<std::string> said;
  std::vector<char> given(keywords.size());
  while (!args.empty()) {
    const int first = args.place();
    const std::string key = args.word("a keyword");
    auto k = keywords.begin();
    while (k != keywords.end() && key != k->name) ++k;
    if (k == keywords.end()) unknown(key);
    if (!k->repeats) args.once(key);
    k->take(args, *k, w);
    given[k - keywords.begin()] = 1;
    said.push_back(args.words_from(first));
  }
  for (std::size_t n = 0; n < keywords.size(); ++n)
    if (const std::string initial = keywords[n].initial; !given[n] && !initial.empty() && initial.find_first_of(",;") == std::string::npos)
      said.push_back(keywords[n].name + (" " + initial));
  return said;
}

template <class Words>
std::vector<std::string> names_of(const std::vector<Keyword<Words>>& keywords) {
  std::vector<std::string> names;
  for (const Keyword<Words>& k : keywords) names.push_back(k.name);
  return names;
}

// Returns one line per keyword: command, name, values, default, separated by tabs.
template <class Words>
std::string listed(const char* command, const std::vector<Keyword<Words>>& keywords) {
  std::string all;
  for (const Keyword<Words>& k : keywords) all += text_of(command, "\t", k.name, "\t", k.values, "\t", k.initial, "\n");
  return all;
}

}  // namespace mpdem

#endif
