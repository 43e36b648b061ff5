// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "static_bond.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

#include "../../mpm/stiffness_force.h"
#include "../../mpm/stiffness_matrix.h"
#include "../../parallel/agree.h"

namespace mpdem {

namespace {

using Vector3 = Eigen::Vector3d;
using Motion = double[2][6];  // motions of both grains, about their centres

// The iteration ends when the preconditioned residual is below kResidual times the initial energy. It also ends when the
// last quarter of the steps reduced the energy by less than kDecline times the initial energy. The relative error of the
// fields is about the root of these factors. Nodes beside failed points have almost no stiffness. They converge slowly, but
// hardly change the energy, so a bond with failed points has the larger limit kDeclineOfCracked.
constexpr double kResidual = 1e-18, kDecline = 1e-14, kDeclineOfCracked = 1e-6;
constexpr int kLeastSteps = 40;

// static_displacement() solves (K + s M) u = f instead of K u = f. The shift s is kShift times the largest nodal ratio of
// stiffness to mass, 1/time^2. Without it, a node beside failed points, which has almost no stiffness, would move by
// metres under its inertia. A vibration mode of squared frequency r s is found with a relative error of 1/(1 + r).
constexpr double kShift = 1e-4;
constexpr int kMostStepsOfForce = 1000;

// The stiffness is factorised if that takes at most kMostMultiplications, which is half a second and some 70 MB, and if each
// pivot is above a share kLeastPivot of its entry on the diagonal. Nodes with a smaller pivot are connected by almost
// nothing. The share is larger for a bond that may stay resolved (kMostStepsOfCandidate): round-off must not make the
// solution of a bond that was condensed once fail as the next run begins.
constexpr double kMostMultiplications = 5e9, kLeastPivot = 1e-11, kLeastPivotOfCandidate = 1e-8;

// The equations of one bond. Vectors have three numbers per node. Constrained nodes are no unknowns. system: null if this
// rank has no share of the bond; it still takes part in all collective calls. shift_share: kShift, or 0 for no shift.
class Equations {
 public:
  Equations(MPI_Comm comm, const StaticSystem* system, double least_pivot, double shift_share = 0.0) : comm_(comm), system_(system) {
    std::vector<double> stiffness;
    if (system) {
      stiffness.resize(system->grid.size());
      add_stiffness_diagonal(system->points, system->grid, system->law, stiffness.data());
      system->grid.halo.sum(stiffness.data(), 1);
    }
    double square = 0.0;  // largest ratio of stiffness to mass, then the shift, 1/time^2
    for (std::size_t i = 0; i < stiffness.size(); ++i)
      if (moves(i)) square = std::max(square, stiffness[i] / system->grid.mass[i]);
    square = shift_share > 0.0 ? shift_share * largest(square) : 0.0;
    find_response();
    if (!system) return;
    Grid& grid = system->grid;
    secants_ = system->links.secants(grid, system->ends);
    std::vector<double> rows(2 * grid.size(), 0.0);  // row sums of the stiffness of links: of grain 0 and of grain 1 for each node
    system->links.add_stiffness(grid, system->ends, std::numeric_limits<double>::infinity(), rows.data());
    grid.halo.sum(rows.data(), 2);
    shift_.assign(grid.size(), 0.0);
    inverse_.assign(grid.size(), 0.0);
    for (int i = 0; i < grid.size(); ++i) {
      const double d = stiffness[i] + rows[2 * i] + rows[2 * i + 1];
      if (!moves(i) || !(d > 0.0)) continue;
      shift_[i] = square * grid.mass[i];
      inverse_[i] = 1.0 / (d + shift_[i]);
    }
    // Free nodes at the edge have almost no stiffness. Only the iteration gives them the same motion on any number of ranks.
    if (comm == MPI_COMM_SELF && grid.constraints.size() > 0) factorise(least_pivot);
  }

  // Finds the force `out` on the nodes and `load` on the grains due to nodal displacements x and motions of the grains.
  // Sets the values of constrained nodes in x.
  void force(std::vector<double>& x, const Motion& motion, std::vector<double>& out, Motion& load) {
    for (auto& of_grain : load) std::fill(of_grain, of_grain + 6, 0.0);
    if (!system_) return add_elastic_force(x, motion, out, load);
    Grid& grid = system_->grid;
    std::fill(out.begin(), out.end(), 0.0);
    grid.constraints.extend(x.data());
    add_stiffness_force(system_->points, grid, system_->law, x.data(), out.data());
    system_->links.add_small_force(secants_, x.data(), motion, out.data(), load);
    add_elastic_force(x, motion, out, load);
    grid.constraints.gather_to_masters(out.data());
    grid.halo.sum(out.data(), 3);
  }

  // Applies the preconditioner: z = P r.
  void precondition(const std::vector<double>& r, std::vector<double>& z) {
    if (matrix_) return matrix_->solve(r, z);
    for (std::size_t i = 0; i < r.size(); ++i) z[i] = inverse_[i / 3] * r[i];
  }
  // Sum of a.b over the nodes of all ranks.
  double dot(const std::vector<double>& a, const std::vector<double>& b) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < inverse_.size(); ++i)
      if (counts(i)) sum += a[3 * i] * b[3 * i] + a[3 * i + 1] * b[3 * i + 1] + a[3 * i + 2] * b[3 * i + 2];
    return all(sum);
  }
  // The shift of component i.
  double shift(std::size_t i) const { return shift_[i / 3]; }

  // Amplitudes of the modes of both elastic grains that the last call of force() found.
  const std::array<Eigen::VectorXd, 2>& amplitudes() const { return amplitudes_; }

  // Over the ranks of the bond, largest() returns the maximum and all() the sum.
  double largest(double mine) const {
    if (comm_ == MPI_COMM_SELF) return mine;
    double most;
    MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE, MPI_MAX, comm_);
    return most;
  }
  double all(double mine) const {
    if (comm_ == MPI_COMM_SELF) return mine;
    double sum;
    MPI_Allreduce(&mine, &sum, 1, MPI_DOUBLE, MPI_SUM, comm_);
    return sum;
  }

 private:
  // Elastic grains: finds the response of the modes of both patches. Collective, also for ranks without a share.
  void find_response() {
    for (int side = 0; side < 2; ++side) modes_[side] = system_ && system_->links.is_elastic() ? system_->links.modal_size(side) : 0;
    if (comm_ != MPI_COMM_SELF) MPI_Allreduce(MPI_IN_PLACE, modes_, 2, MPI_INT, MPI_MAX, comm_);
    for (int side = 0; side < 2; ++side) {
      if (modes_[side] == 0) continue;
      // The size is that of ElasticEnd::stiffness(), which is known here without a share of the bond, too.
      std::vector<double> sums(static_cast<std::size_t>(modes_[side]) * (modes_[side] / 3 + 1), 0.0);
      if (system_) sums = system_->links.modal_stiffness(side);
      add_up(sums.data(), sums.size());
      if (system_) response_[side] = system_->links.modal_response(side, sums);
    }
  }
  // Adds the forces due to the surfaces of elastic grains, which deform under the loads of the links.
  void add_elastic_force(const std::vector<double>& x, const Motion& motion, std::vector<double>& out, Motion& load) {
    if (modes_[0] + modes_[1] == 0) return;
    std::array<Eigen::VectorXd, 2> modes{Eigen::VectorXd::Zero(modes_[0]), Eigen::VectorXd::Zero(modes_[1])};
    if (system_) modes = system_->links.small_modal_loads(secants_, system_->ends, x.data(), motion);
    for (std::size_t side = 0; side < 2; ++side) {
      add_up(modes[side].data(), static_cast<std::size_t>(modes[side].size()));
      if (system_ && modes_[side] > 0) modes[side] = response_[side] * modes[side];
    }
    if (system_) system_->links.add_small_elastic_force(secants_, system_->ends, modes, out.data(), load);
    amplitudes_ = std::move(modes);
  }
  void add_up(double* values, std::size_t count) {
    if (comm_ != MPI_COMM_SELF && count > 0) MPI_Allreduce(MPI_IN_PLACE, values, static_cast<int>(count), MPI_DOUBLE, MPI_SUM, comm_);
  }
  void factorise(double least_pivot) {
    std::vector<char> is_unknown(inverse_.size());
    for (std::size_t i = 0; i < inverse_.size(); ++i) is_unknown[i] = inverse_[i] > 0.0;
    matrix_ = std::make_unique<StiffnessMatrix>(system_->grid, is_unknown);
    matrix_->couple(system_->points);
    system_->links.couple(*matrix_);
    if (matrix_->order(kMostMultiplications)) {
      matrix_->add(system_->points, system_->law);
      system_->links.add_to(*matrix_, secants_);
      matrix_->add_to_diagonal(shift_);
      if (matrix_->factorise(least_pivot)) return;
    }
    matrix_.reset();
  }
  bool counts(std::size_t node) const { return system_->grid.halo.counts_here()[node]; }
  bool moves(std::size_t node) const { return system_->grid.constraints.row(static_cast<int>(node)) < 0 && system_->grid.mass[node] > 0.0; }
  MPI_Comm comm_;
  const StaticSystem* system_;
  std::vector<PenaltyLinks::Secant> secants_;
  std::vector<double> inverse_;  // diagonal preconditioner, one number per node
  std::vector<double> shift_;    // shift of the operator, one number per node
  int modes_[2] = {0, 0};        // numbers of modes of elastic grains, three for each scalar mode
  Eigen::MatrixXd response_[2];  // amplitudes of these modes for unit loads on them
  std::array<Eigen::VectorXd, 2> amplitudes_;
  std::unique_ptr<StiffnessMatrix> matrix_;  // factorised stiffness, the preconditioner in place of inverse_; null: not factorised
};

// Unit motion j is a translation along an axis (j < 3), or a rotation about an axis through the middle of the bond. Finds the
// motion of a grain whose centre is at `arm` from the middle: translation of its centre, then rotation.
void unit_motion(int j, const Vector3& arm, double* motion) {
  Vector3 t = Vector3::Zero(), turn = Vector3::Zero();
  (j < 3 ? t : turn)[j % 3] = 1.0;
  t += turn.cross(arm);
  std::copy(t.data(), t.data() + 3, motion);
  std::copy(turn.data(), turn.data() + 3, motion + 3);
}

Vector3 centre(const BondEnd& s) { return Vector3(s.x[0], s.x[1], s.x[2]); }

// First guess of the displacement of the nodes due to motion j of the second grain. It interpolates between the motions of
// the grains by the distances to their surfaces. A node inside a grain follows it.
std::vector<double> first_guess(const StaticSystem& p, const BondFrame& frame, int j) {
  const Grid& grid = p.grid;
  std::vector<double> x(3 * grid.size());
  for (int i = 0; i < grid.size(); ++i) {
    Vector3 X;
    for (int d = 0; d < 3; ++d) X[d] = grid.keys[i].at(d) * grid.h + grid.displacement[3 * i + d];
    double apart[2], motion[6];
    for (int s = 0; s < 2; ++s) apart[s] = std::max(0.0, (X - centre(p.ends[s])).norm() - p.record.radius[s]);
    const double sum = apart[0] + apart[1], share = sum > 0.0 ? apart[0] / sum : 0.5;
    unit_motion(j, X - frame.middle, motion);
    for (int d = 0; d < 3; ++d) x[3 * i + d] = share * motion[d];
  }
  return x;
}

// Conjugate gradients from x on. r: residual of x. energy: initial energy, the scale of the criteria (kResidual). decline:
// kDecline or kDeclineOfCracked. Returns the number of steps, or more than `most` without convergence.
int iterate(Equations& equations, std::vector<double>& x, std::vector<double>& r, double energy, double decline, int most) {
  const Motion at_rest = {};
  Motion load;
  std::vector<double> p(r.size(), 0.0), z(r.size()), minus_Kp(r.size());
  std::vector<double> taken;  // reduction of energy by each step
  equations.precondition(r, z);
  double rho = equations.dot(r, z), before = 0.0;
  while (rho > kResidual * energy) {
    const double beta = before > 0.0 ? rho / before : 0.0;
    for (std::size_t i = 0; i < r.size(); ++i) p[i] = z[i] + beta * p[i];
    equations.force(p, at_rest, minus_Kp, load);  // -K p is the force on the nodes
    for (std::size_t i = 0; i < r.size(); ++i) minus_Kp[i] -= equations.shift(i) * p[i];
    const double pKp = -equations.dot(p, minus_Kp);
    const int steps = static_cast<int>(taken.size()) + 1, window = std::max(kLeastSteps, steps / 4);
    if (!std::isfinite(pKp) || steps > most) return most + 1;
    if (!(pKp > 0.0)) break;  // the rest of the residual is on nodes without stiffness
    const double a = rho / pKp;
    for (std::size_t i = 0; i < r.size(); ++i) {
      x[i] += a * p[i];
      r[i] += a * minus_Kp[i];
    }
    taken.push_back(a * rho);
    if (steps >= window && std::accumulate(taken.end() - window, taken.end(), 0.0) < decline * energy) break;
    before = rho;
    equations.precondition(r, z);
    rho = equations.dot(r, z);
  }
  return static_cast<int>(taken.size());
}

}  // namespace

std::size_t StaticBond::memory_usage() const {
  std::size_t bytes = 0;
  for (const auto& u : displacement) bytes += u.capacity() * sizeof(double);
  for (const auto* strains : {&strain, &strain_of_film})
    for (const auto& e : *strains) bytes += e.capacity() * sizeof(Sym3<vd>);
  for (const auto& open : faces.open) bytes += open.capacity() * sizeof(open[0]);
  return bytes + separations.blocks.capacity() * sizeof(PenaltyLinks::SmallSeparations::Block);
}

BondFrame frame_of(const BondRecord& record, const BondEnd* ends) {
  const Vector3 from = centre(ends[0]), apart = centre(ends[1]) - from;
  const double distance = apart.norm();
  BondFrame f;
  f.axis = apart / distance;
  f.middle = from + (record.radius[0] + 0.5 * (distance - record.radius[0] - record.radius[1])) * f.axis;
  return f;
}

std::array<std::array<double, 6>, 2> motions_of(const BondFrame& frame, const BondEnd* ends, const double* d) {
  std::array<std::array<double, 6>, 2> motions{};
  for (int j = 0; j < 6; ++j) {
    double unit[6];
    unit_motion(j, centre(ends[1]) - frame.middle, unit);
    for (std::size_t i = 0; i < 6; ++i) motions[1][i] += d[j] * unit[i];
  }
  return motions;
}

StaticBond solve_static(MPI_Comm comm, const StaticSystem* system, int most) {
  StaticBond bond;
  Equations equations(comm, system, most > kMostStepsOfCandidate ? kLeastPivot : kLeastPivotOfCandidate);
  std::array<std::vector<double>, 6> force;  // force of each field on the nodes
  double load_of[6][2][6];
  Motion motion[6] = {};
  // Mutual energy u_i.K u_j of fields i and j, with the motion of the second grain: entry ij of the stiffness of the bond.
  const auto energy = [&](int i, int j) {
    double of_grain = 0.0;
    for (int d = 0; d < 6; ++d) of_grain -= motion[i][1][d] * load_of[j][1][d];
    return equations.all(of_grain) - equations.dot(bond.displacement[i], force[j]);
  };
  if (system) bond.frame = frame_of(system->record, system->ends);
  const double decline = equations.all(system && system->points.any_failed()) > 0.0 ? kDeclineOfCracked : kDecline;
  for (int j = 0; j < 6; ++j) {
    std::vector<double>& x = bond.displacement[j];
    if (system) {
      unit_motion(j, centre(system->ends[1]) - bond.frame.middle, motion[j][1]);
      x = first_guess(*system, bond.frame, j);
    }
    force[j].resize(x.size());
    equations.force(x, motion[j], force[j], load_of[j]);
    std::vector<double> r = force[j];
    const int steps = iterate(equations, x, r, energy(j, j), decline, most);
    if (steps > most)
      throw BadState(text_of(
          "the static equilibrium of ",
          system ? text_of("the bond of grains ", system->record.grain[0], " and ", system->record.grain[1]) : std::string("a bond"),
          " was not found in ", steps, " steps, since nodes at its edge or between points that failed are connected by almost nothing; ",
          kCureOfLooseNodes));
    bond.products += 2 + steps;
    equations.force(x, motion[j], force[j], load_of[j]);
    bond.amplitudes[j] = equations.amplitudes();
    if (system) bond.strain[j] = strain_by(system->points, system->grid, x.data());
  }
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) bond.stiffness(i, j) = bond.stiffness(j, i) = energy(i, j);
  if (system) {
    bond.strain_of_film = system->film.strains(system->ends, bond.frame.middle);
    const std::shared_ptr<const TractionLaw>& interface = system->links.parameters().law;
    if (interface && interface->fields() > 0) {
      bond.faces = system->film.put_faces_in_series(bond.strain_of_film, system->ends, bond.frame.middle, system->law, *interface);
      bond.separations = system->links.small_separations(system->links.secants(system->grid, system->ends), bond.displacement, motion,
                                                         system->ends, bond.amplitudes);
    }
    bond.stiffness_of_film = system->film.stiffness(bond.strain_of_film, system->law);
  }
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) bond.stiffness(i, j) += equations.all(bond.stiffness_of_film(i, j) + bond.faces.stiffness(i, j));
  return bond;
}

std::vector<double> static_displacement(MPI_Comm comm, const StaticSystem* system, std::vector<double> force) {
  Equations equations(comm, system, kLeastPivot, kShift);
  std::vector<double> x(force.size(), 0.0);
  std::vector<double> z(force.size());
  equations.precondition(force, z);
  iterate(equations, x, force, equations.dot(force, z), kDecline, kMostStepsOfForce);
  if (system) system->grid.constraints.extend(x.data());
  return x;
}

PrincipalStiffness principal_stiffness(const Matrix6& K, const Vector3& axis) {
  const Vector3 n = axis.normalized(), a = n.unitOrthogonal(), b = n.cross(a);
  Eigen::Matrix<double, 3, 2> across;
  across << a, b;
  PrincipalStiffness p;
  const auto find = [&](const Eigen::Matrix3d& k, double& along, double* of_across) {
    along = n.dot(k * n);
    const Eigen::Matrix2d m = across.transpose() * k * across;
    const Eigen::Vector2d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(m, Eigen::EigenvaluesOnly).eigenvalues();
    std::copy(values.data(), values.data() + 2, of_across);
  };
  find(K.topLeftCorner<3, 3>(), p.tension, p.shear);
  find(K.bottomRightCorner<3, 3>(), p.torsion, p.bending);
  return p;
}

}  // namespace mpdem
