// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Numbers of a record that was read from a file, taken one by one. The first that is not in its range is told in
// trouble(), with name, value and range; from there on each taken number is one of its range, so that the reader goes
// on to the end of the record and looks at trouble() once.
#ifndef MPDEM_CHECKED_NUMBERS_H
#define MPDEM_CHECKED_NUMBERS_H

#include <cmath>
#include <limits>
#include <sstream>
#include <string>

namespace mpdem {

class CheckedNumbers {
 public:
  explicit CheckedNumbers(const double* from) : next_(from) {}

  double finite(const char* name) { return within(name, -kLargest, kLargest); }
  double positive(const char* name) { return within(name, kSmallest, kLargest); }
  double not_negative(const char* name) { return within(name, 0.0, kLargest); }
  double within(const char* name, double low, double high) { return check(name, *next_++, low, high) ? next_[-1] : low; }
  int integer(const char* name, double low, double high) { return static_cast<int>(check_integer(name, *next_++, low, high) ? next_[-1] : low); }
  bool flag(const char* name) { return integer(name, 0, 1) != 0; }
  template <class Array>
  void finite(const char* name, Array& to) {
    for (double& v : to) v = finite(name);
  }
  void quaternion(const char* name, double (&q)[4]) {
    for (double& v : q) v = *next_++;
    check_quaternion(name, q);
  }

  // Numbers that are at hand.
  bool check(const char* name, double value, double low, double high) {
    const bool good = value >= low && value <= high;
    if (!good) out_of_range(name, value, low, high, "number");
    return good;
  }
  bool check_integer(const char* name, double value, double low, double high) {
    const bool good = value >= low && value <= high && value == std::floor(value);
    if (!good) out_of_range(name, value, low, high, "whole number");
    return good;
  }
  void check_quaternion(const char* name, const double (&q)[4]) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(std::fabs(length - 1.0) < 1e-3)) tell(std::string(name) + " is no rotation, a quaternion of length 1");
  }
  void tell(const std::string& text) {
    if (trouble_.empty()) trouble_ = text;
  }

  const double* next() const { return next_; }
  const std::string& trouble() const { return trouble_; }

  static constexpr double kLargest = 1e150;  // squares stay finite
  static constexpr double kSmallest = std::numeric_limits<double>::min();

 private:
  void out_of_range(const char* name, double value, double low, double high, const char* kind) {
    std::ostringstream s;
    s << name << " is " << value << ", allowed is a " << kind;
    if (low > -kLargest) s << " from " << low;
    if (high < kLargest) s << " to " << high;
    tell(s.str());
  }
  const double* next_;
  std::string trouble_;
};

// The same, unchecked, for what another process has sent.
class TrustedNumbers {
 public:
  explicit TrustedNumbers(const double* from) : next_(from) {}
  double finite(const char*) { return *next_++; }
  double positive(const char*) { return *next_++; }
  double not_negative(const char*) { return *next_++; }
  double within(const char*, double, double) { return *next_++; }
  int integer(const char*, double, double) { return static_cast<int>(*next_++); }
  bool flag(const char*) { return *next_++ != 0.0; }
  template <class Array>
  void finite(const char*, Array& to) {
    for (double& v : to) v = *next_++;
  }
  void quaternion(const char* name, double (&q)[4]) { finite(name, q); }
  const double* next() const { return next_; }

 private:
  const double* next_;
};

}  // namespace mpdem

#endif
