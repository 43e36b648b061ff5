// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "separation.h"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <queue>

namespace mpdem {

namespace {

struct Piece {
  int points = 0, least_tag = 0, part = 0;
  bool attached[2] = {false, false};
};

// Spreads the labels (-1: none) from cell to cell, within a part or across, until every point
// that can be reached has one. Fronts advance together; the lower label wins where two meet.
void grow(const Neighbours& near, const std::vector<CrackPoint>& points, bool across, std::vector<int>& label) {
  std::vector<int> front, next, claim(label.size(), -1);
  for (int i : near.order())
    if (label[i] >= 0) front.push_back(i);
  while (!front.empty()) {
    next.clear();
    for (int i : front)
      for (int j : near.of(i))
        if (j >= 0 && label[j] < 0 && (across || points[j].part == points[i].part)) {
          if (claim[j] < 0) next.push_back(j);
          claim[j] = claim[j] < 0 ? label[i] : std::min(claim[j], label[i]);
        }
    for (int j : next) label[j] = claim[j];
    front.swap(next);
  }
}

// Least damage up to which points have to be passed to come from the first grain to the second over intact points
// of a part (Dijkstra's search with the largest damage for the length of a path), if there is a way.
std::optional<float> damage_to_pass(const Neighbours& near, const std::vector<CrackPoint>& points) {
  using Ahead = std::pair<float, int>;
  std::priority_queue<Ahead, std::vector<Ahead>, std::greater<Ahead>> front;
  std::vector<char> seen(points.size(), 0);
  const auto see = [&](int i) {
    seen[i] = 1;
    front.emplace(points[i].damage, i);
  };
  for (int i : near.order())
    if (!points[i].failed && points[i].attached[0]) see(i);
  float most = 0.0f;
  while (!front.empty()) {
    const int i = front.top().second;
    most = std::max(most, front.top().first);
    front.pop();
    if (points[i].attached[1]) return most;
    for (int j : near.of(i))
      if (j >= 0 && !seen[j] && !points[j].failed && points[j].part == points[i].part) see(j);
  }
  return std::nullopt;
}

// Shortest way from the first grain to the second over intact points of a part with at most this damage.
std::vector<int> find_path(const Neighbours& near, const std::vector<CrackPoint>& points, float damage) {
  const auto passable = [&](int i) { return !points[i].failed && points[i].damage <= damage; };
  constexpr int kUnseen = -2, kStart = -1;
  std::vector<int> from(points.size(), kUnseen), queue, path;
  for (int i : near.order())
    if (passable(i) && points[i].attached[0]) {
      from[i] = kStart;
      queue.push_back(i);
    }
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const int i = queue[k];
    if (points[i].attached[1]) {
      for (int j = i; j != kStart; j = from[j]) path.push_back(points[j].tag);
      std::sort(path.begin(), path.end());
      break;
    }
    for (int j : near.of(i))
      if (j >= 0 && from[j] == kUnseen && passable(j) && points[j].part == points[i].part) {
        from[j] = i;
        queue.push_back(j);
      }
  }
  return path;
}

}  // namespace

Separation separate(const std::vector<CrackPoint>& points, const double* face_area, const JoinedNodes& joined, int support) {
  const int n = static_cast<int>(points.size());
  const Neighbours near(points, joined, support);
  Separation result;
  result.part.resize(n);
  for (int i = 0; i < n; ++i) result.part[i] = points[i].part;
  if (const std::optional<float> damage = damage_to_pass(near, points)) {
    result.path = find_path(near, points, *damage);
    return result;
  }
  result.separated = true;

  // Pieces of intact points of one part.
  std::vector<int> piece_of(n, -1);
  std::vector<Piece> pieces;
  std::vector<int> stack;
  for (int first : near.order()) {
    if (points[first].failed || piece_of[first] >= 0) continue;
    Piece p;
    p.part = points[first].part;
    p.least_tag = points[first].tag;
    stack.assign(1, first);
    piece_of[first] = static_cast<int>(pieces.size());
    while (!stack.empty()) {
      const int i = stack.back();
      stack.pop_back();
      ++p.points;
      p.least_tag = std::min(p.least_tag, points[i].tag);
      for (int s = 0; s < 2; ++s) p.attached[s] = p.attached[s] || points[i].attached[s];
      for (int j : near.of(i))
        if (j >= 0 && !points[j].failed && piece_of[j] < 0 && points[j].part == p.part) {
          piece_of[j] = static_cast<int>(pieces.size());
          stack.push_back(j);
        }
    }
    pieces.push_back(p);
  }
  // Parts only ever split, so that their nodes can take over the motion they had together.
  // What is attached keeps its part, but for the first separation, where the second grain's
  // share becomes part 1. Loose pieces become parts of their own, from 2 on, in the order of their
  // least tag, unless they are all there is of such a part already: 0 and 1 follow their grains.
  int next = 2;
  for (const CrackPoint& p : points) next = std::max(next, p.part + 1);
  std::map<int, int> holders;  // part, pieces that count in it
  const auto counts = [](const Piece& p) { return p.attached[0] || p.attached[1] || p.points >= kLeastLoose; };
  for (const Piece& p : pieces) holders[p.part] += counts(p);
  std::vector<int> part_of(pieces.size(), -1), by_tag(pieces.size());
  std::iota(by_tag.begin(), by_tag.end(), 0);
  std::sort(by_tag.begin(), by_tag.end(), [&](int a, int b) { return pieces[a].least_tag < pieces[b].least_tag; });
  for (int k : by_tag) {
    const Piece& p = pieces[k];
    if (!counts(p)) continue;
    if (p.attached[0]) part_of[k] = p.part;
    else if (p.attached[1]) part_of[k] = p.part == 0 ? 1 : p.part;
    else part_of[k] = p.part < 2 || holders[p.part] > 1 ? next++ : p.part;
  }
  std::vector<int> part(n, -1), side(n, -1);
  for (int i = 0; i < n; ++i)
    if (piece_of[i] >= 0) {
      part[i] = part_of[piece_of[i]];
      const Piece& p = pieces[piece_of[i]];
      if (p.attached[0] || p.attached[1]) side[i] = p.attached[0] ? 0 : 1;
    }
  grow(near, points, false, part);
  for (int i = 0; i < n; ++i) result.part[i] = part[i] >= 0 ? part[i] : points[i].part;

  bool held = false, loose = false;
  for (const Piece& p : pieces) {
    held = held || p.attached[0] || p.attached[1];
    loose = loose || p.points >= kLeastLoose;
  }
  if (!held && loose)  // both grains let go between two looks
    for (const CrackPoint& p : points)
      for (int s = 0; s < 2; ++s) result.at_grain[s] += p.link_area[s];

  grow(near, points, true, side);
  for (int i = 0; i < n; ++i) {
    if (side[i] < 0) continue;
    result.at_grain[1 - side[i]] += points[i].link_area[1 - side[i]];
    for (int f = 0; f < 6; ++f) {
      const int j = near.of(i)[f];
      if (j >= 0 && side[i] == 0 && side[j] == 1) result.inside += face_area[f / 2];
    }
  }
  return result;
}

}  // namespace mpdem
