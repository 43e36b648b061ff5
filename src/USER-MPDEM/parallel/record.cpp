// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "record.h"

#include <sstream>

namespace mpdem {

bool FirstTrouble::judge(const char* name, double value, Range range, bool whole) {
  if (value >= range.low && value <= range.high && (!whole || value == std::floor(value))) return true;
  std::ostringstream s;
  s << name << " is " << value << ", allowed is a " << (whole ? "whole number" : "number");
  if (range.low > -kLargestNumber) s << " from " << range.low;
  if (range.high < kLargestNumber) s << " to " << range.high;
  tell(s.str());
  return false;
}

bool FirstTrouble::check_rotation(const char* name, const double (&q)[4]) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (std::fabs(length - 1.0) < 1e-3) return true;
  tell(std::string(name) + " is no rotation, a quaternion of length 1");
  return false;
}

double RecordReader::take(const char* name, Range range, bool whole) {
  if (next_ == end_) {
    tell(std::string("it ends before ") + name);
    return range.low;
  }
  const double value = *next_++;
  return (whole ? check_whole(name, value, range) : check(name, value, range)) ? value : range.low;
}

std::string trouble_with_version(const std::string& data, double found, int own) {
  if (found == own) return "";
  std::ostringstream s;
  s << data << " of version " << found << ", this program reads version " << own
    << "; go on with the USER-MPDEM that wrote the file, or write the cement there by write_cement and read it here by create_cement ... "
       "file";
  return s.str();
}

}  // namespace mpdem
