// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "grammar.h"

#include <cmath>
#include <cstdio>
#include <sstream>

namespace fuzz {

const char* const kSceneNames[kScenes] = {"nothing", "grains", "cement", "fixes", "point file", "restart"};

namespace {

using Lines = std::vector<std::string>;
using Words = std::vector<std::string>;

const Lines kHost = {"units si",       "atom_style mpdem", "atom_modify map array first grains",
                     "boundary f f f", "newton off",       "communicate single vel yes"};
const Lines kNeighbours = {"communicate single vel yes group grains", "neighbor 0.0005 bin", "neigh_modify include grains delay 0"};
const Lines kTwoGrains = {"region box block -0.006 0.006 -0.006 0.006 -0.0125 0.0125 units box",
                          "create_box 2 box",
                          "create_atoms 1 single 0 0 -0.005 units box",
                          "create_atoms 1 single 0 0 0.005 units box",
                          "set type 1 diameter 0.01 density 2500",
                          "group grains type 1"};
const Lines kMotion = {"group first id 1", "group second id 2", "fix hold first move linear 0 0 0", "fix pull second move linear 0 0 0.1",
                       "timestep 1e-9"};
// The second grain follows its own mass, pushed before and after the package.
const Lines kFreeMotion = {"group first id 1",
                           "group second id 2",
                           "fix hold first move linear 0 0 0",
                           "fix pull second nve/sphere",
                           "fix push second addforce 1 0 5",
                           "fix keep second setforce NULL 0 NULL",
                           "timestep 4e-9"};

const Lines kCreate = {
    "create_cement calcite pair 1 2 shape flat inner 1e-3 outer 2e-3 film grid spacing 4e-4",
    "create_cement calcite pair 1 2 shape flat content 0.01 inner auto spacing 4e-4 density 2600 type 2",
    "create_cement calcite pair 2 1 shape flat outer 2.5e-3 inner auto spacing 4e-4",
    "create_cement calcite pair 1 2 shape meniscus neck 2e-3 contact 20 inner auto spacing 4e-4",
    "create_cement calcite pair 1 2 shape meniscus filling 30 inner 5e-4 film grid spacing 4e-4",
    "create_cement calcite pair 1 2 shape meniscus content 0.02 contact 0 inner auto spacing 4e-4",
    "create_cement calcite pair 1 2 shape coating thickness 8e-4 cap 40 inner 5e-4 film grid spacing 4e-4",
    "create_cement calcite pair 1 2 shape coating content 0.15 cap 60 inner auto spacing 4.5e-4",
    "create_cement calcite pair 1 2 shape coating thickness 8e-4 cap 40 shape meniscus filling 35 inner auto spacing 4e-4",
    "create_cement calcite pair 1 2 shape coating thickness 8e-4 cap 30 inner auto spacing 4e-4 type 2 density 2710",
    "create_cement calcite contacts grains gap 1e-5 shape flat inner 1e-3 outer 2e-3 film grid spacing 4e-4",
};
const Lines kPointFiles = {
    "create_cement calcite pair 1 2 file points.txt spacing 4e-4",
    "create_cement calcite pair 1 2 file points.txt spacing 4e-4 attach 6e-4 density 2600 type 2",
};
const Lines kMpm = {
    "fix cem calcite mpm cell 8e-4 elastic vti 60e9 40e9 0.25 0.2 18e9",
    "fix cem calcite mpm cell 8e-4 elastic isotropic 60e9 0.25 axis bond damage tensor B0 9.6e3 cutoff 0.9 zeta 0.1 interface 0.5",
    "fix cem calcite mpm cell 8e-4 basis quadratic kinematics total elastic vti 60e9 40e9 0.25 0.2 18e9 axis global 0 0 1 reproject 2 "
    "check 1",
    "fix cem calcite mpm cell 8e-4 elastic vti 60e9 40e9 0.25 0.2 18e9 kinematics updated transfer apic damage tensor B0 9.6e3 check 2",
    "fix cem calcite mpm cell 8e-4 elastic vti 60e9 40e9 0.25 0.2 18e9 kinematics updated transfer xpic 3 basis cubic",
    "fix cem calcite mpm cell 8e-4 elastic vti 60e9 40e9 0.25 0.2 18e9 kinematics updated transfer flip 0.9 basis linear",
    "fix cem calcite mpm cell 8e-4 elastic vti 60e9 40e9 0.25 0.2 18e9 kinematics updated transfer pic",
    "fix cem calcite mpm cell 8e-4 elastic vti 60e9 40e9 0.25 0.2 18e9 basis cubic timestep auto 0.9 reproject auto 0.2 transfer apic",
    "fix cem calcite mpm cell 8e-4 elastic vti 60e9 40e9 0.25 0.2 18e9 quasistatic 100 0.2 kinetic_share 0.01 balance yes skip resting no "
    "skip all yes",
    "fix cem calcite mpm cell 8e-4 elastic isotropic 60e9 0.25 damage tensor B0 9.6e3 viscosity 1e-6 evolution full events events.csv",
    "fix cem calcite mpm cell 8e-4 elastic isotropic 60e9 0.25 damage tensor B0 9.6e3 regularization crackband 10 axis radial",
    "fix cem calcite mpm cell 8e-4 elastic isotropic 60e9 0.25 damage tensor B0 9.6e3 regularization nonlocal 8e-4 energy 40 imperfection "
    "1e-3 axis radial",
    "fix cem calcite mpm cell 8e-4 basis linear edge free transfer flip 1 reproject 1 elastic isotropic 60e9 0.25 damage none "
    "regularization none",
    "fix cem calcite mpm cell 4e-4 elastic isotropic 60e9 0.25 skip undamaged no skip failed no skip detached no",
};
const Lines kCouple = {
    "fix bond grains mpm/couple cem",
    "fix bond grains mpm/couple cem kn auto kt auto csv 1 bond.csv",
    "fix bond grains mpm/couple cem kn 9.6e9 kt 0.96e9 length 1e-4 at points damping 0.05",
    "fix bond grains mpm/couple cem length cell at surface damping 0",
};
const Lines kCheck = {"fix ts all check/timestep/mpm 1 cem 0.9", "fix ts all check/timestep/mpm 2 cem 0.5 warn",
                      "fix ts calcite check/timestep/mpm 1 cem 0.9 stop"};
const Words kQuantities = {"damage",    "damage_xx", "damage_yz", "drive", "stress_xx", "stress_zz", "stress_xy", "stress_max", "pressure",
                           "strain_xx", "strain_xy", "attached",  "grain", "failed",    "volume",    "axis_x",    "axis_z",     "bond"};
const Lines kWrite = {"write_cement out.txt", "write_cement out.txt pair 1 2", "write_cement no/such/folder/out.txt pair 2 1",
                      "bond_stiffness out.csv", "bond_stiffness no/such/folder/out.csv"};
const Lines kStyle = {"atom_style mpdem", "atom_style hybrid mpdem molecular", "atom_style hybrid sphere mpdem", "atom_style sphere"};
// Ours is what follows from these, not what LIGGGHTS makes of them: they are not mutated.
const Lines kOther = {"unfix cem",
                      "unfix bond",
                      "unfix hold",
                      "run 0",
                      "run 1",
                      "run 3",
                      "delete_atoms group calcite compress no",
                      "delete_atoms group second compress no",
                      "delete_atoms group second",
                      "displace_atoms calcite move 0 0 1e-5 units box",
                      "velocity all set 0 0 1",
                      "velocity calcite set 1e4 0 0",
                      "velocity calcite ramp vz -1e7 1e7 z -1e-3 1e-3",
                      "timestep 1e-3",
                      "timestep 1e-30",
                      "write_restart a.restart",
                      "group calcite subtract all all",
                      "set group all density 1e-300",
                      "group calcite union all grains",
                      "neigh_modify delay 3 every 7",
                      "fix more all nve/sphere",
                      "fix g all gravity 9.81 vector 0 0 -1",
                      "fix more grains freeze",
                      "change_box all boundary p p p",
                      "change_box all x final -1 1 units box",
                      "set group second diameter 1e-5",
                      "set group grains x 1e300",
                      "reset_timestep 1000000",
                      "clear",
                      "create_atoms 1 single 0.003 0 0 units box",
                      "thermo 1"};
const Words kOdd = {"0",
                    "-1",
                    "1",
                    "2",
                    "1e308",
                    "-1e308",
                    "1e-308",
                    "4.9e-324",
                    "nan",
                    "-nan",
                    "inf",
                    "-inf",
                    "1e999",
                    "0x1p3",
                    "2147483647",
                    "2147483648",
                    "-2147483648",
                    "9223372036854775808",
                    "1e-9",
                    "1e9",
                    "0.5",
                    "90",
                    "180",
                    "360",
                    "1e300",
                    "1e-300",
                    "NULL",
                    "all",
                    "auto",
                    "none",
                    "yes",
                    "no",
                    "calcite",
                    "grains",
                    "cem",
                    "bond",
                    "1e",
                    "e5",
                    "--",
                    "+",
                    ".",
                    "1.2.3",
                    "1,2",
                    "µm",
                    "\xff\xfe",
                    "日本",
                    "%s%n%d",
                    "/dev/null",
                    "/",
                    "..",
                    "*",
                    "?",
                    "\\",
                    "cell",
                    "v_x",
                    "c_1",
                    "f_cem",
                    "1:2",
                    std::string(300, 'a'),
                    std::string(300, '9')};

void split(const std::string& line, Words& words) {
  std::istringstream s(line);
  for (std::string w; s >> w;) words.push_back(w);
}

std::string join(const Words& words) {
  std::string line;
  for (const std::string& w : words) line += (line.empty() ? "" : " ") + w;
  return line;
}

// Words of all commands, to be put where they do not belong.
const Words& pool() {
  static const Words words = [] {
    Words all;
    for (const Lines* lines : {&kCreate, &kPointFiles, &kMpm, &kCouple, &kCheck})
      for (const std::string& l : *lines) split(l, all);
    return all;
  }();
  return words;
}

std::string odd_word(const std::string& word, Random& r) {
  switch (r.below(6)) {
    case 0: return r.of(pool());
    case 1: {  // a number a little or much off
      char* end;
      const double v = std::strtod(word.c_str(), &end);
      if (*end || !std::isfinite(v)) return r.of(kOdd);
      const double factor[] = {-1, 0.5, 2, 10, 1e3, 1e-6, 1e6, 1e-12, 1e12, 1 + 1e-15, 0.1, 0.02, 0.9, 1.1};
      char text[40];
      std::snprintf(text, sizeof text, "%.17g", v * factor[r.below(14)]);
      return text;
    }
    case 2: {  // a letter gone, changed or more
      std::string w = word;
      const int at = r.below(w.size());
      if (r.one_in(3)) w.erase(at, 1);
      else if (r.one_in(2)) w.insert(at, 1, static_cast<char>(33 + r.below(94)));
      else w[at] = static_cast<char>(33 + r.below(94));
      // Quotes and the like are LIGGGHTS' own business.
      for (char& c : w)
        if (c == '$' || c == '"' || c == '\'' || c == '&' || c == '#') c = '_';
      return w.empty() ? "x" : w;
    }
    default: return r.of(kOdd);
  }
}

std::string mutated(const std::string& line, Random& r, int first = 1) {
  Words w;
  split(line, w);
  if (static_cast<int>(w.size()) <= first) return line;
  const auto place = [&] { return first + r.below(w.size() - first); };
  switch (r.below(8)) {
    case 0: {
      w.erase(w.begin() + place());
      break;
    }
    case 1: {
      const int at = place();
      w.insert(w.begin() + at, std::string(w[at]));
      break;
    }
    case 2: {
      std::swap(w[place()], w[place()]);
      break;
    }
    case 3: {
      w.resize(place());
      break;
    }
    case 4: {
      w.insert(w.begin() + place(), r.one_in(2) ? r.of(pool()) : r.of(kOdd));
      break;
    }
    default: {
      const int at = place();
      w[at] = odd_word(w[at], r);
      break;
    }
  }
  return join(w);
}

// Of a script: of the own lines some are mutated, one at least in most inputs.
class Script {
 public:
  explicit Script(Random& r) : r_(r) {}
  void plain(const Lines& lines) { out.insert(out.end(), lines.begin(), lines.end()); }
  void plain(const std::string& line) { out.push_back(line); }
  // What precedes the words of the package (ID, group, style of a fix) is LIGGGHTS' business: changed more rarely.
  void own(std::string line, int odds) {
    const int first = line.rfind("fix ", 0) == 0 ? 4 : line.rfind("compute ", 0) == 0 ? 4 : 1;
    while (r_.one_in(odds)) line = mutated(line, r_, r_.one_in(12) ? 1 : first);
    out.push_back(line);
  }
  Lines out;

 private:
  Random& r_;
};

std::string compute(Random& r) { return "compute q" + std::to_string(r.below(3)) + " calcite mpm/atom cem " + r.of(kQuantities); }

void extras(Script& s, Random& r, int odds) {
  for (int n = r.below(3); n > 0; --n) switch (r.below(6)) {
      case 0: s.own(compute(r), odds); break;
      case 1: s.own(r.of(kCheck), odds); break;
      case 2: s.own(r.of(kWrite), odds); break;
      case 3: s.plain(r.of(kOther)); break;
      default: s.plain("run 2"); break;
    }
}

// A ring of points on a lattice, with some of the columns.
std::string valid_points(Random& r) {
  constexpr double a = 4e-4, R = 5e-3;
  const bool axis = r.one_in(2), tensor = r.one_in(3), principal = !tensor && r.one_in(3), failed = r.one_in(3), grains = r.one_in(3),
             area = r.one_in(3);
  std::ostringstream s;
  s << "# points\nx y z volume" << (axis ? " ax ay az" : "") << (tensor ? " dxx dyy dzz dyz dxz dxy" : "")
    << (principal ? " d1 d2 d3 v1x v1y v1z v2x v2y v2z" : "") << (failed ? " failed" : "") << (grains ? " grain_i grain_j" : "")
    << (area ? " area_i area_j" : "") << "\n";
  s.precision(12);
  for (int i = -7; i < 7; ++i)
    for (int j = -7; j < 7; ++j)
      for (int k = -2; k < 2; ++k) {
        const double x = (i + 0.5) * a, y = (j + 0.5) * a, z = (k + 0.5) * a, rho = std::hypot(x, y);
        if (rho < 2e-3 || rho > 2.5e-3 || std::fabs(z) > R - std::sqrt(R * R - rho * rho)) continue;
        s << x << " " << y << " " << z << " " << a * a * a;
        if (axis) s << " " << x << " " << y << " " << 0.1;
        if (tensor) s << " 0.1 0.2 0.3 0.01 0 0";
        if (principal) s << " 0.1 0.2 0.3 1 0 0 0 1 0";
        if (failed) s << " " << (i == j);
        if (grains) s << " 1 2";
        if (area) s << " " << (z < 0 ? a * a : 0) << " " << (z < 0 ? 0 : a * a);
        s << "\n";
      }
  return s.str();
}

std::string mutated_points(std::string text, Random& r) {
  for (int n = 1 + r.below(3); n > 0 && !text.empty(); --n) switch (r.below(7)) {
      case 0: text[r.below(text.size())] = static_cast<char>(r.below(256)); break;
      case 1: text.resize(r.below(text.size())); break;
      case 2: text.insert(r.below(text.size()), r.of(kOdd)); break;
      case 3: text.erase(r.below(text.size()), 1 + r.below(40)); break;
      default: {  // a word of a line
        Lines lines;
        std::istringstream s(text);
        for (std::string l; std::getline(s, l);) lines.push_back(l);
        std::string& l = lines[r.one_in(3) ? std::min<std::size_t>(1, lines.size() - 1) : r.below(lines.size())];
        l = mutated(l, r, 0);
        if (r.one_in(8)) lines.push_back(l);
        text.clear();
        for (const std::string& line : lines) text += line + "\n";
      }
    }
  return text;
}

std::string mutated_bytes(std::string bytes, Random& r) {
  if (r.one_in(3)) {
    bytes.resize(r.below(bytes.size()));
    return bytes;
  }
  for (int n = 1 + r.below(4); n > 0; --n) {
    const int at = r.below(r.one_in(2) ? std::min<std::size_t>(bytes.size(), 4000) : bytes.size());
    switch (r.below(4)) {
      case 0: bytes[at] = static_cast<char>(bytes[at] ^ (1 << r.below(8))); break;
      case 1: bytes[at] = static_cast<char>(r.below(256)); break;
      case 2: bytes.erase(at, 1 + r.below(16)); break;
      default: bytes.insert(at, 1 + r.below(16), static_cast<char>(r.below(256))); break;
    }
  }
  return bytes;
}

}  // namespace

std::vector<std::string> scene_lines(Scene scene) {
  Lines lines;
  const auto add = [&](const Lines& more) { lines.insert(lines.end(), more.begin(), more.end()); };
  if (scene == kNothing) return lines;
  add(kHost);
  if (scene == kRestart) return lines;
  add(kTwoGrains);
  add(kNeighbours);
  if (scene == kGrains || scene == kPointFile) return lines;
  lines.push_back(kCreate[0]);
  add(kMotion);
  if (scene == kCement) return lines;
  lines.push_back(kMpm[1]);
  lines.push_back(kCouple[1]);
  return lines;
}

Input make_input(std::uint64_t seed, std::uint64_t number, const std::string& restart) {
  Random r(seed * 0x2545f4914f6cdd1du + number);
  Input in;
  in.scene = static_cast<Scene>(number % kScenes);
  Script s(r);
  switch (in.scene) {
    case kNothing:
      s.plain("units si");
      s.own(r.one_in(2) ? kStyle[0] : r.of(kStyle), 6);
      s.plain(Lines(kHost.begin() + 2, kHost.end()));
      if (r.one_in(3)) s.own(r.of(r.one_in(2) ? kCreate : kMpm), 3);  // too early
      if (r.one_in(8)) s.own("write_cement out.txt", 3);
      s.plain(kTwoGrains);
      s.plain(kNeighbours);
      s.own(r.of(kCreate), 4);
      s.plain(r.one_in(3) ? kFreeMotion : kMotion);
      s.own(r.of(kMpm), 4);
      break;
    case kGrains:
      s.own(r.of(kCreate), 2);
      if (r.one_in(6)) s.own(r.of(kCreate), 2);
      s.plain(r.one_in(3) ? kFreeMotion : kMotion);
      s.own(r.of(kMpm), 4);
      s.own(r.of(kCouple), 6);
      extras(s, r, 4);
      s.plain("run 2");
      break;
    case kCement:
      s.own(r.of(kMpm), 2);
      if (!r.one_in(4)) s.own(r.of(kCouple), 3);
      extras(s, r, 3);
      s.plain("run 2");
      extras(s, r, 3);
      break;
    case kFixes:
      for (int n = 1 + r.below(3); n > 0; --n) {
        extras(s, r, 2);
        if (r.one_in(12)) s.own(r.of(kCreate), 2);
        if (r.one_in(3)) s.plain(r.of(kOther));
      }
      s.plain("run 2");
      break;
    case kPointFile:
      in.points = valid_points(r);
      if (!r.one_in(4)) in.points = mutated_points(in.points, r);
      s.own(r.of(kPointFiles), 4);
      s.plain(r.one_in(3) ? kFreeMotion : kMotion);
      s.own(r.of(kMpm), 8);
      s.own(r.of(kCouple), 8);
      s.plain("run 1");
      if (r.one_in(3)) s.own(r.of(kWrite), 4);
      break;
    default:
      in.restart = r.one_in(3) ? restart : mutated_bytes(restart, r);
      s.plain("read_restart fuzz.restart");
      s.plain(kNeighbours);
      s.plain(r.one_in(3) ? kFreeMotion : kMotion);
      s.own(r.one_in(3) ? r.of(kMpm) : kMpm[1], 4);
      s.own(r.one_in(3) ? r.of(kCouple) : kCouple[1], 4);
      s.plain("run 1");
      if (r.one_in(4)) s.plain("write_restart again.restart");
  }
  in.lines = s.out;
  return in;
}

}  // namespace fuzz
