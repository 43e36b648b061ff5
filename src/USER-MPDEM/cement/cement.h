// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The cement of a scene: bonds, their layout, time stepping, books of energy and cracks. It knows no host program: a host
// gives it grains and steps, and takes loads, velocities and reports, all in the axes of the box. doc/architecture.md has the step as a recipe.
//
// State after step n: u_n, v_n-1/2 and a_n at the nodes; F_n, strain and damage at the points. Consistent units.
// Functions are collective. Bad states are thrown, see parallel/agree.h.
#ifndef MPDEM_CEMENT_H
#define MPDEM_CEMENT_H

#include <mpi.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "../material/law.h"
#include "../mpm/largest_eigenvalue.h"
#include "../parallel/halo_sum.h"
#include "bond.h"
#include "bond_table.h"
#include "bonded_grains.h"
#include "cement_restart.h"
#include "condensed_bonds.h"
#include "cracks.h"
#include "energy_books.h"
#include "layout.h"
#include "load_watch.h"
#include "options.h"
#include "sheets.h"
#include "static_bond.h"
#include "step_timer.h"

namespace mpdem {

// What the engine asks of its host, seldom.
class CementHost {
 public:
  virtual ~CementHost() = default;
  // Velocity of a point of this rank that has not moved yet, by its tag.
  virtual std::array<double, 3> initial_velocity(int tag) = 0;
  // Points of a bond failed in this step, Bond::failed; before they get other slots.
  virtual void points_failed(const Bond& bond) = 0;
  // Links of a bond let go of points that did not fail, Bond::link_step.
  virtual void links_let_go(const Bond& bond) = 0;
  // Slots of points of a bond changed.
  virtual void slots_changed(const Bond& bond) = 0;
  // All forces of a step are on the nodes, those of tied nodes on their masters: adds forces from outside, which the books of energy do not
  // know, or holds nodes. Ranks that share a node do the same to it.
  virtual void add_node_forces(Bond&) {}
};

// When, and what acts everywhere.
struct StepInput {
  std::int64_t number = 0;  // of this step
  double dt = 0;            // with sub-steps: of one of them
  int substeps = 1;         // that the cement takes in a step of the host
  double gravity[3] = {0, 0, 0};
};

// The same on all ranks. Places are in the coordinates of the box, maybe beyond a periodic side.
struct StiffnessOfBond {
  double middle[3], axis[3];
  double K[36];     // 6 by 6, see static_bond.h
  double products;  // with the operator that it took; 0: that of an equal bond was taken
};

class Kinematics;

class Cement {
 public:
  Cement(MPI_Comm comm, Bonds& bonds, const CementOptions& options, std::shared_ptr<const Law> law, CementHost& host);
  ~Cement();

  const CementOptions& options() const { return options_; }
  const Law& law() const { return *law_; }
  Bonds& bonds() { return bonds_; }
  BondedGrains& grains() { return grains_; }
  const Cracks& cracks() const { return cracks_; }
  const EnergyBooks& books() const { return books_; }
  StepTimer& timer() { return timer_; }
  // Before each of the functions below.
  void set_step(const StepInput& now) { now_ = now; }
  void set_density(double density);  // of the calcite
  void set_most_bytes(double bytes) { options_.most_bytes = bytes; }
  double density() const { return inertia_ / options_.mass_scale; }
  double inertia() const { return inertia_; }  // density with the mass scale
  // The links, or none.
  void couple(const PenaltyParameters* penalty);
  const std::optional<PenaltyParameters>& penalty() const { return penalty_; }
  bool keeps_skins() const { return penalty_ && penalty_->law->keeps_skins(); }
  bool built() const { return layout_.built; }
  int bodies_started() const { return bodies_started_; }
  double dt_last() const { return dt_last_; }
  double dt() const { return now_.dt; }  // of the cement
  int substeps() const { return now_.substeps; }

  // Points that are new have their damage as a tensor, those of a restart file as the state of a law: makes all of them states of this
  // one. Throws BadState if it cannot go on from them.
  void take_up_states();

  // Bonds may be without points (mpm/point_pattern.h) while they are condensed by fields that bonds of their pattern share: where nodes do not split
  // and frames do not go by axes of the box.
  bool may_leave_points_out() const { return options_.condense && !options_.split && options_.axis != AxisRule::global; }
  // The host made the points of these rows of the table; their layout follows.
  void points_were_made(const std::vector<int>& rows) {
    arrivals_.fresh_points.insert(arrivals_.fresh_points.end(), rows.begin(), rows.end());
    arrivals_.rows_that_want_points.clear();
  }
  // Rows of bonds that ask for their points before the next step, the same on all ranks. They wake in it.
  const std::vector<int>& rows_that_want_points() const { return arrivals_.rows_that_want_points; }

  // Layout. Of all bonds, at the start of a run, or of those whose points or grains went to other ranks.
  void lay_out_run();
  void lay_out_exchanged();
  void refresh_added_mass();  // for another time step
  // Slots of points, which fall behind while points change cells.
  void sync_slots();

  // Largest stable time step in the present state, from the largest eigenvalue of the cement and the stiffness that the
  // links give to free grains; that of a layout yet to be made; that of a known eigenvalue.
  double stable_step();
  EigenvalueEstimate eigenvalue_of_new_layout();
  EigenvalueEstimate eigenvalue();
  double step_for(double eigenvalue, double relax);
  // Collective, needs links. Largest step with which grains on massless bonds of the present static stiffness would be stable.
  double grains_step();
  // What the damping of `quasistatic` takes of the step, and the damping that takes a tenth at most.
  struct DampedStep {
    double step, undamped, admitted;
  };
  DampedStep damped_step(double eigenvalue);
  // The bound will do for steps below it; the eigenvalue itself costs some passes.
  double limiting_eigenvalue(double dt);
  bool eigenvalue_is_known() const { return layout_.eigenvalue > 0.0; }
  double largest_mass_ratio();  // of grains that follow forces

  // A run: start, then steps, each with its end.
  void take_up_commands();  // before the first step
  void start_run();
  // With sub-steps, see substeps.cpp: before the host moves its grains, when it has their velocities and loads of the end of the last step; and after
  // it has moved them. The cement takes all sub-steps but the last. Where free grains arrive, and the velocities with which they do, are left with
  // the grains for the host to take over.
  void begin_substeps();
  void take_substeps();
  // A step, or the last of the sub-steps of one.
  void step();
  void end_step();
  // Throws if any node is not finite or a bonded grain is gone.
  void check_state();

  CementTotals totals(double reach_of_box);
  const std::vector<BondState>& bond_states();
  // As above, but columns that need points (needs_points()) are 0. Cheap enough for every step.
  const std::vector<BondState>& bond_loads();
  // Static stiffness of each bond as it is now, its grains too, by a layout of its own; a run need not have begun. Equal bonds of a rank are
  // solved once. Needs links.
  std::vector<StiffnessOfBond> stiffness_of_bonds();
  std::vector<Cracks::Ahead> cracks_ahead(const std::vector<int>& rows);
  // Added mass: at either side of each bond, over all ranks.
  std::vector<double> added_mass_of_sides();
  double cement_mass();    // of this rank, with the mass scale
  // Displacement and velocity of the points of a bond at the present time, in the axes of its body.
  struct PointMotionNow {
    vd u[3], v[3];
  };
  void motion_of_points(const Bond& bond, std::vector<PointMotionNow>& motion) const;
  // Strain of the points of condensed bonds, for who looks at points.
  void show_condensed_points();
  int awake_bonds() const;  // of all ranks
  int bonds_solved() const { return condensed_.solved_last(); }  // at the last layout, by this rank
  PassTicks ticks() const { return advance_.ticks; }
  void clear_ticks() { advance_.ticks = PassTicks(); }
  std::size_t memory_usage() const { return bonds_.memory_usage(); }

  // Restart. Numbers of all ranks, complete on rank 0; the head has what the host keeps. The same numbers come back on every rank,
  // the head as it was read. Throws BadState if it is that of other options.
  std::vector<double> packed_state(CementHead head);
  // The motion of the nodes of this rank, rows of each bond (NodeRow) one after the other.
  std::map<int, std::vector<double>> packed_nodes() const;
  // nodes: packed, any of those of all ranks on any rank.
  void restore(const CementHead& head, RecordReader& in, const std::vector<double>& nodes);
  bool restored() const { return arrivals_.restored; }

 private:
  friend class Kinematics;
  friend class Total;
  friend class Updated;

  void lay_out(const std::vector<int>& rows, NewPartsOfBonds parts, bool arrange = true, bool splits = false);
  void lay_out_again(const std::vector<int>& rows, NewPartsOfBonds parts = {}, bool arrange = true, bool splits = false);
  void adopt(std::vector<BondLayout>& layouts);
  void start_anew(Bond& b);
  void find_relaxation(Bond& b);
  LayoutRules rules();
  NewPartsOfBonds parts_at_start(Splits& splits, Sheets& sheets) const;
  std::vector<BondLayout> layouts_of_copies(const PenaltyParameters* penalty);
  // Can points fail, or links let go?
  bool can_break() const { return penalty_ && !(law_->inert() && penalty_->law->fields() == 0); }
  // Do places that let go still touch?
  bool touches() const { return penalty_ && penalty_->friction >= 0.0; }
  bool faces_touch() const { return touches() && options_.split; }
  LayoutRequest request_of(Bond& b, NewPartsOfBonds& parts);
  std::vector<int> all_rows() const;
  std::vector<int> agreed_rows(const std::vector<int>& mine) const;
  void bind_grains();
  void refresh_added_mass(const std::vector<int>& rows);
  void drop_inert_added_mass();
  void sort_links(Bond& b);
  void lay_out_parts(Cracks::Found found);
  void choose_condensed();
  NewPartsOfBonds parts_of_fresh_points();
  std::vector<int> patterns_of_owned_grains() const;
  std::vector<CondensedBonds::OfPattern> layouts_of_patterns(const std::vector<int>& patterns, const PenaltyParameters* penalty) const;
  std::vector<CondensedBonds::OfPattern> layouts_at_creation(Bonds& alone, const PenaltyParameters* penalty) const;
  std::vector<int> ask_for_points(const std::vector<int>& rows);
  void bind_shared_nodes();
  std::array<double, 3> weight_of_cement() const;
  void condense(const std::vector<int>& rows, bool at_start);
  void take_patterns(bool at_start);
  void remember_axis();
  void check_restored(const CementHead& head) const;
  void bring_restored_nodes();
  void take_restored_nodes(std::vector<NodeRow> rows);
  using Patches = std::map<int, std::vector<int>>;  // of rows: blocks
  void check_step_after(const std::vector<int>& rows, const char* event, const Patches* patches = nullptr);
  double added_energy_ahead(const std::vector<int>& rows, double later);
  double limiting_eigenvalue(double dt, const std::vector<int>& rows, const Patches* patches = nullptr);
  EigenvalueEstimate eigenvalue_of(const std::vector<int>& rows, const Patches* patches = nullptr);
  void start_velocities(std::vector<BondLayout>& layouts);
  std::vector<double> motion_of(const std::vector<int>& rows) const;
  void keep_motion(const std::vector<int>& rows, const std::vector<double>& before);
  void start_bodies();
  double eigenvalue_bound() const;
  double relaxation_rate(double share);
  double shear_speed() const;

  // Is this the first, or the last, of the sub-steps of a step of the host?
  bool begins_step() const { return substep_ == 1; }
  bool ends_step() const { return substep_ == now_.substeps; }
  void react();
  void advance();
  // Of a grain in a step of the host.
  struct Way {
    double from[3], length[3], start[6], end[6];  // the latter are velocities
    // At the share t of the time of the step.
    double place(int d, double time, double t) const;
    double velocity(int d, double time, double t) const;
  };
  void move_grains(const std::vector<Way>& ways);
  void share_impulses();
  // phases of a step
  static constexpr int kWatchEvery = 5;  // steps between looks at bonds that may have come apart
  void look_for_cracks();
  void average_drives();
  std::vector<Bond*> cut_bonds_near_threshold();
  Cracks::Found look_at_bonds(bool debris);
  void split_nodes();
  void part_bonds(const std::vector<int>& rows, NewPartsOfBonds parts);
  std::vector<int> part_nodes(Bond& b, const NewParts& parts);
  void drop_inert_links(Bond& b);
  void take_failed(Bond& b);
  void let_go(Bond& b);
  void follow_links(Bond& b);
  void open_places(Bond& b, const std::vector<int>& failed, const std::vector<int>& links);
  void open_places_of_files();
  std::vector<int> move_places();
  void refresh_for_places(const std::vector<int>& moved);
  void add_link_forces(Bond& b);
  void sum_shared(double* (*values)(Grid&), int width);
  void begin_completing();
  void complete_early(Bond& b);
  void complete_forces(Bond& b, double kick);
  void complete_forces();
  void find_grain_accelerations();
  void add_inertial_forces();
  void wake_bonds();
  void condense_again();
  double energy_of(const Bond& b) const;
  EnergyBooks::StepWork step_work(const Power& power) const;
  Power damping_power(int first_body) const;
  Power rubbing_power() const;
  EnergyBooks::StepWork work_of_step(int first_body);
  EnergyBooks::StepWork inertial_work_of_step(int first_body) const;
  double kinetic_energy(const Bond& b, double kick) const;
  std::array<double, 3> gravity_of(const Bond& b) const;  // in the axes of its body
  double gravity_power(const Bond& b, const std::vector<double>& velocity) const;
  double half_kick(const Bond& b, const std::vector<double>& jump) const;

  MPI_Comm comm_;
  Bonds& bonds_;
  CementOptions options_;
  std::shared_ptr<const Law> law_;
  CementHost& host_;
  std::unique_ptr<Kinematics> kinematics_;
  BondedGrains grains_;
  EnergyBooks books_;
  Sheets sheets_;
  Cracks cracks_;
  LoadWatch load_watch_;
  Splits splits_;
  CondensedBonds condensed_;
  StepTimer timer_;
  AdvanceResult advance_;  // of the bond at work
  // What is known of the present layout of all bonds.
  struct {
    bool built = false;
    bool completes_early = false;  // forces of bonds that ranks do not cut are complete when those of their links are
    bool any_added_mass = false, any_bond_is_cut = false;  // of any rank
    double eigenvalue = 0.0;  // the largest, 0: not yet found
    HaloSums shared_nodes;
    AlikeLists alike;  // what bonds hold together
  } layout_;
  // What waits for the next layout.
  struct {
    bool restored = false;  // the state is that of a restart file
    std::vector<NodeKinematics> restored_nodes;  // by row of the table
    std::vector<NodeRow> rows_of_nodes;          // of a file, as the ranks read them, until the first layout
    double nodes = -1.0;                         // of all ranks among these; below 0: there are none to come
    std::vector<int> fresh_points, rows_that_want_points;
  } arrivals_;
  std::vector<BondState> states_;
  std::optional<PenaltyParameters> penalty_;
  StepInput now_;
  int substep_ = 1;  // counted from 1
  double inertia_ = 0.0, dt_last_ = 0.0;  // dt_last_: length of the last step; stored velocities belong to its middle
  int bodies_started_ = 0;                // number of rows at the head of the table that have moved; later rows are where they were made
};

}  // namespace mpdem

#endif
