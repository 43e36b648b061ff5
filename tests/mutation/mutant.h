// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The switch of the mutants, in front of every file of the mutated copy of the source and nowhere else.
// MPDEM_MUTANT=N chooses a mutant. With MPDEM_MUTANTS_REACHED=FOLDER a run leaves an empty file
// FOLDER/N for each mutant whose expression it came to.
#ifndef MPDEM_MUTANT_H
#define MPDEM_MUTANT_H

#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace mpdem_mutation {

constexpr int kMost = 1000;

inline const char* const folder = std::getenv("MPDEM_MUTANTS_REACHED");
inline const int chosen = std::getenv("MPDEM_MUTANT") ? std::atoi(std::getenv("MPDEM_MUTANT")) : 0;
inline bool noted[kMost] = {};

inline void note(int n) {
  noted[n] = true;
  if (!folder) return;
  const int file = open((std::string(folder) + "/" + std::to_string(n)).c_str(), O_CREAT | O_WRONLY, 0644);
  if (file >= 0) close(file);
}

}  // namespace mpdem_mutation

inline bool mpdem_mutant(int n) {
  if (__builtin_expect(!mpdem_mutation::noted[n], 0)) mpdem_mutation::note(n);
  return mpdem_mutation::chosen == n;
}

#endif
