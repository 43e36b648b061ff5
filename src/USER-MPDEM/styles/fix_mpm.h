// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// fix mpm: the cement as a continuum on a background grid. See doc/fix_mpm.md for the
// words and the output; the step itself is FixMpm::post_force. Grains are moved by
// LIGGGHTS' own fixes, the points by this one.
#ifdef FIX_CLASS

FixStyle(mpm,FixMpm)

#else

#ifndef MPDEM_FIX_MPM_H
#define MPDEM_FIX_MPM_H

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "../coupling/grain_accelerations.h"
#include "../coupling/grain_sides.h"
#include "../coupling/penalty_links.h"
#include "../coupling/relaxation.h"
#include "../coupling/resting_links.h"
#include "../fracture/crevice.h"
#include "../fracture/separation.h"
#include "../geometry/shape.h"
#include "../material/laws.h"
#include "../mpm/advance_updated.h"
#include "../mpm/grid.h"
#include "../mpm/point_state.h"
#include "../mpm/resting.h"
#include "atom_vec_mpdem.h"
#include "fix.h"
#include "prescribed_motion.h"
#include "step_timer.h"
#include "table_file.h"

namespace mpdem {
class Arguments;
}

namespace mpdem {
class CheckedNumbers;
}

namespace LAMMPS_NS {

class FixMpm : public Fix {
 public:
  FixMpm(LAMMPS* lmp, int narg, char** arg);
  ~FixMpm() override;

  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void setup_pre_neighbor() override;
  void setup(int vflag) override;
  void pre_initial_integrate() override;
  void post_integrate() override;
  void pre_exchange() override;
  void pre_neighbor() override;
  void post_force(int vflag) override;
  void end_of_step() override;
  void post_run() override;
  void reset_dt() override;

  void write_restart(FILE* fp) override;
  void restart(char* buf) override;
  double compute_scalar() override;
  double compute_vector(int n) override;
  double memory_usage() override;

  // Is its state that of a restart file?
  bool continued() const { return restored_cell_ != 0.0; }
  // Has some cement made a step, in this run, one before or that of a restart file?
  bool in_motion() const;
  // File of the events, or empty.
  const std::string& events_name() const { return events_name_; }

  // Sums over all ranks at the present step; collective.
  struct Totals {
    double points, failed, largest_damage, mean_damage;
    double kinetic, elastic, coupling, dissipated, released, damped, external_work, imbalance;
    double momentum[3], angular_momentum[3];
    double separated, debonding, internal, mixed;  // bonds
  };
  const Totals& totals();

  // One row a body; collective.
  struct BondState {
    double force[2][3], torque[2][3], gap, tension;
    double peak;  // largest tension at the steps asked for so far
    double points, attached, debonded, failed, largest_damage, mean_damage;
    double separated, share[2];  // of the separating surface at either grain
  };
  const std::vector<BondState>& bonds();

  // `intact`, `debonding`, `internal` or `mixed`, and what it was found from.
  std::string failure_mode(int body) const;
  const mpdem::Separation& separation(int body) const { return separation_[body]; }

  // What fix mpm/couple hands over; one coupling at most.
  void set_coupling(const Fix* coupling, const mpdem::PenaltyParameters& p);

  const mpdem::Law& law() const { return *law_; }
  double cell() const { return cell_; }
  AtomVecMpdem* cement() const { return avec_; }
  // Slots of the atoms, which fall behind while points change cells; before they are read.
  void sync_slots();
  mpdem::Basis basis() const { return basis_; }
  // Brings LIGGGHTS' positions, velocities and slots of the points up to date.
  void fill_atoms();

  // Collective. Largest stable time step in the present state, from the largest eigenvalue of
  // the cement and the stiffness that the links give to free grains.
  double stable_step();

 private:
  void restore_nodes(std::size_t n, mpdem::CheckedNumbers& in);
  void parse(int narg, char** arg);
  void parse_transfer(mpdem::Arguments& args);
  void parse_skip(mpdem::Arguments& args);
  void check_words(mpdem::Arguments& args);
  void check_scene();
  void check_cell() const;
  bool coupling_follows();
  void remember_coupling();
  void check_initial_damage();
  void check_created_positions();
  void check_box() const;
  std::string changed_box() const;
  void check_grains_stayed();
  std::string changed_radius(int i, double made_for) const;
  void follow_grains();
  void report_grain_trouble(bool output_due);
  void find_other_forces();
  // changed: of each body, since the last layout, points staying where they were; empty: anything may have.
  void rebuild(const std::vector<char>& changed = {});
  void rebuild_parts();
  void lay_out_grid(const std::vector<char>& changed = {});
  void build_grid(mpdem::Grid& grid, const mpdem::PointStore& points, const std::vector<mpdem::Grid::Cell>& cells,
                  const mpdem::NodeKinematics& restored, std::vector<char>& fresh, int margin,
                  const std::vector<char>& changed = {});
  std::vector<mpdem::EdgeTie> find_ties(const mpdem::Grid& grid, const std::vector<char>& changed);
  std::vector<char> changed_bodies() const;
  void divide_bodies(int first);
  mpdem::SheetPoint sheet_point(int block, int lane) const;
  mpdem::JoinedNodes joined_nodes(int body) const;
  int part_of_slot(int slot) const;
  std::vector<char> sheets_at(const std::vector<mpdem::Key>& keys);
  std::vector<int> bodies_to_untie();
  std::vector<double> motion_of_bodies() const;
  void keep_motion_of_bodies(const std::vector<int>& bodies, const std::vector<double>& before);
  std::string flight(int i) const;
  void watch_for_grains_that_leave();
  void find_owned_grains();
  void find_bonded_grains();
  void find_grain_accelerations();
  void watch_late_forces(bool after);
  void refresh_added_mass();
  void drop_added_mass();
  void take_up_added_mass(bool drop_inert);
  void set_frames(mpdem::PointStore& points) const;
  std::string axis_name(int rule, const double* direction) const;
  void check_axis() const;
  void remember_axis();
  void start_bodies();
  struct StepWork {
    double now, before;
  };
  StepWork work_of_step(int first_body = 0) const;
  void start_velocities(const std::vector<char>& fresh);
  void step_total(double dt);
  void step_updated(double dt);
  void reproject();
  bool distorted();
  void take_new_reference();
  void move_links();
  void sort_links();
  double half_kick_of_jump(const std::vector<double>& jump) const;
  double gravity_power(const std::vector<double>& velocity) const;
  double damping_work(double later, int first_body = 0) const;
  double kinetic_energy(double kick) const;  // of this rank's nodes, at the half step, after kick times a
  void distribute_grains();
  void find_rates();
  bool follows_forces(std::size_t n, int d) const;
  double& velocity_of(int i, int d) const;
  void follow_jumps();
  void react_to_jumps();
  void exchange_momentum(const std::vector<std::array<double, 6>>& jump, int first_body, bool at_start);
  void start_added_mass();
  void expect_gravity(int i);
  void go_back_half_a_step();
  void find_limit_of_jumps();
  void keep_velocities();
  void watch_jump(std::size_t n);
  void report_jump();
  void add_forces(bool in_step = true);
  void react_on_grains();
  bool separate_bodies(bool debris);
  void watch_paths();
  bool some_path_is_cut();
  struct WholeBodies;
  WholeBodies collect_bodies(const std::vector<char>& wanted);
  mpdem::Separation look_at(int body, const std::vector<mpdem::CrackPoint>& points) const;
  struct CrackAhead {
    double left = 0.0, whole = 0.0;  // points of the ligament, and of that of the unbroken bond
    mpdem::Separation surface;       // if the ligament failed
  };
  std::vector<CrackAhead> cracks_ahead(const std::vector<char>& wanted);
  void count_modes(Totals& t) const;
  void report_modes();
  void report_sum_of_modes(int lines);
  void record_events();
  void write_events();
  void count_points();
  void check_state();
  std::string grain_that_is_not_finite() const;
  void report_parameters();
  void report_added_mass();
  double eigenvalue_bound() const;
  double stability_bound() const;
  std::map<int, double> inertia_of_cement() const;
  double mass_ratio(int i, const mpdem::PrescribedMotion& p, double inertia) const;
  double shear_speed() const;
  double largest_mass_ratio() const;
  double relaxation_rate(double share) const;
  double step_for(double eigenvalue, double relax) const;
  struct DampedStep {
    double step, undamped, admitted;
  };
  DampedStep damped_step(double eigenvalue) const;
  void tell_of_damping();
  void warn_of_parameters() const;
  double limiting_eigenvalue(double dt);
  void check_step_after(const char* event);
  void set_time_step(const Fix* running);
  void report_times();

  // words of the script
  double cell_ = 0.0;
  enum { kRadial = 1, kBond, kGlobal } axis_ = kRadial;  // values are in restart files
  static_assert(kGlobal == mpdem::kAxisRules);
  double axis_direction_[3] = {0, 0, 1};
  double fracture_energy_ = 0.0;  // of the crack band, 0: no regularization
  int check_every_ = 100;
  static constexpr int kWatchEvery = 5;  // steps between looks at bonds that may have come apart
  mpdem::Basis basis_ = mpdem::Basis::quadratic;
  bool updated_ = false;
  bool tied_ = true;  // nodes at the edge of the cement, see mpm/edge_ties.h
  bool tied_given_ = false;
  mpdem::Transfer transfer_;
  bool transfer_given_ = false;
  int reproject_every_ = 0;
  double reproject_distortion_ = 0.0;  // 0: not `auto`
  mpdem::AdvanceOptions skip_;
  bool skip_detached_ = true;
  double step_fraction_ = 0.0;  // of the limit, 0: the script sets the time step
  double mass_scale_ = 1.0, relax_ = 0.0;  // quasistatic
  std::shared_ptr<const mpdem::Law> law_;
  mpdem::VtiConstants constants_;
  bool coupled_ = false;
  std::string coupling_id_;
  mpdem::PenaltyParameters penalty_;
  // Of the steps so far; part of restart files.
  struct CouplingOfSteps {
    enum { kNoSteps, kLinks, kNone } coupling = kNoSteps;
    double kn = 0.0, kt = 0.0;
    bool at_surface = true;
  } ran_;
  bool warned_of_no_coupling_ = false;

  AtomVecMpdem* avec_ = nullptr;
  mpdem::Grid grid_;
  mpdem::PenaltyLinks links_;
  mpdem::GrainSides sides_;
  mpdem::Relaxation relaxation_;
  mpdem::GrainAccelerations accelerations_;
  std::vector<mpdem::GrainAccelerations::Grain> bonded_;  // of this rank
  bool sudden_forces_are_due_ = false;
  bool jump_told_ = false;
  double jump_limit_ = 0.0;  // of velocity
  std::string worst_jump_;   // of prescribed velocity, seen by this rank in this run
  bool any_free_grain_ = false, any_added_mass_ = false, fresh_added_mass_ = false;  // on any rank; since it was used
  mpdem::Resting resting_;
  mpdem::RestingLinks resting_links_;
  mpdem::UpdatedPass updated_pass_;
  double eigenvalue_ = 0.0;  // found for the present layout, 0: not yet
  std::size_t blocks_when_arranged_ = 0;
  struct OwnedSide {
    int atom, at, body, side;
    double mass_ratio;  // see GrainSide
  };
  std::vector<OwnedSide> owned_;
  std::size_t laid_out_blocks_ = 0;
  std::vector<int> grains_here_;  // atoms of this rank with an orientation to advance
  std::vector<mpdem::PrescribedMotion> prescribed_;  // of these
  std::vector<double> moved_;     // of these, in this step, x y z
  std::string grain_trouble_;     // found on this rank, told at the next report
  double density_ = 0.0;   // of the calcite
  double inertia_ = 0.0;   // density with the mass scale
  class FixGravity* gravity_ = nullptr;  // that acts on the points too
  bool built_ = false, reported_ = false, all_in_motion_ = false;
  int bodies_started_ = 0;  // the first of the table; the others are new and where they were made
  double dt_last_ = 0.0;  // step that the stored velocities lie half of behind
  double auto_step_ = 0.0;  // what `timestep auto` found last
  bigint points_expected_ = -1;
  mpdem::NodeKinematics restored_;
  double memory_limit_ = 0.0;  // of a rank, bytes
  double restored_cell_ = 0.0;  // of the restart file, 0 without one
  mpdem::Basis restored_basis_ = mpdem::Basis::quadratic;
  bool restored_updated_ = false, restored_tied_ = false;

  // crevices
  std::vector<signed char> has_sheets_;// of each body
  std::vector<mpdem::Key> joined_;     // nodes where sheets are joined, by body, of bodies that this rank looked at; ascending

  // bonds that came apart
  std::vector<mpdem::Separation> separation_;
  std::vector<double> failed_seen_;    // of each body, when it was looked at
  std::vector<std::vector<int>> path_; // of each body, see fracture/separation.h; empty: not known
  std::vector<int> path_cut_;          // of each body, on this rank
  bool any_path_cut_ = false;
  std::map<int, int> new_part_;        // slot, part; consumed by rebuild()
  std::map<int, int> parent_field_;
  std::vector<char> untied_;           // of each body that came apart, in the present layout

  // failures since the last check, doubles throughout for MPI
  struct FailureEvent {
    double step, time, point, bond, grain, r, theta, z, damage[3], direction[3];
  };
  std::vector<FailureEvent> events_;
  std::string events_name_;
  mpdem::TableFile events_file_;
  bool events_open_ = false;
  bigint events_from_ = 0;

  // accumulated over steps, this rank's share
  double start_energy_ = 0.0;  // of the cement when it was set in motion
  double dissipated_ = 0.0, released_ = 0.0, damped_ = 0.0, work_ = 0.0, work_ahead_ = 0.0;
  mpdem::AdvanceResult advance_;
  std::vector<double> filtered_;     // that of the part before the nodes move, xpic only
  std::vector<double> transferred_;  // change of the nodal velocity by the transfer of this step, `updated` only
  std::vector<double> jump_;  // of the nodal velocity by re-projection in this step, or empty

  mpdem::StepTimer timer_;
  bigint timed_from_ = 0;

  Totals totals_;
  std::vector<BondState> bonds_;
  bigint totals_at_ = -1, bonds_at_ = -1;
};

}  // namespace LAMMPS_NS

#endif
#endif
