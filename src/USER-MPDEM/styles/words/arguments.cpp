// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "arguments.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <set>

#include "comm.h"

namespace mpdem {

void tell(LAMMPS_NS::LAMMPS* lmp, const std::string& text) {
  for (std::FILE* f : {lmp->screen, lmp->logfile})
    if (f && lmp->comm->me == 0) std::fprintf(f, "%s", text.c_str());
}

namespace {
std::set<std::string> warnings_given;  // warnings that were given in this scene
}

// Checks are made at each run and each write_restart. One warning is enough.
void warn(LAMMPS_NS::LAMMPS* lmp, const std::string& text, const char* style) {
  if (lmp->comm->me == 0 && warnings_given.insert(text).second) lmp->error->warning(style, 0, text.c_str());
}

void forget_warnings() { warnings_given.clear(); }

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

namespace {
// Number of letters to insert, delete, replace or swap that make b of a (optimal string alignment distance).
int edits(const std::string& a, const std::string& b) {
  std::vector<int> before, last, row(b.size() + 1);  // of the first i - 2, i - 1 and i letters of a
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = std::move(last);
    last = row;
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j - 1] + (a[i - 1] != b[j - 1]), last[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row.back();
}

// Returns a question that names the most similar word, or an empty text if none is similar.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  const std::string* nearest = nullptr;
  int fewest = 0;
  for (const std::string& k : known) {
    const int n = edits(word, k);
    if (3 * n <= static_cast<int>(std::max(word.size(), k.size())) && (!nearest || n < fewest)) nearest = &k, fewest = n;
  }
  return nearest ? "; did you mean '" + *nearest + "'?" : "";
}
}  // namespace

void Arguments::complain(const std::string& text) const { stop_all(lmp_, command_ + ": " + text); }

void Arguments::unknown(const std::string& word, const std::vector<std::string>& known) const {
  std::string list;
  for (const std::string& k : known) list += (list.empty() ? "" : ", ") + k;
  complain("unknown keyword '" + word + "'" + did_you_mean(word, known) + "; known here: " + list);
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

namespace {
std::string text_of_range(const NumberPart& p) {
  if (p.above) return text_of(", above ", p.least);
  return std::isfinite(p.least) ? text_of(", from ", p.least, " to ", p.most) : std::string();
}
}  // namespace

std::vector<double> Arguments::numbers(const std::string& keyword, const std::vector<NumberPart>& parts, const std::string& example) {
  std::vector<double> values;
  std::string given = keyword;
  for (const NumberPart& p : parts) {
    const std::string w = empty() ? std::string() : arg_[next_];
    char* end = nullptr;
    const double v = std::strtod(w.c_str(), &end);
    if (w.empty() || *end != '\0' || !std::isfinite(v)) {
      std::string all;
      for (const NumberPart& q : parts)
        all += text_of(&q == &parts.front() ? "" : &q == &parts.back() ? " and " : ", ", q.name, " (", q.meaning, text_of_range(q), ")");
      complain(text_of("'", given, w.empty() ? "" : " ", w, "': ", p.name, " is missing",
                       w.empty() ? "" : ", '" + w + "' is not a finite number", "; '", keyword, "' takes ", parts.size(), " numbers, ", all,
                       "; write for instance '", keyword, " ", example, "'"));
    }
    ++next_;
    given += text_of(" ", v);
    if (p.above ? !(v > p.least) : !(v >= p.least && v <= p.most))
      complain(text_of("'", given, "': ", p.meaning,
                       p.above ? text_of(", must be greater than ", p.least) : text_of(", must lie in [", p.least, ", ", p.most, "]")));
    values.push_back(v);
  }
  return values;
}

std::array<int, 2> Arguments::pair() {
  const int most = std::numeric_limits<int>::max();
  const int first = integer("pair", 1, most, ", the ID of the first grain of 'pair I J',");
  return {first, integer(text_of("pair ", first), 1, most, ", the ID of the second grain of 'pair I J',")};
}

int Arguments::integer(const std::string& keyword, int least, int most, const std::string& or_word) {
  const std::string w = word("a whole number for '" + keyword + "'" + or_word);
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
  if (std::find(allowed.begin(), allowed.end(), w) == allowed.end())
    complain("'" + w + "' stands where " + list + " is needed" + did_you_mean(w, allowed));
  return w;
}

int Arguments::index_of_choice(const std::string& keyword, const std::vector<std::string>& allowed) {
  std::string list;
  for (const std::string& a : allowed) list += (list.empty() ? "" : ", ") + a;
  const std::string w = word("one of " + list + " for '" + keyword + "'");
  const auto found = std::find(allowed.begin(), allowed.end(), w);
  if (found != allowed.end()) return static_cast<int>(found - allowed.begin());
  complain("'" + keyword + " " + w + "': must be one of " + list + did_you_mean(w, allowed));
}

}  // namespace mpdem
