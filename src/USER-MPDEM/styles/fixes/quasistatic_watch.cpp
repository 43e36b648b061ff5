// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "quasistatic_watch.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "../words/arguments.h"
#include "update.h"

namespace mpdem {

namespace {
constexpr double kCalm = 0.1;           // kinetic share over its limit, below which there is almost no motion
constexpr double kDamaged = 0.1;        // energy that damage has dissipated, over that of the cement
constexpr std::size_t kSharesKept = 3;  // checks whose median counts
constexpr double kLoaded = 0.1;         // energy put in at a check that counts, over that at the failure
}  // namespace

void QuasistaticWatch::start_run(Cement& c, bool any_failed) {
  if (limit_ == 0.0 || reported_flag_) return;
  const Shares now = c.report().energy_shares();
  keep(now);
  if (started_) return;
  started_ = true;
  damaged_ = now.dissipated > kDamaged;
  calm_ = !any_failed && !damaged_;
}

void QuasistaticWatch::keep(const Shares& share) {
  if (shares_.size() == kSharesKept) shares_.erase(shares_.begin());
  shares_.push_back(share);
  at_ = lmp_->update->ntimestep;
}

namespace {
double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}
}  // namespace

double QuasistaticWatch::median_share(const Shares& now) const {
  std::vector<double> all, loaded;
  for (const Shares& s : shares_) {
    all.push_back(s.kinetic);
    if (s.put_in >= kLoaded * now.put_in) loaded.push_back(s.kinetic);
  }
  return loaded.empty() ? std::max(median(all), now.kinetic) : median(loaded);
}

// Failure before the first check is judged with the share at that check.
void QuasistaticWatch::check(Cement& c) {
  if (limit_ == 0.0 || reported_flag_ || lmp_->update->ntimestep == at_) return;
  const Shares now = c.report().energy_shares();
  int mine = failed_, any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, lmp_->world);
  failed_ = false;
  const bool damaged = now.dissipated > kDamaged, broke = any || (damaged && !damaged_), judged = broke && calm_;
  damaged_ = damaged;
  calm_ = !broke && (calm_ || now.kinetic < kCalm * limit_);
  if (!checked_) keep(now);
  checked_ = true;
  if (const double share = judged ? median_share(now) : 0.0; share > limit_) warn(c, share);
  keep(now);
}

void QuasistaticWatch::warn(const Cement& c, double share) {
  reported_flag_ = true;
  const double faster = std::sqrt(share / limit_), scale = c.options().mass_scale;
  const double less = scale / (faster * faster);
  const std::string scaled = less >= 1.0 ? text_of(", or 'quasistatic ", less, "' or less in the place of ", scale) : std::string();
  mpdem::warn(
      lmp_,
      text_of(who_, "cement began to break after step ", at_, " with a kinetic share of the energy of ", share, ", more than ", limit_,
              " ('kinetic_share'): the load is not quasi-static, and cement carries more than it does under a slow one; move plates and "
              "grains ",
              faster, " times as slowly", scaled, ", or let motion die away before; where motion is meant use 'kinetic_share no'"));
}

}  // namespace mpdem
