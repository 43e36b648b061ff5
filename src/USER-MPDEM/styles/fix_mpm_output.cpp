// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Global sums, rows of the bonds and restart data of fix mpm. Nothing here runs in a step
// that prints nothing.
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

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
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const mpdem::PointBlock& p = points.blocks[b];
    const mpdem::BlockMeta& m = points.meta[b];
    sum[kPoints] += __builtin_popcount(m.occupied);
    sum[kFailed] += __builtin_popcount(m.failed);
    sum[kVolume] += sum_lanes(p.volume);
    const vd alive = mpdem::select(mpdem::lanes(m.failed), vd{}, p.volume);
    const mpdem::Sym3<vd> s =
        m.damaged ? law_->stress(p.strain, points.damage[b].D) : law_->elasticity().stress(p.strain);
    sum[kElastic] += sum_lanes(0.5 * alive * mpdem::contract(s, p.strain));
    if (m.damaged) {
      const vd d = mpdem::largest(mpdem::eigen(points.damage[b].D));
      sum[kDamaged] += sum_lanes(p.volume * d);
      for (int l = 0; l < kLanes; ++l)
        if (m.occupied >> l & 1) most[0] = std::max(most[0], d[l]);
    }
  }
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
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const mpdem::BlockMeta& m = points.meta[b];
    double* row = &sum[kRow * m.body + 2 * kSide];
    row[0] += __builtin_popcount(m.occupied);
    row[1] += __builtin_popcount(m.failed);
    row[2] += sum_lanes(points.blocks[b].volume);
    if (m.damaged) {
      const vd d = mpdem::largest(mpdem::eigen(points.damage[b].D));
      row[3] += sum_lanes(points.blocks[b].volume * d);
      for (int l = 0; l < kLanes; ++l)
        if (m.occupied >> l & 1) most[m.body] = std::max(most[m.body], d[l]);
    }
  }
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

void FixMpm::restart(char* buf) {
  const double* v = reinterpret_cast<const double*>(buf);
  if (v[0] != kRestartVersion)
    mpdem::stop_all(lmp, mpdem::text_of("fix mpm (id ", id, "): restart data of version ", v[0], ", this program reads version ",
                                        kRestartVersion));
  restored_cell_ = v[1];
  restored_basis_ = static_cast<mpdem::Basis>(static_cast<int>(v[2]));
  restored_updated_ = static_cast<int>(v[3]) & 1;
  restored_tied_ = static_cast<int>(v[3]) & 2;
  dt_last_ = v[4];
  bodies_started_ = static_cast<int>(v[5]);
  start_energy_ = v[6];
  if (comm->me == 0) {
    dissipated_ = v[7];
    released_ = v[8];
    damped_ = v[9];
    work_ = v[10];
    work_ahead_ = v[11];
  }
  // LIGGGHTS' files do not have the time, and it would begin at 0 again.
  update->atime = v[12];
  update->atimestep = update->ntimestep;
  eigenvalue_ = v[13];
  auto_step_ = v[14];
  ran_.coupling = v[15] == CouplingOfSteps::kLinks  ? CouplingOfSteps::kLinks
                  : v[15] == CouplingOfSteps::kNone ? CouplingOfSteps::kNone
                                                    : CouplingOfSteps::kNoSteps;
  ran_.kn = v[16];
  ran_.kt = v[17];
  ran_.at_surface = v[18] != 0.0;
  const std::size_t bodies = static_cast<std::size_t>(v[19]), n = static_cast<std::size_t>(v[20]);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  failed_seen_.resize(bodies);
  separation_.resize(bodies);
  bonds_.resize(bodies);
  const double* row = v + 21;
  for (std::size_t b = 0; b < bodies; ++b, row += 6) {
    failed_seen_[b] = row[0];
    separation_[b].separated = row[1] != 0.0;
    separation_[b].at_grain[0] = row[2];
    separation_[b].at_grain[1] = row[3];
    separation_[b].inside = row[4];
    bonds_[b].peak = row[5];
  }
  const double* rows = row;
  const auto key = [rows](std::size_t i) {
    const double* r = rows + kNodeRow * i;
    return mpdem::Key{static_cast<int>(r[0]), static_cast<int>(r[1]), static_cast<int>(r[2]), static_cast<int>(r[3])};
  };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  for (std::size_t i : order) {
    restored_.keys.push_back(key(i));
    restored_.values.insert(restored_.values.end(), rows + kNodeRow * i + 4, rows + kNodeRow * (i + 1));
  }
}

}  // namespace LAMMPS_NS
