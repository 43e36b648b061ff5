// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "law_words.h"

#include <algorithm>

namespace mpdem {

namespace {

double read_value(Arguments& args, const std::string& law, const LawOption& word) {
  const std::string what = law + " " + word.name;
  if (!word.choices.empty()) {
    const std::string chosen = args.choice(what, word.choices);
    return static_cast<double>(std::find(word.choices.begin(), word.choices.end(), chosen) - word.choices.begin());
  }
  const double v = args.number(what);
  if (!word.allowed(v)) args.complain(text_of("'", what, " ", v, "': ", word.range));
  return v;
}

bool has_word(const LawEntry& law, const std::string& name) {
  return std::any_of(law.words.begin(), law.words.end(), [&](const LawOption& w) { return w.name == name; });
}

}  // namespace

LawValues read_law_words(Arguments& args, const std::string& law, const std::vector<LawOption>& words) {
  LawValues values;
  // The option that the next word of the script names, if it names one.
  const auto next = [&] { return std::find_if(words.begin(), words.end(), [&](const LawOption& w) { return args.accept(w.name); }); };
  for (auto w = next(); w != words.end(); w = next()) {
    args.once(w->name, law);
    values.set(w->name, read_value(args, law, *w));
  }
  for (const LawOption& w : words)
    if (!w.needed_for.empty() && !values.has(w.name)) args.complain("'" + law + "' needs '" + w.name + "', " + w.needed_for);
  return values;
}

void check_misplaced(const Arguments& args, const std::string& word, const LawChoice& chosen) {
  // Some options belong to several laws. The law in use is meant, or else the first that has the option.
  const LawEntry* law = has_word(*chosen.entry, word) ? chosen.entry : nullptr;
  for (const LawEntry& e : law_entries())
    if (!law && has_word(e, word)) law = &e;
  if (!law) return;
  std::string example = "damage " + law->name;
  for (const LawOption& w : law->words)
    if (!w.needed_for.empty() || w.name == word) example += " " + w.name + " ...";
  args.complain("'" + word + "' belongs to the words of 'damage " + law->name + "', with no other keyword between; write it there: '" +
                example + "'");
}

}  // namespace mpdem
