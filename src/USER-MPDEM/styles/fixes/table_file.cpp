// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "table_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace mpdem {

std::string TableFile::open(const std::string& name, const std::string& header, double last_kept) {
  name_ = name;
  kept_to_ = -1;
  std::error_code none;
  const bool goes_on = last_kept != kAnew && std::filesystem::is_regular_file(name, none) && std::filesystem::file_size(name, none) > 0;
  if (goes_on) {
    const std::string trouble = keep_rows(header, last_kept);
    if (!trouble.empty()) return trouble;
  }
  file_ = std::fopen(name.c_str(), goes_on ? "a" : "w");
  if (!file_) return name + ": " + std::strerror(errno);
  std::setvbuf(file_, nullptr, _IONBF, 0);  // rows are written whole, and errors are known at once
  struct stat now {};
  length_ = fstat(fileno(file_), &now) == 0 ? now.st_size : 0;
  return goes_on ? "" : write(header + "\n");
}

// Truncates the file after the last row to keep. These rows are not written again, so a full disk cannot lose them.
std::string TableFile::keep_rows(const std::string& header, double last_kept) {
  std::ifstream old(name_);
  std::string line;
  if (!std::getline(old, line) || line != header) return name_ + ": the file is there with other columns, and would be lost";
  const auto columns = std::count(header.begin(), header.end(), ',');
  std::uintmax_t end = header.size() + 1;
  while (std::getline(old, line) && !old.eof()) {  // a line without an end of line is incomplete
    char* rest;
    const long step = std::strtol(line.c_str(), &rest, 10);
    if (std::count(line.begin(), line.end(), ',') != columns || *rest != ',' || std::strtod(rest + 1, nullptr) > last_kept) break;
    kept_to_ = step;
    end += line.size() + 1;
  }
  old.close();
  std::error_code code;
  std::filesystem::resize_file(name_, end, code);
  return code ? name_ + ": " + code.message() : "";
}

std::string TableFile::write(const std::string& rows) {
  struct stat before {};
  const bool known = fstat(fileno(file_), &before) == 0 && S_ISREG(before.st_mode);
  if (known && before.st_size != length_)
    return name_ + ": it changed since its last row, by another fix, command or program that writes to it";
  if (std::fwrite(rows.data(), 1, rows.size(), file_) == rows.size()) {
    length_ += static_cast<off_t>(rows.size());
    return "";
  }
  const std::string trouble = name_ + ": " + std::strerror(errno);
  // Half a row would be read as a row, so it is cut off. If that fails too, there is no remedy.
  if (known && ftruncate(fileno(file_), before.st_size) == 0) std::clearerr(file_);
  return trouble;
}

void TableFile::close() {
  if (file_) std::fclose(file_);
  file_ = nullptr;
}

void append(std::string& text, const char* format, ...) {
  char buffer[256];
  va_list list;
  va_start(list, format);
  const int n = std::vsnprintf(buffer, sizeof buffer, format, list);
  va_end(list);
  text.append(buffer, std::min<std::size_t>(n, sizeof buffer - 1));
}

}  // namespace mpdem
