// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The film of a bond: cement that is too thin for cells. It consists of columns across the gap (geometry/film_fill.h).
// Their motion depends on that of the two grains alone. A column is a material point with a link to either grain. The
// foot points of the links are its ends on the grains. With Q_s the rotation of grain s since the creation and x_s(X)
// the present position of the material point of grain s that was at X, the middle of the column,
//
//   N = (foot_1 - foot_0)/t,  t = |foot_1 - foot_0|,
//   F = (Q_0 + Q_1)/2 + (x_1 - x_0) (x) N/t.
//
// This is the gradient, at X, of a field that is linear along the column and matches both grains. Strain, damage and
// stress are those of any point. By the virtual work V P : dF the column loads grain 1 at x_1 with the force -V P N/t,
// and with a moment of half of the axial vector of -V Q_1 P^T. Grain 0 has the opposite force and half of that of -V
// Q_0 P^T. So momentum, angular momentum and energy of grains and film are kept for any motion. The film follows its
// grains, so it has no mass and no time step of its own.
//
// A column that fails carries no load, and both of its links debond.
//
// With a traction law that has a state, the faces at the grains open by delta_s, in the axes of the creation, in series
// with the column: x_1 + Q_1 delta_1 and x_0 + Q_0 delta_0 replace x_1 and x_0. In each step the openings are solved by
// secants for equal forces of column and faces, with the damage of the column before the step. A face that debonds
// unloads its column, and the other face debonds, too. Other traction laws are treated as a perfect bond.
//
// An object has the columns of one bond on one rank. `ends` points to end 0 of the bond. End 1 follows it. All is in
// the axes of the bond.
#ifndef MPDEM_COUPLING_FILM_H
#define MPDEM_COUPLING_FILM_H

#include <Eigen/Dense>
#include <array>
#include <memory>
#include <vector>

#include "../material/law.h"
#include "../mpm/advance_points.h"
#include "../mpm/point_store.h"
#include "bond_ends.h"
#include "traction_law.h"

namespace mpdem {

class Film {
 public:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Strains = std::array<std::vector<Sym3<vd>>, 6>;  // strains of each block due to six motions, in the frames of the points

  PointStore points;
  std::vector<int> failed;    // slots that failed in the last step, ascending
  std::vector<int> debonded;  // links of the store whose faces debonded in the last step

  bool empty() const { return points.blocks.empty(); }
  // True if some column carries load.
  bool carries_load() const;
  // Cross-sectional areas of the columns: of those that carry, of those that failed, and of those with a debonded face
  // at a grain.
  struct Areas {
    double intact = 0.0, inside = 0.0, at_grain[2] = {0.0, 0.0};
    double all() const { return intact + inside + at_grain[0] + at_grain[1]; }
  };
  Areas areas() const;

  // Arranges the columns by their IDs in full blocks, and sets the grains of the bond and the law.
  void lay_out(const BondRecord& record, const std::shared_ptr<const Law>& law);

  // Advances to the present positions of the grains: finds strain, damage and stress, and loads the grains. faces: null
  // without links.
  void advance(BondEnd* ends, const Law& law, const TractionLaw* faces, double dt, const AdvanceOptions& options, AdvanceResult& result);
  // Loads the grains by the present state.
  void add_force(BondEnd* ends, const Law& law) const;

  // Energy that open faces store.
  double energy_of_faces(const TractionLaw* faces) const;

  // Sets deformation, frame and strain by the present positions of the grains, relative to those at the creation.
  void start_from(const BondEnd* ends);
  // Sets the strain to the sum of d_j strains_j over the relative motions of the grains.
  void set_strain(const Strains& strains, const double* d);

  // Strain due to small motions j of grain 1: translations, then rotations about `middle`.
  Strains strains(const BondEnd* ends, const Eigen::Vector3d& middle) const;
  // The stiffness for these motions, with the present damage.
  Matrix6 stiffness(const Strains& strains, const Law& law) const;

  // Response of the faces at the grains for these motions, in series with the columns, while their traction law has no
  // damage. open: openings at grain 0 and 1, as Film keeps them. The stiffness is the share of the faces in that of the
  // film.
  struct FaceResponse {
    std::array<std::vector<std::array<vd, 6>>, 6> open;
    Matrix6 stiffness = Matrix6::Zero();
    bool empty() const { return open[0].empty(); }
  };
  // Puts the faces in series with the columns: reduces the strains of perfectly bonded columns.
  FaceResponse put_faces_in_series(Strains& strains, const BondEnd* ends, const Eigen::Vector3d& middle, const Law& law,
                                   const TractionLaw& faces) const;
  // Sets the openings to the sum of d_j open_j; closes the faces without a response. They must have no damage.
  void set_open(const FaceResponse& response, const double* d);
  void close_faces();
  // Largest TractionLaw onset_share of the faces: for the motion d, or for each of the six motions alone, of both signs.
  double largest_onset_share(const FaceResponse& response, const TractionLaw& faces, const double* d) const;
  void largest_onset_shares(const FaceResponse& response, const TractionLaw& faces, double* of_motion) const;

  // Number of blocks at the last lay_out(). Columns added since are in later blocks.
  std::size_t laid_out_blocks() const { return columns_.size(); }
  // Position and velocity of the columns of block b, which must be laid out: means of those of both grains.
  void motion(int b, const BondEnd* ends, double later, vd* x, vd* v) const;

  std::size_t memory_usage() const {
    return points.memory_usage() + columns_.capacity() * sizeof(Column) + faces_.capacity() * sizeof(Faces);
  }

 private:
  struct Column {
    vd arm[2][3];  // from the centres at the creation to the middle of the column
    vd N[3];       // zero in empty lanes
    vd inverse_t;
    vd normal[2][3], area[2];  // of the faces: outward normals of the grains at the creation, areas
    int link[2][kLanes];       // indices in the links of the store, -1 where there is none
    std::uint8_t cut = 0;      // lanes in which a face debonded
  };
  struct Faces {
    vd open[2][3], damage[2];
  };
  struct Rotations {
    Mat3<double> Q[2];
  };
  Rotations turns(const BondEnd* ends) const;
  // Finds the deformation gradient F of the columns of block b, and vectors r from the centres of the grains to x_0 and
  // x_1, with the openings of the faces. r has one entry per grain.
  void deform(std::size_t b, const Rotations& t, const BondEnd* ends, vd (*r)[3], Mat3<vd>& F) const;
  struct Loads;

  std::uint8_t carrying(std::size_t b) const {
    return static_cast<std::uint8_t>(points.meta[b].occupied & ~points.meta[b].failed & ~columns_[b].cut);
  }
  // Opens the faces, for all columns that carry.
  void open_faces(const Law& law, const TractionLaw& faces, const Rotations& turns, const BondEnd* ends, AdvanceResult& result);
  template <class L, class T>
  void open_faces(std::size_t b, const L& law, const T& traction, const Rotations& turns, const BondEnd* ends, AdvanceResult& result);
  // What faces of a block do in a step: energy that their damage dissipates, lanes in which it grew, lanes that debonded.
  struct Softening {
    vd spent{};
    vmask grown{};
    std::uint8_t gone = 0;
  };
  template <class L, class T>
  Softening balance_faces(std::size_t b, const L& law, const T& traction, vd* f);
  template <class L, class T>
  vd released_by_faces(std::size_t b, const L& law, const T& traction, const Rotations& turns, const BondEnd* ends, const Faces& at_start,
                       const Mat3<vd>& F_unopened, const Softening& now) const;
  template <class L>
  Mat3<vd> force_on_face(const L& law, std::size_t b, const Rotations& turns, const BondEnd* ends, vd* f) const;
  template <class L>
  void force_of_column(const L& law, std::size_t b, const Rotations& turns, const Mat3<vd>& F, const Frame& q, const Sym3<vd>& strain,
                       vd* f) const;
  template <class T>
  static vd energy_of(const T& traction, const Column& c, const Faces& faces);
  double energy_of_faces_at(const std::vector<int>& slots, const TractionLaw& faces) const;
  void debond(int slot, bool by_face);  // by_face: a face of the column debonded; else its point failed
  void write_faces(int b);              // writes the faces of block b to the links of the store
  static int grain_behind_of(const Column& c, std::uint8_t live);
  // volume_that_carries() times the drawn factor of the moduli.
  vd stiff_volume(int b) const {
    return points.scatter.empty() ? volume_that_carries(b) : points.scatter[b].stiffness * volume_that_carries(b);
  }
  vd volume_that_carries(int b) const { return masked(carrying(static_cast<std::size_t>(b)), points.blocks[b].volume); }

  std::vector<Column> columns_;
  std::vector<Faces> faces_;  // empty with perfect bond
  Mat3<double> orientation_[2];
};

}  // namespace mpdem

#endif
