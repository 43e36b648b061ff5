// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "fix_mpm_words.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "keywords.h"
#include "law_words.h"
#include "material_words.h"

namespace mpdem {

namespace {
// The parsed options, and values that only the law needs.
struct ScriptOptions : ParsedOptions {
  bool tied_given = false, cracks_given = false, has_elastic = false;
};
using ScriptKeyword = Keyword<ScriptOptions>;

constexpr int kMostProjections = 1000;  // largest m of `transfer xpic m`, which is flip long before
constexpr double kMostInertia = 1e9;    // largest mass scale S of `quasistatic`

void take_transfer(Arguments& args, const ScriptKeyword& key, ScriptOptions& w) {
  CementOptions& o = w.options;
  const std::string name = args.choice(key.name, {"pic", "flip", "apic", "xpic"});
  if (name == "pic") {
    o.transfer.method = Transfer::xpic;
    o.transfer.order = 1;
  } else if (name == "apic") {
    o.transfer.method = Transfer::apic;
  } else if (name == "flip") {
    o.transfer.method = Transfer::flip;
    o.transfer.flip_share = args.number("transfer flip");
    if (!(o.transfer.flip_share >= 0.0 && o.transfer.flip_share <= 1.0))
      args.complain(text_of("'transfer flip ", o.transfer.flip_share, "': share of FLIP, the rest is PIC, must lie in [0, 1]"));
  } else {
    o.transfer.method = Transfer::xpic;
    o.transfer.order = args.integer("transfer xpic", 1, kMostProjections);
  }
}

void take_skip(Arguments& args, const ScriptKeyword&, ScriptOptions& w) {
  CementOptions& o = w.options;
  const bool of_old_scripts = args.accept("detached");
  const std::string name = of_old_scripts ? "detached" : args.choice("skip", {"undamaged", "failed", "resting", "all"});
  args.once("skip " + name);
  const bool on = args.yes_no("skip " + name);
  if (name == "detached")
    w.notes.push_back(text_of("'skip detached ", on ? "yes" : "no", "' has no effect any more: links that debonded take no time"));
  if (name == "undamaged" || name == "all") o.advance.skip_undamaged = on;
  if (name == "failed" || name == "all") o.advance.skip_failed = on;
  if (name == "resting" || name == "all") o.advance.skip_resting = on;
}

void take_elastic(Arguments& args, const ScriptKeyword&, ScriptOptions& w) {
  w.law_words.elastic = read_elastic(args);
  w.has_elastic = true;
}

void take_axis(Arguments& args, const ScriptKeyword&, ScriptOptions& w) {
  CementOptions& o = w.options;
  const std::string rule = args.choice("axis", {"radial", "bond", "global"});
  o.axis = rule == "radial" ? AxisRule::radial : rule == "bond" ? AxisRule::bond : AxisRule::global;
  if (o.axis != AxisRule::global) return;
  const std::vector<double> direction =
      args.numbers("axis global", {{"nx", "direction along x"}, {"ny", "along y"}, {"nz", "along z"}}, "0 0 1");
  double length = 0.0;
  for (int d = 0; d < 3; ++d) {
    o.axis_direction[d] = direction[static_cast<std::size_t>(d)];
    length += o.axis_direction[d] * o.axis_direction[d];
  }
  length = std::sqrt(length);
  if (!(length > 0.0)) args.complain("'axis global 0 0 0': a direction is needed");
  for (double& a : o.axis_direction) a /= length;
}

void take_timestep(Arguments& args, const ScriptKeyword&, ScriptOptions& w) {
  if (!args.accept("auto"))
    args.complain(
        "'timestep' takes the word 'auto' and a share of the stable step; a step in units of "
        "time is set by LIGGGHTS' own command timestep");
  const double share = args.number("timestep auto");
  if (!(share > 0.0 && share <= 1.0)) args.complain(text_of("'timestep auto ", share, "': share of the stable step, must lie in (0, 1]"));
  w.step_fraction = share;
}

void take_regularization(Arguments& args, const ScriptKeyword&, ScriptOptions& w) {
  CementOptions& o = w.options;
  const std::string how = args.choice("regularization", {"none", "crackband", "nonlocal"});
  if (how == "crackband") w.law_words.crack_band = args.positive("regularization crackband");
  if (how != "nonlocal") return;
  o.advance.nonlocal = true;
  o.length = args.positive("regularization nonlocal");
  o.imperfection = kUsualImperfection;
  for (;;) {
    if (args.accept("energy")) {
      args.once("energy", "regularization nonlocal");
      w.law_words.nonlocal_energy = args.positive("regularization nonlocal ... energy");
    } else if (args.accept("imperfection")) {
      args.once("imperfection", "regularization nonlocal");
      o.imperfection = args.between("regularization nonlocal ... imperfection", 0.0, kMostImperfection,
                                    "by how much more strain one side of a bond carries");
    } else {
      return;
    }
  }
}

void take_kinetic_share(Arguments& args, const ScriptKeyword&, ScriptOptions& w) {
  const double share = args.accept("no") ? 0.0 : args.positive("kinetic_share", " or 'no'");
  if (share > 1.0)
    args.complain(
        text_of("'kinetic_share ", share,
                "': share of the energy above which cement should not begin to fail, must lie in (0, 1], or be 'no'; 0.003 for instance"));
  w.kinetic_share = share;
}

void take_reproject(Arguments& args, const ScriptKeyword& key, ScriptOptions& w) {
  if (args.accept("auto")) w.options.reproject_distortion = args.positive("reproject auto");
  else w.options.reproject_every = args.integer(key.name, 1, std::numeric_limits<int>::max(), " or 'auto'");
}

void take_quasistatic(Arguments& args, const ScriptKeyword& key, ScriptOptions& w) {
  CementOptions& o = w.options;
  const std::vector<double> v = args.numbers(
      key.name, {{"S", "factor on the inertia", 1.0, kMostInertia}, {"Z", "share of critical damping", 0.0, kMostDamping}}, "100 0.1");
  o.mass_scale = v[0];
  o.relative_damping = v[1];
}

void take_condense(Arguments& args, const ScriptKeyword&, ScriptOptions& w) {
  CementOptions& o = w.options;
  o.condense = args.yes_no("condense");
  if (!args.accept("wake")) return;
  o.activation_share = args.number("condense ... wake");
  if (!(o.activation_share > 0.0 && o.activation_share <= 1.0))
    args.complain(text_of("'condense ... wake ", o.activation_share, "': share of the threshold of the damage, must lie in (0, 1]"));
}

constexpr int kMostFragment = 1000000000;  // points

void take_fragments(Arguments& args, const ScriptKeyword&, ScriptOptions& w) {
  FragmentRule& rule = w.options.fragments;
  rule.drop = args.choice("fragments", {"keep", "drop"}) == "drop";
  if (!rule.drop) return;
  rule.bonds = args.accept("bonds");
  for (;;) {
    if (args.accept("age")) {
      args.once("age", "fragments");
      rule.age = args.not_negative("fragments drop age");
    } else if (args.accept("size")) {
      args.once("size", "fragments");
      rule.below_points = args.integer("fragments drop size", 1, kMostFragment);
    } else if (args.accept("share")) {
      args.once("share", "fragments");
      rule.below_share = args.between("fragments drop share", 0.0, 1.0, "share of the points of the bond");
    } else {
      break;
    }
  }
  if (rule.bonds && (rule.below_points > 0 || rule.below_share > 0.0))
    args.complain(
        "'fragments drop bonds' drops all cement of a separated bond, so 'size' and 'share' do not go with it; leave them out, or 'bonds'");
}

const std::vector<ScriptKeyword>& fix_mpm_keywords() {
  static const std::vector<ScriptKeyword> all = {
      {"cell", "length", "", [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.options.cell = args.positive(k.name); }},
      {"basis", "linear, quadratic or cubic", "quadratic",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) {
         w.options.basis = static_cast<Basis>(args.index_of_choice(k.name, Bases::names()));
       }},
      {"mass_order", "1 or 2", "1",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.options.mass_order = args.integer(k.name, 1, 2); }},
      {"edge", "tied or free", "tied; free with updated and reproject",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.tied_given = w.options.tied = k.is(args, "tied"); }},
      {"kinematics", "total or updated", "total",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.options.updated = k.is(args, "updated"); }},
      {"reproject", "N or auto D", "", take_reproject},
      {"transfer", "pic, flip A, apic or xpic M", "apic, where there is a transfer", take_transfer},
      {"elastic", "vti Ep Ez nu_p nu_zp Gzp or isotropic E nu", "", take_elastic},
      {"axis", "radial, bond or global nx ny nz", "radial", take_axis},
      {"damage", names_listed(law_entries()), "none",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.law_words.damage = read_choice(args, k.name, law_entries()); }},
      {"scatter", kScatterValues, "",
       [](Arguments& args, const ScriptKeyword&, ScriptOptions& w) { read_scatter(args, w.law_words.scatter); }, true},
      {"regularization", "none, crackband G or nonlocal L [energy G] [imperfection E]", "none", take_regularization},
      {"cracks", "bonds or split", "bonds; split with regularization nonlocal",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.options.split = k.is(args, "split"), w.cracks_given = true; }},
      {"unilateral", "yes or no", "no",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.options.unilateral = k.is(args, "yes"); }},
      {"condense", "yes or no, then [wake W]", "no", take_condense},
      {"timestep", "auto S", "", take_timestep},
      {"subcycle", "N, auto or no", "no",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) {
         w.options.subcycle = args.accept("no") ? 1 : args.accept("auto") ? 0 : args.integer(k.name, 1, kMostSubsteps, ", 'no' or 'auto'");
       }},
      {"quasistatic", "S Z", "1 0", take_quasistatic},
      {"kinetic_share", "X or no", "0.003", take_kinetic_share},
      {"balance", "yes or no", "no",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.options.balance = k.is(args, "yes"); }},
      {"coupling", "grains or none", "grains",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.needs_coupling = k.is(args, "grains"); }},
      {"skip", "undamaged, failed, resting or all, then yes or no", "all yes", take_skip, true},  // once for each thing to skip
      {"check", "N", "100",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.options.check_every = args.integer(k.name, 1); }},
      {"fragments", "keep or drop [bonds] [age T] [size N] [share X]", "keep", take_fragments},
      {"outside", "stop or drop", "stop",
       [](Arguments& args, const ScriptKeyword& k, ScriptOptions& w) { w.options.fragments.outside = k.is(args, "drop"); }},
      {"events", "file", "",
       [](Arguments& args, const ScriptKeyword&, ScriptOptions& w) { w.events = args.word("a file name for 'events'"); }},
  };
  return all;
}

// Chooses the defaults that depend on other keywords. A nonlocal average ends at a crack only where the crack has
// phantom nodes.
void choose_defaults(ScriptOptions& w) {
  CementOptions& o = w.options;
  const auto may_say = [&](const char* words) {  // does no other keyword exclude these words?
    std::vector<SceneOption> all = w.said;
    all.push_back({words});
    return exclusion_in(all).empty();
  };
  if (!w.cracks_given && o.advance.nonlocal && !o.condense && may_say("cracks split")) {
    o.split = true;
    w.said.push_back({"cracks split"});
  }
  if (o.tied && !w.tied_given) o.tied = may_say("edge tied");
}

}  // namespace

ParsedOptions parse_cement_words(Arguments& args) {
  ScriptOptions w;
  CementOptions& o = w.options;
  const std::vector<std::string> said = parse_keywords(args, fix_mpm_keywords(), w, [&](const std::string& key) {
    check_misplaced(args, key, w.law_words.damage);
    std::vector<std::string> known = names_of(fix_mpm_keywords());
    for (const std::string& word : law_words("damage", law_entries())) known.push_back(word);
    known.insert(known.end(), {"and after 'regularization nonlocal' energy", "imperfection"});
    args.unknown(key, known);
  });
  if (o.cell == 0.0) args.complain("keyword 'cell' is missing: the spacing of the background grid");
  if (!w.has_elastic) args.complain("keyword 'elastic' is missing: use 'elastic vti Ep Ez nu_p nu_zp Gzp' or 'elastic isotropic E nu'");
  for (const std::string& words : said) w.said.push_back({words});
  choose_defaults(w);
  const std::string trouble = exclusion_in(w.said);
  if (!trouble.empty()) args.complain(trouble);
  w.law = make_law(args, o, w.law_words);
  if (const std::optional<Localisation> band = w.law->crack_band()) o.half_band = 0.5 * band->width * o.length;
  return w;
}

std::string listed_cement_words() { return listed("fix mpm", fix_mpm_keywords()); }

}  // namespace mpdem
