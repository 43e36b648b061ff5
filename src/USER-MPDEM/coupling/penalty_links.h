// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Penalty coupling of cement to rigid grains. A link has the vector q0, fixed in the grain, from the centre of the
// grain to the point where it acts. It compares this with the current vector q_t to the same point in the cement:
//
//   delta = q_t - R q0,  n = R q0/|q0|,
//   f = -A (k_n (delta.n) n + k_t (delta - (delta.n) n)) - damping,   on the cement
//   -f and -q_t x f on the grain.
//
// f and the moment derive from U = delta_b.K0.delta_b/2. Here delta_b is delta in the frame of the grain, and K0 the
// stiffness there, which is constant. The lever arm must be q_t. Otherwise angular momentum is lost when k_n != k_t. The
// link acts at the foot point on the grain's surface (`at surface`) or at the material point itself (`at points`).
//
// At the foot point the field is the polynomial of the cell of the *material point*, continued to the foot point.
// Mostly both lie in one cell. If not, a node may have the foot point in its support, but no material point. Such a
// node has no stiffness and would move until the penalty force on it vanishes. (The stiffness of a bond would be up to
// 14 % low for unfavourable positions of the grid.) Continuation is the remedy of extended B-splines (Hoellig, Reif &
// Wipper, SIAM J. Numer. Anal. 39 (2001) 442). The weights sum to one and reproduce linear fields, so momentum and
// angular momentum are exact. Some weights are negative.
//
// This is the elastic law. In general the force per area is a function of delta, see traction_law.h.
//
// An object has the links of one bond on one rank. Stiff links need added mass at the nodes, see added_mass.h.
#ifndef MPDEM_COUPLING_PENALTY_LINKS_H
#define MPDEM_COUPLING_PENALTY_LINKS_H

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "../material/cement_density.h"
#include "../mpm/grid.h"
#include "../mpm/point_store.h"
#include "../mpm/power.h"
#include "../numerics/short_list.h"
#include "bond_ends.h"
#include "elastic_end.h"
#include "traction_law.h"

namespace mpdem {

class StiffnessMatrix;

struct PenaltyParameters {
  std::shared_ptr<const TractionLaw> law;
  double damping = 0;  // share of critical damping, for the spring with the mass of its point
  bool at_surface = true;
  double friction = -1;  // friction coefficient of contact points, see debonded_contact.h; below 0: no contact
  // Largest stiffness of a contact point, in pressure over length. A node near its grain gains added mass, which slows
  // it, and loses it when it leaves. If that is many times the mass of the cement there, impacts lose most of its
  // motion.
  double max_contact_stiffness = std::numeric_limits<double>::infinity();
  TractionStiffness contact() const {
    return {std::min(law->stiffness().kn, max_contact_stiffness), std::min(law->stiffness().kt, max_contact_stiffness)};
  }
  // Stiffness of links and of contact points for the added mass. The factor with friction is there because sliding
  // friction depends on the normal force.
  double stiffest(int material = 0) const { return with_friction(law->of_material(material).stiffness()); }
  double stiffest_contact() const { return with_friction(contact()); }

 private:
  double with_friction(const TractionStiffness& k) const {
    const double mu = std::max(friction, 0.0);
    return std::max(k.kn * std::sqrt(1.0 + mu * mu), k.kt);
  }
};

// Changes of the links in a step, for a law with a state.
struct LinkStep {
  double dissipated = 0, released = 0;  // energies: dissipated by the law, and other energy of springs that soften, debond, open or close
  std::vector<int> debond;              // links of the store that debond from intact points
};

// `ends` points to end 0 of the bond. End 1 follows it.
class PenaltyLinks {
 public:
  PenaltyLinks() = default;
  // Lays out the links of the store in blocks of one grain. Call add_cells() before the grid is built.
  PenaltyLinks(const PointStore& points, const BondRecord& record, const PenaltyParameters& parameters, double cell,
               const CementDensity& density, Basis basis = Basis::quadratic);
  void add_cells(std::vector<Grid::Cell>& cells);
  // Finds the columns in a grid that is built already, instead of add_cells(). Returns false if the grid has not all
  // the nodes.
  bool find_columns(const Grid& grid);

  // Finds how far the cement carries the positions of the links in dt with the present velocity of the nodes.
  void find_moves(const Grid& grid, double dt);
  // Moves the positions by find_moves(), and the cement's ends of the links in the store. Returns true if the point of
  // a link left its cell, or if links are gone. Then call follow_points().
  bool move_links(PointStore& points);
  // Makes the blocks that a new layout would have. Returns false if the grid has not all the nodes. Only for grids
  // without constrained nodes.
  bool follow_points(const PointStore& points, const BondRecord& record, const Grid& grid);
  // Makes the present positions the reference of the cement's ends in the store. A new layout must follow.
  void move_to_present(PointStore& points, const Grid& grid) const;
  // Updates the indices of the links after PointStore::sort_links().
  void renumber(const std::vector<int>& new_index);
  // Updates the columns for points that moved to other layers, and for nodes with new indices (Grid::add_nodes()).
  // Throws std::logic_error if the grid does not have the nodes of a link.
  void follow_layers(const PointStore& points, const Grid& grid, const std::vector<int>& new_index);

  // Adds the forces of the present positions and states to nodes and grains. Returns the energy that elastic grains release, as
  // another bond on them left.
  double add_force(Grid& grid, BondEnd* ends);
  // Updates the state of the traction law for the present positions, here and in the links of the store, and then adds
  // the forces. The positions are dt after the previous ones. Unchanged positions change no state.
  void update_and_add_force(PointStore& points, Grid& grid, BondEnd* ends, double dt, LinkStep& step);
  // Power that the dampers dissipate. Their force is that of the stored velocity. Power::after() gives the power for a
  // velocity that is a time of the acceleration later.
  Power damper_power(const Grid& grid, const BondEnd* ends) const;
  // Largest speed of the cement relative to the grain at a link.
  double fastest(const Grid& grid, const BondEnd* ends) const;
  void add_spring_energy(const Grid& grid, const BondEnd* ends, double& energy) const;

  // Debonds the links of points that failed (slots, ascending; links of the store ascend in slot). Adds the energy that
  // they release to `released`. Returns the links of the store that were attached until now, ascending. With a law that
  // leaves residue they stay attached without a force: a failed point has no stress, and shares its nodes with the
  // cement that separated from it. Debonded links count for the added mass until drop_added_mass() is called.
  std::vector<int> debond(PointStore& points, const std::vector<int>& failed, const Grid& grid, const BondEnd* ends, double dt,
                          double& released);
  bool drop_added_mass(PointStore& points);  // returns true if some debonded links counted until now
  // Makes the blocks that a new layout would have, for unchanged points and nodes.
  void remove_dropped(const PointStore& points, const BondRecord& record);
  // Adds the row-summed stiffness of this rank's links, and of their dampers at this time step, to two numbers per node,
  // one for each grain. The stiffness of links at constrained nodes goes to the masters.
  void add_stiffness(const Grid& grid, const BondEnd* ends, double dt, double* penalty) const;

  // Secant stiffness of the links of a block in the present state, times their area; zero if debonded. arm: from the
  // centre of the grain to the position in the cement, so a rotation of both together gives no strain.
  struct Secant {
    vd n[3], arm[3], kn, kt;
  };
  std::vector<Secant> secants(const Grid& grid, const BondEnd* ends) const;
  // Adds the forces due to small displacements x of the nodes, and due to small motions of the two grains: translation
  // of the centre, then rotation. `load` is on the grains, force and moment about the centre. The result is linear and
  // symmetric: the effect of a rotation on present forces is neglected.
  void add_small_force(const std::vector<Secant>& secants, const double* x, const double (*motion)[6], double* force,
                       double (*load)[6]) const;
  // Elastic grains (elastic_end.h), in elastic_links.cpp. update_and_add_force() does all this for a bond that is whole on its rank.
  // Where ranks cut a bond, or a grain has other bonds, cement/step/elastic_forces.h does it: ranks sum the loads of the modes, and their
  // stiffness where it changed, and bonds on one grain move each other. Modes of a side are in the axes of its patch.
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  bool is_elastic() const { return elastic_.has_value(); }
  int modal_size(int side) const { return elastic_->side[static_cast<std::size_t>(side)].end.size(); }
  bool modal_stiffness_changed() const { return elastic_->stiffness_changed; }
  bool some_debonded() const { return elastic_->some_debonded; }  // in this step
  std::vector<double> modal_stiffness(int side) const;            // ElasticEnd::stiffness() of the links of this rank
  Eigen::MatrixXd modal_response(int side, const std::vector<double>& of_all) const {
    return elastic_->side[static_cast<std::size_t>(side)].end.response(of_all).M;
  }
  void take_modal_stiffness(int side, const std::vector<double>& of_all, bool debonded);
  void find_secants(const Grid& grid, const BondEnd* ends);  // of a traction law with a state, after a new layout
  void find_modal_loads(const Grid& grid, const BondEnd* ends, double dt);
  // Updates the states of a traction law that has them, for the motions w of both patches, see find_amplitudes(). Returns true if secants
  // changed: then stiffness and loads have to be found anew.
  bool update_elastic(PointStore& points, const Grid& grid, const BondEnd* ends, double dt, const std::array<Vector6, 2>& w,
                      LinkStep& step);
  const Eigen::VectorXd& modal_loads(int side) const { return elastic_->side[static_cast<std::size_t>(side)].loads; }
  void take_modal_loads(int side, const Eigen::VectorXd& of_all) { elastic_->side[static_cast<std::size_t>(side)].of_all = of_all; }
  // The amplitudes, for the motion w of the patch by other bonds on the grain, and the load F of the patch for w = 0, and its
  // stiffness k, see elastic_end.h.
  void find_amplitudes(int side, const Vector6& w);
  Vector6 rigid_load(int side) const {
    const ElasticEnds::Side& e = elastic_->side[static_cast<std::size_t>(side)];
    return e.response.H.transpose() * e.of_all;
  }
  const Eigen::Matrix<double, 6, 6>& rigid_stiffness(int side) const { return elastic_->side[static_cast<std::size_t>(side)].response.k; }
  bool is_coupled() const { return elastic_ && elastic_->coupled; }
  void set_coupled(bool coupled) { elastic_->coupled = coupled; }
  void note_debonding();  // of another bond on one of the grains
  // Adds the forces for these loads. Returns the energy that the modes release with links that debond in this step.
  double add_elastic_force(Grid& grid, BondEnd* ends);
  // Takes over the motion of the surfaces, and the secants, from the links before a new layout.
  void continue_from(const PenaltyLinks& before);
  // For small motions as in add_small_force(): loads of the modes of both sides, and the forces due to their amplitudes.
  std::array<Eigen::VectorXd, 2> small_modal_loads(const std::vector<Secant>& secants, const BondEnd* ends, const double* x,
                                                   const double (*motion)[6]) const;
  void add_small_elastic_force(const std::vector<Secant>& secants, const BondEnd* ends, const std::array<Eigen::VectorXd, 2>& amplitudes,
                               double* force, double (*load)[6]) const;
  // Of each link of the store, for output: normal traction, tension positive, and the size of that along the surface; zero where it
  // debonded. small_tractions(): for small motions as in add_small_force(), with the amplitudes of the modes of elastic grains.
  struct LinkTraction {
    double normal = 0.0, tangential = 0.0;
  };
  std::vector<LinkTraction> tractions(const PointStore& points, const Grid& grid, const BondEnd* ends) const;
  std::vector<LinkTraction> small_tractions(const PointStore& points, const std::vector<Secant>& secants, const BondEnd* ends,
                                            const double* x, const double (*motion)[6],
                                            const std::array<Eigen::VectorXd, 2>& amplitudes) const;
  // The same stiffness in an assembled matrix: the nodes of the links, and their springs.
  void couple(StiffnessMatrix& matrix) const;
  void add_to(StiffnessMatrix& matrix, const std::vector<Secant>& secants) const;

  // Separations of the attached links due to six small motions: of the nodes by fields[j], and of the two grains by
  // motions[j]. Eight links a block; zero in other lanes.
  struct SmallSeparations {
    struct Block {
      vd delta[6][3], n[3];
    };
    std::vector<Block> blocks;
  };
  SmallSeparations small_separations(const std::vector<Secant>& secants, const std::array<std::vector<double>, 6>& fields,
                                     const double (*motions)[2][6], const BondEnd* ends,
                                     const std::array<std::array<Eigen::VectorXd, 2>, 6>& amplitudes) const;
  // Largest TractionLaw onset_share of the links: for the sum of d_j motions, or for each of them alone, of both signs.
  double largest_onset_share(const SmallSeparations& separations, const double* d) const;
  void largest_onset_shares(const SmallSeparations& separations, double* of_motion) const;

  const PenaltyParameters& parameters() const { return p_; }
  bool empty() const { return blocks_.empty(); }
  // Shares lists with bonds that have equal ones.
  void share(AlikeLists& alike);
  std::size_t memory_usage() const;

 private:
  struct LinkBlock {
    vd X[3];           // where the link acts, reference; it may be outside the cell, which is that of the point
    vd area;           // zero in empty lanes
    vint base[3];      // cells of the points
    int link[kLanes];  // link of the store; -1: empty
    std::uint8_t side, material;
    // Lanes with a link, attached or not.
    std::uint8_t taken() const {
      unsigned bits = 0;
      for (int l = 0; l < kLanes; ++l) bits |= (link[l] >= 0 ? 1u : 0u) << l;
      return static_cast<std::uint8_t>(bits);
    }
  };

  // One bit for each lane: the link is attached; the link counts for the added mass.
  struct LinkFlags {
    std::uint8_t attached = 0, counts_for_added_mass = 0;
  };

  // Positions of the links of a block, or their displacements in a step.
  struct Positions {
    vd X[3];
  };

  // Links are ordered by grain, by the material of the point, by the cell of the foot point, which never changes, and by the ID of the point. Cells
  // have few links, and blocks of one cell would be half empty. So a block has links of several cells.
  struct Item {
    std::array<int, 6> key;  // grain 0 or 1, material, cell, ID
    int link;
    bool same_block(const Item& i) const { return key[0] == i.key[0] && key[1] == i.key[1]; }
  };

  // True if the link is attached and its point is not residue.
  bool is_bonded(const PointStore& points, const Link& k) const {
    return k.attached && !(p_.law->leaves_residue() && points.has_failed(k.slot));
  }
  // Component d of the position of a link: when its bond was created; where it acts, in the reference.
  double created(const PointStore& points, const Link& k, int d) const;
  double acts_at(const PointStore& points, const Link& k, int d) const;
  void base_of(const PointStore& points, const Link& k, int* base) const;
  void set_lane(std::size_t block, int lane, const PointStore& points, int link);
  // Columns of a lane of a block, kSupport^2 of them.
  int* columns(std::size_t block, int lane) { return &columns_.own()[(kLanes * block + lane) * columns_of_cell_]; }
  std::size_t number_of(const LinkBlock& b) const { return static_cast<std::size_t>(&b - blocks_.data()); }
  const int* columns(const LinkBlock& b) const { return columns_.data() + kLanes * number_of(b) * columns_of_cell_; }
  const vd* created_at(const LinkBlock& b) const { return created_.empty() ? b.X : created_[number_of(b)].X; }
  void keep_created();
  // Value of a nodal field where the links of a block act.
  template <class Type>
  void gather(const std::vector<double>& nodal, const LinkBlock& b, const Weights<Type>& w, vd* out) const;
  // Stored energy of each lane.
  template <class L>
  vd energy(const L& law, std::size_t block, const Grid& grid, const BondEnd& s) const;
  template <class L>
  static vd energy_loss_in_step(const L& law, const typename L::State& before, const typename L::State& after, const vd* delta, const vd* n,
                                const vd* v, double dt);
  template <class L>
  vd energy_at_debonding(const L& law, std::size_t block, const Grid& grid, const BondEnd& s, double dt) const;
  template <class L>
  typename L::State state(const L&, std::size_t block) const;
  // Ends the force of the lanes `freed`, and adds their energy to `released`. Residue stays attached in the store.
  void release(std::size_t block, std::uint8_t freed, vd energy, bool is_residue, PointStore& points, double& released);
  void take_states(const PointStore& points);  // from the links of the store
  void find_strength(const PointStore& points, const BondRecord& record);
  // Separation as it counts for damage: over the drawn factor on the strength. Energies then go with its square.
  LinkSeparation counted(const LinkSeparation& s, std::size_t block) const {
    if (strength_.empty()) return s;
    return {s.n / strength_[block], s.square / (strength_[block] * strength_[block])};
  }
  // Neither this nor add_force_of() is inlined, so that forces are bitwise identical with and without update_block().
  template <class Type>
  __attribute__((noinline)) void find_separation(const LinkBlock& b, const Grid& grid, const BondEnd& s, const Weights<Type>& w, vd* q,
                                                 vd* delta, vd* n) const;
  // Calls f(block, lane) for each attached link, and then() with the nodes of the links before, where others follow and at the end.
  template <class F, class Then>
  void each_attached_by_cell(F f, Then then) const;
  // Calls f(block, weights, q, delta, n) for the blocks with attached links.
  template <class F>
  void each_attached(const Grid& grid, const BondEnd* ends, F f) const;
  template <class L, class Type>
  __attribute__((noinline)) void add_force_of(const L& law, std::size_t block, const Weights<Type>& w, const vd* q, const vd* delta,
                                              const vd* n, Grid& grid, BondEnd& s) const;
  template <class L, class Type>
  void update_block(const L& law, std::size_t block, const Weights<Type>& w, const vd* q, const vd* delta, const vd* n, PointStore& points,
                    const Grid& grid, const BondEnd& s, double dt, LinkStep& step);
  // Velocity of the cement relative to the grain where the links act.
  template <class Type>
  void find_velocity(const LinkBlock& b, const Grid& grid, const BondEnd& s, const Weights<Type>& w, const vd* q, vd* v) const;
  // Finds this velocity v, and the force f of the dampers.
  template <class Type>
  void damper(const LinkBlock& b, const Grid& grid, const BondEnd& s, const Weights<Type>& w, const TractionSecant& k, const vd* q,
              const vd* n, vd* v, vd* f) const;
  // Adds the force f of a block and that of its dampers to nodes and grain.
  template <class Type>
  void add_with_damper(const LinkBlock& b, const Weights<Type>& w, const TractionSecant& k, const vd* q, const vd* n, vd* f, Grid& grid,
                       BondEnd& s) const;

  void take_share_of_link(std::size_t block, const Secant& s, const Eigen::VectorXd& amplitudes, vd* delta) const;
  void put_traction(std::size_t block, const TractionSecant& k, const vd* delta, const vd* n, std::vector<LinkTraction>& of_links) const;
  void lay_out_elastic(const PointStore& points, const BondRecord& record);
  TractionSecant softened(int side, const TractionSecant& k) const {
    return elastic_ ? elastic_->side[static_cast<std::size_t>(side)].end.softened(k) : k;
  }
  TractionSecant springs(std::size_t block) const;  // of link and soft spring in series
  template <class L>
  TractionSecant secant_of(const L& law, std::size_t block, const vd* delta, const vd* n, const typename L::State& state) const {
    return softened(blocks_[block].side, law.secant(separation_of(delta, n), state));
  }
  template <class L>
  bool update_elastic_block(const L& law, std::size_t block, const vd* delta, const vd* n, const vd* u, const vd* v, double dt,
                            PointStore& points, LinkStep& step);
  // Stores a new state of the links of a block, also in the store. Returns the lanes whose links debond, which it adds to the step.
  template <class L>
  std::uint8_t store_state(const L& law, std::size_t block, const typename L::State& now, const TractionUpdate& u, PointStore& points,
                           LinkStep& step);
  Mat3<double> axes_of_patch(int side, const BondEnd& s) const;
  void add_whole_elastic_force(PointStore* points, Grid& grid, BondEnd* ends, double dt, LinkStep& step);
  void add_freed(std::size_t block, std::uint8_t freed, const Grid& grid, const BondEnd& s);
  double modal_energy() const;  // to be subtracted from the energy of the links; share of this rank

  PenaltyParameters p_;
  Basis basis_ = Basis::quadratic;
  double cell_ = 0, inverse_h_ = 0;
  CementDensity density_{0.0};
  int row_ = 0, columns_of_cell_ = 0;
  bool gone_ = false;  // some links have neither force nor added mass, by the last move_links()
  // Lists that bonds of one shape share: blocks, and for each lane its columns of nodes (see Grid) and its layer.
  SharedList<LinkBlock> blocks_;
  SharedList<int> columns_;
  SharedList<int> layers_;
  std::vector<LinkFlags> link_flags_;   // one for each block
  std::vector<vd> states_;              // states of the traction law, its fields for each block; equal to those of the store
  std::vector<Positions> moves_;        // moves of the links of each block in this step, `kinematics updated` only
  std::vector<Positions> created_;      // positions of the links of each block at creation; empty: where they act
  std::vector<vd> strength_;            // drawn factor on the strength, for each block; empty without scatter
  std::vector<vd> dampers_;             // damping coefficient over sqrt(k), for each block; empty without damping
  std::optional<ElasticEnds> elastic_;  // none: both grains are rigid
  // Centres of the grains at creation, and the rotations from their frames to the axes of the bond.
  double centre_[2][3] = {};
  Mat3<double> orientation_[2];
};

}  // namespace mpdem

#endif
