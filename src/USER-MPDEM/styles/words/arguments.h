// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Takes words of a command one by one. A complaint names the command, the word, the value and what is allowed.
// Complaints end the run on all ranks (Error::all). So every rank has to read the same words, which LIGGGHTS
// guarantees.
#ifndef MPDEM_STYLES_WORDS_ARGUMENTS_H
#define MPDEM_STYLES_WORDS_ARGUMENTS_H

#include <limits>
#include <set>
#include <string>
#include <vector>

#include "../../parallel/agree.h"
#include "error.h"
#include "lammps.h"

namespace mpdem {

// Returns the words of a list `a, b or c`.
std::vector<std::string> words_in(std::string list);

class Arguments {
 public:
  Arguments(LAMMPS_NS::LAMMPS* lmp, std::string command, int narg, char** arg, int first)
      : lmp_(lmp), command_(std::move(command)), narg_(narg), arg_(arg), next_(first) {}

  bool empty() const { return next_ >= narg_; }
  // Place of the next word, and the words from a place up to it.
  int place() const { return next_; }
  std::string words_from(int first) const;
  const std::string& command() const { return command_; }
  // Names the object in all complaints from here on. It tells which of thousands of such commands is meant.
  void about(const std::string& object) { command_ += " " + object; }

  // Returns the next word. `what` says what it should have been if there is none.
  std::string word(const std::string& what);
  bool accept(const std::string& keyword);  // takes the next word if it is this one

  // Complains if `keyword` was given before. With `scope`, each keyword may come once within that scope.
  void once(const std::string& keyword, const std::string& scope = "");

  // Reads a word that is a number with all of its characters.
  // or_word: what a message adds about words that may stand in place of the number, " or 'auto'".
  double number(const std::string& keyword, const std::string& or_word = {});
  double positive(const std::string& keyword, const std::string& or_word = {});
  double not_negative(const std::string& keyword, const std::string& or_word = {});
  // what: text on the meaning of the number, for the message.
  double between(const std::string& keyword, double least, double most, const std::string& what = {});
  int integer(const std::string& keyword, int least, int most = std::numeric_limits<int>::max(), const std::string& or_word = {});
  std::string choice(const std::string& keyword, const std::vector<std::string>& allowed) {
    return allowed[place_of_choice(keyword, allowed)];
  }
  // Returns the next word, which has to be one of these.
  std::string keyword(const std::vector<std::string>& allowed);
  int place_of_choice(const std::string& keyword, const std::vector<std::string>& allowed);
  bool yes_no(const std::string& keyword) { return choice(keyword, {"yes", "no"}) == "yes"; }

  [[noreturn]] void unknown(const std::string& word, const std::vector<std::string>& known) const;
  [[noreturn]] void complain(const std::string& text) const;

 private:
  LAMMPS_NS::LAMMPS* lmp_;
  std::string command_;
  int narg_;
  char** arg_;
  int next_;
  std::set<std::string> given_;
};

// Print on the first rank: a text on the screen and into the log, or a warning in the name of `style`.
void tell(LAMMPS_NS::LAMMPS* lmp, const std::string& text);
void warn(LAMMPS_NS::LAMMPS* lmp, const std::string& text, const char* style = "fix mpm");

// Calls Error::all with the streams flushed, so that the message survives redirected output.
[[noreturn]] void stop_all(LAMMPS_NS::LAMMPS* lmp, const std::string& text);
// Calls Error::one, for conditions that only this rank sees.
[[noreturn]] void stop_one(LAMMPS_NS::LAMMPS* lmp, const std::string& text);
// Collective. Stops all ranks if any rank has a text. Shows the text of the lowest such rank.
void stop_if_any(LAMMPS_NS::LAMMPS* lmp, const std::string& text);

}  // namespace mpdem

#endif
