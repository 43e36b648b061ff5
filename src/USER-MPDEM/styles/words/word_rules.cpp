// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "word_rules.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <sstream>

#include "../../parallel/agree.h"

namespace mpdem {

namespace {

// Options are written as in the documentation, separated by ` | `, with capitals for numbers. `A with B` means both, `A
// without B` only the first.
struct Exclusion {
  const char *a, *b, *why, *instead;
};

constexpr char kTransfers[] = "kinematics updated | reproject N | reproject auto D";  // points give their velocity to the nodes
constexpr char kNewReference[] = "kinematics updated | reproject auto D";

const Exclusion kExclusions[] = {
    {"reproject N | reproject auto D", "kinematics updated", "velocities are transferred in every step, to a new reference",
     "no 'reproject', or 'kinematics total'"},
    {"transfer", "kinematics total without reproject", "it says how velocities are re-projected, and none are",
     "no 'transfer', or 'reproject N', 'reproject auto D' or 'kinematics updated'"},
    {"quasistatic S Z above 0", "kinematics updated", "the damping needs a reference that stays", "damping 0, or 'kinematics total'"},
    {"edge tied", kTransfers, "nodes that points give their velocity to are free",
     "'edge free', or 'kinematics total' without 'reproject'"},
    {"mass_order 2", kTransfers, "it is for nodes that keep their velocity", "'mass_order 1', or 'kinematics total' without 'reproject'"},
    {"cracks split", kTransfers, "where points meet other nodes as they move, a crack has no nodes of its own",
     "'cracks bonds', or 'kinematics total' without 'reproject'"},
    {"unilateral yes", "damage none", "nothing fails without a law of damage", "'unilateral no', or 'damage tensor'"},
    {"unilateral yes", kNewReference, "cracks are measured from a reference that stays",
     "'unilateral no', or 'kinematics total' without 'reproject auto'"},
    {"condense yes", kTransfers, "a condensed bond has the reference of its creation",
     "'condense no', or 'kinematics total' without 'reproject'"},
    {"condense yes", "mass_order 2", "condensed bonds have the mass of the first order", "'condense no', or 'mass_order 1'"},
    {"condense yes", "basis cubic", "nodes at the edge are connected by so little that bonds are activated differently on other ranks",
     "'condense no', or 'basis quadratic' or 'linear'"},
    {"subcycle N above 1 | subcycle auto", kTransfers, "cement follows impulses on its grains by its positions in the reference",
     "'subcycle no', or 'kinematics total' without 'reproject'"},
    {"basis linear", "kinematics updated",
     "no time step stays stable as points move, since a node that they have just reached has stiffness but next to no mass",
     "'basis quadratic', or 'kinematics total'"},
    {"transfer flip", "reproject N above 1", "it feeds energy into the cement",
     "'reproject 1', or 'transfer apic' or 'xpic' with any interval"},
    {"transfer flip", "reproject auto D", "it needs the velocity of each point, and a new reference leaves none",
     "'transfer apic', or 'reproject N'"},
    {"regularization nonlocal", "damage none", "it averages what drives a law of damage", "'regularization none', or 'damage tensor'"},
    {"regularization crackband", "damage without damage tensor", "this law cannot be given the energy of a crack",
     "'regularization none', or 'damage tensor'"},
    {"regularization nonlocal energy", "damage without damage tensor", "this law cannot be given the energy of a crack",
     "no 'energy', or 'damage tensor'"},
    {"quasistatic S Z above 0", "coupling none", "it damps motion relative to the grains", "damping 0, or a fix mpm/couple"},
    {"friction", kNewReference, "it needs a reference that stays", "no 'friction', or 'kinematics total' without 'reproject auto'"},
    {"friction", "cracks split with mass_order 2", "forces between faces of cracks are found with lumped masses",
     "no 'friction', or 'mass_order 1' or 'cracks bonds'"},
    {"points later", "condense no", "only condensed bonds do without points",
     "'condense yes', or 'fix_modify ... points all', which makes all points now"},
    {"points later", "cracks split", "bonds of one template have the same nodes",
     "'cracks bonds', or 'fix_modify ... points all', which makes all points now"},
    {"points later", "scatter", "bonds of one template have the same values",
     "no 'scatter', or 'fix_modify ... points all', which makes all points now"},
    {"several materials in a bond", "kinematics updated", "points of several materials would share cells as they move",
     "'kinematics total', or one material in each bond"},
    {"several materials in a bond", "regularization nonlocal", "a drive is averaged over one material",
     "'regularization crackband', or one material in each bond"},
    {"unilateral yes", "material elastic | scatter moduli", "closed cracks have the stiffness of the cement of fix mpm",
     "'unilateral no', or the same 'elastic' in all materials"},
    {"scatter moduli", "kinematics updated",
     "the stable step of points that move follows from the stiffest cement, and drawn moduli have no bound",
     "'kinematics total', or no 'scatter moduli'"},
    {"scatter energy", "regularization none | regularization nonlocal", "the softening of a point follows from an energy per cell",
     "'regularization crackband', or no 'scatter energy'"},
    {"scatter", "condense yes with regularization nonlocal", "a strong point of a condensed bond may drive a weak one",
     "'condense no', or 'regularization crackband'"},
    {"scatter strength | scatter energy", "damage none", "nothing fails without a law of damage", "no such scatter, or 'damage tensor'"},
    {"points later", "axis global", "bonds of one template have the same axes",
     "'axis radial' or 'axis bond', or 'fix_modify ... points all', which makes all points now"},
    {"grains elastic", kTransfers, "surfaces of elastic grains keep their reference",
     "'grains rigid', or 'kinematics total' without 'reproject'"},
    {"grains elastic", "friction", "debonded cement touches rigid grains", "'grains rigid', or no 'friction'"},
    {"grains elastic", "at points", "elastic grains deform at their surface", "'grains rigid' or 'at surface'"},
    {"grains elastic", "film joined", "columns of a film lie between rigid grains", "'grains rigid', or 'film grid' of create_cement"},
    {"grains elastic", "points later", "bonds of one template may have other grains", "'grains rigid', or 'fix_modify ... points all'"},
    {"grains elastic", "subcycle N above 1 | subcycle auto", "impulses are shared with rigid grains", "'grains rigid' or 'subcycle no'"},
};

bool is_number(const std::string& word, double& v) {
  char* end = nullptr;
  v = std::strtod(word.c_str(), &end);
  return !word.empty() && *end == '\0';
}

// Does an option of a script match one of the documentation? `reproject 10` matches `reproject N above 1`. Names need
// not follow each other.
bool is_written(const std::string& words, const std::string& value) {
  std::istringstream given(words), wanted(value);
  std::string word, name, keyword;
  given >> word;
  wanted >> keyword;
  double last = 0.0, least = 0.0;
  bool same = word == keyword;
  while (same && wanted >> name) {
    if (name == "above") return wanted >> least && last > least;
    same = static_cast<bool>(given >> word);
    if (std::isupper(static_cast<unsigned char>(name[0]))) same = same && is_number(word, last);
    else
      while (same && word != name) same = static_cast<bool>(given >> word);
  }
  return same;
}

std::string said(const std::vector<SceneOption>& scene, const std::string& value) {
  for (const SceneOption& s : scene)
    if (is_written(s.words, value)) return "'" + s.words + "'" + (s.of.empty() ? "" : " of " + s.of);
  return {};
}

// Returns the options of the scene that match one of these, or an empty text.
std::string said_of(const std::vector<SceneOption>& scene, std::string values) {
  for (values += " | "; !values.empty(); values.erase(0, values.find(" | ") + 3)) {
    std::string value = values.substr(0, values.find(" | ")), other;
    const std::size_t with = value.find(" with "), without = value.find(" without ");
    const std::size_t joint = std::min(with, without);  // end of the first option
    if (joint != std::string::npos) other = value.substr(value.find(' ', joint + 1) + 1), value.erase(joint);
    const std::string first = said(scene, value), second = other.empty() ? other : said(scene, other);
    if (first.empty() || (with != std::string::npos && second.empty()) || (without != std::string::npos && !second.empty())) continue;
    return second.empty() ? first : first + " and " + second;
  }
  return {};
}

}  // namespace

std::string exclusion_in(const std::vector<SceneOption>& scene) {
  for (const Exclusion& e : kExclusions) {
    const std::string a = said_of(scene, e.a), b = a.empty() ? a : said_of(scene, e.b);
    if (!b.empty()) return text_of(a, " does not go with ", b, ": ", e.why, "; use ", e.instead);
  }
  return {};
}

std::string listed_exclusions() {
  std::string all;
  for (const Exclusion& e : kExclusions) all += text_of("excludes\t", e.a, "\t", e.b, "\t", e.why, "\n");
  return all;
}

}  // namespace mpdem
