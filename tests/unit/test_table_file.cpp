// SPDX-License-Identifier: GPL-2.0-or-later
#include "../../src/USER-MPDEM/styles/table_file.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace {

using mpdem::TableFile;

class Table : public testing::Test {
 protected:
  void SetUp() override {
    name = (std::filesystem::temp_directory_path() / ("mpdem_table_" + std::to_string(::getpid()) + ".csv")).string();
    std::filesystem::remove(name);
  }
  void TearDown() override { std::filesystem::remove(name); }
  void put(const std::string& text) { std::ofstream(name) << text; }
  std::string text() const {
    std::ifstream f(name);
    std::ostringstream s;
    s << f.rdbuf();
    return s.str();
  }
  std::string name;
};

TEST_F(Table, BeginsAnew) {
  put("step,a\n0,1\n");
  TableFile t;
  ASSERT_EQ(t.open(name, "step,a", TableFile::kAnew), "");
  EXPECT_EQ(t.kept_to(), -1);
  EXPECT_EQ(t.write("5,2\n"), "");
  EXPECT_EQ(text(), "step,a\n5,2\n");  // before it is closed
}

TEST_F(Table, GoesOnBehindTheRowsThatStay) {
  put("step,a\n0,1\n5,2\n5,3\n10,4\n");
  TableFile t;
  ASSERT_EQ(t.open(name, "step,a", 5), "");
  EXPECT_EQ(t.kept_to(), 5);
  t.write("7,9\n");
  EXPECT_EQ(text(), "step,a\n0,1\n5,2\n5,3\n7,9\n");
}

// Rows from before `reset_timestep` have later steps.
TEST_F(Table, KeepsRowsOfStepsThatWereResetSince) {
  put("step,a\n0,1\n5,2\n10,3\n0,4\n5,5\n10,6\n");
  TableFile t;
  ASSERT_EQ(t.open(name, "step,a", 5), "");
  EXPECT_EQ(t.kept_to(), 5);
  EXPECT_EQ(text(), "step,a\n0,1\n5,2\n10,3\n0,4\n5,5\n");
}

TEST_F(Table, LeavesOutRowsThatAreNotWhole) {
  for (const char* end : {"1", "1,", "1\n", "1,2"}) {
    put(std::string("step,a,b\n0,1,1\n") + end);
    TableFile t;
    ASSERT_EQ(t.open(name, "step,a,b", 100), "");
    EXPECT_EQ(t.kept_to(), 0);
    EXPECT_EQ(text(), "step,a,b\n0,1,1\n");
  }
}

TEST_F(Table, GoesOnWithAnEmptyFileOrNone) {
  for (int there = 0; there < 2; ++there) {
    std::filesystem::remove(name);
    if (there) put("");
    TableFile t;
    ASSERT_EQ(t.open(name, "step,a", 5), "");
    EXPECT_EQ(text(), "step,a\n");
  }
}

TEST_F(Table, DoesNotTakeTheFileOfOthers) {
  put("my notes\n");
  TableFile t;
  EXPECT_NE(t.open(name, "step,a", 5).find("other columns"), std::string::npos);
  EXPECT_EQ(text(), "my notes\n");
}

TEST_F(Table, SaysThatTheDiskIsFull) {
  for (long kept : {TableFile::kAnew, 5L}) {
    TableFile t;
    const std::string why = t.open("/dev/full", "step,a", kept);
    EXPECT_NE(why.find("/dev/full: No space left"), std::string::npos) << why;
  }
  TableFile t;
  EXPECT_NE(t.open("/no/such/folder/t.csv", "step,a", TableFile::kAnew).find("No such file"), std::string::npos);
}

}  // namespace
