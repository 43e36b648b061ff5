// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Main program of the tests that need MPI. Every rank runs every test; the program fails
// if any rank saw a failure.
#include <gtest/gtest.h>
#include <mpi.h>

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  MPI_Init(&argc, &argv);
  int rank;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  // One report is enough as long as all is well; failures are printed by each rank.
  auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
  class FailuresOnly : public ::testing::EmptyTestEventListener {
   public:
    explicit FailuresOnly(int rank) : rank_(rank) {}
    void OnTestPartResult(const ::testing::TestPartResult& r) override {
      if (r.failed()) std::printf("rank %d: %s:%d: %s\n", rank_, r.file_name() ? r.file_name() : "", r.line_number(), r.message());
    }

   private:
    int rank_;
  };
  if (rank != 0) {
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new FailuresOnly(rank));
  }
  int mine = RUN_ALL_TESTS(), any = 0;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return any;
}
