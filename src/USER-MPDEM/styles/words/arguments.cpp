// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "arguments.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "comm.h"

namespace mpdem {

void tell(LAMMPS_NS::LAMMPS* lmp, const std::string& text) {
  for (std::FILE* f : {lmp->screen, lmp->logfile})
    if (f && lmp->comm->me == 0) std::fprintf(f, "%s", text.c_str());
}

void warn(LAMMPS_NS::LAMMPS* lmp, const std::string& text, const char* style) {
  if (lmp->comm->me == 0) lmp->error->warning(style, 0, text.c_str());
}

void stop_all(LAMMPS_NS::LAMMPS* lmp, const std::string& text) {
  std::fflush(nullptr);
  lmp->error->all("USER-MPDEM", 0, text.c_str());
  std::abort();  // not reached; Error::all is not declared so
}

void stop_one(LAMMPS_NS::LAMMPS* lmp, const std::string& text) {
  lmp->error->one("USER-MPDEM", 0, text.c_str());  // see host/abort.cpp
  std::abort();
}

void stop_if_any(LAMMPS_NS::LAMMPS* lmp, const std::string& text) {
  const std::string shown = first_text(lmp->world, text);
  if (!shown.empty()) stop_all(lmp, shown);
}

std::vector<std::string> words_in(std::string list) {
  std::vector<std::string> words;
  while (!list.empty()) {
    const std::size_t comma = list.find(", "), last = list.find(" or "), end = std::min(comma, last);
    words.push_back(list.substr(0, end));
    list.erase(0, end == std::string::npos ? end : end + (end == comma ? 2 : 4));
  }
  return words;
}

std::string Arguments::words_from(int first) const {
  std::string words = arg_[first];
  for (int n = first + 1; n < next_; ++n) words += std::string(" ") + arg_[n];
  return words;
}

void Arguments::complain(const std::string& text) const { stop_all(lmp_, command_ + ": " + text); }

void Arguments::unknown(const std::string& word, const std::vector<std::string>& known) const {
  std::string list;
  for (const std::string& k : known) list += (list.empty() ? "" : ", ") + k;
  complain("unknown keyword '" + word + "'; known here: " + list);
}

std::string Arguments::word(const std::string& what) {
  if (empty()) complain("missing value: " + what + " expected at the end of the command");
  return arg_[next_++];
}

void Arguments::once(const std::string& keyword, const std::string& scope) {
  if (!given_.insert(scope + ' ' + keyword).second)
    complain("'" + keyword + "' is given twice" + (scope.empty() ? "" : " in " + scope) + "; give it once");
}

bool Arguments::accept(const std::string& keyword) {
  if (empty() || keyword != arg_[next_]) return false;
  ++next_;
  return true;
}

double Arguments::number(const std::string& keyword, const std::string& or_word) {
  const std::string w = word("a number for '" + keyword + "'");
  char* end = nullptr;
  const double v = std::strtod(w.c_str(), &end);
  if (w.empty() || *end != '\0' || !std::isfinite(v)) complain("'" + keyword + " " + w + "': a finite number" + or_word + " is needed");
  return v;
}

double Arguments::positive(const std::string& keyword, const std::string& or_word) {
  const double v = number(keyword, or_word);
  if (!(v > 0.0)) complain(text_of("'", keyword, " ", v, "': must be greater than 0", or_word));
  return v;
}

double Arguments::not_negative(const std::string& keyword, const std::string& or_word) {
  const double v = number(keyword, or_word);
  if (!(v >= 0.0))
    complain(text_of("'", keyword, " ", v, "': must not be negative", or_word.empty() ? "" : "; use a positive number, 0", or_word));
  return v;
}

double Arguments::between(const std::string& keyword, double least, double most, const std::string& what) {
  const double v = number(keyword);
  if (!(v >= least && v <= most))
    complain(text_of("'", keyword, " ", v, "': ", what, what.empty() ? "" : ", ", "must lie in [", least, ", ", most, "]"));
  return v;
}

int Arguments::integer(const std::string& keyword, int least, int most, const std::string& or_word) {
  const std::string w = word("a whole number for '" + keyword + "'");
  char* end = nullptr;
  const double v = std::strtod(w.c_str(), &end);
  if (w.empty() || *end != '\0' || v != std::floor(v) || !(v >= least && v <= most))
    complain(text_of("'", keyword, " ", w, "': a whole number from ", least, " to ", most, or_word, " is needed"));
  return static_cast<int>(v);
}

std::string Arguments::keyword(const std::vector<std::string>& allowed) {
  std::string list;
  for (const std::string& a : allowed) list += (list.empty() ? "'" : " or '") + a + "'";
  const std::string w = word("keyword " + list);
  if (std::find(allowed.begin(), allowed.end(), w) == allowed.end()) complain("'" + w + "' stands where " + list + " is needed");
  return w;
}

int Arguments::index_of_choice(const std::string& keyword, const std::vector<std::string>& allowed) {
  std::string list;
  for (const std::string& a : allowed) list += (list.empty() ? "" : ", ") + a;
  const std::string w = word("one of " + list + " for '" + keyword + "'");
  const auto found = std::find(allowed.begin(), allowed.end(), w);
  if (found != allowed.end()) return static_cast<int>(found - allowed.begin());
  complain("'" + keyword + " " + w + "': must be one of " + list);
}

}  // namespace mpdem
