// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The version of the package, and the only place where it is set: CMake reads it from here, and so does
// LIGGGHTS' own `make`, which knows no CMake. CHANGELOG.md says what each version has; tests/system/test_version.py
// compares both with what the program prints, and with CITATION.cff.
#ifndef MPDEM_VERSION_H
#define MPDEM_VERSION_H

namespace mpdem {
constexpr const char* kVersion = "0.2.0-dev";
}  // namespace mpdem

#endif
