// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A small host of the cement: spheres in a row along z with flat bonds between them. The last sphere is pulled away from the
// first. The host calls the engine in the order that fix mpm does.
#ifndef MPDEM_TESTS_CEMENT_HOST_H
#define MPDEM_TESTS_CEMENT_HOST_H

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "cement/engine/cement.h"
#include "coupling/penalty_traction.h"
#include "material/no_damage.h"
#include "material/tensor_damage.h"
#include "geometry/flat.h"
#include "geometry/lattice_fill.h"

namespace mpdem::test {

// Displacement and velocity of a grain at a time.
struct Way {
  double way[3], velocity[3];
};

struct Row {
  int bonds = 1;
  bool updated = false;
  bool free_middle = false;           // grains between the first and the last follow forces
  bool whole_bonds = false;           // each bond on one rank; else points are dealt out by x
  double B0 = 9.6e3, exponent = 1.0;  // parameters of the damage law
  double length = 0.0;                // length that the strain is averaged over
  int mass_order = 1;
  double speed = 4.0;               // at which the last grain leaves the first, after the ramp
  double ramp = 4e-6;               // time until that speed is reached
  std::function<Way(double)> path;  // displacement of the last grain in place of the ramp; the first grain stays where it is
  double friction = -1.0;           // friction of contact points; below 0: none
  bool loose = false;               // links to the first grain are not attached from the start
  bool skin_failed = false;         // and their points have failed
  int cracked = 0;                  // this many layers in the middle have failed, an odd one above it
  double crumbled = 0.0;            // points at x above this have failed and are connected to no grain; 0: none
  bool unilateral = false;
  bool split = false;      // nodes are split where material separates
  double interface = 1.0;  // parameter of the damage law for points with links
  int substeps = 1;        // number of steps of the cement in a step of the host
  bool free_ends = false;  // all grains follow forces
  double grain_mass = 2e-5;
  double contact = 0.0;        // stiffness of a spring of the host along z between the first grain and the second
  double pull[3] = {0, 0, 0};  // a force of the host on the last grain, the opposite on the first
  bool condense = false;       // bonds are condensed while they are far from their threshold
  double relax = 0.0;          // damping, as a share of critical
  double stiffer = 1.0;        // stiffness of the links over kPenalty; forty adds mass to the nodes
};

// SI units. There is no Poisson's ratio, so that the cement between wide grains is springs side by side.
constexpr double kYoung = 60e9, kGap = 8e-4, kRadius = 20e-3, kOuter = 1e-3, kSpacing = 1e-4, kPenalty = 6e14, kStep = 4e-9;

inline MPI_Comm alone_or_together(bool together) { return together ? MPI_COMM_WORLD : MPI_COMM_SELF; }

class RowOfGrains : public CementHost {
 public:
  Bonds bonds;
  std::unique_ptr<Cement> cement;
  int number = 0;
  double dt = kStep;
  double work = 0.0;                          // work of prescribed grains of this rank on the cement
  std::vector<std::array<int, 2>> failed;     // step and tag of points of this rank
  std::vector<std::array<int, 2>> separated;  // step and bond, the same on all ranks

  // Data that goes into a restart file. Each rank has its own.
  struct Saved {
    std::vector<double> state;             // state of all ranks, held on all
    std::vector<double> nodes, all_nodes;  // nodes of the rank before this one; nodes of all ranks
    std::map<int, PointRecord> points;
    std::map<int, GrainState> states;
    std::vector<Grain> grains;
    int number = 0;
    double dt = kStep, time = 0.0;
  };

  RowOfGrains(MPI_Comm comm, const Row& row) : comm_(comm), row_(row) {
    start();
    for (int b = 0; b < row_.bonds; ++b) make_bond(b);
    for (int g = 0; g <= row_.bonds; ++g) {
      if (g % ranks_ != rank_) continue;
      Grain grain;
      grain.tag = 1 + g;
      grain.x[2] = grid_index_of(g, 0.0);
      grain.radius = kRadius;
      grain.mass = row_.grain_mass;
      grain.inertia = 0.4 * grain.mass * kRadius * kRadius;
      const bool free = row_.free_ends || (row_.free_middle && g > 0 && g < row_.bonds);
      for (bool& f : grain.free) f = free;
      GrainState& s = states_[grain.tag];
      std::copy(grain.x, grain.x + 3, s.x);
      s.position_known = true;
      own_.push_back(grain);
    }
    init();
  }
  RowOfGrains(MPI_Comm comm, const Row& row, const Saved& from, const std::vector<BondRecord>& table) : comm_(comm), row_(row) {
    start();
    bonds.table = table;
    for (const auto& p : from.points) slot_[p.first] = bonds.add(p.second, p.first);
    number = from.number;
    dt = from.dt;
    time_ = from.time;
    states_ = from.states;
    own_ = from.grains;
    RecordReader in(from.state.data() + 1, from.state.data() + from.state.size());
    CementHead head;
    in.read(head);
    EXPECT_GE(from.state.size(), 1 + kMostNumbers<CementHead> + numbers_after(head));
    cement->restore(head, in, from.nodes);
    EXPECT_EQ(in.trouble(), "");
    EXPECT_TRUE(in.at_end()) << "what grows with the nodes stands with the points";
    init();
  }

  std::array<double, 3> initial_velocity(int) override { return {0.0, 0.0, 0.0}; }
  void points_failed(const Bond& bond) override {
    for (int slot : bond.failed) failed.push_back({number, bond.points.tags[slot / kLanes][slot % kLanes]});
  }
  void links_debonded(const Bond&) override {}
  void slots_changed(const Bond& bond) override {
    for_points(bond, [&](int slot, int tag) { slot_[tag] = slot; });
  }

  // Start of a run.
  void setup() {
    set_step();
    cement->grains().replace(take_grains());
    cement->lay_out_run();
    clear_forces();
    cement->check_state();
    add_host_forces();
    cement->start_run();
    first_ = true;
  }
  void run(int steps) {
    for (int n = 0; n < steps; ++n) step();
  }
  void step() {
    std::vector<Grain>& grains = cement->grains().grains;
    ++number;
    time_ += dt;
    set_step();
    cement->start_step(first_);
    first_ = false;
    const bool divided = row_.substeps > 1;
    std::vector<std::array<double, 6>> before;
    for (Grain& g : grains) {
      before.push_back({});
      std::copy(g.force, g.force + 6, before.back().begin());
      half_kick(g);
      GrainState& s = *g.state;
      for (int d = 0; d < 3; ++d) g.x[d] += dt * g.velocity[d];
      if (!g.free[2]) {
        prescribe(g);
      }
      for (int d = 0; d < 3 && !divided; ++d) {
        g.moved[d] = g.x[d] - s.x[d];
        s.x[d] = g.x[d];
      }
    }
    cement->grains_moved();
    if (divided)
      for (Grain& g : grains)
        for (int d = 0; d < 3; ++d) {
          g.moved[d] = g.x[d] - g.state->x[d];
          g.state->x[d] = g.x[d];
        }
    if (hand_over_at_ == number) hand_over();
    clear_forces();
    add_host_forces();
    cement->step();
    for (std::size_t n = 0; n < grains.size(); ++n) {
      Grain& g = grains[n];
      half_kick(g);
      for (int d = 0; d < 3; ++d)
        if (!g.free[d]) work -= 0.5 * (before[n][d] + g.force[d]) * g.moved[d];
    }
    cement->end_step();
    for (int b = 0; b < row_.bonds; ++b)
      if (cement->cracks().separated(b) && !was_separated_.count(b)) {
        was_separated_.insert({b, number});
        separated.push_back({number, b});
      }
  }
  // In step `step` bond `row` goes from the rank that has it to rank `to`. With row -1 atoms are exchanged and none of them moves.
  void hand_over_at(int step, int row, int to) { std::tie(hand_over_at_, handed_, to_) = std::make_tuple(step, row, to); }

  Saved save() {
    set_step();
    cement->sync_slots();
    Saved s;
    s.state = cement->packed_state(CementHead());
    int n = static_cast<int>(s.state.size());
    MPI_Bcast(&n, 1, MPI_INT, 0, comm_);
    s.state.resize(n);
    MPI_Bcast(s.state.data(), n, MPI_DOUBLE, 0, comm_);
    std::vector<double> mine;
    for (const auto& rows : cement->packed_nodes()) mine.insert(mine.end(), rows.second.begin(), rows.second.end());
    s.nodes = from_the_rank_before(mine);
    s.all_nodes = gathered(mine);
    for (const Bond& b : bonds) for_points(b, [&](int slot, int tag) { s.points[tag] = b.points.record(slot); });
    s.states = states_;
    s.grains = cement->grains().grains;
    s.number = number;
    s.dt = dt;
    s.time = time_;
    return s;
  }

  std::vector<double> from_the_rank_before(const std::vector<double>& mine) const {
    const int next = (rank_ + 1) % ranks_, before = (rank_ + ranks_ - 1) % ranks_;
    int n = static_cast<int>(mine.size()), of_other = 0;
    MPI_Sendrecv(&n, 1, MPI_INT, next, 0, &of_other, 1, MPI_INT, before, 0, comm_, MPI_STATUS_IGNORE);
    std::vector<double> other(of_other);
    MPI_Sendrecv(mine.data(), n, MPI_DOUBLE, next, 1, other.data(), of_other, MPI_DOUBLE, before, 1, comm_, MPI_STATUS_IGNORE);
    return other;
  }
  // Numbers of all ranks, in order of the ranks.
  std::vector<double> gathered(const std::vector<double>& mine) const {
    const int n = static_cast<int>(mine.size());
    std::vector<int> count(ranks_), at(ranks_, 0);
    MPI_Allgather(&n, 1, MPI_INT, count.data(), 1, MPI_INT, comm_);
    for (int r = 1; r < ranks_; ++r) at[r] = at[r - 1] + count[r - 1];
    std::vector<double> all(at.back() + count.back());
    MPI_Allgatherv(mine.data(), n, MPI_DOUBLE, all.data(), count.data(), at.data(), MPI_DOUBLE, comm_);
    return all;
  }
  double sum(double mine) const {
    double all = 0.0;
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, comm_);
    return all;
  }
  // Calls f(slot, tag) for every point of a bond.
  template <class F>
  static void for_points(const Bond& bond, F f) {
    for (std::size_t b = 0; b < bond.points.meta.size(); ++b)
      for (int l = 0; l < kLanes; ++l)
        if (bond.points.meta[b].occupied >> l & 1) f(kLanes * static_cast<int>(b) + l, bond.points.tags[b][l]);
  }
  // Failures of points on all ranks, ascending by step and tag.
  std::vector<std::array<int, 2>> all_failed() const {
    std::vector<double> mine;
    for (const auto& f : failed) mine.insert(mine.end(), f.begin(), f.end());
    const std::vector<double> all = gathered(mine);
    std::vector<std::array<int, 2>> events;
    for (std::size_t i = 0; i < all.size(); i += 2) events.push_back({static_cast<int>(all[i]), static_cast<int>(all[i + 1])});
    std::sort(events.begin(), events.end());
    return events;
  }
  // All that the state says on all ranks. The key is the tag of a point, or minus the tag of a grain.
  std::map<int, std::vector<double>> content() {
    cement->sync_slots();
    std::vector<double> mine;
    const auto add = [&](int tag, const std::vector<double>& numbers) {
      mine.push_back(tag);
      mine.push_back(static_cast<double>(numbers.size()));
      mine.insert(mine.end(), numbers.begin(), numbers.end());
    };
    for (const Bond& b : bonds)
      for_points(b, [&](int slot, int tag) {
        const PointRecord r = b.points.record(slot);
        std::vector<double> numbers(numbers_of(r));
        pack(r, numbers.data());
        add(tag, numbers);
      });
    for (const Grain& g : cement->grains().grains) {
      std::vector<double> numbers(g.x, g.x + 3);
      numbers.insert(numbers.end(), g.velocity, g.velocity + 6);
      numbers.insert(numbers.end(), g.force, g.force + 6);
      add(-g.tag, numbers);
    }
    const std::vector<double> all = gathered(mine);
    std::map<int, std::vector<double>> content;
    for (auto at = all.begin(); at != all.end(); at += 2 + static_cast<long>(at[1]))
      EXPECT_TRUE(content.emplace(static_cast<int>(at[0]), std::vector<double>(at + 2, at + 2 + static_cast<long>(at[1]))).second);
    return content;
  }
  // Half of the difference of the forces on the grains of a bond along z. All ranks know it.
  double tension(int row) { return cement->report().bond_states()[row].tension; }
  int points_here() const {
    int n = 0;
    for (const Bond& b : bonds) n += b.points.size();
    return n;
  }
  // Distance by which the second grain has moved away from the first along z.
  double contact_stretch() const {
    double z[2] = {0.0, 0.0};
    for (const Grain& g : cement->grains().grains)
      if (g.tag <= 2) z[g.tag - 1] = g.x[2];
    MPI_Allreduce(MPI_IN_PLACE, z, 2, MPI_DOUBLE, MPI_SUM, comm_);
    return z[1] - z[0] - 2 * kRadius - kGap;
  }
  // Energy of the spring of the host.
  double contact_energy() const {
    const double way = contact_stretch();
    return 0.5 * row_.contact * way * way;
  }
  // Distance by which the last grain has moved away from the first along z.
  double stretch() const { return grid_index_of(row_.bonds, time_) - grid_index_of(0, time_) - row_.bonds * (2 * kRadius + kGap); }

 private:
  void start() {
    MPI_Comm_rank(comm_, &rank_);
    MPI_Comm_size(comm_, &ranks_);
    DamageParameters p;
    p.B0 = row_.B0;
    p.exponent = row_.exponent;
    p.interface = row_.interface;
    CementOptions o;
    o.cell = 2 * kSpacing;
    o.axis = AxisRule::global;
    o.updated = row_.updated;
    o.tied = !row_.updated;
    o.check_every = 20;
    o.subcycle = row_.substeps;
    o.split = row_.split;
    o.unilateral = row_.unilateral;
    o.condense = row_.condense;
    o.relative_damping = row_.relax;
    o.length = row_.length;
    o.mass_order = row_.mass_order;
    o.advance.nonlocal = row_.length > 0.0;
    o.imperfection = o.advance.nonlocal ? 0.05 : 0.0;
    const VtiElasticity elasticity(VtiConstants::isotropic(kYoung, 0.0));
    std::unique_ptr<Law> law;
    if (row_.B0 > 0.0) law = std::make_unique<TensorDamage>(elasticity, p);
    else law = std::make_unique<NoDamage>(elasticity);
    law->set_nonlocal(row_.length, 0.0);
    cement = std::make_unique<Cement>(comm_, bonds, o, std::move(law), *this);
  }
  void init() {
    set_step();
    PenaltyParameters p;
    p.law = std::make_shared<PenaltyTraction>(TractionStiffness{row_.stiffer * kPenalty, row_.stiffer * kPenalty});
    p.friction = row_.friction;
    cement->set_density(2710);
    cement->couple(nullptr);
    cement->couple(&p);
    cement->grains().replace(take_grains());
  }
  void set_step() {
    StepInput now;
    now.number = number;
    now.substeps = row_.substeps;
    now.dt = dt / row_.substeps;
    cement->set_step(now);
  }
  std::vector<Grain> take_grains() {
    std::vector<Grain> now = own_.empty() ? cement->grains().grains : std::move(own_);
    own_.clear();
    for (Grain& g : now) {
      Grain fresh;  // holds what LIGGGHTS and GrainState keep, and nothing else
      fresh.tag = g.tag;
      std::copy(g.x, g.x + 3, fresh.x);
      std::copy(g.velocity, g.velocity + 6, fresh.velocity);
      std::copy(g.force, g.force + 6, fresh.force);
      std::copy(g.free, g.free + 6, fresh.free);
      std::copy(g.moved, g.moved + 3, fresh.moved);
      fresh.mass = g.mass;
      fresh.inertia = g.inertia;
      fresh.radius = g.radius;
      fresh.state = &states_.at(g.tag);
      g = fresh;
    }
    return now;
  }
  void clear_forces() {
    for (Grain& g : cement->grains().grains) std::fill(g.force, g.force + 6, 0.0);
  }
  void add_host_forces() {
    const double force = row_.contact * contact_stretch();
    for (Grain& g : cement->grains().grains) {
      if (g.tag <= 2 && row_.contact > 0.0) g.force[2] += g.tag == 1 ? force : -force;
      for (int d = 0; d < 3; ++d) g.force[d] += g.tag == 1 ? -row_.pull[d] : g.tag == 1 + row_.bonds ? row_.pull[d] : 0.0;
    }
  }
  void half_kick(Grain& g) const {
    for (int d = 0; d < 6; ++d)
      if (g.free[d]) g.velocity[d] += 0.5 * dt * g.force[d] / (d < 3 ? g.mass : g.inertia);
  }
  void prescribe(Grain& g) const {
    if (!row_.path) {
      g.x[2] = grid_index_of(g.tag - 1, time_);
      g.velocity[2] = velocity_of(g.tag - 1, time_);
    } else if (g.tag - 1 == row_.bonds) {
      const Way w = row_.path(time_);
      for (int d = 0; d < 3; ++d) {
        g.x[d] = (d == 2 ? row_.bonds * (2 * kRadius + kGap) : 0.0) + w.way[d];
        g.velocity[d] = w.velocity[d];
      }
    }
  }
  // The first grain and the last leave each other to either side. The others stay where they are.
  double share_of(int g) const { return g == 0 ? -0.5 : g == row_.bonds ? 0.5 : 0.0; }
  double grid_index_of(int g, double t) const {
    if (row_.path) return g * (2 * kRadius + kGap);
    const double way = t < row_.ramp ? 0.5 * row_.speed * t * t / row_.ramp : row_.speed * (t - 0.5 * row_.ramp);
    return g * (2 * kRadius + kGap) + share_of(g) * way;
  }
  double velocity_of(int g, double t) const { return share_of(g) * row_.speed * std::min(1.0, t / row_.ramp); }

  void make_bond(int row) {
    const Flat shape(GrainPair{kRadius, kRadius, kGap, Vector3(0, 0, 1)}, kOuter, 0.0);
    const std::vector<FillPoint> fill = fill_with_points(shape, kSpacing);
    BondRecord record;
    for (int s = 0; s < 2; ++s) {
      record.grain[s] = 1 + row + s;
      record.radius[s] = kRadius;
      const Vector3 centre = shape.pair().centre(s);
      std::copy(centre.data(), centre.data() + 3, record.centre[s]);
      record.attached_area[s] = shape.attached_area(s);
    }
    record.origin[2] = grid_index_of(row, 0.0) + kRadius + 0.5 * kGap;
    record.volume = shape.volume();
    record.spacing = kSpacing;
    record.thickness = shape.largest_thickness();
    record.points = static_cast<int>(fill.size());
    bonds.table.push_back(record);
    for (std::size_t n = 0; n < fill.size(); ++n) {
      const FillPoint& p = fill[n];
      const int slice = static_cast<int>((p.X[0] / kOuter + 1.0) / 2.0 * ranks_);
      if ((row_.whole_bonds ? row % ranks_ : std::max(0, std::min(ranks_ - 1, slice))) != rank_) continue;
      PointRecord r;
      r.row = row;
      std::copy(p.X.data(), p.X.data() + 3, r.X);
      r.volume = p.volume;
      r.failed = p.X[2] > -kSpacing * (row_.cracked / 2) && p.X[2] < kSpacing * ((row_.cracked + 1) / 2);
      const bool crumbled = row_.crumbled != 0.0 && p.X[0] > row_.crumbled;
      r.failed = r.failed || crumbled;
      if (r.failed) r.damage[2] = 0.9;  // along z
      r.links = p.link_count;
      for (int k = 0; k < p.link_count; ++k) {
        r.link[k].grain = record.grain[p.link[k].side];
        std::copy(p.link[k].foot.data(), p.link[k].foot.data() + 3, r.link[k].foot);
        r.link[k].area = p.link[k].area;
        const bool loose = row_.loose && p.link[k].side == 0;
        r.link[k].attached = !loose && !crumbled;
        r.failed = r.failed || (loose && row_.skin_failed);
      }
      const int tag = 1000 + row * 100000 + static_cast<int>(n);
      slot_[tag] = bonds.add(r, tag);
    }
  }
  // Hands a bond over as an exchange of atoms does: points leave one by one and come in an order of their own.
  void hand_over() {
    cement->sync_slots();
    std::vector<double> mine;
    if (Bond* b = bonds.find(handed_)) {
      std::map<int, PointRecord> leaving;
      for_points(*b, [&](int slot, int tag) { leaving[tag] = b->points.record(slot); });
      for (auto p = leaving.rbegin(); p != leaving.rend(); ++p) {
        mine.push_back(p->first);
        mine.resize(mine.size() + numbers_of(p->second));
        pack(p->second, &mine[mine.size() - numbers_of(p->second)]);
        b->points.release(slot_.at(p->first));
        slot_.erase(p->first);
      }
    }
    const std::vector<double> all = gathered(mine);
    if (rank_ == to_)
      for (const double* at = all.data(); at != all.data() + all.size();) {
        const int tag = static_cast<int>(*at++);
        PointRecord r;
        at = unpack(at, r);
        slot_[tag] = bonds.add(r, tag);
      }
    cement->grains().replace(take_grains());
    cement->lay_out_exchanged();
  }

  MPI_Comm comm_;
  Row row_;
  int rank_ = 0, ranks_ = 1;
  bool first_ = true;
  double time_ = 0.0;
  int hand_over_at_ = -1, handed_ = 0, to_ = 0;
  std::map<int, int> slot_;  // slot of each point of this rank, by tag
  std::map<int, int> was_separated_;
  std::map<int, GrainState> states_;
  std::vector<Grain> own_;  // grains of this rank until the engine has them
};

// Compares two results of content() bit by bit.
inline void expect_same_bits(const std::map<int, std::vector<double>>& a, const std::map<int, std::vector<double>>& b) {
  ASSERT_EQ(a.size(), b.size());
  int different = 0, first = 0;
  for (auto i = a.begin(), j = b.begin(); i != a.end(); ++i, ++j) {
    ASSERT_EQ(i->first, j->first);
    const bool same =
        i->second.size() == j->second.size() && std::memcmp(i->second.data(), j->second.data(), i->second.size() * sizeof(double)) == 0;
    if (!same && different++ == 0) first = i->first;
  }
  EXPECT_EQ(different, 0) << "of " << a.size() << " points and grains, the first is " << first;
}

// `whole` runs to step `at`. Its state is saved and read back. Both go on by `steps` steps of length dt.
// They fail the same points and end bitwise identical. `then(again)` compares further.
template <class Then>
void expect_restart_to_the_bit(RowOfGrains& whole, const Row& row, int at, int steps, double dt, Then then) {
  whole.run(at - whole.number);
  const RowOfGrains::Saved saved = whole.save();
  RowOfGrains again(MPI_COMM_WORLD, row, saved, whole.bonds.table);
  whole.dt = again.dt = dt;
  again.setup();
  whole.setup();
  whole.failed.clear();
  whole.run(steps);
  again.run(steps);
  EXPECT_EQ(again.all_failed(), whole.all_failed());
  expect_same_bits(whole.content(), again.content());
  then(again);
}

}  // namespace mpdem::test

#endif
