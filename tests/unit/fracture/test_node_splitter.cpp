// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A block of points, two in a cell and direction, that fail in planes or at random; connected parts are found again in the plainest way.
#include "fracture/phantom_nodes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace mpdem {
namespace {

constexpr int kSupport = 3;

std::vector<SplitterPoint> block(int nx, int ny, int nz) {
  std::vector<SplitterPoint> points;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k) {
        SplitterPoint p{};
        p.tag = 1 + static_cast<int>(points.size());
        const int cell[3] = {i, j, k};
        for (int d = 0; d < 3; ++d) {
          p.cell[d] = cell[d];
          p.base[d] = cell[d] / 2 - 1;
          p.at[d] = 0.75 + 0.5 * (cell[d] % 2);
        }
        p.volume = 1.0 + 0.01 * (p.tag % 7);
        points.push_back(p);
      }
  return points;
}

// The block with the layers that it has by now.
class Pieces {
 public:
  explicit Pieces(std::vector<SplitterPoint> points) : points_(points), lattice_(std::move(points), Basis::quadratic) {
    take(lattice_.start(copies), PhantomNodes());
    EXPECT_TRUE(copies.empty());
  }

  void fail(const std::vector<int>& tags) {
    for (SplitterPoint& p : points_) p.failed = p.failed || std::count(tags.begin(), tags.end(), p.tag);
    const PhantomNodes before(copies);
    take(lattice_.fail(tags, copies), before);
  }

  void split_pieces(const std::vector<NodeSplitter::OfPiece>& pieces) {
    const PhantomNodes before(copies);
    take(lattice_.split_pieces(pieces, copies), before);
  }

  template <class Assignment>
  void leave(Assignment goes) {
    points_.erase(std::remove_if(points_.begin(), points_.end(), goes), points_.end());
    lattice_ = NodeSplitter(points_, Basis::quadratic);
    lattice_.leave(copies);
  }

  // Checks the intact points in the support of each node: which of them share a phantom node, and which are connected?
  void check() const {
    std::map<GridIndex, std::vector<int>> nodes;
    for (int i = 0; i < static_cast<int>(points_.size()); ++i)
      for (int a = 0; a < 27; ++a)
        nodes[{points_[i].base[0] + a / 9, points_[i].base[1] + a / 3 % 3, points_[i].base[2] + a % 3}].push_back(i);
    for (const auto& n : nodes) {
      const std::vector<int> component = components(n.second);
      std::map<int, int> of_copy, of_component;
      double all = 0.0, of_copies = 0.0;
      std::map<int, double> holds, volumes;
      for (std::size_t k = 0; k < n.second.size(); ++k) {
        const SplitterPoint& p = points_[n.second[k]];
        const int stands = copies.representative(p.layer, n.first);
        // what represents a phantom node represents itself
        ASSERT_EQ(copies.representative(stands, n.first), stands);
        all += volume_at(p, n.first);
        volumes[stands] = copies.at(p.layer, n.first).volume;
        if (p.failed) continue;
        holds[stands] += volume_at(p, n.first);
        ASSERT_EQ(of_copy.emplace(stands, component[k]).first->second, component[k]) << "shared by what is not connected";
        ASSERT_EQ(of_component.emplace(component[k], stands).first->second, stands) << "not shared by what is connected";
      }
      if (!copies.row(n.first)) continue;
      for (const PhantomNodes::Entry& e : *copies.row(n.first)) volumes[copies.representative(e.layer, n.first)] = e.volume;
      for (const auto& v : volumes) {
        of_copies += v.second;
        ASSERT_GE(v.second, holds[v.first] * (1 - 1e-12)) << "less mass than stiffness";
      }
      ASSERT_NEAR(of_copies, all, 1e-12 * all) << "mass is lost";
    }
  }

  std::map<int, int> layers() const {
    std::map<int, int> of_tag;
    for (const SplitterPoint& p : points_) of_tag[p.tag] = p.layer;
    return of_tag;
  }

  PhantomNodes copies;

  static double volume_at(const SplitterPoint& p, const GridIndex& node) {
    double v = p.volume;
    for (int d = 0; d < 3; ++d) {
      const double s = p.at[d] - 1.0;
      const double w[3] = {0.5 * (0.5 - s) * (0.5 - s), 0.75 - s * s, 0.5 * (0.5 + s) * (0.5 + s)};
      v *= w[node[d] - p.base[d]];
    }
    return v;
  }

 private:
  // Nodes that represent others now, and those of the new layers, take the motion of the node that represented them. Nodes that
  // represent none may not be there.
  void take(const NodeChange& change, const PhantomNodes& before) {
    std::map<std::pair<GridIndex, int>, int> source;
    for (const NodeChange::Source& s : change.sources) {
      ASSERT_EQ(source.emplace(std::make_pair(s.node, s.layer), s.from).first->second, s.from) << "two sources of a node";
      ASSERT_EQ(before.representative(s.from, s.node), s.from) << "a source that did not stand for itself";
    }
    std::map<int, int> moved;
    for (const NodeChange::Moved& m : change.moved) moved[m.tag] = m.layer;
    for (SplitterPoint& p : points_) {
      const auto m = moved.find(p.tag);
      const int layer = m == moved.end() ? p.layer : m->second;
      for (int a = 0; a < 27; ++a) {
        const GridIndex n{p.base[0] + a / 9, p.base[1] + a / 3 % 3, p.base[2] + a % 3};
        const int stood = before.representative(p.layer, n);
        for (int to : {copies.representative(layer, n), layer}) {
          if (to == stood || (to == layer && layer == p.layer && copies.representative(layer, n) != layer)) continue;
          const auto s = source.find({n, to});
          ASSERT_TRUE(s != source.end()) << "a node without a source";
          ASSERT_EQ(s->second, stood);
        }
      }
      p.layer = layer;
    }
  }

  std::vector<int> components(const std::vector<int>& members) const {
    std::vector<int> component(members.size());
    for (std::size_t i = 0; i < members.size(); ++i) component[i] = static_cast<int>(i);
    for (bool more = true; more;) {
      more = false;
      for (std::size_t i = 0; i < members.size(); ++i)
        for (std::size_t j = 0; j < members.size(); ++j) {
          const SplitterPoint &a = points_[members[i]], &b = points_[members[j]];
          int steps = 0;
          for (int d = 0; d < 3; ++d) steps += std::abs(a.cell[d] - b.cell[d]);
          if (a.failed || b.failed || steps != 1 || component[j] <= component[i]) continue;
          component[j] = component[i];
          more = true;
        }
    }
    return component;
  }

  std::vector<SplitterPoint> points_;
  NodeSplitter lattice_;
};

TEST(PhantomNodes, OneFailedPointSplitsNothing) {
  Pieces p(block(8, 8, 8));
  p.fail({1 + 3 * 64 + 3 * 8 + 3});
  EXPECT_TRUE(p.copies.empty());
}

// Lists of points that do not belong together are errors.
TEST(PhantomNodes, PointsThatAreNotThere) {
  PhantomNodes copies;
  NodeSplitter lattice(block(2, 2, 2), Basis::quadratic);
  lattice.start(copies);
  EXPECT_THROW(lattice.fail({9}, copies), std::logic_error);
  EXPECT_THROW(lattice.fail({0}, copies), std::logic_error);
  EXPECT_THROW(lattice.split_pieces({{1, 0}, {2, 1}}, copies), std::logic_error);
}

// Points on faces of cells have no weight at the nodes where the support ends, and a node may have no others.
TEST(PhantomNodes, PointsOnFacesOfCells) {
  std::vector<SplitterPoint> points = block(8, 4, 4);
  for (SplitterPoint& p : points)
    for (double& at : p.at) at -= 0.25;
  NodeSplitter lattice(points, Basis::quadratic);
  PhantomNodes copies;
  lattice.start(copies);
  std::vector<int> crack;
  for (const SplitterPoint& p : points)
    if (p.cell[0] == 7 || p.cell[1] == 2) crack.push_back(p.tag);
  lattice.fail(crack, copies);
  ASSERT_FALSE(copies.empty());
  for (const auto& row : copies.rows())
    for (const PhantomNodes::Entry& e : row.second) EXPECT_TRUE(std::isfinite(e.volume));
}

// Nodes up to the tip are whole if the crack does not divide their support.
TEST(PhantomNodes, CrackWithATip) {
  std::vector<SplitterPoint> points = block(12, 16, 6);
  Pieces p(points);
  std::vector<int> crack;
  for (const SplitterPoint& q : points)
    if (q.cell[0] == 6 && q.cell[1] < 8) crack.push_back(q.tag);
  p.fail(crack);
  p.check();
  std::set<int> split;
  for (const auto& row : p.copies.rows()) {
    split.insert(row.first[1]);
    EXPECT_GE(row.first[0], 2);  // supports that the plane crosses
    EXPECT_LE(row.first[0], 4);
  }
  // Cells 0 to 3 along y are cracked through: these nodes see no others.
  EXPECT_EQ(split, (std::set<int>{-1, 0, 1, 2}));
}

// A failed point between two sides of as many points joins that whose middle is nearer, along each axis and in either sense.
TEST(PhantomNodes, FailedPointGoesWithTheNearerMiddle) {
  const int far[3][3] = {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}}, near[3][3] = {{0, 0, 4}, {1, 0, 4}, {0, 1, 4}};
  const auto point = [](const int* cell, int axis, bool mirrored, int tag) {
    SplitterPoint p{};
    p.tag = tag;
    p.volume = 1.0;
    for (int d = 0; d < 3; ++d) {
      const int c = d == 2 && mirrored ? 4 - cell[d] : cell[d], to = (d + axis) % 3;
      p.cell[to] = c;
      p.base[to] = c / 2 - 1;
      p.at[to] = 0.75 + 0.5 * (c % 2);
    }
    return p;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const bool mirrored : {false, true}) {
      const int between[3] = {0, 0, 3};
      std::vector<SplitterPoint> points;
      for (const auto& cell : far) points.push_back(point(cell, axis, mirrored, static_cast<int>(points.size()) + 1));
      for (const auto& cell : near) points.push_back(point(cell, axis, mirrored, static_cast<int>(points.size()) + 1));
      points.push_back(point(between, axis, mirrored, 7));
      Pieces pieces(points);
      pieces.fail({7});
      const GridIndex node{1, 1, 1};  // in the support of all
      const std::map<int, int> layer = pieces.layers();
      const auto copy = [&](int tag) { return pieces.copies.representative(layer.at(tag), node); };
      EXPECT_NE(copy(1), copy(4));
      EXPECT_EQ(copy(7), copy(4)) << axis << ' ' << mirrored;
    }
}

TEST(PhantomNodes, AnyFailuresInAnyOrder) {
  for (unsigned seed : {1u, 2u, 3u}) {
    std::mt19937 random(seed);
    std::vector<SplitterPoint> points = block(10, 8, 8);
    std::vector<int> tags;
    for (const SplitterPoint& q : points) tags.push_back(q.tag);
    std::shuffle(tags.begin(), tags.end(), random);
    Pieces p(points);
    std::reverse(points.begin(), points.end());
    std::vector<SplitterPoint> again(points);
    NodeSplitter other(again, Basis::quadratic);
    PhantomNodes copies;
    other.start(copies);
    for (int n = 0; n < 6; ++n) {
      std::vector<int> failed(tags.begin() + 80 * n, tags.begin() + 80 * (n + 1));
      p.fail(failed);
      std::reverse(failed.begin(), failed.end());
      other.fail(failed, copies);
      p.check();
    }
    EXPECT_GT(p.copies.rows().size(), 100u);
    const std::map<int, int> layers = p.layers();
    for (const SplitterPoint& q : other.points()) ASSERT_EQ(q.layer, layers.at(q.tag));
  }
}

// A side of a crack leaves, then half of what failed there. Volumes are those of the points that stay, and nodes that split stay so when they split again.
TEST(PhantomNodes, PointsLeave) {
  Pieces p(block(8, 6, 4));
  const auto plane = [](int d, int cell, int below) {
    std::vector<int> tags;
    for (const SplitterPoint& q : block(8, 6, 4))
      if (q.cell[d] == cell && q.cell[0] < below) tags.push_back(q.tag);
    return tags;
  };
  p.fail(plane(0, 4, 8));
  std::vector<GridIndex> split;
  for (const auto& row : p.copies.rows())
    if (p.copies.representative_of_first(0, row.first) < 0) split.push_back(row.first);
  ASSERT_GT(split.size(), 10u);
  p.leave([](const SplitterPoint& q) { return q.cell[0] > 4; });
  p.check();
  p.leave([](const SplitterPoint& q) { return q.cell[0] == 4 && q.cell[1] % 2 == 0; });
  p.check();
  p.fail(plane(1, 3, 4));
  p.check();
  for (const GridIndex& n : split) EXPECT_LT(p.copies.representative_of_first(0, n), 0);
}

// New nodes take the motion of the phantom node that their points had.
TEST(PhantomNodes, SourcesAreThoseOfThePoints) {
  std::vector<SplitterPoint> points = block(12, 6, 6);
  NodeSplitter lattice(points, Basis::quadratic);
  PhantomNodes copies;
  lattice.start(copies);
  std::vector<int> crack;
  for (const SplitterPoint& q : points)
    if (q.cell[0] == 5) crack.push_back(q.tag);
  const NodeChange change = lattice.fail(crack, copies);
  EXPECT_FALSE(change.moved.empty());
  std::set<std::pair<GridIndex, int>> have;
  for (const NodeChange::Source& s : change.sources) {
    EXPECT_EQ(s.from, 0);
    have.insert({s.node, s.layer});
  }
  for (const SplitterPoint& q : lattice.points())
    for (int a = 0; a < 27 && q.layer != 0; ++a)
      EXPECT_TRUE(have.count({GridIndex{q.base[0] + a / 9, q.base[1] + a / 3 % 3, q.base[2] + a % 3}, q.layer}));
}

TEST(PhantomNodes, PiecesShareNoNode) {
  std::vector<SplitterPoint> points = block(8, 4, 4);
  Pieces p(points);
  std::vector<NodeSplitter::OfPiece> pieces;
  for (const SplitterPoint& q : points) pieces.push_back({q.tag, q.cell[0] < 4 ? 0 : 1});
  p.split_pieces(pieces);
  const std::map<int, int> layers = p.layers();
  for (const SplitterPoint& a : points)
    for (const SplitterPoint& b : points)
      for (int n = 0; n < 27 && a.cell[0] < 4 && b.cell[0] >= 4; ++n) {
        const GridIndex node{a.base[0] + n / 9, a.base[1] + n / 3 % 3, a.base[2] + n % 3};
        bool both = true;
        for (int d = 0; d < 3; ++d) both = both && node[d] >= b.base[d] && node[d] < b.base[d] + kSupport;
        if (both) {
          ASSERT_NE(p.copies.representative(layers.at(a.tag), node), p.copies.representative(layers.at(b.tag), node));
        }
      }
}

// A fold of two slabs that meet at one end: nodes beside the fold know in which layer they continue.
TEST(PhantomNodes, NextNodesAtTheStart) {
  std::vector<SplitterPoint> points;
  for (SplitterPoint p : block(16, 4, 6)) {
    if (p.cell[0] >= 4 && (p.cell[2] == 2 || p.cell[2] == 3)) continue;
    p.nearer = p.cell[2] < 3;
    p.tag = 1 + static_cast<int>(points.size());
    points.push_back(p);
  }
  NodeSplitter lattice(points, Basis::quadratic);
  PhantomNodes copies;
  lattice.start(copies);
  ASSERT_FALSE(copies.empty());
  int met = 0, forks = 0;
  for (const SplitterPoint& p : lattice.points())
    for (int a = 0; a < 27; ++a)
      for (int f = 0; f < 6; ++f) {
        const GridIndex node{p.base[0] + a / 9, p.base[1] + a / 3 % 3, p.base[2] + a % 3};
        GridIndex next = node;
        next[f / 2] += f % 2 == 0 ? -1 : 1;
        if (next[f / 2] < p.base[f / 2] || next[f / 2] >= p.base[f / 2] + kSupport) continue;
        const int to = copies.continuation(node, copies.at(p.layer, node).first, f);
        if (copies.row(node)) {
          ASSERT_EQ(to, copies.at(p.layer, next).first);
          ++met;
        } else if (copies.row(next) && to != -1) {  // whole, before a split one: one of its phantom nodes, if only that is met
          ASSERT_EQ(to, copies.at(p.layer, next).first);
        } else if (copies.row(next)) {
          ++forks;
        } else {
          ASSERT_EQ(to, 0);
        }
      }
  EXPECT_GT(met, 1000);
  EXPECT_GT(forks, 0);
}

}  // namespace
}  // namespace mpdem
