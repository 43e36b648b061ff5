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
}  // namespace

void QuasistaticWatch::start_run(Cement& c, bool any_failed) {
  if (limit_ == 0.0 || reported_flag_) return;
  const Report::EnergyShares now = c.report().energy_shares();
  keep(now.kinetic);
  if (started_) return;
  started_ = true;
  damaged_ = now.dissipated > kDamaged;
  calm_ = !any_failed && !damaged_;
}

void QuasistaticWatch::keep(double share) {
  if (shares_.size() == kSharesKept) shares_.erase(shares_.begin());
  shares_.push_back(share);
  at_ = lmp_->update->ntimestep;
}

double QuasistaticWatch::median_share() const {
  std::vector<double> sorted(shares_);
  const auto middle = sorted.begin() + static_cast<long>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

// Failure before the first check is judged with the share at that check.
void QuasistaticWatch::check(Cement& c) {
  if (limit_ == 0.0 || reported_flag_ || lmp_->update->ntimestep == at_) return;
  const Report::EnergyShares now = c.report().energy_shares();
  int mine = failed_, any;
  MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, lmp_->world);
  failed_ = false;
  const bool damaged = now.dissipated > kDamaged, broke = any || (damaged && !damaged_), judged = broke && calm_;
  damaged_ = damaged;
  calm_ = !broke && (calm_ || now.kinetic < kCalm * limit_);
  if (!checked_) keep(now.kinetic);
  checked_ = true;
  if (judged && median_share() > limit_) warn(c);
  keep(now.kinetic);
}

void QuasistaticWatch::warn(const Cement& c) {
  reported_flag_ = true;
  const double share = median_share(), faster = std::sqrt(share / limit_), scale = c.options().mass_scale;
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
