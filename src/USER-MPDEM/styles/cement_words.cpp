// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement_words.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "arguments.h"
#include "law_words.h"

namespace mpdem {

namespace {
const std::vector<std::string> kKeywords = {"cell", "basis", "mass_order", "edge", "kinematics", "transfer", "reproject", "elastic", "axis", "damage",
                                            "regularization", "cracks", "unilateral", "condense", "timestep", "subcycle", "quasistatic", "kinetic_share", "balance", "skip", "check", "events"};

constexpr int kMostProjections = 1000;  // of `transfer xpic`, which is flip long before
constexpr double kMostInertia = 1e9;    // of `quasistatic`, as a factor

bool is_one_of(const std::string& key, const std::vector<std::string>& list) { return std::find(list.begin(), list.end(), key) != list.end(); }

void take_transfer(Arguments& args, CementWords& w) {
  CementOptions& o = w.options;
  const std::string name = args.choice("transfer", {"pic", "flip", "apic", "xpic"});
  w.transfer_given = true;
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

void take_skip(Arguments& args, CementWords& w) {
  CementOptions& o = w.options;
  const bool of_old_scripts = args.accept("detached");
  const std::string name = of_old_scripts ? "detached" : args.choice("skip", {"undamaged", "failed", "resting", "all"});
  args.once("skip " + name);
  const bool on = args.yes_no("skip " + name);
  if (name == "detached") w.notes.push_back(text_of("'skip detached ", on ? "yes" : "no", "' has no effect any more: links that let go take no time"));
  if (name == "undamaged" || name == "all") o.advance.skip_undamaged = on;
  if (name == "failed" || name == "all") o.advance.skip_failed = on;
  if (name == "resting" || name == "all") o.advance.skip_resting = on;
}

VtiConstants take_elastic(Arguments& args) {
  VtiConstants constants;
  if (args.choice("elastic", {"vti", "isotropic"}) == "isotropic") {
    const double E = args.number("elastic isotropic E"), nu = args.number("elastic isotropic nu");
    constants = VtiConstants::isotropic(E, nu);
    if (!(nu > -1.0 && nu < 0.5)) args.complain(text_of("'elastic isotropic' nu = ", nu, " must lie between -1 and 0.5"));
  } else {
    constants.Ep = args.number("elastic vti Ep");
    constants.Ez = args.number("elastic vti Ez");
    constants.nu_p = args.number("elastic vti nu_p");
    constants.nu_zp = args.number("elastic vti nu_zp");
    constants.Gzp = args.number("elastic vti Gzp");
  }
  const std::string why = constants.violated_condition();
  if (!why.empty()) args.complain("'elastic' is not positive definite: " + why);
  return constants;
}

void take_axis(Arguments& args, CementOptions& o) {
  const std::string rule = args.choice("axis", {"radial", "bond", "global"});
  o.axis = rule == "radial" ? AxisRule::radial : rule == "bond" ? AxisRule::bond : AxisRule::global;
  if (o.axis != AxisRule::global) return;
  double length = 0.0;
  for (double& a : o.axis_direction) {
    a = args.number("axis global");
    length += a * a;
  }
  length = std::sqrt(length);
  if (!(length > 0.0)) args.complain("'axis global 0 0 0': a direction is needed");
  for (double& a : o.axis_direction) a /= length;
}

double take_step_fraction(Arguments& args) {
  if (!args.accept("auto")) args.complain("'timestep' takes the word 'auto' and a share of the stable step; a step in units of "
                                          "time is set by LIGGGHTS' own command timestep");
  const double share = args.number("timestep auto");
  if (!(share > 0.0 && share <= 1.0)) args.complain(text_of("'timestep auto ", share, "': share of the stable step, must lie in (0, 1]"));
  return share;
}

void take_subcycle(Arguments& args, CementOptions& o) {
  o.subcycle = args.accept("no") ? 1 : args.accept("auto") ? 0 : args.integer("subcycle", 1, kMostSubsteps, ", 'no' or 'auto'");
}

// Energies of a crack per area that a script asks for; 0: none.
struct Softening {
  double crack_band = 0.0, nonlocal = 0.0;
};

void take_regularization(Arguments& args, CementOptions& o, Softening& energy) {
  const std::string how = args.choice("regularization", {"none", "crackband", "nonlocal"});
  if (how == "crackband") energy.crack_band = args.positive("regularization crackband");
  o.advance.nonlocal = how == "nonlocal";
  if (!o.advance.nonlocal) return;
  o.length = args.positive("regularization nonlocal");
  o.imperfection = kUsualImperfection;
  for (;;) {
    if (args.accept("energy")) {
      args.once("energy", "regularization nonlocal");
      energy.nonlocal = args.positive("regularization nonlocal ... energy");
    } else if (args.accept("imperfection")) {
      args.once("imperfection", "regularization nonlocal");
      o.imperfection = args.between("regularization nonlocal ... imperfection", 0.0, kMostImperfection, "by how much more strain one side of a bond bears");
    } else {
      return;
    }
  }
}

// Calls f, and complains if f finds no softening with that energy.
template <class F>
void soften(const Arguments& args, const std::string& word, const Law& law, F f) {
  if (!law.has_crack_energy()) args.complain(word + " needs 'damage tensor'");
  try {
    f();
  } catch (const std::domain_error& e) {
    args.complain(word + ": " + e.what());
  }
}

std::shared_ptr<const Law> make_law(const Arguments& args, const LawChoice& damage, const VtiConstants& constants, const Softening& energy,
                                    const CementOptions& o) {
  std::shared_ptr<Law> law = damage.make(VtiElasticity(constants));
  if (energy.crack_band > 0.0)
    soften(args, "'regularization crackband'", *law, [&] { law->set_crack_energy(energy.crack_band, o.cell); });
  if (!o.advance.nonlocal) return law;
  if (law->inert()) args.complain("'regularization nonlocal' needs a law of damage, 'damage tensor' for instance");
  // a length that is a little less comes from rounding of numbers in a script
  if (o.length < 0.999999 * o.cell)
    args.complain(text_of("'regularization nonlocal ", o.length, "': the length must be at least the cell, which is ", o.cell, "; take 'cell ", o.length,
                          "' or less"));
  constexpr double kMostCells = 100.0;  // an average of more takes thousands of sweeps a step
  if (o.length > kMostCells * o.cell)
    args.complain(text_of("'regularization nonlocal ", o.length, "': the length must be at most ", kMostCells, " cells, which are ", kMostCells * o.cell,
                          ", in the units of the box; take a length of one to four cells"));
  if (energy.nonlocal > 0.0)
    soften(args, "'regularization nonlocal ... energy'", *law, [&] { law->set_nonlocal(o.length, energy.nonlocal); });
  else
    law->set_nonlocal(o.length, 0.0);
  return law;
}

// Complains of a law whose strength, strain at failure or energy is no finite number. Thresholds that no cement reaches are allowed.
void check_strength(const Arguments& args, const Law& law, const std::string& name) {
  if (law.inert()) return;
  const VtiConstants& e = law.elasticity().constants;
  const ImpliedStrength s = law.implied_strength(std::max(e.Ep, e.Ez));
  if (std::isfinite(s.failure_strain) && std::isfinite(s.tensile_strength) && std::isfinite(s.work_per_volume)) return;
  args.complain(text_of("'damage ", name, "': cement would fail at a strain of ", s.failure_strain, " with a strength of ", s.tensile_strength, "; both must be finite, ", law.advice_on_strain()));
}

// Complains of words that do not go together.
void check_together(Arguments& args, CementWords& w) {
  CementOptions& o = w.options;
  const bool flip = w.transfer_given && o.transfer.method == Transfer::flip;
  if (o.updated && o.reproject_every > 0)
    args.complain(text_of("'reproject ", o.reproject_every, "' is for 'kinematics total'; with 'kinematics updated' velocities are "
                          "transferred in every step, leave 'reproject' out"));
  if (o.updated && o.reproject_distortion > 0.0)
    args.complain("'reproject auto' is for 'kinematics total'; 'kinematics updated' takes a new reference in every step, leave "
                  "'reproject' out");
  if (o.reproject_every > 0 && o.reproject_distortion > 0.0)
    args.complain("'reproject' is given as a number and as 'auto'; use one of them");
  if (!o.updated && w.transfer_given && o.reproject_every == 0 && o.reproject_distortion == 0.0)
    args.complain("'transfer' says how velocities are re-projected, which 'kinematics total' does with 'reproject N' or 'reproject "
                  "auto D' only; give one of them, or 'kinematics updated'");
  if (o.updated && o.relax > 0.0)
    args.complain(text_of("'quasistatic ", o.mass_scale, " ", o.relax, "' with 'kinematics updated': its damping goes with the reference "
                          "of 'kinematics total'; use that, or damping 0"));
  const bool reprojects = o.reprojects();
  if (w.tied_given && o.tied && reprojects)
    args.complain(text_of("'edge tied' is for 'kinematics total' without 'reproject': nodes that points give their velocity to are free; "
                          "use 'edge free' or leave ", o.updated ? "'kinematics updated'" : "'reproject'", " out"));
  if (reprojects) o.tied = false;
  if (reprojects && o.mass_order > 1)
    args.complain(text_of("'mass_order ", o.mass_order, "' is for 'kinematics total' without 'reproject', whose nodes keep their velocity; leave it out, or leave ",
                          o.updated ? "'kinematics updated'" : "'reproject'", " out"));
  // An average of the drive ends at a crack only where its sides have nodes of their own.
  if (!w.cracks_given) o.split = o.advance.nonlocal && !reprojects && !o.condense;
  if (o.split && reprojects)
    args.complain(text_of("'cracks split' is for 'kinematics total' without 'reproject': where points meet other nodes as they move, a crack has no nodes "
                          "of its own; use 'cracks bonds' or leave ", o.updated ? "'kinematics updated'" : "'reproject'", " out"));
  if (o.unilateral && w.law->inert()) args.complain("'unilateral yes' needs a law of damage, 'damage tensor' for instance");
  if (o.unilateral && (o.updated || o.reproject_distortion > 0.0))
    args.complain(text_of("'unilateral yes' measures cracks from a reference that stays; use 'kinematics total' without 'reproject auto', or 'unilateral no'"));
  if (o.condense && reprojects)
    args.complain(text_of("'condense yes' is for 'kinematics total' without 'reproject': a condensed bond waits in the reference of its creation; use "
                          "'condense no' or leave ", o.updated ? "'kinematics updated'" : "'reproject'", " out"));
  if (o.condense && o.mass_order > 1)
    args.complain(text_of("'condense yes' is for 'mass_order 1', the mass that condensed bonds have; use 'condense no' or leave 'mass_order ", o.mass_order, "' out"));
  if (o.condense && o.basis == Basis::cubic)
    args.complain("'condense yes' is for 'basis quadratic' or 'linear': with 'basis cubic' nodes at the edge hold by so little that bonds wake differently on "
                  "other ranks; use 'condense no' or leave 'basis cubic' out");
  if (o.condense && o.unilateral)
    args.complain("'condense yes' is for 'unilateral no': points that are stiff again while their crack is closed are not linear; use 'condense no' or leave 'unilateral yes' out");
  if (o.subcycle != 1 && reprojects)
    args.complain(text_of("'subcycle' is for 'kinematics total' without 'reproject': cement follows impulses on its grains by its places in the reference; use "
                          "'subcycle no' or leave ", o.updated ? "'kinematics updated'" : "'reproject'", " out"));
  if (o.updated && o.basis == Basis::linear)
    args.complain("'kinematics updated' with 'basis linear': no time step stays stable as points move, since a node that they have just reached has "
                  "stiffness but next to no mass; use 'basis quadratic', or 'kinematics total'");
  if (flip && o.reproject_every > 1)
    args.complain(text_of("'transfer flip' with 'reproject ", o.reproject_every, "' feeds energy into the cement; use 'reproject 1', "
                          "or 'transfer apic' or 'xpic' with any interval"));
  if (flip && o.reproject_distortion > 0.0)
    args.complain("'transfer flip' needs the velocity of each point, which 'reproject auto' has not; use 'transfer apic'");
}

double take_kinetic_share(Arguments& args) {
  const double share = args.accept("no") ? 0.0 : args.positive("kinetic_share", " or 'no'");
  if (share > 1.0)
    args.complain(text_of("'kinetic_share ", share, "': share of the energy above which cement should not begin to fail, must lie in (0, 1], or be 'no'; 0.003 for instance"));
  return share;
}

void take_condense(Arguments& args, CementOptions& o) {
  o.condense = args.yes_no("condense");
  if (!args.accept("wake")) return;
  o.wake = args.number("condense ... wake");
  if (!(o.wake > 0.0 && o.wake <= 1.0)) args.complain(text_of("'condense ... wake ", o.wake, "': share of the threshold of the damage, must lie in (0, 1]"));
}

}  // namespace

CementWords take_cement_words(Arguments& args) {
  CementWords w;
  CementOptions& o = w.options;
  bool has_elastic = false;
  VtiConstants constants;
  LawChoice damage{&law_entries().front(), {}};
  Softening softening;
  while (!args.empty()) {
    const std::string key = args.word("a keyword");
    check_misplaced(args, key, damage);
    // each thing that may be skipped has a `skip` of its own; `reproject` in two ways has a message of its own
    if (is_one_of(key, kKeywords) && key != "skip" && key != "reproject") args.once(key);
    if (key == "cell") {
      o.cell = args.positive(key);
    } else if (key == "basis") {
      o.basis = static_cast<Basis>(args.place_of_choice(key, Bases::names()));
    } else if (key == "mass_order") {
      o.mass_order = args.integer(key, 1, 2);
    } else if (key == "kinematics") {
      o.updated = args.choice(key, {"total", "updated"}) == "updated";
    } else if (key == "edge") {
      o.tied = args.choice(key, {"tied", "free"}) == "tied";
      w.tied_given = true;
    } else if (key == "transfer") {
      take_transfer(args, w);
    } else if (key == "elastic") {
      constants = take_elastic(args);
      has_elastic = true;
    } else if (key == "axis") {
      take_axis(args, o);
    } else if (key == "damage") {
      damage = read_choice(args, "damage", law_entries());
    } else if (key == "regularization") {
      take_regularization(args, o, softening);
    } else if (key == "reproject") {
      const bool automatic = args.accept("auto");
      args.once(automatic ? "reproject auto" : "reproject N");
      if (automatic) o.reproject_distortion = args.positive("reproject auto");
      else o.reproject_every = args.integer(key, 1, std::numeric_limits<int>::max(), " or 'auto'");
    } else if (key == "skip") {
      take_skip(args, w);
    } else if (key == "timestep") {
      w.step_fraction = take_step_fraction(args);
    } else if (key == "subcycle") {
      take_subcycle(args, o);
    } else if (key == "quasistatic") {
      o.mass_scale = args.between("quasistatic", 1.0, kMostInertia, "factor on the inertia");
      o.relax = args.between(text_of("quasistatic ", o.mass_scale), 0.0, kMostDamping, "the second number, share of critical damping");
    } else if (key == "kinetic_share") {
      w.kinetic_share = take_kinetic_share(args);
    } else if (key == "events") {
      w.events = args.word("a file name for 'events'");
    } else if (key == "cracks") {
      o.split = args.choice(key, {"bonds", "split"}) == "split";
      w.cracks_given = true;
    } else if (key == "unilateral") {
      o.unilateral = args.choice(key, {"yes", "no"}) == "yes";
    } else if (key == "condense") {
      take_condense(args, o);
    } else if (key == "balance") {
      o.balance = args.yes_no(key);
    } else if (key == "check") {
      o.check_every = args.integer(key, 1);
    } else {
      std::vector<std::string> known = kKeywords;
      for (const std::string& word : law_words("damage", law_entries())) known.push_back(word);
      known.insert(known.end(), {"and after 'regularization nonlocal' energy", "imperfection"});
      args.unknown(key, known);
    }
  }
  if (o.cell == 0.0) args.complain("keyword 'cell' is missing: the spacing of the background grid");
  if (!has_elastic) args.complain("keyword 'elastic' is missing: use 'elastic vti Ep Ez nu_p nu_zp Gzp' or 'elastic isotropic E nu'");
  w.law = make_law(args, damage, constants, softening, o);
  check_strength(args, *w.law, damage.entry->name);
  if (const std::optional<Localisation> band = w.law->crack_band()) o.half_band = 0.5 * band->width * o.length;
  check_together(args, w);
  return w;
}

}  // namespace mpdem
