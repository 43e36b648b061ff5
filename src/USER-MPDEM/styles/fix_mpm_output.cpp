// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Global sums, rows of the bonds and restart data of fix mpm. Nothing here runs in a step
// that prints nothing.
#include <malloc.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

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
void global_sum(std::vector<double>& v, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, v.data(), static_cast<int>(v.size()), MPI_DOUBLE, MPI_SUM, comm);
}
void global_max(std::vector<double>& v, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, v.data(), static_cast<int>(v.size()), MPI_DOUBLE, MPI_MAX, comm);
}

// Of all ranks in their order, on the first.
std::vector<double> gather(const std::vector<double>& mine, MPI_Comm comm) {
  int me, ranks, n = static_cast<int>(mine.size());
  MPI_Comm_rank(comm, &me);
  MPI_Comm_size(comm, &ranks);
  std::vector<int> counts(ranks), at(ranks, 0);
  MPI_Gather(&n, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  std::vector<double> all;
  if (me == 0) {
    for (int r = 1; r < ranks; ++r) at[r] = at[r - 1] + counts[r - 1];
    all.resize(at.back() + counts.back());
  }
  MPI_Gatherv(mine.data(), n, MPI_DOUBLE, all.data(), counts.data(), at.data(), MPI_DOUBLE, 0, comm);
  return all;
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
    mpdem::NodeRow row;
    row.field = grid_.keys[i][0];
    for (int d = 0; d < 3; ++d) {
      row.place[d] = grid_.keys[i][1 + d];
      row.velocity[d] = grid_.velocity[3 * i + d];
      row.displacement[d] = grid_.displacement[3 * i + d];
      row.acceleration[d] = grid_.acceleration[3 * i + d];
    }
    mpdem::append(row, mine);
  }
  const std::vector<double> rows = gather(mine, world);
  if (comm->me != 0) return;
  const std::size_t bodies = avec_->bodies.size(), nodes = rows.size() / mpdem::kMostNumbers<mpdem::NodeRow>;
  mpdem::CementHead head;
  head.cell = cell_;
  head.basis = basis_;
  head.updated = updated_;
  head.tied = tied_;
  head.step = dt_last_;
  head.bodies_started = bodies_started_;
  head.start_energy = start_energy_;
  head.dissipated = sums[0];
  head.released = sums[1];
  head.damped = sums[2];
  head.work = sums[3];
  head.work_ahead = sums[4];
  head.time = update->get_cur_time();
  head.eigenvalue = eigenvalue_;
  head.auto_step = auto_step_;
  head.links = ran_;
  head.bodies = static_cast<int>(bodies);
  head.nodes = static_cast<int>(nodes);
  std::vector<double> front = {mpdem::CementHead::kVersion};
  mpdem::append(head, front);
  failed_seen_.resize(bodies, 0.0);
  separation_.resize(bodies);
  bonds_.resize(bodies);
  for (std::size_t b = 0; b < bodies; ++b) {
    const mpdem::Separation& s = separation_[b];
    mpdem::append(mpdem::BondRow{failed_seen_[b], s.separated, {s.at_grain[0], s.at_grain[1]}, s.inside, bonds_[b].peak}, front);
  }
  const std::size_t bytes = (front.size() + rows.size()) * sizeof(double);
  const int size = static_cast<int>(bytes);  // LIGGGHTS' format
  if (bytes > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    mpdem::stop_one(lmp, mpdem::text_of("fix mpm (id ", id, "): the motion of ", nodes, " nodes does not fit into the 2 GiB that a restart "
                                 "file of LIGGGHTS has for a fix; use a larger 'cell', or several scenes"));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(front.data(), sizeof(double), front.size(), fp);
  if (!rows.empty()) fwrite(rows.data(), sizeof(double), rows.size(), fp);
}

// The same numbers on every rank.
void FixMpm::restart(char* buf) {
  const auto damaged = [this](const std::string& what) {
    mpdem::stop_all(lmp, mpdem::text_of("fix mpm (id ", id, "): its data in the restart file are damaged: ", what, "; use another restart file"));
  };
  // LIGGGHTS does not tell how long its copy is.
  const std::size_t numbers = malloc_usable_size(buf) / sizeof(double);
  const double* v = reinterpret_cast<const double*>(buf);
  if (numbers == 0) damaged("there are none");
  const std::string other = mpdem::trouble_with_version(mpdem::text_of("fix mpm (id ", id, "): restart data"), v[0], mpdem::CementHead::kVersion);
  if (!other.empty()) mpdem::stop_all(lmp, other);
  mpdem::RecordReader in(v + 1, v + numbers);
  mpdem::CementHead head;
  in.read(head);
  // Cement may have been made since.
  const double most = static_cast<double>(avec_->bodies.size());
  in.check_whole("the number of bonds that have moved", head.bodies_started, mpdem::from(0, most));
  in.check_whole("the number of bonds", head.bodies, mpdem::from(head.bodies_started, most));
  if (!in.trouble().empty()) damaged(in.trouble());
  const std::size_t bodies = head.bodies, nodes = head.nodes;
  const std::size_t expected = 1 + mpdem::kMostNumbers<mpdem::CementHead> + mpdem::kMostNumbers<mpdem::BondRow> * bodies +
                               mpdem::kMostNumbers<mpdem::NodeRow> * nodes;
  if (expected > numbers) damaged(mpdem::text_of(bodies, " bonds and ", nodes, " nodes take ", expected, " numbers, it has ", numbers, " at most"));
  take_up(head);
  failed_seen_.resize(bodies);
  separation_.resize(bodies);
  bonds_.resize(bodies);
  for (std::size_t b = 0; b < bodies; ++b) {
    mpdem::BondRow row;
    in.read(row);
    failed_seen_[b] = row.failed_seen;
    separation_[b].separated = row.separated;
    std::copy(row.at_grain, row.at_grain + 2, separation_[b].at_grain);
    separation_[b].inside = row.inside;
    bonds_[b].peak = row.peak;
  }
  restore_nodes(nodes, in);
  if (!in.trouble().empty()) damaged(in.trouble());
}

void FixMpm::take_up(const mpdem::CementHead& head) {
  restored_cell_ = head.cell;
  restored_basis_ = head.basis;
  restored_updated_ = head.updated;
  restored_tied_ = head.tied;
  dt_last_ = head.step;
  bodies_started_ = head.bodies_started;
  start_energy_ = head.start_energy;
  if (comm->me == 0) {
    dissipated_ = head.dissipated;
    released_ = head.released;
    damped_ = head.damped;
    work_ = head.work;
    work_ahead_ = head.work_ahead;
  }
  // LIGGGHTS' files do not have the time, and it would begin at 0 again.
  update->atime = head.time;
  update->atimestep = update->ntimestep;
  eigenvalue_ = head.eigenvalue;
  auto_step_ = head.auto_step;
  ran_ = head.links;
}

// In the order of the keys.
void FixMpm::restore_nodes(std::size_t n, mpdem::RecordReader& in) {
  std::vector<mpdem::NodeRow> rows(n);
  for (mpdem::NodeRow& row : rows) {
    in.read(row);
    in.check_whole("the bond of a node", mpdem::body_of(row.field), mpdem::from(0, static_cast<double>(avec_->bodies.size()) - 1.0));
  }
  const auto key_of = [](const mpdem::NodeRow& r) { return mpdem::Key{r.field, r.place[0], r.place[1], r.place[2]}; };
  std::sort(rows.begin(), rows.end(), [&](const mpdem::NodeRow& a, const mpdem::NodeRow& b) { return key_of(a) < key_of(b); });
  for (const mpdem::NodeRow& row : rows) {
    restored_.keys.push_back(key_of(row));
    for (const double* part : {row.velocity, row.displacement, row.acceleration})
      restored_.values.insert(restored_.values.end(), part, part + 3);
  }
}

}  // namespace LAMMPS_NS
