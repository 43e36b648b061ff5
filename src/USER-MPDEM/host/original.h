// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The executable redefines some functions of the LIGGGHTS library, and its definitions take precedence. original()
// finds the library's function by its mangled name, so that the new one can call it. A member function takes its object
// as first argument, as in the Itanium C++ ABI. Ends the program if the library has no such symbol.
#ifndef MPDEM_HOST_ORIGINAL_H
#define MPDEM_HOST_ORIGINAL_H

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace mpdem {

template <class F>
F original(const char* mangled) {
  void* symbol = dlsym(RTLD_NEXT, mangled);
  if (!symbol) {
    std::fprintf(stderr, "liggghts-mpdem: symbol %s is not in the LIGGGHTS library; the package needs LIGGGHTS 3.8.0\n", mangled);
    std::exit(1);
  }
  F f;
  std::memcpy(&f, &symbol, sizeof f);
  return f;
}

}  // namespace mpdem

#endif
