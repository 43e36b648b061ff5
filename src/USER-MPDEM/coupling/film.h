// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The film of a bond: cement that is too thin for cells. It is columns across the gap (geometry/film_fill.h), which the two
// grains move alone. A column is a point with a link to either grain. The feet of the links are its ends on the grains.
// With Q_s the rotation of grain s since the creation and x_s(X) the place to which it took X, the middle of the column,
//
//   N = (foot_1 - foot_0)/t,  t = |foot_1 - foot_0|,
//   F = (Q_0 + Q_1)/2 + (x_1 - x_0) (x) N/t.
//
// This is the gradient, at X, of a field that is linear along the column and meets both grains. Strain, damage and stress
// are those of any point. With the work V P : dF the column pulls grain 1 at x_1 with -V P N/t and turns it by half of the
// axial vector of -V Q_1 P^T, and grain 0 by the opposite force and half of that of -V Q_0 P^T. So momentum, angular
// momentum and energy of the grains and the film are kept for any motion. A film that follows its grains has no time
// step of its own, and no mass.
//
// A column that fails carries nothing, and both of its links let go.
//
// With a traction law that has a state, the faces at the grains open by delta_s, in the axes of the creation, in series with
// the column: x_1 + Q_1 delta_1 and x_0 + Q_0 delta_0 take the places of x_1 and x_0. In each step the openings go to where
// column and faces have one force, by secants, as far as the damage of the column before the step tells. A face that
// lets go takes the load from its column, and the other face lets go, too. Other traction laws are taken for perfect bond.
//
// An object has the columns of one bond on one rank. `side` points to the first of the two sides of the bond; the second
// follows it. All is in the axes of the body.
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
  using Strains = std::array<std::vector<Sym3<vd>>, 6>;  // of each block by six motions, in the frames of the points

  PointStore points;
  std::vector<int> failed;    // slots that failed in the last step, ascending
  std::vector<int> debonded;  // links of the store whose faces let go in the last step

  bool empty() const { return points.blocks.empty(); }
  // Does some column hold?
  bool holds() const;
  // Sums of the areas across the columns: of those that hold, that failed, and whose face at a grain let go.
  struct Areas {
    double holding = 0.0, inside = 0.0, at_grain[2] = {0.0, 0.0};
    double all() const { return holding + inside + at_grain[0] + at_grain[1]; }
  };
  Areas areas() const;

  // Arranges the columns by their IDs in full blocks, and takes up the grains of the body and the law.
  void lay_out(const BondRecord& record, const std::shared_ptr<const Law>& law);

  // Takes a step to the present places of the grains, finds strain, damage and stress, and loads the grains.
  // faces: null without links.
  void advance(BondEnd* ends, const Law& law, const TractionLaw* faces, double dt, const AdvanceOptions& options, AdvanceResult& result);
  // Loads the grains by the present state. Changes no column.
  void add_force(BondEnd* ends, const Law& law) const;

  // Energy that open faces store.
  double energy_of_faces(const TractionLaw* faces) const;

  // Sets deformation, frame and strain by the present places of the grains, from those of the creation.
  void start_from(const BondEnd* ends);
  // Sets the strain by relative motions of the grains: sum of d_j strains_j.
  void set_strain(const Strains& strains, const double* d);

  // Strain by small motions j of the second grain: translations, then turns about `middle`.
  Strains strains(const BondEnd* ends, const Eigen::Vector3d& middle) const;
  // The stiffness against them, with the present damage.
  Matrix6 stiffness(const Strains& strains, const Law& law) const;

  // Blocks whose columns lay_out() has seen. Columns that came since are in later ones.
  std::size_t laid_out_blocks() const { return columns_.size(); }
  // Place and velocity of the columns of block b, which must be laid out: means of those of both grains.
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
    std::uint8_t cut = 0;      // lanes in which a face let go
  };
  struct Faces {
    vd open[2][3], damage[2];
  };
  struct Turns {
    Mat3<double> Q[2];
  };
  Turns turns(const BondEnd* ends) const;
  // Finds vectors r from the centres to the ends of the columns of block b, and the gradient.
  void deform(std::size_t b, const Turns& t, const BondEnd* ends, vd (*r)[3], Mat3<vd>& F) const;
  struct Loads;

  std::uint8_t carrying(std::size_t b) const {
    return static_cast<std::uint8_t>(points.meta[b].occupied & ~points.meta[b].failed & ~columns_[b].cut);
  }
  template <class L, class T>
  void open_faces(const L& law, const T& traction, const Turns& turns, const BondEnd* ends, AdvanceResult& result);
  template <class L>
  void force_on_face(const L& law, std::size_t b, const Turns& turns, const BondEnd* ends, vd* f) const;
  template <class T>
  vd energy_of_faces(const T& traction, std::size_t b) const;
  void debond(int slot, bool debonds);
  void write_faces(int b);
  static int side_behind_of(const Column& c, std::uint8_t live);
  vd carried(int b) const { return masked(carrying(static_cast<std::size_t>(b)), points.blocks[b].volume); }  // volume that carries

  std::vector<Column> columns_;
  std::vector<Faces> faces_;  // empty with perfect bond
  int second_grain_ = 0;      // its tag
  Mat3<double> orientation_[2];
};

}  // namespace mpdem

#endif
