// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "table_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <vector>

namespace mpdem {

std::string TableFile::open(const std::string& name, const std::string& header, long last_kept) {
  std::vector<std::string> kept;
  std::ifstream old(name);
  std::string line;
  if (last_kept > 0 && std::getline(old, line) && line == header)
    while (std::getline(old, line))
      if (std::atol(line.c_str()) <= last_kept) kept.push_back(line);
  old.close();
  file_ = std::fopen(name.c_str(), "w");
  if (!file_) return name + ": " + std::strerror(errno);
  std::fprintf(file_, "%s\n", header.c_str());
  for (const std::string& k : kept) std::fprintf(file_, "%s\n", k.c_str());
  flush();
  kept_to_ = kept.empty() ? -1 : std::atol(kept.back().c_str());
  return "";
}

void TableFile::close() {
  if (file_) std::fclose(file_);
  file_ = nullptr;
}

}  // namespace mpdem
