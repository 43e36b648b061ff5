// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Inputs of the fuzzer: valid scripts, point files and restart files, with some of their words, lines or
// bytes changed. Input n of a seed is the same on every machine and for any number of jobs.
#ifndef MPDEM_FUZZ_GRAMMAR_H
#define MPDEM_FUZZ_GRAMMAR_H

#include <cstdint>
#include <string>
#include <vector>

namespace fuzz {

// SplitMix64 (Steele, Lea, Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  int below(std::size_t n) { return static_cast<int>(bits() % n); }
  bool one_in(int n) { return below(n) == 0; }
  template <class T>
  const T& of(const std::vector<T>& v) {
    return v[below(v.size())];
  }

 private:
  std::uint64_t state_;
};

// What a child starts from, made once by its parent.
enum Scene { kNothing, kGrains, kCement, kFixes, kPointFile, kRestart, kScenes };
extern const char* const kSceneNames[kScenes];

// Lines that set the scene up.
std::vector<std::string> scene_lines(Scene scene);

struct Input {
  Scene scene;
  std::vector<std::string> lines;  // of the script, after those of the scene
  std::string points;              // text of the file `points.txt`, or empty
  std::string restart;             // bytes of the file `fuzz.restart`, or empty
};

// restart: bytes of a valid restart file, for that scene.
Input make_input(std::uint64_t seed, std::uint64_t number, const std::string& restart);

}  // namespace fuzz

#endif
