// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Chooses which pairs of grains get cement, and how much: bond contents that are equal, drawn from a distribution or
// read from a file, at a share of the pairs; or contents that add up to a calcite content of the specimen, divided among
// patterns of precipitation. A draw is a hash of the seed and the IDs of the two grains, so it does not depend on the
// number of ranks, the order of atoms, or other pairs. See doc/calcite_content.md.
#ifndef MPDEM_CEMENT_CREATION_CONTACT_CONTENTS_H
#define MPDEM_CEMENT_CREATION_CONTACT_CONTENTS_H

#include <array>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "scene_box.h"

namespace mpdem {

struct ContentWish {
  enum Spread { same, lognormal, uniform, file } spread = same;
  double first = 0.0, second = 0.0;  // lognormal: mean and coefficient of variation; uniform: least and largest
  std::string file_name;
  int seed = 0;
  double share = 1.0;    // share of all pairs that gets cement
  bool nearest = false;  // true: cement is at the pairs with the smallest gaps; false: at drawn pairs
  enum Pattern { contact, bridging, coating, filling };
  static constexpr int kPatterns = 4;
  double calcite = 0.0;                           // over the mass of the grains; 0: contents are as given
  std::array<double, kPatterns> pattern = {};     // shares of it, of the sum 1
  double touch = -1.0;                            // largest gap of a contact; below 0: kTouch times the smaller radius
  bool coat_at_walls = true, says_walls = false;  // walls touch the coats; the script says whether

  static constexpr double kTouch = 0.01;
  bool acts() const { return spread != same || share < 1.0 || calcite > 0.0; }
};

const std::array<const char*, ContentWish::kPatterns>& pattern_names();

// A pair of grains that may get cement.
struct PairToCement {
  std::pair<int, int> tags;   // ascending
  double gap, smaller, mass;  // smaller: the smaller radius; mass: of both grains
};

// Uniform number in (0, 1), the same for the same arguments on every machine. stream: for several draws of one pair.
double draw_of_pair(int seed, std::pair<int, int> tags, int stream);
// x below which a standard normal variable lies with this probability, in (0, 1).
double normal_quantile(double probability);

class ContactContents {
 public:
  // Least and largest content that a shape allows between the grains of a pair.
  using Bounds = std::function<std::pair<double, double>(std::size_t pair)>;

  // content: bond content with Spread `same`. grain_mass: of the grains that `calcite` refers to. by_pair: with Spread
  // `file`, contents by pair.
  ContactContents(const ContentWish& wish, double content, double grain_mass, std::map<std::pair<int, int>, double> by_pair)
      : wish_(wish), content_(content), grain_mass_(grain_mass), by_pair_(std::move(by_pair)) {}

  // Returns the content of each pair, 0 where there is no cement. Throws BadState if `calcite` is out of reach.
  std::vector<double> choose(const std::vector<PairToCement>& pairs, const Bounds& bounds);

  // Pattern of a pair, and numbers of pairs, as the last choose() found them.
  ContentWish::Pattern pattern_of(const PairToCement& pair) const;
  int cemented(ContentWish::Pattern p) const { return cemented_[p]; }
  int candidates(ContentWish::Pattern p) const { return candidates_[p]; }
  int cut() const { return cut_; }  // contents that were set to a bound

 private:
  double weight(const PairToCement& pair) const;
  std::vector<std::size_t> chosen(const std::vector<PairToCement>& pairs, const std::vector<std::size_t>& among) const;
  void reach(ContentWish::Pattern p, const std::vector<PairToCement>& pairs, const std::vector<std::size_t>& among, const Bounds& bounds,
             std::vector<double>& contents);

  const ContentWish wish_;
  const double content_, grain_mass_;
  const std::map<std::pair<int, int>, double> by_pair_;
  std::array<int, ContentWish::kPatterns> cemented_ = {}, candidates_ = {};
  int cut_ = 0;
};

// Reads lines `I J content`; `#` begins a comment. pairs: those that may get cement. Throws BadState that names the line.
std::map<std::pair<int, int>, double> read_contents(const std::string& text, const std::string& file,
                                                    const std::vector<std::pair<int, int>>& pairs);

// Thickness of an even coat of this mass on all these spheres. Throws BadState if it exceeds kMostCoat times the smallest
// radius.
constexpr double kMostCoat = 0.2;
double coat_of_mass(const std::vector<double>& radii, double density, double mass, const std::string& asked);
double volume_of_coats(const std::vector<double>& radii, double thickness);

}  // namespace mpdem

#endif
