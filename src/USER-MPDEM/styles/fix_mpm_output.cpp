// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Global sums, rows of the bonds and restart data of fix mpm. Nothing here runs in a step
// that prints nothing.
#include <malloc.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "../mpm/checked_numbers.h"
#include "arguments.h"
#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "fix_mpm.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::kLanes;
using mpdem::sum_lanes;
using mpdem::vd;

namespace {
constexpr double kRestartVersion = 5.0;
constexpr std::size_t kRestartHead = 21, kBondRow = 6;
constexpr int kNodeRow = 4 + mpdem::NodeKinematics::kWidth;

void global_sum(std::vector<double>& v, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, v.data(), static_cast<int>(v.size()), MPI_DOUBLE, MPI_SUM, comm);
}
void global_max(std::vector<double>& v, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, v.data(), static_cast<int>(v.size()), MPI_DOUBLE, MPI_MAX, comm);
}
}  // namespace

const FixMpm::Totals& FixMpm::totals() {
  if (totals_at_ == update->ntimestep) return totals_;
  if (!built_) {
    totals_ = Totals{};
    count_modes(totals_);
    return totals_;
  }
  const mpdem::PointStore& points = avec_->points;
  // points, failed, V, V d, elastic, coupling, kinetic, kinetic by central differences, p(3), L(3), then what accumulates
  enum { kPoints, kFailed, kVolume, kDamaged, kElastic, kCoupling, kKinetic, kKept, kP, kL = kP + 3, kDissipated = kL + 3,
         kReleased, kDamped, kWork, kCount };
  std::vector<double> sum(kCount, 0.0), most(1, 0.0);
  mpdem::with_law(*law_, [&](const auto& law) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const mpdem::PointBlock& p = points.blocks[b];
      const mpdem::BlockMeta& m = points.meta[b];
      sum[kPoints] += __builtin_popcount(m.occupied);
      sum[kFailed] += __builtin_popcount(m.failed);
      sum[kVolume] += sum_lanes(p.volume);
      const vd alive = mpdem::select(mpdem::lanes(m.failed), vd{}, p.volume);
      const mpdem::Sym3<vd> s = mpdem::stress_of(points, static_cast<int>(b), law);
      sum[kElastic] += sum_lanes(0.5 * alive * mpdem::contract(s, p.strain));
      if (m.damaged) {
        const vd d = mpdem::largest_damage_of(points, static_cast<int>(b), law);
        sum[kDamaged] += sum_lanes(p.volume * d);
        for (int l = 0; l < kLanes; ++l)
          if (m.occupied >> l & 1) most[0] = std::max(most[0], d[l]);
      }
    }
  });
  for (int i = 0; i < grid_.size(); ++i) {
    if (!grid_.halo.counts_here()[i]) continue;
    const mpdem::Body& body = avec_->bodies[mpdem::body_of(grid_.keys[i][0])];
    double v[3], x[3], kick[3];
    for (int d = 0; d < 3; ++d) {
      kick[d] = 0.5 * dt_last_ * grid_.acceleration[3 * i + d];
      v[d] = grid_.velocity[3 * i + d] + kick[d];
      x[d] = body.origin[d] + grid_.keys[i][1 + d] * cell_ + grid_.displacement[3 * i + d];
    }
    const double mass = grid_.mass[i];
    for (int d = 0; d < 3; ++d) {
      sum[kKinetic] += 0.5 * mass * v[d] * v[d];
      sum[kKept] += 0.5 * mass * (v[d] - kick[d]) * (v[d] + kick[d]);
      sum[kP + d] += mass * v[d];
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      sum[kL + d] += mass * (x[e] * v[g] - x[g] * v[e]);
    }
  }
  if (coupled_) {
    const double inertial = links_.inertial_energy(grid_, sides_, 0.5 * dt_last_, 0.5 * dt_last_);
    sum[kCoupling] = links_.spring_energy(grid_, sides_) + inertial;
    sum[kKept] += links_.inertial_energy(grid_, sides_, 0.0, dt_last_) - inertial;
  }
  sum[kDissipated] = dissipated_;
  sum[kReleased] = released_;
  sum[kDamped] = damped_;
  sum[kWork] = work_ - work_ahead_;
  global_sum(sum, world);
  global_max(most, world);

  Totals& t = totals_;
  t.points = sum[kPoints];
  t.failed = sum[kFailed];
  t.largest_damage = most[0];
  t.mean_damage = sum[kDamaged] / sum[kVolume];
  t.kinetic = sum[kKinetic];
  t.elastic = sum[kElastic];
  t.coupling = sum[kCoupling];
  t.dissipated = sum[kDissipated];
  t.released = sum[kReleased];
  t.damped = sum[kDamped];
  t.external_work = sum[kWork];
  const double spent = t.kinetic + t.elastic + t.coupling + t.dissipated + t.released + t.damped;
  const double scale = std::max(std::fabs(t.external_work), spent);
  // What central differences keep is not m/2 v.v but m/2 v-.v+, of the velocities half a step before and after.
  const double kept = spent - t.kinetic + sum[kKept];
  // With positions rounded as they are in the box, springs and cement have energies of this order even at
  // rest, more where the rounding of many steps adds up.
  double reach = 0.0;
  for (int d = 0; d < 3; ++d) reach = std::max({reach, std::fabs(domain->boxlo[d]), std::fabs(domain->boxhi[d])});
  const double strain = std::numeric_limits<double>::epsilon() * reach / cell_;
  const double rounding = 100.0 * std::max(law_->elasticity().C33, coupled_ ? penalty_.kn * cell_ : 0.0) * sum[kVolume] * strain * strain;
  t.imbalance = scale > rounding ? (t.external_work + start_energy_ - kept) / scale : 0.0;
  count_modes(t);
  for (int d = 0; d < 3; ++d) {
    t.momentum[d] = sum[kP + d];
    t.angular_momentum[d] = sum[kL + d];
  }
  totals_at_ = update->ntimestep;
  return totals_;
}

const std::vector<FixMpm::BondState>& FixMpm::bonds() {
  if (bonds_at_ == update->ntimestep) return bonds_;
  const int n = static_cast<int>(avec_->bodies.size());
  std::vector<double> peak(n, 0.0);
  for (int i = 0; i < n && i < static_cast<int>(bonds_.size()); ++i) peak[i] = bonds_[i].peak;
  bonds_.assign(n, BondState{});
  for (int i = 0; i < n; ++i) bonds_[i].peak = peak[i];
  if (!built_) return bonds_;
  const mpdem::PointStore& points = avec_->points;
  constexpr int kSide = 9;  // force, torque, position of the grain
  constexpr int kRow = 2 * kSide + 6;
  std::vector<double> sum(kRow * n, 0.0), most(n, 0.0);
  for (const OwnedSide& o : owned_) {
    if (!coupled_) break;
    const mpdem::GrainSide& s = sides_.sides[o.at];
    double* row = &sum[kRow * o.body + kSide * o.side];
    for (int d = 0; d < 3; ++d) {
      row[d] = s.force[d];
      row[3 + d] = s.torque[d];
      row[6 + d] = s.x[d];
    }
  }
  mpdem::with_law(*law_, [&](const auto& law) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const mpdem::BlockMeta& m = points.meta[b];
      double* row = &sum[kRow * m.body + 2 * kSide];
      row[0] += __builtin_popcount(m.occupied);
      row[1] += __builtin_popcount(m.failed);
      row[2] += sum_lanes(points.blocks[b].volume);
      if (m.damaged) {
        const vd d = mpdem::largest_damage_of(points, static_cast<int>(b), law);
        row[3] += sum_lanes(points.blocks[b].volume * d);
        for (int l = 0; l < kLanes; ++l)
          if (m.occupied >> l & 1) most[m.body] = std::max(most[m.body], d[l]);
      }
    }
  });
  for (const mpdem::Link& k : points.links)
    sum[kRow * points.meta[k.slot / kLanes].body + 2 * kSide + (k.attached ? 4 : 5)] += 1.0;
  global_sum(sum, world);
  global_max(most, world);
  for (int i = 0; i < n; ++i) {
    const double* row = &sum[kRow * i];
    BondState& b = bonds_[i];
    double axis[3], length = 0.0;
    for (int d = 0; d < 3; ++d) {
      axis[d] = row[kSide + 6 + d] - row[6 + d];
      length += axis[d] * axis[d];
    }
    length = std::sqrt(length);
    for (int s = 0; s < 2; ++s)
      for (int d = 0; d < 3; ++d) {
        b.force[s][d] = row[kSide * s + d];
        b.torque[s][d] = row[kSide * s + 3 + d];
        b.tension += (s == 0 ? 0.5 : -0.5) * b.force[s][d] * (length > 0.0 ? axis[d] / length : 0.0);
      }
    b.peak = std::max(peak[i], b.tension);
    b.gap = length - avec_->bodies[i].radius[0] - avec_->bodies[i].radius[1];
    b.points = row[2 * kSide];
    b.failed = row[2 * kSide + 1];
    b.mean_damage = row[2 * kSide + 3] / row[2 * kSide + 2];
    b.largest_damage = most[i];
    b.attached = row[2 * kSide + 4];
    b.debonded = row[2 * kSide + 5];
    if (i < static_cast<int>(separation_.size()) && separation_[i].separated) {
      const mpdem::Separation& s = separation_[i];
      const double all = s.at_grain[0] + s.at_grain[1] + s.inside;
      b.separated = 1.0;
      for (int g = 0; g < 2; ++g) b.share[g] = all > 0.0 ? s.at_grain[g] / all : 0.0;
    }
  }
  bonds_at_ = update->ntimestep;
  return bonds_;
}

double FixMpm::compute_scalar() {
  const Totals& t = totals();
  return t.elastic + t.coupling;
}

double FixMpm::compute_vector(int n) {
  const Totals& t = totals();
  const double v[] = {t.points,     t.failed,      t.largest_damage, t.mean_damage, t.kinetic,         t.elastic,
                      t.coupling,   t.dissipated,  t.released,       t.damped,      t.external_work,   t.imbalance,
                      t.momentum[0], t.momentum[1], t.momentum[2],
                      t.angular_momentum[0], t.angular_momentum[1], t.angular_momentum[2],
                      t.separated, t.debonding, t.internal, t.mixed};
  return v[n];
}

// Nodal motion is not held by the points, so it travels in the fix's own part of the file.
void FixMpm::write_restart(FILE* fp) {
  if (built_) check_state();  // a spoilt state must not take the place of a good file
  write_events();  // a run that goes on from the file does not tell of them again
  std::vector<double> sums = {dissipated_, released_, damped_, work_, work_ahead_};
  global_sum(sums, world);
  std::vector<double> mine;
  for (int i = 0; i < grid_.size(); ++i) {
    if (!grid_.halo.counts_here()[i]) continue;
    for (int k : grid_.keys[i]) mine.push_back(k);
    for (int d = 0; d < 3; ++d) mine.push_back(grid_.velocity[3 * i + d]);
    for (int d = 0; d < 3; ++d) mine.push_back(grid_.displacement[3 * i + d]);
    for (int d = 0; d < 3; ++d) mine.push_back(grid_.acceleration[3 * i + d]);
  }
  std::vector<int> counts(comm->nprocs), at(comm->nprocs, 0);
  int n = static_cast<int>(mine.size());
  MPI_Gather(&n, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, world);
  std::vector<double> all;
  if (comm->me == 0) {
    for (int r = 1; r < comm->nprocs; ++r) at[r] = at[r - 1] + counts[r - 1];
    all.resize(at.back() + counts.back());
  }
  MPI_Gatherv(mine.data(), n, MPI_DOUBLE, all.data(), counts.data(), at.data(), MPI_DOUBLE, 0, world);
  if (comm->me != 0) return;
  std::vector<double> head = {kRestartVersion, cell_, static_cast<double>(basis_), 1.0 * updated_ + 2.0 * tied_, dt_last_,
                              static_cast<double>(bodies_started_), start_energy_};
  head.insert(head.end(), sums.begin(), sums.end());
  head.push_back(update->get_cur_time());
  head.push_back(eigenvalue_);
  head.push_back(auto_step_);
  head.insert(head.end(), {static_cast<double>(ran_.coupling), ran_.kn, ran_.kt, 1.0 * ran_.at_surface});
  const std::size_t bodies = avec_->bodies.size();
  head.push_back(static_cast<double>(bodies));
  head.push_back(static_cast<double>(all.size() / kNodeRow));
  failed_seen_.resize(bodies, 0.0);
  separation_.resize(bodies);
  bonds_.resize(bodies);
  for (std::size_t b = 0; b < bodies; ++b) {
    const mpdem::Separation& s = separation_[b];
    head.insert(head.end(), {failed_seen_[b], static_cast<double>(s.separated), s.at_grain[0], s.at_grain[1], s.inside, bonds_[b].peak});
  }
  const std::size_t bytes = (head.size() + all.size()) * sizeof(double);
  const int size = static_cast<int>(bytes);  // LIGGGHTS' format
  if (bytes > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    mpdem::stop_one(lmp, mpdem::text_of("fix mpm (id ", id, "): the motion of ", all.size() / kNodeRow, " nodes does not fit into the 2 GiB that a restart "
                                 "file of LIGGGHTS has for a fix; use a larger 'cell', or several scenes"));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(head.data(), sizeof(double), head.size(), fp);
  if (!all.empty()) fwrite(all.data(), sizeof(double), all.size(), fp);
}

// The same numbers on every rank.
void FixMpm::restart(char* buf) {
  const auto damaged = [this](const std::string& what) {
    mpdem::stop_all(lmp, mpdem::text_of("fix mpm (id ", id, "): its data in the restart file are damaged: ", what, "; use another restart file"));
  };
  // LIGGGHTS does not tell how long its copy is.
  const std::size_t numbers = malloc_usable_size(buf) / sizeof(double);
  const double* v = reinterpret_cast<const double*>(buf);
  if (numbers < kRestartHead) damaged(mpdem::text_of("they end after ", numbers, " numbers"));
  if (v[0] != kRestartVersion)
    mpdem::stop_all(lmp, mpdem::text_of("fix mpm (id ", id, "): restart data of version ", v[0], ", this program reads version ",
                                        kRestartVersion));
  mpdem::CheckedNumbers in(v + 1);
  restored_cell_ = in.positive("cell");
  restored_basis_ = static_cast<mpdem::Basis>(in.integer("the number of the basis", 0, static_cast<int>(mpdem::Basis::cubic)));
  const int kinematics = in.integer("the number of the kinematics", 0, 3);
  restored_updated_ = kinematics & 1;
  restored_tied_ = kinematics & 2;
  dt_last_ = in.not_negative("the time step");
  bodies_started_ = in.integer("the number of bonds that have moved", 0, static_cast<double>(avec_->bodies.size()));
  start_energy_ = in.finite("an energy");
  double sums[5];
  in.finite("an energy", sums);
  if (comm->me == 0) {
    dissipated_ = sums[0];
    released_ = sums[1];
    damped_ = sums[2];
    work_ = sums[3];
    work_ahead_ = sums[4];
  }
  // LIGGGHTS' files do not have the time, and it would begin at 0 again.
  update->atime = in.finite("the time");
  update->atimestep = update->ntimestep;
  eigenvalue_ = in.not_negative("the largest eigenvalue");
  auto_step_ = in.not_negative("the step of 'timestep auto'");
  using Coupling = decltype(ran_.coupling);
  ran_.coupling = static_cast<Coupling>(in.integer("the kind of coupling", CouplingOfSteps::kNoSteps, CouplingOfSteps::kNone));
  ran_.kn = in.finite("kn of the coupling");
  ran_.kt = in.finite("kt of the coupling");
  ran_.at_surface = in.flag("'at surface' of the coupling");
  // Cement may have been made since.
  const std::size_t bodies = in.integer("the number of bonds", bodies_started_, static_cast<double>(avec_->bodies.size()));
  const std::size_t n = in.integer("the number of nodes", 0, std::numeric_limits<int>::max());
  if (!in.trouble().empty()) damaged(in.trouble());
  const std::size_t expected = kRestartHead + kBondRow * bodies + kNodeRow * n;
  if (expected > numbers) damaged(mpdem::text_of(bodies, " bonds and ", n, " nodes take ", expected, " numbers, it has ", numbers, " at most"));
  failed_seen_.resize(bodies);
  separation_.resize(bodies);
  bonds_.resize(bodies);
  for (std::size_t b = 0; b < bodies; ++b) {
    failed_seen_[b] = in.not_negative("the number of failed points of a bond");
    separation_[b].separated = in.flag("'is separated' of a bond");
    separation_[b].at_grain[0] = in.not_negative("the area of separation at a grain");
    separation_[b].at_grain[1] = in.not_negative("the area of separation at a grain");
    separation_[b].inside = in.not_negative("the area of separation inside");
    bonds_[b].peak = in.finite("the largest tension of a bond");
  }
  restore_nodes(n, in);
  if (!in.trouble().empty()) damaged(in.trouble());
}

// Rows of nodes in the order of the keys.
void FixMpm::restore_nodes(std::size_t n, mpdem::CheckedNumbers& in) {
  const double bodies = static_cast<double>(avec_->bodies.size()), most = 1 << 30;
  const double* rows = in.next();
  std::vector<std::pair<mpdem::Key, const double*>> nodes;
  for (std::size_t i = 0; i < n; ++i) {
    const int field = in.integer("the bond of a node", 0, most);
    in.check("the bond of a node", mpdem::body_of(field), 0, bodies - 1);
    mpdem::Key key{field, 0, 0, 0};
    for (int d = 1; d < 4; ++d) key[d] = in.integer("the place of a node", -most, most);
    for (int d = 0; d < mpdem::NodeKinematics::kWidth; ++d) in.finite("the motion of a node");
    nodes.emplace_back(key, rows + kNodeRow * i + 4);
  }
  std::sort(nodes.begin(), nodes.end());
  for (const auto& [key, values] : nodes) {
    restored_.keys.push_back(key);
    restored_.values.insert(restored_.values.end(), values, values + mpdem::NodeKinematics::kWidth);
  }
}

}  // namespace LAMMPS_NS
