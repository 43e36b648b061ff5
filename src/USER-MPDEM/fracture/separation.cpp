// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "separation.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <queue>

#include "../numerics/sort_unique.h"

namespace mpdem {

namespace {

struct Piece {
  int points = 0, least_tag = 0, layer = 0;
  bool attached[2] = {false, false};
};

// The material to which a point is assigned: that attached to the first grain (bit 0), to the second (bit 1), or a
// loose piece, by its rank.
struct Assignment {
  int held = 0, loose = kNone;
  static constexpr int kNone = std::numeric_limits<int>::max();
  bool anywhere() const { return held != 0 || loose != kNone; }
  void join(const Assignment& other) {
    held |= other.held;
    loose = std::min(loose, other.loose);
  }
};

// Spreads assignments from cell to cell, within a layer or across layers, until every point that can be reached has
// one. Fronts advance together: a point is assigned to all material at its least number of steps.
void spread_assignments(const Neighbours& near, const std::vector<CrackPoint>& points, bool across, std::vector<Assignment>& goes) {
  std::vector<int> front, next;
  std::vector<Assignment> claim(goes.size());
  for (int i : near.order())
    if (goes[i].anywhere()) front.push_back(i);
  while (!front.empty()) {
    next.clear();
    for (int i : front)
      for (int j : near.of(i))
        if (j >= 0 && !goes[j].anywhere() && (across || points[j].layer == points[i].layer)) {
          if (!claim[j].anywhere()) next.push_back(j);
          claim[j].join(goes[i]);
        }
    for (int j : next) goes[j] = claim[j];
    front.swap(next);
  }
}

// Share of a point that belongs to the material of the first grain.
double share_of_first(int held) { return held == 1 ? 1.0 : held == 2 ? 0.0 : 0.5; }

// Damage of the connection of a point to grain g: the larger one of the point and its links.
float damage_at_grain(const CrackPoint& p, int g) { return std::max(p.damage, p.link_damage[g]); }

// Least value of the largest damage on a path from the first grain to the second, over links and intact points of a
// layer. Uses Dijkstra's search with the largest damage as the length of a path. Empty if there is no path.
std::optional<float> damage_to_pass(const Neighbours& near, const std::vector<CrackPoint>& points) {
  using Ahead = std::pair<float, int>;
  std::priority_queue<Ahead, std::vector<Ahead>, std::greater<>> front;
  std::vector<char> seen(points.size(), 0);
  const int second_grain = static_cast<int>(points.size());
  // A point beside the first grain may be reached over its links or, at less damage, over its neighbours.
  for (int i : near.order())
    if (!points[i].failed && points[i].attached[0]) front.emplace(damage_at_grain(points[i], 0), i);
  float most = 0.0f;
  while (!front.empty()) {
    const int i = front.top().second;
    most = std::max(most, front.top().first);
    front.pop();
    if (i == second_grain) return most;
    seen[i] = 1;
    if (points[i].attached[1]) front.emplace(damage_at_grain(points[i], 1), second_grain);
    for (int f = 0; f < 6; ++f) {
      const int j = near.of(i)[f];
      if (j < 0 || seen[j] || points[j].layer != points[i].layer || !near.bridged(i, f)) continue;
      seen[j] = 1;
      front.emplace(points[j].damage, j);
    }
  }
  return std::nullopt;
}

// Finds a shortest path from the first grain to the second over links and intact points of a layer with at most this damage. Returns
// the tags of its points and of the points of its bridges.
std::vector<int> find_path(const Neighbours& near, const std::vector<CrackPoint>& points, float damage) {
  const auto passable = [&](int i) { return !points[i].failed && points[i].damage <= damage; };
  const auto reaches = [&](int i, int g) { return points[i].attached[g] && points[i].link_damage[g] <= damage; };
  constexpr int kUnseen = -2, kStart = -1;
  std::vector<int> from(points.size(), kUnseen), queue, path;
  for (int i : near.order())
    if (passable(i) && reaches(i, 0)) {
      from[i] = kStart;
      queue.push_back(i);
    }
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const int i = queue[k];
    if (reaches(i, 1)) {
      for (int j = i; j != kStart; j = from[j]) {
        path.push_back(points[j].tag);
        for (int f = 0; f < 6 && from[j] != kStart; ++f)
          if (near.of(j)[f] == from[j])
            for (int b : near.bridge(j, f)) path.push_back(points[b].tag);
      }
      sort_unique(path);
      break;
    }
    for (int f = 0; f < 6; ++f) {
      const int j = near.of(i)[f];
      if (j >= 0 && from[j] == kUnseen && passable(j) && points[j].layer == points[i].layer && near.bridged(i, f)) {
        from[j] = i;
        queue.push_back(j);
      }
    }
  }
  return path;
}

// Finds the pieces, each of intact points of one layer, and the piece of each point, -1 for a failed one.
std::vector<Piece> find_pieces(const Neighbours& near, const std::vector<CrackPoint>& points, std::vector<int>& piece_of) {
  piece_of.assign(points.size(), -1);
  std::vector<Piece> pieces;
  std::vector<int> stack;
  for (int first : near.order()) {
    if (points[first].failed || piece_of[first] >= 0) continue;
    Piece p;
    p.layer = points[first].layer;
    p.least_tag = points[first].tag;
    stack.assign(1, first);
    piece_of[first] = static_cast<int>(pieces.size());
    while (!stack.empty()) {
      const int i = stack.back();
      stack.pop_back();
      ++p.points;
      p.least_tag = std::min(p.least_tag, points[i].tag);
      for (int s = 0; s < 2; ++s) p.attached[s] = p.attached[s] || points[i].attached[s];
      for (int f = 0; f < 6; ++f) {
        const int j = near.of(i)[f];
        if (j < 0 || piece_of[j] >= 0 || points[j].layer != p.layer || !near.bridged(i, f)) continue;
        piece_of[j] = static_cast<int>(pieces.size());
        stack.push_back(j);
      }
    }
    pieces.push_back(p);
  }
  return pieces;
}

bool is_attached(const Piece& p) { return p.attached[0] || p.attached[1]; }
bool counts(const Piece& p) { return is_attached(p) || p.points >= kLeastLoose; }
int layer_at_grain(int side, int layer) { return side == 1 && layer == 0 ? 1 : layer; }

// Finds the material of each piece, and the layers of loose pieces by their rank. Layers only ever split, so that new
// nodes can take over the motion of the old ones. Attached pieces keep their layer, except that those of layer 0 at the
// second grain become layer 1. Loose pieces become new layers, from 2 on: the largest first, and of equal ones that
// with the least tag. A loose piece keeps its layer if that is 2 or more and has no other piece that counts. Layers 0
// and 1 follow their grains.
std::vector<Assignment> rank_pieces(const std::vector<Piece>& pieces, int next, std::vector<int>& loose_part) {
  std::map<int, int> holders;  // by layer: number of pieces in it that count
  for (const Piece& p : pieces) holders[p.layer] += counts(p);
  std::vector<int> ranked(pieces.size());
  std::iota(ranked.begin(), ranked.end(), 0);
  std::sort(ranked.begin(), ranked.end(), [&](int a, int b) {
    return pieces[a].points != pieces[b].points ? pieces[a].points > pieces[b].points : pieces[a].least_tag < pieces[b].least_tag;
  });
  std::vector<Assignment> of_piece(pieces.size());
  loose_part.assign(pieces.size(), -1);
  for (std::size_t rank = 0; rank < ranked.size(); ++rank) {
    const Piece& p = pieces[ranked[rank]];
    Assignment& goes = of_piece[ranked[rank]];
    if (is_attached(p)) {
      goes.held = p.attached[0] ? 1 : 2;
    } else if (counts(p)) {
      goes.loose = static_cast<int>(rank);
      loose_part[rank] = p.layer < 2 || holders[p.layer] > 1 ? next++ : p.layer;
    }
  }
  return of_piece;
}

// Bits, as in Assignment::held, of the grains on which a failed point stays as residue; 0 if there are none.
int residue_on(const CrackPoint& p) { return p.failed ? p.attached[0] + 2 * p.attached[1] : 0; }

// Adds the area between two points. It counts at the height half way between them.
void count_between(const CrackPoint& a, const CrackPoint& b, double area, double reach, FractureSurface& surface) {
  bool at[2];
  for (int g = 0; g < 2; ++g) at[g] = 0.5 * (a.above[g] + b.above[g]) < reach;
  if (!at[0] && !at[1]) surface.inside += area;
  for (int g = 0; g < 2; ++g)
    if (at[g]) surface.at_grain[g] += at[1 - g] ? 0.5 * area : area;
}

// Finds the fracture surface. side: for each point the grains whose material or residue is nearest, by
// spread_assignments(). Links of residue are intact. So the cement separates beside the residue, or through it if it is
// on both grains.
void find_surface(const Neighbours& near, const std::vector<CrackPoint>& points, const std::vector<Piece>& pieces, const double* face_area,
                  const std::vector<Assignment>& side, double reach, Separation& result) {
  const bool held = std::any_of(pieces.begin(), pieces.end(), is_attached) || std::any_of(points.begin(), points.end(), residue_on);
  const bool loose = std::any_of(pieces.begin(), pieces.end(), [](const Piece& p) { return p.points >= kLeastLoose; });
  if (!held && loose)  // all links to both grains debonded between two calls
    for (const CrackPoint& p : points)
      for (int s = 0; s < 2; ++s) result.at_grain[s] += p.link_area[s];
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (side[i].held == 0) continue;
    const double first = share_of_first(side[i].held);
    if (residue_on(points[i]) == 3) {
      result.inside += 0.5 * (points[i].link_area[0] + points[i].link_area[1]);
    } else {
      result.at_grain[0] += (1.0 - first) * points[i].link_area[0];
      result.at_grain[1] += first * points[i].link_area[1];
    }
    for (int f = 1; f < 6; f += 2) {  // +x, +y, +z: each pair of points counts once
      const int j = near.of(static_cast<int>(i))[f];
      if (j >= 0 && side[j].held != 0)
        count_between(points[i], points[j], face_area[f / 2] * std::fabs(first - share_of_first(side[j].held)), reach, result);
    }
  }
}

}  // namespace

Separation separate(const std::vector<CrackPoint>& points, const double* face_area, bool again, int across, double reach) {
  const int n = static_cast<int>(points.size());
  const Neighbours near(points, across);
  Separation result;
  result.piece.resize(n);
  result.between.assign(n, 0);
  int next = 2;
  for (int i = 0; i < n; ++i) {
    result.piece[i] = points[i].layer;
    next = std::max(next, points[i].layer + 1);
  }
  if (const std::optional<float> damage = damage_to_pass(near, points)) {
    result.path = find_path(near, points, *damage);
    return result;
  }
  result.separated = true;
  std::vector<int> piece_of, loose_part;
  const std::vector<Piece> pieces = find_pieces(near, points, piece_of);
  const std::vector<Assignment> of_piece = rank_pieces(pieces, next, loose_part);
  std::vector<Assignment> goes(n), side(n);  // side: without loose pieces, for the fracture surface
  result.attached_grains.assign(n, 0);
  for (int i = 0; i < n; ++i) {
    if (piece_of[i] >= 0) result.attached_grains[i] = pieces[piece_of[i]].attached[0] + 2 * pieces[piece_of[i]].attached[1];
    if (piece_of[i] >= 0) goes[i] = of_piece[piece_of[i]];
    else goes[i].held = residue_on(points[i]);
    side[i].held = goes[i].held;
  }
  spread_assignments(near, points, false, goes);
  for (int i = 0; i < n; ++i) {
    const CrackPoint& p = points[i];
    result.between[i] = goes[i].held == 3;
    if (goes[i].held != 0) result.piece[i] = layer_at_grain(goes[i].held == 3 ? p.nearer : goes[i].held - 1, p.layer);
    else if (goes[i].loose != Assignment::kNone) result.piece[i] = loose_part[goes[i].loose];
    else if (!again) result.piece[i] = layer_at_grain(p.nearer, p.layer);  // no step reaches it
  }
  spread_assignments(near, points, true, side);
  find_surface(near, points, pieces, face_area, side, reach, result);
  return result;
}

std::vector<char> attached_grains(const std::vector<CrackPoint>& points, int across) {
  std::vector<int> piece_of;
  const std::vector<Piece> pieces = find_pieces(Neighbours(points, across), points, piece_of);
  std::vector<char> held(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Piece* p = piece_of[i] < 0 ? nullptr : &pieces[piece_of[i]];
    held[i] = static_cast<char>(p ? p->attached[0] + 2 * p->attached[1] : residue_on(points[i]));
  }
  return held;
}

std::vector<int> piece_sizes(const std::vector<CrackPoint>& points, int across) {
  std::vector<int> piece_of;
  const std::vector<Piece> pieces = find_pieces(Neighbours(points, across), points, piece_of);
  std::vector<int> sizes(points.size(), 1);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (piece_of[i] >= 0) sizes[i] = pieces[piece_of[i]].points;
  return sizes;
}

}  // namespace mpdem
