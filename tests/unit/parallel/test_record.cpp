// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "parallel/record.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "cement/layout/cement_restart.h"
#include "coupling/coat.h"
#include "coupling/grain_state.h"
#include "lanes.h"
#include "mpm/point_template.h"
#include "mpm/point_row.h"
#include "mpm/point_store.h"

namespace mpdem {
namespace {

// Stands for any number, and for nothing else, so that an initializer list of these goes into arrays and structs.
struct AnyNumber {
  template <class T, class = std::enable_if_t<std::is_arithmetic_v<T> || std::is_enum_v<T>>>
  constexpr operator T() const;
};
template <std::size_t>
using AnyNumberAt = AnyNumber;
template <class R, std::size_t... I>
constexpr auto takes(std::index_sequence<I...>, int) -> decltype(R{AnyNumberAt<I>{}...}, true) {
  return true;
}
template <class R, class Sequence>
constexpr bool takes(Sequence, long) {
  return false;
}
// Count of the numbers that an aggregate declares, with those in arrays and structs inside it.
template <class R, int n = 1>
constexpr int numbers_declared() {
  if constexpr (takes<R>(std::make_index_sequence<n>{}, 0)) return numbers_declared<R, n + 1>();
  else return n - 1;
}

// A number of a record as its description has it.
struct Described {
  std::string name;
  Range range;
  bool whole, rotation;
};

// All numbers of a record, in order.
class Lister : public record_detail::Visitor<Lister> {
 public:
  template <class T>
  void put(const char* name, const T& field, Range range) {
    record_detail::each_number(field, [&](const auto& v) {
      numbers.push_back({name, range, record_detail::kWhole<std::decay_t<decltype(v)>>, rotation_});
      values.push_back(static_cast<double>(v));
    });
  }
  template <class T>
  void rotation(const char* name, const T& q) {
    rotation_ = true;
    put(name, q, kFinite);
    rotation_ = false;
  }
  template <class T>
  void left_out(const T& field) {
    record_detail::each_number(field, [this](const auto&) { ++left_out_numbers; });
  }
  std::vector<Described> numbers;
  std::vector<double> values;
  int left_out_numbers = 0;

 private:
  bool rotation_ = false;
};

template <class R>
Lister listed(const R& r) {
  Lister all;
  R::describe(r, all);
  return all;
}

// Gives every number of a record a value in its range, an own one where the range allows it; flags and optional parts by chance.
class Filler : public record_detail::Visitor<Filler> {
 public:
  Filler(test::Random& random, bool full) : random_(random), full_(full) {}
  template <class T>
  void put(const char*, T& field, Range range) {
    record_detail::each_number(field, [&](auto& v) {
      using V = std::decay_t<decltype(v)>;
      if constexpr (std::is_same_v<V, bool>) {
        v = full_ || random_.index(2);
      } else if constexpr (record_detail::kWhole<V>) {
        const double most = std::min(range.high, range.low + 1000.0);
        v = static_cast<V>(static_cast<int>(range.low) + random_.index(static_cast<int>(most - range.low) + 1));
      } else {
        const double low = std::max(range.low, -10.0), high = std::min(range.high, 10.0);
        v = low + (high - low) * random_.uniform(0.01, 0.99);
      }
    });
  }
  void rotation(const char*, double (&q)[4]) {
    const Eigen::Quaterniond any(random_.frame());
    q[0] = any.w(), q[1] = any.x(), q[2] = any.y(), q[3] = any.z();
  }
  template <class T>
  int length(const char*, T& field, int most) {
    return field = full_ ? most : random_.index(most + 1);
  }
  void left_out(int&) {}
  void left_out(bool& v) { v = full_; }

 private:
  test::Random& random_;
  bool full_;
};

template <class R>
R filled(test::Random& random, bool full) {
  R r;
  Filler fill(random, full);
  R::describe(r, fill);
  return r;
}

template <class R>
std::vector<double> numbers_in(const R& r) {
  std::vector<double> buffer(numbers_of(r) + 1, -12345.0);
  EXPECT_EQ(pack(r, buffer.data()), buffer.data() + buffer.size() - 1);
  EXPECT_EQ(buffer.back(), -12345.0);  // no more than it says
  buffer.pop_back();
  return buffer;
}

// Text that says what is wrong with these numbers as a record, empty if nothing is.
template <class R>
std::string trouble_in(const std::vector<double>& numbers) {
  R r;
  RecordReader in(numbers.data(), numbers.data() + numbers.size());
  in.read(r);
  return in.trouble();
}

// Values that the described number cannot have.
std::vector<double> bad_values(const Described& of) {
  std::vector<double> bad = {std::numeric_limits<double>::quiet_NaN(), 1e300, -1e300};
  if (of.rotation) return bad;
  const double next = of.whole ? 1.0 : 1e-6 * (1.0 + std::fabs(of.range.high));
  if (of.range.high < kLargestNumber) bad.push_back(of.range.high + next);
  if (of.range.low > -kLargestNumber) bad.push_back(of.range.low - (of.range.low == kSmallestNumber ? kSmallestNumber : next));
  if (of.whole) bad.push_back(of.range.low + 0.5);
  return bad;
}

template <class R>
class Records : public testing::Test {};
using AllRecords = testing::Types<BondRecord, Link, ContactPoint, PointRecord, GrainState, CementHead, BondRow, NodeRow, PhantomNodeRow,
                                  LooseRow, TemplateHead, TemplatePoint, Coat, BarePair>;
TYPED_TEST_SUITE(Records, AllRecords);

// True if the description of a record has all numbers that the record declares.
template <class R>
bool described_whole() {
  test::Random random(700);
  const Lister said = listed(filled<R>(random, true));
  return static_cast<int>(said.numbers.size()) + said.left_out_numbers == numbers_declared<R>();
}

TYPED_TEST(Records, NoFieldIsLeftOut) { EXPECT_TRUE(described_whole<TypeParam>()); }

TYPED_TEST(Records, RoundTrip) {
  test::Random random(701);
  for (int n = 0; n < 100; ++n) {
    const TypeParam r = filled<TypeParam>(random, n == 0);
    const Lister said = listed(r);
    const std::vector<double> numbers = numbers_in(r);
    EXPECT_EQ(numbers, said.values);
    EXPECT_LE(numbers_of(r), kMostNumbers<TypeParam>);
    EXPECT_TRUE(n > 0 || numbers_of(r) == kMostNumbers<TypeParam>);
    TypeParam back, read;
    EXPECT_EQ(unpack(numbers.data(), back), numbers.data() + numbers.size());
    EXPECT_EQ(listed(back).values, said.values);
    RecordReader in(numbers.data(), numbers.data() + numbers.size());
    in.read(read);
    EXPECT_EQ(in.trouble(), "");
    EXPECT_TRUE(in.at_end());
    EXPECT_EQ(listed(read).values, said.values);
  }
}

TYPED_TEST(Records, EachNumberIsItsOwn) {
  test::Random random(702);
  const TypeParam r = filled<TypeParam>(random, true);
  const std::vector<double> numbers = numbers_in(r);
  const std::vector<Described> said = listed(r).numbers;
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    const std::string& name = said[n].name;
    if (name.find("its number of") != std::string::npos || name == "'is moving'" || name == "'has slid'" ||
        name == "'loads are spread' of a bonded grain")
      continue;  // others follow
    std::vector<double> changed = numbers;
    changed[n] = said[n].whole ? (numbers[n] == said[n].range.low ? said[n].range.high : said[n].range.low) : 0.5 * numbers[n];
    TypeParam back;
    unpack(changed.data(), back);
    EXPECT_EQ(numbers_in(back), changed) << said[n].name;
  }
}

TYPED_TEST(Records, EachBadNumberIsNamed) {
  test::Random random(703);
  const TypeParam r = filled<TypeParam>(random, true);
  const std::vector<double> numbers = numbers_in(r);
  const std::vector<Described> said = listed(r).numbers;
  for (std::size_t n = 0; n < numbers.size(); ++n)
    for (double bad : bad_values(said[n])) {
      std::vector<double> changed = numbers;
      changed[n] = bad;
      const std::string trouble = trouble_in<TypeParam>(changed);
      EXPECT_EQ(trouble.compare(0, said[n].name.size(), said[n].name), 0) << said[n].name << " " << bad << ": " << trouble;
      const char* kind = said[n].rotation ? "" : said[n].whole ? "allowed is a whole number" : "allowed is a number";
      EXPECT_NE(trouble.find(kind), std::string::npos) << trouble;
    }
}

TYPED_TEST(Records, MissingNumbersAreNamed) {
  test::Random random(704);
  const TypeParam r = filled<TypeParam>(random, true);
  const std::vector<double> numbers = numbers_in(r);
  const std::vector<Described> said = listed(r).numbers;
  for (std::size_t n = 0; n < numbers.size(); ++n)
    EXPECT_EQ(trouble_in<TypeParam>({numbers.begin(), numbers.begin() + n}), "it ends before " + said[n].name);
}

// FNV-1a over names and kinds of all numbers.
template <class R>
std::string layout_of() {
  test::Random random(705);
  std::uint64_t sum = 0xcbf29ce484222325u;
  for (const Described& n : listed(filled<R>(random, true)).numbers)
    for (char c : n.name + (n.whole ? "#" : ".")) sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  std::ostringstream s;
  s << std::hex << sum;
  return s.str();
}

// Restart files are refused by their version alone, so a layout must not change without it.
TEST(Record, LayoutsAreThoseOfTheVersion) {
  const std::string cure =
      "the layout of a record changed: raise AtomVecMpdem::kRestartVersion or CementHead::kVersion, and then write the new sum here";
  EXPECT_EQ(layout_of<BondRecord>(), "8d410ce17ae58f6e") << cure;
  EXPECT_EQ(layout_of<PointRecord>(), "e2878c675af88327") << cure;
  EXPECT_EQ(layout_of<GrainState>(), "7569a87a96c3194e") << cure;
  EXPECT_EQ(layout_of<CementHead>(), "84752e26364139ad") << cure;
  EXPECT_EQ(layout_of<BondRow>(), "9444696e40213dd7") << cure;
  EXPECT_EQ(layout_of<NodeRow>(), "abb48e7e756a60f4") << cure;
  EXPECT_EQ(layout_of<PhantomNodeRow>(), "9d18cc32ef8c8f12") << cure;
  EXPECT_EQ(layout_of<LooseRow>(), "a1713fd68caff1b4") << cure;
  EXPECT_EQ(layout_of<Coat>(), "3f5a64e84cf73952") << cure;
  EXPECT_EQ(layout_of<BarePair>(), "555f1d987524125d") << cure;
  EXPECT_EQ(layout_of<TemplateHead>(), "e4ff7aef62b30342") << cure;
  EXPECT_EQ(layout_of<TemplatePoint>(), "7a8fb79298e6992c") << cure;
}

struct Small {
  double a = 1.0;
  bool b = false;
  bool forgotten = false;  // no padding shows it
  int c[2][3] = {};

  template <class Self, class Visitor>
  static constexpr void describe(Self& r, Visitor& visit) {
    visit("a", r.a, kFinite);
    visit("b", r.b);
    visit("c", r.c, kCount);
  }
};
struct Nested {
  Small small[2];
  Basis basis = Basis::linear;
  template <class Self, class Visitor>
  static constexpr void describe(Self& r, Visitor& visit) {
    for (auto& s : r.small) {
      visit.part(s);
      visit.left_out(s.forgotten);
    }
    visit("basis", r.basis, from(0, 2));
  }
};

TEST(Record, AFieldThatIsLeftOutIsFound) {
  EXPECT_EQ(numbers_declared<Small>(), 9);
  EXPECT_FALSE(described_whole<Small>());
  EXPECT_EQ(numbers_declared<Nested>(), 19);
  EXPECT_TRUE(described_whole<Nested>());
}

TEST(PointRow, ColumnsAreThoseOfThePage) {
  EXPECT_TRUE(described_whole<PointRow>());
  for (bool has_axis : {false, true}) {
    PointRow row;
    row.has_axis = has_axis;
    std::string names;
    for (const Described& n : listed(row).numbers) names += n.name + " ";
    EXPECT_EQ(names, std::string("grain_i grain_j x y z volume ") + (has_axis ? "ax ay az " : "") +
                         "dxx dyy dzz dyz dxz dxy failed "
                         "area_i foot_ix foot_iy foot_iz attached_i area_j foot_jx foot_jy foot_jz attached_j ");
  }
}

TEST(Record, VersionsAreRefusedByName) {
  EXPECT_EQ(trouble_with_version("data of a thing", 3, 3), "");
  for (double other : {2.0, 4.0, std::numeric_limits<double>::quiet_NaN()}) {
    const std::string trouble = trouble_with_version("data of a thing", other, 3);
    EXPECT_NE(trouble.find("data of a thing of version "), std::string::npos);
    EXPECT_NE(trouble.find("this program reads version 3; go on with"), std::string::npos);
  }
}

// A point and its record hold the same.
TEST(PointStore, KeepsEveryNumberOfARecord) {
  test::Random random(706);
  for (bool moving : {false, true}) {
    PointStore store;
    std::vector<PointRecord> records;
    std::vector<int> slots;
    for (int n = 0; n < 50; ++n) {
      PointRecord r = filled<PointRecord>(random, n == 0 && moving);
      r.moving = moving;
      r.film = false;                     // which store a point is in tells that
      if (n > 0) r.law = records[0].law;  // one in a store
      records.push_back(r);
      slots.push_back(store.add(r, n + 1));
    }
    for (std::size_t n = 0; n < slots.size(); ++n) EXPECT_EQ(numbers_in(store.record(slots[n])), numbers_in(records[n]));
  }
}

TEST(PointRecord, IsJudgedAsOneOfItsBond) {
  test::Random random(707);
  BondRecord record;
  record.grain[0] = 4;
  record.grain[1] = 9;
  record.volume = 2.0;
  record.spacing = 1e-8;
  for (int s = 0; s < 2; ++s) {
    record.radius[s] = 1.0;
    record.centre[s][0] = s == 0 ? -1.0 : 1.0;
    record.attached_area[s] = 0.5 + s;
  }
  PointRecord good;
  good.volume = 1.0;
  good.links = 1;
  good.link[0].grain = 9;
  good.link[0].area = 1.0;
  const auto trouble = [&](auto change) {
    PointRecord r = good;
    change(r);
    return trouble_of(r, {record});
  };
  EXPECT_EQ(trouble([](PointRecord&) {}), "");
  const auto says = [](const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; };
  EXPECT_TRUE(says(trouble([](PointRecord& r) { r.row = 1; }), "its bond is 1, allowed is a whole number from 0 to 0"));
  EXPECT_TRUE(says(trouble([](PointRecord& r) { r.X[2] = 1.5; }), "its position is 1.5"));
  EXPECT_TRUE(says(trouble([](PointRecord& r) { r.moving = true, r.X0[1] = -1.5; }), "its first position is -1.5"));
  EXPECT_TRUE(says(trouble([](PointRecord& r) { r.volume = 2.1; }), "its volume is 2.1"));
  EXPECT_TRUE(says(trouble([](PointRecord& r) { r.link[0].grain = 5; }), "grain of a link is 5, which is none of its bond"));
  EXPECT_TRUE(says(trouble([](PointRecord& r) { r.link[0].area = 1.6; }), "area of a link is 1.6"));
  EXPECT_TRUE(says(trouble([](PointRecord& r) { r.link[0].grain = 4, r.link[0].area = 0.6; }), "area of a link is 0.6"));
  EXPECT_TRUE(says(trouble([](PointRecord& r) { r.link[0].foot[1] = 0.5; }), "distance of the foot"));
}

}  // namespace
}  // namespace mpdem
