// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Makes the points of planned bonds (cement_plan.h) in batches of about a hundred thousand points. Bonds of bitwise
// identical geometry have the same points, which are made once. Ranks share out what is to be made, and send it to the
// ranks in whose subdomain it lies. The result does not depend on the number of ranks: every rank knows the number of
// points of every bond, and so their IDs.
#ifndef MPDEM_CEMENT_CREATION_CEMENT_MAKER_H
#define MPDEM_CEMENT_CREATION_CEMENT_MAKER_H

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "../../geometry/lattice_fill.h"
#include "../../mpm/bond_record.h"
#include "cement_plan.h"

namespace mpdem {

// A new bond: its row of the table, its grains, and its points, of all ranks. The tags of the points are consecutive.
struct NewBond {
  int row, first_tag;
  const GrainToBond* grain;  // both grains
  const BondRecord& record;
  const std::vector<FillPoint>& points;  // points in the coordinates of the bond
  const Box& box;                        // box around the points
};

// Point of this rank that represents a cube (nearly) full of cement: a cell, or a cube within a column of a film.
struct FullPoint {
  Vector3 x;
  int row;
  double width;
};
// Width of that cube. 0: the cell of the point is cut. spacing: that of its bond; full: least volume of an uncut cell.
template <class Point>
double width_filled(const Point& p, double spacing, double full) {
  constexpr double kWidthInColumn = 0.5;  // over the thickness of the film
  if (p.film) return kWidthInColumn * (Vector3(p.link[1].foot) - Vector3(p.link[0].foot)).norm();
  return p.volume < full ? 0.0 : spacing;
}

// Returns the box, in the coordinates of the simulation box, around a box in the coordinates of a bond.
Box box_around(const BondRecord& record, const Box& box);

// Interface of the maker to its host.
class CementMakerHost {
 public:
  virtual ~CementMakerHost() = default;
  // Returns points of this rank that represent full cells of bonds before row `rows`.
  virtual std::vector<FullPoint> full_points(int rows) = 0;
  // Creates those points that belong to this rank, and returns their number. more: whether other calls follow.
  virtual std::size_t create_points(const std::vector<NewBond>& bonds, bool more) = 0;
  // Returns the template, counted from 1, of bonds whose points are made later. All ranks pass the same points.
  virtual int template_of(const std::vector<FillPoint>& points) = 0;
  // The maker calls these two on the first rank alone.
  virtual void say(const std::string& text) = 0;
  virtual void warn(const std::string& text) = 0;
};

// Bonds that one warning counts, and the least of their values.
struct BondsToWarnOf {
  int count = 0;
  double least = 1e300;
  void add(double value) {
    ++count;
    least = std::min(least, value);
  }
};

class CementMaker {
 public:
  struct Sums {
    double points = 0, volume = 0, mass = 0;
  };
  // The scene before the command.
  struct Scene {
    std::vector<Sphere> grains;  // grains of this rank
    double atoms = 0;            // number of atoms of all ranks
    int last_tag = 0;
  };

  // table: bonds of the scene, to which the new ones are added.
  CementMaker(MPI_Comm comm, CementPlan& plan, std::vector<BondRecord>& table, const Scene& scene, CementMakerHost& host);

  // Collective. Makes all bonds of the plan. Throws BadState.
  Sums make();
  const std::vector<GrainTags>& skipped() const { return skipped_; }  // bonds left out
  int last_tag() const { return last_tag_; }
  double created() const { return created_; }  // number of points made, of all ranks
  // Text about the bonds that were left out, empty if there are none.
  std::string text_of_skipped() const;

 private:
  // Bonds of the same points: bonds of one kind, with the same neighbours if these trim them.
  struct Fill {
    std::size_t first;  // the first bond with these points
    bool known = false;
    BondRecord record;                                         // what all of the bonds have in common; all ranks know it, and the box
    Box box;                                                   // box around the points, in the coordinates of the bond
    std::vector<FillPoint> points;                             // points in these coordinates, on ranks that need them
    std::vector<char> sent;                                    // for each rank: whether the points were sent to it
    Vector3 corner = Vector3::Zero();                          // origin of these coordinates, from the middle of the gap
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  // rotation to the axes of the planned bond; a file may have its own axes
    int point_template = 0;                                    // template that the host gave; 0: not known yet
  };
  // Bonds from `from` to `to` (exclusive) that are made together, with their records.
  struct Batch {
    std::size_t from, to;
    std::vector<BondRecord> records;
    std::vector<char> kept;  // for each bond: 0 if it is left out
  };
  struct Overlap {
    std::size_t bond;
    int row;  // row of the table, as it is or will be if all bonds of the batch are made
    double volume;
  };

  // In cement_maker.cpp.
  void group_fills();
  std::size_t end_of_batch(std::size_t from) const;
  void make_batch(Batch& batch);
  void create(const Batch& batch);
  void choose_templates(Batch& batch);
  BondRecord record_of(std::size_t bond) const;
  const Fill& fill_of(std::size_t bond) const { return fills_[fill_of_bond_[bond]]; }
  void forget_fills();
  void report(const Batch& batch);
  std::string report_of(std::size_t bond, const BondRecord& record);
  double cells_across(const CementPlan::Kind& kind) const;
  bool narrow(const CementPlan::Kind& kind) const;

  // In cement_fills.cpp.
  void make_fills(const Batch& batch, BondTrouble& trouble);
  void fill_one(int fill, double most, BondTrouble& trouble);
  void find_own_mass(Fill& fill) const;
  void fill_by_shape(Fill& fill, double most);
  void fill_by_file(Fill& fill);
  void check_grains_of_file(std::size_t bond, const std::map<int, int>& line) const;
  double most_points(double memory, double more) const;
  void share_numbers(const std::vector<int>& fills);
  void send_fills(const Batch& batch, const std::vector<int>& fills);
  std::vector<std::vector<char>> needed(const Batch& batch, const std::vector<int>& fills) const;

  // In cement_overlaps.cpp.
  double reach_of_cells() const;
  std::vector<Overlap> overlaps(const Batch& batch, int rows) const;
  void resolve(Batch& batch, const std::vector<Overlap>& found, BondTrouble& trouble);
  void check_other_grains(const Batch& batch, BondTrouble& trouble) const;
  void check_numbers(const Batch& batch, BondTrouble& trouble) const;
  int points_outside(const Fill& fill, const BondRecord& record) const;

  MPI_Comm comm_;
  int me_, ranks_;
  CementPlan& plan_;
  const CementRequest& wish_;
  std::vector<BondRecord>& table_;
  CementMakerHost& host_;
  const std::size_t first_row_;
  const double atoms_before_;
  int last_tag_;
  std::vector<Sphere> grains_;              // grains of all ranks
  std::unique_ptr<BoxSearch> near_grains_;  // boxes around the grains
  std::vector<Fill> fills_;
  std::vector<int> fill_of_bond_;
  std::vector<std::vector<CementPlan::Near>> near_;  // neighbours of each bond, with 'overlap trim'
  std::vector<GrainTags> skipped_;
  Sums sums_;
  double live_ = 0, created_ = 0;  // points of the fills that are kept; points made
  int listed_ = 0;                 // bonds reported one by one
  BondsToWarnOf thin_, coarse_;    // other bonds: less than two spacings thin at the inner rim, less than kFewCells across
};

}  // namespace mpdem

#endif
