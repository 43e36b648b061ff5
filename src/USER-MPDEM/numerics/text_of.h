// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Joins text and numbers. Numbers are written as by a C++ stream.
#ifndef MPDEM_NUMERICS_TEXT_OF_H
#define MPDEM_NUMERICS_TEXT_OF_H

#include <sstream>
#include <string>

namespace mpdem {

template <class... T>
std::string text_of(const T&... parts) {
  std::ostringstream s;
  (s << ... << parts);
  return s.str();
}

// Returns the text of a choice between two.
inline const char* word_of(bool choice, const char* if_true, const char* if_false) { return choice ? if_true : if_false; }

}  // namespace mpdem

#endif
