// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// CSV file with a header line, and rows that begin with step and time. Times ascend; steps do not where they are reset.
// A continued run continues its table: rows up to a given time are kept. Rows are written whole or not at all, and not
// after foreign text. The caller gets every error as text. Rank 0 writes; on other ranks the file stays closed.
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
  // Replaces an existing file (kAnew), or keeps its rows up to the time last_kept. Returns the error, or an empty text.
  std::string open(const std::string& name, const std::string& header, double last_kept);
  // Step of the last row that was kept; -1: none.
  long kept_to() const { return kept_to_; }
  // Writes whole rows, each with its end of line. Returns the error, or an empty text; after an error the file is as it
  // was before.
  std::string write(const std::string& rows);
  void close();

 private:
  std::string keep_rows(const std::string& header, double last_kept);

  std::string name_;
  std::FILE* file_ = nullptr;
  off_t length_ = 0;  // length of the file by what this object wrote and kept, bytes
  long kept_to_ = -1;
};

// Appends formatted text.
__attribute__((format(printf, 2, 3))) void append(std::string& text, const char* format, ...);

}  // namespace mpdem

#endif
