// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "hidden_points.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

#include "atom.h"
#include "fix_move.h"
#include "input.h"
#include "modify.h"
#include "private_access.h"
#include "variable.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {

// Constants and functions of a formula that do not depend on atoms.
const char* const kWords[] = {"PI",    "step", "dt",      "time",    "sqrt",   "exp",       "ln",      "log",    "abs",
                              "sin",   "cos",  "tan",     "asin",    "acos",   "atan",      "atan2",   "ceil",   "floor",
                              "round", "ramp", "stagger", "logfreq", "stride", "vdisplace", "swiggle", "cwiggle"};

// Declared here, since formulas refer to variables that have formulas. seen: variables that lead to this one. They end a
// cycle, which LIGGGHTS reports later.
bool is_of_time_alone(LAMMPS* lmp, const std::string& formula, const std::vector<std::string>& seen);

// A variable of a style other than equal and atom holds plain numbers.
bool variable_is_of_time_alone(LAMMPS* lmp, const std::string& name, std::vector<std::string> seen) {
  Variable* variables = lmp->input->variable;
  const int place = variables->find(const_cast<char*>(name.c_str()));
  if (place < 0 || variables->atomstyle(place) || std::find(seen.begin(), seen.end(), name) != seen.end()) return false;
  seen.push_back(name);
  return !variables->equalstyle(place) || is_of_time_alone(lmp, formula_of(variables, place), seen);
}

bool is_of_time_alone(LAMMPS* lmp, const std::string& formula, const std::vector<std::string>& seen) {
  const auto is_part = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  for (std::size_t at = 0; at < formula.size();) {
    const char c = formula[at];
    if (c == '[' || c == '$') return false;
    if (std::isdigit(static_cast<unsigned char>(c)) || c == '.') {  // a number, possibly with an exponent
      while (at < formula.size() && (std::isdigit(static_cast<unsigned char>(formula[at])) || formula[at] == '.')) ++at;
      if (at < formula.size() && (formula[at] == 'e' || formula[at] == 'E')) ++at;
      continue;
    }
    if (!is_part(c)) {
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < formula.size() && is_part(formula[end])) ++end;
    const std::string word = formula.substr(at, end - at);
    at = end;
    if (word.compare(0, 2, "v_") == 0) {
      if (!variable_is_of_time_alone(lmp, word.substr(2), seen)) return false;
    } else if (std::find(std::begin(kWords), std::end(kWords), word) == std::end(kWords)) {
      return false;
    }
  }
  return true;
}

}  // namespace

bool is_of_time_alone(LAMMPS* lmp, const std::string& formula) { return is_of_time_alone(lmp, formula, {}); }

void HiddenPoints::start(const Fix* fix) {
  show();
  hides_ = may_hide(fix);
  if (hides_) act_last(lmp_->modify, fix);
}

bool HiddenPoints::may_hide(const Fix* own) const {
  const Modify& modify = *lmp_->modify;
  for (int i = 0; i < modify.nfix; ++i) {
    const Fix* fix = modify.fix[i];
    constexpr int kWhileHidden =
        FixConst::PRE_INITIAL_INTEGRATE | FixConst::INITIAL_INTEGRATE | FixConst::PRE_FINAL_INTEGRATE | FixConst::FINAL_INTEGRATE;
    if (fix == own || !(modify.fmask[i] & kWhileHidden)) continue;
    const std::string style = fix->style;
    if (style == "nve" || style.compare(0, 4, "nve/") == 0) continue;
    const FixMove* move = style == "move" ? dynamic_cast<const FixMove*>(fix) : nullptr;
    if (!move) return false;
    const MoveMembers m = members_of(move);
    for (const char* const* names : {m.position_variable, m.velocity_variable})
      for (int d = 0; d < 3; ++d)
        if (names[d] && !is_of_time_alone(lmp_, std::string("v_") + names[d])) return false;
  }
  return true;
}

void HiddenPoints::hide() {
  if (hides_ && lmp_->atom->firstgroupname) hidden_.emplace(*lmp_->atom);
}

}  // namespace mpdem
