// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// CSV file of one header and rows that begin with the step. Opened at a later step than 0 it
// keeps the rows up to that step, so that a run continued from a restart file continues its
// tables too. Rank 0 writes; the others hold a closed file.
#ifndef MPDEM_TABLE_FILE_H
#define MPDEM_TABLE_FILE_H

#include <cstdio>
#include <string>

namespace mpdem {

class TableFile {
 public:
  TableFile() = default;
  TableFile(const TableFile&) = delete;
  TableFile& operator=(const TableFile&) = delete;
  ~TableFile() { close(); }

  // Empty, or why the file cannot be written. Rows of `last_kept` and before stay if the file
  // is there with the same header.
  std::string open(const std::string& name, const std::string& header, long last_kept);
  // Step of the last row that stayed, -1: none did.
  long kept_to() const { return kept_to_; }
  void close();
  bool is_open() const { return file_ != nullptr; }

  std::FILE* stream() { return file_; }
  void flush() { std::fflush(file_); }

 private:
  std::FILE* file_ = nullptr;
  long kept_to_ = -1;
};

}  // namespace mpdem

#endif
