// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "contact_contents.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>

#include "../../geometry/shape.h"
#include "../../parallel/agree.h"

namespace mpdem {

namespace {

enum Stream { kSelection, kContent };  // draws of a pair

// Finalizer of SplitMix64 (Steele, Lea, Flood 2014): every bit of the argument changes half of those of the result.
std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

}  // namespace

const std::array<const char*, ContentWish::kPatterns>& pattern_names() {
  static const std::array<const char*, ContentWish::kPatterns> names = {"contact", "bridging", "coating", "filling"};
  return names;
}

double draw_of_pair(int seed, std::pair<int, int> tags, int stream) {
  std::uint64_t h = mixed(static_cast<std::uint64_t>(seed) * 4u + static_cast<std::uint64_t>(stream));
  h = mixed(h ^ static_cast<std::uint64_t>(tags.first));
  h = mixed(h ^ static_cast<std::uint64_t>(tags.second));
  return (static_cast<double>(h >> 12) + 0.5) * 0x1p-52;
}

// Halley's method on the distribution, from the bound 2 Phi(x) <= exp(-x^2/2) of the tail.
double normal_quantile(double probability) {
  const double p = std::min(probability, 1.0 - probability);  // the lower tail, without cancellation in erfc
  double x = -std::sqrt(-2.0 * std::log(2.0 * p));
  for (int n = 0; n < 100; ++n) {
    const double below = 0.5 * std::erfc(-x / std::sqrt(2.0));
    const double step = (below - p) / (std::exp(-0.5 * x * x) / std::sqrt(2.0 * M_PI));
    const double next = x - step / (1.0 + 0.5 * x * step);  // Halley
    if (std::fabs(next - x) <= 1e-15 * (1.0 + std::fabs(x))) break;
    x = next;
  }
  return probability < 0.5 ? x : -x;
}

ContentWish::Pattern ContactContents::pattern_of(const PairToCement& pair) const {
  const double touch = wish_.touch < 0.0 ? ContentWish::kTouch * pair.smaller : wish_.touch;
  return pair.gap <= touch ? ContentWish::contact : ContentWish::bridging;
}

// The content of a pair, or with `calcite` its ratio to others.
double ContactContents::weight(const PairToCement& pair) const {
  if (wish_.spread == ContentWish::same) return content_;
  if (wish_.spread == ContentWish::file) return by_pair_.at(pair.tags);
  const double u = draw_of_pair(wish_.seed, pair.tags, kContent);
  if (wish_.spread == ContentWish::uniform) return wish_.first + u * (wish_.second - wish_.first);
  const double square = std::log1p(wish_.second * wish_.second);  // variance of the logarithm
  return wish_.first * std::exp(std::sqrt(square) * normal_quantile(u) - 0.5 * square);
}

// The share of these pairs that gets cement: the nearest ones, or those whose draws are least.
std::vector<std::size_t> ContactContents::chosen(const std::vector<PairToCement>& pairs, const std::vector<std::size_t>& among) const {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t n : among) order.emplace_back(wish_.nearest ? pairs[n].gap : draw_of_pair(wish_.seed, pairs[n].tags, kSelection), n);
  std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : pairs[a.second].tags < pairs[b.second].tags;
  });
  order.resize(static_cast<std::size_t>(std::llround(wish_.share * static_cast<double>(order.size()))));
  std::vector<std::size_t> kept;
  for (const auto& o : order) kept.push_back(o.second);
  std::sort(kept.begin(), kept.end());
  return kept;
}

// Sets the contents of these pairs to f w within their bounds, with weights w and the factor f that gives the mass asked for.
void ContactContents::reach(ContentWish::Pattern p, const std::vector<PairToCement>& pairs, const std::vector<std::size_t>& among,
                            const Bounds& bounds, std::vector<double>& contents) {
  struct Part {
    double weight, least, most, mass;
  };
  std::vector<Part> parts;
  double least = 0.0, most = 0.0, to = 0.0;
  for (std::size_t n : among) {
    const auto [low, high] = bounds(n);
    parts.push_back({weight(pairs[n]), low, high, pairs[n].mass});
    least += low * pairs[n].mass;
    most += high * pairs[n].mass;
    to = std::max(to, high / parts.back().weight);
  }
  const double target = wish_.calcite * wish_.pattern[p] * grain_mass_;
  const std::string where = p == ContentWish::contact ? " contacts" : " gaps between grains";
  if (!(target >= least && target <= most))
    throw BadState(text_of(
        "'calcite ", wish_.calcite, "' with 'pattern ... ", pattern_names()[p], " ", wish_.pattern[p], "' asks for ", target / grain_mass_,
        " of the mass of the grains at ", among.size(), where, ", which take ", least / grain_mass_, " to ", most / grain_mass_, "; ",
        among.empty() ? "use a wider 'gap', another 'touch', or no such share" : "give this pattern another share, or another 'calcite'"));
  const auto content = [](const Part& part, double f) { return std::clamp(f * part.weight, part.least, part.most); };
  const double f = bisect_rising(
      [&](double factor) {
        double sum = -target;
        for (const Part& part : parts) sum += content(part, factor) * part.mass;
        return sum;
      },
      0.0, to);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    contents[among[k]] = content(parts[k], f);
    cut_ += contents[among[k]] != f * parts[k].weight;
  }
}

std::vector<double> ContactContents::choose(const std::vector<PairToCement>& pairs, const Bounds& bounds) {
  std::vector<double> contents(pairs.size(), 0.0);
  for (const ContentWish::Pattern p : {ContentWish::contact, ContentWish::bridging}) {
    if (wish_.calcite > 0.0 && wish_.pattern[p] == 0.0) continue;
    std::vector<std::size_t> among;
    for (std::size_t n = 0; n < pairs.size(); ++n)
      if (pattern_of(pairs[n]) == p && (wish_.spread != ContentWish::file || by_pair_.count(pairs[n].tags))) among.push_back(n);
    candidates_[p] = static_cast<int>(among.size());
    among = chosen(pairs, among);
    cemented_[p] = static_cast<int>(among.size());
    if (wish_.calcite > 0.0) {
      reach(p, pairs, among, bounds, contents);
      continue;
    }
    for (std::size_t n : among) {
      contents[n] = weight(pairs[n]);
      if (wish_.spread == ContentWish::same) continue;  // what does not fit is an error
      const auto [low, high] = bounds(n);
      cut_ += contents[n] < low || contents[n] > high;
      contents[n] = std::clamp(contents[n], low, high);
    }
  }
  return contents;
}

std::map<std::pair<int, int>, double> read_contents(const std::string& text, const std::string& file,
                                                    const std::vector<std::pair<int, int>>& pairs) {
  std::map<std::pair<int, int>, double> found;
  std::istringstream in(text);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line.resize(std::min(line.find('#'), line.size()));
    std::istringstream words(line);
    std::string rest;
    int a = 0, b = 0;
    double content = 0.0;
    if (!(words >> rest)) continue;
    words.clear();
    words.str(line);
    const std::string where = text_of("file '", file, "', line ", number, ": ");
    if (!(words >> a >> b >> content) || words >> rest || !std::isfinite(content) || content <= 0.0)
      throw BadState(where + "needs two IDs of grains and a content above 0, as '3 7 0.006'");
    const std::pair<int, int> pair = std::minmax(a, b);
    if (!std::binary_search(pairs.begin(), pairs.end(), pair))
      throw BadState(text_of(where, "grains ", a, " and ", b,
                             " are no pair that gets cement here: they must differ, be in the group, within the gap, and "
                             "have none yet"));
    if (!found.emplace(pair, content).second) throw BadState(text_of(where, "grains ", a, " and ", b, " come twice"));
  }
  if (found.empty()) throw BadState(text_of("file '", file, "' has no pair of grains; write lines as '3 7 0.006'"));
  return found;
}

double volume_of_coats(const std::vector<double>& radii, double t) {
  double sum = 0.0;
  for (double R : radii) sum += 4.0 / 3.0 * M_PI * t * (3.0 * R * R + 3.0 * R * t + t * t);
  return sum;
}

double coat_of_mass(const std::vector<double>& radii, double density, double mass, const std::string& asked) {
  const double smallest = *std::min_element(radii.begin(), radii.end()), most = kMostCoat * smallest;
  const double largest = density * volume_of_coats(radii, most);
  if (mass > largest)
    throw BadState(text_of(asked, " needs a coat of the mass ", mass, ", and one of ", kMostCoat, " of the smallest radius, ", most,
                           ", has ", largest, "; give at most ", largest / mass, " of it"));
  return bisect_rising([&](double t) { return density * volume_of_coats(radii, t) - mass; }, 0.0, most);
}

}  // namespace mpdem
