// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// One description of a record, for state that goes to another rank or into a restart file. A struct R names its fields
// once,
//
//   template <class Self, class Visitor>
//   static constexpr void describe(Self& self, Visitor& visit) {
//     visit("its volume", self.volume, kPositive);            // name, field, range
//     visit("its position", self.X, from(-1.0, 1.0));         // arrays of numbers too
//     visit("'is moving'", self.moving);                      // bool: 0 or 1
//     if (visit.present(self.moving)) visit("its velocity", self.velocity, kFinite);
//     const int n = visit.length("its number of links", self.links, kMostLinks);
//     for (int k = 0; k < n; ++k) visit.part(self.link[k]);   // records inside
//     visit.left_out(self.slot);                              // not packed; the call tells a test that this is meant
//   }
//
// and this gives it the functions below. Every number is a double in the buffer. A range may depend on fields that are
// named before. A field has the type that the code wants: double, int, bool or an enum.
#ifndef MPDEM_PARALLEL_RECORD_H
#define MPDEM_PARALLEL_RECORD_H

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace mpdem {

struct Range {
  double low, high;
};
constexpr double kLargestNumber = 1e150;  // squares stay finite
constexpr double kSmallestNumber = std::numeric_limits<double>::min();
constexpr double kLargestInt = std::numeric_limits<int>::max();
constexpr Range kFinite{-kLargestNumber, kLargestNumber}, kPositive{kSmallestNumber, kLargestNumber}, kNotNegative{0.0, kLargestNumber};
constexpr Range kCount{0.0, kLargestInt};
constexpr Range from(double low, double high) { return {low, high}; }

// Checks numbers one after the other and stores the first error: name, value and range. A check returns true if the number is allowed.
class FirstTrouble {
 public:
  bool check(const char* name, double value, Range range) { return judge(name, value, range, false); }
  bool check_whole(const char* name, double value, Range range) { return judge(name, value, range, true); }
  bool check_rotation(const char* name, const double (&q)[4]);
  void tell(const std::string& text) {
    if (trouble_.empty()) trouble_ = text;
  }
  // The first error; empty if there is none.
  const std::string& trouble() const { return trouble_; }

 private:
  bool judge(const char* name, double value, Range range, bool whole);
  std::string trouble_;
};

// Error message on data of version `found`, with a cure; empty if that is the version `own` of this program.
std::string trouble_with_version(const std::string& data, double found, int own);

namespace record_detail {

// Calls f(number) for every number in a field, in the order of memory.
template <class T, class F>
constexpr void each_number(T& field, F&& f) {
  if constexpr (std::is_array_v<T>)
    for (auto& element : field) each_number(element, f);
  else f(field);
}

template <class T>
using Number = std::remove_cv_t<std::remove_all_extents_t<T>>;

template <class T>
constexpr bool kWhole = !std::is_floating_point_v<Number<T>>;

template <class T>
constexpr T number_from(double v) {
  if constexpr (std::is_same_v<T, bool>) return v != 0.0;
  else if constexpr (std::is_enum_v<T>) return static_cast<T>(static_cast<int>(v));
  else return static_cast<T>(v);
}

// Common base of the visitors, which handles each kind of call in describe(). Derived has put(name, field, range).
template <class Derived>
class Visitor {
 public:
  template <class T>
  constexpr void operator()(const char* name, T& field, Range range) {
    static_assert(std::is_arithmetic_v<Number<T>> || std::is_enum_v<Number<T>>, "a field is made of numbers");
    self().put(name, field, range);
  }
  template <class T>
  constexpr void operator()(const char* name, T& field) {
    static_assert(std::is_same_v<Number<T>, bool>, "all but flags have a range");
    self().put(name, field, Range{0.0, 1.0});
  }
  template <class T>
  constexpr void rotation(const char* name, T& q) {
    self().put(name, q, Range{-1.001, 1.001});
  }
  constexpr bool present(bool there) const { return there; }
  template <class T>
  constexpr int length(const char* name, T& field, int most) {
    self().put(name, field, Range{0.0, static_cast<double>(most)});
    return field;
  }
  template <class R>
  constexpr void part(R& record) {
    std::remove_const_t<R>::describe(record, self());
  }
  template <class T>
  constexpr void left_out(T&) {}

 private:
  constexpr Derived& self() { return static_cast<Derived&>(*this); }
};

class Packer : public Visitor<Packer> {
 public:
  explicit Packer(double* to) : next(to) {}
  template <class T>
  void put(const char*, const T& field, Range) {
    each_number(field, [this](const auto& v) { *next++ = static_cast<double>(v); });
  }
  double* next;
};

class Unpacker : public Visitor<Unpacker> {
 public:
  explicit Unpacker(const double* from) : next(from) {}
  template <class T>
  void put(const char*, T& field, Range) {
    each_number(field, [this](auto& v) { v = number_from<std::decay_t<decltype(v)>>(*next++); });
  }
  const double* next;
};

class Counter : public Visitor<Counter> {
 public:
  template <class T>
  constexpr void put(const char*, const T& field, Range) {
    each_number(field, [this](const auto&) { ++numbers; });
  }
  int numbers = 0;
};

// Counts the largest number of values that a record of the type can have.
class MostCounter : public Visitor<MostCounter> {
 public:
  template <class T>
  constexpr void put(const char*, const T& field, Range) {
    each_number(field, [this](const auto&) { ++numbers; });
  }
  constexpr bool present(bool) const { return true; }
  template <class T>
  constexpr int length(const char* name, const T& field, int most) {
    put(name, field, Range{});
    return most;
  }
  int numbers = 0;
};

template <class R>
constexpr int count_most() {
  const R record{};
  MostCounter count;
  R::describe(record, count);
  return count.numbers;
}

}  // namespace record_detail

// numbers_of() is the number of values that pack() writes. kMostNumbers is its maximum over records of this type.
template <class R>
constexpr int numbers_of(const R& record) {
  record_detail::Counter count;
  R::describe(record, count);
  return count.numbers;
}
template <class R>
constexpr int kMostNumbers = record_detail::count_most<R>();

// Both return where the next record begins. unpack() checks no values, since they come from another rank.
template <class R>
double* pack(const R& record, double* to) {
  record_detail::Packer out(to);
  R::describe(record, out);
  return out.next;
}
template <class R>
const double* unpack(const double* from, R& record) {
  record_detail::Unpacker in(from);
  R::describe(record, in);
  return in.next;
}

template <class R>
void append(const R& record, std::vector<double>& to) {
  to.resize(to.size() + numbers_of(record));
  pack(record, to.data() + to.size() - numbers_of(record));
}

// Reads records from the values of a file. trouble() names the first value that is out of its range or missing. Such a
// value is replaced by the lower end of its range, so the caller may check trouble() once, at the end.
class RecordReader : public record_detail::Visitor<RecordReader>, public FirstTrouble {
 public:
  RecordReader(const double* from, const double* end) : next_(from), end_(end) {}

  template <class R>
  void read(R& record) {
    R::describe(record, *this);
  }
  const double* next() const { return next_; }
  bool at_end() const { return next_ == end_; }

  template <class T>
  void put(const char* name, T& field, Range range) {
    record_detail::each_number(field, [&](auto& v) {
      using V = std::decay_t<decltype(v)>;
      v = record_detail::number_from<V>(take(name, range, record_detail::kWhole<V>));
    });
  }
  void rotation(const char* name, double (&q)[4]) {
    put(name, q, kFinite);
    if (trouble().empty()) check_rotation(name, q);
  }

 private:
  double take(const char* name, Range range, bool whole);
  const double *next_, *end_;
};

}  // namespace mpdem

#endif
