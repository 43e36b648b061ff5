// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "ligament.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace mpdem {

namespace {

// Finds the largest number of paths from grain to grain with no point in common. It is the maximum flow through the graph in which
// each point is an entry and an exit, joined by an arc of capacity one. Arcs to neighbours lead from an exit to an entry and have no
// limit. A further path may also go back along an arc of an earlier one, which then takes another way. Such paths are searched in
// sweeps. A sweep passes each entry and exit once, the nearest to the second grain first, for paths of any length. Among many small
// gaps paths of all lengths are needed. A sweep for each length (Dinic) takes several times as long.
class Flow {
 public:
  // near: for each passable point those across its faces, kNone if there is none. attached: for each point and grain.
  Flow(std::vector<std::array<int, 6>> near, std::vector<std::array<char, 2>> attached)
      : near_(std::move(near)),
        attached_(std::move(attached)),
        before_(near_.size(), kNone),
        after_(near_.size(), kNone),
        level_(2 * near_.size()),
        met_(2 * near_.size()) {
    for (bool more = true; more;) {
      more = false;
      spread_from_second();
      met_.assign(met_.size(), 0);
      for (int i = 0; i < size(); ++i)
        if (attached_[i][0] && reached(entry(i)) && !met_[entry(i)]) more = augment(i) || more;
    }
  }

  // Points of the minimum cut nearest to a grain (0, 1): the last points that can be reached from there.
  std::vector<int> cut_near(int grain) {
    if (grain == 0) spread_from_first();
    else spread_from_second();
    std::vector<int> cut;
    for (int i = 0; i < size(); ++i)
      if (reached(grain == 0 ? entry(i) : exit(i)) && !reached(grain == 0 ? exit(i) : entry(i))) cut.push_back(i);
    return cut;
  }

  static constexpr int kNone = -1;

 private:
  static constexpr int kGrain = -2;

  int size() const { return static_cast<int>(near_.size()); }
  static int entry(int i) { return 2 * i; }
  static int exit(int i) { return 2 * i + 1; }
  // before_ and after_ have the neighbours of a point on its path: kGrain at the ends of the path, kNone without a path.
  bool on_path(int i) const { return before_[i] != kNone; }
  bool reached(int node) const { return level_[node] > 0; }
  void reach(int node, int level) {
    if (node < 0 || reached(node)) return;
    level_[node] = level;
    queue_.push_back(node);
  }

  // Sets level_ of each entry and exit to its steps to the second grain, 0 without a way. spread_from_first(): steps from the first.
  void spread_from_second() {
    level_.assign(level_.size(), 0);
    queue_.clear();
    for (int i = 0; i < size(); ++i)
      if (attached_[i][1]) reach(exit(i), 1);
    for (std::size_t k = 0; k < queue_.size(); ++k) {
      const int node = queue_[k], i = node / 2, level = level_[node] + 1;
      if (node == exit(i)) {
        const int from = !on_path(i) ? i : after_[i];
        if (from >= 0) reach(entry(from), level);
      } else {
        for (int j : near_[i])
          if (j >= 0) reach(exit(j), level);
        if (on_path(i)) reach(exit(i), level);
      }
    }
  }

  void spread_from_first() {
    level_.assign(level_.size(), 0);
    queue_.clear();
    for (int i = 0; i < size(); ++i)
      if (attached_[i][0]) reach(entry(i), 1);
    for (std::size_t k = 0; k < queue_.size(); ++k) {
      const int node = queue_[k], i = node / 2, level = level_[node] + 1;
      if (node == entry(i)) {
        const int to = !on_path(i) ? i : before_[i];
        if (to >= 0) reach(exit(to), level);
      } else {
        for (int j : near_[i])
          if (j >= 0) reach(entry(j), level);
        if (on_path(i)) reach(entry(i), level);
      }
    }
  }

  // Next node (entry or exit) towards the second grain: the one with the fewest steps left that this sweep has not met, or kNone.
  int step(int node) const {
    const int i = node / 2;
    int best = kNone;
    const auto offer = [&](int next) {
      if (reached(next) && !met_[next] && (best == kNone || level_[next] < level_[best])) best = next;
    };
    if (node == entry(i)) {
      const int to = !on_path(i) ? i : before_[i];
      if (to >= 0) offer(exit(to));
      return best;
    }
    for (int j : near_[i])
      if (j >= 0) offer(entry(j));
    if (on_path(i)) offer(entry(i));
    return best;
  }

  // Adds a path from this point at the first grain over nodes that this sweep has not met. Returns false if there is none.
  bool augment(int start) {
    walk_.assign(1, entry(start));
    met_[entry(start)] = 1;
    while (!walk_.empty()) {
      const int node = walk_.back();
      if (node == exit(node / 2) && level_[node] == 1) break;
      const int next = step(node);
      if (next != kNone) {
        walk_.push_back(next);
        met_[next] = 1;
      } else {
        walk_.pop_back();
      }
    }
    if (walk_.empty()) return false;
    before_[start] = kGrain;
    for (std::size_t k = 0; k + 1 < walk_.size(); ++k) {
      const int a = walk_[k], b = walk_[k + 1], i = a / 2, j = b / 2;
      if (a != exit(i)) continue;  // arcs through a point, or back along a path, follow from the arcs beside them
      if (i == j) {
        before_[i] = after_[i] = kNone;  // the earlier path leaves the point
      } else {
        after_[i] = j;
        before_[j] = i;
      }
    }
    after_[walk_.back() / 2] = kGrain;
    return true;
  }

  std::vector<std::array<int, 6>> near_;
  std::vector<std::array<char, 2>> attached_;
  std::vector<int> before_, after_, level_, queue_, walk_;
  std::vector<char> met_;
};

// Indices of the passable points of a bond, and the flow over these. Point k of the flow is points[k].
struct PassableBond {
  std::vector<int> points;
  Flow flow;
};

template <class Passes, class Attached>
PassableBond bond_of(const std::vector<CrackPoint>& points, const Neighbours& near, Passes passes, Attached attached) {
  std::vector<int> passed, place(points.size(), Flow::kNone);
  for (int i : near.order())
    if (passes(points[i])) {
      place[i] = static_cast<int>(passed.size());
      passed.push_back(i);
    }
  std::vector<std::array<int, 6>> across(passed.size());
  std::vector<std::array<char, 2>> held(passed.size());
  for (std::size_t k = 0; k < passed.size(); ++k) {
    const CrackPoint& p = points[passed[k]];
    for (int f = 0; f < 6; ++f) {
      const int j = near.of(passed[k])[f];
      across[k][f] = j >= 0 && points[j].layer == p.layer ? place[j] : Flow::kNone;
    }
    for (int g = 0; g < 2; ++g) held[k][g] = attached(p, g);
  }
  return {std::move(passed), Flow(std::move(across), std::move(held))};
}

// Largest damage of the point and of its attached links.
double weakness(const CrackPoint& p) {
  float most = p.damage;
  for (int g = 0; g < 2; ++g)
    if (p.attached[g]) most = std::max(most, p.link_damage[g]);
  return most;
}

// Marks the points of the cut that are attached to a grain and also connected to it over points behind the cut. Paths
// from the other grain would still lead over such a point if only its link failed, so the point must fail.
std::vector<char> leading_on(const std::vector<int>& cut, const std::vector<CrackPoint>& points, const Neighbours& near) {
  std::vector<char> in_cut(points.size(), 0), leads_on(points.size(), 0);
  for (int i : cut) in_cut[i] = 1;
  for (int g = 0; g < 2; ++g) {
    std::vector<char> behind(points.size(), 0);
    std::vector<int> stack;
    const auto add = [&](int i) {
      if (behind[i] || in_cut[i] || points[i].failed) return;
      behind[i] = 1;
      stack.push_back(i);
    };
    for (int i : near.order())
      if (points[i].attached[g]) add(i);
    while (!stack.empty()) {
      const int i = stack.back();
      stack.pop_back();
      for (int j : near.of(i)) {
        if (j < 0 || points[j].layer != points[i].layer) continue;
        if (in_cut[j] && points[j].attached[g]) leads_on[j] = 1;
        add(j);
      }
    }
  }
  return leads_on;
}

double mean_damage(const std::vector<int>& cut, const std::vector<CrackPoint>& points) {
  double sum = 0.0;
  for (int i : cut) sum += weakness(points[i]);
  return cut.empty() ? 0.0 : sum / static_cast<double>(cut.size());
}

}  // namespace

Ligament find_ligament(const std::vector<CrackPoint>& points) {
  const Neighbours near(points);
  Ligament result;
  {
    PassableBond whole = bond_of(
        points, near, [](const CrackPoint&) { return true; },
        [](const CrackPoint& p, int g) { return p.attached[g] || p.link_area[g] > 0.0; });
    result.whole = static_cast<int>(whole.flow.cut_near(0).size());
  }
  PassableBond left = bond_of(
      points, near, [](const CrackPoint& p) { return !p.failed; }, [](const CrackPoint& p, int g) { return p.attached[g]; });
  result.cuts.resize(2);
  double damage[2];
  for (int g = 0; g < 2; ++g) {
    for (int k : left.flow.cut_near(g)) result.cuts[g].push_back(left.points[k]);
    std::sort(result.cuts[g].begin(), result.cuts[g].end());
    damage[g] = mean_damage(result.cuts[g], points);
  }
  if (std::fabs(damage[1] - damage[0]) > kSameDamage) result.cuts.erase(result.cuts.begin() + (damage[0] > damage[1]));
  else if (result.cuts[0] == result.cuts[1]) result.cuts.pop_back();
  return result;
}

std::vector<CrackPoint> cut_through(const std::vector<int>& cut, std::vector<CrackPoint> points, bool residue) {
  const std::vector<char> leads_on = residue ? leading_on(cut, points, Neighbours(points)) : std::vector<char>(points.size(), 1);
  for (int i : cut) {
    CrackPoint& p = points[i];
    bool debond = false;
    for (int g = 0; g < 2; ++g) {
      if (!p.attached[g] || (residue && p.link_damage[g] <= p.damage)) continue;
      p.attached[g] = false;
      debond = true;
    }
    p.failed = !debond || leads_on[i];
  }
  return points;
}

}  // namespace mpdem
