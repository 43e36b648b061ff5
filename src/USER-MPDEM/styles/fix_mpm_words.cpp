// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Words of fix mpm in the script, see doc/fix_mpm.md.
#include <algorithm>
#include <cmath>

#include "arguments.h"
#include "atom.h"
#include "fix_mpm.h"
#include "law_words.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::text_of;

namespace {
const std::vector<std::string> kKeywords = {"cell", "basis", "edge", "kinematics", "transfer", "reproject", "elastic", "axis", "damage",
                                            "regularization", "timestep", "quasistatic", "skip", "check", "events"};

bool is_one_of(const std::string& key, const std::vector<std::string>& list) { return std::find(list.begin(), list.end(), key) != list.end(); }
}  // namespace

void FixMpm::parse(int narg, char** arg) {
  Arguments args(lmp, text_of("fix mpm (id ", id, ")"), narg, arg, 3);
  if (!avec_)
    args.complain(text_of("atom style '", atom->atom_style, "' cannot hold material points; use 'atom_style mpdem'"));
  bool has_elastic = false;
  mpdem::LawChoice damage;
  while (!args.empty()) {
    const std::string key = args.word("a keyword");
    mpdem::check_misplaced(args, key, damage);
    // one `skip` for each thing that may be skipped; `reproject` in two ways has a message of its own
    if (is_one_of(key, kKeywords) && key != "skip" && key != "reproject") args.once(key);
    if (key == "cell") {
      cell_ = args.positive(key);
    } else if (key == "basis") {
      const std::string name = args.choice(key, {"linear", "quadratic", "cubic"});
      basis_ = name == "linear" ? mpdem::Basis::linear : name == "cubic" ? mpdem::Basis::cubic : mpdem::Basis::quadratic;
    } else if (key == "kinematics") {
      updated_ = args.choice(key, {"total", "updated"}) == "updated";
    } else if (key == "edge") {
      tied_ = args.choice(key, {"tied", "free"}) == "tied";
      tied_given_ = true;
    } else if (key == "transfer") {
      parse_transfer(args);
    } else if (key == "elastic") {
      if (args.choice(key, {"vti", "isotropic"}) == "isotropic") {
        const double E = args.number("elastic isotropic E"), nu = args.number("elastic isotropic nu");
        constants_ = mpdem::VtiConstants::isotropic(E, nu);
        if (!(nu > -1.0 && nu < 0.5)) args.complain(text_of("'elastic isotropic' nu = ", nu, " must lie between -1 and 0.5"));
      } else {
        constants_.Ep = args.number("elastic vti Ep");
        constants_.Ez = args.number("elastic vti Ez");
        constants_.nu_p = args.number("elastic vti nu_p");
        constants_.nu_zp = args.number("elastic vti nu_zp");
        constants_.Gzp = args.number("elastic vti Gzp");
      }
      const std::string why = constants_.violated_condition();
      if (!why.empty()) args.complain("'elastic' is not positive definite: " + why);
      has_elastic = true;
    } else if (key == "axis") {
      const std::string rule = args.choice(key, {"radial", "bond", "global"});
      axis_ = rule == "radial" ? kRadial : rule == "bond" ? kBond : kGlobal;
      if (axis_ == kGlobal) {
        double length = 0.0;
        for (double& a : axis_direction_) {
          a = args.number("axis global");
          length += a * a;
        }
        length = std::sqrt(length);
        if (!(length > 0.0)) args.complain("'axis global 0 0 0': a direction is needed");
        for (double& a : axis_direction_) a /= length;
      }
    } else if (key == "damage") {
      damage = mpdem::read_law(args);
    } else if (key == "regularization") {
      fracture_energy_ = args.choice(key, {"none", "crackband"}) == "none" ? 0.0 : args.positive("regularization crackband");
    } else if (key == "reproject") {
      const bool automatic = args.accept("auto");
      args.once(automatic ? "reproject auto" : "reproject N");
      if (automatic) reproject_distortion_ = args.positive("reproject auto");
      else reproject_every_ = args.integer(key, 1);
    } else if (key == "skip") {
      parse_skip(args);
    } else if (key == "timestep") {
      if (!args.accept("auto")) args.complain("'timestep' takes the word 'auto' and a share of the stable step; a step in units of "
                                              "time is set by LIGGGHTS' own command timestep");
      step_fraction_ = args.number("timestep auto");
      if (!(step_fraction_ > 0.0 && step_fraction_ <= 1.0))
        args.complain(text_of("'timestep auto ", step_fraction_, "': share of the stable step, must lie in (0, 1]"));
    } else if (key == "quasistatic") {
      mass_scale_ = args.number("quasistatic");
      if (!(mass_scale_ >= 1.0)) args.complain(text_of("'quasistatic ", mass_scale_, "': factor on the inertia, must be 1 or more"));
      relax_ = args.not_negative("quasistatic: the second number, share of critical damping,");
    } else if (key == "events") {
      events_name_ = args.word("a file name for 'events'");
      events_from_ = update->ntimestep;
    } else if (key == "check") {
      check_every_ = args.integer(key, 1);
    } else {
      std::vector<std::string> known = kKeywords;
      for (const std::string& w : mpdem::law_words()) known.push_back(w);
      args.unknown(key, known);
    }
  }
  if (cell_ == 0.0) args.complain("keyword 'cell' is missing: the spacing of the background grid");
  if (!has_elastic) args.complain("keyword 'elastic' is missing: use 'elastic vti Ep Ez nu_p nu_zp Gzp' or 'elastic isotropic E nu'");
  std::shared_ptr<mpdem::Law> law = damage.make(mpdem::VtiElasticity(constants_));
  if (fracture_energy_ > 0.0) {
    if (!law->has_crack_energy()) args.complain("'regularization crackband' needs 'damage tensor'");
    try {
      law->set_crack_energy(fracture_energy_, cell_);
    } catch (const std::domain_error& e) {
      args.complain(text_of("'regularization crackband': ", e.what()));
    }
  }
  law_ = law;
  check_words(args);
}

void FixMpm::parse_transfer(Arguments& args) {
  using mpdem::Transfer;
  const std::string name = args.choice("transfer", {"pic", "flip", "apic", "xpic"});
  transfer_given_ = true;
  if (name == "pic") {
    transfer_.method = Transfer::pic;
  } else if (name == "apic") {
    transfer_.method = Transfer::apic;
  } else if (name == "flip") {
    transfer_.method = Transfer::flip;
    transfer_.flip_share = args.number("transfer flip");
    if (!(transfer_.flip_share >= 0.0 && transfer_.flip_share <= 1.0))
      args.complain(text_of("'transfer flip ", transfer_.flip_share, "': share of FLIP, the rest is PIC, must lie in [0, 1]"));
  } else {
    transfer_.method = Transfer::xpic;
    transfer_.order = args.integer("transfer xpic", 1);
  }
}

void FixMpm::parse_skip(Arguments& args) {
  const std::string name = args.choice("skip", {"undamaged", "failed", "detached", "resting", "all"});
  args.once("skip " + name);
  const bool on = args.yes_no("skip " + name);
  if (name == "undamaged" || name == "all") skip_.skip_undamaged = on;
  if (name == "failed" || name == "all") skip_.skip_failed = on;
  if (name == "detached" || name == "all") skip_detached_ = on;
  if (name == "resting" || name == "all") skip_.skip_resting = on;
}

// What does not go together.
void FixMpm::check_words(Arguments& args) {
  const bool flip = transfer_given_ && transfer_.method == mpdem::Transfer::flip;
  if (updated_ && reproject_every_ > 0)
    args.complain(text_of("'reproject ", reproject_every_, "' is for 'kinematics total'; with 'kinematics updated' velocities are "
                          "transferred in every step, leave 'reproject' out"));
  if (updated_ && reproject_distortion_ > 0.0)
    args.complain("'reproject auto' is for 'kinematics total'; 'kinematics updated' takes a new reference in every step, leave "
                  "'reproject' out");
  if (reproject_every_ > 0 && reproject_distortion_ > 0.0)
    args.complain("'reproject' is given as a number and as 'auto'; use one of them");
  if (!updated_ && transfer_given_ && reproject_every_ == 0 && reproject_distortion_ == 0.0)
    args.complain("'transfer' says how velocities are re-projected, which 'kinematics total' does with 'reproject N' or 'reproject "
                  "auto D' only; give one of them, or 'kinematics updated'");
  if (updated_ && relax_ > 0.0)
    args.complain(text_of("'quasistatic ", mass_scale_, " ", relax_, "' with 'kinematics updated': its damping goes with the reference "
                          "of 'kinematics total'; use that, or damping 0"));
  const bool transfers = updated_ || reproject_every_ > 0 || reproject_distortion_ > 0.0;
  if (tied_given_ && tied_ && transfers)
    args.complain(text_of("'edge tied' is for 'kinematics total' without 'reproject': nodes that points give their velocity to are free; "
                          "use 'edge free' or leave ", updated_ ? "'kinematics updated'" : "'reproject'", " out"));
  if (transfers) tied_ = false;
  if (flip && reproject_every_ > 1)
    args.complain(text_of("'transfer flip' with 'reproject ", reproject_every_, "' feeds energy into the cement; use 'reproject 1', "
                          "or 'transfer apic' or 'xpic' with any interval"));
  if (flip && reproject_distortion_ > 0.0)
    args.complain("'transfer flip' needs the velocity of each point, which 'reproject auto' has not; use 'transfer apic'");
}

}  // namespace LAMMPS_NS
