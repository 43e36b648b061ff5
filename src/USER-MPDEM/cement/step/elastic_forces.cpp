// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "elastic_forces.h"

#include <algorithm>

#include "../../parallel/ranks.h"

namespace mpdem {

namespace {
constexpr double kDebonded = 1e9;                                                          // a number above that of the ranks
constexpr int kMostStiffness = 3 * ElasticEnd::kMostModes * (ElasticEnd::kMostModes + 1);  // numbers of ElasticEnd::stiffness()
}  // namespace

void ElasticForces::find_coupling(bool anew) {
  if (scene_.elastic_grains != ElasticGrains::coupled || (!anew && found_at_ == scene_.bonds().resolved_changes())) return;
  found_at_ = scene_.bonds().resolved_changes();
  coupling_.find(scene_.bonds(), scene_.options.cell);
  const int me = rank_in(scene_.comm), none = ranks_of(scene_.comm);
  std::vector<int> lowest(coupling_.ends(), none);
  for (Bond& b : scene_.bonds().resolved()) {
    if (!b.links.is_elastic()) continue;
    b.links.set_coupled(coupling_.is_coupled(b.row));
    for (int side = 0; side < 2; ++side)
      if (const int end = coupling_.end_of(b.row, side); end >= 0) lowest[static_cast<std::size_t>(end)] = me;
  }
  note_departures();
  MPI_Allreduce(MPI_IN_PLACE, lowest.data(), static_cast<int>(lowest.size()), MPI_INT, MPI_MIN, scene_.comm);
  counts_here_.resize(lowest.size());
  for (std::size_t n = 0; n < lowest.size(); ++n) counts_here_[n] = lowest[n] == me;
}

// A bond that left no longer moves the surfaces below the others, which release energy.
void ElasticForces::note_departures() {
  std::vector<std::array<int, 2>> now;
  for (const BondRecord& r : scene_.bonds().table)
    if (r.has_grain(0) && r.has_grain(1) && r.grain_E[0] + r.grain_E[1] > 0.0) now.push_back({r.grain[0], r.grain[1]});
  std::sort(now.begin(), now.end());
  const bool some_left = !std::includes(now.begin(), now.end(), pairs_.begin(), pairs_.end());
  pairs_ = std::move(now);
  if (!some_left) return;
  for (Bond& b : scene_.bonds().resolved())
    if (b.links.is_elastic()) b.links.note_debonding();
}

bool ElasticForces::waits(Bond& b) {
  if (!b.links.is_elastic()) return false;
  const bool shared = b.cut_by_ranks(), waits = shared || b.links.is_coupled();
  if (waits) waiting_.push_back({&b, shared});
  return waits;
}

template <class F>
void ElasticForces::each_coupled(F f) {
  for (const auto& [b, shared] : waiting_)
    for (int side = 0; side < 2 && b->links.is_coupled(); ++side)
      if (const int end = coupling_.end_of(b->row, side); end >= 0) f(*b, side, static_cast<std::size_t>(end));
}

void ElasticForces::sum_over_ranks(double* values, std::size_t width) const {
  for (std::size_t n = 0; n < counts_here_.size(); ++n)
    if (!counts_here_[n]) std::fill(values + width * n, values + width * (n + 1), 0.0);
  MPI_Allreduce(MPI_IN_PLACE, values, static_cast<int>(width * counts_here_.size()), MPI_DOUBLE, MPI_SUM, scene_.comm);
}

void ElasticForces::share_stiffness() {
  BondEnds& ends = scene_.grains.ends;
  std::vector<double> changed(ends.ends.size(), 0.0);
  int any = 0;
  for (const auto& [b, shared] : waiting_)
    if (b->links.modal_stiffness_changed())
      changed[static_cast<std::size_t>(b->first_end_index)] = b->links.some_debonded() ? kDebonded : 1.0, any = 1;
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, scene_.comm);
  if (!any) return;
  const auto of_bond = [&](const Bond& b) { return changed[static_cast<std::size_t>(b.first_end_index)]; };
  ends.sum(changed.data(), 1);
  sum_modes(
      kMostStiffness, [&](Bond& b, int side) { return of_bond(b) > 0.0 ? b.links.modal_stiffness(side) : std::vector<double>(); },
      [&](Bond& b, int side, const std::vector<double>& sums) { b.links.take_modal_stiffness(side, sums, of_bond(b) >= kDebonded); });
  for (const auto& [b, shared] : waiting_)
    for (int side = 0; side < 2 && !shared && of_bond(*b) > 0.0; ++side)
      if (b->links.modal_size(side) > 0) b->links.take_modal_stiffness(side, b->links.modal_stiffness(side), of_bond(*b) >= kDebonded);
  if (coupling_.ends() == 0) return;
  using Matrix6 = ElasticCoupling::Matrix6;
  std::vector<Matrix6> k(coupling_.ends(), Matrix6::Zero());
  std::vector<double> debonded(coupling_.ends(), 0.0);
  each_coupled([&](Bond& b, int side, std::size_t end) {
    k[end] = b.links.rigid_stiffness(side);
    debonded[end] = of_bond(b) >= kDebonded ? 1.0 : 0.0;
  });
  sum_over_ranks(k.front().data(), 36);
  sum_over_ranks(debonded.data(), 1);
  coupling_.set_stiffness(k);
  const std::vector<char> moved = coupling_.neighbours(std::vector<char>(debonded.begin(), debonded.end()));
  each_coupled([&](Bond& b, int, std::size_t end) {
    if (moved[end]) b.links.note_debonding();
  });
}

void ElasticForces::share_loads(double dt) {
  for (const auto& [b, shared] : waiting_) {
    b->links.find_modal_loads(b->grid, scene_.grains.ends_of(*b), dt);
    for (int side = 0; side < 2; ++side)
      if (b->links.modal_size(side) > 0) b->links.take_modal_loads(side, b->links.modal_loads(side));
  }
  sum_modes(
      3 * ElasticEnd::kMostModes,
      [](Bond& b, int side) {
        const Eigen::VectorXd& s = b.links.modal_loads(side);
        return std::vector<double>(s.data(), s.data() + s.size());
      },
      [](Bond& b, int side, const std::vector<double>& sums) {
        b.links.take_modal_loads(side, Eigen::Map<const Eigen::VectorXd>(sums.data(), static_cast<Eigen::Index>(sums.size())));
      });
}

void ElasticForces::couple() {
  if (coupling_.ends() == 0) return;
  std::vector<ElasticCoupling::Vector6> loads(coupling_.ends(), ElasticCoupling::Vector6::Zero());
  each_coupled([&](Bond& b, int side, std::size_t end) { loads[end] = b.links.rigid_load(side); });
  sum_over_ranks(loads.front().data(), 6);
  coupling_.find_motions(loads);
}

std::array<ElasticCoupling::Vector6, 2> ElasticForces::motions_of(const Bond& b) const {
  std::array<ElasticCoupling::Vector6, 2> w{ElasticCoupling::Vector6::Zero(), ElasticCoupling::Vector6::Zero()};
  for (int side = 0; side < 2 && b.links.is_coupled(); ++side)
    if (const int end = coupling_.end_of(b.row, side); end >= 0) w[static_cast<std::size_t>(side)] = coupling_.motion(end);
  return w;
}

// Traction laws with a state soften by the loads that they had so far.
void ElasticForces::update_links() {
  int changed = 0;
  for (const auto& [b, shared] : waiting_)
    if (b->links.update_elastic(b->points, b->grid, scene_.grains.ends_of(*b), scene_.now.dt, motions_of(*b), b->link_step)) changed = 1;
  MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, scene_.comm);
  if (changed) find_loads(scene_.now.dt);
}

// dt: time since the positions before, which count for what debonding releases.
void ElasticForces::find_loads(double dt) {
  share_stiffness();
  share_loads(dt);
  couple();
}

void ElasticForces::find(bool at_start, const std::function<void(Bond&)>& then) {
  if (scene_.elastic_grains == ElasticGrains::none) return;
  for (const auto& [b, shared] : waiting_) {
    b->links.find_secants(b->grid, scene_.grains.ends_of(*b));
    b->link_step = LinkStep();
  }
  find_loads(at_start ? 0.0 : scene_.now.dt);
  if (!at_start && scene_.penalty->law->fields() > 0) update_links();
  for (const auto& [b, shared] : waiting_) {
    const auto w = motions_of(*b);
    for (std::size_t side = 0; side < 2; ++side)
      if (b->links.modal_size(static_cast<int>(side)) > 0) b->links.find_amplitudes(static_cast<int>(side), w[side]);
    b->link_step.released += b->links.add_elastic_force(b->grid, scene_.grains.ends_of(*b));
    std::sort(b->link_step.debond.begin(), b->link_step.debond.end());
    then(*b);
  }
  waiting_.clear();
}

// Sums numbers of the ends of bonds that ranks cut, at most so many an end, in pieces.
template <class Get, class Take>
void ElasticForces::sum_modes(int most, Get get, Take take) {
  if (ranks_of(scene_.comm) == 1) return;
  constexpr int kPiece = 3 * ElasticEnd::kMostModes;
  BondEnds& ends = scene_.grains.ends;
  std::vector<std::vector<double>> numbers(2 * waiting_.size());
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    const auto& [b, shared] = waiting_[n / 2];
    if (shared && b->links.modal_size(static_cast<int>(n % 2)) > 0) numbers[n] = get(*b, static_cast<int>(n % 2));
  }
  std::vector<double> piece(kPiece * ends.ends.size());
  for (int first = 0; first < most; first += kPiece) {
    std::fill(piece.begin(), piece.end(), 0.0);
    const auto each = [&](auto f) {
      for (std::size_t n = 0; n < numbers.size(); ++n)
        for (std::size_t i = static_cast<std::size_t>(first); i < std::min(numbers[n].size(), static_cast<std::size_t>(first + kPiece));
             ++i)
          f(piece[kPiece * (static_cast<std::size_t>(waiting_[n / 2].bond->first_end_index) + n % 2) + i - static_cast<std::size_t>(first)],
            numbers[n][i]);
    };
    each([](double& to, double of_rank) { to = of_rank; });
    ends.sum(piece.data(), kPiece);
    each([](double of_all, double& to) { to = of_all; });
  }
  for (std::size_t n = 0; n < numbers.size(); ++n)
    if (!numbers[n].empty()) take(*waiting_[n / 2].bond, static_cast<int>(n % 2), numbers[n]);
}

}  // namespace mpdem
