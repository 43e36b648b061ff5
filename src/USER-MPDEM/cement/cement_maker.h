// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Makes the points of planned bonds (cement_plan.h) in parts, a few hundred thousand points at a time. Bonds whose geometry is the same to
// the bit have the same points, which are made once. Ranks deal out what is to be made, and send it to those in whose part of the box it
// lies. What comes out does not depend on the number of ranks: every rank knows the number of points of every bond, and so their IDs.
#ifndef MPDEM_CEMENT_MAKER_H
#define MPDEM_CEMENT_MAKER_H

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "../geometry/lattice_fill.h"
#include "../mpm/body.h"
#include "cement_plan.h"

namespace mpdem {

// A bond that is new: its row of the table and its points, of all ranks, whose tags follow each other.
struct NewBond {
  int row, first_tag;
  const Body& body;
  const std::vector<FillPoint>& points;  // in the coordinates of the body
  const Box& box;                        // of the points
};

// Point of this rank that stands for a cell of a body that is (nearly) full.
struct FullPoint {
  Vector3 x;
  int body;
};

// Around a box in the coordinates of a body, in those of the box.
Box box_around(const Body& body, const Box& box);

// What the maker asks of its host.
class CementMakerHost {
 public:
  virtual ~CementMakerHost() = default;
  // Of the bodies before this one.
  virtual std::vector<FullPoint> full_points(int bodies) = 0;
  // Takes those points that belong to this rank, and returns how many these are. more: will other calls follow?
  virtual std::size_t create_points(const std::vector<NewBond>& bonds, bool more) = 0;
  // The pattern, counted from 1, of bonds whose points are made later. The same points on all ranks.
  virtual int pattern_of(const std::vector<FillPoint>& points) = 0;
  // On the first rank alone.
  virtual void say(const std::string& text) = 0;
  virtual void warn(const std::string& text) = 0;
};

class CementMaker {
 public:
  struct Sums {
    double points = 0, volume = 0, mass = 0;
  };
  // What is in the scene before.
  struct Scene {
    std::vector<Sphere> grains;  // of this rank
    double atoms = 0;            // of all ranks
    int last_tag = 0;
  };

  // table: of all bonds, which the new ones are added to.
  CementMaker(MPI_Comm comm, CementPlan& plan, std::vector<Body>& table, const Scene& scene, CementMakerHost& host);

  // All bonds of the plan. Collective, throws BadState.
  Sums make();
  const std::vector<GrainTags>& skipped() const { return skipped_; }  // bonds left out
  int last_tag() const { return last_tag_; }
  double created() const { return created_; }                       // points, of all ranks
  // Of bonds left out. No text if there are none.
  std::string text_of_skipped() const;

 private:
  // Bonds of the same points: of one kind, with the same neighbours if these take a part.
  struct Fill {
    std::size_t first;  // bond
    bool known = false;
    Body body;          // what all of the bonds have in common; known to all ranks, as the box
    Box box;            // of the points, in the coordinates of the body
    std::vector<FillPoint> points;    // in these, on ranks that need them
    std::vector<char> sent;           // to each rank, by the one that makes them
    Vector3 corner = Vector3::Zero();  // origin from the middle of the gap
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  // to the axes of the planned bond; points of a file may have their own
    int pattern = 0;  // of the host, once it is known
  };
  // Bonds from `from` to `to` that are made together, with their bodies.
  struct Part {
    std::size_t from, to;
    std::vector<Body> bodies;
    std::vector<char> kept;
  };
  struct Overlap {
    std::size_t bond;
    int body;  // as it is, or will be if all bonds of the part are made
    double volume;
  };

  // cement_maker.cpp
  void group_fills();
  std::size_t end_of_part(std::size_t from) const;
  void make_part(Part& part);
  void create(const Part& part);
  void choose_patterns(Part& part);
  Body body_of(std::size_t bond) const;
  const Fill& fill_of(std::size_t bond) const { return fills_[fill_of_bond_[bond]]; }
  void forget_fills();
  void report(const Part& part);
  std::string told_of(std::size_t bond, const Body& body);

  // cement_fills.cpp
  void make_fills(const Part& part, BondTrouble& trouble);
  void fill_one(int fill, double most, BondTrouble& trouble);
  void fill_by_shape(Fill& fill, double most);
  void fill_by_file(Fill& fill);
  void check_grains_of_file(std::size_t bond, const std::map<int, int>& line) const;
  double most_points(double memory, double more) const;
  void share_numbers(const std::vector<int>& fills);
  void send_fills(const Part& part, const std::vector<int>& fills);
  std::vector<std::vector<char>> needed(const Part& part, const std::vector<int>& fills) const;

  // cement_overlaps.cpp
  double reach_of_cells() const;
  std::vector<Overlap> overlaps(const Part& part, int bodies) const;
  void resolve(Part& part, const std::vector<Overlap>& found, BondTrouble& trouble);
  void check_other_grains(const Part& part, BondTrouble& trouble) const;
  void check_numbers(const Part& part, BondTrouble& trouble) const;
  int points_outside(const Fill& fill, const Body& body) const;

  MPI_Comm comm_;
  int me_, ranks_;
  CementPlan& plan_;
  const CementWish& wish_;
  std::vector<Body>& table_;
  CementMakerHost& host_;
  const std::size_t first_body_;
  const double atoms_before_;
  int last_tag_;
  std::vector<Sphere> grains_;                  // of all ranks
  std::unique_ptr<BoxSearch> near_grains_;      // boxes around them
  std::vector<Fill> fills_;
  std::vector<int> fill_of_bond_;
  std::vector<std::vector<CementPlan::Near>> near_;  // of each bond, if bonds share out what they have in common
  std::vector<GrainTags> skipped_;
  Sums sums_;
  double live_ = 0, created_ = 0;     // points of the fills that are kept; points
  int listed_ = 0, thin_ = 0;         // bonds that were told of one by one; with too thin a film
  double thinnest_ = 1e300;
};

}  // namespace mpdem

#endif
