// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Run on 1, 2 and 3 ranks. What the ranks find out about each other by messages is compared
// with what one sees who has gathered everything.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <vector>

#include "cement.h"
#include "coupling/bond_ends.h"
#include "mpi_ranks.h"
#include "parallel/agree.h"
#include "parallel/gather_ranks.h"
#include "parallel/halo_sum.h"
#include "parallel/huge_pages.h"
#include "parallel/memory_limit.h"
#include "parallel/rendezvous.h"

namespace mpdem {
namespace {

using test::rank;
using test::ranks;

template <class T>
std::vector<std::vector<T>> gather_all(const std::vector<T>& mine, MPI_Datatype type) {
  const int n = static_cast<int>(mine.size());
  std::vector<int> count(ranks()), at(ranks(), 0);
  MPI_Allgather(&n, 1, MPI_INT, count.data(), 1, MPI_INT, MPI_COMM_WORLD);
  for (int r = 1; r < ranks(); ++r) at[r] = at[r - 1] + count[r - 1];
  std::vector<T> flat(at.back() + count.back());
  MPI_Allgatherv(mine.data(), n, type, flat.data(), count.data(), at.data(), type, MPI_COMM_WORLD);
  std::vector<std::vector<T>> all(ranks());
  for (int r = 0; r < ranks(); ++r) all[r].assign(flat.begin() + at[r], flat.begin() + at[r] + count[r]);
  return all;
}
std::vector<std::vector<double>> gather_all(const std::vector<double>& mine) { return gather_all(mine, MPI_DOUBLE); }
std::vector<std::vector<Key>> gather_all(const std::vector<Key>& mine) {
  std::vector<int> flat;
  for (const Key& k : mine) flat.insert(flat.end(), {static_cast<int>(k.field()), k.at(0), k.at(1), k.at(2)});
  std::vector<std::vector<Key>> all;
  for (const std::vector<int>& v : gather_all(flat, MPI_INT)) {
    all.emplace_back();
    for (std::size_t i = 0; i < v.size(); i += 4) all.back().push_back({v[i], v[i + 1], v[i + 2], v[i + 3]});
  }
  return all;
}

// Each rank's own choice out of a pool of keys around the origin; some ranks may get none.
std::vector<Key> random_keys(test::Random& random, double share) {
  std::set<Key> keys;
  for (int b = 0; b < 2; ++b)
    for (int i = -3; i <= 3; ++i)
      for (int j = -2; j <= 2; ++j)
        for (int k = -3; k <= 3; ++k)
          if (random.uniform(0, 1) < share) keys.insert({b, i, j, k});
  return {keys.begin(), keys.end()};
}

class Ranks : public ::testing::Test {
 protected:
  test::Random random_{static_cast<std::uint64_t>(1000 + rank())};
};

TEST_F(Ranks, FindSharing) {
  for (double share : {0.0, 0.02, 0.3, 0.9, 1.0}) {
    for (int round = 0; round < 4; ++round) {
      // in the last round rank 0 holds nothing
      const std::vector<Key> keys = random_keys(random_, round == 3 && rank() == 0 ? 0.0 : share);
      const std::vector<std::vector<Key>> all = gather_all(keys);
      const Sharing found = find_sharing(MPI_COMM_WORLD, keys);
      Sharing expected;
      for (int r = 0; r < ranks(); ++r) {
        if (r == rank()) continue;
        std::vector<int> items;
        for (std::size_t i = 0; i < keys.size(); ++i)
          if (std::binary_search(all[r].begin(), all[r].end(), keys[i])) items.push_back(static_cast<int>(i));
        if (items.empty()) continue;
        expected.ranks.push_back(r);
        expected.items.push_back(items);
      }
      EXPECT_EQ(found.ranks, expected.ranks);
      EXPECT_EQ(found.items, expected.items);
    }
  }
}

TEST_F(Ranks, FetchValues) {
  const int width = 4;
  // a key has one value, whoever holds it
  const auto value_of = [](const Key& k, int c) {
    return 1.0 / (3 + static_cast<int>(k.field()) + 10 * (k.at(0) + 5) + 100 * (k.at(1) + 5) + 1000 * (k.at(2) + 5)) + c;
  };
  for (double share : {0.0, 0.05, 0.4, 1.0})
    for (int round = 0; round < 3; ++round) {
      const std::vector<Key> keys = random_keys(random_, share), wanted = random_keys(random_, 0.5);
      std::vector<double> values;
      for (const Key& k : keys)
        for (int c = 0; c < width; ++c) values.push_back(value_of(k, c));
      std::vector<char> found;
      const std::vector<double> got = fetch_values(MPI_COMM_WORLD, width, keys, values, wanted, found);
      const std::vector<std::vector<Key>> all = gather_all(keys);
      const bool complete = got.size() == wanted.size() * width && found.size() == wanted.size();
      EXPECT_TRUE(complete);
      if (!complete) continue;  // no rank may leave the others waiting
      for (std::size_t i = 0; i < wanted.size(); ++i) {
        bool held = false;
        for (const std::vector<Key>& r : all) held = held || std::binary_search(r.begin(), r.end(), wanted[i]);
        EXPECT_EQ(found[i] != 0, held);
        for (int c = 0; c < width; ++c) EXPECT_EQ(got[width * i + c], held ? value_of(wanted[i], c) : 0.0);
      }
    }
}

TEST_F(Ranks, HaloSum) {
  for (double share : {0.0, 0.1, 0.5, 1.0})
    for (int width : {1, 3, 9}) {
      const std::vector<Key> keys = random_keys(random_, share);
      HaloSum halo;
      halo.build(MPI_COMM_WORLD, keys);
      const std::vector<std::vector<Key>> all_keys = gather_all(keys);
      std::size_t shared = 0;
      for (std::size_t i = 0; i < keys.size(); ++i) {
        int first = -1, holders = 0;
        for (int r = 0; r < ranks(); ++r)
          if (std::binary_search(all_keys[r].begin(), all_keys[r].end(), keys[i])) {
            ++holders;
            if (first < 0) first = r;
          }
        shared += holders > 1;
        EXPECT_EQ(halo.counts_here()[i] != 0, first == rank());
      }
      EXPECT_EQ(halo.shared_items(), shared);
      // twice over, as buffers are kept
      for (int round = 0; round < 2; ++round) {
        std::vector<double> values(keys.size() * width);
        // of many magnitudes, or their sums would be exact in any order
        for (double& v : values) v = random_.uniform(-1, 1) * std::pow(10.0, random_.uniform(-3, 3));
        const std::vector<std::vector<double>> all_values = gather_all(values);
        halo.sum(values.data(), width);
        // what all holders have, in the order of the ranks: bitwise identical
        std::map<Key, std::vector<double>> sums;
        for (int r = 0; r < ranks(); ++r)
          for (std::size_t i = 0; i < all_keys[r].size(); ++i) {
            std::vector<double>& s = sums.emplace(all_keys[r][i], std::vector<double>(width, 0.0)).first->second;
            for (int c = 0; c < width; ++c) s[c] += all_values[r][i * width + c];
          }
        for (std::size_t i = 0; i < keys.size(); ++i)
          for (int c = 0; c < width; ++c) EXPECT_EQ(values[i * width + c], sums[keys[i]][c]);
        // and among the holders
        const std::vector<std::vector<double>> after = gather_all(values);
        for (int r = 0; r < ranks(); ++r)
          for (std::size_t i = 0; i < all_keys[r].size(); ++i) {
            const auto it = std::lower_bound(keys.begin(), keys.end(), all_keys[r][i]);
            if (it == keys.end() || *it != all_keys[r][i]) continue;
            const double* mine = &values[(it - keys.begin()) * width];
            EXPECT_EQ(std::memcmp(&after[r][i * width], mine, width * sizeof(double)), 0);
          }
      }
    }
}

// Many arrays in one message a rank: bitwise identical to one after the other. Some arrays no rank shares, or this one has nothing of.
TEST_F(Ranks, HaloSumsAreHaloSumsOneByOne) {
  constexpr int kParts = 6;
  const double share[kParts] = {0.5, 0.0, 1.0, 0.05, 0.3, 0.8};
  for (int width : {1, 3, 9}) {
    std::vector<HaloSum> halo(kParts);
    std::vector<std::vector<Key>> keys(kParts);
    std::size_t shared = 0;
    for (int p = 0; p < kParts; ++p) {
      // of the array before the last rank 0 holds nothing, of the last only one rank holds anything
      const bool none = (p == kParts - 2 && rank() == 0) || (p == kParts - 1 && rank() != ranks() - 1);
      keys[p] = random_keys(random_, none ? 0.0 : share[p]);
      for (Key& k : keys[p]) k = k.with_field(k.field() + 2 * p);
      halo[p].build(MPI_COMM_WORLD, keys[p]);
      shared += halo[p].shared_items();
    }
    EXPECT_EQ(shared > 0, ranks() > 1);
    EXPECT_FALSE(halo.back().shares_any());
    HaloSums all;
    std::vector<const HaloSum*> parts;
    for (HaloSum& h : halo) parts.push_back(&h);
    all.build(parts);
    for (int round = 0; round < 2; ++round) {
      std::vector<std::vector<double>> one(kParts), together;
      for (int p = 0; p < kParts; ++p) {
        one[p].resize(width * keys[p].size());
        for (double& v : one[p]) v = random_.uniform(-1, 1) * std::pow(10.0, random_.uniform(-3, 3));
      }
      together = one;
      for (int p = 0; p < kParts; ++p) halo[p].sum(one[p].data(), width);
      std::vector<double*> values;
      for (std::vector<double>& v : together) values.push_back(v.data());
      all.sum(values, width);
      for (int p = 0; p < kParts; ++p) {
        EXPECT_EQ(std::memcmp(one[p].data(), together[p].data(), one[p].size() * sizeof(double)), 0) << "part " << p;
      }
    }
  }
}

// Grids of several bonds laid out at once are those laid out one by one: nodes, columns, motion, halo. One bond is separated,
// the motion of another is known to all, of some this rank has nothing.
TEST_F(Ranks, GridsAtOnceAreGridsOneByOne) {
  constexpr int kBonds = 5;
  constexpr double kSize = 0.5;
  for (const int margin : {0, 2}) {
    struct Made {
      Grid grid;
      std::vector<std::array<int, kMostColumns>> column;
      std::vector<char> fresh;
    };
    std::vector<std::vector<Key>> bases(kBonds);
    std::vector<NodeKinematics> before(kBonds);
    std::vector<std::vector<Key>> extra(kBonds);
    test::Random same(77);
    for (int b = 0; b < kBonds; ++b) {
      const bool apart = b == 2;
      const int cells = b == 1 && rank() == 0 ? 0 : 12;
      for (int i = 0; i < cells; ++i)
        bases[b].push_back({field_of(b, apart ? random_.index(2) : 0), random_.index(5), random_.index(5), random_.index(5)});
      // a value belongs to its node, whoever knows it
      for (int i = -1; i < 5; ++i)
        for (int j = 0; j < 6; ++j)
          for (int k = 0; k < 6; ++k) {
            std::array<double, NodeKinematics::kWidth> v;
            for (double& x : v) x = same.uniform(-1, 1);
            if (b != 3 && (i + j + k + 9) % ranks() != rank()) continue;
            before[b].keys.push_back({field_of(b, 0), i, j, k});
            before[b].values.insert(before[b].values.end(), v.begin(), v.end());
          }
      if (b == 4) extra[b].push_back({field_of(b, 0), 40 + rank() % 2, 0, 0});
    }
    const auto cells_of = [&](int b, Made& m) {
      std::vector<Grid::Cell> cells;
      m.column.assign(bases[b].size(), {});
      for (std::size_t i = 0; i < bases[b].size(); ++i)
        cells.push_back({bases[b][i].field(), bases[b][i].index().data(), m.column[i].data()});
      return cells;
    };
    std::vector<Made> one(kBonds), together(kBonds);
    for (int b = 0; b < kBonds; ++b)
      one[b].grid.build(MPI_COMM_WORLD, kSize, cells_of(b, one[b]), before[b], one[b].fresh, margin, extra[b]);
    std::vector<GridRequest> requests;
    std::vector<int> asked;
    for (int b = 0; b < kBonds; ++b) {
      if (bases[b].empty() && before[b].keys.empty()) continue;
      GridRequest r;
      r.grid = &together[b].grid;
      r.cells = cells_of(b, together[b]);
      r.before = before[b];
      r.extra = extra[b];
      requests.push_back(r);
      asked.push_back(b);
    }
    build_grids(MPI_COMM_WORLD, kSize, margin, 1e9, requests);
    int fresh = 0, known = 0;
    for (std::size_t n = 0; n < asked.size(); ++n) {
      const Made &a = one[asked[n]], &b = together[asked[n]];
      EXPECT_EQ(a.grid.keys, b.grid.keys);
      EXPECT_EQ(a.column, b.column);
      EXPECT_EQ(a.fresh, requests[n].fresh);
      EXPECT_EQ(a.grid.velocity, b.grid.velocity);
      EXPECT_EQ(a.grid.displacement, b.grid.displacement);
      EXPECT_EQ(a.grid.acceleration, b.grid.acceleration);
      EXPECT_EQ(a.grid.mass.size(), b.grid.mass.size());
      EXPECT_EQ(a.grid.force.size(), b.grid.force.size());
      EXPECT_EQ(a.grid.halo.counts_here(), b.grid.halo.counts_here());
      EXPECT_EQ(a.grid.halo.shared_items(), b.grid.halo.shared_items());
      for (char f : a.fresh) (f ? fresh : known) += 1;
    }
    EXPECT_GT(fresh, 0);
    EXPECT_GT(known, 0);
    // the halos exchange the same
    for (int b = 0; b < kBonds; ++b) {
      std::vector<double> x(3 * one[b].grid.keys.size());
      for (double& v : x) v = random_.uniform(-1, 1);
      std::vector<double> y = x;
      one[b].grid.halo.sum(x.data(), 3);
      if (std::find(asked.begin(), asked.end(), b) == asked.end()) continue;
      together[b].grid.halo.sum(y.data(), 3);
      EXPECT_EQ(x, y);
    }
    // too large for one rank is too large for all, which hear of the same size
    constexpr double kMost = 8e6;
    if (rank() == ranks() - 1)
      for (int i = 0; i < 20000; ++i) requests.back().extra.push_back({field_of(asked.back(), 0), 100 + i, 0, 0});
    double told = 0.0;
    try {
      build_grids(MPI_COMM_WORLD, kSize, margin, kMost, requests);
    } catch (const GridTooLarge& e) {
      told = e.bytes;
    }
    double least = 0.0, largest = 0.0;
    MPI_Allreduce(&told, &least, 1, MPI_DOUBLE, MPI_MIN, MPI_COMM_WORLD);
    MPI_Allreduce(&told, &largest, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    EXPECT_EQ(least, largest);
    EXPECT_GT(largest, kMost);
  }
}

// Cement dealt out to the ranks gives the masses and the forces that one rank gets alone.
TEST_F(Ranks, GridIsThatOfOneRank) {
  const double h = 1e-4;
  test::Random same(7);
  const std::vector<test::Vector> X = test::scattered(same, h, 4, 6);
  const NoDamage law(VtiElasticity({50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9}));
  test::Cement whole(h, X, 1e-13);
  whole.grid.lump_mass(whole.points, 2710);
  std::map<Key, int> index;
  for (int n = 0; n < whole.grid.size(); ++n) index[whole.grid.keys[n]] = n;
  for (double& v : whole.grid.velocity) v = same.uniform(-1, 1);

  PointStore points;
  for (std::size_t i = 0; i < X.size(); ++i) {
    // by thirds along x with a ragged edge
    const double share = X[i][0] / (4 * h) + 0.1 * same.uniform(-1, 1);
    if (std::max(0, std::min(ranks() - 1, static_cast<int>(share * ranks()))) != rank()) continue;
    PointRecord r;
    r.has_frame = true;
    for (int d = 0; d < 3; ++d) r.X[d] = X[i][d];
    r.volume = 1e-13;
    points.add(r, static_cast<int>(i) + 1);
  }
  points.arrange(h);
  std::vector<Grid::Cell> cells;
  for (BlockMeta& m : points.meta) cells.push_back({field_of(m.row, m.layer), m.base, m.column});
  Grid grid;
  std::vector<char> fresh;
  // the motion comes from the rank that has it, here each for a part
  NodeKinematics saved;
  const NodeKinematics full = whole.grid.kinematics();
  for (std::size_t i = rank(); i < full.keys.size(); i += ranks()) {
    saved.keys.push_back(full.keys[i]);
    const auto value = full.values.begin() + i * NodeKinematics::kWidth;
    saved.values.insert(saved.values.end(), value, value + NodeKinematics::kWidth);
  }
  grid.build(MPI_COMM_WORLD, h, cells, saved, fresh);
  grid.lump_mass(points, 2710);
  AdvanceResult result;
  whole.grid.clear_force();
  advance_points(whole.points, whole.grid, law, 1e-6, result);
  grid.clear_force();
  advance_points(points, grid, law, 1e-6, result);
  grid.sum_force();
  double mass = 0, force = 0;
  for (double m : whole.grid.mass) mass = std::max(mass, m);
  for (double f : whole.grid.force) force = std::max(force, std::fabs(f));
  test::Worst mass_error, force_error;
  for (int n = 0; n < grid.size(); ++n) {
    ASSERT_TRUE(index.count(grid.keys[n]));
    const int w = index[grid.keys[n]];
    EXPECT_FALSE(fresh[n]);
    mass_error.add(std::fabs(grid.mass[n] - whole.grid.mass[w]) / mass);
    for (int d = 0; d < 3; ++d) {
      EXPECT_EQ(grid.velocity[3 * n + d], whole.grid.velocity[3 * w + d]);
      force_error.add(std::fabs(grid.force[3 * n + d] - whole.grid.force[3 * w + d]) / force);
    }
  }
  expect_within(mass_error, 1e-14, "mass");
  expect_within(force_error, 1e-13, "force");
}

// The owner of a grain hands out its motion; forces of all holders add up at all of them.
TEST_F(Ranks, BondEnds) {
  const int n = 7;
  test::Random same(8);
  std::vector<BondRecord> records(n);
  std::vector<BondEnds::Motion> motions(2 * n);
  for (int b = 0; b < n; ++b)
    for (int s = 0; s < 2; ++s) {
      records[b].points = 1;
      records[b].grain[s] = 100 * b + s + 1;
      BondEnds::Motion& m = motions[2 * b + s];
      const Eigen::Quaterniond q(same.frame());
      const double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
      std::copy(wxyz, wxyz + 4, m.q);
      for (int d = 0; d < 3; ++d) {
        records[b].origin[d] = same.uniform(-1, 1);
        records[b].shift[s][d] = same.uniform(-1, 1);
        m.x[d] = same.uniform(-1, 1);
        m.v[d] = same.uniform(-1, 1);
        m.omega[d] = same.uniform(-1, 1);
      }
    }
  // end k belongs to rank k mod ranks, but the last to nobody in the second round
  for (bool lost : {false, true}) {
    std::vector<int> here;  // bonds with nodes on this rank
    std::vector<Key> owned;
    std::vector<BondEnds::Motion> mine;
    for (int b = 0; b < n; ++b)
      if (random_.index(2) || b == n - 1) here.push_back(b);
    for (int k = 0; k < 2 * n; ++k) {
      const Key key{k / 2, k % 2, 0, 0};
      if (k % ranks() == rank() && !(lost && k == 2 * n - 1)) {
        owned.push_back(key);
        mine.push_back(motions[k]);
      }
    }
    BondEnds ends;
    ends.build(MPI_COMM_WORLD, records, here, owned);
    ends.distribute(records, mine);
    EXPECT_EQ(ends.orphan() >= 0, lost);
    if (ends.orphan() >= 0) {
      EXPECT_EQ(ends.ends[ends.orphan()].tag, records[n - 1].grain[1]);
    }
    std::vector<double> forces(12 * n, 0.0);
    ends.clear_forces();
    // of either grain both ends are here, one behind the other
    std::set<int> bonds(here.begin(), here.end());
    for (const Key& k : owned) {
      bonds.insert(row_of(k.field()));
      EXPECT_EQ(ends.owned().at(&k - owned.data()), ends.find(row_of(k.field()), k.at(0)));
    }
    EXPECT_EQ(ends.ends.size(), 2 * bonds.size());
    for (int b : bonds) {
      EXPECT_GE(ends.find(b, 0), 0);
      EXPECT_EQ(ends.find(b, 1), ends.find(b, 0) + 1);
    }
    EXPECT_EQ(ends.find(n, 0), -1);
    for (std::size_t i = 0; i < ends.ends.size(); ++i) {
      BondEnd& s = ends.ends[i];
      EXPECT_EQ(ends.find(s.row, s.side), static_cast<int>(i));
      const BondEnds::Motion& m = motions[2 * s.row + s.side];
      EXPECT_EQ(s.tag, records[s.row].grain[s.side]);
      if (!(lost && s.row == n - 1 && s.side == 1)) {
        const Mat3<double> R = rotation_of(m.q);
        for (int d = 0; d < 3; ++d) {
          EXPECT_EQ(s.x[d], m.x[d] + records[s.row].shift[s.side][d] - records[s.row].origin[d]);
          EXPECT_EQ(s.v[d], m.v[d]);
          EXPECT_EQ(s.omega[d], m.omega[d]);
          for (int e = 0; e < 3; ++e) EXPECT_EQ(s.R.a[d][e], R.a[d][e]);
        }
      }
      for (int d = 0; d < 3; ++d) {
        EXPECT_EQ(s.force[d], 0.0);
        EXPECT_EQ(s.torque[d], 0.0);
        forces[6 * (2 * s.row + s.side) + d] = s.force[d] = random_.uniform(-1, 1);
        forces[6 * (2 * s.row + s.side) + 3 + d] = s.torque[d] = random_.uniform(-1, 1);
      }
    }
    const std::vector<std::vector<double>> all = gather_all(forces);
    ends.sum_forces();
    for (const BondEnd& s : ends.ends)
      for (int d = 0; d < 3; ++d) {
        double F = 0, T = 0;
        for (int r = 0; r < ranks(); ++r) {
          F += all[r][6 * (2 * s.row + s.side) + d];
          T += all[r][6 * (2 * s.row + s.side) + 3 + d];
        }
        EXPECT_NEAR(s.force[d], F, 1e-15);
        EXPECT_NEAR(s.torque[d], T, 1e-15);
      }
  }
}

// All ranks of a machine together have no more than the machine, and one that the user limits sets the limit of all.
// Memory of malloc, in pieces as small as those of bonds, keeps what it holds, and can be freed and taken again.
TEST(HugePages, ChangeNothing) {
  constexpr std::size_t kPieces = 400, kNumbers = 8000;
  std::vector<std::vector<double>> pieces;
  const auto value = [](std::size_t i, std::size_t k) { return 1e4 * static_cast<double>(i) + static_cast<double>(k); };
  for (std::size_t i = 0; i < kPieces; ++i) {
    pieces.emplace_back(kNumbers);
    for (std::size_t k = 0; k < kNumbers; ++k) pieces[i][k] = value(i, k);
  }
  for (int round = 0; round < 2; ++round) {
    gather_into_huge_pages();
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < kPieces; ++i)
      for (std::size_t k = 0; k < pieces[i].size(); ++k) wrong += pieces[i][k] != value(i, k);
    EXPECT_EQ(wrong, 0u);
    for (std::size_t i = 0; i < kPieces; i += 2) pieces[i] = {};
  }
}

TEST(MemoryLimit, IsThatOfTheMachineOrOfTheUser) {
  const double machine = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  rlimit given;
  ASSERT_EQ(getrlimit(RLIMIT_RSS, &given), 0);
  const double share = memory_limit(MPI_COMM_WORLD);
  EXPECT_LE(share, machine / ranks());
  rlimit address;
  ASSERT_EQ(getrlimit(RLIMIT_AS, &address), 0);
  if (given.rlim_cur == RLIM_INFINITY && address.rlim_cur == RLIM_INFINITY) {
    EXPECT_GT(share, 0.999 * machine / ranks());
  }

  constexpr double kSmall = 1 << 28;  // Linux counts it but does not enforce it
  if (rank() == ranks() - 1) {
    const rlimit small{1 << 28, given.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_RSS, &small), 0);
  }
  EXPECT_EQ(memory_limit(MPI_COMM_WORLD), kSmall);
  ASSERT_EQ(setrlimit(RLIMIT_RSS, &given), 0);
}

TEST(RotationOf, Quaternion) {
  test::Random random(9);
  test::Worst worst;
  for (int n = 0; n < 100; ++n) {
    const test::Matrix R = random.frame();
    const Eigen::Quaterniond q(R);
    const double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
    const Mat3<double> m = rotation_of(wxyz);
    for (int i = 0; i < 9; ++i) worst.add(std::fabs(m.a[i / 3][i % 3] - R(i / 3, i % 3)));
  }
  expect_within(worst, 1e-14, "matrix");
}

// Rank r has r numbers, and the second of three none.
TEST(GatherRanks, InTheOrderOfTheRanks) {
  std::vector<double> expected;
  const auto of_rank = [](int r) { return r == 1 ? std::vector<double>() : std::vector<double>(r + 1, 10.0 * r); };
  for (int r = 0; r < ranks(); ++r)
    for (double v : of_rank(r)) expected.push_back(v);
  EXPECT_EQ(mpdem::gather_all(MPI_COMM_WORLD, of_rank(rank())), expected);
  EXPECT_EQ(gather_on_first(MPI_COMM_WORLD, of_rank(rank())), rank() == 0 ? expected : std::vector<double>());
}

TEST(GatherRanks, UnionOfNumbers) {
  EXPECT_TRUE(union_of_ranks(MPI_COMM_WORLD, {}).empty());
  std::vector<int> expected{7};
  for (int r = 0; r < ranks(); ++r) expected.push_back(20 + r);
  EXPECT_EQ(union_of_ranks(MPI_COMM_WORLD, {20 + rank(), 7}), expected);
  EXPECT_EQ(union_of_ranks(MPI_COMM_WORLD, rank() == ranks() - 1 ? std::vector<int>{5, 3} : std::vector<int>()), (std::vector<int>{3, 5}));
}

}  // namespace
}  // namespace mpdem
