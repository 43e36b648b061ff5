// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Reads the arguments of a command one by one. An error message names the command, the argument, the value and what is
// allowed. Errors end the run on all ranks (Error::all), so every rank has to read the same arguments, which LIGGGHTS
// guarantees.
#ifndef MPDEM_STYLES_WORDS_ARGUMENTS_H
#define MPDEM_STYLES_WORDS_ARGUMENTS_H

#include <array>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "../../parallel/agree.h"
#include "error.h"
#include "lammps.h"

namespace mpdem {

// Returns the items of a list `a, b or c`.
std::vector<std::string> words_in(std::string list);

// One of several numbers after a keyword: its name, its meaning, and its range, which is [least, most] or all above `least`.
struct NumberPart {
  const char *name, *meaning;
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
  bool above = false;
};

class Arguments {
 public:
  Arguments(LAMMPS_NS::LAMMPS* lmp, std::string command, int narg, char** arg, int first)
      : lmp_(lmp), command_(std::move(command)), narg_(narg), arg_(arg), next_(first) {}

  bool empty() const { return next_ >= narg_; }
  // Index of the next argument, and the text of the arguments from an index up to it.
  int place() const { return next_; }
  std::string words_from(int first) const;
  const std::string& command() const { return command_; }
  // Adds the name of the object to all later messages, to tell it from others of the same command.
  void name_object(const std::string& object) { command_ += " " + object; }

  // Returns the next argument. `what` says what is expected, for the message if there is none.
  std::string word(const std::string& what);
  bool accept(const std::string& keyword);  // consumes the next argument if it is this one

  // Stops if `keyword` was given before. With `scope`, each keyword may come once within that scope.
  void once(const std::string& keyword, const std::string& scope = "");

  // Reads an argument that is a number with all of its characters. or_word: addition to the message about keywords that
  // may replace the number, " or 'auto'".
  double number(const std::string& keyword, const std::string& or_word = {});
  double positive(const std::string& keyword, const std::string& or_word = {});
  double not_negative(const std::string& keyword, const std::string& or_word = {});
  // what: meaning of the number, for the message.
  double between(const std::string& keyword, double least, double most, const std::string& what = {});
  // Reads a number for each part. The message about one that is missing or out of range names all of them. example: values of
  // the parts that are right.
  std::vector<double> numbers(const std::string& keyword, const std::vector<NumberPart>& parts, const std::string& example);
  std::array<int, 2> pair();  // reads the IDs of two grains after `pair`
  int integer(const std::string& keyword, int least, int most = std::numeric_limits<int>::max(), const std::string& or_word = {});
  std::string choice(const std::string& keyword, const std::vector<std::string>& allowed) {
    return allowed[index_of_choice(keyword, allowed)];
  }
  // Returns the next argument, which must be one of these.
  std::string keyword(const std::vector<std::string>& allowed);
  int index_of_choice(const std::string& keyword, const std::vector<std::string>& allowed);
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

// Print on the first rank: a text on screen and in the log, or a warning in the name of `style`. The same warning is
// given once, until forget_warnings() at the start of another scene.
void tell(LAMMPS_NS::LAMMPS* lmp, const std::string& text);
void warn(LAMMPS_NS::LAMMPS* lmp, const std::string& text, const char* style = "fix mpm");
void forget_warnings();

// Calls Error::all with all streams flushed, so that the message survives redirected output.
[[noreturn]] void stop_all(LAMMPS_NS::LAMMPS* lmp, const std::string& text);
// Calls Error::one, for conditions that only this rank sees.
[[noreturn]] void stop_one(LAMMPS_NS::LAMMPS* lmp, const std::string& text);
// Collective. Stops if any rank has a text, and prints that of the lowest such rank.
void stop_if_any(LAMMPS_NS::LAMMPS* lmp, const std::string& text);

}  // namespace mpdem

#endif
