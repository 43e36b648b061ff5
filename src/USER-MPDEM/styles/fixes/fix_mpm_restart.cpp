// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Reads and writes the data of fix mpm in restart files.
#include <malloc.h>

#include <cstdio>
#include <limits>
#include <vector>

#include "../words/arguments.h"
#include "comm.h"
#include "fix_mpm.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::text_of;

void FixMpm::write_restart(FILE* fp) {
  if (cement_->restored() && !cement_->built() && cement_->rows_started() > 0)
    mpdem::stop_all(lmp, who() +
                             "no run has read the motion of the nodes since read_restart, and a restart file that is written now would "
                             "lose it; use 'run 0' before write_restart");
  if (ranks_.shows_homes()) write_point_atoms();
  if (cement_->built())
    check_state(false);  // a corrupt state must not replace a good file; LIGGGHTS has exchanged atoms, which loses forces
  write_events();        // a run that continues from the file does not report these events again
  mpdem::CementHead head;
  head.time = update->get_cur_time();
  step_->save(head);
  head.links = coupling_.so_far();
  const std::vector<double> all = cement_->packed_state(head);
  avec_->write_with_points(cement_->packed_nodes());
  if (comm->me != 0) return;
  const std::size_t bytes = all.size() * sizeof(double);
  if (bytes > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    mpdem::stop_one(lmp, text_of(who(), "what it keeps of bonds and split nodes takes ", bytes,
                                 " bytes in a restart file of LIGGGHTS, which has 2 GiB for a fix; use several scenes"));
  const int size = static_cast<int>(bytes);  // LIGGGHTS' format has an int
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(all.data(), sizeof(double), all.size(), fp);
}

// Every rank gets the same numbers.
void FixMpm::restart(char* buf) {
  const auto damaged = [this](const std::string& what) {
    return what.empty() ? what : text_of(who(), "its data in the restart file are damaged: ", what, "; use another restart file");
  };
  const auto check = [&](const std::string& what) {
    if (!what.empty()) mpdem::stop_all(lmp, damaged(what));
  };
  // LIGGGHTS does not pass the length of its copy.
  const std::size_t numbers = malloc_usable_size(buf) / sizeof(double);
  const double* v = reinterpret_cast<const double*>(buf);
  check(numbers == 0 ? "there are none" : "");
  const std::string other = mpdem::trouble_with_version(who() + "restart data", v[0], mpdem::CementHead::kVersion);
  if (!other.empty()) mpdem::stop_all(lmp, other);
  mpdem::RecordReader in(v + 1, v + numbers);
  mpdem::CementHead head;
  in.read(head);
  // Cement may have been made since the file was written.
  const double most = static_cast<double>(avec_->bonds.table.size());
  in.check_whole("the number of bonds that have moved", head.rows_started, mpdem::from(0, most));
  in.check_whole("the number of bonds", head.rows, mpdem::from(head.rows_started, most));
  check(in.trouble());
  const std::size_t expected = 1 + mpdem::kMostNumbers<mpdem::CementHead> + mpdem::numbers_after(head);
  if (expected > numbers)
    check(text_of(head.rows, " bonds and ", head.copies, " copies of nodes take ", expected, " numbers, it has ", numbers, " at most"));
  std::vector<double> nodes;
  nodes.swap(avec_->restored_rows);
  guarded([&] { cement_->restore(head, in, nodes); });
  mpdem::stop_if_any(lmp, damaged(in.trouble()));  // only the nodes differ between ranks
  const std::string others = cement_->changed_options_since(head);
  if (!others.empty())
    mpdem::warn(lmp, text_of(who(), "the cement goes on with other words than in the steps before the restart file: ", others));
  // LIGGGHTS' files do not have the time, which would begin at 0 again.
  update->atime = head.time;
  update->atimestep = update->ntimestep;
  step_->restore(head);
  coupling_.restore(head.links);
}

}  // namespace LAMMPS_NS
