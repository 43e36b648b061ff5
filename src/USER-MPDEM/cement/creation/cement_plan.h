// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Plans the cement of one command between pairs of grains: where the bonds lie, which of them have the same shape, and
// what prevents a bond from being made. CementMaker makes the points.
#ifndef MPDEM_CEMENT_CREATION_CEMENT_PLAN_H
#define MPDEM_CEMENT_CREATION_CEMENT_PLAN_H

#include <mpi.h>

#include <Eigen/Geometry>
#include <array>
#include <climits>
#include <functional>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../../geometry/film_fill.h"
#include "../../geometry/shape_styles.h"
#include "contact_contents.h"
#include "scene_box.h"

namespace mpdem {

using GrainTags = std::pair<int, int>;  // a pair of tags, ascending

// Options of a command, for all its bonds.
struct CementRequest {
  std::vector<ShapeWords> shapes;
  std::string file;     // file from which points are read; empty: points are made of shapes
  double attach = 0.0;  // PointFileOptions::attach; used with a file only
  double spacing = 0.0, density = 0.0;
  enum Inner {
    usual,
    two_spacings,
    given
  } inner_rule = usual;                // which inner radius: usual_inner(), that at which the gap is two spacings wide, or `inner`
  double inner = 0.0;                  // radius about the line of centres within which there is no cement
  double share = GrainPair::kLeftOut;  // argument of GrainPair::usual_inner()
  bool film = true;                    // cement that is too thin for cells is film
  double grid[3] = {0, 0, 0};          // origin of the grid from the middle of the gap
  enum Overlap { error, skip, trim } overlap = error;
  bool later = false;  // true: points are made when they are needed
  // material_of_shape: number of the material of each shape, -1 if the shape has none of its own. material: number for the
  // points of such shapes. A point belongs to the first shape that contains it. materials: how many the scene has.
  int material = 0, materials = 1;
  std::vector<int> material_of_shape;
  std::vector<double> own_densities;  // of the materials from number 1 on, 0: `density`
  double own_density(int material_number) const {
    const std::size_t n = static_cast<std::size_t>(material_number) - 1;
    return n < own_densities.size() ? own_densities[n] : 0.0;
  }
  double density_of(int material_number) const {
    const double own = own_density(material_number);
    return own > 0.0 ? own : density;
  }
  double density_of_shape(const ShapeWords& shape) const { return density_of(material_of(static_cast<int>(&shape - shapes.data()))); }
  int material_of(int shape) const {
    const std::size_t n = static_cast<std::size_t>(shape);
    return n < material_of_shape.size() && material_of_shape[n] >= 0 ? material_of_shape[n] : material;
  }
  ContentWish contents;
};

struct GrainToBond {
  int tag = 0;
  bool is_point = false;  // true: the atom is a material point and no grain
  double x[3] = {0, 0, 0}, unwrapped[3] = {0, 0, 0}, radius = 0.0, mass = 0.0, q[4] = {1, 0, 0, 0};
  double v[3] = {0, 0, 0}, omega[3] = {0, 0, 0};
};

struct PlannedBond {
  GrainToBond grain[2];
  Vector3 between;                                           // vector from the first grain to the second
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  // rotation from the axes of the bond to those of the box
  GrainPair pair;                                            // the pair in the axes of the bond
  int kind = 0;
  double content = 0.0;  // bond content where CementRequest::contents acts, else as the shapes say
  // Position of the middle of the gap, at the periodic image of the first grain.
  Vector3 middle() const { return Vector3(grain[0].x[0], grain[0].x[1], grain[0].x[2]) - turn * pair.centre(0); }
};

// Message that several atoms have one ID.
std::string trouble_of_shared_id(int tag);

// Velocity of new cement between moving grains. `arm`: vectors from the centres of both grains to a position. The
// motion of each grain is weighted by the distance to the surface of the other. So cement at a grain moves with it, and
// cement between grains in a common rigid motion follows that motion.
std::array<double, 3> velocity_between(const GrainToBond* grain, const std::array<double, 3>* arm);

// Error that prevents a bond from being made. Keeps the first in the order of the command, then of the checks.
struct BondTrouble {
  std::size_t bond = INT_MAX;
  int check = 0;
  std::string text;
  void tell(std::size_t of_bond, int of_check, const std::string& why);
  // Collective. Throws BadState with the first error of all ranks, whichever rank found it.
  void stop(MPI_Comm comm) const;
};

class CementPlan {
 public:
  CementPlan(MPI_Comm comm, const SceneBox& box) : comm_(comm), box_(box) {}

  // Returns the contents of all pairs, 0 where there is no cement.
  using Choice = std::function<std::vector<double>(const CementPlan&)>;
  // Collective. Plans bonds between these pairs. grains: grains of this rank that the pairs name. before: pairs that
  // have cement, ascending. read_words: called once the first pair has been checked. It sets the options.
  // choice: called then if CementRequest::contents acts. Throws BadState.
  void make(const std::vector<GrainTags>& pairs, const std::vector<GrainToBond>& grains, const std::vector<GrainTags>& before,
            const std::function<void(CementRequest&)>& read_words, const Choice& choice = {});

  // A set of bonds that have the same shape: radii, gap, direction in the axes of the bond, mass of the grains and bond
  // content are bitwise identical.
  struct Kind {
    std::size_t first;  // the first bond of the kind
    // Made by shape_of(). shape: null until it is made, or if points come from a file. resolved: the part that cells
    // fill, null: all of it.
    std::unique_ptr<Shape> shape, resolved;
    FilmFill film;  // known with `shape`
    // Sizes that all ranks know. area: attached area. thickness: largest thickness, 0 if all of it is film. thinnest:
    // smallest thickness. film_share: share of the film in the attached area. width: radial width of the part that
    // reaches from grain to grain, without the film.
    double volume = 0, area[2] = {0, 0}, thickness = 0, thinnest = 0, film_share = 0, width = 0;
  };
  // A neighbour of a bond.
  struct Near {
    std::size_t bond;         // index of the neighbour
    Vector3 apart;            // from the middle of the bond to that of the neighbour, in the axes of the bond
    Eigen::Quaterniond turn;  // rotation from the axes of the bond to those of the neighbour
  };
  const CementRequest& wish() const { return wish_; }
  const SceneBox& box() const { return box_; }
  const std::vector<PlannedBond>& bonds() const { return bonds_; }
  const Kind& kind_of(std::size_t bond) const { return kinds_[bonds_[bond].kind]; }
  double points_expected(std::size_t bond) const;  // volume over the volume of a lattice cell
  // Least and largest content that the shape with `content` allows between these grains. Throws ShapeError.
  std::pair<double, double> content_bounds(const PlannedBond& bond) const;
  // Makes the shape when it is first asked for. Throws ShapeError.
  const Shape& shape_of(int kind);
  // The part of the shape that cells fill, and its film. None of it is left for cells if FilmFill::all.
  const Shape& resolved_of(int kind);
  const FilmFill& film_of(int kind) { return shape_of(kind), kinds_[kind].film; }
  // Finds for each bond the others, and periodic images, whose boxes meet its own.
  std::vector<std::vector<Near>> neighbours();
  // Text with which messages about a bond begin.
  std::string prefix(std::size_t bond) const { return prefix(bonds_[bond]); }

 private:
  static std::string prefix(const PlannedBond& bond);
  std::string trouble_of_geometry(PlannedBond& bond) const;
  static void choose_axes(PlannedBond& bond);
  int kind_of(std::size_t bond, std::unordered_map<std::string, int>& kinds);
  static std::string error_of_position(const PlannedBond& bond, double length);
  void choose_contents(const Choice& choice);
  double inner_of(const PlannedBond& bond) const;
  double content_of(const ShapeWords& words, const PlannedBond& bond) const;
  void measure_kinds(BondTrouble& trouble);
  void share_kinds();

  MPI_Comm comm_;
  SceneBox box_;
  CementRequest wish_;
  std::vector<PlannedBond> bonds_;
  std::vector<Kind> kinds_;
};

}  // namespace mpdem

#endif
