// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The cement of a scene. It owns the components that do the work, and defines their order at the start of a run, in a
// step and in a layout. It does not depend on a host program. The host gives it grains and time steps, and gets loads,
// velocities and reports, all in the axes of the box. doc/architecture.md describes the components and the step.
//
// State after step n: u_n, v_n-1/2 and a_n at the nodes; F_n, strain and damage at the points. Consistent units.
// Functions are collective, except setters and getters. Invalid states are thrown as BadState, see
// parallel/agree.h.
#ifndef MPDEM_CEMENT_ENGINE_CEMENT_H
#define MPDEM_CEMENT_ENGINE_CEMENT_H

#include <mpi.h>

#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "../step/added_masses.h"
#include "../step/layout_manager.h"
#include "../layout/cement_restart.h"
#include "../condensed/condensed_bonds.h"
#include "../../contact/piece_contact.h"
#include "../step/condensing.h"
#include "../step/departures.h"
#include "../failure/discontinuities.h"
#include "../step/kinematics.h"
#include "../step/nodal_forces.h"
#include "../step/topology_update.h"
#include "report.h"
#include "../layout/restored_nodes.h"
#include "../bond/scene.h"
#include "../bond/shared_nodes.h"
#include "../step/stable_step.h"
#include "../condensed/stiffness_of_bonds.h"
#include "../step/substeps.h"
#include "../layout/elastic_grains.h"
#include "../step/work_of_step.h"

namespace mpdem {

class Cement {
 public:
  Cement(MPI_Comm comm, Bonds& bonds, const CementOptions& options, std::shared_ptr<const Law> law, CementHost& host);
  ~Cement();

  // Settings of the script.
  const CementOptions& options() const { return scene_.options; }
  const Law& law() const { return *scene_.law; }
  // Sets the density of cement without a density of its own. Throws BadState if such cement had another one in earlier steps.
  void set_density(double density);
  void set_most_bytes(double bytes) { scene_.options.most_bytes = bytes; }
  double density() const { return scene_.density(); }
  double scaled_density() const { return scene_.scaled_density; }  // density times the mass scale
  // Sets the parameters of the links; null: no links.
  void couple(const PenaltyParameters* penalty);
  // Collective. Sets which grains are elastic, see cement/layout/elastic_grains.h.
  void set_elastic_grains(const std::vector<ElasticPair>& of_rows);
  bool has_coupled_grains() const {
    return scene_.elastic_grains == ElasticGrains::coupled;
  }  // do bonds on one elastic grain act on each other?
  const std::optional<PenaltyParameters>& penalty() const { return scene_.penalty; }
  bool leaves_residue() const { return scene_.leaves_residue(); }

  // Access to the scene and its components for the host.
  Bonds& bonds() { return scene_.bonds(); }
  BondedGrains& grains() { return scene_.grains; }
  const Cracks& cracks() const { return discontinuities_.cracks; }
  StepTimer& timer() { return scene_.timer; }
  Report& report() { return report_; }
  StableStep& stable_step() { return stable_step_; }
  NodalForces& forces() { return forces_; }
  Departures& departures() { return departures_; }
  // Sets the step. Call before each of the functions below.
  void set_step(const StepInput& now) { scene_.now = now; }
  bool built() const { return scene_.laid_out; }
  int rows_started() const { return scene_.rows_started; }
  double dt() const { return scene_.now.dt; }  // time step of the cement
  int substeps() const { return scene_.now.substeps; }

  // Converts the states of all points to those of the law. New points have a damage tensor, points of a restart file
  // the state of a law. Throws BadState if the law cannot start from them.
  void read_point_states();

  // Rows of bonds that need their points before the next step, the same on all ranks. They are activated in it.
  const std::vector<int>& rows_that_want_points() const { return condensing_.rows_that_want_points(); }
  // Call when the host has made the points of these rows, before their layout.
  void points_were_made(const std::vector<int>& rows);

  // The host calls these in this order:
  //
  //   lay_out_run, start_run, then in each step: start_step, grains_moved, [lay_out_exchanged,] step, end_step.
  //
  // Another order throws std::logic_error.
  //
  // Lays out all bonds. Grains and points must be on their ranks.
  void lay_out_run();
  // Finds the forces at the start of the run. Grains must have their velocities and the loads of the host.
  void start_run();
  // Call before the host moves its grains, which have the velocities and loads of the end of the last step. commands:
  // commands may have changed velocities since then.
  void start_step(bool commands);
  // Call when the host has moved its grains. Advances all sub-steps but the last. The host then has to copy the
  // positions and velocities of free grains from grains().
  void grains_moved();
  // Lays out bonds whose points or grains moved to other ranks, or that got their points.
  void lay_out_exchanged();
  // Advances the step, or its last sub-step. Grains have the loads of the host, and get those of the cement.
  void step();
  // Call when grains have their velocities at the end of the step.
  void end_step();
  // Call when the time step changed. Finds the added mass for it, and counts the energy that this mass loses.
  void change_step();
  // Updates the slots of points, which are not kept sorted while points change cells.
  void sync_slots() { layout_manager_.sync_slots(); }
  // Calls sync_slots(), and writes the strain of points of condensed bonds, for code that reads points.
  void show_points();
  // Tractions of the links of a bond, for each link of its points. Call show_points() before.
  std::vector<PenaltyLinks::LinkTraction> link_tractions(const Bond& b) const;
  // Properties of layouts that are not made yet. These change nothing, and need no run. eigenvalue_of_new_layout():
  // largest eigenvalue. stiffness_of_bonds(): static stiffness of each bond in the present state; needs links.
  // grains_step(): stability limit of the time step of grains on massless bonds of that stiffness.
  EigenvalueEstimate eigenvalue_of_new_layout() const;
  std::vector<StiffnessOfBond> stiffness_of_bonds() const;
  double grains_step() const { return stable_step_.of_grains(stiffness_of_bonds()); }
  // grains_step(), or infinity if a bond is almost separated, so that its static stiffness does not converge.
  double grains_step_if_known() const {
    try {
      return grains_step();
    } catch (const BadState&) {
      return std::numeric_limits<double>::infinity();
    }
  }

  // Contact of the cement with other bodies, see contact/piece_contact.h. is_apart(): the bond is separated, and its pieces
  // and fragments touch each other and its grains. changes_of_surfaces(): another number when a bond becomes apart, loses
  // points, or when its fragments break. seen_of_fragments(): the latter of one bond.
  // take_surfaces(): finds the surfaces of these bonds anew; collective. The host calls contact() with the motion of all its
  // grains and of motions_of_fragments(), and adds the forces to its own. moved: nodes have the positions of the grains.
  // load_fragments(): six numbers a fragment, of the ranks that found its forces; collective.
  PieceContact& contact() { return contact_; }
  bool has_contact() const;
  ContactOfPieces contact_parameters() const;
  bool is_apart(int row) const { return condensed_.is_in_pieces(row) || scene_.fragments.has(row); }
  double changes_of_surfaces() const;
  double seen_of_fragments(int row) const { return scene_.fragments.has(row) ? cracks()[static_cast<std::size_t>(row)].broken_seen : 0.0; }
  void take_surfaces(const std::vector<int>& rows);
  int fragments() const { return scene_.fragments.size(); }
  const std::vector<BodyOfNodes>& motions_of_fragments(bool moved);
  void load_fragments(std::vector<double> forces);

  // Throws BadState if a node is not finite, a bonded grain is gone, cement is pressed too deep into a grain, or faces
  // of a crack in contact slid too far.
  void check_state();
  // Ligaments of intact bonds. rows: ascending.
  std::vector<Cracks::LigamentReport> ligaments(const std::vector<int>& rows) { return topology_.find_ligaments(rows); }

  // Restart: packs the state of all ranks, complete on rank 0. head: has the values that the host knows; the others are
  // filled in.
  std::vector<double> packed_state(CementHead head);
  // Packs the motion of the nodes of this rank: the NodeRows of each bond, by row of the table.
  std::map<int, std::vector<double>> packed_nodes() const { return mpdem::packed_nodes(scene_); }
  // Restores a packed state, the same on every rank. head: as it was read. nodes: packed; each node on any rank. Throws
  // BadState if the state belongs to other options.
  void restore(const CementHead& head, RecordReader& in, const std::vector<double>& nodes);
  // Returns the options of the damage law that differ from that head, with both values; empty: none.
  std::string changed_options_since(const CementHead& head) const;
  bool restored() const { return restored_; }

 private:
  std::vector<BondLayout> layouts_of_copies(const PenaltyParameters* penalty) const {
    return mpdem::layouts_of_copies(scene_, discontinuities_, restored_nodes_, layout_manager_.fresh_points(), penalty);
  }
  // The last call of the host.
  enum class Stage { none, laid_out, between_steps, step_started, grains_moved, step_taken };

  // Throws std::logic_error if the stage is not `from`.
  void go_on(const char* call, Stage from, Stage to);
  void read_commanded_velocities();
  void take_substeps();
  void advance();
  void end_substep();
  void find_forces_anew();
  void start_bonds();
  void correct_half_kicks(const std::vector<std::vector<double>>& accelerations);  // accelerations of resolved bonds in the last step
  void restore_bonds(int bond_rows, RecordReader& in);
  std::vector<std::vector<CementPiece>> surfaces(const std::vector<int>& rows);
  void name_fragments();

  // Components in the order of construction: they refer to those above them.
  Scene scene_;
  Discontinuities discontinuities_;
  CondensedBonds condensed_;
  SharedNodes shared_{scene_};
  RestoredNodes restored_nodes_{scene_};
  StableStep stable_step_{scene_, condensed_};
  AddedMasses added_{scene_, stable_step_};
  LayoutManager layout_manager_{scene_, discontinuities_, restored_nodes_, shared_, added_};
  WorkOfStep work_{scene_, condensed_};
  TopologyUpdate topology_{scene_, discontinuities_, layout_manager_, added_};
  Condensing condensing_{scene_, condensed_, discontinuities_.cracks, topology_.load_history(), layout_manager_, shared_, added_, work_};
  Departures departures_{scene_, discontinuities_, layout_manager_, condensed_, condensing_, work_};
  NodalForces forces_{scene_, shared_, added_, condensed_, discontinuities_.cracks};
  std::unique_ptr<Kinematics> kinematics_;
  Substeps substeps_{scene_};
  PieceContact contact_;
  Report report_{scene_, discontinuities_.cracks, condensed_, contact_};
  bool restored_ = false;  // the state came from a restart file
  Stage stage_ = Stage::none;
};

}  // namespace mpdem

#endif
