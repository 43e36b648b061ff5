// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Text of words and numbers, one after the other, numbers as a C++ stream writes them.
#ifndef MPDEM_TEXT_OF_H
#define MPDEM_TEXT_OF_H

#include <sstream>
#include <string>

namespace mpdem {

template <class... T>
std::string text_of(const T&... parts) {
  std::ostringstream s;
  (s << ... << parts);
  return s.str();
}

}  // namespace mpdem

#endif
