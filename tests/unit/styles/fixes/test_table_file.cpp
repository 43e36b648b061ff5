// SPDX-License-Identifier: GPL-2.0-or-later
#include "../../src/USER-MPDEM/styles/fixes/table_file.h"

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
  put("step,time,a\n0,0,1\n");
  TableFile t;
  ASSERT_EQ(t.open(name, "step,time,a", TableFile::kAnew), "");
  EXPECT_EQ(t.kept_to(), -1);
  EXPECT_EQ(t.write("5,0.5,2\n"), "");
  EXPECT_EQ(text(), "step,time,a\n5,0.5,2\n");  // before it is closed
}

TEST_F(Table, GoesOnBehindTheRowsThatStay) {
  put("step,time,a\n0,0,1\n5,0.5,2\n5,0.5,3\n10,1e0,4\n");
  TableFile t;
  ASSERT_EQ(t.open(name, "step,time,a", 0.55), "");
  EXPECT_EQ(t.kept_to(), 5);
  t.write("7,0.7,9\n");
  EXPECT_EQ(text(), "step,time,a\n0,0,1\n5,0.5,2\n5,0.5,3\n7,0.7,9\n");
}

// Rows from before `reset_timestep` have later steps. A file from before that goes on there.
TEST_F(Table, GoesByTimeWhereStepsWereReset) {
  const std::string head = "step,time,a\n0,0,1\n5,0.5,2\n10,1,3\n0,1,4\n5,1.5,5\n", before = "step,time,a\n0,0,1\n5,0.5,2\n";
  for (const double time : {0.55, 1.55}) {
    put(head + "10,2,6\n");
    TableFile t;
    ASSERT_EQ(t.open(name, "step,time,a", time), "");
    EXPECT_EQ(t.kept_to(), 5);
    EXPECT_EQ(text(), time < 1.0 ? before : head);
  }
}

TEST_F(Table, LeavesOutRowsThatAreNotWhole) {
  for (const char* end : {"1", "1,", "1\n", "1,2", "1,0.2", "1,0.2,"}) {
    put(std::string("step,time,b\n0,0,1\n") + end);
    TableFile t;
    ASSERT_EQ(t.open(name, "step,time,b", 100.0), "");
    EXPECT_EQ(t.kept_to(), 0);
    EXPECT_EQ(text(), "step,time,b\n0,0,1\n");
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
  for (double kept : {TableFile::kAnew, 5.0}) {
    TableFile t;
    const std::string why = t.open("/dev/full", "step,a", kept);
    EXPECT_NE(why.find("/dev/full: No space left"), std::string::npos) << why;
  }
  TableFile t;
  EXPECT_NE(t.open("/no/such/folder/t.csv", "step,a", TableFile::kAnew).find("No such file"), std::string::npos);
}

}  // namespace
