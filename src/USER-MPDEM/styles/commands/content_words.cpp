// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "content_words.h"

#include <cmath>

namespace mpdem {

namespace {
constexpr double kLeastShare = 1e-6;    // least share of the pairs, and of the calcite
constexpr double kMostVariation = 3.0;  // coefficient of variation of a lognormal content
}  // namespace

std::vector<std::string> content_words() { return {"seed", "cement", "calcite", "pattern", "touch", "walls"}; }

// Reads a distribution of contents after `content`. Returns whether there is one.
bool read_spread(Arguments& args, ContentWish& c) {
  const ContentWish::Spread before = c.spread;
  if (args.accept("lognormal")) {
    c.spread = ContentWish::lognormal;
    const std::vector<double> v = args.numbers(
        "content lognormal", {{"M", "mean content", 0.0, 0.0, true}, {"V", "coefficient of variation", 0.0, kMostVariation}}, "0.01 0.5");
    c.first = v[0], c.second = v[1];
  } else if (args.accept("uniform")) {
    c.spread = ContentWish::uniform;
    const std::vector<double> v = args.numbers(
        "content uniform", {{"LOW", "least content", 0.0, 0.0, true}, {"HIGH", "largest content", 0.0, 0.0, true}}, "0.005 0.02");
    c.first = v[0], c.second = v[1];
    if (!(c.first < c.second)) args.complain(text_of("'content uniform ", c.first, " ", c.second, "': the first must be below the second"));
  } else if (args.accept("file")) {
    c.spread = ContentWish::file;
    c.file_name = args.word("a file name for 'content file'");
  } else {
    return false;
  }
  if (before != ContentWish::same) args.complain("contents of two shapes are drawn; draw one, or use two commands");
  return true;
}

// Reads a keyword of ContentWish. Returns whether it is one.
bool read_content_word(const std::string& key, Arguments& args, ContentWish& c) {
  if (key == "seed") {
    c.seed = args.integer(key, 1);
  } else if (key == "cement") {
    c.share = args.between(key, kLeastShare, 1.0, "share of the pairs");
    c.nearest = args.accept("nearest");
  } else if (key == "calcite") {
    c.calcite = args.between(key, kLeastShare, 1.0, "mass of calcite over that of the grains");
  } else if (key == "pattern") {
    const auto& names = pattern_names();
    const auto begins = [&] {
      for (int p = 0; p < ContentWish::kPatterns; ++p)
        if (args.accept(names[p])) return p;
      return -1;
    };
    double sum = 0.0;
    bool given[ContentWish::kPatterns] = {};
    for (int p; (p = begins()) >= 0; given[p] = true) {
      if (given[p]) args.complain(text_of("'pattern ... ", names[p], "' comes twice"));
      sum += c.pattern[p] = args.between(text_of("pattern ... ", names[p]), 0.0, 1.0, "share of the calcite");
    }
    if (std::fabs(sum - 1.0) > 1e-6)
      args.complain(text_of("'pattern': the shares of contact, bridging, coating and filling add up to ", sum,
                            ", they must to 1; write 'pattern contact 0.6 coating 0.4'"));
  } else if (key == "touch") {
    c.touch = args.not_negative(key);
  } else if (key == "walls") {
    c.coat_at_walls = args.choice(key, {"coat", "bare"}) == "coat";
    c.says_walls = true;
  } else {
    return false;
  }
  return true;
}

// Checks keywords of contents over contacts, and gives the shape its size by `calcite`.
void check_contents(const Arguments& args, CementRequest& wish, bool several) {
  ContentWish& c = wish.contents;
  const double patterns = c.pattern[0] + c.pattern[1] + c.pattern[2] + c.pattern[3];
  if (!several && (c.acts() || c.touch >= 0.0 || c.seed > 0))
    args.complain("contents that are drawn, 'cement' and 'calcite' belong to 'contacts'");
  if (c.acts() && !wish.file.empty())
    args.complain("contents that are drawn, 'cement' and 'calcite' belong to shapes, not to points of a file");
  const bool draws = c.spread == ContentWish::lognormal || c.spread == ContentWish::uniform || (c.share < 1.0 && !c.nearest);
  if (draws && c.seed == 0) args.complain("keyword 'seed' is missing: a whole number from 1 on for the draws");
  if (!draws && c.seed > 0)
    args.complain(text_of("'seed ", c.seed, "': nothing is drawn; use 'content lognormal', 'content uniform' or 'cement'"));
  if (c.calcite == 0.0) {
    if (patterns > 0.0 || c.touch >= 0.0 || c.says_walls)
      args.complain("'pattern', 'touch' and 'walls' belong to 'calcite'; write 'calcite 0.03 pattern contact 1'");
    return;
  }
  if (patterns == 0.0) args.complain("keyword 'pattern' is missing: write 'calcite 0.03 pattern contact 1', or shares of the sum 1");
  if (c.pattern[ContentWish::contact] + c.pattern[ContentWish::bridging] == 0.0)
    args.complain("'pattern': neither contacts nor gaps get cement; for coats alone use 'create_cement ... coat GROUP calcite C'");
  if (wish.shapes.size() != 1) args.complain("'calcite' sizes one shape; use one command for each");
  auto& given = wish.shapes[0].given;
  if (c.spread == ContentWish::same && given.count("content"))
    args.complain("'calcite' and 'content' both give the size of the shape; leave 'content' out, or draw it for the ratio of contents");
  given["content"] = 1.0;
}

}  // namespace mpdem
