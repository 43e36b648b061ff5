// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Scene has the data that the classes of the engine share: bonds and grains, options and laws, the clock, and the
// energy balance. Code that changes energy counts it there. Cement owns the scene and gives it to the other classes by
// reference, as const where they only read it.
//
// Units are consistent.
#ifndef MPDEM_CEMENT_BOND_SCENE_H
#define MPDEM_CEMENT_BOND_SCENE_H

#include <mpi.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "../../material/law.h"
#include "../../parallel/own_comm.h"
#include "bond.h"
#include "bonded_grains.h"
#include "energy_balance.h"
#include "fragment_bodies.h"
#include "options.h"
#include "formulation.h"
#include "step_timer.h"

namespace mpdem {

// Interface by which the engine calls its host. Calls are rare.
class CementHost {
 public:
  virtual ~CementHost() = default;
  // Initial velocity of a point of this rank, by its tag.
  virtual std::array<double, 3> initial_velocity(int tag) = 0;
  // Points of a bond failed in this step, see Bond::failed. Called before their slots change.
  virtual void points_failed(const Bond& bond) = 0;
  // Columns of the film of a bond failed in this step, see Film::failed.
  virtual void film_failed(const Bond& /* bond */) {}
  // Links of a bond debonded from points that did not fail, see Bond::link_step.
  virtual void links_debonded(const Bond& bond) = 0;
  // Slots of points of a bond changed.
  virtual void slots_changed(const Bond& bond) = 0;
  // Adds external forces to nodes, or fixes nodes. All other forces of the step are on the nodes already, those of
  // constrained nodes on their masters. The energy balance does not count this. Ranks must treat shared nodes alike.
  virtual void add_node_forces(Bond&) {}
};

// The clock of a step, and gravity.
struct StepInput {
  std::int64_t number = 0;  // number of this step
  double dt = 0;            // time step; with sub-steps, the length of one
  int substeps = 1;         // number of sub-steps that the cement takes in a step of the host
  double gravity[3] = {0, 0, 0};
};

// Do bonds have elastic grains (coupling/elastic_end.h), and do bonds on one of them act on each other (cement/step/elastic_coupling.h)?
enum class ElasticGrains { none, apart, coupled };

struct Scene {
  static constexpr int kTopologyInterval =
      5;  // steps of the cement between two checks for separation, and between remappings of contact points

  const OwnComm comm;
  CementOptions options;
  const std::unique_ptr<const Formulation> formulation;
  std::shared_ptr<const Law> law;            // law of material 0, which has the laws of the other materials
  std::optional<PenaltyParameters> penalty;  // parameters of the links; none: no links
  ElasticGrains elastic_grains = ElasticGrains::none;
  double scaled_density = 0.0;  // of materials without a density of their own: density times the mass scale
  BondedGrains grains;
  FragmentBodies fragments;
  EnergyBalance energy;
  StepTimer timer;

  StepInput now;
  int substep = 1;        // number of the sub-step, counted from 1
  double dt_last = 0.0;   // length of the last step; stored velocities belong to its middle
  int rows_started = 0;   // number of rows at the head of the table that have moved; later rows are still as made
  bool laid_out = false;  // bonds have a layout, and grains the ends of their bonds

  Scene(MPI_Comm comm_of_all, Bonds& of_host, CementHost& asked, const CementOptions& words, std::unique_ptr<const Formulation> of_bonds,
        std::shared_ptr<const Law> of_points)
      : comm(comm_of_all), options(words), formulation(std::move(of_bonds)), law(std::move(of_points)), bonds_(of_host), host_(asked) {}
  Scene(const Scene&) = delete;  // other objects refer to it

  // A const scene has const bonds, and no access to the host.
  Bonds& bonds() { return bonds_; }
  const Bonds& bonds() const { return bonds_; }
  CementHost& host() { return host_; }

  // Is this the first, or the last, of the sub-steps of a step of the host?
  bool begins_step() const { return substep == 1; }
  bool ends_step() const { return substep == now.substeps; }
  // Time from the middle of the last step to the middle of this one.
  double kick() const { return 0.5 * (dt_last + now.dt); }
  // Steps of the host between two such checks (kTopologyInterval). They are made in the first sub-step.
  int topology_interval() const { return std::max(1, kTopologyInterval / now.substeps); }
  bool is_topology_step() const { return begins_step() && (now.number - 1) % topology_interval() == 0; }

  double density() const { return scaled_density / options.mass_scale; }
  // Density of the inertia of the cement, by materials. true_density() is the same without the mass scale.
  CementDensity inertia() const { return {scaled_density, options.mass_scale, law.get()}; }
  CementDensity true_density() const { return {density(), 1.0, law.get()}; }
  bool leaves_residue() const { return penalty && penalty->law->leaves_residue(); }
  // Can points fail, or links debond?
  bool can_break() const { return penalty && !(law->inert() && penalty->law->fields() == 0); }
  // touches(): do debonded surfaces keep contact with the grains? faces_touch(): do crack faces have contact?
  double friction() const { return penalty ? std::max(penalty->friction, 0.0) : 0.0; }
  bool touches() const { return penalty && penalty->friction >= 0.0; }
  // Are contact points mapped to other material points in this step?
  bool contacts_move() const { return touches() && is_topology_step(); }
  bool faces_touch() const { return touches() && options.split; }
  // Do they in this bond? Otherwise its surfaces touch, see contact/piece_contact.h.
  bool touches_in(const Bond& b) const { return touches() && !fragments.has(b.row); }
  // What nodes still have to move in this step, before its pass over the points.
  FragmentBodies::Drift drift() const { return {kick(), now.dt}; }
  // May bonds be condensed? Where cement has contact, separated bonds may become rigid pieces in any case.
  bool may_condense() const { return penalty && (options.condense || touches()); }
  // Is the response linear as long as nothing else fails? Contact, cracks that close and links that softened are not.
  bool stays_linear(const Bond& b) const;

  // weight() is the acceleration by gravity that acts on the inertia of the cement, in the axes of the box.
  // weight_of() is the same in the axes of a bond.
  std::array<double, 3> weight() const;
  std::array<double, 3> weight_of(const Bond& b) const;
  double shear_speed() const;
  // Largest dt^2 lambda of a stable step.
  double stability_limit() const { return formulation->stability_limit() / options.mass_order; }
  // Upper bound of the largest eigenvalue of cement without constrained nodes; 0: none is known.
  double eigenvalue_bound() const;

  std::vector<int> all_rows() const;
  // Collective. Returns the union of the rows of all ranks, ascending.
  std::vector<int> agreed_rows(const std::vector<int>& mine) const;

 private:
  Bonds& bonds_;
  CementHost& host_;
};

}  // namespace mpdem

#endif
