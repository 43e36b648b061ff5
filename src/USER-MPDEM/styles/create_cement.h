// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Command create_cement: fills the cement between two grains with material points, or
// reads them from a file, and attaches them. See doc/create_cement.md.
//
// Bonds are planned all together, then made in parts, a few hundred thousand points at a time. Bonds whose geometry is the
// same to the bit have the same points, which are made once. Ranks deal out what is to be made, and send it to those in
// whose sub-domains it lies. What comes out does not depend on the number of ranks: every rank knows the number of points of
// every bond, and so their IDs.
#ifdef COMMAND_CLASS

CommandStyle(create_cement,CreateCement)

#else

#ifndef MPDEM_CREATE_CEMENT_H
#define MPDEM_CREATE_CEMENT_H

#include <climits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "../geometry/box_search.h"
#include "../geometry/lattice_fill.h"
#include "../geometry/shape_styles.h"
#include "../mpm/body.h"
#include "../mpm/point_store.h"
#include "arguments.h"
#include "pointers.h"

namespace LAMMPS_NS {

class CreateCement : protected Pointers {
 public:
  explicit CreateCement(LAMMPS* lmp) : Pointers(lmp) {}
  void command(int narg, char** arg);

 private:
  using Pair = std::pair<int, int>;  // of IDs, ascending
  struct Grain {
    int tag;
    double x[3], unwrapped[3], radius, mass, q[4];
  };
  // A bond that is to be made.
  struct Bond {
    int tags[2];
    Grain grain[2];
    double between[3];  // from the first grain to the second
    mpdem::GrainPair pair;
    int kind = 0, fill = 0;
    // Of the middle of the gap, beside the first grain.
    mpdem::Vector3 middle() const { return mpdem::Vector3(grain[0].x[0], grain[0].x[1], grain[0].x[2]) - pair.centre(0); }
  };
  // Bonds of the same shape: radii, gap, direction and mass of the grains are the same to the bit.
  struct Kind {
    std::size_t first;                    // bond
    std::unique_ptr<mpdem::Shape> shape;  // see shape_of; none: points from a file
    double volume = 0, area[2] = {0, 0}, thickness = 0, thinnest = 0;  // known to all ranks
  };
  struct Near {
    std::size_t bond;
    mpdem::Vector3 apart;  // of its middle
  };
  // Bonds of the same points: of one kind, with the same neighbours if these take a part.
  struct Fill {
    std::size_t first;  // bond
    bool known = false;
    mpdem::Body body;     // what all of the bonds have in common; known to all ranks, as the box
    mpdem::Box box;       // of the points, from the origin
    std::vector<mpdem::FillPoint> points;  // from the origin, on ranks that need them
    std::vector<char> sent;                // to each rank, by the one that makes them
    mpdem::Vector3 corner = mpdem::Vector3::Zero();  // origin from the middle of the gap
  };
  // What keeps a bond from being made: the first bond in the order of the command, and of it the first check.
  struct Trouble {
    std::size_t bond = INT_MAX;
    int check = 0;
    std::string text;
    void tell(std::size_t of_bond, int of_check, const std::string& why);
  };
  struct Sums {
    double points = 0, volume = 0, mass = 0;
  };
  struct Overlap {
    std::size_t bond;
    int body;  // as it is, or will be if all bonds of the part are made
    double volume;
  };
  // Bonds from `from` to `to` that are made together, with their bodies.
  struct Part {
    std::size_t from, to;
    std::vector<mpdem::Body> bodies;
    std::vector<char> kept;
  };

  // create_cement.cpp: words, and what is to be made
  void check_scene(const mpdem::Arguments& args) const;
  void read_words(mpdem::Arguments& args);
  void plan(const std::vector<Pair>& pairs, const mpdem::Arguments& args);
  std::vector<Grain> find_grains(const std::vector<int>& tags, std::vector<std::string>& trouble) const;
  std::string trouble_of_geometry(Bond& bond) const;
  std::string trouble_of_place(const Bond& bond, double length) const;
  void measure_kinds(Trouble& trouble);
  void share_kinds();
  const mpdem::Shape& shape_of(int kind);
  mpdem::Arguments named(const Bond& bond, const mpdem::Arguments& args) const;
  std::string prefix(const Bond& bond) const;
  // Collective.
  void stop_at(const Trouble& trouble) const;
  std::vector<Pair> cemented() const;

  // create_cement_make.cpp
  Sums make(const mpdem::Arguments& args, std::vector<Pair>& skipped);
  Sums make_part(Part& part, std::size_t first_body, const mpdem::Arguments& args, std::vector<Pair>& skipped, Sums sums);
  void group_fills();
  std::size_t end_of_part(std::size_t from) const;
  void make_fills(const Part& part, Trouble& trouble, const mpdem::Arguments& args);
  void fill_one(int fill, double most, Trouble& trouble, const mpdem::Arguments& args);
  void share_numbers(const std::vector<int>& fills);
  void send_fills(const Part& part, const std::vector<int>& fills);
  std::vector<std::vector<char>> needed(const Part& part, const std::vector<int>& fills) const;
  mpdem::Body body_of(const Bond& bond) const;
  double most_points(double memory, double more) const;
  void check_numbers(const Part& part, Trouble& trouble) const;
  void create_points(const Part& part, const mpdem::Arguments& args);
  void finish(int before, int first_tag);
  void report(const Part& part);
  static void measure(const std::vector<mpdem::FillPoint>& fill, mpdem::Body& body);

  // create_cement_points.cpp: all that touches the store of the points
  struct FullPoint {
    mpdem::Vector3 x;
    int body;
  };
  // Of this rank, in cells that bodies before this one fill (nearly) whole.
  std::vector<FullPoint> full_points(int bodies) const;
  bool place(const mpdem::Body& body, const mpdem::FillPoint& p, double* x, tagint& image) const;
  void add_point(const mpdem::FillPoint& p, const mpdem::Body& body, int body_index, int tag, const double* x, tagint image);

  // create_cement_file.cpp
  std::vector<mpdem::FillPoint> read_file(const mpdem::GrainPair& pair, const int* tags, const double* first_centre,
                                          mpdem::Body& body, mpdem::Vector3& corner, const mpdem::Arguments& args);
  void check_grains_of_file(const std::map<int, int>& line, const mpdem::Arguments& args) const;
  void set_frame(const mpdem::FillPoint& p, mpdem::PointRecord& r) const;

  // create_cement_checks.cpp
  double reach_of_cells() const;
  std::vector<mpdem::Vector3> images() const;
  std::vector<Overlap> overlaps(const Part& part, int bodies) const;
  void resolve(Part& part, const std::vector<Overlap>& found, Trouble& trouble, std::vector<Pair>& skipped) const;
  void gather_grains();
  void check_other_grains(const Part& part, Trouble& trouble) const;

  // create_cement_contacts.cpp
  std::vector<Pair> contacts(int groupbit, double gap) const;
  void cement_contacts(mpdem::Arguments& args);
  std::vector<std::vector<Near>> neighbours();
  void report_skipped(const std::vector<Pair>& skipped) const;
  void report_sums(const Sums& sums, int groupbit, const std::string& name) const;

  // words
  std::vector<mpdem::ShapeWords> shapes_;
  std::string file_, overlap_ = "error";
  double attach_ = 0;
  int groupbit_ = 0;
  int type_ = 0;
  double spacing_ = 0, density_ = 2710.0, inner_ = -1.0;  // inner: negative is auto
  double grid_[3] = {0, 0, 0};  // origin of the grid from the middle of the gap

  std::vector<Bond> bonds_;
  std::vector<Kind> kinds_;
  std::vector<Fill> fills_;
  std::vector<std::vector<Near>> near_;  // of each bond, if bonds share out what they have in common
  double live_ = 0;                      // points of the fills that are kept
  int last_tag_ = 0;
  double created_ = 0;                   // points
  int listed_ = 0, thin_ = 0;            // bonds that were told of one by one; with too thin a film
  double thinnest_ = 1e300;
  // All grains of all ranks, and the boxes around them.
  struct Sphere {
    int tag;
    mpdem::Vector3 x;
    double radius;
  };
  std::vector<Sphere> grains_;
  std::unique_ptr<mpdem::BoxSearch> near_grains_;
};

}  // namespace LAMMPS_NS

#endif
#endif
