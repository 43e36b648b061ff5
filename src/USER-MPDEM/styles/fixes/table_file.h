// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// CSV file of one header, and rows that begin with step and time. Times ascend. Steps do not where they are reset. A run
// that is continued continues its table too: rows up to a time stay. Nothing is lost in silence. Rows are written whole or not at all, and not behind what
// somebody else wrote. Whoever writes is told why. Rank 0 writes; the others hold a closed file.
#ifndef MPDEM_STYLES_FIXES_TABLE_FILE_H
#define MPDEM_STYLES_FIXES_TABLE_FILE_H

#include <sys/types.h>

#include <cstdio>
#include <string>

namespace mpdem {

class TableFile {
 public:
  TableFile() = default;
  TableFile(const TableFile&) = delete;
  TableFile& operator=(const TableFile&) = delete;
  ~TableFile() { close(); }

  static constexpr double kAnew = -1.0;
  // Replaces a file that is there (kAnew), or keeps its rows up to the time last_kept. Returns what went wrong, or an
  // empty text.
  std::string open(const std::string& name, const std::string& header, double last_kept);
  // Step of the last row that stayed; -1: none did.
  long kept_to() const { return kept_to_; }
  // Writes whole rows, with their ends of line. Returns what went wrong, or an empty text. If it failed, the file is as
  // it was before.
  std::string write(const std::string& rows);
  void close();

 private:
  std::string keep_rows(const std::string& header, double last_kept);

  std::string name_;
  std::FILE* file_ = nullptr;
  off_t length_ = 0;  // length of the file, by what this object wrote and kept
  long kept_to_ = -1;
};

// Appends formatted text.
__attribute__((format(printf, 2, 3))) void append(std::string& text, const char* format, ...);

}  // namespace mpdem

#endif
